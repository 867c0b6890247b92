//! Model-based ILC: a law that is iterated on the model of the machine before the first run.
//!
//! [`model_based_ilc`] iterates on the reference, repeats the iteration on the replanned program where the control
//! plans its own feed profile, and returns the best accepted forecast with its reference.

mod acceptance;
mod gain;
mod laws;
mod on_program;
mod outcome;
mod outside;
mod settings;
mod stops;
mod task;

use compensation::{Descent, Ended, Iteration, StopRule};
use machine::Machine;
use models::{Bundle, LearnedMachine, OperatingRange, fade};
use motion::Trajectory;

use acceptance::{Bound, SAME_FORECAST, best, cost, least};
use gain::{Gains, LEAST_GAIN, SAME_MAX_MM};
use laws::law;
use on_program::{OnProgram, relearn_on_program};
use outside::ranges;
use stops::slow_stop;
use task::{Runs, STEPS, STEPS_OF_REPLANNED, Task};

use crate::control::ControlledMachine;
use crate::error::Result;
use crate::expectation::{Expectation, ExpectedFigures};
use crate::input::Input;
use crate::part::Part;
use crate::progress::{Progress, SILENT};
use crate::refit::{Mark, RefitSettings};
use crate::statistics::{Figures, counts};

pub use gain::WithoutGain;
pub use laws::{PROBE, RESPONSE_S, norm_optimal};
pub use outcome::{BesideUnchanged, Outcome};
pub use outside::OutsideRange;
pub use settings::{FewerPoints, LawName, Settings, shift_bound};

/// Least relative decrease of the forecast by an update on the reference for which the iteration continues.
const LEAST_DECREASE: f64 = 0.02;

/// Computes a compensated reference for `input` by iteration on `model`.
///
/// The law is iterated on the reference, then on the replanned program where `settings.written` is given. The best
/// forecast is taken if it gains and no figure grows (MAX by up to 2 % beside moves that are not changed); otherwise the reference is the desired path.
///
/// # Errors
/// When the path does not fit the model (axes, sampling period), a predictor of the model is invalid, or `progress` cancels.
pub fn model_based_ilc(input: &Input, model: &Bundle, settings: &Settings, progress: Progress<'_>) -> Result<Outcome> {
    model_based_ilc_after(input, model, None, settings, progress)
}

/// What earlier runs of a path show.
#[derive(Debug)]
pub struct KnownRuns {
    /// Part of the model's error that repeats in every run: actual minus predicted position at every sample of the path, one column an axis,
    /// mm or rad.
    pub repeated: Vec<Vec<f64>>,
    /// Command of the best run, in the path's time. Learning on the replanned program starts from it too.
    pub command: Trajectory,
}

/// Same as [`model_based_ilc`], with what earlier runs of the path show.
///
/// # Errors
/// As [`model_based_ilc`].
pub fn model_based_ilc_after(
    input: &Input,
    model: &Bundle,
    known: Option<&KnownRuns>,
    settings: &Settings,
    progress: Progress<'_>,
) -> Result<Outcome> {
    let held_out = model.manifest.axes.iter().map(|axis| axis.held_out.rms.powi(2)).sum::<f64>().sqrt();
    let mut machine = model.machine()?;
    let learned = Learner { machine: &mut machine, coverage: &model.coverage(), known, model_error_mm: held_out };
    let outcome = on_learner(input, learned, settings, progress)?;
    // What runs have shown of the model's error is in the forecast already.
    let outcome = if known.is_none() { where_certain(outcome, input, model)? } else { outcome };
    Ok(Outcome { mark: Some(Mark::of_model(model, settings)?), ..outcome })
}

/// The outcome where less error is expected with it than without; else the unchanged path. A correction into motion of which the model
/// is less sure may cost more than the forecast gains.
fn where_certain(outcome: Outcome, input: &Input, model: &Bundle) -> Result<Outcome> {
    if !outcome.gained {
        return Ok(outcome);
    }
    let before = Expectation::of(model, input, input.command(), &outcome.uncompensated)?;
    let after = Expectation::of(model, input, &outcome.reference, &outcome.forecast)?;
    let Some((before, after)) = before.zip(after) else { return Ok(outcome) };
    let gains = |before: ExpectedFigures, after: ExpectedFigures| after.rms.middle < before.rms.middle;
    let turns_better = before.direction.zip(after.direction).is_some_and(|(before, after)| gains(before, after));
    if gains(before.tip, after.tip) || turns_better {
        return Ok(outcome);
    }
    Ok(outcome.unchanged(input, [before, after].map(|of| of.tip.rms.middle)))
}

/// Same as [`model_based_ilc`], on a learned machine with its operating range `coverage` and its error
/// `model_error_mm`.
///
/// # Errors
/// As [`model_based_ilc`].
pub fn on_learned_machine(
    input: &Input,
    machine: &mut LearnedMachine,
    coverage: &[OperatingRange],
    settings: &Settings,
    model_error_mm: f64,
    progress: Progress<'_>,
) -> Result<Outcome> {
    on_learner(input, Learner { machine, coverage, known: None, model_error_mm }, settings, progress)
}

/// A learned machine, and what is known of it.
struct Learner<'a> {
    machine: &'a mut LearnedMachine,
    coverage: &'a [OperatingRange],
    known: Option<&'a KnownRuns>,
    /// Error of the model, mm; 0 where it is not known.
    model_error_mm: f64,
}

fn on_learner(input: &Input, learner: Learner<'_>, settings: &Settings, progress: Progress<'_>) -> Result<Outcome> {
    input.check_original()?;
    let Learner { machine, coverage, known, model_error_mm } = learner;
    let (weights, outside) = prepare(input, machine, coverage);
    let control = ControlledMachine::learned(machine, input.part()).disturbed(known.map(|known| known.repeated.as_slice()));
    let resumed = known.map(|known| &known.command);
    let subject = Subject { control, weights, resumed, model_error_mm };
    Ok(Outcome { outside, ..subject.learn(input, settings, progress)? })
}

/// Computes a reference for `input` on any machine, as [`model_based_ilc`] does on a learned one. On the noise-free
/// simulated machine it is the result of a perfect model.
///
/// # Errors
/// When the path does not fit the machine, or a program cannot be planned.
pub fn on_machine(machine: &mut dyn Machine, input: &Input, settings: &Settings) -> Result<Outcome> {
    input.check_original()?;
    let control = ControlledMachine::new(machine, input.part());
    let weights = input.part().map_or_else(Vec::new, Part::taper);
    Subject { control, weights, resumed: None, model_error_mm: 0.0 }.learn(input, settings, SILENT)
}

/// A machine to learn on, behind its control.
struct Subject<'a, M: ?Sized> {
    control: ControlledMachine<'a, M>,
    /// Correction weights of the samples; empty for 1.
    weights: Vec<f64>,
    /// Command of an earlier run of the program.
    resumed: Option<&'a Trajectory>,
    /// Error of the model, mm; 0 where it is not known.
    model_error_mm: f64,
}

impl<M: Machine + ?Sized> Subject<'_, M> {
    fn learn(self, input: &Input, settings: &Settings, progress: Progress<'_>) -> Result<Outcome> {
        let Self { mut control, weights, resumed, model_error_mm } = self;
        let (max_shift, uncompensated) = bound_of(settings, &mut control, input)?;
        let correction_limits = input.correction_limits(max_shift, settings.max_rotation_rad, weights);
        let mut task = Task::new(input, correction_limits, model_error_mm, progress);

        let OnReference { mut runs, ended } = learn_on_reference(&mut task, &mut control, input, uncompensated, settings)?;
        let updates = runs.len() - 1;
        // A program whose whole does not gain may hold segments that do.
        let run = best(&runs, Bound::of(&runs[0], LEAST_GAIN)).or(input.part().map(|_| least(&runs))).filter(|run| *run > 0);
        let run = run.map(|run| runs.swap_remove(run));
        let run = match run {
            Some((ideal, _)) if settings.unavoidable_apart => Some(task.leave_out_unavoidable(ideal)?),
            run => run,
        };
        let (first, _) = runs.swap_remove(0);
        drop(runs);
        let mut chosen = OnProgram { run, updates, ..OnProgram::default() };
        if let (Some(written), Some(part)) = (settings.written, input.part())
            && let Some((ideal, _)) = &chosen.run
            && control.can_replan(written)
        {
            task.leave_limits_to_control();
            let freed =
                if settings.law == LawName::ModelBased { task.freed(&mut control, ideal, settings.iterations)? } else { None };
            control.replans(written);
            let ideals: Vec<&Iteration> = std::iter::once(ideal).chain(&freed).collect();
            let slow_stop = slow_stop(&task, &mut control, part, [&first.actual, &ideal.reference], written, settings)?;
            let mut learned = |slow_stop| {
                let written = RefitSettings { slow_stop, ..written };
                relearn_on_program(&task, &mut control, input, settings, written, &ideals, resumed)
            };
            let mut on_program = learned(slow_stop)?;
            if slow_stop.is_some() && on_program.run.is_none() {
                on_program = learned(None)?;
            }
            chosen = on_program;
            chosen.updates += updates;
        }
        let without_gain = leave_out(&task, &mut control, input, &first, &mut chosen)?;
        let outcome = choose(input, first, chosen, Learned { max_shift, ended, without_gain })?;
        let beside_unchanged = if outcome.gained { task.beside_unchanged(&outcome.forecast)? } else { None };
        let outcome = Outcome { beside_unchanged, ..outcome };
        // What the axes do at standstills is no part of learning, and of what is forecast.
        if outcome.gained
            && outcome.of_program.is_none()
            && has_standstills(input)
            && let Some(forecast) = control.run_standing(&outcome.reference)?
        {
            return Ok(Outcome { after: input.figures(&forecast)?, forecast, ..outcome });
        }
        Ok(outcome)
    }
}

/// Whether the path of a program stands still between moves.
fn has_standstills(input: &Input) -> bool {
    let path = input.trajectory();
    input.part().is_some() && (1..path.len()).any(|k| path.at(k).eq(path.at(k - 1)))
}

/// Reduces the correction of segments without gain, until the forecast of every corrected segment gains. Returns those that are left as they
/// are.
fn leave_out<M: Machine + ?Sized>(
    task: &Task<'_>,
    control: &mut ControlledMachine<'_, M>,
    input: &Input,
    first: &Iteration,
    chosen: &mut OnProgram,
) -> Result<Vec<WithoutGain>> {
    let before_mm = task.errors(&first.actual)?.costs_mm();
    let Some(mut gains) = Gains::of(input, before_mm, task.floor_mm()) else { return Ok(Vec::new()) };
    let Some((mut run, mut figures)) = chosen.run.take() else { return Ok(Vec::new()) };
    if let Some(written) = chosen.written {
        control.replans(written);
    }
    let mut errors = task.errors(&run.actual)?;
    while let Some(reference) = gains.reduce(&run.reference, &errors.costs_mm())? {
        if !gains.corrects() {
            return Ok(Vec::new());
        }
        let actual = control.run(&reference)?;
        errors = task.errors(&actual)?;
        figures = task.figures(&errors)?;
        run = Iteration { measure: cost(&figures), reference, actual };
        if let Some((_, after_s)) = &mut chosen.cycle_s {
            *after_s = control.last_s();
        }
    }
    chosen.run = Some((run, figures));
    Ok(gains.into_without_gain())
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

/// Bound of corrections, mm: the given one, else that for an uncompensated run of `machine`, with that run.
fn bound_of(settings: &Settings, machine: &mut dyn Machine, input: &Input) -> Result<(f64, Option<Trajectory>)> {
    if let Some(given) = settings.max_shift {
        return Ok((given, None));
    }
    let run = machine.run(input.trajectory())?;
    Ok((shift_bound(0.0, input.figures(&run)?.tip.max_mm), Some(run)))
}

/// Runs on the reference itself, the uncompensated one first.
struct OnReference {
    runs: Runs,
    ended: Option<Ended>,
}

fn learn_on_reference<M: Machine + ?Sized>(
    task: &mut Task<'_>,
    control: &mut ControlledMachine<'_, M>,
    input: &Input,
    uncompensated: Option<Trajectory>,
    settings: &Settings,
) -> Result<OnReference> {
    if settings.law == LawName::ModelBased {
        let worth = if input.part().is_some() { task.worth(settings.worth) } else { Descent::default().worth };
        let is_replanned = settings.written.is_some_and(|written| control.can_replan(written));
        let steps_each = if is_replanned { STEPS_OF_REPLANNED } else { STEPS };
        let (runs, ended) = task.descend(control, uncompensated, [settings.iterations, steps_each], worth)?;
        return Ok(OnReference { runs, ended });
    }
    let mut law = law(settings, input.trajectory(), control)?;
    let updates = if settings.law == LawName::OneShot { 1 } else { settings.iterations };
    let runs = task.iterate(control, law.as_mut(), StopRule::while_better(updates, LEAST_DECREASE))?;
    Ok(OnReference { runs, ended: None })
}

/// Result of the iteration beside its runs.
struct Learned {
    max_shift: f64,
    ended: Option<Ended>,
    without_gain: Vec<WithoutGain>,
}

/// Time from a move that is not changed up to which an error counts as beside it, s: that of a corner.
const BESIDE_S: f64 = 0.05;

/// Whether a feed move that is not changed lies within [`BESIDE_S`] of a sample, the `counted`-th of those that count.
fn is_beside_unchanged(part: &Part, counted: usize) -> bool {
    let reach = (BESIDE_S / part.settings.period_s).round() as usize;
    let at = (0..part.plan.samples.len()).filter(|k| counts(Some(part), *k)).nth(counted);
    let last = part.plan.samples.len().saturating_sub(1);
    at.is_some_and(|at| (at.saturating_sub(reach)..=last.min(at + reach)).any(|k| part.feeds_at(k) && !part.shiftable_at(k)))
}

/// Takes the chosen run where the figures over all feed moves do not grow either, else the uncompensated run.
fn choose(input: &Input, first: Iteration, mut chosen: OnProgram, learned: Learned) -> Result<Outcome> {
    let before = input.figures(&first.actual)?;
    let overall = |(iteration, _): (Iteration, Figures)| -> Result<(Figures, Iteration)> {
        Ok((input.figures(&iteration.actual)?, iteration))
    };
    // Where moves are left as they are, the forecast of their corners varies with the points beside them.
    let same_mm = |after: &Figures| {
        let gains = after.cost_mm() <= (1.0 - LEAST_GAIN) * before.cost_mm();
        let is_unchanged = || input.part().is_some_and(|part| is_beside_unchanged(part, after.tip.max_at));
        if gains && is_unchanged() { SAME_MAX_MM.max(SAME_FORECAST * before.tip.max_mm) } else { SAME_MAX_MM }
    };
    let kept = chosen
        .run
        .take()
        .map(overall)
        .transpose()?
        .filter(|(after, _)| after.cost_mm() <= before.cost_mm() && after.tip.max_mm <= before.tip.max_mm + same_mm(after));
    let is_recorded = input.part().is_some_and(|part| part.recording.is_some());
    let of_program = |run: &Iteration| is_recorded.then(|| input.figures_of_program(&run.actual)).transpose();
    let first_of_program = of_program(&first)?;
    let kept_of_program = kept.as_ref().map_or(Ok(None), |(_, run)| of_program(run))?;
    let grows = first_of_program.zip(kept_of_program).is_some_and(|(first, kept)| kept.cost_mm() > first.cost_mm());
    let kept = kept.filter(|_| !grows);
    let gained = kept.is_some();
    let cycle_s = chosen.cycle_s.filter(|_| gained);
    let uncompensated = first.actual.clone();
    let (after, Iteration { reference, actual: forecast, .. }) = kept.unwrap_or((before, first));
    let of_program = first_of_program.map(|first| [first, kept_of_program.filter(|_| gained).unwrap_or(first)]);
    let OnProgram { updates, kept_feeds, too_slow, written, .. } = chosen;
    let Learned { max_shift, ended, without_gain } = learned;
    Ok(Outcome {
        reference,
        forecast,
        uncompensated,
        max_shift,
        before,
        after,
        of_program,
        updates,
        ended,
        gained,
        cycle_s,
        kept_feeds,
        too_slow,
        written: written.filter(|_| gained),
        without_gain: if gained { without_gain } else { Vec::new() },
        beside_unchanged: None,
        uncertain_mm: None,
        outside: Vec::new(),
        mark: None,
    })
}

#[cfg(test)]
mod tests {
    use machine::MachineSpec;

    use super::*;
    use crate::{ReadSettings, Setup};

    #[test]
    fn errors_count_as_beside_a_move_that_is_not_changed_near_it_alone() {
        let setup = Setup::new(&MachineSpec::builtin("ballscrew").unwrap(), None).unwrap();
        let settings = ReadSettings { at_zero: true, ..ReadSettings::default() };
        let text = "G21 G17 G90 G94\nG0 X0. Y0. Z0.\nG1 X40. F1500\nG41 D1 X45. Y20.\nG40 X20.\nG1 Y0.\nX0.\nM30\n";
        let part = Part::read("part.nc", text, &setup, &settings).unwrap();
        let counted: Vec<usize> = (0..part.plan.samples.len()).filter(|k| counts(Some(&part), *k)).collect();
        let at = |line: usize, share: f64| {
            let of_line: Vec<usize> = (0..counted.len()).filter(|k| part.line_at(counted[*k]) == Some(line)).collect();
            of_line[((of_line.len() - 1) as f64 * share) as usize]
        };
        assert!(is_beside_unchanged(&part, at(4, 0.5)) && is_beside_unchanged(&part, at(3, 1.0)));
        assert!(!is_beside_unchanged(&part, at(3, 0.5)) && !is_beside_unchanged(&part, at(7, 0.5)));
    }
}
