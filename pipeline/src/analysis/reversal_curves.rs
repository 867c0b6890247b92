//! The contour error around the reversals of an axis, aligned at the reversals.

use motion::{DesiredPath, Vec3};

use crate::measure::reversal_samples;

/// Time before and after a reversal that the curves show, s.
const BEFORE_S: f64 = 0.02;
const AFTER_S: f64 = 0.1;
/// Largest number of curves of an axis; of more reversals those with the largest swing are taken.
const MOST: usize = 24;

/// Error around one reversal.
#[derive(Debug, Clone, PartialEq)]
pub struct ReversalCurve {
    /// Sample of the path at which the axis reverses.
    pub sample: usize,
    /// Whether the axis moved in positive direction before.
    pub from_positive: bool,
    /// Contour error along the axis, mm, with its sign turned such that the motion after the reversal is positive; without the error just before
    /// the reversal. Not a number where the sample does not count.
    pub error_mm: Vec<f64>,
}

/// Error around the reversals of one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct ReversalCurves {
    /// Name of the axis.
    pub axis: String,
    /// Number of reversals, of which the largest are given.
    pub reversals: usize,
    /// Time from the reversal, s.
    pub time_s: Vec<f64>,
    /// The curves, in order of time.
    pub curves: Vec<ReversalCurve>,
    /// Median over the curves at every instant, mm.
    pub median_mm: Vec<f64>,
}

/// Contour errors `errors` of a run at the reversals of the axes x, y and z of `path`, sample by sample. Nothing on a machine with rotary axes,
/// whose linear axes are no directions of the workpiece.
#[must_use]
pub fn reversal_curves(path: &DesiredPath, errors: &[Vec3], counts: &[bool]) -> Vec<ReversalCurves> {
    let trajectory = path.trajectory();
    if path.kinematics().has_rotary_axes() {
        return Vec::new();
    }
    let period = trajectory.period_s();
    let [before, after] = [BEFORE_S, AFTER_S].map(|time_s| (time_s / period).round() as usize);
    let time_s: Vec<f64> = (0..=before + after).map(|k| (k as f64 - before as f64) * period).collect();
    let axes = trajectory.axes().iter().zip(trajectory.columns());
    let of_axis = |(axis, column): (&motion::Axis, &Vec<f64>)| {
        let component = axis.slot().filter(|slot| *slot < 3)?;
        let whole = |at: &usize| *at >= before && at + after < errors.len() && counts[*at];
        let found: Vec<(usize, bool)> = reversal_samples(column, period).into_iter().filter(|(at, _)| whole(at)).collect();
        let curve = |&(sample, from_positive): &(usize, bool)| {
            let sign = if from_positive { -1.0 } else { 1.0 };
            // The sample before is the last one that moves as before.
            let zero = errors[sample.saturating_sub(1)][component];
            let at = |k: usize| if counts[k] { sign * (errors[k][component] - zero) } else { f64::NAN };
            ReversalCurve { sample, from_positive, error_mm: (sample - before..=sample + after).map(at).collect() }
        };
        let mut curves: Vec<ReversalCurve> = found.iter().map(curve).collect();
        curves.sort_by(|a, b| swing(&b.error_mm).total_cmp(&swing(&a.error_mm)));
        let median_mm = (0..time_s.len()).map(|k| median(curves.iter().map(|curve| curve.error_mm[k]))).collect();
        curves.truncate(MOST);
        curves.sort_by_key(|curve| curve.sample);
        let reversals = found.len();
        (reversals > 0).then(|| ReversalCurves { axis: axis.name.clone(), reversals, time_s: time_s.clone(), curves, median_mm })
    };
    axes.filter_map(of_axis).collect()
}

/// Range of the finite values.
fn swing(values: &[f64]) -> f64 {
    let finite = values.iter().filter(|value| value.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), e| (low.min(*e), high.max(*e)));
    (high - low).max(0.0)
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;
    use std::sync::Arc;

    use motion::{Axis, Cartesian, Trajectory};

    use super::*;

    #[test]
    fn both_directions_show_the_same_glitch() {
        let (period, n) = (0.002, 5000);
        let x: Vec<f64> = (0..n).map(|k| 20.0 * (PI * f64::from(k) * period).cos()).collect();
        let axes = vec![Axis::named("x")];
        let trajectory = Trajectory::new(period, axes.clone(), vec![x]).unwrap();
        let path = DesiredPath::new(trajectory, Arc::new(Cartesian::new(axes))).unwrap();
        // Once a second x reverses; it then sticks for a while, 4 µm behind its motion.
        let error = |k: i32| {
            let t = f64::from(k) * period;
            let heading = if t.rem_euclid(2.0) < 1.0 { -1.0 } else { 1.0 };
            let since = t.rem_euclid(1.0);
            Vec3::new(if since < 0.05 { -heading * 0.004 * (since / 0.05 * PI).sin() } else { 0.0 }, 7.0, 0.0)
        };
        let errors: Vec<Vec3> = (0..n).map(error).collect();
        let found = reversal_curves(&path, &errors, &vec![true; errors.len()]);
        let [axis] = found.as_slice() else { panic!("{}", found.len()) };
        assert_eq!((axis.axis.as_str(), axis.reversals, axis.curves.len()), ("x", 9, 9));
        let least = |values: &[f64]| values.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(axis.curves.iter().all(|curve| (least(&curve.error_mm) + 0.004).abs() < 3e-4));
        assert!((least(&axis.median_mm) + 0.004).abs() < 3e-4);
        assert!(reversal_curves(&path, &errors, &vec![false; errors.len()]).is_empty());
    }
}
