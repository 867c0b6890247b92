//! What a job reports beside its result.

use precomp::output::Printer;
use serde_json::Value;

/// The figures of a job, as the command writes them by `--json`, and the lines that it prints.
#[derive(Debug, Clone, Default)]
pub struct Report {
    /// The figures.
    pub figures: Value,
    /// The lines.
    pub lines: Vec<String>,
}

impl Report {
    /// The figures with what was printed.
    pub fn new(figures: Value, printer: Printer) -> Self {
        Self { figures, lines: printer.into_lines() }
    }

    /// All lines as one text.
    pub fn text(&self) -> String {
        self.lines.join("\n")
    }

    /// The lines that warn, or say what is not known.
    pub fn warnings(&self) -> Vec<String> {
        self.lines.iter().filter(|line| ["warning", "note"].iter().any(|word| line.starts_with(word))).cloned().collect()
    }
}
