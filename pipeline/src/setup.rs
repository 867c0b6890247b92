//! Machine setup: the machine and control that run a program.

use std::collections::BTreeMap;
use std::sync::Arc;

use gcode::{DecimalPoint, Dialect};
use machine::{AxisSpec, ControllerSpec, MachineSpec, ProgramDecimalPoint, ProgramDialect, ProgramWords, UNSTATED_BLEND_MM};
use models::Bundle;
use motion::{Kinematics, Limits, PlanSettings};

use crate::error::{Error, Result};

/// Kinematics, limits and control of a machine, without a model of its drives.
#[derive(Debug, Clone)]
pub struct Setup {
    /// Name of the machine.
    pub name: String,
    /// Kinematics: axis positions ↔ tool pose.
    pub kinematics: Arc<dyn Kinematics>,
    /// Default meaning of program words: axis positions or tool tip coordinates.
    pub words: ProgramWords,
    /// Limits of axes and path.
    pub limits: Limits,
    /// Sampling period, s.
    pub period_s: f64,
    /// Planner settings; [`Setup::period_s`] replaces their sampling period.
    pub plan: PlanSettings,
    /// Whether the machine description states how its control passes corners.
    pub states_corners: bool,
    /// Control profile, where one is stated.
    pub controller: Option<ControllerSpec>,
    /// Program dialect of the control, where the profile states one.
    pub dialect: Option<Dialect>,
    /// Reading of coordinates without a decimal point, where the profile states one.
    pub decimal_point: Option<DecimalPoint>,
    /// Travel of every axis, lowest and highest position, mm or rad; `None` for an unlimited axis.
    pub travel: Vec<Option<[f64; 2]>>,
    /// Work offsets by coordinate system name, mm, machine minus program coordinates, as far as the machine description
    /// states them.
    pub work_offsets: BTreeMap<String, [f64; 3]>,
}

impl Setup {
    /// Setup of a machine description. `controller` replaces the control profile of the description.
    ///
    /// # Errors
    /// When the axes do not define a tool tip position.
    pub fn new(machine: &MachineSpec, controller: Option<ControllerSpec>) -> Result<Self> {
        let controller = controller.or(machine.controller);
        let dialect = controller.and_then(|controller| controller.dialect).map(|dialect| match dialect {
            ProgramDialect::Fanuc => Dialect::Fanuc,
            ProgramDialect::LinuxCnc => Dialect::LinuxCnc,
            ProgramDialect::Sinumerik => Dialect::Sinumerik,
        });
        let decimal_point = controller.and_then(|controller| controller.decimal_point).map(|point| match point {
            ProgramDecimalPoint::Unit => DecimalPoint::Unit,
            ProgramDecimalPoint::LeastIncrement => DecimalPoint::LeastIncrement,
        });
        Ok(Self {
            name: machine.name.clone(),
            kinematics: machine.kinematics()?,
            words: machine.program_words(),
            limits: machine.limits(),
            period_s: machine.sampling_period_s(),
            plan: machine.plan_settings(),
            states_corners: machine.control.is_some(),
            controller,
            dialect,
            decimal_point,
            travel: machine.axes.iter().map(AxisSpec::travel).collect(),
            work_offsets: machine.work_offsets.clone(),
        })
    }

    /// Setup of the machine that a model was trained for.
    ///
    /// # Errors
    /// When the machine description in the model is invalid.
    pub fn of_model(model: &Bundle) -> Result<Self> {
        Self::new(&machine_of(model)?, None)
    }

    /// Planner settings with the sampling period of the setup.
    #[must_use]
    pub fn plan_settings(&self) -> PlanSettings {
        PlanSettings { period_s: self.period_s, ..self.plan.clone() }
    }

    /// The same for a program, with the rounding of corners that it does not state itself: `given`, mm, that of the machine description, or
    /// [`UNSTATED_BLEND_MM`].
    #[must_use]
    pub fn program_plan(&self, given: Option<f64>) -> PlanSettings {
        let plan = self.plan_settings();
        let unstated = if self.states_corners { plan.corner_tolerance_mm } else { UNSTATED_BLEND_MM };
        PlanSettings { corner_tolerance_mm: given.unwrap_or(unstated), ..plan }
    }
}

/// Description of the machine that a model was trained for.
///
/// # Errors
/// When the description in the model is invalid.
pub fn machine_of(model: &Bundle) -> Result<MachineSpec> {
    MachineSpec::from_toml(&model.manifest.machine_toml).map_err(Error::ModelMachine)
}
