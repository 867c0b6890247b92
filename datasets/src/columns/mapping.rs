//! Column mappings given as text.

use std::path::Path;

use super::map::{AxisColumns, ColumnMap, Source};
use super::recognise::{axis, time_column, unit_of_name, unused};
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
    /// by its name.
    ///
    /// # Errors
    /// When the text cannot be parsed, or the table lacks a column.
    pub fn parse(text: &str, path: &Path, table: &Table) -> Result<Self, DatasetError> {
        parse(text, path, table)
    }
}

fn parse(text: &str, path: &Path, table: &Table) -> Result<ColumnMap, DatasetError> {
    let (time, sides) = entries(text, table)?;
    let whole = |reason: String| DatasetError::Mapping { text: text.to_owned(), reason };
    let axes = sides.into_iter().map(both_sides).collect::<Result<Vec<_>, _>>().map_err(whole)?;
    if axes.is_empty() {
        return Err(whole("no axis is named".to_owned()));
    }
    let time = match time {
        Some(time) => Some(time),
        None => time_column(table).map_err(|reason| DatasetError::Columns {
            path: path.to_owned(),
            reason,
            names: table.names.clone(),
        })?,
    };
    let mut used: Vec<usize> = time.iter().map(|source| source.column).collect();
    used.extend(axes.iter().flat_map(|axis| [axis.reference.column, axis.actual.column]));
    let unused = unused(table, &used);
    Ok(ColumnMap { time, axes, unused, assumed: Vec::new() })
}

/// The entries of a mapping, as `t=time_s,x_ref=cmd`: the column of time, and those of the axes.
fn entries(text: &str, table: &Table) -> Result<(Option<Source>, Vec<Sides>), DatasetError> {
    let mut time = None;
    let mut sides: Vec<Sides> = Vec::new();
    for entry in text.split(',').map(str::trim).filter(|entry| !entry.is_empty()) {
        let fail = |reason: String| DatasetError::Mapping { text: entry.to_owned(), reason };
        let (key, value) = entry.split_once('=').ok_or_else(|| fail("there is no `=`".to_owned()))?;
        let key = key.trim().to_ascii_lowercase();
        let axis = key.rsplit_once('_').map_or("", |(axis, _)| axis);
        let named = named(value.trim(), axis, table).map_err(fail)?;
        let duplicate = || fail(format!("`{key}` is given twice"));
        if key == "t" {
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
            _ => return Err(fail(format!("`{key}` is neither `t`, `<axis>_ref` nor `<axis>_act`"))),
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
    Ok((time, sides))
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
