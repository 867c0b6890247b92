//! Samples of a motion at which an axis exceeds a limit.

use rayon::prelude::*;

use crate::{AxisLimits, Limits};

/// Tolerance for rounding in comparisons with limits.
const SLACK: f64 = 1.0 + 1e-7;

/// A sample at which an axis exceeds a limit.
pub(super) struct Excess {
    pub sample: usize,
    pub axis: usize,
    /// 1 velocity, 2 acceleration, 3 jerk.
    pub order: usize,
    /// Value over limit, above 1.
    pub ratio: f64,
}

/// Every sample whose backward differences exceed a limit. The axes are at standstill before the
/// first and after the last sample.
pub(super) fn excess(columns: &[Vec<f64>], limits: &Limits, period_s: f64) -> Vec<Excess> {
    let of_axis = |(axis, (column, limit)): (usize, (&Vec<f64>, &AxisLimits))| excess_of_axis(axis, column, limit, period_s);
    columns.par_iter().zip(&limits.axes).enumerate().flat_map_iter(of_axis).collect()
}

fn excess_of_axis(axis: usize, column: &[f64], limit: &AxisLimits, period_s: f64) -> Vec<Excess> {
    let mut found = Vec::new();
    let rate = 1.0 / period_s;
    let rates = [rate, rate * rate, rate * rate * rate];
    let bounds = [limit.velocity, limit.acceleration, limit.jerk];
    let n = column.len();
    let (mut last, mut speed, mut acceleration) = (column[0], 0.0, 0.0);
    for (k, &position) in column.iter().chain(std::iter::repeat_n(&column[n - 1], 3)).enumerate().skip(1) {
        let v = (position - last) * rate;
        let a = (v - speed) * rate;
        let j = (a - acceleration) * rate;
        (last, speed, acceleration) = (position, v, a);
        // Rounding errors of positions are amplified by a third difference.
        let rounding = 8.0 * f64::EPSILON * position.abs().max(1.0);
        for (order, value) in [v, a, j].into_iter().enumerate() {
            let free_of_noise = value.abs() - rounding * rates[order];
            if free_of_noise > SLACK * bounds[order] {
                found.push(Excess { sample: k.min(n - 1), axis, order: order + 1, ratio: free_of_noise / bounds[order] });
            }
        }
    }
    found
}
