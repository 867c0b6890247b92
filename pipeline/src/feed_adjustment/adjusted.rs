//! Result of a feed adjustment.

use std::collections::BTreeMap;

use gcode::Feed;

use crate::error::Result;
use crate::input::Input;
use crate::model_based_ilc::Outcome;
use crate::part::Part;

/// Result of a feed adjustment.
#[derive(Debug)]
pub struct Adjusted {
    /// The program with its adjusted feeds.
    pub input: Input,
    /// Its compensation.
    pub outcome: Outcome,
    /// Cycle time before and after, s.
    pub cycle_s: (f64, f64),
    /// Cycle times without a tolerance; `None` where they were not looked for.
    pub bounds: Option<Bounds>,
    /// Number of moves with lower and with higher feeds than programmed.
    pub moves: (usize, usize),
    /// Largest predicted contour error of feed moves before and after the adjustment, both compensated, mm.
    pub max_mm: (f64, f64),
    /// Program lines, from 1, that exceed the tolerance, with their predicted error, mm; largest first.
    pub above: Vec<(usize, f64)>,
    /// Feeds above the programmed ones, by tool and spindle speed.
    pub chip_loads: Vec<ChipLoad>,
}

/// Planned cycle times of the program without a tolerance, s. Compensated points, where they round corners, may be passed a little faster.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// At the highest allowed feeds.
    pub allowed_s: f64,
    /// At any feed of the moves that may change: the limits of the machine alone.
    pub machine_s: f64,
}

/// The largest increase of a feed with one tool and spindle speed. Chips grow by the same ratio.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChipLoad {
    /// Tool number, where the program states one.
    pub tool: Option<u32>,
    /// Spindle speed, rev/min, where the program states one.
    pub spindle_rpm: Option<f64>,
    /// Program line, from 1.
    pub line: usize,
    /// Programmed and new feed, mm/s.
    pub feed_mm_s: (f64, f64),
}

/// Feeds of a part above the programmed ones: the largest ratio for each tool and spindle speed.
pub(super) fn chip_loads(part: &Part) -> Vec<ChipLoad> {
    let mut largest: BTreeMap<(Option<u32>, Option<u64>), ChipLoad> = BTreeMap::new();
    for (step, factor) in part.toolpath.moves.iter().zip(&part.feed_factors).filter(|(_, factor)| **factor > 1.0) {
        let (Some(Feed::Linear { mm_s }), modal) = (step.feed, part.toolpath.modal(step)) else { continue };
        let feed_mm_s = (mm_s, mm_s * factor);
        let load = ChipLoad { tool: modal.tool, spindle_rpm: modal.spindle_rpm, line: step.block as usize + 1, feed_mm_s };
        let known = largest.entry((modal.tool, modal.spindle_rpm.map(f64::to_bits))).or_insert(load);
        if known.feed_mm_s.1 / known.feed_mm_s.0 < *factor {
            *known = load;
        }
    }
    largest.into_values().collect()
}

/// Program lines, from 1, whose error exceeds the tolerance, mm, with it; largest first.
pub(super) fn above(part: &Part, worst_mm: &[f64], tolerance_mm: f64) -> Vec<(usize, f64)> {
    let worst = worst_mm.iter().zip(&part.toolpath.moves).filter(|(worst, _)| **worst > tolerance_mm);
    let mut above: Vec<(usize, f64)> = worst.map(|(worst, step)| (step.block as usize + 1, *worst)).collect();
    above.sort_by(|a, b| b.1.total_cmp(&a.1));
    above
}

/// Number of moves with lower and with higher feeds than programmed.
pub(super) fn changed_moves(part: &Part) -> (usize, usize) {
    let count = |changed: fn(f64) -> bool| part.feed_factors.iter().filter(|factor| changed(**factor)).count();
    (count(|factor| factor < 1.0), count(|factor| factor > 1.0))
}

/// Cycle time of a part with unlimited feeds of the moves that `allows` names, s.
pub(super) fn unlimited_s(part: Part, allows: impl Fn(usize) -> bool) -> Result<(Part, f64)> {
    let own = part.feed_factors.clone();
    let factors = own.iter().enumerate().map(|(index, own)| if allows(index) { f64::INFINITY } else { *own }).collect();
    let part = part.with_feeds(factors)?;
    let machine_s = part.plan.desired.trajectory().duration_s();
    Ok((part.with_feeds(own)?, machine_s))
}
