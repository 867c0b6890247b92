//! Sections on a model: errors on held-out runs, the range that it was trained on beside what a part asks, its fit to a log.

use models::{AxisManifest, AxisSignal, Bundle, OperatingRange};
use motion::Vec3;
use pipeline::measure::Fit;
use pipeline::training::{Adapted, Trained};
use pipeline::units::{ErrorUnit, in_programs};
use pipeline::{Input, Log};

use super::column::Column;
use super::section::{Chart, Content, Line, Quantity, RangeRow, Ranges, Section, Style, Table, Verdict};
use super::thin::thinned;

/// Samples that are drawn of the held-out runs of an axis.
const MOST_SAMPLES: usize = 20_000;
/// Share of the tracking error that a good model leaves at most, and that a fair one leaves: from the latter on `train` warns.
const LEFT: [f64; 2] = [0.2, 0.5];

/// Errors of every axis on runs that training never saw.
#[must_use]
pub fn known(model: &Bundle) -> Section {
    let share = |axis: &AxisManifest| axis.held_out.rms / axis.held_out.raw_rms;
    let row = |axis: &AxisManifest| {
        let (unit, held) = (ErrorUnit::from(axis), &axis.held_out);
        let errors = [held.raw_rms, held.linear_rms, held.rms, held.max].map(|value| unit.number(value));
        let shares = [100.0 * share(axis), 100.0 * held.band_held].map(|percent| format!("{percent:.1} %"));
        std::iter::once(unit.label(&axis.name)).chain(errors).chain(shares).collect()
    };
    let verdict = |axis: &AxisManifest| match share(axis) {
        share if share <= LEFT[0] => Verdict::Good,
        share if share <= LEFT[1] => Verdict::Fair,
        _ => Verdict::Poor,
    };
    let header = ["axis", "tracking error RMS", "linear model RMS", "model RMS", "model MAX", "left over", "95 % band holds"];
    let axes = &model.manifest.axes;
    let table = Table { verdicts: axes.iter().map(verdict).collect(), ..Table::new(&header, axes.iter().map(row).collect()) };
    let note = format!(
        "How well the model predicts runs that it was not fitted to. What is left over of the tracking error cannot be corrected: good up to \
         {:.0} %, fair up to {:.0} %.",
        100.0 * LEFT[0],
        100.0 * LEFT[1]
    );
    Section::new("Held-out errors of the model", note, Content::Table(table))
}

/// Measured and predicted tracking error of every axis on held-out runs, with the prediction interval.
#[must_use]
pub fn held_out(trained: &Trained, logs: &[Log]) -> Vec<Section> {
    let axes = trained.bundle.manifest.axes.iter().zip(&trained.held_out);
    axes.filter_map(|(axis, pieces)| held_out_axis(axis, pieces, logs)).flatten().collect()
}

fn held_out_axis(axis: &AxisManifest, pieces: &[pipeline::training::HeldOutPiece], logs: &[Log]) -> Option<[Section; 2]> {
    let unit = ErrorUnit::from(axis);
    let (mut time_s, mut measured, mut predicted, mut half_width) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut now_s = 0.0;
    for piece in pieces {
        let log = logs.get(piece.run)?;
        let (reference, actual) = (log.reference.column(&axis.name)?, log.actual.column(&axis.name)?);
        let widths = axis.band.at(&AxisSignal::uncompensated(&reference[piece.rows.clone()], log.period_s()));
        for ((k, error), width) in piece.rows.clone().zip(&piece.errors).zip(widths) {
            time_s.push(now_s);
            measured.push(unit.value(reference[k] - actual[k]));
            predicted.push(unit.value(reference[k] - actual[k] + error));
            half_width.push(unit.value(width));
            now_s += log.period_s();
        }
        // A gap between two runs.
        time_s.push(now_s);
        [&mut measured, &mut predicted, &mut half_width].into_iter().for_each(|column| column.push(f64::NAN));
        now_s += log.period_s();
    }
    let residual: Vec<f64> = measured.iter().zip(&predicted).map(|(m, p)| m - p).collect();
    let kept = thinned(MOST_SAMPLES, &[&measured, &predicted, &residual], &vec![Vec3::zeros(); time_s.len()]);
    if kept.is_empty() {
        return None;
    }
    let column = |of: &dyn Fn(usize) -> f64| Column::scaled(&kept.iter().map(|k| of(*k)).collect::<Vec<f64>>());
    let line = |name: &str, style, color, values| Line { name: name.to_owned(), style, color, values };
    let time_s: Vec<f64> = kept.iter().map(|k| time_s[*k]).collect();
    let chart = |name: &str, lines: Vec<Line>| {
        let x = Quantity::at("held-out time", "s", &time_s);
        Content::Chart(Chart { x, y: Quantity::of(name, unit.sign()), lines, log: [false, false] })
    };
    let errors = vec![
        line("measured", Style::Line, 0, column(&|k| measured[k])),
        line("predicted", Style::Dashed, 1, column(&|k| predicted[k])),
    ];
    let left = vec![
        line("95 % interval, from", Style::Low, 1, column(&|k| -half_width[k])),
        line("to", Style::High, 1, column(&|k| half_width[k])),
        line("measured − predicted", Style::Line, 0, column(&|k| residual[k])),
    ];
    let note = "Runs that were held out, one after the other: each is predicted by a model that was fitted without it.";
    let band = "The same runs: measured minus predicted. The band is the model's 95 % prediction interval.";
    Some([
        Section::new(&format!("Prediction of axis {}", axis.name), note, chart("tracking error", errors)),
        Section::new(&format!("What is left over of axis {}", axis.name), band, chart("measured − predicted", left)),
    ])
}

/// The errors of an adapted model.
#[must_use]
pub fn adaptation(adapted: &Adapted) -> Section {
    let row = |axis: &pipeline::training::AdaptedAxis| {
        let errors = [axis.before, axis.held_out].map(|value| axis.unit.number(value));
        let what = if axis.taken { "adapted" } else { "kept as it was" };
        std::iter::once(axis.unit.label(&axis.name)).chain(errors).chain([what.to_owned()]).collect()
    };
    let table = Table::new(&["axis", "error before RMS", "adapted, held out RMS", ""], adapted.axes.iter().map(row).collect());
    let note =
        "Errors of the model on the new log, before its adaptation and after it, on folds of the log to which it was not fitted.";
    Section::new("Adaptation", note, Content::Table(table))
}

/// What the training data hold of every axis.
#[must_use]
pub fn trained_range(model: &Bundle) -> Section {
    let row = |axis: &AxisManifest| {
        let c = &axis.coverage;
        let (scale, unit) = programs(axis);
        let number = |value: f64| format!("{:.2}", value * scale);
        let position = format!("{} to {}", number(c.position.0), number(c.position.1));
        let events = [c.reversals.to_string(), c.starts.to_string(), format!("{:.1}", c.dwell_s)];
        let sizes = [number(c.velocity), number(c.acceleration)];
        [format!("{} ({unit})", axis.name), position].into_iter().chain(sizes).chain(events).collect()
    };
    let header = ["axis", "position", "speed up to, per s", "acceleration up to, per s²", "reversals", "starts", "standstill s"];
    let table = Table::new(&header, model.manifest.axes.iter().map(row).collect());
    let note = "What the model was trained on. Outside of these speeds and accelerations corrections fade; outside of the positions the terms \
                that depend on the position fade.";
    Section::new("Operating range", note, Content::Table(table))
}

/// What a part asks of every axis, beside what the model was trained on.
#[must_use]
pub fn asked(model: &Bundle, input: &Input) -> Section {
    let is_placed = input.part().is_none_or(|part| part.placement.known());
    let command = input.command();
    let rows = |axis: &AxisManifest| -> Vec<RangeRow> {
        let Some(column) = command.column(&axis.name) else { return Vec::new() };
        let asks = OperatingRange::of(std::iter::once(column), command.period_s());
        let (scale, unit) = programs(axis);
        let row = |name: &str, per: &str, has: [f64; 2], asks: [f64; 2]| RangeRow {
            name: format!("{} {name}", axis.name),
            unit: format!("{unit}{per}"),
            has: has.map(|value| value * scale),
            asks: asks.map(|value| value * scale),
        };
        let position = is_placed.then(|| row("position", "", axis.coverage.position.into(), asks.position.into()));
        let speed = row("speed", "/s", [0.0, axis.coverage.velocity], [0.0, asks.velocity]);
        let acceleration = row("acceleration", "/s²", [0.0, axis.coverage.acceleration], [0.0, asks.acceleration]);
        position.into_iter().chain([speed, acceleration]).collect()
    };
    let names = ["trained on".to_owned(), "the part asks".to_owned()];
    let ranges = Ranges { names, rows: model.manifest.axes.iter().flat_map(rows).collect() };
    let unplaced = if is_placed { "" } else { " The work offset is not known, so positions are not compared." };
    let note = format!("Where the part leaves the range that the model was trained on, its corrections fade.{unplaced}");
    Section::new("Operating range", note, Content::Ranges(ranges))
}

/// Whether a model still fits the machine that made a log.
#[must_use]
pub fn model_fit(fits: &[Fit]) -> Section {
    let row = |fit: &Fit| {
        let errors = [fit.rms, fit.expected].map(|value| fit.unit.number(value));
        let shares = [fit.in_band, fit.outside].map(|share| format!("{:.1} %", 100.0 * share));
        std::iter::once(fit.unit.label(&fit.axis)).chain(errors).chain(shares).collect()
    };
    let verdict = |fit: &Fit| match fit.stale {
        true => Verdict::Poor,
        false if fit.outside >= 1.0 => Verdict::Fair,
        false => Verdict::Good,
    };
    let header = ["axis", "error RMS", "held-out RMS", "within its 95 % band", "outside its range"];
    let table = Table { verdicts: fits.iter().map(verdict).collect(), ..Table::new(&header, fits.iter().map(row).collect()) };
    let note = "The model's prediction beside the log. Good: it fits. Poor: it is stale; train again, or adapt it with `train --from`. \
                Fair: not judged, since the run lies outside of what the model was trained on.";
    Section::new("Does the model still fit?", note, Content::Table(table))
}

fn programs(axis: &AxisManifest) -> (f64, &'static str) {
    in_programs(if axis.rotary { motion::AxisKind::Rotary } else { motion::AxisKind::Linear })
}
