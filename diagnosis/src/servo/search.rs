//! Which servo model follows an axis best: starts, structures, and the final fit.

use motion::lag_s;

use super::fit::{Fit, Free, fit};
use super::parameters::{Servo, index};
use crate::record::{AxisRecord, Run};

/// Position gains from which the search starts, 1/s: those of slow, usual and stiff feed drives.
const STARTS_1_S: [f64; 4] = [20.0, 45.0, 90.0, 160.0];
/// Pulsation of the table from which it starts, 1/s: 80 Hz.
const TABLE_1_S: f64 = 500.0;
/// Backlash from which it starts, mm.
const BACKLASHES_MM: [f64; 2] = [0.0, 8e-3];
/// Length of the record on which starts and structures are compared, and of that of the final fit, s.
const COMPARED_S: f64 = 12.0;
const FITTED_S: f64 = 40.0;
/// Parameters that a structure of as many parameters has to be better by.
const MARGIN: f64 = 0.5;
/// Iterations of a start, of a structure's trial, and of a structure; ratio of the mean squares up to which a trial goes on.
const START_ITERATIONS: usize = 6;
const TRIAL_ITERATIONS: usize = 5;
const STRUCTURE_ITERATIONS: usize = 14;
const PROMISING: f64 = 1.15;

/// The servo model of an axis. `sees_backlash` where the sensor may lie behind the backlash. `None` where none follows the record.
#[must_use]
pub fn identify(record: &AxisRecord, sees_backlash: bool) -> Option<Fit> {
    let short = shortened(record, COMPARED_S);
    let start = best_start(&short, sees_backlash)?;
    let blocks = short.runs.iter().map(Run::len).sum::<usize>() as f64 * short.period_s;
    let mut best = fit(start.servo, &short, &cascade(sees_backlash), Some(STRUCTURE_ITERATIONS))?;
    for structure in structures(&best) {
        let trial = fit(structure.0, &short, &structure.1, Some(TRIAL_ITERATIONS));
        let Some(trial) = trial.filter(|trial| trial.mean_square < PROMISING * best.mean_square) else { continue };
        let Some(other) = fit(trial.servo, &short, &structure.1, Some(STRUCTURE_ITERATIONS)) else { continue };
        if is_better(&other, &best, blocks) {
            best = other;
        }
    }
    let Fit { servo, free, .. } = best;
    fit(servo, &shortened(record, FITTED_S), &free, None)
}

/// Whether a structure pays for its further parameters (Bayesian information criterion); seconds stand for independent samples, since
/// residuals are correlated.
fn is_better(other: &Fit, best: &Fit, seconds: f64) -> bool {
    let parameters = (other.free.0.len() as f64 - best.free.0.len() as f64).max(MARGIN);
    seconds * (best.mean_square / other.mean_square).ln() > parameters * seconds.max(2.0).ln()
}

/// Parameters of a cascade.
fn cascade(sees_backlash: bool) -> Free {
    use index::*;
    let mut free = vec![GAIN, LOOP_LAG, BANDWIDTH, INTEGRAL, COULOMB, STRIBECK, STRIBECK_SPEED, PRESLIDING, ASYMMETRY];
    if sees_backlash {
        free.extend([BACKLASH, TABLE_FRICTION, TABLE_PULSATION, TABLE_DAMPING, TABLE_MASS]);
    }
    Free(free)
}

/// Other structures, from the present best one: a velocity loop without integrator, a PID position loop, a delayed or averaged command.
fn structures(best: &Fit) -> Vec<(Servo, Free)> {
    use index::*;
    let without = |parameter: usize| best.free.0.iter().copied().filter(move |free| *free != parameter);
    let with = |more: &[usize]| Free(best.free.0.iter().chain(more).copied().collect());
    let servo = best.servo;
    let stiff = Servo { integral: 0.0, ..servo };
    let outer = |servo: &Servo| Servo { outer_backlash_mm: servo.backlash_mm.max(2e-3), backlash_mm: 0.0, ..*servo };
    let average_s = (0.5 * servo.lag_s()).clamp(1e-3, 0.02);
    // Position gain and integral of the velocity loop enter the poles alike: each may stand for the other.
    let exchanged = |servo: &Servo| {
        let gain = (servo.integral * servo.bandwidth_1_s).max(2.0);
        Servo {
            position_gain_1_s: gain,
            integral: servo.position_gain_1_s / servo.bandwidth_1_s,
            feed_forward: 1.0 - gain * servo.lag_s(),
            coulomb_mm: servo.coulomb_mm * servo.position_gain_1_s / gain,
            ..*servo
        }
    };
    let elastic = Servo { table_pulsation_1_s: TABLE_1_S, ..servo };
    let mut all = vec![
        (exchanged(&servo), best.free.clone()),
        (servo, with(&[LOOP_DELAY])),
        (servo, with(&[ACCELERATION])),
        (exchanged(&servo), with(&[ACCELERATION])),
        (stiff, Free(without(INTEGRAL).chain([OFFSET]).collect())),
        (Servo { position_integral_1_s: 5.0, ..stiff }, Free(without(INTEGRAL).chain([OFFSET, POSITION_INTEGRAL]).collect())),
        (Servo { channel_delay_s: 1e-3, ..servo }, with(&[CHANNEL_DELAY])),
        (
            Servo {
                command_average_s: average_s,
                feed_forward: servo.feed_forward + 0.5 * average_s * servo.position_gain_1_s,
                ..servo
            },
            with(&[AVERAGE]),
        ),
    ];
    if servo.table_pulsation_1_s == 0.0 {
        all.push((elastic, with(&[TABLE_FRICTION, TABLE_PULSATION, TABLE_DAMPING, TABLE_MASS])));
    }
    if best.free.0.contains(&BACKLASH) {
        // Friction and elasticity may have taken the place of backlash, and the reverse.
        let more = Servo { backlash_mm: servo.backlash_mm + 6e-3, coulomb_mm: 0.5 * servo.coulomb_mm, ..servo };
        all.push((more, best.free.clone()));
        let beyond = Free(without(BACKLASH).chain([OUTER_BACKLASH]).collect());
        all.extend([
            (outer(&servo), beyond.clone()),
            (outer(&stiff), Free(beyond.0.into_iter().filter(|free| *free != INTEGRAL).collect())),
        ]);
    }
    all
}

/// The best of a few iterations from each start.
fn best_start(record: &AxisRecord, sees_backlash: bool) -> Option<Fit> {
    use index::*;
    let lag_s = mean_lag_s(record)?;
    let mut free = Free(vec![GAIN, LOOP_LAG, BANDWIDTH, INTEGRAL, COULOMB]);
    // Friction and backlash each explain part of the other: both are tried first.
    let backlashes: &[f64] = if sees_backlash { &BACKLASHES_MM } else { &BACKLASHES_MM[..1] };
    if sees_backlash {
        free.0.push(BACKLASH);
    }
    let starts = STARTS_1_S.iter().flat_map(|&gain| backlashes.iter().map(move |&backlash_mm| (gain, backlash_mm)));
    let fits = starts.filter_map(|(gain, backlash_mm)| {
        let table_pulsation_1_s = if sees_backlash { TABLE_1_S } else { 0.0 };
        let servo = Servo { backlash_mm, table_pulsation_1_s, ..Servo::usual(gain, (1.0 - gain * lag_s).clamp(0.0, 1.1)) };
        fit(servo, record, &free, Some(START_ITERATIONS))
    });
    fits.min_by(|a, b| a.mean_square.total_cmp(&b.mean_square))
}

/// Mean lag of the runs, s.
fn mean_lag_s(record: &AxisRecord) -> Option<f64> {
    let lags: Vec<f64> = record.runs.iter().filter_map(|run| lag_s(&run.reference, &run.actual, record.period_s)).collect();
    (!lags.is_empty()).then(|| lags.iter().sum::<f64>() / lags.len() as f64)
}

/// The record cut to about `seconds`, an equal share from the start of every run.
fn shortened(record: &AxisRecord, seconds: f64) -> AxisRecord {
    let samples = seconds / record.period_s;
    let total: usize = record.runs.iter().map(Run::len).sum();
    if total as f64 <= samples {
        return record.clone();
    }
    // No share shorter than two seconds: of many runs every n-th is taken.
    let least = (2.0 / record.period_s).ceil();
    let runs = record.runs.len();
    let taken = ((samples / least) as usize).clamp(1, runs);
    let share = (samples / taken as f64).ceil() as usize;
    let cut = |run: &Run| {
        let end = run.len().min(share);
        Run { name: run.name.clone(), reference: run.reference[..end].to_vec(), actual: run.actual[..end].to_vec() }
    };
    let picked = (0..taken).map(|i| cut(&record.runs[i * runs / taken])).collect();
    AxisRecord { runs: picked, name: record.name.clone(), ..*record }
}
