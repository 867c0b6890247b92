//! TwinCAT Scope's text export: a header of key and value for every channel, then rows of time and value.

use std::path::Path;

use super::LogFormat;
use super::text::{self, Line};
use crate::{Check, DatasetError, Finding, Severity, Table};

/// TwinCAT Scope View CSV: tab, semicolon or comma between fields, decimal point or comma, with a time column for each channel, for
/// each sampling time, or none. Columns of channels with other time stamps than those before follow their own time column.
#[derive(Debug, Clone, Copy)]
pub struct TwincatScope;

/// Key of the row with the sampling time of every channel; no other format has it.
const SAMPLE_TIME: &str = "SampleTime[ms]";
/// Keys of the first rows, which tell of the scope.
const FIRST_KEYS: [&str; 3] = ["Name", "File", "Start"];
/// Time stamps from here on are file times: 100 ns since 1601.
const FILE_TIME: f64 = 1e15;

impl LogFormat for TwincatScope {
    fn name(&self) -> &'static str {
        "TwinCAT Scope CSV"
    }

    fn recognises(&self, head: &[u8]) -> bool {
        let head = text::decode(head);
        let mut rows = head.lines().map(|line| line.trim_start_matches('"')).filter(|line| !line.trim().is_empty());
        // With many channels the row of sampling times is far down.
        let first: Vec<&str> = rows.clone().take(FIRST_KEYS.len()).collect();
        let is_scope = first.len() == FIRST_KEYS.len() && first.iter().zip(FIRST_KEYS).all(|(row, key)| row.starts_with(key));
        is_scope || rows.any(|line| line.starts_with(SAMPLE_TIME))
    }

    fn read(&self, path: &Path, bytes: Vec<u8>) -> Result<Table, DatasetError> {
        let text = text::decode(&bytes);
        let (lines, _) = text::lines(&text);
        let fields = Fields { separator: separator(&lines) };
        let header = Header::find(path, &lines, fields)?;
        let wanted: Vec<usize> = header.columns().collect();
        let mut rows = Rows { columns: vec![Vec::new(); wanted.len()], lines: Vec::new(), findings: Vec::new() };
        let places: Vec<usize> = wanted.iter().map(|index| header.place(*index)).collect();
        rows.fill(path, &lines, header.data, fields, &places, header.labels.len())?;
        let Rows { columns, lines, findings } = rows;
        let groups = header.groups(&wanted, columns);
        let has_times = groups.iter().any(|(time, _)| time.is_some());
        let period_s = if has_times { None } else { header.common_period_s(path, fields)? };
        let mut table = Table { lines, period_s, findings, ..Table::default() };
        let mut start = None;
        for (time, channels) in groups {
            let (time, channels) = compact(time, channels);
            if let Some(mut time) = time {
                let first = *start.get_or_insert(time.first().copied().unwrap_or_default());
                if first > FILE_TIME {
                    time.iter_mut().for_each(|ticks| *ticks = (*ticks - first) * 1e-4);
                }
                let last = table.names.iter().rposition(|name| name == TIME).map(|index| &table.columns[index]);
                if last.is_none_or(|last| !is_same(last, &time)) {
                    table.names.push(TIME.to_owned());
                    table.columns.push(time);
                }
            }
            for (index, column) in channels {
                table.names.push(header.name(index));
                table.columns.push(column);
            }
        }
        Ok(table)
    }
}

/// Name of a column of time stamps.
const TIME: &str = "time [ms]";

/// A column of time stamps, if there are any, and the channels with these stamps by their index in the file.
type Group = (Option<Vec<f64>>, Vec<(usize, Vec<f64>)>);

/// The group with its empty rows at the end: where rows are of one instant, a slower channel has none in most of them.
fn compact(time: Option<Vec<f64>>, channels: Vec<(usize, Vec<f64>)>) -> Group {
    let Some(time) = time else { return (None, channels) };
    let kept: Vec<usize> = (0..time.len()).filter(|row| !time[*row].is_nan()).collect();
    if kept.len() == time.len() {
        return (Some(time), channels);
    }
    let packed = |column: &[f64]| {
        let values = kept.iter().map(|row| column[*row]);
        values.chain(std::iter::repeat(f64::NAN)).take(column.len()).collect()
    };
    let channels = channels.iter().map(|(index, column)| (*index, packed(column))).collect();
    (Some(packed(&time)), channels)
}

/// Whether two columns hold the same numbers, empty fields included.
fn is_same(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a == b || a.is_nan() && b.is_nan())
}

/// Separators of fields and decimals.
#[derive(Clone, Copy)]
struct Fields {
    separator: char,
}

impl Fields {
    fn of(self, line: &Line<'_>) -> Vec<String> {
        line.text.split(self.separator).map(|field| field.trim().trim_matches('"').trim().to_owned()).collect()
    }

    /// A number with a decimal point, or with a decimal comma if commas do not separate fields.
    fn number(self, field: &str) -> f64 {
        let point = if self.separator == ',' { field.to_owned() } else { field.replace(',', ".") };
        point.parse().unwrap_or(f64::NAN)
    }
}

/// Content of the rows before the data.
struct Header {
    labels: Vec<String>,
    units: Option<Vec<String>>,
    /// Sampling time of each channel, ms, as written.
    periods: Vec<String>,
    /// The first row of numbers.
    data: usize,
    /// Indices of the columns of time, and of those of the channels.
    times: Vec<usize>,
    channels: Vec<usize>,
}

impl Header {
    fn find(path: &Path, lines: &[Line<'_>], fields: Fields) -> Result<Self, DatasetError> {
        let broken = |message: &str| DatasetError::format(path, message);
        let is_data = |line: &Line<'_>| {
            let row = fields.of(line);
            let mut filled = row.iter().filter(|field| !field.is_empty()).peekable();
            row.len() >= 2 && filled.peek().is_some() && filled.all(|field| fields.number(field).is_finite())
        };
        let data = lines.iter().position(is_data).ok_or_else(|| broken("no row holds numbers"))?;
        let head: Vec<Vec<String>> = lines[..data].iter().map(|line| fields.of(line)).collect();
        // The scope itself has a name, too, in an earlier row.
        let row = |key: &str| head.iter().rfind(|row| row.first().is_some_and(|first| first == key)).cloned();
        let labels = row("Name").ok_or_else(|| broken("no row `Name` states the channels"))?;
        let (units, periods) = (row("Unit"), row(SAMPLE_TIME).unwrap_or_default());
        let (mut times, channels): (Vec<usize>, Vec<usize>) =
            (0..labels.len()).filter(|index| !labels[*index].is_empty()).partition(|index| labels[*index] == "Name");
        let width = fields.of(&lines[data]).iter().rposition(|field| !field.is_empty()).map_or(0, |last| last + 1);
        if width == channels.len() && channels.iter().any(|index| *index >= width) {
            // Values without times under a header that has room for them.
            times.clear();
        }
        Ok(Self { units, periods, data, times, channels, labels })
    }

    /// Sampling period of all channels, s, where it is stated.
    ///
    /// # Errors
    /// When the channels have several.
    fn common_period_s(&self, path: &Path, fields: Fields) -> Result<Option<f64>, DatasetError> {
        let stated = || self.channels.iter().filter_map(|index| self.periods.get(*index)).map(|period| fields.number(period));
        let (fastest, slowest) = (stated().fold(f64::INFINITY, f64::min), stated().fold(0.0, f64::max));
        if slowest > fastest * 1.000_001 {
            let message = format!(
                "channels are sampled every {fastest} ms and every {slowest} ms, and there are no time stamps; record all positions in one task, or \
                 export with `Timelines: All`"
            );
            return Err(DatasetError::format(path, message));
        }
        Ok((fastest.is_finite() && fastest > 0.0).then_some(fastest * 1e-3))
    }

    /// Place in a row of numbers of the column that is at this index of the header.
    fn place(&self, index: usize) -> usize {
        let among_channels = || self.channels.iter().position(|channel| *channel == index);
        if self.times.is_empty() { among_channels().unwrap_or(index) } else { index }
    }

    /// Indices of the columns of time and of the channels, in the order of the header.
    fn columns(&self) -> impl Iterator<Item = usize> {
        (0..self.labels.len()).filter(|index| self.times.contains(index) || self.channels.contains(index))
    }

    /// The channels with their time stamps, each column of which is before its channels.
    fn groups(&self, wanted: &[usize], columns: Vec<Vec<f64>>) -> Vec<Group> {
        let mut groups: Vec<Group> = Vec::new();
        for (index, column) in wanted.iter().zip(columns) {
            if self.times.contains(index) {
                // A column of time without any stamp is only the header's.
                groups.push((column.iter().any(|time| !time.is_nan()).then_some(column), Vec::new()));
            } else if let Some((_, channels)) = groups.last_mut() {
                channels.push((*index, column));
            } else {
                groups.push((None, vec![(*index, column)]));
            }
        }
        groups
    }

    /// Name of a channel, with its unit.
    fn name(&self, index: usize) -> String {
        let unit = self.units.as_ref().and_then(|units| units.get(index)).filter(|unit| !unit.is_empty() && *unit != "(None)");
        unit.map_or_else(|| self.labels[index].clone(), |unit| format!("{} {unit}", self.labels[index]))
    }
}

/// The rows of numbers.
struct Rows {
    columns: Vec<Vec<f64>>,
    lines: Vec<usize>,
    findings: Vec<Finding>,
}

impl Rows {
    /// Reads the `wanted` columns from line `first` on; an incomplete last row is dropped.
    fn fill(
        &mut self,
        path: &Path,
        lines: &[Line<'_>],
        first: usize,
        fields: Fields,
        wanted: &[usize],
        expected: usize,
    ) -> Result<(), DatasetError> {
        for line in &lines[first..] {
            let row = fields.of(line);
            if row.first().is_some_and(|key| key == "EOF") {
                break;
            }
            if row.len() <= *wanted.iter().max().unwrap_or(&0) {
                if line.number < lines.last().map_or(0, |last| last.number) {
                    return Err(DatasetError::Ragged { path: path.to_owned(), line: line.number, found: row.len(), expected });
                }
                let message = format!("the last row (line {}) is cut off; it was left out", line.number);
                self.findings.push(Finding::new(Severity::Warn, Check::Mended, message));
                break;
            }
            for (column, index) in self.columns.iter_mut().zip(wanted) {
                column.push(fields.number(&row[*index]));
            }
            self.lines.push(line.number);
        }
        Ok(())
    }
}

/// The character after a key: of the row of sampling times, or of the first row.
fn separator(lines: &[Line<'_>]) -> char {
    let key = |key: &str| lines.iter().find_map(|line| line.text.trim_start_matches('"').strip_prefix(key));
    key(SAMPLE_TIME)
        .or_else(|| key(FIRST_KEYS[0]))
        .and_then(|rest| rest.chars().find(|c| ['\t', ';', ','].contains(c)))
        .unwrap_or('\t')
}
