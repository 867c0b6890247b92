//! Errors at stops: how slowly a program has to come to its ends.
//!
//! No shift removes the error at a stop. The end itself stays where it is, so that the correction is tapered to zero before it, and axes that lead or lag
//! while the control brakes pass the end, or cut the corner to it. Measured on ten random machines (`random:140`, `142`, `153`, `160`, `163`, `170`, `172`,
//! `174`, `179`, `181`; 270° of a circle of short lines, 80 mm/s): axes that lead pass the end by 10 to 26 µm; with a zone of 1.75 times that, taken in the time
//! that they are beyond by more than 0.3 of it, 0 to 2 µm are left. Axes that lag (`bc`, the S-shaped test piece: 10 µm) need shorter ones: 0.01 mm in 30 ms leave
//! 3.5 µm, 0.03 mm in 60 ms 7.8.

use std::ops::Range;

use machine::Machine;
use motion::{Trajectory, Vec3};

use super::acceptance::cost;
use super::gain::LEAST_GAIN;
use super::settings::Settings;
use super::task::Task;
use crate::control::ControlledMachine;
use crate::error::Result;
use crate::part::{Part, PathSegment};
use crate::refit::{RefitSettings, SlowStop};

/// Length of the zone, as a multiple of the overshoot of axes that lead: they have to come to rest within it.
const OVERSHOOTS: f64 = 1.75;
/// Share of the overshoot above which it counts as lasting, and of the distance at a stop below which an axis has settled.
const LASTING_SHARE: f64 = 0.3;
const SETTLED_SHARE: f64 = 0.2;
/// Zones that are tried for any axes: length as a multiple of the error near the stop, and time as a multiple of that in which the axes settle.
const TRIED: [[f64; 2]; 3] = [[1.0, 0.7], [1.0, 1.5], [3.0, 1.5]];
/// Largest time in a zone, s.
const MOST_S: f64 = 0.25;
/// Least time, as a share of the one that is wanted. A shorter one leaves most of the error.
const LEAST_SHARE: f64 = 0.25;
/// Share of the allowed increase of the cycle time that slow stops may take.
const CYCLE_SHARE: f64 = 0.5;
/// Least error near a stop for which zones are tried, as a multiple of the error of the model, as a share of the largest error anywhere.
const LEAST_ERRORS: f64 = 2.0;
const LEAST_OF_MAX: f64 = 0.25;
/// Time before and after a stop that counts as near, s; distance before it in which an overshoot is sought, mm.
const NEAR_S: [f64; 2] = [0.05, 0.1];
const NEAR_MM: f64 = 0.5;
/// Length over which the direction at a stop is taken, the distance up to which a path has not gone on, and that of a sample at the stop, mm.
const DIRECTION_MM: f64 = 0.01;
const SAME_MM: f64 = 1e-3;
const AT_STOP_MM: f64 = 1e-6;

/// The slow zone before the stops of a program with which the run of `reference` costs least; `None` where none gains.
///
/// # Errors
/// When a program cannot be written, planned or run.
pub(super) fn slow_stop<M: Machine + ?Sized>(
    task: &Task<'_>,
    control: &mut ControlledMachine<'_, M>,
    part: &Part,
    [uncompensated, reference]: [&Trajectory; 2],
    written: RefitSettings,
    settings: &Settings,
) -> Result<Option<SlowStop>> {
    if !settings.slow_stops {
        return Ok(None);
    }
    let mut run = |slow_stop: Option<SlowStop>| -> Result<(f64, Vec<f64>)> {
        control.replans(RefitSettings { slow_stop, ..written });
        let errors = task.errors(&control.run(reference)?)?;
        Ok((cost(&task.whole_figures(&errors)?), errors.costs_mm()))
    };
    let (before, costs_mm) = run(None)?;
    let mut best = (before * (1.0 - LEAST_GAIN), None);
    for zone in candidates(part, uncompensated, &costs_mm, task.model_error_mm(), settings)? {
        let (cost_mm, _) = run(Some(zone))?;
        // No stop of the program may be slow.
        if cost_mm == before {
            break;
        }
        if cost_mm < best.0 {
            best = (cost_mm, Some(zone));
        }
    }
    Ok(best.1)
}

/// Zones to try, where the errors near the stops are larger than the model's error allows to say, and than a quarter of all others.
fn candidates(
    part: &Part,
    uncompensated: &Trajectory,
    costs_mm: &[f64],
    model_error_mm: f64,
    settings: &Settings,
) -> Result<Vec<SlowStop>> {
    let (tips, actual) = (part.plan.desired.tips(), part.plan.desired.tips_of(uncompensated)?);
    let period_s = uncompensated.period_s();
    let segments = part.segments();
    let stops = segments.iter().filter_map(|segment| Stop::of(part, &tips, segment, period_s));
    let error_mm = |stop: &Stop| stop.near.clone().map(|k| costs_mm[k]).fold(0.0, f64::max);
    let worst = stops.map(|stop| (error_mm(&stop), stop)).max_by(|a, b| a.0.total_cmp(&b.0));
    let Some((error_mm, stop)) = worst else { return Ok(Vec::new()) };
    let most_mm = segments.iter().flat_map(|segment| &costs_mm[segment.samples.clone()]).copied().fold(0.0, f64::max);
    if error_mm <= LEAST_ERRORS * model_error_mm || error_mm < LEAST_OF_MAX * most_mm {
        return Ok(Vec::new());
    }
    let (overshoot_mm, lasting_s) = stop.overshoot(&tips, &actual, period_s);
    let leads = overshoot_mm > LEAST_ERRORS * model_error_mm;
    let of_lead = leads.then_some((OVERSHOOTS * overshoot_mm, lasting_s));
    let settle_s = stop.settles(&tips, &actual, period_s);
    let of_any = TRIED.iter().map(|[lengths, times]| (lengths * error_mm, times * settle_s));
    let budget_s = CYCLE_SHARE * settings.cycle_limit * part.plan.desired.trajectory().duration_s() / segments.len() as f64;
    let zone = |(length_mm, wanted_s): (f64, f64)| {
        let wanted_s = wanted_s.min(MOST_S).min(length_mm / SlowStop::LEAST_MM_S);
        let time_s = wanted_s.min(budget_s);
        (time_s >= LEAST_SHARE * wanted_s).then_some(SlowStop { length_mm, time_s })
    };
    Ok(of_lead.into_iter().chain(of_any).filter_map(zone).collect())
}

/// A stop at the end of a segment.
struct Stop {
    /// Sample at which the path comes to it.
    at: usize,
    /// Direction of the path there.
    towards: Vec3,
    /// Samples of the segment near the stop.
    near: Range<usize>,
}

impl Stop {
    fn of(part: &Part, tips: &[Vec3], segment: &PathSegment, period_s: f64) -> Option<Self> {
        let end_mm = *part.plan.piece_ends_mm.get(segment.pieces.end.checked_sub(1)?)?;
        let samples = &part.plan.samples;
        let at = samples.partition_point(|sample| sample.position_mm < end_mm - AT_STOP_MM).min(samples.len() - 1);
        let before = (segment.samples.start..at).rev().find(|k| (tips[at] - tips[*k]).norm() >= DIRECTION_MM)?;
        let [before_s, after_s] = NEAR_S.map(|time_s| (time_s / period_s) as usize);
        let near = at.saturating_sub(before_s).max(segment.samples.start)..(at + after_s).min(segment.samples.end);
        Some(Self { at, towards: (tips[at] - tips[before]).normalize(), near })
    }

    /// How far a run is beyond the stop, mm, and for how long, s.
    fn overshoot(&self, tips: &[Vec3], actual: &[Vec3], period_s: f64) -> (f64, f64) {
        let end = tips[self.at];
        let near = |k: &usize| (tips[*k] - end).norm() <= NEAR_MM;
        let from = (0..self.at).rev().take_while(near).last().unwrap_or(self.at);
        let goes_on = |k: &usize| (tips[*k] - end).dot(&self.towards) > SAME_MM;
        let until = (self.at + (NEAR_S[1] / period_s) as usize).min(tips.len() - 1);
        let until = (self.at..until).find(goes_on).unwrap_or(until);
        let beyond: Vec<f64> = actual[from..=until].iter().map(|tip| (tip - end).dot(&self.towards)).collect();
        let largest = (0..beyond.len()).max_by(|a, b| beyond[*a].total_cmp(&beyond[*b])).unwrap_or_default();
        let lasts = |at: &&f64| **at > LASTING_SHARE * beyond[largest];
        let [before, after] =
            [beyond[..largest].iter().rev().take_while(lasts).count(), beyond[largest..].iter().take_while(lasts).count()];
        (beyond[largest], (before + after).max(1) as f64 * period_s)
    }

    /// Time after the stop in which a run comes near to it, s.
    fn settles(&self, tips: &[Vec3], actual: &[Vec3], period_s: f64) -> f64 {
        let off = |k: usize| (actual[k] - tips[self.at]).norm();
        let most = ((MOST_S / period_s) as usize).min(actual.len() - 1 - self.at);
        let settled = (1..most).find(|k| off(self.at + k) <= SETTLED_SHARE * off(self.at));
        settled.unwrap_or(most).max(1) as f64 * period_s
    }
}

#[cfg(test)]
mod tests {
    use machine::MachineSpec;

    use super::*;
    use crate::part::WorkOffsets;
    use crate::setup::Setup;

    const PERIOD_S: f64 = 0.002;

    /// Two cuts of 20 mm between rapids.
    fn part() -> Part {
        let text = "G21 G90\nG0 X0 Y0 Z0\nG1 X20 F3000\nG0 Z5\nG0 X40\nG0 Z0\nG1 X60\nM2\n";
        let setup = Setup::new(&MachineSpec::builtin("ballscrew").unwrap(), None).unwrap();
        let (program, options) = (gcode::parse(text), gcode::Dialect::LinuxCnc.into());
        Part::planned("two-cuts.nc", program, options, &WorkOffsets::default().or_zero(), &setup, &setup.plan_settings()).unwrap()
    }

    /// A run that is up to `beyond_mm` beyond the end of the first cut for 40 ms.
    fn beyond_first_end(part: &Part, beyond_mm: f64) -> Trajectory {
        let path = part.plan.desired.trajectory();
        let mut columns = path.columns().to_vec();
        let stop = columns[0].iter().position(|x| *x >= 20.0 - 1e-9).unwrap();
        for (k, x) in columns[0][stop - 10..stop + 10].iter_mut().enumerate() {
            *x = 20.0 + beyond_mm * (std::f64::consts::PI * (k as f64 - 10.0) / 20.0).cos().powi(2);
        }
        path.with_columns(columns).unwrap()
    }

    fn zones(part: &Part, run: &Trajectory, model_error_mm: f64, settings: &Settings) -> Vec<SlowStop> {
        let tips = part.plan.desired.tips();
        let beyond = |(tip, wanted): (Vec3, &Vec3)| (tip - wanted).norm();
        let costs_mm: Vec<f64> = part.plan.desired.tips_of(run).unwrap().into_iter().zip(&tips).map(beyond).collect();
        candidates(part, run, &costs_mm, model_error_mm, settings).unwrap()
    }

    #[test]
    fn zones_are_tried_where_the_error_at_a_stop_is_more_than_the_models() {
        let part = part();
        assert_eq!((part.segments().len(), part.plan.desired.trajectory().period_s()), (2, PERIOD_S));
        let settings = Settings { cycle_limit: f64::INFINITY, ..Settings::default() };
        let run = beyond_first_end(&part, 0.02);
        let found = zones(&part, &run, 1e-3, &settings);
        assert_eq!(found.len(), 1 + TRIED.len());
        assert!((found[0].length_mm - 0.035).abs() < 1e-4, "{found:?}");
        // cos² is above 0.3 for 63 % of its half period.
        assert!((found[0].time_s - 0.025).abs() < 2.0 * PERIOD_S, "{found:?}");
        assert_eq!(zones(&part, part.plan.desired.trajectory(), 1e-3, &settings), []);
        assert_eq!(zones(&part, &run, 0.1, &settings), []);
        // A larger error elsewhere is what counts.
        let mut columns = run.columns().to_vec();
        let cut = columns[0].iter().position(|x| *x > 10.0).unwrap();
        columns[1][cut] += 0.2;
        assert_eq!(zones(&part, &run.with_columns(columns).unwrap(), 1e-3, &settings), []);
    }

    #[test]
    fn slow_stops_take_half_of_the_time_that_a_cycle_may_take_longer() {
        let part = part();
        let cycle_s = part.plan.desired.trajectory().duration_s();
        let run = beyond_first_end(&part, 0.02);
        let zones = |cycle_limit: f64| zones(&part, &run, 1e-3, &Settings { cycle_limit, ..Settings::default() });
        // Two stops.
        let limit = 4.0 * 0.015 / cycle_s;
        assert!((zones(limit)[0].time_s - 0.015).abs() < 1e-9);
        assert!(zones(limit).iter().all(|zone| zone.time_s < 0.015 + 1e-9));
        assert_eq!(zones(0.0), []);
    }
}
