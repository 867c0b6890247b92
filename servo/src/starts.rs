//! Where the search for a servo model starts.

use motion::lag_s;
use rayon::prelude::*;

use crate::fit::{Fit, Free, fit};
use crate::parameters::Servo;
use crate::record::{Record, Scope};
use crate::scales::index;

/// Position gains from which the search starts, 1/s: those of slow, usual and stiff feed drives.
const GAINS_1_S: [f64; 4] = [20.0, 45.0, 90.0, 160.0];
/// Pulsation of the table from which it starts, 1/s: 80 Hz.
pub const TABLE_1_S: f64 = 500.0;
/// Backlash from which it starts, mm.
const BACKLASHES_MM: [f64; 2] = [0.0, 8e-3];
/// Integral of a PID position loop from which it starts, 1/s.
const POSITION_INTEGRAL_1_S: f64 = 10.0;
/// Share of the lag that a smoothed command is taken to have at first, and the longest such time, s.
const SMOOTHING: (f64, f64) = (0.5, 0.03);
/// Iterations of a start.
const ITERATIONS: usize = 6;
/// Starts that are followed, and the ratio of their mean squares to the best up to which they are.
const FOLLOWED: (usize, f64) = (3, 4.0);

/// What the axes of a machine have of their control: kind of loop, and smoothing of the command.
pub type Control = (Kind, Smoothing);

/// Kinds of loops that are started from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Cascade,
    /// A PID position loop over a velocity loop without integrator.
    Pid,
}

/// Ways in which a control smooths its command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Smoothing {
    None,
    Average,
    Lag,
}

/// The best start, and for the whole model the best of other kinds beside it, after a few iterations each.
pub fn promising(record: &Record, scope: Scope) -> Vec<Fit> {
    let fits = of_every_control(record, scope);
    let best = fits.first().map_or(0.0, |(_, fit)| fit.mean_square);
    let followed = fits.into_iter().map(|(_, fit)| fit).filter(|fit| fit.mean_square <= FOLLOWED.1 * best);
    followed.take(if scope.whole { FOLLOWED.0 } else { 1 }).collect()
}

/// The best start of every control, best first.
pub fn of_every_control(record: &Record, scope: Scope) -> Vec<(Control, Fit)> {
    let Some(lag_s) = mean_lag_s(record) else { return Vec::new() };
    let (kinds, smoothings): (&[Kind], &[Smoothing]) = if scope.whole {
        (&[Kind::Cascade, Kind::Pid], &[Smoothing::None, Smoothing::Average, Smoothing::Lag])
    } else {
        (&[Kind::Cascade], &[Smoothing::None])
    };
    // Friction and backlash each explain part of the other: both are tried first.
    let backlashes_mm = if scope.sees_backlash { &BACKLASHES_MM[..] } else { &BACKLASHES_MM[..1] };
    let mut starts = Vec::new();
    for &kind in kinds {
        for &smoothing in smoothings {
            for gain in GAINS_1_S {
                starts.extend(backlashes_mm.iter().map(|&backlash_mm| {
                    let (servo, free) = start((kind, smoothing), gain, lag_s, backlash_mm, scope.sees_backlash);
                    ((kind, smoothing), servo, free)
                }));
            }
        }
    }
    let fitted = |(control, servo, free): &(Control, Servo, Free)| Some((*control, fit(*servo, record, free, Some(ITERATIONS))?));
    let mut fits: Vec<(Control, Fit)> = starts.par_iter().filter_map(fitted).collect();
    fits.sort_by(|a, b| a.1.mean_square.total_cmp(&b.1.mean_square));
    let mut seen = Vec::new();
    fits.retain(|(control, _)| {
        let is_first = !seen.contains(control);
        seen.push(*control);
        is_first
    });
    fits
}

/// A start, and the parameters that it moves.
fn start((kind, smoothing): Control, gain_1_s: f64, lag_s: f64, backlash_mm: f64, sees_backlash: bool) -> (Servo, Free) {
    use index::*;
    let smoothing_s = if smoothing == Smoothing::None { 0.0 } else { (SMOOTHING.0 * lag_s).clamp(1e-3, SMOOTHING.1) };
    let feed_forward = (1.0 - gain_1_s * (lag_s - smoothing_s)).clamp(0.0, 1.1);
    let mut servo = Servo { backlash_mm, ..Servo::usual(gain_1_s, feed_forward) };
    let mut free = Free(vec![GAIN, LOOP_LAG, BANDWIDTH, COULOMB]);
    match kind {
        Kind::Cascade => free = free.with([INTEGRAL]),
        Kind::Pid => {
            (servo.integral, servo.position_integral_1_s) = (0.0, POSITION_INTEGRAL_1_S);
            free = free.with([POSITION_INTEGRAL, OFFSET]);
        }
    }
    match smoothing {
        Smoothing::None => {}
        Smoothing::Average => {
            servo.command_average_s = 2.0 * smoothing_s;
            free = free.with([AVERAGE]);
        }
        Smoothing::Lag => {
            servo.command_lag_s = smoothing_s;
            free = free.with([COMMAND_LAG]);
        }
    }
    if sees_backlash {
        servo.table_pulsation_1_s = TABLE_1_S;
        free = free.with([BACKLASH]);
    }
    (servo, free)
}

/// Mean lag of the runs, s.
fn mean_lag_s(record: &Record) -> Option<f64> {
    let lags: Vec<f64> = record.runs.iter().filter_map(|run| lag_s(&run.reference, &run.actual, record.period_s)).collect();
    (!lags.is_empty()).then(|| lags.iter().sum::<f64>() / lags.len() as f64)
}
