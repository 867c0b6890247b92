//! What the methods run on.

use machine::{Machine, MachineSpec, SimulatedMachine, SimulationOptions};
use models::Bundle;

use super::method::Ilc;
use crate::error::Result;
use crate::setup::Setup;

/// What the methods run on.
#[derive(Debug, Clone, Copy)]
pub enum Plant<'a> {
    /// The simulated machine of a description.
    Simulated(&'a MachineSpec),
    /// What a model makes of a machine that is not at hand; it repeats itself exactly.
    Learned(&'a Bundle),
}

impl Plant<'_> {
    /// The machine's setup.
    ///
    /// # Errors
    /// When the machine's axes cannot place a tool.
    pub fn setup(self) -> Result<Setup> {
        match self {
            Self::Simulated(spec) => Setup::new(spec, None),
            Self::Learned(bundle) => Setup::of_model(bundle),
        }
    }

    /// The machine with noise of its own for every seed.
    pub(super) fn machine(self, seed: u64, options: SimulationOptions) -> Result<Box<dyn Machine>> {
        Ok(match self {
            Self::Simulated(spec) => Box::new(SimulatedMachine::new(spec, seed)?.with_options(options)?),
            Self::Learned(bundle) => Box::new(bundle.machine()?),
        })
    }

    /// The laws that can learn on it. Across a path there is only a plane where the axes are the coordinates of the tip.
    pub(super) fn laws(self) -> Result<Vec<Ilc>> {
        let turns = self.setup()?.kinematics.has_rotary_axes();
        Ok(Ilc::ALL.into_iter().filter(|law| !(turns && *law == Ilc::CrossCoupled)).collect())
    }
}
