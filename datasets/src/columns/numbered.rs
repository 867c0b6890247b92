//! Column names that number their axis instead of naming it.

use super::meaning::{Meaning, Role};
use super::unit::Unit;

/// The axes by their number, from the first one.
const AXES: [&str; 6] = ["x", "y", "z", "a", "b", "c"];

/// Meaning of a name that numbers its axis; `None` for other names.
///
/// A pin of a joint in LinuxCNC's HAL, from 0: `joint.0.motor-pos-cmd`, `joint.0.pos-fb`. A signal of SINUMERIK Edge, from 1: `DES_POS|1`,
/// `ENC1_POS|1`. Linear axes are in mm and rotary ones in degrees, unless a unit follows.
pub(super) fn numbered(name: &str) -> Option<Meaning> {
    if is_edge_name(name) { edge_signal(name) } else { joint_pin(name) }
}

/// Whether a name is one of SINUMERIK Edge, `SIGNAL|number`. It is no text to be split into words: `DES_POS|x` names no axis.
pub(super) fn is_edge_name(name: &str) -> bool {
    name.contains('|')
}

/// Unit of a column that numbers its axis and states no unit, where a mapping says that the axis is `axis`.
pub(super) fn assumed_unit(name: &str, axis: &str) -> Option<Unit> {
    let is_bare = name.split_once('|').is_none_or(|(_, place)| place.trim().bytes().all(|byte| byte.is_ascii_digit()));
    numbered(name).filter(|_| is_bare).and_then(|_| unit_of(axis))
}

fn unit_of(axis: &str) -> Option<Unit> {
    let is_rotary = motion::Axis::named(axis).kind == motion::AxisKind::Rotary;
    Unit::named(if is_rotary { "deg" } else { "mm" })
}

fn meaning(role: Role, index: usize, is_table: bool, unit: Option<Unit>) -> Option<Meaning> {
    let axis = *AXES.get(index)?;
    Some(Meaning { role, axis: axis.to_owned(), unit: unit.or_else(|| unit_of(axis)), is_table })
}

fn joint_pin(name: &str) -> Option<Meaning> {
    let (number, pin) = name.strip_prefix("joint.")?.split_once('.')?;
    let role = match pin.strip_prefix("motor-").unwrap_or(pin) {
        "pos-cmd" => Role::Reference,
        "pos-fb" => Role::Actual,
        "f-error" => Role::Error,
        _ => return None,
    };
    meaning(role, number.parse().ok()?, false, None)
}

/// Role of a position signal of SINUMERIK Edge, and whether it is of the second encoder, which is at the table.
pub(crate) fn edge_role(signal: &str) -> Option<(bool, bool)> {
    match signal.trim().to_ascii_uppercase().as_str() {
        "DES_POS" | "CMD_POS" => Some((true, false)),
        "ENC_POS" | "ENC1_POS" | "ACT_POS" => Some((false, false)),
        "ENC2_POS" => Some((false, true)),
        _ => None,
    }
}

fn edge_signal(name: &str) -> Option<Meaning> {
    let (signal, place) = name.split_once('|')?;
    let (is_reference, is_table) = edge_role(signal)?;
    let place = place.trim();
    let digits = place.find(|c: char| !c.is_ascii_digit()).unwrap_or(place.len());
    let (number, rest) = place.split_at(digits);
    let rest = rest.trim_matches(['_', ' ']);
    let unit = if rest.is_empty() { None } else { Some(Unit::named(rest)?) };
    let role = if is_reference { Role::Reference } else { Role::Actual };
    meaning(role, number.parse::<usize>().ok()?.checked_sub(1)?, is_table, unit)
}

/// Whether a column has the name of a joint's pin, which does not state the axis.
pub(crate) fn is_joint_pin(name: &str) -> bool {
    joint_pin(name).is_some()
}

/// Whether a column is a position of SINUMERIK Edge, of an axis that is numbered.
pub(super) fn is_edge_signal(name: &str) -> bool {
    edge_signal(name).is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signals_of_numbered_axes_are_those_of_x_y_z_a_b_c() {
        for (name, role, axis, is_table) in [
            ("DES_POS|1", Role::Reference, "x", false),
            ("CMD_POS|2", Role::Reference, "y", false),
            ("ENC_POS|3", Role::Actual, "z", false),
            ("ENC1_POS|1", Role::Actual, "x", false),
            ("ACT_POS|6", Role::Actual, "c", false),
            ("ENC2_POS|2", Role::Actual, "y", true),
            ("des_pos|3 [mm]", Role::Reference, "z", false),
            ("joint.1.motor-pos-cmd", Role::Reference, "y", false),
            ("joint.3.pos-fb", Role::Actual, "a", false),
        ] {
            let found = numbered(name).unwrap_or_else(|| panic!("{name}"));
            assert_eq!((found.role, found.axis.as_str(), found.is_table), (role, axis, is_table), "{name}");
        }
        assert_eq!(numbered("DES_POS|4").unwrap().unit, Unit::named("deg"));
        assert_eq!(numbered("DES_POS|4_rad").unwrap().unit, Unit::named("rad"));
    }

    #[test]
    fn what_is_no_number_or_no_position_is_not_guessed() {
        for name in [
            "DES_POS|x",
            "DES_POS|",
            "DES_POS|0",
            "DES_POS|7",
            "DES_POS|1|2",
            "DES_POS|1x",
            "LOAD|1",
            "CTRL_POS|1",
            "X_ref|mm",
            "|1",
        ] {
            assert!(numbered(name).is_none(), "{name}");
        }
    }
}
