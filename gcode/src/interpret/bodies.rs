//! The subprograms, loops and branches that are open, and what they leave uncertain.

/// Most subprograms, loops and branches open at once.
pub(super) const DEEPEST: usize = 100;

#[derive(Debug)]
pub(super) struct Body {
    pub label: Vec<u8>,
    pub block: usize,
    pub is_do: bool,
    pub is_subprogram: bool,
}

/// Which bodies are open and what made the rest uncertain.
#[derive(Debug, Default)]
pub(super) struct OpenBodies {
    pub bodies: Vec<Body>,
    /// The first block that may have jumped, or changed modal state under a condition.
    pub uncertain: Option<usize>,
}

impl OpenBodies {
    /// Whether a subprogram is being defined.
    pub fn in_subprogram(&self) -> bool {
        self.bodies.iter().any(|body| body.is_subprogram)
    }

    /// The block that makes a move here unpredictable, and how.
    pub fn fault(&self) -> Option<(usize, &'static str)> {
        match (self.bodies.first(), self.uncertain) {
            (Some(body), _) => Some((body.block, "inside the subprogram, loop or branch that opens")),
            (None, Some(block)) => Some((block, "after the jump or condition")),
            (None, None) => None,
        }
    }

    /// Closes the body of this label and those inside it; returns whether one was open.
    pub fn close(&mut self, label: &[u8]) -> bool {
        let found = self.bodies.iter().rposition(|body| body.label.eq_ignore_ascii_case(label));
        if let Some(at) = found {
            self.bodies.truncate(at);
        }
        found.is_some()
    }
}
