//! Excitation runs recorded on a simulated machine.

use datasets::{ExcitationPlan, Log, excite};
use machine::{AxisSpec, Machine, MachineSpec, ProgramWords, SimulatedMachine};
use motion::{AxisKind, Trajectory, poses_of};

use crate::error::{Error, Result};
use crate::setup::Setup;
use crate::units::in_programs;

/// Half of the default travel of linear axes in excitation, mm.
pub const TRAVEL_MM: f64 = 60.0;

/// Half of the default travel of rotary axes in excitation, rad.
pub const TURN_RAD: f64 = std::f64::consts::PI;
/// Share of an axis's own travel that excitation uses, so that it stops before the ends.
const OF_TRAVEL: f64 = 0.9;

/// Where excitation moves.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    /// Linear axes keep within ± this range about the origin, mm.
    pub travel_mm: f64,
    /// Rotary axes keep within ± this range about the origin, rad.
    pub turn_rad: f64,
    /// Position of axes in the middle of the motion, by name, mm or rad. Of others: 0, or as near to it as the motion fits.
    pub origin: Vec<(String, f64)>,
}

impl Default for Region {
    fn default() -> Self {
        Self { travel_mm: TRAVEL_MM, turn_rad: TURN_RAD, origin: Vec::new() }
    }
}

/// Lowest and highest position of every axis during excitation, mm or rad: the region, within the axes' own travel.
///
/// # Errors
/// When the origin names an axis that the machine lacks, or lies outside of an axis's travel.
pub fn travel(spec: &MachineSpec, region: &Region) -> Result<Vec<(f64, f64)>> {
    if let Some((axis, _)) = region.origin.iter().find(|(axis, _)| !spec.axes.iter().any(|of| of.name() == axis)) {
        let known = spec.axes.iter().map(|axis| axis.name().to_owned()).collect();
        return Err(Error::OriginOfNoAxis { axis: axis.clone(), known });
    }
    spec.axes.iter().map(|axis| range(axis, region)).collect()
}

/// Lowest and highest position of an axis.
fn range(axis: &AxisSpec, region: &Region) -> Result<(f64, f64)> {
    let half = if axis.axis().kind == AxisKind::Rotary { region.turn_rad } else { region.travel_mm };
    let stated = region.origin.iter().find(|(name, _)| name == axis.name()).map(|(_, origin)| *origin);
    let Some([low, high]) = axis.travel() else {
        let origin = stated.unwrap_or_default();
        return Ok((origin - half, origin + half));
    };
    let (middle, reach) = (f64::midpoint(low, high), 0.5 * OF_TRAVEL * (high - low));
    let (lowest, highest) = (middle - reach, middle + reach);
    match stated {
        Some(origin) if !(lowest..=highest).contains(&origin) => {
            let (scale, unit) = in_programs(axis.axis().kind);
            let [origin, low, high] = [origin, lowest, highest].map(|position| position * scale);
            Err(Error::OriginOutside { axis: axis.name().to_owned(), origin, low, high, unit })
        }
        Some(origin) => Ok((f64::max(lowest, origin - half), f64::min(highest, origin + half))),
        None => {
            let half = half.min(reach);
            let origin = 0.0_f64.clamp(lowest + half, f64::max(highest - half, lowest + half));
            Ok((origin - half, origin + half))
        }
    }
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
    let travel = travel(spec, &Region { travel_mm, ..Region::default() })?;
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
