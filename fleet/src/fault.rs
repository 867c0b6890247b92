//! Faults of simulated machines.

use std::fmt;
use std::str::FromStr;

use machine::{AxisSpec, MachineSpec};
use thiserror::Error;

use crate::error::{FleetError, Result};

/// A fault that one axis of one machine has from one day on.
#[derive(Debug, Clone, PartialEq)]
pub struct Fault {
    /// Number of the machine, from 1.
    pub machine: usize,
    /// Name of the axis.
    pub axis: String,
    /// What changes.
    pub kind: FaultKind,
    /// By how much: percent of friction or position gain, µm of backlash.
    pub size: f64,
    /// First day with the fault, from 1.
    pub day: usize,
}

/// What a fault changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FaultKind {
    /// Coulomb and static friction, percent.
    Friction,
    /// Width of the backlash, µm.
    Backlash,
    /// Position gain, percent.
    Gain,
}

impl FaultKind {
    const ALL: [Self; 3] = [Self::Friction, Self::Backlash, Self::Gain];

    fn name(self) -> &'static str {
        match self {
            Self::Friction => "friction",
            Self::Backlash => "backlash",
            Self::Gain => "gain",
        }
    }
}

/// A text that states no fault.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("write MACHINE:AXIS:KIND=SIZE@DAY, as in 2:x:friction=20@9 (percent), 1:y:backlash=5@4 (µm) or 3:z:gain=-10@5 (percent)")]
pub struct FaultSyntax;

/// Largest size of a fault: percent or µm.
const LARGEST: f64 = 1000.0;

impl FromStr for Fault {
    type Err = FaultSyntax;

    fn from_str(text: &str) -> std::result::Result<Self, FaultSyntax> {
        let parts = || {
            let (place, change) = text.split_once('=')?;
            let mut place = place.split(':');
            let (machine, axis, kind) = (place.next()?, place.next()?, place.next()?);
            let (size, day) = change.split_once('@')?;
            let fault = Self {
                machine: machine.parse().ok()?,
                axis: axis.to_owned(),
                kind: FaultKind::ALL.into_iter().find(|known| known.name() == kind)?,
                size: size.parse().ok()?,
                day: day.parse().ok()?,
            };
            let in_range = fault.size.abs() <= LARGEST && fault.machine >= 1 && fault.day >= 1;
            (place.next().is_none() && in_range).then_some(fault)
        };
        parts().ok_or(FaultSyntax)
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}={}@{}", self.machine, self.axis, self.kind.name(), self.size, self.day)
    }
}

impl Fault {
    /// Changes the machine.
    ///
    /// # Errors
    /// When the machine has no such axis, or the fault cannot be in its drive.
    pub fn apply(&self, spec: &mut MachineSpec) -> Result<()> {
        let refused = |reason: &str| FleetError::Fault { fault: self.to_string(), reason: reason.to_owned() };
        let axis = spec.axes.iter_mut().find(|axis| axis.name() == self.axis);
        let drive = match axis {
            Some(AxisSpec::Linear(axis)) => axis.drive.as_mut(),
            _ => None,
        };
        let drive =
            drive.ok_or_else(|| refused("the machine has no linear axis of this name with a drive; its axes are x, y and z"))?;
        let factor = 1.0 + 0.01 * self.size;
        if self.kind != FaultKind::Backlash && factor <= 0.0 {
            return Err(refused("nothing would be left; state more than -100 percent"));
        }
        match self.kind {
            FaultKind::Friction => {
                drive.friction.coulomb_n *= factor;
                drive.friction.static_n *= factor;
            }
            FaultKind::Backlash if drive.screw.rigid => {
                return Err(refused("the drive is rigid and has no backlash; take another machine"));
            }
            FaultKind::Backlash => {
                let half_um = &mut drive.screw.backlash_half_width_um;
                *half_um = (*half_um + 0.5 * self.size).max(0.0);
            }
            FaultKind::Gain => drive.loops.position_gain_1_s *= factor,
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_is_read_as_written_and_others_are_refused() {
        let fault: Fault = "2:x:friction=20@9".parse().unwrap();
        assert_eq!(
            (fault.machine, fault.axis.as_str(), fault.kind, fault.size, fault.day),
            (2, "x", FaultKind::Friction, 20.0, 9)
        );
        assert_eq!(fault.to_string(), "2:x:friction=20@9");
        for text in [
            "",
            "x:friction=20@9",
            "0:x:friction=20@9",
            "1:x:wear=20@9",
            "1:x:friction=20",
            "1:x:friction=nan@2",
            "1:x:y:gain=1@1",
        ] {
            assert_eq!(text.parse::<Fault>(), Err(FaultSyntax), "{text}");
        }
    }

    #[test]
    fn a_fault_changes_its_drive_alone_and_a_rigid_one_has_no_backlash() {
        let mut spec = MachineSpec::builtin("ballscrew").unwrap();
        let before = spec.clone();
        "1:x:backlash=5@1".parse::<Fault>().unwrap().apply(&mut spec).unwrap();
        let half = |spec: &MachineSpec, axis: usize| match &spec.axes[axis] {
            AxisSpec::Linear(axis) => axis.drive.as_ref().unwrap().screw.backlash_half_width_um,
            AxisSpec::Rotary(_) => 0.0,
        };
        assert!((half(&spec, 0) - half(&before, 0) - 2.5).abs() < 1e-12);
        assert_eq!(spec.axes[1], before.axes[1]);
        assert!("1:w:gain=5@1".parse::<Fault>().unwrap().apply(&mut spec).unwrap_err().to_string().contains("no linear axis"));
    }
}
