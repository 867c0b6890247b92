//! Data frames by Arrow's C stream interface, which pandas, polars and pyarrow speak (the PyCapsule interface).

use arrow_array::cast::AsArray;
use arrow_array::ffi_stream::{FFI_ArrowArrayStream, RecordBatchStreamReader};
use arrow_array::types::{
    ArrowPrimitiveType, DurationMicrosecondType, DurationMillisecondType, DurationNanosecondType, DurationSecondType,
    Float32Type, Float64Type, Int8Type, Int16Type, Int32Type, Int64Type, TimestampMicrosecondType, TimestampMillisecondType,
    TimestampNanosecondType, TimestampSecondType, UInt8Type, UInt16Type, UInt32Type, UInt64Type,
};
use arrow_array::{Array, RecordBatchReader};
use arrow_schema::{ArrowError, DataType, TimeUnit};
use datasets::Table;
use pyo3::prelude::*;
use pyo3::types::PyCapsule;

use crate::errors::Error;

/// The columns of a data frame, of instants as seconds since the first one; `None` for an object that is none. Columns that hold no numbers
/// are kept without values, as those of a file are.
pub fn table(frame: &Bound<'_, PyAny>) -> PyResult<Option<Table>> {
    let Ok(export) = frame.getattr("__arrow_c_stream__") else { return Ok(None) };
    let capsule = export.call0()?;
    let capsule = capsule.cast::<PyCapsule>()?;
    let stream = stream_of(capsule)?;
    let broken = |error: ArrowError| Error::new_err(format!("the data frame cannot be read: {error}"));
    let reader = RecordBatchStreamReader::try_new(stream).map_err(broken)?;
    let names: Vec<String> = reader.schema().fields().iter().map(|field| field.name().clone()).collect();
    let mut columns: Vec<Growing> = names.iter().map(|_| Growing::default()).collect();
    let mut rows = 0;
    for batch in reader {
        let batch = batch.map_err(broken)?;
        rows += batch.num_rows();
        columns.iter_mut().zip(batch.columns()).for_each(|(column, array)| column.append(array));
    }
    let columns = columns.into_iter().map(|column| column.values).collect();
    Ok(Some(Table { names, columns, lines: (1..=rows).collect(), ..Table::default() }))
}

/// Takes the stream out of its capsule, which is empty afterwards.
#[allow(unsafe_code)]
fn stream_of(capsule: &Bound<'_, PyCapsule>) -> PyResult<FFI_ArrowArrayStream> {
    let pointer = capsule.pointer_checked(Some(c"arrow_array_stream"))?;
    // SAFETY: a capsule of this name holds such a structure by the interface's rule; taking it leaves an empty one, which the capsule's
    // destructor passes over.
    Ok(unsafe { FFI_ArrowArrayStream::from_raw(pointer.as_ptr().cast()) })
}

/// Columns as they grow: the values, and the first instant of a column of instants.
#[derive(Default)]
struct Growing {
    values: Vec<f64>,
    first: Option<i64>,
}

impl Growing {
    /// Appends the values of an array; a missing one, and any of a column that holds no numbers, becomes NaN.
    fn append(&mut self, array: &dyn Array) {
        let rows = self.values.len() + array.len();
        match array.data_type() {
            DataType::Float64 => self.numbers::<Float64Type>(array, |value| value),
            DataType::Float32 => self.numbers::<Float32Type>(array, f64::from),
            DataType::Int8 => self.numbers::<Int8Type>(array, f64::from),
            DataType::Int16 => self.numbers::<Int16Type>(array, f64::from),
            DataType::Int32 => self.numbers::<Int32Type>(array, f64::from),
            DataType::Int64 => self.numbers::<Int64Type>(array, |value| value as f64),
            DataType::UInt8 => self.numbers::<UInt8Type>(array, f64::from),
            DataType::UInt16 => self.numbers::<UInt16Type>(array, f64::from),
            DataType::UInt32 => self.numbers::<UInt32Type>(array, f64::from),
            DataType::UInt64 => self.numbers::<UInt64Type>(array, |value| value as f64),
            DataType::Timestamp(TimeUnit::Second, _) => self.instants::<TimestampSecondType>(array, 1.0),
            DataType::Timestamp(TimeUnit::Millisecond, _) => self.instants::<TimestampMillisecondType>(array, 1e3),
            DataType::Timestamp(TimeUnit::Microsecond, _) => self.instants::<TimestampMicrosecondType>(array, 1e6),
            DataType::Timestamp(TimeUnit::Nanosecond, _) => self.instants::<TimestampNanosecondType>(array, 1e9),
            DataType::Duration(TimeUnit::Second) => self.instants::<DurationSecondType>(array, 1.0),
            DataType::Duration(TimeUnit::Millisecond) => self.instants::<DurationMillisecondType>(array, 1e3),
            DataType::Duration(TimeUnit::Microsecond) => self.instants::<DurationMicrosecondType>(array, 1e6),
            DataType::Duration(TimeUnit::Nanosecond) => self.instants::<DurationNanosecondType>(array, 1e9),
            _ => {}
        }
        self.values.resize(rows, f64::NAN);
    }

    fn numbers<T: ArrowPrimitiveType>(&mut self, array: &dyn Array, number: impl Fn(T::Native) -> f64) {
        self.values.extend(array.as_primitive::<T>().iter().map(|value| value.map_or(f64::NAN, &number)));
    }

    /// Instants of so many ticks a second. The first one is taken off before they become floating-point numbers, which do not hold the
    /// nanoseconds of a date.
    fn instants<T: ArrowPrimitiveType<Native = i64>>(&mut self, array: &dyn Array, ticks: f64) {
        for value in array.as_primitive::<T>() {
            let since = value.map(|value| value.wrapping_sub(*self.first.get_or_insert(value)));
            self.values.push(since.map_or(f64::NAN, |since| since as f64 / ticks));
        }
    }
}
