//! Exports of scopes, laboratory software and scripts: LinuxCNC's `halscope` with decimal commas, TwinCAT Scope, LabVIEW, JSON, two rows of names.

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

/// The first rows of an export of TwinCAT 3, and of TwinCAT 2.
const TWINCAT_3: &str = "Name;YT Chart\r\nFile;C:\\scope\\run.svdx\r\nStarttime of export;133500000000000000;Thursday\r\nEndtime of export;133500000008000000;Thursday\r\n\r\n";
const TWINCAT_2: &str = "Name;Scope01\r\nFile;\r\nStartRecord;128783093223690000;Donnerstag, 5. Februar 2009;13:08:42\r\nEndRecord;128783093339880000;;\r\n\r\n";

/// One row of the header of channels: the key before every channel.
fn header(key: &str, values: [&str; 4]) -> String {
    values.map(|value| format!("{key};{value}")).join(";") + "\r\n"
}

fn channels(rows: &[(&str, [&str; 4])]) -> String {
    rows.iter().map(|(key, values)| header(key, *values)).collect()
}

const NAMES: [&str; 4] = ["X SetPos", "X ActPos", "Z SetPos", "Z ActPos"];

/// Four channels, each with its own time: value and stamp of row `k`, or none.
fn scope(first: &str, head: &[(&str, [&str; 4])], at: impl Fn(usize, usize) -> Option<(f64, f64)>) -> String {
    let mut text = first.to_owned() + &channels(head) + "\r\n";
    for k in 0..SAMPLES {
        let fields =
            [0, 1, 2, 3].map(|channel| at(channel, k).map_or(";".to_owned(), |(time, value)| format!("{time};{value:.6}")));
        writeln!(text, "{}\r", fields.join(";").replace('.', ",")).unwrap();
    }
    text + "EOF\r\n"
}

fn at(channel: usize, t: f64) -> f64 {
    sample(t)[channel]
}

#[test]
fn exports_of_both_scopes_of_twincat_are_read() {
    let three = [
        ("Name", NAMES),
        ("SymbolComment", [""; 4]),
        ("Data-Type", ["REAL64"; 4]),
        ("SampleTime[ms]", ["2"; 4]),
        ("SymbolName", ["a.b"; 4]),
        ("Unit", ["mm"; 4]),
    ];
    let two = [
        ("Name", NAMES),
        ("NetId", ["172.16.8.205.1.1"; 4]),
        ("Port", ["801"; 4]),
        ("SampleTime[ms]", ["2"; 4]),
        ("SymbolBased", ["TRUE"; 4]),
        ("Data-Type", ["ADST_REAL64"; 4]),
    ];
    // Milliseconds since the first sample, or ticks of 100 ns since 1601.
    for start in [0.0, 1.335e17] {
        let time = |k: usize| if start > 0.0 { start + k as f64 * 20_000.0 } else { k as f64 * 2.0 };
        for (first, head) in [(TWINCAT_3, &three[..]), (TWINCAT_2, &two[..])] {
            let text = scope(first, head, |channel, k| Some((time(k), at(channel, k as f64 * PERIOD_S))));
            let (log, report) = read("scope.csv", &text).unwrap();
            assert_sample(&log);
            assert!(report.findings.is_empty(), "{report}");
            assert_sample(&read("scope.txt", text.replace(';', "\t")).unwrap().0);
        }
    }
}

#[test]
fn the_row_of_sampling_times_may_be_missing() {
    let text = scope(TWINCAT_3, &[("Name", NAMES)], |channel, k| Some((2.0 * k as f64, at(channel, k as f64 * PERIOD_S))));
    assert_sample(&read("scope.csv", text).unwrap().0);
}

#[test]
fn a_header_of_many_channels_is_recognised() {
    let long = "MAIN.fbMachine.stStation.stAxis.NcToPlc.".repeat(30);
    let head = [("Name", NAMES), ("SymbolName", [long.as_str(); 4]), ("SampleTime[ms]", ["2"; 4]), ("Unit", ["mm"; 4])];
    assert_sample(
        &read("scope.csv", scope(TWINCAT_3, &head, |channel, k| Some((2.0 * k as f64, at(channel, k as f64 * PERIOD_S)))))
            .unwrap()
            .0,
    );
}

#[test]
fn channels_of_twincat_with_times_of_their_own_are_joined() {
    let head = [("Name", NAMES), ("SampleTime[ms]", ["2", "4", "2", "4"]), ("Unit", ["mm"; 4])];
    let value = |channel: usize, t: f64| Some((1e3 * t, at(channel, t)));
    // Slower channels end early, or have samples in every second row only.
    let early = |channel: usize, k: usize| match channel % 2 {
        1 if k >= SAMPLES / 2 => None,
        1 => value(channel, 2.0 * k as f64 * PERIOD_S),
        _ => value(channel, k as f64 * PERIOD_S),
    };
    let spread =
        |channel: usize, k: usize| if channel % 2 == 1 && k % 2 == 1 { None } else { value(channel, k as f64 * PERIOD_S) };
    for text in [scope(TWINCAT_3, &head, early), scope(TWINCAT_3, &head, spread)] {
        let (log, report) = read("scope.csv", text).unwrap();
        assert_eq!((log.len(), log.axes().len(), log.period_s()), (SAMPLES - 1, 2, PERIOD_S));
        assert_found(&report, Severity::Note, Check::Timing, "X ActPos mm");
        for k in 0..log.len() {
            let wanted = sample(k as f64 * PERIOD_S);
            assert!((log.reference.columns()[0][k] - wanted[0]).abs() < 1e-9);
            // a·T²/8 at 720 mm/s² and 4 ms.
            assert!((log.actual.columns()[0][k] - wanted[1]).abs() < 1.5e-3);
        }
    }
}

#[test]
fn exports_of_twincat_without_times_have_the_sampling_time_of_their_header() {
    let values = |separator: &str, k: usize| sample(k as f64 * PERIOD_S).map(|value| format!("{value:.6}")).join(separator);
    let rows = |start: &str| (0..SAMPLES).map(|k| format!("{start}{}\n", values(";", k))).collect::<String>();
    let paired = |rate: &str| channels(&[("Name", NAMES), ("SampleTime[ms]", ["2", "2", "2", rate]), ("Unit", ["mm"; 4])]);
    let single = |rate: &str| format!("Name;{}\nSampleTime[ms];2;2;2;{rate}\nUnit;mm;mm;mm;mm\n", NAMES.join(";"));
    for (good, bad) in [
        (paired("2") + "\n" + &rows(""), paired("4") + "\n" + &rows("")),
        (single("2") + "\n" + &rows(";"), single("4") + "\n" + &rows(";")),
    ] {
        let (log, report) = read("scope.csv", TWINCAT_3.to_owned() + &good).unwrap();
        assert_sample(&log);
        assert!(report.findings.is_empty(), "{report}");
        let error = read("scope.csv", TWINCAT_3.to_owned() + &bad).unwrap_err().to_string();
        assert!(error.contains("every 2 ms and every 4 ms") && error.contains("Timelines: All"), "{error}");
    }
}

#[test]
fn binary_files_of_twincat_scope_are_refused_with_the_remedy() {
    // As documented: lengths as 64-bit and 32-bit numbers before names.
    let mut bytes = 90_i64.to_le_bytes().to_vec();
    bytes.extend(5_i32.to_le_bytes());
    bytes.extend(b"Scope");
    bytes.extend(133_500_000_000_000_000_i64.to_le_bytes());
    for name in ["run.svb", "RUN.SVB", "run.svdx"] {
        let error = read(name, &bytes).unwrap_err().to_string();
        assert!(error.contains("binary file of TwinCAT Scope") && error.contains("export the channels as CSV"), "{error}");
    }
    assert!(read("run.bin", &bytes).unwrap_err().to_string().contains("no format that is known"));
}

#[test]
fn no_bytes_make_reading_panic() {
    let head = [("Name", NAMES), ("SampleTime[ms]", ["2", "4", "2", "4"]), ("Unit", ["mm"; 4])];
    let paired = scope(TWINCAT_3, &head, |channel, k| Some((2.0 * k as f64, at(channel, k as f64 * PERIOD_S))));
    let pairs = (0..SAMPLES).fold("t,DES_POS|1,t,ENC2_POS|1,ENC1_POS|1,CYCLE\n".to_owned(), |text, k| {
        let [a, b, ..] = sample(k as f64 * PERIOD_S);
        let t = 0.002 * k as f64 + if k > 200 { 3.0 } else { 0.0 };
        text + &format!("{t},{a:.6},{},{b:.6},0,{k}\n", t + 0.0007)
    });
    let mut state = 7_u64;
    let mut draw = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.csv");
    let mapped = ReadOptions { columns: Some("t_ref=#1,t_act=#3,x_ref=#2,x_act=#4,x:inch".to_owned()), period_s: Some(PERIOD_S) };
    let (mut read_well, mut refused) = (0, 0);
    for text in [paired, pairs, halscope("\t", "2,0 ms", "")] {
        for _ in 0..200 {
            let mut bytes = text.clone().into_bytes();
            bytes.truncate(1 + draw(bytes.len()));
            for _ in 0..draw(12) {
                // Half of the changes are in the header.
                let within = if draw(2) == 0 { bytes.len().min(300) } else { bytes.len() };
                let place = draw(within);
                bytes[place] = [b'0', b'-', b';', b'"', b'|', b'\n', b'e', 0xFF, b' ', b',', b'\t', b't'][draw(12)];
            }
            std::fs::write(&path, bytes).unwrap();
            for options in [ReadOptions::default(), mapped.clone()] {
                let _ = read_log(&path, &options);
                let _ = datasets::read_reference(&path, &options);
                match datasets::read_runs(&path, &options) {
                    Ok(_) => read_well += 1,
                    Err(_) => refused += 1,
                }
            }
        }
    }
    assert!(read_well > 50 && refused > 50, "{read_well} {refused}");
}

/// The samples, one line each as `line` writes them.
fn rows(line: impl Fn(f64, [f64; 4]) -> String) -> String {
    (0..SAMPLES).map(|k| k as f64 * PERIOD_S).map(|t| line(t, sample(t)) + "\n").collect()
}

#[test]
fn measurement_files_of_labview_are_read() {
    let head = "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\nDecimal_Separator\t.\nDate\t2026/11/04\nTime\t10:11:12.345678\n\
                ***End_of_Header***\t\n\t\nChannels\t4\t\nSamples\t400\t400\t400\t400\t\nY_Unit_Label\tmm\tmm\tmm\tmm\t\n\
                X0\t0.0E+0\t0.0E+0\t0.0E+0\t0.0E+0\t\nDelta_X\t0.002\t0.002\t0.002\t0.002\t\n***End_of_Header***\t\n\
                X_Value\tx_cmd\tx_act\tz_cmd\tz_act\tComment\n";
    let text = head.to_owned() + &rows(|t, [a, b, c, d]| format!("{t:.6}\t{a:.6}\t{b:.6}\t{c:.6}\t{d:.6}\t"));
    assert_sample(&read("run.lvm", &text).unwrap().0);
    // Of two recordings none is dropped in silence.
    let second = text.split_once("\n***End_of_Header***\t\n\t\n").unwrap().1;
    assert!(read("run.lvm", format!("{text}{second}")).unwrap_err().to_string().contains("several recordings"));
    // Without times the head states the period.
    let untimed = head.to_owned() + &rows(|_, [a, b, c, d]| format!("\t{a:.6}\t{b:.6}\t{c:.6}\t{d:.6}\t"));
    assert_sample(&read("run.lvm", untimed).unwrap().0);
}

#[test]
fn json_is_read() {
    let lines = rows(|t, [a, b, c, d]| {
        format!("{{\"t\": {t:.3}, \"x\": {{\"cmd\": {a}, \"act\": {b}}}, \"z\": {{\"cmd\": {c}, \"act\": {d}}}}}")
    });
    assert_sample(&read("run.jsonl", &lines).unwrap().0);
    assert_sample(&read("run.json", format!("[{}]", lines.trim_end().replace('\n', ",\n"))).unwrap().0);
    let column = |of: fn([f64; 4]) -> f64| rows(|_, values| of(values).to_string()).trim_end().replace('\n', ",");
    let columns = format!(
        "{{\"machine\": \"mill\", \"time\": [{}], \"x_cmd\": [{}], \"x_act\": [{}], \"z_cmd\": [{}], \"z_act\": [{}]}}",
        rows(|t, _| format!("{t:.3}")).trim_end().replace('\n', ","),
        column(|[a, ..]| a),
        column(|[_, b, ..]| b),
        column(|[_, _, c, _]| c),
        column(|[.., d]| d),
    );
    assert_sample(&read("run.json", columns).unwrap().0);
    let error = read("run.jsonl", &lines[..lines.len() - 20]).unwrap_err().to_string();
    assert!(error.contains("line 400") && error.contains("save it again"), "{error}");
}

#[test]
fn names_in_two_rows_are_read() {
    let data = rows(|t, [a, b, c, d]| format!("{t:.3},{a:.6},{b:.6},{c:.6},{d:.6}"));
    for head in [
        "Time,X,,Z,\n[s],command [mm],actual [mm],command [mm],actual [mm]\n",
        ",X,,Z,\ntime,cmd,act,cmd,act\n",
        "Time,X,X,Z,Z\n[s],cmd,act,cmd,act\n",
        // One name more, or one less, than the rows have fields.
        "t,x_cmd,x_act,z_cmd,z_act,remark\n",
        "t,Commanded,,,Actual\n,x,,z,\n",
    ] {
        let read = read("run.csv", format!("{head}{data}"));
        if head.starts_with("t,Commanded") {
            // What nothing tells apart stays refused.
            assert!(read.is_err());
        } else {
            assert_sample(&read.unwrap_or_else(|error| panic!("{head}: {error}")).0);
        }
    }
}

#[test]
fn names_in_another_encoding_are_told() {
    // X轴指令位置, X轴实际位置 in GBK.
    let names: [&[u8]; 3] = [b"t", b"X\xd6\xe1\xd6\xb8\xc1\xee\xce\xbb\xd6\xc3", b"X\xd6\xe1\xca\xb5\xbc\xca\xce\xbb\xd6\xc3"];
    let data = rows(|t, [a, b, ..]| format!("{t:.3},{a:.6},{b:.6}"));
    let error = read("run.csv", [names.join(&b','), data.into_bytes()].join(&b'\n')).unwrap_err().to_string();
    assert!(error.contains("save the file as UTF-8"), "{error}");
}

#[test]
fn speeds_and_voltages_are_no_axes() {
    let lone = rows(|t, [a, b, c, d]| format!("{t:.3},{a:.6},{b:.6},{c:.6},{d:.6}"));
    for head in [
        "t,pos_cmd,pos_act,v_cmd,v_act",
        "t,p_ref,p_act,u_ref,u_act",
        "Zeit,Soll,Ist,v_Soll,v_Ist",
        "t,theta_ref,theta_act,w_ref,w_act",
    ] {
        let error = read("run.csv", format!("{head}\n{lone}")).unwrap_err().to_string();
        assert!(error.contains("may be speeds or voltages"), "{head}: {error}");
    }
    let speed = |t: f64| 120.0 * (6.0 * t).cos();
    let beside = rows(|t, [a, b, ..]| format!("{t:.3},{a:.6},{b:.6},{:.6},{:.6}", speed(t), speed(t - 0.0015)));
    let (log, report) = read("run.csv", format!("t,x_cmd,x_act,v_cmd,v_act\n{beside}")).unwrap();
    assert_eq!(log.axes().len(), 1);
    assert_found(&report, Severity::Note, Check::Mended, "`v_cmd` and `v_act` may be speeds");
    // An axis of that name stays one.
    let (log, _) = read("run.csv", format!("t,x_cmd,x_act,v_cmd,v_act\n{lone}")).unwrap();
    assert_eq!(log.axes().iter().map(|axis| axis.name.as_str()).collect::<Vec<_>>(), ["x", "v"]);
}

#[test]
fn the_second_clock_of_two_of_one_name_counts() {
    for (first, second) in [("Time", "Time.1"), ("Time", "Time_1"), ("t", "t2"), ("t1", "t2"), ("Time [s]", "Time [s].1")] {
        let data = rows(|t, [a, b, ..]| format!("{t:.4},{a:.6},{:.4},{b:.6}", t - 0.0005));
        let (log, report) = read("run.csv", format!("{first},x_cmd,{second},x_act\n{data}")).unwrap();
        assert_found(&report, Severity::Note, Check::Timing, "joined to the clock of the command");
        assert!(log.len() < SAMPLES + 1, "{first} {second}");
    }
    // A temperature is no clock.
    let data = rows(|t, [a, b, ..]| format!("{t:.4},{a:.6},{b:.6},{:.2}", 20.0 + (50.0 * t).sin()));
    assert_eq!(read("run.csv", format!("t,x_cmd,x_act,T1\n{data}")).unwrap().0.len(), SAMPLES);
}

#[test]
fn a_stated_period_that_the_log_contradicts_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let with_period = |name: &str, text: String, period_s: f64| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        read_log(&path, &ReadOptions { period_s: Some(period_s), ..ReadOptions::default() })
    };
    let stamped = rows(|t, [a, b, ..]| format!("{t:.3},{a:.6},{b:.6}"));
    let (_, report) = with_period("a.csv", format!("t,x_cmd,x_act\n{stamped}"), 0.004).unwrap();
    assert_found(&report, Severity::Warn, Check::Timing, "the stated period of 4.000 ms is not used");
    // A clock of whole seconds, and half of the rows of the stated period.
    let coarse: String = (0..4 * SAMPLES)
        .map(|k| format!("10:00:{:02},{},{}\n", k * 4 / 1000, (0.01 * k as f64).sin(), (0.01 * k as f64 - 0.01).sin()))
        .collect();
    let error = with_period("b.csv", format!("Time,x_cmd,x_act\n{coarse}"), 0.002).unwrap_err().to_string();
    assert!(error.contains("rows are lost, or the period is another"), "{error}");
    assert!(with_period("c.csv", format!("Time,x_cmd,x_act\n{coarse}"), 0.004).is_ok());
    // A counter of rows shows those that are lost.
    let lost = |k: usize| if k < 200 { k } else { k + 100 };
    let counted: String =
        (0..SAMPLES - 100).map(|k| format!("{},{},{}\n", lost(k), lost(k) as f64 * 0.1, lost(k) as f64 * 0.1 - 0.05)).collect();
    let (_, report) = with_period("d.csv", format!("sample,x_cmd,x_act\n{counted}"), 0.002).unwrap();
    assert_found(&report, Severity::Refuse, Check::Timing, "100 rows are missing");
}
