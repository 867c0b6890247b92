//! Arcs whose centres fit no circle: whether they may be measured from the program's zero.

/// Arcs whose centres fit no circle.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ArcFaults {
    /// All of them.
    pub any: bool,
    /// Whether one of them has a radius at its start, so that its centre may be measured from elsewhere.
    pub is_telling: bool,
}

impl ArcFaults {
    pub fn note(&mut self, is_telling: bool) {
        self.any = true;
        self.is_telling |= is_telling;
    }
}
