//! Spatial iterative learning control, sILC (Papers A and B).

use motion::contour::{ContourEstimator, HermiteFootPoint};
use motion::{DesiredPath, Trajectory, Vec3};

use crate::{CompensationError, CompensationLaw, LowPass, PoseErrors, Shift, move_poses, pose_errors};

/// Learning gain by run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Gain {
    /// Constant; the papers use 0.8.
    Constant(f64),
    /// `1/j` in run `j`: averages the noise of the runs; a constant gain learns the noise of each
    /// run.
    Decreasing,
}

impl Gain {
    /// Gain of update `j`, counted from zero.
    #[must_use]
    pub fn at(self, j: usize) -> f64 {
        match self {
            Self::Constant(gain) => gain,
            Self::Decreasing => 1.0 / (j + 1) as f64,
        }
    }
}

/// `x_r,i = x_r,i−1 + Q ε_i`, `x_r,0 = x_d`, with `ε` from the actual curve to the desired sample (Paper A, eq. 21-23; in space
/// Paper B, eq. 11; of tool tip and tool axis Paper C, eq. 19-20, whose learning rate `α` is the gain).
pub struct SpatialIlc {
    gain: Gain,
    low_pass: Option<LowPass>,
    estimator: Box<dyn ContourEstimator>,
    turn_s: Option<f64>,
    updates: usize,
}

impl SpatialIlc {
    /// The law with learning gain `Q` and, where given, a zero-phase low-pass on every update.
    ///
    /// # Errors
    /// When a constant gain is not positive. Gains of 2 and more are allowed: they diverge, which Paper A shows.
    pub fn new(gain: Gain, low_pass: Option<LowPass>) -> Result<Self, CompensationError> {
        if let Gain::Constant(value) = gain
            && !(value.is_finite() && value > 0.0)
        {
            return Err(CompensationError::BadSetting {
                name: "learning gain Q",
                value,
                remedy: "it must be positive; it converges below 2",
            });
        }
        Ok(Self { gain, low_pass, estimator: Box::new(HermiteFootPoint::default()), turn_s: None, updates: 0 })
    }

    /// The same law with another contour-error estimator.
    #[must_use]
    pub fn with_estimator(mut self, estimator: Box<dyn ContourEstimator>) -> Self {
        self.estimator = estimator;
        self
    }

    /// The same law with the tracking error instead of the contour error where the path turns
    /// sharply or stops within `turn_s` (a servo's time constant, s).
    ///
    /// A shift acts only after that time. By then the normal of a sharp turn has rotated, and a
    /// stopped path has no foot point for axes that still move; the tracking error shows them in
    /// time.
    #[must_use]
    pub fn with_tracking_in_turns(mut self, turn_s: f64) -> Self {
        self.turn_s = Some(turn_s);
        self
    }
}

impl CompensationLaw for SpatialIlc {
    fn name(&self) -> &'static str {
        "spatial-ilc"
    }

    fn update(
        &mut self,
        desired: &DesiredPath,
        reference: &Trajectory,
        actual: &Trajectory,
    ) -> Result<Trajectory, CompensationError> {
        let PoseErrors { shifts: errors, actual, .. } = pose_errors(desired, actual, self.estimator.as_mut())?;
        let gain = self.gain.at(self.updates);
        let mut shifts: Vec<Shift> = errors.into_iter().map(|error| error.times(gain)).collect();
        if let Some(turn_s) = self.turn_s {
            let reach = (turn_s / desired.trajectory().period_s()).round() as usize;
            let shares = turn_shares(&desired.tips(), reach);
            for ((shift, share), (wanted, actual)) in shifts.iter_mut().zip(shares).zip(desired.poses().iter().zip(&actual)) {
                let in_time = Shift { tip: wanted.tip - actual.tip, tool: wanted.tool - actual.tool };
                *shift = shift.lerp(in_time.times(gain), share);
            }
        }
        if let Some(filter) = &self.low_pass {
            smooth(&mut shifts, filter, desired.kinematics().has_rotary_axes());
        }
        self.updates += 1;
        move_poses(desired, reference, &shifts)
    }
}

/// Filters each coordinate of the shifts; those of the tool only if it rotates.
fn smooth(shifts: &mut [Shift], filter: &LowPass, has_rotary_axes: bool) {
    if has_rotary_axes {
        let both: Vec<[f64; 6]> = shifts.iter().map(|Shift { tip: a, tool: b }| [a.x, a.y, a.z, b.x, b.y, b.z]).collect();
        for (shift, [x, y, z, i, j, k]) in shifts.iter_mut().zip(filter.zero_phase_of(&both)) {
            *shift = Shift { tip: Vec3::new(x, y, z), tool: Vec3::new(i, j, k) };
        }
    } else {
        let tips: Vec<[f64; 3]> = shifts.iter().map(|shift| shift.tip.into()).collect();
        for (shift, tip) in shifts.iter_mut().zip(filter.zero_phase_of(&tips)) {
            shift.tip = tip.into();
        }
    }
}

/// Turn within the reach at which the tracking error counts as much as the contour error, rad.
const SHARP_RAD: f64 = 0.5;

/// Share of the tracking error at every sample, 0 to 1: from the turns and stops within `reach`
/// samples, smoothed over as many.
fn turn_shares(path: &[Vec3], reach: usize) -> Vec<f64> {
    let last = path.len().saturating_sub(1);
    let moves = |k: usize| path[(k + 1).min(last)] != path[k];
    let raw: Vec<f64> = (0..path.len())
        .map(|k| {
            let (from, to) = (k.saturating_sub(reach), (k + reach).min(last));
            if !moves(from) || !moves(to) {
                return 1.0;
            }
            let (before, after) = (path[k] - path[from], path[to] - path[k]);
            let turn = before.angle(&after) / SHARP_RAD;
            turn * turn / (1.0 + turn * turn)
        })
        .collect();
    (0..raw.len())
        .map(|k| {
            let window = &raw[k.saturating_sub(reach)..(k + reach + 1).min(raw.len())];
            window.iter().sum::<f64>() / window.len() as f64
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_and_stops_count_and_straights_do_not() {
        // Standstill, 1 mm a sample along x, a corner, along y, standstill.
        let mut path = vec![Vec3::zeros(); 20];
        path.extend((1..=50).map(|k| Vec3::new(f64::from(k), 0.0, 0.0)));
        path.extend((1..=50).map(|k| Vec3::new(50.0, f64::from(k), 0.0)));
        path.extend(vec![Vec3::new(50.0, 50.0, 0.0); 20]);
        let shares = turn_shares(&path, 5);
        assert!(shares.iter().all(|share| (0.0..=1.0).contains(share)));
        assert_eq!((shares[5], shares[134]), (1.0, 1.0));
        assert!(shares[69] > 0.5, "{}", shares[69]);
        assert_eq!((shares[45], shares[95]), (0.0, 0.0));
        assert!(turn_shares(&[], 5).is_empty() && turn_shares(&[Vec3::zeros()], 5) == [1.0]);
    }
}
