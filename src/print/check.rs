//! What a log holds.

use datasets::{Column, Finding, Inspection, Log, Report, Role, Severity};
use motion::AxisKind;
use pipeline::statistics::rms_max;
use pipeline::units::{ErrorUnit, in_programs};
use serde_json::{Map, Value, json};

use crate::output::{Printer, table};

/// Characters of a picture.
const PICTURE: usize = 60;
const BARS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];

/// One log: its columns, and every axis of every run with a picture.
pub fn show(printer: &Printer, found: &Inspection) {
    for (index, log) in found.runs.iter().enumerate() {
        let (period_ms, seconds) = (log.period_s() * 1e3, log.reference.duration_s());
        let (format, rows) = (found.format, rows(found, log));
        printer.line(format!("{}: {format}, {rows} rows, one every {period_ms:.3} ms, {seconds:.2} s", log.name));
        if index == 0 {
            let of = |column: &Column| vec![column.name.clone(), role(&column.role), column.unit.clone()];
            printer.line(table(&["column", "taken for", "unit"], &found.columns.iter().map(of).collect::<Vec<_>>()));
        }
        show_axes(printer, log);
    }
    found.report.findings.iter().for_each(|finding| printer.line(finding));
}

/// Rows of a run: those of the file where it is one run.
fn rows(found: &Inspection, log: &Log) -> usize {
    if found.runs.len() == 1 { found.rows } else { log.len() }
}

fn show_axes(printer: &Printer, log: &Log) {
    for (axis, (reference, actual)) in log.axes().iter().zip(log.reference.columns().iter().zip(log.actual.columns())) {
        let error: Vec<f64> = reference.iter().zip(actual).map(|(r, a)| r - a).collect();
        let ((rms, max), unit, (scale, shown)) = (rms_max(&error), ErrorUnit::from(axis), in_programs(axis.kind));
        let (low, high) = range(reference);
        let (low, high) = (low * scale, high * scale);
        printer.line(format!("{axis}  {}  {low:.3} to {high:.3} {shown}", picture(reference, range(reference))));
        let most = max.max(f64::MIN_POSITIVE);
        let text = format!("command − actual, {} RMS, {} at most", unit.text(rms), unit.text(max));
        printer.line(format!("{}  {}  {text}", " ".repeat(axis.name.chars().count()), picture(&error, (-most, most))));
    }
}

fn role(role: &Role) -> String {
    match role {
        Role::Time => "time".to_owned(),
        Role::Commanded(axis) => format!("{axis} commanded"),
        Role::Actual(axis) => format!("{axis} actual"),
        Role::Error(axis) => format!("{axis} tracking error"),
        Role::Unused => "not used".to_owned(),
    }
}

fn range(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(*value), high.max(*value)))
}

/// Values over time, as bars between the ends of a range; each of the value that is furthest from the middle.
fn picture(values: &[f64], (low, high): (f64, f64)) -> String {
    let middle = f64::midpoint(low, high);
    let bar = |k: usize| {
        let of = |k: usize| k * values.len() / PICTURE;
        let part = values.get(of(k)..of(k + 1).max(of(k) + 1).min(values.len())).unwrap_or_default();
        let value = part.iter().copied().max_by(|a, b| (a - middle).abs().total_cmp(&(b - middle).abs()))?;
        let share = if high > low { (value - low) / (high - low) } else { 0.5 };
        Some(BARS[((share * BARS.len() as f64) as usize).min(BARS.len() - 1)])
    };
    (0..PICTURE).filter_map(bar).collect()
}

/// What is to be done with the logs.
pub fn verdict(worst: Option<Severity>) -> String {
    match worst {
        Some(Severity::Refuse) => "verdict: not fit for training; mend what is refused above",
        Some(Severity::Warn) => "verdict: fit for training, with the warnings above",
        Some(Severity::Note) | None => "verdict: fit for training",
    }
    .to_owned()
}

/// The same in a word.
pub fn verdict_name(worst: Option<Severity>) -> &'static str {
    match worst {
        Some(Severity::Refuse) => "unfit",
        Some(Severity::Warn) => "fit with warnings",
        Some(Severity::Note) | None => "fit",
    }
}

/// The runs of a log as JSON; the findings about the file are those of the first one.
pub fn json(found: &Inspection) -> Vec<Value> {
    let findings = |index: usize| if index == 0 { findings_json(&found.report) } else { Value::Array(Vec::new()) };
    found.runs.iter().enumerate().map(|(index, log)| run_json(found, log, findings(index))).collect()
}

fn run_json(found: &Inspection, log: &Log, findings: Value) -> Value {
    let columns: Vec<Value> = found.columns.iter().map(column_json).collect();
    let pairs = log.reference.columns().iter().zip(log.actual.columns());
    let axes: Map<String, Value> = log
        .axes()
        .iter()
        .zip(pairs)
        .map(|(axis, (reference, actual))| {
            let error: Vec<f64> = reference.iter().zip(actual).map(|(r, a)| r - a).collect();
            let ((rms, max), unit, (low, high)) = (rms_max(&error), ErrorUnit::from(axis), range(reference));
            let position = if axis.kind == AxisKind::Linear { "position_mm" } else { "position_rad" };
            let figures = json!({
                position: [low, high],
                unit.key("tracking_rms"): unit.value(rms),
                unit.key("tracking_max"): unit.value(max),
            });
            (axis.name.clone(), figures)
        })
        .collect();
    json!({
        "name": log.name,
        "format": found.format,
        "rows": rows(found, log),
        "period_ms": log.period_s() * 1e3,
        "seconds": log.reference.duration_s(),
        "columns": columns,
        "axes": axes,
        "findings": findings,
    })
}

fn column_json(column: &Column) -> Value {
    let (role, axis) = match &column.role {
        Role::Time => ("time", None),
        Role::Commanded(axis) => ("commanded", Some(&axis.name)),
        Role::Actual(axis) => ("actual", Some(&axis.name)),
        Role::Error(axis) => ("error", Some(&axis.name)),
        Role::Unused => ("unused", None),
    };
    json!({ "name": column.name, "role": role, "axis": axis, "unit": column.unit })
}

/// Findings as JSON.
pub fn findings_json(report: &Report) -> Value {
    let one = |finding: &Finding| {
        let severity = match finding.severity {
            Severity::Note => "note",
            Severity::Warn => "warning",
            Severity::Refuse => "refused",
        };
        let place = &finding.place;
        json!({
            "severity": severity,
            "check": finding.check.name(),
            "run": place.run,
            "column": place.column,
            "row": place.row,
            "time_s": place.time_s,
            "message": finding.message,
        })
    };
    report.findings.iter().map(one).collect()
}
