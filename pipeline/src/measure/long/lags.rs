//! Lags of the axes of a long log: as [`motion::lag_s`] finds them, a pass over the log an iteration.

use datasets::{Lengths, LongFile, Piece};
use motion::{cubic, lag_s};

use crate::error::Result;

/// Step of the iteration below which it ends, samples: the next one would be a thousand times smaller.
const LAST_STEP: f64 = 0.02;
/// Largest number of passes over the log.
const PASSES: usize = 4;

/// Normal equation of the lag of an axis.
struct LagSum {
    /// Lag at which it is set up, samples.
    at: f64,
    slope: f64,
    curvature: f64,
}

impl LagSum {
    /// Adds the samples of a piece of a log of `samples`.
    fn add(&mut self, piece: &Piece, reference: &[f64], actual: &[f64], samples: usize) {
        let last = samples.saturating_sub(2) as f64;
        for k in piece.own.clone() {
            let at = (piece.first + k) as f64 - self.at;
            let here = k as f64 - self.at;
            let is_held = here >= 1.0 && here + 2.0 <= reference.len() as f64;
            if at < 1.0 || at > last - 1.0 || !is_held {
                continue;
            }
            let (value, speed) = cubic(reference, here);
            self.slope += (value - actual[k]) * speed;
            self.curvature += speed * speed;
        }
    }
}

/// Lag of every axis, s, with `visit` called on every piece of the first pass. Lags are sought within the margins of the pieces.
pub(super) fn lags_s(file: &LongFile, lengths: Lengths, mut visit: impl FnMut(&Piece) -> Result<()>) -> Result<Vec<Option<f64>>> {
    let mut sums: Vec<LagSum> = Vec::new();
    for pass in 0..PASSES {
        for piece in file.pieces(lengths)? {
            let piece = piece?;
            let Some(actual) = &piece.actual else { continue };
            let columns = || piece.reference.columns().iter().zip(actual.columns());
            if sums.is_empty() {
                let start = |(reference, actual): (&Vec<f64>, &Vec<f64>)| lag_s(reference, actual, file.period_s());
                let starts: Vec<Option<f64>> = columns().map(start).collect();
                let at = |lag: &Option<f64>| lag.unwrap_or(0.0) / file.period_s();
                sums = starts.iter().map(|lag| LagSum { at: at(lag), slope: 0.0, curvature: 0.0 }).collect();
            }
            for (sum, (reference, actual)) in sums.iter_mut().zip(columns()) {
                sum.add(&piece, reference, actual, file.len());
            }
            if pass == 0 {
                visit(&piece)?;
            }
        }
        let mut largest = 0.0_f64;
        for sum in sums.iter_mut().filter(|sum| sum.curvature > 0.0) {
            let step = sum.slope / sum.curvature;
            sum.at += step;
            largest = largest.max(step.abs());
        }
        if largest < LAST_STEP || pass + 1 == PASSES {
            break;
        }
        sums.iter_mut().for_each(|sum| (sum.slope, sum.curvature) = (0.0, 0.0));
    }
    Ok(sums.iter().map(|sum| (sum.curvature > 0.0).then_some(sum.at * file.period_s())).collect())
}
