//! Which command an actual position follows: exchanged columns, one ahead of the other, one hidden in noise.

mod common;

use common::{assert_found, healthy, hurt, log};
use datasets::Severity::{Note, Refuse, Warn};
use datasets::{Check, Log, Purpose, Report, assess, assess_runs, moving_axes, without_offsets};

fn training(log: &Log) -> Report {
    let report = assess(log, Purpose::Training);
    println!("{report}");
    report
}

/// Moves of half a second to places and back, with rests of half a second, and an actual position that friction keeps 3 µm off.
fn with_rests(wrong_mm: impl Fn(f64, f64) -> f64) -> Log {
    with_friction(0.003, wrong_mm)
}

/// The same with another friction. The first rest is reached from the other side than the last one, at the same place.
fn with_friction(friction_mm: f64, wrong_mm: impl Fn(f64, f64) -> f64) -> Log {
    let places = [0.0, 12.0, -8.0, 20.0, 5.0, -15.0, 8.0, -20.0, 0.0];
    let mut command = vec![0.0; 250];
    for pair in places.windows(2) {
        let share = |k: usize| 0.5 - 0.5 * (std::f64::consts::PI * k as f64 / 250.0).cos();
        command.extend((1..=250).map(|k| pair[0] + (pair[1] - pair[0]) * share(k)));
        let rest = command.last().copied().unwrap_or_default();
        command.extend(std::iter::repeat_n(rest, 250));
    }
    let mut late = command.clone();
    late.rotate_right(3);
    late[..3].fill(0.0);
    let mut from = -1.0;
    let actual = late.iter().enumerate().map(|(k, at)| {
        let step = command[k] - command[k.saturating_sub(1)];
        from = if step == 0.0 { from } else { step.signum() };
        at - friction_mm * from + wrong_mm(*at, k as f64 / late.len() as f64)
    });
    let actual = actual.collect();
    log(0.002, vec![command], vec![actual])
}

#[test]
fn columns_that_disagree_at_rest_are_seen() {
    let of = |wrong_mm: &dyn Fn(f64, f64) -> f64| assess_runs(&[with_rests(wrong_mm), with_rests(wrong_mm)], Purpose::Training);
    let good = of(&|_, _| 0.0);
    assert!(!good.findings.iter().any(|finding| finding.check == Check::Units), "{good}");
    assert_found(&of(&|_, _| 0.02), Warn, Check::Units, "x_act: at rest the actual position stands 0.0");
    let without = without_offsets(&[with_rests(|_, _| 0.02)]).unwrap();
    assert!(without_offsets(&without).is_none() && without_offsets(&[with_rests(|_, _| 0.0)]).is_none());
    let mean = |log: &Log| {
        let pairs = log.reference.columns()[0].iter().zip(&log.actual.columns()[0]);
        pairs.map(|(command, actual)| actual - command).sum::<f64>() / log.len() as f64
    };
    assert!(mean(&without[0]).abs() < 0.004, "{}", mean(&without[0]));
    assert_found(&of(&|_, share| 0.03 * share), Refuse, Check::Units, "the actual position drifts against its command");
    assert_found(&of(&|at, _| 0.002 * at), Warn, Check::Units, "over 40.0 mm (0.20 %)");
    let rubbing = assess_runs(&[with_friction(0.02, |_, _| 0.0)], Purpose::Training);
    assert!(!rubbing.findings.iter().any(|finding| finding.check == Check::Units), "{rubbing}");
    let rounded = of(&|at, _| (at * 100.0).round() / 100.0 - at);
    assert!(!rounded.findings.iter().any(|finding| finding.check == Check::Units), "{rounded}");
}

#[test]
fn backlash_of_a_run_that_rests_twice_is_no_refusal() {
    // Rests at 0, reached from below before the run, and from above at its end.
    let path = |t: f64| if (1.0..3.0).contains(&t) { 5.0 - 5.0 * (std::f64::consts::PI * (t - 1.0)).cos() } else { 0.0 };
    let of = |play_mm: f64| {
        let command: Vec<f64> = (0..2000).map(|k| path(f64::from(k) * 0.002)).collect();
        let mut held = -play_mm;
        let actual = command.iter().map(|at| {
            held = held.clamp(at - play_mm, at + play_mm);
            held
        });
        let actual = actual.collect();
        assess_runs(&[log(0.002, vec![command], vec![actual])], Purpose::Training)
    };
    let report = of(0.008);
    assert_found(&report, Warn, Check::Units, "by 0.0160 mm in the mean of 1 runs");
    assert!(!report.is_refused(), "{report}");
    assert_found(&of(0.04), Refuse, Check::Units, "by 0.0800 mm in the mean of 1 runs");
}

#[test]
fn zeros_that_differ_are_seen_in_motion_where_nothing_rests() {
    let of = |offset_mm: f64| hurt(move |_, actual| actual[0].iter_mut().for_each(|at| *at += offset_mm));
    for offset_mm in [0.05, -0.5, 2.0, -300.0] {
        let report = assess_runs(&[of(offset_mm)], Purpose::Training);
        assert!(!report.is_refused(), "{report}");
        assert_found(&report, Warn, Check::Units, &format!("x_act: in motion the actual position stands {offset_mm:.2}"));
        let without = without_offsets(&[of(offset_mm)]).unwrap();
        let own = healthy();
        let left = without[0].actual.columns()[0].iter().zip(&own.actual.columns()[0]).map(|(left, own)| left - own);
        let most = left.fold(0.0_f64, |most, left| most.max(left.abs()));
        assert!(most < 1e-3, "{most}");
        assert_found(&assess(&of(1000.0 * offset_mm), Purpose::Measuring), Warn, Check::Units, "different zeros");
    }
    assert!(without_offsets(&[of(0.0)]).is_none());
    // Zeros that were set between the runs are no offset of all of them.
    let apart = assess_runs(&[of(2.0), of(7.0), of(2.0)], Purpose::Training);
    assert_found(&apart, Refuse, Check::Units, "zeros were set between the runs");
}

#[test]
fn a_scale_that_no_machine_has_is_seen_in_one_run() {
    let of = |scale: f64| {
        let log = hurt(move |_, actual| actual[0].iter_mut().for_each(|at| *at *= scale));
        assess_runs(&[log], Purpose::Training)
    };
    assert_found(&of(1.02), Refuse, Check::Units, "grows by 2.0");
    assert!(!of(1.0).findings.iter().any(|finding| finding.check == Check::Units), "{}", of(1.0));
}

#[test]
fn a_lead_that_no_machine_has_is_refused() {
    let lead = |rows: usize| {
        hurt(|reference, actual| {
            reference.iter_mut().for_each(|column| column.truncate(5000 - rows));
            actual.iter_mut().for_each(|column| drop(column.drain(..rows)));
        })
    };
    assert_found(&training(&lead(50)), Refuse, Check::Pairing, "no axis leads by so much");
}

#[test]
fn rows_that_are_lost_without_a_trace_are_seen() {
    let report = training(&hurt(|reference, actual| {
        for column in reference.iter_mut().chain(actual) {
            for row in [4000, 2900, 1700] {
                column.remove(row);
            }
        }
    }));
    assert_found(&report, Warn, Check::Timing, "row 1701, t = 3.400 s: over 3 rows every axis moves further than before");
}

#[test]
fn jumps_of_the_command_are_seen() {
    let report = training(&hurt(|reference, _| reference[0][2000..].iter_mut().for_each(|v| *v += 3.0)));
    assert_found(&report, Warn, Check::Command, "x_ref, row 2001");
    let stop = hurt(|reference, actual| {
        // At full speed, then at standstill from one sample to the next.
        let (stop, lag) = (reference[0][0], 3);
        for k in 0..1000 {
            reference[0][k] = stop + 0.1 * (k as f64 - 1000.0);
            actual[0][k] = reference[0][k] - 0.05;
        }
        reference[0][1000..].fill(stop);
        for k in 1000..actual[0].len() {
            actual[0][k] = stop - 0.05 * (-((k - 1000 + lag) as f64) / 10.0).exp();
        }
    });
    assert_found(&training(&stop), Warn, Check::Command, "speed (per s) jumps");
}

#[test]
fn copies_of_the_command_are_seen() {
    let report = training(&hurt(|reference, actual| actual[0].clone_from(&reference[0])));
    assert_found(&report, Refuse, Check::Copied, "x_act: the actual position equals the command");
    let report = training(&hurt(|reference, actual| {
        for (reference, actual) in reference.iter().zip(actual) {
            actual[100..300].copy_from_slice(&reference[100..300]);
        }
    }));
    assert_found(&report, Warn, Check::Copied, "200 of 5000 rows");
    assert_found(&report, Warn, Check::Copied, "rows 101-300");
    for rows in [1, 7] {
        let report = training(&hurt(|reference, actual| {
            actual[0].clone_from(&reference[0]);
            actual[0].rotate_right(rows);
        }));
        assert_found(
            &report,
            Refuse,
            Check::Copied,
            &format!("x_act: the actual position equals the command {rows} row(s) before"),
        );
    }
    // A tracking error of a few steps of rounding is 0 now and then.
    let coarse = training(&hurt(|reference, actual| {
        for (reference, actual) in reference.iter().zip(actual) {
            for (at, command) in actual.iter_mut().zip(reference) {
                *at = command - ((command - *at) * 0.05 * 1e3).round() / 1e3;
            }
        }
    }));
    assert!(!coarse.findings.iter().any(|finding| finding.check == Check::Copied), "{coarse}");
}

#[test]
fn digits_are_counted() {
    let rounded = |step: f64| hurt(|_, actual| actual[0].iter_mut().for_each(|v| *v = (*v / step).round() * step));
    assert_found(&training(&rounded(0.01)), Warn, Check::Digits, "x_act");
    assert_found(&training(&rounded(0.1)), Refuse, Check::Digits, "3 significant digits");
    assert!(training(&rounded(1e-4)).findings.is_empty());
}

#[test]
fn axes_that_never_move_or_never_turn_are_named() {
    let still = hurt(|reference, actual| {
        reference[1].fill(7.0);
        actual[1].fill(7.0);
    });
    assert_found(&training(&still), Note, Check::Motion, "y_ref: the axis never moves");
    assert_eq!(moving_axes(&still), vec![0]);
    let rest = hurt(|reference, actual| {
        for column in reference.iter_mut().chain(actual) {
            column.fill(1.0);
        }
    });
    assert_found(&training(&rest), Refuse, Check::Motion, "no axis's command moves");
    let dead = hurt(|_, actual| actual[0].fill(1.0));
    assert_found(&training(&dead), Refuse, Check::Motion, "never changes");
    let uncommanded = hurt(|reference, _| reference[0].fill(1.0));
    assert_found(&training(&uncommanded), Warn, Check::Motion, "the command never moves but");
}

#[test]
fn one_direction_alone_is_refused_unless_another_run_turns_back() {
    let ramp = |sign: f64| {
        hurt(|reference, actual| {
            for k in 0..5000 {
                let position = sign * (0.01 * f64::from(k) + (0.01 * f64::from(k)).sin() * 0.5);
                reference[0][k as usize] = position;
                actual[0][k as usize] = position - sign * 0.05;
            }
        })
    };
    let report = assess_runs(&[ramp(1.0)], Purpose::Training);
    assert_found(&report, Warn, Check::Motion, "made, x_ref: the axis moves in one direction only");
    assert_found(&report, Refuse, Check::Motion, "never reverses in any run");
    assert!(!assess_runs(&[ramp(1.0), healthy()], Purpose::Training).is_refused());
    let report = assess_runs(&[ramp(1.0), ramp(-1.0)], Purpose::Training);
    assert_found(&report, Warn, Check::Motion, "no run holds a reversal");
    assert!(report.of(Refuse).all(|finding| !finding.message.contains("reverses")), "{report}");
}

#[test]
fn one_axis_ahead_of_its_command_is_refused() {
    // The commands of the first axes lie `rows` earlier beside the other columns.
    let late = |rows: usize, axes: usize| {
        let healthy = healthy();
        let count = healthy.len() - rows;
        let from = |axis: usize| if axis < axes { 0 } else { rows };
        let columns = healthy.reference.columns().iter().enumerate();
        let reference = columns.map(|(axis, column)| column[from(axis)..from(axis) + count].to_vec()).collect();
        let actual = healthy.actual.columns().iter().map(|column| column[rows..].to_vec()).collect();
        log(0.002, reference, actual)
    };
    // The axes lag by 3 rows.
    let report = training(&late(7, 1));
    assert_found(&report, Refuse, Check::Pairing, "x_act: the actual position is ahead of the command by 7.");
    assert_found(&report, Refuse, Check::Pairing, "other axes are not");
    // What is wrong with the machine is measured all the same.
    assert_found(&assess(&late(7, 1), Purpose::Measuring), Warn, Check::Pairing, "other axes are not");
    // All together are ahead by a time that is theirs in common, and by 6 ms one axis may be by its feed-forward.
    for log in [late(7, 2), late(6, 1)] {
        let report = training(&log);
        assert_found(&report, Warn, Check::Pairing, "x_act: the actual position is ahead of the command by");
        assert!(report.of(Refuse).all(|finding| finding.check != Check::Pairing), "{report}");
    }
}

#[test]
fn columns_that_do_not_belong_together_are_named() {
    let report = training(&hurt(std::mem::swap));
    assert_found(&report, Refuse, Check::Pairing, "ahead of the command by 6.");
    let report = training(&hurt(|reference, actual| {
        for (reference, actual) in reference.iter().zip(actual) {
            actual[..4990].copy_from_slice(&reference[10..]);
            actual[4990..].copy_from_slice(&reference[4990..]);
        }
    }));
    assert_found(&report, Warn, Check::Pairing, "x_act: the actual position is ahead of the command by 19");
    let report = training(&hurt(|_, actual| actual.swap(0, 1)));
    assert_found(&report, Refuse, Check::Pairing, "the actual position of `y` follows the command of `x`");
    let report = training(&hurt(|_, actual| actual[0].iter_mut().for_each(|v| *v = -*v)));
    assert_found(&report, Refuse, Check::Pairing, "wrong sign");
    let report = training(&hurt(|_, actual| {
        actual[0].rotate_left(1700);
    }));
    assert_found(&report, Refuse, Check::Pairing, "does not follow");
}

#[test]
fn an_axis_that_only_makes_corrections_is_measured_and_not_trained_on() {
    let mut seed = 1_u64;
    let mut noise = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    // Corrections below the noise, held by friction, and against what another axis does to it.
    let correction = |k: usize| 2e-3 * (0.02 * k as f64).sin();
    let mut shaken = |k: usize| correction(k) + 4e-3 * noise();
    let pushed = |k: usize| -0.7 * correction(k);
    let follows: [&mut dyn FnMut(usize) -> f64; 3] = [&mut shaken, &mut |_| 1e-4, &mut |k| pushed(k)];
    for follow in follows {
        let corrected = hurt(|reference, actual| {
            for (k, (r, x)) in reference[1].iter_mut().zip(&mut actual[1]).enumerate() {
                (*r, *x) = (3.0 + correction(k), 3.0 + follow(k));
            }
        });
        assert_eq!(moving_axes(&corrected), [0]);
        assert_found(
            &training(&corrected),
            Note,
            Check::Motion,
            "y_ref: the axis moves by 0.0040 mm only and is left out of training",
        );
        let measured = assess(&corrected, Purpose::Measuring);
        assert!(measured.of(Refuse).chain(measured.of(Warn)).next().is_none(), "{measured}");
    }
    // Where all motion is small, it is motion.
    let small = hurt(|reference, actual| reference.iter_mut().chain(actual).flatten().for_each(|x| *x *= 1e-4));
    assert_eq!(moving_axes(&small), [0, 1]);
}

#[test]
fn a_command_with_the_noise_of_a_sensor_is_the_actual_position() {
    let mut state = 1_u64;
    let mut random = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let noisy = hurt(|_, actual| actual.iter_mut().flatten().for_each(|position| *position += 4e-4 * random()));
    assert!(!training(&noisy).is_refused());
    let swapped = Log::new("swapped", noisy.actual.clone(), noisy.reference.clone()).unwrap();
    assert_found(&training(&swapped), Refuse, Check::Pairing, "the two columns are swapped");
    // Of an axis that neither lags nor leads, as with full feed-forward, the noise alone shows it.
    let mut follows =
        |log: &Log| log.reference.columns().iter().map(|x| x.iter().map(|x| x + 4e-5 * random()).collect()).collect();
    let wave = hurt(|_, _| {});
    let exact = Log::new("full", wave.reference.clone(), wave.reference.with_columns(follows(&wave)).unwrap()).unwrap();
    let report = training(&exact);
    assert!(!report.findings.iter().any(|finding| finding.check == Check::Pairing), "{report}");
    let swapped = Log::new("swapped", exact.actual.clone(), exact.reference.clone()).unwrap();
    assert_found(&training(&swapped), Warn, Check::Pairing, "are the two columns swapped? State them");
}

#[test]
fn a_well_tuned_axis_under_a_command_without_jerk_limit_is_no_swapped_log() {
    // Strokes of jerky acceleration; the axis smooths them, leads by 0.2 ms and settles after each.
    let period = 0.001;
    let (mut position, mut velocity, mut planned) = (0.0_f64, 0.0_f64, Vec::new());
    for k in 0..40_000 {
        let (stroke, within) = (k / 1000, k % 1000);
        let direction = if stroke % 2 == 0 { 1.0 } else { -1.0 };
        let jerky = 1.0 + 0.5 * (1.7 * f64::from(within)).sin();
        let push = match within {
            0..450 => 200.0,
            450..900 => -200.0,
            _ => 0.0,
        };
        velocity = if within < 900 { velocity + period * direction * push * jerky } else { 0.0 };
        position += period * velocity;
        planned.push(position);
    }
    let at = |k: usize| planned[k.min(planned.len() - 1)];
    let smooth = |k: usize| (0..21).map(|i| at((k + i).saturating_sub(10))).sum::<f64>() / 21.0;
    let actual = (0..planned.len()).map(|k| smooth(k) + 0.2 * (smooth(k + 1) - smooth(k))).collect();
    let axes = vec![motion::Axis::named("x")];
    let trajectory = |column: Vec<f64>| motion::Trajectory::new(period, axes.clone(), vec![column]).unwrap();
    let log = Log::new("tuned", trajectory(planned.clone()), trajectory(actual)).unwrap();
    let report = training(&log);
    assert!(!report.is_refused(), "{report}");
}

#[test]
fn a_large_offset_of_an_axis_that_rests_is_taken_off() {
    let logs = [with_rests(|_, _| 137.25)];
    let report = assess_runs(&logs, Purpose::Training);
    assert_found(&report, Warn, Check::Units, "training takes this offset off");
    assert_eq!(report.worst(), Some(Warn), "{report}");
    assert!(without_offsets(&without_offsets(&logs).unwrap()).is_none());
}

#[test]
fn an_actual_position_that_is_that_of_another_axis_is_refused() {
    for (axis, other) in [(0, 1), (1, 0)] {
        let report = training(&hurt(|_, actual| actual[axis] = actual[other].clone()));
        let name = ["x", "y"];
        let text = format!("the actual position of `{}` follows the command of `{}`", name[axis], name[other]);
        assert_found(&report, Refuse, Check::Pairing, &text);
    }
}
