//! Excitation: motions for the identification of the axes.
//!
//! [`program`] writes an excitation run as a part program for a real control. [`record`] runs excitation on a simulated
//! machine.

mod program;
mod recording;

pub use program::{Style, program};
pub use recording::{TRAVEL_MM, TURN_RAD, record, travel};
