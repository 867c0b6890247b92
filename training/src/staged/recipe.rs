//! The settings of the fit.

use serde::{Deserialize, Serialize};

use crate::TrainingError;

/// How a staged predictor is fitted; the defaults need no change from machine to machine.
///
/// Lengths and speeds are for an axis whose top speed in the log is `speed_unit`; they are scaled by the top speed that is found, so
/// that the unit of the axis (mm, rad, degrees) does not matter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct StagedRecipe {
    /// Top speed for which the lengths and speeds below are meant, unit/s.
    pub speed_unit: f64,
    /// Folds of the cross-validation: whole runs where there are at least as many, else contiguous blocks.
    pub folds: usize,
    /// Time constants that are tried for the linear law's response to die out, s, shortest first.
    pub memory_s: Vec<f64>,
    /// Window of the linear law in such time constants.
    pub memories: f64,
    /// Time back to which the linear law's response is free at every sample, s: about as long as resonances ring.
    pub dense_s: f64,
    /// Share of the time beyond that over which the response is linear.
    pub lag_growth: f64,
    /// Longest window of the linear law after the present, s.
    pub future_s: f64,
    /// Samples over which errors are alike, so that many samples weigh no more than their independent ones.
    pub correlated: f64,
    /// Ridge of the linear law, on columns of unit RMS.
    pub linear_ridge: f64,
    /// Ridges tried on the non-linear columns.
    pub ridges: Vec<f64>,
    /// Share of the mean square by which a stronger ridge may be worse than the best.
    pub ridge_slack: f64,
    /// Half-widths of the stop operators; none for the linear law alone.
    pub stop_half_widths: Vec<f64>,
    /// The operators of the smallest variant, by index.
    pub few_stops: Vec<usize>,
    /// Knots of the operators' responses, s; further ones follow where the linear law reaches further back.
    pub knots_s: Vec<f64>,
    /// Decay speeds of the terms that act in slow motion.
    pub slow_speeds: Vec<f64>,
    /// The operator that those decay on, by index.
    pub slow_stop: usize,
    /// The operators whose magnitude, and whose product with the lines, is used, by index.
    pub shape_stops: Vec<usize>,
    /// Speeds from which on a drag is constant.
    pub drag_speeds: Vec<f64>,
    /// Half-width of the play from which the search for the true one starts.
    pub play_half_width: f64,
    /// Most passes of drag and play; zero for none.
    pub play_passes: usize,
    /// Least gain in mean square, as a share, for which a richer stage is taken.
    pub least_gain: f64,
    /// Standard errors by which the gain has to be above zero.
    pub standard_errors: f64,
    /// Loss in mean square, as a share, that is let pass on speeds which were left out of the fit.
    pub carry_loss: f64,
    /// Share of the mean square on such speeds below which a stage is taken that is merely as good on the others.
    pub carry_gain: f64,
    /// Mean square on such speeds, over that on the others, above which the freest columns (slow motion, direction, position lines) are
    /// not trusted: the log has too few speeds to tell what they do between them.
    pub carry_ratio: f64,
    /// Position lines: how they are looked for.
    pub lines: LineRecipe,
    /// Friction map: how it is fitted.
    pub map: MapRecipe,
}

/// How the friction map is fitted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MapRecipe {
    /// Rounds of fitting; zero for no map.
    pub rounds: usize,
    /// Places along the travel.
    pub places: usize,
    /// Lengths over which the level is alike that are tried, as shares of the travel.
    pub lengths: Vec<f64>,
    /// Deviations of the level from 1 that are tried.
    pub deviations: Vec<f64>,
    /// Deviations of the difference between the directions that are tried, as shares of that of the level.
    pub odd_shares: Vec<f64>,
    /// Least gain in mean square, as a share, for which a map is taken.
    pub least_gain: f64,
    /// Standard errors by which that gain has to be above zero.
    pub standard_errors: f64,
}

/// Most places of a map: each takes two columns.
const MOST_PLACES: usize = 500;

impl MapRecipe {
    /// Checks that a map can be fitted with these settings.
    ///
    /// # Errors
    /// Names the setting and its range.
    pub fn check(&self) -> Result<(), TrainingError> {
        let positive = |values: &[f64]| values.iter().all(|value| value.is_finite() && *value > 0.0);
        let wrong = if !(2..=MOST_PLACES).contains(&self.places) {
            format!("map.places is {}: it must be 2 to {MOST_PLACES}", self.places)
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

/// How position lines are looked for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LineRecipe {
    /// Rounds of looking; zero for no lines.
    pub rounds: usize,
    /// Lines that a round adds at most.
    pub per_round: usize,
    /// Peaks, strongest first, of which one has to be confirmed for the search to go on.
    pub tried: usize,
    /// Least gain in mean square, as a share, for which a line, or a way in which it acts, is taken.
    pub least_gain: f64,
    /// Standard errors by which that gain has to be above zero.
    pub standard_errors: f64,
    /// Lines in all, at most.
    pub at_most: usize,
    /// Lowest frequency, in cycles over the travel.
    pub lowest_cycles: f64,
    /// Spacing of the frequencies looked at, in cycles over the travel.
    pub spacing_cycles: f64,
    /// Highest frequency, 1/unit.
    pub highest: f64,
    /// Frequency above which a line is a matter of the motor (ripple, cogging), 1/unit.
    pub fine_above: f64,
    /// A peak has to be this many times the median around it.
    pub peak_over_median: f64,
    /// Frequencies on either side over which that median goes.
    pub median_bins: usize,
    /// Slowest motion in which the residual is looked at, unit/s.
    pub slowest: f64,
    /// Responses through which operator × line products act.
    pub filters: usize,
    /// Rounds of frequency refinement.
    pub refinements: usize,
    /// Largest change of a frequency in one round, 1/unit.
    pub largest_step: f64,
}

/// Share of the play's half-width at the start below which there is no play.
const LEAST_PLAY: f64 = 0.05;

impl StagedRecipe {
    /// Half-width below which there is no play on an axis whose lengths are those of the recipe times `unit`.
    pub(super) fn least_half_width(&self, unit: f64) -> f64 {
        LEAST_PLAY * self.play_half_width * unit
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
            drag_speeds: vec![0.1, 0.3, 1.0, 3.0],
            play_half_width: 3e-3,
            play_passes: 4,
            least_gain: 0.02,
            standard_errors: 1.0,
            carry_loss: 0.25,
            carry_gain: 0.5,
            carry_ratio: 4.0,
            lines: LineRecipe::default(),
            map: MapRecipe::default(),
        }
    }
}

impl Default for LineRecipe {
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
