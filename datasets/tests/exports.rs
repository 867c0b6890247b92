//! Exports of scopes: LinuxCNC's `halscope` with decimal commas, TwinCAT Scope.

mod common;

use std::fmt::Write;

use common::assert_found;
use datasets::{Check, DatasetError, Log, ReadOptions, Report, Severity, read_log};

const PERIOD_S: f64 = 0.002;
const SAMPLES: usize = 400;

/// Commanded and actual X and Z, mm.
fn sample(t: f64) -> [f64; 4] {
    let (x, z) = (|t: f64| 20.0 * (6.0 * t).sin(), |t: f64| 5.0 * (9.0 * t).cos());
    [x(t), x(t - 0.0015), z(t), z(t - 0.0015)].map(|value| (value * 1e6).round() / 1e6)
}

fn read(name: &str, bytes: impl AsRef<[u8]>) -> Result<(Log, Report), DatasetError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    read_log(&path, &ReadOptions::default())
}

fn assert_sample(log: &Log) {
    assert!((log.period_s() - PERIOD_S).abs() < 1e-9 && log.len() == SAMPLES, "{} {}", log.period_s(), log.len());
    assert_eq!(log.axes().iter().map(|axis| axis.name.as_str()).collect::<Vec<_>>(), ["x", "z"]);
    for k in 0..SAMPLES {
        let (reference, actual) = (log.reference.columns(), log.actual.columns());
        let found = [reference[0][k], actual[0][k], reference[1][k], actual[1][k]];
        let wanted = sample(k as f64 * PERIOD_S);
        assert!(found.iter().zip(wanted).all(|(found, wanted)| (found - wanted).abs() < 1e-9), "{k}: {found:?} {wanted:?}");
    }
}

/// A halscope file of a system with decimal commas, with a bit among the channels.
fn halscope(separator: &str, period: &str, end: &str) -> String {
    let names =
        ["joint.0.motor-pos-cmd", "joint.0.motor-pos-fb", "spindle.0.at-speed", "joint.2.motor-pos-cmd", "joint.2.motor-pos-fb"];
    let mut text = format!("# Sampling period is {period}\n{}{end}\n", names.join(separator));
    for k in 0..SAMPLES {
        let [a, b, c, d] = sample(k as f64 * PERIOD_S).map(|value| format!("{value:.6}").replace('.', ","));
        writeln!(text, "{}{end}", [a, b, "1".to_owned(), c, d].join(separator)).unwrap();
    }
    text
}

#[test]
fn halscope_files_with_decimal_commas_are_read() {
    for separator in [";", "\t", " ; "] {
        for period in ["2000000 ns", "2,0 ms", "2.0 ms"] {
            for end in ["", separator] {
                let text = halscope(separator, period, end);
                for text in [text.clone(), text.replace('\n', "\r\n")] {
                    let (log, report) = read("run.csv", text).unwrap_or_else(|error| panic!("{separator:?} {period}: {error}"));
                    assert_sample(&log);
                    assert_found(&report, Severity::Note, Check::Mended, "joints 0 to 5");
                    assert_found(&report, Severity::Note, Check::Mended, "columns not used: spindle.0.at-speed");
                    assert_eq!(report.findings.len(), 2, "{report}");
                }
            }
        }
    }
    // Whole numbers have their comma, too.
    let whole = halscope(";", "2000000 ns", "").replace(";1;", ";1,000000;");
    assert_sample(&read("run.csv", whole).unwrap().0);
}

#[test]
fn a_halscope_file_with_decimal_commas_that_is_cut_off_is_read_to_its_last_row() {
    let text = halscope(";", "2000000 ns", "");
    for cut in [20, 4] {
        let (log, report) = read("run.csv", &text[..text.len() - cut]).unwrap();
        assert_eq!(log.len(), SAMPLES - 1);
        assert_found(&report, Severity::Warn, Check::Mended, "the last row (line 402)");
    }
}
