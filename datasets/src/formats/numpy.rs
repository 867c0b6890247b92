//! NumPy's arrays: single ones (`np.save`) and archives of them (`np.savez`, `np.savez_compressed`), ZIP files with one `.npy` file an array.

use std::io::{Cursor, Read};
use std::path::Path;

use zip::ZipArchive;

use super::arrays::{Array, MOST_NUMBERS, Number, count, table};
use super::{ARCHIVE, LogFormat};
use crate::{DatasetError, Table};

/// An archive of arrays by name. A matrix is one signal a column: `name.1`, `name.2`, ….
#[derive(Debug, Clone, Copy)]
pub struct NumpyArchive;

/// A single array. A matrix, whose columns have no names, is one signal a column: `1`, `2`, …; of records each field is one.
#[derive(Debug, Clone, Copy)]
pub struct NumpyArray;

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
            let array = self::arrays(name, file, (most, most_bytes));
            arrays.extend(array.map_err(|why| DatasetError::format(path, format!("array `{name}`: {why}")))?);
        }
        table(path, arrays)
    }
}

impl LogFormat for NumpyArray {
    fn name(&self) -> &'static str {
        "NumPy array"
    }

    fn recognises(&self, head: &[u8]) -> bool {
        head.starts_with(MAGIC)
    }

    fn read(&self, path: &Path, bytes: Vec<u8>) -> Result<Table, DatasetError> {
        let most = (MOST_NUMBERS, bytes.len());
        let arrays = arrays("", bytes.as_slice(), most).map_err(|why| DatasetError::format(path, format!("the array: {why}")))?;
        let single = |Array { name, columns }: Array| {
            let named = move |(index, column)| {
                let name = if name.is_empty() { format!("{}", index + 1) } else { name.clone() };
                Array { name, columns: vec![column] }
            };
            columns.into_iter().enumerate().map(named)
        };
        table(path, arrays.into_iter().flat_map(single).collect())
    }
}

/// The array of a `.npy` file, or one for each field of an array of records, named as its field; none where it holds no real numbers or has more than two
/// dimensions. Refused beyond `most` numbers or bytes.
fn arrays(name: &str, mut file: impl Read, most: (usize, usize)) -> Result<Vec<Array>, String> {
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
    let Some(Header { fields, by_columns, shape }) = Header::of(&header) else { return Ok(Vec::new()) };
    let (rows, columns) = match shape.as_slice() {
        // A row is a signal too.
        [rows] | [1, rows] => (*rows, 1),
        [rows, columns] => (*rows, *columns),
        _ => return Ok(Vec::new()),
    };
    if rows == 0 || columns == 0 || (columns > 1 && fields.len() > 1) {
        return Ok(Vec::new());
    }
    let of_record: usize = fields.iter().map(|field| field.number.bytes()).sum();
    let records = rows.checked_mul(columns).filter(|records| records.saturating_mul(fields.len()) <= most.0);
    let bytes = records.and_then(|records| records.checked_mul(of_record)).filter(|bytes| *bytes <= most.1);
    let bytes = bytes.ok_or_else(|| {
        format!(
            "{rows} × {} numbers are more than the file holds, or than {MOST_NUMBERS} in all; save it again, in parts if need be",
            columns * fields.len()
        )
    })?;
    let mut data = vec![0; bytes];
    fill(&mut data)?;
    let mut before = 0;
    let arrays = fields.into_iter().map(|field| {
        let place = before..before + field.number.bytes();
        before = place.end;
        let values: Vec<f64> = data.chunks_exact(of_record).map(|record| field.value(&record[place.clone()])).collect();
        let name = field.name.unwrap_or_else(|| name.to_owned());
        if by_columns { Array::by_columns(name, &values, rows) } else { Array::by_rows(name, &values, columns) }
    });
    Ok(arrays.collect())
}

/// Field of the records of an array.
struct Field {
    /// `None` for an array of plain numbers.
    name: Option<String>,
    number: Number,
    /// Unit of points in time, or of durations.
    tick_s: Option<f64>,
    is_big_endian: bool,
}

impl Field {
    /// `None` for what is no real number. `kind` as `<f8`.
    fn of(name: Option<&str>, kind: &str) -> Option<Self> {
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
        Some(Self { name: name.map(str::to_owned), number, tick_s, is_big_endian: order == ">" })
    }

    fn value(&self, bytes: &[u8]) -> f64 {
        self.number.number(bytes, self.is_big_endian) * self.tick_s.unwrap_or(1.0)
    }
}

/// Header of an array file: a dictionary in Python's notation.
struct Header {
    fields: Vec<Field>,
    by_columns: bool,
    shape: Vec<usize>,
}

impl Header {
    /// `None` for what is no array of real numbers, or of records of them.
    fn of(text: &str) -> Option<Self> {
        let after = |key: &str| text.split_once(key).map(|(_, after)| after.trim_start_matches([' ', ':']));
        let kind = after("'descr'")?;
        let fields = match kind.strip_prefix('[') {
            // A field of several numbers has a third part.
            Some(records) => {
                let records = records.split("'fortran_order'").next()?;
                let field = |record: &str| match record.split('\'').collect::<Vec<_>>().as_slice() {
                    [_, name, _, kind, end] if end.trim_matches([' ', ',', ')', ']']).is_empty() => Field::of(Some(name), kind),
                    _ => None,
                };
                records.split('(').skip(1).map(field).collect::<Option<Vec<_>>>()?
            }
            None => vec![Field::of(None, kind.strip_prefix('\'')?.split('\'').next()?)?],
        };
        let by_columns = after("'fortran_order'")?.starts_with("True");
        let shape = after("'shape'")?.strip_prefix('(')?.split(')').next()?;
        let shape = shape
            .split(',')
            .map(str::trim)
            .filter(|part| !part.is_empty())
            .map(|part| part.parse().ok())
            .collect::<Option<_>>()?;
        Some(Self { fields, by_columns, shape })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(descr: &str, shape: &str, data: &[u8]) -> Vec<u8> {
        let header = format!("{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}\n");
        let length = u16::try_from(header.len()).unwrap().to_le_bytes();
        [MAGIC, &[1, 0], &length, header.as_bytes(), data].concat()
    }

    fn read(bytes: Vec<u8>) -> Result<Table, DatasetError> {
        assert!(NumpyArray.recognises(&bytes));
        NumpyArray.read(Path::new("log.npy"), bytes)
    }

    #[test]
    fn columns_of_a_matrix_are_numbered_and_fields_of_records_keep_their_names() {
        let data: Vec<u8> = [0.0, 1.5, 0.5, 2.5].iter().flat_map(|value: &f64| value.to_le_bytes()).collect();
        let table = read(file("'<f8'", "(2, 2)", &data)).unwrap();
        assert_eq!((table.names, table.columns), (vec!["1".into(), "2".into()], vec![vec![0.0, 0.5], vec![1.5, 2.5]]));
        let row = |t: i64, x: f32| [&t.to_le_bytes()[..], &x.to_le_bytes()[..]].concat();
        let data = [row(2_000_000, 1.5), row(4_000_000, 2.5)].concat();
        let table = read(file("[('t', '<M8[ns]'), ('x_cmd', '<f4')]", "(2,)", &data)).unwrap();
        assert_eq!((table.names, table.columns), (vec!["t".into(), "x_cmd".into()], vec![vec![0.002, 0.004], vec![1.5, 2.5]]));
    }

    #[test]
    fn what_is_no_record_of_signals_is_refused() {
        for (descr, shape) in [("'<U8'", "(2,)"), ("[('t', '<f8'), ('pos', '<f8', (3,))]", "(2,)"), ("'<f8'", "(2, 2, 2)")] {
            let error = read(file(descr, shape, &[0; 64])).unwrap_err().to_string();
            assert!(error.contains("no array of numbers"), "{error}");
        }
        let error = read(file("'<f8'", "(9, 9)", &[0; 64])).unwrap_err().to_string();
        assert!(error.contains("9 × 9 numbers are more than the file holds"), "{error}");
        assert!(read(file("'<f8'", "(2, 4)", &[0; 40])).unwrap_err().to_string().contains("cut off"));
    }
}
