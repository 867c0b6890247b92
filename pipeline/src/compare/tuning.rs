//! Settings of every ILC law, tuned for each machine on a separate curve and noise seed.
//!
//! Every law runs on [`tuning_curve`] on the compared machine with another noise seed. The search starts from every
//! other cut-off with every window at stops and sharp turns (or every other weight `R`). From the best candidate it
//! goes to better neighbours (cut-off, gain, window; or `R`, `S`) until there is none. The cost is the mean over the
//! last runs, see `Trial::cost`. A law that diverges is therefore never chosen where a lower cut-off converges.

use std::collections::BTreeMap;
use std::sync::Arc;

use compensation::laws::{Gain, NormOptimalIlc, NormOptimalSettings, SpatialIlc, TrackingIlc};
use compensation::{CompensationLaw, CorrectionLimits, Held, ImpulseResponse, Iteration, LowPass, StopRule, learn};
use machine::Machine;
use motion::contour::Exact;
use motion::curves::{Curve, OnSaddle, library};
use motion::{AxisKind, DesiredPath, Limits, Trajectory, plan_curve_on, poses_of};
use rayon::prelude::*;

use super::method::Ilc;
use super::plant::Plant;
use super::settings::{CompareSettings, FEED_MM_S};
use crate::error::{Error, Result};
use crate::model_based_ilc::{PROBE, RESPONSE_S};
use crate::progress::{Job, Progress, Steps};
use crate::setup::Setup;
use crate::statistics;

/// Settings of one law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LawSettings {
    /// Settings of a law with a gain and a low-pass.
    Filtered {
        /// Learning gain.
        gain: Gain,
        /// Cut-off of the zero-phase low-pass on every update, Hz.
        low_pass_hz: f64,
        /// Time around stops and sharp turns in which a spatial law uses the tracking error, s; 0 for none.
        window_s: f64,
    },
    /// Settings of a norm-optimal law: its weights `S` and `R`.
    NormOptimal {
        /// Weight of the correction.
        s: f64,
        /// Weight of the correction's change from run to run.
        r: f64,
    },
}

/// Candidate cut-offs, Hz: from below the bandwidth of a slow servo to above that of a fast one.
const CUT_OFFS_HZ: [f64; 7] = [8.0, 12.0, 20.0, 35.0, 60.0, 100.0, 150.0];
/// Candidate gains. The papers use 0.8. A lower gain learns less noise, a higher one converges in fewer runs.
const GAINS: [f64; 3] = [0.5, 0.8, 1.0];
/// Candidate windows around stops and sharp turns, s: none, and the time constants of position loops of 100 and 40 1/s.
const WINDOWS_S: [f64; 3] = [0.0, 0.01, 0.025];
/// Candidate weights `S` and `R`. Paper E uses 1e-3 for both; `R` damps noise like a lower gain.
const WEIGHTS_S: [f64; 3] = [1e-3, 1e-2, 1e-1];
const WEIGHTS_R: [f64; 3] = [1e-3, 0.3, 1.0];
/// Start index of the gain, and index of the window without tuning: 0.8 and 10 ms, as in the papers and the first run.
const START_GAIN: usize = 1;
const START_WINDOW: usize = 1;

/// Offset of the tuning noise seed from the first seed; the seeds of compared runs are 1000 apart.
pub(super) const TUNING_SEED: u64 = 500;
/// Number of points of the tuning curve, their standard deviation, mm, and its seed: a motion of some seconds between
/// standstills. No reported curve has so few points.
const TUNING_POINTS: usize = 6;
const TUNING_SIGMA_MM: f64 = 8.0;
const TUNING_CURVE_SEED: u64 = 901;
/// Number of last runs whose mean cost is the cost of a candidate.
const COST_RUNS: usize = 3;
/// Bounds of divergence: the ratio of a run's error to that of the uncompensated run, and the ratio of the last run's
/// error to that of the best run. Noise changes the RMS of a run by less than a tenth.
const MOST_GROWTH: f64 = 2.0;
const MOST_RISE: f64 = 1.25;

/// Settings of every ILC law on one machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Tuned {
    /// The laws with their settings.
    pub laws: Vec<(Ilc, LawSettings)>,
    /// Whether the settings were tuned on the machine; otherwise they were given.
    pub searched: bool,
}

impl Tuned {
    /// Settings of `law`, where it has been tuned.
    #[must_use]
    pub fn of(&self, law: Ilc) -> Option<LawSettings> {
        self.laws.iter().find(|(known, _)| *known == law).map(|(_, settings)| *settings)
    }

    /// Tunes every law on `plant`. If gain and cut-off are both given, takes them, with the weights of Paper E.
    ///
    /// # Errors
    /// When the tuning curve cannot be planned, or the machine cannot run it.
    pub fn on(plant: Plant<'_>, laws: &[Ilc], setup: &Setup, settings: &CompareSettings, progress: Progress<'_>) -> Result<Self> {
        let grid = Grid::of(settings.ilc_gain, settings.ilc_low_pass_hz);
        if settings.ilc_gain.is_some() && settings.ilc_low_pass_hz.is_some() {
            let given = |law: &Ilc| (*law, Candidate([0, 0, START_WINDOW]).settings(*law, &grid));
            return Ok(Self { laws: laws.iter().map(given).collect(), searched: false });
        }
        let desired = tuning_curve(setup).map_err(|error| Error::TuningCurve(Box::new(error)))?;
        let trial = Trial { plant, desired, limits: setup.limits.clone(), settings, grid };
        let steps = Steps::new(progress, Job::TuningIlc, laws.len());
        let tuned = |law: &Ilc| {
            let best = trial.best(*law)?.settings(*law, &trial.grid);
            steps.step(law.name())?;
            Ok((*law, best))
        };
        let laws = laws.par_iter().map(tuned);
        Ok(Self { laws: laws.collect::<Result<_>>()?, searched: true })
    }
}

impl LawSettings {
    /// The law with these settings; `responses` are the machine's impulse responses for norm-optimal laws.
    ///
    /// # Errors
    /// When a setting is out of range.
    pub fn law(self, law: Ilc, period_s: f64, responses: &[ImpulseResponse]) -> Result<Box<dyn CompensationLaw>> {
        Ok(match self {
            Self::NormOptimal { s, r } => {
                let a = if law == Ilc::CrossCoupled { 1.0 } else { 0.0 };
                Box::new(NormOptimalIlc::new(NormOptimalSettings { a, s, r }, responses.to_vec())?)
            }
            Self::Filtered { gain, low_pass_hz, window_s } if law.is_spatial() => {
                let spatial = SpatialIlc::new(gain, LowPass::new(low_pass_hz, period_s)?)?;
                let spatial = spatial.with_estimator(Box::new(Exact::default()));
                Box::new(if window_s > 0.0 { spatial.with_tracking_in_turns(window_s) } else { spatial })
            }
            Self::Filtered { gain, low_pass_hz, .. } => Box::new(TrackingIlc::new(gain, LowPass::new(low_pass_hz, period_s)?)),
        })
    }

    /// The settings for programs: another cut-off and no window, since a control takes a correction along the path as
    /// another position at which to slow down.
    #[must_use]
    pub fn for_programs(self, low_pass_hz: f64) -> Self {
        match self {
            Self::Filtered { gain, .. } => Self::Filtered { gain, low_pass_hz, window_s: 0.0 },
            weights => weights,
        }
    }

    /// Cut-off of the low-pass, Hz; `None` for norm-optimal laws.
    #[must_use]
    pub fn low_pass_hz(self) -> Option<f64> {
        match self {
            Self::Filtered { low_pass_hz, .. } => Some(low_pass_hz),
            Self::NormOptimal { .. } => None,
        }
    }
}

/// Grid of candidate values.
struct Grid {
    gains: Vec<f64>,
    cut_offs_hz: Vec<f64>,
}

impl Grid {
    fn of(gain: Option<f64>, low_pass_hz: Option<f64>) -> Self {
        Self {
            gains: gain.map_or(GAINS.to_vec(), |gain| vec![gain]),
            cut_offs_hz: low_pass_hz.map_or(CUT_OFFS_HZ.to_vec(), |hz| vec![hz]),
        }
    }

    /// Number of values along each grid coordinate of a law: cut-off, gain, window; or `R`, `S`.
    fn sizes(&self, law: Ilc) -> [usize; 3] {
        if law.is_norm_optimal() {
            return [WEIGHTS_R.len(), WEIGHTS_S.len(), 1];
        }
        let gains = if law.is_decreasing() { 1 } else { self.gains.len() };
        [self.cut_offs_hz.len(), gains, if law.is_spatial() { WINDOWS_S.len() } else { 1 }]
    }
}

/// Grid indices of a candidate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Candidate([usize; 3]);

impl Candidate {
    fn settings(self, law: Ilc, grid: &Grid) -> LawSettings {
        let [first, second, third] = self.0;
        if law.is_norm_optimal() {
            return LawSettings::NormOptimal { s: WEIGHTS_S[second], r: WEIGHTS_R[first] };
        }
        let gain = if law.is_decreasing() { Gain::Decreasing } else { Gain::Constant(grid.gains[second]) };
        LawSettings::Filtered { gain, low_pass_hz: grid.cut_offs_hz[first], window_s: WINDOWS_S[third] }
    }

    /// Candidates one step away along one coordinate.
    fn neighbours(self, sizes: [usize; 3]) -> Vec<Self> {
        let mut found = Vec::new();
        for (coordinate, size) in sizes.into_iter().enumerate() {
            let at = self.0[coordinate];
            for next in [at.checked_sub(1), Some(at + 1).filter(|next| *next < size)].into_iter().flatten() {
                let mut point = self.0;
                point[coordinate] = next;
                found.push(Self(point));
            }
        }
        found
    }
}

/// Machine and curve on which candidates are evaluated.
struct Trial<'a> {
    plant: Plant<'a>,
    desired: DesiredPath,
    limits: Limits,
    settings: &'a CompareSettings,
    grid: Grid,
}

impl Trial<'_> {
    /// Best candidate of a law: a coarse scan, then a descent to better neighbours.
    fn best(&self, law: Ilc) -> Result<Candidate> {
        let sizes = self.grid.sizes(law);
        let second = if law.is_norm_optimal() { 0 } else { START_GAIN.min(sizes[1] - 1) };
        let mut known: BTreeMap<Candidate, f64> = BTreeMap::new();
        let every_other = (0..sizes[0]).skip(usize::from(sizes[0] > 1)).step_by(2);
        let mut next: Vec<Candidate> =
            every_other.flat_map(|first| (0..sizes[2]).map(move |third| Candidate([first, second, third]))).collect();
        loop {
            let costs = next.par_iter().map(|point| Ok((*point, self.cost(law, *point)?))).collect::<Result<Vec<_>>>()?;
            known.extend(costs);
            let best = known.iter().min_by(|one, other| one.1.total_cmp(other.1)).map(|(point, _)| *point);
            let best = best.ok_or(Error::NoRun(law.name()))?;
            next = best.neighbours(sizes).into_iter().filter(|point| !known.contains_key(point)).collect();
            if next.is_empty() {
                return Ok(best);
            }
        }
    }

    /// Mean cost of the last runs, mm; infinite where the law diverges or the machine refuses a reference.
    fn cost(&self, law: Ilc, point: Candidate) -> Result<f64> {
        let desired = &self.desired;
        let seed = self.settings.seed.wrapping_add(TUNING_SEED);
        let mut machine = self.plant.machine(seed, self.settings.simulation)?;
        let machine = machine.as_mut();
        let uncompensated = machine.run(desired.trajectory())?;
        let responses = if law.is_norm_optimal() { probe(machine, desired)? } else { Vec::new() };
        let settings = point.settings(law, &self.grid);
        let mut law = settings.law(law, desired.trajectory().period_s(), &responses)?;
        let correction_limits = ilc_correction_limits(desired, Some(&self.limits), &uncompensated, settings)?;
        let most = MOST_GROWTH * statistics::figures(desired, None, &uncompensated)?.cost_mm();
        let mut reference = desired.trajectory().clone();
        let mut actual = uncompensated;
        let mut costs = Vec::new();
        for _ in 0..self.settings.ilc_runs {
            let Ok(next) = law.update(desired, &reference, &actual) else { return Ok(f64::INFINITY) };
            reference = correction_limits.apply_step(desired, &reference, &next)?;
            let Ok(run) = machine.run(&reference) else { return Ok(f64::INFINITY) };
            actual = run;
            let cost = statistics::figures(desired, None, &actual)?.cost_mm();
            if cost.is_nan() || cost > most {
                return Ok(f64::INFINITY);
            }
            costs.push(cost);
        }
        let lowest = costs.iter().fold(f64::INFINITY, |low, cost| low.min(*cost));
        if costs.last().is_some_and(|last| *last > MOST_RISE * lowest) {
            return Ok(f64::INFINITY);
        }
        let last = &costs[costs.len().saturating_sub(COST_RUNS)..];
        Ok(last.iter().sum::<f64>() / last.len().max(1) as f64)
    }
}

/// Tuning curve: a random NURBS that no table reports; on a machine with rotary axes it is projected on the saddle.
///
/// # Errors
/// When the curve cannot be planned on the machine.
pub fn tuning_curve(setup: &Setup) -> Result<DesiredPath> {
    let has_rotary_axes = setup.kinematics.has_rotary_axes();
    let dimensions = if has_rotary_axes { 2 } else { setup.kinematics.axes().len().min(3) };
    let nurbs = library::random_nurbs(TUNING_POINTS, TUNING_SIGMA_MM, dimensions, TUNING_CURVE_SEED)?;
    let curve: Arc<dyn Curve> = if has_rotary_axes { Arc::new(OnSaddle(nurbs)) } else { Arc::new(nurbs) };
    Ok(plan_curve_on(curve, FEED_MM_S, &setup.kinematics, &setup.limits, &setup.plan_settings())?)
}

/// Impulse responses of the machine on a path.
///
/// # Errors
/// As [`ImpulseResponse::probe`].
pub fn probe(machine: &mut dyn Machine, desired: &DesiredPath) -> Result<Vec<ImpulseResponse>> {
    Ok(ImpulseResponse::probe(machine, desired.trajectory(), PROBE, RESPONSE_S)?)
}

/// Bound of the correction as a multiple of the uncompensated error: a law that compensates the whole lag needs all of
/// it.
const SHIFT_OF_ERROR: f64 = 2.0;

/// Correction limits of an ILC law: the machine's `limits` as for the first run, its whole lag, and corrections at stops
/// for as long as the law's window.
///
/// # Errors
/// When the axes of the run are not those of the path.
pub fn ilc_correction_limits(
    desired: &DesiredPath,
    limits: Option<&Limits>,
    uncompensated: &Trajectory,
    settings: LawSettings,
) -> Result<CorrectionLimits> {
    let poses = poses_of(uncompensated, desired.kinematics().as_ref())?;
    let (mut tip_mm, mut turn_rad) = (0.0_f64, 0.0_f64);
    for (wanted, actual) in desired.poses().iter().zip(&poses) {
        tip_mm = tip_mm.max((wanted.tip - actual.tip).norm());
        turn_rad = turn_rad.max(wanted.angle_to(actual));
    }
    let errors = desired.trajectory().tracking_error(uncompensated)?;
    for (axis, error) in desired.trajectory().axes().iter().zip(errors) {
        let largest = error.iter().fold(0.0_f64, |most, e| most.max(e.abs()));
        match axis.kind {
            AxisKind::Linear => tip_mm = tip_mm.max(largest),
            AxisKind::Rotary => turn_rad = turn_rad.max(largest),
        }
    }
    let default = CorrectionLimits::default();
    let settle_s = match settings {
        // The default's ratio to the window of the first run.
        LawSettings::Filtered { window_s, .. } => (window_s / WINDOWS_S[START_WINDOW] * default.settle_s).max(default.settle_s),
        LawSettings::NormOptimal { .. } => default.settle_s,
    };
    Ok(CorrectionLimits {
        max_shift: default.max_shift.max(SHIFT_OF_ERROR * tip_mm),
        max_rotation_rad: default.max_rotation_rad.max(SHIFT_OF_ERROR * turn_rad),
        limits: limits.cloned(),
        settle_s,
        // As for the first run.
        held: Held::AllAxes,
        ..default
    })
}

/// Runs `law` on the machine. Returns every run, the uncompensated one first.
///
/// # Errors
/// When the machine refuses a reference.
pub fn run_ilc(
    machine: &mut dyn Machine,
    law: &mut dyn CompensationLaw,
    desired: &DesiredPath,
    correction_limits: &CorrectionLimits,
    runs: usize,
) -> Result<Vec<Iteration>> {
    // Never stops early: the last run counts, independent of the noise of the run before.
    Ok(learn(machine, law, desired, None, correction_limits, &StopRule::after(runs), &mut |_, _| 0.0)?.iterations)
}
