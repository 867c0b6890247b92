//! Splits are by run.

mod common;

use common::{healthy, hurt};
use datasets::{DatasetError, Log, blocks, scored, segment_at_rests, split_logs, split_runs};

fn ten() -> Vec<Log> {
    (0..10).map(|k| healthy().part(format!("run {k}"), 0, 1000 + 100 * k).unwrap()).collect()
}

#[test]
fn whole_runs_are_held_out_near_the_fraction() {
    let logs = ten();
    let total: usize = logs.iter().map(Log::len).sum();
    for seed in 0..20 {
        let split = split_runs(&logs, 0.25, seed).unwrap();
        assert_eq!(split.training.len() + split.held_out.len(), 10);
        assert!(split.held_out.iter().all(|log| logs.contains(log) && !split.training.contains(log)));
        let share = split.held_out.iter().map(Log::len).sum::<usize>() as f64 / total as f64;
        assert!((0.15..0.35).contains(&share), "{share}");
        assert_eq!(split, split_runs(&logs, 0.25, seed).unwrap());
    }
    assert_ne!(split_runs(&logs, 0.25, 1).unwrap(), split_runs(&logs, 0.25, 2).unwrap());
}

#[test]
fn neither_side_is_ever_empty() {
    for fraction in [0.001, 0.5, 0.999] {
        let split = split_runs(&ten()[..2], fraction, 3).unwrap();
        assert_eq!((split.training.len(), split.held_out.len()), (1, 1));
    }
    assert!(matches!(split_runs(&ten()[..1], 0.5, 1), Err(DatasetError::Runs(_))));
    assert!(matches!(split_runs(&ten(), 1.0, 1), Err(DatasetError::BadSetting { .. })));
}

#[test]
fn a_log_is_cut_in_the_middle_of_its_rests() {
    let stops = hurt(|reference, _| {
        for column in reference {
            for start in [1200, 3000] {
                let hold = column[start];
                column[start..start + 200].fill(hold);
            }
        }
    });
    let pieces = segment_at_rests(&stops, 0.1).unwrap();
    let lengths: Vec<usize> = pieces.iter().map(Log::len).collect();
    assert_eq!(lengths.iter().sum::<usize>(), stops.len());
    assert_eq!(lengths.len(), 3);
    assert!(lengths[0].abs_diff(1300) <= 1 && lengths[1].abs_diff(1800) <= 1, "{lengths:?}");
    assert_eq!(segment_at_rests(&stops, 1.0).unwrap().len(), 1);
    assert!(segment_at_rests(&stops, 0.0).is_err());
}

#[test]
fn a_log_without_rests_is_cut_by_time() {
    let log = healthy();
    let split = split_logs(std::slice::from_ref(&log), 0.25, 5).unwrap();
    assert_eq!((split.training.len(), split.held_out.len()), (3, 1));
    assert_eq!(split.held_out[0].len(), 1250);
    assert!(blocks(&log, 100).is_err());
    assert!(blocks(&log, 0).is_err());
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
