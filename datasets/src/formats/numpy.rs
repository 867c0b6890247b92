//! NumPy's archives of arrays (`np.savez`, `np.savez_compressed`): a ZIP archive with one `.npy` file an array.

use std::io::{Cursor, Read};
use std::path::Path;

use zip::ZipArchive;

use super::arrays::{Array, MOST_NUMBERS, Number, count, table};
use super::{ARCHIVE, LogFormat};
use crate::{DatasetError, Table};

/// An archive of arrays by name. A matrix is one signal a column: `name.1`, `name.2`, ….
#[derive(Debug, Clone, Copy)]
pub struct NumpyArchive;

/// Beginning of an array file.
const MAGIC: &[u8] = b"\x93NUMPY";
/// Bytes that one byte of an archive can stand for at most: the limit of its compression.
const MOST_EXPANSION: usize = 1040;
/// Longest header of an array.
const LONGEST_HEADER: usize = 1 << 16;

impl LogFormat for NumpyArchive {
    fn name(&self) -> &'static str {
        "NumPy archive"
    }

    fn recognises(&self, head: &[u8]) -> bool {
        // The name of the first file stands behind 30 bytes, its length in bytes 26 and 27.
        let length = head.get(26..28).map_or(0, |length| usize::from(u16::from_le_bytes([length[0], length[1]])));
        head.starts_with(ARCHIVE) && head.get(30..30 + length).is_some_and(|name| name.ends_with(b".npy"))
    }

    fn read(&self, path: &Path, bytes: Vec<u8>) -> Result<Table, DatasetError> {
        let damaged = |message: String| DatasetError::format(path, format!("the archive is damaged: {message}; save it again"));
        let most_bytes = bytes.len().saturating_mul(MOST_EXPANSION);
        let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|error| damaged(error.to_string()))?;
        let mut arrays = Vec::new();
        for index in 0..archive.len() {
            let file = archive.by_index(index).map_err(|error| damaged(error.to_string()))?;
            let stored = file.name().map_err(|error| damaged(error.to_string()))?.into_owned();
            let Some(name) = stored.strip_suffix(".npy") else { continue };
            let most = MOST_NUMBERS.saturating_sub(count(&arrays));
            let array = array(name, file, (most, most_bytes));
            arrays.extend(array.map_err(|why| DatasetError::format(path, format!("array `{name}`: {why}")))?);
        }
        table(path, arrays)
    }
}

/// The array of a `.npy` file; `None` where it holds no real numbers or has more than two dimensions.
/// Refused beyond `most` numbers or bytes.
fn array(name: &str, mut file: impl Read, most: (usize, usize)) -> Result<Option<Array>, String> {
    let mut start = [0; 8];
    let mut fill = |into: &mut [u8]| file.read_exact(into).map_err(|error| format!("it is cut off ({error}); save it again"));
    fill(&mut start)?;
    if !start.starts_with(MAGIC) {
        return Err("it is no array file of NumPy; save it again".into());
    }
    let length = if start[6] == 1 {
        let mut length = [0; 2];
        fill(&mut length)?;
        usize::from(u16::from_le_bytes(length))
    } else {
        let mut length = [0; 4];
        fill(&mut length)?;
        usize::try_from(u32::from_le_bytes(length)).unwrap_or(usize::MAX)
    };
    if length > LONGEST_HEADER {
        return Err(format!("its header of {length} bytes is too long; save it again"));
    }
    let mut header = vec![0; length];
    fill(&mut header)?;
    let header = String::from_utf8_lossy(&header).into_owned();
    let Some(Header { number, tick_s, is_big_endian, by_columns, shape }) = Header::of(&header) else { return Ok(None) };
    let (rows, columns) = match shape.as_slice() {
        // A row is a signal too.
        [rows] | [1, rows] => (*rows, 1),
        [rows, columns] => (*rows, *columns),
        _ => return Ok(None),
    };
    if rows == 0 || columns == 0 {
        return Ok(None);
    }
    let count = rows.checked_mul(columns).filter(|count| *count <= most.0);
    let bytes = count.and_then(|count| count.checked_mul(number.bytes())).filter(|bytes| *bytes <= most.1);
    let bytes = bytes.ok_or_else(|| {
        format!("{rows} × {columns} numbers are more than the file holds, or than {MOST_NUMBERS} in all; save it again, in parts if need be")
    })?;
    let mut data = vec![0; bytes];
    fill(&mut data)?;
    let mut values = number.read(&data, is_big_endian);
    if let Some(tick_s) = tick_s {
        values.iter_mut().for_each(|value| *value *= tick_s);
    }
    let name = name.to_owned();
    Ok(Some(if by_columns { Array::by_columns(name, &values, rows) } else { Array::by_rows(name, &values, columns) }))
}

/// Header of an array file: a dictionary in Python's notation.
struct Header {
    number: Number,
    /// Unit of points in time, or of durations.
    tick_s: Option<f64>,
    is_big_endian: bool,
    by_columns: bool,
    shape: Vec<usize>,
}

impl Header {
    /// `None` for what is no array of real numbers.
    fn of(text: &str) -> Option<Self> {
        let after = |key: &str| text.split_once(key).map(|(_, after)| after.trim_start_matches([' ', ':']));
        let kind = after("'descr'")?.strip_prefix('\'')?.split('\'').next()?;
        let (order, kind) = kind.split_at_checked(1)?;
        let tick_s = match kind {
            "M8[s]" | "m8[s]" => Some(1.0),
            "M8[ms]" | "m8[ms]" => Some(1e-3),
            "M8[us]" | "m8[us]" => Some(1e-6),
            "M8[ns]" | "m8[ns]" => Some(1e-9),
            _ => None,
        };
        let number = match kind {
            _ if tick_s.is_some() => Number::I64,
            "f8" => Number::F64,
            "f4" => Number::F32,
            "i8" => Number::I64,
            "u8" => Number::U64,
            "i4" => Number::I32,
            "u4" => Number::U32,
            "i2" => Number::I16,
            "u2" => Number::U16,
            "i1" => Number::I8,
            "u1" => Number::U8,
            _ => return None,
        };
        let by_columns = after("'fortran_order'")?.starts_with("True");
        let shape = after("'shape'")?.strip_prefix('(')?.split(')').next()?;
        let shape = shape
            .split(',')
            .map(str::trim)
            .filter(|part| !part.is_empty())
            .map(|part| part.parse().ok())
            .collect::<Option<_>>()?;
        Some(Self { number, tick_s, is_big_endian: order == ">", by_columns, shape })
    }
}
