//! What changes on a machine from day to day, and which change is an alarm.

use std::collections::BTreeMap;
use std::path::Path;

use models::Bundle;
use serde::Serialize;
use servo::Servo;

use crate::alarm::{Change, Limits};
use crate::baseline::{AxisBaseline, Baseline, model_path};
use crate::error::{FleetError, Result};
use crate::estimate::{AxisEstimate, Quantity, estimates};
use crate::quality::{Quality, quality};
use crate::store::{Day, MachineFolder};
use crate::table::day_logs;
use crate::train::finished;

/// Settings of a watch.
#[derive(Debug, Clone)]
pub struct WatchSettings {
    /// Accepted false alarms.
    pub limits: Limits,
    /// Days before this date (`YYYY-MM-DD`) are left out.
    pub since: Option<String>,
    /// Largest number of samples that are read of a day; of more, the first part of every file.
    pub most_samples_a_day: usize,
}

/// What a day is for the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Phase {
    /// The model was trained on it.
    Training,
    /// It is taken to be healthy.
    Healthy,
    /// It is watched.
    Watched,
}

impl Phase {
    /// Its name in results.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Training => "training",
            Self::Healthy => "healthy",
            Self::Watched => "watched",
        }
    }
}

/// One axis of one machine on one day.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisDay {
    /// Name of the machine.
    pub machine: String,
    /// The day as `YYYY-MM-DD`.
    pub date: String,
    /// What it is for the model.
    pub phase: Phase,
    /// Quality of the logs, with the name of the axis.
    pub quality: Quality,
    /// What the logs say; `None` where the axis hardly moves.
    pub estimate: Option<AxisEstimate>,
    /// Levels of friction, µm, backlash, µm, and lag, ms: those of the training and their changes. By quantity, where the day shows it.
    pub levels: BTreeMap<Quantity, f64>,
    /// Changes against the healthy days, on watched days.
    pub changes: BTreeMap<Quantity, Change>,
}

impl AxisDay {
    /// The quantities with an alarm.
    pub fn alarms(&self) -> impl Iterator<Item = Quantity> + '_ {
        self.changes.iter().filter(|(_, change)| change.is_alarm()).map(|(quantity, _)| *quantity)
    }
}

/// Every axis of a machine on every day, in the order of the days. One day is held at a time.
///
/// # Errors
/// When the machine has no model, or its logs or files cannot be read.
pub fn watch(machine: &MachineFolder, models: &Path, settings: &WatchSettings) -> Result<Vec<AxisDay>> {
    if !finished(models, &machine.name) {
        return Err(FleetError::NotTrained { machine: machine.name.clone(), path: models.to_owned() });
    }
    let path = model_path(models, &machine.name);
    let bytes = std::fs::read(&path).map_err(FleetError::io(&path))?;
    let bundle = Bundle::from_bytes(&bytes).map_err(|source| FleetError::Model { path, source: Box::new(source) })?;
    let baseline = Baseline::read(models, &machine.name)?;
    let mut all = Vec::new();
    for day in machine.days()? {
        if settings.since.as_ref().is_none_or(|since| day.date >= *since) {
            all.extend(of_day(machine, &day, &bundle, &baseline, settings)?);
        }
    }
    Ok(all)
}

fn of_day(
    machine: &MachineFolder,
    day: &Day,
    bundle: &Bundle,
    baseline: &Baseline,
    settings: &WatchSettings,
) -> Result<Vec<AxisDay>> {
    let phase = match &day.date {
        date if baseline.trained_on.contains(date) => Phase::Training,
        date if baseline.calibrated_on.contains(date) => Phase::Healthy,
        _ => Phase::Watched,
    };
    let found = estimates(&machine.name, bundle, &baseline.servos(), &day_logs(day, settings.most_samples_a_day)?)?;
    let tests: usize = found.iter().map(|estimate| estimate.readings.len()).sum();
    let mut all = Vec::new();
    for quality in quality(day)? {
        let estimate = found.iter().find(|estimate| estimate.axis == quality.axis);
        let known = baseline.axes.iter().find(|axis| axis.axis == quality.axis);
        let (mut levels, mut changes) = (BTreeMap::new(), BTreeMap::new());
        if let (Some(estimate), Some(known)) = (estimate, known) {
            levels = levels_of(&known.servo, estimate);
            if phase == Phase::Watched {
                changes = changes_of(known, estimate, settings.limits, tests);
            }
        }
        let (machine, date) = (machine.name.clone(), day.date.clone());
        all.push(AxisDay { machine, date, phase, quality, estimate: estimate.cloned(), levels, changes });
    }
    Ok(all)
}

fn changes_of(known: &AxisBaseline, estimate: &AxisEstimate, limits: Limits, tests: usize) -> BTreeMap<Quantity, Change> {
    let healthy = |quantity: &Quantity| known.healthy.get(quantity).map_or(&[][..], Vec::as_slice);
    // What usually lies behind reversals only healthy days say.
    let is_known = |quantity: &Quantity| *quantity != Quantity::Reversals || !healthy(quantity).is_empty();
    let readings = estimate.readings.iter().filter(|(quantity, _)| is_known(quantity));
    readings.map(|(quantity, today)| (*quantity, limits.change(*quantity, healthy(quantity), today, tests))).collect()
}

/// Levels of friction, µm, backlash, µm, and lag, ms.
fn levels_of(servo: &Servo, estimate: &AxisEstimate) -> BTreeMap<Quantity, f64> {
    let level = |quantity: Quantity, value: f64| match quantity {
        Quantity::Fit | Quantity::Reversals => None,
        Quantity::Friction => Some(1e3 * servo.coulomb_mm * (1.0 + value)),
        Quantity::Backlash => Some(1e3 * (servo.backlash_mm + servo.outer_backlash_mm) + value),
        Quantity::Lag => Some(1e3 * servo.lag_s() + 1e-3 * value),
    };
    let readings = estimate.readings.iter();
    readings.filter_map(|(quantity, reading)| Some((*quantity, level(*quantity, reading.value)?))).collect()
}
