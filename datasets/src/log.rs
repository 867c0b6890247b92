//! One recorded run.

use motion::{Axis, Trajectory};

use crate::DatasetError;

/// One run of a machine: what was commanded and what the encoders reported, at the same instants.
#[derive(Debug, Clone, PartialEq)]
pub struct Log {
    /// Name of the run, for messages; the file's name without its ending where it was read from one.
    pub name: String,
    /// Commanded positions, mm or rad.
    pub reference: Trajectory,
    /// Reported positions, mm or rad, with the axes, period and length of the reference.
    pub actual: Trajectory,
}

impl Log {
    /// A run from its two trajectories.
    ///
    /// # Errors
    /// When axes, period or length differ.
    pub fn new(name: impl Into<String>, reference: Trajectory, actual: Trajectory) -> Result<Self, DatasetError> {
        reference.check_matches(&actual)?;
        Ok(Self { name: name.into(), reference, actual })
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
        Self::new(name, cut(&self.reference)?, cut(&self.actual)?)
    }
}
