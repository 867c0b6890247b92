//! Whether learning goes on after a run, and which run was the best.

use crate::statistics::Figures;

/// Why learning ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// The last program is worse than the best one.
    Worse,
    /// No other program is expected to be better than the best one.
    NoGain,
}

impl Ended {
    /// Name in figures.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Worse => "worse",
            Self::NoGain => "no-gain",
        }
    }
}

/// Ratios of RMS and MAX of the last run to those of the best one above which its program counts as worse. Runs of one program with four noise
/// seeds differ by up to 3 % in RMS and 16 % in MAX (`simulate --seed` of the compensated `nist_box_op4_engraving.nc` on `ballscrew`).
const WORSE: [f64; 2] = [1.05, 1.3];
/// Ratio of the forecast RMS of the best program to the measured one up to which the forecast explains the run: noise adds to a run, so that a
/// forecast above it is wrong.
const EXPLAINS: f64 = 1.05;
/// Least expected decrease of the RMS for which a new program is written, as a share: a third of those differences.
const LEAST_GAIN: f64 = 0.01;
/// Ratio up to which the forecast MAX of a new program may exceed the lowest one of the programs so far.
const MOST_GROWTH: f64 = 1.05;

/// Index of the run with the lowest error; `None` without runs.
#[must_use]
pub fn best_of(runs: &[Figures]) -> Option<usize> {
    (0..runs.len()).min_by(|a, b| runs[*a].cost_mm().total_cmp(&runs[*b].cost_mm()))
}

/// Whether the last run was worse than the best one by more than noise.
#[must_use]
pub fn last_is_worse(runs: &[Figures]) -> bool {
    let Some((last, best)) = runs.last().zip(best_of(runs).map(|best| &runs[best])) else { return false };
    last.cost_mm() > WORSE[0] * best.cost_mm() || last.tip.max_mm > WORSE[1] * best.tip.max_mm
}

/// Expected runs, from the forecasts of the programs so far and of the next one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Expected {
    /// RMS of what differs from run to run or cannot be predicted, mm.
    pub rest_mm: f64,
    /// RMS of another run of the best program, mm.
    pub best_mm: f64,
    /// RMS of a run of the next program, mm.
    pub next_mm: f64,
    /// Whether the next program is better by more than noise, its MAX is not larger, and the forecast explains the best run.
    pub gains: bool,
}

impl Expected {
    /// From the index of the best run, the measured figures of all runs, the forecasts of their programs, and the forecast of the next program, all
    /// over the same samples. What the forecasts leave of the measured error is as large in the next run, and independent of the forecast.
    #[must_use]
    pub fn of(best: usize, measured: &[Figures], forecasts: &[Figures], next: &Figures) -> Self {
        let squares = measured.iter().zip(forecasts).map(|(run, forecast)| run.cost_mm().powi(2) - forecast.cost_mm().powi(2));
        let rest = (squares.sum::<f64>() / measured.len().max(1) as f64).max(0.0);
        let with_rest = |forecast: &Figures| (forecast.cost_mm().powi(2) + rest).sqrt();
        let (best_mm, next_mm) = (with_rest(&forecasts[best]), with_rest(next));
        let lowest_max = forecasts.iter().map(|forecast| forecast.tip.max_mm).fold(f64::INFINITY, f64::min);
        let explains = forecasts[best].cost_mm() <= EXPLAINS * measured[best].cost_mm();
        let gains = explains && next_mm < (1.0 - LEAST_GAIN) * best_mm && next.tip.max_mm <= MOST_GROWTH * lowest_max;
        Self { rest_mm: rest.sqrt(), best_mm, next_mm, gains }
    }
}

#[cfg(test)]
mod tests {
    use motion::contour::ContourSummary;

    use super::*;

    fn figures(rms_mm: f64, max_mm: f64) -> Figures {
        Figures { tip: ContourSummary { rms_mm, mean_mm: rms_mm, max_mm, p95_mm: max_mm, max_at: 0 }, orientation: None }
    }

    fn runs(of: &[(f64, f64)]) -> Vec<Figures> {
        of.iter().map(|(rms, max)| figures(*rms, *max)).collect()
    }

    #[test]
    fn the_last_run_is_worse_where_rms_or_max_grow_by_more_than_noise() {
        assert_eq!(best_of(&runs(&[(0.27, 2.4), (0.24, 1.9), (0.25, 1.5)])), Some(1));
        assert!(!last_is_worse(&runs(&[(0.27, 2.4), (0.24, 1.9), (0.25, 2.1)])));
        assert!(last_is_worse(&runs(&[(0.24, 1.9), (0.27, 1.9)])));
        assert!(last_is_worse(&runs(&[(0.24, 1.9), (0.24, 2.9)])));
        // A run that was worse ends nothing after a good one.
        assert!(!last_is_worse(&runs(&[(0.24, 1.9), (0.4, 4.0), (0.24, 1.9)])));
        assert!(best_of(&[]).is_none() && !last_is_worse(&[]));
    }

    #[test]
    fn a_next_program_needs_a_gain_above_the_noise_and_no_larger_max() {
        let measured = runs(&[(0.26, 2.0), (0.26, 2.0)]);
        let forecasts = runs(&[(0.1, 1.0), (0.1, 1.1)]);
        let gains = |rms: f64, max: f64| Expected::of(0, &measured, &forecasts, &figures(rms, max)).gains;
        assert!(gains(0.05, 1.0) && gains(0.05, 1.04));
        assert!(!gains(0.05, 1.06), "MAX grows");
        assert!(!gains(0.095, 1.0), "0.2579 instead of 0.26");
        // A forecast of 0.3 for a run of 0.26 is no ground for another program.
        assert!(!Expected::of(0, &measured, &runs(&[(0.3, 1.0), (0.1, 1.0)]), &figures(0.05, 1.0)).gains);
        let expected = Expected::of(0, &measured, &forecasts, &figures(0.0, 0.0));
        assert!((expected.rest_mm - 0.24).abs() < 1e-9 && (expected.best_mm - 0.26).abs() < 1e-9);
        assert_eq!(expected.next_mm, expected.rest_mm);
    }
}
