//! Named arrays of numbers, as numerical packages store them, as a table.

use std::collections::BTreeMap;
use std::path::Path;

use crate::columns::{is_known, is_own_clock};
use crate::{Check, DatasetError, Finding, Severity, Table};

/// Numbers that are read of a file at most: 2 GiB.
pub(super) const MOST_NUMBERS: usize = 1 << 28;
/// Columns of a matrix at most; one of more is no record of signals.
pub(super) const MOST_COLUMNS: usize = 4096;

/// Numbers of the arrays that were read so far.
pub(super) fn count(arrays: &[Array]) -> usize {
    arrays.iter().flat_map(|array| &array.columns).map(Vec::len).sum()
}

/// An array of a file: a vector, or a matrix with one signal a column.
pub(super) struct Array {
    pub name: String,
    /// Columns of equal length; none of a matrix that is no record of signals.
    pub columns: Vec<Vec<f64>>,
}

impl Array {
    fn rows(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }

    /// A vector, or a matrix whose numbers lie column by column.
    pub(super) fn by_columns(name: String, values: &[f64], rows: usize) -> Self {
        let rows = rows.max(1);
        let fits = values.len() / rows <= MOST_COLUMNS;
        Self { name, columns: values.chunks_exact(rows).filter(|_| fits).map(<[f64]>::to_vec).collect() }
    }

    /// A vector, or a matrix whose numbers lie row by row.
    pub(super) fn by_rows(name: String, values: &[f64], columns: usize) -> Self {
        let column = |index: usize| values.iter().skip(index).step_by(columns).copied().collect();
        Self { name, columns: (0..columns).filter(|_| columns <= MOST_COLUMNS).map(column).collect() }
    }
}

/// The arrays of a file as one table: those of the length that most signals have, longest first. Where names tell that channels have clocks of
/// their own, vectors whose names are known may be of other lengths, and shorter ones end with NaN. The others are named in a finding.
///
/// # Errors
/// When no array has two numbers.
pub(super) fn table(path: &Path, arrays: Vec<Array>) -> Result<Table, DatasetError> {
    let mut signals: BTreeMap<usize, usize> = BTreeMap::new();
    for array in &arrays {
        *signals.entry(array.columns.first().map_or(0, Vec::len)).or_default() += array.columns.len();
    }
    let usual = signals.into_iter().filter(|(length, _)| *length > 1).max_by_key(|(length, count)| (*count, *length));
    let Some((length, _)) = usual else {
        return Err(DatasetError::format(
            path,
            "it holds no array of numbers; store time, commanded and actual positions as vectors",
        ));
    };
    let has_own_clocks = arrays.iter().any(|array| is_own_clock(&array.name));
    let is_usual = |array: &Array| array.columns.first().is_some_and(|column| column.len() == length);
    let is_channel = |array: &Array| has_own_clocks && array.columns.len() == 1 && is_known(&array.name);
    let longest = arrays.iter().filter(|array| is_usual(array) || is_channel(array)).map(Array::rows).max().unwrap_or(length);
    let columns: usize = arrays.iter().map(|array| array.columns.len()).sum();
    let fits = longest.saturating_mul(columns) <= MOST_NUMBERS;
    let length = if fits { longest } else { length };
    let (taken, left): (Vec<Array>, Vec<Array>) =
        arrays.into_iter().partition(|array| is_usual(array) || (fits && is_channel(array)));
    let mut table = Table { lines: (1..=length).collect(), ..Table::default() };
    if !left.is_empty() {
        let names: Vec<&str> = left.iter().map(|array| array.name.as_str()).collect();
        let message = format!(
            "arrays of another length than {length}, or of more than {MOST_COLUMNS} columns, are left out: {}",
            names.join(", ")
        );
        table.findings.push(Finding::new(Severity::Note, Check::Mended, message));
    }
    for Array { name, columns } in taken {
        let single = columns.len() == 1;
        for (index, mut column) in columns.into_iter().enumerate() {
            column.resize(length, f64::NAN);
            table.names.push(if single { name.clone() } else { format!("{name}.{}", index + 1) });
            table.columns.push(column);
        }
    }
    Ok(table)
}

/// A number type of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Number {
    F64,
    F32,
    I64,
    U64,
    I32,
    U32,
    I16,
    U16,
    I8,
    U8,
}

impl Number {
    /// Bytes of a number.
    pub(super) const fn bytes(self) -> usize {
        match self {
            Self::F64 | Self::I64 | Self::U64 => 8,
            Self::F32 | Self::I32 | Self::U32 => 4,
            Self::I16 | Self::U16 => 2,
            Self::I8 | Self::U8 => 1,
        }
    }

    /// Whole numbers of `bytes`.
    pub(super) fn read(self, bytes: &[u8], is_big_endian: bool) -> Vec<f64> {
        bytes.chunks_exact(self.bytes()).map(|bytes| self.number(bytes, is_big_endian)).collect()
    }

    /// The number of `bytes`.
    pub(super) fn number(self, bytes: &[u8], is_big_endian: bool) -> f64 {
        let mut low_first = [0; 8];
        low_first[..bytes.len()].copy_from_slice(bytes);
        if is_big_endian {
            low_first[..bytes.len()].reverse();
        }
        let [a, b, c, d, ..] = low_first;
        match self {
            Self::F64 => f64::from_le_bytes(low_first),
            Self::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Self::I64 => i64::from_le_bytes(low_first) as f64,
            Self::U64 => u64::from_le_bytes(low_first) as f64,
            Self::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Self::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            Self::I16 => f64::from(i16::from_le_bytes([a, b])),
            Self::U16 => f64::from(u16::from_le_bytes([a, b])),
            Self::I8 => f64::from(i8::from_le_bytes([a])),
            Self::U8 => f64::from(a),
        }
    }
}
