//! `precomp predict`: what the model expects of a path.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use datasets::Log;
use machine::Machine;
use serde_json::json;

use crate::cli::{Common, ProgramArgs};
use crate::expectation::Expectation;
use crate::files::Files;
use crate::left_out::{self, LeftOut};
use crate::output::{Outputs, Printer, table};
use crate::units::ErrorUnit;
use crate::{evaluate, input, travel};

/// Forecast the tracking and contour error of a path
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  precomp predict part.nc -m mill.model")]
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
}

impl Predict {
    pub fn files(&self) -> Files {
        Files::of(self.common.json.as_deref())
            .reads("INPUT", &*self.input)
            .reads("-m", &*self.model)
            .writes("-o", self.out.as_deref())
    }

    pub fn run(&self) -> Result<()> {
        let bundle = input::model(&self.model)?;
        let frame = input::Frame::of(&input::machine_of(&bundle)?)?;
        let path = input::Input::read(&self.input, &frame, &self.program)?;
        let reference = path.desired.trajectory();
        let actual = left_out::machine_for(&bundle, path.part.as_ref())?.run(reference)?;
        let figures = evaluate::figures(&path.desired, path.part.as_ref(), &actual)?;
        let errors = reference.tracking_error(&actual)?;
        let printer = Printer::new(self.common.json.as_deref());
        let left_out = LeftOut::of(&bundle, &path)?;
        left_out.iter().filter_map(LeftOut::in_words).chain(travel::unchecked(&path, &frame)).for_each(|line| printer.line(line));
        printer.line(format!("{}: {:.2} s; predicted {}", path.name, reference.duration_s(), evaluate::in_words(&figures)));
        let expected = Expectation::of(&bundle, &path.desired, path.part.as_ref(), reference, &actual)?;
        if let Some(expected) = &expected {
            printer.line(format!(
                "expected on the machine, the model's own error included: {}, nine runs in ten",
                expected.in_words()
            ));
        }
        let rows: Vec<Vec<String>> = reference
            .axes()
            .iter()
            .zip(&errors)
            .zip(&bundle.manifest.axes)
            .map(|((axis, error), known)| {
                let (rms, max) = evaluate::rms_max(error);
                let unit = ErrorUnit::from(axis);
                let known = format!("±{}", unit.number(2.0 * known.held_out.rms));
                vec![unit.label(&axis.name), unit.number(rms), unit.number(max), known]
            })
            .collect();
        printer.line(table(&["axis", "tracking error RMS", "MAX", "known to (95 %)"], &rows));
        let mut outputs = Outputs::default();
        if let Some(out) = &self.out {
            outputs.add_log(out, &Log::new(path.name.clone(), reference.clone(), actual.clone())?)?;
            printer.line(format!("forecast in {}", out.display()));
        }
        outputs.write(
            self.common.json.as_deref(),
            &json!({
                "contour_um": evaluate::contour_json(&figures.tip),
                "expected_contour_um": expected.map(|expected| expected.json()),
                "orientation_urad": evaluate::orientation_json(figures.orientation.as_ref()),
                "tracking_um": evaluate::tracking_json(reference, &actual)?,
                "left_out": left_out.map(|left_out| left_out.json()),
            }),
        )
    }
}
