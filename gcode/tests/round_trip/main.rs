//! No byte is lost and nothing panics, for any input.

mod dialogue;
mod rs274;

use gcode::{Edits, GcodeError, Options, Program, Span, edit, interpret};
use proptest::prelude::*;

/// Blocks tile the program behind its byte order mark, words lie in order inside their block, and only blanks lie between them.
fn check_bytes(program: &Program, bytes: &[u8]) -> Result<(), TestCaseError> {
    let kept = edit(program, &Edits::new());
    prop_assert_eq!(kept.as_deref(), Ok(bytes));
    let mut at = if bytes.starts_with("\u{feff}".as_bytes()) { 3 } else { 0 };
    for (index, block) in program.blocks().iter().enumerate() {
        prop_assert_eq!(block.span.start, at);
        let mut cursor = block.span.start;
        for word in program.block_words(index) {
            prop_assert!(word.span.start >= cursor && word.span.end <= block.span.end && !word.span.is_empty());
            prop_assert!(word.value_start >= word.span.start && word.value_start <= word.span.end);
            let gap = program.text(Span { start: cursor, end: word.span.start });
            prop_assert!(gap.iter().all(|b| matches!(b, b' ' | b'\t')));
            cursor = word.span.end;
        }
        let rest = program.text(Span { start: cursor, end: block.span.end });
        prop_assert!(rest.iter().all(|b| matches!(b, b' ' | b'\t')));
        at = block.next;
    }
    prop_assert_eq!(at as usize, bytes.len());
    Ok(())
}

/// A program is interpreted, or refused with errors. What comes back can be read.
fn check_interpretation(program: &Program, options: &Options) -> Result<(), TestCaseError> {
    match interpret(program, options) {
        Ok(toolpath) => {
            for step in &toolpath.moves {
                prop_assert!((step.block as usize) < program.blocks().len());
                step.words(program);
                step.point_mm(0.5);
                prop_assert!(step.length_mm().is_none_or(|length| length >= 0.0 && length.is_finite()));
                toolpath.modal(step);
            }
            for warning in &toolpath.warnings {
                warning.render(program, "a.nc");
            }
        }
        Err(GcodeError::Refused { diagnostics }) => {
            prop_assert!(diagnostics.iter().any(|d| d.is_error()));
            for diagnostic in &diagnostics {
                prop_assert!(diagnostic.render(program, "a.nc").contains('^'));
            }
        }
        Err(other) => return Err(TestCaseError::fail(other.to_string())),
    }
    Ok(())
}
