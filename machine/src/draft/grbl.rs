//! The settings that Grbl and its relatives print for `$$`.

use super::known::{Draft, Known, order};
use crate::{ControlSpec, CornerRule, MachineError};

/// Grbl recomputes its speed a hundred times a second (its documentation, "acceleration manager").
const SEGMENT_MS: f64 = 10.0;

/// Flag of `$22` with which an axis homes, and that with which grblHAL sets machine zero where the axis homes (its wiki, "Additional or extended settings").
const HOMES: u32 = 1;
const ORIGIN_AT_HOME: u32 = 8;
/// Number of axes that `$110` to `$115` name.
const MOST_AXES: usize = 6;

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
        let mut draft = draft(file, &settings, letters(text))?;
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

/// The letters of the axes in their order: those that grblHAL's `[AXS:5:XYZAC]` states, if the text holds it.
fn letters(text: &str) -> &str {
    text.lines().find_map(axes_of).unwrap_or("XYZABC")
}

/// The letters of a line `[AXS:5:XYZAC]`.
fn axes_of(line: &str) -> Option<&str> {
    line.trim().strip_prefix("[AXS:")?.strip_suffix(']')?.split_once(':').map(|(_, letters)| letters)
}

fn setting(line: &str, number_of_line: usize) -> Option<Setting<'_>> {
    let (number, rest) = line.trim().strip_prefix('$')?.split_once('=')?;
    let value = rest.split(['(', ';', '[']).next().unwrap_or(rest).trim();
    Some(Setting { number: number.trim().parse().ok()?, value, line: number_of_line })
}

fn draft(file: &str, settings: &[Setting<'_>], letters: &str) -> Result<Draft, MachineError> {
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
    let flags = |wanted: u32| Ok::<_, MachineError>(number(wanted, 1.0)?.map(|of| of.value as u32));
    let (homing, lower_ends) = (flags(22)?, flags(23)?.unwrap_or_default());
    if homing.is_some_and(|homing| homing & HOMES == 0) {
        draft.notes.push(
            "it does not home ($22): machine zero is where it was switched on, and its travel is not stated here (--travel)"
                .to_owned(),
        );
    }
    for (index, letter) in letters.chars().enumerate().take(MOST_AXES) {
        let (name, index) = (letter.to_ascii_lowercase().to_string(), index as u32);
        let (velocity, acceleration) = (number(110 + index, 1.0 / 60.0)?, number(120 + index, 1.0)?);
        if velocity.is_none() && acceleration.is_none() {
            continue;
        }
        if order(&name) == 6 {
            draft.notes.push(format!("axis {letter} is left out: only X Y Z A B C are known"));
            continue;
        }
        let travel =
            number(130 + index, 1.0)?.filter(|travel| travel.value > 0.0 && homing.is_none_or(|homing| homing & HOMES != 0));
        let axis = draft.axis(&name);
        (axis.velocity, axis.acceleration) = (velocity, acceleration);
        // Machine zero is at the upper end of every axis; at the lower one where grblHAL sets it to the end at which the axis homes.
        let is_from_zero = homing.is_some_and(|homing| homing & ORIGIN_AT_HOME != 0) && lower_ends >> index & 1 == 1;
        axis.travel = travel.map(|travel| match is_from_zero {
            true => Known::new([0.0, travel.value], format!("{} (machine zero at its lower end, $22 and $23)", travel.source)),
            false => Known::new([-travel.value, 0.0], format!("{} (machine zero at its upper end)", travel.source)),
        });
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
