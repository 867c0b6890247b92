//! Missing values: rows that lack one, and channels that have values in some rows only.

use std::path::Path;

use crate::columns::{Clock, ColumnMap, Side};
use crate::recorded::stated_period_s;
use crate::{Check, DatasetError, Finding, ReadOptions, Severity, Source, Table};

/// Share of the rows up to which those with a missing value are left out. Where more values of an axis are missing, the axis is.
const FEW: f64 = 0.1;
/// Longest mean stretch of rows without a value that a channel of its own rate leaves between its samples, and least number of them.
const BETWEEN: f64 = 20.0;
const FEWEST: usize = 20;

/// Whether some values of a column are missing, and not all.
pub(crate) fn is_incomplete(missing: usize, rows: usize) -> bool {
    (1..rows).contains(&missing)
}

/// The table and clocks of a log whose channels have rows of their own, as tables have that were joined by time: every channel gets its time
/// stamps as a column. `None` for other logs.
pub(crate) fn apart(table: &Table, map: &ColumnMap) -> Option<(Table, Vec<Clock>, Finding)> {
    let time = map.time.filter(|time| map.clocks.is_empty() && time.column < table.columns.len())?;
    let used = used(table, map);
    let has = |column: usize| -> Vec<bool> { table.columns[column].iter().map(|value| value.is_finite()).collect() };
    let whole = (0..table.len())
        .filter(|row| used.iter().all(|column| table.columns[*column].get(*row).is_some_and(|value| value.is_finite())));
    let few = FEW * table.len() as f64;
    // Few values may be missing in every channel, and in too many rows together.
    let is_mixed = table.len() - whole.count() > few as usize && used.iter().all(|column| is_between(&has(*column)));
    if !is_mixed && !used.iter().any(|column| is_sparse(&has(*column))) {
        return None;
    }
    // The command with most values has the clock of the log; channels with a value in nearly all of its rows have it, too.
    let commands = map.axes.iter().filter(|axis| axis.error_for != Some(Side::Reference)).map(|axis| axis.reference.column);
    let master = commands.filter(|column| used.contains(column)).rev().max_by_key(|column| count(&has(*column)))?;
    let own = has(master);
    let mut channels: Vec<(Vec<bool>, Vec<usize>)> = Vec::new();
    for &column in used.iter().filter(|column| **column != master) {
        let mask = has(column);
        let lacking = own.iter().zip(&mask).filter(|(own, has)| **own && !**has).count();
        if lacking as f64 <= if is_mixed { 0.0 } else { FEW * count(&own) as f64 } {
            continue;
        }
        match channels.iter_mut().find(|(known, _)| *known == mask) {
            Some((_, columns)) => columns.push(column),
            None => channels.push((mask, vec![column])),
        }
    }
    let rows = channels.iter().map(|(mask, _)| count(mask)).max().unwrap_or(0).max(count(&own));
    let taken = |column: usize, mask: &[bool]| {
        let values = table.columns[column].iter().zip(mask).filter(|(_, has)| **has).map(|(value, _)| *value);
        values.chain(std::iter::repeat(f64::NAN)).take(rows).collect::<Vec<f64>>()
    };
    let of = |column: usize| channels.iter().find(|(_, columns)| columns.contains(&column)).map_or(&own, |(mask, _)| mask);
    let mut out = Table { names: table.names.clone(), period_s: table.period_s, ..Table::default() };
    out.columns = (0..table.columns.len()).map(|column| taken(column, of(column))).collect();
    let lines = table.lines.iter().zip(&own).filter(|(_, has)| **has).map(|(line, _)| *line);
    let last = table.lines.last().copied().unwrap_or_default();
    out.lines = lines.chain(std::iter::repeat(last)).take(rows).collect();
    let mut clocks = Vec::with_capacity(channels.len());
    for (mask, signals) in &channels {
        out.names.push(format!("time of {}", table.names[signals[0]]));
        out.columns.push(taken(time.column, mask));
        clocks.push(Clock { time: Source { column: out.columns.len() - 1, ..time }, signals: signals.clone() });
    }
    let message = format!(
        "of {} rows {} hold a value of `{}`, others are those of other channels: the log has the clock of that one",
        table.len(),
        count(&own),
        table.names[master]
    );
    Some((out, clocks, Finding::new(Severity::Note, Check::Timing, message)))
}

/// The table without the rows in which a value is missing, where these are few, with its column of time, and a finding. A table without time
/// stamps gets a column of them, so that the rows that stay keep their times.
///
/// # Errors
/// When there is neither a column of time nor a period.
pub(crate) fn without_rows(
    path: &Path,
    table: &Table,
    map: &ColumnMap,
    options: &ReadOptions,
) -> Result<Option<(Table, Source, Finding)>, DatasetError> {
    let is_missing = |column: &usize, row: usize| table.columns[*column].get(row).is_none_or(|value| !value.is_finite());
    let few = |column: &usize| {
        let missing = (0..table.len()).filter(|row| is_missing(column, *row)).count();
        missing > 0 && missing as f64 <= FEW * table.len() as f64
    };
    let time_column = map.time.map(|time| time.column).filter(|column| *column < table.columns.len());
    let columns: Vec<usize> = used(table, map).into_iter().chain(time_column).filter(few).collect();
    let lacks = |row: usize| columns.iter().find(|column| is_missing(column, row));
    let kept: Vec<usize> = (0..table.len()).filter(|row| lacks(*row).is_none()).collect();
    let left_out = table.len() - kept.len();
    if left_out == 0 || left_out as f64 > FEW * table.len() as f64 {
        return Ok(None);
    }
    let mut out = Table { names: table.names.clone(), period_s: table.period_s, ..Table::default() };
    out.lines = kept.iter().map(|row| table.lines[*row]).collect();
    let of = |column: &Vec<f64>| kept.iter().map(|row| column.get(*row).copied().unwrap_or(f64::NAN)).collect();
    out.columns = table.columns.iter().map(of).collect();
    let time = match map.time {
        Some(time) => time,
        None => {
            let period_s = stated_period_s(path, table, &[], options.period_s)?;
            out.names.push("time of rows".to_owned());
            out.columns.push(kept.iter().map(|row| *row as f64 * period_s).collect());
            Source { column: out.columns.len() - 1, scale: 1.0 }
        }
    };
    let first = (0..table.len()).find_map(|row| Some((row, *lacks(row)?)));
    let place =
        first.map_or(String::new(), |(row, column)| format!(", first `{}` in line {}", table.names[column], table.lines[row]));
    let rows = if left_out == 1 { "a row lacks a value".to_owned() } else { format!("{left_out} rows lack a value") };
    let message = format!("{rows}{place}; such rows are left out and the motion over them interpolated");
    Ok(Some((out, time, Finding::new(Severity::Warn, Check::Mended, message))))
}

/// The columns of positions, the first command before the others.
fn used(table: &Table, map: &ColumnMap) -> Vec<usize> {
    let columns = map.axes.iter().flat_map(|axis| [axis.reference.column, axis.actual.column]);
    columns.filter(|column| *column < table.columns.len()).collect()
}

fn count(mask: &[bool]) -> usize {
    mask.iter().filter(|has| **has).count()
}

/// Whether a column has values throughout, with rows without one between them.
fn is_between(has: &[bool]) -> bool {
    let missing = has.len() - count(has);
    let stretches = has.chunk_by(|a, b| a == b).filter(|chunk| !chunk[0]).count();
    missing < has.len() && (missing == 0 || stretches >= FEWEST && missing as f64 <= BETWEEN * stretches as f64)
}

/// Whether more of its rows lack a value than may be left out.
fn is_sparse(has: &[bool]) -> bool {
    is_between(has) && (has.len() - count(has)) as f64 > FEW * has.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    const NO: f64 = f64::NAN;

    fn table(columns: &[(&str, Vec<f64>)]) -> (Table, ColumnMap) {
        let rows = columns[0].1.len();
        let table = Table {
            names: columns.iter().map(|(name, _)| (*name).to_owned()).collect(),
            columns: columns.iter().map(|(_, values)| values.clone()).collect(),
            lines: (2..rows + 2).collect(),
            ..Table::default()
        };
        let map = ColumnMap::recognise(Path::new("log.csv"), &table).unwrap();
        (table, map)
    }

    #[test]
    fn channels_with_rows_of_their_own_get_their_time_stamps() {
        let t: Vec<f64> = (0..60).map(f64::from).collect();
        let of = |rest: usize, add: f64| (0..60).map(|k| if k % 2 == rest { k as f64 + add } else { NO }).collect::<Vec<_>>();
        let (even, odd) = (of(0, 0.0), of(1, 0.5));
        let (table, map) = table(&[("t", t), ("x_ref", even.clone()), ("x_act", odd), ("y_ref", even.clone()), ("y_act", even)]);
        let (split, clocks, _) = apart(&table, &map).unwrap();
        let begin = |column: usize| split.columns[column][..4].to_vec();
        assert_eq!(
            (begin(0), begin(1), begin(2)),
            (vec![0.0, 2.0, 4.0, 6.0], vec![0.0, 2.0, 4.0, 6.0], vec![1.5, 3.5, 5.5, 7.5])
        );
        assert_eq!((begin(5), &split.lines[..4], split.len()), (vec![1.0, 3.0, 5.0, 7.0], &[2, 4, 6, 8][..], 30));
        assert_eq!(clocks, [Clock { time: Source { column: 5, scale: 1.0 }, signals: vec![2] }]);
    }

    #[test]
    fn a_column_that_ends_early_is_no_channel() {
        let t: Vec<f64> = (0..100).map(f64::from).collect();
        let short: Vec<f64> = t.iter().map(|t| if *t < 60.0 { *t } else { NO }).collect();
        let (table, map) = table(&[("t", t.clone()), ("x_ref", t), ("x_act", short)]);
        assert!(apart(&table, &map).is_none());
    }

    #[test]
    fn few_rows_without_a_value_are_left_out() {
        let t: Vec<f64> = (0..200).map(f64::from).collect();
        let mut actual = t.clone();
        (actual[50], actual[120]) = (NO, NO);
        let path = Path::new("log.csv");
        let (given, map) = table(&[("t", t.clone()), ("x_ref", t.clone()), ("x_act", actual.clone())]);
        let (left, _, found) = without_rows(path, &given, &map, &ReadOptions::default()).unwrap().unwrap();
        assert!(left.len() == 198 && left.columns[0][50] == 51.0 && left.lines[50] == 53, "{left:?}");
        assert!(found.message.contains("2 rows") && found.message.contains("`x_act` in line 52"), "{}", found.message);
        // Without time stamps the rows keep their places.
        let (given, map) = table(&[("x_ref", t.clone()), ("x_act", actual)]);
        let stated = ReadOptions { period_s: Some(0.5), ..ReadOptions::default() };
        let (left, time, _) = without_rows(path, &given, &map, &stated).unwrap().unwrap();
        assert_eq!(left.columns[time.column][49..51], [24.5, 25.5]);
        assert!(without_rows(path, &given, &map, &ReadOptions::default()).is_err());
        // An axis without its values is another thing.
        let half: Vec<f64> = t.iter().map(|t| if *t < 100.0 { *t } else { NO }).collect();
        let (given, map) = table(&[("t", t.clone()), ("x_ref", t), ("x_act", half)]);
        assert!(without_rows(path, &given, &map, &ReadOptions::default()).unwrap().is_none());
    }
}
