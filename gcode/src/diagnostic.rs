//! Errors and warnings about a program, displayed with the line and a caret under the word.

use std::collections::HashMap;
use std::fmt::Write as _;

use crate::program::Program;
use crate::word::Span;

/// Longest part of a line that is displayed, bytes.
const SHOWN_BYTES: usize = 120;
/// Bytes displayed before the caret if the line is longer than that.
const SHOWN_BEFORE: usize = 60;

/// Lines and ranges of lines that a merged message names before it counts the others.
const RANGES_NAMED: usize = 5;

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

/// Texts of at most `most` diagnostics, as [`Diagnostic::render`] displays them. Those that differ by their place alone are one, at the first of
/// the places and with the lines of all. Also returns how many diagnostics are left out.
pub fn render_merged(diagnostics: &[Diagnostic], program: &Program, file_name: &str, most: usize) -> (Vec<String>, usize) {
    let mut groups: Vec<Vec<&Diagnostic>> = Vec::new();
    let mut known = HashMap::new();
    for diagnostic in diagnostics {
        let key = (diagnostic.severity, &diagnostic.message, &diagnostic.help);
        let group = *known.entry(key).or_insert(groups.len());
        if group == groups.len() {
            groups.push(Vec::new());
        }
        groups[group].push(diagnostic);
    }
    let text = |group: &Vec<&Diagnostic>| {
        let first = group[0];
        let lines = lines(group.iter().map(|of| of.line).collect());
        let message = lines.map_or_else(|| first.message.clone(), |lines| format!("{} ({lines})", first.message));
        Diagnostic { message, ..first.clone() }.render(program, file_name)
    };
    let left_out = groups.iter().skip(most).map(Vec::len).sum();
    (groups.iter().take(most).map(text).collect(), left_out)
}

/// Lines in words: `lines 12, 15-40 and 87 more`; `None` for a single one.
fn lines(mut of: Vec<usize>) -> Option<String> {
    of.sort_unstable();
    of.dedup();
    let ranges: Vec<&[usize]> = of.chunk_by(|before, after| before + 1 == *after).collect();
    let named: Vec<String> = ranges
        .iter()
        .take(RANGES_NAMED)
        .map(|range| match range {
            [first, .., last] => format!("{first}-{last}"),
            _ => range[0].to_string(),
        })
        .collect();
    let others: usize = ranges.iter().skip(RANGES_NAMED).map(|range| range.len()).sum();
    let more = if others > 0 { format!(" and {others} more") } else { String::new() };
    (of.len() > 1).then(|| format!("lines {}{more}", named.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parse;

    #[test]
    fn diagnostics_of_the_same_text_are_one_with_their_lines() {
        let program = parse("G1 X1\n".repeat(200));
        let on = |line: usize, message: &str| {
            let span = program.block_words(line - 1)[0].span;
            Diagnostic::new(&program, Severity::Warning, span, message)
        };
        let mut found: Vec<Diagnostic> = [12, 12].into_iter().chain(15..=40).map(|line| on(line, "same")).collect();
        found.push(on(50, "other"));
        found.push(on(51, "same").with_help("do"));
        let (texts, left_out) = render_merged(&found, &program, "a.nc", 2);
        assert_eq!((texts.len(), left_out), (2, 1));
        assert!(texts[0].starts_with("warning: same (lines 12, 15-40)\n  --> a.nc:12:1\n"), "{}", texts[0]);
        assert!(texts[1].starts_with("warning: other\n"), "{}", texts[1]);
        assert_eq!(lines((1..100).step_by(2).collect()).as_deref(), Some("lines 1, 3, 5, 7, 9 and 45 more"));
        assert_eq!(lines(vec![7, 7]), None);
    }

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
