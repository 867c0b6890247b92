//! A recorded run of a program beside its plan.

use motion::{DesiredPath, Plan, Trajectory};

/// How a program is planned that a control ran otherwise.
#[derive(Debug)]
pub struct Recording {
    /// The plan of the program.
    pub plan: Plan,
    /// Command by that plan, where it is not the plan itself.
    pub command: Option<Trajectory>,
    /// Planned path in the time of the run. The path that the part is compensated for keeps the corners as they were recorded.
    pub desired: DesiredPath,
    /// For every sample of the run how far it is from corners: 0 next to one, 1 away from all.
    pub away: Vec<f64>,
    /// Position in the plan of every sample of the run, as a sample index with fraction.
    pub path_positions: Vec<f64>,
}

impl Recording {
    /// Command by the plan.
    #[must_use]
    pub fn command(&self) -> &Trajectory {
        self.command.as_ref().unwrap_or(self.plan.desired.trajectory())
    }
}
