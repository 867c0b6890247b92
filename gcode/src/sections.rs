//! Open sections: functions that change how coordinates become axis positions, or the path or speed of moves. Nothing in them is changed.

/// The open sections by their causes.
#[derive(Debug)]
pub(crate) struct Sections<Cause>(Vec<Cause>);

impl<Cause> Default for Sections<Cause> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<Cause: PartialEq> Sections<Cause> {
    pub fn is_open(&self) -> bool {
        !self.0.is_empty()
    }

    /// Whether a section with such a cause is open.
    pub fn any(&self, wanted: impl Fn(&Cause) -> bool) -> bool {
        self.0.iter().any(wanted)
    }

    /// Opens a section. Returns whether it is new.
    pub fn open(&mut self, cause: Cause) -> bool {
        let new = !self.0.contains(&cause);
        if new {
            self.0.push(cause);
        }
        new
    }

    /// Ends the section opened by this cause. Returns whether it was open.
    pub fn close(&mut self, cause: Cause) -> bool {
        self.close_where(|other| *other == cause)
    }

    /// Ends the sections whose causes `ends` names. Returns whether there were any.
    pub fn close_where(&mut self, ends: impl Fn(&Cause) -> bool) -> bool {
        let open = self.0.len();
        self.0.retain(|cause| !ends(cause));
        self.0.len() < open
    }
}
