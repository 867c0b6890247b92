//! Machines: the interface from commanded to actual motion, and simulated feed drives.
//!
//! # One simulated axis
//! Extends the single-axis servo system of Paper D, section II (eq. 1-7: motor, two-mass
//! transmission, cascaded P, PI and current loops) by the non-linearities of a real axis. `θ` is
//! the motor angle, `x` the table position, `R = lead/2π`:
//! ```text
//! position loop   v* = K_pp (r − x_enc) + k_ff ṙ                 every 1 ms, x_enc in whole counts
//! velocity loop   T* = K_v (ω* − θ̇) + K_v/T_i ∫(ω* − θ̇) dt        every 0.25 ms, |T*| ≤ T_max, anti-windup
//! current loop    τ_c Ṫ_i = T* − T_i                             exact exponential
//! torque          T = T_i (1 + ripple(θ)) + cogging(θ) + noise
//! motor           J θ̈ = T − B_m θ̇ − F R − F_fm R
//! table           M ẍ = F − F_ft − B_t ẋ + noise
//! transmission    F = K_s dead(θR − x) + C_s (θ̇R − ẋ)            no force inside the backlash
//! ```
//! The velocity loop uses the motor speed itself, not a difference of counts. The friction forces
//! `F_fm`, `F_ft` on the motor and table sides are LuGre or Maxwell-slip models whose Coulomb level
//! depends on direction, position, run and time.
//!
//! A rotary drive has the same equations with the table angle for `x`, `R = 1/ratio` of the gear,
//! inertias for masses and torques about the table axis for forces.
//!
//! The steady tracking error in a ramp is `v (1 − k_ff) / K_pp`: positive for positive `v`.
//!
//! [`SimulatedMachine::run_full`] returns both views of a run: a motor encoder does not measure
//! backlash and the elastic deflection of screw or gear.

#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr, clippy::exit, clippy::disallowed_methods))]

mod draft;
mod drive;
mod error;
mod options;
mod random;
mod simulated;
mod spec;
mod testbed;

pub use draft::{AxisDraft, Draft, Known, Missing, MissingValue, draft};
pub use error::MachineError;
use motion::Trajectory;
pub use options::{Interpolation, Sensor, SimulationOptions};
pub use simulated::{Run, SimulatedMachine};
pub use spec::{
    AxisSpec, BUILTIN_CONTROLLERS, BUILTIN_MACHINES, CommentStyle, ControlSpec, ControllerSpec, CornerRule, DriveSpec, FileFault,
    FileFaults, FiveAxisSpec, FrictionSpec, GearSpec, Harmonic, KinematicsSpec, LinearAxis, LoopSpec, MachineSpec, MotorSpec,
    Mount, Patch, PathSpec, PreslidingSpec, ProfileFormat, ProgramDecimalPoint, ProgramDialect, ProgramWords, RotaryAxis,
    RotaryDriveSpec, RotaryFrictionSpec, RotaryJointSpec, RotaryPatch, RotaryPreslidingSpec, RotaryTableSpec, RotaryWave,
    ScrewSpec, TableSpec, TorqueHarmonic, UNSTATED_BLEND_MM, WORK_SYSTEMS, Warming, Wave,
};
pub use testbed::Testbed;

/// A machine: commanded motion in, actual motion out.
pub trait Machine {
    /// Runs `reference` once and returns the actual positions at the same instants, for the same
    /// axes.
    ///
    /// # Errors
    /// If the reference does not fit the machine (axes, period), or the run failed.
    fn run(&mut self, reference: &Trajectory) -> Result<Trajectory, MachineError>;
}
