//! Model-based ILC: a law that is iterated on the model of the machine before the first run.
//!
//! [`model_based_ilc`] iterates on the reference, repeats the iteration on the replanned program where the control
//! plans its own feed profile, and returns the best accepted forecast with its reference.

mod acceptance;
mod laws;
mod outcome;
mod outside;
mod settings;
mod task;

use compensation::{Ended, Iteration, LowPass, StopRule};
use machine::Machine;
use models::{Bundle, LearnedMachine, OperatingRange, fade};
use motion::Trajectory;

use acceptance::{Bound, best, cost};
use laws::{law, spatial};
use outside::ranges;
use task::{Runs, Task};

use crate::control::ControlledMachine;
use crate::error::Result;
use crate::input::Input;
use crate::progress::{Progress, SILENT};
use crate::refit::{Mark, RefitSettings, TimeEncoding};
use crate::statistics::Figures;

pub use laws::{PROBE, RESPONSE_S, norm_optimal};
pub use outcome::Outcome;
pub use outside::OutsideRange;
pub use settings::{LawName, Settings, shift_bound};

/// Least relative decrease of the forecast by an update on the reference for which the iteration continues.
const LEAST_DECREASE: f64 = 0.02;
/// Relative difference between the forecast on the reference and that on the replanned program up to which the two
/// count as equal.
const SAME_FORECAST: f64 = 0.02;
/// Updates on the replanned program for each update on the reference, and largest number of consecutive updates without
/// improvement.
const REPLANNED_UPDATES: usize = 3;
const REPLANNED_PATIENCE: usize = 4;
/// Largest number of replanned samples over all updates, and least number of updates for a program of hours: replanning
/// takes most of the time.
const REPLANNED_SAMPLES: usize = 12_000_000;
const LEAST_REPLANNED: usize = 2;
/// Gain and cut-off, Hz, of updates on the replanned program. Corrections above the cut-off become kinks, at which a
/// control slows down.
const REPLANNED_GAIN: f64 = 0.7;
const REPLANNED_LOW_PASS_HZ: f64 = 40.0;

/// Least predicted gain for which a path is changed, as a share of its RMS contour error.
const LEAST_GAIN: f64 = 0.05;

/// Forecast at which the iteration ends, as a share of the model's held-out error. It adds half a per cent to that error.
const FLOOR_SHARE: f64 = 0.1;

/// Computes a compensated reference for `input` by iteration on `model`.
///
/// The law is iterated on the reference, then on the replanned program where `settings.written` is given. The best
/// forecast is taken if it gains and no figure grows; otherwise the reference is the desired path.
///
/// # Errors
/// When the path does not fit the model (axes, sampling period), a predictor of the model is invalid, or `progress` cancels.
pub fn model_based_ilc(input: &Input, model: &Bundle, settings: &Settings, progress: Progress<'_>) -> Result<Outcome> {
    let held_out = model.manifest.axes.iter().map(|axis| axis.held_out.rms.powi(2)).sum::<f64>().sqrt();
    let (mut machine, floor_mm) = (model.machine()?, FLOOR_SHARE * held_out);
    let outcome = on_learned_machine(input, &mut machine, &model.coverage(), settings, floor_mm, progress)?;
    Ok(Outcome { mark: Some(Mark::of_model(model)?), ..outcome })
}

/// Same as [`model_based_ilc`], on a learned machine with its operating range `coverage`. The iteration ends at the
/// forecast `floor_mm`.
///
/// # Errors
/// As [`model_based_ilc`].
pub fn on_learned_machine(
    input: &Input,
    machine: &mut LearnedMachine,
    coverage: &[OperatingRange],
    settings: &Settings,
    floor_mm: f64,
    progress: Progress<'_>,
) -> Result<Outcome> {
    input.check_original()?;
    let (weights, outside) = prepare(input, machine, coverage);
    let mut control = ControlledMachine::learned(machine, input.part());
    let max_shift = bound_of(settings, &mut control, input)?;
    let correction_limits = input.correction_limits(max_shift, settings.max_rotation_rad, weights);
    let mut task = Task::new(input, correction_limits, floor_mm, progress);

    let OnReference { mut runs, ended } = learn_on_reference(&mut task, &mut control, input, settings)?;
    let most = Bound::of(&runs[0], LEAST_GAIN);
    let updates = runs.len() - 1;
    let run = best(&runs, most).map(|run| runs.swap_remove(run));
    let mut chosen = OnProgram { run, updates, ..OnProgram::default() };
    if let Some(written) = settings.written.filter(|_| chosen.run.is_some())
        && control.replans(written)
    {
        chosen = relearn_on_program(&task, &mut control, input, settings, written, chosen, most)?;
    }
    let (first, _) = runs.swap_remove(0);
    choose(input, first, chosen, Learned { max_shift, ended, outside })
}

/// Correction weights of the samples, and the ranges outside the operating range. Also gives the machine its directions
/// of motion, and leaves out position-dependent terms where the work offset is unknown.
fn prepare(input: &Input, machine: &mut LearnedMachine, coverage: &[OperatingRange]) -> (Vec<f64>, Vec<OutsideRange>) {
    let command = input.command();
    machine.freeze_flags(command);
    if input.part().is_some_and(|part| !part.placement.known()) {
        machine.leave_out_position();
    }
    let (mut weights, reasons) = fade(coverage, machine, command);
    let outside = ranges(input.trajectory(), &reasons, &weights);
    if let Some(part) = input.part() {
        for (weight, allowed) in weights.iter_mut().zip(part.taper()) {
            *weight *= allowed;
        }
    }
    (weights, outside)
}

/// Bound of corrections, mm: the given one, else that for an uncompensated run of `machine`.
fn bound_of(settings: &Settings, machine: &mut dyn Machine, input: &Input) -> Result<f64> {
    Ok(match settings.max_shift {
        Some(given) => given,
        None => shift_bound(0.0, input.figures(&machine.run(input.trajectory())?)?.tip.max_mm),
    })
}

/// Runs on the reference itself, the uncompensated one first.
struct OnReference {
    runs: Runs,
    ended: Option<Ended>,
}

fn learn_on_reference(
    task: &mut Task<'_>,
    control: &mut ControlledMachine<'_, LearnedMachine>,
    input: &Input,
    settings: &Settings,
) -> Result<OnReference> {
    if settings.law == LawName::ModelBased {
        let (runs, ended) = task.descend(control, settings.iterations)?;
        return Ok(OnReference { runs, ended });
    }
    let mut law = law(settings, input.trajectory(), control)?;
    let updates = if settings.law == LawName::OneShot { 1 } else { settings.iterations };
    let runs = task.iterate(control, law.as_mut(), None, StopRule::while_better(updates, LEAST_DECREASE))?;
    Ok(OnReference { runs, ended: None })
}

/// Candidate for the result, on the feed profile that the control uses.
#[derive(Default)]
struct OnProgram {
    run: Option<(Iteration, Figures)>,
    /// Updates so far, on the reference and on the replanned program.
    updates: usize,
    /// Cycle time before and after, s, where the control replans the program.
    cycle_s: Option<(f64, f64)>,
    /// Relative increase of the cycle time by timed points, where it is too large and the program therefore keeps its
    /// feeds.
    kept_feeds: Option<f64>,
}

/// Continues the iteration from the best reference on the replanned program.
fn relearn_on_program(
    task: &Task<'_>,
    control: &mut ControlledMachine<'_, LearnedMachine>,
    input: &Input,
    settings: &Settings,
    written: RefitSettings,
    so_far: OnProgram,
    most: Bound,
) -> Result<OnProgram> {
    let OnProgram { run: Some((ideal, _)), mut updates, .. } = so_far else { return Ok(so_far) };
    let (path, reference) = (input.trajectory(), ideal.reference);
    let mut seen = control.run(&reference)?;
    let slowdown = control.last_s() / path.duration_s() - 1.0;
    let keep = RefitSettings { encoding: TimeEncoding::Keep, ..written };
    let mut kept_feeds = None;
    if slowdown > settings.slowest && written.encoding != TimeEncoding::Keep && control.replans(keep) {
        kept_feeds = Some(slowdown);
        seen = control.run(&reference)?;
    }
    let mut after_s = control.last_s();
    let figures = task.figures(&seen)?;
    let measure = cost(&figures);
    // The papers' laws are not iterated again; only their forecast is that of the replanned program.
    let run = if settings.law == LawName::ModelBased && (measure / ideal.measure - 1.0).abs() > SAME_FORECAST {
        let mut law = spatial(REPLANNED_GAIN, LowPass::new(REPLANNED_LOW_PASS_HZ, path.period_s())?)?;
        let affordable = (REPLANNED_SAMPLES / path.len().max(1)).max(LEAST_REPLANNED);
        let most_updates = affordable.min(REPLANNED_UPDATES * settings.iterations);
        let stop = StopRule { updates: most_updates, patience: REPLANNED_PATIENCE, worth: 0.0 };
        let first = control.durations_s().len();
        let mut planned = task.iterate(control, &mut law, Some(reference), stop)?;
        updates += planned.len() - 1;
        let run = best(&planned, most);
        after_s = run.map_or(after_s, |run| control.durations_s()[first + run]);
        run.map(|run| planned.swap_remove(run))
    } else {
        most.holds(measure, &figures).then_some((Iteration { reference, actual: seen, measure }, figures))
    };
    let cycle_s = run.is_some().then_some((path.duration_s(), after_s));
    Ok(OnProgram { run, updates, cycle_s, kept_feeds })
}

/// Result of the iteration beside its runs.
struct Learned {
    max_shift: f64,
    ended: Option<Ended>,
    outside: Vec<OutsideRange>,
}

/// Takes the chosen run where the figures over all feed moves do not grow either, else the uncompensated run.
fn choose(input: &Input, first: Iteration, chosen: OnProgram, learned: Learned) -> Result<Outcome> {
    let before = input.figures(&first.actual)?;
    let overall = |(iteration, _): (Iteration, Figures)| -> Result<(Figures, Iteration)> {
        Ok((input.figures(&iteration.actual)?, iteration))
    };
    let kept = chosen.run.map(overall).transpose()?.filter(|(after, _)| {
        let most = |before: f64| before * (1.0 + SAME_FORECAST);
        after.cost_mm() <= most(before.cost_mm()) && after.tip.max_mm <= most(before.tip.max_mm)
    });
    let gained = kept.is_some();
    let cycle_s = chosen.cycle_s.filter(|_| gained);
    let (after, Iteration { reference, actual: forecast, .. }) = kept.unwrap_or((before, first));
    let (updates, kept_feeds) = (chosen.updates, chosen.kept_feeds);
    let Learned { max_shift, ended, outside } = learned;
    Ok(Outcome {
        reference,
        forecast,
        max_shift,
        before,
        after,
        updates,
        ended,
        gained,
        cycle_s,
        kept_feeds,
        outside,
        mark: None,
    })
}

/// Computes a reference for `input` on any machine, as [`model_based_ilc`] does on a learned one. On the noise-free
/// simulated machine it is the result of a perfect model.
///
/// # Errors
/// When the path does not fit the machine.
pub fn on_machine(machine: &mut dyn Machine, input: &Input, settings: &Settings) -> Result<Trajectory> {
    let max_shift = bound_of(settings, machine, input)?;
    let correction_limits = input.correction_limits(max_shift, settings.max_rotation_rad, Vec::new());
    let (runs, _) = Task::new(input, correction_limits, 0.0, SILENT).descend(machine, settings.iterations)?;
    let most = Bound::of(&runs[0], 0.0);
    Ok(best(&runs, most).map_or_else(|| input.trajectory().clone(), |run| runs[run].0.reference.clone()))
}
