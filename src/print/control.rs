//! What is known of the control that plans.

use models::ControlFidelity;
use pipeline::Recorded;
use pipeline::units::um;

use super::measurement::readback;

/// Agreement of a learned control with recorded commands beyond which a recorded run of the program is asked for.
const TRUSTED_PATH_MM: f64 = 2e-3;
const TRUSTED_CYCLE: f64 = 0.02;

/// Limits that no machine file states.
pub const LIMITS_FROM_LOG: &str =
    "note: the machine's limits were taken from what the training log reached; give --machine to state them";

/// A control of which nothing is known, so that its plan is a guess; what is expected covers other plans where `covered`.
#[must_use]
pub fn control_unknown(covered: bool) -> String {
    let holds = if covered {
        "covers accelerations and jerks beside those of the log, and no control that rounds corners by more than micrometres"
    } else {
        "holds where it moves as is planned here"
    };
    format!("note: how the control plans is not known: what is expected {holds}; train with --programs, or give --machine")
}

/// Whether plans of a control are too poor for a first run.
pub fn is_poor(path_rms_mm: f64, cycle_share: f64) -> bool {
    path_rms_mm > TRUSTED_PATH_MM || cycle_share > TRUSTED_CYCLE
}

/// How far the learned control can be trusted; more on it where the plan is too poor for a first run.
pub fn control_fidelity(control: &ControlFidelity) -> String {
    let ControlFidelity { path_rms_mm, path_max_mm, cycle_share, held_out, .. } = control;
    let known = format!(
        "the control as learned from {}: plans within {} µm RMS, {} µm MAX and {:.2} % of the cycle time",
        if *held_out > 0 { "recorded programs" } else { "one recorded program, by that program itself" },
        um(*path_rms_mm),
        um(*path_max_mm),
        100.0 * cycle_share
    );
    if is_poor(*path_rms_mm, *cycle_share) {
        return format!(
            "warning: {known}; the forecast is no better than that. Run the program once and give its log with --reference"
        );
    }
    known
}

/// The control of --machine, in place of the one that was learned.
pub fn control_unused(machine: &str) -> String {
    format!(
        "note: planned with limits and control of {machine}; the control as learned with the model is not used (without --machine it is)"
    )
}

/// What a recorded run says of the plan.
pub fn recorded(found: &Recorded) -> Vec<String> {
    let mut lines: Vec<String> = found.resampled.iter().map(ToString::to_string).collect();
    lines.push(readback(&found.readback));
    if found.is_as_planned {
        lines.push("the control does as is planned: the program is compensated from the plan, which also tells what the control makes of the compensated points".into());
    }
    lines
}

/// Time of a run, as a multiple of that planned, from which on the plan says little of what added points cost.
const SLOW: f64 = 1.1;

/// How far the forecast for a recorded run holds, where the control does not do as is planned; `replans` says whether it is of the points as they change the
/// plan.
pub fn recorded_warning(found: &Recorded, replans: bool) -> Option<String> {
    if found.is_as_planned {
        return None;
    }
    let readback = &found.readback;
    let slower = readback.commanded_s / readback.intended_s;
    let of = match replans {
        false => {
            "The forecast is of the recorded times; a control that plans the compensated points anew keeps other ones".to_owned()
        }
        true if slower > SLOW => format!(
            "The forecast is of its recorded run, changed as the compensated points change the plan. The run took {slower:.1} times as long as planned: \
             what points cost on this control is not known, and the cycle may take longer than is said"
        ),
        true => "The forecast is of its recorded run, changed as the compensated points change the plan".to_owned(),
    };
    Some(format!(
        "the control does not do as is planned. {of}. Measure the first run with `measure --desired`; `train --programs` learns the control"
    ))
}
