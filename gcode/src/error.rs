//! Errors of reading and editing programs.

use crate::diagnostic::Diagnostic;
use crate::word::Span;

/// Errors of this crate.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GcodeError {
    /// A feed move depends on something that cannot be predicted. The whole program is refused.
    #[error("the program is refused: {}", summary(.diagnostics))]
    Refused {
        /// All errors found, up to a cap, in program order, warnings included.
        diagnostics: Vec<Diagnostic>,
    },
    /// Two edits change the same bytes.
    #[error("two edits overlap: bytes {}..{} and {}..{}", .first.start, .first.end, .second.start, .second.end)]
    OverlappingEdits {
        /// The edit that comes first in the program.
        first: Span,
        /// The edit that overlaps it.
        second: Span,
    },
    /// An edit names bytes beyond the program.
    #[error("an edit of bytes {}..{} lies outside the program of {length} bytes", .span.start, .span.end)]
    OutsideProgram {
        /// The byte range named by the edit.
        span: Span,
        /// Length of the program, bytes.
        length: usize,
    },
    /// A block index beyond the last block.
    #[error("block {block} does not exist: the program has {blocks}")]
    NoSuchBlock {
        /// Block index, from 0.
        block: usize,
        /// Number of blocks.
        blocks: usize,
    },
    /// A block whose motion cannot be split into several lines, because the line holds words that
    /// act before the motion and words that act after it.
    #[error("line {line} cannot be split into {lines} lines: {reason}")]
    Unsplittable {
        /// The line, from 1.
        line: usize,
        /// Number of lines that were to replace the motion.
        lines: usize,
        /// Reason.
        reason: &'static str,
    },
    /// A number that has no G-code form: NaN or infinite.
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
