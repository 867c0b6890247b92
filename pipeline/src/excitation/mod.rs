//! Motions that teach a machine's axes: as programs for a real control, or recorded on a simulated machine.

mod program;
mod recording;

pub use program::{Style, program};
pub use recording::{TRAVEL_MM, TURN_RAD, record, travel};
