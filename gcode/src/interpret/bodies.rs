//! Open subprograms, loops and branches, and the uncertainty that they leave.

/// Maximum nesting depth of subprograms, loops and branches.
pub(super) const DEEPEST: usize = 100;

#[derive(Debug)]
pub(super) struct Body {
    pub label: Vec<u8>,
    pub block: usize,
    pub is_do: bool,
    pub is_subprogram: bool,
}

/// Open bodies, and the cause of uncertainty after them.
#[derive(Debug, Default)]
pub(super) struct OpenBodies {
    pub bodies: Vec<Body>,
    /// The first block that may have jumped, or changed modal state under a condition.
    pub uncertain: Option<usize>,
}

impl OpenBodies {
    /// Whether a subprogram definition is open.
    pub fn in_subprogram(&self) -> bool {
        self.bodies.iter().any(|body| body.is_subprogram)
    }

    /// The block that makes a move here unpredictable, and the reason.
    pub fn fault(&self) -> Option<(usize, &'static str)> {
        match (self.bodies.first(), self.uncertain) {
            (Some(body), _) => Some((body.block, "inside the subprogram, loop or branch that opens")),
            (None, Some(block)) => Some((block, "after the jump or condition")),
            (None, None) => None,
        }
    }

    /// Closes the body with this label and all bodies inside it. Returns whether one was open.
    pub fn close(&mut self, label: &[u8]) -> bool {
        let found = self.bodies.iter().rposition(|body| body.label.eq_ignore_ascii_case(label));
        if let Some(at) = found {
            self.bodies.truncate(at);
        }
        found.is_some()
    }
}
