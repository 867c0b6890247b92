//! The words of a column name.

use super::meaning::{Meaning, Role};
use super::numbered::{is_edge_name, numbered};
use super::unit::{Quantity, Unit};
use super::vocabulary::{
    ACTUAL, AXIS_SIGNS, COMPOUND, ERROR, MEASURING_SYSTEM, NEUTRAL, OF_ERROR, REFERENCE, SUFFIXES, TABLE, TIME,
};

/// Meaning of a column name; `None` if a word is unknown, so that `x_act_velocity` is never taken
/// for a position.
pub(super) fn understand(name: &str) -> Option<Meaning> {
    if let Some(meaning) = numbered(name) {
        return Some(meaning);
    }
    if is_edge_name(name) {
        return None;
    }
    if has_other_unit(name) {
        return None;
    }
    let (mut role, mut is_time, mut is_table) = (None, false, false);
    let is_error = words(name).iter().any(|word| ERROR.contains(&word.as_str()));
    let mut axis = String::new();
    let mut unit = None;
    let words = words(name);
    // A log may name its time by the unit alone, though not by one of letters that mean much else.
    if let [word] = words.as_slice()
        && let Some(unit) = Unit::named(word).filter(|unit| unit.quantity == Quantity::Time && word.len() > 1 && word != "min")
    {
        return Some(Meaning { role: Role::Time, axis, unit: Some(unit), is_table });
    }
    for (index, word) in words.iter().enumerate() {
        let word = word.as_str();
        if index > 0 && words[index - 1] == MEASURING_SYSTEM && ["1", "2"].contains(&word) {
            is_table = word == "2";
            continue;
        }
        // Of several columns of one name some tools number the later ones: `Time.1`, `t2`.
        if TIME.contains(&word.trim_end_matches(|sign: char| sign.is_ascii_digit())) {
            is_time = true;
            continue;
        }
        let is_number = word.bytes().all(|byte| byte.is_ascii_digit());
        let is_before_unit = word == "in" && words.get(index + 1).is_some_and(|unit| Unit::named(unit).is_some());
        if is_time && is_number && word.len() < 3 || is_before_unit {
            continue;
        }
        if let Some(new_role) = side_of(word) {
            is_table |= TABLE.contains(&word);
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
        } else if !(NEUTRAL.contains(&word) || is_error && (ERROR.contains(&word) || OF_ERROR.contains(&word))) {
            return None;
        }
    }
    if is_error {
        let is_known = role.is_none() && !is_time && !axis.is_empty() && unit.is_none_or(|unit| unit.quantity != Quantity::Time);
        return is_known.then_some(Meaning { role: Role::Error, axis, unit, is_table });
    }
    let role = match role {
        None if is_time && axis.is_empty() => Role::Time,
        None if is_time => return None,
        Some(Role::Reference) if is_time => Role::ReferenceTime,
        Some(_) if is_time => Role::ActualTime,
        _ if axis.is_empty() => return None,
        Some(role) => role,
        None => Role::Position,
    };
    Some(Meaning { role, axis, unit, is_table })
}

/// Whether a name states what no unit of positions or times is: signs alone, as in `[%]`, or newton metres, whose small letters are nanometres.
fn has_other_unit(name: &str) -> bool {
    let Some((_, unit)) = name.rsplit_once(['[', '(']) else { return false };
    let unit = unit.trim_end_matches([']', ')', ' ']).trim();
    unit == "Nm" || !unit.is_empty() && !unit.contains(|sign: char| sign.is_alphanumeric() || sign == '°')
}

/// Whether a lower-case word says that a column is of commanded or actual positions, or of tracking errors.
pub(super) fn role_of(word: &str) -> Option<Role> {
    if ERROR.contains(&word) { Some(Role::Error) } else { side_of(word) }
}

/// Whether a lower-case word says that positions are commanded or actual.
fn side_of(word: &str) -> Option<Role> {
    if REFERENCE.contains(&word) {
        Some(Role::Reference)
    } else if ACTUAL.contains(&word) || TABLE.contains(&word) {
        Some(Role::Actual)
    } else {
        None
    }
}

/// Lower-case words: split at everything that is neither letter nor digit, where a capital follows a small letter or digit, before the
/// last of several capitals that a small letter follows, and between scripts with capitals and without: `XSoll` is `x` and `soll`, `X轴指令位置` is `x` and `指令`.
fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let characters: Vec<char> = name.chars().collect();
    for (index, &character) in characters.iter().enumerate() {
        let before = if index > 0 { characters[index - 1] } else { ' ' };
        let is_word = (character.is_alphanumeric() || character == '°') && !AXIS_SIGNS.contains(&character);
        let starts = before.is_uppercase() && characters.get(index + 1).is_some_and(|next| next.is_lowercase());
        let hump = character.is_uppercase() && (before.is_lowercase() || before.is_ascii_digit() || starts);
        let changes = before.is_alphanumeric() && is_word && has_no_case(before) != has_no_case(character);
        if !is_word || hump || changes {
            words.push(String::new());
        }
        if is_word && let Some(word) = words.last_mut() {
            word.extend(character.to_lowercase());
        }
    }
    words.retain(|word| !word.is_empty());
    words.into_iter().flat_map(|word| halves(&word).unwrap_or(vec![without_suffix(&word).to_owned()])).collect()
}

/// Whether a letter belongs to a script without capitals.
fn has_no_case(character: char) -> bool {
    character.is_alphabetic() && !character.is_lowercase() && !character.is_uppercase()
}

fn without_suffix(word: &str) -> &str {
    SUFFIXES.iter().find_map(|suffix| word.strip_suffix(suffix)).filter(|rest| !rest.is_empty()).unwrap_or(word)
}

fn halves(word: &str) -> Option<Vec<String>> {
    COMPOUND.iter().find_map(|role| {
        let axis = word.strip_prefix(role).or_else(|| word.strip_suffix(role))?;
        axis_name(axis).map(|axis| vec![axis, (*role).to_owned()])
    })
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
            ("DES_POS|2", Role::Reference, "y"),
            ("Zeit [ms]", Role::Time, ""),
            ("t_cmd", Role::ReferenceTime, ""),
            ("time_act_ms", Role::ActualTime, ""),
            ("t_x_ref", Role::ReferenceTime, "x"),
            ("YActTime", Role::ActualTime, "y"),
            ("X_Soll", Role::Reference, "x"),
            ("Soll Y [mm]", Role::Reference, "y"),
            ("SollpositionZ", Role::Reference, "z"),
            ("XSollposition", Role::Reference, "x"),
            ("ZIst", Role::Actual, "z"),
            ("Ist-Position X1 (mm)", Role::Actual, "x1"),
            ("Istposition Achse Y", Role::Actual, "y"),
            ("Lagesollwert X", Role::Reference, "x"),
            ("XSOLL", Role::Reference, "x"),
            ("istposition_y1", Role::Actual, "y1"),
            ("sollz [mm]", Role::Reference, "z"),
            ("x_enc2_mm", Role::Actual, "x"),
            ("MC_X_ActualPosition", Role::Actual, "x"),
            ("X nominal", Role::Reference, "x"),
            ("X_programmed", Role::Reference, "x"),
            ("Y real (mm)", Role::Actual, "y"),
            ("xcmd", Role::Reference, "x"),
            ("ZACT", Role::Actual, "z"),
            ("Date Time", Role::Time, ""),
            ("elapsed_ms", Role::Time, ""),
            ("Temps (s)", Role::Time, ""),
            ("X consigne (mm)", Role::Reference, "x"),
            ("Position réelle Y", Role::Actual, "y"),
            ("Consigna X [mm]", Role::Reference, "x"),
            ("Posizione reale Z", Role::Actual, "z"),
            ("时间(ms)", Role::Time, ""),
            ("X轴指令位置(mm)", Role::Reference, "x"),
            ("X实际位置", Role::Actual, "x"),
            ("Y1軸指令値", Role::Reference, "y1"),
            ("実位置Z", Role::Actual, "z"),
            ("X跟随误差", Role::Error, "x"),
            ("x_err", Role::Error, "x"),
            ("Axis1_FollowingError [um]", Role::Error, "axis1"),
            ("X1_PosDiff", Role::Error, "x1"),
            ("LagDistance Z", Role::Error, "z"),
            ("Schleppabstand X (mm)", Role::Error, "x"),
            ("joint.0.f-error", Role::Error, "x"),
            ("X_FBK_POS", Role::Actual, "x"),
            ("s noml X [mm]", Role::Reference, "x"),
            ("s actl X [mm]", Role::Actual, "x"),
            ("X POSF(mm)", Role::Actual, "x"),
            ("X ERR(um)", Role::Error, "x"),
            ("X mesure (mm)", Role::Actual, "x"),
            ("Axis X.NcToPlc.SetPos", Role::Reference, "x"),
            ("ts", Role::Time, ""),
            ("axes_x_set", Role::Reference, "x"),
            ("Time.1", Role::Time, ""),
            ("Time [s].1", Role::Time, ""),
            ("t2", Role::Time, ""),
            ("Time in ms", Role::Time, ""),
            ("TIME_STAMP_MS", Role::Time, ""),
            ("ms", Role::Time, ""),
            ("seconds", Role::Time, ""),
            ("MCS X Set", Role::Reference, "x"),
            ("Posición referencia X", Role::Reference, "x"),
            ("Фактическая позиция X (mm)", Role::Actual, "x"),
            ("X 지령 위치", Role::Reference, "x"),
            ("X1: Position setpoint", Role::Reference, "x1"),
            ("X1: Actual position value measuring system 1", Role::Actual, "x1"),
        ] {
            assert_eq!(meaning(name), Some((role, axis.to_owned())), "{name}");
        }
    }

    #[test]
    fn an_unknown_word_makes_the_name_unknown() {
        for name in [
            "X1_ActualVelocity",
            "x_act_error",
            "x_lag_ms",
            "x_velocity_error",
            "contour_error",
            "x_contour_error",
            "x_following",
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
            "DES_POS|x",
            "x|Soll",
            "X_Sollgeschwindigkeit",
            "Istwert",
            "xsolly",
            "bistro",
            "X_Soll_Ist",
            "X实际速度",
            "X1: Actual position value measuring system 3",
            "X1: Actual position 2",
            "s",
            "min",
            "X ref [%]",
            "x_act [Nm]",
            "x_ref 2",
            "X指令实际",
        ] {
            assert_eq!(meaning(name), None, "{name}");
        }
    }
}
