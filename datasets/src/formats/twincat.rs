//! TwinCAT Scope's text export: a header of key and value for every channel, then rows of time and value.

use std::path::Path;

use super::LogFormat;
use super::text::{self, Line};
use crate::{Check, DatasetError, Finding, Severity, Table};

/// TwinCAT Scope View CSV: tab, semicolon or comma between fields, decimal point or comma, with a time column for each channel or for
/// each sampling time.
#[derive(Debug, Clone, Copy)]
pub struct TwincatScope;

/// Key of the row with the sampling time of every channel; no other format has it.
const SAMPLE_TIME: &str = "SampleTime[ms]";
/// Time stamps from here on are file times: 100 ns since 1601.
const FILE_TIME: f64 = 1e15;

impl LogFormat for TwincatScope {
    fn name(&self) -> &'static str {
        "TwinCAT Scope CSV"
    }

    fn recognises(&self, head: &[u8]) -> bool {
        text::decode(head).lines().any(|line| line.trim_start_matches('"').starts_with(SAMPLE_TIME))
    }

    fn read(&self, path: &Path, bytes: Vec<u8>) -> Result<Table, DatasetError> {
        let text = text::decode(&bytes);
        let (lines, _) = text::lines(&text);
        let fields = Fields { separator: separator(&lines) };
        let header = Header::find(path, &lines, fields)?;
        let fastest_ms = header.common_period_ms(path, fields)?;
        let wanted: Vec<usize> = header.times.iter().take(1).chain(&header.channels).copied().collect();
        let mut rows = Rows { columns: vec![Vec::new(); wanted.len()], lines: Vec::new(), findings: Vec::new() };
        rows.fill(path, &lines, header.data, fields, &wanted, header.labels.len())?;
        let Rows { mut columns, lines, findings } = rows;
        let timed = !header.times.is_empty();
        if timed
            && let Some(time) = columns.first_mut()
            && time.first().is_some_and(|first| *first > FILE_TIME)
        {
            let start = time[0];
            time.iter_mut().for_each(|ticks| *ticks = (*ticks - start) * 1e-4);
        }
        let period_s = (!timed && fastest_ms.is_finite() && fastest_ms > 0.0).then_some(fastest_ms * 1e-3);
        Ok(Table { names: header.names(), columns, lines, period_s, findings })
    }
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
        let rates = lines.iter().position(|line| line.text.trim_matches('"').starts_with(SAMPLE_TIME)).unwrap_or_default();
        // The scope itself has a name, too, in an earlier row.
        let named = lines[..rates].iter().rposition(|line| fields.of(line).first().is_some_and(|key| key == "Name"));
        let labels = named.map(|row| fields.of(&lines[row])).ok_or_else(|| broken("no row `Name` states the channels"))?;
        let mut head = lines.iter().take(rates + 12).map(|line| fields.of(line));
        let units = head.find(|row| row.first().is_some_and(|key| key == "Unit"));
        let is_data = |row: &usize| {
            let row = fields.of(&lines[*row]);
            row.len() >= 2 && row.iter().filter(|field| !field.is_empty()).all(|field| fields.number(field).is_finite())
        };
        let data = (rates + 1..lines.len()).find(is_data).ok_or_else(|| broken("no row holds numbers"))?;
        let (times, channels) =
            (0..labels.len()).filter(|index| !labels[*index].is_empty()).partition(|index| labels[*index] == "Name");
        Ok(Self { units, periods: fields.of(&lines[rates]), data, times, channels, labels })
    }

    /// Sampling time of all channels, ms; infinite if not stated.
    fn common_period_ms(&self, path: &Path, fields: Fields) -> Result<f64, DatasetError> {
        let stated = || self.channels.iter().filter_map(|index| self.periods.get(*index)).map(|period| fields.number(period));
        let (fastest, slowest) = (stated().fold(f64::INFINITY, f64::min), stated().fold(0.0, f64::max));
        if slowest > fastest * 1.000_001 {
            let message =
                format!("channels are sampled every {fastest} ms and every {slowest} ms; record all positions in one task");
            return Err(DatasetError::format(path, message));
        }
        Ok(fastest)
    }

    /// Names of the columns to read: time, if any, then the channels with their units.
    fn names(&self) -> Vec<String> {
        let time = (!self.times.is_empty()).then(|| "time [ms]".to_owned());
        let channel = |index: &usize| {
            let units = self.units.as_ref();
            let unit = units.and_then(|units| units.get(*index)).filter(|unit| !unit.is_empty() && *unit != "(None)");
            unit.map_or_else(|| self.labels[*index].clone(), |unit| format!("{} {unit}", self.labels[*index]))
        };
        time.into_iter().chain(self.channels.iter().map(channel)).collect()
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

/// The character after the first key of the row of sampling times.
fn separator(lines: &[Line<'_>]) -> char {
    let row = lines.iter().find_map(|line| line.text.trim_matches('"').strip_prefix(SAMPLE_TIME));
    row.and_then(|rest| rest.chars().find(|c| ['\t', ';', ','].contains(c))).unwrap_or('\t')
}
