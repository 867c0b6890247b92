//! Excitation runs recorded on a simulated machine.

use datasets::{ExcitationPlan, Log, excite};
use machine::{AxisSpec, Machine, MachineSpec, ProgramWords, SimulatedMachine};
use motion::{AxisKind, Trajectory, poses_of};

use crate::error::Result;
use crate::setup::Setup;

/// Half of the default travel of linear axes in excitation, mm.
pub const TRAVEL_MM: f64 = 60.0;

/// Half of the default travel of rotary axes in excitation, rad.
pub const TURN_RAD: f64 = std::f64::consts::PI;
/// Share of an axis's own travel that excitation uses, so that it stops before the ends.
const OF_TRAVEL: f64 = 0.9;

/// Lowest and highest position of every axis during excitation, mm or rad: ± `travel_mm`, rotary axes ± `turn_rad`,
/// within the axes' own travel.
#[must_use]
pub fn travel(spec: &MachineSpec, travel_mm: f64, turn_rad: f64) -> Vec<(f64, f64)> {
    let of = |axis: &AxisSpec| {
        let half = if axis.axis().kind == AxisKind::Rotary { turn_rad } else { travel_mm };
        let [low, high] = axis.travel().unwrap_or([-half / OF_TRAVEL, half / OF_TRAVEL]);
        let (middle, reach) = (f64::midpoint(low, high), 0.5 * OF_TRAVEL * (high - low));
        (f64::max(middle - reach, -half), f64::min(middle + reach, half))
    };
    spec.axes
        .iter()
        .map(of)
        // A travel that does not reach the requested range is used as it is.
        .zip(&spec.axes)
        .map(|(range, axis)| if range.0 < range.1 { range } else { axis.travel().map_or(range, |[low, high]| (low, high)) })
        .collect()
}

/// The positions that the words of a program have to state: on a control whose words are the tool tip's, those of the tip.
///
/// # Errors
/// When the axes of `reference` are not those of the setup.
pub fn in_program_words(reference: &Trajectory, setup: &Setup) -> Result<Trajectory> {
    if setup.words == ProgramWords::Axes {
        return Ok(reference.clone());
    }
    let mut columns = reference.columns().to_vec();
    for (k, pose) in poses_of(reference, setup.kinematics.as_ref())?.iter().enumerate() {
        for (slot, name) in ["x", "y", "z"].iter().enumerate() {
            if let Some(axis) = reference.axes().iter().position(|axis| axis.name == *name) {
                columns[axis][k] = pose.tip[slot];
            }
        }
    }
    Ok(reference.with_columns(columns)?)
}

/// Records about `seconds` of excitation within [`travel`] on the simulated machine of `spec`; one log for each run. The demo
/// uses 120 s.
///
/// # Errors
/// When the description has no drives.
pub fn record(spec: &MachineSpec, seconds: f64, travel_mm: f64, seed: u64) -> Result<Vec<Log>> {
    let setup = Setup::new(spec, None)?;
    let travel = travel(spec, travel_mm, TURN_RAD);
    let plan = ExcitationPlan::of_seconds(seconds);
    let mut machine = SimulatedMachine::new(spec, seed)?;
    excite(&plan, &setup.limits, setup.kinematics.axes(), &travel, setup.period_s, seed)?
        .into_iter()
        .map(|(name, reference)| {
            let actual = machine.run(&reference)?;
            Ok(Log::new(name, reference, actual)?)
        })
        .collect()
}
