//! Machine files in TOML.

mod axis;
mod builtin;
mod check;
mod control;
mod drive;
mod faults;
mod friction;
mod kinematics;
mod places;
mod ranges;
mod read;
mod rotary_drive;
mod structure;
mod waves;

use std::collections::BTreeMap;
use std::sync::Arc;

pub use axis::{AxisSpec, LinearAxis, RotaryAxis};
pub use builtin::{BUILTIN_CONTROLLERS, BUILTIN_MACHINES};
pub use control::{ControlSpec, CornerRule, UNSTATED_BLEND_MM};
pub(crate) use drive::Rates;
pub use drive::{DriveSpec, LoopSpec, MotorSpec, ScrewSpec, TableSpec};
pub use faults::{FileFault, FileFaults};
pub use friction::{FrictionSpec, Patch, PreslidingSpec, Warming};
pub use kinematics::{FiveAxisSpec, KinematicsSpec, Mount, ProgramWords, RotaryJointSpec};
use motion::{Axis, AxisFilter, Cartesian, FiveAxis, Kinematics, Limits, PlanSettings, RotaryJoint, RotaryMount, Vec3};
pub use rotary_drive::{
    GearSpec, RotaryDriveSpec, RotaryFrictionSpec, RotaryPatch, RotaryPreslidingSpec, RotaryTableSpec, RotaryWave,
};
pub use waves::{Harmonic, TorqueHarmonic, Wave};

use serde::{Deserialize, Serialize};

use crate::{MachineError, Sensor};
use check::{not_negative, positive, within};

/// A machine: axes, limits, kinematics, controller, and the drives of a simulated machine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MachineSpec {
    /// Name of the machine.
    pub name: String,
    /// Sampling period of the reference, ms.
    pub sampling_period_ms: f64,
    /// Position sensor of the position loops and logs.
    #[serde(default, skip_serializing_if = "Sensor::is_motor")]
    pub sensor: Sensor,
    /// Limits along the path.
    pub path: PathSpec,
    /// Kinematics.
    #[serde(default)]
    pub kinematics: KinematicsSpec,
    /// How the control passes corners and filters its command, where it is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub control: Option<ControlSpec>,
    /// Controller profile.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub controller: Option<ControllerSpec>,
    /// Machine minus program coordinates X, Y, Z by work coordinate system ([`WORK_SYSTEMS`]), mm,
    /// if known.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub work_offsets: BTreeMap<String, [f64; 3]>,
    /// The axes, in the order of every trajectory.
    pub axes: Vec<AxisSpec>,
}

/// Longest window over which a plan is smoothed, sampling periods. The time of planning grows with
/// it. Controls smooth over a few hundred.
const LONGEST_WINDOW: f64 = 5000.0;

/// Names of the work coordinate systems, in numerical order.
pub const WORK_SYSTEMS: [&str; 9] = ["G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3"];

/// Limits along the path.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PathSpec {
    /// Largest speed, mm/s.
    pub velocity_mm_s: f64,
    /// Largest acceleration along the path, mm/s².
    pub acceleration_mm_s2: f64,
    /// Largest jerk along the path, mm/s³.
    pub jerk_mm_s3: f64,
    /// Largest acceleration across the path, mm/s².
    pub centripetal_mm_s2: f64,
    /// Time over which the control smooths a change of acceleration, in addition to the jerk limit,
    /// ms. 0 for a control without jerk limit.
    #[serde(default = "smoothing_ms")]
    pub smoothing_ms: f64,
    /// Fraction of the acceleration that the control uses along lines whose end it does not round as the tolerance allows: they are too
    /// short for it, the tool dwells there, or the program ends.
    #[serde(default = "whole")]
    pub short_line_acceleration: f64,
    /// Largest acceleration in arcs, along and across together, mm/s²: along an arc the control uses what its fastest passage leaves.
    /// `None`: each has its own limit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arc_acceleration_mm_s2: Option<f64>,
}

fn smoothing_ms() -> f64 {
    PlanSettings::default().smoothing_s * 1e3
}

fn whole() -> f64 {
    PlanSettings::default().short_line_acceleration
}

/// Controller profile: the output form of a compensated program.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ControllerSpec {
    /// Decimals of a coordinate in mm.
    pub decimals: u8,
    /// Time encoding of the points.
    #[serde(alias = "carrier")]
    pub format: ProfileFormat,
    /// Time between points or setpoints, ms.
    pub point_spacing_ms: f64,
    /// Dialect of its programs. Absent: detected from each program.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dialect: Option<ProgramDialect>,
    /// Reading of coordinates without a decimal point. Absent: it is a setting of the control, and has to be stated for
    /// programs that depend on it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub decimal_point: Option<ProgramDecimalPoint>,
    /// Path tolerance of compensated segments, mm. Absent: that of the program. LinuxCNC: `G64 P…
    /// Q0`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub path_tolerance_mm: Option<f64>,
    /// Comments of its programs, where a program holds none to go by.
    #[serde(default, skip_serializing_if = "CommentStyle::is_usual")]
    pub comments: CommentStyle,
}

/// How a program sets comments apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CommentStyle {
    /// `(comment)` (NIST RS274NGC, Fanuc).
    #[default]
    Parentheses,
    /// `; comment` up to the end of the line (SINUMERIK).
    Semicolon,
}

impl CommentStyle {
    fn is_usual(&self) -> bool {
        *self == Self::default()
    }
}

/// Program dialect of a control.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ProgramDialect {
    /// Fanuc and compatible controls.
    Fanuc,
    /// LinuxCNC.
    LinuxCnc,
    /// SINUMERIK in its own dialect.
    Sinumerik,
}

/// Reading of a coordinate without a decimal point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ProgramDecimalPoint {
    /// In units: `X50` is 50 mm.
    Unit,
    /// In least input increments: `X50` is 0.050 mm.
    LeastIncrement,
}

impl ControllerSpec {
    fn check(&self) -> Result<(), MachineError> {
        positive("controller.point_spacing_ms", self.point_spacing_ms)?;
        self.path_tolerance_mm.map_or(Ok(()), |tolerance| positive("controller.path_tolerance_mm", tolerance))?;
        if self.decimals > 12 {
            return Err(MachineError::BadDescription(format!(
                "`controller.decimals` is {}; it must be 12 or less",
                self.decimals
            )));
        }
        Ok(())
    }
}

/// Time encoding of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ProfileFormat {
    /// Inverse time: `F` is one over the duration of the block in minutes.
    G93,
    /// Feed per minute on every block.
    G94,
    /// Feed words of the program: the control plans speed and acceleration as before.
    Keep,
    /// Setpoint table of axis positions instead of a program, for a control with linear
    /// interpolation.
    Table,
    /// Setpoint table of axis positions and velocities, for a control with cubic interpolation.
    Pvt,
}

impl MachineSpec {
    /// Sampling period of the reference, s.
    #[must_use]
    pub fn sampling_period_s(&self) -> f64 {
        self.sampling_period_ms * 1e-3
    }

    /// The axes, in order.
    #[must_use]
    pub fn motion_axes(&self) -> Vec<Axis> {
        self.axes.iter().map(AxisSpec::axis).collect()
    }

    /// Limits of the axes and the path.
    #[must_use]
    pub fn limits(&self) -> Limits {
        Limits {
            axes: self.axes.iter().map(AxisSpec::limits).collect(),
            path_velocity_mm_s: self.path.velocity_mm_s,
            path_acceleration_mm_s2: self.path.acceleration_mm_s2,
            path_jerk_mm_s3: self.path.jerk_mm_s3,
            centripetal_mm_s2: self.path.centripetal_mm_s2,
        }
    }

    /// Planner settings of the control; except the tolerance of corners where `control` is not stated.
    #[must_use]
    pub fn plan_settings(&self) -> PlanSettings {
        let settings = PlanSettings {
            period_s: self.sampling_period_s(),
            smoothing_s: self.path.smoothing_ms * 1e-3,
            short_line_acceleration: self.path.short_line_acceleration,
            arc_acceleration_mm_s2: self.path.arc_acceleration_mm_s2.unwrap_or(f64::INFINITY),
            filters: self.axes.iter().map(|axis| self.control.unwrap_or_default().filter(axis)).collect(),
            ..PlanSettings::default()
        };
        self.control.map_or(settings.clone(), |control| control.applied(settings))
    }

    /// Kinematics of the machine.
    ///
    /// # Errors
    /// If the rotary axes give the tool fewer than two degrees of rotational freedom.
    pub fn kinematics(&self) -> Result<Arc<dyn Kinematics>, MachineError> {
        Ok(match &self.kinematics {
            KinematicsSpec::Cartesian => Arc::new(Cartesian::new(self.motion_axes())),
            KinematicsSpec::FiveAxis(spec) => Arc::new(self.five_axis(spec)?),
        })
    }

    fn five_axis(&self, spec: &FiveAxisSpec) -> Result<FiveAxis, MachineError> {
        let travel = |name: &str| self.axes.iter().find(|axis| axis.name() == name).and_then(AxisSpec::travel);
        let joints = spec.rotary.iter().map(|joint| RotaryJoint {
            axis: joint.axis.clone(),
            mount: match joint.mount {
                Mount::Table => RotaryMount::Table,
                Mount::Head => RotaryMount::Head,
            },
            direction: Vec3::from(joint.direction),
            pivot_mm: Vec3::from(joint.pivot_mm),
            travel_rad: travel(&joint.axis),
        });
        FiveAxis::new(self.motion_axes(), joints.collect(), spec.tool_length_mm, ["x", "y", "z"].map(travel))
            .map_err(|error| MachineError::BadDescription(format!("`kinematics`: {error}")))
    }

    /// Meaning of program words if the program does not state it.
    #[must_use]
    pub fn program_words(&self) -> ProgramWords {
        match &self.kinematics {
            KinematicsSpec::Cartesian => ProgramWords::Axes,
            KinematicsSpec::FiveAxis(spec) => spec.programs,
        }
    }

    /// Refuses smoothing over more samples than a plan can be averaged over.
    fn check_windows(&self) -> Result<(), MachineError> {
        let PathSpec { acceleration_mm_s2, jerk_mm_s3, smoothing_ms, .. } = self.path;
        let longest_ms = LONGEST_WINDOW * self.sampling_period_ms;
        let least_jerk = 2.0 * acceleration_mm_s2 / (longest_ms * 1e-3);
        let remedy =
            format!("at least {least_jerk:.3}, so that this acceleration builds up within {LONGEST_WINDOW} sampling periods");
        within("path.jerk_mm_s3", jerk_mm_s3, jerk_mm_s3 >= least_jerk, &remedy)?;
        let remedy = format!("at most {longest_ms}, {LONGEST_WINDOW} sampling periods");
        within("path.smoothing_ms", smoothing_ms, smoothing_ms <= longest_ms, &remedy)?;
        // The delay of a lag is planned along the path as an average.
        let control = self.control.unwrap_or_default();
        let of_axis = |axis: &AxisSpec| (format!("axes.{}", axis.name()), control.filter(axis));
        let all = std::iter::once(("control".to_owned(), control.common_filter())).chain(self.axes.iter().map(of_axis));
        for (table, AxisFilter { averages_s, time_constant_s }) in all {
            for average_s in averages_s {
                let window_ms = 1e3 * (average_s + time_constant_s);
                let key = format!("{table}.{}", if average_s > 0.0 { "filters_ms" } else { "time_constant_ms" });
                let remedy = format!("at most {longest_ms} together with the time constant, {LONGEST_WINDOW} sampling periods");
                within(&key, window_ms, window_ms <= longest_ms, &remedy)?;
            }
        }
        Ok(())
    }

    /// Refuses values out of range.
    ///
    /// # Errors
    /// Names the key and the requirement.
    pub fn check(&self) -> Result<(), MachineError> {
        positive("sampling_period_ms", self.sampling_period_ms)?;
        for (key, value) in [
            ("path.velocity_mm_s", self.path.velocity_mm_s),
            ("path.acceleration_mm_s2", self.path.acceleration_mm_s2),
            ("path.jerk_mm_s3", self.path.jerk_mm_s3),
            ("path.centripetal_mm_s2", self.path.centripetal_mm_s2),
        ] {
            positive(key, value)?;
        }
        let PathSpec { smoothing_ms, short_line_acceleration, arc_acceleration_mm_s2, .. } = self.path;
        not_negative("path.smoothing_ms", smoothing_ms)?;
        let used = short_line_acceleration;
        within("path.short_line_acceleration", used, (0.01..=1.0).contains(&used), "at least 0.01 and at most 1")?;
        if let Some(both) = arc_acceleration_mm_s2 {
            positive("path.arc_acceleration_mm_s2", both)?;
            // Else nothing would be left along an arc.
            let across = self.path.centripetal_mm_s2;
            within("path.arc_acceleration_mm_s2", both, both > across, &format!("above `path.centripetal_mm_s2`, {across}"))?;
        }
        if let Some(control) = &self.control {
            control.check()?;
        }
        self.check_windows()?;
        if let Some(controller) = &self.controller {
            controller.check()?;
        }
        for (system, offset) in &self.work_offsets {
            if !WORK_SYSTEMS.contains(&system.as_str()) {
                return Err(MachineError::BadDescription(format!(
                    "`work_offsets.{system}` is no work coordinate system; they are {}",
                    WORK_SYSTEMS.join(", ")
                )));
            }
            for (slot, value) in offset.iter().enumerate() {
                within(&format!("work_offsets.{system}[{slot}]"), *value, true, "finite")?;
            }
        }
        if self.axes.is_empty() {
            return Err(MachineError::BadDescription("there is no `[[axes]]`; describe at least one axis".into()));
        }
        for (i, axis) in self.axes.iter().enumerate() {
            let name = axis.name();
            if self.axes[..i].iter().any(|other| other.name() == name) {
                return Err(MachineError::BadDescription(format!(
                    "axis `{name}` is described twice; give every axis a name of its own"
                )));
            }
            axis.check(self.sampling_period_ms)?;
        }
        self.kinematics.check(&self.axes)?;
        self.kinematics().map(drop)
    }
}

impl Default for ControllerSpec {
    /// Six decimals, inverse time, a point every 8 ms: within the capability of LinuxCNC.
    fn default() -> Self {
        Self {
            decimals: 6,
            format: ProfileFormat::G93,
            point_spacing_ms: 8.0,
            dialect: None,
            decimal_point: None,
            path_tolerance_mm: None,
            comments: CommentStyle::Parentheses,
        }
    }
}
