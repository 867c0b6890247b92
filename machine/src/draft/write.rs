//! The machine file of a draft, with a comment beside every value.

use std::fmt::Write;

use super::known::{AxisDraft, Draft, Known};
use crate::{ControllerSpec, CornerRule, MachineError, MachineSpec};

/// Time in which the acceleration changes from nothing to its limit where a control states no jerk, ms.
const RISE_MS: f64 = 20.0;

impl Draft {
    /// The machine file with comments. It is read once more before it is returned.
    ///
    /// # Errors
    /// When values are [missing](Draft::missing) or out of range.
    pub fn to_toml(&self) -> Result<String, MachineError> {
        let missing: Vec<String> = self.missing().into_iter().map(|missing| missing.what).collect();
        if !missing.is_empty() {
            return Err(MachineError::BadDescription(format!("it lacks {}", missing.join(", "))));
        }
        let text = file(self)?;
        MachineSpec::from_toml(&text)?;
        Ok(text)
    }
}

/// The file. Nothing that it needs is missing.
fn file(draft: &Draft) -> Result<String, MachineError> {
    let mut out = format!("# Machine file, from {}.\n# Every key is explained in docs/machine-file.md.\n", draft.origin);
    let mut line = |text: String| {
        out.push_str(&text);
        out.push('\n');
    };
    draft.notes.iter().for_each(|note| line(format!("# Note: {note}.")));
    line(format!("name = {}", toml::Value::String(draft.name.clone())));
    let period = draft.period_ms.as_ref().map_or(Known::new(0.0, ""), Known::clone);
    line(format!("sampling_period_ms = {}  # time between samples of command and logs; {}", number(period.value), period.source));
    let linear: Vec<&AxisDraft> = draft.axes.iter().filter(|axis| !axis.is_rotary).collect();
    // Where the control states no limit along the path, those of the axes alone hold.
    let of_axes = |of: fn(&AxisDraft) -> &Option<Known<f64>>, with: fn(f64, f64) -> f64| {
        linear.iter().filter_map(|axis| of(axis).as_ref()).map(|known| known.value).fold(0.0, with)
    };
    let velocity = draft.path_velocity_mm_s.clone().unwrap_or_else(|| {
        Known::new(of_axes(|axis| &axis.velocity, f64::hypot), "what the axes allow together: no limit of its own is known")
    });
    let acceleration = draft.path_acceleration_mm_s2.clone().unwrap_or_else(|| {
        Known::new(of_axes(|axis| &axis.acceleration, f64::max), "the largest of the axes: no limit of its own is known")
    });
    let rise = draft.rise_ms.clone().unwrap_or(Known::new(RISE_MS, "assumed: the acceleration rises within 20 ms"));
    let jerk = acceleration.value / (1e-3 * rise.value);
    line("\n# Limits along the path.\n[path]".to_owned());
    line(format!("velocity_mm_s = {}  # {}", number(velocity.value), velocity.source));
    line(format!("acceleration_mm_s2 = {}  # {}", number(acceleration.value), acceleration.source));
    line(format!("jerk_mm_s3 = {}  # {}", number(jerk), rise.source));
    let across =
        draft.centripetal_mm_s2.clone().unwrap_or_else(|| Known::new(acceleration.value, "as the acceleration along the path"));
    line(format!("centripetal_mm_s2 = {}  # across the path, in arcs; {}", number(across.value), across.source));
    if let Some(both) = &draft.arc_acceleration_mm_s2 {
        line(format!("arc_acceleration_mm_s2 = {}  # along and across together; {}", number(both.value), both.source));
    }
    if let Some(smoothing_ms) = draft.smoothing_ms {
        line(format!("smoothing_ms = {}  # further smoothing of the acceleration", number(smoothing_ms)));
    }
    if let Some(share) = &draft.short_line_acceleration {
        line(format!("short_line_acceleration = {}  # {}", number(share.value), share.source));
    }
    line("\n[kinematics]\nkind = \"cartesian\"  # \"five-axis\" where rotary axes tilt the tool: docs/five-axis.md".to_owned());
    if let Some(control) = &draft.control {
        let (key, value) = match control.value.corners {
            CornerRule::BlendMm(value) => ("blend_mm", value),
            CornerRule::SpeedJumpMmS(value) => ("speed_jump_mm_s", value),
            CornerRule::JunctionDeviationMm(value) => ("junction_deviation_mm", value),
        };
        line(format!(
            "\n# How the control passes corners.\n[control]\ncorners = {{ {key} = {} }}  # {}",
            number(value),
            control.source
        ));
        if let Some(lines) = &draft.look_ahead_lines {
            line(format!("look_ahead_lines = {}  # {}", lines.value, lines.source));
        }
    }
    if let Some(name) = &draft.controller {
        let profile = toml::to_string(&ControllerSpec::builtin(name)?);
        let profile = profile.map_err(|error| MachineError::BadDescription(error.to_string()))?;
        line(format!(
            "\n# How compensated programs are written: the built-in profile `{name}`.\n[controller]\n{}",
            profile.trim_end()
        ));
    }
    for axis in &draft.axes {
        line(axis_of(axis, &rise)?);
    }
    Ok(out)
}

fn axis_of(axis: &AxisDraft, rise: &Known<f64>) -> Result<String, MachineError> {
    let mut out = format!("\n[[axes]]\nname = \"{}\"\n", axis.name);
    let (kind, unit, travel, scale) =
        if axis.is_rotary { ("rotary", "rad", "deg", 1f64.to_radians()) } else { ("linear", "mm", "mm", 1.0) };
    let fault = |_| MachineError::BadDescription("a machine file could not be written".to_owned());
    writeln!(out, "kind = \"{kind}\"").map_err(fault)?;
    let mut limit =
        |key: &str, value: f64, source: &str| writeln!(out, "{key} = {}  # {source}", number(value * scale)).map_err(fault);
    if let (Some(velocity), Some(acceleration)) = (&axis.velocity, &axis.acceleration) {
        limit(&format!("velocity_{unit}_s"), velocity.value, &velocity.source)?;
        limit(&format!("acceleration_{unit}_s2"), acceleration.value, &acceleration.source)?;
        let of_rise = || Known::new(acceleration.value / (1e-3 * rise.value), rise.source.clone());
        let jerk = axis.jerk.clone().unwrap_or_else(of_rise);
        limit(&format!("jerk_{unit}_s3"), jerk.value, &jerk.source)?;
    }
    if let Some(Known { value: [low, high], source }) = &axis.travel {
        write!(out, "travel_{travel} = [{}, {}]  # {source}", number(*low), number(*high)).map_err(fault)?;
    }
    Ok(out.trim_end().to_owned())
}

/// A number with at most six significant digits and always a decimal point.
fn number(value: f64) -> String {
    let digits = if value == 0.0 { 0 } else { (5 - value.abs().log10().floor() as i32).max(0) };
    let rounded: f64 = format!("{value:.*}", digits as usize).parse().unwrap_or(value);
    format!("{rounded:?}")
}
