//! LinuxCNC's INI file.

use super::known::{Draft, Known, order};
use super::sections::{Beside, Setting, Settings, Style};
use crate::MachineError;

/// Servo period where the file states none, ms.
const SERVO_PERIOD_MS: f64 = 1.0;
/// LinuxCNC plans lines that are too short for the blends of their corners, and those before a dwell, with half of the acceleration, and arcs with
/// at most this share of it across: measured on its simulator (`tests/linuxcnc`).
const SHORT_LINES: f64 = 0.5;
const ACROSS: f64 = 0.866;

/// Limits from here on are LinuxCNC's way to say that there is none, in its units.
const UNLIMITED: f64 = 1e9;

/// The draft, if the file is one.
pub(super) fn read(file: &str, text: &str, beside: Beside<'_>) -> Option<Result<Draft, MachineError>> {
    let settings = Settings::read(file, text, Style::Ini, beside);
    let is_one = settings.sections().any(|section| ["TRAJ", "EMCMOT", "KINS"].contains(&section));
    is_one.then(|| draft(file, &settings))
}

/// Millimetres of a unit of length, and degrees of a unit of angle: a name, or the number of units in a millimetre or degree.
fn unit(settings: &Settings, key: &str, names: &[(&[&str], f64)]) -> Result<f64, MachineError> {
    let Some(of) = settings.find("TRAJ", key) else { return Ok(1.0) };
    let is = |(known, _): &&(&[&str], f64)| known.iter().any(|name| name.eq_ignore_ascii_case(&of.value));
    if let Some((_, unit)) = names.iter().find(is) {
        return Ok(*unit);
    }
    let of_number = of.value.parse::<f64>().ok().filter(|number| number.is_finite() && *number > 0.0).map(f64::recip);
    of_number.ok_or_else(|| {
        let known: Vec<&str> = names.iter().filter_map(|(names, _)| names.first().copied()).collect();
        let first = known.first().copied().unwrap_or_default();
        of.refused(&format!("{}, or the number of units in 1 {first}, is wanted", known.join(", ")))
    })
}

/// The letters that joints move, in their order; `None` where the kinematics makes more of joints than positions of axes.
fn letters_of_joints(settings: &Settings, coordinates: &str) -> Option<String> {
    let Some(kinematics) = settings.find("KINS", "KINEMATICS") else { return Some(coordinates.to_owned()) };
    let mut words = kinematics.value.split_whitespace();
    words.next().filter(|name| name.eq_ignore_ascii_case("trivkins"))?;
    let stated = words.find_map(|word| word.split_once('=').filter(|(key, _)| key.eq_ignore_ascii_case("coordinates")));
    Some(stated.map_or("XYZABCUVW", |(_, letters)| letters).to_ascii_uppercase())
}

fn draft(file: &str, settings: &Settings) -> Result<Draft, MachineError> {
    let mut draft = Draft {
        name: settings.find("EMC", "MACHINE").map_or("mill", |of| &of.value).to_owned(),
        origin: format!("the LinuxCNC configuration {file}"),
        controller: Some("linuxcnc".to_owned()),
        smoothing_ms: Some(0.0),
        short_line_acceleration: Some(Known::new(SHORT_LINES, "LinuxCNC's planner")),
        notes: settings.notes.clone(),
        ..Draft::default()
    };
    let mm = unit(settings, "LINEAR_UNITS", &[(&["mm", "metric"], 1.0), (&["inch", "in", "imperial"], 25.4)])?;
    let degrees = unit(
        settings,
        "ANGULAR_UNITS",
        &[(&["degree", "deg", "degrees"], 1.0), (&["radian", "rad", "radians"], 1f64.to_degrees())],
    )?;
    let number = |section: &str, key: &str, scale: f64| {
        let known = |of: &Setting| Ok::<_, MachineError>(Known::new(of.number()? * scale, of.place(file)));
        settings.find(section, key).map(known).transpose()
    };
    let servo = number("EMCMOT", "SERVO_PERIOD", 1e-6)?;
    let period = servo.unwrap_or(Known::new(SERVO_PERIOD_MS, "LinuxCNC's usual servo period"));
    draft.rise_ms = Some(Known::new(period.value, "LinuxCNC limits no jerk: one servo period"));
    draft.period_ms = Some(period);
    draft.path_velocity_mm_s = number("TRAJ", "MAX_LINEAR_VELOCITY", mm)?.or(number("TRAJ", "MAX_VELOCITY", mm)?);
    let coordinates = settings.find("TRAJ", "COORDINATES").map_or("XYZ", |of| &of.value).to_ascii_uppercase();
    let coordinates: String = coordinates.chars().filter(char::is_ascii_alphabetic).collect();
    let joints = letters_of_joints(settings, &coordinates);
    if let (None, Some(kinematics)) = (&joints, settings.find("KINS", "KINEMATICS")) {
        draft.notes.push(format!(
            "its kinematics are {}: limits of joints are none of axes, so that [AXIS_…] alone counts, and this file says cartesian; for a machine that tilts \
             the tool see docs/five-axis.md",
            kinematics.value
        ));
    }
    let mut done = String::new();
    for letter in coordinates.chars() {
        if done.contains(letter) {
            continue;
        }
        done.push(letter);
        let name = letter.to_ascii_lowercase().to_string();
        if order(&name) == 6 {
            draft.notes.push(format!("axis {letter} is left out: only X Y Z A B C are known"));
            continue;
        }
        let of_letter = joints.iter().flat_map(|joints| joints.chars().enumerate()).filter(|(_, of)| *of == letter);
        let sections: Vec<String> =
            std::iter::once(format!("AXIS_{letter}")).chain(of_letter.map(|(joint, _)| format!("JOINT_{joint}"))).collect();
        let scale = if ["a", "b", "c"].contains(&&*name) { degrees } else { mm };
        let all = |key: &str| {
            sections.iter().filter_map(|section| number(section, key, scale).transpose()).collect::<Result<Vec<_>, _>>()
        };
        // The narrowest of axis and joints holds.
        let least = |key: &str| Ok::<_, MachineError>(all(key)?.into_iter().min_by(|a, b| a.value.total_cmp(&b.value)));
        let largest = |key: &str| Ok::<_, MachineError>(all(key)?.into_iter().max_by(|a, b| a.value.total_cmp(&b.value)));
        let is_limit = |limit: &Known<f64>| limit.value.abs() < UNLIMITED * scale;
        let (low, high) = (largest("MIN_LIMIT")?.filter(is_limit), least("MAX_LIMIT")?.filter(is_limit));
        let (velocity, acceleration, jerk) = (least("MAX_VELOCITY")?, least("MAX_ACCELERATION")?, least("MAX_JERK")?);
        let travel = match (low, high) {
            (Some(low), Some(high)) => Some(Known::new([low.value, high.value], format!("{}; {}", low.source, high.source))),
            (None, None) => None,
            (Some(one), None) | (None, Some(one)) => {
                draft.notes.push(format!(
                    "axis {letter} has one limit alone ({}): its travel is not stated here (--travel)",
                    one.source
                ));
                None
            }
        };
        let axis = draft.axis(&name);
        (axis.velocity, axis.acceleration, axis.jerk, axis.travel) = (velocity, acceleration, jerk, travel);
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
