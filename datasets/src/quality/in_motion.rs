//! An offset between command and actual position of logs without rests: what is left of the error where lag, acceleration and friction are taken off.

use nalgebra::SVector;

use super::regression::{motions, slopes};
use super::signals::Signals;
use crate::Log;

/// Offset from which on the columns have different zeros, mm, and as a multiple of what the other terms leave of the error.
const OFFSET_MM: f64 = 0.020;
const OF_REST: f64 = 3.0;

/// Actual position minus command where nothing moves, mm; `None` where that is no more than axes without an offset show.
pub(super) fn offset_mm(logs: &[Log], axis: usize) -> Option<f64> {
    let mut rows = Vec::new();
    for log in logs {
        let signals = Signals::of(log);
        let Some(axis) = signals.get(axis).filter(|axis| axis.moves()) else { continue };
        rows.extend(
            motions(axis).into_iter().map(|at| (SVector::from([1.0, at.speed, at.acceleration, at.direction]), at.error)),
        );
    }
    let (slopes, rest) = slopes(&rows)?;
    Some(-slopes[0]).filter(|offset_mm| offset_mm.abs() > OFFSET_MM.max(OF_REST * rest))
}

/// What to say of an offset.
pub(super) fn message(offset_mm: f64) -> String {
    format!(
        "in motion the actual position stands {offset_mm:.4} mm beside its command, lag and friction taken off: the columns have different zeros; training \
         takes this offset off"
    )
}
