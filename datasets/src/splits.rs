//! Held-out data: whole runs, or rows of a single one. Never random windows, since neighbouring
//! windows leak.

use std::ops::Range;

use motion::Trajectory;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use crate::{DatasetError, Log, quality};

/// Unscored start of a log, s: its samples lack their command history.
const UNSCORED_S: f64 = 0.3;
/// Shortest standstill at which a log is cut, s.
pub const STANDSTILL_S: f64 = 0.1;
/// Shortest piece between standstills, s, and shortest block of a log without standstills.
const SHORTEST_S: f64 = 1.0;
const SHORTEST_BLOCK_S: f64 = 0.5;

/// Held-out rows of a fold per log, sorted and disjoint; empty for a log that is used for training
/// only.
pub type Fold = Vec<Vec<Range<usize>>>;

/// Piece of a log that is not split.
#[derive(Debug, Clone)]
struct Unit {
    log: usize,
    rows: Range<usize>,
}

/// Folds that each hold out about `share` of all rows, at most `most` of them and at most one over
/// the share. No row is held out twice.
///
/// Several logs are held out as whole runs. A single log is cut at its standstills, or, with fewer
/// than two, into contiguous blocks. The grouping of runs is drawn by `seed`. An axis that moves in
/// several runs is in the first fold.
///
/// # Errors
/// When the share is not between 0 and 1, or a single log is too short.
pub fn folds(logs: &[Log], share: f64, most: usize, seed: u64) -> Result<Vec<Fold>, DatasetError> {
    if !(share > 0.0 && share < 1.0) {
        return Err(DatasetError::BadSetting { name: "held_out_fraction", value: share, remedy: "it must be between 0 and 1" });
    }
    let parts = (1.0 / share).round().max(2.0) as usize;
    let mut units: Vec<Unit> = match logs {
        [log] => pieces(log, parts)?.into_iter().map(|rows| Unit { log: 0, rows }).collect(),
        _ => logs.iter().enumerate().map(|(log, whole)| Unit { log, rows: 0..whole.len() }).collect(),
    };
    units.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
    let wanted = share * units.iter().map(|unit| unit.rows.len() as f64).sum::<f64>();
    let count = units.len();
    let mut chosen: Vec<Vec<Unit>> = vec![Vec::new(); parts.min(most.max(1)).min(count)];
    let mut left = std::collections::VecDeque::from(units);
    for fold in &mut chosen {
        let mut sum = 0.0;
        while let Some(unit) = left.pop_front() {
            // A unit is taken if the sum comes nearer to the target; at least one unit remains for
            // training.
            let taken = fold.is_empty() || (sum + 0.5 * unit.rows.len() as f64 <= wanted && fold.len() + 1 < count);
            if !taken {
                left.push_front(unit);
                break;
            }
            sum += unit.rows.len() as f64;
            fold.push(unit);
        }
    }
    let axes = logs.first().map_or(0, |log| log.axes().len());
    for axis in 0..axes {
        let moves = |unit: &Unit| moves(&logs[unit.log], axis, &unit.rows);
        let judged = chosen.iter().flatten().any(moves);
        if !judged
            && left.iter().filter(|unit| moves(unit)).count() >= 2
            && let Some(unit) = left.iter().position(moves).and_then(|index| left.remove(index))
        {
            chosen[0].push(unit);
        }
    }
    let fold = |units: &Vec<Unit>| {
        let mut fold: Fold = vec![Vec::new(); logs.len()];
        units.iter().for_each(|unit| fold[unit.log].push(unit.rows.clone()));
        fold.iter_mut().for_each(|rows| rows.sort_by_key(|rows| rows.start));
        fold
    };
    Ok(chosen.iter().filter(|units| !units.is_empty()).map(fold).collect())
}

/// Pieces of a single log: between its standstills, or blocks of equal length.
fn pieces(log: &Log, parts: usize) -> Result<Vec<Range<usize>>, DatasetError> {
    let pieces = between_standstills(log, STANDSTILL_S);
    if pieces.len() >= parts.max(3) {
        return Ok(pieces);
    }
    let length = log.len() / parts;
    if (length as f64) * log.period_s() < SHORTEST_BLOCK_S {
        return Err(DatasetError::Runs(format!(
            "`{}` lasts {:.2} s; at least {:.1} s are needed to hold a part of it out. Record a longer run, or a second one",
            log.name,
            log.reference.duration_s(),
            SHORTEST_BLOCK_S * parts as f64
        )));
    }
    Ok((0..parts).map(|part| part * length..if part + 1 == parts { log.len() } else { (part + 1) * length }).collect())
}

/// Rows of a log from the middle of one standstill of its command of at least `standstill_s` to the
/// middle of the next. Pieces shorter than a second join the previous one.
#[must_use]
pub fn between_standstills(log: &Log, standstill_s: f64) -> Vec<Range<usize>> {
    let shortest = (SHORTEST_S / log.period_s()).ceil() as usize;
    let needed = (standstill_s / log.period_s()).ceil() as usize;
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
    cuts.windows(2).map(|cut| cut[0]..cut[1]).collect()
}

/// The scored samples of a run: all, except the first 0.3 s of a run that begins in motion, whose
/// samples lack their command history. `reference` is the commanded position of one axis, one value
/// per period.
#[must_use]
pub fn scored(reference: &[f64], period_s: f64) -> Range<usize> {
    let begins_in_motion = reference.first() != reference.get(1);
    let skipped = if begins_in_motion { (UNSCORED_S / period_s).ceil() as usize } else { 0 };
    skipped.min(reference.len())..reference.len()
}

/// Whether an axis is commanded to move in some rows.
fn moves(log: &Log, axis: usize, rows: &Range<usize>) -> bool {
    log.reference.columns().get(axis).is_some_and(|column| column[rows.clone()].windows(2).any(|pair| pair[0] != pair[1]))
}

/// Whether no axis's command moves from sample `k − 1` to `k`.
fn is_still(reference: &Trajectory, k: usize) -> bool {
    reference
        .axes()
        .iter()
        .zip(reference.columns())
        .all(|(axis, column)| (column[k] - column[k - 1]).abs() < quality::standstill_speed(axis.kind) * reference.period_s())
}
