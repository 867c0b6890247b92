//! Reading and writing of files.

mod common;

use std::path::{Path, PathBuf};

use common::{assert_found, healthy};
use datasets::{Check, DatasetError, Log, ReadOptions, Report, Severity, read_log, read_reference, write_log, write_reference};
use motion::{Axis, AxisKind, Trajectory};

fn file(folder: &tempfile::TempDir, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

fn read_bytes(bytes: &[u8], options: &ReadOptions) -> Result<(Log, Report), DatasetError> {
    let folder = tempfile::tempdir().unwrap();
    read_log(&file(&folder, "log.csv", bytes), options)
}

fn read(text: &str) -> Result<(Log, Report), DatasetError> {
    read_bytes(text.as_bytes(), &ReadOptions::default())
}

fn mapped(text: &str, columns: &str) -> Result<(Log, Report), DatasetError> {
    let options = ReadOptions { columns: Some(columns.to_owned()), ..ReadOptions::default() };
    read_bytes(text.as_bytes(), &options)
}

const SMALL: &str = "t,x_ref,x_act\n0.000,0,0.5\n0.002,1,1.5\n0.004,2,2.5\n0.006,3,3.5\n0.008,4,4.5\n";

fn assert_small(log: &Log) {
    assert_eq!(log.reference.columns(), [vec![0.0, 1.0, 2.0, 3.0, 4.0]]);
    assert_eq!(log.actual.columns(), [vec![0.5, 1.5, 2.5, 3.5, 4.5]]);
    assert_eq!(log.period_s(), 0.002);
}

#[test]
fn logs_come_back_from_csv_to_a_nanometre_and_from_parquet_exactly() {
    let folder = tempfile::tempdir().unwrap();
    let mut log = healthy();
    for (name, tolerance) in [("a.csv", 0.51e-9), ("a.parquet", 0.0)] {
        log.name = "a".to_owned();
        let path = folder.path().join(name);
        write_log(&path, &log).unwrap();
        let (back, report) = read_log(&path, &ReadOptions::default()).unwrap();
        assert!(report.findings.is_empty(), "{report}");
        back.reference.check_matches(&log.reference).unwrap();
        assert_eq!(back.name, log.name);
        for (mine, yours) in [(&back.reference, &log.reference), (&back.actual, &log.actual)] {
            for (a, b) in mine.columns().iter().flatten().zip(yours.columns().iter().flatten()) {
                assert!((a - b).abs() <= tolerance, "{a} {b}");
            }
        }
    }
    let text = std::fs::read_to_string(folder.path().join("a.csv")).unwrap();
    assert!(text.starts_with("t,x_ref,x_act,y_ref,y_act\n0.000000000,"), "{}", &text[..60]);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
}

#[test]
fn references_come_back_and_are_found_in_logs() {
    let folder = tempfile::tempdir().unwrap();
    let axes = ["x", "y", "z", "b", "c"].map(Axis::named).to_vec();
    let columns = (0..5).map(|axis| (0..100).map(|k| f64::from(k * axis) * 0.001).collect()).collect();
    let reference = Trajectory::new(0.004, axes, columns).unwrap();
    for name in ["r.csv", "r.pq"] {
        let path = folder.path().join(name);
        write_reference(&path, &reference).unwrap();
        let (back, _) = read_reference(&path, &ReadOptions::default()).unwrap();
        back.check_matches(&reference).unwrap();
        for (a, b) in back.columns().iter().flatten().zip(reference.columns().iter().flatten()) {
            assert!((a - b).abs() < 0.51e-9);
        }
    }
    let path = file(&folder, "log.csv", SMALL.as_bytes());
    let (found, _) = read_reference(&path, &ReadOptions::default()).unwrap();
    assert_eq!(found.columns(), [vec![0.0, 1.0, 2.0, 3.0, 4.0]]);
}

#[test]
fn many_ways_to_write_a_table_are_one() {
    let tabs = SMALL.replace(',', "\t");
    let blanks = SMALL.replace(',', "   ");
    let german = SMALL.replace(',', ";").replace('.', ",");
    let comment = format!("# logged on a mill\n# t,x_ref,x_act\n{}", SMALL.split_once('\n').unwrap().1);
    let preamble = format!("Name;Scope\n\n{}", SMALL.replace(',', ";"));
    let crlf = SMALL.replace('\n', "\r\n");
    let units = SMALL.replacen('\n', "\ns,mm,mm\n", 1);
    let trailing = SMALL.replace('\n', ",\n").replacen(",\n", "\n", 1);
    let quoted = SMALL.replacen("t,x_ref,x_act", "\"t\",\"x_ref\",\"x_act\"", 1);
    let signs = SMALL.replace(",4,", ",+4.0e0,");
    for text in [SMALL, &tabs, &blanks, &german, &comment, &preamble, &crlf, &units, &trailing, &quoted, &signs] {
        let (log, report) = read(text).unwrap_or_else(|error| panic!("{text}\n{error}"));
        assert_small(&log);
        assert!(report.worst() <= Some(Severity::Note), "{text}\n{report}");
    }
    let marked = [b"\xEF\xBB\xBF".as_slice(), SMALL.as_bytes()].concat();
    let wide: Vec<u8> = [0xFEFF].into_iter().chain(SMALL.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    for bytes in [marked, wide] {
        assert_small(&read_bytes(&bytes, &ReadOptions::default()).unwrap().0);
    }
}

#[test]
fn units_in_names_are_converted() {
    let text = "Time [ms];X Command Position [um];X Actual Position [um];A_set_deg;A_act_deg\n\
                0;0;500;0;180\n2;1000;1500;90;90\n4;2000;2500;0;0\n6;3000;3500;0;0\n8;4000;4500;0;0\n";
    let (log, _) = read(text).unwrap();
    assert_eq!(log.axes()[1].kind, AxisKind::Rotary);
    assert!((log.actual.columns()[1][0] - std::f64::consts::PI).abs() < 1e-15);
    assert!((log.actual.columns()[0][4] - 4.5).abs() < 1e-12);
    assert_eq!(log.period_s(), 0.002);
}

#[test]
fn mappings_name_what_does_not_speak_for_itself() {
    let text = "clock,p,q,r\n0,0,500,9\n2,1,1500,9\n4,2,2500,9\n6,3,3500,9\n8,4,4500,9\n";
    let (log, report) = mapped(text, "t=clock:ms,x_ref=p,x_act=q*0.001").unwrap();
    assert_small(&log);
    assert_found(&report, Severity::Note, Check::Mended, "columns not used: r");
    let headless = &text[text.find('\n').unwrap() + 1..];
    assert_small(&mapped(headless, "t=#1:ms,x_ref=#2,x_act=#3:um").unwrap().0);
    assert!(matches!(read(text), Err(DatasetError::Columns { .. })));
    assert!(matches!(mapped(text, "t=clock:ms,x_ref=p"), Err(DatasetError::Mapping { .. })));
}

#[test]
fn a_truncated_last_row_is_left_out_with_a_warning() {
    for (cut, words) in [
        ("0.010", "the last row (line 7) is cut off after 1 of 3 fields"),
        ("0.010,5", "is cut off after 2 of 3 fields"),
        ("0.010,5\n", "is cut off after 2 of 3 fields"),
        ("0.010,5,", "ends within a number"),
        ("0.010,5,5", "ends within a number"),
    ] {
        let (log, report) = read(&format!("{SMALL}{cut}")).unwrap();
        assert_small(&log);
        assert_found(&report, Severity::Warn, Check::Mended, words);
    }
}

#[test]
fn holes_are_refused_with_line_and_column() {
    for hole in ["", "NaN", "inf", "err", "1e999"] {
        let error = read(&SMALL.replace("2.5", hole)).unwrap_err();
        assert!(matches!(&error, DatasetError::Missing { line: 4, column, .. } if column == "x_act"), "{hole}: {error}");
    }
    let error = read(&SMALL.replace("0.004,2,2.5", "0.004,2")).unwrap_err();
    assert!(matches!(error, DatasetError::Ragged { line: 4, found: 2, expected: 3, .. }), "{error}");
    let error = read(&SMALL.replace("2,2.5", "2,2.5,7")).unwrap_err();
    assert!(matches!(error, DatasetError::Ragged { line: 4, found: 4, expected: 3, .. }), "{error}");
}

#[test]
fn stamps_that_stand_still_need_a_stated_period() {
    let rows: Vec<String> =
        (0..4000).map(|k| format!("{},{1},{1}", 1_700_000_000 + k / 4000, (0.01 * f64::from(k)).sin())).collect();
    let text = format!("t,x_ref,x_act\n{}\n", rows.join("\n"));
    let error = read(&text).unwrap_err().to_string();
    assert!(
        error.contains("3999 of 4000 time stamps are those of the row before") && error.contains("state the sampling period"),
        "{error}"
    );
}

#[test]
fn time_stamps_are_checked() {
    let (log, report) = read(&SMALL.replace("0.004,2,2.5\n", "0.004,2,2.5\n0.004,2,2.5\n")).unwrap();
    assert_small(&log);
    assert_found(&report, Severity::Warn, Check::Mended, "1 rows repeat the row before them, stamp and all (first in line 5)");
    let error = read(&SMALL.replace("0.006", "0.001")).unwrap_err();
    assert!(matches!(error, DatasetError::TimeOrder { line: 5, .. }), "{error}");
    let (_, report) = read(&format!("{SMALL}0.100,50,50.5\n0.102,51,51.5\n0.104,52,52.5\n")).unwrap();
    assert_found(&report, Severity::Refuse, Check::Timing, "45 rows are missing after line 6");
    assert!(matches!(read(&SMALL.replace("t,", "number,")), Err(DatasetError::NoTime { .. })));
    assert!(matches!(read("t,x_ref,x_act\n0,1,1\n"), Err(DatasetError::TooShort { rows: 1, .. })));
}

#[test]
fn columns_that_contradict_each_other_are_refused() {
    for header in ["t,x_ref,x_ref", "t,x_ref_mm,x_act_deg", "t,x_ref,y_act", "t_mm,x_ref,x_act", "a,b,c"] {
        let error = read(&SMALL.replace("t,x_ref,x_act", header)).unwrap_err();
        assert!(matches!(error, DatasetError::Columns { .. }), "{header}: {error}");
    }
}

#[test]
fn bytes_of_any_kind_are_refused_in_words() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in [
        ("empty.csv", b"".as_slice()),
        ("text.csv", b"hello\nworld\n"),
        ("zeros.bin", &[0; 100]),
        ("short.parquet", b"PAR1"),
        ("noise.parquet", b"PAR1 and nothing that makes sense PAR1"),
        ("image.png", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR"),
    ] {
        let error = read_log(&file(&folder, name, bytes), &ReadOptions::default()).unwrap_err();
        assert!(error.to_string().contains(name), "{error}");
    }
    let program = b"%\n(CUBE, 10 MM)\nN10 G21 G90\n/N20 G0 X0 Y0 (start)\nG1 X10. F600\nX20 Y-1.5\nM30\n%\n";
    let error = read_log(&file(&folder, "part.nc", program), &ReadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("part program"), "{error}");
    let archive = file(&folder, "book.xlsx", b"PK\x03\x04\x14\0\0\0\x08\0[Content_Types].xml");
    let error = read_log(&archive, &ReadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("archive") && error.contains("CSV"), "{error}");
    assert!(matches!(read_log(Path::new("nowhere.csv"), &ReadOptions::default()), Err(DatasetError::Io { .. })));
}

#[test]
fn a_damaged_parquet_file_is_an_error_or_a_log_and_never_a_panic() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("good.parquet");
    write_log(&path, &healthy().part("small", 0, 200).unwrap()).unwrap();
    let good = std::fs::read(&path).unwrap();
    for place in (4..good.len()).step_by(37) {
        let cut = file(&folder, "cut.parquet", &good[..place]);
        assert!(read_log(&cut, &ReadOptions::default()).is_err());
        let mut bytes = good.clone();
        bytes[place] ^= 0x55;
        let _ = read_log(&file(&folder, "bad.parquet", &bytes), &ReadOptions::default());
    }
}

#[test]
fn a_failed_write_leaves_what_was_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(&folder, "log.csv", b"precious");
    let result = datasets::write_atomically(&path, |file| {
        use std::io::Write;
        file.write_all(b"half").unwrap();
        Err(DatasetError::Runs("stopped".to_owned()))
    });
    assert!(result.is_err());
    assert_eq!(std::fs::read(&path).unwrap(), b"precious");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    assert!(write_log(&folder.path().join("no/where.csv"), &healthy()).is_err());
}

#[test]
fn implausible_numbers_are_refused_with_their_position() {
    let folder = tempfile::tempdir().unwrap();
    let rows = |period_s: f64, row: usize, value: f64| {
        let at = |k: usize| if (row..row + 5).contains(&k) { value } else { 0.001 * k as f64 };
        let row_of = |k: usize| format!("{:e},{:e},{:e}\n", k as f64 * period_s, at(k), 0.001 * k as f64);
        format!("t,x_ref,x_act\n{}", (0..50).map(row_of).collect::<String>())
    };
    let said = |text: String, period_s: Option<f64>| {
        let path = file(&folder, "log.csv", text.as_bytes());
        read_log(&path, &ReadOptions { period_s, ..ReadOptions::default() }).unwrap_err().to_string()
    };
    let error = said(rows(0.002, 7, 1e300), None);
    assert!(error.contains("line 9: column `x_ref`") && error.contains("mm"), "{error}");
    let error = said(rows(1e298, 99, 0.0), None);
    assert!(error.contains("line 3: column `t`"), "{error}");
    for period_s in [1e5, 1e-9] {
        let error = said(rows(period_s, 99, 0.0), None);
        assert!(error.contains("sampling period"), "{error}");
    }
    for period_s in [1e300, 1e-300] {
        let error = said(rows(0.002, 99, 0.0).replace("t,", "k,"), Some(period_s));
        assert!(error.contains("sampling period"), "{error}");
    }
    assert!(read_log(&file(&folder, "log.csv", rows(0.002, 99, 0.0).as_bytes()), &ReadOptions::default()).is_ok());
}
