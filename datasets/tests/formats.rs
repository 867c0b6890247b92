//! Controllers' log formats: a small log in every format is read back unchanged, and every fault is
//! reported.

mod common;

use std::fmt::Write;
use std::path::PathBuf;

use common::assert_found;
use datasets::{Check, DatasetError, Log, ReadOptions, Report, Severity, read_log};

const PERIOD_S: f64 = 0.002;
const SAMPLES: usize = 400;

/// Commanded and actual X and Z, mm.
fn sample(k: usize) -> [f64; 4] {
    let (t, late) = (k as f64 * PERIOD_S, k as f64 * PERIOD_S - 0.0015);
    let (x, z) = (|t: f64| 20.0 * (6.0 * t).sin(), |t: f64| 5.0 * (9.0 * t).cos());
    [x(t), x(late), z(t), z(late)].map(|value| (value * 1e6).round() / 1e6)
}

fn file(folder: &tempfile::TempDir, name: &str, text: &str) -> PathBuf {
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    path
}

fn read(name: &str, text: &str, columns: Option<&str>, period_s: Option<f64>) -> Result<(Log, Report), DatasetError> {
    let folder = tempfile::tempdir().unwrap();
    read_log(&file(&folder, name, text), &ReadOptions { columns: columns.map(str::to_owned), period_s })
}

/// Whether a log is the sample, from sample `from` on.
fn assert_sample(log: &Log, from: usize, length: usize) {
    assert!((log.period_s() - PERIOD_S).abs() < 1e-9, "{}", log.period_s());
    assert_eq!(log.len(), length);
    let names: Vec<&str> = log.axes().iter().map(|axis| axis.name.as_str()).collect();
    assert_eq!(names, ["x", "z"]);
    for k in 0..length {
        let wanted = sample(from + k);
        let found = [
            log.reference.columns()[0][k],
            log.actual.columns()[0][k],
            log.reference.columns()[1][k],
            log.actual.columns()[1][k],
        ];
        assert!(found.iter().zip(wanted).all(|(found, wanted)| (found - wanted).abs() < 1e-9), "{k}: {found:?} {wanted:?}");
    }
}

fn halsampler(lost_after: Option<usize>, tagged: bool) -> String {
    let mut text = String::new();
    for k in 0..SAMPLES {
        if lost_after == Some(k) {
            text.push_str("overrun\n");
        }
        let [xr, xa, zr, za] = sample(k);
        if tagged {
            write!(text, "{k} ").unwrap();
        }
        writeln!(text, "{xr:.6} {xa:.6} {zr:.6} {za:.6} 1 ").unwrap();
    }
    text
}

const PINS: &str = "x_ref=1:mm,x_act=2:mm,z_ref=3:mm,z_act=4:mm";

#[test]
fn halsampler_logs_are_read_with_a_mapping() {
    let (log, report) = read("run.txt", &halsampler(None, false), Some(PINS), Some(PERIOD_S)).unwrap();
    assert_sample(&log, 0, SAMPLES);
    assert_found(&report, Severity::Note, Check::Mended, "columns not used: 5");
    let tagged = "x_ref=2:mm,x_act=3:mm,z_ref=4:mm,z_act=5:mm";
    assert_sample(&read("run.txt", &halsampler(None, true), Some(tagged), Some(PERIOD_S)).unwrap().0, 0, SAMPLES);
    // Without a mapping the columns have only numbers.
    let error = read("run.txt", &halsampler(None, false), None, Some(PERIOD_S)).unwrap_err().to_string();
    assert!(error.contains("the columns are") && error.contains("mapping"), "{error}");
}

#[test]
fn a_mapping_may_stand_in_a_file_beside_the_log() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(&folder, "run.txt", &halsampler(None, false));
    file(&folder, "run.txt.columns", &format!("# pins of the sampler\nperiod = 2 ms\n{}\n", PINS.replace(',', "\n")));
    let (log, report) = read_log(&path, &ReadOptions::default()).unwrap();
    assert_sample(&log, 0, SAMPLES);
    assert_found(&report, Severity::Note, Check::Mended, "run.txt.columns");
    file(&folder, "run.txt.columns", "period = soon\n");
    let error = read_log(&path, &ReadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("run.txt.columns") && error.contains("soon"), "{error}");
}

#[test]
fn lost_samples_and_a_cut_off_end_of_halsampler_are_reported() {
    let (log, report) = read("run.txt", &halsampler(Some(150), false), Some(PINS), Some(PERIOD_S)).unwrap();
    assert_sample(&log, 150, SAMPLES - 150);
    assert_found(&report, Severity::Warn, Check::Dropout, "line 151 (`overrun`)");
    let text = halsampler(None, false);
    let (log, report) = read("run.txt", &text[..text.len() - 14], Some(PINS), Some(PERIOD_S)).unwrap();
    assert_sample(&log, 0, SAMPLES - 1);
    assert_found(&report, Severity::Warn, Check::Mended, "the last row (line 400) is cut off");
    let error = read("run.txt", &text.replacen(" 1 \n", "\n", 3), Some(PINS), Some(PERIOD_S)).unwrap_err();
    assert!(matches!(error, DatasetError::Ragged { .. }), "{error}");
}

/// Output of halscope for these channels.
fn halscope(period: &str, names: [&str; 4]) -> String {
    let mut text = format!("# Sampling period is {period}\n{}\n", names.join(";"));
    for k in 0..SAMPLES {
        writeln!(text, "{}", sample(k).map(|value| format!("{value:.14}")).join(";")).unwrap();
    }
    text
}

const JOINTS: [&str; 4] = ["joint.0.motor-pos-cmd", "joint.0.motor-pos-fb", "joint.2.motor-pos-cmd", "joint.2.motor-pos-fb"];

#[test]
fn halscope_logs_state_their_content() {
    let text = halscope("2000000 ns", JOINTS);
    let (log, report) = read("run.csv", &text, None, None).unwrap();
    assert_sample(&log, 0, SAMPLES);
    assert_found(&report, Severity::Note, Check::Mended, "joints 0 to 5 are taken for the axes x y z a b c");
    // A separator after the last channel, and signals in place of pins.
    let (log, report) = read("run.csv", &text.replace('\n', ";\n").replacen("ns;", "ns", 1), None, None).unwrap();
    assert_sample(&log, 0, SAMPLES);
    assert_eq!(report.findings.len(), 1, "{report}");
    let signals = halscope("2000000 ns", ["x-pos-cmd", "x-pos-fb", "z-pos-cmd", "z-pos-fb"]);
    let (log, report) = read("run.csv", &signals, None, None).unwrap();
    assert_sample(&log, 0, SAMPLES);
    assert!(report.findings.is_empty(), "{report}");
    // On a lathe joint 1 is Z; its machine unit may be the inch.
    let lathe = halscope("2000000 ns", ["joint.0.pos-cmd", "joint.0.pos-fb", "joint.1.pos-cmd", "joint.1.pos-fb"]);
    let map = "x_ref=joint.0.pos-cmd,x_act=joint.0.pos-fb,z_ref=joint.1.pos-cmd,z_act=joint.1.pos-fb";
    assert_sample(&read("run.csv", &lathe, Some(map), None).unwrap().0, 0, SAMPLES);
    let inches = read("run.csv", &lathe, Some("z_ref=joint.1.pos-cmd:in,z_act=joint.1.pos-fb:in"), None).unwrap().0;
    assert!((inches.reference.columns()[0][7] - 25.4 * sample(7)[2]).abs() < 1e-6);
    let turned = halscope("2000000 ns", ["joint.3.pos-cmd", "joint.3.pos-fb", "joint.1.pos-cmd", "joint.1.pos-fb"]);
    let turned = read("run.csv", &turned, None, None).unwrap().0;
    assert_eq!(turned.axes()[0].kind, motion::AxisKind::Rotary);
    assert!((turned.reference.columns()[0][7] - sample(7)[0].to_radians()).abs() < 1e-9);
}

#[test]
fn faults_of_halscope_logs_are_reported() {
    let text = halscope("2000000 ns", JOINTS);
    // Cut off within a row, and within its last number.
    for cut in [30, 5] {
        let (log, report) = read("run.csv", &text[..text.len() - cut], None, None).unwrap();
        assert_sample(&log, 0, SAMPLES - 1);
        assert_found(&report, Severity::Warn, Check::Mended, "the last row (line 402)");
    }
    for period in ["", "0 ns", "1000000", "soon"] {
        let error = read("run.csv", &halscope(period, JOINTS), None, None).unwrap_err().to_string();
        assert!(error.contains("line 1: ") && error.contains("# Sampling period is 1000000 ns"), "{error}");
    }
    // Without the comment it is a table of no known rate.
    let bare = text.split_once('\n').unwrap().1;
    let error = read("run.csv", bare, None, None).unwrap_err().to_string();
    assert!(error.contains("no time column and no sampling period given"), "{error}");
    assert_sample(&read("run.csv", bare, None, Some(PERIOD_S)).unwrap().0, 0, SAMPLES);
    // A channel without its other half is left out; without any pair there is no axis.
    let alone = halscope(
        "2000000 ns",
        ["joint.0.motor-pos-cmd", "joint.0.motor-pos-fb", "joint.2.motor-pos-cmd", "joint.2.motor-offset"],
    );
    let (log, report) = read("run.csv", &alone, None, None).unwrap();
    assert_eq!(log.axes().len(), 1);
    assert_found(&report, Severity::Note, Check::Mended, "columns not used: joint.2.motor-pos-cmd, joint.2.motor-offset");
    // The following error stands for it.
    let error = alone.replace("joint.2.motor-offset", "joint.2.f-error");
    let (log, report) = read("run.csv", &error, None, None).unwrap();
    assert_eq!(log.axes().len(), 2);
    assert_found(
        &report,
        Severity::Note,
        Check::Mended,
        "the actual position of z is taken from its command and `joint.2.f-error`",
    );
    let none = halscope("2000000 ns", ["joint.0.motor-pos-cmd", "joint.1.motor-pos-fb", "spindle.0.at-speed", "joint.2.f-error"]);
    let error = read("run.csv", &none, None, None).unwrap_err().to_string();
    assert!(error.contains("no axis has both a commanded and an actual position"), "{error}");
    let both = halscope("2000000 ns", ["joint.0.motor-pos-cmd", "joint.0.motor-pos-fb", "joint.0.pos-cmd", "joint.0.f-error"]);
    let error = read("run.csv", &both, None, None).unwrap_err().to_string();
    assert!(error.contains("columns 1 and 3 both claim to be the command of x"), "{error}");
    let ragged = text.replacen(&format!("{:.14};", sample(200)[0]), "", 1);
    assert!(matches!(read("run.csv", &ragged, None, None).unwrap_err(), DatasetError::Ragged { .. }));
}

/// Scope's export with `;` and decimal commas, or tabs and points; a time column for each channel, or one for all.
fn scope(separator: char, comma: bool, each: bool, times: [&str; 2]) -> String {
    let names = ["X SetPos", "X ActPos", "Z SetPos", "Z ActPos"];
    let row = |key: &str, values: [&str; 4]| {
        let mut fields = Vec::new();
        for (index, value) in values.iter().enumerate() {
            if each || index == 0 {
                fields.push(key.to_owned());
            }
            fields.push((*value).to_owned());
        }
        fields.join(&separator.to_string()) + "\r\n"
    };
    let mut text = format!("Name{separator}Scope\r\nFile{separator}run.svdx\r\n\r\n");
    text += &row("Name", names);
    text += &row("SymbolComment", [""; 4]);
    text += &row("Data-Type", ["REAL64"; 4]);
    text += &row("SampleTime[ms]", [times[0], times[0], times[0], times[1]]);
    text += &row("Unit", ["mm", "mm", "mm", "mm"]);
    text += &row("ScaleFactor", ["1"; 4]);
    text += "\r\n";
    for k in 0..SAMPLES {
        let number = |value: f64| {
            let text = format!("{value:.6}");
            if comma { text.replace('.', ",") } else { text }
        };
        let values = sample(k).map(number);
        text += &row(&(2 * k).to_string(), [&values[0], &values[1], &values[2], &values[3]]);
    }
    text + "EOF\r\n"
}

#[test]
fn twincat_scope_exports_are_read() {
    for (separator, comma) in [('\t', false), (';', true), (',', false)] {
        for each in [true, false] {
            let (log, _) = read("scope.csv", &scope(separator, comma, each, ["2", "2"]), None, None).unwrap();
            assert_sample(&log, 0, SAMPLES);
        }
    }
    // Stamps count, not what the header states.
    assert_sample(&read("scope.csv", &scope('\t', false, true, ["2", "10"]), None, None).unwrap().0, 0, SAMPLES);
}

/// A recording with rows of the given cycles.
fn edge(cycles: impl Iterator<Item = usize>) -> String {
    let mut text = String::from(
        "{\"Header\":{\"Version\":{\"RecorderVersion\":\"1.2\"},\"CycleTimeMs\":2,\"SignalListHFData\":[\
         {\"Name\":\"CYCLE\",\"Type\":\"INTEGER\",\"Address\":\"CYCLE\"},\
         {\"Name\":\"DES_POS|1\",\"Axis\":\"X\",\"Address\":\"DES_POS|1\"},{\"Name\":\"ENC_POS|1\",\"Axis\":\"X\",\"Address\":\"ENC_POS|1\"},\
         {\"Name\":\"DES_POS|3\",\"Axis\":\"Z\",\"Address\":\"DES_POS|3\"},{\"Name\":\"ENC_POS|3\",\"Axis\":\"Z\",\"Address\":\"ENC_POS|3\"},\
         {\"Name\":\"CURRENT|1\",\"Axis\":\"X\",\"Address\":\"CURRENT|1\"}]},\n\"Payload\":[{\"HFTimestamp\":\"2026-01-01T00:00:00Z\"}",
    );
    for k in cycles {
        let [xr, xa, zr, za] = sample(k);
        write!(text, ",\n{{\"HFData\":[[{},{xr:.6},{xa:.6},{zr:.6},{za:.6},0.1]]}}", 7000 + k).unwrap();
        if k == 10 {
            text.push_str(",{\"HFBlockEvent\":{\"GCode\":\"G1 X1\"}}");
        }
    }
    text + "],\n\"Footer\":{}}"
}

#[test]
fn sinumerik_edge_recordings_are_read() {
    let (log, report) = read("capture.json", &edge(0..SAMPLES), None, None).unwrap();
    assert_sample(&log, 0, SAMPLES);
    assert_found(&report, Severity::Note, Check::Mended, "CURRENT|1");
    // A lost cycle shows in the counter, and is reported like any other gap.
    let (log, report) = read("capture.json", &edge((0..SAMPLES).filter(|k| *k != 200)), None, None).unwrap();
    assert_eq!(log.len(), SAMPLES);
    assert!(
        report.findings.iter().any(|finding| finding.check == Check::Timing && finding.severity == Severity::Warn),
        "{report}"
    );
    let cut = edge(0..SAMPLES);
    let error = read("capture.json", &cut[..cut.len() / 2], None, None).unwrap_err().to_string();
    assert!(error.contains("line") && error.contains("column"), "{error}");
    let error = read("capture.json", &edge(0..0), None, None).unwrap_err().to_string();
    assert!(error.contains("no `HFData`"), "{error}");
}

fn trace(gap: Option<usize>) -> String {
    let mut text = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<root><traceCfg/><traceData><dataFrame>\n");
    for name in ["X set position", "X actual position", "Z set position", "Z actual position"] {
        writeln!(text, "<dataSignal name=\"/Nck/{name}\" description=\"{name}\"/>").unwrap();
    }
    for k in 0..SAMPLES {
        let [xr, xa, zr, za] = sample(k);
        let second = if gap == Some(k) { "9.2233720368547758e18".to_owned() } else { format!("{xa:.6}") };
        writeln!(text, "<rec time=\"{:.6}\" f1=\"{xr:.6}\" f2=\"{second}\" f3=\"{zr:.6}\" f4=\"{za:.6}\"/>", k as f64 * PERIOD_S)
            .unwrap();
    }
    text + "</dataFrame></traceData></root>\n"
}

#[test]
fn sinumerik_traces_are_read() {
    let (log, report) = read("trace.xml", &trace(None), None, None).unwrap();
    assert_sample(&log, 0, SAMPLES);
    assert!(report.findings.is_empty(), "{report}");
    // A value that was not sampled keeps the one before it, and is reported.
    let (log, report) = read("trace.xml", &trace(Some(20)), None, None).unwrap();
    assert_eq!(log.actual.columns()[0][20], log.actual.columns()[0][19]);
    assert_found(&report, Severity::Warn, Check::Mended, "1 values");
    let cut = trace(None);
    let error = read("trace.xml", &cut[..cut.len() / 2], None, None).unwrap_err().to_string();
    assert!(error.contains("byte"), "{error}");
}

#[test]
fn no_bytes_of_any_format_make_reading_panic() {
    let samples = [
        ("run.txt", halsampler(Some(150), true)),
        ("halscope.csv", halscope("2000000 ns", JOINTS)),
        ("scope.csv", scope(';', true, true, ["2", "2"])),
        ("capture.json", edge(0..60)),
        ("trace.xml", trace(Some(20))),
    ];
    let folder = tempfile::tempdir().unwrap();
    let mut state = 1_u64;
    let mut draw = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    let options = ReadOptions { columns: None, period_s: Some(PERIOD_S) };
    let (mut read_well, mut refused) = (0, 0);
    for (name, text) in samples {
        for _ in 0..150 {
            let mut bytes = text.clone().into_bytes();
            bytes.truncate(1 + draw(bytes.len()));
            for _ in 0..draw(12) {
                let place = draw(bytes.len());
                bytes[place] = [b'0', b'-', b';', b'"', b'<', b'{', b'\n', b'e', 0xFF, b' ', b',', b']'][draw(12)];
            }
            let path = folder.path().join(name);
            std::fs::write(&path, bytes).unwrap();
            match read_log(&path, &options) {
                Ok(_) => read_well += 1,
                Err(error) => {
                    assert!(error.to_string().contains(name), "{error}");
                    refused += 1;
                }
            }
        }
    }
    assert!(read_well > 5 && refused > 20, "{read_well} {refused}");
}

#[test]
fn a_second_header_in_another_order_is_refused() {
    let row = |k: usize, order: [usize; 4]| order.map(|column| format!("{:.6}", sample(k)[column])).join(",");
    let text = |second: &str, order: [usize; 4]| {
        let mut text = "t,x_ref,x_act,z_ref,z_act\n".to_owned();
        for k in 0..SAMPLES {
            if k == SAMPLES / 2 {
                writeln!(text, "{second}").unwrap();
            }
            let order = if k < SAMPLES / 2 { [0, 1, 2, 3] } else { order };
            writeln!(text, "{:.4},{}", k as f64 * PERIOD_S, row(k, order)).unwrap();
        }
        text
    };
    let refused = read("log.csv", &text("t,z_ref,z_act,x_ref,x_act", [2, 3, 0, 1]), None, None).unwrap_err().to_string();
    assert!(refused.contains("line 202 is a second header") && refused.contains("cut the file there"), "{refused}");
    // The same header again, as of files that were joined.
    let (log, _) = read("log.csv", &text("t,x_ref,x_act,z_ref,z_act", [0, 1, 2, 3]), None, None).unwrap();
    assert_sample(&log, 0, SAMPLES);
}
