//! The machine and control that run a program.

use std::collections::BTreeMap;
use std::sync::Arc;

use gcode::Dialect;
use machine::{AxisSpec, ControllerSpec, MachineSpec, ProgramDialect, ProgramWords};
use models::Bundle;
use motion::{Kinematics, Limits, PlanSettings};

use crate::error::{Error, Result};

/// What is known of a machine and its control, without the machine's drives.
#[derive(Debug, Clone)]
pub struct Setup {
    /// Name of the machine.
    pub name: String,
    /// How the axes place the tool.
    pub kinematics: Arc<dyn Kinematics>,
    /// What the words of a program mean while it does not say so itself.
    pub words: ProgramWords,
    /// What the axes and the path are allowed to do.
    pub limits: Limits,
    /// Sampling period, s.
    pub period_s: f64,
    /// How programs are planned, but for the sampling period.
    pub plan: PlanSettings,
    /// How programs are written for the control, where that is stated.
    pub controller: Option<ControllerSpec>,
    /// What the control's programs are written in, where its profile says so.
    pub dialect: Option<Dialect>,
    /// Lowest and highest position of every axis, mm or rad, where they are limited.
    pub travel: Vec<Option<[f64; 2]>>,
    /// The machine's work offsets by coordinate system, mm, where its description says so.
    pub work_offsets: BTreeMap<String, [f64; 3]>,
}

impl Setup {
    /// The setup of a machine description; `controller` stands above the profile in the description.
    ///
    /// # Errors
    /// When the axes cannot place a tool.
    pub fn new(machine: &MachineSpec, controller: Option<ControllerSpec>) -> Result<Self> {
        let controller = controller.or(machine.controller);
        let dialect = controller.and_then(|controller| controller.dialect).map(|dialect| match dialect {
            ProgramDialect::Fanuc => Dialect::Fanuc,
            ProgramDialect::LinuxCnc => Dialect::LinuxCnc,
        });
        Ok(Self {
            name: machine.name.clone(),
            kinematics: machine.kinematics()?,
            words: machine.program_words(),
            limits: machine.limits(),
            period_s: machine.sampling_period_s(),
            plan: machine.plan_settings(),
            controller,
            dialect,
            travel: machine.axes.iter().map(AxisSpec::travel).collect(),
            work_offsets: machine.work_offsets.clone(),
        })
    }

    /// The setup of the machine that a model was trained for.
    ///
    /// # Errors
    /// When the description in the model is not sound.
    pub fn of_model(model: &Bundle) -> Result<Self> {
        Self::new(&machine_of(model)?, None)
    }

    /// How programs are planned.
    #[must_use]
    pub fn plan_settings(&self) -> PlanSettings {
        PlanSettings { period_s: self.period_s, ..self.plan.clone() }
    }
}

/// The description of the machine that a model was trained for.
///
/// # Errors
/// When it is not sound.
pub fn machine_of(model: &Bundle) -> Result<MachineSpec> {
    MachineSpec::from_toml(&model.manifest.machine_toml).map_err(Error::ModelMachine)
}
