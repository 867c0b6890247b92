//! What is measured of a run.

use motion::contour::{CircularTest, ContourError, ContourSummary};
use motion::{Axis, Vec3};

use super::matching::Match;
use super::reversals::Reversal;
use crate::statistics::OrientationSummary;

/// Number of worst positions that are reported, and their least distance in time, s.
pub(super) const WORST: usize = 5;
pub(super) const APART_S: f64 = 0.05;

/// Measurement of a run. Lengths in mm, times in s.
#[derive(Debug)]
pub struct Measurement {
    /// Axes of the log.
    pub axes: Vec<Axis>,
    /// RMS and largest tracking error of every axis, mm or rad.
    pub tracking: Vec<(f64, f64)>,
    /// Contour error, every sample of the path counted once: of a program those of feed moves, of a reference all. MAX is that of all samples of
    /// the run.
    pub contour: ContourSummary,
    /// Error of the tool orientation; `None` on a machine without rotary axes.
    pub orientation: Option<OrientationSummary>,
    /// Alignment of the run with the path.
    pub matched: Match,
    /// Lag of every axis's actual position behind its command, s; `None` where the axis does not move.
    pub lags_s: Vec<Option<f64>>,
    /// Reversals of the linear axes, in order of time; of a log that was read in pieces those with the largest glitches.
    pub reversals: Vec<Reversal>,
    /// Number of all reversals.
    pub reversals_found: usize,
    /// Positions of the largest contour errors, largest first; rapids are excluded.
    pub worst: Vec<WorstPoint>,
    /// Segments in order: program lines with feed moves, or motion between standstills; of a log that was read in pieces those with the
    /// largest RMS.
    pub segments: Vec<Segment>,
    /// Number of all segments.
    pub segments_found: usize,
    /// Circular-test figures; `None` where the path is not a full circle.
    pub circle: Option<CircularTest>,
    /// Contour error of every sample of the run; none of a log that was read in pieces.
    pub errors: Vec<ContourError>,
    /// Weight of each of these samples in the figures, so that every sample of the path counts once; `None` where it does not count.
    pub weights: Vec<Option<f64>>,
}

/// A position in a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorstPoint {
    /// Time in the log, s.
    pub time_s: f64,
    /// Foot point on the desired path, mm.
    pub at: Vec3,
    /// Contour error, mm.
    pub error_mm: f64,
    /// Program line, from 1; `None` without a program.
    pub line: Option<usize>,
}

/// A segment of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// Program line, from 1; `None` without a program.
    pub line: Option<usize>,
    /// Time of its first sample, s.
    pub from_s: f64,
    /// Contour error over the segment.
    pub contour: ContourSummary,
    /// Number of samples.
    pub samples: usize,
}

impl Measurement {
    /// Common lag of all axes, s: the mean over the moving axes. It has little effect on the contour.
    #[must_use]
    pub fn common_lag_s(&self) -> Option<f64> {
        let lags: Vec<f64> = self.lags_s.iter().flatten().copied().collect();
        (!lags.is_empty()).then(|| lags.iter().sum::<f64>() / lags.len() as f64)
    }
}
