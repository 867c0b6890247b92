//! The settings of the fit.

use serde::{Deserialize, Serialize};

use crate::TrainingError;

/// Settings of the fit of a staged predictor. The defaults suit all machines.
///
/// Lengths and speeds are for an axis whose top speed in the log is `speed_unit`. They are scaled
/// by the measured top speed, so that the unit of the axis (mm, rad, degrees) does not matter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct StagedRecipe {
    /// Top speed for which the lengths and speeds below are given, unit/s.
    pub speed_unit: f64,
    /// Folds of the cross-validation: whole runs if there are at least as many, else contiguous
    /// blocks.
    pub folds: usize,
    /// Candidates for the time constant of the linear law's response, s, shortest first.
    pub memory_s: Vec<f64>,
    /// Window of the linear law, in such time constants.
    pub memories: f64,
    /// Time back to which the linear law's response is free at every sample, s: about the duration
    /// of the ringing of resonances.
    pub dense_s: f64,
    /// Share of the time beyond that over which the response is linear.
    pub lag_growth: f64,
    /// Longest window of the linear law after the present, s.
    pub future_s: f64,
    /// Correlation length of the errors, samples: many samples count only as their independent
    /// ones.
    pub correlated: f64,
    /// Ridge of the linear law, on columns of unit RMS.
    pub linear_ridge: f64,
    /// Candidates for the ridge of the non-linear columns.
    pub ridges: Vec<f64>,
    /// Largest loss in mean square, as a share, for which a stronger ridge is preferred to the
    /// best.
    pub ridge_slack: f64,
    /// Half-widths of the stop operators; empty for the linear law alone.
    pub stop_half_widths: Vec<f64>,
    /// Operators of the smallest variant, by index.
    pub few_stops: Vec<usize>,
    /// Knots of the operators' responses, s. Further ones follow if the linear law has a longer
    /// memory.
    pub knots_s: Vec<f64>,
    /// Decay speeds of the terms for slow motion.
    pub slow_speeds: Vec<f64>,
    /// Operator of those terms, by index.
    pub slow_stop: usize,
    /// Operators whose magnitude, and whose product with the harmonics, is used, by index.
    pub shape_stops: Vec<usize>,
    /// Speeds from which on the saturated viscous friction is constant.
    #[serde(alias = "drag_speeds")]
    pub viscous_speeds: Vec<f64>,
    /// Half-width of the backlash at the start of the search.
    #[serde(alias = "play_half_width")]
    pub backlash_half_width: f64,
    /// Maximum number of passes of viscous friction and backlash; zero for none.
    #[serde(alias = "play_passes")]
    pub backlash_passes: usize,
    /// Minimum gain in mean square, as a share, for a richer stage.
    pub least_gain: f64,
    /// Number of standard errors by which the gain must exceed zero.
    pub standard_errors: f64,
    /// Largest accepted loss in mean square, as a share, at speeds left out of the fit.
    pub carry_loss: f64,
    /// Ratio of the mean squares at such speeds below which a stage is accepted that is only as
    /// good at the others.
    pub carry_gain: f64,
    /// Ratio of the mean square at such speeds to that at the others above which the freest columns
    /// (slow motion, direction, position harmonics) are rejected: the log has too few speeds to fit
    /// them.
    pub carry_ratio: f64,
    /// Settings of the search for position harmonics.
    #[serde(alias = "lines")]
    pub harmonics: HarmonicRecipe,
    /// Settings of the friction map.
    pub map: MapRecipe,
}

/// Settings of the fit of the friction map.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MapRecipe {
    /// Iterations of the fit; zero for no map.
    pub rounds: usize,
    /// Number of positions along the travel.
    pub places: usize,
    /// Candidates for the correlation length of the level, as shares of the travel.
    pub lengths: Vec<f64>,
    /// Candidates for the standard deviation of the level from 1.
    pub deviations: Vec<f64>,
    /// Candidates for the standard deviation of the difference between the directions, as shares of
    /// that of the level.
    pub odd_shares: Vec<f64>,
    /// Minimum gain in mean square, as a share, for a map.
    pub least_gain: f64,
    /// Number of standard errors by which that gain must exceed zero.
    pub standard_errors: f64,
}

/// Maximum number of positions of a map: each takes two columns.
const MOST_POSITIONS: usize = 500;

impl MapRecipe {
    /// Checks that a map can be fitted with these settings.
    ///
    /// # Errors
    /// When a setting is out of range; the message has its name and range.
    pub fn check(&self) -> Result<(), TrainingError> {
        let positive = |values: &[f64]| values.iter().all(|value| value.is_finite() && *value > 0.0);
        let wrong = if !(2..=MOST_POSITIONS).contains(&self.places) {
            format!("map.places is {}: it must be 2 to {MOST_POSITIONS}", self.places)
        } else if !(positive(&self.lengths) && positive(&self.deviations) && positive(&self.odd_shares)) {
            "map.lengths, map.deviations and map.odd_shares must be positive numbers".to_owned()
        } else {
            return Ok(());
        };
        Err(TrainingError::Unusable(format!("{wrong}; map.rounds = 0 goes without a map")))
    }
}

impl Default for MapRecipe {
    fn default() -> Self {
        Self {
            rounds: 2,
            places: 49,
            lengths: vec![1.0 / 48.0, 1.0 / 24.0, 1.0 / 12.0, 1.0 / 6.0],
            deviations: vec![0.1, 0.3],
            odd_shares: vec![0.1, 0.5],
            least_gain: 0.01,
            standard_errors: 2.0,
        }
    }
}

/// Settings of the search for position harmonics.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct HarmonicRecipe {
    /// Iterations of the search; zero for no harmonics.
    pub rounds: usize,
    /// Maximum number of harmonics per iteration.
    pub per_round: usize,
    /// Number of peaks, strongest first, of which one must be confirmed for the search to continue.
    pub tried: usize,
    /// Minimum gain in mean square, as a share, for a harmonic or one of its effects.
    pub least_gain: f64,
    /// Number of standard errors by which that gain must exceed zero.
    pub standard_errors: f64,
    /// Maximum number of harmonics.
    pub at_most: usize,
    /// Lowest frequency, in cycles over the travel.
    pub lowest_cycles: f64,
    /// Spacing of the frequencies of the search, in cycles over the travel.
    pub spacing_cycles: f64,
    /// Highest frequency, 1/unit.
    pub highest: f64,
    /// Frequency above which a harmonic belongs to the motor (ripple, cogging), 1/unit.
    pub fine_above: f64,
    /// Minimum ratio of a peak to the median around it.
    pub peak_over_median: f64,
    /// Number of frequencies on either side for that median.
    pub median_bins: usize,
    /// Slowest motion of which the residual is used, unit/s.
    pub slowest: f64,
    /// Number of responses for the products of operators and harmonics.
    pub filters: usize,
    /// Iterations of the frequency refinement.
    pub refinements: usize,
    /// Largest change of a frequency in one iteration, 1/unit.
    pub largest_step: f64,
}

/// Share of the initial half-width of the backlash below which there is no backlash.
const LEAST_BACKLASH: f64 = 0.05;

impl StagedRecipe {
    /// Half-width below which there is no backlash on an axis whose lengths are those of the recipe
    /// times `unit`.
    pub(super) fn least_half_width(&self, unit: f64) -> f64 {
        LEAST_BACKLASH * self.backlash_half_width * unit
    }
}

impl Default for StagedRecipe {
    fn default() -> Self {
        let knots = [-80, -65, -52, -40, -30, -24, -19, -15, -12, -10, -8, -7, -6, -5, -4, -3, -2, -1, 0, 1, 2];
        Self {
            speed_unit: 80.0,
            folds: 8,
            memory_s: vec![0.01, 0.02, 0.03, 0.05, 0.1, 0.2],
            memories: 4.0,
            dense_s: 0.05,
            lag_growth: 0.08,
            future_s: 0.05,
            correlated: 3.0,
            linear_ridge: 1e-6,
            ridges: vec![5e-5, 2e-4, 5e-4, 1e-3],
            ridge_slack: 0.002,
            stop_half_widths: vec![1.5e-3, 3e-3, 5e-3, 8e-3, 13e-3, 22e-3, 40e-3, 80e-3, 200e-3, 600e-3],
            few_stops: vec![1, 5, 8],
            knots_s: knots.map(|lag| f64::from(lag) * 0.002).to_vec(),
            slow_speeds: vec![1.5, 5.0, 15.0],
            slow_stop: 1,
            shape_stops: vec![1, 3, 5, 7],
            viscous_speeds: vec![0.1, 0.3, 1.0, 3.0],
            backlash_half_width: 3e-3,
            backlash_passes: 4,
            least_gain: 0.02,
            standard_errors: 1.0,
            carry_loss: 0.25,
            carry_gain: 0.5,
            carry_ratio: 4.0,
            harmonics: HarmonicRecipe::default(),
            map: MapRecipe::default(),
        }
    }
}

impl Default for HarmonicRecipe {
    fn default() -> Self {
        Self {
            rounds: 2,
            per_round: 6,
            tried: 4,
            least_gain: 2e-3,
            standard_errors: 2.0,
            at_most: 12,
            lowest_cycles: 1.5,
            spacing_cycles: 0.25,
            highest: 3.0,
            fine_above: 0.35,
            peak_over_median: 6.0,
            median_bins: 81,
            slowest: 3.0,
            filters: 4,
            refinements: 3,
            largest_step: 2e-3,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_that_cannot_be_fitted_is_refused_by_name() {
        assert!(MapRecipe::default().check().is_ok());
        for places in [0, 1, 4_000_000_000] {
            let refused = MapRecipe { places, ..MapRecipe::default() }.check();
            assert!(refused.is_err_and(|error| error.to_string().contains("map.places")));
        }
        assert!(MapRecipe { lengths: vec![-1.0], ..MapRecipe::default() }.check().is_err());
        assert!(MapRecipe { odd_shares: vec![0.0], ..MapRecipe::default() }.check().is_err());
        assert!(MapRecipe { deviations: vec![f64::NAN], ..MapRecipe::default() }.check().is_err());
    }
}
