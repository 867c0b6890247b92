//! Recognition by the first bytes and by NUL bytes.

use super::kind::Foreign;
use crate::program::BYTE_ORDER_MARK;

/// Bytes that are searched for signs of UTF-16 and for plain text beside NUL bytes.
const SEARCHED: usize = 1 << 16;
/// Header and triangle of a binary STL file, bytes.
const STL_HEADER: usize = 84;
const STL_TRIANGLE: usize = 50;

/// First bytes of formats that are no text, or no program.
const SIGNATURES: [(&[u8], Foreign); 16] = [
    (b"%PDF-", Foreign::Document),
    (b"\x89PNG", Foreign::Document),
    (b"\xff\xd8\xff", Foreign::Document),
    (b"GIF8", Foreign::Document),
    (b"{\\rtf", Foreign::Document),
    (b"\xd0\xcf\x11\xe0", Foreign::Document),
    (b"AutoCAD Binary DXF", Foreign::Model("DXF")),
    (b"AC10", Foreign::Model("DWG")),
    (b"ISO-10303-21;", Foreign::Model("STEP")),
    (b"<?xml", Foreign::Markup),
    (b"<!doctype", Foreign::Markup),
    (b"<html", Foreign::Markup),
    (b"<svg", Foreign::Markup),
    (b"PK\x03\x04", Foreign::Binary),
    (b"\x1f\x8b", Foreign::Binary),
    (b"\x7fELF", Foreign::Binary),
];

/// Recognises content by its bytes.
pub(super) fn recognise(bytes: &[u8]) -> Option<Foreign> {
    if is_utf16(bytes) {
        return Some(Foreign::Utf16);
    }
    // The runout of a punched tape, or the padding of a file, is no content.
    let text = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
    let is_padding = |byte: &u8| byte.is_ascii_whitespace() || matches!(byte, 0 | 0x1a);
    let Some(start) = text.iter().position(|byte| !is_padding(byte)) else { return Some(Foreign::Empty) };
    let end = text.iter().rposition(|byte| !is_padding(byte)).map_or(start, |last| last + 1);
    let content = &text[start..end];
    let starts_with =
        |sign: &&(&[u8], Foreign)| content.get(..sign.0.len()).is_some_and(|head| head.eq_ignore_ascii_case(sign.0));
    if let Some((_, kind)) = SIGNATURES.iter().find(starts_with) {
        return Some(*kind);
    }
    if is_binary_stl(bytes) {
        return Some(Foreign::Model("STL"));
    }
    content.contains(&0).then(|| match content.windows(8).any(|run| run.eq_ignore_ascii_case(b"MAZATROL")) {
        true => Foreign::Mazatrol,
        false => Foreign::Binary,
    })
}

/// With a byte order mark, or as ASCII in which one byte of each two is NUL.
fn is_utf16(bytes: &[u8]) -> bool {
    if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
        return true;
    }
    let searched = &bytes[..bytes.len().min(SEARCHED) & !1];
    let pairs = searched.len() / 2;
    let nul = |parity: usize| searched.iter().skip(parity).step_by(2).filter(|byte| **byte == 0).count();
    let (even, odd) = (nul(0), nul(1));
    pairs > 1 && even.max(odd) * 10 >= pairs * 9 && even.min(odd) * 10 <= pairs
}

fn is_binary_stl(bytes: &[u8]) -> bool {
    let Some(Ok(count)) = bytes.get(STL_HEADER - 4..STL_HEADER).map(<[u8; 4]>::try_from) else { return false };
    let triangles = u32::from_le_bytes(count) as usize;
    triangles > 0 && triangles.checked_mul(STL_TRIANGLE).is_some_and(|length| length + STL_HEADER == bytes.len())
}
