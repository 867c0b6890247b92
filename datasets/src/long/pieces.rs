//! Pieces of a long log, in its order.

use std::ops::Range;

use motion::Trajectory;

use super::LongFile;
use crate::formats::Rows;
use crate::{DatasetError, Log};

/// Lengths of the pieces of a log, samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Lengths {
    /// Samples of a piece itself.
    pub own: usize,
    /// Samples before it.
    pub before: usize,
    /// Samples after it.
    pub after: usize,
}

/// A piece of a log with what is before and after it.
#[derive(Debug, Clone)]
pub struct Piece {
    /// Sample of the log at which the trajectories begin.
    pub first: usize,
    /// The samples of the piece itself within them.
    pub own: Range<usize>,
    /// Commanded positions, mm or rad.
    pub reference: Trajectory,
    /// Reported positions; `None` in a file of references.
    pub actual: Option<Trajectory>,
}

impl Piece {
    /// The piece as a log; `None` in a file of references.
    #[must_use]
    pub fn into_log(self, name: impl Into<String>) -> Option<Log> {
        Log::new(name, self.reference, self.actual?).ok()
    }
}

/// The pieces of a log, read as they are asked for. What is held is one piece with what is beside it.
pub struct Pieces<'a> {
    file: &'a LongFile,
    rows: Box<dyn Rows>,
    lengths: Lengths,
    /// Samples that are held, and the sample of the log of the first of them.
    columns: Vec<Vec<f64>>,
    first: usize,
    /// Start of the next piece.
    next: usize,
}

impl std::fmt::Debug for Pieces<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Pieces").field("lengths", &self.lengths).field("next", &self.next).finish_non_exhaustive()
    }
}

impl<'a> Pieces<'a> {
    pub(super) fn new(file: &'a LongFile, lengths: Lengths) -> Result<Self, DatasetError> {
        let lengths = Lengths { own: lengths.own.max(1), ..lengths };
        let columns = vec![Vec::new(); file.positions().len()];
        Ok(Self { file, rows: file.rows_of(&file.positions())?, lengths, columns, first: 0, next: 0 })
    }

    /// Reads on up to the sample `end`.
    fn fill(&mut self, end: usize) -> Result<(), DatasetError> {
        let mut lines = Vec::new();
        loop {
            let held = self.first + self.columns[0].len();
            if held >= end {
                return Ok(());
            }
            if self.rows.read(end - held, &mut self.columns, &mut lines)? == 0 {
                return Err(DatasetError::format(&self.file.path, "the file became shorter while it was read"));
            }
        }
    }

    fn read(&mut self, own: Range<usize>) -> Result<Piece, DatasetError> {
        let from = own.start.saturating_sub(self.lengths.before);
        let end = (own.end + self.lengths.after).min(self.file.len());
        let held = self.first + self.columns[0].len();
        if held < from {
            self.rows.skip(from - held)?;
            self.columns.iter_mut().for_each(Vec::clear);
        } else {
            let done = from - self.first;
            self.columns.iter_mut().for_each(|column| drop(column.drain(..done)));
        }
        self.first = from;
        self.fill(end)?;
        let axes = self.file.axes();
        let of = |columns: &[Vec<f64>]| {
            let columns = columns.iter().map(|column| column[..end - from].to_vec()).collect();
            Trajectory::new(self.file.period_s(), axes.to_vec(), columns)
        };
        let (reference, actual) = self.columns.split_at(axes.len());
        let actual = (!actual.is_empty()).then(|| of(actual)).transpose()?;
        Ok(Piece { first: from, own: own.start - from..own.end - from, reference: of(reference)?, actual })
    }

    /// The samples `own` of the log as a piece; they begin nowhere before those of the last piece.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn at(&mut self, own: Range<usize>) -> Result<Piece, DatasetError> {
        self.next = own.end;
        self.read(own)
    }
}

impl Iterator for Pieces<'_> {
    type Item = Result<Piece, DatasetError>;

    fn next(&mut self) -> Option<Self::Item> {
        let end = (self.next + self.lengths.own).min(self.file.len());
        (end > self.next).then(|| {
            let own = self.next..end;
            self.next = end;
            self.read(own)
        })
    }
}
