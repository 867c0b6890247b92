//! Excitation: motions for the identification of the axes and of the control.
//!
//! [`program`] writes an excitation run as a part program for a real control, [`control_test`] the moves that show how the
//! control plans. [`next_excitation`] chooses the runs for a machine that has a model. [`record`] runs excitation on a simulated machine.

mod control_test;
mod next;
mod program;
mod recording;
mod style;

pub use control_test::{ControlProgram, control_test};
pub use next::{NextAxis, NextExcitation, is_placed, next_excitation, possible_names};
pub use program::{program, without_words};
pub use recording::{Region, TRAVEL_MM, TURN_RAD, in_program_words, record, travel};
pub use style::Style;
