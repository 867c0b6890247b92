//! Acceptance of forecasts: the cost has to fall, and no figure may grow.

use compensation::Iteration;

use crate::statistics::Figures;

/// Relative difference between two forecasts up to which they count as equal: that on the reference and that on the replanned program, or
/// the largest error before and after, also beside moves that are not changed.
pub(super) const SAME_FORECAST: f64 = 0.02;

/// Cost of a forecast, mm: RMS plus a tenth of MAX, which is three to ten times as large.
pub(super) fn cost(figures: &Figures) -> f64 {
    cost_of(figures.cost_mm(), figures.tip.max_mm)
}

/// The same from the two figures, mm.
pub(super) fn cost_of(rms_mm: f64, max_mm: f64) -> f64 {
    rms_mm + 0.1 * max_mm
}

/// Acceptance bound of a forecast: its cost falls below the bound, and neither RMS nor MAX grows.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bound {
    measure: f64,
    cost_mm: f64,
    max_mm: f64,
}

impl Bound {
    /// Bound relative to a first run, of whose cost the share `gain` has to be gained.
    pub fn of((iteration, figures): &(Iteration, Figures), gain: f64) -> Self {
        Self { measure: (1.0 - gain) * iteration.measure, cost_mm: figures.cost_mm(), max_mm: figures.tip.max_mm }
    }

    pub fn holds(self, measure: f64, figures: &Figures) -> bool {
        measure < self.measure && figures.cost_mm() <= self.cost_mm && figures.tip.max_mm <= self.max_mm
    }
}

/// Index of the run with the lowest cost; 0 where none is below that of the first run.
pub(super) fn least(runs: &[(Iteration, Figures)]) -> usize {
    (0..runs.len()).min_by(|a, b| runs[*a].0.measure.total_cmp(&runs[*b].0.measure)).unwrap_or_default()
}

/// Index of the run with the lowest cost within the bound.
pub(super) fn best(runs: &[(Iteration, Figures)], most: Bound) -> Option<usize> {
    let measure = |run: &usize| runs[*run].0.measure;
    let held = (0..runs.len()).filter(|run| most.holds(measure(run), &runs[*run].1));
    held.min_by(|a, b| measure(a).total_cmp(&measure(b)))
}

#[cfg(test)]
mod tests {
    use motion::contour::ContourSummary;

    use super::*;

    #[test]
    fn a_forecast_that_gains_in_max_and_loses_in_rms_is_refused_and_the_other_way_round() {
        let figures = |rms_mm: f64, max_mm: f64| {
            let tip = ContourSummary { rms_mm, mean_mm: rms_mm, max_mm, p95_mm: max_mm, max_at: 0 };
            Figures { tip, orientation: None }
        };
        let reference = motion::Trajectory::new(0.002, motion::Axis::xyz(), vec![vec![0.0; 3]; 3]).unwrap();
        let run = |rms_mm: f64, max_mm: f64| {
            let figures = figures(rms_mm, max_mm);
            (Iteration { reference: reference.clone(), actual: reference.clone(), measure: cost(&figures) }, figures)
        };
        let runs =
            [run(2.6e-3, 28.0e-3), run(3.0e-3, 15.0e-3), run(2.0e-3, 29.0e-3), run(2.5e-3, 27.0e-3), run(2.59e-3, 28.0e-3)];
        let bound = Bound::of(&runs[0], 0.0);
        // The second and the third run have lower costs than the fourth.
        assert!(runs[1].0.measure < runs[3].0.measure && runs[2].0.measure < runs[3].0.measure);
        assert_eq!(best(&runs, bound), Some(3));
        assert_eq!(best(&runs, Bound::of(&runs[0], 0.05)), None);
    }
}
