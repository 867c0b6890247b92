//! MATLAB's MAT files of level 5 (`save -v6`, `save -v7`): elements of a type, a length and data, compressed one by one from version 7 on.
//!
//! MATLAB, "MAT-File Format", chapter 1.

use std::io::Read;
use std::path::Path;

use flate2::bufread::ZlibDecoder;

use super::LogFormat;
use super::arrays::{Array, MOST_NUMBERS, Number, count, table};
use crate::{DatasetError, Table};

/// Variables by name. A matrix is one signal a column: `name.1`, `name.2`, …. Fields of a structure are `name.field`.
#[derive(Debug, Clone, Copy)]
pub struct Matlab;

/// Bytes before the first element.
const HEADER: usize = 128;
/// Beginning of the text of a header.
const MAGIC: &[u8] = b"MATLAB 5.0 MAT-file";
/// Beginning of the text of a header of version 7.3, which is HDF5 behind it.
const MAGIC_HDF5: &[u8] = b"MATLAB 7.3 MAT-file";
/// Element types.
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;
/// Classes of arrays: structure, and the first and last of numbers.
const STRUCTURE: u8 = 2;
const NUMBERS: std::ops::RangeInclusive<u8> = 6..=15;
/// Flag of an array with an imaginary part.
const COMPLEX: u8 = 8;
/// Bytes that one byte of a compressed element can stand for at most.
const MOST_EXPANSION: u64 = 1040;
/// Most bytes of an unpacked element.
const MOST_BYTES: u64 = 1 << 30;
/// Structures within structures.
const DEEPEST: usize = 8;

impl LogFormat for Matlab {
    fn name(&self) -> &'static str {
        "MATLAB"
    }

    fn recognises(&self, head: &[u8]) -> bool {
        head.starts_with(MAGIC) || head.starts_with(MAGIC_HDF5)
    }

    fn read(&self, path: &Path, bytes: Vec<u8>) -> Result<Table, DatasetError> {
        if bytes.starts_with(MAGIC_HDF5) {
            return Err(DatasetError::format(path, "this is a MAT file of version 7.3 (HDF5); save it with `save -v7`"));
        }
        let is_big_endian = match bytes.get(126..HEADER) {
            Some(b"IM") => false,
            Some(b"MI") => true,
            _ => return Err(DatasetError::format(path, "the header does not state the order of bytes; save the file again")),
        };
        let mut arrays = Vec::new();
        let file = Elements { bytes: &bytes[HEADER..], at: HEADER, is_big_endian };
        file.variables(&mut arrays).map_err(|fault| DatasetError::format(path, fault))?;
        table(path, arrays)
    }
}

/// Elements one after another.
struct Elements<'a> {
    bytes: &'a [u8],
    /// Place of the first byte in the file, for messages.
    at: usize,
    is_big_endian: bool,
}

/// An element: type and data.
struct Element<'a> {
    kind: u32,
    data: &'a [u8],
    at: usize,
}

/// The data of a compressed element.
fn unpacked(element: &Element<'_>) -> Result<Vec<u8>, String> {
    let mut unpacked = Vec::new();
    let most = (element.data.len() as u64).saturating_mul(MOST_EXPANSION).min(MOST_BYTES);
    let read = ZlibDecoder::new(element.data).take(most).read_to_end(&mut unpacked);
    read.map_err(|error| format!("byte {}: the element cannot be unpacked ({error}); save the file again", element.at))?;
    Ok(unpacked)
}

impl<'a> Elements<'a> {
    fn variables(mut self, arrays: &mut Vec<Array>) -> Result<(), String> {
        while let Some(element) = self.next()? {
            match element.kind {
                MATRIX => self.within(&element).array("", arrays, 0)?,
                COMPRESSED => {
                    let unpacked = unpacked(&element)?;
                    let mut within = Elements { bytes: &unpacked, at: element.at, is_big_endian: self.is_big_endian };
                    // One element stands in a compressed one, and it is not compressed itself.
                    if let Some(element) = within.next()?.filter(|element| element.kind == MATRIX) {
                        within.within(&element).array("", arrays, 0)?;
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn within<'b>(&self, element: &Element<'b>) -> Elements<'b> {
        Elements { bytes: element.data, at: element.at, is_big_endian: self.is_big_endian }
    }

    /// The array whose parts these elements are: flags, dimensions, name, data. `before` is the name of the structure that it is a field of.
    fn array(mut self, before: &str, arrays: &mut Vec<Array>, depth: usize) -> Result<(), String> {
        let Some(flags) = self.next()? else { return Ok(()) };
        let word = self.words(flags.data).first().copied().unwrap_or_default().to_le_bytes();
        let (class, flags) = (word[0], word[1]);
        let (dimensions, name) = (self.part()?, self.part()?);
        let dimensions: Vec<usize> = self.words(dimensions.data).iter().map(|&size| size as usize).collect();
        let own = String::from_utf8_lossy(name.data).into_owned();
        let name = match (before.is_empty(), own.is_empty()) {
            (true, _) => own,
            (_, true) => before.to_owned(),
            _ => format!("{before}.{own}"),
        };
        if class == STRUCTURE && dimensions.iter().all(|size| *size == 1) && depth < DEEPEST {
            return self.fields(&name, arrays, depth);
        }
        let &[rows, columns] = dimensions.as_slice() else { return Ok(()) };
        if !NUMBERS.contains(&class) || flags & COMPLEX != 0 {
            return Ok(());
        }
        let data = self.part()?;
        let values = self.numbers(&data, count(arrays))?;
        if rows.checked_mul(columns) != Some(values.len()) {
            return Err(format!(
                "byte {}: `{name}` has {rows} × {columns} numbers, and {} are there; save the file again",
                data.at,
                values.len()
            ));
        }
        // A row is a signal too.
        let rows = if rows == 1 { columns } else { rows };
        arrays.push(Array::by_columns(name, &values, rows));
        Ok(())
    }

    /// The fields of a structure: length and list of their names, then an array each.
    fn fields(mut self, name: &str, arrays: &mut Vec<Array>, depth: usize) -> Result<(), String> {
        let (length, names) = (self.part()?, self.part()?);
        let length = self.words(length.data).first().map_or(0, |length| *length as usize);
        if length == 0 {
            return Ok(());
        }
        for field in names.data.chunks_exact(length) {
            let field = field.split(|byte| *byte == 0).next().unwrap_or_default();
            let array = self.part()?;
            self.within(&array).array(&format!("{name}.{}", String::from_utf8_lossy(field)), arrays, depth + 1)?;
        }
        Ok(())
    }

    /// The next element, which has to be there.
    fn part(&mut self) -> Result<Element<'a>, String> {
        let at = self.at;
        self.next()?.ok_or_else(|| format!("byte {at}: an array ends before its data; save the file again"))
    }

    fn next(&mut self) -> Result<Option<Element<'a>>, String> {
        let at = self.at;
        if self.bytes.len() < 8 {
            return Ok(None);
        }
        let (first, second) = (self.word(0), self.word(4));
        // A short element has type and length in one word and its data in the other.
        let (kind, start, length) =
            if first >> 16 != 0 { (first & 0xffff, 4, (first >> 16) as usize) } else { (first, 8, second as usize) };
        let end = start + length;
        let data = self
            .bytes
            .get(start..end)
            .ok_or_else(|| format!("byte {at}: {length} bytes are stated, and the file ends; save it again"))?;
        // Elements begin at multiples of eight bytes, but for compressed ones.
        let whole = if start == 4 {
            8
        } else if kind == COMPRESSED {
            end
        } else {
            end.next_multiple_of(8)
        };
        let whole = whole.min(self.bytes.len());
        self.bytes = &self.bytes[whole..];
        self.at += whole;
        Ok(Some(Element { kind, data, at }))
    }

    fn word(&self, at: usize) -> u32 {
        self.words(&self.bytes[at..at + 4])[0]
    }

    fn words(&self, bytes: &[u8]) -> Vec<u32> {
        let word = |bytes: &[u8]| {
            let bytes = [bytes[0], bytes[1], bytes[2], bytes[3]];
            if self.is_big_endian { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) }
        };
        bytes.chunks_exact(4).map(word).collect()
    }

    /// The numbers of an element, in the type that they are stored in; `before` of the file are held already.
    fn numbers(&self, element: &Element<'_>, before: usize) -> Result<Vec<f64>, String> {
        let number = match element.kind {
            1 => Number::I8,
            2 => Number::U8,
            3 => Number::I16,
            4 => Number::U16,
            5 => Number::I32,
            6 => Number::U32,
            7 => Number::F32,
            9 => Number::F64,
            12 => Number::I64,
            13 => Number::U64,
            kind => {
                return Err(format!(
                    "byte {}: type {kind} of numbers is not known; save the file again with `save -v7`",
                    element.at
                ));
            }
        };
        if element.data.len() / number.bytes() > MOST_NUMBERS - before.min(MOST_NUMBERS) {
            return Err(format!("byte {}: the file holds more than {MOST_NUMBERS} numbers; save it in parts", element.at));
        }
        Ok(number.read(element.data, self.is_big_endian))
    }
}
