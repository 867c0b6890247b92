//! Components of the program zero offset.

/// Components of the program zero offset (mm; rad for A, B, C).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Shifts {
    pub local: [f64; 6],
    pub position: [f64; 6],
    pub saved: [f64; 6],
    /// Axes whose frame G92 redefined. Cancelling it leaves their position unknown.
    pub relaid: [bool; 6],
    /// Axes of which G92 took the place of a G52.
    pub absorbed: [bool; 6],
}
