//! Learning on a model with a trust region: a step is kept only if the predicted cost falls.

use std::f64::consts::TAU;

use machine::Machine;
use motion::contour::{ContourEstimator, Exact};
use motion::{DesiredPath, Trajectory};

use crate::laws::ContourOptimal;
use crate::{CompensationError, CompensationLaw, CorrectionLimits, Iteration, LowPass, Worth};

/// Why a descent ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// The predicted cost is within the requested floor.
    AtFloor,
    /// No step lowers the predicted cost any more.
    AtOptimum,
    /// All runs were used.
    AtRuns,
}

impl std::fmt::Display for Ended {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::AtFloor => "ended at the floor of the forecast",
            Self::AtOptimum => "ended where no step improves the forecast",
            Self::AtRuns => "ended after all updates that are allowed",
        })
    }
}

/// Settings of a descent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Descent {
    /// Runs of the model after which no further step begins, including the first run. The last step
    /// may take two runs.
    pub runs: usize,
    /// Cost below which further steps gain nothing: the uncertainty of the model.
    pub floor: f64,
    /// Damping of the first step, and its minimum.
    pub damping: [f64; 2],
    /// Cut-off of the shifts, Hz; `None` begins at four times the bandwidth of the
    /// machine and doubles as long as that is worth it.
    pub cut_off_hz: Option<f64>,
    /// What a step has to save to be successful.
    pub worth: Worth,
    /// Number of successive unsuccessful steps before the end, or fewer where little is left to save; each has more damping than the one before.
    pub patience: usize,
}

impl Default for Descent {
    /// Twelve runs. The first step ignores frequencies where the response of the machine is below
    /// one sixth, the last ones below one thirtieth.
    fn default() -> Self {
        Self { runs: 12, floor: 0.0, damping: [0.03, 3e-3], cut_off_hz: None, worth: Worth::of_cost(WORTH), patience: PATIENCE }
    }
}

/// Factor on the damping after a successful step, and after an unsuccessful one.
const EASE: f64 = 0.3;
const TIGHTEN: f64 = 6.0;
/// Minimum improvement of the cost, as a share, of a successful step.
const WORTH: f64 = 0.01;
/// First cut-off as a multiple of the bandwidth `1/(2π·delay)` of the machine's response.
const FIRST_BANDWIDTHS: f64 = 4.0;
/// Minimum improvement of the cost, as a share, by shifts of twice the cut-off.
const WORTH_ROUGHER: f64 = 0.05;
/// Default number of successive unsuccessful steps.
const PATIENCE: usize = 3;

/// Runs the steps of the law on `machine` from the run `start`. Returns all runs in order,
/// including `start` and rejected ones. A step starts from the best run so far. If a part of the
/// path becomes worse, a further run keeps the step on the other parts only. If neither run is
/// better, the next step has more damping.
///
/// Shifts are smooth at first: cut-off four times the bandwidth of the machine. Where
/// no step improves the cost any more, the cut-off doubles, as long as that is worth it. A learned
/// model knows little of frequencies that its log does not hold, and shifts there are errors on the
/// real machine.
///
/// # Errors
/// When the machine refuses a reference, or the law does not match it.
pub fn descend(
    machine: &mut dyn Machine,
    law: &mut ContourOptimal,
    desired: &DesiredPath,
    start: Iteration,
    limits: &CorrectionLimits,
    settings: &Descent,
    measure: &mut dyn FnMut(&DesiredPath, &Trajectory) -> f64,
) -> Result<(Vec<Iteration>, Ended), CompensationError> {
    let mut run = |reference: Trajectory| -> Result<Iteration, CompensationError> {
        let actual = machine.run(&reference)?;
        let measure = measure(desired, &actual);
        Ok(Iteration { reference, actual, measure })
    };
    let mut iterations = vec![start];
    let (mut best, mut damping, mut failures) = (0, settings.damping[0], 0);
    // Of the best run, until another one is better.
    let mut old: Option<Vec<f64>> = None;
    let period_s = desired.trajectory().period_s();
    let first_hz = FIRST_BANDWIDTHS / (TAU * period_s * law.delay_samples().max(1.0));
    let mut cut_off_hz = settings.cut_off_hz.unwrap_or(first_hz);
    // Costs and number of runs when the present cut-off began.
    let mut level = ([f64::INFINITY; 2], 1);
    law.smooth(LowPass::new(cut_off_hz, period_s)?);
    while iterations.len() < settings.runs {
        if iterations[best].measure <= settings.floor || settings.worth.patience(iterations[best].measure, settings.patience) == 0
        {
            return Ok((iterations, Ended::AtFloor));
        }
        law.damp(damping)?;
        let next = law.update(desired, &iterations[best].reference, &iterations[best].actual)?;
        let next = run(limits.apply_step(desired, &iterations[best].reference, &next)?)?;
        let before = iterations[best].measure;
        let of_best = match old.take() {
            Some(known) => known,
            None => local_error(desired, &iterations[best], law.reach())?,
        };
        let mixed = kept_where_better(desired, &iterations[best], &of_best, &next, law.reach())?;
        iterations.push(next);
        if let Some(mixed) = mixed {
            iterations.push(run(limits.apply_step(desired, &iterations[best].reference, &mixed)?)?);
        }
        let latest =
            (best + 1..iterations.len()).min_by(|a, b| iterations[*a].measure.total_cmp(&iterations[*b].measure)).unwrap_or(best);
        let reached = iterations[latest].measure;
        let mut worth = settings.worth.counts(before, reached);
        old = Some(of_best);
        if reached < before {
            let of_latest = local_error(desired, &iterations[latest], law.reach())?;
            worth |= settings.worth.counts(mean_root(old.as_deref().unwrap_or_default()), mean_root(&of_latest));
            (best, old) = (latest, Some(of_latest));
        }
        damping = if worth { (damping * EASE).max(settings.damping[1]) } else { damping * TIGHTEN };
        failures = if worth { 0 } else { failures + 1 };
        if failures > 0 && failures >= settings.worth.patience(iterations[best].measure, settings.patience) {
            let ([cost, local], runs) = level;
            let of_best = mean_root(old.as_deref().unwrap_or_default());
            if iterations[best].measure > (1.0 - WORTH_ROUGHER) * cost && of_best > (1.0 - WORTH_ROUGHER) * local {
                // A smoother shift is as good.
                iterations[runs..].iter_mut().for_each(|iteration| iteration.measure = f64::INFINITY);
                return Ok((iterations, Ended::AtOptimum));
            }
            if settings.cut_off_hz.is_some() || LowPass::new(cut_off_hz, period_s)?.is_none() {
                return Ok((iterations, Ended::AtOptimum));
            }
            cut_off_hz *= 2.0;
            law.smooth(LowPass::new(cut_off_hz, period_s)?);
            level = ([iterations[best].measure, of_best], iterations.len());
            (damping, failures) = (settings.damping[0], 0);
        }
    }
    Ok((iterations, Ended::AtRuns))
}

/// Minimum rejected share of a step for a run with the remaining step.
const IN_DOUBT: f64 = 0.02;

/// The reference of `best` plus a share of the step to `next` at each sample, from the samples
/// within `reach`: `o² / (o² + n²)` with the mean squares `o` (`old`) and `n` of the contour error before
/// and after. `None` if nearly all of the step remains.
fn kept_where_better(
    desired: &DesiredPath,
    best: &Iteration,
    old: &[f64],
    next: &Iteration,
    reach: usize,
) -> Result<Option<Trajectory>, CompensationError> {
    let new = local_error(desired, next, reach)?;
    let share = |(old, new): (&f64, &f64)| {
        let (old, new) = (old * old, new * new);
        if old + new > 0.0 { old / (old + new) } else { 1.0 }
    };
    let shares = around(&old.iter().zip(&new).map(share).collect::<Vec<f64>>(), reach);
    let doubt = shares.iter().filter(|share| **share < 0.5).count() as f64;
    if doubt < IN_DOUBT * shares.len() as f64 {
        return Ok(None);
    }
    let columns = best.reference.columns().iter().zip(next.reference.columns());
    let columns = columns.map(|(b, n)| b.iter().zip(n).zip(&shares).map(|((b, n), share)| b + share * (n - b)).collect());
    Ok(Some(best.reference.with_columns(columns.collect())?))
}

/// Mean square of a run's contour error within `reach` of each sample, mm².
fn local_error(desired: &DesiredPath, run: &Iteration, reach: usize) -> Result<Vec<f64>, CompensationError> {
    let errors = Exact::default().estimate(&desired.tips_of(&run.actual)?, &desired.tips())?;
    Ok(around(&errors.iter().map(|error| error.magnitude_mm.powi(2)).collect::<Vec<f64>>(), reach))
}

/// Mean of the local errors of all samples. What is left at one place, such as the end of a path, hides no improvement elsewhere in it.
fn mean_root(squares: &[f64]) -> f64 {
    squares.iter().map(|square| square.sqrt()).sum::<f64>() / squares.len().max(1) as f64
}

/// Mean over the samples within `reach` of each.
fn around(values: &[f64], reach: usize) -> Vec<f64> {
    let mut sums = vec![0.0; values.len() + 1];
    for (k, value) in values.iter().enumerate() {
        sums[k + 1] = sums[k] + value;
    }
    let mean = |k: usize| {
        let (from, to) = (k.saturating_sub(reach), (k + reach + 1).min(values.len()));
        (sums[to] - sums[from]) / (to - from) as f64
    };
    (0..values.len()).map(mean).collect()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use machine::MachineError;
    use motion::{Axis, Cartesian};

    use super::*;
    use crate::{CutOffCandidates, ImpulseResponse, spatial_candidates};

    /// A first-order lag of 20 ms on every axis: a servo of 8 Hz, of which a cut-off of 100 Hz diverges.
    struct Slow;

    impl Machine for Slow {
        fn run(&mut self, reference: &Trajectory) -> Result<Trajectory, MachineError> {
            let lag = |column: &Vec<f64>| {
                let mut position = column[0];
                let follow = |target: &f64| {
                    position += 0.1 * (target - position);
                    position
                };
                column.iter().map(follow).collect()
            };
            Ok(reference.with_columns(reference.columns().iter().map(lag).collect())?)
        }
    }

    /// Circles of 5 mm at up to 40 mm/s, from and to a standstill; a lag of 20 ms reduces their
    /// radius by up to 0.06 mm.
    fn circles() -> DesiredPath {
        let angle = |k: usize| {
            let (t, end) = (k as f64 * 0.002, 4.0);
            let share = (t / end).min(1.0);
            4.0 * (t.min(end) - end / std::f64::consts::TAU * (std::f64::consts::TAU * share).sin())
        };
        let columns = vec![
            (0..2100).map(|k| 5.0 * angle(k).cos()).collect(),
            (0..2100).map(|k| 5.0 * angle(k).sin()).collect(),
            vec![0.0; 2100],
        ];
        let path = Trajectory::new(0.002, Axis::xyz(), columns).unwrap();
        DesiredPath::new(path, Arc::new(Cartesian::new(Axis::xyz()))).unwrap()
    }

    /// Largest distance from the circle, mm.
    fn off(_: &DesiredPath, actual: &Trajectory) -> f64 {
        let [x, y] = [&actual.columns()[0], &actual.columns()[1]];
        x.iter().zip(y).map(|(x, y)| (x.hypot(*y) - 5.0).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn a_slow_servo_is_learned_and_no_step_is_kept_that_is_worse() {
        let path = circles();
        let (limits, mut machine) = (CorrectionLimits { settle_s: 0.05, ..CorrectionLimits::default() }, Slow);
        let settings = CutOffCandidates { turn_s: Some(0.02), updates: 4, cut_offs: 5 };
        let iterations = spatial_candidates(&mut machine, &path, &limits, &settings, None, &mut off).unwrap();
        let best = iterations.iter().min_by(|a, b| a.measure.total_cmp(&b.measure)).unwrap().clone();
        assert!(best.measure < 0.1 * iterations[0].measure, "{} of {}", best.measure, iterations[0].measure);
        let responses = ImpulseResponse::probe_model(&mut machine, path.trajectory(), 0.4).unwrap();
        assert!((responses[0].delay_samples() - 9.0).abs() < 0.5, "{}", responses[0].delay_samples());
        assert!((responses[0].static_gain() - 1.0).abs() < 0.02, "{}", responses[0].static_gain());
        let mut law = ContourOptimal::new(responses, 0.03).unwrap();
        let start = iterations[0].clone();
        let (steps, _) = descend(&mut machine, &mut law, &path, start, &limits, &Descent::default(), &mut off).unwrap();
        let reached = steps.iter().map(|iteration| iteration.measure).fold(f64::INFINITY, f64::min);
        assert!(reached < 0.1 * iterations[0].measure, "{reached} of {}", iterations[0].measure);
    }

    /// [`Slow`], with an answer to fast shifts that no servo has: that of a model whose log does not hold any.
    struct Guessing;

    impl Machine for Guessing {
        fn run(&mut self, reference: &Trajectory) -> Result<Trajectory, MachineError> {
            let lagging = Slow.run(reference)?;
            let column = |(lagging, reference): (&Vec<f64>, &Vec<f64>)| {
                let at = |k: usize| reference[k.min(reference.len() - 1)];
                let fast = |k: usize| at(k.saturating_sub(1)) - 2.0 * at(k) + at(k + 1);
                lagging.iter().enumerate().map(|(k, x)| x + 3.0 * fast(k)).collect()
            };
            Ok(reference.with_columns(lagging.columns().iter().zip(reference.columns()).map(column).collect())?)
        }
    }

    #[test]
    fn shifts_stay_smooth_where_a_model_answers_to_fast_ones_by_chance() {
        let path = circles();
        let mut machine = Guessing;
        let reference = path.trajectory().clone();
        let actual = machine.run(&reference).unwrap();
        let start = Iteration { measure: off(&path, &actual), reference, actual };
        let before = start.measure;
        let responses = ImpulseResponse::probe_model(&mut machine, path.trajectory(), 0.4).unwrap();
        let mut law = ContourOptimal::new(responses, 0.03).unwrap();
        let limits = CorrectionLimits { settle_s: 0.05, ..CorrectionLimits::default() };
        let (runs, _) = descend(&mut machine, &mut law, &path, start, &limits, &Descent::default(), &mut off).unwrap();
        let best = runs.iter().min_by(|a, b| a.measure.total_cmp(&b.measure)).unwrap();
        assert!(best.measure < 0.1 * before, "{} of {before}", best.measure);
        // While the path is cut: 4 × the bandwidth of 8 Hz, against the Nyquist frequency of 250 Hz.
        let shift: Vec<f64> =
            best.reference.columns()[0].iter().zip(&path.trajectory().columns()[0]).map(|(r, d)| r - d).collect();
        let cut = &shift[100..1900];
        let square = |values: &mut dyn Iterator<Item = f64>| values.map(|value| value * value).sum::<f64>().sqrt();
        let fast = square(&mut cut.windows(3).map(|w| 0.25 * (w[0] - 2.0 * w[1] + w[2])));
        assert!(fast < 0.003 * square(&mut cut.iter().copied()), "{fast}");
    }

    /// An axis of 8 Hz that overshoots by a quarter.
    struct Springy;

    impl Machine for Springy {
        fn run(&mut self, reference: &Trajectory) -> Result<Trajectory, MachineError> {
            let (stiffness, friction, period_s) = (2500.0, 40.0, reference.period_s());
            let follow = |column: &Vec<f64>| {
                let (mut position, mut speed) = (column[0], 0.0);
                let step = |target: &f64| {
                    speed += period_s * (stiffness * (target - position) - friction * speed);
                    position += period_s * speed;
                    position
                };
                column.iter().map(step).collect()
            };
            Ok(reference.with_columns(reference.columns().iter().map(follow).collect())?)
        }
    }

    #[test]
    fn an_overshoot_at_a_stop_is_seen_and_taken_off() {
        // 4 mm in 0.2 s from and to a standstill: the whole path is on the line, so that only the
        // overshoot is an error.
        let at = |k: usize| {
            let share = (k as f64 / 100.0).min(1.0);
            4.0 * (share - (std::f64::consts::TAU * share).sin() / std::f64::consts::TAU)
        };
        let columns = vec![(0..400).map(at).collect(), vec![0.0; 400], vec![0.0; 400]];
        let path = Trajectory::new(0.002, Axis::xyz(), columns).unwrap();
        let path = DesiredPath::new(path, Arc::new(Cartesian::new(Axis::xyz()))).unwrap();
        let mut beyond = |_: &DesiredPath, actual: &Trajectory| actual.columns()[0].iter().map(|x| x - 4.0).fold(0.0, f64::max);
        let reference = path.trajectory().clone();
        let actual = Springy.run(&reference).unwrap();
        let start = Iteration { measure: beyond(&path, &actual), reference, actual };
        let before = start.measure;
        assert!(before > 0.05, "{before}");
        let mut law =
            ContourOptimal::new(ImpulseResponse::probe_model(&mut Springy, path.trajectory(), 0.4).unwrap(), 0.03).unwrap();
        let limits = CorrectionLimits { max_shift: 1.0, settle_s: 0.2, ..CorrectionLimits::default() };
        let (iterations, _) = descend(&mut Springy, &mut law, &path, start, &limits, &Descent::default(), &mut beyond).unwrap();
        let reached = iterations.iter().map(|iteration| iteration.measure).fold(f64::INFINITY, f64::min);
        assert!(reached < 0.2 * before, "{reached} of {before}");
    }

    #[test]
    fn a_step_is_kept_where_it_helps_and_taken_back_where_it_does_not() {
        let path = circles();
        let (half, samples) = (path.trajectory().len() / 2, path.trajectory().len());
        // The old run is off by 10 um in its first half, the new run in its second half.
        let round = |off: std::ops::Range<usize>, reference_mm: f64| {
            let column = |axis: usize| -> Vec<f64> {
                let radius = |k: usize| if off.contains(&k) { 1.002 } else { 1.0 };
                path.trajectory().columns()[axis].iter().enumerate().map(|(k, x)| x * radius(k)).collect()
            };
            let actual = path.trajectory().with_columns(vec![column(0), column(1), column(2)]).unwrap();
            let shifted = path.trajectory().columns().iter().map(|column| column.iter().map(|x| x + reference_mm).collect());
            let reference = path.trajectory().with_columns(shifted.collect()).unwrap();
            Iteration { reference, actual, measure: 0.0 }
        };
        let (best, next) = (round(0..half, 0.0), round(half..samples, 0.1));
        let kept = |best: &Iteration, next: &Iteration| {
            kept_where_better(&path, best, &local_error(&path, best, 10).unwrap(), next, 10).unwrap()
        };
        let mixed = kept(&best, &next).unwrap();
        let shift = |k: usize| mixed.columns()[2][k];
        assert!(
            (shift(half / 2) - 0.1).abs() < 1e-6 && shift(half + half / 2).abs() < 1e-6,
            "{} {}",
            shift(half / 2),
            shift(half + half / 2)
        );
        assert!(kept(&round(0..samples, 0.0), &round(0..0, 0.1)).is_none());
    }

    #[test]
    fn a_descent_ends_at_the_floor_and_reports_it() {
        let path = circles();
        let start = Iteration { reference: path.trajectory().clone(), actual: path.trajectory().clone(), measure: 1e-5 };
        let mut law = ContourOptimal::new(vec![ImpulseResponse::new(vec![1.0]).unwrap(); 3], 0.03).unwrap();
        let settings = Descent { floor: 1e-4, ..Descent::default() };
        let (iterations, ended) =
            descend(&mut Slow, &mut law, &path, start, &CorrectionLimits::default(), &settings, &mut off).unwrap();
        assert_eq!((iterations.len(), ended), (1, Ended::AtFloor));
        assert!(law.damp(0.0).is_err());
    }
}
