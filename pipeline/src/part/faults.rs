//! Program faults, reported with their lines.

use gcode::{Diagnostic, GcodeError, Program, Severity, Toolpath};
use motion::MotionError;

use crate::error::Error;

/// A planning fault, reported at the program line of its path segment.
pub(super) fn on_line(error: MotionError, owners: &[Option<usize>], toolpath: &Toolpath, program: &Program, name: &str) -> Error {
    // A segment that the program does not state leads to the next move.
    let owner = error.piece().and_then(|piece| owners[piece..].iter().flatten().next().copied());
    let Some(owner) = owner else { return error.into() };
    let what = match &error {
        MotionError::UnreachableOnPath { what, .. } => format!("this move cannot be run on the machine: {what}"),
        MotionError::Infeasible { what, .. } => format!("no feed holds the machine's limits in this move: {what}"),
        other => other.to_string(),
    };
    on_move(toolpath, owner, program, name, what)
}

/// The errors of a program that is refused, as text with its lines.
pub(crate) fn refused(error: GcodeError, program: &Program, name: &str) -> Error {
    match error {
        GcodeError::Refused { diagnostics } => {
            let text = render(&diagnostics, program, name);
            Error::Program { diagnostics, text }
        }
        other => other.into(),
    }
}

/// A fault of a move: its line and a caret under its first word.
pub(super) fn on_move(toolpath: &Toolpath, owner: usize, program: &Program, name: &str, what: String) -> Error {
    let block = toolpath.moves[owner].block as usize;
    let span = program.block_words(block).first().map_or(program.blocks()[block].span, |word| word.span);
    let diagnostics = vec![Diagnostic::new(program, Severity::Error, span, what)];
    let text = render(&diagnostics, program, name);
    Error::Program { diagnostics, text }
}

/// The same error with the warnings of the program: they name the options that help.
pub(super) fn with_warnings(error: Error, toolpath: &Toolpath, program: &Program, name: &str) -> Error {
    let Error::Program { mut diagnostics, .. } = error else { return error };
    diagnostics.extend_from_slice(&toolpath.warnings);
    Error::Program { text: render(&diagnostics, program, name), diagnostics }
}

/// Warnings that are listed beside errors.
const WARNINGS: usize = 20;

/// Text of the faults of a program, errors first, each with its line and a caret under the word. The first fault has no
/// `error:` label, so that the caller can print its own. Warnings of the same text are one.
#[must_use]
pub fn render(diagnostics: &[Diagnostic], program: &Program, name: &str) -> String {
    let (errors, warnings): (Vec<Diagnostic>, Vec<_>) = diagnostics.iter().cloned().partition(Diagnostic::is_error);
    let (warnings, left_out) = gcode::render_merged(&warnings, program, name, WARNINGS);
    let more = (left_out > 0).then(|| format!("warning: {left_out} more warnings"));
    let errors = errors.iter().map(|error| error.render(program, name));
    let text = errors.chain(warnings).chain(more).collect::<Vec<String>>().join("\n");
    text.strip_prefix("error: ").unwrap_or(&text).trim_end().to_owned()
}
