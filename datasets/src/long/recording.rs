//! Recordings of training: held in memory, or in a file of any length.

use std::ops::Range;

use motion::Axis;

use super::{Extent, Lengths, LongFile};
use crate::quality::which_move;
use crate::{DatasetError, Log};

/// A recorded run.
#[derive(Debug)]
pub enum Recording {
    /// In memory.
    Held(Log),
    /// In a file that is read in pieces.
    File(LongFile),
}

impl From<Log> for Recording {
    fn from(log: Log) -> Self {
        Self::Held(log)
    }
}

impl Recording {
    /// The axes, in column order.
    #[must_use]
    pub fn axes(&self) -> &[Axis] {
        match self {
            Self::Held(log) => log.axes(),
            Self::File(file) => file.axes(),
        }
    }

    /// Time between samples, s.
    #[must_use]
    pub fn period_s(&self) -> f64 {
        match self {
            Self::Held(log) => log.period_s(),
            Self::File(file) => file.period_s(),
        }
    }

    /// Time stamp of the first sample, s.
    #[must_use]
    pub fn start_s(&self) -> f64 {
        match self {
            Self::Held(log) => log.start_s,
            Self::File(file) => file.start_s(),
        }
    }

    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::Held(log) => log.len(),
            Self::File(file) => file.len(),
        }
    }

    /// Whether there is no sample.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Name of the run.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Self::Held(log) => log.name.clone(),
            Self::File(file) => file.name(),
        }
    }

    /// Extents of the commanded positions, one an axis.
    #[must_use]
    pub fn extents(&self) -> Vec<Extent> {
        match self {
            Self::Held(log) => log.reference.columns().iter().map(|column| Extent::of(column)).collect(),
            Self::File(file) => file.extents().to_vec(),
        }
    }

    /// Indices of the axes whose command moves.
    #[must_use]
    pub fn moving_axes(&self) -> Vec<usize> {
        let ranges = self.axes().iter().zip(self.extents()).map(|(axis, extent)| (axis.kind, extent.high - extent.low));
        let moves = which_move(&ranges.collect::<Vec<_>>());
        moves.into_iter().enumerate().filter(|(_, moves)| *moves).map(|(index, _)| index).collect()
    }

    /// The samples `rows`, which are in order and disjoint, each behind up to `lead` samples of what came before, as logs of the name of the
    /// run, to `take`.
    ///
    /// # Errors
    /// When the file cannot be read, or `take` fails.
    pub fn read(
        &self,
        rows: impl Iterator<Item = Range<usize>>,
        lead: usize,
        mut take: impl FnMut(Log, Range<usize>) -> Result<(), DatasetError>,
    ) -> Result<(), DatasetError> {
        match self {
            Self::Held(log) => rows.into_iter().try_for_each(|rows| {
                let before = rows.start.min(lead);
                take(log.part(log.name.clone(), rows.start - before, rows.end)?, before..before + rows.len())
            }),
            Self::File(file) => {
                let mut pieces = file.pieces(Lengths { own: 1, before: lead, after: 0 })?;
                rows.into_iter().try_for_each(|rows| {
                    let piece = pieces.at(rows)?;
                    let (own, start_s) = (piece.own.clone(), file.start_s() + piece.first as f64 * file.period_s());
                    let log = piece.into_log(file.name()).map(|log| log.starting_at(start_s));
                    log.map_or(Ok(()), |log| take(log, own))
                })
            }
        }
    }

    /// The whole run in memory.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn into_log(self) -> Result<Log, DatasetError> {
        match self {
            Self::Held(log) => Ok(log),
            Self::File(_) => {
                let mut whole = None;
                self.read(std::iter::once(0..self.len()), 0, |log, _| {
                    whole = Some(log);
                    Ok(())
                })?;
                whole.ok_or_else(|| DatasetError::Runs(format!("`{}` holds no run", self.name())))
            }
        }
    }
}
