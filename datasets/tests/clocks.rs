//! Logs whose channels have clocks of their own.

mod common;

use std::fmt::Write;
use std::path::PathBuf;

use common::assert_found;
use datasets::{Check, DatasetError, Log, LongFile, ReadOptions, Report, Role, Severity, inspect, read_log, read_reference};

const PERIOD_S: f64 = 0.002;
const SAMPLES: usize = 600;
/// The samples of the actual positions lie this far after those of the command, s.
const LATE_S: f64 = 0.0007;

fn command(t: f64) -> f64 {
    20.0 * (6.0 * t).sin()
}

fn actual(t: f64) -> f64 {
    command(t - 0.003)
}

fn file(folder: &tempfile::TempDir, text: &str) -> PathBuf {
    let path = folder.path().join("run.csv");
    std::fs::write(&path, text).unwrap();
    path
}

fn read(text: &str, columns: Option<&str>) -> Result<(Log, Report), DatasetError> {
    let folder = tempfile::tempdir().unwrap();
    read_log(&file(&folder, text), &ReadOptions { columns: columns.map(str::to_owned), period_s: None })
}

/// A table of these rows.
fn table(names: &str, row: impl Fn(f64) -> String) -> String {
    (0..SAMPLES).fold(format!("{names}\n"), |mut text, k| {
        writeln!(text, "{}", row(k as f64 * PERIOD_S)).unwrap();
        text
    })
}

/// Stamp and command, stamp and actual position; X, then Y with the sign turned.
fn pairs(t: f64, axes: usize) -> String {
    let late = t + LATE_S;
    let one = |sign: f64| format!("{t:.6},{:.9},{late:.6},{:.9}", sign * command(t), sign * actual(late));
    [one(1.0), one(-1.0)][..axes].join(",")
}

/// Whether commands are as recorded, and actual positions those at the instants of the commands.
fn assert_joined(log: &Log, axes: usize) {
    assert_eq!((log.axes().len(), log.period_s()), (axes, PERIOD_S));
    // The first command has no actual position before it.
    assert_eq!((log.len(), log.start_s), (SAMPLES - 1, PERIOD_S));
    for axis in 0..axes {
        let sign = [1.0, -1.0][axis];
        for k in 0..log.len() {
            let t = (k + 1) as f64 * PERIOD_S;
            let found = (log.reference.columns()[axis][k], log.actual.columns()[axis][k]);
            assert!((found.0 - sign * command(t)).abs() < 1e-8);
            // a·T²/8 at 720 mm/s²; the nearest sample would be off by 84 µm.
            assert!((found.1 - sign * actual(t)).abs() < 4e-4, "{k}: {}", found.1 - sign * actual(t));
        }
    }
}

#[test]
fn actual_positions_are_joined_to_the_clock_of_the_command() {
    for names in [
        "t_cmd,x_cmd,t_act,x_act",
        "t,x_cmd,t,x_act",
        "time [s],X Soll,Zeit_Ist,X Ist",
        "t_x_ref,x_ref,t_x_act,x_act",
        "t,x_ref,time_act,x_act",
    ] {
        let (log, report) = read(&table(names, |t| pairs(t, 1)), None).unwrap_or_else(|error| panic!("{names}: {error}"));
        assert_joined(&log, 1);
        let told = "joined to the clock of the command by cubic interpolation; the nearest samples are 0.700 to 0.700 ms";
        assert_found(&report, Severity::Note, Check::Timing, told);
        assert_eq!(report.findings.len(), 1, "{names}: {report}");
    }
    for names in ["t,x_ref,t,x_act,t,y_ref,t,y_act", "t_ref,x_ref,t_act,x_act,spare,y_ref,spare2,y_act"] {
        assert_joined(&read(&table(names, |t| pairs(t, 2)), None).unwrap().0, 2);
    }
    let names = "clock1,p,clock2,q";
    assert_joined(&read(&table(names, |t| pairs(t, 1)), Some("t_ref=clock1,x_ref=p,t_act=clock2,x_act=q")).unwrap().0, 1);
    assert_joined(&read(&table(names, |t| pairs(t, 1)), Some("t=clock1,x_ref=p,t_act=clock2,x_act=q")).unwrap().0, 1);
}

#[test]
fn a_channel_may_be_shorter_and_slower() {
    // Every fifth row of the file has an actual position, the first ones; the others are empty.
    let mut index = 0;
    let mut text = String::from("t_cmd,x_cmd,t_act,x_act\n");
    for k in 0..SAMPLES {
        let t = k as f64 * PERIOD_S;
        write!(text, "{t:.6},{:.9}", command(t)).unwrap();
        if index * 5 < SAMPLES {
            let late = (5 * index) as f64 * PERIOD_S;
            writeln!(text, ",{late:.6},{:.9}", actual(late)).unwrap();
            index += 1;
        } else {
            text.push_str(",,\n");
        }
    }
    let (log, report) = read(&text, None).unwrap();
    assert_eq!(log.len(), SAMPLES - 4);
    assert_found(&report, Severity::Note, Check::Timing, "-4.000 to 4.000 ms from its instants; 4 rows of the command");
    assert_found(&report, Severity::Warn, Check::Timing, "sampled every 10.000 ms, the command every 2.000 ms");
    for (k, found) in log.actual.columns()[0].iter().enumerate() {
        assert!((found - actual(k as f64 * PERIOD_S)).abs() < 720.0 * 1e-4 / 8.0 + 1e-6, "{k}");
    }
}

#[test]
fn clocks_that_are_not_clear_are_refused() {
    for (names, words) in [
        ("t,time,x_ref,x_act", "columns 1 and 2 both claim to be the time of the log"),
        ("x_ref,x_act,t,time", "columns 3 and 4 both claim to be the time of the log"),
        ("x_ref,t,x_act,t", "columns 2 and 4 both claim to be the time of the log"),
        ("t_act,x_ref,t_act,x_act", "columns 1 and 3 both claim to be the time of `x_act`"),
    ] {
        let error = read(&table(names, |t| pairs(t, 1)), None).unwrap_err();
        assert!(matches!(error, DatasetError::Columns { .. }) && error.to_string().contains(words), "{names}: {error}");
    }
    let error = read(&table("a,x_ref,b,x_act", |t| pairs(t, 1)), Some("t_act=a,x_ref=x_ref,x_act=x_act")).unwrap_err();
    assert!(error.to_string().contains("belong together"), "{error}");
    let text = table("t_cmd,x_cmd,t_act,x_act", |t| format!("{t},1,{},2", t + 1e6));
    assert!(read(&text, None).unwrap_err().to_string().contains("no instant in common"));
}

#[test]
fn a_commanded_path_has_the_clock_of_its_commands() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(&folder, &table("t_cmd,x_cmd,t_act,x_act", |t| pairs(t, 1)));
    let (reference, report) = read_reference(&path, &ReadOptions::default()).unwrap();
    assert!(reference.len() == SAMPLES && report.findings.is_empty(), "{report}");
    let found = inspect(&path, &ReadOptions::default()).unwrap();
    assert!(found.columns[0].role == Role::Time && found.columns[2].role == Role::Time);
}

#[test]
fn logs_with_several_clocks_are_read_whole() {
    let folder = tempfile::tempdir().unwrap();
    let rows = |k: usize| pairs(k as f64 * 1e-3, 1) + "\n";
    let text = "t_cmd,x_cmd,t_act,x_act\n".to_owned() + &(0..60_000).map(rows).collect::<String>();
    let path = file(&folder, &text);
    assert!(LongFile::log(&path, &ReadOptions::default(), 10_000).unwrap().is_none());
    assert_eq!(LongFile::reference(&path, &ReadOptions::default(), 10_000).unwrap().unwrap().len(), 60_000);
}
