//! Collects diagnostics up to a largest number.

use crate::diagnostic::{Diagnostic, Severity};
use crate::program::Program;
use crate::word::Span;

/// Maximum number of errors: reading stops there.
const MOST_ERRORS: usize = 20;
/// Maximum number of warnings, about 3 MB.
const MOST_WARNINGS: usize = 10_000;

/// The diagnostics of one interpretation.
#[derive(Debug)]
pub(crate) struct Report<'a> {
    program: &'a Program,
    diagnostics: Vec<Diagnostic>,
    errors: usize,
    warnings: usize,
    /// The block whose state was reported last. Each cause is reported once.
    last_cause: Option<(&'static str, usize)>,
}

impl<'a> Report<'a> {
    /// A report with what evaluation noted.
    pub fn new(program: &'a Program) -> Self {
        let mut report = Self { program, diagnostics: Vec::new(), errors: 0, warnings: 0, last_cause: None };
        for note in program.execution().iter().flat_map(|execution| &execution.notes) {
            report.warning(note.span, note.message.as_str(), note.help);
        }
        report
    }

    pub fn error(&mut self, span: Span, message: impl Into<String>, help: Option<&str>) {
        self.errors += 1;
        if self.errors <= MOST_ERRORS {
            self.push(Severity::Error, span, message.into(), help);
        }
    }

    pub fn warning(&mut self, span: Span, message: impl Into<String>, help: Option<&str>) {
        self.warnings += 1;
        match self.warnings {
            ..=MOST_WARNINGS => self.push(Severity::Warning, span, message.into(), help),
            count if count == MOST_WARNINGS + 1 => {
                let message = format!("from this line on warnings are not listed: there are more than {MOST_WARNINGS}");
                self.push(Severity::Warning, span, message, None);
            }
            _ => {}
        }
    }

    /// Number of diagnostics so far.
    pub fn len(&self) -> usize {
        self.diagnostics.len()
    }

    /// Replaces a part of the message of an earlier diagnostic.
    pub fn amend(&mut self, index: usize, part: &str, with: &str) {
        if let Some(diagnostic) = self.diagnostics.get_mut(index) {
            diagnostic.message = diagnostic.message.replace(part, with);
        }
    }

    /// An error caused by an earlier block. Each cause is reported once.
    pub fn error_from(&mut self, kind: &'static str, cause: usize, span: Span, message: impl Into<String>, help: &str) {
        if self.last_cause != Some((kind, cause)) {
            self.last_cause = Some((kind, cause));
            self.error(span, message, Some(help));
        }
    }

    fn push(&mut self, severity: Severity, span: Span, message: String, help: Option<&str>) {
        let mut diagnostic = Diagnostic::new(self.program, severity, span, message);
        diagnostic.help = help.map(str::to_owned);
        self.diagnostics.push(diagnostic);
    }

    /// Whether the error cap is reached, so that reading can stop.
    pub fn is_full(&self) -> bool {
        self.errors >= MOST_ERRORS
    }

    pub fn has_errors(&self) -> bool {
        self.errors > 0
    }

    pub fn into_diagnostics(self) -> Vec<Diagnostic> {
        self.diagnostics
    }
}
