//! Held-out data: whole runs, or rows of a single one.

mod common;

use std::ops::Range;

use common::{healthy, hurt};
use datasets::{DatasetError, Log, between_standstills, folds, scored};

fn ten() -> Vec<Log> {
    (0..10).map(|k| healthy().part(format!("run {k}"), 0, 1000 + 100 * k).unwrap()).collect()
}

fn len(rows: &[Range<usize>]) -> usize {
    rows.iter().map(ExactSizeIterator::len).sum()
}

#[test]
fn whole_runs_are_held_out_near_the_share() {
    let logs = ten();
    let total: usize = logs.iter().map(Log::len).sum();
    for seed in 0..20 {
        let all = folds(&logs, 0.25, 9, seed).unwrap();
        assert_eq!(all, folds(&logs, 0.25, 9, seed).unwrap());
        assert!((3..=4).contains(&all.len()));
        for fold in &all {
            let held: Vec<usize> = (0..10).filter(|log| !fold[*log].is_empty()).collect();
            assert!(held.iter().all(|&log| fold[log].len() == 1 && fold[log][0] == (0..logs[log].len())));
            let share = held.iter().map(|&log| logs[log].len()).sum::<usize>() as f64 / total as f64;
            assert!((0.07..0.35).contains(&share), "{share}");
        }
        let times = |log: usize| all.iter().filter(|fold| !fold[log].is_empty()).count();
        assert!((0..10).all(|log| times(log) <= 1));
        assert_eq!(folds(&logs, 0.25, 1, seed).unwrap(), all[..1]);
    }
    assert_ne!(folds(&logs, 0.25, 1, 1).unwrap(), folds(&logs, 0.25, 1, 2).unwrap());
}

#[test]
fn something_is_always_learned_from_and_something_judged() {
    for share in [0.001, 0.5, 0.999] {
        for fold in folds(&ten()[..2], share, 9, 3).unwrap() {
            assert_eq!(fold.iter().filter(|rows| rows.is_empty()).count(), 1);
        }
    }
    assert!(matches!(folds(&ten(), 1.0, 1, 1), Err(DatasetError::BadSetting { .. })));
    assert!(folds(&[], 0.2, 1, 1).unwrap().is_empty());
}

#[test]
fn an_axis_that_few_runs_move_is_judged_by_one_of_them() {
    let still = hurt(|reference, _| reference[1].fill(3.0));
    let logs: Vec<Log> = (0..10).map(|k| if k < 2 { healthy() } else { still.clone() }).collect();
    for seed in 0..20 {
        let [fold] = &folds(&logs, 0.2, 1, seed).unwrap()[..] else { panic!("one fold was asked for") };
        assert!(!fold[0].is_empty() || !fold[1].is_empty());
    }
}

#[test]
fn a_log_is_cut_in_the_middle_of_its_standstills() {
    let stops = hurt(|reference, _| {
        for column in reference {
            for start in [1200, 3000] {
                let hold = column[start];
                column[start..start + 200].fill(hold);
            }
        }
    });
    let lengths: Vec<usize> = between_standstills(&stops, 0.1).iter().map(ExactSizeIterator::len).collect();
    assert_eq!(lengths.iter().sum::<usize>(), stops.len());
    assert_eq!(lengths.len(), 3);
    assert!(lengths[0].abs_diff(1300) <= 1 && lengths[1].abs_diff(1800) <= 1, "{lengths:?}");
    assert_eq!(between_standstills(&stops, 1.0).len(), 1);
}

#[test]
fn a_log_without_standstills_is_cut_by_time() {
    let log = healthy();
    let all = folds(std::slice::from_ref(&log), 0.25, 9, 5).unwrap();
    assert_eq!(all.len(), 4);
    assert!(all.iter().all(|fold| fold[0].len() == 1 && len(&fold[0]) == 1250));
    let short = log.part("short", 0, 400).unwrap();
    let why = folds(&[short], 0.25, 9, 5).unwrap_err().to_string();
    assert!(why.contains("at least 2.0 s"), "{why}");
}

#[test]
fn the_start_of_a_run_that_begins_in_motion_is_not_scored() {
    let moving: Vec<f64> = (0..500).map(f64::from).collect();
    assert_eq!(scored(&moving, 0.002), 150..500);
    assert_eq!(scored(&moving[..100], 0.002), 100..100);
    let resting = [&[7.0; 200][..], &moving].concat();
    assert_eq!(scored(&resting, 0.002), 0..700);
    assert_eq!(scored(&[], 0.002), 0..0);
}
