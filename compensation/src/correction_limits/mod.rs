//! Limits of a learned reference: standstill, largest shift, limits of the axes.

mod axis_limits;
mod standstills;

use std::ops::Range;

use motion::{AxisKind, DesiredPath, Limits, Pose, SHARE, Trajectory};
use rayon::prelude::*;

pub use axis_limits::OVERSHOOT;
use axis_limits::{scale_where_too_fast, smooth_where_too_fast};
pub use standstills::Held;
use standstills::{TAPER_S, common, hold, samples, standstills};

use crate::CompensationError;

/// Bounds on the correction, applied after every update of a law.
#[derive(Debug, Clone, PartialEq)]
pub struct CorrectionLimits {
    /// Largest correction of the linear axes, mm: length of the vector. On a machine that rotates
    /// tool or workpiece: of the tool tip in the workpiece frame.
    pub max_shift: f64,
    /// Largest correction of the tool's direction, rad, on a machine that rotates it; of a rotary
    /// axis on other machines.
    pub max_rotation_rad: f64,
    /// Limits of the machine. The corrected reference exceeds speeds and accelerations by no more
    /// than [`OVERSHOOT`].
    pub limits: Option<Limits>,
    /// Duration of the correction before a motion begins and after it ends, s; at standstill it is
    /// constant between. Long enough for a good end of the motion, too short to move an axis beyond
    /// its stop and back.
    pub settle_s: f64,
    /// Standstills in which the correction is constant.
    pub held: Held,
    /// Taper: share of the correction to keep at every sample, in `[0, 1]`; empty keeps all.
    pub weights: Vec<f64>,
    /// Samples, in order, at which each axis is not corrected, on a machine that rotates tool or workpiece; empty for no axis. The tip is corrected by the
    /// other axes there.
    pub resting: Vec<Vec<Range<usize>>>,
}

impl Default for CorrectionLimits {
    fn default() -> Self {
        Self {
            max_shift: 0.1,
            max_rotation_rad: Self::MAX_ROTATION_DEG.to_radians(),
            limits: None,
            settle_s: 0.012,
            held: Held::EachAxis,
            weights: Vec::new(),
            resting: Vec::new(),
        }
    }
}

impl CorrectionLimits {
    /// Default of [`CorrectionLimits::max_rotation_rad`], degrees: at a 20 mm deep cut it moves the
    /// tool's end by 0.17 mm, as much as the default of `max_shift`.
    pub const MAX_ROTATION_DEG: f64 = 0.5;

    /// Limits the correction of `reference` against `desired`.
    ///
    /// If the machine rotates tool or workpiece, its axes are limited together.
    ///
    /// # Errors
    /// When the two do not match, or a limit is negative or not finite.
    pub fn apply(&self, desired: &DesiredPath, reference: &Trajectory) -> Result<Trajectory, CompensationError> {
        self.apply_step(desired, desired.trajectory(), reference)
    }

    /// The same for a step to `reference` from a reference within the limits: taper and standstills are those of the step, so that none leaves `from` as it
    /// is. Of the whole correction they would take something off with every step.
    ///
    /// # Errors
    /// As [`apply`](Self::apply).
    pub fn apply_step(
        &self,
        desired: &DesiredPath,
        from: &Trajectory,
        reference: &Trajectory,
    ) -> Result<Trajectory, CompensationError> {
        for (name, value) in [("largest shift, mm,", self.max_shift), ("largest turn, rad,", self.max_rotation_rad)] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(CompensationError::BadSetting { name, value, remedy: "it must be finite and not negative" });
            }
        }
        let path = desired.trajectory();
        path.check_matches(reference)?;
        path.check_matches(from)?;
        let has_rotary_axes = desired.kinematics().has_rotary_axes();
        let of = |reference: &Trajectory| -> Vec<Vec<f64>> {
            let pairs = path.columns().iter().zip(reference.columns());
            pairs.map(|(target, column)| column.iter().zip(target).map(|(r, d)| r - d).collect()).collect()
        };
        let (before, mut corrections) = (of(from), of(reference));
        if has_rotary_axes {
            self.rest(desired, &mut corrections);
            self.bound_poses(desired, &mut corrections);
        } else {
            self.bound_axes(path, &mut corrections);
        }
        let settle = samples(self.settle_s, path.period_s());
        let of_axes: Vec<_> = path.columns().iter().map(|target| standstills(target, settle)).collect();
        let of_all = (has_rotary_axes || self.held == Held::AllAxes).then(|| common(of_axes.iter().cloned()));
        let taper = samples(TAPER_S, path.period_s());
        for ((correction, before), own) in corrections.iter_mut().zip(&before).zip(&of_axes) {
            correction.iter_mut().zip(before).for_each(|(c, before)| *c -= before);
            hold(correction, of_all.as_ref().unwrap_or(own), taper);
            correction.iter_mut().zip(&self.weights).for_each(|(c, weight)| *c *= weight);
            correction.iter_mut().zip(before).for_each(|(c, before)| *c += before);
        }
        if !has_rotary_axes {
            // At standstill an axis holds a mean over other samples than the moving axes.
            self.bound_axes(path, &mut corrections);
        }
        if let Some(limits) = &self.limits {
            let axes = if has_rotary_axes {
                vec![(0..corrections.len()).collect()]
            } else {
                (0..corrections.len()).map(|i| vec![i]).collect()
            };
            for group in axes {
                smooth_where_too_fast(&mut corrections, path, &group, &limits.axes)?;
                scale_where_too_fast(&mut corrections, path, &group, &limits.axes);
            }
        }
        if has_rotary_axes {
            hold_travel(&mut corrections, desired);
            // Limits of the axes may have spread what is beside a rest.
            for (correction, resting) in corrections.iter_mut().zip(&self.resting) {
                resting.iter().for_each(|samples| correction[samples.clone()].fill(0.0));
            }
        }
        let columns = corrections.iter().zip(path.columns());
        Ok(path.with_columns(columns.map(|(c, d)| c.iter().zip(d).map(|(c, d)| c + d).collect()).collect())?)
    }

    /// Takes the correction off axes that rest, and gives it to the others, so that the tip stays where it is; takes all of it off where their travel
    /// does not reach that far.
    fn rest(&self, desired: &DesiredPath, corrections: &mut [Vec<f64>]) {
        let (path, kinematics) = (desired.trajectory(), desired.kinematics());
        let rests = |axis: usize, k: usize| {
            let next = self.resting[axis].partition_point(|samples| samples.end <= k);
            self.resting[axis].get(next).is_some_and(|samples| samples.contains(&k))
        };
        let axes = self.resting.len().min(corrections.len());
        for k in 0..path.len() {
            let mut resting = (0..axes).filter(|axis| rests(*axis, k)).peekable();
            if resting.peek().is_none() {
                continue;
            }
            let mut joints: Vec<f64> =
                path.at(k).zip(corrections.iter()).map(|(target, correction)| target + correction[k]).collect();
            let tip = kinematics.forward(&joints).tip;
            resting.for_each(|axis| joints[axis] -= corrections[axis][k]);
            let mut rotary = [0.0; 3];
            for (axis, joint) in path.axes().iter().zip(&joints) {
                if let Some(slot) = axis.slot().and_then(|slot| slot.checked_sub(3)) {
                    rotary[slot] = *joint;
                }
            }
            let is_placed = kinematics.place_at(&tip, &rotary, &mut joints).is_ok();
            for (correction, (joint, target)) in corrections.iter_mut().zip(joints.iter().zip(path.at(k))) {
                correction[k] = if is_placed { joint - target } else { 0.0 };
            }
        }
    }

    /// Scales the correction of the linear axes where their vector is too long, and clamps that of
    /// rotary axes.
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

    /// Scales the correction of all axes where the shift of tip or tool is too large.
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

/// Limits corrections to the travel of the axes.
fn hold_travel(corrections: &mut [Vec<f64>], desired: &DesiredPath) {
    for (axis, (correction, target)) in corrections.iter_mut().zip(desired.trajectory().columns()).enumerate() {
        if let Some([low, high]) = desired.kinematics().travel(axis) {
            for (c, d) in correction.iter_mut().zip(target) {
                *c = (d + *c).clamp(low.min(*d), high.max(*d)) - d;
            }
        }
    }
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

    /// Standstill, a move of 1 mm in 0.4 s, standstill, and back.
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
        // At standstill the mean correction of the law remains; only its ends follow the law.
        let level = held[400];
        assert!(held[320..=480].iter().all(|c| (c - level).abs() < 1e-15) && level.abs() < 0.003, "{level}");
        assert!(held[305] != level && held[310] != level && held[492] != level);
        let largest = held.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max);
        assert!(largest < 0.003, "{largest}");
    }

    #[test]
    fn a_step_that_is_none_changes_nothing_and_further_steps_reach_what_taper_and_standstills_leave() {
        let path = there_and_back();
        let weights: Vec<f64> = (0..path.trajectory().len()).map(|k| (k as f64 / 100.0).min(1.0)).collect();
        let limits = CorrectionLimits { weights, ..CorrectionLimits::default() };
        let wave = |k: usize| 0.01 * (k as f64 * 0.05).sin();
        let first = limits.apply(&path, &shifted(&path, wave)).unwrap();
        let again = limits.apply_step(&path, &first, &first).unwrap();
        let most = |one: &Trajectory, other: &Trajectory| {
            let pairs = one.columns()[0].iter().zip(&other.columns()[0]);
            pairs.map(|(one, other)| (one - other).abs()).fold(0.0, f64::max)
        };
        assert!(most(&first, &again) < 1e-14, "{}", most(&first, &again));
        // The whole correction, limited again, loses some of itself.
        assert!(most(&first, &limits.apply(&path, &first).unwrap()) > 1e-4);
        // Half of a correction, then the other half, is all of it.
        let half = limits.apply(&path, &shifted(&path, |k| 0.5 * wave(k))).unwrap();
        let on = half.columns()[0].iter().enumerate().map(|(k, at)| at + 0.5 * wave(k)).collect();
        let whole = limits.apply_step(&path, &half, &path.trajectory().with_columns(vec![on]).unwrap()).unwrap();
        assert!(most(&first, &whole) < 1e-12);
    }

    #[test]
    fn no_shift_exceeds_the_bound() {
        let path = there_and_back();
        let correction_limits = CorrectionLimits { max_shift: 0.02, ..CorrectionLimits::default() };
        let bounded = correction(&path, &correction_limits.apply(&path, &shifted(&path, |_| 5.0)).unwrap());
        assert!(bounded.iter().all(|c| c.abs() <= 0.02 + 1e-15));
    }

    proptest! {
        #[test]
        fn no_vector_of_shifts_is_longer_than_the_bound(
            shift in prop::collection::vec(prop::array::uniform3(-0.3..0.3), 60),
            standstill in 0..3_usize,
            max_shift in 0.01..0.2,
            each in prop::bool::ANY,
        ) {
            let held = if each { Held::EachAxis } else { Held::AllAxes };
            // Three axes, one of them at standstill: of each axis it holds a mean while the others move.
            let axes = ["x", "y", "z"].map(Axis::named).to_vec();
            let column = |axis: usize| (0..60).map(|k| if axis == standstill { 0.0 } else { 0.05 * f64::from(k) }).collect();
            let path = Trajectory::new(0.002, axes.clone(), vec![column(0), column(1), column(2)]).unwrap();
            let desired = DesiredPath::new(path.clone(), Arc::new(Cartesian::new(axes))).unwrap();
            let moved = |axis: usize| path.columns()[axis].iter().zip(&shift).map(|(d, s)| d + s[axis]).collect();
            let wild = path.with_columns(vec![moved(0), moved(1), moved(2)]).unwrap();
            let bounded = CorrectionLimits { max_shift, held, ..CorrectionLimits::default() }.apply(&desired, &wild).unwrap();
            for k in 0..60 {
                let length = path.at(k).zip(bounded.at(k)).map(|(d, r)| (r - d) * (r - d)).sum::<f64>().sqrt();
                prop_assert!(length <= max_shift + 1e-12, "{length} at {k}");
            }
        }
    }

    #[test]
    fn an_axis_at_standstill_is_corrected_while_others_move_where_all_are_held_together() {
        let axes = ["x", "y"].map(Axis::named).to_vec();
        let moves = (0..200).map(|k| 0.02 * f64::from(k.clamp(50, 150) - 50)).collect();
        let path = Trajectory::new(0.002, axes.clone(), vec![moves, vec![0.0; 200]]).unwrap();
        let desired = DesiredPath::new(path.clone(), Arc::new(Cartesian::new(axes))).unwrap();
        let wave: Vec<f64> = (0..200).map(|k| 0.01 * (f64::from(k) * 0.1).sin()).collect();
        let wanted = path.with_columns(vec![path.columns()[0].clone(), wave.clone()]).unwrap();
        let of_still = |held: Held| {
            let limits = CorrectionLimits { held, ..CorrectionLimits::default() };
            limits.apply(&desired, &wanted).unwrap().columns()[1].clone()
        };
        let (together, alone) = (of_still(Held::AllAxes), of_still(Held::EachAxis));
        assert!((60..140).all(|k| (together[k] - wave[k]).abs() < 1e-12), "{together:?}");
        // It never moves: there is nothing before its first motion to correct.
        assert!(alone[..180].iter().all(|c| *c == 0.0), "{alone:?}");
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
        let correction_limits = CorrectionLimits { limits: Some(limits), ..CorrectionLimits::default() };
        let reference = correction_limits.apply(&path, &shifted(&path, |k| 0.01 * (k as f64 * 0.9).sin())).unwrap();
        let x = &reference.columns()[0];
        for k in 2..x.len() {
            let a = (x[k] - 2.0 * x[k - 1] + x[k - 2]) / 4e-6;
            assert!(a.abs() <= 150.0 + 1e-3, "{a} at {k}");
        }
        // A slow correction remains unchanged.
        let gentle = shifted(&path, |k| 0.001 * (k as f64 * 0.01).sin());
        let kept = correction(&path, &correction_limits.apply(&path, &gentle).unwrap());
        assert!((kept[200] - 0.001 * 2.0_f64.sin()).abs() < 1e-9);
    }
}
