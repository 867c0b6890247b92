//! Settings of LinuxCNC that follow from a diagnosis, with the following error that the servo model forecasts for each.

use std::fmt::Write;

use datasets::Log;
use serde::Serialize;

use crate::context::Sensor;
use crate::diagnosis::{AxisModel, Diagnosis};
use crate::error::DiagnosisError;
use crate::finding::{Estimate, Quantity};
use crate::record::{AxisRecord, Run};
use servo::{Servo, simulate};

/// Length of the logs on which gains are forecast, s.
const FORECAST_S: f64 = 20.0;
/// Range of a suggested FF1 and FF2 (s): beyond it the log shows a fault, not a setting.
const FF1: (f64, f64) = (0.0, 1.2);
const FF2_S: (f64, f64) = (-0.02, 0.05);
/// Steps of the numerical derivatives.
const STEPS: [f64; 2] = [1e-2, 1e-4];
/// Decrease of the following error below which a setting is not suggested.
const LEAST_GAIN: f64 = 0.03;

/// A setting with its forecast.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Setting {
    /// Key in the section of the joint.
    pub key: &'static str,
    /// Value.
    pub value: f64,
    /// Following error RMS with this setting and those before it, µm.
    pub forecast_um: f64,
}

/// Suggested settings of one joint.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Joint {
    /// Axis.
    pub axis: String,
    /// Number of the joint; axes are taken in the order x, y, z, a, b, c of those that are logged.
    pub joint: usize,
    /// Gain that the log shows, 1/s: P of the position loop where its output is a speed in mm/s.
    pub position_gain_1_s: f64,
    /// FF1 that the log shows, as a share.
    pub feed_forward: f64,
    /// Following error RMS as logged, µm.
    pub logged_um: f64,
    /// The settings.
    pub settings: Vec<Setting>,
    /// Why there is no BACKLASH, where the log shows some.
    pub note: Option<String>,
}

/// Suggestions for the joints of the linear axes, from the diagnosis of `logs`.
///
/// # Errors
/// When the logs are not those of a diagnosis.
pub fn suggest(found: &Diagnosis, logs: &[Log]) -> Result<Vec<Joint>, DiagnosisError> {
    let records = AxisRecord::of(logs)?;
    let joints = found.models.iter().zip(&records).enumerate().filter(|(_, (_, record))| !record.rotary);
    Ok(joints.map(|(joint, (model, record))| of_joint(joint, model, record, found)).collect())
}

fn of_joint(joint: usize, model: &AxisModel, record: &AxisRecord, found: &Diagnosis) -> Joint {
    let runs = forecast_runs(record);
    let now = model.servo;
    let before = rms_um(&now, &runs, record.period_s);
    let mut settings = Vec::new();
    let mut best = (now, before);
    let fed = fed_forward(&now, &runs, record.period_s);
    let ff1 = Servo { feed_forward: fed.feed_forward, ..now };
    for (key, servo, value) in [("FF1", ff1, fed.feed_forward), ("FF2", fed, fed.velocity_per_acceleration_s)] {
        let forecast_um = rms_um(&servo, &runs, record.period_s);
        if forecast_um < (1.0 - LEAST_GAIN) * best.1 {
            best = (servo, forecast_um);
            settings.push(Setting { key, value, forecast_um });
        }
    }
    let width: Option<Estimate> = found.finding(Quantity::Backlash, &model.axis).and_then(|finding| finding.estimate);
    let mut note = None;
    if let Some(width) = width.filter(|width| width.low > 0.0) {
        if now.outer_backlash_mm > 0.0 {
            let servo = Servo { outer_backlash_mm: 0.0, ..best.0 };
            settings.push(Setting {
                key: "BACKLASH",
                value: 1e-3 * width.value,
                forecast_um: rms_um(&servo, &runs, record.period_s),
            });
        } else {
            note = Some(format!(
                "{:.1} µm of backlash lie inside the loop: the scale closes it, and BACKLASH would be added on top; mend it mechanically",
                width.value
            ));
        }
    } else if found.sensor == Sensor::Motor {
        note = Some("a motor encoder does not show backlash: measure it with a dial gauge before BACKLASH is set".to_owned());
    }
    Joint {
        axis: model.axis.clone(),
        joint,
        position_gain_1_s: now.position_gain_1_s,
        feed_forward: now.feed_forward,
        logged_um: 1e3 * model.tracking_rms_mm,
        settings,
        note,
    }
}

fn forecast_runs(record: &AxisRecord) -> Vec<Run> {
    let samples = (FORECAST_S / record.period_s) as usize / record.runs.len().max(1);
    let cut = |run: &Run| {
        let end = run.len().min(samples.max(2 * record.first_scored()));
        Run { name: run.name.clone(), reference: run.reference[..end].to_vec(), actual: run.actual[..end].to_vec() }
    };
    record.runs.iter().map(cut).collect()
}

/// Following errors that the model makes on the runs, mm.
fn errors(servo: &Servo, runs: &[Run], period_s: f64) -> Vec<f64> {
    let first = (crate::record::UNSCORED_S / period_s) as usize;
    let of_run = |run: &Run| {
        let actual = simulate(servo, &run.reference, period_s, run.start(period_s));
        run.reference.iter().zip(actual).skip(first).map(|(r, x)| r - x).collect::<Vec<f64>>()
    };
    runs.iter().flat_map(of_run).collect()
}

fn rms_um(servo: &Servo, runs: &[Run], period_s: f64) -> f64 {
    let errors = errors(servo, runs, period_s);
    1e3 * (errors.iter().map(|e| e * e).sum::<f64>() / errors.len().max(1) as f64).sqrt()
}

/// FF1 and FF2 of the least following error: both enter it linearly, so two derivatives and a least-squares step give them.
fn fed_forward(servo: &Servo, runs: &[Run], period_s: f64) -> Servo {
    let with = |one: f64, two: f64| Servo {
        feed_forward: (servo.feed_forward + one).clamp(FF1.0, FF1.1),
        velocity_per_acceleration_s: (servo.velocity_per_acceleration_s + two).clamp(FF2_S.0, FF2_S.1),
        ..*servo
    };
    let base = errors(servo, runs, period_s);
    let slope = |servo: Servo, step: f64| -> Vec<f64> {
        errors(&servo, runs, period_s).iter().zip(&base).map(|(e, b)| (e - b) / step).collect()
    };
    let (a, b) = (slope(with(STEPS[0], 0.0), STEPS[0]), slope(with(0.0, STEPS[1]), STEPS[1]));
    let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
    let (aa, ab, bb, ae, be) = (dot(&a, &a), dot(&a, &b), dot(&b, &b), dot(&a, &base), dot(&b, &base));
    let determinant = aa * bb - ab * ab;
    if determinant <= 1e-9 * aa * bb {
        return *servo;
    }
    with(-(bb * ae - ab * be) / determinant, -(aa * be - ab * ae) / determinant)
}

/// The suggestions as lines of an INI file, to be reviewed.
#[must_use]
pub fn ini(joints: &[Joint]) -> String {
    let mut text = String::from(
        "# Suggestions from logs of commanded and actual positions. Review every line: copy it into the section of the joint,\n\
         # change one setting at a time, at low speed first. Values hold where the position loop's output is a speed in mm/s and P its\n\
         # gain in 1/s; with another output scale multiply FF1 and FF2 by P over the gain stated here. Forecasts: servo model on the logs.\n",
    );
    for joint in joints {
        // Writing to a text cannot fail.
        let _ = writeln!(text, "\n[JOINT_{}]", joint.joint);
        let _ = writeln!(
            text,
            "# {}: gain {:.1} 1/s, FF1 {:.3}, following error {:.2} µm RMS",
            joint.axis, joint.position_gain_1_s, joint.feed_forward, joint.logged_um
        );
        for Setting { key, value, forecast_um } in &joint.settings {
            let decimals = if *key == "FF1" { 4 } else { 6 };
            let _ = writeln!(text, "{key} = {value:.decimals$}\n# forecast with it: {forecast_um:.2} µm RMS");
        }
        if joint.settings.is_empty() {
            let _ = writeln!(text, "# nothing to change");
        }
        if let Some(note) = &joint.note {
            let _ = writeln!(text, "# {note}");
        }
    }
    text
}
