//! What a compensation came to.

use std::collections::BTreeMap;
use std::path::Path;

use gcode::{Diagnostic, Dialect, Language, Options, Program};
use models::{ControlFidelity, Outside};
use motion::contour::ContourSummary;
use pipeline::model_based_ilc::{BesideUnchanged, Outcome, WithoutGain};
use pipeline::part::FixedMoves;
use pipeline::refit::{RefitSettings, SlowStop};
use pipeline::setpoints::{SetpointsWritten, TOLERANCE_MM};
use pipeline::units::{ErrorUnit, um};
use pipeline::{Expectation, Expected, Input, Part, PositionTerms, Setup, travel};
use serde_json::{Map, Value, json};

use super::figures::contour_json;
use crate::output::Printer;

/// Agreement of a learned control with recorded commands beyond which a recorded run of the program is asked for.
const TRUSTED_PATH_MM: f64 = 2e-3;
const TRUSTED_CYCLE: f64 = 0.02;

/// The dialect that was found in the program, where no option and no profile states one.
pub fn show_dialect(printer: &Printer, program: &Program, options: &Options) {
    if program.language() == Language::Dialogue {
        return;
    }
    let (name, dialect) = (dialect_name(program, options), options.dialect);
    printer.line(if dialect.is_certain(program) {
        format!("dialect: {name}, found in the program or its name")
    } else {
        format!("dialect: {name}, a guess, since the program holds no code that decides; --dialect or --controller states it")
    });
}

/// The dialect in which a program was read, as `--dialect` calls it.
pub fn dialect_name(program: &Program, options: &Options) -> &'static str {
    match (program.language(), options.dialect) {
        (Language::Dialogue, _) => "heidenhain",
        (_, Dialect::Fanuc) => "fanuc",
        (_, Dialect::LinuxCnc) => "linuxcnc",
        (_, Dialect::Sinumerik) => "sinumerik",
    }
}

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

/// Warnings of a program that are printed without `--verbose`.
const WARNINGS: usize = 20;

/// The warnings of a program: `all`, or those of the same text in one and at most twenty.
pub fn show_warnings(printer: &Printer, warnings: &[Diagnostic], (program, name): (&Program, &str), all: bool) {
    if all {
        return warnings.iter().for_each(|warning| printer.line(warning.render(program, name)));
    }
    let (texts, left_out) = gcode::render_merged(warnings, program, name, WARNINGS);
    texts.iter().for_each(|text| printer.line(text));
    if left_out > 0 {
        printer.line(format!("warning: {left_out} more warnings; --verbose shows all"));
    }
}

/// The forecast with and without compensation, what a run is expected to come to, and what is left alone; with `all` every warning.
pub fn show(printer: &Printer, input: &Input, outcome: &Outcome, expected: Option<&Expectation>, all: bool) {
    if let Some(part) = input.part() {
        show_warnings(printer, &part.toolpath.warnings, (&part.program, &part.name), all);
    }
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

/// Difference that recorded corners make to MAX from which on they are told of, mm.
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

/// What a run is expected to come to: "0.24 µm RMS (0.20 to 0.31), 0.90 µm MAX (0.70 to 1.40)".
pub fn expectation(expected: &Expectation) -> String {
    let one = |of: Expected, name: &str| format!("{} µm {name} ({} to {})", um(of.middle), um(of.low), um(of.high));
    format!("{}, {}", one(expected.rms, "RMS"), one(expected.max, "MAX"))
}

/// The same as JSON, µm.
pub fn expectation_json(expected: &Expectation) -> Value {
    let one = |of: Expected| json!({ "low": of.low * 1e3, "middle": of.middle * 1e3, "high": of.high * 1e3 });
    json!({ "rms": one(expected.rms), "max": one(expected.max) })
}

/// The setpoints in words, and what is wrong with it.
pub fn setpoints(written: &SetpointsWritten) -> Vec<String> {
    let SetpointsWritten { count, interval_s, off_mm, .. } = written;
    let within = um(TOLERANCE_MM);
    let mut lines = vec![format!(
        "{count} setpoints, one every {:.3} ms; between them an axis is at most {} µm from the compensated path",
        interval_s * 1e3,
        um(*off_mm)
    )];
    if *off_mm > TOLERANCE_MM {
        lines.push(match written.finer_s {
            Some(finer_s) => format!(
                "warning: that is more than {within} µm: the interval is too coarse for this path; --spacing {:.3} is not",
                finer_s * 1e3
            ),
            None => format!("warning: that is more than {within} µm whatever the interval: write more --decimals"),
        });
    }
    lines
}

/// The same as JSON.
pub fn setpoints_json(written: &SetpointsWritten) -> Value {
    json!({
        "count": written.count,
        "interval_ms": written.interval_s * 1e3,
        "off_um": written.off_mm * 1e3,
        "tolerance_um": TOLERANCE_MM * 1e3,
        "finer_interval_ms": written.finer_s.map(|finer_s| finer_s * 1e3),
    })
}

/// Moves that stay as they are for one reason, with the line of the first one.
fn counted(why: &str, fixed: FixedMoves) -> String {
    let from = if fixed.moves > 1 { "from line" } else { "line" };
    format!("{} {why} ({from} {})", fixed.moves, fixed.first_line)
}

/// Which moves of a program stay as they are, if any do.
pub fn left_alone(fixed: &BTreeMap<&'static str, FixedMoves>, share: f64) -> Option<String> {
    let fixed: Vec<String> = fixed.iter().map(|(why, fixed)| counted(why, *fixed)).collect();
    let share = 100.0 * share;
    (!fixed.is_empty()).then(|| format!("moves left as they are: {}; {share:.1} % of the feed length", fixed.join(", ")))
}

/// Segments without gain that are named one by one.
const SEGMENTS_NAMED: usize = 5;

/// Segments that are not changed because the forecast gains nothing by it, the longest ones by their lines.
pub fn without_gain(left: &[WithoutGain]) -> Option<String> {
    let mut longest: Vec<&WithoutGain> = left.iter().collect();
    longest.sort_by(|a, b| b.length_mm.total_cmp(&a.length_mm));
    let named: Vec<String> = longest.iter().take(SEGMENTS_NAMED).map(|segment| segment_without_gain(segment)).collect();
    let more = if left.len() > named.len() { format!(" and {} shorter ones", left.len() - named.len()) } else { String::new() };
    (!left.is_empty())
        .then(|| format!("segments left as they are, because the forecast gains nothing: {}{more}", named.join(", ")))
}

fn segment_without_gain(of: &WithoutGain) -> String {
    let ((first, last), (before, after)) = (of.lines, (of.before_mm, of.after_mm));
    let lines = if first == last { format!("line {first}") } else { format!("lines {first} to {last}") };
    format!("{lines} ({} → {} µm RMS, {} → {} µm MAX)", um(before.0), um(after.0), um(before.1), um(after.1))
}

/// Shares of the feed length of a program, 0…1; the rest is compensated.
pub struct Shares {
    pub without_gain: f64,
    pub left_alone: f64,
}

/// What became of the feed length of a program, and how it grew. `points` are its finest and coarsest ones.
pub fn summary(
    shares: &Shares,
    points: Option<(RefitSettings, RefitSettings)>,
    slow_stop: Option<SlowStop>,
    lines: (usize, usize),
) -> String {
    let points = points.filter(|(finest, _)| finest.spacing_s.is_finite()).map_or(String::new(), |(finest, coarsest)| {
        let both = |a: f64, b: f64| if a == b { a.to_string() } else { format!("{a} to {b}") };
        let spacing_ms = both(finest.spacing_s * 1e3, coarsest.spacing_s * 1e3);
        let chord_um = both(finest.chord_tolerance_mm * 1e3, coarsest.chord_tolerance_mm * 1e3);
        format!(", with points at least {spacing_ms} ms apart and lines within {chord_um} µm of the corrected curve")
    });
    let stops = slow_stop.map_or(String::new(), |SlowStop { length_mm, time_s }| {
        let time_ms = time_s * 1e3;
        format!("\nstops: the last {length_mm:.3} mm before them take {time_ms:.0} ms, for less error there (--keep-stops: as programmed)")
    });
    let share = |share: f64| format!("{:.1} %", 100.0 * share);
    let Shares { without_gain, left_alone } = shares;
    format!(
        "feed length: {} compensated, {} without gain, {} left alone; {} lines in, {} out{points}{stops}",
        share((1.0 - without_gain - left_alone).max(0.0)),
        share(*without_gain),
        share(*left_alone),
        lines.0,
        lines.1
    )
}

/// The same as JSON.
pub fn summary_json(part: &Part, outcome: &Outcome, lines: (usize, usize)) -> Value {
    json!({
        "dialect": dialect_name(&part.program, &part.options),
        "lines_in": lines.0,
        "lines_out": lines.1,
        "without_gain": without_gain_json(&outcome.without_gain),
        "without_gain_share": part.share(outcome.without_gain.iter().map(|left| left.length_mm).sum()),
        "spacing_ms": outcome.written.map(|written| written.spacing_s * 1e3),
        "chord_tolerance_um": outcome.written.map(|written| written.chord_tolerance_mm * 1e3),
        "slow_stop": outcome.written.and_then(|written| written.slow_stop).map(slow_stop_json),
    })
}

/// A slow zone before stops as JSON.
pub fn slow_stop_json(SlowStop { length_mm, time_s }: SlowStop) -> Value {
    json!({ "length_mm": length_mm, "time_ms": time_s * 1e3 })
}

/// Segments without gain as JSON.
pub fn without_gain_json(left: &[WithoutGain]) -> Value {
    let one = |left: &WithoutGain| {
        json!({
            "lines": [left.lines.0, left.lines.1],
            "length_mm": left.length_mm,
            "before_um": { "rms": left.before_mm.0 * 1e3, "max": left.before_mm.1 * 1e3 },
            "after_um": { "rms": left.after_mm.0 * 1e3, "max": left.after_mm.1 * 1e3 },
        })
    };
    left.iter().map(one).collect()
}

pub const NO_GAIN: &str = "the model predicts no gain worth having";

pub const LIMITS_FROM_LOG: &str =
    "note: the machine's limits were taken from what the training log reached; give --machine to state them";

/// Why nothing is changed where the cycle would take longer by this share whatever the points.
pub fn too_slow(slowdown: f64) -> String {
    format!("the cycle would take at least {:.2} % longer, which --cycle-limit does not allow", 100.0 * slowdown)
}

/// What was written.
pub fn written(largest_shift_mm: f64, out: &Path) -> String {
    format!("largest shift {} µm; written to {}", um(largest_shift_mm), out.display())
}

/// Why a path is left as it is: there is nothing that may be changed, or nothing that changing it would better.
fn why_unchanged(part: Option<&Part>, outcome: &Outcome) -> String {
    if let Some(slowdown) = outcome.too_slow {
        return too_slow(slowdown);
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
        _ => "the correction fades there",
    };
    format!("{place}: {reason} of axis {axis} lies outside what the model was trained on ({samples} samples); {effect}")
}
