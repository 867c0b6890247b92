//! Logs as controls write them: names, encoders, gaps, idle axes and clocks of their own.

mod common;

use std::fmt::Write;
use std::path::PathBuf;

use common::assert_found;
use datasets::{Check, DatasetError, Log, ReadOptions, Report, Severity, read_log};
use motion::AxisKind;

const PERIOD_S: f64 = 0.002;
const SAMPLES: usize = 400;

/// Commanded and actual position of an axis, mm, to a nanometre.
fn sample(axis: usize, t: f64) -> [f64; 2] {
    let at = |t: f64| 20.0 * ((6.0 + axis as f64) * t + axis as f64).sin();
    [at(t), at(t - 0.0015)].map(|value| (value * 1e6).round() / 1e6)
}

/// A table with these names and the values of a row.
fn table(names: &str, row: impl Fn(usize) -> String) -> String {
    (0..SAMPLES).fold(format!("{names}\n"), |mut text, k| {
        writeln!(text, "{}", row(k)).unwrap();
        text
    })
}

fn file(folder: &tempfile::TempDir, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

fn read(bytes: impl AsRef<[u8]>, columns: Option<&str>) -> Result<(Log, Report), DatasetError> {
    let folder = tempfile::tempdir().unwrap();
    let options = ReadOptions { columns: columns.map(str::to_owned), period_s: None };
    read_log(&file(&folder, "run.csv", bytes), &options)
}

fn names(log: &Log) -> Vec<&str> {
    log.axes().iter().map(|axis| axis.name.as_str()).collect()
}

/// Whether an axis of a log is axis `of` of the sample.
fn assert_axis(log: &Log, index: usize, of: usize, scale: f64) {
    for k in 0..SAMPLES {
        let found = [log.reference.columns()[index][k], log.actual.columns()[index][k]];
        let wanted = sample(of, k as f64 * PERIOD_S).map(|value| value * scale);
        assert!(found.iter().zip(wanted).all(|(found, wanted)| (found - wanted).abs() < 1e-9), "{k}: {found:?} {wanted:?}");
    }
}

/// Time in s, then command and actual of the axes.
fn row(k: usize, axes: &[usize]) -> String {
    let t = k as f64 * PERIOD_S;
    axes.iter().fold(format!("{t:.3}"), |text, axis| text + &sample(*axis, t).map(|value| format!(",{value:.6}")).concat())
}

#[test]
fn numbered_axes_of_sinumerik_edge_are_x_y_z() {
    let text =
        table("time,DES_POS|1,ENC1_POS|1,CMD_POS|3,ACT_POS|3,DES_POS|4,ENC_POS|4,CURRENT|1", |k| row(k, &[0, 1, 2]) + ",7");
    let (log, report) = read(&text, None).unwrap();
    assert_eq!(names(&log), ["x", "z", "a"]);
    assert_eq!(log.axes()[2].kind, AxisKind::Rotary);
    assert_axis(&log, 0, 0, 1.0);
    assert_axis(&log, 1, 1, 1.0);
    assert_axis(&log, 2, 2, std::f64::consts::PI / 180.0);
    assert_found(&report, Severity::Note, Check::Mended, "axes 1 to 6 are taken for x y z a b c");
    assert_found(&report, Severity::Note, Check::Mended, "columns not used: CURRENT|1");
    // The fourth axis of this machine is linear.
    let map = "y_ref=DES_POS|4,y_act=ENC_POS|4";
    assert_axis(&read(&text, Some(map)).unwrap().0, 0, 2, 1.0);
}

#[test]
fn a_signal_that_is_not_numbered_is_not_guessed() {
    for names in ["time,DES_POS|x,ENC_POS|x", "time,x|soll,x|ist", "time,DES_POS|0,ENC_POS|0", "time,LOAD|1,ENC_POS|1"] {
        let error = read(table(names, |k| row(k, &[0])), None).unwrap_err();
        assert!(matches!(error, DatasetError::Columns { .. }), "{names}: {error}");
    }
}

#[test]
fn the_encoder_at_the_table_counts_where_it_is_there() {
    let second = |there: bool| {
        table("time,DES_POS|1,ENC2_POS|1,ENC1_POS|1", |k| {
            let encoders = row(k, &[0]);
            if there {
                format!("{encoders},9")
            } else {
                format!("{},0,{}", &encoders[..encoders.rfind(',').unwrap()], &encoders[encoders.rfind(',').unwrap() + 1..])
            }
        })
    };
    for (there, words) in
        [(true, "`ENC2_POS|1` is used, the encoder at the table"), (false, "`ENC1_POS|1` is used, the other one reads 0")]
    {
        let (log, report) = read(second(there), None).unwrap();
        assert_axis(&log, 0, 0, 1.0);
        assert_found(&report, Severity::Note, Check::Mended, words);
    }
    let (log, _) = read(table("time,DES_POS|2,ENC2_POS|2", |k| row(k, &[1])), None).unwrap();
    assert_eq!(names(&log), ["y"]);
    assert_axis(&log, 0, 1, 1.0);
}

/// A recording of two axes without names.
fn edge(signals: [&str; 4]) -> String {
    let listed = signals.map(|name| format!("{{\"Name\":\"{name}\",\"Address\":\"{name}\"}}")).join(",");
    let mut text =
        format!("{{\"Header\":{{\"CycleTimeMs\":2,\"SignalListHFData\":[{{\"Name\":\"CYCLE\"}},{listed}]}},\"Payload\":[");
    for k in 0..SAMPLES {
        let comma = if k > 0 { "," } else { "" };
        let row = row(k, &[0, 1]);
        let values = row.split_once(',').unwrap().1;
        write!(text, "{comma}{{\"HFData\":[[{},{values}]]}}", 500 + k).unwrap();
    }
    text + "]}"
}

#[test]
fn recordings_of_sinumerik_edge_may_lack_the_names_of_axes() {
    let (log, report) = read(edge(["DES_POS|1", "ENC1_POS|1", "DES_POS|2", "ENC2_POS|2"]), None).unwrap();
    assert_eq!(names(&log), ["x", "y"]);
    assert_axis(&log, 0, 0, 1.0);
    assert_axis(&log, 1, 1, 1.0);
    assert_found(&report, Severity::Note, Check::Mended, "axes 1 to 6 are taken for x y z a b c");
    let named = edge(["DES_POS|1", "ENC1_POS|1", "DES_POS|2", "ENC2_POS|2"]);
    let named = named
        .replace("\"DES_POS|2\"}", "\"DES_POS|2\",\"Axis\":\"Z1\"}")
        .replace("\"ENC2_POS|2\"}", "\"ENC2_POS|2\",\"Axis\":\"Z1\"}");
    assert_eq!(names(&read(named, None).unwrap().0), ["x", "z"]);
}

#[test]
fn german_names_are_read_with_their_units() {
    for (header, scale) in [
        ("Zeit,X_Soll,X_Ist,Y_Soll,Y_Ist", 1.0),
        ("Zeit [s];Soll X [µm];Ist X [µm];Soll Y [µm];Ist Y [µm]", 1e-3),
        ("Zeit;SollpositionX;IstpositionX;YSollposition;YIstposition", 1.0),
        ("Zeit;Lagesollwert X;Lageistwert X;Lagesollwert Y;Lageistwert Y", 1.0),
    ] {
        let is_german = header.contains(';');
        let text =
            table(header, |k| if is_german { row(k, &[0, 1]).replace(',', ";").replace('.', ",") } else { row(k, &[0, 1]) });
        // Older controls write Latin-1.
        let latin: Vec<u8> = text.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect();
        for bytes in [text.into_bytes(), latin] {
            let (log, report) = read(bytes, None).unwrap_or_else(|error| panic!("{header}: {error}"));
            assert_eq!(names(&log), ["x", "y"]);
            assert_axis(&log, 0, 0, scale);
            assert_axis(&log, 1, 1, scale);
            assert!(report.findings.is_empty(), "{report}");
        }
    }
}
