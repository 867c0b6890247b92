//! Result of a refit.

use std::collections::HashMap;

use gcode::Edits;

use super::element::Element;

/// Edits of a program whose points are shifted.
#[derive(Debug, Default)]
pub struct Refitted {
    /// Edits of the program's bytes.
    pub edits: Edits,
    /// For every rewritten move its index and the lines and arcs in its place.
    pub targets: Vec<(usize, Vec<Element>)>,
    /// Number of slow lines at the end of a move, by its index.
    pub slow: HashMap<usize, usize>,
    /// Largest correction of the tool tip, mm.
    pub largest_shift_mm: f64,
}
