//! Column mappings given as text.

use std::path::Path;

use super::entries::{Entries, Named, Sides};
use super::map::{AxisColumns, ColumnMap, Side};
use super::meaning::Role;
use super::recognise::{axis, clocks_of, column_of, unused};
use super::unit::Unit;
use crate::{DatasetError, Table};

impl ColumnMap {
    /// Parses a map such as `t=time_s,x_ref=x_cmd_mm,x_act=raw*0.001,y_ref=#4:um,y_act=#5:um`.
    ///
    /// Left-hand side: `t`, or axis and role, by any of the words that names of columns have (`x_ref`, `x_cmd`, `x_soll`). Right-hand side:
    /// a column name or `#` and its number, then `*factor` or `:unit`. The default is the unit of the axis where the map has one (`x:inch`),
    /// else that in the column's name, else s, mm or rad. Without `t` a time column is searched by its name; `t_ref` and `t_act` name those
    /// of commands and actual positions that have clocks of their own. Where a map
    /// names no axis, or only one column of an axis, the other columns are recognised by their names.
    ///
    /// # Errors
    /// When the text cannot be parsed, or the table lacks a column.
    pub fn parse(text: &str, path: &Path, table: &Table) -> Result<Self, DatasetError> {
        parse(text, path, table)
    }
}

fn parse(text: &str, path: &Path, table: &Table) -> Result<ColumnMap, DatasetError> {
    let Entries { times, sides, units } = Entries::parse(text, table)?;
    let whole = |reason: String| DatasetError::Mapping { text: text.to_owned(), reason };
    let is_partial = sides.iter().any(|sides| sides.count() < 2);
    let names_no_axis = sides.is_empty() && (!units.is_empty() || !times.is_empty());
    let recognised = (is_partial || names_no_axis).then(|| ColumnMap::recognise(path, table));
    if let Some(Ok(mut map)) = recognised {
        sides.into_iter().try_for_each(|stated| replace(&mut map.axes, stated, table)).map_err(whole)?;
        units.iter().try_for_each(|(axis, unit)| set_unit(&mut map.axes, axis, *unit)).map_err(whole)?;
        if let Some((time, clocks)) = times.clocks(&map.axes).map_err(whole)? {
            (map.time, map.clocks) = (time, clocks);
        }
        map.unused = unused(table, &map);
        return Ok(map);
    }
    if let (true, Some(Err(error))) = (names_no_axis, recognised) {
        return Err(error);
    }
    let axes =
        sides.into_iter().map(|stated| both_sides(completed(stated, table))).collect::<Result<Vec<_>, _>>().map_err(whole)?;
    if axes.is_empty() {
        return Err(whole("no axis is named".to_owned()));
    }
    if let Some((lost, _)) = units.iter().find(|(name, _)| axes.iter().all(|columns| columns.axis.name != *name)) {
        return Err(whole(no_such_axis(lost, &axes)));
    }
    let (time, clocks) = match times.clocks(&axes).map_err(whole)? {
        Some(stated) => stated,
        None => clocks_of(table, &axes).map_err(|reason| DatasetError::Columns {
            path: path.to_owned(),
            reason,
            names: table.names.clone(),
        })?,
    };
    let assumed = axes.iter().filter_map(|columns| columns.assumed(&table.names)).collect();
    let mut map = ColumnMap { time, clocks, axes, unused: Vec::new(), assumed };
    map.unused = unused(table, &map);
    Ok(map)
}

/// The columns of an axis of which one is stated, with the other by its name.
fn completed(mut stated: Sides, table: &Table) -> Sides {
    if stated.count() != 1 {
        return stated;
    }
    let Sides { axis, reference, actual, error } = &mut stated;
    let stated_columns: Vec<usize> =
        [&*reference, &*actual, &*error].into_iter().flatten().map(|named| named.source.column).collect();
    let named = |role| {
        let (column, unit) = column_of(table, axis, role).filter(|(column, _)| !stated_columns.contains(column))?;
        Some(Named::of_name(column, unit))
    };
    if reference.is_none() {
        *reference = named(Role::Reference);
    }
    if actual.is_none() && (reference.is_none() || error.is_none()) {
        *actual = named(Role::Actual);
    }
    if error.is_none() && (reference.is_none() || actual.is_none()) {
        *error = named(Role::Error);
    }
    stated
}

/// Replaces the columns of a recognised axis by those that are stated, or adds an axis.
fn replace(axes: &mut Vec<AxisColumns>, stated: Sides, table: &Table) -> Result<(), String> {
    let Some(columns) = axes.iter_mut().find(|columns| columns.axis.name == stated.axis) else {
        axes.push(both_sides(completed(stated, table))?);
        return Ok(());
    };
    if stated.count() > 1 {
        *columns = both_sides(stated)?;
        return Ok(());
    }
    let units = [&stated.reference, &stated.actual, &stated.error].map(|side| side.as_ref().and_then(|named| named.unit));
    if units.iter().any(Option::is_some) {
        columns.axis = axis(&stated.axis, &units)?;
    }
    columns.states_unit |= stated.states_unit();
    // A position that is stated takes the place of the tracking error.
    if let Some(named) = stated.reference {
        columns.reference = named.source;
        columns.error_for = columns.error_for.filter(|side| *side != Side::Reference);
    }
    if let Some(named) = stated.actual {
        columns.actual = named.source;
        columns.error_for = columns.error_for.filter(|side| *side != Side::Actual);
    }
    if let Some(named) = stated.error {
        match columns.error_for {
            Some(Side::Reference) => columns.reference = named.source,
            Some(Side::Actual) => columns.actual = named.source,
            None => {
                return Err(format!(
                    "axis `{0}` has a command and an actual position; map the one that counts beside `{0}_err`",
                    stated.axis
                ));
            }
        }
    }
    Ok(())
}

/// Sets the unit of an axis that was recognised.
fn set_unit(axes: &mut [AxisColumns], name: &str, unit: Unit) -> Result<(), String> {
    let Some(index) = axes.iter().position(|columns| columns.axis.name == name) else { return Err(no_such_axis(name, axes)) };
    let columns = &mut axes[index];
    columns.axis = axis(name, &[Some(unit)])?;
    columns.states_unit = true;
    (columns.reference.scale, columns.actual.scale) = (unit.scale, unit.scale);
    Ok(())
}

fn no_such_axis(name: &str, axes: &[AxisColumns]) -> String {
    let known: Vec<&str> = axes.iter().map(|columns| columns.axis.name.as_str()).collect();
    format!("a unit is given for `{name}`; the axes are {}", known.join(", "))
}

/// Refuses an axis with one missing column.
fn both_sides(stated: Sides) -> Result<AxisColumns, String> {
    let states_unit = stated.states_unit();
    let Sides { axis: name, reference, actual, error } = stated;
    let named = [reference, actual, error];
    if named.iter().all(Option::is_some) {
        return Err(format!("of `{name}_ref`, `{name}_act` and `{name}_err` two are enough; leave one out"));
    }
    let axis = axis(&name, &named.each_ref().map(|side| side.as_ref().and_then(|side| side.unit)))?;
    let columns = AxisColumns::with_error(axis, named.map(|side| side.map(|side| side.source)), states_unit);
    columns.ok_or_else(|| format!("axis `{name}` needs both `{name}_ref` and `{name}_act`, or one of them and `{name}_err`"))
}

#[cfg(test)]
mod tests {
    use motion::AxisKind;

    use super::*;
    use crate::{Severity, Source};

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
    fn roles_have_the_words_of_column_names() {
        let wanted = read("t=time_s,x_ref=5,x_act=motor_um").unwrap();
        for text in [
            "t=time_s,x_cmd=5,x_fb=motor_um",
            "t=time_s,X_Soll=5,x_ist=motor_um",
            "t_cmd=time_s,t_ist=time_s,x_des=5,x_enc=motor_um",
        ] {
            assert_eq!(read(text).unwrap(), wanted, "{text}");
        }
    }

    #[test]
    fn an_axis_has_a_unit_for_both_columns() {
        let scales = |map: &ColumnMap| [map.axes[0].reference.scale, map.axes[0].actual.scale];
        assert_eq!(scales(&read("x_cmd=5:inch,x_act=motor_um").unwrap()), [25.4, 1e-3]);
        // A unit or factor of a column counts more than that of the axis, which counts more than the name.
        assert_eq!(scales(&read("x_ref=5,x_act=motor_um,x:inch").unwrap()), [25.4, 25.4]);
        assert_eq!(scales(&read("x:inch,x_ref=5:mm,x_act=5*2").unwrap()), [1.0, 2.0]);
        let turned = read("x_ref=5,x_act=motor_um,X:deg").unwrap();
        assert_eq!(turned.axes[0].axis.kind, AxisKind::Rotary);
        // Of columns that are recognised by their names only the unit is stated.
        let names = ["clock", "x_ref", "x_act_mm", "y_ref", "y_act"].map(str::to_owned).to_vec();
        let table = Table { names, ..Table::default() };
        let map = parse("t=clock:ms,x:inch", Path::new("log.csv"), &table).unwrap();
        assert_eq!((scales(&map), map.axes[1].reference.scale), ([25.4, 25.4], 1.0));
        assert_eq!((map.time, map.unused.len()), (Some(Source { column: 0, scale: 1e-3 }), 0));
        // What is stated of some columns leaves the others to their names.
        let map = parse("t=clock:ms", Path::new("log.csv"), &table).unwrap();
        assert_eq!((map.time, map.axes.len()), (Some(Source { column: 0, scale: 1e-3 }), 2));
        let map = parse("y_act=y_act*-1,x_ref=x_ref:um", Path::new("log.csv"), &table).unwrap();
        assert_eq!((scales(&map), map.axes[1].actual.scale, map.axes[1].reference.scale), ([1e-3, 1.0], -1.0, 1.0));
        let both = parse("z_ref=clock", Path::new("log.csv"), &table).unwrap_err().to_string();
        assert!(both.contains("needs both"), "{both}");
    }

    #[test]
    fn one_column_of_an_axis_is_completed_by_the_names_of_the_others() {
        let parsed = |names: &[&str], text: &str| {
            let names = names.iter().map(|name| (*name).to_owned()).collect();
            parse(text, Path::new("log.csv"), &Table { names, ..Table::default() })
        };
        let columns =
            |map: &ColumnMap| map.axes.iter().map(|axis| [axis.reference.column, axis.actual.column]).collect::<Vec<_>>();
        assert_eq!(columns(&parsed(&["t", "x_ref", "pos"], "x_act=pos").unwrap()), [[1, 2]]);
        let map = parsed(&["t", "x_ref", "x_ferr"], "x_err=x_ferr:um").unwrap();
        assert_eq!((columns(&map), map.axes[0].error_for), (vec![[1, 2]], Some(Side::Actual)));
        let map = parsed(&["t", "own", "x_lag", "x_ist"], "x_ref=own").unwrap();
        assert_eq!((columns(&map), map.axes[0].error_for), (vec![[1, 3]], None));
        // An axis that no name gives is added to those that are recognised.
        let names = ["t", "x_ref", "x_act", "p", "q"];
        assert_eq!(columns(&parsed(&names, "y_ref=p,y_act=q,x_act=x_act:um").unwrap()), [[1, 2], [3, 4]]);
    }

    #[test]
    fn columns_of_one_name_are_mapped_by_their_numbers() {
        let names = ["t", "SetPos", "ActPos", "SetPos", "ActPos"].map(str::to_owned).to_vec();
        let table = Table { names, ..Table::default() };
        let refused = parse("x_ref=SetPos,x_act=ActPos", Path::new("log.csv"), &table).unwrap_err().to_string();
        assert!(refused.contains("columns 2 and 4") && refused.contains("`#2`"), "{refused}");
        let map = parse("y_ref=#4,y_act=#5:um", Path::new("log.csv"), &table).unwrap();
        assert_eq!((map.axes[0].reference.column, map.axes[0].actual.scale), (3, 1e-3));
    }

    #[test]
    fn angles_without_a_unit_are_told_but_for_logs_of_this_program() {
        let found = |names: &[&str], text: &str, travel_rad: f64| {
            let table = Table { names: names.iter().map(|name| (*name).to_owned()).collect(), ..Table::default() };
            let map = match text {
                "" => ColumnMap::recognise(Path::new("log.csv"), &table),
                text => parse(text, Path::new("log.csv"), &table),
            };
            map.unwrap().axes[0].unstated_angle(travel_rad).map(|finding| finding.severity)
        };
        let soll = ["Zeit", "C Soll", "C Ist"];
        assert_eq!(found(&soll, "", 8.0), Some(Severity::Refuse));
        assert_eq!(found(&soll, "", 2.0), Some(Severity::Warn));
        assert_eq!(found(&soll, "c:deg", 8.0), None);
        assert_eq!(found(&soll, "c_ref=C Soll*0.0174533,c_act=C Ist*0.0174533", 8.0), None);
        assert_eq!(found(&soll, "c_ref=C Soll,c_act=C Ist", 8.0), Some(Severity::Refuse));
        assert_eq!(found(&["t", "c_ref", "c_act"], "", 8.0), None);
        assert_eq!(found(&["t", "c_soll_deg", "c_ist_deg"], "", 8.0), None);
        assert_eq!(found(&["t", "x_soll", "x_ist"], "", 8.0), None);
    }

    #[test]
    fn a_tracking_error_stands_for_a_position() {
        let map = read("x_ref=5,x_err=motor_um*-1").unwrap();
        assert_eq!((map.axes[0].error_for, map.axes[0].actual), (Some(Side::Actual), Source { column: 2, scale: -1.0 }));
        assert!(map.assumed[0].contains("`motor_um`"), "{:?}", map.assumed);
        let map = read("x_fb=5,x_lag=motor_um").unwrap();
        assert_eq!((map.axes[0].error_for, map.axes[0].reference), (Some(Side::Reference), Source { column: 2, scale: 1e-3 }));
        // Of a recognised one sign or unit are stated alone.
        let names = ["t", "x_ref", "x_err", "y_ref", "y_act", "y_err"].map(str::to_owned).to_vec();
        let table = Table { names, ..Table::default() };
        let parsed = |text: &str| parse(text, Path::new("log.csv"), &table);
        let map = parsed("x_err=x_err*-0.001").unwrap();
        assert_eq!((map.axes[0].actual, map.axes[1].error_for), (Source { column: 2, scale: -1e-3 }, None));
        let map = parsed("y_ref=y_ref,y_err=y_err").unwrap();
        assert_eq!((map.axes[0].error_for, map.axes[0].actual.column), (Some(Side::Actual), 5));
        let both = parsed("y_err=y_err").unwrap_err().to_string();
        assert!(both.contains("map the one that counts"), "{both}");
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
            ("x:furlong", "no unit"),
            ("x:ms", "length or angle"),
            ("x:mm,x:inch", "given twice"),
            ("x_ref=5,x_act=5,y:inch", "the axes are x"),
            ("x_ref=5,x_cmd=5", "twice"),
            ("t_x=5", "neither"),
            ("t_err=5", "neither"),
            ("x_ref=5,x_act=5,x_err=#3", "two are enough"),
            ("x_err=5", "needs both"),
        ] {
            let message = read(text).unwrap_err().to_string();
            assert!(message.contains(word), "{text}: {message}");
        }
    }
}
