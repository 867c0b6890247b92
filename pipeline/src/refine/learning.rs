//! The next program from all runs so far, by the model of the machine.
//!
//! Every program is computed from the original: model-based ILC, with the part of the model's error added that the runs show to repeat. What
//! was commanded in a run is used for the prediction of that run only. A command that is written as points again is rounded at every corner by
//! the control once more, which adds up from run to run.

use datasets::Log;
use models::Bundle;

use super::decision::{Ended, Expected, best_of, last_is_worse};
use super::observed::ObservedRun;
use super::repeated::repeated;
use crate::error::{Error, Result};
use crate::input::Input;
use crate::model_based_ilc::{KnownRuns, Outcome, Settings, model_based_ilc_after};
use crate::progress::Progress;
use crate::statistics::{Figures, counts};

/// Result of learning from runs.
#[derive(Debug)]
pub struct Learning {
    /// The runs, in order.
    pub runs: Vec<ObservedRun>,
    /// Index of the run with the lowest measured error.
    pub best: usize,
    /// Expected errors of further runs.
    pub expected: Expected,
    /// The next program.
    pub outcome: Outcome,
    /// Why the program of the best run should run on instead; `None` where the next program is expected to be better.
    pub ended: Option<Ended>,
}

/// Learns the next program or reference from the logs of all runs so far, in order. The programs of the runs may have been computed in any way:
/// the original, one that was compensated by a model, or one that was learned.
///
/// # Errors
/// When there is no log, a log is not of a run of the path or does not fit the model, or `progress` cancels.
pub fn learn_from_runs(
    input: &Input,
    logs: &[Log],
    model: &Bundle,
    settings: &Settings,
    progress: Progress<'_>,
) -> Result<Learning> {
    input.check_original()?;
    let runs: Vec<ObservedRun> = logs.iter().map(|log| ObservedRun::of(input, log, model)).collect::<Result<_>>()?;
    let measured: Vec<Figures> = runs.iter().map(|run| run.figures).collect();
    let best = best_of(&measured).ok_or(Error::NoRun("learning"))?;
    let known = KnownRuns { repeated: repeated_of(input, model, &runs)?, command: runs[best].command.clone() };
    let forecasts: Vec<Figures> = runs.iter().map(|run| run.forecast(input, &known.repeated)).collect::<Result<_>>()?;
    let outcome = model_based_ilc_after(input, model, Some(&known), settings, progress)?;
    let expected = Expected::of(best, &measured, &forecasts, &outcome.after);
    let ended = match (last_is_worse(&measured), expected.gains) {
        (true, _) => Some(Ended::Worse),
        (false, false) => Some(Ended::NoGain),
        (false, true) => None,
    };
    Ok(Learning { runs, best, expected, outcome, ended })
}

/// Repeatable part of the model's error, one column an axis.
fn repeated_of(input: &Input, model: &Bundle, runs: &[ObservedRun]) -> Result<Vec<Vec<f64>>> {
    let path = input.trajectory();
    let counted: Vec<bool> = (0..path.len()).map(|k| counts(input.part(), k)).collect();
    let of_axis = |(index, axis): (usize, &motion::Axis)| {
        let of_runs: Vec<&[f64]> = runs.iter().map(|run| run.model_error[index].as_slice()).collect();
        let known = model.manifest.axes.iter().find(|known| known.name == axis.name);
        repeated(&of_runs, &counted, known.map_or(0.0, |known| known.held_out.rms), path.period_s())
    };
    path.axes().iter().enumerate().map(of_axis).collect()
}
