//! Corrections that would take an axis beyond its speed or acceleration.

use motion::{AxisLimits, Trajectory};

use super::standstills::samples;
use crate::{CompensationError, LowPass};

/// Factors by which a corrected reference may exceed the speeds and accelerations of the
/// desired path's plan; otherwise a path at its limits could not be corrected at all. A corner
/// needs the excess for milliseconds, well within the reserve of a planner's limits.
pub const OVERSHOOT: [f64; 2] = [1.1, 1.5];

/// Half of the window in which a correction is scaled down around a position where it is too fast,
/// s.
const WINDOW_S: f64 = 0.05;
/// Iterations that scale it down to 0.3 there, and iterations that remove it.
const SCALINGS: [usize; 2] = [20, 20];

/// Iterations that smooth the correction around positions where it is too fast, before it is scaled
/// down there; cut-off of the first, Hz, and ratio of successive cut-offs. The last one is below 5
/// Hz.
const SMOOTHINGS: usize = 12;
const SMOOTHING_HZ: f64 = 60.0;
const SMOOTHER: f64 = 0.8;

/// Low-passes the corrections of the axes of `group` around samples at which one of them would
/// exceed its limits.
///
/// # Errors
/// Those of [`LowPass::new`], which the cut-offs here do not cause.
pub(super) fn smooth_where_too_fast(
    corrections: &mut [Vec<f64>],
    path: &Trajectory,
    group: &[usize],
    limits: &[AxisLimits],
) -> Result<(), CompensationError> {
    let half_width = samples(WINDOW_S, path.period_s());
    let n = path.len();
    for iteration in 0..SMOOTHINGS {
        let mut smoothed = vec![0.0_f64; n];
        let mut exceeded = false;
        for axis in group {
            let Some(limit) = limits.get(*axis) else { continue };
            for k in too_fast(&corrections[*axis], &path.columns()[*axis], path.period_s(), limit) {
                exceeded = true;
                let first = k.saturating_sub(half_width);
                for (i, share) in smoothed.iter_mut().enumerate().take((k + half_width).min(n)).skip(first) {
                    let distance = i.abs_diff(k) as f64 / half_width as f64;
                    *share = share.max(0.5 + 0.5 * (std::f64::consts::PI * distance).cos());
                }
            }
        }
        let filter = LowPass::new(SMOOTHING_HZ * SMOOTHER.powi(iteration as i32), path.period_s())?;
        let (true, Some(filter)) = (exceeded, filter) else { return Ok(()) };
        for axis in group {
            let slow = filter.zero_phase(&corrections[*axis]);
            let values = corrections[*axis].iter_mut().zip(slow).zip(&smoothed);
            values.for_each(|((c, slow), share)| *c += share * (slow - *c));
        }
    }
    Ok(())
}

/// Scales the corrections of the axes of `group` down around samples at which one of them would exceed its limits.
pub(super) fn scale_where_too_fast(corrections: &mut [Vec<f64>], path: &Trajectory, group: &[usize], limits: &[AxisLimits]) {
    let half_width = samples(WINDOW_S, path.period_s());
    let n = path.len();
    for iteration in 0..SCALINGS[0] + SCALINGS[1] {
        // A raised cosine: 1 at the ends of the window, `kept` at its centre.
        let kept = if iteration < SCALINGS[0] { 0.3 } else { 0.0 };
        let mut scale = vec![1.0_f64; n];
        let mut exceeded = false;
        for axis in group {
            let Some(limit) = limits.get(*axis) else { continue };
            for k in too_fast(&corrections[*axis], &path.columns()[*axis], path.period_s(), limit) {
                exceeded = true;
                for (i, s) in scale.iter_mut().enumerate().take((k + half_width).min(n)).skip(k.saturating_sub(half_width)) {
                    let distance = i.abs_diff(k) as f64 / half_width as f64;
                    let window = 1.0 - 0.5 * (1.0 - kept) * (1.0 + (std::f64::consts::PI * distance).cos());
                    *s = s.min(window);
                }
            }
        }
        if !exceeded {
            return;
        }
        for axis in group {
            corrections[*axis].iter_mut().zip(&scale).for_each(|(c, s)| *c *= s);
        }
    }
    // Still too fast: remove the correction.
    for axis in group {
        corrections[*axis].fill(0.0);
    }
}

/// Samples at which the corrected axis exceeds its limits by more than its path does.
fn too_fast<'a>(
    correction: &'a [f64],
    desired: &'a [f64],
    period_s: f64,
    limit: &'a AxisLimits,
) -> impl Iterator<Item = usize> + 'a {
    let corrected = move |k: usize| desired[k] + correction[k];
    let speed = move |at: &dyn Fn(usize) -> f64, k: usize| (at(k) - at(k - 1)) / period_s;
    let rate = move |at: &dyn Fn(usize) -> f64, k: usize| (at(k) - 2.0 * at(k - 1) + at(k - 2)) / (period_s * period_s);
    let plain = move |k: usize| desired[k];
    (2..desired.len()).filter(move |k| {
        let allowed_speed = (limit.velocity * OVERSHOOT[0]).max(speed(&plain, *k).abs());
        let allowed_rate = (limit.acceleration * OVERSHOOT[1]).max(rate(&plain, *k).abs());
        speed(&corrected, *k).abs() > allowed_speed * (1.0 + 1e-9) || rate(&corrected, *k).abs() > allowed_rate * (1.0 + 1e-9)
    })
}
