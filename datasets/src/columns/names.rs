//! The words of a column name.

use super::unit::Unit;

/// Content of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    Time,
    Reference,
    Actual,
    /// A position whose name does not state whether it is commanded or actual.
    Position,
}

/// Meaning of a column name of which every word is known.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Meaning {
    pub role: Role,
    /// Lower-case axis name; empty for the time.
    pub axis: String,
    pub unit: Option<Unit>,
}

const TIME: &[&str] = &["t", "time", "timestamp"];
const REFERENCE: &[&str] =
    &["ref", "reference", "cmd", "command", "commanded", "des", "desired", "set", "setpoint", "sp", "target"];
const ACTUAL: &[&str] = &["act", "actual", "enc", "encoder", "fb", "feedback", "meas", "measured"];
const NEUTRAL: &[&str] = &["pos", "position", "axis", "joint", "value"];

/// Meaning of a column name; `None` if a word is unknown, so that `x_act_velocity` is never taken
/// for a position.
pub(super) fn understand(name: &str) -> Option<Meaning> {
    if let Some(meaning) = joint_pin(name) {
        return Some(meaning);
    }
    let mut role = None;
    let mut axis = String::new();
    let mut unit = None;
    for (index, word) in words(name).iter().enumerate() {
        let word = word.as_str();
        let new_role = if TIME.contains(&word) {
            Some(Role::Time)
        } else if REFERENCE.contains(&word) {
            Some(Role::Reference)
        } else if ACTUAL.contains(&word) {
            Some(Role::Actual)
        } else {
            None
        };
        if let Some(new_role) = new_role {
            if role.replace(new_role).is_some_and(|old| old != new_role) {
                return None;
            }
        } else if let Some(found) = axis_name(word) {
            if !axis.is_empty() {
                return None;
            }
            axis = found;
        } else if index > 0 && Unit::named(word).is_some() {
            if unit.is_some() {
                return None;
            }
            unit = Unit::named(word);
        } else if !NEUTRAL.contains(&word) {
            return None;
        }
    }
    let role = match role {
        Some(Role::Time) if axis.is_empty() => Role::Time,
        Some(Role::Time) => return None,
        _ if axis.is_empty() => return None,
        Some(role) => role,
        None => Role::Position,
    };
    Some(Meaning { role, axis, unit })
}

/// Axes of LinuxCNC's joints 0 to 5 if its configuration names no others.
const JOINTS: [&str; 6] = ["x", "y", "z", "a", "b", "c"];

/// A pin of a joint in LinuxCNC's HAL: `joint.0.motor-pos-cmd`, `joint.0.pos-fb`. Rotary joints are
/// in degrees.
fn joint_pin(name: &str) -> Option<Meaning> {
    let (number, pin) = name.strip_prefix("joint.")?.split_once('.')?;
    let role = match pin.strip_prefix("motor-").unwrap_or(pin) {
        "pos-cmd" => Role::Reference,
        "pos-fb" => Role::Actual,
        _ => return None,
    };
    let axis = *JOINTS.get(number.parse::<usize>().ok()?)?;
    let unit = if JOINTS[..3].contains(&axis) { "mm" } else { "deg" };
    Some(Meaning { role, axis: axis.to_owned(), unit: Unit::named(unit) })
}

/// Whether a column has the name of a joint's pin, which does not state the axis.
pub(crate) fn is_joint_pin(name: &str) -> bool {
    joint_pin(name).is_some()
}

/// Lower-case words: split at everything that is neither letter nor digit, and where a capital follows a small letter or digit.
fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut before = ' ';
    for character in name.chars() {
        let is_word = character.is_alphanumeric() || character == '°';
        let hump = character.is_uppercase() && (before.is_lowercase() || before.is_ascii_digit());
        if !is_word || hump {
            words.push(String::new());
        }
        if is_word && let Some(word) = words.last_mut() {
            word.extend(character.to_lowercase());
        }
        before = character;
    }
    words.retain(|word| !word.is_empty());
    words
}

/// `x`, `x1`, `j3`, `q3`, `axis1`, `joint1`; spindles (`s1`) are no axes here.
fn axis_name(word: &str) -> Option<String> {
    let digits = word.find(|c: char| c.is_ascii_digit()).unwrap_or(word.len());
    let (letters, number) = word.split_at(digits);
    if !number.bytes().all(|byte| byte.is_ascii_digit()) {
        return None;
    }
    match letters {
        "x" | "y" | "z" | "u" | "v" | "w" | "a" | "b" | "c" => Some(word.to_owned()),
        "j" | "q" | "joint" if !number.is_empty() => Some(format!("j{number}")),
        "axis" if !number.is_empty() => Some(word.to_owned()),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn meaning(name: &str) -> Option<(Role, String)> {
        understand(name).map(|meaning| (meaning.role, meaning.axis))
    }

    #[test]
    fn names_of_many_vendors_are_recognised() {
        for (name, role, axis) in [
            ("t", Role::Time, ""),
            ("time [s]", Role::Time, ""),
            ("x_ref", Role::Reference, "x"),
            ("X1_CommandPosition", Role::Reference, "x1"),
            ("X1_ActualPosition", Role::Actual, "x1"),
            ("j6_cmd_deg", Role::Reference, "j6"),
            ("Axis X Set Position (mm)", Role::Reference, "x"),
            ("y-fb-um", Role::Actual, "y"),
            ("ActPosZ", Role::Actual, "z"),
            ("joint.1.motor-pos-cmd", Role::Reference, "y"),
            ("joint.3.pos-fb", Role::Actual, "a"),
        ] {
            assert_eq!(meaning(name), Some((role, axis.to_owned())), "{name}");
        }
    }

    #[test]
    fn an_unknown_word_makes_the_name_unknown() {
        for name in [
            "X1_ActualVelocity",
            "x_act_error",
            "S1_ActualPosition",
            "drive_volt",
            "x_ref_act",
            "x_y_ref",
            "",
            "M1_CURRENT_FEEDRATE",
            "tool_condition",
            "x_time",
            "joint.0.motor-offset",
            "joint.9.motor-pos-cmd",
        ] {
            assert_eq!(meaning(name), None, "{name}");
        }
    }
}
