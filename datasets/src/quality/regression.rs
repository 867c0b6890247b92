//! Regression of the tracking error on terms of the motion.

use nalgebra::{SMatrix, SVector};

use super::signals::{Signals, standstill_speed};

/// Rows of a run that count.
const ROWS: usize = 2000;

/// The motion at a row of a run.
pub(super) struct Motion {
    pub speed: f64,
    pub acceleration: f64,
    /// −1, 0 or 1.
    pub direction: f64,
    pub position: f64,
    pub time_s: f64,
    /// Command minus actual position.
    pub error: f64,
}

/// The counted rows of a run.
pub(super) fn motions(axis: &Signals) -> Vec<Motion> {
    let period_s = axis.period_s;
    let length = axis.reference.len();
    let at = |k: usize| {
        let [before, here, after] = [axis.reference[k - 2], axis.reference[k], axis.reference[k + 2]];
        let speed = (after - before) / (4.0 * period_s);
        let direction = if speed.abs() > standstill_speed(axis.axis.kind) { speed.signum() } else { 0.0 };
        let acceleration = (after - 2.0 * here + before) / (4.0 * period_s * period_s);
        Motion { speed, acceleration, direction, position: here, time_s: k as f64 * period_s, error: axis.error[k] }
    };
    let step = length.div_ceil(ROWS).max(1);
    (2..length.saturating_sub(2)).step_by(step).map(at).collect()
}

/// Least-squares slopes of an error over its terms, and the RMS of what they leave; `None` where the terms do not tell them.
pub(super) fn slopes<const TERMS: usize>(rows: &[(SVector<f64, TERMS>, f64)]) -> Option<(SVector<f64, TERMS>, f64)> {
    let (mut normal, mut right) = (SMatrix::<f64, TERMS, TERMS>::zeros(), SVector::<f64, TERMS>::zeros());
    for (terms, error) in rows {
        normal += terms * terms.transpose();
        right += terms * *error;
    }
    // Units of the terms alike, so that their sizes do not matter.
    let scale = normal.diagonal().map(|square| if square > 0.0 { square.sqrt() } else { 1.0 });
    let scaled = normal.component_div(&(scale * scale.transpose())) + SMatrix::identity() * 1e-12;
    let slopes = scaled.cholesky()?.solve(&right.component_div(&scale)).component_div(&scale);
    let rest = rows.iter().map(|(terms, error)| (error - slopes.dot(terms)).powi(2)).sum::<f64>() / rows.len() as f64;
    Some((slopes, rest.sqrt()))
}
