//! Which servo model follows an axis best: starts, structures, and the final fit.

use rayon::prelude::*;

use crate::fit::{Fit, Free, fit, residuals, scored};
use crate::parameters::Servo;
use crate::record::{Record, Scope};
use crate::scales::index;
use crate::starts::{Control, TABLE_1_S, of_every_control, promising};

/// Length of the record on which starts and structures are compared, and of that on which they are checked and fitted, s.
const COMPARED_S: f64 = 12.0;
const FITTED_S: f64 = 40.0;
/// Length of the record of the last fit for a prediction, s: the first seconds of many runs may lie in one place of an axis, whose friction is then
/// taken for that of the travel. Held-out RMS over that with 40 s, 20 axes of `random:` 971, 972, 947, 142, 905 and `xyzac`: median 1.0, best 0.65,
/// worst 1.2; training took 1.07 to 1.18 times as long, on a robot's log 1.6. All of 140 s came to 0.91 to 1.32 of that with 80 s, in more time.
const PREDICTED_S: f64 = 80.0;
/// Parameters that a structure of as many parameters has to be better by.
const MARGIN: f64 = 0.5;
/// Iterations of a structure's trial, and of a structure; ratio of the mean squares up to which a trial goes on.
const TRIAL_ITERATIONS: usize = 5;
const STRUCTURE_ITERATIONS: usize = 14;
const PROMISING: f64 = 1.15;
/// The same up to which the other kind of loop is followed.
const RIVAL: f64 = 9.0;
/// Time that stands for an independent sample of a prediction, s.
const WHOLE_S: f64 = 0.25;
/// Rounds of trials, so that several parts come together.
const ROUNDS: usize = 3;
/// Backlash that is tried where none is expected, mm.
const LOOSE_MM: f64 = 4e-3;
/// Backlashes from which a table that is not seen starts, mm.
const HIDDEN_BACKLASHES_MM: [f64; 2] = [LOOSE_MM, 12e-3];
/// Least viscous friction from which it starts, over the velocity gain: from none its share on the table has no effect.
const HIDDEN_VISCOUS: f64 = 0.01;
/// Ratio of the squares on a longer record to those of the best start from which on a start is given up, and to those of the structure before it up to which
/// a structure is taken.
const RUNS_AWAY: f64 = 100.0;
const FOLLOWS_WORSE: f64 = 2.0;
/// Iterations of the fit with the whole friction, and of a fit to other samples of the same axis.
const FRICTION_ITERATIONS: usize = 8;
const REFIT_ITERATIONS: usize = 6;
/// Decrease of the squares on samples outside a fit for which a part of the friction is kept.
const LEAST_GAIN: f64 = 0.01;

/// The servo model of an axis. `None` where none follows the record.
#[must_use]
pub fn identify(record: &Record, scope: Scope) -> Option<Fit> {
    identify_from(record, scope, scope)
}

/// The same for a diagnosis, from the starts of a prediction: cascades and PID loops, with smoothed commands and without.
#[must_use]
pub fn identify_any_control(record: &Record, scope: Scope) -> Option<Fit> {
    identify_from(record, scope, Scope { whole: true, ..scope })
}

/// The best model from the starts `of`.
fn identify_from(record: &Record, scope: Scope, of: Scope) -> Option<Fit> {
    let short = record.shortened(COMPARED_S);
    let seconds = short.fitted_s();
    let long = record.shortened(FITTED_S);
    let starts = promising(&short, of);
    let full = |start: &Fit| fit(start.servo, &short, &of_friction(start, scope), Some(STRUCTURE_ITERATIONS));
    let mut fits = steady(starts.iter().filter_map(full).collect(), &long, |fit| fit);
    fits.sort_by(|a, b| a.mean_square.total_cmp(&b.mean_square));
    // A cascade and a PID loop seldom turn into each other: the better one of either kind is followed.
    let first = fits.first()?;
    let integral = |fit: &Fit| fit.servo.integral > 0.0;
    let others = fits.iter().skip(1).find(|fit| integral(fit) != integral(first));
    let followed = [Some(first), others.filter(|other| other.mean_square < RIVAL * first.mean_square)];
    let structured = followed.into_iter().flatten().map(|fit| best_structure(fit.clone(), [&short, &long], scope, false));
    let best = structured.reduce(|best, other| if is_better(&other, &best, seconds, scope) { other } else { best })?;
    let Fit { servo, free, .. } = best;
    if !scope.whole {
        return fit(servo, &long, &free, None);
    }
    fit_for_prediction(servo, &free, record)
}

/// Ratio of the mean squares of an axis's own control and of that of all axes up to which it has the latter.
const DEPARTURE: f64 = 0.25;

/// Servo models of the axes of one machine, for a prediction: as [`identify`], with the same kind of loop and the same smoothing of the command on all
/// of them. A log of smooth motion hardly tells a slow loop from a smoothed command; the axes together do. An axis that its own control fits far
/// better keeps it.
#[must_use]
pub fn identify_all(records: &[Record]) -> Vec<Option<Fit>> {
    let scope = Scope { sees_backlash: false, whole: true };
    if let [record] = records {
        return vec![identify(record, scope)];
    }
    let shorts: Vec<Record> = records.par_iter().map(|record| record.shortened(COMPARED_S)).collect();
    let longs: Vec<Record> = records.par_iter().map(|record| record.shortened(FITTED_S)).collect();
    let of_axes: Vec<Vec<(Control, Fit)>> =
        shorts.par_iter().zip(&longs).map(|(short, long)| steady(controls(short, scope), long, |(_, fit)| fit)).collect();
    let shared = shared_control(&of_axes, &shorts);
    let start = |fits: &Vec<(Control, Fit)>| {
        let own = fits.iter().min_by(|a, b| a.1.mean_square.total_cmp(&b.1.mean_square))?;
        let common = fits.iter().find(|(control, _)| Some(*control) == shared);
        common.filter(|(_, fit)| own.1.mean_square > DEPARTURE * fit.mean_square).or(Some(own)).cloned()
    };
    let starts: Vec<Option<(Control, Fit)>> = of_axes.iter().map(start).collect();
    let finish = |axis: usize| {
        let start = of_other_axes(starts[axis].clone()?, &starts, &shorts[axis]);
        let best = best_structure(start, [&shorts[axis], &longs[axis]], scope, true);
        fit_for_prediction(best.servo, &best.free, &records[axis])
    };
    (0..records.len()).into_par_iter().map(finish).collect()
}

/// Fits of every control to an axis, each with its friction.
fn controls(record: &Record, scope: Scope) -> Vec<(Control, Fit)> {
    let full = |(control, start): &(Control, Fit)| {
        // Without them a smoothed command takes their place.
        let free = of_friction(start, scope).with([index::ACCELERATION, index::LOOP_DELAY]);
        Some((*control, fit(start.servo, record, &free, Some(STRUCTURE_ITERATIONS))?))
    };
    of_every_control(record, scope).par_iter().filter_map(full).collect()
}

/// The control that the axes together prefer (Bayesian information criterion), of those that every axis with a fit has.
fn shared_control(of_axes: &[Vec<(Control, Fit)>], records: &[Record]) -> Option<Control> {
    let samples: f64 = records.iter().map(|record| record.fitted_s() / WHOLE_S).sum();
    let known: Vec<(&Vec<(Control, Fit)>, &Record)> = of_axes.iter().zip(records).filter(|(fits, _)| !fits.is_empty()).collect();
    let cost = |control: Control| -> Option<f64> {
        let of_axis = |(fits, record): &(&Vec<(Control, Fit)>, &Record)| {
            let (_, fit) = fits.iter().find(|(known, _)| *known == control)?;
            Some(record.fitted_s() / WHOLE_S * fit.mean_square.ln() + fit.effective * samples.max(2.0).ln())
        };
        known.iter().map(of_axis).sum()
    };
    let (first, _) = known.first()?;
    let costs = first.iter().filter_map(|(control, _)| Some((*control, cost(*control)?)));
    costs.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(control, _)| control)
}

/// The best fit of an axis from its own start and from the loops of other axes with the same control, with its own friction. The axes of a machine have much
/// the same loops, and a fit that went astray on one of them finds back from another one's: y of `random:545547` (one log of 60 s) had a position gain of 442
/// 1/s and 0.85 µm, and has 50 and 0.22.
fn of_other_axes((control, own): (Control, Fit), starts: &[Option<(Control, Fit)>], record: &Record) -> Fit {
    let same = starts.iter().flatten().filter(|(other, fit)| *other == control && fit.servo != own.servo);
    let others: Vec<Servo> = same.map(|(_, fit)| own.servo.with_loops_of(&fit.servo)).collect();
    others.into_iter().fold(own, |best, servo| {
        let trial = fit(servo, record, &best.free, Some(TRIAL_ITERATIONS));
        let Some(trial) = trial.filter(|trial| trial.mean_square < PROMISING * best.mean_square) else { return best };
        let other = fit(trial.servo, record, &best.free, Some(STRUCTURE_ITERATIONS));
        other.filter(|other| other.mean_square < best.mean_square).unwrap_or(best)
    })
}

/// Those of the fits that do not run away on a longer record.
fn steady<T>(fits: Vec<T>, long: &Record, of: impl Fn(&T) -> &Fit) -> Vec<T> {
    let left: Vec<f64> = fits.iter().map(|fit| squares(&of(fit).servo, long)).collect();
    let least = left.iter().copied().fold(f64::INFINITY, f64::min);
    fits.into_iter().zip(left).filter(|(_, left)| *left <= RUNS_AWAY * least).map(|(fit, _)| fit).collect()
}

/// The best structure on a short record that is reached from a fit, one part after the other, of those that do not follow a longer one worse. Kind of loop and smoothing stay where the control `is_known`.
fn best_structure(start: Fit, [record, long]: [&Record; 2], scope: Scope, is_known: bool) -> Fit {
    use index::{AVERAGE, COMMAND_LAG, INTEGRAL, POSITION_INTEGRAL};
    let of_control = |free: &Free| [INTEGRAL, POSITION_INTEGRAL, AVERAGE, COMMAND_LAG].map(|part| free.0.contains(&part));
    let control = of_control(&start.free);
    let mut left = squares(&start.servo, long);
    let mut best = start;
    for _ in 0..if scope.whole { ROUNDS } else { 1 } {
        let before = best.free.clone();
        for (servo, free) in structures(&best, scope) {
            if is_known && of_control(&free) != control {
                continue;
            }
            let trial = fit(servo, record, &free, Some(TRIAL_ITERATIONS));
            let Some(trial) = trial.filter(|trial| trial.mean_square < PROMISING * best.mean_square) else { continue };
            let Some(other) = fit(trial.servo, record, &free, Some(STRUCTURE_ITERATIONS)) else { continue };
            if !is_better(&other, &best, record.fitted_s(), scope) {
                continue;
            }
            // A loop at the edge of stability may follow a short record, and run away on a longer one.
            let of_other = squares(&other.servo, long);
            if of_other <= FOLLOWS_WORSE * left {
                (best, left) = (other, of_other);
            }
        }
        if best.free == before {
            break;
        }
    }
    best
}

/// The same structure fitted to other samples of the axis, from the parameters of `found`.
#[must_use]
pub fn refit(found: &Fit, record: &Record) -> Option<Fit> {
    fit(found.servo, &record.shortened(FITTED_S), &found.free, Some(REFIT_ITERATIONS))
}

/// The last fit of a structure, with the whole friction.
fn fit_for_prediction(servo: Servo, free: &Free, record: &Record) -> Option<Fit> {
    let last = record.shortened(PREDICTED_S);
    Some(with_whole_friction(fit(servo, &last, free, None)?, &last))
}

/// A model with the same structure fitted to either half of its record.
struct Halved {
    whole: Fit,
    halves: [Fit; 2],
    /// Sum of the squares that each half leaves on the other, mm².
    left: f64,
}

/// Adds delay and acceleration feed-forward, friction by place, contacts of elements, and a table that only the motor feels, each where it
/// lowers the error on samples that did not fit it.
fn with_whole_friction(found: Fit, record: &Record) -> Fit {
    use index::*;
    let [one, other] = record.halves();
    let sees_table = found.free.0.contains(&OUTER_BACKLASH);
    let halved = |servos: [Servo; 2], free: &Free| -> Option<([Fit; 2], f64)> {
        let (a, b) = rayon::join(
            || fit(servos[0], &one, free, Some(FRICTION_ITERATIONS)),
            || fit(servos[1], &other, free, Some(FRICTION_ITERATIONS)),
        );
        let (a, b) = (a?, b?);
        let left = squares(&a.servo, &other) + squares(&b.servo, &one);
        Some(([a, b], left))
    };
    let Some((halves, left)) = halved([found.servo; 2], &found.free) else { return found };
    let mut best = Halved { whole: found, halves, left };
    let mut take = |more: &[usize], change: &dyn Fn(Servo) -> Servo| {
        let free = best.whole.free.with(more.iter().copied());
        let [one, other] = &best.halves;
        let Some((halves, left)) = halved([change(one.servo), change(other.servo)], &free) else { return };
        if left < (1.0 - LEAST_GAIN) * best.left
            && let Some(whole) = fit(change(best.whole.servo), record, &free, Some(FRICTION_ITERATIONS))
        {
            best = Halved { whole, halves, left };
        }
    };
    let as_it_is = |servo: Servo| servo;
    take(&[LOOP_DELAY, ACCELERATION], &as_it_is);
    let (low, high) = record.travel();
    if high > low {
        take(&LEVELS.collect::<Vec<_>>(), &|servo| servo.with_places(low, high));
    }
    take(&SHARES.collect::<Vec<_>>(), &|servo| Servo { slips: true, ..servo });
    let table =
        [VISCOUS, CHANNEL_DELAY, LOOP_DELAY, BACKLASH, TABLE_FRICTION, TABLE_PULSATION, TABLE_DAMPING, TABLE_MASS, TABLE_VISCOUS];
    if !sees_table {
        for backlash_mm in HIDDEN_BACKLASHES_MM {
            take(&table, &|servo| hidden_table(servo, backlash_mm));
        }
    }
    let of_halves: f64 = best.halves.iter().zip([&one, &other]).map(|(fit, half)| fit.mean_square * half.fitted() as f64).sum();
    let optimism = (of_halves > 0.0).then(|| optimism(best.left / of_halves));
    Fit { optimism, ..best.whole }
}

/// Ratio of the RMS error on other samples to that on the fitted ones, from the ratio of the squares where half of the samples were fitted:
/// `√((n + p)/(n − p))` of `p` parameters and `n` samples (final prediction error, Akaike 1970), with the share `p/n` that shows in the halves.
fn optimism(of_halves: f64) -> f64 {
    let share = 0.5 * (1.0 - 2.0 / (of_halves + 1.0)).clamp(0.0, 1.0);
    ((1.0 + share) / (1.0 - share)).sqrt()
}

/// The axis with a table behind screw and backlash that only the motor feels.
fn hidden_table(servo: Servo, backlash_mm: f64) -> Servo {
    let viscous = servo.viscous.max(HIDDEN_VISCOUS);
    // The lag stays.
    let fed = if servo.integral > 0.0 { 0.0 } else { viscous - servo.viscous };
    Servo {
        hides_table: true,
        feed_forward: servo.feed_forward + fed,
        backlash_mm,
        outer_backlash_mm: 0.0,
        viscous,
        table_friction: 0.5,
        table_viscous: 0.5,
        table_pulsation_1_s: TABLE_1_S,
        table_mass: 0.5,
        ..servo
    }
}

/// Sum of the squares that a model leaves on a record, mm².
fn squares(servo: &Servo, record: &Record) -> f64 {
    let residuals = residuals(servo, record);
    scored(&residuals, record).map(|r| r * r).sum()
}

/// Whether a structure pays for its further parameters (Bayesian information criterion). Residuals are correlated: of a diagnosis, which has
/// to be sure of its quantities, seconds stand for independent samples; of a prediction quarters of them.
fn is_better(other: &Fit, best: &Fit, seconds: f64, scope: Scope) -> bool {
    let (independent, more) = if scope.whole {
        (seconds / WHOLE_S, other.effective - best.effective)
    } else {
        (seconds, other.free.0.len() as f64 - best.free.0.len() as f64)
    };
    let parameters = more.max(MARGIN);
    independent * (best.mean_square / other.mean_square).ln() > parameters * independent.max(2.0).ln()
}

/// The parameters of a start, and those of its friction.
fn of_friction(start: &Fit, scope: Scope) -> Free {
    use index::*;
    let mut free = start.free.with([STRIBECK, STRIBECK_SPEED, PRESLIDING, ASYMMETRY]);
    if scope.whole {
        // Short runs show little else than how they start. Creep begins at none: from more, fits of axes that have none went astray.
        free = free.with([START_DEFLECTION, START_ERROR, CREEP, CONTACT_DAMPING]);
    }
    if scope.sees_backlash { free.with([TABLE_FRICTION, TABLE_PULSATION, TABLE_DAMPING, TABLE_MASS]) } else { free }
}

/// Other structures, from the present best one: a velocity loop without integrator, a PID position loop, a delayed or smoothed command.
fn structures(best: &Fit, scope: Scope) -> Vec<(Servo, Free)> {
    use index::*;
    let (servo, free) = (best.servo, &best.free);
    let stiff = Servo { integral: 0.0, position_integral_1_s: 0.0, ..servo };
    let outer = |servo: &Servo| Servo { outer_backlash_mm: servo.backlash_mm.max(2e-3), backlash_mm: 0.0, ..*servo };
    let smoothing_s = (0.5 * servo.lag_s()).clamp(1e-3, 0.02);
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
    let faster =
        |servo: &Servo, late_s: f64| Servo { feed_forward: servo.feed_forward + late_s * servo.position_gain_1_s, ..*servo };
    let without_integral = free.without(INTEGRAL);
    let mut all = vec![
        (servo, free.with([LOOP_DELAY])),
        (servo, free.with([ACCELERATION])),
        (stiff, without_integral.without(POSITION_INTEGRAL).with([OFFSET])),
        (Servo { position_integral_1_s: 5.0, ..stiff }, without_integral.with([OFFSET, POSITION_INTEGRAL])),
        (Servo { channel_delay_s: 1e-3, ..servo }, free.with([CHANNEL_DELAY])),
        (Servo { command_average_s: smoothing_s, ..faster(&servo, 0.5 * smoothing_s) }, free.with([AVERAGE])),
    ];
    if servo.integral > 0.0 {
        all.insert(0, (exchanged(&servo), free.clone()));
        all.insert(3, (exchanged(&servo), free.with([ACCELERATION])));
    }
    if scope.whole {
        all.push((
            Servo { command_lag_s: smoothing_s, ..faster(&servo, smoothing_s) },
            free.without(AVERAGE).with([COMMAND_LAG]),
        ));
    }
    if servo.table_pulsation_1_s == 0.0 {
        let elastic = Servo { table_pulsation_1_s: TABLE_1_S, ..servo };
        all.push((elastic, free.with([TABLE_FRICTION, TABLE_PULSATION, TABLE_DAMPING, TABLE_MASS])));
    }
    if scope.whole && !free.0.contains(&BACKLASH) {
        // The sensor is not known to lie behind it: the backlash has to pay for itself.
        let loose = Servo { backlash_mm: LOOSE_MM, table_pulsation_1_s: TABLE_1_S, ..servo };
        let table = [TABLE_FRICTION, TABLE_PULSATION, TABLE_DAMPING, TABLE_MASS];
        all.push((loose, free.with([BACKLASH]).with(table)));
        all.push((outer(&loose), free.with([OUTER_BACKLASH]).with(table)));
    }
    if free.0.contains(&BACKLASH) {
        // Friction and elasticity may have taken the place of backlash, and the reverse.
        let more = Servo { backlash_mm: servo.backlash_mm + 6e-3, coulomb_mm: 0.5 * servo.coulomb_mm, ..servo };
        all.push((more, free.clone()));
        let beyond = free.without(BACKLASH).with([OUTER_BACKLASH]);
        all.extend([(outer(&servo), beyond.clone()), (outer(&stiff), beyond.without(INTEGRAL).without(POSITION_INTEGRAL))]);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::Run;

    #[test]
    fn what_halves_leave_on_each_other_gives_the_error_on_other_samples() {
        assert_eq!(optimism(1.0), 1.0);
        // 20 parameters and 100 samples in each half.
        let of_all = optimism(120.0 / 80.0);
        assert!((of_all - (220.0f64 / 180.0).sqrt()).abs() < 1e-12, "{of_all}");
        assert!(optimism(f64::INFINITY).is_finite());
    }

    #[test]
    fn a_table_that_only_the_motor_feels_is_found() {
        let truth = Servo {
            hides_table: true,
            backlash_mm: 0.011,
            viscous: 0.02,
            table_viscous: 0.5,
            table_friction: 0.6,
            table_pulsation_1_s: 700.0,
            table_mass: 0.6,
            ..Servo::usual(50.0, 0.7)
        };
        let period_s = 0.002;
        let run = |index: u32| {
            let wave = |k: u32| {
                let (t, slow) = (f64::from(k) * period_s, 1.0 + 0.3 * f64::from(index));
                12.0 * (slow * t).sin().powi(3) + 4.0 * (2.3 * slow * t).sin()
            };
            let reference: Vec<f64> = (0..4000).map(wave).collect();
            let actual = truth.follow(&reference, period_s);
            Run { rows: std::iter::once(500..reference.len()).collect(), reference, actual, start: None }
        };
        let record = Record { period_s, runs: (0..4).map(run).collect() };
        let free = Free(vec![index::GAIN, index::LOOP_LAG, index::BANDWIDTH, index::INTEGRAL, index::COULOMB, index::PRESLIDING]);
        let one_mass = fit(Servo::usual(45.0, 0.6), &record, &free, None).unwrap();
        let found = with_whole_friction(one_mass.clone(), &record);
        assert!(found.servo.hides_table);
        let (before, after) = (one_mass.mean_square.sqrt() * 1e3, found.mean_square.sqrt() * 1e3);
        assert!(after < 0.4 * before, "{after} of {before} µm");
        assert!(found.optimism.is_some_and(|ratio| (1.0..1.3).contains(&ratio)), "{:?}", found.optimism);
    }
}
