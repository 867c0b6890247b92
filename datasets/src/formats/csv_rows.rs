//! Rows of a text table, a batch at a time: as [`Csv`](super::Csv) reads them, without holding the file.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use super::csv::{is_other_header, other_header};
use super::dialect::Dialect;
use super::rows::Rows;
use super::text::{self, COMMENTS};
use super::{Csv, LogFormat, format_of};
use crate::{DatasetError, Source, Table};

/// Length of the beginning of a file that decides about its columns, bytes.
const HEAD: u64 = 1 << 20;
/// Size of the buffer of the file, bytes.
const BUFFER: usize = 1 << 20;
/// Byte-order mark of UTF-8.
const MARK: &[u8] = b"\xEF\xBB\xBF";

/// What the beginning of a text table says.
#[derive(Debug, Clone)]
pub(crate) struct CsvHead {
    /// Names, and the rows of the beginning.
    pub table: Table,
    /// Estimated number of rows of the whole file.
    pub rows: usize,
    dialect: Dialect,
    /// Number of the first line of data.
    first: usize,
}

impl CsvHead {
    /// The beginning of `path`; `None` for other formats, for UTF-16, and for files that are not much longer than a beginning.
    ///
    /// # Errors
    /// When the file cannot be read, or its beginning violates the format.
    pub fn of(path: &Path) -> Result<Option<Self>, DatasetError> {
        let failed = |source| DatasetError::io(path, source);
        let file = File::open(path).map_err(failed)?;
        let length = file.metadata().map_err(failed)?.len();
        let mut bytes = Vec::new();
        file.take(HEAD).read_to_end(&mut bytes).map_err(failed)?;
        let is_text = format_of(&bytes).is_some_and(|format| format.name() == Csv.name());
        let is_utf16 = text::is_utf16(&bytes);
        let Some(end) = bytes.iter().rposition(|byte| *byte == b'\n') else { return Ok(None) };
        if !is_text || is_utf16 || length < 2 * HEAD {
            return Ok(None);
        }
        bytes.truncate(end + 1);
        let text = text::decode(&bytes);
        let (lines, _) = text::lines(&text);
        let dialect = Dialect::sniff(&lines);
        let first = lines.iter().find(|line| dialect.is_data(line.text)).map(|line| line.number);
        let rows = (lines.len() as f64 * length as f64 / bytes.len() as f64) as usize;
        let table = Csv.read(path, bytes)?;
        Ok(first.map(|first| Self { table, rows, dialect, first }))
    }
}

/// Rows of a text table.
pub(crate) struct CsvRows {
    path: PathBuf,
    reader: BufReader<File>,
    dialect: Dialect,
    names: Vec<String>,
    /// Slot of every column of the file among those that are wanted, with its scale.
    slots: Vec<Option<(usize, f64)>>,
    /// Values of a row.
    values: Vec<f64>,
    /// The last line and the row before it, and the number of the line.
    line: Vec<u8>,
    before: Vec<u8>,
    number: usize,
    cut_off: Option<String>,
}

impl CsvRows {
    /// The rows of `path`, whose beginning is `head`.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn open(path: &Path, head: &CsvHead, wanted: &[Source]) -> Result<Self, DatasetError> {
        let file = File::open(path).map_err(|source| DatasetError::io(path, source))?;
        let width = head.dialect.width;
        let mut slots = vec![None; width];
        for (slot, wanted) in wanted.iter().enumerate() {
            let place = slots.get_mut(wanted.column).filter(|place| place.is_none());
            let why = || DatasetError::format(path, format!("there is no column {}, or it is named twice", wanted.column + 1));
            *place.ok_or_else(why)? = Some((slot, wanted.scale));
        }
        let mut rows = Self {
            path: path.to_owned(),
            reader: BufReader::with_capacity(BUFFER, file),
            dialect: head.dialect.clone(),
            names: head.table.names.clone(),
            slots,
            values: vec![f64::NAN; wanted.len()],
            line: Vec::new(),
            before: Vec::new(),
            number: 0,
            cut_off: None,
        };
        while rows.number + 1 < head.first && rows.next_line()? {}
        Ok(rows)
    }

    /// Reads the next line; whether there is one.
    fn next_line(&mut self) -> Result<bool, DatasetError> {
        self.line.clear();
        let read = self.reader.read_until(b'\n', &mut self.line).map_err(|source| DatasetError::io(&self.path, source))?;
        self.number += usize::from(read > 0);
        if self.number == 1 && self.line.starts_with(MARK) {
            self.line.drain(..MARK.len());
        }
        Ok(read > 0)
    }

    /// Reads the next line with content; whether there is one.
    fn next_row(&mut self) -> Result<bool, DatasetError> {
        std::mem::swap(&mut self.line, &mut self.before);
        while self.next_line()? {
            let start =
                self.line.iter().position(|byte| !matches!(byte, b' ' | b'\r' | b'\n' | b'\t')).unwrap_or(self.line.len());
            let content = &self.line[start..];
            let is_comment = COMMENTS.iter().any(|mark| content.starts_with(mark.as_bytes()));
            if !content.is_empty() && !is_comment && !self.dialect.has_remark(content) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Takes the values of the line; the number of its fields where that is not the right one.
    fn parse(&mut self) -> Result<(), usize> {
        let line = String::from_utf8_lossy(&self.line);
        let line = trimmed(&line);
        let (mut count, mut surplus) = (0, false);
        let (slots, values, dialect) = (&self.slots, &mut self.values, &self.dialect);
        dialect.each_field(line, |field| {
            if let Some(Some((slot, scale))) = slots.get(count) {
                values[*slot] = dialect.number(field).map_or(f64::NAN, |value| value * scale);
            }
            surplus |= count >= slots.len() && !field.is_empty();
            count += 1;
        });
        if count < slots.len() || surplus { Err(count) } else { Ok(()) }
    }

    /// Leaves out a last row with too few fields; any other row of another width is refused.
    fn end_at(&mut self, found: usize) -> Result<(), DatasetError> {
        let (line, expected) = (self.number, self.slots.len());
        if found >= expected || self.next_row()? {
            return Err(DatasetError::Ragged { path: self.path.clone(), line, found, expected });
        }
        self.cut_off = Some(format!("the last row (line {line}) is cut off after {found} of {expected} fields; it was left out"));
        Ok(())
    }

    /// Whether the line is the end of a file and its last number has fewer decimals than that of the row before.
    fn ends_within_a_number(&self) -> bool {
        let sign = if self.dialect.decimal_comma { ',' } else { '.' };
        let decimals = |line: &[u8]| {
            let line = String::from_utf8_lossy(line);
            let fields = self.dialect.fields(trimmed(&line));
            fields.last().map_or(0, |field| field.split_once(sign).map_or(0, |(_, after)| after.len()))
        };
        !self.line.ends_with(b"\n") && !self.before.is_empty() && decimals(&self.line) < decimals(&self.before)
    }
}

fn trimmed(line: &str) -> &str {
    line.trim_matches([' ', '\r', '\n'])
}

impl Rows for CsvRows {
    fn read(&mut self, most: usize, columns: &mut [Vec<f64>], lines: &mut Vec<usize>) -> Result<usize, DatasetError> {
        let mut rows = 0;
        while rows < most && self.cut_off.is_none() && self.next_row()? {
            if let Err(found) = self.parse() {
                self.end_at(found)?;
                break;
            }
            if self.ends_within_a_number() {
                let number = self.number;
                let why = format!("the last row (line {number}) ends within a number, without a line end; it was left out");
                self.cut_off = Some(why);
                break;
            }
            if self.values.iter().all(|value| value.is_nan())
                && is_other_header(&self.dialect, &self.names, trimmed(&String::from_utf8_lossy(&self.line)))
            {
                return Err(DatasetError::format(&self.path, other_header(self.number)));
            }
            columns.iter_mut().zip(&self.values).for_each(|(column, value)| column.push(*value));
            lines.push(self.number);
            rows += 1;
        }
        Ok(rows)
    }

    fn skip(&mut self, rows: usize) -> Result<(), DatasetError> {
        for _ in 0..rows {
            if !self.next_row()? {
                break;
            }
        }
        Ok(())
    }

    fn cut_off(&self) -> Option<&str> {
        self.cut_off.as_deref()
    }
}
