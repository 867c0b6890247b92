//! What a training found.

use models::{Bundle, HeldOut};
use pipeline::training::{Adapted, Stretches, Trained, Unreached};
use pipeline::units::ErrorUnit;
use serde_json::{Map, Value, json};

use crate::output::table;

/// Held-out figures of every axis; µm, or µrad for rotary axes.
pub fn held_out(model: &Bundle) -> String {
    let rows: Vec<Vec<String>> = model
        .manifest
        .axes
        .iter()
        .map(|axis| {
            let unit = ErrorUnit::from(axis);
            let HeldOut { rms, max, linear_rms, raw_rms, band_held, .. } = axis.held_out;
            std::iter::once(unit.label(&axis.name))
                .chain([rms, max, linear_rms, raw_rms].map(|value| unit.number(value)))
                .chain([format!("{:.1} %", band_held * 100.0), axis.predictor.clone()])
                .collect()
        })
        .collect();
    let folds = model.manifest.axes.iter().map(|axis| axis.held_out.folds).max().unwrap_or_default();
    let title = format!("held out, {folds} fold{}", if folds == 1 { "" } else { "s" });
    table(&[&title, "RMS", "MAX", "linear RMS", "tracking error RMS", "95 % band holds", "predictor"], &rows)
}

/// The figures as JSON.
pub fn json(trained: &Trained, seconds: f64) -> Value {
    let axes: Map<String, Value> = trained
        .bundle
        .manifest
        .axes
        .iter()
        .zip(&trained.lags_s)
        .map(|(axis, lag)| {
            let unit = ErrorUnit::from(axis);
            let HeldOut { rms, max, linear_rms, raw_rms, band_held, .. } = axis.held_out;
            let figures = json!({
                unit.key("held_out_rms"): unit.value(rms),
                unit.key("held_out_max"): unit.value(max),
                unit.key("linear_rms"): unit.value(linear_rms),
                unit.key("raw_rms"): unit.value(raw_rms),
                "band_held_share": band_held,
                "folds": axis.held_out.folds,
                "lag_ms": lag.map(|lag| lag * 1e3),
                "predictor": axis.predictor,
                "coverage": axis.coverage,
            });
            (axis.name.clone(), figures)
        })
        .collect();
    json!({ "seconds": seconds, "axes": axes, "common_lag_ms": trained.bundle.manifest.common_delay_s * 1e3, "left_out": trained.left_out, "notes": trained.notes,
        "samples": trained.stretches.as_ref().map(|taken| json!({ "trained_on": taken.samples, "of": taken.of, "stretches": taken.runs.len() })) })
}

/// A machine file whose accelerations no log comes near to.
pub fn unreached(axes: &[Unreached]) -> String {
    let of_axis = |axis: &Unreached| format!("{} {:.0} of {:.0} mm/s²", axis.axis, axis.reached_mm_s2, axis.limit_mm_s2);
    format!(
        "the logs accelerate by less than half of what the machine file allows ({}): where the control is slower than the file, programs are planned too \
         fast, and compensation makes them worse. Put the control's own limits into the machine file, give the programs that ran with --programs, or \
         compensate with --reference",
        axes.iter().map(of_axis).collect::<Vec<_>>().join(", ")
    )
}

/// What was taken of long logs.
pub fn stretches(trained: &Trained) -> Option<String> {
    let Stretches { runs, samples, of } = trained.stretches.as_ref()?;
    let share = 100.0 * *samples as f64 / *of as f64;
    let what =
        format!("trained on {samples} of {of} samples ({share:.0} %), in {} stretches that show most of the motion", runs.len());
    Some(format!("{what}; --most-samples takes more"))
}

/// How late every axis follows its command, and all together.
pub fn lags(trained: &Trained) -> String {
    let manifest = &trained.bundle.manifest;
    let lag = |(axis, lag): (&models::AxisManifest, &Option<f64>)| Some(format!("{} {:.3} ms", axis.name, (*lag)? * 1e3));
    let lags: Vec<String> = manifest.axes.iter().zip(&trained.lags_s).filter_map(lag).collect();
    format!("lag behind the command: {}; all axes together {:.3} ms", lags.join(", "), manifest.common_delay_s * 1e3)
}

/// The range that every axis was trained on, a line each.
pub fn coverage(model: &Bundle) -> Vec<String> {
    let line = |axis: &models::AxisManifest| {
        let c = &axis.coverage;
        format!(
            "coverage of {}: position {:.3} to {:.3}, speed to {:.2}, acceleration to {:.1}, {} reversals, {} starts, {:.1} s at rest",
            axis.name, c.position.0, c.position.1, c.velocity, c.acceleration, c.reversals, c.starts, c.dwell_s
        )
    };
    model.manifest.axes.iter().map(line).collect()
}

/// What became of every axis of an adapted model.
pub fn adapted(adapted: &Adapted) -> String {
    let row = |axis: &pipeline::training::AdaptedAxis| {
        let verdict = if axis.taken { "adapted" } else { "kept as it was" };
        let unit = axis.unit;
        vec![unit.label(&axis.name), unit.number(axis.before), unit.number(axis.held_out), verdict.to_owned()]
    };
    let rows: Vec<Vec<String>> = adapted.axes.iter().map(row).collect();
    table(&["axis", "error before RMS", "adapted, held out RMS", ""], &rows)
}

/// The same as JSON.
pub fn adapted_json(adapted: &Adapted, seconds: f64, warnings: &[String]) -> Value {
    let axis = |axis: &pipeline::training::AdaptedAxis| {
        let figures = json!({
            axis.unit.key("before_rms"): axis.unit.value(axis.before),
            axis.unit.key("held_out_rms"): axis.unit.value(axis.held_out),
            "adapted": axis.taken,
        });
        (axis.name.clone(), figures)
    };
    let axes: Map<String, Value> = adapted.axes.iter().map(axis).collect();
    json!({ "seconds": seconds, "axes": axes, "warnings": warnings })
}
