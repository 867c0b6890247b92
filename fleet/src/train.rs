//! Training of one machine of a fleet: its model, its servo models, and what healthy days show.

use std::collections::BTreeMap;
use std::path::Path;

use datasets::Log;
use diagnosis::Sensor;
use diagnosis::record::AxisRecord;
use models::Bundle;
use pipeline::{Progress, Recipe};
use rayon::prelude::*;
use servo::{Scope, Servo, identify};

use crate::baseline::{AxisBaseline, Baseline, baseline_path, model_path};
use crate::error::{FleetError, Result};
use crate::estimate::{Quantity, Reading, estimates};
use crate::store::{Day, MachineFolder, sensor_of};
use crate::table::day_logs;

/// Settings of the training of a fleet.
#[derive(Debug, Clone)]
pub struct TrainSettings {
    /// Recipe of the predictors.
    pub recipe: Recipe,
    /// Number of days on which the model is trained: the first ones.
    pub days: usize,
    /// Number of days after them that are taken to be healthy.
    pub healthy_days: usize,
    /// Largest number of samples to train on.
    pub most_samples: usize,
    /// Largest number of samples that are read of a day; of more, the first part of every file.
    pub most_samples_a_day: usize,
    /// Where positions are measured, where no machine file says it.
    pub sensor: Option<Sensor>,
    /// Seed of all random draws.
    pub seed: u64,
}

/// A machine that was trained.
#[derive(Debug)]
pub struct Finished {
    /// Its model.
    pub bundle: Bundle,
    /// Its baseline.
    pub baseline: Baseline,
}

/// Whether the machine has a finished model: both files are complete, since each gets its name when it is.
#[must_use]
pub fn finished(models: &Path, machine: &str) -> bool {
    model_path(models, machine).is_file() && baseline_path(models, machine).is_file()
}

/// Trains the model of a machine and writes it, with its baseline, into the folder `models`. Both are written to temporary files first; the
/// model is renamed last. The same logs, settings and seed give the same bytes.
///
/// # Errors
/// When logs cannot be read or are not fit for training, no model is better than none, or files cannot be written.
pub fn train(machine: &MachineFolder, models: &Path, settings: &TrainSettings, progress: Progress<'_>) -> Result<Finished> {
    let days = machine.days()?;
    let (training, later) = days.split_at(settings.days.clamp(1, days.len()));
    let healthy = &later[..settings.healthy_days.min(later.len())];
    let spec = machine.description()?;
    let logs = logs_of(training, settings.most_samples_a_day)?;
    let own = pipeline::training::TrainSettings {
        most_samples: settings.most_samples,
        ..pipeline::training::TrainSettings::of(settings.recipe.clone(), settings.seed)
    };
    let failed = FleetError::pipeline(&machine.name);
    let trained = pipeline::training::train(&logs, spec.as_ref(), &own, progress).map_err(&failed)?;
    trained.doubts().map_err(&failed)?;
    let sensor = settings.sensor.unwrap_or_else(|| sensor_of(spec.as_ref()));
    let servos = servos(&machine.name, &trained.bundle, &logs, sensor)?;
    drop(logs);
    let readings = readings(machine, &trained.bundle, &servos, healthy, settings.most_samples_a_day)?;
    let axes = servos.into_iter().zip(readings).map(|((axis, servo), healthy)| AxisBaseline { axis, servo, healthy });
    let dates = |days: &[Day]| days.iter().map(|day| day.date.clone()).collect();
    let baseline = Baseline::new(&machine.name, dates(training), dates(healthy), axes.collect());
    let model = trained.bundle.to_bytes().map_err(|error| failed(error.into()))?;
    let (path, beside) = (model_path(models, &machine.name), baseline_path(models, &machine.name));
    let content = baseline.to_bytes(&beside)?;
    datasets::write_all(&[(beside, content), (path, model)])?;
    Ok(Finished { bundle: trained.bundle, baseline })
}

/// The logs of some days.
fn logs_of(days: &[Day], most: usize) -> Result<Vec<Log>> {
    let share = most / days.len().max(1);
    let logs = days.iter().map(|day| day_logs(day, share)).collect::<Result<Vec<_>>>()?;
    Ok(logs.concat())
}

/// The servo model of every axis of a model.
fn servos(machine: &str, bundle: &Bundle, logs: &[Log], sensor: Sensor) -> Result<Vec<(String, Servo)>> {
    let records = AxisRecord::of(logs);
    let records = records.map_err(|source| FleetError::Diagnosis { machine: machine.to_owned(), source: Box::new(source) })?;
    let scope = Scope { sees_backlash: sensor != Sensor::Motor, whole: false };
    let of = |name: &String| {
        let record = records.iter().find(|record| record.name == *name);
        let fit = record.and_then(|record| identify(&record.for_fit(), scope));
        let fit = fit.ok_or_else(|| FleetError::NoServo { machine: machine.to_owned(), axis: name.clone() })?;
        Ok((name.clone(), fit.servo))
    };
    let names: Vec<String> = bundle.manifest.axes.iter().map(|axis| axis.name.clone()).collect();
    names.par_iter().map(of).collect()
}

/// Readings of the healthy days, by axis in the order of `servos`.
fn readings(
    machine: &MachineFolder,
    bundle: &Bundle,
    servos: &[(String, Servo)],
    healthy: &[Day],
    most: usize,
) -> Result<Vec<BTreeMap<Quantity, Vec<Reading>>>> {
    let mut all = vec![BTreeMap::<Quantity, Vec<Reading>>::new(); servos.len()];
    for day in healthy {
        for found in estimates(&machine.name, bundle, servos, &day_logs(day, most)?)? {
            let Some(place) = servos.iter().position(|(axis, _)| *axis == found.axis) else { continue };
            for (quantity, reading) in found.readings {
                all[place].entry(quantity).or_default().push(reading);
            }
        }
    }
    Ok(all)
}
