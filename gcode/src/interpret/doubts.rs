//! What a macro that is not read may have changed.

/// Modal groups that a macro may have changed, until the program states them again.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Doubts {
    /// G90, G91: axis words may be targets or distances.
    pub distance: bool,
    /// G54 to G59.3. Not if the program never states one: then it is left to the macro.
    pub work_offset: bool,
    /// G17 to G19, which concern arcs alone.
    pub plane: bool,
    /// The motion code of blocks without one.
    pub motion: bool,
    /// The feed of moves without F.
    pub feed: bool,
}

impl Doubts {
    /// Whether a move may be another than the program says.
    pub fn concern(self, is_arc: bool) -> bool {
        self.distance || self.work_offset || self.motion || self.feed || (self.plane && is_arc)
    }
}
