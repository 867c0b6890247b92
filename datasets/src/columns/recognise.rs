//! Recognises columns by their names.

use std::path::Path;

use motion::{Axis, AxisKind};

use super::clocks::{Signal, clocks};
use super::doubts::{Doubtful, is_garbled, is_perhaps_time, many_turns, rises};
use super::map::{AxisColumns, Clock, ColumnMap, Side, Source};
use super::meaning::{Meaning, Role};
use super::names::understand;
use super::numbered::{assumed_unit, is_edge_signal};
use super::unit::{Quantity, Unit};
use crate::{DatasetError, Table};

impl ColumnMap {
    /// The map that follows from a table's column names. A name counts only if every word in it is
    /// known.
    ///
    /// # Errors
    /// When no axis has both columns, two columns have the same meaning, or units contradict each
    /// other.
    pub fn recognise(path: &Path, table: &Table) -> Result<Self, DatasetError> {
        recognise(path, table)
    }
}

fn recognise(path: &Path, table: &Table) -> Result<ColumnMap, DatasetError> {
    let fail = |reason: String| DatasetError::Columns { path: path.to_owned(), reason, names: table.names.clone() };
    let (meanings, mut assumed) = meanings(table);
    assumed.extend(numbered_axes(table));
    let mut axes: Vec<AxisColumns> = Vec::new();
    let mut signals: Vec<Signal<'_>> = Vec::new();
    let names = axis_names(&meanings, &[Role::Reference, Role::Actual]);
    let mut doubtful = Doubtful::of(table, &meanings);
    for name in &names {
        let reference = only(&meanings, name, Role::Reference).map_err(fail)?;
        let actual = only(&meanings, name, Role::Actual).map_err(fail)?;
        let error = match (reference, actual) {
            (Some(_), Some(_)) => None,
            _ => only(&meanings, name, Role::Error).map_err(fail)?,
        };
        let bare = only(&meanings, name, Role::Position).map_err(fail)?.filter(|_| error.is_none());
        let (reference, actual) = match (reference, actual, bare) {
            (None, Some(actual), Some(bare)) => {
                assumed.push(format!("`{}` is taken for the command of {name}", table.names[bare.0]));
                (Some(bare), Some(actual))
            }
            (Some(reference), None, Some(bare)) => {
                assumed.push(format!("`{}` is taken for the actual position of {name}", table.names[bare.0]));
                (Some(reference), Some(bare))
            }
            both => (both.0, both.1),
        };
        let units = [reference, actual, error].map(|found| found.and_then(|(_, unit)| unit));
        let axis = axis(&short_name(name, &meanings), &units).map_err(fail)?;
        let of = |found: Found| found.map(|(column, unit)| source(column, unit));
        // An error without a unit has that of the position.
        let error = error.map(|(column, unit)| (column, unit.or(units[0]).or(units[1])));
        let sources = [of(reference), of(actual), of(error)];
        let of_log = |found: Found, role: &str| found.is_some_and(|(column, _)| table.names[column] == format!("{axis}_{role}"));
        // The names that a log has which this program wrote: mm and rad.
        let is_own = of_log(reference, "ref") && of_log(actual, "act");
        let states_unit = is_own || units.iter().any(Option::is_some);
        if is_own && axis.kind == AxisKind::Rotary && units.iter().all(Option::is_none) {
            assumed.extend(reference.and_then(|(column, _)| many_turns(&axis.name, table.columns.get(column)?)));
        }
        let Some(columns) = AxisColumns::with_error(axis, sources, states_unit) else { continue };
        let sides = [columns.reference, columns.actual].map(|source| source.column);
        if units.iter().all(Option::is_none) && doubtful.leaves_out(name, sides) {
            continue;
        }
        assumed.extend(columns.assumed(&table.names));
        signals.push(Signal { axis: name, role: Role::Reference, column: columns.reference.column });
        signals.push(Signal { axis: name, role: Role::Actual, column: columns.actual.column });
        axes.push(columns);
    }
    if let Some(why) = doubtful.why() {
        if axes.is_empty() {
            return Err(fail(format!("{why}, and no other columns are known for positions")));
        }
        assumed.push(format!("{why} and are left out; where they are positions, say so with a mapping"));
    }
    if axes.is_empty() {
        let encoding = if table.names.iter().any(|name| is_garbled(name)) {
            " (their letters are of another encoding than UTF-8, perhaps GBK or Shift-JIS; save the file as UTF-8)"
        } else {
            ""
        };
        return Err(fail(format!(
            "no axis has both a commanded and an actual position, or one of them and its tracking error, by its column names{encoding}"
        )));
    }
    let (time, clocks) = clocks(&table.names, &meanings, &signals).map_err(fail)?;
    let mut map = ColumnMap { time, clocks, axes, unused: Vec::new(), assumed };
    map.unused = unused(table, &map);
    Ok(map)
}

/// The columns of a reference: time, others with time stamps of their own, positions.
#[derive(Debug)]
pub(crate) struct CommandColumns {
    pub time: Option<Source>,
    pub clocks: Vec<Clock>,
    pub axes: Vec<(Axis, Source)>,
}

impl TryFrom<ColumnMap> for CommandColumns {
    type Error = String;

    fn try_from(map: ColumnMap) -> Result<Self, String> {
        if let Some(lost) = map.axes.iter().find(|columns| columns.error_for == Some(Side::Reference)) {
            return Err(format!("of axis `{}` the file holds no command, only actual position and tracking error", lost.axis));
        }
        let axes: Vec<(Axis, Source)> = map.axes.into_iter().map(|axis| (axis.axis, axis.reference)).collect();
        let is_command = |column: &usize| axes.iter().any(|(_, source)| source.column == *column);
        let of_commands = |clock: Clock| {
            let signals: Vec<usize> = clock.signals.into_iter().filter(is_command).collect();
            (!signals.is_empty()).then_some(Clock { signals, ..clock })
        };
        Ok(Self { time: map.time, clocks: map.clocks.into_iter().filter_map(of_commands).collect(), axes })
    }
}

/// The column that a name gives to a role of an axis, as a unit of its own where the name has one; `None` where there is none, or not one alone.
pub(super) fn column_of(table: &Table, axis: &str, role: Role) -> Found {
    let meanings = meanings(table).0;
    let names = axis_names(&meanings, &[role]);
    let name = names.iter().find(|name| *name == axis || short_name(name, &meanings) == axis)?;
    only(&meanings, name, role).ok().flatten()
}

/// Columns of a reference: `t,x,y,z`, or the commanded ones of a log.
pub(crate) fn recognise_reference(path: &Path, table: &Table) -> Result<CommandColumns, DatasetError> {
    let fail = |reason: String| DatasetError::Columns { path: path.to_owned(), reason, names: table.names.clone() };
    let (meanings, _) = meanings(table);
    for role in [Role::Position, Role::Reference] {
        let (names, mut axes, mut signals) = (axis_names(&meanings, &[role]), Vec::new(), Vec::new());
        for name in &names {
            if let Some((column, unit)) = only(&meanings, name, role).map_err(fail)? {
                let axis = axis(&short_name(name, &meanings), &[unit]).map_err(fail)?;
                axes.push((axis, source(column, unit)));
                signals.push(Signal { axis: name, role, column });
            }
        }
        if !axes.is_empty() {
            let (time, clocks) = clocks(&table.names, &meanings, &signals).map_err(fail)?;
            return Ok(CommandColumns { time, clocks, axes });
        }
    }
    Err(fail("no column is named like an axis".to_owned()))
}

/// The time stamps of mapped axes, by the names of the columns.
pub(super) fn clocks_of(table: &Table, axes: &[AxisColumns]) -> Result<(Option<Source>, Vec<Clock>), String> {
    let signals = axes.iter().flat_map(|axis| {
        let sides = [(Role::Reference, axis.reference), (Role::Actual, axis.actual)];
        sides.map(|(role, source)| Signal { axis: &axis.axis.name, role, column: source.column })
    });
    clocks(&table.names, &meanings(table).0, &signals.collect::<Vec<_>>())
}

/// Whether every word of a name is known.
pub(crate) fn is_known(name: &str) -> bool {
    understand(name).is_some()
}

/// Whether a name is that of the time stamps of commands or of actual positions only.
pub(crate) fn is_own_clock(name: &str) -> bool {
    understand(name).is_some_and(|meaning| meaning.role.is_time() && meaning.role != Role::Time)
}

/// The unit of a column that is mapped to `axis`.
pub(super) fn unit_of_name(name: &str, axis: &str) -> Option<Unit> {
    if let Some(unit) = assumed_unit(name, axis) {
        return Some(unit);
    }
    understand(name).and_then(|meaning| meaning.unit).or_else(|| {
        // Names with unknown words may still end in their unit: `motor_travel_um`.
        let (_, last) = name.rsplit_once(['_', ' ', '[', '('])?;
        Unit::named(last)
    })
}

/// Names of the columns that a map leaves out.
pub(super) fn unused(table: &Table, map: &ColumnMap) -> Vec<String> {
    let times = map.time.iter().chain(map.clocks.iter().map(|clock| &clock.time)).map(|source| source.column);
    let positions = map.axes.iter().flat_map(|axis| [axis.reference.column, axis.actual.column]);
    let used: Vec<usize> = times.chain(positions).collect();
    table.names.iter().enumerate().filter(|(index, _)| !used.contains(index)).map(|(_, name)| name.clone()).collect()
}

/// The axis of a name; a unit of length or angle decides its kind.
pub(super) fn axis(name: &str, units: &[Option<Unit>]) -> Result<Axis, String> {
    let mut axis = Axis::named(name);
    let mut quantities = units.iter().flatten().map(|unit| unit.quantity);
    if let Some(first) = quantities.next() {
        if quantities.any(|other| other != first) || first == Quantity::Time {
            return Err(format!("the units of axis `{name}` contradict each other"));
        }
        axis.kind = match first {
            Quantity::Angle => AxisKind::Rotary,
            _ => AxisKind::Linear,
        };
    }
    Ok(axis)
}

/// Estimated period from a column of positions and one of speeds, s: the regression of the
/// position's steps on the speed.
pub(crate) fn implied_period_s(table: &Table) -> Option<f64> {
    table.names.iter().zip(&table.columns).find_map(|(name, positions)| {
        let speed_name = name.replace("Position", "Velocity").replace("pos", "vel");
        if speed_name == *name {
            return None;
        }
        let speeds = &table.columns[table.names.iter().position(|other| *other == speed_name)?];
        let (mut travel, mut square) = (0.0, 0.0);
        for (position, speed) in positions.windows(2).zip(speeds.windows(2)) {
            let mean = f64::midpoint(speed[0], speed[1]);
            travel += (position[1] - position[0]) * mean;
            square += mean * mean;
        }
        let period_s = travel / square;
        (period_s.is_finite() && period_s > 0.0).then_some(period_s)
    })
}

/// Rows at the beginning of a log that show whether an encoder is there.
pub(crate) const PROBED_ROWS: usize = 1000;

/// Indices of the columns of second encoders.
pub(crate) fn table_encoders(table: &Table) -> Vec<usize> {
    let is_table = |name: &String| understand(name).is_some_and(|meaning| meaning.is_table);
    table.names.iter().enumerate().filter(|(_, name)| is_table(name)).map(|(index, _)| index).collect()
}

/// Meanings of the columns, and what was assumed: of the two encoders of an axis the one at the table counts, unless it is not there, so
/// that it reads 0 throughout the first rows.
fn meanings(table: &Table) -> (Vec<Option<Meaning>>, Vec<String>) {
    let mut meanings: Vec<Option<Meaning>> = table.names.iter().map(|name| understand(name)).collect();
    for (meaning, (name, values)) in meanings.iter_mut().zip(table.names.iter().zip(&table.columns)) {
        if is_perhaps_time(name) && meaning.as_ref().is_some_and(|meaning| meaning.role.is_time()) && !rises(values) {
            *meaning = None;
        }
    }
    let mut assumed = Vec::new();
    for second in table_encoders(table) {
        let axis = meanings[second].as_ref().map(|meaning| meaning.axis.clone()).unwrap_or_default();
        let is_first = |meaning: &Meaning| meaning.role == Role::Actual && meaning.axis == axis && !meaning.is_table;
        let Some(first) = meanings.iter().position(|meaning| meaning.as_ref().is_some_and(is_first)) else { continue };
        let rows = table.columns.get(second).map_or(&[][..], Vec::as_slice);
        let rows = &rows[..rows.len().min(PROBED_ROWS)];
        let (taken, left) =
            if !rows.is_empty() && rows.iter().all(|value| *value == 0.0) { (first, second) } else { (second, first) };
        let why = if taken == second { "the encoder at the table" } else { "the other one reads 0" };
        assumed.push(format!("of the encoders of {axis} `{}` is used, {why}; choose with a mapping", table.names[taken]));
        meanings[left] = None;
    }
    (meanings, assumed)
}

/// What is assumed of axes that are numbered.
fn numbered_axes(table: &Table) -> Option<String> {
    table.names.iter().any(|name| is_edge_signal(name)).then(|| {
        "axes 1 to 6 are taken for x y z a b c, in mm and degrees; where the machine's are others, say so with a mapping like \
         `z_ref=DES_POS|2,z_act=ENC1_POS|2`"
            .to_owned()
    })
}

fn source(column: usize, unit: Option<Unit>) -> Source {
    Source { column, scale: unit.map_or(1.0, |unit| unit.scale) }
}

fn axis_names(meanings: &[Option<Meaning>], roles: &[Role]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for meaning in meanings.iter().flatten() {
        if roles.contains(&meaning.role) && !names.contains(&meaning.axis) {
            names.push(meaning.axis.clone());
        }
    }
    names
}

/// `x1` becomes `x` if no other axis begins with that letter.
fn short_name(name: &str, meanings: &[Option<Meaning>]) -> String {
    let letter = &name[..name.len().min(1)];
    let alone = meanings.iter().flatten().all(|meaning| meaning.axis == name || !meaning.axis.starts_with(letter));
    let lettered = name.len() > 1 && !matches!(letter, "j") && !name.starts_with("axis");
    if alone && lettered { letter.to_owned() } else { name.to_owned() }
}

pub(super) type Found = Option<(usize, Option<Unit>)>;

fn only(meanings: &[Option<Meaning>], axis: &str, role: Role) -> Result<Found, String> {
    let mut found = meanings.iter().enumerate().filter_map(|(index, meaning)| {
        let meaning = meaning.as_ref()?;
        (meaning.role == role && meaning.axis == axis).then_some((index, meaning.unit))
    });
    let first = found.next();
    match (first, found.next()) {
        (Some((first, _)), Some((second, _))) => Err(format!(
            "columns {} and {} both claim to be the {} of {}",
            first + 1,
            second + 1,
            match role {
                Role::Actual => "actual position",
                Role::Error => "tracking error",
                _ => "command",
            },
            axis
        )),
        _ => Ok(first),
    }
}
