//! Pieces of a long log are those of the whole.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use motion::{Axis, Trajectory};
use tempfile::TempDir;

use super::*;
use crate::{Log, LogSpool, Purpose, assess, read_log, read_reference, write_all_and, write_log};

const ROWS: usize = 60_000;

fn log() -> Log {
    let column = |speed: f64, late: f64| (0..ROWS).map(|k| 40.0 * (speed * (k as f64 * 1e-3 - late)).sin()).collect::<Vec<f64>>();
    let of =
        |late| Trajectory::new(0.001, ["x", "y"].map(Axis::named).to_vec(), vec![column(0.7, late), column(1.1, late)]).unwrap();
    Log::new("run", of(0.0), of(0.004)).unwrap()
}

fn write(folder: &TempDir, name: &str, content: &str) -> PathBuf {
    let path = folder.path().join(name);
    std::fs::write(&path, content).unwrap();
    path
}

/// A text log with remarks, blank lines, other line ends and columns that are not used.
fn text() -> String {
    let log = log();
    let mut text = String::from("# recorded at the machine\r\n\r\nt,mode,x_ref,x_act,y_ref,y_act\r\n");
    for k in 0..ROWS {
        let at = |of: &Trajectory, axis: usize| of.columns()[axis][k];
        let (time_s, x, y) = (12.0 + k as f64 * 1e-3, at(&log.reference, 0), at(&log.reference, 1));
        let (x_act, y_act) = (at(&log.actual, 0), at(&log.actual, 1));
        write!(text, "{time_s:.4},auto,{x:.6},{x_act:.6},{y:.6},{y_act:.6}\r\n").unwrap();
        if k % 20_000 == 7 {
            text.push_str("# a remark\r\n\r\n");
        }
    }
    text
}

fn open(path: &Path) -> LongFile {
    LongFile::log(path, &ReadOptions::default(), 10_000).unwrap().unwrap()
}

/// Whether all pieces of the file are the rows of the log read whole.
fn check(path: &Path, lengths: Lengths) {
    let (whole, report) = read_log(path, &ReadOptions::default()).unwrap();
    let file = open(path);
    assert_eq!((file.len(), file.period_s(), file.start_s()), (whole.len(), whole.period_s(), whole.start_s));
    assert_eq!((file.report.clone(), file.name()), (report, whole.name.clone()));
    let mut next = 0;
    for piece in file.pieces(lengths).unwrap() {
        let piece = piece.unwrap();
        assert_eq!(piece.first + piece.own.start, next);
        assert_eq!(piece.own.start, lengths.before.min(next));
        next += piece.own.len();
        let end = piece.first + piece.reference.len();
        assert_eq!(end, (next + lengths.after).min(whole.len()));
        let wanted = whole.part(whole.name.clone(), piece.first, end).unwrap();
        let found = piece.into_log(whole.name.clone()).unwrap();
        assert!(found.reference == wanted.reference && found.actual == wanted.actual);
    }
    assert_eq!(next, whole.len());
    // Stretches far apart, as training takes them.
    let mut pieces = file.pieces(lengths).unwrap();
    for from in [100, 30_000, 30_500, ROWS - 50] {
        let piece = pieces.at(from..from + 40).unwrap();
        let last = whole.axes().len() - 1;
        let own = &piece.reference.columns()[last][piece.own.clone()];
        assert_eq!(own, &whole.reference.columns()[last][from..from + 40]);
    }
}

#[test]
fn pieces_of_text_and_parquet_are_those_of_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    let csv = write(&folder, "run.csv", &text());
    let parquet = folder.path().join("run.parquet");
    write_log(&parquet, &log()).unwrap();
    for (own, before, after) in [(1000, 0, 0), (7777, 2000, 500), (500, 3000, 800), (200_000, 5, 5)] {
        check(&csv, Lengths { own, before, after });
        check(&parquet, Lengths { own, before, after });
    }
}

#[test]
fn a_last_row_that_is_cut_off_is_left_out_with_the_same_words() {
    let folder = tempfile::tempdir().unwrap();
    for end in ["72.0000,auto,1.0", "72.0000,auto,1.000000,1.000000,1.000000,1.0"] {
        check(&write(&folder, "cut.csv", &(text() + end)), Lengths { own: 30_000, before: 0, after: 0 });
    }
}

#[test]
fn tracking_errors_become_positions_as_of_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    let log = log();
    let of = |from: &Trajectory, axis: usize| from.columns()[axis].clone();
    let less = |a: Vec<f64>, b: Vec<f64>| a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<f64>>();
    let [x, x_act, y, y_act] = [of(&log.reference, 0), of(&log.actual, 0), of(&log.reference, 1), of(&log.actual, 1)];
    let time = (0..ROWS).map(|k| k as f64 * 0.001).collect();
    let columns =
        [("t", time), ("x_ref", x.clone()), ("x_err", less(x, x_act)), ("y_act", y_act.clone()), ("YLag", less(y, y_act))];
    for path in both_forms(&folder, &columns) {
        check(&path, Lengths { own: 7777, before: 100, after: 100 });
        let (whole, report) = read_log(&path, &ReadOptions::default()).unwrap();
        let near = |found: &Trajectory, wanted: &Trajectory| {
            found.columns().iter().flatten().zip(wanted.columns().iter().flatten()).all(|(a, b)| (a - b).abs() < 1e-8)
        };
        assert!(near(&whole.reference, &log.reference) && near(&whole.actual, &log.actual));
        assert!(report.to_string().contains("`YLag`, which counts as command minus actual position"), "{report}");
    }
}

/// The line of a text log at this index, and its fields.
fn line_of(text: &str, index: usize) -> (&str, Vec<&str>) {
    let line = text.lines().nth(index).unwrap();
    (line, line.split(',').collect())
}

/// A text log whose lines of these indices are those that `line` makes of time, actual position of x and command of y.
fn hurt(text: &str, lines: std::ops::Range<usize>, line: impl Fn([&str; 3]) -> String) -> String {
    let of = |(index, old): (usize, &str)| {
        let fields: Vec<&str> = old.split(',').collect();
        let is_row = lines.contains(&index) && fields.len() == 6;
        if is_row { line([fields[0], fields[3], fields[4]]) } else { old.to_owned() }
    };
    text.lines().enumerate().map(of).fold(String::new(), |text, line| text + &line + "\n")
}

#[test]
fn faults_have_the_words_of_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    let (text, lines) = (text(), 50_003);
    let (line, fields) = line_of(&text, lines);
    let [t, x, y] = [fields[0], fields[2], fields[5]];
    // Both axes, over more rows than a spike has.
    let no_axis = hurt(&text, lines..lines + 9, |[t, x_act, y]| format!("{t},auto,1e9,{x_act},{y},1e9"));
    // A stamp, too few fields and too many.
    for mended in [&no_axis, &line.replace(t, "1e300"), &line.replace(&format!(",{y}"), ""), &format!("{line},7")] {
        let (line, mended) = if mended == &no_axis { (text.as_str(), mended) } else { (line, mended) };
        let path = write(&folder, "fault.csv", &text.replace(line, mended));
        let found = LongFile::log(&path, &ReadOptions::default(), 10_000).unwrap_err().to_string();
        assert_eq!(found, read_log(&path, &ReadOptions::default()).unwrap_err().to_string());
        assert!(found.contains(&format!("line {}", lines + 1)), "{found}");
    }
    // A commanded path needs all of its axes.
    let path = write(&folder, "fault.csv", &text.replace(line, &line.replace(x, "nan")));
    let found = LongFile::reference(&path, &ReadOptions::default(), 10_000).unwrap_err().to_string();
    assert_eq!(found, read_reference(&path, &ReadOptions::default()).unwrap_err().to_string());
}

#[test]
fn a_bad_axis_is_left_out_as_of_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    let text = text();
    let stuck: String = text
        .lines()
        .map(|line| match line.split(',').collect::<Vec<_>>()[..] {
            [t, mode, x, "x_act", y, y_act] => [t, mode, x, "x_act", y, y_act].join(","),
            [t, mode, x, _, y, y_act] => [t, mode, x, "3.25", y, y_act].join(","),
            _ => line.to_owned(),
        } + "\n")
        .collect();
    let without: String = text
        .lines()
        .map(|line| match line.split(',').collect::<Vec<_>>()[..] {
            [t, mode, x, x_act, y, y_act] if x != "x_ref" => [t, mode, "", x_act, y, y_act].join(","),
            _ => line.to_owned(),
        } + "\n")
        .collect();
    for (bad, kept, words) in [
        (without, "y", "axis x is left out: line 4: column `x_ref` has no finite number"),
        (
            hurt(&text, 50_003..50_012, |[t, x_act, y]| format!("{t},auto,{x_act},{x_act},{y},1e9")),
            "x",
            "axis y is left out: line 50004: column `y_act` holds 1000000000 mm",
        ),
        (stuck, "y", "column `x_act` never changes"),
    ] {
        let path = write(&folder, "bad.csv", &bad);
        check(&path, Lengths { own: 7777, before: 100, after: 100 });
        let file = open(&path);
        let names: Vec<&str> = file.axes().iter().map(|axis| axis.name.as_str()).collect();
        assert_eq!((names, file.extents().len()), (vec![kept], 1));
        let message = &file.report.findings.last().unwrap().message;
        assert!(message.contains(words), "{message}");
    }
}

#[test]
fn what_is_short_or_uneven_is_read_whole() {
    let folder = tempfile::tempdir().unwrap();
    let text = text();
    let short = write(&folder, "short.csv", &text[..100_000]);
    let gap = write(&folder, "gap.csv", &text.replace("\r\n42.0", "\r\n42.5"));
    let (line, fields) = line_of(&text, 50_003);
    let hole = write(&folder, "hole.csv", &text.replace(line, &line.replace(fields[2], "")));
    let turns: String = (0..ROWS).map(|k| format!("{:.3},{1:.4},{1:.4}\n", k as f64 * 1e-3, (k as f64 * 0.01) % 360.0)).collect();
    let turns = write(&folder, "turns.csv", &(String::from("t,c_ref_deg,c_act_deg\n") + &turns));
    let spike = write(&folder, "spike.csv", &text.replace(line, &line.replace(fields[3], "-9999")));
    for path in [short, gap, hole, turns, spike] {
        assert!(LongFile::log(&path, &ReadOptions::default(), 10_000).unwrap().is_none(), "{}", path.display());
    }
    let path = write(&folder, "run.csv", &text);
    assert!(LongFile::log(&path, &ReadOptions::default(), ROWS + 1000).unwrap().is_none());
}

#[test]
fn a_reference_has_the_commanded_columns() {
    let folder = tempfile::tempdir().unwrap();
    let path = write(&folder, "run.csv", &text());
    let file = LongFile::reference(&path, &ReadOptions::default(), 10_000).unwrap().unwrap();
    let (whole, _) = read_reference(&path, &ReadOptions::default()).unwrap();
    let piece = file.pieces(Lengths { own: ROWS, before: 0, after: 0 }).unwrap().next().unwrap().unwrap();
    assert!(piece.reference == whole && piece.actual.is_none());
    let extent = file.extents()[0];
    let column = &whole.columns()[0];
    let two_steps = column.windows(3).map(|three| (three[2] - three[0]).abs()).fold(0.0, f64::max);
    assert_eq!(extent.two_steps, two_steps);
    assert_eq!(extent.high, column.iter().copied().fold(0.0, f64::max));
}

#[test]
fn a_spool_holds_what_is_written_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let log = log();
    for name in ["run.csv", "run.parquet"] {
        let (whole, path) = (folder.path().join(format!("whole-{name}")), folder.path().join(name));
        write_log(&whole, &log).unwrap();
        let mut spool = LogSpool::new(&path, log.axes(), log.period_s()).unwrap();
        for from in (0..ROWS).step_by(7001) {
            let rows = from..(from + 7001).min(ROWS);
            let slices = |of: &'_ Trajectory| of.columns().iter().map(|column| column[rows.clone()].to_vec()).collect::<Vec<_>>();
            let [reference, actual] = [slices(&log.reference), slices(&log.actual)];
            let [reference, actual]: [Vec<&[f64]>; 2] = [&reference, &actual].map(|of| of.iter().map(Vec::as_slice).collect());
            spool.add(&reference, &actual).unwrap();
        }
        // Nothing shows before it is written.
        assert!(!path.exists());
        write_all_and(&[], &mut [spool.finish().unwrap()]).unwrap();
        let read = |path: &Path| read_log(path, &ReadOptions::default()).unwrap().0;
        let (found, wanted) = (read(&path), read(&whole));
        assert!(found.reference == wanted.reference && found.actual == wanted.actual, "{name}");
    }
}

/// These columns as a text table and as Parquet.
fn both_forms(folder: &TempDir, columns: &[(&str, Vec<f64>)]) -> [PathBuf; 2] {
    let named: Vec<(String, Vec<f64>)> = columns.iter().map(|(name, column)| ((*name).to_owned(), column.clone())).collect();
    let mut parquet = Vec::new();
    crate::formats::parquet::write(&mut parquet, &named).unwrap();
    let path = folder.path().join("run.parquet");
    std::fs::write(&path, parquet).unwrap();
    let mut text = columns.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(",") + "\n";
    for k in 0..columns[0].1.len() {
        let row: Vec<String> = columns.iter().map(|(_, column)| format!("{:.9}", column[k])).collect();
        text += &(row.join(",") + "\n");
    }
    [path, write(folder, "run.csv", &text)]
}

#[test]
fn the_encoder_is_chosen_as_for_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    let column = |gain: f64| (0..ROWS).map(|k| gain * (1.0 + (k as f64 * 0.0007).sin())).collect::<Vec<f64>>();
    for table in [1.2, 0.0] {
        let time = (0..ROWS).map(|k| k as f64 * 0.001).collect();
        let columns = [("time", time), ("DES_POS|1", column(1.0)), ("ENC1_POS|1", column(1.1)), ("ENC2_POS|1", column(table))];
        for path in both_forms(&folder, &columns) {
            check(&path, Lengths { own: 7777, before: 100, after: 100 });
            let highest = read_log(&path, &ReadOptions::default()).unwrap().0.actual.columns()[0][2244];
            assert!((highest - 2.0 * if table > 0.0 { table } else { 1.1 }).abs() < 1e-3, "{highest}");
        }
    }
}

#[test]
fn an_axis_that_never_moves_is_noted_as_of_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    let column = |late: f64| (0..ROWS).map(|k| 40.0 * (0.7 * (k as f64 * 1e-3 - late)).sin()).collect::<Vec<f64>>();
    let time = (0..ROWS).map(|k| k as f64 * 0.001).collect();
    let still = vec![5.0; ROWS];
    let columns = [("t", time), ("x_ref", column(0.0)), ("x_act", column(0.004)), ("y_ref", still.clone()), ("y_act", still)];
    for path in both_forms(&folder, &columns) {
        let (whole, _) = read_log(&path, &ReadOptions::default()).unwrap();
        let (file, mut findings) = (open(&path), PieceFindings::default());
        assert_eq!(file.axes(), whole.axes());
        for piece in file.pieces(Lengths { own: 20_000, before: 0, after: 0 }).unwrap() {
            findings.add(&piece.unwrap(), Purpose::Training);
        }
        let is_reported = |report: &Report| {
            report.findings.iter().any(|f| f.to_string().contains("y_ref: the axis never moves and is left out"))
        };
        assert!(is_reported(&findings.into_report()) && is_reported(&assess(&whole, Purpose::Training)));
    }
}
