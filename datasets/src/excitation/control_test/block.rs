//! Blocks of the control test, in program coordinates.

/// Program coordinates X, Y, Z, A, B, C, mm and rad.
pub type Coordinates = [f64; 6];

/// A block of the control test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Block {
    /// Rapid.
    Rapid {
        /// End.
        to: Coordinates,
    },
    /// Straight line.
    Line {
        /// End.
        to: Coordinates,
        /// Feed, mm/s; rad/s where only rotary axes move.
        feed: f64,
    },
    /// Arc in the x-y plane; a full circle where the end is the start.
    Arc {
        /// End.
        to: Coordinates,
        /// Centre minus start, mm.
        centre_mm: [f64; 2],
        /// Direction of travel, seen from +z.
        clockwise: bool,
        /// Feed, mm/s.
        feed: f64,
    },
    /// Standstill, of one time in all of the test.
    Dwell,
}

/// Figures of one kind.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// Kind of the figures.
    pub title: &'static str,
    /// Blocks, from the start of the program and back.
    pub blocks: Vec<Block>,
}
