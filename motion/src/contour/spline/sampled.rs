//! The smooth path through samples.

use super::pieces::Pieces;
use crate::contour::{ContourError, check_point};
use crate::{MotionError, Vec3};

/// Samples that the slope at one sample depends on.
const STENCIL: usize = 5;

/// The path through uniformly sampled points: cubic between neighbours, continuous first
/// derivative.
///
/// The slope at a sample is the fourth-order difference `(8 (Q₊₁ − Q₋₁) − (Q₊₂ − Q₋₂)) / 12`,
/// one-sided at the ends. The path is within `h⁴/384·|d⁴C/dt⁴|` of a smooth motion sampled every
/// `h`, a fifth of the bound of the C2 cubic spline. The slopes are local, so the path can grow
/// while it is used.
#[derive(Debug, Clone, Default)]
pub struct SampledSpline {
    pub(in crate::contour) pieces: Pieces,
    /// The last samples, oldest first. With fewer than [`STENCIL`] samples, those at the front.
    recent: [Vec3; STENCIL],
    /// Samples pushed since the last clear.
    count: usize,
    /// Slope at the end of the last piece.
    slope: Vec3,
}

impl SampledSpline {
    /// The path through `samples`, mm.
    ///
    /// # Errors
    /// If there is no sample or one is not finite or beyond 1e9 mm.
    pub fn new(samples: &[Vec3]) -> Result<Self, MotionError> {
        samples.iter().try_for_each(check_point)?;
        if samples.is_empty() {
            return Err(MotionError::BadCurve("a path needs at least one sample".into()));
        }
        let mut spline = Self::default();
        spline.rebuild(samples);
        Ok(spline)
    }

    /// Number of segments.
    #[must_use]
    pub fn segments(&self) -> usize {
        self.pieces.end()
    }

    /// Point at the fraction `t ∈ [0, 1]` of the segment `segment`, mm. Both are clamped.
    #[must_use]
    pub fn point(&self, segment: usize, t: f64) -> Vec3 {
        let (piece, _) = self.pieces.split(segment as f64);
        self.pieces.cubic(piece).point(t.clamp(0.0, 1.0))
    }

    /// The nearest point to `p` on the segments `segments` (clamped), to within 1e-10 mm.
    #[must_use]
    pub fn nearest(&self, segments: std::ops::Range<usize>, p: &Vec3) -> ContourError {
        let last = self.segments() - 1;
        let low = segments.start.min(last);
        let high = segments.end.clamp(low + 1, last + 1);
        let foot = self.pieces.nearest(low, high, ((low + high) / 2, 0.5), p);
        self.pieces.error_at(&foot, p, &mut Vec3::zeros())
    }

    /// Restarts with these samples, which must not be empty.
    pub(in crate::contour) fn rebuild(&mut self, samples: &[Vec3]) {
        self.clear();
        self.extend(samples, samples.len());
        self.finish();
    }

    pub(in crate::contour) fn clear(&mut self) {
        self.pieces.clear();
        self.count = 0;
    }

    /// Adds a sample. Pieces follow two samples later, when their slopes are known.
    pub(in crate::contour) fn push(&mut self, sample: Vec3) {
        self.count += 1;
        if self.count <= STENCIL {
            self.recent[self.count - 1] = sample;
        } else {
            let [_, b, c, d, e] = self.recent;
            self.recent = [b, c, d, e, sample];
        }
        if self.count < STENCIL {
            return;
        }
        if self.count == STENCIL {
            self.slope = slope(&self.recent, 0);
            let second = slope(&self.recent, 1);
            self.join(0, second);
        }
        self.join(1, central(&self.recent));
    }

    /// Adds the samples of `path` up to `end`. The samples added so far must be its first ones.
    pub(in crate::contour) fn extend(&mut self, path: &[Vec3], end: usize) {
        while self.count < end.min(STENCIL) {
            self.push(path[self.count]);
        }
        if self.count >= end {
            return;
        }
        let mut leaving = self.slope;
        for samples in path[self.count + 1 - STENCIL..end].windows(STENCIL) {
            let arriving = central(samples);
            self.pieces.push(samples[1], leaving, samples[2], arriving);
            leaving = arriving;
        }
        self.slope = leaving;
        self.count = end;
        self.recent.copy_from_slice(&path[end - STENCIL..end]);
    }

    /// Adds the pieces up to the last sample.
    pub(in crate::contour) fn finish(&mut self) {
        let known = self.count.min(STENCIL);
        let recent = self.recent;
        let slope = |at: usize| slope(&recent[..known], at);
        match known {
            0 => {}
            1 => {
                let point = self.recent[0];
                self.pieces.push(point, Vec3::zeros(), point, Vec3::zeros());
            }
            STENCIL => {
                for start in [2, 3] {
                    self.join(start, slope(start + 1));
                }
            }
            _ => {
                self.slope = slope(0);
                for start in 0..known - 1 {
                    self.join(start, slope(start + 1));
                }
            }
        }
    }

    /// The piece from `recent[start]` to the next sample, with slope `end_slope` there.
    #[inline(always)]
    fn join(&mut self, start: usize, end_slope: Vec3) {
        let (a, b) = (self.recent[start], self.recent[start + 1]);
        self.pieces.push(a, self.slope, b, end_slope);
        self.slope = end_slope;
    }
}

/// Slope at the middle of five samples.
#[inline(always)]
fn central(samples: &[Vec3]) -> Vec3 {
    (8.0 * (samples[3] - samples[1]) - (samples[4] - samples[0])) / 12.0
}

/// Derivative per sample at `points[at]` of the polynomial through all `points` (2 to 5, one sample
/// apart).
fn slope(points: &[Vec3], at: usize) -> Vec3 {
    let node = |i: usize| i as f64;
    let others = |skip: usize| (0..points.len()).filter(move |k| *k != skip);
    (0..points.len())
        .map(|i| {
            let weight = if i == at {
                others(at).map(|k| 1.0 / (node(at) - node(k))).sum::<f64>()
            } else {
                let above: f64 = others(at).filter(|k| *k != i).map(|k| node(at) - node(k)).product();
                let below: f64 = others(i).map(|k| node(i) - node(k)).product();
                above / below
            };
            points[i] * weight
        })
        .sum()
}
