//! Arcs that fit centres measured from their start and from the program's zero alike: full circles, and others by chance.

use crate::word::Span;

/// Distance within which a circle begins beside its centre, mm.
const BESIDE_MM: f64 = 1e-3;

/// What the arcs of a program say about how their centres are stated.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct OpenCentres {
    /// Whether an arc shows that centres are distances from the start.
    decided: bool,
    /// The first arc that fits both and begins beside its centre only if that is measured from the program's zero.
    doubtful: Option<Span>,
}

impl OpenCentres {
    /// Notes an arc from the way from its start to its centre, read as a distance from the start and, where both words are given, as a position.
    /// Programs begin circles and half circles beside, above or below their centres.
    pub fn note(&mut self, span: Span, fits_both: bool, from_start: [f64; 2], as_position: Option<[f64; 2]>) {
        let beside = |way: [f64; 2]| way.iter().any(|along| along.abs() <= BESIDE_MM);
        match as_position {
            Some(way) if fits_both && !beside(from_start) => {
                if beside(way) {
                    self.doubtful.get_or_insert(span);
                }
            }
            _ => self.decided = true,
        }
    }

    /// The arc that leaves the reading open, where no arc decides.
    pub fn doubt(&self) -> Option<Span> {
        self.doubtful.filter(|_| !self.decided)
    }
}
