//! Findings about a log.

use std::fmt;

/// Severity of a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// Information.
    Note,
    /// Usable with reduced quality, or after a correction.
    Warn,
    /// Unfit for the purpose.
    Refuse,
}

/// Check that made a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Check {
    /// Sampling rate and length.
    Rate,
    /// Time stamps: gaps, jitter, duplicates.
    Timing,
    /// Rows or columns corrected or left out while reading.
    Mended,
    /// Digits of the positions.
    Digits,
    /// Axes without motion or without reversals.
    Motion,
    /// Command recorded in place of the actual position.
    Copied,
    /// Steps in the actual position: counter resets, lost rows.
    Jumps,
    /// Zeros and frozen values in the actual position.
    Dropout,
    /// Steps of the command that no machine can follow.
    Command,
    /// Swapped columns or axes, wrong sign, actual ahead of the command.
    Pairing,
    /// Implausible units and scales.
    Units,
    /// Runs that do not match.
    Runs,
}

impl Check {
    /// Short name, as printed before a finding.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Rate => "rate",
            Self::Timing => "timing",
            Self::Mended => "mended",
            Self::Digits => "digits",
            Self::Motion => "motion",
            Self::Copied => "copied",
            Self::Jumps => "jumps",
            Self::Dropout => "dropout",
            Self::Command => "command",
            Self::Pairing => "pairing",
            Self::Units => "units",
            Self::Runs => "runs",
        }
    }
}

/// Position of a finding in the data.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Place {
    /// Name of the run.
    pub run: Option<String>,
    /// Column by its internal name, as `x_act`.
    pub column: Option<String>,
    /// Sample, from 1 (data row of the file if it was not resampled).
    pub row: Option<usize>,
    /// Time since the first sample, s.
    pub time_s: Option<f64>,
}

/// One finding about a log; the message has the fault, its position and the remedy.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// Severity.
    pub severity: Severity,
    /// The check.
    pub check: Check,
    /// Position in the data.
    pub place: Place,
    /// Fault and remedy.
    pub message: String,
}

impl Finding {
    /// A finding without a position.
    #[must_use]
    pub fn new(severity: Severity, check: Check, message: impl Into<String>) -> Self {
        Self { severity, check, place: Place::default(), message: message.into() }
    }

    /// A finding about a column.
    #[must_use]
    pub fn in_column(mut self, column: impl Into<String>) -> Self {
        self.place.column = Some(column.into());
        self
    }

    /// A finding about sample `index` (from 0) of a log with this period.
    #[must_use]
    pub fn at_sample(mut self, index: usize, period_s: f64) -> Self {
        self.place.row = Some(index + 1);
        self.place.time_s = Some(index as f64 * period_s);
        self
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let severity = match self.severity {
            Severity::Note => "note",
            Severity::Warn => "warning",
            Severity::Refuse => "refused",
        };
        write!(f, "{severity} [{}]", self.check.name())?;
        let mut separator = " ";
        if let Some(run) = &self.place.run {
            write!(f, "{separator}{run}")?;
            separator = ", ";
        }
        if let Some(column) = &self.place.column {
            write!(f, "{separator}{column}")?;
            separator = ", ";
        }
        if let Some(row) = self.place.row {
            write!(f, "{separator}row {row}")?;
            separator = ", ";
        }
        if let Some(time_s) = self.place.time_s {
            write!(f, "{separator}t = {time_s:.3} s")?;
        }
        write!(f, ": {}", self.message)
    }
}

/// All findings about a log, in the order of the checks.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Report {
    /// The findings.
    pub findings: Vec<Finding>,
}

impl Report {
    /// Adds a finding.
    pub fn push(&mut self, finding: Finding) {
        self.findings.push(finding);
    }

    /// Adds another report's findings.
    pub fn extend(&mut self, other: Self) {
        self.findings.extend(other.findings);
    }

    /// The highest severity; `None` without findings.
    #[must_use]
    pub fn worst(&self) -> Option<Severity> {
        self.findings.iter().map(|finding| finding.severity).max()
    }

    /// Whether a finding forbids the purpose.
    #[must_use]
    pub fn is_refused(&self) -> bool {
        self.worst() == Some(Severity::Refuse)
    }

    /// Findings of one severity.
    pub fn of(&self, severity: Severity) -> impl Iterator<Item = &Finding> {
        self.findings.iter().filter(move |finding| finding.severity == severity)
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.findings.iter().try_for_each(|finding| writeln!(f, "{finding}"))
    }
}
