//! LinuxCNC's `halsampler`: blanks between numbers, no header, the word `overrun` where samples were lost.

use std::ops::Range;
use std::path::Path;

use super::LogFormat;
use super::text::{self, Line};
use crate::{Check, DatasetError, Finding, Severity, Table};

/// Text of `halsampler`, with or without its sample numbers (`-t`). Columns are called `1`, `2`, … in the order of the sampler's pins; a
/// mapping names them, on the command line or in a file beside the log.
#[derive(Debug, Clone, Copy)]
pub struct Halsampler;

/// Its output after a buffer overrun.
const OVERRUN: &str = "overrun";

impl LogFormat for Halsampler {
    fn name(&self) -> &'static str {
        "halsampler"
    }

    fn recognises(&self, head: &[u8]) -> bool {
        let Ok(head) = std::str::from_utf8(head) else { return false };
        // The head may end within a line, which is then ignored.
        let whole = head.rfind('\n').map_or(head, |end| &head[..end]);
        let mut lines = whole.lines().map(str::trim).filter(|line| !line.is_empty()).peekable();
        let of_numbers = |line: &str| line.split_whitespace().all(|word| word.parse::<f64>().is_ok());
        lines.peek().is_some() && !whole.contains('\t') && lines.all(|line| line == OVERRUN || of_numbers(line))
    }

    fn read(&self, path: &Path, bytes: Vec<u8>) -> Result<Table, DatasetError> {
        let text = text::decode(&bytes);
        let (lines, _) = text::lines(&text);
        let mut findings = Vec::new();
        let rows = &lines[longest(&lines)];
        if let (Some(lost), Some(first), Some(last)) =
            (lines.iter().find(|line| line.text.trim() == OVERRUN), rows.first(), rows.last())
            && rows.len() < lines.iter().filter(|line| line.text.trim() != OVERRUN).count()
        {
            findings.push(Finding::new(
                Severity::Warn,
                Check::Dropout,
                format!(
                    "samples were lost in line {} (`overrun`); only the longest stretch without loss is used, lines {} to {}; \
                     give `sampler` a larger depth",
                    lost.number, first.number, last.number
                ),
            ));
        }
        let width = rows.first().map_or(0, |row| row.text.split_whitespace().count());
        let mut columns = vec![Vec::with_capacity(rows.len()); width];
        let mut numbers = Vec::with_capacity(rows.len());
        for (index, row) in rows.iter().enumerate() {
            let words: Vec<&str> = row.text.split_whitespace().collect();
            // An interrupted recording ends within a line, or even within a number.
            let last = index + 1 == lines.len().min(rows.len()) && row.number == lines.last().map_or(0, |line| line.number);
            if last && (words.len() < width || !text.ends_with('\n')) {
                findings.push(Finding::new(
                    Severity::Warn,
                    Check::Mended,
                    format!("the last row (line {}) is cut off; it was left out", row.number),
                ));
                break;
            }
            if words.len() != width {
                return Err(DatasetError::Ragged {
                    path: path.to_owned(),
                    line: row.number,
                    found: words.len(),
                    expected: width,
                });
            }
            for (column, word) in columns.iter_mut().zip(words) {
                column.push(word.parse().unwrap_or(f64::NAN));
            }
            numbers.push(row.number);
        }
        let names = (1..=width).map(|column| column.to_string()).collect();
        Ok(Table { names, columns, lines: numbers, period_s: None, findings })
    }
}

/// The longest range of lines between overruns.
fn longest(lines: &[Line<'_>]) -> Range<usize> {
    let mut best = 0..0;
    let mut start = 0;
    for end in 0..=lines.len() {
        if end == lines.len() || lines[end].text.trim() == OVERRUN {
            if end - start > best.len() {
                best = start..end;
            }
            start = end + 1;
        }
    }
    best
}
