//! Machine on which methods are compared.

use std::fmt::Debug;

use machine::{Machine, MachineSpec, SimulatedMachine, SimulationOptions};
use models::Bundle;

use super::method::Ilc;
use crate::error::Result;
use crate::setup::Setup;

/// A machine of the caller on which methods are compared.
pub trait OwnMachine: Debug + Sync {
    /// Setup of the machine.
    ///
    /// # Errors
    /// When its axes do not define a tool tip position.
    fn setup(&self) -> Result<Setup>;

    /// The machine as it is before its first run, with the noise of a seed. Several are made, and run at the same time.
    ///
    /// # Errors
    /// When there is none.
    fn machine(&self, seed: u64) -> Result<Box<dyn Machine>>;
}

/// Machine on which methods are compared.
#[derive(Debug, Clone, Copy)]
pub enum Plant<'a> {
    /// Simulated machine of a description.
    Simulated(&'a MachineSpec),
    /// Learned machine of a model. Its runs have no noise.
    Learned(&'a Bundle),
    /// Machine of the caller.
    Own(&'a dyn OwnMachine),
}

impl Plant<'_> {
    /// Setup of the machine.
    ///
    /// # Errors
    /// When the axes do not define a tool tip position.
    pub fn setup(self) -> Result<Setup> {
        match self {
            Self::Simulated(spec) => Setup::new(spec, None),
            Self::Learned(bundle) => Setup::of_model(bundle),
            Self::Own(own) => own.setup(),
        }
    }

    /// The machine with the noise of a seed.
    pub(super) fn machine(self, seed: u64, options: SimulationOptions) -> Result<Box<dyn Machine>> {
        Ok(match self {
            Self::Simulated(spec) => Box::new(SimulatedMachine::new(spec, seed)?.with_options(options)?),
            Self::Learned(bundle) => Box::new(bundle.machine()?),
            Self::Own(own) => own.machine(seed)?,
        })
    }

    /// The simulated machine without noise, a perfect model of itself; `None` for other machines.
    pub(super) fn noise_free(self, options: SimulationOptions) -> Result<Option<SimulatedMachine>> {
        let Self::Simulated(spec) = self else { return Ok(None) };
        Ok(Some(SimulatedMachine::new(spec, 0)?.with_options(SimulationOptions { noise_scale: 0.0, ..options })?))
    }

    /// Laws that apply to the machine. The cross-coupled law needs axes that are the coordinates of the tip.
    pub(super) fn laws(self) -> Result<Vec<Ilc>> {
        let has_rotary_axes = self.setup()?.kinematics.has_rotary_axes();
        Ok(Ilc::ALL.into_iter().filter(|law| !(has_rotary_axes && *law == Ilc::CrossCoupled)).collect())
    }
}
