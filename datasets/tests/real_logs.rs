//! Recorded logs of real machines.

mod common;

use common::{assert_found, shared};
use datasets::{
    Check, DatasetError, Log, Purpose, ReadOptions, Report, Severity, assess, assess_runs, folds, read_log, read_runs,
};
use motion::AxisKind;

fn read(name: &str) -> Option<(Log, Report)> {
    let path = shared(name)?;
    let (log, report) = read_log(&path, &ReadOptions::default()).unwrap();
    println!(
        "{name}: {} samples of {} axes every {} ms\n{report}{}",
        log.len(),
        log.axes().len(),
        1e3 * log.period_s(),
        assess(&log, Purpose::Training)
    );
    Some((log, report))
}

#[test]
fn emps_is_fit_for_training() {
    let mut logs = Vec::new();
    for name in ["emps_train_1kHz.csv", "emps_pulses_1kHz.csv"] {
        let Some((log, reading)) = read(name) else { return };
        assert_eq!((log.len(), log.period_s()), (24841, 0.001));
        assert_eq!(log.axes()[0].name, "x");
        assert!((log.reference.columns()[0][1] - 0.121_721).abs() < 1e-12);
        assert!(reading.worst() <= Some(Severity::Note), "{reading}");
        let report = assess(&log, Purpose::Training);
        assert!(report.findings.is_empty(), "{report}");
        logs.push(log);
    }
    assert!(!assess_runs(&logs, Purpose::Training).is_refused());
}

#[test]
fn a_gap_of_a_real_log_makes_two_runs() {
    let Some(path) = shared("emps_train_1kHz.csv") else { return };
    let text = std::fs::read_to_string(path).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("gap.csv");
    std::fs::write(&path, [&lines[..12_001], &lines[12_061..]].concat().join("\n") + "\n").unwrap();
    let (logs, report) = read_runs(&path, &ReadOptions::default()).unwrap();
    let found: Vec<(&str, usize)> = logs.iter().map(|log| (log.name.as_str(), log.len())).collect();
    assert_eq!(found, [("gap part 1", 12_000), ("gap part 2", 12_781)]);
    assert_found(
        &report,
        Severity::Note,
        Check::Timing,
        "after line 12001: 60 rows are missing; the log is cut there into two runs",
    );
    assert!(report.worst() == Some(Severity::Note), "{report}");
    let report = assess_runs(&logs, Purpose::Training);
    assert!(report.worst() <= Some(Severity::Note), "{report}");
}

#[test]
fn one_long_log_is_split_into_contiguous_pieces() {
    let Some((log, _)) = read("emps_train_1kHz.csv") else { return };
    let folds = folds(std::slice::from_ref(&log), 0.2, 5, 1).unwrap();
    let mut held: Vec<_> = folds.iter().flat_map(|fold| fold[0].clone()).collect();
    held.sort_by_key(|rows| rows.start);
    assert_eq!(held.len(), 5);
    assert!(held.windows(2).all(|pair| pair[0].end == pair[1].start) && held[0].start == 0 && held[4].end == log.len());
}

#[test]
fn ur5_with_copied_rows_is_accepted_with_their_position() {
    let Some((log, _)) = read("ur5_no6_125Hz.csv") else { return };
    assert_eq!((log.axes().len(), log.period_s()), (6, 0.008));
    assert!(log.axes().iter().all(|axis| axis.kind == AxisKind::Rotary));
    let degrees = log.reference.columns()[0][0].to_degrees();
    assert!((degrees + 89.999_981).abs() < 1e-9, "{degrees}");
    let report = assess(&log, Purpose::Training);
    assert_found(&report, Severity::Warn, Check::Copied, "1724 of 10264 rows have command = actual");
    assert_found(&report, Severity::Warn, Check::Copied, "rows 3504-3610");
    assert_found(&report, Severity::Warn, Check::Command, "the command's speed");
    assert!(!report.is_refused(), "{report}");
}

#[test]
fn ur5_with_jitter_is_resampled_with_a_finding() {
    let Some((log, reading)) = read("ur5_no1_125Hz_jitter.csv") else { return };
    assert_eq!(log.period_s(), 0.008);
    assert_found(&reading, Severity::Warn, Check::Timing, "1108 of 2243 intervals are off 8.000 ms by more than 25 %");
    assert!((log.reference.duration_s() - 35.796).abs() < 0.008);
    // The interpolated log still lags by the same half millisecond and has no outliers.
    let report = assess(&log, Purpose::Training);
    assert!(!report.is_refused(), "{report}");
}

#[test]
fn the_michigan_log_is_refused_with_the_reason() {
    let Some(path) = shared("michigan_experiment_11.csv") else { return };
    let error = read_log(&path, &ReadOptions::default()).unwrap_err();
    println!("{error}");
    assert!(matches!(error, DatasetError::NoTime { .. }));
    let message = error.to_string();
    for words in ["no time column", "10 Hz", "too slow for training", "3 significant digits"] {
        assert!(message.contains(words), "{words}: {message}");
    }
    let options = ReadOptions { period_s: Some(0.1), ..ReadOptions::default() };
    let (log, _) = read_log(&path, &options).unwrap();
    let names: Vec<&str> = log.axes().iter().map(|axis| axis.name.as_str()).collect();
    assert_eq!(names, ["x", "y", "z"]);
    let report = assess(&log, Purpose::Training);
    println!("{report}");
    assert_found(&report, Severity::Refuse, Check::Rate, "sampled at 10.000 Hz");
    assert_found(&report, Severity::Refuse, Check::Digits, "steps of 1 mm (3 significant digits)");
    assert!(!assess(&log, Purpose::Measuring).findings.is_empty());
}

/// Faults inserted into a real log are found; the log itself has none.
#[test]
fn faults_put_into_a_real_log_are_seen() {
    let Some((log, _)) = read("emps_train_1kHz.csv") else { return };
    let with = |change: &dyn Fn(&mut Vec<f64>, &mut Vec<f64>)| {
        let mut reference = log.reference.columns()[0].clone();
        let mut actual = log.actual.columns()[0].clone();
        change(&mut reference, &mut actual);
        let report = assess(&common::log(0.001, vec![reference], vec![actual]), Purpose::Training);
        println!("{report}");
        report
    };
    let report = with(&|_, actual| actual[9000..].iter_mut().for_each(|value| *value += 0.05));
    assert_found(&report, Severity::Refuse, Check::Jumps, "row 9001");
    let report = with(&|reference, actual| {
        reference.drain(1000..1030);
        actual.drain(1000..1030);
    });
    assert_found(&report, Severity::Refuse, Check::Jumps, "rows are lost");
    let report = with(&|_, actual| actual[4000..4012].fill(0.0));
    assert_found(&report, Severity::Refuse, Check::Dropout, "12 rows in 1 stretches read exactly 0");
    let round = |values: &mut Vec<f64>, step: f64| values.iter_mut().for_each(|v| *v = (*v / step).round() * step);
    let report = with(&|_, actual| round(actual, 0.01));
    assert_found(&report, Severity::Warn, Check::Digits, "steps of 0.01 mm");
    let report = with(&|_, actual| round(actual, 0.1));
    assert_found(&report, Severity::Refuse, Check::Digits, "steps of 0.1 mm");
    let report = with(&|reference, actual| std::mem::swap(reference, actual));
    assert_found(&report, Severity::Refuse, Check::Pairing, "ahead of the command by 6.");
}
