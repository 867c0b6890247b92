//! `precomp compensate`: the main job.

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Args;
use compensation::Guard;
use models::Outside;
use serde_json::json;

use crate::cli::{CarrierArgs, Common, LogArgs, ProgramArgs, parse_length, parse_not_negative};
use crate::evaluate;
use crate::expectation::Expectation;
use crate::feeds::{self, Adjusted, Goal};
use crate::files::Files;
use crate::input::{self, Frame, Input, Source};
use crate::learning::{self, LawName, Outcome, Settings};
use crate::left_out::{self, LeftOut};
use crate::measurement::Readback;
use crate::output::{Outputs, Printer, Refusal, Usage, um};
use crate::pipeline::{Carried, Carrier, Part, RowsWritten, as_recorded, write_out};
use crate::progress::LearningProgress;
use crate::report::{PathReport, Series, report_page};
use crate::travel;

/// Shift a part program's (or reference's) points so that the machine cuts the path that it asks for
///
/// Only points of feed moves change. The output is read again and compared with what was meant before it is written.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  precomp compensate part.nc -m mill.model -o compensated.nc --report forecast.html
  precomp compensate reference.csv -m mill.model -o compensated.csv
  precomp compensate part.nc -m mill.model -o compensated.nc --reference run-of-part.log
  precomp compensate part.nc -m mill.model -o rows.csv --carrier pvt --spacing 5")]
pub struct Compensate {
    /// Part program or reference (.csv, .parquet)
    input: PathBuf,
    #[command(flatten)]
    common: Common,
    /// Model of the machine, from `precomp train`
    #[arg(short, long, value_name = "MODEL")]
    model: PathBuf,
    /// The file to write, of the same kind as INPUT; a table (.csv) with `--carrier table` or `pvt`
    #[arg(short, long, value_name = "OUT")]
    out: PathBuf,
    #[command(flatten)]
    program: ProgramArgs,
    #[command(flatten)]
    carrier: CarrierArgs,
    /// How the reference is learned on the model
    #[arg(long, value_enum, default_value_t = LawName::Virtual)]
    law: LawName,
    /// Updates on the model; a program that its control plans anew gets up to three times as many more, one of hours fewer
    #[arg(long, default_value_t = 4)]
    iterations: usize,
    /// Largest shift of the tool tip, mm: the length of the vector. Twice the largest error of the uncompensated forecast when left out, from 0.1 to 1 mm
    #[arg(long, value_name = "MM", value_parser = parse_not_negative)]
    max_shift: Option<f64>,
    /// Largest correction of the tool's direction on a machine that turns tool or workpiece, degrees
    #[arg(long, value_name = "DEG", default_value_t = Guard::MAX_TURN_DEG, value_parser = parse_not_negative)]
    max_turn: f64,
    /// Slow moves down whose predicted contour error stays above this after compensation: 2um, 0.002mm
    #[arg(long, value_name = "LENGTH", value_parser = parse_length)]
    tolerance: Option<f64>,
    /// With --tolerance: speed other moves up until the cycle takes no longer than before
    #[arg(long, requires = "tolerance")]
    keep_time: bool,
    /// Limits of this machine instead of those in the model: a TOML file, or a built-in one
    #[arg(long, value_name = "TOML")]
    machine: Option<String>,
    /// Log of a run of INPUT as it is: compensate from what the control commanded in it, where it plans otherwise than precomp
    #[arg(long, value_name = "LOG", conflicts_with = "tolerance")]
    reference: Option<PathBuf>,
    #[command(flatten)]
    columns: LogArgs,
    /// Write the forecast before and after as a page
    #[arg(long, value_name = "HTML")]
    report: Option<PathBuf>,
}

impl Compensate {
    pub fn files(&self) -> Files {
        Files::of(self.common.json.as_deref())
            .reads("INPUT", &*self.input)
            .reads("-m", &*self.model)
            .reads_machine(self.machine.as_deref())
            .reads_controller(self.carrier.controller.as_deref())
            .reads_logs("--reference", self.reference.as_ref())
            .writes("-o", &*self.out)
            .writes("--report", self.report.as_deref())
    }

    pub fn run(&self) -> Result<()> {
        // Among the threads that share the work: whoever waits for a part does another one meanwhile.
        rayon::scope(|_| self.compensate())
    }

    fn compensate(&self) -> Result<()> {
        let (bundle, source) = rayon::join(|| input::model(&self.model), || Source::open(&self.input));
        let bundle = bundle?;
        let spec = match &self.machine {
            Some(machine) => input::machine(machine)?,
            None => input::machine_of(&bundle)?,
        };
        let spec = self.carrier.on(spec)?;
        let frame = Frame::of(&spec)?;
        let mut path = source?.on(&frame, &self.program)?;
        let mut carried = Carried::of(&self.carrier, &spec);
        carried.check(&path, &self.out)?;
        path.part.iter_mut().for_each(|part| carried.tell(part, &self.carrier, &spec));
        let settings = Settings {
            law: self.law,
            iterations: self.iterations,
            max_shift: self.max_shift,
            max_turn_rad: self.max_turn.to_radians(),
            written: carried.program(&self.carrier, &spec).filter(|_| path.part.is_some()),
            slowest: if self.carrier.carrier.is_some() { f64::INFINITY } else { SLOWEST },
            ..Settings::default()
        };
        let printer = Printer::new(self.common.json.as_deref());
        if self.reference.is_none() && (self.columns.columns.is_some() || self.columns.period.is_some()) {
            return Err(Usage("--columns and --period say how the log of --reference is read; there is none".into()).into());
        }
        let mut readback = None;
        if let Some(log) = &self.reference {
            let (recorded, found) = self.recorded(path, log, &printer)?;
            path = recorded;
            readback = Some(found);
        }
        let left_out = LeftOut::of(&bundle, &path)?;
        left_out.iter().filter_map(LeftOut::in_words).chain(travel::unchecked(&path, &frame)).for_each(|line| printer.line(line));
        let mut feeds = serde_json::Value::Null;
        let progress = LearningProgress::new();
        let watch = |forecast| progress.show(forecast);
        let outcome = match self.tolerance {
            Some(tolerance_mm) => {
                let Some(part) = path.part.take() else {
                    return Err(Usage(
                        "--tolerance changes feeds: only part programs have them, references carry their time".into(),
                    )
                    .into());
                };
                let goal = Goal { tolerance_mm, keep_time: self.keep_time };
                let adjusted = feeds::adjust(part, &bundle, &frame.limits, &settings, goal, &watch)?;
                say_feeds(&printer, &adjusted, goal);
                feeds = feeds_json(&adjusted, goal);
                path.desired = adjusted.part.plan.desired.clone();
                path.part = Some(adjusted.part);
                adjusted.outcome
            }
            None => learning::compensate_watched(&bundle, &frame.limits, &path.desired, path.part.as_ref(), &settings, &watch)?,
        };
        drop(progress);
        if let (true, Some(slowdown), Some(written)) = (outcome.gained, outcome.kept_feeds, settings.written) {
            printer.line(format!(
                "note: with the time of every point the cycle would take {:.1} % longer; the program keeps its feeds instead (--carrier {} states the times)",
                100.0 * slowdown,
                written.carrier.name()
            ));
            carried = Carried::Program(Carrier::Keep);
        }
        if bundle.manifest.limits_from_log {
            printer
                .line("note: the machine's limits were taken from what the training log reached; give --machine to state them");
        }
        let expected = Expectation::of(&bundle, &path.desired, path.part.as_ref(), &outcome.reference, &outcome.forecast)?;
        self.say(&printer, &path, &outcome, expected.as_ref());
        let written = write_out(&path, &outcome.reference, carried, &spec, &self.carrier, outcome.max_shift, &self.out)?;
        let mut outputs = Outputs::default();
        outputs.add(&self.out, written.content);
        printer.line(format!("largest shift {} µm; written to {}", um(written.largest_shift_mm), self.out.display()));
        if outcome.gained && written.largest_shift_mm > AT_BOUND * outcome.max_shift {
            printer.line(format!(
                "warning: the correction is cut off at its bound of {} mm; with a larger --max-shift more may be gained",
                outcome.max_shift
            ));
        }
        written.rows.iter().flat_map(RowsWritten::in_words).for_each(|line| printer.line(line));
        if let Some(report) = &self.report {
            let page = report_page(&format!("Forecast for {}", path.name), &[forecast(&path, &bundle, &outcome)?])?;
            outputs.add(report, page);
            printer.line(format!("report in {}", report.display()));
        }
        outputs.write(
            self.common.json.as_deref(),
            &json!({
                "changed": outcome.gained,
                "law": self.law,
                "updates": outcome.updates,
                "ended": outcome.ended.map(|ended| ended.to_string()),
                "largest_shift_um": written.largest_shift_mm * 1e3,
                "predicted_contour_um": {
                    "before": evaluate::contour_json(&outcome.before.tip),
                    "after": evaluate::contour_json(&outcome.after.tip),
                },
                "predicted_orientation_urad": {
                    "before": evaluate::orientation_json(outcome.before.orientation.as_ref()),
                    "after": evaluate::orientation_json(outcome.after.orientation.as_ref()),
                },
                "expected_contour_um": expected.map(|expected| expected.json()),
                "left_alone": path.part.as_ref().map(|part| json!({ "moves": part.fixed_moves(), "feed_length_share": part.fixed_share() })),
                "cycle_s": outcome.cycle_s.map(|(before, after)| json!({ "before": before, "after": after })),
                "carrier": written.carried.filter(|_| outcome.gained || written.rows.is_some()),
                "rows": written.rows.map(|rows| rows.json()),
                "feeds": feeds,
                "left_out": left_out.map(|left_out| left_out.json()),
                "reference": readback.map(|found| found.json()),
                "warnings": warnings(path.part.as_ref(), &outcome),
            }),
        )
    }

    /// The program in the time of the recorded run, with what the control commanded in it.
    fn recorded(&self, path: Input, log: &Path, printer: &Printer) -> Result<(Input, Readback)> {
        if path.part.is_none() {
            return Err(Usage("--reference goes with a part program: a reference is the command itself".into()).into());
        }
        let log = input::log_to_measure(log, &self.columns, printer)?;
        let wanted = path.desired.trajectory();
        let log = log.with_axes(wanted.axes()).map_err(|error| Refusal(error.to_string()))?;
        let (log, resampled) = log.resampled(wanted.period_s()).map_err(|error| Refusal(error.to_string()))?;
        if let Some(finding) = resampled {
            printer.line(finding);
        }
        let (path, found) = as_recorded(path, &log)?;
        printer.line(found.in_words());
        if !found.is_faithful()[0] {
            printer.line(
                "corners that the control rounds off stay so; where else it leaves the path is corrected with the servo's error",
            );
        }
        Ok((path, found))
    }

    fn say(&self, printer: &Printer, path: &Input, outcome: &Outcome, expected: Option<&Expectation>) {
        for warning in path.part.iter().flat_map(|part| &part.toolpath.warnings) {
            if let Some(part) = &path.part {
                printer.line(warning.render(&part.program, &part.name));
            }
        }
        for warning in warnings(path.part.as_ref(), outcome) {
            printer.line(format!("warning: {warning}"));
        }
        printer.line(format!(
            "predicted contour error{}: {} → {} µm RMS, {} → {} µm MAX ({} updates on the model{})",
            if path.part.is_some() { " over feed moves" } else { "" },
            um(outcome.before.tip.rms_mm),
            um(outcome.after.tip.rms_mm),
            um(outcome.before.tip.max_mm),
            um(outcome.after.tip.max_mm),
            outcome.updates,
            outcome.ended.map_or(String::new(), |ended| format!("; {ended}"))
        ));
        if let Some(expected) = expected {
            printer.line(format!(
                "expected on the machine, the model's own error included: {}, nine runs in ten",
                expected.in_words()
            ));
        }
        if let (Some(before), Some(after)) = (&outcome.before.orientation, &outcome.after.orientation) {
            let urad = |rad: f64| format!("{:.2}", rad * 1e6);
            printer.line(format!(
                "predicted error of the tool's direction: {} → {} µrad RMS, {} → {} µrad MAX",
                urad(before.rms_rad),
                urad(after.rms_rad),
                urad(before.max_rad),
                urad(after.max_rad)
            ));
        }
        if let Some((before_s, after_s)) = outcome.cycle_s {
            printer.line(format!(
                "expected cycle time: {before_s:.2} → {after_s:.2} s ({:+.1} %)",
                100.0 * (after_s / before_s - 1.0)
            ));
        }
        if let Some(left) = path.part.as_ref().filter(|_| outcome.gained).and_then(left_alone) {
            printer.line(left);
        }
        if !outcome.gained {
            printer.line(format!("{}: what is written is the input, unchanged", why_unchanged(path.part.as_ref())));
        }
    }
}

/// Which moves of a program stay as they are, if any do.
fn left_alone(part: &Part) -> Option<String> {
    let fixed: Vec<String> = part.fixed_moves().iter().map(|(why, count)| format!("{count} {why}")).collect();
    let share = 100.0 * part.fixed_share();
    (!fixed.is_empty()).then(|| format!("moves left as they are: {}; {share:.1} % of the feed length", fixed.join(", ")))
}

/// Why a path is left as it is: there is nothing that may be changed, or nothing that changing it would better.
fn why_unchanged(part: Option<&Part>) -> String {
    const NO_GAIN: &str = "the model predicts no gain worth having";
    let Some(part) = part else { return NO_GAIN.to_owned() };
    let changeable = part.toolpath.moves.iter().filter(|of| part.is_shiftable(of)).count();
    let fixed: Vec<String> = part.fixed_moves().iter().map(|(why, count)| format!("{count} {why}")).collect();
    match (changeable, fixed.is_empty()) {
        (0, _) => format!("the program holds no move that may be changed ({})", fixed.join(", ")),
        (_, true) => NO_GAIN.to_owned(),
        (_, false) => format!("{NO_GAIN} on the {changeable} moves that may be changed (not changed: {})", fixed.join(", ")),
    }
}

/// Share of its bound from which on a correction counts as cut off by it.
const AT_BOUND: f64 = 0.99;

/// Share of the cycle time that points with times of their own may cost before the program's feeds are kept.
const SLOWEST: f64 = 0.03;

/// Lines above the tolerance that are named one by one.
const NAMED: usize = 5;

fn say_feeds(printer: &Printer, adjusted: &Adjusted, goal: Goal) {
    let (before_s, after_s) = adjusted.cycle_s;
    let (slower, faster) = adjusted.moves;
    printer.line(format!(
        "feeds: {slower} moves slower, {faster} faster; cycle time {before_s:.2} → {after_s:.2} s; predicted MAX on feed moves {} → {} µm, tolerance {} µm",
        um(adjusted.max_mm.0),
        um(adjusted.max_mm.1),
        um(goal.tolerance_mm)
    ));
    if goal.keep_time && after_s > before_s * (1.0 + feeds::SAME_TIME) {
        printer.line("warning: the other moves cannot win all of the time back within the tolerance and the axes' limits");
    }
    for (line, error) in adjusted.above.iter().take(NAMED) {
        printer.line(format!("warning: line {line}: predicted contour error {} µm at the slowest feed that helps", um(*error)));
    }
    if adjusted.above.len() > NAMED {
        printer.line(format!("warning: {} more moves stay above the tolerance", adjusted.above.len() - NAMED));
    }
}

fn feeds_json(adjusted: &Adjusted, goal: Goal) -> serde_json::Value {
    json!({
        "tolerance_um": goal.tolerance_mm * 1e3,
        "keep_time": goal.keep_time,
        "slower_moves": adjusted.moves.0,
        "faster_moves": adjusted.moves.1,
        "cycle_before_s": adjusted.cycle_s.0,
        "cycle_after_s": adjusted.cycle_s.1,
        "max_before_um": adjusted.max_mm.0 * 1e3,
        "max_after_um": adjusted.max_mm.1 * 1e3,
        "lines_above": adjusted.above.iter().map(|(line, error)| json!({ "line": line, "max_um": error * 1e3 })).collect::<Vec<_>>(),
    })
}

/// Where the model is out of its depth, with lines where there is a program.
fn warnings(part: Option<&Part>, outcome: &Outcome) -> Vec<String> {
    let period = outcome.reference.period_s();
    outcome
        .outside
        .iter()
        .map(|range| {
            let line = |k: usize| part.and_then(|part| part.line_at(k));
            let place = match (line(range.first), line(range.last)) {
                (Some(first), Some(last)) if first == last => format!("line {first}"),
                (Some(first), Some(last)) => format!("lines {first} to {last}"),
                _ => format!("t = {:.3} to {:.3} s", range.first as f64 * period, range.last as f64 * period),
            };
            if range.reason == Outside::Unplaced {
                let axis = &range.axis;
                return format!("the predictor of axis {axis} needs its position, which is not known without --work-offset; nothing is corrected");
            }
            let effect = match range.reason {
                Outside::Position if !range.fades => "what depends on the place is corrected less and less there",
                _ => "the correction fades there",
            };
            format!(
                "{place}: {} of axis {} lies outside what the model was trained on ({} samples); {effect}",
                range.reason, range.axis, range.samples
            )
        })
        .collect()
}

fn forecast(path: &Input, bundle: &models::Bundle, outcome: &Outcome) -> Result<PathReport> {
    use machine::Machine;
    let command = path.part.as_ref().and_then(|part| part.command.as_ref()).unwrap_or(path.desired.trajectory());
    let before = left_out::machine_for(bundle, path.part.as_ref())?.run(command)?;
    let series = vec![
        Series::of_program("uncompensated (forecast)", &path.desired, path.part.as_ref(), &before)?,
        Series::of_program("compensated (forecast)", &path.desired, path.part.as_ref(), &outcome.forecast)?,
    ];
    Ok(PathReport::new(&path.name, &path.desired, series))
}
