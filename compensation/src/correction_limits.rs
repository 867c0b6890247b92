//! What keeps a learned reference safe: standstill, largest shift, the axes' limits.

use motion::{AxisKind, AxisLimits, DesiredPath, Limits, Pose, SHARE, Trajectory};
use rayon::prelude::*;

use crate::{CompensationError, LowPass};

/// Bounds on the correction, applied after every update of a law.
#[derive(Debug, Clone, PartialEq)]
pub struct CorrectionLimits {
    /// Largest correction of the linear axes together, mm: the length of the vector. On a machine that turns tool or workpiece, of the tool tip in
    /// the workpiece frame.
    pub max_shift: f64,
    /// Largest correction of the tool's direction, rad, on a machine that turns it; of a rotary axis on a machine that does not.
    pub max_rotation_rad: f64,
    /// The machine's limits; the corrected reference exceeds speeds and accelerations by no more than [`CorrectionLimits::OVERSHOOT`].
    pub limits: Option<Limits>,
    /// The correction may move this long before a motion begins and after it ends, s; in between it stands still. Long enough to end a
    /// motion well, too short to carry an axis beyond its stop and back.
    pub settle_s: f64,
    /// Share of the correction to keep at every sample, in `[0, 1]`; empty keeps all.
    pub weights: Vec<f64>,
}

impl Default for CorrectionLimits {
    fn default() -> Self {
        Self {
            max_shift: 0.1,
            max_rotation_rad: Self::MAX_ROTATION_DEG.to_radians(),
            limits: None,
            settle_s: 0.012,
            weights: Vec::new(),
        }
    }
}

impl CorrectionLimits {
    /// Factors by which a corrected reference may exceed the speeds and accelerations that the desired path was planned to: a path at
    /// its limits could not be corrected at all otherwise. What a corner needs lasts milliseconds and stays well within what a
    /// planner's limits keep in hand.
    pub const OVERSHOOT: [f64; 2] = [1.1, 1.5];

    /// Default of [`CorrectionLimits::max_rotation_rad`], degrees: at a 20 mm deep cut it moves the tool's end by 0.17 mm, as much as the default
    /// `max_shift` does.
    pub const MAX_ROTATION_DEG: f64 = 0.5;

    /// `reference` with its correction against `desired` bounded.
    ///
    /// Where the machine turns tool or workpiece its axes belong together: what one of them may not take, none takes.
    ///
    /// # Errors
    /// When the two do not match, or a bound is negative or not finite.
    pub fn apply(&self, desired: &DesiredPath, reference: &Trajectory) -> Result<Trajectory, CompensationError> {
        for (name, value) in [("largest shift, mm,", self.max_shift), ("largest turn, rad,", self.max_rotation_rad)] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(CompensationError::BadSetting { name, value, remedy: "it must be finite and not negative" });
            }
        }
        let path = desired.trajectory();
        path.check_matches(reference)?;
        let turns = desired.kinematics().has_rotary_axes();
        let mut corrections = path.columns().iter().zip(reference.columns());
        let mut corrections: Vec<Vec<f64>> =
            corrections.by_ref().map(|(target, column)| column.iter().zip(target).map(|(r, d)| r - d).collect()).collect();
        if turns {
            self.bound_poses(desired, &mut corrections);
        } else {
            self.bound_axes(path, &mut corrections);
        }
        let settle = samples(self.settle_s, path.period_s());
        let together = turns.then(|| common(path.columns().iter().map(|target| rests(target, settle))));
        let fade = samples(FADE_S, path.period_s());
        for (correction, target) in corrections.iter_mut().zip(path.columns()) {
            match &together {
                Some(rests) => hold(correction, rests, fade),
                None => hold(correction, &rests(target, settle), fade),
            }
            correction.iter_mut().zip(&self.weights).for_each(|(c, weight)| *c *= weight);
        }
        if !turns {
            // At rest an axis holds a mean of other samples than the axes that move.
            self.bound_axes(path, &mut corrections);
        }
        if let Some(limits) = &self.limits {
            let axes =
                if turns { vec![(0..corrections.len()).collect()] } else { (0..corrections.len()).map(|i| vec![i]).collect() };
            for group in axes {
                smooth_where_too_fast(&mut corrections, path, &group, &limits.axes)?;
                fade_where_too_fast(&mut corrections, path, &group, &limits.axes);
            }
        }
        if turns {
            hold_travel(&mut corrections, desired);
        }
        let columns = corrections.iter().zip(path.columns());
        Ok(path.with_columns(columns.map(|(c, d)| c.iter().zip(d).map(|(c, d)| c + d).collect()).collect())?)
    }

    /// Scales the correction of the linear axes where their vector is too long, and clamps that of rotary axes.
    fn bound_axes(&self, path: &Trajectory, corrections: &mut [Vec<f64>]) {
        let (mut linear, mut rotary): (Vec<_>, Vec<_>) =
            corrections.iter_mut().zip(path.axes()).partition(|(_, axis)| axis.kind == AxisKind::Linear);
        rotary
            .iter_mut()
            .flat_map(|(c, _)| c.iter_mut())
            .for_each(|c| *c = c.clamp(-self.max_rotation_rad, self.max_rotation_rad));
        for k in 0..path.len() {
            let length = linear.iter().map(|(correction, _)| correction[k] * correction[k]).sum::<f64>().sqrt();
            if length > self.max_shift {
                linear.iter_mut().for_each(|(correction, _)| correction[k] *= self.max_shift / length);
            }
        }
    }

    /// Scales the correction of all axes where tip or tool would be moved too far.
    fn bound_poses(&self, desired: &DesiredPath, corrections: &mut [Vec<f64>]) {
        let path = desired.trajectory();
        let so_far: &[Vec<f64>] = corrections;
        let kept_of = |joints: &mut Vec<f64>, (k, wanted): (usize, &Pose)| {
            joints.clear();
            joints.extend(path.at(k).zip(so_far).map(|(target, correction)| target + correction[k]));
            let pose = desired.kinematics().forward(joints);
            (self.max_shift / (pose.tip - wanted.tip).norm()).min(self.max_rotation_rad / pose.angle_to(wanted)).min(1.0)
        };
        let poses = desired.poses().par_iter().enumerate().with_min_len(SHARE);
        let kept: Vec<f64> = poses.map_init(Vec::new, kept_of).collect();
        for (k, kept) in kept.into_iter().enumerate().filter(|(_, kept)| *kept < 1.0) {
            corrections.iter_mut().for_each(|correction| correction[k] *= kept);
        }
    }
}

/// No axis leaves its travel for a correction.
fn hold_travel(corrections: &mut [Vec<f64>], desired: &DesiredPath) {
    for (axis, (correction, target)) in corrections.iter_mut().zip(desired.trajectory().columns()).enumerate() {
        if let Some([low, high]) = desired.kinematics().travel(axis) {
            for (c, d) in correction.iter_mut().zip(target) {
                *c = (d + *c).clamp(low.min(*d), high.max(*d)) - d;
            }
        }
    }
}

/// Stretches that lie within one of every list.
fn common(mut lists: impl Iterator<Item = Vec<(usize, usize)>>) -> Vec<(usize, usize)> {
    let Some(first) = lists.next() else { return Vec::new() };
    lists.fold(first, |all, list| {
        let overlap = |a: &(usize, usize), b: &(usize, usize)| (a.0.max(b.0), a.1.min(b.1));
        let mut out: Vec<(usize, usize)> = Vec::new();
        let mut from = 0;
        for a in &all {
            from += list[from..].partition_point(|b| b.1 <= a.0);
            out.extend(list[from..].iter().take_while(|b| b.0 < a.1).map(|b| overlap(a, b)).filter(|o| o.1 > o.0));
        }
        out
    })
}

/// Stretches `(first, last)` in which an axis of the desired path stands still, shortened by `settle` samples on the sides where it moves.
///
/// Axis by axis: in a planar cut the third axis is not to move at all.
fn rests(path: &[f64], settle: usize) -> Vec<(usize, usize)> {
    let n = path.len();
    let still = |k: usize| path[k] == path[k - 1];
    let mut rests = Vec::new();
    let mut k = 1;
    while k < n {
        let first = k - 1;
        while k < n && still(k) {
            k += 1;
        }
        let last = k - 1;
        let from = if first == 0 { 0 } else { first + settle };
        let to = if last + 1 == n { last } else { last.saturating_sub(settle) };
        if last > first && to > from {
            rests.push((from, to));
        }
        k += 1;
    }
    rests
}

/// Holds the correction in every rest at what the law says of it on average, before the first motion at zero.
///
/// What an axis keeps of an error at a standstill is constant: a table behind backlash stays where it was left, and with a sensor on the
/// motor the servo's integrator leaves nothing. A law that moved the command there would only learn noise and wind up.
fn hold(correction: &mut [f64], rests: &[(usize, usize)], fade: usize) {
    for &(first, last) in rests {
        // Each end keeps what the law says there and leaves it within the fade, unless no motion lies beyond it.
        let (leaving, coming) = (correction[first], correction[last]);
        let level = if first > 0 { mean(&correction[first..=last]) } else { 0.0 };
        correction[first..=last].fill(level);
        let share = |i: usize| 0.5 + 0.5 * (std::f64::consts::PI * i as f64 / fade as f64).cos();
        for i in 0..fade.min(last + 1 - first) {
            if first > 0 {
                correction[first + i] += (leaving - level) * share(i);
            }
            if last + 1 < correction.len() {
                correction[last - i] += (coming - level) * share(i);
            }
        }
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Time over which a correction is taken back, s.
const FADE_S: f64 = 0.02;
/// Half the time over which a correction is scaled down around a place where it is too fast, s.
const WINDOW_S: f64 = 0.05;
/// Rounds in which it is scaled down by two thirds there, and in which it is taken away.
const ROUNDS: [usize; 2] = [20, 20];

fn samples(seconds: f64, period_s: f64) -> usize {
    (seconds / period_s).round().max(1.0) as usize
}

/// Rounds in which the correction is smoothed around places where it is too fast, before it is scaled down there; the cut-off of the first, Hz, and the factor
/// from one to the next: the last one is below 5 Hz.
const SMOOTHINGS: usize = 12;
const SMOOTHING_HZ: f64 = 60.0;
const SMOOTHER: f64 = 0.8;

/// Takes what is too fast out of the corrections of the axes of `group` around samples at which one of them would exceed its limits; what is slow stays.
///
/// # Errors
/// Those of [`LowPass::new`], which the cut-offs here do not meet.
fn smooth_where_too_fast(
    corrections: &mut [Vec<f64>],
    path: &Trajectory,
    group: &[usize],
    limits: &[AxisLimits],
) -> Result<(), CompensationError> {
    let half_width = samples(WINDOW_S, path.period_s());
    let n = path.len();
    for round in 0..SMOOTHINGS {
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
        let filter = LowPass::new(SMOOTHING_HZ * SMOOTHER.powi(round as i32), path.period_s())?;
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
fn fade_where_too_fast(corrections: &mut [Vec<f64>], path: &Trajectory, group: &[usize], limits: &[AxisLimits]) {
    let half_width = samples(WINDOW_S, path.period_s());
    let n = path.len();
    for round in 0..ROUNDS[0] + ROUNDS[1] {
        // A raised cosine: from 1 at the window's ends down to what is kept at the place.
        let kept = if round < ROUNDS[0] { 0.3 } else { 0.0 };
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
    // Still too fast: no correction is better than a wild one.
    for axis in group {
        corrections[*axis].fill(0.0);
    }
}

/// Samples at which the corrected axis exceeds its limits by more than its path does anyway.
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
        let allowed_speed = (limit.velocity * CorrectionLimits::OVERSHOOT[0]).max(speed(&plain, *k).abs());
        let allowed_rate = (limit.acceleration * CorrectionLimits::OVERSHOOT[1]).max(rate(&plain, *k).abs());
        speed(&corrected, *k).abs() > allowed_speed * (1.0 + 1e-9) || rate(&corrected, *k).abs() > allowed_rate * (1.0 + 1e-9)
    })
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use motion::{Axis, Cartesian};
    use proptest::prelude::*;

    use super::*;

    fn desired(positions: Vec<f64>) -> DesiredPath {
        let axes = vec![Axis::named("x")];
        let trajectory = Trajectory::new(0.002, axes.clone(), vec![positions]).unwrap();
        DesiredPath::new(trajectory, Arc::new(Cartesian::new(axes))).unwrap()
    }

    /// Rest, a move of 1 mm in 0.4 s, rest, and back.
    fn there_and_back() -> DesiredPath {
        let ramp = |k: usize| 0.5 - 0.5 * (std::f64::consts::PI * k as f64 / 200.0).cos();
        let mut positions = vec![0.0; 100];
        positions.extend((1..=200).map(ramp));
        positions.extend(vec![1.0; 200]);
        positions.extend((0..200).rev().map(ramp));
        positions.extend(vec![0.0; 100]);
        desired(positions)
    }

    fn shifted(path: &DesiredPath, shift: impl Fn(usize) -> f64) -> Trajectory {
        let column = path.trajectory().columns()[0].iter().enumerate().map(|(k, d)| d + shift(k)).collect();
        path.trajectory().with_columns(vec![column]).unwrap()
    }

    fn correction(path: &DesiredPath, reference: &Trajectory) -> Vec<f64> {
        reference.columns()[0].iter().zip(&path.trajectory().columns()[0]).map(|(r, d)| r - d).collect()
    }

    #[test]
    fn nothing_moves_at_a_standstill_and_nothing_jumps() {
        let path = there_and_back();
        let wild = shifted(&path, |k| 0.01 * (k as f64 * 0.05).sin());
        let held = correction(&path, &CorrectionLimits::default().apply(&path, &wild).unwrap());
        assert!(held[..79].iter().all(|c| *c == 0.0));
        // What the law says of the rest on average stays; only its ends follow the law.
        let level = held[400];
        assert!(held[320..=480].iter().all(|c| (c - level).abs() < 1e-15) && level.abs() < 0.003, "{level}");
        assert!(held[305] != level && held[310] != level && held[492] != level);
        let largest = held.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max);
        assert!(largest < 0.003, "{largest}");
    }

    #[test]
    fn no_shift_exceeds_the_bound() {
        let path = there_and_back();
        let guard = CorrectionLimits { max_shift: 0.02, ..CorrectionLimits::default() };
        let bounded = correction(&path, &guard.apply(&path, &shifted(&path, |_| 5.0)).unwrap());
        assert!(bounded.iter().all(|c| c.abs() <= 0.02 + 1e-15));
    }

    proptest! {
        #[test]
        fn no_vector_of_shifts_is_longer_than_the_bound(
            shift in prop::collection::vec(prop::array::uniform3(-0.3..0.3), 60),
            rest in 0..3_usize,
            max_shift in 0.01..0.2,
        ) {
            // Three axes; one of them rests, so that it holds a mean while the others move.
            let axes = ["x", "y", "z"].map(Axis::named).to_vec();
            let column = |axis: usize| (0..60).map(|k| if axis == rest { 0.0 } else { 0.05 * f64::from(k) }).collect();
            let path = Trajectory::new(0.002, axes.clone(), vec![column(0), column(1), column(2)]).unwrap();
            let desired = DesiredPath::new(path.clone(), Arc::new(Cartesian::new(axes))).unwrap();
            let moved = |axis: usize| path.columns()[axis].iter().zip(&shift).map(|(d, s)| d + s[axis]).collect();
            let wild = path.with_columns(vec![moved(0), moved(1), moved(2)]).unwrap();
            let bounded = CorrectionLimits { max_shift, ..CorrectionLimits::default() }.apply(&desired, &wild).unwrap();
            for k in 0..60 {
                let length = path.at(k).zip(bounded.at(k)).map(|(d, r)| (r - d) * (r - d)).sum::<f64>().sqrt();
                prop_assert!(length <= max_shift + 1e-12, "{length} at {k}");
            }
        }
    }

    #[test]
    fn bounds_that_are_none_are_refused() {
        let path = there_and_back();
        for bad in [-1.0, f64::NAN, f64::INFINITY] {
            let shift = CorrectionLimits { max_shift: bad, ..CorrectionLimits::default() };
            let turn = CorrectionLimits { max_rotation_rad: bad, ..CorrectionLimits::default() };
            assert!(shift.apply(&path, path.trajectory()).is_err() && turn.apply(&path, path.trajectory()).is_err());
        }
    }

    #[test]
    fn the_axis_limits_are_held() {
        let path = there_and_back();
        let limits = Limits::uniform(1, 10.0, 100.0, 0.02);
        let guard = CorrectionLimits { limits: Some(limits), ..CorrectionLimits::default() };
        let reference = guard.apply(&path, &shifted(&path, |k| 0.01 * (k as f64 * 0.9).sin())).unwrap();
        let x = &reference.columns()[0];
        for k in 2..x.len() {
            let a = (x[k] - 2.0 * x[k - 1] + x[k - 2]) / 4e-6;
            assert!(a.abs() <= 150.0 + 1e-3, "{a} at {k}");
        }
        // A gentle correction is left alone.
        let gentle = shifted(&path, |k| 0.001 * (k as f64 * 0.01).sin());
        let kept = correction(&path, &guard.apply(&path, &gentle).unwrap());
        assert!((kept[200] - 0.001 * 2.0_f64.sin()).abs() < 1e-9);
    }
}
