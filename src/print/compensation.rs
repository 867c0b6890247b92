//! What a compensation came to.

use models::Outside;
use motion::contour::ContourSummary;
use pipeline::model_based_ilc::{BesideUnchanged, Outcome};
use pipeline::units::{ErrorUnit, um};
use pipeline::{Expectation, Expected, ExpectedFigures, Input, Part, PositionTerms, Setup, travel};
use serde_json::{Map, Value, json};

use super::figures::contour_json;
use super::program::show_warnings;
use super::written::{counted, left_alone, without_gain};
use crate::output::Printer;

/// What the forecast of `input` lacks, and what could not be checked.
pub fn show_unknown(printer: &Printer, input: &Input, setup: &Setup, terms: Option<&PositionTerms>) {
    if let Some(line) = terms.and_then(position_terms) {
        printer.line(line);
    }
    if travel::is_unchecked(input, setup) {
        printer.line(
            "note: whether the axes stay within their travel was not checked, only that the part is not larger: its work offset is not known",
        );
    }
}

/// What reading a program found: codes that are not understood and the moves behind them; with `all` every warning.
pub fn show_read(printer: &Printer, input: &Input, all: bool) {
    if let Some(part) = input.part() {
        show_warnings(printer, &part.toolpath.warnings, (&part.program, &part.name), all);
    }
}

/// The forecast with and without compensation, what a run is expected to come to, and what is left alone; with `all` every warning.
pub fn show(printer: &Printer, input: &Input, outcome: &Outcome, expected: Option<&Expectation>, all: bool) {
    show_read(printer, input, all);
    for warning in warnings(input.part(), outcome) {
        printer.line(format!("warning: {warning}"));
    }
    show_forecast(printer, input, outcome);
    if let Some(expected) = expected {
        show_expectation(printer, expected);
    }
    if let Some(beside) = &outcome.beside_unchanged {
        printer.line(beside_unchanged(beside));
    }
    show_orientation(printer, outcome);
    if let Some(cycle_s) = outcome.cycle_s {
        printer.line(cycle(cycle_s));
    }
    let of_part = |part: &Part| left_alone(&part.fixed_moves(), part.fixed_share());
    if let Some(left) = input.part().filter(|_| outcome.gained).and_then(of_part) {
        printer.line(left);
    }
    if let Some(line) = without_gain(&outcome.without_gain) {
        printer.line(line);
    }
    if !outcome.gained {
        printer.line(format!("{}: what is written is the input, unchanged", why_unchanged(input.part(), outcome)));
    }
}

/// Says that a program whose errors are evaluated is a compensated one.
pub fn show_marked(printer: &Printer, input: &Input) {
    if input.check_original().is_err() {
        printer.line(format!(
            "note: {} is a compensated program. Errors are evaluated against its shifted points, not against the part; that takes the original program",
            input.name()
        ));
    }
}

/// The largest error, where no correction reaches it.
fn beside_unchanged(beside: &BesideUnchanged) -> String {
    format!(
        "MAX is at line {}, beside a rapid or another move that is not changed, and no correction reaches it: {} µm; elsewhere it is {} µm. A dwell \
         (G4) between the two moves lets the machine settle",
        beside.line,
        um(beside.max_mm),
        um(beside.elsewhere_mm)
    )
}

/// Difference that recorded corners make to MAX from which on they are reported, mm.
const CORNERS_MM: f64 = 1e-4;

fn show_forecast(printer: &Printer, input: &Input, outcome: &Outcome) {
    let over = if input.part().is_some() { " over feed moves" } else { "" };
    let how =
        format!("{} updates on the model{}", outcome.updates, outcome.ended.map_or(String::new(), |ended| format!("; {ended}")));
    let [before, after] = outcome.figures();
    printer.line(forecast(over, &before.tip, &after.tip, &how));
    if (before.tip.max_mm - outcome.before.tip.max_mm).abs() > CORNERS_MM {
        printer.line(format!(
            "the run leaves the planned path at corners, which are not corrected: with them as recorded {} → {} µm RMS, {} → {} µm MAX",
            um(outcome.before.tip.rms_mm),
            um(outcome.after.tip.rms_mm),
            um(outcome.before.tip.max_mm),
            um(outcome.after.tip.max_mm)
        ));
    }
}

/// The forecast without and with compensation.
pub fn forecast(over: &str, before: &ContourSummary, after: &ContourSummary, how: &str) -> String {
    format!(
        "predicted contour error{over}: {} → {} µm RMS, {} → {} µm MAX ({how})",
        um(before.rms_mm),
        um(after.rms_mm),
        um(before.max_mm),
        um(after.max_mm)
    )
}

/// The cycle time without and with compensation, s.
pub fn cycle((before_s, after_s): (f64, f64)) -> String {
    format!("expected cycle time: {before_s:.2} → {after_s:.2} s ({:+.1} %)", 100.0 * (after_s / before_s - 1.0))
}

/// A correction that reaches its bound, mm.
pub fn cut_off(max_shift: f64) -> String {
    format!("warning: the correction is cut off at its bound of {max_shift:.3} mm; with a larger --max-shift more may be gained")
}

/// What a run is expected to come to.
pub fn show_expectation(printer: &Printer, expected: &Expectation) {
    printer.line(format!("expected on the machine, the model's own error included: {}, nine runs in ten", expectation(expected)));
}

fn show_orientation(printer: &Printer, outcome: &Outcome) {
    let [Some(before), Some(after)] = outcome.figures().map(|figures| figures.orientation) else { return };
    let urad = |rad: f64| format!("{:.2}", rad * 1e6);
    printer.line(format!(
        "predicted error of the tool's direction: {} → {} µrad RMS, {} → {} µrad MAX",
        urad(before.rms_rad),
        urad(after.rms_rad),
        urad(before.max_rad),
        urad(after.max_rad)
    ));
}

/// What leaving terms of position out costs, in words; `None` where the model has no such terms.
pub fn position_terms(terms: &PositionTerms) -> Option<String> {
    let axes: Vec<String> = terms.axes.iter().map(|(axis, rms)| format!("{axis} {}", ErrorUnit::from(axis).text(*rms))).collect();
    (!axes.is_empty()).then(|| {
            format!(
                "note: the work offset is not known: terms that depend on position (screw pitch, ripple, friction along the axis) are left out. With the \
                 part at 0,0,0 they would be {} RMS, and the uncompensated forecast {} instead of {} µm RMS. Give --work-offset X,Y,Z",
                axes.join(", "),
                um(terms.with.tip.rms_mm),
                um(terms.without.tip.rms_mm)
            )
        })
}

/// The same as JSON.
pub fn position_terms_json(terms: &PositionTerms) -> Value {
    let axes: Map<String, Value> = terms
        .axes
        .iter()
        .map(|(axis, rms)| {
            let unit = ErrorUnit::from(axis);
            (axis.name.clone(), json!({ unit.key("rms"): unit.value(*rms) }))
        })
        .collect();
    json!({
        "axes": axes,
        "contour_um_without": contour_json(&terms.without.tip),
        "contour_um_at_zero": contour_json(&terms.with.tip),
    })
}

/// What a run is expected to come to: "0.24 µm RMS (0.20 to 0.31), 0.90 µm MAX (0.70 to 1.40)", with the tool's direction where it turns.
pub fn expectation(expected: &Expectation) -> String {
    let figures = |of: &ExpectedFigures, unit: ErrorUnit| {
        let one = |of: Expected, name: &str| {
            let [low, high] = [of.low, of.high].map(|value| unit.number(value));
            format!("{} {name} ({low} to {high})", unit.text(of.middle))
        };
        format!("{}, {}", one(of.rms, "RMS"), one(of.max, "MAX"))
    };
    let direction = expected.direction.map(|of| format!("; tool direction {}", figures(&of, ErrorUnit::Microradian)));
    figures(&expected.tip, ErrorUnit::Micrometre) + &direction.unwrap_or_default()
}

/// The same as JSON, µm.
pub fn expectation_json(expected: &Expectation) -> Value {
    expected_json(&expected.tip, ErrorUnit::Micrometre)
}

/// The same of the tool's direction, µrad; `null` where it does not turn.
pub fn expected_orientation_json(expected: Option<&Expectation>) -> Value {
    expected.and_then(|expected| expected.direction).map_or(Value::Null, |of| expected_json(&of, ErrorUnit::Microradian))
}

fn expected_json(of: &ExpectedFigures, unit: ErrorUnit) -> Value {
    let one = |of: Expected| json!({ "low": unit.value(of.low), "middle": unit.value(of.middle), "high": unit.value(of.high) });
    json!({ "rms": one(of.rms), "max": one(of.max) })
}

pub const NO_GAIN: &str = "the model predicts no gain worth having";

/// Why nothing is changed where the cycle would take longer by this share whatever the points.
pub fn too_slow(slowdown: f64) -> String {
    format!("the cycle would take at least {:.2} % longer, which --cycle-limit does not allow", 100.0 * slowdown)
}

/// Why a path is left as it is: there is nothing that may be changed, or nothing that changing it would better.
pub fn why_unchanged(part: Option<&Part>, outcome: &Outcome) -> String {
    if let Some(slowdown) = outcome.too_slow {
        return too_slow(slowdown);
    }
    if let Some([before_mm, after_mm]) = outcome.uncertain_mm {
        let expected = format!("{} → {} µm RMS expected", um(before_mm), um(after_mm));
        return format!("the model's own error grows by more than the forecast gains ({expected})");
    }
    let Some(part) = part else { return NO_GAIN.to_owned() };
    let changeable = part.toolpath.moves.iter().filter(|of| part.is_shiftable(of)).count();
    let fixed: Vec<String> = part.fixed_moves().iter().map(|(why, fixed)| counted(why, *fixed)).collect();
    match (changeable, fixed.is_empty()) {
        (0, _) => format!("the program holds no move that may be changed ({})", fixed.join(", ")),
        (_, true) => NO_GAIN.to_owned(),
        (_, false) => format!("{NO_GAIN} on the {changeable} moves that may be changed (not changed: {})", fixed.join(", ")),
    }
}

/// Where the model is out of its depth, with lines where there is a program.
pub fn warnings(part: Option<&Part>, outcome: &Outcome) -> Vec<String> {
    let period = outcome.reference.period_s();
    outcome
        .outside
        .iter()
        .map(|range| {
            let line = |k: usize| part.and_then(|part| part.line_at(k));
            let place = match (line(range.first), line(range.last)) {
                (Some(first), Some(last)) if first == last => format!("line {first}"),
                (Some(first), Some(last)) => format!("lines {first} to {last}"),
                _ => format!("t = {:.3} to {:.3} s", range.first as f64 * period, range.last as f64 * period),
            };
            outside(&place, &range.axis, range.reason, range.samples, range.fades)
        })
        .chain(outcome.of_program.as_ref().and_then(|[before, after]| grows(&before.tip, &after.tip)))
        .collect()
}

/// A largest error that grows where the program is not corrected.
fn grows(before: &ContourSummary, after: &ContourSummary) -> Option<String> {
    (after.max_mm > before.max_mm + CORNERS_MM).then(|| {
        format!(
            "at a corner, which is not corrected, the largest error is predicted to grow: {} → {} µm",
            um(before.max_mm),
            um(after.max_mm)
        )
    })
}

/// A place outside of what the model was trained on.
pub fn outside(place: &str, axis: &str, reason: Outside, samples: usize, fades: bool) -> String {
    if reason == Outside::Unplaced {
        return format!(
            "the predictor of axis {axis} needs its position, which is not known without --work-offset; nothing is corrected"
        );
    }
    let effect = match reason {
        Outside::Position if !fades => "what depends on the place is corrected less and less there",
        _ if !fades => "the correction there is an extrapolation; a log of such motion makes it better",
        _ => "the correction fades there",
    };
    format!("{place}: {reason} of axis {axis} lies outside what the model was trained on ({samples} samples); {effect}")
}
