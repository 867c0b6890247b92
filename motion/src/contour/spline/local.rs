//! Local view of a path for the approximating estimators: a few samples and differences.

use crate::contour::{ContourError, Location};
use crate::{Vec3, interpolate};

/// A path with the lengths of its chords. The buffers are reused between calls.
#[derive(Debug, Clone, Default)]
pub(in crate::contour) struct Arcs {
    /// Length from the first sample, mm, one per sample.
    values: Vec<f64>,
}

impl Arcs {
    pub fn rebuild(&mut self, path: &[Vec3]) {
        self.values.clear();
        let mut arc = 0.0;
        let mut before = path.first().copied().unwrap_or_default();
        self.values.extend(path.iter().map(|point| {
            arc += (point - before).norm();
            before = *point;
            arc
        }));
    }

    /// Position on the chord from sample `segment`, at a fraction in `[0, 1]`.
    pub fn location(&self, segment: usize, fraction: f64) -> Location {
        let start = self.values[segment];
        let end = self.values.get(segment + 1).copied().unwrap_or(start);
        Location { segment, fraction, arc_mm: start + fraction * (end - start) }
    }
}

/// Half the path length from sample `k − 1` to `k + 1`, mm per sample. At an end the length to the
/// only neighbour.
pub(in crate::contour) fn slope(path: &[Vec3], k: usize) -> Vec3 {
    let before = k.saturating_sub(1);
    let after = (k + 1).min(path.len() - 1);
    match after - before {
        0 => Vec3::zeros(),
        samples => (path[after] - path[before]) / samples as f64,
    }
}

/// The nearest samples before and after `k` that do not coincide with it, at most `reach` away.
pub(in crate::contour) fn distinct_neighbours(path: &[Vec3], k: usize, reach: usize) -> (Option<Vec3>, Option<Vec3>) {
    let here = path[k];
    let differs = |point: &&Vec3| **point != here;
    let before = path[k.saturating_sub(reach)..k].iter().rev().find(differs);
    let after = path[k + 1..(k + 1 + reach).min(path.len())].iter().find(differs);
    (before.copied(), after.copied())
}

/// Fraction in `[0, 1]` of the chord `a → b` at the foot of the perpendicular from `p`, and whether
/// the foot lies within the chord.
pub(in crate::contour) fn foot_on_chord(p: &Vec3, a: &Vec3, b: &Vec3) -> (f64, bool) {
    let chord = b - a;
    let length_squared = chord.norm_squared();
    if length_squared == 0.0 {
        return (0.0, false);
    }
    let share = (p - a).dot(&chord) / length_squared;
    (share.clamp(0.0, 1.0), (0.0..=1.0).contains(&share))
}

/// The error of `sample` with this foot point. `along` is the direction of travel.
pub(in crate::contour) fn error(sample: &Vec3, foot: Vec3, along: Vec3, location: Location, at_end: bool) -> ContourError {
    let vector = sample - foot;
    ContourError {
        vector,
        foot,
        tangent: along.try_normalize(0.0).unwrap_or_default(),
        magnitude_mm: vector.norm(),
        location,
        at_end,
    }
}

/// Point and derivative of the cubic Hermite spline through `to` (Paper A, eq. 5).
pub(in crate::contour) fn hermite(to: &[Vec3], segment: usize, t: f64) -> (Vec3, Vec3) {
    let start = to[segment];
    let Some(end) = to.get(segment + 1) else {
        return (start, slope(to, segment));
    };
    let (leaving, arriving) = (slope(to, segment), slope(to, segment + 1));
    interpolate::hermite(start, *end, leaving, arriving, t)
}
