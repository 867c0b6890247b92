//! Parquet tables.

use std::fs::File;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Arc;

use bytes::Bytes;
use parquet::basic::{Compression, ConvertedType, LogicalType, Repetition, TimeUnit, Type as Physical, ZstdLevel};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{DataType, DoubleType};
use parquet::errors::ParquetError;
use parquet::file::metadata::RowGroupMetaData;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{ColumnDescriptor, SchemaDescriptor, Type};

use super::LogFormat;
use crate::{DatasetError, Table};

/// Number of values read from a column at once.
const BATCH: usize = 1 << 16;

/// Parquet files with one numeric column per signal, or one of points in time, in s; columns of other types are kept empty.
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
        if bytes.len() < 12 || !bytes.ends_with(b"PAR1") {
            return Err(DatasetError::format(path, "the Parquet file is cut off: its footer is missing; copy it again"));
        }
        // The reader panics on some damaged footers and pages; the panic becomes an error.
        catch_unwind(AssertUnwindSafe(|| read(Bytes::from(bytes))))
            .map_err(|_| DatasetError::format(path, "the Parquet file is damaged; copy it again"))?
            .map_err(|error| DatasetError::format(path, error))
    }
}

fn read(bytes: Bytes) -> Result<Table, ParquetError> {
    let file = SerializedFileReader::new(bytes)?;
    let schema = file.metadata().file_metadata().schema_descr_ptr();
    let mut table = Table::default();
    let mut rows = None;
    for (index, field) in schema.root_schema().get_fields().iter().enumerate() {
        let mut values = Vec::new();
        if let Some(leaf) = leaf_of(&schema, index) {
            for group in 0..file.num_row_groups() {
                check_codec(file.metadata().row_group(group), leaf)?;
                let mut reader = file.get_row_group(group)?.get_column_reader(leaf)?;
                while read_numbers(&mut reader, &schema.column(leaf), BATCH, &mut values)? > 0 {}
            }
            if *rows.get_or_insert(values.len()) != values.len() {
                return Err(ParquetError::General(format!(
                    "column `{}` is shorter or longer than those before it",
                    field.name()
                )));
            }
        }
        table.names.push(field.name().to_owned());
        table.columns.push(values);
    }
    // The number of rows in the footer is checked against a column.
    let rows = rows.unwrap_or(0);
    table.lines = (1..=rows).collect();
    for column in &mut table.columns {
        column.resize(rows, f64::NAN);
    }
    Ok(table)
}

/// The leaf of the column with this index, where it holds plain numbers.
pub(super) fn leaf_of(schema: &SchemaDescriptor, column: usize) -> Option<usize> {
    let field = schema.root_schema().get_fields().get(column)?;
    // A column of lists or structures has nested leaves with longer names.
    let leaf = (0..schema.num_columns()).find(|&leaf| schema.get_column_root_idx(leaf) == column);
    leaf.filter(|&leaf| field.is_primitive() && is_number(&schema.column(leaf)))
}

/// Refuses codecs that are not read.
pub(super) fn check_codec(group: &RowGroupMetaData, leaf: usize) -> Result<(), ParquetError> {
    if matches!(group.column(leaf).compression(), Compression::BROTLI(_) | Compression::LZO) {
        let message = "it is compressed with Brotli or LZO, which are not read; write it with Zstandard, Snappy, gzip or LZ4";
        return Err(ParquetError::General(message.to_owned()));
    }
    Ok(())
}

/// Ticks a second of a leaf of points in time, as since 1970.
fn ticks_per_s(leaf: &ColumnDescriptor) -> Option<i64> {
    match (leaf.logical_type_ref(), leaf.converted_type()) {
        (Some(LogicalType::Timestamp(time)), _) => Some(match time.unit {
            TimeUnit::MILLIS => 1_000,
            TimeUnit::MICROS => 1_000_000,
            TimeUnit::NANOS => 1_000_000_000,
        }),
        (None, ConvertedType::TIMESTAMP_MILLIS) => Some(1_000),
        (None, ConvertedType::TIMESTAMP_MICROS) => Some(1_000_000),
        _ => None,
    }
}

/// Whether a leaf holds plain numbers or points in time: no lists, booleans, text, dates or decimals.
fn is_number(leaf: &ColumnDescriptor) -> bool {
    use ConvertedType::{INT_8, INT_16, INT_32, INT_64, NONE, UINT_8, UINT_16, UINT_32, UINT_64};
    let plain = match (leaf.logical_type_ref(), leaf.converted_type()) {
        (Some(LogicalType::Integer(_)), _) => true,
        _ if ticks_per_s(leaf).is_some() => true,
        (Some(_), _) => false,
        (None, converted) => matches!(converted, NONE | INT_8 | INT_16 | INT_32 | INT_64 | UINT_8 | UINT_16 | UINT_32 | UINT_64),
    };
    plain
        && leaf.max_rep_level() == 0
        && matches!(leaf.physical_type(), Physical::INT32 | Physical::INT64 | Physical::FLOAT | Physical::DOUBLE)
}

/// Appends at most `most` values of a column, and returns their number; 0 at its end.
pub(super) fn read_numbers(
    reader: &mut ColumnReader,
    leaf: &ColumnDescriptor,
    most: usize,
    column: &mut Vec<f64>,
) -> Result<usize, ParquetError> {
    let unsigned = match leaf.logical_type_ref() {
        Some(LogicalType::Integer(integer)) => !integer.is_signed,
        _ => matches!(leaf.converted_type(), ConvertedType::UINT_32 | ConvertedType::UINT_64),
    };
    let ticks = ticks_per_s(leaf);
    match reader {
        ColumnReader::Int64ColumnReader(reader) if ticks.is_some() => {
            let ticks = ticks.unwrap_or(1);
            // Nanoseconds since 1970 are no number of 53 bits; their whole seconds and the rest are.
            read_as(reader, |value| (value / ticks) as f64 + (value % ticks) as f64 / ticks as f64, most, column)
        }
        ColumnReader::Int32ColumnReader(reader) if unsigned => {
            read_as(reader, |value| f64::from(value.cast_unsigned()), most, column)
        }
        ColumnReader::Int32ColumnReader(reader) => read_as(reader, f64::from, most, column),
        ColumnReader::Int64ColumnReader(reader) if unsigned => {
            read_as(reader, |value| value.cast_unsigned() as f64, most, column)
        }
        ColumnReader::Int64ColumnReader(reader) => read_as(reader, |value| value as f64, most, column),
        ColumnReader::FloatColumnReader(reader) => read_as(reader, f64::from, most, column),
        ColumnReader::DoubleColumnReader(reader) => read_as(reader, |value| value, most, column),
        _ => Err(ParquetError::General(format!("column `{}` is not of numbers", leaf.name()))),
    }
}

/// Passes over values of a column.
pub(super) fn skip_rows(reader: &mut ColumnReader, rows: usize) -> Result<(), ParquetError> {
    let skipped = match reader {
        ColumnReader::Int32ColumnReader(reader) => reader.skip_records(rows),
        ColumnReader::Int64ColumnReader(reader) => reader.skip_records(rows),
        ColumnReader::FloatColumnReader(reader) => reader.skip_records(rows),
        ColumnReader::DoubleColumnReader(reader) => reader.skip_records(rows),
        _ => Ok(rows),
    }?;
    if skipped == rows { Ok(()) } else { Err(ParquetError::General("a column is shorter than stated".to_owned())) }
}

/// Appends values of a column; a missing one becomes NaN.
fn read_as<T: DataType>(
    reader: &mut ColumnReaderImpl<T>,
    number: impl Fn(T::T) -> f64,
    most: usize,
    column: &mut Vec<f64>,
) -> Result<usize, ParquetError> {
    let (mut present, mut values) = (Vec::new(), Vec::new());
    let (rows, found, _) = reader.read_records(most, Some(&mut present), None, &mut values)?;
    let mut numbers = values.drain(..found).map(&number);
    if present.is_empty() {
        column.extend(numbers);
    } else {
        column.extend(present.iter().map(|&level| if level > 0 { numbers.next().unwrap_or(f64::NAN) } else { f64::NAN }));
    }
    Ok(rows)
}

/// Writes columns of equal length as non-null double-precision numbers, compressed with Zstandard.
///
/// # Errors
/// When the file cannot be written.
pub(crate) fn write(bytes: &mut Vec<u8>, columns: &[(String, Vec<f64>)]) -> Result<(), ParquetError> {
    let names: Vec<String> = columns.iter().map(|(name, _)| name.clone()).collect();
    let mut file = begun(bytes, &names)?;
    add_group(&mut file, &columns.iter().map(|(_, values)| values.as_slice()).collect::<Vec<_>>())?;
    file.close().map(drop)
}

fn begun<W: std::io::Write + Send>(out: W, names: &[String]) -> Result<SerializedFileWriter<W>, ParquetError> {
    let field = |name: &String| {
        let field = Type::primitive_type_builder(name, Physical::DOUBLE).with_repetition(Repetition::REQUIRED);
        field.build().map(Arc::new)
    };
    let fields = names.iter().map(field).collect::<Result<Vec<_>, _>>()?;
    let schema = Type::group_type_builder("log").with_fields(fields).build()?;
    let properties = WriterProperties::builder().set_compression(Compression::ZSTD(ZstdLevel::default())).build();
    SerializedFileWriter::new(out, Arc::new(schema), Arc::new(properties))
}

/// Adds columns of equal length as a row group.
fn add_group<W: std::io::Write + Send>(file: &mut SerializedFileWriter<W>, columns: &[&[f64]]) -> Result<(), ParquetError> {
    let mut group = file.next_row_group()?;
    for values in columns {
        if let Some(mut column) = group.next_column()? {
            column.typed::<DoubleType>().write_batch(values, None, None)?;
            column.close()?;
        }
    }
    group.close().map(drop)
}

/// A table that is written group by group, as [`write`] writes it whole.
pub(crate) struct Writer(SerializedFileWriter<File>);

impl Writer {
    /// A table with columns of these names in `file`.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn new(file: File, names: &[String]) -> Result<Self, ParquetError> {
        begun(file, names).map(Self)
    }

    /// Adds columns of equal length as a row group.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn add(&mut self, columns: &[&[f64]]) -> Result<(), ParquetError> {
        add_group(&mut self.0, columns)
    }

    /// The complete file.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn finish(self) -> Result<File, ParquetError> {
        self.0.into_inner()
    }
}

#[cfg(test)]
mod tests {
    use parquet::data_type::{ByteArray, ByteArrayType, FloatType, Int32Type, Int64Type};
    use parquet::schema::parser::parse_message_type;

    use super::*;

    /// Features of other tools' files: missing values, narrow and unsigned numbers, text, times and
    /// lists, several row groups.
    fn foreign(compression: Compression) -> Vec<u8> {
        let schema = "message table {
            required double t;
            optional float x;
            required int32 count (INTEGER(32,false));
            required int64 ticks;
            required binary note (UTF8);
            required int64 at (TIMESTAMP(NANOS,true));
            required group list { repeated group list { required double element; } }
        }";
        let schema = Arc::new(parse_message_type(schema).unwrap());
        let properties = WriterProperties::builder().set_compression(compression).build();
        let mut bytes = Vec::new();
        let mut file = SerializedFileWriter::new(&mut bytes, schema, Arc::new(properties)).unwrap();
        for group in 0..2 {
            let from = 3.0 * f64::from(group);
            let mut group = file.next_row_group().unwrap();
            let mut index = 0;
            while let Some(mut column) = group.next_column().unwrap() {
                match index {
                    0 => column.typed::<DoubleType>().write_batch(&[from, from + 1.0, from + 2.0], None, None),
                    1 => column.typed::<FloatType>().write_batch(&[0.5, 1.5], Some(&[1, 0, 1]), None),
                    2 => column.typed::<Int32Type>().write_batch(&[-1, 0, 7], None, None),
                    3 => column.typed::<Int64Type>().write_batch(&[-1, 0, 1 << 40], None, None),
                    4 => {
                        let notes = ["a", "b", "c"].map(ByteArray::from);
                        column.typed::<ByteArrayType>().write_batch(&notes, None, None)
                    }
                    5 => column.typed::<Int64Type>().write_batch(&[1_790_000_000_250_000_000, 2, 3_000_000_000], None, None),
                    _ => column.typed::<DoubleType>().write_batch(&[1.0; 4], Some(&[1; 4]), Some(&[0, 1, 0, 0])),
                }
                .unwrap();
                column.close().unwrap();
                index += 1;
            }
            group.close().unwrap();
        }
        file.close().unwrap();
        bytes
    }

    #[test]
    fn tables_of_other_tools_are_read() {
        let compressions =
            [Compression::UNCOMPRESSED, Compression::SNAPPY, Compression::GZIP(Default::default()), Compression::LZ4_RAW];
        for compression in compressions {
            let table = Parquet.read(Path::new("log.parquet"), foreign(compression)).unwrap();
            assert_eq!(table.names, ["t", "x", "count", "ticks", "note", "at", "list"]);
            assert_eq!(table.lines, [1, 2, 3, 4, 5, 6]);
            assert_eq!(table.columns[0], [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
            let x = &table.columns[1];
            assert!(x.len() == 6 && x[0] == 0.5 && x[1].is_nan() && x[2] == 1.5 && x[3] == 0.5, "{x:?}");
            assert_eq!(table.columns[2][..3], [4_294_967_295.0, 0.0, 7.0]);
            assert_eq!(table.columns[3][..3], [-1.0, 0.0, 1_099_511_627_776.0]);
            assert_eq!(table.columns[5][..3], [1_790_000_000.25, 2e-9, 3.0]);
            for column in [&table.columns[4], &table.columns[6]] {
                assert!(column.len() == 6 && column.iter().all(|value| value.is_nan()));
            }
        }
    }

    #[test]
    fn what_is_packed_with_brotli_is_refused_with_the_remedy() {
        let mut bytes = foreign(Compression::UNCOMPRESSED);
        // The footer's entry of the column `t`: its path, then its codec, 0. Brotli is 4, which is written as 8.
        let entry = [0x18, 1, b't', 0x15, 0];
        let places: Vec<usize> = (0..bytes.len() - entry.len()).filter(|&at| bytes[at..].starts_with(&entry)).collect();
        assert_eq!(places.len(), 2, "one a row group");
        for at in places {
            bytes[at + 4] = 8;
        }
        let error = Parquet.read(Path::new("log.parquet"), bytes).unwrap_err().to_string();
        assert!(error.contains("Brotli") && error.contains("write it with"), "{error}");
    }
}
