//! Errors and warnings about a program, displayed with the line and a caret under the word.

use std::fmt::Write as _;

use crate::program::Program;
use crate::word::Span;

/// Longest part of a line that is displayed, bytes.
const SHOWN_BYTES: usize = 120;
/// Bytes displayed before the caret if the line is longer than that.
const SHOWN_BEFORE: usize = 60;

/// Severity of a diagnostic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Severity {
    /// The program is refused.
    Error,
    /// The program is accepted. The user should know of the condition.
    Warning,
}

/// One error or warning with the bytes that it refers to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// Severity.
    pub severity: Severity,
    /// The message, one line without a full stop.
    pub message: String,
    /// Line, from 1.
    pub line: usize,
    /// Column of the first byte, from 1, in bytes.
    pub column: usize,
    /// The bytes that the message refers to.
    pub span: Span,
    /// Remedy.
    pub help: Option<String>,
}

impl Diagnostic {
    /// A message about bytes of a program.
    pub fn new(program: &Program, severity: Severity, span: Span, message: impl Into<String>) -> Self {
        let block = program.block_at(span.start);
        let start = program.blocks().get(block).map_or(0, |b| b.span.start);
        let column = span.start.saturating_sub(start) as usize + 1;
        Self { severity, message: message.into(), line: block + 1, column, span, help: None }
    }

    /// Adds a remedy.
    #[must_use]
    pub fn with_help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// Whether the program is refused.
    pub fn is_error(&self) -> bool {
        self.severity == Severity::Error
    }

    /// Renders the message with its line and a caret under the word.
    ///
    /// Bytes beyond ASCII are shown as Latin-1 and control characters as blanks, one column each.
    pub fn render(&self, program: &Program, file_name: &str) -> String {
        let label = match self.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
        };
        let line = program.blocks().get(self.line.saturating_sub(1)).map_or(&[][..], |b| program.text(b.span));
        let at = self.column.saturating_sub(1).min(line.len());
        let from = if line.len() > SHOWN_BYTES { at.saturating_sub(SHOWN_BEFORE) } else { 0 };
        let to = line.len().min(from + SHOWN_BYTES);
        let shown: String = line[from..to].iter().map(|b| if b.is_ascii_control() { ' ' } else { char::from(*b) }).collect();
        let carets = self.span.len().min(to.saturating_sub(at)).max(1);
        let number = self.line.to_string();
        let margin = " ".repeat(number.len());
        let mut text = String::new();
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{label}: {}", self.message);
        let _ = writeln!(text, "{margin}--> {file_name}:{}:{}", self.line, self.column);
        let _ = writeln!(text, "{margin} |");
        let _ = writeln!(text, "{number} | {}", shown.trim_end());
        let _ = writeln!(text, "{margin} | {}{}", " ".repeat(at - from), "^".repeat(carets));
        if let Some(help) = &self.help {
            let _ = writeln!(text, "{margin} = help: {help}");
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parse;

    #[test]
    fn a_caret_stands_under_the_word() {
        let program = parse(b"G21\nN1\tG1 X\xe9 Y#1\n".to_vec());
        let word = program.words()[program.find(1, b'Y').expect("there is a Y")];
        let text = Diagnostic::new(&program, Severity::Error, word.span, "no").with_help("do").render(&program, "a.nc");
        assert_eq!(text, "error: no\n --> a.nc:2:10\n  |\n2 | N1 G1 X\u{e9} Y#1\n  |          ^^^\n  = help: do\n");
    }

    #[test]
    fn long_lines_are_cut_around_the_caret() {
        let program = parse(format!("{}X#1{}", "(a) ".repeat(500), " (b)".repeat(500)));
        let word = program.words()[program.find(0, b'X').expect("there is an X")];
        let text = Diagnostic::new(&program, Severity::Warning, word.span, "long").render(&program, "a.nc");
        let lines: Vec<_> = text.lines().collect();
        assert!(lines[3].len() < 140 && lines[3].contains("X#1"));
        assert_eq!(lines[3].find("X#1"), lines[4].find("^^^"));
    }
}
