//! Models and changes of a fleet, in words, as tables and as JSON.

use fleet::{AxisDay, Change, Finished, Phase, Quantity};
use pipeline::units::ErrorUnit;
use serde_json::{Map, Value, json};

use crate::output::table;

/// A trained machine in a line.
pub fn model(done: &Finished, seconds: f64) -> String {
    let axis = |axis: &models::AxisManifest| format!("{} {}", axis.name, ErrorUnit::from(axis).text(axis.held_out.rms));
    let axes: Vec<String> = done.bundle.manifest.axes.iter().map(axis).collect();
    let baseline = &done.baseline;
    format!(
        "{}: {} days of training, {} healthy days; held-out RMS {}; {seconds:.1} s",
        baseline.machine,
        baseline.trained_on.len(),
        baseline.calibrated_on.len(),
        axes.join(", ")
    )
}

/// The same as JSON.
pub fn model_json(done: &Finished, seconds: f64) -> Value {
    let axis = |axis: &models::AxisManifest| {
        let unit = ErrorUnit::from(axis);
        (axis.name.clone(), json!({ unit.key("held_out_rms"): unit.value(axis.held_out.rms) }))
    };
    let axes: Map<String, Value> = done.bundle.manifest.axes.iter().map(axis).collect();
    json!({ "axes": axes, "trained_on": done.baseline.trained_on, "calibrated_on": done.baseline.calibrated_on, "seconds": seconds })
}

/// A row for every axis of every machine: its last day, and the number of its alarms.
pub fn summary(rows: &[AxisDay]) -> String {
    let header =
        ["machine", "axis", "last day", "days", "model RMS µm", "held out µm", "friction µm", "backlash µm", "lag ms", "alarms"];
    let mut axes: Vec<Vec<&AxisDay>> = Vec::new();
    for row in rows {
        let is_same = |known: &[&AxisDay]| known[0].machine == row.machine && known[0].quality.axis == row.quality.axis;
        match axes.iter_mut().find(|known| is_same(known)) {
            Some(known) => known.push(row),
            None => axes.push(vec![row]),
        }
    }
    let line = |days: &Vec<&AxisDay>| -> Option<Vec<String>> {
        let last = days.last()?;
        let of = |value: Option<f64>, digits: usize| value.map_or_else(|| "–".to_owned(), |value| format!("{value:.digits$}"));
        let estimate = last.estimate.as_ref();
        let level = |quantity: Quantity| last.levels.get(&quantity).copied();
        Some(vec![
            last.machine.clone(),
            last.quality.axis.clone(),
            last.date.clone(),
            days.len().to_string(),
            of(estimate.map(|estimate| estimate.model_rms_um), 3),
            of(estimate.map(|estimate| estimate.held_out_rms_um), 3),
            of(level(Quantity::Friction), 2),
            of(level(Quantity::Backlash), 2),
            of(level(Quantity::Lag), 3),
            days.iter().map(|day| day.alarms().count()).sum::<usize>().to_string(),
        ])
    };
    table(&header, &axes.iter().filter_map(line).collect::<Vec<_>>())
}

/// A line for every day of an axis with alarms.
pub fn alarms(rows: &[AxisDay]) -> Vec<String> {
    let line = |row: &AxisDay| {
        let found: Vec<String> = row.alarms().filter_map(|quantity| Some(text(quantity, row.changes.get(&quantity)?))).collect();
        (!found.is_empty()).then(|| format!("alarm: {} {} {}: {}", row.machine, row.date, row.quality.axis, found.join(", ")))
    };
    rows.iter().filter_map(line).collect()
}

/// A change with its limit.
fn text(quantity: Quantity, change: &Change) -> String {
    let Change { change, limit } = *change;
    match quantity {
        Quantity::Fit => format!("error of the model × {:.2} (limit × {:.2})", change.exp(), limit.exp()),
        Quantity::Reversals => format!("error behind reversals × {:.2} (limit × {:.2})", change.exp(), limit.exp()),
        Quantity::Friction => format!("friction {:+.1} % (limit {:.1} %)", 100.0 * change, 100.0 * limit),
        Quantity::Backlash => format!("backlash {change:+.2} µm (limit {limit:.2} µm)"),
        Quantity::Lag => format!("lag {change:+.0} µs (limit {limit:.0} µs)"),
    }
}

/// The alarms, and of how many days, as JSON.
pub fn watch_json(rows: &[AxisDay], seconds: f64) -> Value {
    let alarm = |row: &AxisDay, quantity: Quantity| {
        let change = row.changes.get(&quantity);
        json!({
            "machine": row.machine,
            "date": row.date,
            "axis": row.quality.axis,
            "quantity": quantity.name(),
            quantity.change_name(): change.map(|change| change.change),
            "limit": change.map(|change| change.limit),
        })
    };
    let all: Vec<Value> = rows.iter().flat_map(|row| row.alarms().map(move |quantity| alarm(row, quantity))).collect();
    let mut watched: Vec<(&str, &str)> =
        rows.iter().filter(|row| row.phase == Phase::Watched).map(|row| (row.machine.as_str(), row.date.as_str())).collect();
    watched.dedup();
    json!({ "alarms": all, "watched_machine_days": watched.len(), "rows": rows.len(), "seconds": seconds })
}
