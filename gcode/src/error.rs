//! What can go wrong with a program or with its editing.

use crate::diagnostic::Diagnostic;
use crate::word::Span;

/// The crate's one error.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GcodeError {
    /// The program holds something in a feed move that cannot be predicted, so that it is refused as a whole.
    #[error("the program is refused: {}", summary(.diagnostics))]
    Refused {
        /// Every fault found, up to a cap, in the order of the program, warnings included.
        diagnostics: Vec<Diagnostic>,
    },
    /// Two edits change the same bytes.
    #[error("two edits overlap: bytes {}..{} and {}..{}", .first.start, .first.end, .second.start, .second.end)]
    OverlappingEdits {
        /// The edit that comes first in the program.
        first: Span,
        /// The edit that runs into it.
        second: Span,
    },
    /// An edit names bytes that the program does not have.
    #[error("an edit of bytes {}..{} lies outside the program of {length} bytes", .span.start, .span.end)]
    OutsideProgram {
        /// The bytes named.
        span: Span,
        /// The program's length.
        length: usize,
    },
    /// A block index beyond the program's last block.
    #[error("block {block} does not exist: the program has {blocks}")]
    NoSuchBlock {
        /// The block asked for, from 0.
        block: usize,
        /// The number of blocks.
        blocks: usize,
    },
    /// A block whose motion cannot become several lines, because words before it and words after it share the line.
    #[error("line {line} cannot be split into {lines} lines: {reason}")]
    Unsplittable {
        /// The line, from 1.
        line: usize,
        /// How many lines were to replace its motion.
        lines: usize,
        /// Why not.
        reason: &'static str,
    },
    /// A number that a program cannot hold.
    #[error("{value} cannot be written as a coordinate")]
    NotFinite {
        /// The number.
        value: f64,
    },
}

fn summary(diagnostics: &[Diagnostic]) -> String {
    let mut errors = diagnostics.iter().filter(|d| d.is_error());
    match errors.next() {
        Some(first) => {
            let more = errors.count();
            let tail = if more > 0 { format!(" (and {more} more)") } else { String::new() };
            format!("line {}: {}{tail}", first.line, first.message)
        }
        None => "no reason given".to_owned(),
    }
}
