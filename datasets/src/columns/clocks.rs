//! Which time stamps belong to which column.

use super::map::{Clock, Source};
use super::meaning::{Meaning, Role};
use super::unit::Quantity;

/// A column of positions: its axis by name, what it is, its index.
pub(super) struct Signal<'a> {
    pub axis: &'a str,
    pub role: Role,
    pub column: usize,
}

/// The time stamps of the first signal, which is a command, and those of signals that have others.
///
/// The stamps of a signal are the column named for it (`t_x_act`), else for its side (`t_act`), else the only column of time. Of several the
/// nearest one before the signal counts, as in exports with a time column beside every channel.
pub(super) fn clocks(
    names: &[String],
    meanings: &[Option<Meaning>],
    signals: &[Signal<'_>],
) -> Result<(Option<Source>, Vec<Clock>), String> {
    let times = times(meanings)?;
    check_plain(&times, names.len())?;
    let found = signals.iter().map(|signal| clock_of(signal, &times, names)).collect::<Result<Vec<_>, _>>()?;
    let mut known: Vec<Source> = Vec::new();
    for source in found.iter().flatten() {
        if !known.contains(source) {
            known.push(*source);
        }
    }
    // One column of time stands for what has none.
    let default = if known.len() == 1 { known.first().copied() } else { None };
    let mut master = None;
    let mut clocks: Vec<Clock> = Vec::new();
    for (signal, own) in signals.iter().zip(found) {
        let Some(time) = own.or(default) else {
            if known.is_empty() {
                continue;
            }
            return Err(format!("no time stamps belong to `{}`", names[signal.column]));
        };
        if *master.get_or_insert(time) != time {
            Clock::add(&mut clocks, time, signal.column);
        }
    }
    Ok((master, clocks))
}

/// A column of time stamps, and what it is for.
struct Time {
    source: Source,
    role: Role,
    axis: String,
}

fn times(meanings: &[Option<Meaning>]) -> Result<Vec<Time>, String> {
    let mut times = Vec::new();
    for (column, meaning) in meanings.iter().enumerate() {
        let Some(meaning) = meaning.as_ref().filter(|meaning| meaning.role.is_time()) else { continue };
        if meaning.unit.is_some_and(|unit| unit.quantity != Quantity::Time) {
            return Err("the time column's unit is not one of time".to_owned());
        }
        let source = Source { column, scale: meaning.unit.map_or(1.0, |unit| unit.scale) };
        times.push(Time { source, role: meaning.role, axis: meaning.axis.clone() });
    }
    Ok(times)
}

/// Refuses two columns of time of which neither stands before other columns, so that one is in excess.
fn check_plain(times: &[Time], width: usize) -> Result<(), String> {
    let plain: Vec<usize> = times.iter().filter(|time| time.role == Role::Time).map(|time| time.source.column).collect();
    let is_time = |column: &usize| times.iter().any(|time| time.source.column == *column);
    for (index, column) in plain.iter().enumerate().filter(|_| plain.len() > 1) {
        let next = plain.get(index + 1).copied().unwrap_or(width);
        if (column + 1..next).all(|between| is_time(&between)) {
            let (first, second) = if index + 1 < plain.len() { (*column, next) } else { (plain[index - 1], *column) };
            return Err(format!("columns {} and {} both claim to be the time of the log", first + 1, second + 1));
        }
    }
    Ok(())
}

fn clock_of(signal: &Signal<'_>, times: &[Time], names: &[String]) -> Result<Option<Source>, String> {
    let role = if signal.role == Role::Actual { Role::ActualTime } else { Role::ReferenceTime };
    for axis in [signal.axis, ""] {
        let mut own = times.iter().filter(|time| time.role == role && time.axis == axis);
        match (own.next(), own.next()) {
            (Some(first), Some(second)) => {
                let (first, second) = (first.source.column + 1, second.source.column + 1);
                return Err(format!("columns {first} and {second} both claim to be the time of `{}`", names[signal.column]));
            }
            (Some(time), None) => return Ok(Some(time.source)),
            _ => {}
        }
    }
    let plain: Vec<Source> = times.iter().filter(|time| time.role == Role::Time).map(|time| time.source).collect();
    match plain[..] {
        [] => Ok(None),
        [only] => Ok(Some(only)),
        _ => {
            let before = plain.iter().rfind(|time| time.column < signal.column);
            let missing = || format!("of several columns of time none stands before `{}`", names[signal.column]);
            before.copied().map(Some).ok_or_else(missing)
        }
    }
}
