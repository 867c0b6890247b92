//! Machines behind a control.
//!
//! [`ControlledMachine`] wraps a machine with a control that may replan every program. [`run_program`] and
//! [`learn_program`] run part programs on it.

mod controlled;
mod programs;
mod replanned;
mod rerun;
mod short_lines;

pub use controlled::{CommandedRun, ControlledMachine, Pairing, in_step, is_replanned, plus};
pub use programs::{MOVE_POINTS, ProgramRun, learn_program, run_program};
pub use replanned::Replanned;
pub use short_lines::{curve_program, curve_program_in_steps};
