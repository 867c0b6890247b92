//! Parquet tables.

use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use polars::prelude::{DataType, ParquetReader, SerReader};

use super::LogFormat;
use crate::{DatasetError, Table};

/// Parquet files with one column of numbers a signal; columns of other types are kept as empty.
#[derive(Debug, Clone, Copy)]
pub struct Parquet;

impl LogFormat for Parquet {
    fn name(&self) -> &'static str {
        "Parquet"
    }

    fn recognises(&self, head: &[u8]) -> bool {
        head.starts_with(b"PAR1")
    }

    fn read(&self, path: &Path, bytes: Vec<u8>) -> Result<Table, DatasetError> {
        let failed = |error: polars::error::PolarsError| DatasetError::format(path, error);
        if bytes.len() < 12 || !bytes.ends_with(b"PAR1") {
            return Err(DatasetError::format(path, "the Parquet file is cut off: its footer is missing; copy it again"));
        }
        // The reader panics on some damaged footers and pages; a damaged file is to be an error like any other.
        let frame = catch_unwind(AssertUnwindSafe(|| ParquetReader::new(Cursor::new(bytes)).finish()))
            .map_err(|_| DatasetError::format(path, "the Parquet file is damaged; copy it again"))?
            .map_err(failed)?;
        let mut table = Table { lines: (1..=frame.height()).collect(), ..Table::default() };
        for column in frame.columns() {
            let values = if column.dtype().is_primitive_numeric() {
                column
                    .cast(&DataType::Float64)
                    .map_err(failed)?
                    .f64()
                    .map_err(failed)?
                    .iter()
                    .map(|value| value.unwrap_or(f64::NAN))
                    .collect()
            } else {
                vec![f64::NAN; frame.height()]
            };
            table.names.push(column.name().to_string());
            table.columns.push(values);
        }
        Ok(table)
    }
}
