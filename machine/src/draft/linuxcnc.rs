//! LinuxCNC's INI file.

use super::known::{Draft, Known, order};
use super::sections::{Setting, find, settings};
use crate::MachineError;

/// Servo period where the file states none, ms.
const SERVO_PERIOD_MS: f64 = 1.0;
/// LinuxCNC plans lines that are too short for the blends of their corners, and those before a dwell, with half of the acceleration, and arcs with
/// at most this share of it across: measured on its simulator (`tests/linuxcnc`).
const SHORT_LINES: f64 = 0.5;
const ACROSS: f64 = 0.866;

/// The draft, if the file is one.
pub(super) fn read(file: &str, text: &str) -> Option<Result<Draft, MachineError>> {
    let settings = settings(text);
    let is_one = settings.iter().any(|of| ["TRAJ", "EMCMOT", "KINS"].contains(&of.section));
    is_one.then(|| draft(file, &settings))
}

fn draft(file: &str, settings: &[Setting<'_>]) -> Result<Draft, MachineError> {
    let mut draft = Draft {
        name: find(settings, "EMC", "MACHINE").map_or("mill", |of| of.value).to_owned(),
        origin: format!("the LinuxCNC configuration {file}"),
        controller: Some("linuxcnc".to_owned()),
        smoothing_ms: Some(0.0),
        short_line_acceleration: Some(Known::new(SHORT_LINES, "LinuxCNC's planner")),
        ..Draft::default()
    };
    let mm = match find(settings, "TRAJ", "LINEAR_UNITS").map(|of| of.value.to_ascii_lowercase()).as_deref() {
        Some("inch" | "in" | "imperial") => 25.4,
        _ => 1.0,
    };
    let number = |section: &str, key: &str, scale: f64| {
        let known = |of: &Setting<'_>| Ok::<_, MachineError>(Known::new(of.number(file)? * scale, of.place()));
        find(settings, section, key).map(known).transpose()
    };
    let servo = number("EMCMOT", "SERVO_PERIOD", 1e-6)?;
    let period = servo.unwrap_or(Known::new(SERVO_PERIOD_MS, "LinuxCNC's usual servo period"));
    draft.rise_ms = Some(Known::new(period.value, "LinuxCNC limits no jerk: one servo period"));
    draft.period_ms = Some(period);
    draft.path_velocity_mm_s = number("TRAJ", "MAX_LINEAR_VELOCITY", mm)?.or(number("TRAJ", "MAX_VELOCITY", mm)?);
    let coordinates = find(settings, "TRAJ", "COORDINATES").map_or("XYZ", |of| of.value);
    for (joint, letter) in coordinates.chars().filter(char::is_ascii_alphabetic).enumerate() {
        let name = letter.to_ascii_lowercase().to_string();
        if order(&name) == 6 {
            draft.notes.push(format!("axis {} is left out: only X Y Z A B C are known", letter.to_ascii_uppercase()));
            continue;
        }
        let sections = [format!("AXIS_{}", letter.to_ascii_uppercase()), format!("JOINT_{joint}")];
        let scale = if ["a", "b", "c"].contains(&&*name) { 1.0 } else { mm };
        // The narrower of axis and joint holds.
        let least = |key: &str| -> Result<Option<Known<f64>>, MachineError> {
            let both = sections.iter().map(|section| number(section, key, scale)).collect::<Result<Vec<_>, _>>()?;
            Ok(both.into_iter().flatten().min_by(|a, b| a.value.total_cmp(&b.value)))
        };
        let largest = |key: &str| -> Result<Option<Known<f64>>, MachineError> {
            let both = sections.iter().map(|section| number(section, key, scale)).collect::<Result<Vec<_>, _>>()?;
            Ok(both.into_iter().flatten().max_by(|a, b| a.value.total_cmp(&b.value)))
        };
        let axis = draft.axis(&name);
        axis.velocity = least("MAX_VELOCITY")?;
        axis.acceleration = least("MAX_ACCELERATION")?;
        axis.jerk = least("MAX_JERK")?;
        if let (Some(low), Some(high)) = (largest("MIN_LIMIT")?, least("MAX_LIMIT")?) {
            axis.travel = Some(Known::new([low.value, high.value], format!("{}; {}", low.source, high.source)));
        }
    }
    let linear = draft.axes.iter().filter(|axis| !axis.is_rotary).filter_map(|axis| axis.acceleration.as_ref());
    let accelerations: Vec<f64> = linear.map(|known| known.value).collect();
    let largest = accelerations.iter().copied().fold(0.0, f64::max);
    if largest > 0.0 {
        let together = accelerations.iter().fold(0.0, |sum: f64, axis| sum.hypot(*axis));
        draft.path_acceleration_mm_s2 =
            Some(Known::new(together, "what the axes allow together: LinuxCNC has no other limit for programs"));
        draft.centripetal_mm_s2 =
            Some(Known::new(ACROSS * largest, "LinuxCNC's planner: 0.866 of that along and across together"));
        draft.arc_acceleration_mm_s2 =
            Some(Known::new(largest, "LinuxCNC's planner: in every plane what its slowest axis allows"));
    }
    Ok(draft)
}
