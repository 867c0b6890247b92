//! Fitness of a log for its purpose. Each check is a function of the log alone, with its thresholds
//! beside it.

mod copied;
mod digits;
mod dropout;
mod held;
mod in_motion;
mod jumps;
mod lags;
mod lost_rows;
mod motion_checks;
mod pairing;
mod purpose;
mod rate;
mod regression;
mod rests;
mod runs;
mod signals;
mod trends;
mod units;

pub(crate) use digits::{significant_digits, step_of};
pub(crate) use motion_checks::is_stuck;
pub use purpose::Purpose;
pub use rate::SLOWEST_HZ;
pub(crate) use rate::{FEWEST_SAMPLES, SHORT_S};
pub use rests::without_offsets;
pub use runs::assess_runs;
pub(crate) use signals::{standstill_speed, which_move};

use crate::{Log, Report};
use signals::Signals;

/// All checks of one run. For training use [`assess_runs`] on all runs: it includes the checks of
/// the set.
#[must_use]
pub fn assess(log: &Log, purpose: Purpose) -> Report {
    let mut report = Report::default();
    rate::check(log, purpose, &mut report);
    if log.len() < rate::FEWEST_SAMPLES {
        return report;
    }
    let signals = Signals::of(log);
    motion_checks::check(&signals, purpose, &mut report);
    copied::check(&signals, &mut report);
    let mut whole = Vec::new();
    for axis in signals.iter().filter(|axis| axis.moves()) {
        digits::check(axis, purpose, &mut report);
        let has_one_unit = units::check(axis, purpose, &mut report);
        held::check(axis, purpose, &mut report);
        let lost = dropout::check(axis, purpose, &mut report);
        jumps::check(axis, &lost, purpose, &mut report);
        // A missing value, or one in another unit, does not follow the command either; one report is enough.
        if !lost.contains(&true) && !motion_checks::is_dead(axis) && has_one_unit {
            whole.push(axis);
        }
    }
    pairing::check(&whole, purpose, &mut report);
    lost_rows::check(&whole, &mut report);
    report
}

/// Indices of the axes whose command moves in this run; the others are left out of training.
#[must_use]
pub fn moving_axes(log: &Log) -> Vec<usize> {
    Signals::of(log).iter().enumerate().filter(|(_, axis)| axis.moves()).map(|(index, _)| index).collect()
}
