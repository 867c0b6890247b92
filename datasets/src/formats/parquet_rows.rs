//! Rows of a Parquet table, a batch at a time. Memory is that of one page a column.

use std::fs::File;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use parquet::column::reader::ColumnReader;
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};

use super::LogFormat;
use super::parquet::{Parquet, check_codec, leaf_of, read_numbers, skip_rows};
use super::rows::Rows;
use crate::{DatasetError, Source, Table};

/// Names of the columns of a Parquet file, without rows, and the number of its rows; `None` for other files.
///
/// # Errors
/// When the file cannot be read or is damaged.
pub(crate) fn parquet_head(path: &Path) -> Result<Option<(Table, usize)>, DatasetError> {
    let mut head = [0; 4];
    let read = File::open(path).and_then(|mut file| std::io::Read::read(&mut file, &mut head));
    let length = read.map_err(|source| DatasetError::io(path, source))?;
    if !Parquet.recognises(&head[..length]) {
        return Ok(None);
    }
    let file = open(path)?;
    let metadata = file.metadata().file_metadata();
    let names: Vec<String> =
        metadata.schema_descr().root_schema().get_fields().iter().map(|field| field.name().to_owned()).collect();
    let rows = usize::try_from(metadata.num_rows()).unwrap_or(0);
    Ok(Some((Table { columns: vec![Vec::new(); names.len()], names, ..Table::default() }, rows)))
}

fn open(path: &Path) -> Result<SerializedFileReader<File>, DatasetError> {
    let file = File::open(path).map_err(|source| DatasetError::io(path, source))?;
    guarded(path, || SerializedFileReader::new(file))
}

/// The reader panics on some damaged footers and pages; the panic becomes an error.
fn guarded<T>(path: &Path, read: impl FnOnce() -> Result<T, ParquetError>) -> Result<T, DatasetError> {
    catch_unwind(AssertUnwindSafe(read))
        .map_err(|_| DatasetError::format(path, "the Parquet file is damaged; copy it again"))?
        .map_err(|error| DatasetError::format(path, error))
}

/// Rows of a Parquet table.
pub(crate) struct ParquetRows {
    path: PathBuf,
    file: SerializedFileReader<File>,
    wanted: Vec<Source>,
    /// Readers of the wanted columns in the row group, where there is one, and the rows that are left in it.
    readers: Vec<ColumnReader>,
    left: usize,
    /// Next row group, and the number of the last row.
    group: usize,
    number: usize,
}

impl ParquetRows {
    /// The rows of `path`.
    ///
    /// # Errors
    /// When the file cannot be read or is damaged.
    pub fn open(path: &Path, wanted: &[Source]) -> Result<Self, DatasetError> {
        let (path, wanted) = (path.to_owned(), wanted.to_vec());
        let file = open(&path)?;
        Ok(Self { path, file, wanted, readers: Vec::new(), left: 0, group: 0, number: 0 })
    }

    /// Opens the next row group with rows; whether there is one.
    fn next_group(&mut self) -> Result<bool, DatasetError> {
        while self.left == 0 && self.group < self.file.num_row_groups() {
            let (file, wanted, index) = (&self.file, &self.wanted, self.group);
            let opened = guarded(&self.path, || {
                let group = file.get_row_group(index)?;
                let schema = file.metadata().file_metadata().schema_descr();
                let reader = |wanted: &Source| {
                    let leaf = leaf_of(schema, wanted.column)
                        .ok_or_else(|| ParquetError::General(format!("column {} is not of numbers", wanted.column + 1)))?;
                    check_codec(group.metadata(), leaf)?;
                    group.get_column_reader(leaf)
                };
                let readers = wanted.iter().map(reader).collect::<Result<Vec<_>, _>>()?;
                Ok((readers, usize::try_from(group.metadata().num_rows()).unwrap_or(0)))
            });
            (self.readers, self.left) = opened?;
            self.group += 1;
        }
        Ok(self.left > 0)
    }
}

impl Rows for ParquetRows {
    fn read(&mut self, most: usize, columns: &mut [Vec<f64>], lines: &mut Vec<usize>) -> Result<usize, DatasetError> {
        if most == 0 || !self.next_group()? {
            return Ok(0);
        }
        let rows = most.min(self.left);
        let (file, wanted, readers) = (&self.file, &self.wanted, &mut self.readers);
        guarded(&self.path, || {
            let schema = file.metadata().file_metadata().schema_descr();
            for ((wanted, reader), column) in wanted.iter().zip(readers).zip(columns) {
                let (leaf, from) = (leaf_of(schema, wanted.column).unwrap_or_default(), column.len());
                read_numbers(reader, &schema.column(leaf), rows, column)?;
                if column.len() != from + rows {
                    return Err(ParquetError::General(format!("column {} is shorter than stated", wanted.column + 1)));
                }
                column[from..].iter_mut().for_each(|value| *value *= wanted.scale);
            }
            Ok(())
        })?;
        lines.extend(self.number + 1..=self.number + rows);
        self.left -= rows;
        self.number += rows;
        Ok(rows)
    }

    fn skip(&mut self, rows: usize) -> Result<(), DatasetError> {
        let mut rows = rows;
        while rows > 0 && self.next_group()? {
            let some = rows.min(self.left);
            let readers = &mut self.readers;
            guarded(&self.path, || readers.iter_mut().try_for_each(|reader| skip_rows(reader, some)))?;
            self.left -= some;
            self.number += some;
            rows -= some;
        }
        Ok(())
    }

    fn cut_off(&self) -> Option<&str> {
        None
    }
}
