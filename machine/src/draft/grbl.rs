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
    is_one.then(|| {
        let mut draft = draft(file, &settings)?;
        draft.look_ahead_lines = look_ahead(text);
        if let (Some(lines), None) = (&draft.look_ahead_lines, &draft.control) {
            draft.notes.push(format!(
                "a look-ahead of {} lines ({}) is not stated, for there is no rule of corners ($11)",
                lines.value, lines.source
            ));
        }
        Ok(draft)
    })
}

/// Lines after the present one in the buffer of the planner, if the text also holds the answer to `$I`: `[OPT:V,15,128]` states 15 lines
/// together (Grbl's documentation of its interface).
fn look_ahead(text: &str) -> Option<Known<u32>> {
    let of_line = |(index, line): (usize, &str)| {
        let mut fields = line.trim().strip_prefix("[OPT:")?.strip_suffix(']')?.split(',');
        let lines = fields.nth(1)?.trim().parse::<u32>().ok().filter(|lines| *lines > 1)?;
        Some(Known::new(lines - 1, format!("$I, line {}: a buffer of {lines} lines with the present one", index + 1)))
    };
    text.lines().enumerate().find_map(of_line)
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
