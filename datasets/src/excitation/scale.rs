//! Time scaling: as fast as the limits allow, and no faster.

use motion::{Axis, AxisKind, Limits};

use super::spline::QuinticSpline;

/// Places looked at between two knots.
const PER_KNOT: usize = 40;
/// What is kept back from each limit, for what lies between the places looked at.
const KEPT_BACK: f64 = 0.995;
/// Rounds in which the samples themselves are brought within the limits.
const ROUNDS: usize = 8;

/// Splines sampled at a uniform rate, slow enough for all limits.
pub(super) struct Sampled {
    /// One an axis.
    pub columns: Vec<Vec<f64>>,
    pub duration_s: f64,
}

impl Sampled {
    /// Scales the time of all splines (of equal duration) by one factor until the limits hold, with a share of the speed limits.
    pub fn within(splines: &[QuinticSpline], axes: &[Axis], limits: &Limits, speed_share: f64, period_s: f64) -> Self {
        let bounds = Bounds { axes, limits, speed_share };
        let duration_s = splines.iter().map(QuinticSpline::duration_s).fold(0.0, f64::max);
        let mut places: Vec<f64> = Vec::new();
        for spline in splines {
            for pair in spline.times().windows(2) {
                let step = (pair[1] - pair[0]) / PER_KNOT as f64;
                places.extend((0..PER_KNOT).map(|k| pair[0] + step * k as f64));
            }
        }
        let mut slowdown = places
            .iter()
            .map(|&time| {
                let derivatives: Vec<[f64; 4]> = splines.iter().map(|spline| spline.at(time)).collect();
                bounds.slowdown(|axis, order| derivatives[axis][order])
            })
            .fold(0.0, f64::max)
            .max(f64::MIN_POSITIVE);
        let mut columns = Vec::new();
        let mut samples = 0;
        for _ in 0..ROUNDS {
            // A whole number of samples, so that the last one is at rest at the end.
            samples = ((duration_s * slowdown / period_s).ceil() as usize).max(2);
            let at = |k: usize| duration_s * k as f64 / samples as f64;
            columns = splines.iter().map(|spline| (0..=samples).map(|k| spline.at(at(k))[0]).collect()).collect();
            let excess = sampled_slowdown(&columns, &bounds, period_s);
            if excess <= 1.0 {
                break;
            }
            slowdown = slowdown.max(samples as f64 * period_s / duration_s) * excess * 1.001;
        }
        Self { columns, duration_s: samples as f64 * period_s }
    }
}

/// How far the finite differences of samples, with rest before and after them, exceed the limits; 1 where they just hold.
fn sampled_slowdown(columns: &[Vec<f64>], bounds: &Bounds, period_s: f64) -> f64 {
    let count = columns.first().map_or(0, Vec::len);
    let position = |axis: usize, k: usize| {
        let column = &columns[axis];
        column[k.saturating_sub(3).min(column.len() - 1)]
    };
    (3..count + 6)
        .map(|k| {
            bounds.slowdown(|axis, order| {
                let p = |back: usize| position(axis, k - back);
                match order {
                    1 => (p(0) - p(1)) / period_s,
                    2 => (p(0) - 2.0 * p(1) + p(2)) / period_s.powi(2),
                    _ => (p(0) - 3.0 * (p(1) - p(2)) - p(3)) / period_s.powi(3),
                }
            })
        })
        .fold(0.0, f64::max)
}

/// Limits of the axes and of the path.
struct Bounds<'a> {
    axes: &'a [Axis],
    limits: &'a Limits,
    speed_share: f64,
}

impl Bounds<'_> {
    /// Factor by which time has to be stretched for the derivatives `of(axis, order)`, orders 1 to 3, to keep within the limits.
    ///
    /// The path's whole acceleration is held below both its tangential and its centripetal limit: stricter than each alone.
    fn slowdown(&self, of: impl Fn(usize, usize) -> f64) -> f64 {
        let stretch = |value: f64, limit: f64, order: usize| {
            let ratio = value / (KEPT_BACK * limit);
            match order {
                1 => ratio / self.speed_share,
                2 => ratio.sqrt(),
                _ => ratio.cbrt(),
            }
        };
        let mut most: f64 = 0.0;
        for order in 1..=3 {
            let mut squares = 0.0;
            for (index, (axis, limits)) in self.axes.iter().zip(&self.limits.axes).enumerate() {
                let value = of(index, order).abs();
                let limit = [limits.velocity, limits.acceleration, limits.jerk][order - 1];
                most = most.max(stretch(value, limit, order));
                if axis.kind == AxisKind::Linear {
                    squares += value * value;
                }
            }
            let path = [
                self.limits.path_velocity_mm_s,
                self.limits.path_acceleration_mm_s2.min(self.limits.centripetal_mm_s2),
                self.limits.path_jerk_mm_s3,
            ];
            most = most.max(stretch(squares.sqrt(), path[order - 1], order));
        }
        most
    }
}
