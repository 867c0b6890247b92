//! Data, networks and models of Paper D's tables.

use std::rc::Rc;

use anyhow::Result;
use datasets::Log;
use machine::MachineSpec;
use models::{Bundle, FeatureSet};
use motion::Trajectory;
use pipeline::excitation::{TRAVEL_MM, record};
use pipeline::training::{TrainSettings, train};
use pipeline::{SILENT, Setup};

use super::Reproduce;
use super::trained::{Axes, Key};
use crate::read;

/// Samples of Paper D's training set.
const SAMPLES: f64 = 30_106.0;

impl Reproduce {
    /// The simulated machine's log in Paper D's amount.
    fn paper_d_logs(&self, spec: &MachineSpec, seed: u64) -> Result<Vec<Log>> {
        let seconds = self.seconds.unwrap_or(SAMPLES * Setup::new(spec, None)?.period_s);
        Ok(record(spec, seconds, TRAVEL_MM, seed)?)
    }

    /// A model of Paper D's tables, trained once in a call.
    pub(super) fn model(&self, axes: Axes, predictor: &str, features: FeatureSet, seed: u64) -> Result<Rc<Bundle>> {
        let key = Key { axes, predictor: predictor.to_owned(), features, seed };
        self.trained.get(key, || {
            let spec = read::machine(&self.machine.machine)?;
            let mut logs = self.paper_d_logs(&spec, seed)?;
            if axes == Axes::X {
                logs = logs.iter().map(|log| only(log, 0)).collect::<Result<_>>()?;
            }
            let settings = TrainSettings::of(read::recipe(predictor)?.with_features(features), seed);
            // The machine's description has all axes, whatever the log's.
            Ok(train(&logs, (axes == Axes::All).then_some(&spec), &settings, SILENT)?.bundle)
        })
    }

    /// The paper's network, or the small one.
    pub(super) fn network(&self, small: &'static str) -> &'static str {
        match small {
            "lstm" if !self.quick => "lstm-paper",
            "gru" if !self.quick => "gru-paper",
            other => other,
        }
    }

    /// Networks and data, for the page.
    pub(super) fn paper_d_note(&self) -> Result<String> {
        let spec = read::machine(&self.machine.machine)?;
        let samples: usize = self.paper_d_logs(&spec, self.common.seed)?.iter().map(|log| log.reference.len()).sum();
        let networks = if self.quick {
            "small networks (64 units) instead of the paper's"
        } else {
            "the paper's networks, 3 layers of 128 units"
        };
        Ok(format!(
            "Trained on {samples} samples (the paper: 30,106) of random splines and lines at three speeds, {networks}; whole runs are held out \
             instead of the last 25 %."
        ))
    }

    pub(super) fn seeds_used(&self) -> impl Iterator<Item = u64> + use<> {
        let first = self.common.seed;
        (0..self.seeds).map(move |k| first.wrapping_add(1000 * k))
    }
}

/// The log of one axis.
pub(super) fn only(log: &Log, axis: usize) -> Result<Log> {
    let pick =
        |from: &Trajectory| Trajectory::new(from.period_s(), vec![from.axes()[axis].clone()], vec![from.columns()[axis].clone()]);
    Ok(Log::new(log.name.clone(), pick(&log.reference)?, pick(&log.actual)?)?)
}
