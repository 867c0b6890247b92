//! Prediction intervals: the expected accuracy of a prediction.

use serde::{Deserialize, Serialize};

use crate::AxisSignal;
use crate::features::{events, velocity};
use crate::quantile::quantile;
use crate::ranges::{LENGTH, VELOCITY, all_within, within};
use crate::spread::Spread;

/// Duration after a reversal or a start in which friction settles, s.
const SETTLING_S: f64 = 0.06;
/// Number of speed regimes, in octaves below the top speed of the training data.
const OCTAVES: usize = 3;
/// Standstill, after an event, and one regime per octave of speed.
const REGIMES: usize = 2 + OCTAVES;

/// Half-widths of the 95 % prediction interval of an axis, one per regime of motion, mm or rad:
/// quantiles of the absolute errors on held-out runs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PredictionInterval {
    /// Standstill; just after a reversal or start; slow to fast.
    half_widths: [f64; REGIMES],
    /// Reference speed of the octaves, mm/s or rad/s.
    top_speed: f64,
    /// Distribution of the errors of the final predictor; `None` in bundles of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    spread: Option<Spread>,
}

impl PredictionInterval {
    pub(crate) fn check(&self) -> Result<(), String> {
        all_within("half_widths", &self.half_widths, LENGTH)?;
        within("top_speed", self.top_speed, VELOCITY)?;
        self.spread.as_ref().map_or(Ok(()), Spread::check)
    }

    /// The interval from held-out `runs`: signals with the absolute errors of their prediction.
    #[must_use]
    pub fn fit(runs: &[(AxisSignal<'_>, Vec<f64>)], top_speed: f64) -> Self {
        let mut errors: [Vec<f64>; REGIMES] = Default::default();
        for (signal, error) in runs {
            for (regime, error) in regimes(signal, top_speed).into_iter().zip(error) {
                errors[regime].push(error.abs());
            }
        }
        let all: Vec<f64> = errors.iter().flatten().copied().collect();
        let overall = quantile(all, 0.95);
        let half_widths = errors.map(|errors| {
            // Too few samples give no quantile.
            if errors.len() < 200 { overall } else { quantile(errors, 0.95) }
        });
        Self { half_widths, top_speed, spread: None }
    }

    /// The same interval with the error distribution of the final predictor.
    #[must_use]
    pub fn with_spread(self, spread: Option<Spread>) -> Self {
        Self { spread, ..self }
    }

    /// Error distribution of the final predictor; `None` if the bundle has none.
    #[must_use]
    pub fn spread(&self) -> Option<&Spread> {
        self.spread.as_ref()
    }

    /// Half-width of the 95 % interval at every sample, mm or rad.
    #[must_use]
    pub fn at(&self, signal: &AxisSignal<'_>) -> Vec<f64> {
        regimes(signal, self.top_speed).into_iter().map(|regime| self.half_widths[regime]).collect()
    }

    /// Coverage probability: share of the errors within the interval.
    #[must_use]
    pub fn held(&self, signal: &AxisSignal<'_>, errors: &[f64]) -> f64 {
        let inside = self.at(signal).iter().zip(errors).filter(|(width, error)| error.abs() <= **width).count();
        inside as f64 / errors.len().max(1) as f64
    }
}

fn regimes(signal: &AxisSignal<'_>, top_speed: f64) -> Vec<usize> {
    let v = velocity(signal.reference, signal.period_s);
    let flags = velocity(signal.flag_source(), signal.period_s);
    let settling = (SETTLING_S / signal.period_s).ceil() as usize;
    let mut regimes: Vec<usize> = v
        .iter()
        .map(|v| match v.abs() {
            0.0 => 0,
            speed => {
                let octave = (top_speed / speed).log2().max(0.0) as usize;
                2 + OCTAVES - 1 - octave.min(OCTAVES - 1)
            }
        })
        .collect();
    for event in events(&flags) {
        let to = (event.sample + settling).min(regimes.len());
        regimes[event.sample.min(to)..to].fill(1);
    }
    regimes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(seed: u64) -> (Vec<f64>, Vec<f64>) {
        let x: Vec<f64> = (0..4000).map(|k| 10.0 * (f64::from(k) * 0.01).sin()).collect();
        let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
        let errors = x
            .iter()
            .map(|x| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                let unit = (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
                unit * (1.0 + x.abs())
            })
            .collect();
        (x, errors)
    }

    #[test]
    fn intervals_hold_on_runs_they_were_not_fitted_to() {
        let (x, errors) = run(1);
        let signal = AxisSignal::uncompensated(&x, 0.002);
        let interval = PredictionInterval::fit(&[(signal, errors)], 50.0);
        let (x, errors) = run(2);
        let signal = AxisSignal::uncompensated(&x, 0.002);
        let coverage = interval.held(&signal, &errors);
        assert!((0.90..0.98).contains(&coverage), "{coverage}");
        let worse: Vec<f64> = errors.iter().map(|e| e * 3.0).collect();
        assert!(interval.held(&signal, &worse) < 0.75);
    }
}
