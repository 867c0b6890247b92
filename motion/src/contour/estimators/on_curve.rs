//! The exact contour error against an analytic curve.

use std::sync::Arc;

use super::window::{Due, Follower, PathSource, Window};
use crate::contour::spline::{CurvePieces, Pieces};
use crate::contour::{ContourError, ContourEstimator, ContourQuery, Location, check_paths};
use crate::{Curve, MotionError, Vec3};

/// Step length of the Newton iteration at which it ends, mm.
const LAST_STEP_MM: f64 = 1e-12;

/// The foot point on an analytic curve sampled by `to` in time order: the nearest point within the
/// [`Window`].
///
/// Cubic pieces within 1e-8 mm of the curve locate the foot point. A safeguarded Newton iteration
/// on the curve refines it to 1e-9 mm. If two points are equally near to within 2e-8 mm, either may
/// be reported. The samples of `to` only define which segment of the curve is due at which time.
/// [`Location::arc_mm`] is the arc length along the curve's fine pieces.
#[derive(Debug, Clone)]
pub struct ExactOnCurve {
    curve: Arc<dyn Curve>,
    window: Window,
    cut: CurvePieces,
    parameters: Option<Vec<f64>>,
}

impl ExactOnCurve {
    /// The estimator on `curve`. The samples of `to` are located by projection, in time order from
    /// the start of the curve.
    #[must_use]
    pub fn new(curve: Arc<dyn Curve>) -> Self {
        Self { cut: CurvePieces::new(curve.as_ref()), curve, window: Window::default(), parameters: None }
    }

    /// The same with the curve parameter of every sample of `to`, non-decreasing.
    ///
    /// # Errors
    /// If a parameter is not finite or decreases.
    pub fn with_parameters(mut self, parameters: Vec<f64>) -> Result<Self, MotionError> {
        let rising = parameters.windows(2).all(|pair| pair[0] <= pair[1]);
        if !rising || parameters.iter().any(|u| !u.is_finite()) {
            return Err(MotionError::Mismatch("the samples' curve parameters are not finite and rising".into()));
        }
        self.parameters = Some(parameters);
        Ok(self)
    }

    /// The same with another window.
    ///
    /// # Errors
    /// As [`Exact::with_window`](crate::contour::Exact::with_window).
    pub fn with_window(mut self, window: Window) -> Result<Self, MotionError> {
        window.check()?;
        self.window = window;
        Ok(self)
    }

    fn positions(&self, to: &[Vec3]) -> Result<Vec<f64>, MotionError> {
        match &self.parameters {
            None => Ok(self.cut.positions_of(to)),
            Some(parameters) if parameters.len() == to.len() => Ok(parameters.iter().map(|u| self.cut.position(*u)).collect()),
            Some(parameters) => {
                Err(MotionError::Mismatch(format!("{} curve parameters for {} samples", parameters.len(), to.len())))
            }
        }
    }

    /// Fraction of the arc length between two samples that lies before a position, `None` if it is
    /// zero. Positions themselves do not measure length: pieces differ in length.
    fn share(&self, positions: &[f64], segment: usize, position: f64) -> Option<f64> {
        let arc = |position: f64| self.cut.pieces.arc_at(position);
        let (start, end) = (arc(positions[segment]), arc(*positions.get(segment + 1)?));
        (end > start).then(|| ((arc(position) - start) / (end - start)).clamp(0.0, 1.0))
    }

    /// Foot point of `p`: its position and the error, searched around `due`.
    fn nearest(&self, source: &Timed, due: &Due, p: &Vec3) -> (f64, ContourError) {
        let pieces = source.pieces();
        let nearest_piece = self.window.nearest(source, due, p);
        let rough = nearest_piece.position();
        let (u, [foot, slope, ..]) = self.refine(self.cut.parameter(rough), self.cut.around(rough), p);
        let position = self.cut.position(u);
        let vector = p - foot;
        let (first, last) = self.curve.domain();
        let error = ContourError {
            vector,
            foot,
            tangent: slope.try_normalize(0.0).unwrap_or_default(),
            magnitude_mm: vector.norm(),
            location: Location { arc_mm: pieces.arc_at(position), ..Location::default() },
            at_end: u <= first || u >= last,
        };
        (position, error)
    }

    /// Newton's method on `(C − p)·C′ = 0` from `start`, bounded by `low` and `high`. The result is
    /// never farther from `p` than the start.
    fn refine(&self, start: f64, (mut low, mut high): (f64, f64), p: &Vec3) -> (f64, [Vec3; 4]) {
        let mut u = start;
        let mut best = (u, self.curve.derivatives(u));
        let mut jet = best.1;
        for _ in 0..48 {
            let [point, slope, bend, _] = jet;
            let gap = point - p;
            if gap.norm_squared() < (best.1[0] - p).norm_squared() {
                best = (u, jet);
            }
            let g = gap.dot(&slope);
            let speed_squared = slope.norm_squared();
            let convexity = speed_squared + gap.dot(&bend);
            if g > 0.0 {
                high = u;
            } else {
                low = u;
            }
            let newton = u - g / convexity;
            let next = if convexity > 0.0 && newton > low && newton < high { newton } else { 0.5 * (low + high) };
            let moved = next - u;
            if moved == 0.0 || moved * moved * speed_squared < LAST_STEP_MM * LAST_STEP_MM {
                break;
            }
            u = next;
            jet = self.curve.derivatives(u);
        }
        best
    }
}

impl ContourEstimator for ExactOnCurve {
    fn name(&self) -> &'static str {
        "exact-on-curve"
    }

    fn estimate_into(&mut self, query: ContourQuery<'_>, out: &mut Vec<ContourError>) -> Result<(), MotionError> {
        let ContourQuery { from, to, matching } = query;
        check_paths(from, to, matching)?;
        let positions = self.positions(to)?;
        out.clear();
        let source = Timed { pieces: &self.cut.pieces, positions: &positions };
        let mut follower = Follower::default();
        for (k, sample) in from.iter().enumerate() {
            let matched = matching.index(k);
            let due = follower.due(&self.window, matched, matching.rate);
            let (position, mut error) = self.nearest(&source, &due, sample);
            let index = index_of(&positions, due.moved_on, position);
            follower.found(matched, index);
            let segment = (index as usize).min(to.len().saturating_sub(2));
            error.location.segment = segment;
            error.location.fraction = self.share(&positions, segment, position).unwrap_or(index - segment as f64);
            out.push(error);
        }
        Ok(())
    }
}

/// The pieces of the curve and the position of every sample on them.
struct Timed<'a> {
    pieces: &'a Pieces,
    positions: &'a [f64],
}

impl PathSource for Timed<'_> {
    fn pieces(&self) -> &Pieces {
        self.pieces
    }

    fn locate(&self, index: f64) -> (usize, f64) {
        self.pieces.split(interpolate(self.positions, index))
    }

    fn before(&self, index: f64, _: usize, samples: usize) -> usize {
        self.locate(index - samples as f64).0
    }

    fn after(&self, index: f64, _: usize, samples: usize) -> usize {
        self.locate(index + samples as f64).0
    }
}

/// Position at a fractional sample index, clamped to the range.
fn interpolate(positions: &[f64], index: f64) -> f64 {
    let index = index.clamp(0.0, (positions.len() - 1) as f64);
    let k = index as usize;
    let after = positions[(k + 1).min(positions.len() - 1)];
    positions[k] + (index - k as f64) * (after - positions[k])
}

/// Sample index of a position. At standstill several match: the one nearest to `near`.
fn index_of(positions: &[f64], near: f64, position: f64) -> f64 {
    let end = positions.len() - 1;
    let near = near.clamp(0.0, end as f64);
    let mut k = near as usize;
    while k > 0 && positions[k] > position {
        k -= 1;
    }
    while k < end && positions[k + 1] < position {
        k += 1;
    }
    if k == end {
        return end as f64;
    }
    let width = positions[k + 1] - positions[k];
    let share = if width > 0.0 { (position - positions[k]) / width } else { near - k as f64 };
    k as f64 + share.clamp(0.0, 1.0)
}
