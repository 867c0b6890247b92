//! One file per quantity or family.

mod backlash;
mod drift;
mod feed_forward;
mod friction;
mod gain;
mod mismatch;
mod place;
mod repeatability;
mod resonance;
mod reversal;
mod ripple;
mod stick_slip;

pub use mismatch::mismatches;

use crate::context::AxisContext;
use crate::finding::{Finding, Quantity};

/// All findings of one axis.
pub fn of_axis(axis: &AxisContext<'_>) -> Vec<Finding> {
    let mut all = gain::findings(axis);
    all.extend(feed_forward::findings(axis));
    all.extend(friction::findings(axis));
    all.extend([
        place::finding(axis),
        backlash::finding(axis),
        reversal::finding(axis),
        stick_slip::finding(axis),
        ripple::finding(axis),
        pitch(axis),
        resonance::finding(axis),
        drift::finding(axis),
        repeatability::finding(axis),
    ]);
    all
}

/// Pitch error: a loop holds its own sensor to the command, whatever the pitch of screw or scale.
fn pitch(axis: &AxisContext<'_>) -> Finding {
    let why =
        "the loop holds its own sensor to the command: an error of pitch or scale is in both columns of the log and cancels";
    let record = "measure with a laser or a step gauge (ISO 230-2) and enter it. SINUMERIK: MD32700 ENC_COMP_ENABLE; Fanuc: No. 3620 ff.; LinuxCNC: COMP_FILE";
    Finding::not_observable(Quantity::PitchError, axis.name(), "µm", why, record)
}
