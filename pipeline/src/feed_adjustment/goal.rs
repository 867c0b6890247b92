//! What feeds are chosen for.

use models::Bundle;

use super::adjusted::Adjusted;
use super::fastest::{fastest, within_time};
use super::limits::FeedLimits;
use super::slower::slower;
use crate::error::Result;
use crate::model_based_ilc::Settings;
use crate::part::Part;
use crate::progress::Progress;

/// Goal of a feed adjustment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Goal {
    /// Lower feeds where the predicted contour error exceeds a tolerance.
    Slower {
        /// Largest predicted contour error, mm.
        tolerance_mm: f64,
        /// Raise other feeds until the cycle time is no longer than before.
        keep_time: bool,
    },
    /// The shortest cycle whose predicted contour error stays within a tolerance.
    Fastest {
        /// Largest predicted contour error, mm.
        tolerance_mm: f64,
    },
    /// The least predicted MAX whose cycle takes at most `1 + change` times as long as programmed.
    WithinTime {
        /// Relative increase of the cycle time; a decrease where it is negative.
        change: f64,
    },
}

impl Goal {
    /// The tolerance of the goal, mm.
    #[must_use]
    pub fn tolerance_mm(self) -> Option<f64> {
        match self {
            Self::Slower { tolerance_mm, .. } | Self::Fastest { tolerance_mm } => Some(tolerance_mm),
            Self::WithinTime { .. } => None,
        }
    }
}

/// Compensates `part` with the feeds of this goal, within `limits`. Where these name lines or tools, no stop gets a feed of its own.
///
/// Feeds are searched over groups of moves; they do not exceed the speeds of the model's training
/// data. Moves that exceed a tolerance whatever their feed get the feed of their least error; [`Adjusted::above`] names them.
///
/// # Errors
/// When `limits` leave no feed to change, planning fails, or the path does not fit the model.
pub fn adjust(
    part: Part,
    model: &Bundle,
    settings: &Settings,
    goal: Goal,
    limits: &FeedLimits,
    progress: Progress<'_>,
) -> Result<Adjusted> {
    let settings = &Settings { slow_stops: settings.slow_stops && !limits.names_moves(), ..*settings };
    match goal {
        Goal::Slower { tolerance_mm, keep_time } => slower(part, model, settings, (tolerance_mm, keep_time), limits, progress),
        Goal::Fastest { tolerance_mm } => fastest(part, model, settings, tolerance_mm, limits, progress),
        Goal::WithinTime { change } => within_time(part, model, settings, change, limits, progress),
    }
}
