//! What a control does to every axis after interpolation.

use super::settings::{AxisFilter, PlanSettings};
use super::smooth;

/// Time after which a first-order lag has settled, in time constants: a thousandth of the way is left.
const SETTLED: f64 = 7.0;

/// The filters of all axes, in periods.
pub(super) struct Filters {
    axes: Vec<Discrete>,
    /// Moving averages of the motion along the path that delay it as the filters delay the axes, on average.
    along_path: [usize; 2],
    /// Periods after the end of a motion until every axis stands.
    settling: usize,
}

/// The filter of an axis, in periods.
struct Discrete {
    averages: [usize; 2],
    /// Share of the distance that the lag makes up in a period, 1 without one.
    share: f64,
}

impl Discrete {
    fn new(filter: &AxisFilter, period_s: f64) -> Self {
        let share = if filter.time_constant_s > 0.0 { -(-period_s / filter.time_constant_s).exp_m1() } else { 1.0 };
        Self { averages: filter.averages_s.map(|average_s| periods(average_s, period_s).max(1)), share }
    }

    fn apply(&self, column: &[f64]) -> Vec<f64> {
        let average = |column: Vec<f64>, window: &usize| match *window {
            1 => column,
            window => smooth::filtered(&column, window),
        };
        let mut out = self.averages.iter().fold(column.to_vec(), average);
        out.truncate(column.len());
        let mut at = out.first().copied().unwrap_or(0.0);
        for position in out.iter_mut().filter(|_| self.share < 1.0) {
            at += self.share * (*position - at);
            *position = at;
        }
        out
    }
}

fn periods(time_s: f64, period_s: f64) -> usize {
    (time_s / period_s).round() as usize
}

impl Filters {
    /// `None` if no axis is filtered.
    pub fn new(settings: &PlanSettings) -> Option<Self> {
        let (filters, period_s) = (&settings.filters, settings.period_s);
        let axes: Vec<Discrete> = filters.iter().map(|filter| Discrete::new(filter, period_s)).collect();
        if axes.iter().all(|axis| axis.averages == [1, 1] && axis.share >= 1.0) {
            return None;
        }
        let mean = |of: &dyn Fn(&AxisFilter) -> f64| filters.iter().map(of).sum::<f64>() / filters.len() as f64;
        // Two averages over a time constant each delay as much as the lag does, and end.
        let along_path = [0, 1].map(|k| mean(&|filter| filter.averages_s[k] + filter.time_constant_s));
        let along_path = along_path.map(|average_s| periods(average_s, period_s).max(1));
        let settling = |filter: &AxisFilter| {
            let averages: usize = Discrete::new(filter, period_s).averages.iter().map(|average| average - 1).sum();
            averages + periods(SETTLED * filter.time_constant_s, period_s)
        };
        let of_path = along_path.iter().map(|average| average - 1).sum();
        let settling = filters.iter().map(settling).fold(of_path, usize::max);
        Some(Self { axes, along_path, settling })
    }

    /// The motion along the path that goes with the filtered axes: as late, and lasting until they stand.
    pub fn along_path(&self, motion: Vec<f64>) -> Vec<f64> {
        let samples = motion.len() + self.settling;
        let mut motion = smooth::averaged(motion, self.along_path);
        hold(&mut motion, samples);
        motion
    }

    /// Rests at the end of a motion that is not filtered yet until the filters have settled.
    pub fn settle(&self, column: &mut Vec<f64>) {
        hold(column, column.len() + self.settling);
    }

    /// The command of every axis.
    pub fn apply(&self, columns: &[Vec<f64>]) -> Vec<Vec<f64>> {
        columns.iter().zip(&self.axes).map(|(column, axis)| axis.apply(column)).collect()
    }
}

/// Repeats the last value up to a length.
fn hold(column: &mut Vec<f64>, length: usize) {
    let last = column.last().copied();
    column.resize(length.max(column.len()), last.unwrap_or(0.0));
}
