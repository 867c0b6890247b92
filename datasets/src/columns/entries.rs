//! Entries of a column mapping.

use super::map::{AxisColumns, Clock, Source};
use super::meaning::Role;
use super::names::role_of;
use super::recognise::unit_of_name;
use super::unit::{Quantity, UNITS, Unit};
use crate::{DatasetError, Table};

/// A column on the right-hand side of an entry.
pub(super) struct Named {
    pub source: Source,
    pub unit: Option<Unit>,
    /// Whether unit or factor are stated, not that of the column's name.
    is_stated: bool,
}

impl Named {
    /// A column that its name gives, with the unit in that name.
    pub(super) fn of_name(column: usize, unit: Option<Unit>) -> Self {
        let scale = unit.map_or(1.0, |unit| unit.scale);
        Self { source: Source { column, scale }, unit, is_stated: false }
    }
}

/// The columns of an axis.
pub(super) struct Sides {
    pub axis: String,
    pub reference: Option<Named>,
    pub actual: Option<Named>,
    /// The tracking error.
    pub error: Option<Named>,
}

/// The entries of a mapping.
#[derive(Default)]
pub(super) struct Entries {
    pub times: Times,
    pub sides: Vec<Sides>,
    /// Units of axes.
    pub units: Vec<(String, Unit)>,
}

/// Columns of time that a mapping names: of all positions, of the commands, of the actual ones.
#[derive(Default)]
pub(super) struct Times {
    all: Option<Source>,
    reference: Option<Source>,
    actual: Option<Source>,
}

/// The time stamps of the log, and the columns with others.
pub(super) type Stamps = (Option<Source>, Vec<Clock>);

impl Times {
    pub fn is_empty(&self) -> bool {
        self.all.or(self.reference).or(self.actual).is_none()
    }

    /// The time stamps of the commands, and those of the actual positions where they are others; `None` where the mapping names none.
    pub fn clocks(&self, axes: &[AxisColumns]) -> Result<Option<Stamps>, String> {
        if self.is_empty() {
            return Ok(None);
        }
        let (reference, actual) = (self.reference.or(self.all), self.actual.or(self.all));
        let (Some(reference), Some(actual)) = (reference, actual) else {
            return Err("`t_ref` and `t_act` belong together".to_owned());
        };
        let mut clocks = Vec::new();
        if reference != actual {
            axes.iter().for_each(|axis| Clock::add(&mut clocks, actual, axis.actual.column));
        }
        Ok(Some((Some(reference), clocks)))
    }
}

impl Entries {
    /// The entries of a text such as `t=time_s,x_ref=cmd,x_act=enc,x:inch`.
    ///
    /// # Errors
    /// When an entry cannot be parsed, is given twice, or names no column.
    pub fn parse(text: &str, table: &Table) -> Result<Self, DatasetError> {
        let mut entries = Self::default();
        for entry in split(text).map(str::trim).filter(|entry| !entry.is_empty()) {
            entries.add(entry, table).map_err(|reason| DatasetError::Mapping { text: entry.to_owned(), reason })?;
        }
        let Self { sides, units, .. } = &mut entries;
        for side in sides {
            let unit = units.iter().find(|(axis, _)| *axis == side.axis).map(|(_, unit)| *unit);
            if let Some(unit) = unit {
                side.take_unit(unit);
            }
        }
        Ok(entries)
    }

    fn add(&mut self, entry: &str, table: &Table) -> Result<(), String> {
        let Some((key, value)) = entry.split_once('=') else { return self.add_unit(entry) };
        let key = key.trim().to_lowercase();
        let is_given_twice = || format!("`{key}` is given twice");
        let (axis, side) = key.rsplit_once('_').map_or((key.as_str(), None), |(axis, word)| (axis, role_of(word)));
        let named = named(value.trim(), axis, table)?;
        if axis == "t" && (side.is_some_and(|role| role != Role::Error) || key == "t") {
            if named.unit.is_some_and(|unit| unit.quantity != Quantity::Time) {
                return Err("time needs a unit of time: s, ms, us, ns or min".to_owned());
            }
            let time = match side {
                None => &mut self.times.all,
                Some(Role::Actual) => &mut self.times.actual,
                Some(_) => &mut self.times.reference,
            };
            return time.replace(named.source).map_or(Ok(()), |_| Err(is_given_twice()));
        }
        let Some(role) = side.filter(|_| !axis.is_empty() && axis != "t") else {
            return Err(format!("`{key}` is neither `t`, `t_ref`, `t_act`, `<axis>_ref`, `<axis>_act` nor `<axis>_err`"));
        };
        let index = self.sides.iter().position(|sides| sides.axis == axis).unwrap_or_else(|| {
            self.sides.push(Sides { axis: axis.to_owned(), reference: None, actual: None, error: None });
            self.sides.len() - 1
        });
        let sides = &mut self.sides[index];
        let side = match role {
            Role::Actual => &mut sides.actual,
            Role::Error => &mut sides.error,
            _ => &mut sides.reference,
        };
        side.replace(named).map_or(Ok(()), |_| Err(is_given_twice()))
    }

    /// Adds the unit of an axis, `x:inch`.
    fn add_unit(&mut self, entry: &str) -> Result<(), String> {
        let Some((axis, word)) = entry.split_once(':') else { return Err("there is no `=`".to_owned()) };
        let unit = Unit::named(word).ok_or_else(|| format!("`{}` is no unit known here ({UNITS})", word.trim()))?;
        if unit.quantity == Quantity::Time {
            return Err("positions need a unit of length or angle".to_owned());
        }
        let axis = axis.trim().to_lowercase();
        if self.units.iter().any(|(known, _)| *known == axis) {
            return Err(format!("the unit of `{axis}` is given twice"));
        }
        self.units.push((axis, unit));
        Ok(())
    }
}

/// The entries of a mapping; a comma between double quotes belongs to a name.
fn split(text: &str) -> impl Iterator<Item = &str> {
    let mut quoted = false;
    text.split(move |sign| {
        quoted ^= sign == '"';
        sign == ',' && !quoted
    })
}

impl Sides {
    /// Whether the unit of a column is stated, or its factor.
    pub(super) fn states_unit(&self) -> bool {
        [&self.reference, &self.actual, &self.error].into_iter().flatten().any(|named| named.unit.is_some() || named.is_stated)
    }
    /// Number of columns that are named.
    pub fn count(&self) -> usize {
        [&self.reference, &self.actual, &self.error].into_iter().flatten().count()
    }

    /// Takes the unit of the axis for the columns whose own is not stated.
    fn take_unit(&mut self, unit: Unit) {
        for side in [&mut self.reference, &mut self.actual, &mut self.error].into_iter().flatten().filter(|side| !side.is_stated)
        {
            side.unit = Some(unit);
            side.source.scale = unit.scale;
        }
    }
}

/// What a name states in brackets as its unit, where that is none known: `rev` of `x_ref [rev]`.
fn strange_unit(name: &str) -> Option<&str> {
    let unit = name.trim_end().strip_suffix(']')?.rsplit_once('[')?.1.trim();
    (!unit.is_empty() && Unit::named(unit).is_none() && !unit.contains(|sign: char| sign.is_ascii_digit())).then_some(unit)
}

/// A column's name, in double quotes or not, or `#` and its number, with `*factor` or `:unit`, for `axis`.
fn named(text: &str, axis: &str, table: &Table) -> Result<Named, String> {
    if let Some(column) = find(text, table)? {
        let unit = unit_of_name(&table.names[column], axis);
        return match strange_unit(&table.names[column]).filter(|_| unit.is_none()) {
            Some(strange) => Err(format!(
                "the column states `{strange}`, which is no unit known here ({UNITS}); give its factor to mm, rad or s, as `{text}*10`"
            )),
            None => Ok(Named::of_name(column, unit)),
        };
    }
    if let Some((name, factor)) = text.rsplit_once('*')
        && let Some(column) = find(name.trim(), table)?
    {
        let scale: f64 = factor.trim().parse().map_err(|_| format!("`{factor}` is not a number"))?;
        if !scale.is_finite() || scale == 0.0 {
            return Err(format!("a factor of {scale} makes no positions"));
        }
        return Ok(Named { source: Source { column, scale }, unit: None, is_stated: true });
    }
    if let Some((name, word)) = text.rsplit_once(':')
        && let Some(column) = find(name.trim(), table)?
    {
        let unit = Unit::named(word).ok_or_else(|| format!("`{word}` is no unit known here ({UNITS})"))?;
        return Ok(Named { source: Source { column, scale: unit.scale }, unit: Some(unit), is_stated: true });
    }
    Err(format!("there is no column `{text}`; the columns are {}", table.names.join(", ")))
}

fn find(name: &str, table: &Table) -> Result<Option<usize>, String> {
    let name = name.strip_prefix('"').and_then(|name| name.strip_suffix('"')).unwrap_or(name);
    let mut named = (0..table.names.len()).filter(|index| table.names[*index] == name);
    if let Some(index) = named.next() {
        return match named.next() {
            Some(other) => Err(format!(
                "`{name}` is the name of columns {} and {}; map one by its number, as `#{}`",
                index + 1,
                other + 1,
                index + 1
            )),
            None => Ok(Some(index)),
        };
    }
    match name.strip_prefix('#').map(str::parse::<usize>) {
        Some(Ok(number)) if (1..=table.names.len()).contains(&number) => Ok(Some(number - 1)),
        Some(Ok(number)) => Err(format!("there are {} columns, no {number}", table.names.len())),
        _ => Ok(None),
    }
}
