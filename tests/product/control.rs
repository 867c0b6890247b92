//! A control learned from the logs of programs: first runs without a recording of the part.

use std::sync::LazyLock;

use serde_json::{Value, json};

use crate::common::{Folder, csv_files};

const PART: &str =
    "G21 G90 G17\nG0 X0 Y0\nG4 P0.2\nG1 X30. F3600\nG3 X30. Y20. J10.\nG1 X10.\nG1 X0 Y10.\nG4 P0.1\nG1 X8. Y4.\nG1 X0 Y0\nM30\n";

/// The machine `ballscrew` behind a control of under half its acceleration that averages every axis over 30 ms.
fn control() -> String {
    let machine = include_str!("../../machine/machines/ballscrew.toml");
    let slower = machine.replace("acceleration_mm_s2 = 800.0", "acceleration_mm_s2 = 300.0");
    let slower = slower.replace("centripetal_mm_s2 = 565.0", "centripetal_mm_s2 = 200.0");
    slower.replace("[kinematics]", "[control]\ncorners = { blend_mm = 0.01 }\nfilters_ms = [30.0, 0.0]\n\n[kinematics]")
}

/// A model whose control was learned, and what the training said of it.
struct Learned {
    model: Vec<u8>,
    control: Value,
}

/// Trained once: 20 s of excitation, and the control test on the control.
static LEARNED: LazyLock<Learned> = LazyLock::new(|| {
    let folder = Folder::new();
    folder.write("control.toml", control());
    folder.figures(&["excite", "--machine", "ballscrew", "-o", "excitation", "--seconds", "20"]);
    let mut logs = Vec::new();
    for path in csv_files(&folder.path("excitation")) {
        let log = path.file_name().unwrap().to_string_lossy().into_owned();
        let seed = (50_101 + logs.len()).to_string();
        folder.figures(&["simulate", &path.to_string_lossy(), "--machine", "ballscrew", "-o", &log, "--seed", &seed]);
        logs.push(log);
    }
    for (program, name) in [("excitation/control-test.nc", "control-test"), ("excitation/01-full.nc", "01-full")] {
        let log = format!("{name}.csv");
        folder.figures(&["simulate", program, "--machine", "control.toml", "-o", &log, "--seed", "50201"]);
        logs.push(log);
    }
    logs.sort();
    logs.dedup();
    let logs: Vec<&str> = logs.iter().map(String::as_str).collect();
    let programs = ["--programs", "excitation/control-test.nc", "excitation/01-full.nc"];
    let figures = folder.figures(&[&["train", "-o", "own.model"][..], &logs, &programs].concat());
    Learned { model: std::fs::read(folder.path("own.model")).unwrap(), control: figures["control"].clone() }
});

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("own.model", &LEARNED.model);
    folder.write("control.toml", control());
    folder.write("part.nc", PART);
    folder
}

/// Contour error RMS of a run of `program` on the control, µm.
fn error_um(folder: &Folder, program: &str) -> f64 {
    folder.figures(&["simulate", program, "--machine", "control.toml", "-o", "run.csv", "--seed", "7"]);
    let measured = folder.figures(&["measure", "run.csv", "--desired", "part.nc", "--machine", "ballscrew"]);
    measured["contour_um"]["rms"].as_f64().unwrap()
}

#[test]
fn the_first_run_on_a_learned_control_has_less_than_half_the_error_of_one_without_it() {
    let folder = folder();
    folder.figures(&["simulate", "part.nc", "--machine", "control.toml", "-o", "recorded.csv", "--seed", "3"]);
    let compensate =
        |out: &str, more: &[&str]| folder.figures(&[&["compensate", "part.nc", "-m", "own.model", "-o", out][..], more].concat());
    let slowdown = compensate("own.nc", &[]);
    // The limits of the machine, and a control of which nothing is known.
    compensate("plain.nc", &["--machine", "ballscrew"]);
    compensate("by-record.nc", &["--machine", "ballscrew", "--reference", "recorded.csv"]);
    let [raw, plain, recorded, own] = ["part.nc", "plain.nc", "by-record.nc", "own.nc"].map(|program| error_um(&folder, program));
    println!("{raw:.2} µm raw, {plain:.2} by our plan, {recorded:.2} by the record, {own:.2} by the learned control");
    assert!(own <= 0.85 && own <= 1.2 * recorded && own < 0.35 * plain, "{raw} {plain} {recorded} {own}");
    let cycle = |at: &str| slowdown["cycle_s"][at].as_f64().unwrap();
    assert!(cycle("after") <= 1.01 * cycle("before"), "{slowdown}");
}

#[test]
fn sharp_corners_are_corrected_where_the_control_passes_them_at_its_largest_acceleration() {
    let folder = folder();
    // Without a limit of jerk, and a turn by 135 degrees.
    let control =
        control().replace("jerk_mm_s3 = 80000.0", "jerk_mm_s3 = 1e10").replacen("= 1e10", "= 1e10\nsmoothing_ms = 0.0", 1);
    folder.write("control.toml", control);
    folder.write("part.nc", "G21 G90 G17\nG0 X0 Y0\nG4 P0.2\nG1 X12. F3600\nG1 X6. Y6.\nG1 X20.\nG1 X0 Y0\nG4 P0.2\nM30\n");
    let worst_um = |program: &str| {
        folder.figures(&["simulate", program, "--machine", "control.toml", "-o", "run.csv", "--seed", "7"]);
        let measured = folder.figures(&["measure", "run.csv", "--desired", "part.nc", "--machine", "control.toml"]);
        measured["contour_um"]["max"].as_f64().unwrap()
    };
    folder.figures(&["compensate", "part.nc", "-m", "own.model", "-o", "own.nc", "--machine", "control.toml"]);
    let [raw, own] = ["part.nc", "own.nc"].map(worst_um);
    println!("{raw:.2} -> {own:.2} µm MAX");
    assert!(own < 0.3 * raw, "{raw} {own}");
}

#[test]
fn training_says_what_it_learned_of_the_control_and_how_far_it_holds() {
    let control = &LEARNED.control;
    let filter = control["values"].as_array().unwrap().iter().find(|value| value["key"] == "control.filters_ms[0]").unwrap();
    assert!((filter["value"].as_f64().unwrap() - 30.0).abs() <= 4.0, "{control}");
    assert!(control["fidelity"]["path_um"]["rms"].as_f64().unwrap() < 5.0, "{control}");
    assert_ne!(control["held_out"], json!([]));
    let folder = folder();
    let said = folder.prints(&["compensate", "part.nc", "-m", "own.model", "-o", "out.nc"]);
    assert!(said.contains("the control as learned from recorded programs: plans within"), "{said}");
    // A machine that is stated counts instead.
    let said = folder.prints(&["compensate", "part.nc", "-m", "own.model", "-o", "other.nc", "--machine", "control.toml"]);
    assert!(!said.contains("plans within") && said.contains("the control as learned with the model is not used"), "{said}");
}

#[test]
fn programs_without_their_log_are_refused() {
    let folder = folder();
    folder.figures(&["simulate", "part.nc", "--machine", "control.toml", "-o", "part.csv"]);
    folder.write("other.nc", PART.replace("X30", "X33"));
    let refused = folder.fails(2, &["train", "part.csv", "--programs", "other.nc", "-o", "no.model"]);
    assert!(refused.contains("no log belongs to other.nc") && refused.contains("other.csv"), "{refused}");
    std::fs::copy(folder.path("part.csv"), folder.path("other.csv")).unwrap();
    let refused = folder.fails(1, &["train", "other.csv", "--programs", "other.nc", "-o", "no.model"]);
    assert!(refused.contains("other.nc"), "{refused}");
    assert!(!folder.path("no.model").exists());
}
