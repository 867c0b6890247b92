//! What a table came to: figures for JSON, and sections of the page.

use serde_json::Value;

use super::picture::Picture;

/// Figures of a table of the papers.
#[derive(Debug, Default)]
pub(super) struct Found {
    /// Tables of `--json`.
    pub tables: Vec<Value>,
    /// Sections of `--page`.
    pub sections: Vec<Section>,
}

impl Found {
    pub(super) fn extend(&mut self, other: Self) {
        self.tables.extend(other.tables);
        self.sections.extend(other.sections);
    }

    /// Adds what is not reproduced of the papers that are here.
    pub(super) fn add_missing(&mut self, missing: Vec<Section>) {
        let papers: Vec<char> = self.sections.iter().map(|section| section.paper).collect();
        self.sections.extend(missing.into_iter().filter(|section| papers.contains(&section.paper)));
    }
}

/// A table or figure of a paper.
#[derive(Debug)]
pub(super) struct Section {
    /// Letter of the paper.
    pub paper: char,
    /// Table or figure, as the paper numbers it, and what it shows.
    pub title: String,
    /// Settings and reading.
    pub note: String,
    pub entries: Vec<Entry>,
    /// Shown below the entries.
    pub pictures: Vec<Picture>,
}

/// A printed value beside the measured one.
#[derive(Debug)]
pub(super) struct Entry {
    pub what: String,
    pub unit: &'static str,
    pub printed: Printed,
    /// `None` where it is not reproduced.
    pub measured: Option<f64>,
    /// Why the two differ, or what is missing.
    pub why: &'static str,
}

/// What a paper prints.
#[derive(Debug, Clone)]
pub(super) enum Printed {
    Value(f64),
    /// In words, as in "diverges".
    Words(String),
    /// A row of our own.
    None,
}

impl From<Option<f64>> for Printed {
    /// Nothing where the value is missing or not finite.
    fn from(value: Option<f64>) -> Self {
        value.filter(|value| value.is_finite()).map_or(Self::None, Self::Value)
    }
}

impl Entry {
    /// An entry in µm, measured in mm.
    pub(super) fn um(what: impl Into<String>, printed: impl Into<Printed>, measured_mm: f64, why: &'static str) -> Self {
        Self::of(what, "µm", printed, measured_mm * 1e3, why)
    }

    pub(super) fn of(
        what: impl Into<String>,
        unit: &'static str,
        printed: impl Into<Printed>,
        measured: f64,
        why: &'static str,
    ) -> Self {
        Self { what: what.into(), unit, printed: printed.into(), measured: Some(measured), why }
    }
}
