//! `precomp compensate`: the main job.

mod effort;
mod feeds;
mod figures;
mod long;
mod page;

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use compensation::CorrectionLimits;
use gcode::{Distance, Move, Shiftable};
use machine::MachineSpec;
use models::Bundle;
use pipeline::control::is_replanned;
use pipeline::feed_adjustment::Adjusted;
use pipeline::measure::Readback;
use pipeline::model_based_ilc::{LawName, Outcome, Settings};
use pipeline::training::check_machine;
use pipeline::{
    Expectation, Input, Output, OutputFormat, OutputSettings, Part, PositionTerms, as_recorded, is_plan_guessed, model_based_ilc,
};
use serde_json::{Value, json};

use crate::args::{Common, LawArg, LogArgs, OutputArgs, ProgramArgs, ReportArgs, parse_not_negative};
use crate::files::Files;
use crate::kind::Kind;
use crate::numbers;
use crate::output::{Outputs, Printer, Usage};
use crate::output_format;
use crate::plot::PlotArgs;
use crate::print::compensation as print;
use crate::print::control;
use crate::print::measurement::readback_json;
use crate::print::program;
use crate::print::written::{self, Shares};
use crate::read::{self, Source};
use crate::report::{Forecasts, Track};

pub use effort::Effort;
pub use feeds::{Chosen, FeedArgs};
pub(super) use figures::merged;
use figures::outcome_json;
use page::before_and_after;
pub(super) use page::forecast;

/// Shift a part program's (or reference's) points so that the machine cuts the path that it asks for
///
/// Only points of feed moves change. The output is read again and compared with what was meant before it is written.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  precomp compensate part.nc -m mill.model -o compensated.nc --report forecast.html
  precomp compensate reference.csv -m mill.model -o compensated.csv
  precomp compensate part.nc -m mill.model -o compensated.nc --reference run-of-part.log
  precomp compensate part.nc -m mill.model -o compensated.nc --tolerance 5um --fastest --may-exceed-feed 100
  precomp compensate part.nc -m mill.model -o setpoints.csv --format pvt --spacing 5")]
pub struct Compensate {
    /// Part program (G-code or Heidenhain dialogue) or reference (.csv, .parquet)
    input: PathBuf,
    #[command(flatten)]
    common: Common,
    /// Model of the machine, from `precomp train`
    #[arg(short, long, value_name = "MODEL")]
    model: PathBuf,
    /// The file to write, of the same kind as INPUT; a table (.csv) with `--format table` or `pvt`
    #[arg(short, long, value_name = "OUT")]
    out: PathBuf,
    #[command(flatten)]
    program: ProgramArgs,
    #[command(flatten)]
    output: OutputArgs,
    /// How the reference is learned on the model
    #[arg(long, value_enum, default_value = "model-based")]
    law: LawArg,
    /// How much time the search may take
    #[arg(long, value_enum, default_value = "normal")]
    effort: Effort,
    /// Rounds of updates on the model, instead of those of --effort: one of `fast`, four of `normal`, eight of `best`. A round has up to eight runs of the model; a
    /// replanned program gets up to three times as many rounds more
    #[arg(long, value_parser = crate::numbers::iterations, conflicts_with = "effort")]
    iterations: Option<usize>,
    /// Largest shift of the tool tip, mm. When left out: twice the largest error of the uncompensated forecast, from 0.1 to 1 mm
    #[arg(long, value_name = "MM", value_parser = parse_not_negative)]
    max_shift: Option<f64>,
    /// Largest correction of the tool's direction on a machine that turns tool or workpiece, degrees
    #[arg(long, alias = "max-turn", value_name = "DEG", default_value_t = CorrectionLimits::MAX_ROTATION_DEG, value_parser = parse_not_negative)]
    max_rotation: f64,
    /// Refuse a program with moves that would be left alone because it does not say enough: codes that are not understood, values of run
    /// time, blocks that may be skipped, starts that are not stated
    #[arg(long)]
    strict: bool,
    /// Largest increase of the cycle time by the compensated program, percent. When left out: 1, and no limit with --format or --spacing
    #[arg(long, value_name = "PERCENT", value_parser = numbers::percent)]
    cycle_limit: Option<f64>,
    /// Come to stops at the program's own feed, also where a slower end would lower the predicted error
    #[arg(long)]
    keep_stops: bool,
    #[command(flatten)]
    feeds: FeedArgs,
    /// Limits of this machine instead of those in the model: a TOML file, a built-in one, or random:SEED
    #[arg(long, value_name = "TOML")]
    machine: Option<String>,
    /// Log of an uncompensated run of INPUT: its command, changed as the compensated points change the plan, takes the place of the plan where the
    /// control does otherwise, and gives the work offset
    #[arg(long, value_name = "LOG", conflicts_with_all = ["tolerance", "max_time", "pareto"])]
    reference: Option<PathBuf>,
    #[command(flatten)]
    columns: LogArgs,
    #[command(flatten)]
    report: ReportArgs,
    #[command(flatten)]
    plot: PlotArgs,
}

impl Compensate {
    pub fn files(&self) -> Files {
        Files::of(self.common.json.as_deref())
            .reads("INPUT", &*self.input)
            .reads("-m", &*self.model)
            .reads_machine(self.machine.as_deref())
            .reads_controller(self.output.controller.as_deref())
            .reads_logs("--reference", self.reference.as_ref())
            .writes("-o", &*self.out, Kind::Path)
            .writes("--report", self.report.report.as_deref(), Kind::Report)
    }

    pub fn run(&self) -> Result<()> {
        // Among the threads that share the work: whoever waits for a part does another one meanwhile.
        rayon::scope(|_| self.compensate())
    }

    fn compensate(&self) -> Result<()> {
        self.feeds.check()?;
        let printer = self.common.printer();
        let (model, source) = rayon::join(|| read::model(&self.model), || Source::open(&self.input));
        let (model, source) = (model?, source?);
        let setup = self.output.setup(&self.machine(&model)?)?;
        let format = self.output.settings(&setup);
        if let Some(long) = self.long(&source, &setup, &format)? {
            return self.compensate_long(&long, &model, &setup, &format, &printer);
        }
        let input = source.on(&setup, &self.program.settings(), self.program.feed)?;
        output_format::check(&format, &input, &self.out)?;
        if let Some(part) = input.part().filter(|_| self.strict) {
            part.check_understood()?;
        }
        let (input, record) = self.recorded(input, &model, &format, &printer)?;
        if let Some(part) = input.part().filter(|_| self.program.dialect.is_none() && setup.dialect.is_none()) {
            program::show_dialect(&printer, &part.program, &part.options);
        }
        let terms = PositionTerms::of(&model, &input)?;
        print::show_unknown(&printer, &input, &setup, terms.as_ref());

        let forecasts = Forecasts::default();
        let Learned { input, outcome, feeds } = self.learn(input, &model, &format, &forecasts, &printer)?;
        show_kept_feeds(&outcome, &format, &printer);
        show_increments(&input, &outcome, &format, &printer)?;
        let guessed = self.machine.is_none() && is_plan_guessed(&model, &input, format.program());
        self.show_control(&model, is_planned(&input), &printer);
        let output = outcome.write(&input, &format, &self.out)?;
        let (expected, covers) = Expectation::of_written(&model, &input, &outcome, &output.content, guessed)?;
        if guessed {
            printer.line(control::control_unknown(covers));
        }
        print::show(&printer, &input, &outcome, expected.as_ref(), self.common.verbose);

        self.show_output(&output, &outcome, &printer);
        if input.part().is_none() {
            printer.line(written::UNITS);
        }
        let lines = input.part().map(|part| (line_count(part.program.bytes()), line_count(&output.content)));
        if let (Some(part), Some(lines), None) = (input.part(), lines, &output.setpoints) {
            let points = outcome.written.map(|points| (points, points));
            let slow_stop = outcome.written.and_then(|written| written.slow_stop);
            printer.line(written::summary(&shares(part, &outcome), points, slow_stop, lines));
        }
        let mut outputs = Outputs::default();
        let mut figures = outcome_json(LawName::from(self.law), &input, &outcome, &output, expected.as_ref());
        if let (Some(warning), Some(warnings)) =
            (record.as_ref().and_then(|record| record.warning.as_ref()), figures["warnings"].as_array_mut())
        {
            warnings.push(json!(warning));
        }
        outputs.add(&self.out, output.content);
        if self.plot.plot {
            let track = Track::of(&input);
            self.plot.show(&printer, &track, &before_and_after(&track, &outcome)?);
        }
        let title = format!("Forecast for {}", input.name());
        self.report.add(&mut outputs, &printer, (&title, LEAD), || forecast(&input, &outcome, &model, &forecasts))?;
        let beside = json!({
            "feeds": feeds,
            "left_out": terms.as_ref().map(print::position_terms_json),
            "reference": record.as_ref().map(|record| readback_json(&record.readback)),
            "program": input.part().zip(lines).map(|(part, lines)| written::summary_json(part, &outcome, lines)),
        });
        outputs.write(self.common.json.as_deref(), &merged(figures, beside))
    }

    /// The machine that limits and control are those of.
    fn machine(&self, model: &Bundle) -> Result<MachineSpec> {
        match &self.machine {
            Some(machine) => {
                let spec = read::machine(machine)?;
                check_machine(model, &spec)?;
                Ok(spec)
            }
            None => Ok(pipeline::machine_of(model)?),
        }
    }

    /// What is known of the control that plans.
    fn show_control(&self, model: &Bundle, is_planned: bool, printer: &Printer) {
        let learned = model.manifest.control.as_ref().filter(|_| is_planned);
        if let Some(machine) = &self.machine {
            learned.iter().for_each(|_| printer.line(control::control_unused(machine)));
            return;
        }
        if model.manifest.limits_from_log {
            printer.line(control::LIMITS_FROM_LOG);
        }
        learned.iter().for_each(|control| printer.line(control::control_fidelity(control)));
    }

    /// The input as it is to be written; with --reference as the control ran it.
    fn recorded(
        &self,
        mut input: Input,
        model: &Bundle,
        format: &OutputSettings,
        printer: &Printer,
    ) -> Result<(Input, Option<Record>)> {
        if let Some(part) = input.part_mut() {
            format.prepare(part);
        }
        let Some(log) = &self.reference else {
            if self.columns.columns.is_some() || self.columns.period.is_some() {
                return Err(Usage("--columns and --period say how the log of --reference is read; there is none".into()).into());
            }
            return Ok((input, None));
        };
        if input.part().is_none() {
            return Err(Usage("--reference goes with a part program: a reference is the command itself".into()).into());
        }
        let log = read::log_to_measure(log, &self.columns.options(), printer)?;
        let recorded = as_recorded(input, model, &log)?;
        control::recorded(&recorded).into_iter().for_each(|line| printer.line(line));
        let replans = recorded.input.part().zip(format.program()).is_some_and(|(part, written)| is_replanned(part, written));
        let warning = control::recorded_warning(&recorded, replans);
        warning.iter().for_each(|warning| printer.line(format!("warning: {warning}")));
        Ok((recorded.input, Some(Record { readback: recorded.readback, warning })))
    }

    fn settings(&self) -> Settings {
        Settings {
            law: self.law.into(),
            iterations: self.iterations.unwrap_or(self.effort.updates()),
            worth: self.effort.worth(),
            tries_larger_limit: self.effort.tries_larger_limit(),
            max_shift: self.max_shift,
            max_rotation_rad: self.max_rotation.to_radians(),
            slow_stops: !self.keep_stops,
            ..self.output.learning(self.cycle_limit)
        }
    }

    /// Learns the reference, and the feeds where they may change.
    fn learn(
        &self,
        input: Input,
        model: &Bundle,
        format: &OutputSettings,
        forecasts: &Forecasts,
        printer: &Printer,
    ) -> Result<Learned> {
        let settings = Settings { written: format.program().filter(|_| input.part().is_some()), ..self.settings() };
        let shown = self.common.shown();
        let progress = |event: pipeline::Event<'_>| {
            forecasts.note(event);
            shown.event(event)
        };
        if !self.feeds.is_used() {
            let outcome = model_based_ilc(&input, model, &settings, &progress)?;
            return Ok(Learned { input, outcome, feeds: Value::Null });
        }
        let Input::Program(part) = input else {
            let why =
                "--tolerance, --max-time and --pareto change feeds: only part programs have them, references carry their time";
            return Err(Usage(why.into()).into());
        };
        let (chosen, feeds) = self.feeds.choose(*part, model, &settings, printer, &progress)?;
        match chosen {
            Chosen::Adjusted(adjusted) => {
                let Adjusted { input, outcome, .. } = *adjusted;
                Ok(Learned { input, outcome, feeds })
            }
            Chosen::Same(part) => {
                let input = Input::Program(part);
                let outcome = model_based_ilc(&input, model, &settings, &progress)?;
                Ok(Learned { input, outcome, feeds })
            }
        }
    }

    fn show_output(&self, output: &Output, outcome: &Outcome, printer: &Printer) {
        printer.line(written::written(output.largest_shift_mm, &self.out));
        if outcome.gained && output.largest_shift_mm > AT_BOUND * outcome.max_shift {
            printer.line(print::cut_off(outcome.max_shift));
        }
        output.setpoints.iter().flat_map(written::setpoints).for_each(|line| printer.line(line));
    }
}

/// Whether precomp itself plans what the control will command.
fn is_planned(input: &Input) -> bool {
    input.part().is_some_and(|part| part.recording.is_none())
}

/// Says with which decimals increments are written where nobody states them: with more, the rounding of a control that resolves less would add up.
fn show_increments(input: &Input, outcome: &Outcome, format: &OutputSettings, printer: &Printer) -> Result<()> {
    let Some((part, settings)) = input.part().zip(format.program()).filter(|_| outcome.gained) else { return Ok(()) };
    let Some(decimals) = settings.suited_to(part)?.increment_decimals else { return Ok(()) };
    let is_increment =
        |step: &&Move| step.shiftable == Shiftable::Yes && part.toolpath.modal(step).distance == Distance::Incremental;
    if let Some(step) = part.toolpath.moves.iter().find(is_increment) {
        printer.line(format!(
            "note: increments (G91, from line {}) are written with {decimals} decimals (mm; one more in inches), as most controls resolve them; \
             --decimals or --controller states more",
            step.block + 1
        ));
    }
    Ok(())
}

/// Reports where the program keeps its feeds because timed points would lengthen the cycle too much.
fn show_kept_feeds(outcome: &Outcome, format: &OutputSettings, printer: &Printer) {
    if let (true, Some(slowdown), OutputFormat::Program(encoding)) = (outcome.gained, outcome.kept_feeds, format.format) {
        printer.line(format!(
            "note: with the time of every point the cycle would take {:.1} % longer; the program keeps its feeds instead (--format {} states the times)",
            100.0 * slowdown,
            encoding.name()
        ));
    }
}

/// What was found of a recorded run.
struct Record {
    readback: Readback,
    warning: Option<String>,
}

/// A reference, and the input that it was learned for: with its feeds where these were changed.
struct Learned {
    input: Input,
    outcome: Outcome,
    feeds: Value,
}

/// What became of the feed length of a program.
fn shares(part: &Part, outcome: &Outcome) -> Shares {
    let without = part.share(outcome.without_gain.iter().map(|left| left.length_mm).sum());
    let left_alone = part.fixed_share();
    Shares { without_gain: if outcome.gained { without } else { 1.0 - left_alone }, left_alone }
}

/// Number of lines, which end with LF, CR LF or CR.
fn line_count(bytes: &[u8]) -> usize {
    let is_end = |k: usize| bytes[k] == b'\n' || (bytes[k] == b'\r' && bytes.get(k + 1) != Some(&b'\n'));
    let is_open = bytes.last().is_some_and(|last| !b"\r\n".contains(last));
    (0..bytes.len()).filter(|k| is_end(*k)).count() + usize::from(is_open)
}

/// Share of its bound from which on a correction counts as cut off by it.
pub const AT_BOUND: f64 = 0.99;

/// What the page shows.
const LEAD: &str =
    "What the model predicts for the program as it is, and for the compensated one. Nothing was run on the machine.";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_with_any_of_three_endings() {
        for text in ["A\nB\nC", "A\r\nB\r\nC\r\n", "A\rB\rC\r", "A\rB\r\nC\n"] {
            assert_eq!(line_count(text.as_bytes()), 3, "{text:?}");
        }
        assert_eq!(line_count(b""), 0);
    }
}
