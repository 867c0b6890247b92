//! One recorded run.

use motion::{Axis, AxisKind, Trajectory};

use crate::resample::resample;
use crate::{Check, DatasetError, Finding, Severity};

/// Largest relative difference of equal periods.
const SAME_PERIOD: f64 = 1e-6;
/// Minimum number of samples for interpolation.
const FEWEST: usize = 4;

/// One run of a machine: commanded and reported positions at the same instants.
#[derive(Debug, Clone, PartialEq)]
pub struct Log {
    /// Name of the run, for messages; the file name without extension if it was read from a file.
    pub name: String,
    /// Commanded positions, mm or rad.
    pub reference: Trajectory,
    /// Reported positions, mm or rad, with the axes, period and length of the reference.
    pub actual: Trajectory,
    /// Time stamp of the first sample, s; zero if unknown.
    pub start_s: f64,
}

impl Log {
    /// A run from its two trajectories.
    ///
    /// # Errors
    /// When axes, period or length differ.
    pub fn new(name: impl Into<String>, reference: Trajectory, actual: Trajectory) -> Result<Self, DatasetError> {
        reference.check_matches(&actual)?;
        Ok(Self { name: name.into(), reference, actual, start_s: 0.0 })
    }

    /// The same run with another time stamp of its first sample, s.
    #[must_use]
    pub fn starting_at(self, start_s: f64) -> Self {
        Self { start_s, ..self }
    }

    /// The axes, in column order.
    #[must_use]
    pub fn axes(&self) -> &[Axis] {
        self.reference.axes()
    }

    /// Time between samples, s.
    #[must_use]
    pub fn period_s(&self) -> f64 {
        self.reference.period_s()
    }

    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.reference.len().min(self.actual.len())
    }

    /// Whether there is no sample.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The run at another period, interpolated like uneven time stamps, with a finding; unchanged
    /// if the period is its own.
    ///
    /// # Errors
    /// When the period is not positive, or there are too few samples for interpolation.
    pub fn resampled(&self, period_s: f64) -> Result<(Self, Option<Finding>), DatasetError> {
        let own_s = self.period_s();
        let same = (period_s / own_s - 1.0).abs() < SAME_PERIOD;
        if !same && self.len() < FEWEST {
            return Err(DatasetError::BadSetting {
                name: "the number of samples to be resampled",
                value: self.len() as f64,
                remedy: "log a whole run",
            });
        }
        let times: Vec<f64> = (0..self.len()).map(|k| k as f64 * own_s).collect();
        let at = |trajectory: &Trajectory| {
            let columns = trajectory.columns().iter();
            let columns = columns.map(|column| if same { column.clone() } else { resample(&times, column, period_s) });
            Trajectory::new(period_s, self.axes().to_vec(), columns.collect())
        };
        let log = Self::new(self.name.clone(), at(&self.reference)?, at(&self.actual)?)?.starting_at(self.start_s);
        let (own_ms, period_ms) = (1e3 * own_s, 1e3 * period_s);
        let loss = if own_s > period_s { ": fast detail between its samples is lost; log at that rate" } else { "" };
        let message = format!(
            "sampled every {own_ms:.3} ms, resampled onto a uniform grid of {period_ms:.3} ms by cubic interpolation{loss}"
        );
        Ok((log, (!same).then(|| Finding::new(Severity::Warn, Check::Timing, message))))
    }

    /// The run with only these axes, in this order.
    ///
    /// # Errors
    /// When the log lacks an axis; the message names the first one.
    pub fn with_axes(&self, axes: &[Axis]) -> Result<Self, DatasetError> {
        let pick = |trajectory: &Trajectory| {
            let column = |axis: &Axis| match trajectory.axes().iter().position(|own| own == axis) {
                Some(index) => Ok(trajectory.columns()[index].clone()),
                None => Err(DatasetError::Runs(format!(
                    "`{}` has no columns of the {} axis {axis}; its axes are {}",
                    self.name,
                    if axis.kind == AxisKind::Linear { "linear" } else { "rotary" },
                    self.axes().iter().map(ToString::to_string).collect::<Vec<_>>().join(" ")
                ))),
            };
            let columns = axes.iter().map(column).collect::<Result<_, _>>()?;
            Ok::<_, DatasetError>(Trajectory::new(trajectory.period_s(), axes.to_vec(), columns)?)
        };
        Ok(Self::new(self.name.clone(), pick(&self.reference)?, pick(&self.actual)?)?.starting_at(self.start_s))
    }

    /// Samples `start..end` as a run of its own; the range is clipped to the log.
    ///
    /// # Errors
    /// Never for a log whose trajectories match.
    pub fn part(&self, name: impl Into<String>, start: usize, end: usize) -> Result<Self, DatasetError> {
        let end = end.min(self.len());
        let start = start.min(end);
        let cut = |trajectory: &Trajectory| {
            trajectory.with_columns(trajectory.columns().iter().map(|column| column[start..end].to_vec()).collect())
        };
        let start_s = self.start_s + start as f64 * self.period_s();
        Ok(Self::new(name, cut(&self.reference)?, cut(&self.actual)?)?.starting_at(start_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn log(period_s: f64) -> Log {
        let column = |late: f64| (0..200).map(|k| (20.0 * (f64::from(k) * period_s - late)).sin()).collect::<Vec<f64>>();
        let axes = ["x", "y"].map(Axis::named).to_vec();
        let trajectory = |late| Trajectory::new(period_s, axes.clone(), vec![column(late), column(2.0 * late)]).unwrap();
        Log::new("run", trajectory(0.0), trajectory(0.003)).unwrap()
    }

    #[test]
    fn another_period_keeps_the_run_and_is_reported() {
        let (fine, coarse) = (log(0.001), log(0.002));
        let (at_two, finding) = fine.resampled(0.002).unwrap();
        assert_eq!(at_two.len(), 100);
        assert!(!finding.unwrap().message.contains("lost"));
        let (at_one, finding) = coarse.resampled(0.001).unwrap();
        assert!(finding.unwrap().message.contains("every 2.000 ms, resampled onto a uniform grid of 1.000 ms"));
        for (found, wanted) in at_one.actual.columns()[1].iter().zip(&fine.actual.columns()[1]).take(200) {
            assert!((found - wanted).abs() < 1e-4, "{found} {wanted}");
        }
        let (same, finding) = fine.resampled(0.001).unwrap();
        assert!(same == fine && finding.is_none());
        assert!(fine.part("few", 0, 3).unwrap().resampled(0.002).unwrap_err().to_string().contains("log a whole run"));
    }

    #[test]
    fn axes_are_picked_by_name_and_kind() {
        let log = log(0.002);
        let turned = log.with_axes(&["y", "x"].map(Axis::named)).unwrap();
        assert_eq!(turned.reference.columns()[1], log.reference.columns()[0]);
        let missing = log.with_axes(&["x", "a"].map(Axis::named)).unwrap_err().to_string();
        assert_eq!(missing, "`run` has no columns of the rotary axis a; its axes are x y");
    }
}
