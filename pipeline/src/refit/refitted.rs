//! Result of a refit.

use gcode::Edits;
use motion::Vec6;

/// Edits of a program whose points are shifted.
#[derive(Debug, Default)]
pub struct Refitted {
    /// Edits of the program's bytes.
    pub edits: Edits,
    /// For every rewritten move its index and the ends of its lines in program coordinates, mm and rad.
    pub targets: Vec<(usize, Vec<Vec6>)>,
    /// Largest correction of the tool tip, mm.
    pub largest_shift_mm: f64,
}
