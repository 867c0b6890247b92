//! What was learned about a control.

use pipeline::identification::{Fidelity, Identified, Value};
use pipeline::units::um;
use serde_json::json;

use super::control::is_poor;
use crate::output::Printer;

/// An end of an interval beyond which nothing was seen: the factor up to which ends are tried.
const OPEN: f64 = 1.9;

/// What the control does, its numbers with their intervals, and how far a plan can be trusted.
pub fn show(printer: &Printer, control: &Identified, seconds: f64) {
    printer.line(format!("control learned in {seconds:.1} s: {}", control.structure));
    for value in &control.values {
        printer.line(format!("  {}", words(value)));
    }
    let Fidelity { cycle_share, .. } = control.fidelity;
    let on = match control.held_out.as_slice() {
        [] => "on the program of the fit itself, for there was no other".to_owned(),
        names => format!("on held-out programs ({})", names.join(", ")),
    };
    printer.line(format!(
        "its plan {on}: {} µm RMS and {} µm MAX from the recorded command, cycle time within {:.2} %",
        um(control.fidelity.path_rms_mm),
        um(control.fidelity.path_max_mm),
        100.0 * cycle_share
    ));
    if let Some(warning) = warning(control) {
        printer.line(format!("warning: {warning}"));
    }
}

/// What is said of a control whose plans are too poor for a first run.
pub fn warning(control: &Identified) -> Option<String> {
    let Fidelity { path_rms_mm, cycle_share, .. } = control.fidelity;
    is_poor(path_rms_mm, cycle_share).then(|| {
        "the control as learned does not plan as the recorded one does: forecasts are those of another motion. Give the machine file the control's own \
         limits and corner rule, or more programs with their logs, the control test among them; or compensate with --reference"
            .to_owned()
    })
}

fn words(value: &Value) -> String {
    let (name, unit) = match value.key.as_str() {
        "path.acceleration_mm_s2" => ("acceleration along the path".to_owned(), "mm/s²"),
        "path.velocity_mm_s" => ("speed of rapids along the path".to_owned(), "mm/s"),
        "path.centripetal_mm_s2" => ("acceleration across the path, in curves".to_owned(), "mm/s²"),
        "path.rise_ms" => ("time in which the acceleration changes".to_owned(), "ms"),
        "path.smoothing_ms" => ("second average along the path".to_owned(), "ms"),
        "path.short_line_acceleration" => ("share of the acceleration along short lines and before a dwell".to_owned(), ""),
        "path.tight_arcs_mm_s2" => ("acceleration along tight arcs".to_owned(), "mm/s²"),
        "jerk_mm_s3" => ("jerk of every linear axis".to_owned(), "mm/s³"),
        "control.filters_ms[0]" => ("moving average of every axis".to_owned(), "ms"),
        "control.filters_ms[1]" => ("second moving average of every axis".to_owned(), "ms"),
        "control.time_constant_ms" => ("time constant of every axis".to_owned(), "ms"),
        "control.look_ahead_lines" => ("lines known ahead".to_owned(), ""),
        "control.line_time_ms" => ("least time for a line".to_owned(), "ms"),
        "control.corners.blend_mm" => ("corners rounded within".to_owned(), "mm"),
        "control.corners.speed_jump_mm_s" => ("jump of an axis's speed at corners".to_owned(), "mm/s"),
        "control.corners.junction_deviation_mm" => ("junction deviation".to_owned(), "mm"),
        other => of_axis(other),
    };
    let [from, to] = value.interval;
    let digits = |value: f64| if value.fract() == 0.0 && value < 1e6 { format!("{value:.0}") } else { digits(value) };
    let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
    // A limit that was never reached shows only where it is not.
    match (value.value / from > OPEN, to / value.value > OPEN) {
        (true, true) => format!("{name}: not seen"),
        (false, true) => format!("{name}: not below {}{unit}", digits(from)),
        (true, false) => format!("{name}: not above {}{unit}", digits(to)),
        (false, false) => format!("{name}: {}{unit} ({} to {})", digits(value.value), digits(from), digits(to)),
    }
}

/// Words and unit of a number that every axis has for itself.
fn of_axis(key: &str) -> (String, &'static str) {
    let all = [
        (".acceleration_mm_s2", "acceleration", "mm/s²"),
        (".filters_ms[0]", "moving average", "ms"),
        (".filters_ms[1]", "second moving average", "ms"),
        (".time_constant_ms", "time constant", "ms"),
    ];
    let found = all.into_iter().find_map(|(end, name, unit)| Some((format!("{name} of {}", key.strip_suffix(end)?), unit)));
    found.unwrap_or_else(|| (key.to_owned(), ""))
}

/// Three significant digits.
fn digits(value: f64) -> String {
    let decimals = (2.0 - value.abs().max(1e-9).log10().floor()).clamp(0.0, 6.0) as usize;
    format!("{value:.decimals$}")
}

/// The same as JSON.
pub fn json(control: &Identified, seconds: f64) -> serde_json::Value {
    let fidelity = |of: &Fidelity| {
        json!({
            "path_um": { "rms": of.path_rms_mm * 1e3, "max": of.path_max_mm * 1e3 },
            "time_share": of.time_share,
            "cycle_share": of.cycle_share,
        })
    };
    json!({
        "seconds": seconds,
        "structure": control.structure,
        "values": control.values.iter().map(|value| json!({ "key": value.key, "value": value.value, "interval": value.interval })).collect::<Vec<_>>(),
        "held_out": control.held_out,
        "fidelity": fidelity(&control.fidelity),
        "tried": control.tried.iter().map(|(structure, of)| json!({ "structure": structure, "fidelity": fidelity(of) })).collect::<Vec<_>>(),
    })
}
