//! Column mappings given as text.

use std::path::Path;

use super::map::{AxisColumns, Clock, ColumnMap, Source};
use super::recognise::{axis, clocks_of, unit_of_name, unused};
use super::unit::{Quantity, Unit};
use crate::{DatasetError, Table};

/// A column on the right-hand side of an entry.
struct Named {
    source: Source,
    unit: Option<Unit>,
}

/// Name of an axis with the columns of its reference and its actual position, if given.
type Sides = (String, Option<Named>, Option<Named>);

impl ColumnMap {
    /// Parses a map such as `t=time_s,x_ref=x_cmd_mm,x_act=raw*0.001,y_ref=#4:um,y_act=#5:um`.
    ///
    /// Right-hand side: a column name or `#` and its number, then `*factor` or `:unit`. The default
    /// is the unit in the column's name, else s, mm or rad. Without `t` a time column is searched
    /// by its name; `t_ref` and `t_act` name those of commands and actual positions that have clocks of their own.
    ///
    /// # Errors
    /// When the text cannot be parsed, or the table lacks a column.
    pub fn parse(text: &str, path: &Path, table: &Table) -> Result<Self, DatasetError> {
        parse(text, path, table)
    }
}

fn parse(text: &str, path: &Path, table: &Table) -> Result<ColumnMap, DatasetError> {
    let (times, sides) = entries(text, table)?;
    let whole = |reason: String| DatasetError::Mapping { text: text.to_owned(), reason };
    let axes = sides.into_iter().map(both_sides).collect::<Result<Vec<_>, _>>().map_err(whole)?;
    if axes.is_empty() {
        return Err(whole("no axis is named".to_owned()));
    }
    let (time, clocks) = match times.clocks(&axes).map_err(whole)? {
        Some(stated) => stated,
        None => clocks_of(table, &axes).map_err(|reason| DatasetError::Columns {
            path: path.to_owned(),
            reason,
            names: table.names.clone(),
        })?,
    };
    let mut map = ColumnMap { time, clocks, axes, unused: Vec::new(), assumed: Vec::new() };
    map.unused = unused(table, &map);
    Ok(map)
}

/// Columns of time that a mapping names: of all positions, of the commands, of the actual ones.
#[derive(Default)]
struct Times {
    all: Option<Source>,
    reference: Option<Source>,
    actual: Option<Source>,
}

/// The time stamps of the log, and the columns with others.
type Stamps = (Option<Source>, Vec<Clock>);

impl Times {
    /// The time stamps of the commands, and those of the actual positions where they are others; `None` where the mapping names none.
    fn clocks(&self, axes: &[AxisColumns]) -> Result<Option<Stamps>, String> {
        if self.all.or(self.reference).or(self.actual).is_none() {
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

/// The entries of a mapping, as `t=time_s,x_ref=cmd`: the columns of time, and those of the axes.
fn entries(text: &str, table: &Table) -> Result<(Times, Vec<Sides>), DatasetError> {
    let mut times = Times::default();
    let mut sides: Vec<Sides> = Vec::new();
    for entry in text.split(',').map(str::trim).filter(|entry| !entry.is_empty()) {
        let fail = |reason: String| DatasetError::Mapping { text: entry.to_owned(), reason };
        let (key, value) = entry.split_once('=').ok_or_else(|| fail("there is no `=`".to_owned()))?;
        let key = key.trim().to_ascii_lowercase();
        let axis = key.rsplit_once('_').map_or("", |(axis, _)| axis);
        let named = named(value.trim(), axis, table).map_err(fail)?;
        let duplicate = || fail(format!("`{key}` is given twice"));
        let time = match key.as_str() {
            "t" => Some(&mut times.all),
            "t_ref" => Some(&mut times.reference),
            "t_act" => Some(&mut times.actual),
            _ => None,
        };
        if let Some(time) = time {
            if named.unit.is_some_and(|unit| unit.quantity != Quantity::Time) {
                return Err(fail("time needs a unit of time: s, ms, us, ns or min".to_owned()));
            }
            if time.replace(named.source).is_some() {
                return Err(duplicate());
            }
            continue;
        }
        let (name, is_reference) = match key.rsplit_once('_') {
            Some((name, "ref")) if !name.is_empty() => (name, true),
            Some((name, "act")) if !name.is_empty() => (name, false),
            _ => return Err(fail(format!("`{key}` is neither `t`, `t_ref`, `t_act`, `<axis>_ref` nor `<axis>_act`"))),
        };
        let index = match sides.iter().position(|side| side.0 == name) {
            Some(index) => index,
            None => {
                sides.push((name.to_owned(), None, None));
                sides.len() - 1
            }
        };
        let side = if is_reference { &mut sides[index].1 } else { &mut sides[index].2 };
        if side.replace(named).is_some() {
            return Err(duplicate());
        }
    }
    Ok((times, sides))
}

/// Refuses an axis with one missing column.
fn both_sides((name, reference, actual): Sides) -> Result<AxisColumns, String> {
    let (Some(reference), Some(actual)) = (reference, actual) else {
        return Err(format!("axis `{name}` needs both `{name}_ref` and `{name}_act`"));
    };
    Ok(AxisColumns { axis: axis(&name, &[reference.unit, actual.unit])?, reference: reference.source, actual: actual.source })
}

/// A column's name or `#` and its number, with `*factor` or `:unit`, for `axis`.
fn named(text: &str, axis: &str, table: &Table) -> Result<Named, String> {
    if let Some(column) = find(text, table)? {
        let unit = unit_of_name(&table.names[column], axis);
        let scale = unit.map_or(1.0, |unit| unit.scale);
        return Ok(Named { source: Source { column, scale }, unit });
    }
    if let Some((name, factor)) = text.rsplit_once('*')
        && let Some(column) = find(name.trim(), table)?
    {
        let scale: f64 = factor.trim().parse().map_err(|_| format!("`{factor}` is not a number"))?;
        if !scale.is_finite() || scale == 0.0 {
            return Err(format!("a factor of {scale} makes no positions"));
        }
        return Ok(Named { source: Source { column, scale }, unit: None });
    }
    if let Some((name, word)) = text.rsplit_once(':')
        && let Some(column) = find(name.trim(), table)?
    {
        let unit = Unit::named(word).ok_or_else(|| format!("`{word}` is no unit known here"))?;
        return Ok(Named { source: Source { column, scale: unit.scale }, unit: Some(unit) });
    }
    Err(format!("there is no column `{text}`; the columns are {}", table.names.join(", ")))
}

fn find(name: &str, table: &Table) -> Result<Option<usize>, String> {
    if let Some(index) = table.names.iter().position(|other| other == name) {
        return Ok(Some(index));
    }
    match name.strip_prefix('#').map(str::parse::<usize>) {
        Some(Ok(number)) if (1..=table.names.len()).contains(&number) => Ok(Some(number - 1)),
        Some(Ok(number)) => Err(format!("there are {} columns, no {number}", table.names.len())),
        _ => Ok(None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use motion::AxisKind;

    fn table() -> Table {
        Table { names: ["time_s", "cmd a*b", "motor_um", "5"].map(str::to_owned).to_vec(), ..Table::default() }
    }

    fn read(text: &str) -> Result<ColumnMap, DatasetError> {
        parse(text, Path::new("log.csv"), &table())
    }

    #[test]
    fn names_numbers_factors_and_units_are_read() {
        let map = read("t=#1:ms, x_ref = cmd a*b*0.001, x_act=motor_um").unwrap();
        assert_eq!(map.time, Some(Source { column: 0, scale: 1e-3 }));
        assert_eq!(map.axes[0].reference, Source { column: 1, scale: 1e-3 });
        assert_eq!(map.axes[0].actual, Source { column: 2, scale: 1e-3 });
        assert_eq!(map.unused, vec!["5".to_owned()]);
        let map = read("x_ref=#4:deg,x_act=5*1").unwrap();
        assert_eq!(map.time, Some(Source { column: 0, scale: 1.0 }));
        assert_eq!(map.axes[0].axis.kind, AxisKind::Rotary);
    }

    #[test]
    fn invalid_mappings_are_reported() {
        for (text, word) in [
            ("", "no axis"),
            ("x_ref", "no `=`"),
            ("x_ref=nothing", "no column `nothing`"),
            ("x_ref=5", "needs both"),
            ("x_ref=5,x_ref=5", "twice"),
            ("x_pos=5", "neither"),
            ("x_ref=5:furlong", "no unit"),
            ("x_ref=5*a", "not a number"),
            ("x_ref=#9", "4 columns"),
            ("t=motor_um,x_ref=5,x_act=5", "unit of time"),
            ("x_ref=5:deg,x_act=5:mm", "contradict"),
        ] {
            let message = read(text).unwrap_err().to_string();
            assert!(message.contains(word), "{text}: {message}");
        }
    }
}
