//! Model-based ILC: a law, iterated on the model of the machine before the first run.

mod acceptance;
mod laws;
mod outcome;
mod outside;
mod settings;
mod task;

use compensation::{CorrectionLimits, Ended, Iteration, LowPass, StopRule};
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
use crate::refit::{RefitSettings, TimeEncoding};
use crate::statistics::Figures;

pub use laws::{PROBE, RESPONSE_S, norm_optimal};
pub use outcome::Outcome;
pub use outside::OutsideRange;
pub use settings::{LawName, Settings, shift_bound};

/// Share by which an update on the reference has to lower the forecast for another to follow.
const WORTH: f64 = 0.02;
/// Difference of the forecasts on the reference itself and on what a control makes of the program, as a share, up to which the control
/// does as it is told.
const SAME: f64 = 0.02;
/// Updates on what a control makes of the program, for every one on the reference, and how many in a row may bring nothing.
const PLANNED_UPDATES: usize = 3;
const PLANNED_PATIENCE: usize = 4;
/// Samples planned anew in all of them together, and the least updates of a program of hours: planning takes most of the time.
const PLANNED_SAMPLES: usize = 12_000_000;
const LEAST_PLANNED: usize = 2;
/// Gain and cut-off (Hz) of these updates: what is learned above it comes back as kinks, at which a control slows down.
const PLANNED_GAIN: f64 = 0.7;
const PLANNED_LOW_PASS_HZ: f64 = 40.0;

/// Least predicted gain for which a path is changed at all, as a share of its RMS contour error.
const LEAST_GAIN: f64 = 0.05;

/// Forecast at which learning ends, as a share of the error that the model leaves on data held out: it adds half a per cent to that error.
const FLOOR_SHARE: f64 = 0.1;
/// Learns a reference for `input` on `model`: on the reference itself, then on what the control makes of the program that is written, and takes
/// the best forecast if it gains and makes nothing worse.
///
/// # Errors
/// When the path does not fit the model (axes, sampling period), a predictor of the model is not usable, or `progress` asks to stop.
pub fn model_based_ilc(input: &Input, model: &Bundle, settings: &Settings, progress: Progress<'_>) -> Result<Outcome> {
    let held_out = model.manifest.axes.iter().map(|axis| axis.held_out.rms.powi(2)).sum::<f64>().sqrt();
    let (mut machine, floor_mm) = (model.machine()?, FLOOR_SHARE * held_out);
    on_learned_machine(input, &mut machine, &model.coverage(), settings, floor_mm, progress)
}

/// As [`model_based_ilc`], on a learned machine with the ranges that it was trained on; `floor_mm` is the forecast at which nothing is gained by
/// going on.
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
    let (weights, outside) = prepare(input, machine, coverage);
    let mut control = ControlledMachine::learned(machine, input.part());
    let max_shift = bound_of(settings, &mut control, input)?;
    let limits = input.limits().cloned();
    let guard = CorrectionLimits {
        max_shift,
        max_rotation_rad: settings.max_rotation_rad,
        limits,
        weights,
        ..CorrectionLimits::default()
    };
    let mut task = Task::new(input, guard, floor_mm, progress);

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

/// How much of a correction every sample may take, and where the model is out of its depth. The machine learns which way the path leads, and
/// leaves out what depends on a position that is not known.
fn prepare(input: &Input, machine: &mut LearnedMachine, coverage: &[OperatingRange]) -> (Vec<f64>, Vec<OutsideRange>) {
    let command = input.command();
    machine.freeze_flags(command);
    if input.part().is_some_and(|part| !part.placement.known()) {
        machine.leave_out_position();
    }
    let (mut weights, reasons) = fade(coverage, machine, command);
    let outside = ranges(input.trajectory(), &reasons, &weights);
    if let Some(part) = input.part() {
        for (weight, allowed) in weights.iter_mut().zip(part.weights()) {
            *weight *= allowed;
        }
    }
    (weights, outside)
}

/// The bound of corrections that is given, or that of a run of `machine` without any, mm.
fn bound_of(settings: &Settings, machine: &mut dyn Machine, input: &Input) -> Result<f64> {
    Ok(match settings.max_shift {
        Some(given) => given,
        None => shift_bound(0.0, input.figures(&machine.run(input.trajectory())?)?.tip.max_mm),
    })
}

/// Every run on the reference itself, the uncompensated one first.
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
    if settings.law == LawName::Virtual {
        let (runs, ended) = task.descend(control, settings.iterations)?;
        return Ok(OnReference { runs, ended });
    }
    let mut law = law(settings, input.trajectory(), control)?;
    let updates = if settings.law == LawName::OneShot { 1 } else { settings.iterations };
    let runs = task.iterate(control, law.as_mut(), None, StopRule::while_better(updates, WORTH))?;
    Ok(OnReference { runs, ended: None })
}

/// The run that is taken if it makes nothing worse, on the way that the control takes it.
#[derive(Default)]
struct OnProgram {
    run: Option<(Iteration, Figures)>,
    /// Updates up to here, on the reference and on the program.
    updates: usize,
    /// How long the program takes before and after, s, where the control plans it anew.
    cycle_s: Option<(f64, f64)>,
    /// Where the program keeps its feeds because the times of its points would cost too much: how much, as a share of the cycle time.
    kept_feeds: Option<f64>,
}

/// Goes on from the best reference on what the control makes of the program that it is written into.
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
    // The papers' laws are left as they are; only the forecast is the control's.
    let run = if settings.law == LawName::Virtual && (measure / ideal.measure - 1.0).abs() > SAME {
        let mut law = spatial(PLANNED_GAIN, LowPass::new(PLANNED_LOW_PASS_HZ, path.period_s())?)?;
        let affordable = (PLANNED_SAMPLES / path.len().max(1)).max(LEAST_PLANNED);
        let most_updates = affordable.min(PLANNED_UPDATES * settings.iterations);
        let stop = StopRule { updates: most_updates, patience: PLANNED_PATIENCE, worth: 0.0 };
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

/// What is known beside the runs.
struct Learned {
    max_shift: f64,
    ended: Option<Ended>,
    outside: Vec<OutsideRange>,
}

/// Takes the chosen run where what may not be changed does not come out worse for what is changed beside it either, else the uncompensated one.
fn choose(input: &Input, first: Iteration, chosen: OnProgram, learned: Learned) -> Result<Outcome> {
    let before = input.figures(&first.actual)?;
    let overall =
        |(round, _): (Iteration, Figures)| -> Result<(Figures, Iteration)> { Ok((input.figures(&round.actual)?, round)) };
    let kept = chosen.run.map(overall).transpose()?.filter(|(after, _)| {
        let most = |before: f64| before * (1.0 + SAME);
        after.cost_mm() <= most(before.cost_mm()) && after.tip.max_mm <= most(before.tip.max_mm)
    });
    let gained = kept.is_some();
    let cycle_s = chosen.cycle_s.filter(|_| gained);
    let (after, Iteration { reference, actual: forecast, .. }) = kept.unwrap_or((before, first));
    let (updates, kept_feeds) = (chosen.updates, chosen.kept_feeds);
    let Learned { max_shift, ended, outside } = learned;
    Ok(Outcome { reference, forecast, max_shift, before, after, updates, ended, gained, cycle_s, kept_feeds, outside })
}

/// Learns a reference for `input` on any machine, as [`model_based_ilc`] does on a learned one: on the noise-free simulated machine this is what
/// a perfect model would give.
///
/// # Errors
/// When the path does not fit the machine.
pub fn on_machine(machine: &mut dyn Machine, input: &Input, settings: &Settings) -> Result<Trajectory> {
    let max_shift = bound_of(settings, machine, input)?;
    let guard = CorrectionLimits {
        max_shift,
        max_rotation_rad: settings.max_rotation_rad,
        limits: input.limits().cloned(),
        ..CorrectionLimits::default()
    };
    let (runs, _) = Task::new(input, guard, 0.0, SILENT).descend(machine, settings.iterations)?;
    let most = Bound::of(&runs[0], 0.0);
    Ok(best(&runs, most).map_or_else(|| input.trajectory().clone(), |run| runs[run].0.reference.clone()))
}
