//! Training and held-out runs: split by run, never by window, for neighbouring windows leak.

use std::ops::Range;

use motion::Trajectory;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use crate::{DatasetError, Log, quality};

/// The start of a log that is not scored, s: its samples lack their command history.
pub const UNSCORED_S: f64 = 0.3;
/// Shortest rest at which a log is cut, s.
pub const REST_S: f64 = 0.1;
/// Pieces into which a log without rests is cut by time.
const BLOCKS: usize = 4;

/// Runs to learn from and runs to judge by.
#[derive(Debug, Clone, PartialEq)]
pub struct Split {
    /// Runs to learn from.
    pub training: Vec<Log>,
    /// Runs to judge by.
    pub held_out: Vec<Log>,
}

/// Holds out whole runs, drawn at random, until they make `held_out_fraction` of all samples: at least one, and never all.
///
/// # Errors
/// When there are fewer than two runs, or the fraction is not between 0 and 1.
pub fn split_runs(logs: &[Log], held_out_fraction: f64, seed: u64) -> Result<Split, DatasetError> {
    if !(held_out_fraction > 0.0 && held_out_fraction < 1.0) {
        return Err(DatasetError::BadSetting {
            name: "held_out_fraction",
            value: held_out_fraction,
            remedy: "it must be between 0 and 1",
        });
    }
    if logs.len() < 2 {
        return Err(DatasetError::Runs(format!(
            "{} run cannot be split by run; record a second one, or cut it at its rests",
            logs.len()
        )));
    }
    let mut order: Vec<usize> = (0..logs.len()).collect();
    order.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
    let total: usize = logs.iter().map(Log::len).sum();
    let wanted = held_out_fraction * total as f64;
    let mut held = vec![false; logs.len()];
    let mut sum = 0;
    for (position, &index) in order.iter().enumerate().take(logs.len() - 1) {
        // A run is taken when that brings the sum nearer to what is wanted.
        let nearer = (sum + logs[index].len()) as f64 - wanted < wanted - sum as f64;
        if position == 0 || nearer {
            held[index] = true;
            sum += logs[index].len();
        }
    }
    // An axis that moves in several runs is judged by one of them.
    for axis in 0..logs[0].axes().len() {
        let moving: Vec<usize> = order.iter().copied().filter(|index| moves(&logs[*index], axis)).collect();
        if moving.len() >= 2 && moving.iter().all(|index| !held[*index]) {
            held[moving[0]] = true;
        }
    }
    let pick = |side: bool| {
        let chosen = logs.iter().zip(&held).filter(|(_, held)| **held == side);
        chosen.map(|(log, _)| log.clone()).collect()
    };
    Ok(Split { training: pick(false), held_out: pick(true) })
}

/// Splits by run; a single log is cut at its rests first, or where it never rests into four blocks.
///
/// # Errors
/// As [`split_runs`], for a log that is too short to be cut.
pub fn split_logs(logs: &[Log], held_out_fraction: f64, seed: u64) -> Result<Split, DatasetError> {
    let [log] = logs else {
        return split_runs(logs, held_out_fraction, seed);
    };
    let pieces = segment_at_rests(log, REST_S)?;
    if pieces.len() >= 3 {
        split_runs(&pieces, held_out_fraction, seed)
    } else {
        split_runs(&blocks(log, BLOCKS)?, held_out_fraction, seed)
    }
}

/// Cuts a log in the middle of each rest of its command of at least `rest_s`; pieces shorter than a second join the one before.
///
/// # Errors
/// When `rest_s` is not positive.
pub fn segment_at_rests(log: &Log, rest_s: f64) -> Result<Vec<Log>, DatasetError> {
    if !(rest_s.is_finite() && rest_s > 0.0) {
        return Err(DatasetError::BadSetting { name: "rest_s", value: rest_s, remedy: "it must be positive" });
    }
    let shortest = (1.0 / log.period_s()).ceil() as usize;
    let needed = (rest_s / log.period_s()).ceil() as usize;
    let mut cuts = vec![0];
    let mut start = None;
    for k in 1..=log.len() {
        let still = k < log.len() && is_still(&log.reference, k);
        match (still, start) {
            (true, None) => start = Some(k - 1),
            (false, Some(from)) => {
                start = None;
                let middle = usize::midpoint(from, k);
                let last = cuts.last().copied().unwrap_or(0);
                let inside = middle >= last + shortest && middle + shortest <= log.len();
                if k - from > needed && inside {
                    cuts.push(middle);
                }
            }
            _ => {}
        }
    }
    cuts.push(log.len());
    parts(log, &cuts)
}

/// Cuts a log into `count` contiguous pieces of equal length; what follows a cut lacks its command history for [`UNSCORED_S`].
///
/// # Errors
/// When the pieces would be shorter than twice [`UNSCORED_S`].
pub fn blocks(log: &Log, count: usize) -> Result<Vec<Log>, DatasetError> {
    let length = log.len() / count.max(1);
    if count == 0 || length as f64 * log.period_s() < 2.0 * UNSCORED_S {
        return Err(DatasetError::Runs(format!(
            "`{}` lasts {:.2} s, too short for {count} pieces of at least {:.1} s",
            log.name,
            log.reference.duration_s(),
            2.0 * UNSCORED_S
        )));
    }
    let mut cuts: Vec<usize> = (0..count).map(|piece| piece * length).collect();
    cuts.push(log.len());
    parts(log, &cuts)
}

/// The samples of a run that are scored: all, but for the first [`UNSCORED_S`] of a run that begins in motion, whose samples lack their command
/// history. `reference` is the commanded position of one axis, one a period.
#[must_use]
pub fn scored(reference: &[f64], period_s: f64) -> Range<usize> {
    let begins_in_motion = reference.first() != reference.get(1);
    let skipped = if begins_in_motion { (UNSCORED_S / period_s).ceil() as usize } else { 0 };
    skipped.min(reference.len())..reference.len()
}

fn parts(log: &Log, cuts: &[usize]) -> Result<Vec<Log>, DatasetError> {
    cuts.windows(2).enumerate().map(|(index, cut)| log.part(format!("{} part {}", log.name, index + 1), cut[0], cut[1])).collect()
}

/// Whether no axis's command moves from sample `k − 1` to `k`.
/// Whether an axis is commanded to move in a run.
fn moves(log: &Log, axis: usize) -> bool {
    log.reference.columns().get(axis).is_some_and(|column| column.iter().any(|position| *position != column[0]))
}

fn is_still(reference: &Trajectory, k: usize) -> bool {
    reference
        .axes()
        .iter()
        .zip(reference.columns())
        .all(|(axis, column)| (column[k] - column[k - 1]).abs() < quality::rest_speed(axis.kind) * reference.period_s())
}
