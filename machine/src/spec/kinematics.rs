//! Kinematics in a machine file.

use serde::{Deserialize, Deserializer, Serialize};

use super::AxisSpec;
use super::check::{finite, not_negative};
use crate::MachineError;

/// Kinematics: `kind = "cartesian"` or `"five-axis"`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum KinematicsSpec {
    /// Perpendicular linear axes, upright tool.
    #[default]
    #[serde(deserialize_with = "nothing_more")]
    Cartesian,
    /// Linear axes `x`, `y`, `z` and one or two rotary axes that tilt the tool relative to the
    /// workpiece.
    FiveAxis(FiveAxisSpec),
}

/// Linear axes `x`, `y`, `z` with one or two rotary axes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FiveAxisSpec {
    /// From the spindle nose to the tool tip, mm.
    pub tool_length_mm: f64,
    /// Meaning of program words without G43.4.
    #[serde(default)]
    pub programs: ProgramWords,
    /// The rotary axes, from the bed outwards: of two in the table the first carries the second,
    /// likewise in the head.
    #[serde(default)]
    pub rotary: Vec<RotaryJointSpec>,
}

/// Meaning of program words without G43.4.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ProgramWords {
    /// Positions of the axes.
    #[default]
    Axes,
    /// Tool tip in the workpiece frame, and positions of the rotary axes.
    Tip,
}

/// Mounting of a rotary axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RotaryJointSpec {
    /// Name of a rotary axis of the machine.
    pub axis: String,
    /// Mounting side.
    pub mount: Mount,
    /// Direction of the axis in the machine frame, all rotary axes at 0, any length. A positive
    /// angle rotates the tool right-handed about it as seen from the workpiece (ISO 841), so a
    /// table itself rotates left-handed. Reverse it for a control with the opposite sign.
    pub direction: [f64; 3],
    /// A point on the axis, all rotary axes at 0, machine frame, mm: from workpiece zero for a
    /// table axis, from the spindle nose for a head axis.
    pub pivot_mm: [f64; 3],
}

/// Mounting side of a rotary axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Mount {
    /// The workpiece.
    Table,
    /// The tool.
    Head,
}

/// Refuses every key: `deny_unknown_fields` alone accepts the keys of other variants for a variant
/// without fields.
fn nothing_more<'de, D: Deserializer<'de>>(deserializer: D) -> Result<(), D::Error> {
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Nothing {}
    Nothing::deserialize(deserializer).map(|Nothing {}| ())
}

impl KinematicsSpec {
    /// Refuses kinematics that do not match `axes`.
    pub(super) fn check(&self, axes: &[AxisSpec]) -> Result<(), MachineError> {
        match self {
            Self::Cartesian => Ok(()),
            Self::FiveAxis(spec) => spec.check(axes),
        }
    }
}

impl FiveAxisSpec {
    fn check(&self, axes: &[AxisSpec]) -> Result<(), MachineError> {
        let refuse = |fault: String| Err(MachineError::BadDescription(fault));
        not_negative("kinematics.tool_length_mm", self.tool_length_mm)?;
        for name in ["x", "y", "z"] {
            if !axes.iter().any(|axis| axis.name() == name && matches!(axis, AxisSpec::Linear(_))) {
                return refuse(format!(
                    "`kinematics.kind` is `five-axis`, but there is no linear axis `{name}`; describe `x`, `y` and `z` in `[[axes]]`"
                ));
            }
        }
        if self.rotary.is_empty() || self.rotary.len() > 2 {
            return refuse(format!(
                "`kinematics.rotary` has {} axes; give one or two `[[kinematics.rotary]]`, or `kind = \"cartesian\"` for none",
                self.rotary.len()
            ));
        }
        for (i, joint) in self.rotary.iter().enumerate() {
            let name = &joint.axis;
            if !axes.iter().any(|axis| axis.name() == name && matches!(axis, AxisSpec::Rotary(_))) {
                return refuse(format!(
                    "`kinematics.rotary[{i}].axis` is `{name}`; it must be the name of an axis of `kind = \"rotary\"` in `[[axes]]`"
                ));
            }
            if self.rotary[..i].iter().any(|other| other.axis == *name) {
                return refuse(format!("`kinematics.rotary` names axis `{name}` twice; mount every axis once"));
            }
            joint.check(&format!("kinematics.rotary[{i}]"))?;
        }
        Ok(())
    }
}

impl RotaryJointSpec {
    fn check(&self, at: &str) -> Result<(), MachineError> {
        for (key, values) in [("direction", self.direction), ("pivot_mm", self.pivot_mm)] {
            for (i, value) in values.into_iter().enumerate() {
                finite(&format!("{at}.{key}[{i}]"), value)?;
            }
        }
        if self.direction.iter().all(|part| part.abs() < 1e-6) {
            return Err(MachineError::BadDescription(format!(
                "`{at}.direction` is zero; give the direction of the axis, such as [0.0, 1.0, 0.0] for an axis along Y"
            )));
        }
        Ok(())
    }
}
