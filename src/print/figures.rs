//! The figures of a run in words and as JSON.

use motion::contour::ContourSummary;
use motion::{Axis, MotionError, Trajectory};
use pipeline::statistics::{Figures, OrientationSummary, rms_max};
use pipeline::units::{ErrorUnit, um};
use serde_json::{Value, json};

/// The JSON figures of a contour error: `{"rms":…,"max":…,"p95":…}`, µm.
pub fn contour_json(figures: &ContourSummary) -> Value {
    json!({ "rms": figures.rms_mm * 1e3, "max": figures.max_mm * 1e3, "p95": figures.p95_mm * 1e3 })
}

/// The JSON figures of an orientation error, µrad; `null` where the tool does not turn.
pub fn orientation_json(figures: Option<&OrientationSummary>) -> Value {
    figures.map_or(Value::Null, |f| json!({ "rms": f.rms_rad * 1e6, "max": f.max_rad * 1e6, "p95": f.p95_rad * 1e6 }))
}

/// The figures of a run in words: "0.25 µm RMS, 0.81 µm MAX", with those of the tool's direction where it turns.
pub fn text(figures: &Figures) -> String {
    let tip = format!("contour error {} µm RMS, {} µm MAX", um(figures.tip.rms_mm), um(figures.tip.max_mm));
    match &figures.orientation {
        None => tip,
        Some(o) => format!("{tip}; tool direction {:.2} µrad RMS, {:.2} µrad MAX", o.rms_rad * 1e6, o.max_rad * 1e6),
    }
}

/// The JSON figures of tracking errors, by axis: µm for linear axes, µrad for rotary ones.
///
/// # Errors
/// When reference and actual do not match.
pub fn tracking_json(reference: &Trajectory, actual: &Trajectory) -> Result<Value, MotionError> {
    let errors = reference.tracking_error(actual)?;
    Ok(tracking_figures_json(reference.axes(), &errors.iter().map(|error| rms_max(error)).collect::<Vec<_>>()))
}

/// The same of RMS and MAX of every axis, mm or rad.
pub fn tracking_figures_json(axes: &[Axis], figures: &[(f64, f64)]) -> Value {
    let entries = axes.iter().zip(figures).map(|(axis, (rms, max))| {
        let unit = ErrorUnit::from(axis);
        // The key above all axes says µm already.
        let key = |quantity: &str| if unit == ErrorUnit::Micrometre { quantity.to_owned() } else { unit.key(quantity) };
        (axis.name.clone(), json!({ key("rms"): unit.value(*rms), key("max"): unit.value(*max) }))
    });
    Value::Object(entries.collect())
}
