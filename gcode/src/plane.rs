//! The main planes.

/// Plane of arcs. Its normal is the tool axis of cycles and length offsets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Plane {
    /// G17.
    Xy,
    /// G18; counter-clockwise turns Z towards X.
    Zx,
    /// G19.
    Yz,
}

impl Plane {
    /// Axis indices (0 = X): first and second in the plane, then the normal, right-handed.
    pub fn axes(self) -> [usize; 3] {
        match self {
            Plane::Xy => [0, 1, 2],
            Plane::Zx => [2, 0, 1],
            Plane::Yz => [1, 2, 0],
        }
    }
}
