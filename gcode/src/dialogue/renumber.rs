//! Block numbers. The control numbers the blocks of a program in ascending order, one by one.

use super::block::continues;
use crate::edit::{Edits, edit};
use crate::error::GcodeError;
use crate::program::Program;
use crate::word::Span;

/// Numbers the blocks of a dialogue program one by one from its first number. Bytes other than numbers stay. A program whose first block has no
/// number is returned unchanged.
///
/// # Errors
/// Never for a parsed program; those of [`edit`].
pub fn renumber(program: &Program) -> Result<Vec<u8>, GcodeError> {
    let first = program.words().first().filter(|word| word.is(b'N')).and_then(|word| word.number());
    let Some(first) = first.filter(|number| *number <= f64::from(u32::MAX)) else { return Ok(program.bytes().to_vec()) };
    let mut edits = Edits::new();
    let mut number = first as u64;
    for index in 0..program.blocks().len() {
        let Some(word) = program.block_words(index).first() else { continue };
        if continues(program, index) {
            continue;
        }
        if word.is(b'N') {
            if word.value != number as f64 {
                edits.replace(word.span, number.to_string());
            }
        } else {
            edits.replace(Span { start: word.span.start, end: word.span.start }, format!("{number} "));
        }
        number += 1;
    }
    edit(program, &edits)
}
