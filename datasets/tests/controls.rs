//! Logs as controls write them: names, encoders, gaps, idle axes and clocks of their own.

mod common;

use std::fmt::Write;
use std::path::PathBuf;

use common::assert_found;
use datasets::{
    Check, DatasetError, Log, Purpose, ReadOptions, Report, Severity, assess_runs, read_log, read_reference, read_runs,
};
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
fn a_counter_of_cycles_shows_lost_rows() {
    let folder = tempfile::tempdir().unwrap();
    let rows = (0..4000).filter(|k| !(1500..1700).contains(k));
    let text = rows.fold("CYCLE,DES_POS|1,ENC1_POS|1\n".to_owned(), |text, k| {
        let [reference, actual] = sample(0, k as f64 * PERIOD_S);
        text + &format!("{},{reference:.6},{actual:.6}\n", 90 + 2 * k)
    });
    let path = file(&folder, "run.csv", text);
    let options = ReadOptions { columns: None, period_s: Some(PERIOD_S) };
    let (logs, report) = read_runs(&path, &options).unwrap();
    assert_eq!(logs.iter().map(Log::len).collect::<Vec<_>>(), [1500, 2300]);
    assert_found(&report, Severity::Note, Check::Timing, "200 rows are missing");
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

/// A log of 4000 rows without those that are lost.
fn with_gaps(lost: &[(usize, usize)], time: impl Fn(usize) -> f64) -> String {
    let kept = (0..4000).filter(|k| !lost.iter().any(|(from, to)| (*from..*to).contains(k)));
    kept.fold("t,x_ref,x_act\n".to_owned(), |mut text, k| {
        let [reference, actual] = sample(0, k as f64 * PERIOD_S);
        writeln!(text, "{:.6},{reference:.6},{actual:.6}", time(k)).unwrap();
        text
    })
}

fn runs(text: &str) -> Result<(Vec<Log>, Report), DatasetError> {
    let folder = tempfile::tempdir().unwrap();
    read_runs(&file(&folder, "run.csv", text), &ReadOptions::default())
}

#[test]
fn a_log_with_gaps_is_cut_into_runs() {
    // 4 lost rows are interpolated; 50 and 2000 are not; between them are 100 rows only.
    let text = with_gaps(&[(300, 304), (1000, 1050), (1150, 3150)], |k| 7.0 + k as f64 * PERIOD_S);
    let (logs, report) = runs(&text).unwrap();
    let found: Vec<(&str, usize, f64)> = logs.iter().map(|log| (log.name.as_str(), log.len(), log.start_s)).collect();
    assert_eq!(found, [("run part 1", 1000, 7.0), ("run part 3", 850, 13.3)]);
    for log in &logs {
        assert_eq!(log.period_s(), PERIOD_S);
        let first = ((log.start_s - 7.0) / PERIOD_S).round() as usize;
        for (k, actual) in log.actual.columns()[0].iter().enumerate() {
            assert!((actual - sample(0, (first + k) as f64 * PERIOD_S)[1]).abs() < 2e-3, "{k}");
        }
    }
    let first = "t = 1.998 s: the time steps by 0.102000 s after line 997: 50 rows are missing";
    assert_found(&report, Severity::Note, Check::Timing, first);
    assert_found(&report, Severity::Note, Check::Timing, "steps by 4.002000 s after line 1097: 2000 rows are missing");
    assert_found(&report, Severity::Note, Check::Timing, "left out: part 2 (100 rows, 0.198 s)");
    // Only the part with the lost rows is interpolated.
    assert_found(&report, Severity::Warn, Check::Timing, "run part 1: 1 of 995 intervals");
    assert!(!report.is_refused() && report.findings.len() == 4, "{report}");
    assert!(!assess_runs(&logs, Purpose::Training).is_refused());
}

#[test]
fn a_clock_that_was_set_forward_is_a_gap_and_one_that_was_set_back_is_not() {
    let (logs, report) = runs(&with_gaps(&[], |k| k as f64 * PERIOD_S + if k < 1500 { 0.0 } else { 1e8 })).unwrap();
    assert_eq!(logs.iter().map(Log::len).collect::<Vec<_>>(), [1500, 2500]);
    assert_found(&report, Severity::Note, Check::Timing, "after line 1501");
    let error = runs(&with_gaps(&[], |k| k as f64 * PERIOD_S - if k < 1500 { 0.0 } else { 1.0 })).unwrap_err();
    assert!(matches!(error, DatasetError::TimeOrder { line: 1502, .. }), "{error}");
}

#[test]
fn parts_of_a_log_have_one_period_whatever_the_rounding_of_its_stamps() {
    // Stamps of 10 ms, rows every 4 ms.
    let period_s = 0.004;
    let text = with_gaps(&[(700, 903), (3000, 3102)], |k| (k as f64 * period_s * 100.0 + 1e-9).floor() * 0.01);
    let (logs, report) = runs(&text).unwrap();
    assert_eq!(logs.len(), 3);
    assert!(logs.iter().all(|log| log.period_s() == logs[0].period_s()), "{report}");
    assert!((logs[0].period_s() / period_s - 1.0).abs() < 1e-3, "{}", logs[0].period_s());
}

#[test]
fn a_log_of_scraps_is_refused() {
    let lost: Vec<_> = (0..40).map(|k| (100 * k, 100 * k + 20)).collect();
    let error = runs(&with_gaps(&lost, |k| k as f64 * PERIOD_S)).unwrap_err().to_string();
    assert!(error.contains("39 gaps, the first after line 81") && error.contains("log without loss"), "{error}");
}

#[test]
fn a_log_with_gaps_is_not_one_run() {
    let (_, report) = read(with_gaps(&[(1000, 1100)], |k| k as f64 * PERIOD_S), None).unwrap();
    assert_found(&report, Severity::Refuse, Check::Timing, "100 rows are missing after line 1001");
}

#[test]
fn a_commanded_path_with_gaps_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(&folder, "path.csv", with_gaps(&[(1000, 1100)], |k| k as f64 * PERIOD_S));
    let mapped = ReadOptions { columns: Some("x_ref=x_ref,x_act=x_act".to_owned()), ..ReadOptions::default() };
    for options in [ReadOptions::default(), mapped] {
        let error = read_reference(&path, &options).unwrap_err();
        assert!(matches!(error, DatasetError::Gap { line: 1001, .. }), "{error}");
        assert!(error.to_string().contains("steps by 0.202000 s after 1.998 s"), "{error}");
    }
    let whole = file(&folder, "path.csv", with_gaps(&[(300, 304)], |k| k as f64 * PERIOD_S));
    assert_eq!(read_reference(&whole, &ReadOptions::default()).unwrap().0.len(), 4000);
}

#[test]
fn a_bad_axis_is_left_out_and_the_others_are_used() {
    let header = "t,x_ref,x_act,y_ref,y_act,z_ref,z_act";
    let still = |k: usize| row(k, &[0, 1]) + ",5,5";
    let (log, report) = read(table(header, still), None).unwrap();
    // An axis that stands still is none of these: it may move in another run.
    assert_eq!(names(&log), ["x", "y", "z"]);
    assert!(report.findings.is_empty(), "{report}");
    let stuck = |k: usize| row(k, &[0, 1]) + &format!(",{},7.5", sample(2, k as f64 * PERIOD_S)[0]);
    let (log, report) = read(table(header, stuck), None).unwrap();
    assert_eq!(names(&log), ["x", "y"]);
    assert_axis(&log, 1, 1, 1.0);
    assert_found(&report, Severity::Warn, Check::Mended, "axis z is left out: the command travels");
    let unlogged = |k: usize| row(k, &[0, 1]) + ",,";
    let (log, report) = read(table(header, unlogged), None).unwrap();
    assert_eq!(names(&log), ["x", "y"]);
    assert_found(&report, Severity::Warn, Check::Mended, "axis z is left out: line 2: column `z_ref` has no finite number");
    let hole = |rows: std::ops::Range<usize>| {
        move |k: usize| {
            let mark = if rows.contains(&k) { ",n/a," } else { "," };
            row(k, &[0, 1, 2]).replacen(',', mark, 1).split(',').take(7).collect::<Vec<_>>().join(",")
        }
    };
    let (log, report) = read(table(header, hole(300..360)), None).unwrap();
    assert_eq!(names(&log), ["y", "z"]);
    assert_found(&report, Severity::Warn, Check::Mended, "axis x is left out: line 302: column `x_ref`");
    // Few such rows are interpolated.
    let (log, report) = read(table(header, hole(300..303)), None).unwrap();
    assert_eq!(names(&log), ["x", "y", "z"]);
    let off = |k: usize| (log.reference.columns()[0][k] - sample(0, k as f64 * PERIOD_S)[0]).abs();
    assert!((0..SAMPLES).all(|k| off(k) < 1e-5), "{:?}", (300..303).map(off).collect::<Vec<_>>());
    assert_found(&report, Severity::Warn, Check::Mended, "3 rows lack a value, first `x_ref` in line 302");
}

#[test]
fn a_log_without_a_good_axis_is_refused() {
    let error = read(table("t,x_ref,x_act", |k| row(k, &[0]).rsplit_once(',').unwrap().0.to_owned() + ",2.5"), None).unwrap_err();
    assert!(matches!(&error, DatasetError::Stuck { column, .. } if column == "x_act"), "{error}");
    let error = read(table("t,x_ref,x_act,y_ref,y_act", |k| format!("{},,1,2,", k as f64 * PERIOD_S)), None).unwrap_err();
    assert!(matches!(&error, DatasetError::Missing { line: 2, column, .. } if column == "x_ref"), "{error}");
}
