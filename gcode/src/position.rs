//! Positions with coordinates that may be unknown.

/// A machine axis. Its value as `usize` indexes six-element arrays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Axis {
    /// Linear, mm.
    X,
    /// Linear, mm.
    Y,
    /// Linear, mm.
    Z,
    /// Rotary about X, rad.
    A,
    /// Rotary about Y, rad.
    B,
    /// Rotary about Z, rad.
    C,
}

/// Larger numbers are no machine coordinates. Keeps sums finite.
pub(crate) const LARGEST_COORDINATE: f64 = 1e9;
/// Address letters of the six axes.
pub(crate) const AXIS_LETTERS: [u8; 6] = *b"XYZABC";

/// A position: six coordinates, each known or only nominal.
///
/// A coordinate that is unknown (program start, after G28, after a change of work offset) has a
/// nominal value: the sum of the incremental words. Differences of nominal values along incremental
/// moves are true displacements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Position {
    pub(crate) nominal: [f64; 6],
    pub(crate) known: u8,
}

impl Position {
    /// All coordinates unknown, nominal zero.
    pub fn unknown() -> Self {
        Self { nominal: [0.0; 6], known: 0 }
    }

    /// Whether a coordinate is known.
    pub fn is_known(&self, axis: Axis) -> bool {
        self.knows(axis as usize)
    }

    /// A coordinate if it is known: mm, or rad for A, B, C.
    pub fn axis(&self, axis: Axis) -> Option<f64> {
        self.is_known(axis).then(|| self.nominal[axis as usize])
    }

    /// X, Y, Z in mm if all three are known.
    pub fn xyz_mm(&self) -> Option<[f64; 3]> {
        (self.known & 0b111 == 0b111).then(|| self.nominal_mm())
    }

    /// X, Y, Z in mm, nominal if unknown.
    pub fn nominal_mm(&self) -> [f64; 3] {
        [self.nominal[0], self.nominal[1], self.nominal[2]]
    }

    /// A, B, C in rad if known.
    pub fn rotary_rad(&self) -> [Option<f64>; 3] {
        [self.axis(Axis::A), self.axis(Axis::B), self.axis(Axis::C)]
    }

    /// A, B, C in rad, nominal if unknown.
    pub fn nominal_rotary_rad(&self) -> [f64; 3] {
        [self.nominal[3], self.nominal[4], self.nominal[5]]
    }

    pub(crate) fn knows(&self, axis: usize) -> bool {
        self.known & (1 << axis) != 0
    }

    pub(crate) fn set(&mut self, axis: usize, value: f64) {
        self.nominal[axis] = value;
        self.known |= 1 << axis;
    }

    pub(crate) fn forget(&mut self, axis: usize) {
        self.known &= !(1 << axis);
    }
    /// Knows two coordinates or none of them.
    pub(crate) fn keep_pair(&mut self, first: usize, second: usize) {
        if !(self.knows(first) && self.knows(second)) {
            self.forget(first);
            self.forget(second);
        }
    }
}
