//! Text tables: comma, semicolon, tab or blanks, decimal point or comma, comments, a preamble, a row of units.

use std::collections::HashSet;
use std::hash::Hash;
use std::path::Path;

use super::dialect::Dialect;
use super::text::{self, Line};
use super::{HEAD_BYTES, LogFormat};
use crate::columns::{Unit, is_known};
use crate::{Check, DatasetError, Finding, Severity, Table};

/// Text tables with a header line. Separator and decimal sign are detected.
///
/// Files without a header get the column names `1`, `2`, …, for a mapping to refer to.
#[derive(Debug, Clone, Copy)]
pub struct Csv;

impl LogFormat for Csv {
    fn name(&self) -> &'static str {
        "CSV"
    }

    fn recognises(&self, head: &[u8]) -> bool {
        let head = &head[..head.len().min(HEAD_BYTES)];
        text::is_utf16(head) || !head.contains(&0)
    }

    fn read(&self, path: &Path, bytes: Vec<u8>) -> Result<Table, DatasetError> {
        let text = text::decode(&bytes);
        let (lines, comments) = text::lines(&text);
        if text.matches(text::HEAD_END).count() > HEADS {
            let why =
                "the file holds several recordings of LabVIEW, each with a head of its own; cut it into one file a recording";
            return Err(DatasetError::format(path, why));
        }
        if is_part_program(&lines) {
            return Err(DatasetError::format(path, "this is a part program; a log holds recorded positions, one row a sample"));
        }
        let dialect = Dialect::sniff(&lines);
        let Some(first) = lines.iter().position(|line| dialect.is_data(line.text)) else {
            return Err(DatasetError::format(path, "no line holds numbers; a log holds recorded positions, one row a sample"));
        };
        let names = header(&dialect, &lines[..first], &comments, &lines[first]);
        let mut rows: Vec<Line<'_>> = lines[first..].iter().filter(|line| !dialect.is_remark(line.text)).cloned().collect();
        let mut findings = Vec::new();
        if let Some(row) = rows.iter().find(|row| is_other_header(&dialect, &names, row.text)) {
            return Err(DatasetError::format(path, other_header(row.number)));
        }
        check_widths(path, &dialect, &mut rows, &mut findings)?;
        drop_cut_number(&text, &dialect, &mut rows, &mut findings);
        let mut table = Table {
            columns: parse(&dialect, &rows),
            lines: rows.iter().map(|row| row.number).collect(),
            names,
            period_s: None,
            findings,
        };
        if text.contains(text::HEAD_END) {
            name_time_of_labview(&mut table, &text);
        }
        Ok(table)
    }
}

/// Heads of a measurement file of LabVIEW with one recording.
const HEADS: usize = 2;

/// Names the time of a measurement file of LabVIEW, whose column `X_Value` it is; where that is empty, the head states the sampling period.
fn name_time_of_labview(table: &mut Table, text: &str) {
    let Some(time) = table.names.iter().position(|name| name == "X_Value") else { return };
    if table.columns[time].iter().all(|value| value.is_nan()) {
        let period = text.lines().find_map(|line| line.strip_prefix("Delta_X")?.split_whitespace().next());
        table.period_s = period.and_then(|period| period.replace(',', ".").parse().ok()).filter(|period_s| *period_s > 0.0);
    } else {
        table.names[time] = "time [s]".to_owned();
    }
}

/// Whether most of the first lines are blocks of words such as `N10 G1 X2.5`.
fn is_part_program(lines: &[Line<'_>]) -> bool {
    let is_block = |code: &str| {
        let words = match code.strip_prefix(['N', 'n']) {
            Some(numbered) => numbered.trim_start_matches(|c: char| c.is_ascii_digit() || c == ' '),
            None => code,
        };
        let mut characters = words.chars();
        characters.next().is_some_and(|letter| "GMTSFXYZ".contains(letter.to_ascii_uppercase()))
            && characters.next().is_some_and(|after| after.is_ascii_digit() || "+-.#".contains(after))
            && !words.contains([',', '\t'])
    };
    let code = |line: &'_ Line<'_>| line.text.split(['(', ';']).next().map(|code| code.trim_matches(['/', ' ']).to_owned());
    let code: Vec<String> = lines.iter().take(PROGRAM_LINES).filter_map(code).filter(|code| !code.is_empty()).collect();
    2 * code.iter().filter(|code| is_block(code)).count() > code.len()
}

/// Number of lines for the detection of a part program.
const PROGRAM_LINES: usize = 100;

/// Column names from the last line of the right width before the data, the first of which is `row` (with a row of units or of groups added to the names), or from a comment.
fn header(dialect: &Dialect, before: &[Line<'_>], comments: &[Line<'_>], row: &Line<'_>) -> Vec<String> {
    let trimmed = |line| {
        let mut fields = dialect.fields(line);
        // As in rows, a separator at the end adds no column.
        while fields.len() > dialect.width && fields.last().is_some_and(|field| field.is_empty()) {
            fields.pop();
        }
        fields
    };
    let lines = comments.iter().chain(before).rev();
    let mut candidates = lines.map(|line| trimmed(line.text)).filter(|fields| fields.len() == dialect.width);
    let numbered = || (1..=dialect.width).map(|column| column.to_string()).collect();
    let Some(last) = candidates.next() else {
        return before.last().and_then(|line| of_other_width(dialect, line, row)).unwrap_or_else(numbered);
    };
    let is_units =
        last.iter().all(|word| word.is_empty() || Unit::named(word).is_some()) && last.iter().any(|word| !word.is_empty());
    match candidates.next() {
        Some(names) if is_units => {
            let with_unit = |(name, unit): (&&str, &&str)| match Unit::named(unit) {
                Some(_) => format!("{name} {unit}"),
                None => (*name).to_owned(),
            };
            names.iter().zip(&last).map(with_unit).collect()
        }
        groups => {
            let both = groups.and_then(|groups| in_two_rows(&groups, &last));
            both.unwrap_or_else(|| last.iter().map(|name| (*name).to_owned()).collect())
        }
    }
}

/// The names of a line that has one more or one less than the rows have fields: a last column that rows leave out, or numbers of rows before the first.
fn of_other_width(dialect: &Dialect, line: &Line<'_>, row: &Line<'_>) -> Option<Vec<String>> {
    let mut names: Vec<String> = dialect.fields(line.text).into_iter().map(str::to_owned).collect();
    let known = names.iter().filter(|name| is_known(name)).count();
    let is_counted = || dialect.fields(row.text).first().is_some_and(|field| field.parse::<u64>().is_ok());
    if names.len() == dialect.width + 1 && known > 1 && names.last().is_some_and(|name| !is_known(name)) {
        names.pop();
        Some(names)
    } else if names.len() + 1 == dialect.width && known > 1 && is_counted() {
        names.insert(0, "row".to_owned());
        Some(names)
    } else {
        None
    }
}

/// The names in two rows, where the lower alone do not tell the columns apart: `,X,,Y,` or `,X,X,Y,Y` over `t,set,act,set,act`. A group without a name
/// is the one before it.
fn in_two_rows(groups: &[&str], names: &[&str]) -> Option<Vec<String>> {
    let is_number = |group: &&str| group.parse::<f64>().is_ok();
    if !repeats(names) || groups.iter().any(is_number) {
        return None;
    }
    let over = groups.iter().scan("", |over, group| {
        *over = if group.is_empty() { *over } else { group };
        Some(*over)
    });
    let both: Vec<String> = over.zip(names).map(|(over, name)| format!("{over} {name}").trim().to_owned()).collect();
    let known = names.iter().filter(|name| is_known(name)).count();
    (!repeats(&both) && both.iter().filter(|name| is_known(name)).count() > known).then_some(both)
}

/// Whether a name comes twice.
fn repeats<T: Eq + Hash>(names: &[T]) -> bool {
    names.iter().collect::<HashSet<_>>().len() < names.len()
}

/// Whether a row is a header of the same columns in another order: the rows behind it would be taken for those before it.
pub(super) fn is_other_header(dialect: &Dialect, names: &[String], row: &str) -> bool {
    let is_name = |byte: &u8| byte.is_ascii_alphabetic();
    // Most rows hold numbers alone.
    if !row.as_bytes().iter().any(is_name) {
        return false;
    }
    let fields = dialect.fields(row);
    let fields = &fields[..fields.len().min(names.len())];
    let is_known = |field: &&str| dialect.plain_number(field).is_none() && names.iter().any(|name| name == field);
    fields.len() == names.len() && fields.iter().all(is_known) && fields.iter().zip(names).any(|(field, name)| field != name)
}

/// What to say of such a row.
pub(super) fn other_header(line: usize) -> String {
    format!("line {line} is a second header, with the columns in another order: cut the file there into one log a run")
}

/// Refuses rows of the wrong width. An incomplete last row, from a stopped recording, is dropped.
fn check_widths(
    path: &Path,
    dialect: &Dialect,
    rows: &mut Vec<Line<'_>>,
    findings: &mut Vec<Finding>,
) -> Result<(), DatasetError> {
    let last = rows.len().saturating_sub(1);
    for (index, row) in rows.iter().enumerate() {
        let fields = dialect.fields(row.text);
        let surplus = fields.iter().skip(dialect.width).any(|field| !field.is_empty());
        if fields.len() < dialect.width && index == last {
            findings.push(Finding::new(
                Severity::Warn,
                Check::Mended,
                format!(
                    "the last row (line {}) is cut off after {} of {} fields; it was left out",
                    row.number,
                    fields.len(),
                    dialect.width
                ),
            ));
        } else if fields.len() < dialect.width || surplus {
            return Err(DatasetError::Ragged {
                path: path.to_owned(),
                line: row.number,
                found: fields.len(),
                expected: dialect.width,
            });
        }
    }
    if !findings.is_empty() {
        rows.pop();
    }
    Ok(())
}

/// Drops a last row of full width whose last number is cut off: it has fewer decimals than in the
/// row before.
fn drop_cut_number(text: &str, dialect: &Dialect, rows: &mut Vec<Line<'_>>, findings: &mut Vec<Finding>) {
    if text.ends_with('\n') || !findings.is_empty() {
        return;
    }
    let decimals = |row: &Line<'_>| {
        let sign = if dialect.decimal_comma { ',' } else { '.' };
        dialect.fields(row.text).last().map_or(0, |field| field.split_once(sign).map_or(0, |(_, after)| after.len()))
    };
    if let [.., before, last] = rows.as_slice()
        && decimals(last) < decimals(before)
    {
        findings.push(Finding::new(
            Severity::Warn,
            Check::Mended,
            format!("the last row (line {}) ends within a number, without a line end; it was left out", last.number),
        ));
        rows.pop();
    }
}

/// The columns; a field that is no number becomes NaN.
fn parse(dialect: &Dialect, rows: &[Line<'_>]) -> Vec<Vec<f64>> {
    let mut columns = vec![Vec::with_capacity(rows.len()); dialect.width];
    for row in rows {
        for (column, field) in columns.iter_mut().zip(dialect.fields(row.text)) {
            column.push(dialect.number(field).unwrap_or(f64::NAN));
        }
    }
    columns
}
