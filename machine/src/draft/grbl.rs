//! The settings that Grbl and its relatives print for `$$`.

use super::known::{Draft, Known};
use crate::{ControlSpec, CornerRule, MachineError};

/// Grbl recomputes its speed a hundred times a second (its documentation, "acceleration manager").
const SEGMENT_MS: f64 = 10.0;

/// A setting `$110=500.000 (x max rate, mm/min)`.
struct Setting<'a> {
    number: u32,
    value: &'a str,
    line: usize,
}

/// The draft, if the file is one.
pub(super) fn read(file: &str, text: &str) -> Option<Result<Draft, MachineError>> {
    let settings: Vec<Setting<'_>> = text.lines().enumerate().filter_map(|(index, line)| setting(line, index + 1)).collect();
    let is_one = settings.iter().any(|of| (110..=115).contains(&of.number) || (120..=125).contains(&of.number));
    is_one.then(|| draft(file, &settings))
}

fn setting(line: &str, number_of_line: usize) -> Option<Setting<'_>> {
    let (number, rest) = line.trim().strip_prefix('$')?.split_once('=')?;
    let value = rest.split(['(', ';', '[']).next().unwrap_or(rest).trim();
    Some(Setting { number: number.trim().parse().ok()?, value, line: number_of_line })
}

fn draft(file: &str, settings: &[Setting<'_>]) -> Result<Draft, MachineError> {
    let number = |wanted: u32, scale: f64| {
        let known = |of: &Setting<'_>| match of.value.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(Known::new(value * scale, format!("${wanted}, line {}", of.line))),
            _ => {
                let Setting { number, value, line } = of;
                Err(MachineError::BadDescription(format!("{file}:{line}: ${number} is `{value}`; a number is wanted")))
            }
        };
        settings.iter().rev().find(|of| of.number == wanted).map(known).transpose()
    };
    let mut draft = Draft {
        name: "mill".to_owned(),
        origin: format!("the Grbl settings {file}"),
        controller: Some("grbl".to_owned()),
        smoothing_ms: Some(0.0),
        rise_ms: Some(Known::new(SEGMENT_MS, "Grbl limits no jerk: one segment of its planner")),
        ..Draft::default()
    };
    for (index, name) in ["x", "y", "z", "a", "b", "c"].into_iter().enumerate() {
        let index = index as u32;
        let (velocity, acceleration) = (number(110 + index, 1.0 / 60.0)?, number(120 + index, 1.0)?);
        if velocity.is_none() && acceleration.is_none() {
            continue;
        }
        let travel = number(130 + index, 1.0)?.filter(|travel| travel.value > 0.0);
        let axis = draft.axis(name);
        (axis.velocity, axis.acceleration) = (velocity, acceleration);
        // Machine zero is where the axis homes, at the upper end, unless the homing mask says otherwise.
        axis.travel =
            travel.map(|travel| Known::new([-travel.value, 0.0], format!("{} (homes at its upper end)", travel.source)));
    }
    draft.control = number(11, 1.0)?.map(|deviation| {
        let corners = CornerRule::JunctionDeviationMm(deviation.value);
        Known::new(ControlSpec { corners, ..ControlSpec::default() }, deviation.source)
    });
    draft.notes.push(
        "Grbl reports positions a few times a second: record with an encoder or a logic analyser at a fixed rate".to_owned(),
    );
    Ok(draft)
}
