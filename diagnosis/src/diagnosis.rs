//! The diagnosis of a machine from its logs.

use datasets::Log;
use rayon::prelude::*;
use serde::Serialize;

use crate::context::{AxisContext, Sensor, TestCircle};
use crate::error::DiagnosisError;
use crate::finding::{Estimate, Finding};
use crate::findings::{mismatches, of_axis};
use crate::record::AxisRecord;
use servo::{Fit, Record, Scope, Servo, identify, identify_any_control};

/// Share of the tracking error that the servo model may leave: it leaves 0.1 to 6 % of drives, simulated ones and EMPS, and a third to a half of
/// the joints of a UR5 arm, which are no feed drives.
const DOUBTFUL: f64 = 0.2;
/// Magnitude that no figure of a machine has: a metre in micrometres.
const ABSURD: f64 = 1e6;
/// Share up to which loops of other kinds are not tried, and ratio of the mean squares from which on one of them is taken: wrong loops left 0.3 to 83 % on
/// `random:500` to `512`; on the 40 cascades of the blind test no other loop is taken.
const LITTLE: f64 = 0.002;
const FAR_BETTER: f64 = 0.25;

/// What the caller knows about the logs.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Settings {
    /// Where the actual position is measured.
    pub sensor: Sensor,
    /// Circle on which deviations are stated; one within the logged speeds and accelerations if absent.
    pub circle: Option<TestCircle>,
}

/// A diagnosis.
#[derive(Debug, Clone, Serialize)]
pub struct Diagnosis {
    /// Circle on which deviations are stated.
    pub circle: TestCircle,
    /// Sensor of the logs.
    pub sensor: Sensor,
    /// Logged time, s.
    pub seconds: f64,
    /// Names of the axes that were diagnosed.
    pub axes: Vec<String>,
    /// Axes whose logs the servo model does not follow well: their findings are doubtful.
    pub doubtful_axes: Vec<String>,
    /// Findings, axis by axis, then those of pairs.
    pub findings: Vec<Finding>,
    /// Servo model of every axis.
    #[serde(skip)]
    pub models: Vec<AxisModel>,
}

/// The servo model of an axis.
#[derive(Debug, Clone)]
pub struct AxisModel {
    /// Name of the axis.
    pub axis: String,
    /// Fitted parameters.
    pub servo: Servo,
    /// RMS of the tracking error, and of what the model leaves of it, mm.
    pub tracking_rms_mm: f64,
    /// See `tracking_rms_mm`.
    pub residual_rms_mm: f64,
}

/// Diagnoses the machine that made `logs`, one log a run.
///
/// # Errors
/// When the logs do not match each other, no axis moves, or no servo model follows an axis.
pub fn diagnose(logs: &[Log], settings: &Settings) -> Result<Diagnosis, DiagnosisError> {
    let records = AxisRecord::of(logs)?;
    let circle = settings.circle.unwrap_or_else(|| TestCircle::within(&records));
    let scope = Scope { sees_backlash: settings.sensor != Sensor::Motor, whole: false };
    let fits: Vec<Fit> = records
        .par_iter()
        .map(|record| followed(record, scope).ok_or_else(|| DiagnosisError::NoFit { axis: record.name.clone() }))
        .collect::<Result<_, _>>()?;
    let contexts: Vec<AxisContext<'_>> =
        records.iter().zip(&fits).map(|(record, fit)| AxisContext::new(record, fit, circle, settings.sensor)).collect();
    let mut findings: Vec<Finding> = contexts.par_iter().flat_map(of_axis).collect();
    findings.extend(mismatches(&contexts));
    let models: Vec<AxisModel> = records.iter().zip(&fits).map(|(record, fit)| model(record, fit)).collect();
    let doubtful = models.iter().filter(|model| model.residual_rms_mm > DOUBTFUL * model.tracking_rms_mm);
    Ok(Diagnosis {
        doubtful_axes: doubtful.map(|model| model.axis.clone()).collect(),
        circle,
        sensor: settings.sensor,
        seconds: logs.iter().map(|log| log.len() as f64 * log.period_s()).sum(),
        axes: records.iter().map(|record| record.name.clone()).collect(),
        findings: findings.into_iter().map(observable).collect(),
        models,
    })
}

/// The finding, where its figures are those of a machine.
fn observable(finding: Finding) -> Finding {
    let is_absurd = |of: &Estimate| ![of.value, of.low, of.high].iter().all(|value| value.abs() < ABSURD);
    if !finding.estimate.iter().chain(&finding.effect_um).any(is_absurd) {
        return finding;
    }
    let remedy = "record reversals and stops at full acceleration (precomp excite), at a higher rate";
    Finding::not_observable(finding.quantity, &finding.axis, finding.unit, "the logs do not bound it", remedy)
}

/// The servo model that follows an axis. Where that of the usual loops leaves much, loops of any kind are tried.
fn followed(record: &AxisRecord, scope: Scope) -> Option<Fit> {
    let runs: Record = record.for_fit();
    let usual = identify(&runs, scope);
    if usual.as_ref().is_some_and(|fit| fit.mean_square.sqrt() < LITTLE * tracking_rms_mm(record)) {
        return usual;
    }
    let least = usual.as_ref().map_or(f64::INFINITY, |fit| FAR_BETTER * fit.mean_square);
    identify_any_control(&runs, scope).filter(|other| other.mean_square < least).or(usual)
}

/// RMS of the tracking error, mm.
fn tracking_rms_mm(record: &AxisRecord) -> f64 {
    let errors = record.runs.iter().flat_map(|run| run.reference.iter().zip(&run.actual).skip(record.first_scored()));
    let (squares, count) = errors.fold((0.0, 0_usize), |(sum, count), (r, x)| (sum + (r - x).powi(2), count + 1));
    (squares / count.max(1) as f64).sqrt()
}

fn model(record: &AxisRecord, fit: &Fit) -> AxisModel {
    AxisModel {
        axis: record.name.clone(),
        servo: fit.servo,
        tracking_rms_mm: tracking_rms_mm(record),
        residual_rms_mm: fit.mean_square.sqrt(),
    }
}

impl Diagnosis {
    /// The finding of a quantity of an axis.
    #[must_use]
    pub fn finding(&self, quantity: crate::finding::Quantity, axis: &str) -> Option<&Finding> {
        self.findings.iter().find(|finding| finding.quantity == quantity && finding.axis == axis)
    }
}
