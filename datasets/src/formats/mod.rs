//! File formats: one file a format, each of which turns bytes into a [`Table`].

mod csv;
mod dialect;
mod halsampler;
mod halscope;
pub(crate) mod parquet;
mod sinumerik_json;
mod sinumerik_xml;
mod text;
mod twincat;

use std::path::Path;

use crate::{DatasetError, Table};

pub use csv::Csv;
pub use halsampler::Halsampler;
pub use halscope::Halscope;
pub use parquet::Parquet;
pub use sinumerik_json::SinumerikJson;
pub use sinumerik_xml::SinumerikTrace;
pub use twincat::TwincatScope;

/// A way in which logs are stored.
///
/// A new controller's format is one file with an implementation of this and one line in [`FORMATS`]. What its columns mean is not
/// decided here: it only has to name them so that [`ColumnMap::recognise`](crate::ColumnMap::recognise) understands, as `x_ref`, `x_act_um`.
pub trait LogFormat: Sync {
    /// Name for messages.
    fn name(&self) -> &'static str;

    /// Whether a file that begins with `head` (up to [`HEAD_BYTES`] bytes) is of this format.
    fn recognises(&self, head: &[u8]) -> bool;

    /// The file's columns; `path` is for messages.
    ///
    /// # Errors
    /// When the bytes break the format's rules.
    fn read(&self, path: &Path, bytes: Vec<u8>) -> Result<Table, DatasetError>;
}

/// How much of a file a format may look at to recognise it.
pub const HEAD_BYTES: usize = 4096;

/// How a ZIP archive begins, models among them.
pub const ARCHIVE: &[u8] = b"PK\x03\x04";

/// All formats, the most particular first.
pub static FORMATS: &[&dyn LogFormat] = &[&Parquet, &SinumerikJson, &SinumerikTrace, &TwincatScope, &Halscope, &Halsampler, &Csv];

/// The columns of a file in any format that is known.
///
/// # Errors
/// When the file cannot be read, no format recognises it, or it breaks its format's rules.
pub fn read_table(path: &Path) -> Result<Table, DatasetError> {
    table_of(path, std::fs::read(path).map_err(|source| DatasetError::io(path, source))?)
}

/// As [`read_table`], of bytes that are at hand; errors name `path`.
///
/// # Errors
/// When no format recognises the bytes, or they break its rules.
pub fn table_of(path: &Path, bytes: Vec<u8>) -> Result<Table, DatasetError> {
    if bytes.is_empty() {
        return Err(DatasetError::format(path, "the file is empty"));
    }
    if bytes.starts_with(ARCHIVE) {
        let why = "this is an archive, as spreadsheets and models are, and no log; export the log as CSV (a model goes behind -m or --from)";
        return Err(DatasetError::format(path, why));
    }
    let head = &bytes[..bytes.len().min(HEAD_BYTES)];
    match FORMATS.iter().find(|format| format.recognises(head)) {
        Some(format) => format.read(path, bytes),
        None => Err(DatasetError::format(
            path,
            "no format that is known (CSV, Parquet, halsampler, halscope, TwinCAT Scope, SINUMERIK Edge or trace); export the log as CSV",
        )),
    }
}
