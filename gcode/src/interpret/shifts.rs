//! The parts that add up to the shift of the program's zero.

/// The parts of the program's shift (mm; rad for A, B, C).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Shifts {
    pub local: [f64; 6],
    pub position: [f64; 6],
    pub saved: [f64; 6],
    /// Axes whose frame G92 laid anew, so that taking it back leaves their place unknown.
    pub relaid: [bool; 6],
}
