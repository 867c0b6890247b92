//! File formats: one file per format, from bytes to a [`Table`].

mod arrays;
mod clock_text;
mod csv;
mod csv_rows;
mod dialect;
mod halsampler;
mod halscope;
mod json;
mod matlab;
mod numpy;
pub(crate) mod parquet;
mod parquet_rows;
mod rows;
mod sinumerik_json;
mod sinumerik_xml;
mod text;
mod twincat;

use std::path::Path;

use crate::{DatasetError, Table};

pub(crate) use csv_rows::{CsvHead, CsvRows};
pub(crate) use parquet_rows::{ParquetRows, parquet_head};
pub(crate) use rows::Rows;

pub use csv::Csv;
pub use halsampler::Halsampler;
pub use halscope::Halscope;
pub use json::Json;
pub use matlab::Matlab;
pub use numpy::{NumpyArchive, NumpyArray};
pub use parquet::Parquet;
pub use sinumerik_json::SinumerikJson;
pub use sinumerik_xml::SinumerikTrace;
pub use twincat::TwincatScope;

/// A storage format of logs.
///
/// A new controller's format is one file with an implementation of this trait and one line in
/// [`FORMATS`]. It only names its columns, as `x_ref`, `x_act_um`;
/// [`ColumnMap::recognise`](crate::ColumnMap::recognise) interprets the names.
pub trait LogFormat: Sync {
    /// Name for messages.
    fn name(&self) -> &'static str;

    /// Whether a file with the beginning `head` (up to [`HEAD_BYTES`] bytes) has this format.
    fn recognises(&self, head: &[u8]) -> bool;

    /// The file's columns; `path` is for messages.
    ///
    /// # Errors
    /// When the bytes violate the format.
    fn read(&self, path: &Path, bytes: Vec<u8>) -> Result<Table, DatasetError>;
}

/// Length of the beginning of a file for the recognition of its format.
pub const HEAD_BYTES: usize = 4096;

/// Beginning of a ZIP archive, such as a model.
pub const ARCHIVE: &[u8] = b"PK\x03\x04";

/// All formats, the most specific first.
pub static FORMATS: &[&dyn LogFormat] = &[
    &Parquet,
    &NumpyArchive,
    &NumpyArray,
    &Matlab,
    &SinumerikJson,
    &Json,
    &SinumerikTrace,
    &TwincatScope,
    &Halscope,
    &Halsampler,
    &Csv,
];

/// Reads the columns of a file in any known format.
///
/// # Errors
/// When the file cannot be read, no format recognises it, or it violates its format.
pub fn read_table(path: &Path) -> Result<Table, DatasetError> {
    table_of(path, std::fs::read(path).map_err(|source| DatasetError::io(path, source))?)
}

const GZIP: &[u8] = &[0x1F, 0x8B];
const OLE: &[u8] = &[0xD0, 0xCF, 0x11, 0xE0];

/// The format of a file with this content; `None` for none that is known.
#[must_use]
pub fn format_of(bytes: &[u8]) -> Option<&'static dyn LogFormat> {
    let head = &bytes[..bytes.len().min(HEAD_BYTES)];
    FORMATS.iter().copied().find(|format| format.recognises(head))
}

/// As [`read_table`], from bytes; errors name `path`.
///
/// # Errors
/// When no format recognises the bytes, or they violate it.
pub fn table_of(path: &Path, bytes: Vec<u8>) -> Result<Table, DatasetError> {
    if bytes.is_empty() {
        return Err(DatasetError::format(path, "the file is empty"));
    }
    match format_of(&bytes) {
        Some(format) => format.read(path, bytes),
        None if bytes.starts_with(ARCHIVE) => {
            let why = "this is an archive, as spreadsheets and models are, and no log; export the log as CSV (a model goes behind -m or --from)";
            Err(DatasetError::format(path, why))
        }
        None if bytes.starts_with(GZIP) => Err(DatasetError::format(path, "this is a compressed file (gzip); unpack it first")),
        None if bytes.starts_with(OLE) => Err(DatasetError::format(
            path,
            "this is a spreadsheet or another file of Microsoft Office, and no log; export the log as CSV",
        )),
        None if is_hdf5(&bytes) => {
            let why = "this is an HDF5 file; export the signals as Parquet or CSV, or save a MAT file of MATLAB with `save -v7`";
            Err(DatasetError::format(path, why))
        }
        None if is_scope_file(path) => {
            let why =
                "this is a binary file of TwinCAT Scope; open it there and export the channels as CSV, with `Timelines: All`";
            Err(DatasetError::format(path, why))
        }
        None => Err(DatasetError::format(
            path,
            "no format that is known (CSV, JSON, Parquet, NumPy, MATLAB, halsampler, halscope, TwinCAT Scope, SINUMERIK Edge or trace); export the log as CSV",
        )),
    }
}

/// Whether the name is that of a binary export or a recording of TwinCAT Scope.
fn is_scope_file(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ["svb", "svd", "svdx"].iter().any(|known| ending.eq_ignore_ascii_case(known)))
}

/// Signature of HDF5.
const HDF5: &[u8] = b"\x89HDF\r\n\x1a\n";

/// Whether the bytes are an HDF5 file, whose signature is at the start or behind a block of 512, 1024, 2048, … bytes.
fn is_hdf5(bytes: &[u8]) -> bool {
    let places = std::iter::once(0).chain((9..).map(|power| 1 << power).take_while(|place| *place < HEAD_BYTES));
    places.into_iter().any(|place| bytes.get(place..).is_some_and(|rest| rest.starts_with(HDF5)))
}
