//! Open sections: functions that change how coordinates become axis positions, or the path or speed of moves. Nothing in them is changed.

/// A function whose effect is not interpreted, until its own end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cause {
    /// CYCL DEF 7 from a table or a parameter.
    Shift,
    /// CYCL DEF 8.
    Mirror,
    /// CYCL DEF 10.
    Rotation,
    /// CYCL DEF 11.
    Scaling,
    /// PLANE.
    Plane,
    /// An M function with the number of the one that ends it.
    EndedBy(u16),
    /// M128 or FUNCTION TCPM.
    ToolCentrePoint,
    /// Without a known end.
    Lasting,
}

/// The open sections.
#[derive(Debug, Default)]
pub(super) struct Sections(Vec<Cause>);

impl Sections {
    pub fn is_open(&self) -> bool {
        !self.0.is_empty()
    }

    /// Opens a section. Returns whether it is new.
    pub fn open(&mut self, cause: Cause) -> bool {
        let new = !self.0.contains(&cause);
        if new {
            self.0.push(cause);
        }
        new
    }

    /// Ends a section. Returns whether it was open.
    pub fn close(&mut self, cause: Cause) -> bool {
        let open = self.0.len();
        self.0.retain(|other| *other != cause);
        self.0.len() < open
    }
}
