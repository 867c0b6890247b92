//! The main job: compensated programs and references.

use std::path::{Path, PathBuf};

use anyhow::Result;
use datasets::{Log as Recorded, reference_content};
use models::Bundle;
use motion::Trajectory;
use numpy::{PyArray1, PyArray2};
use pipeline::feed_adjustment::Adjusted;
use pipeline::model_based_ilc::{LawName, Outcome, Settings};
use pipeline::windows::{Joined, LongProgram};
use pipeline::{
    Expectation, Input, OutputSettings, PositionTerms, Progress, Setup, as_recorded, is_control_unknown, is_plan_guessed,
    model_based_ilc,
};
use precomp::Chosen;
use precomp::output::{Printer, Usage};
use precomp::print::control::{LIMITS_FROM_LOG, control_fidelity, control_unknown, recorded as print_recorded};
use precomp::print::figures::{contour_json, orientation_json};
use precomp::print::measurement::readback_json;
use precomp::print::{compensation as print, program, written};
use precomp::read::Source;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde_json::{Value, json};

use crate::contour::{errors_mm, micrometres};
use crate::errors::OrRaise;
use crate::log;
use crate::options::CompensateOptions;
use crate::report::Report;
use crate::{arrays, json as objects};

/// What was written.
pub enum Content {
    /// A program, or a table of setpoints.
    Text(Vec<u8>),
    /// A reference.
    Reference(Trajectory),
}

/// The paths of a compensation, all in the time of the desired one.
struct Paths {
    desired: Trajectory,
    reference: Trajectory,
    forecast: Trajectory,
    uncompensated: Trajectory,
    /// Contour error of every sample before and after, mm.
    errors_mm: [Vec<f64>; 2],
}

/// A compensated path.
#[pyclass(frozen, module = "precomp")]
pub struct Compensated {
    pub name: String,
    pub content: Content,
    is_changed: bool,
    /// None of a long program, which is compensated in windows.
    paths: Option<Paths>,
    report: Report,
}

impl Compensated {
    fn array<'py>(&self, py: Python<'py>, of: impl Fn(&Paths) -> &Trajectory) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        self.paths.as_ref().map(|paths| arrays::array(py, of(paths))).transpose()
    }

    fn errors<'py>(&self, py: Python<'py>, index: usize) -> Option<Bound<'py, PyArray1<f64>>> {
        Some(micrometres(py, &self.paths.as_ref()?.errors_mm[index]))
    }
}

#[pymethods]
impl Compensated {
    /// Name of the path.
    #[getter]
    fn name(&self) -> &str {
        &self.name
    }

    /// The compensated program, or the table of setpoints; `None` where the input was a reference.
    #[getter]
    fn text(&self) -> Option<String> {
        match &self.content {
            Content::Text(text) => Some(String::from_utf8_lossy(text).into_owned()),
            Content::Reference(_) => None,
        }
    }

    /// The bytes that [`save`](Self::save) writes; of a reference those of a CSV file.
    #[getter]
    fn content<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        Ok(match &self.content {
            Content::Text(text) => PyBytes::new(py, text),
            Content::Reference(reference) => {
                PyBytes::new(py, &reference_content(Path::new("reference.csv"), reference).or_raise()?)
            }
        })
    }

    /// Whether anything was changed: where the model predicts no gain, the input comes back as it was.
    #[getter]
    fn changed(&self) -> bool {
        self.is_changed
    }

    /// Names of the axes.
    #[getter]
    fn axes(&self) -> Option<Vec<String>> {
        self.paths.as_ref().map(|paths| arrays::names(paths.desired.axes()))
    }

    /// Instants of the samples of the desired path, s.
    #[getter]
    fn time_s<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        Some(arrays::times(py, &self.paths.as_ref()?.desired))
    }

    /// Desired positions, mm or rad. `None` of a program of more than two minutes, which is compensated in windows; so are the other arrays.
    #[getter]
    fn desired<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        self.array(py, |paths| &paths.desired)
    }

    /// Compensated positions, mm or rad.
    #[getter]
    fn reference<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        self.array(py, |paths| &paths.reference)
    }

    /// Predicted actual positions with compensation, mm or rad.
    #[getter]
    fn forecast<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        self.array(py, |paths| &paths.forecast)
    }

    /// Predicted actual positions without compensation, mm or rad.
    #[getter]
    fn uncompensated<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        self.array(py, |paths| &paths.uncompensated)
    }

    /// Predicted contour error of every sample without compensation, µm; rapids included, which the figures leave out.
    #[getter]
    fn error_before_um<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        self.errors(py, 0)
    }

    /// The same with compensation, µm.
    #[getter]
    fn error_after_um<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        self.errors(py, 1)
    }

    /// The figures that the command writes by `--json`.
    #[getter]
    fn figures<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        objects::object(py, &self.report.figures)
    }

    /// What the command prints.
    #[getter]
    fn report(&self) -> String {
        self.report.text()
    }

    /// The lines of the report that warn, or say what is not known.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.report.warnings()
    }

    /// Writes the program, table or reference: the bytes that the command writes. Complete or not at all.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        let content = match &self.content {
            Content::Text(text) => text.clone(),
            Content::Reference(reference) => reference_content(&path, reference).or_raise()?,
        };
        log::write(path, content)
    }
}

/// What a compensation is made of.
pub struct Job<'a> {
    pub model: &'a Bundle,
    pub setup: Setup,
    pub options: &'a CompensateOptions,
    /// Log of an uncompensated run of the program, whose command replaces the plan.
    pub recorded: Option<Recorded>,
    /// Whether the machine is the model's own.
    pub own_machine: bool,
}

impl Job<'_> {
    /// Compensates a path, as the command `compensate` does.
    pub fn compensate(&self, source: Source, progress: Progress<'_>) -> Result<Compensated> {
        let format = self.options.output.settings(&self.setup);
        let printer = Printer::keeping();
        if let Some(long) = self.long(&source, &format)? {
            return self.long_program(&long, &format, printer, progress);
        }
        let input = source.on(&self.setup, &self.options.program.settings(), self.options.program.feed)?;
        if let (Some(written), Some(part)) = (format.program(), input.part()) {
            written.suited_to(part)?;
        }
        if let Some(part) = input.part().filter(|_| self.options.strict) {
            part.check_understood()?;
        }
        let (input, read_back) = self.in_recorded_time(input, &format, &printer)?;
        if let Some(part) = input.part().filter(|_| self.options.program.dialect.is_none() && self.setup.dialect.is_none()) {
            program::show_dialect(&printer, &part.program, &part.options);
        }
        let terms = PositionTerms::of(self.model, &input)?;
        print::show_unknown(&printer, &input, &self.setup, terms.as_ref());
        let (input, outcome, feeds) = self.learn(input, &format, &printer, progress)?;
        let guessed = self.own_machine && is_plan_guessed(self.model, &input, format.program());
        self.show_limits(&printer, self.recorded.is_none() && input.part().is_some());
        let output = outcome.write(&input, &format, Path::new("reference.csv"))?;
        let (expected, covers) = Expectation::of_written(self.model, &input, &outcome, &output.content, guessed)?;
        if guessed {
            printer.line(control_unknown(covers));
        }
        print::show(&printer, &input, &outcome, expected.as_ref(), false);
        let content = match (input.part(), &output.setpoints) {
            (None, None) => Content::Reference(outcome.reference.clone()),
            _ => Content::Text(output.content),
        };
        let setpoints = output.setpoints.as_ref().map(written::setpoints_json);
        if outcome.gained && output.largest_shift_mm > precomp::AT_BOUND * outcome.max_shift {
            printer.line(print::cut_off(outcome.max_shift));
        }
        output.setpoints.iter().flat_map(written::setpoints).for_each(|line| printer.line(line));
        let figures = json!({
            "changed": outcome.gained,
            "law": LawName::from(self.options.law),
            "updates": outcome.updates,
            "ended": outcome.ended.map(|ended| ended.to_string()),
            "largest_shift_um": output.largest_shift_mm * 1e3,
            "predicted_contour_um": { "before": contour_json(&outcome.before.tip), "after": contour_json(&outcome.after.tip) },
            "predicted_orientation_urad": {
                "before": orientation_json(outcome.before.orientation.as_ref()),
                "after": orientation_json(outcome.after.orientation.as_ref()),
            },
            "expected_contour_um": expected.as_ref().map(print::expectation_json),
            "expected_orientation_urad": print::expected_orientation_json(expected.as_ref()),
            "left_alone": input.part().map(|part| json!({ "moves": part.fixed_moves(), "feed_length_share": part.fixed_share() })),
            "cycle_s": outcome.cycle_s.map(|(before, after)| json!({ "before": before, "after": after })),
            "format": output.format.filter(|_| outcome.gained || output.setpoints.is_some()),
            "setpoints": setpoints,
            "warnings": print::warnings(input.part(), &outcome),
            "feeds": feeds,
            "left_out": terms.as_ref().map(print::position_terms_json),
            "reference": read_back,
            "program": input.part().zip(lines(&input, &content)).map(|(part, lines)| written::summary_json(part, &outcome, lines)),
        });
        let name = input.name().to_owned();
        let is_changed = outcome.gained;
        let paths = Some(paths(&input, outcome)?);
        Ok(Compensated { name, content, is_changed, paths, report: Report::new(figures, printer) })
    }

    /// The program, where it is compensated in windows; the same ones as on the command line.
    fn long(&self, source: &Source, format: &OutputSettings) -> Result<Option<LongProgram>> {
        let options = self.options;
        let whole = options.feeds.is_used() || self.recorded.is_some() || options.strict;
        if whole || format.program().is_none() || LawName::from(options.law) != LawName::ModelBased {
            return Ok(None);
        }
        source.long(&self.setup, &options.program.settings())
    }

    fn long_program(
        &self,
        long: &LongProgram,
        format: &OutputSettings,
        printer: Printer,
        progress: Progress<'_>,
    ) -> Result<Compensated> {
        let whole = long.whole();
        if self.options.program.dialect.is_none() && self.setup.dialect.is_none() {
            program::show_dialect(&printer, &whole.program, &whole.options);
        }
        self.show_limits(&printer, true);
        if self.own_machine && is_control_unknown(self.model) {
            printer.line(control_unknown(false));
        }
        let joined = long.compensate(self.model, &self.options.settings(), format, progress)?;
        let how = format!("{} windows, up to {} updates on the model", joined.windows(), joined.updates);
        printer.line(print::forecast(" over feed moves", &joined.before()?, &joined.after()?, &how));
        printer.line(print::cycle(joined.cycle_s));
        if joined.gained && joined.largest_shift_mm > precomp::AT_BOUND * joined.max_shift {
            printer.line(print::cut_off(joined.max_shift));
        }
        let figures = joined_json(&joined, self.options.law.into())?;
        let name = whole.name.clone();
        let is_changed = joined.gained;
        let content = Content::Text(joined.content);
        Ok(Compensated { name, content, is_changed, paths: None, report: Report::new(figures, printer) })
    }

    /// The input as it is to be written; with a recorded run in its time, with what the control commanded in it, and how the two agree.
    fn in_recorded_time(&self, mut input: Input, format: &OutputSettings, printer: &Printer) -> Result<(Input, Option<Value>)> {
        if let Some(part) = input.part_mut() {
            format.prepare(part);
        }
        let Some(log) = &self.recorded else { return Ok((input, None)) };
        if input.part().is_none() {
            return Err(Usage("reference goes with a part program: a reference is the command itself".into()).into());
        }
        let recorded = as_recorded(input, self.model, log)?;
        print_recorded(&recorded).into_iter().for_each(|line| printer.line(line));
        Ok((recorded.input, Some(readback_json(&recorded.readback))))
    }

    /// Learns the reference, and the feeds where they may change.
    fn learn(
        &self,
        input: Input,
        format: &OutputSettings,
        printer: &Printer,
        progress: Progress<'_>,
    ) -> Result<(Input, Outcome, Value)> {
        let settings = Settings { written: format.program().filter(|_| input.part().is_some()), ..self.options.settings() };
        self.options.feeds.check()?;
        if !self.options.feeds.is_used() {
            let outcome = model_based_ilc(&input, self.model, &settings, progress)?;
            return Ok((input, outcome, Value::Null));
        }
        let Input::Program(part) = input else {
            let why = "tolerance, max_time and pareto change feeds: only part programs have them, references carry their time";
            return Err(Usage(why.into()).into());
        };
        let (chosen, feeds) = self.options.feeds.choose(*part, self.model, &settings, printer, progress)?;
        match chosen {
            Chosen::Adjusted(adjusted) => {
                let Adjusted { input, outcome, .. } = *adjusted;
                Ok((input, outcome, feeds))
            }
            Chosen::Same(part) => {
                let input = Input::Program(part);
                let outcome = model_based_ilc(&input, self.model, &settings, progress)?;
                Ok((input, outcome, feeds))
            }
        }
    }

    fn show_limits(&self, printer: &Printer, is_planned: bool) {
        if self.model.manifest.limits_from_log && self.own_machine {
            printer.line(LIMITS_FROM_LOG);
        }
        if let Some(control) = self.model.manifest.control.as_ref().filter(|_| self.own_machine && is_planned) {
            printer.line(control_fidelity(control));
        }
    }
}

fn paths(input: &Input, outcome: Outcome) -> Result<Paths> {
    let Outcome { reference, forecast, uncompensated, .. } = outcome;
    let errors_mm = [errors_mm(input.desired(), &uncompensated)?, errors_mm(input.desired(), &forecast)?];
    Ok(Paths { desired: input.trajectory().clone(), reference, forecast, uncompensated, errors_mm })
}

/// Number of lines of the program before and after.
fn lines(input: &Input, content: &Content) -> Option<(usize, usize)> {
    let count = |bytes: &[u8]| bytes.split_inclusive(|byte| *byte == b'\n').count();
    match content {
        Content::Text(text) => Some((count(input.part()?.program.bytes()), count(text))),
        Content::Reference(_) => None,
    }
}

fn joined_json(joined: &Joined<'_>, law: LawName) -> Result<Value> {
    let share = |length_mm: f64| if joined.feed_mm > 0.0 { length_mm / joined.feed_mm } else { 0.0 };
    Ok(json!({
        "changed": joined.gained,
        "law": law,
        "windows": joined.windows(),
        "updates": joined.updates,
        "largest_shift_um": joined.largest_shift_mm * 1e3,
        "predicted_contour_um": { "before": contour_json(&joined.before()?), "after": contour_json(&joined.after()?) },
        "expected_contour_um": joined.expectation().as_ref().map(print::expectation_json),
        "expected_orientation_urad": print::expected_orientation_json(joined.expectation().as_ref()),
        "left_alone": { "moves": joined.fixed, "feed_length_share": share(joined.fixed_mm) },
        "cycle_s": { "before": joined.cycle_s.0, "after": joined.cycle_s.1 },
        "format": joined.points.map(|(finest, _)| finest.encoding),
    }))
}
