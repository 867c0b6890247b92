//! Faults of a file, with their places.

use std::fmt;

use super::places::{Place, Places, Step};

/// A fault of a machine file or controller profile.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct FileFault {
    /// Line, from 1.
    pub line: usize,
    /// Column, from 1, characters.
    pub column: usize,
    /// What is wrong there, and the remedy.
    pub message: String,
}

impl fmt::Display for FileFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}, column {}: {}", self.line, self.column, self.message)
    }
}

/// Faults of one file, in the order of their places.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileFaults(Vec<FileFault>);

impl FileFaults {
    /// A single fault.
    pub(super) fn one(place: Place, message: String) -> Self {
        Self(vec![FileFault { line: place.line, column: place.column, message }])
    }

    /// The faults, in the order of their places; never none.
    #[must_use]
    pub fn all(&self) -> &[FileFault] {
        &self.0
    }
}

impl fmt::Display for FileFaults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let [only] = self.0.as_slice() {
            return only.fmt(f);
        }
        write!(f, "{} faults", self.0.len())?;
        self.0.iter().try_for_each(|fault| write!(f, "\n  {fault}"))
    }
}

/// Gathers the faults of a file.
pub(super) struct Gathered<'a> {
    pub places: &'a Places<'a>,
    found: Vec<FileFault>,
}

impl<'a> Gathered<'a> {
    pub(super) const fn new(places: &'a Places<'a>) -> Self {
        Self { places, found: Vec::new() }
    }

    /// Adds a fault of the key or value at `path`: what `say` makes of its label.
    pub(super) fn add(&mut self, path: &[Step], say: impl FnOnce(&str) -> String) {
        let place = self.places.of(path);
        self.found.push(FileFault { line: place.line, column: place.column, message: say(&place.label) });
    }

    /// The faults, if any.
    pub(super) fn into_faults(self) -> Option<FileFaults> {
        let mut found = self.found;
        // A drive that several axes share has each fault once.
        found.sort();
        found.dedup();
        (!found.is_empty()).then_some(FileFaults(found))
    }
}

/// The faults that the parser of TOML found.
pub(super) fn of_syntax(errors: &[toml::de::Error], places: &Places<'_>) -> FileFaults {
    let fault = |error: &toml::de::Error| {
        let (line, column) = places.line_and_column(error.span().map_or(0, |span| span.start));
        FileFault { line, column, message: error.message().to_owned() }
    };
    FileFaults(errors.iter().map(fault).collect())
}
