//! Identification of a control: how it plans a program, from logs of programs that are known.
//!
//! [`identify`] plans every program with a candidate for the control and compares the result with the recorded command: the time in which
//! every part of the path is passed, and the distance from the path. Structures (how acceleration is shaped, how corners are passed, what
//! is done besides) are compared on programs that their parameters were not fitted to. What comes out is a machine description with the
//! limits of axes and path, [`ControlSpec`](machine::ControlSpec), and its [`Fidelity`].

mod besides;
mod comparison;
mod fidelity;
mod first;
mod last_fit;
mod observed;
mod parameters;
mod search;
mod structure;

use datasets::Log;
use gcode::DecimalPoint;
use machine::MachineSpec;
use models::ControlFidelity;
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::part::ReadSettings;
use crate::progress::{Job, Progress, Steps};
use crate::setup::Setup;
use crate::training::limits_of_logs;

use comparison::{Comparison, simplest};
use first::{first_corners, first_limits};
use last_fit::Fitted;
use observed::Observed;
use parameters::Parameter;
use search::interval;
use structure::{CORNERS, SHAPES};

pub use fidelity::Fidelity;
pub use observed::KnownRun;

/// An identified control.
#[derive(Debug)]
pub struct Identified {
    /// The machine with the limits and the control that were found.
    pub machine: MachineSpec,
    /// What the control does, in words.
    pub structure: String,
    /// The numbers that were found.
    pub values: Vec<Value>,
    /// Agreement on programs that were held out; on those of the fit where there is but one.
    pub fidelity: Fidelity,
    /// Names of the held-out programs; none where there is but one program.
    pub held_out: Vec<String>,
    /// Agreement of every structure that was tried, best first.
    pub tried: Vec<(String, Fidelity)>,
}

impl Identified {
    /// What a model states of it.
    #[must_use]
    pub fn summary(&self) -> ControlFidelity {
        let Fidelity { path_rms_mm, path_max_mm, cycle_share, .. } = self.fidelity;
        ControlFidelity {
            structure: self.structure.clone(),
            held_out: self.held_out.len(),
            path_rms_mm,
            path_max_mm,
            cycle_share,
        }
    }
}

/// A number of a control.
#[derive(Debug, Clone, PartialEq)]
pub struct Value {
    /// Its key in a machine file; `path.rise_ms` is the time in which the acceleration reaches its limit, 2·acceleration/jerk, and
    /// `path.tight_arcs_mm_s2` the acceleration along the tightest arcs, `√(arc_acceleration² − centripetal²)`.
    pub key: String,
    /// Its value.
    pub value: f64,
    /// Range within which the agreement stays as it is within a tenth; half a range where a bound is reached.
    pub interval: [f64; 2],
}

/// Every so many runs one is held out.
const HELD_OUT: usize = 3;
/// Time in motion of the runs to which parameters are fitted, to compare structures and at last, s. It bounds the computing time.
const COMPARED_S: f64 = 35.0;
const FIT_S: f64 = 60.0;
/// The golden ratio: its multiples leave remainders that are spread evenly, however many are taken.
const GOLDEN: f64 = 0.618_033_988_749_895;

/// Identifies the control that ran `runs`. `machine` gives kinematics and first values; without it they come from the logs.
///
/// # Errors
/// When a program cannot be read, when a log is not of its program, when there is no run, or when `progress` cancels.
pub fn identify(runs: &[KnownRun<'_>], machine: Option<&MachineSpec>, progress: Progress<'_>) -> Result<Identified> {
    let logs: Vec<&Log> = runs.iter().map(|run| run.log).collect();
    let first = match machine {
        Some(machine) => machine.clone(),
        None => limits_of_logs(&logs)?,
    };
    let observed = by_corners(observe(runs, &first)?);
    let start = first_limits(&first, &logs, &observed);
    let first_corners = first_corners(&start, &observed);
    let (fitted, held_out) = split(&observed);
    let steps = Steps::new(progress, Job::Identifying, SHAPES.len() * CORNERS.len());
    let fitted = parts(&fitted);
    let compared = spread(COMPARED_S, &fitted);
    let mut comparison = Comparison::new(&compared, &held_out, first_corners, steps);
    comparison.run(&start)?;
    let tried = comparison.sorted();
    let best = simplest(&tried).ok_or(Error::NoLog)?;
    let all = parts(&up_to(FIT_S, observed.iter()));
    let all = spread(FIT_S, &all);
    // Within the pool of threads: from outside, every small parallel step of a plan would wait for another thread.
    let Fitted { structure, parameters, machine, .. } = rayon::scope(|_| Fitted::of(best, &all));
    let value = |parameter: &Parameter| Value {
        key: parameter.key.clone(),
        value: parameter.of(&machine),
        interval: interval(&all, &machine, parameter),
    };
    let values = parameters.par_iter().map(value).collect();
    let of_structure = tried.iter().find(|candidate| candidate.structure == structure).unwrap_or(best);
    // As the machine that comes out, the judged one is fitted to more than structures are compared on.
    let judged = rayon::scope(|_| Fitted::as_compared(of_structure, &spread(FIT_S, &fitted)));
    Ok(Identified {
        values,
        structure: structure.to_string(),
        fidelity: Fidelity::of(&judged, &held_out),
        held_out: held_out.iter().filter(|_| observed.len() > 1).map(|run| run.name.clone()).collect(),
        tried: tried.iter().map(|candidate| (candidate.structure.to_string(), candidate.fidelity.clone())).collect(),
        machine: rounded(machine, &parameters),
    })
}

/// Agreement of the plans of `machine` with `runs`, which need not be those that it was identified from.
///
/// # Errors
/// When a program cannot be read, a log is not of its program, or there is no run.
pub fn agreement(machine: &MachineSpec, runs: &[KnownRun<'_>]) -> Result<Fidelity> {
    let observed = observe(runs, machine)?;
    Ok(Fidelity::of(machine, &observed.iter().collect::<Vec<_>>()))
}

fn observe(runs: &[KnownRun<'_>], machine: &MachineSpec) -> Result<Vec<Observed>> {
    let period_s = runs.first().ok_or(Error::NoLog)?.log.period_s();
    let setup = Setup { period_s, ..Setup::new(machine, None)? };
    let read = |run: &KnownRun<'_>, decimal_point: DecimalPoint| {
        let settings =
            ReadSettings { at_zero: true, decimal_point: setup.decimal_point.or(Some(decimal_point)), ..ReadSettings::default() };
        Observed::new(run, &setup, &settings)
    };
    // Where coordinates without a decimal point can be read in two ways, the log shows which one holds.
    let moving = |run: &KnownRun<'_>| {
        let found = read(run, DecimalPoint::Unit).or_else(|error| read(run, DecimalPoint::LeastIncrement).map_err(|_| error));
        match found {
            Err(Error::NoMotion) => Err(Error::StillProgram(run.name.clone())),
            Ok(observed) if observed.parts().is_empty() => Err(Error::StillProgram(run.name.clone())),
            found => found,
        }
    };
    runs.iter().map(moving).collect()
}

/// The runs, those with most corners first: they say most about the control. A program of one smooth curve says little.
fn by_corners(mut observed: Vec<Observed>) -> Vec<Observed> {
    observed.sort_by_key(|run| std::cmp::Reverse(run.corners().len()));
    observed
}

/// Runs to fit, and runs to compare structures on: every third run. Of a single run both are the same.
fn split(observed: &[Observed]) -> (Vec<&Observed>, Vec<&Observed>) {
    if observed.len() < 2 {
        return (observed.iter().collect(), observed.iter().collect());
    }
    let apart = HELD_OUT.min(observed.len());
    let of =
        |wanted: bool| observed.iter().enumerate().filter(move |(k, _)| (k % apart == apart - 1) == wanted).map(|(_, run)| run);
    (up_to(FIT_S, of(false)), of(true).collect())
}

/// The first runs, up to so much time in motion; at least one.
fn up_to<'a>(most_s: f64, runs: impl Iterator<Item = &'a Observed>) -> Vec<&'a Observed> {
    let mut taken_s = 0.0;
    let within = |run: &&Observed| {
        let goes_on = taken_s < most_s;
        taken_s += run.seconds();
        goes_on
    };
    runs.take_while(within).collect()
}

/// The runs in their parts from rest to rest.
fn parts(runs: &[&Observed]) -> Vec<Observed> {
    runs.iter().flat_map(|run| run.parts()).collect()
}

/// So much time in motion of the runs, spread over all of them.
fn spread(most_s: f64, runs: &[Observed]) -> Vec<&Observed> {
    let share = most_s / runs.iter().map(Observed::seconds).sum::<f64>();
    runs.iter().enumerate().filter(|(k, _)| (*k as f64 * GOLDEN).fract() < share).map(|(_, run)| run).collect()
}

/// The machine with four significant digits of its parameters.
fn rounded(mut machine: MachineSpec, parameters: &[Parameter]) -> MachineSpec {
    for parameter in parameters {
        let value = parameter.of(&machine);
        if value > 0.0 {
            let unit = 10f64.powf(value.log10().floor() - 3.0);
            parameter.set(&mut machine, (value / unit).round() * unit);
        }
    }
    machine
}
