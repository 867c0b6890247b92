//! What the logs of a day say about an axis, against its model: residual, friction, backlash, lag.

use std::collections::BTreeMap;

use datasets::Log;
use diagnosis::DiagnosisError;
use diagnosis::record::AxisRecord;
use models::{AxisPredictor, AxisSignal, Bundle};
use nalgebra::{DMatrix, DVector};
use pipeline::measure::{Fit, fits};
use serde::{Deserialize, Serialize};
use servo::{Servo, clustered};

use crate::error::{FleetError, Result};
use crate::quality::LEVER_MM;
use crate::reversals::rms_behind;
use crate::sensitivity::{Cause, sensitivities};

/// A quantity that is watched.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Quantity {
    /// Logarithm of the model's RMS error over that on held-out runs of the training.
    Fit,
    /// Relative change of the friction level since the training.
    Friction,
    /// Change of the backlash since the training, µm.
    Backlash,
    /// Change of the lag since the training, µs.
    Lag,
    /// Logarithm of the RMS of the residual behind reversals, over the model's RMS error on held-out runs of the training.
    Reversals,
}

impl Quantity {
    /// All of them, in the order of results.
    pub const ALL: [Self; 5] = [Self::Fit, Self::Friction, Self::Backlash, Self::Lag, Self::Reversals];

    /// Its name in results.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Fit => "fit",
            Self::Friction => "friction",
            Self::Backlash => "backlash",
            Self::Lag => "lag",
            Self::Reversals => "reversals",
        }
    }

    /// Unit of its level in results; `None` where there is but a change.
    #[must_use]
    pub fn unit(self) -> Option<&'static str> {
        match self {
            Self::Fit | Self::Reversals => None,
            Self::Friction | Self::Backlash => Some("um"),
            Self::Lag => Some("ms"),
        }
    }

    /// What its change is called in results, with the unit.
    #[must_use]
    pub fn change_name(self) -> &'static str {
        match self {
            Self::Fit | Self::Reversals => "change_ln",
            Self::Friction => "change_share",
            Self::Backlash => "change_um",
            Self::Lag => "change_us",
        }
    }
}

/// A quantity as one day shows it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Reading {
    /// The value, in the unit of its quantity.
    pub value: f64,
    /// Its standard deviation by the spread of the residual from second to second; 0 where it is not known.
    pub deviation: f64,
}

/// What the logs of a day say about an axis.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisEstimate {
    /// Name of the axis.
    pub axis: String,
    /// RMS of predicted minus measured position, µm (a rotary axis: on a lever arm of 100 mm).
    pub model_rms_um: f64,
    /// The same on held-out runs of the training, µm.
    pub held_out_rms_um: f64,
    /// Share of the samples within the 95 % prediction interval.
    pub in_band: f64,
    /// The quantities that the day shows.
    pub readings: BTreeMap<Quantity, Reading>,
}

/// Standard deviations above which a day shows nothing of a quantity: a quarter of the friction, 5 µm, 1 ms.
const TOO_WIDE: [(Quantity, f64); 3] = [(Quantity::Friction, 0.25), (Quantity::Backlash, 5.0), (Quantity::Lag, 1e3)];

/// Estimates of every axis of a model from the logs of a day. `servos` holds the servo model of each axis by name. Where no axis moves for two
/// seconds there is none.
///
/// The residual of the model, `actual − predicted`, is regressed on the derivatives of the servo model's position by friction, backlash and lag, with
/// a constant. Errors of the servo model change the sizes found, not whether a change is found: the residual is that of the whole model.
///
/// # Errors
/// When the logs have other axes or another period than each other or the model.
pub fn estimates(machine: &str, bundle: &Bundle, servos: &[(String, Servo)], logs: &[Log]) -> Result<Vec<AxisEstimate>> {
    let records = match AxisRecord::of(logs) {
        Err(DiagnosisError::NoMotion { .. }) => return Ok(Vec::new()),
        found => found.map_err(|source| FleetError::Diagnosis { machine: machine.to_owned(), source: Box::new(source) })?,
    };
    let mut fitted: BTreeMap<String, Pooled> = BTreeMap::new();
    for log in logs {
        for fit in fits(bundle, log).map_err(FleetError::pipeline(machine))? {
            fitted.entry(fit.axis.clone()).or_default().add(&fit, log.len());
        }
    }
    let predictors = bundle.predictors().map_err(|source| FleetError::pipeline(machine)(source.into()))?;
    let mut all = Vec::new();
    for (manifest, predictor) in bundle.manifest.axes.iter().zip(&predictors) {
        let Some(record) = records.iter().find(|record| record.name == manifest.name) else { continue };
        let (Some(fit), Some((_, servo))) = (fitted.get(&manifest.name), servos.iter().find(|(name, _)| *name == manifest.name))
        else {
            continue;
        };
        let per_um = if manifest.rotary { LEVER_MM * 1e3 } else { 1e3 };
        let residuals = residuals(record, predictor.as_ref());
        let mut readings = changes(record, servo, &residuals);
        let lever = if manifest.rotary { LEVER_MM } else { 1.0 };
        let behind = rms_behind(record, &residuals, servo.lag_s()).map(|rms| rms / lever);
        for (quantity, rms) in [(Quantity::Fit, Some(fit.rms())), (Quantity::Reversals, behind)] {
            let value = rms.map(|rms| (rms / manifest.held_out.rms).ln()).filter(|value| value.is_finite());
            if let Some(value) = value {
                readings.insert(quantity, Reading { value, deviation: 0.0 });
            }
        }
        all.push(AxisEstimate {
            axis: manifest.name.clone(),
            model_rms_um: fit.rms() * per_um,
            held_out_rms_um: manifest.held_out.rms * per_um,
            in_band: fit.in_band(),
            readings,
        });
    }
    Ok(all)
}

/// The fit of a model to several logs.
#[derive(Debug, Default)]
struct Pooled {
    squares: f64,
    in_band: f64,
    samples: f64,
}

impl Pooled {
    fn add(&mut self, fit: &Fit, samples: usize) {
        // Samples outside of the operating range count only where there are no others.
        let counted = samples as f64 * (1.0 - fit.outside).max(1e-6);
        self.squares += counted * fit.rms * fit.rms;
        self.in_band += counted * fit.in_band;
        self.samples += counted;
    }

    fn rms(&self) -> f64 {
        (self.squares / self.samples).sqrt()
    }

    fn in_band(&self) -> f64 {
        self.in_band / self.samples
    }
}

/// Changes of friction, backlash and lag that explain the residual of the model best.
fn changes(record: &AxisRecord, servo: &Servo, residuals: &[Vec<f64>]) -> BTreeMap<Quantity, Reading> {
    let causes = Cause::of(servo);
    let columns = sensitivities(record, servo, &causes);
    let Some(found) = regression(&columns, residuals, record.period_s) else { return BTreeMap::new() };
    let quantity = |cause: Cause| match cause {
        Cause::Friction => Some((Quantity::Friction, 1.0)),
        Cause::Backlash => Some((Quantity::Backlash, 1e3)),
        Cause::Lag => Some((Quantity::Lag, 1e6)),
        Cause::Offset => None,
    };
    let mut readings = BTreeMap::new();
    for (cause, (value, deviation)) in causes.into_iter().zip(found) {
        let Some((quantity, scale)) = quantity(cause) else { continue };
        let most = TOO_WIDE.iter().find(|(of, _)| *of == quantity).map_or(f64::INFINITY, |(_, most)| *most);
        if deviation * scale <= most {
            readings.insert(quantity, Reading { value: value * scale, deviation: deviation * scale });
        }
    }
    readings
}

/// Actual less predicted position of the scored samples of every run, mm.
fn residuals(record: &AxisRecord, predictor: &dyn AxisPredictor) -> Vec<Vec<f64>> {
    let first = record.first_scored();
    let per_mm = if record.rotary { LEVER_MM } else { 1.0 };
    let of = |run: &diagnosis::record::Run| -> Vec<f64> {
        let reference: Vec<f64> = run.reference.iter().map(|position| position / per_mm).collect();
        let errors = predictor.predict(&AxisSignal::uncompensated(&reference, record.period_s));
        let samples = run.reference.iter().zip(&run.actual).zip(&errors).take(run.len()).skip(first);
        samples.map(|((reference, actual), error)| actual - reference + per_mm * error).collect()
    };
    record.runs.iter().map(of).collect()
}

/// Least squares of the residuals on the columns: weights with their standard deviations. A column without effect has an infinite one. `None` where
/// the columns cannot be told apart.
fn regression(columns: &[Vec<f64>], residuals: &[Vec<f64>], period_s: f64) -> Option<Vec<(f64, f64)>> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let norms: Vec<f64> = columns.iter().map(|column| dot(column, column).sqrt()).collect();
    let seen: Vec<usize> = (0..columns.len()).filter(|&i| norms[i].is_normal()).collect();
    let scaled: Vec<Vec<f64>> = seen.iter().map(|&i| columns[i].iter().map(|value| value / norms[i]).collect()).collect();
    let count = seen.len();
    let normal = DMatrix::from_fn(count, count, |i, j| dot(&scaled[i], &scaled[j]));
    let target = residuals.concat();
    let right = DVector::from_fn(count, |i, _| dot(&scaled[i], &target));
    let weights = normal.clone().cholesky()?.solve(&right);
    let mut left = residuals.to_vec();
    let values = left.iter_mut().flatten();
    for (k, value) in values.enumerate() {
        *value -= (0..count).map(|i| weights[i] * scaled[i][k]).sum::<f64>();
    }
    let pieces: Vec<&[f64]> = left.iter().map(Vec::as_slice).collect();
    let covariance = clustered(&normal, &scaled, &pieces, period_s)?;
    let mut found = vec![(0.0, f64::INFINITY); columns.len()];
    for (place, &column) in seen.iter().enumerate() {
        found[column] = (weights[place] / norms[column], covariance[(place, place)].max(0.0).sqrt() / norms[column]);
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_of_known_columns_are_found_and_an_empty_one_is_unknown() {
        let wave = |step: f64, size: f64| (0..4000).map(|k| size * (step * f64::from(k)).sin()).collect::<Vec<f64>>();
        let columns = [wave(0.013, 30.0), vec![0.0; 4000], wave(0.05, 1e-4)];
        let noise = wave(1.7, 1e-6);
        let residuals: Vec<f64> = (0..4000).map(|k| 2e-5 * columns[0][k] - 0.3 * columns[2][k] + noise[k]).collect();
        let found = regression(&columns, &[residuals[..1500].to_vec(), residuals[1500..].to_vec()], 0.002).unwrap();
        assert!((found[0].0 - 2e-5).abs() < 1e-7 && (found[2].0 + 0.3).abs() < 1e-3, "{found:?}");
        assert!(found[1].1.is_infinite() && found[2].1 > 0.0 && found[2].1 < 0.01);
    }
}
