//! What became of a program.

use gcode::Edits;
use motion::Vec6;

/// A program with its points moved.
#[derive(Debug, Default)]
pub struct Refitted {
    /// The patches.
    pub edits: Edits,
    /// For every move that was rewritten its index and the ends of the lines in its place, program coordinates: mm, rad.
    pub targets: Vec<(usize, Vec<Vec6>)>,
    /// Largest correction of the tool tip, mm.
    pub largest_shift_mm: f64,
}
