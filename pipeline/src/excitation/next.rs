//! The next excitation of a machine that has a model: more of the motion that decides the model's error.
//!
//! A model states its expected error by regime of motion (at rest, after starts and reversals, by speed), and how long each was in its log. What a
//! path asks of each regime gives its expected error there. The runs of the next excitation are chosen one after the other: each is of the kind
//! that lowers this error most for its length, where the squared error of a regime falls with its length in all logs to the power [`DECAY`].

use datasets::{ExcitationPlan, RunPlan, excite};
use machine::MachineSpec;
use models::{AxisSignal, Bundle, REGIMES, Spread};
use motion::{AxisKind, Trajectory};

use super::recording::{Region, travel};
use crate::error::{Error, Result};
use crate::input::Input;
use crate::setup::Setup;

/// Number of runs if all take as long as they should, and the largest number.
const RUNS: usize = 10;
const MOST_RUNS: usize = 20;
/// Length of all runs over the requested one beyond which no run is added.
const MOST_OF_SECONDS: f64 = 1.2;
/// Exponent of the fall of a model's squared error with the length of its log. With logs of 30, 60 and 120 s it fell by the power 0.11 on `ballscrew`, 0.01 on
/// `random:142` and, from 30 to 60 s, 0.06 on `random:146`: most of the error is noise and what the model does not hold.
const DECAY: f64 = 0.1;
/// Length of a regime that counts as known before any log, s: shorter ones are not distinguished.
const BEFOREHAND_S: f64 = 1.0;
/// Motion around a part that belongs to its excitation, mm.
const AROUND_PART_MM: f64 = 10.0;
/// Lever arm at which an angle counts beside lengths, mm.
const LEVER_MM: f64 = 100.0;

/// The next excitation.
#[derive(Debug, Clone)]
pub struct NextExcitation {
    /// Its runs.
    pub plan: ExcitationPlan,
    /// Lowest and highest position of every axis, mm or rad.
    pub travel: Vec<(f64, f64)>,
    /// What is expected of every axis.
    pub axes: Vec<NextAxis>,
}

/// Expected error of an axis on the path, mm or rad.
#[derive(Debug, Clone, PartialEq)]
pub struct NextAxis {
    /// Name of the axis.
    pub name: String,
    /// Its kind.
    pub kind: AxisKind,
    /// RMS with the present model.
    pub before: f64,
    /// RMS with a model of the present and the next logs.
    pub after: f64,
    /// The regime that adds most to the squared error, as an index of [`models::REGIME_NAMES`]; its RMS, and its length in the model's log, s.
    pub weakest: (usize, f64, f64),
}

/// Seconds of each regime.
type Seconds = [f64; REGIMES];

/// What the model knows of an axis, and what the path asks of it.
struct Known<'a> {
    name: &'a str,
    kind: AxisKind,
    spread: &'a Spread,
    /// Share of the path's time in each regime.
    shares: Seconds,
}

impl Known<'_> {
    /// Expected squared error on the path, with `more` seconds of each regime.
    fn square(&self, more: &Seconds) -> f64 {
        let known_s = self.spread.trained_s();
        let of = |regime: usize| {
            let before_s = BEFOREHAND_S + known_s[regime];
            let rms = self.spread.by_regime()[regime];
            self.shares[regime] * rms * rms * (before_s / (before_s + more[regime])).powf(DECAY)
        };
        (0..REGIMES).map(of).sum()
    }

    fn weakest(&self) -> (usize, f64, f64) {
        let rms = self.spread.by_regime();
        let part = |regime: &usize| self.shares[*regime] * rms[*regime].powi(2);
        let regime = (0..REGIMES).max_by(|a, b| part(a).total_cmp(&part(b))).unwrap_or_default();
        (regime, rms[regime], self.spread.trained_s()[regime])
    }
}

/// Kinds of runs that are chosen from.
fn kinds(each_s: f64) -> [RunPlan; 7] {
    [
        RunPlan::standard("full", each_s, 1.0),
        RunPlan::standard("half", each_s, 0.5),
        RunPlan::standard("slow", each_s, 0.25),
        RunPlan::standard("creep", each_s, 0.06),
        RunPlan::sharp("sharp", each_s),
        RunPlan::lines("lines", each_s),
        RunPlan { speed_share: 0.25, ..RunPlan::lines("slow-lines", each_s) },
    ]
}

/// Names of all runs that a next excitation may have.
#[must_use]
pub fn possible_names(seconds: f64) -> Vec<String> {
    let kinds = kinds(seconds / RUNS as f64);
    (0..MOST_RUNS)
        .flat_map(|run| kinds.iter().map(move |kind| format!("{:02}-{}", run + 1, kind.name)).collect::<Vec<_>>())
        .collect()
}

/// Plans about `seconds` of excitation after `model`: for the motion of `part` and around it, where it is known where the part lies, or for that of
/// an excitation of all kinds within `region`.
///
/// # Errors
/// When the model states no errors by regime, none of its axes is one of the path's, or no excitation fits the machine.
pub fn next_excitation(
    model: &Bundle,
    (spec, setup): (&MachineSpec, &Setup),
    region: &Region,
    part: Option<&Input>,
    seconds: f64,
    seed: u64,
) -> Result<NextExcitation> {
    let travel = ranges(model, spec, region, part.filter(|part| is_placed(part)))?;
    let runs_of = |runs: Vec<RunPlan>| -> Result<Vec<Trajectory>> {
        let plan = ExcitationPlan { runs };
        let runs = excite(&plan, &setup.limits, setup.kinematics.axes(), &travel, setup.period_s, seed)?;
        Ok(runs.into_iter().map(|(_, run)| run).collect())
    };
    let asked = match part {
        Some(part) => vec![part.command().clone()],
        None => runs_of(ExcitationPlan::of_seconds(seconds).runs)?,
    };
    let known = known_axes(model, &asked)?;
    let kinds = kinds(seconds / RUNS as f64);
    let candidates = runs_of(kinds.to_vec())?;
    let (chosen, more) = choose(&known, &candidates, seconds);
    let expected = |(known, more): (&Known<'_>, &Seconds)| NextAxis {
        name: known.name.to_owned(),
        kind: known.kind,
        before: known.square(&[0.0; REGIMES]).sqrt(),
        after: known.square(more).sqrt(),
        weakest: known.weakest(),
    };
    let axes = known.iter().zip(&more).map(expected).collect();
    let runs = chosen.into_iter().map(|kind| kinds[kind].clone()).collect();
    Ok(NextExcitation { plan: ExcitationPlan { runs }, travel, axes })
}

/// The axes of the model that the runs `asked` move, with the shares of their time in each regime.
fn known_axes<'a>(model: &'a Bundle, asked: &[Trajectory]) -> Result<Vec<Known<'a>>> {
    let mut known = Vec::new();
    for (own, axis) in model.manifest.axes.iter().zip(model.axes()) {
        let Some(spread) = own.band.spread() else { continue };
        let mut shares = [0.0; REGIMES];
        for run in asked {
            shares.iter_mut().zip(seconds_of(spread, &own.name, run)).for_each(|(share, seconds)| *share += seconds);
        }
        let total = shares.iter().sum::<f64>();
        if total > 0.0 {
            known.push(Known { name: &own.name, kind: axis.kind, spread, shares: shares.map(|share| share / total) });
        }
    }
    let says = |known: &Known<'_>| known.spread.trained_s().iter().sum::<f64>() > 0.0;
    if known.is_empty() || !known.iter().all(says) { Err(Error::NoRegimes) } else { Ok(known) }
}

/// Length of each regime of an axis in a run, s; none where the run has no such axis.
fn seconds_of(spread: &Spread, axis: &str, run: &Trajectory) -> Seconds {
    match run.axes().iter().position(|of| of.name == axis) {
        Some(axis) => spread.seconds_of(&AxisSignal::uncompensated(&run.columns()[axis], run.period_s())),
        None => [0.0; REGIMES],
    }
}

/// Indices of the kinds of runs, of which `candidates` holds one each, and what they add to each regime of every axis.
fn choose(known: &[Known<'_>], candidates: &[Trajectory], seconds: f64) -> (Vec<usize>, Vec<Seconds>) {
    let adds = |run: &Trajectory| known.iter().map(|known| seconds_of(known.spread, known.name, run)).collect();
    let adds: Vec<Vec<Seconds>> = candidates.iter().map(adds).collect();
    let with = |more: &[Seconds], kind: usize| -> Vec<Seconds> {
        let sum = |(more, add): (&Seconds, &Seconds)| std::array::from_fn(|regime| more[regime] + add[regime]);
        more.iter().zip(&adds[kind]).map(sum).collect()
    };
    let square = |more: &[Seconds]| -> f64 {
        let scale = |kind: AxisKind| if kind == AxisKind::Rotary { LEVER_MM } else { 1.0 };
        known.iter().zip(more).map(|(known, more)| known.square(more) * scale(known.kind).powi(2)).sum()
    };
    let (mut more, mut chosen, mut length_s) = (vec![[0.0; REGIMES]; known.len()], Vec::new(), 0.0);
    while chosen.len() < MOST_RUNS && length_s < seconds {
        let now = square(&more);
        let gain = |kind: &usize| (now - square(&with(&more, *kind))) / candidates[*kind].duration_s();
        let fits = |kind: &usize| chosen.is_empty() || length_s + candidates[*kind].duration_s() <= MOST_OF_SECONDS * seconds;
        let Some(best) = (0..candidates.len()).filter(fits).max_by(|a, b| gain(a).total_cmp(&gain(b))) else { break };
        more = with(&more, best);
        length_s += candidates[best].duration_s();
        chosen.push(best);
    }
    (chosen, more)
}

/// Whether it is known where a part lies on the machine; a reference states it.
#[must_use]
pub fn is_placed(part: &Input) -> bool {
    part.part().is_none_or(|part| part.placement.known())
}

/// Lowest and highest position of every axis, mm or rad. Linear axes that `part` moves: its own with some motion around it, within the travel.
/// Others: those of `region`; of an axis without stated travel and origin as many about the middle of the model's log, and within it, since nothing else is
/// known of how far it may go.
fn ranges(model: &Bundle, spec: &MachineSpec, region: &Region, part: Option<&Input>) -> Result<Vec<(f64, f64)>> {
    let mut ranges = travel(spec, region)?;
    for (range, axis) in ranges.iter_mut().zip(&spec.axes) {
        let name = axis.name();
        let logged = model.manifest.axes.iter().find(|own| own.name == name).map(|own| own.coverage.position);
        let is_stated = region.origin.iter().any(|(stated, _)| stated == name);
        if let (None, Some((low, high)), false) = (axis.travel(), logged, is_stated) {
            let (middle, half) = (f64::midpoint(low, high), 0.5 * (range.1 - range.0));
            *range = (low.max(middle - half), high.min(middle + half));
        }
        let Some((low, high)) =
            part.filter(|_| axis.axis().kind == AxisKind::Linear).and_then(|part| extent(part.trajectory(), name))
        else {
            continue;
        };
        let [lowest, highest] = axis.travel().unwrap_or_else(|| {
            let (first, last) = logged.unwrap_or((low, high));
            [first.min(low), last.max(high)]
        });
        *range = (lowest.max(low - AROUND_PART_MM), highest.min(high + AROUND_PART_MM));
    }
    Ok(ranges)
}

/// Lowest and highest position of an axis on a path; `None` where it does not move.
fn extent(path: &Trajectory, axis: &str) -> Option<(f64, f64)> {
    let positions = &path.columns()[path.axes().iter().position(|of| of.name == axis)?];
    let (low, high) = positions.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(*x), high.max(*x)));
    (high > low).then_some((low, high))
}
