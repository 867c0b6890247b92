//! Klipper's configuration.

use super::known::{Draft, Known};
use super::sections::{Beside, Setting, Settings, Style};
use crate::{ControlSpec, CornerRule, MachineError};

/// Square corner velocity where the file states none, mm/s (Klipper's configuration reference).
const SQUARE_CORNER_MM_S: f64 = 5.0;
/// Klipper limits no jerk; a millisecond stands for a step of acceleration.
const STEP_MS: f64 = 1.0;

/// The draft, if the file is one.
pub(super) fn read(file: &str, text: &str, beside: Beside<'_>) -> Option<Result<Draft, MachineError>> {
    let settings = Settings::read(file, text, Style::Klipper, beside);
    settings.find("printer", "kinematics").is_some().then(|| draft(file, &settings))
}

fn draft(file: &str, settings: &Settings) -> Result<Draft, MachineError> {
    let number = |section: &str, key: &str| {
        let known = |of: &Setting| Ok::<_, MachineError>(Known::new(of.number()?, of.place(file)));
        settings.find(section, key).map(known).transpose()
    };
    let mut draft = Draft {
        name: "printer".to_owned(),
        origin: format!("the Klipper configuration {file}"),
        controller: Some("generic".to_owned()),
        smoothing_ms: Some(0.0),
        rise_ms: Some(Known::new(STEP_MS, "Klipper limits no jerk")),
        notes: settings.notes.clone(),
        ..Draft::default()
    };
    let (velocity, acceleration) = (number("printer", "max_velocity")?, number("printer", "max_accel")?);
    for name in ["x", "y", "z"] {
        let of_z = |key: &str| if name == "z" { number("printer", key) } else { Ok(None) };
        let (z_velocity, z_acceleration) = (of_z("max_z_velocity")?, of_z("max_z_accel")?);
        let stepper = format!("stepper_{name}");
        let (low, high) = (number(&stepper, "position_min")?, number(&stepper, "position_max")?);
        let axis = draft.axis(name);
        axis.velocity = z_velocity.or_else(|| velocity.clone());
        axis.acceleration = z_acceleration.or_else(|| acceleration.clone());
        axis.travel = high.map(|high| {
            let low = low.unwrap_or(Known::new(0.0, "Klipper's default"));
            Known::new([low.value, high.value], format!("{}; {}", low.source, high.source))
        });
    }
    if let Some(most) = &acceleration {
        let square = number("printer", "square_corner_velocity")?.unwrap_or(Known::new(SQUARE_CORNER_MM_S, "Klipper's default"));
        // The corner of 90° that is passed at this speed (Klipper's documentation of its kinematics).
        let off_mm = square.value * square.value * (std::f64::consts::SQRT_2 - 1.0) / most.value;
        let control = ControlSpec { corners: CornerRule::JunctionDeviationMm(off_mm), ..ControlSpec::default() };
        draft.control = Some(Known::new(control, format!("from {} and max_accel", square.source)));
    }
    (draft.path_velocity_mm_s, draft.path_acceleration_mm_s2) = (velocity, acceleration);
    if settings.sections().any(|section| section.starts_with("input_shaper")) {
        draft.notes.push("the input shaper is not stated here: train --programs finds what it does to the command".to_owned());
    }
    let kinematics = settings.find("printer", "kinematics").map_or("", |of| of.value.as_str());
    if kinematics != "cartesian" {
        draft.notes.push("x and y are the axes of programs; their motors drive both: log x and y, not motors".to_owned());
    }
    let without: Vec<&str> = draft.axes.iter().filter(|axis| axis.travel.is_none()).map(|axis| axis.name.as_str()).collect();
    if !without.is_empty() {
        draft.notes.push(format!("the travel of {} is not stated ({kinematics}): --travel states it", without.join(", ")));
    }
    Ok(draft)
}
