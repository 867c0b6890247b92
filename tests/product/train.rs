//! From logs to a model: whatever the format, however the files are cut; and logs that would teach a wrong machine.

use std::fmt::Write;
use std::path::Path;

use datasets::{Log, ReadOptions, read_log, write_log};

use crate::common::{Folder, csv_files, shared, text};

fn log_of(path: &Path) -> Log {
    read_log(path, &ReadOptions::default()).unwrap().0
}

/// Rows of a text file with their header.
fn lines(path: &Path) -> (String, Vec<String>) {
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines = text.lines().map(str::to_owned);
    (lines.next().unwrap(), lines.collect())
}

fn write(folder: &Folder, name: &str, header: &str, rows: &[String]) {
    std::fs::write(folder.path(name), format!("{header}\n{}\n", rows.join("\n"))).unwrap();
}

/// Twelve seconds of a simulated machine, one log.
fn recording(folder: &Folder) -> Log {
    folder.figures(&["excite", "--machine", "ballscrew", "-o", "excitation", "--seconds", "12"]);
    let names = csv_files(&folder.path("excitation"));
    let longest = names.iter().max_by_key(|path| std::fs::metadata(path).unwrap().len()).unwrap();
    folder.figures(&["simulate", &longest.to_string_lossy(), "--machine", "ballscrew", "-o", "run.csv"]);
    log_of(&folder.path("run.csv"))
}

#[test]
fn the_second_half_of_a_real_log_is_predicted_from_the_first() {
    let Some(emps) = shared("logs/emps_train_1kHz.csv") else { return };
    let folder = Folder::new();
    let (header, rows) = lines(&emps);
    let half = rows.len() / 2;
    write(&folder, "first.csv", &header, &rows[..half]);
    let command: Vec<String> = rows[half..].iter().map(|row| row.split(',').take(2).collect::<Vec<_>>().join(",")).collect();
    write(&folder, "command.csv", "t,x", &command);
    folder.figures(&["train", "first.csv", "-o", "axis.model"]);
    folder.figures(&["predict", "command.csv", "-m", "axis.model", "-o", "forecast.csv"]);
    write(&folder, "second.csv", &header, &rows[half..]);
    let (forecast, second) = (log_of(&folder.path("forecast.csv")), log_of(&folder.path("second.csv")));
    // The log begins in motion: its first samples lack their command history.
    let errors: Vec<f64> =
        forecast.actual.columns()[0].iter().zip(&second.actual.columns()[0]).skip(300).map(|(f, x)| 1e3 * (f - x)).collect();
    let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
    let max = errors.iter().fold(0.0_f64, |max, e| max.max(e.abs()));
    println!("second half: {rms:.3} µm RMS, {max:.2} µm MAX");
    assert!(rms <= 0.75 && max <= 4.0, "{rms} {max}");
}

#[test]
fn a_recording_cut_into_files_gives_the_model_of_the_whole() {
    let Some(emps) = shared("logs/emps_train_1kHz.csv") else { return };
    let folder = Folder::new();
    let (header, rows) = lines(&emps);
    write(&folder, "whole.csv", &header, &rows);
    let mut words = vec!["train".to_owned()];
    for (part, rows) in rows.chunks(rows.len().div_ceil(5)).enumerate() {
        let name = format!("part{part}.csv");
        write(&folder, &name, &header, rows);
        words.insert(1, name);
    }
    words.extend(["--predictor", "linear", "-o", "parts.model"].map(str::to_owned));
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let parts = folder.figures(&words);
    let whole = folder.figures(&["train", "whole.csv", "--predictor", "linear", "-o", "whole.model"]);
    assert_eq!(parts["axes"]["x"]["held_out_rms_um"], whole["axes"]["x"]["held_out_rms_um"]);
    assert_eq!(std::fs::read(folder.path("parts.model")).unwrap(), std::fs::read(folder.path("whole.model")).unwrap());
}

#[test]
fn every_format_gives_the_same_model() {
    let folder = Folder::new();
    let log = recording(&folder);
    let value = |column: &[f64], k: usize| format!("{:.9}", column[k]);
    let columns: Vec<&[f64]> =
        log.reference.columns().iter().zip(log.actual.columns()).flat_map(|(r, x)| [r.as_slice(), x.as_slice()]).collect();
    let table = |separator: &str, timed: bool| -> Vec<String> {
        let row = |k: usize| {
            let time = timed.then(|| format!("{:.6}", k as f64 * log.period_s()));
            time.into_iter().chain(columns.iter().map(|column| value(column, k))).collect::<Vec<_>>().join(separator)
        };
        (0..log.len()).map(row).collect()
    };
    write_log(&folder.path("run.parquet"), &log).unwrap();
    write(&folder, "semicolons.csv", "time_s;X1_set;X1_enc;Y1_set;Y1_enc;Z1_set;Z1_enc", &table(";", true));
    let mut pins = String::from("# Sampling period is 2000000 ns\n");
    let names: Vec<String> =
        (0..3).flat_map(|joint| ["cmd", "fb"].map(|role| format!("joint.{joint}.motor-pos-{role}"))).collect();
    write!(pins, "{}", names.join(";")).unwrap();
    write(&folder, "halscope.csv", &pins, &table(";", false));
    std::fs::write(folder.path("halsampler.txt"), table(" ", false).join("\n") + "\n").unwrap();
    let train = |name: &str, more: &[&str]| {
        let mut words = vec!["train", name, "--machine", "ballscrew", "--predictor", "linear", "-o", "one.model"];
        words.extend(more);
        folder.figures(&words)["axes"]["y"]["held_out_rms_um"].as_f64().unwrap()
    };
    let wanted = train("run.csv", &[]);
    let sampler = "x_ref=1:mm,x_act=2:mm,y_ref=3:mm,y_act=4:mm,z_ref=5:mm,z_act=6:mm";
    let found = [
        train("run.parquet", &[]),
        train("semicolons.csv", &[]),
        train("halscope.csv", &[]),
        train("halsampler.txt", &["--columns", sampler, "--period", "2"]),
    ];
    for rms in found {
        assert!((rms / wanted - 1.0).abs() < 1e-3, "{rms} instead of {wanted} µm");
    }
}

/// Trains on the log with these columns (order of `x_ref, x_act, y_ref, y_act, …`) and rows; the model must not be written.
fn refused(folder: &Folder, name: &str, change: impl Fn(usize, &[f64]) -> Option<Vec<f64>>) -> String {
    write_changed(folder, name, change);
    let said = folder.fails(1, &["train", name, "--predictor", "linear", "-o", "wrong.model"]);
    assert!(!folder.path("wrong.model").exists());
    said
}

/// Writes the recording with its rows changed.
fn write_changed(folder: &Folder, name: &str, change: impl Fn(usize, &[f64]) -> Option<Vec<f64>>) {
    let (header, rows) = lines(&folder.path("run.csv"));
    let rows = rows.iter().enumerate().filter_map(|(k, row)| {
        let row: Vec<f64> = row.split(',').map(|value| value.parse().unwrap()).collect();
        Some(change(k, &row)?.iter().map(|value| format!("{value:.9}")).collect::<Vec<_>>().join(","))
    });
    write(folder, name, &header, &rows.collect::<Vec<_>>());
}

#[test]
fn a_log_that_would_teach_a_wrong_machine_is_refused() {
    let folder = Folder::new();
    recording(&folder);
    let said = refused(&folder, "swapped.csv", |_, row| Some([0, 2, 1, 4, 3, 6, 5].map(|column| row[column]).to_vec()));
    assert!(said.contains("the two columns are swapped"), "{said}");
    let said = refused(&folder, "exchanged.csv", |_, row| Some([0, 1, 4, 3, 2, 5, 6].map(|column| row[column]).to_vec()));
    assert!(said.contains("exchanged") || said.contains("travels"), "{said}");
}

#[test]
fn zeros_that_differ_are_told_and_taken_off() {
    let folder = Folder::new();
    recording(&folder);
    write_changed(&folder, "offset.csv", |_, row| {
        let mut row = row.to_vec();
        row[2] -= 12.5;
        Some(row)
    });
    let train = |log: &str, model: &str| folder.figures(&["train", log, "--predictor", "linear", "-o", model]);
    let (own, offset) = (train("run.csv", "own.model"), train("offset.csv", "offset.model"));
    let [own, offset] = [own, offset].map(|figures| figures["axes"]["x"]["held_out_rms_um"].as_f64().unwrap());
    assert!((offset / own - 1.0).abs() < 0.01, "{offset} for {own}");
    let said = text(&folder.precomp(&["check", "offset.csv"]).stdout);
    assert!(said.contains("in motion the actual position stands -12.5"), "{said}");
}

#[test]
fn a_log_with_a_gap_is_trained_on_as_two_runs() {
    let Some(emps) = shared("logs/emps_train_1kHz.csv") else { return };
    let folder = Folder::new();
    let (header, rows) = lines(&emps);
    write(&folder, "gap.csv", &header, &[&rows[..12_000], &rows[12_060..]].concat());
    let printed = folder.prints(&["train", "gap.csv", "--predictor", "linear", "-o", "gap.model"]);
    assert!(printed.contains("after line 12001: 60 rows are missing; the log is cut there into two runs"), "{printed}");
    assert!(folder.path("gap.model").exists());
    // A program is compared with a whole run.
    folder.write("gap.nc", "G1 X10 F600\nM30\n");
    let said = folder.fails(1, &["train", "gap.csv", "--programs", "gap.nc", "-o", "other.model"]);
    assert!(said.contains("log the whole run of a program"), "{said}");
    // A commanded path is not cut.
    let command: Vec<String> = rows.iter().map(|row| row.split(',').take(2).collect::<Vec<_>>().join(",")).collect();
    write(&folder, "command.csv", "t,x", &[&command[..12_000], &command[12_060..]].concat());
    let said = folder.fails(1, &["predict", "command.csv", "-m", "gap.model", "-o", "forecast.csv"]);
    assert!(said.contains("a commanded path has no gaps"), "{said}");
}

#[test]
fn a_model_that_is_no_better_than_none_is_not_written() {
    let folder = Folder::new();
    let log = recording(&folder);
    // An actual position that leaves its command at random: nothing in the command tells where it is.
    let mut state = 7_u64;
    let mut random = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let noise = log.actual.with_columns(
        log.reference.columns().iter().map(|column| column.iter().map(|x| x + 0.05 * random()).collect()).collect(),
    );
    write_log(&folder.path("noise.csv"), &Log::new("noise", log.reference.clone(), noise.unwrap()).unwrap()).unwrap();
    let output = folder.precomp(&["train", "noise.csv", "--predictor", "linear", "-o", "noise.model"]);
    let said = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    // Either it says how little it explains, or nothing is written.
    assert!(said.contains("the model leaves"), "{said}");
    assert_eq!(output.status.success(), folder.path("noise.model").exists());
}

#[test]
fn limits_that_no_log_comes_near_to_are_told() {
    let folder = Folder::new();
    folder.train_on("ballscrew", "20", "linear");
    let logs = csv_files(&folder.path("")).into_iter().map(|path| path.file_name().unwrap().to_string_lossy().into_owned());
    let logs: Vec<String> = logs.collect();
    let train = |machine: &str| {
        let mut words = vec!["train"];
        words.extend(logs.iter().map(String::as_str));
        words.extend(["--machine", machine, "--predictor", "linear", "-o", "x.model"]);
        folder.prints(&words)
    };
    let warning = "the logs accelerate by less than half of what the machine file allows";
    assert!(!train("ballscrew").contains(warning));
    folder.prints(&["init", "--axes", "xyz", "--velocity", "300", "--acceleration", "6000", "--period", "2", "-o", "fast.toml"]);
    let said = train("fast.toml");
    assert!(said.contains(warning) && said.contains("of 6000 mm/s²") && said.contains("--programs"), "{said}");
}

#[test]
fn without_a_machine_file_a_rotary_axis_says_nothing_about_speeds_along_the_path() {
    let folder = Folder::new();
    folder.figures(&["excite", "--machine", "bc", "-o", "excitation", "--seconds", "12"]);
    let longest =
        csv_files(&folder.path("excitation")).into_iter().max_by_key(|path| std::fs::metadata(path).unwrap().len()).unwrap();
    folder.figures(&["simulate", &longest.to_string_lossy(), "--machine", "bc", "-o", "run.csv"]);
    folder.prints(&["train", "run.csv", "--predictor", "linear", "-o", "x.model"]);
    let log = log_of(&folder.path("run.csv"));
    let fastest = |axis: usize| {
        let column = &log.reference.columns()[axis];
        column.windows(2).map(|pair| (pair[1] - pair[0]).abs() / log.period_s()).fold(0.0, f64::max)
    };
    let linear: Vec<usize> = (0..log.axes().len()).filter(|axis| log.axes()[*axis].kind == motion::AxisKind::Linear).collect();
    let together = linear.iter().map(|axis| fastest(*axis)).fold(0.0, f64::hypot);
    let bundle = models::Bundle::from_bytes(&std::fs::read(folder.path("x.model")).unwrap()).unwrap();
    let spec = pipeline::machine_of(&bundle).unwrap();
    assert!((spec.path.velocity_mm_s / together - 1.0).abs() < 1e-6, "{} {together}", spec.path.velocity_mm_s);
}
