//! `precomp predict`: what the model expects of a path.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use datasets::{Log, LogSpool, LongFile};
use machine::Machine;
use models::{AxisManifest, Bundle};
use motion::Axis;
use pipeline::statistics::{Figures, rms_max};
use pipeline::units::ErrorUnit;
use pipeline::{Columns, Expectation, PositionTerms, Setup, forecast, machine_for};
use serde_json::json;

use crate::args::{Common, ProgramArgs, ReportArgs};
use crate::files::Files;
use crate::kind::Kind;
use crate::output::{Outputs, table};
use crate::plot::PlotArgs;
use crate::print::compensation as print;
use crate::print::figures::{contour_json, orientation_json, text, tracking_figures_json, tracking_json};
use crate::progress::Shown;
use crate::read;
use crate::report::{Group, Run, Track, asked, known, sections};

/// Forecast the tracking and contour error of a path
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  precomp predict part.nc -m mill.model --report forecast.html")]
pub struct Predict {
    /// Part program, reference (.csv, .parquet) or test curve (`curve:NAME`)
    input: PathBuf,
    #[command(flatten)]
    common: Common,
    /// Model of the machine, from `precomp train`
    #[arg(short, long, value_name = "MODEL")]
    model: PathBuf,
    #[command(flatten)]
    program: ProgramArgs,
    /// Write the forecast as a log: `x_act` is the predicted actual position
    #[arg(short, long, value_name = "LOG")]
    out: Option<PathBuf>,
    #[command(flatten)]
    report: ReportArgs,
    #[command(flatten)]
    plot: PlotArgs,
}

impl Predict {
    pub fn files(&self) -> Files {
        Files::of(self.common.json.as_deref())
            .reads("INPUT", &*self.input)
            .reads("-m", &*self.model)
            .writes("-o", self.out.as_deref(), Kind::Table)
            .writes("--report", self.report.report.as_deref(), Kind::Report)
    }

    pub fn run(&self) -> Result<()> {
        let model = read::model(&self.model)?;
        let setup = Setup::of_model(&model)?;
        if self.report.report.is_none()
            && let Some(file) = read::long_reference(&self.input)?
            && self.run_long(&model, &setup, &file)?
        {
            return Ok(());
        }
        let input = read::input(&self.input, &setup, &self.program.settings(), self.program.feed)?;
        let reference = input.command();
        let actual = machine_for(&model, input.part())?.run(reference)?;
        let figures = input.figures(&actual)?;
        let terms = PositionTerms::of(&model, &input)?;
        let expected = Expectation::of(&model, &input, reference, &actual)?;

        let printer = self.common.printer();
        print::show_unknown(&printer, &input, &setup, terms.as_ref());
        print::show_read(&printer, &input, self.common.verbose);
        print::show_marked(&printer, &input);
        printer.line(format!("{}: {:.2} s; predicted {}", input.name(), reference.duration_s(), text(&figures)));
        if let Some(expected) = &expected {
            print::show_expectation(&printer, expected);
        }
        let figures_of = |error: &Vec<f64>| rms_max(error);
        let tracking: Vec<(f64, f64)> = reference.tracking_error(&actual)?.iter().map(figures_of).collect();
        printer.line(errors(&model, reference.axes(), &tracking));
        let mut outputs = Outputs::default();
        if let Some(out) = &self.out {
            outputs.add_log(out, &Log::new(input.name(), reference.clone(), actual.clone())?)?;
            printer.line(format!("forecast in {}", out.display()));
        }
        if self.plot.plot {
            let track = Track::of(&input);
            self.plot.show(&printer, &track, &[Run::of("forecast", &track, None, &actual)?]);
        }
        let title = format!("Forecast for {}", input.name());
        let lead = "What the model predicts for the program or reference as it is. Nothing was run on the machine.";
        self.report.add(&mut outputs, &printer, (&title, lead), || {
            let track = Track::of(&input);
            // The recorded command is the program's own, and no correction.
            let runs = [Run::of("forecast", &track, None, &actual)?];
            let mut all = sections(&track, &runs);
            all.extend([asked(&model, &input), known(&model)]);
            Ok(vec![Group { name: input.name().to_owned(), sections: all }])
        })?;
        outputs.write(
            self.common.json.as_deref(),
            &json!({
                "contour_um": contour_json(&figures.tip),
                "expected_contour_um": expected.as_ref().map(print::expectation_json),
                "expected_orientation_urad": print::expected_orientation_json(expected.as_ref()),
                "orientation_urad": orientation_json(figures.orientation.as_ref()),
                "tracking_um": tracking_json(reference, &actual)?,
                "left_out": terms.as_ref().map(print::position_terms_json),
            }),
        )
    }

    /// Forecasts a long reference in pieces; `false` where that cannot be done.
    fn run_long(&self, model: &Bundle, setup: &Setup, file: &LongFile) -> Result<bool> {
        let (printer, shown) = (self.common.printer(), Shown::default());
        let spool = |out: &PathBuf| LogSpool::new(out, file.axes(), file.period_s());
        let mut spool = self.out.as_ref().map(spool).transpose()?;
        let mut write = |[reference, actual]: Columns<'_>| match &mut spool {
            Some(spool) => Ok(spool.add(&reference, &actual)?),
            None => Ok(()),
        };
        let Some(found) = forecast(model, setup, file, None, &mut write, &|event| shown.event(event))? else {
            return Ok(false);
        };
        drop(shown);
        let figures = Figures { tip: found.contour, orientation: None };
        let name = self.input.file_name().unwrap_or_default().to_string_lossy();
        printer.line(format!("{name}: {:.2} s; predicted {}", found.duration_s, text(&figures)));
        if let Some(expected) = &found.expected {
            print::show_expectation(&printer, expected);
        }
        printer.line(errors(model, &found.axes, &found.tracking));
        let mut outputs = Outputs::default();
        if let (Some(out), Some(spool)) = (&self.out, spool) {
            outputs.add_spool(spool.finish()?);
            printer.line(format!("forecast in {}", out.display()));
        }
        outputs.write(
            self.common.json.as_deref(),
            &json!({
                "contour_um": contour_json(&figures.tip),
                "expected_contour_um": found.expected.as_ref().map(print::expectation_json),
                "orientation_urad": orientation_json(None),
                "tracking_um": tracking_figures_json(&found.axes, &found.tracking),
                "left_out": null,
            }),
        )?;
        Ok(true)
    }
}

/// The tracking error of every axis, and how well it is known.
fn errors(model: &Bundle, axes: &[Axis], figures: &[(f64, f64)]) -> String {
    let row = |((axis, (rms, max)), known): ((&Axis, &(f64, f64)), &AxisManifest)| {
        let unit = ErrorUnit::from(axis);
        let known = format!("±{}", unit.number(2.0 * known.held_out.rms));
        vec![unit.label(&axis.name), unit.number(*rms), unit.number(*max), known]
    };
    let rows: Vec<Vec<String>> = axes.iter().zip(figures).zip(&model.manifest.axes).map(row).collect();
    table(&["axis", "tracking error RMS", "MAX", "known to (95 %)"], &rows)
}
