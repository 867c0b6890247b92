//! Corner detection by the curve-to-chord ratio (Paper B, section 4).

use std::ops::Range;

use crate::Vec3;

/// Paper B's region of support.
pub const PAPER_B_SUPPORT: SupportRegion = SupportRegion::Samples(4);
/// Paper B's threshold: a ratio below it marks a corner.
pub const PAPER_B_RATIO: f64 = 0.998;

/// Region of support: extent of curve and chord on either side of a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SupportRegion {
    /// A number of samples, as printed: the ratio then depends on feed and sampling rate.
    Samples(usize),
    /// A path length, mm: the ratio depends on the geometry alone. `1 − κ²l²/6` on an arc of
    /// curvature κ.
    LengthMm(f64),
}

/// Chord over curve, `R(P_i) = |P_{i−k} P_{i+k}| / Σ |P_j P_{j+1}|` (Paper B, eq. 12), one per
/// sample of `path` (mm).
///
/// Near an end the support shrinks equally on both sides. The ratio of a support without length is
/// 1. A support that is not a positive number has no length.
#[must_use]
pub fn corner_ratios(path: &[Vec3], support: SupportRegion) -> Vec<f64> {
    let mut arc = 0.0;
    let mut arcs = Vec::with_capacity(path.len());
    for (k, point) in path.iter().enumerate() {
        arc += (point - path[k.saturating_sub(1)]).norm();
        arcs.push(arc);
    }
    // Both ends of the support only move forward: one pass along the path is enough.
    let (mut left, mut right) = (0, 0);
    (0..path.len())
        .map(|i| {
            let (chord, curve) = match support {
                SupportRegion::Samples(k) => {
                    let k = k.min(i).min(path.len() - 1 - i);
                    ((path[i + k] - path[i - k]).norm(), arcs[i + k] - arcs[i - k])
                }
                SupportRegion::LengthMm(length) => {
                    let length = if length > 0.0 { length } else { 0.0 };
                    let half = length.min(arcs[i]).min(arc - arcs[i]);
                    let from = point_at(path, &arcs, arcs[i] - half, &mut left);
                    let to = point_at(path, &arcs, arcs[i] + half, &mut right);
                    ((to - from).norm(), 2.0 * half)
                }
            };
            if curve > 0.0 { chord / curve } else { 1.0 }
        })
        .collect()
}

/// Whether each sample of `path` (mm) belongs to a corner: its curve-to-chord ratio is below `threshold`.
#[must_use]
pub fn corner_flags(path: &[Vec3], support: SupportRegion, threshold: f64) -> Vec<bool> {
    corner_ratios(path, support).into_iter().map(|ratio| ratio < threshold).collect()
}

/// Runs of adjacent set flags.
#[must_use]
pub fn stretches(flags: &[bool]) -> Vec<Range<usize>> {
    let mut found: Vec<Range<usize>> = Vec::new();
    for (i, _) in flags.iter().enumerate().filter(|(_, flag)| **flag) {
        match found.last_mut() {
            Some(last) if last.end == i => last.end = i + 1,
            _ => found.push(i..i + 1),
        }
    }
    found
}

/// The point at a path length. `at` is a segment at or before it and advances to it.
fn point_at(path: &[Vec3], arcs: &[f64], arc: f64, at: &mut usize) -> Vec3 {
    while *at > 0 && arcs[*at] > arc {
        *at -= 1;
    }
    while *at + 1 < path.len() && arcs[*at + 1] < arc {
        *at += 1;
    }
    let Some(end) = path.get(*at + 1) else {
        return path[*at];
    };
    let length = arcs[*at + 1] - arcs[*at];
    let share = if length > 0.0 { (arc - arcs[*at]) / length } else { 0.0 };
    path[*at] + (end - path[*at]) * share
}
