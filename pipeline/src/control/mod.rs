//! Machines behind a control, and programs run by them.

mod controlled;
mod programs;
mod replanned;
mod short_lines;

pub use controlled::{CommandedRun, ControlledMachine, Pairing, in_step};
pub use programs::{MOVE_POINTS, ProgramRun, learn_program, run_program};
pub use replanned::Replanned;
pub use short_lines::curve_program;
