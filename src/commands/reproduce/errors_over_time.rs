//! Paper D, figures 13 to 15: tracking and contour errors over time, measured and predicted.

use anyhow::{Context, Result};
use machine::{Machine, MachineSpec, SimulatedMachine};
use models::Bundle;
use motion::Trajectory;
use pipeline::compare::KeptRun;
use pipeline::model_based_ilc::{LawName, Settings};
use pipeline::statistics::contour_errors;
use pipeline::{Input, SILENT, model_based_ilc};

use super::Reproduce;
use super::picture::{Line, Panel, Picture, draw};

const TIME: &str = "t, s";
const ERROR: &str = "error, µm";

/// Tracking error of the X axis of the butterfly, and what each set of features leaves of it; mm.
pub(super) fn figure_13(period_s: f64, measured: &[f64], missed: &[(String, Vec<f64>)]) -> Picture {
    let um = |values: &[f64]| values.iter().map(|value| value * 1e3).collect::<Vec<f64>>();
    let panel = |title: &str, line| Panel { title: title.into(), axes: (TIME, ERROR), is_path: false, lines: vec![line] };
    let mut panels = vec![panel("tracking error of X", Line::over_time("measured", period_s, &um(measured)))];
    for (name, missed) in missed {
        panels.push(panel(name, Line::over_time("predicted less measured", period_s, &um(missed))));
    }
    Picture {
        file: "d-figure-13",
        caption: "Figure 13: tracking error of the X axis on the butterfly, and the error of its prediction from three sets of features".into(),
        svg: draw(2, &panels),
    }
}

impl Reproduce {
    /// Errors on one curve with the paper's network (figure 14), and the contour error left by every compensation (figure 15).
    pub(super) fn figures_14_and_15(
        &self,
        spec: &MachineSpec,
        bundle: &Bundle,
        path: &Input,
        ilc: Option<&KeptRun>,
    ) -> Result<Vec<Picture>> {
        let reference = path.trajectory();
        let period_s = reference.period_s();
        let mut machine = SimulatedMachine::new(spec, self.common.seed.wrapping_add(500))?;
        let actual = machine.run(reference)?;
        let one_shot = Settings { law: LawName::OneShot, ..Settings::default() };
        let compensated = machine.run(&model_based_ilc(path, bundle, &one_shot, SILENT)?.reference)?;
        let measured = reference.tracking_error(&actual)?;
        let mut learned = bundle.machine()?;
        let predicted = learned.tracking_errors(reference).context("the model")?;
        let contour_um = |run: &Trajectory| -> Result<Vec<f64>> {
            Ok(contour_errors(path.desired(), run)?.iter().map(|error| error.magnitude_mm * 1e3).collect())
        };
        let (contour, expected) = (contour_um(&actual)?, contour_um(&learned.run(reference)?)?);
        let with = contour_um(&compensated)?;
        let line = |name, values: &[f64]| Line::over_time(name, period_s, values);
        let panel = |title: String, lines| Panel { title, axes: (TIME, ERROR), is_path: false, lines };
        let um = |values: &[f64]| values.iter().map(|value| value * 1e3).collect::<Vec<f64>>();
        let off = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<f64>>();
        let axes = || reference.axes().iter().zip(measured.iter().zip(&predicted));
        let mut panels: Vec<Panel> = axes()
            .map(|(axis, (measured, predicted))| {
                let lines = vec![line("measured", &um(measured)), line("predicted", &um(predicted))];
                panel(format!("tracking error of {}", axis.name.to_uppercase()), lines)
            })
            .collect();
        panels.extend(axes().map(|(axis, (measured, predicted))| {
            let lines = vec![line("predicted less measured", &um(&off(predicted, measured)))];
            panel(format!("prediction error of {}", axis.name.to_uppercase()), lines)
        }));
        panels.push(panel("contour error".into(), vec![line("measured", &contour), line("predicted", &expected)]));
        let missed = line("predicted less measured", &off(&expected, &contour));
        panels.push(panel("prediction error of the contour error".into(), vec![missed]));
        panels.push(panel("contour error".into(), vec![line("measured", &contour), line("pre-compensated", &with)]));
        let mut methods = vec![line("uncompensated", &contour), line("pre-compensated", &with)];
        if let Some(ilc) = ilc {
            methods.push(line("converged ILC", &contour_um(&ilc.actual)?));
        }
        let name = path.name();
        Ok(vec![
            Picture {
                file: "d-figure-14",
                caption: format!("Figure 14: prediction and compensation of the contour error on {name}, by the LSTM"),
                svg: draw(3, &panels),
            },
            Picture {
                file: "d-figure-15",
                caption: format!("Figure 15: contour error of three methods on {name}"),
                svg: draw(1, &[panel("contour error".into(), methods)]),
            },
        ])
    }
}
