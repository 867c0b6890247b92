//! Program edits as patches of byte spans. Bytes outside the patches do not change.

use std::ops::Range;

use crate::error::GcodeError;
use crate::program::Program;
use crate::word::Span;

#[derive(Clone, Debug)]
struct Patch {
    span: Span,
    text: Vec<u8>,
    /// Whether it was inserted after a block, and belongs to that one.
    follows: bool,
}

/// Edits of one program, collected in any order and applied together by [`edit`].
#[derive(Clone, Debug, Default)]
pub struct Edits {
    patches: Vec<Patch>,
}

impl Edits {
    /// No edits.
    pub fn new() -> Self {
        Self::default()
    }

    /// Whether there are no edits.
    pub fn is_empty(&self) -> bool {
        self.patches.is_empty()
    }

    /// Number of patches.
    pub fn len(&self) -> usize {
        self.patches.len()
    }

    /// Replaces the bytes of a span; an empty span inserts, an empty text deletes.
    ///
    /// Several insertions at one offset keep their order.
    pub fn replace(&mut self, span: Span, text: impl Into<Vec<u8>>) {
        self.patches.push(Patch { span, text: text.into(), follows: false });
    }

    /// Inserts whole lines before a block, with the program's line ending.
    ///
    /// # Errors
    /// [`GcodeError::NoSuchBlock`].
    pub fn insert_before<L: AsRef<[u8]>>(&mut self, program: &Program, block: usize, lines: &[L]) -> Result<(), GcodeError> {
        let start = existing(program, block)?.span.start;
        let text = joined(program, lines, false);
        if !text.is_empty() {
            self.replace(Span { start, end: start }, text);
        }
        Ok(())
    }

    /// Inserts whole lines after a block, with the program's line ending.
    ///
    /// # Errors
    /// [`GcodeError::NoSuchBlock`].
    pub fn insert_after<L: AsRef<[u8]>>(&mut self, program: &Program, block: usize, lines: &[L]) -> Result<(), GcodeError> {
        let here = existing(program, block)?;
        // A last line without a line ending keeps none: the ending is written before the new lines.
        let text = joined(program, lines, here.next == here.span.end);
        if !text.is_empty() {
            self.patches.push(Patch { span: Span { start: here.next, end: here.next }, text, follows: true });
        }
        Ok(())
    }
}

fn existing(program: &Program, block: usize) -> Result<crate::program::Block, GcodeError> {
    program.blocks().get(block).copied().ok_or(GcodeError::NoSuchBlock { block, blocks: program.blocks().len() })
}

fn joined<L: AsRef<[u8]>>(program: &Program, lines: &[L], ending_first: bool) -> Vec<u8> {
    let mut text = Vec::new();
    for line in lines {
        if ending_first {
            text.extend_from_slice(program.line_ending());
        }
        text.extend_from_slice(line.as_ref());
        if !ending_first {
            text.extend_from_slice(program.line_ending());
        }
    }
    text
}

/// Applies edits to a program and returns the new bytes. No edits: the bytes are unchanged.
///
/// # Errors
/// [`GcodeError::OverlappingEdits`] if two edits name the same byte or one inserts inside the span
/// of the other, [`GcodeError::OutsideProgram`] for bytes beyond the program.
pub fn edit(program: &Program, edits: &Edits) -> Result<Vec<u8>, GcodeError> {
    patched(program, 0..program.bytes().len(), edits.patches.iter().collect())
}

/// Same as [`edit`], for the bytes of some blocks; the bytes before the first block belong to it. Edits of other blocks are left out, those
/// behind the last block as well.
///
/// # Errors
/// As [`edit`].
pub fn edit_blocks(program: &Program, blocks: Range<usize>, edits: &Edits) -> Result<Vec<u8>, GcodeError> {
    let start = |block: usize| match (block, program.blocks().get(block)) {
        (0, _) => 0,
        (_, Some(block)) => block.span.start as usize,
        (_, None) => program.bytes().len(),
    };
    let bytes = start(blocks.start)..start(blocks.end);
    let is_last = bytes.end == program.bytes().len();
    // What is inserted where the next block starts stands before that block, unless it follows the last one.
    let own = |patch: &&Patch| {
        let at = patch.span.start as usize;
        at >= bytes.start
            && (at < bytes.end || is_last || patch.follows && at == bytes.end)
            && !(patch.follows && at == bytes.start)
    };
    let patches = edits.patches.iter().filter(own).collect();
    patched(program, bytes, patches)
}

fn patched(program: &Program, range: Range<usize>, mut order: Vec<&Patch>) -> Result<Vec<u8>, GcodeError> {
    let bytes = program.bytes();
    // Stable sort: insertions at one offset keep their order and precede a replacement that starts
    // there.
    order.sort_by_key(|patch| (patch.span.start, patch.span.end));
    let added: usize = order.iter().map(|patch| patch.text.len()).sum();
    let mut out = Vec::with_capacity(range.len() + added);
    let mut done = Span { start: range.start as u32, end: range.start as u32 };
    for patch in order {
        let Span { start, end } = patch.span;
        if start > end || end as usize > bytes.len() {
            return Err(GcodeError::OutsideProgram { span: patch.span, length: bytes.len() });
        }
        if start < done.end {
            return Err(GcodeError::OverlappingEdits { first: done, second: patch.span });
        }
        out.extend_from_slice(&bytes[done.end as usize..start as usize]);
        out.extend_from_slice(&patch.text);
        done = patch.span;
    }
    out.extend_from_slice(&bytes[done.end as usize..range.end]);
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parse;

    #[test]
    fn words_and_lines_are_patched() {
        let program = parse("%\r\nG1 X1 Y2 (keep)\r\nM30");
        let mut edits = Edits::new();
        let word = program.words()[program.find(1, b'X').expect("there is an X")];
        edits.replace(word.value_span(), "1.25");
        edits.insert_before(&program, 1, &["G64 P0.01"]).expect("block 1 exists");
        edits.insert_after(&program, 1, &["X3", "X4"]).expect("block 1 exists");
        edits.insert_after(&program, 2, &["%"]).expect("block 2 exists");
        let text = edit(&program, &edits).expect("no overlap");
        assert_eq!(text, b"%\r\nG64 P0.01\r\nG1 X1.25 Y2 (keep)\r\nX3\r\nX4\r\nM30\r\n%");
    }

    #[test]
    fn carriage_returns_alone_end_lines_that_are_put_in() {
        let program = parse("%\rG1 X1 F100\rM30\r");
        let mut edits = Edits::new();
        edits.replace_motion(&program, 1, crate::Dialect::Fanuc, &["G1 X0.5 F100", "X1."]).expect("it can be split");
        assert_eq!(program.blocks().len(), 3);
        assert_eq!(edit(&program, &edits).expect("no overlap"), b"%\rG1 X0.5 F100\rX1.\rM30\r");
    }

    #[test]
    fn the_edits_of_all_parts_are_those_of_the_whole() {
        let program = parse("\u{feff}%\nG1 X1\n\nX2\nX3");
        let mut edits = Edits::new();
        for block in 0..program.blocks().len() {
            edits.insert_before(&program, block, &[format!("(before {block})")]).expect("it exists");
            edits.insert_after(&program, block, &[format!("(after {block})")]).expect("it exists");
        }
        let whole = edit(&program, &edits).expect("no overlap");
        for cut in 0..=program.blocks().len() {
            let part = |blocks| edit_blocks(&program, blocks, &edits).expect("no overlap");
            let (first, second) = (part(0..cut), part(cut..program.blocks().len()));
            let text = String::from_utf8_lossy(&first).into_owned();
            assert_eq!([first, second].concat(), whole, "{cut}");
            assert!(
                !text.contains(&format!("(before {cut})")) && (cut == 0 || text.contains(&format!("(after {})", cut - 1))),
                "{text}"
            );
        }
    }

    #[test]
    fn conflicts_are_found() {
        let program = parse("G1 X1 Y2");
        let mut edits = Edits::new();
        edits.replace(Span { start: 3, end: 5 }, "X2");
        edits.replace(Span { start: 4, end: 8 }, "3");
        assert!(matches!(edit(&program, &edits), Err(GcodeError::OverlappingEdits { .. })));
        let mut outside = Edits::new();
        outside.replace(Span { start: 7, end: 9 }, "");
        assert!(matches!(edit(&program, &outside), Err(GcodeError::OutsideProgram { .. })));
        assert!(matches!(outside.insert_after(&program, 1, &["X"]), Err(GcodeError::NoSuchBlock { block: 1, blocks: 1 })));
    }
}
