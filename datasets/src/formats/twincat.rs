//! TwinCAT Scope's text export: a header of key and value for every channel, then rows of time and value.

use std::path::Path;

use super::LogFormat;
use super::text::{self, Line};
use crate::{Check, DatasetError, Finding, Severity, Table};

/// TwinCAT Scope View CSV: tab, semicolon or comma between fields, decimal point or comma, with a time column for each channel or for
/// each sampling time.
#[derive(Debug, Clone, Copy)]
pub struct TwincatScope;

/// Key of the row that states every channel's sampling time; no other format has it.
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
        let separator = separator(&lines);
        let fields = |line: &Line<'_>| -> Vec<String> {
            line.text.split(separator).map(|field| field.trim().trim_matches('"').trim().to_owned()).collect()
        };
        let number = |field: &str| -> f64 {
            let point = if separator == ',' { field.to_owned() } else { field.replace(',', ".") };
            point.parse().unwrap_or(f64::NAN)
        };
        let broken = |message: String| DatasetError::format(path, message);
        let rates = lines.iter().position(|line| line.text.trim_matches('"').starts_with(SAMPLE_TIME)).unwrap_or_default();
        // The scope itself has a name, too, further up.
        let named = lines[..rates].iter().rposition(|line| fields(line).first().is_some_and(|key| key == "Name"));
        let labels = named.map(|row| fields(&lines[row])).ok_or_else(|| broken("no row `Name` states the channels".into()))?;
        let units = lines.iter().take(rates + 12).map(fields).find(|row| row.first().is_some_and(|key| key == "Unit"));
        let periods = fields(&lines[rates]);
        let first = rates + 1;
        let data = (first..lines.len())
            .find(|row| {
                let row = fields(&lines[*row]);
                row.len() >= 2 && row.iter().filter(|field| !field.is_empty()).all(|field| number(field).is_finite())
            })
            .ok_or_else(|| broken("no row holds numbers".into()))?;
        let is_time = |index: usize| labels[index] == "Name";
        let (times, channels): (Vec<usize>, Vec<usize>) =
            (0..labels.len()).filter(|index| !labels[*index].is_empty()).partition(|index| is_time(*index));
        let slowest = channels.iter().filter_map(|index| periods.get(*index)).map(|period| number(period)).fold(0.0, f64::max);
        let fastest =
            channels.iter().filter_map(|index| periods.get(*index)).map(|period| number(period)).fold(f64::INFINITY, f64::min);
        if slowest > fastest * 1.000_001 {
            return Err(broken(format!(
                "channels are sampled every {fastest} ms and every {slowest} ms; record all positions in one task"
            )));
        }
        let wanted: Vec<usize> = times.iter().take(1).chain(&channels).copied().collect();
        let mut columns = vec![Vec::new(); wanted.len()];
        let mut numbers = Vec::new();
        let mut findings = Vec::new();
        for line in &lines[data..] {
            let row = fields(line);
            if row.first().is_some_and(|key| key == "EOF") {
                break;
            }
            if row.len() <= *wanted.iter().max().unwrap_or(&0) {
                if line.number < lines.last().map_or(0, |last| last.number) {
                    let expected = labels.len();
                    return Err(DatasetError::Ragged { path: path.to_owned(), line: line.number, found: row.len(), expected });
                }
                let message = format!("the last row (line {}) is cut off; it was left out", line.number);
                findings.push(Finding::new(Severity::Warn, Check::Mended, message));
                break;
            }
            for (column, index) in columns.iter_mut().zip(&wanted) {
                column.push(number(&row[*index]));
            }
            numbers.push(line.number);
        }
        let mut names = Vec::with_capacity(wanted.len());
        if !times.is_empty() {
            if let Some(time) = columns.first_mut()
                && time.first().is_some_and(|first| *first > FILE_TIME)
            {
                let start = time[0];
                time.iter_mut().for_each(|ticks| *ticks = (*ticks - start) * 1e-4);
            }
            names.push("time [ms]".to_owned());
        }
        for index in &channels {
            let unit = units.as_ref().and_then(|units| units.get(*index)).filter(|unit| !unit.is_empty() && *unit != "(None)");
            names.push(unit.map_or_else(|| labels[*index].clone(), |unit| format!("{} {unit}", labels[*index])));
        }
        let period_s = (times.is_empty() && fastest.is_finite() && fastest > 0.0).then_some(fastest * 1e-3);
        Ok(Table { names, columns, lines: numbers, period_s, findings })
    }
}

/// What stands after the first key of the row of sampling times.
fn separator(lines: &[Line<'_>]) -> char {
    let row = lines.iter().find_map(|line| line.text.trim_matches('"').strip_prefix(SAMPLE_TIME));
    row.and_then(|rest| rest.chars().find(|c| ['\t', ';', ','].contains(c))).unwrap_or('\t')
}
