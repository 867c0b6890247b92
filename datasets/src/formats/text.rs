//! From the bytes of a text log to its lines: encodings, comments, line ends.

/// A line with data or a header.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Line<'a> {
    /// Number in the file, from 1.
    pub number: usize,
    /// Without line end and outer blanks other than tabs.
    pub text: &'a str,
}

/// Marks of comment lines.
pub(crate) const COMMENTS: [&str; 3] = ["#", "%", "//"];
/// Byte-order marks of UTF-16.
pub(crate) const UTF16: [&[u8]; 2] = [&[0xFF, 0xFE], &[0xFE, 0xFF]];

/// Bytes by whose zeros UTF-16 without a mark is recognised.
const SIGNS: usize = 64;

/// From two bytes to a unit of UTF-16, where bytes begin with its mark, or every other one of the first is zero as in plain text.
fn unit16(bytes: &[u8]) -> Option<fn([u8; 2]) -> u16> {
    let head = &bytes[..bytes.len().min(SIGNS)];
    let zeros = |from: usize| head.len() > 1 && head.iter().enumerate().all(|(at, byte)| (at % 2 == from) == (*byte == 0));
    if bytes.starts_with(UTF16[0]) || zeros(1) {
        Some(u16::from_le_bytes)
    } else if bytes.starts_with(UTF16[1]) || zeros(0) {
        Some(u16::from_be_bytes)
    } else {
        None
    }
}

/// Whether bytes are UTF-16.
pub(crate) fn is_utf16(bytes: &[u8]) -> bool {
    unit16(bytes).is_some()
}

/// The text of a log: UTF-8 or UTF-16, with or without a byte-order mark; bytes that are no
/// UTF-8 are taken as Latin-1. Otherwise `[µm]` of such a file would lose its `µ` and be metres. Lines that end with CR alone end with LF.
pub(crate) fn decode(bytes: &[u8]) -> String {
    let text = if let Some(read) = unit16(bytes) {
        let units: Vec<u16> = bytes.chunks_exact(2).map(|pair| read([pair[0], pair[1]])).collect();
        let text = String::from_utf16_lossy(&units);
        text.strip_prefix('\u{FEFF}').map(str::to_owned).unwrap_or(text)
    } else {
        let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
        let mut text = String::with_capacity(bytes.len());
        for chunk in bytes.utf8_chunks() {
            text.push_str(chunk.valid());
            text.extend(chunk.invalid().iter().copied().map(char::from));
        }
        text
    };
    if text.contains('\r') && !text.contains('\n') { text.replace('\r', "\n") } else { text }
}

/// End of a head of LabVIEW's measurement files (`.lvm`): the file's own, then that of each part.
pub(crate) const HEAD_END: &str = "***End_of_Header***";

/// Lines with content behind the heads of a measurement file, and the comment lines (`#`, `%`, `//`, without their mark) before the first of them.
pub(crate) fn lines(text: &str) -> (Vec<Line<'_>>, Vec<Line<'_>>) {
    let mut content = Vec::new();
    let mut comments = Vec::new();
    for (index, text) in text.split('\n').enumerate() {
        let number = index + 1;
        let text = text.trim_matches([' ', '\r']);
        let comment = COMMENTS.iter().find_map(|mark| text.strip_prefix(mark));
        match comment {
            Some(text) if content.is_empty() => comments.push(Line { number, text: text.trim() }),
            Some(_) => {}
            None if text.trim().is_empty() => {}
            None if text.starts_with(HEAD_END) => content.clear(),
            None => content.push(Line { number, text }),
        }
    }
    (content, comments)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn byte_order_marks_and_comments_are_taken_off() {
        assert_eq!(decode(b"\xEF\xBB\xBFt,x"), "t,x");
        assert_eq!(decode(b"\xFF\xFEt\0,\0"), "t,");
        assert_eq!(decode(b"\xFE\xFF\0t\0,"), "t,");
        assert_eq!([decode(b"t\0,\0"), decode(b"\0t\0,"), decode(b"t,\0"), decode(b"t")], ["t,", "t,", "t,\0", "t"]);
        assert_eq!(decode(b"t,x\r1,2\r"), "t,x\n1,2\n");
        assert_eq!(decode(b"x_ist [\xB5m]"), "x_ist [µm]");
        let (content, comments) = lines("# t x\r\n\r\n 1 2 \n# later\n3\t\n");
        assert_eq!(comments[0].text, "t x");
        assert_eq!(content.len(), 2);
        assert_eq!((content[0].number, content[0].text), (3, "1 2"));
        assert_eq!((content[1].number, content[1].text), (5, "3\t"));
        let lab = lines("Separator\tTab\n***End_of_Header***\t\nSamples\t5\n***End_of_Header***\nX_Value\tx\n0\t1\n").0;
        assert_eq!(lab.iter().map(|line| line.number).collect::<Vec<_>>(), [5, 6]);
    }
}
