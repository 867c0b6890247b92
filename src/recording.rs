//! Excitation runs, recorded on a simulated machine.

use anyhow::Result;
use datasets::{ExcitationPlan, Log, excite};
use machine::{Machine, MachineSpec};

use crate::input::{self, Frame};

/// Travel of the demo's and the tables' excitation: the axes keep within ± this, mm.
pub const TRAVEL_MM: f64 = 60.0;

/// Runs about `seconds` of excitation within ± `travel_mm` on the simulated machine of `spec`; one log a run.
///
/// # Errors
/// When the machine has no drives.
pub fn record(spec: &MachineSpec, seconds: f64, travel_mm: f64, seed: u64) -> Result<Vec<Log>> {
    let frame = Frame::of(spec);
    let travel = vec![(-travel_mm, travel_mm); spec.axes.len()];
    let plan = ExcitationPlan::of_seconds(seconds);
    let mut machine = input::simulated(spec, seed)?;
    excite(&plan, &frame.limits, frame.kinematics.axes(), &travel, frame.period_s, seed)?
        .into_iter()
        .map(|(name, reference)| {
            let actual = machine.run(&reference)?;
            Ok(Log::new(name, reference, actual)?)
        })
        .collect()
}
