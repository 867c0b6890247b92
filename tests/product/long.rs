//! Long programs, which are compensated in windows.

use std::fmt::Write;

use serde_json::Value;

use crate::common::{Folder, text, without_mark};

/// Rows of 0.4 mm lines over a wavy surface, with what stands around and between them in real programs: a tape mark, comments, drilling,
/// increments, arcs, a dwell, an axis that rests for minutes.
fn program() -> String {
    let mut out = String::from(
        "%\nO0007 (MOULD)\nG21 G90 G17 G40 G49 G80\nT1 M6\nG0 G54 X-20. Y-20. S8000 M3\nZ5. M8\nG1 Z0. F500\nF1500\n",
    );
    for row in 0..100 {
        writeln!(out, "(ROW {row})").unwrap();
        let y = -20.0 + 0.3 * f64::from(row);
        for point in 0..=90 {
            let x = if row % 2 == 0 { -18.0 + 0.4 * f64::from(point) } else { 18.0 - 0.4 * f64::from(point) };
            // From the fiftieth row on Z rests.
            let z = if row < 50 { 1.5 * (0.35 * x + 0.2 * y).sin() } else { 0.25 };
            writeln!(out, "X{x:.4} Y{y:.4} Z{z:.4}").unwrap();
        }
        match row {
            20 => out.push_str("G0 Z5.\nG81 X0. Y0. Z-3. R2. F100\nX10.\nG80\nG1 Z0. F1500\n"),
            40 => out.push_str("G91\nX1. Y-1.\nX-1. Y1.\nG90\nG4 P0.3\n"),
            60 => out.push_str("G3 X18. Y0. I0. J1.\nG1 X-18.\nM9\nM8\n"),
            _ => {}
        }
    }
    out.push_str("G0 Z50. M9\nM30\n%\n");
    out
}

fn um(figures: &Value, at: &str, which: &str) -> f64 {
    figures["predicted_contour_um"][at][which].as_f64().unwrap()
}

/// Contour error RMS and MAX of a run on the simulated machine, µm.
fn run_um(folder: &Folder, program: &str) -> (f64, f64) {
    folder.figures(&["simulate", program, "--machine", "ballscrew", "-o", "run.csv", "--seed", "5"]);
    let run = folder.figures(&["measure", "run.csv", "--desired", "long.nc", "--machine", "ballscrew"]);
    (run["contour_um"]["rms"].as_f64().unwrap(), run["contour_um"]["max"].as_f64().unwrap())
}

#[test]
fn windows_are_joined_to_what_the_whole_program_gives() {
    let folder = Folder::with_model();
    folder.write("long.nc", program());
    let compensate = |out: &str, more: &[&str]| {
        let words = ["compensate", "long.nc", "-m", "machine.model", "-o", out, "--work-offset", "0,0,0"];
        folder.figures(&[&words[..], more].concat())
    };
    let windows = compensate("windows.nc", &[]);
    // A picture of the forecast needs the whole.
    let whole = compensate("whole.nc", &["--report", "forecast.html"]);
    assert!(windows["windows"].as_u64().unwrap() >= 4 && whole["windows"].is_null(), "{windows}");
    for which in ["rms", "max", "p95"] {
        let (of_windows, of_whole) = (um(&windows, "before", which), um(&whole, "before", which));
        assert!((of_windows / of_whole - 1.0).abs() < 0.01, "{which}: {of_windows} in windows, {of_whole} in one");
    }
    let cycle = |figures: &Value| figures["cycle_s"]["before"].as_f64().unwrap();
    assert!((cycle(&windows) / cycle(&whole) - 1.0).abs() < 1e-3, "{} {}", cycle(&windows), cycle(&whole));
    assert_eq!(windows["left_alone"]["moves"], whole["left_alone"]["moves"]);
    assert!(um(&windows, "after", "rms") <= um(&whole, "after", "rms") + 0.03, "{windows}");
    let [raw, of_windows, of_whole] = ["long.nc", "windows.nc", "whole.nc"].map(|program| run_um(&folder, program));
    println!("RMS and MAX, µm: raw {raw:?}, windows {of_windows:?}, whole {of_whole:?}");
    assert!(of_windows.0 <= 1.08 * of_whole.0 && of_windows.1 <= 1.2 * of_whole.1 && of_windows.0 < 0.4 * raw.0);
}

#[test]
fn what_windows_do_not_change_keeps_its_bytes_and_the_output_is_recognised() {
    let folder = Folder::with_model();
    folder.write("long.nc", program());
    let words = ["compensate", "long.nc", "-m", "machine.model", "-o", "out.nc", "--effort", "fast"];
    let said = folder.prints(&words);
    assert!(said.contains(" windows, up to ") && said.contains("the work offset is not known"), "{said}");
    // All lines but those of feed moves stand as they were, in their order; the mark is behind the head.
    let kept = |program: &str| -> Vec<String> {
        let is_feed = |line: &&str| {
            line.starts_with(['X', 'Y', 'Z']) || line.starts_with("G1") || line.starts_with("G2") || line.starts_with("G3")
        };
        without_mark(program).lines().filter(|line| !is_feed(line)).map(str::to_owned).collect()
    };
    let (before, after) = (program(), folder.read("out.nc"));
    let (before, after_kept) = (kept(&before), kept(&after));
    assert_eq!(after_kept, before);
    assert!(after.starts_with("%\nO0007 (MOULD)\n(PRECOMP "), "{}", &after[..80]);
    let refused = folder.fails(1, &["compensate", "out.nc", "-m", "machine.model", "-o", "twice.nc"]);
    assert!(refused.contains("out.nc") && refused.contains("compensated"), "{refused}");
    // A fault is named by its line in the whole program.
    let long = folder.read("long.nc");
    let line = long.lines().position(|line| line == "(ROW 90)").unwrap() + 2;
    let broken = long.replace("(ROW 90)\n", "(ROW 90)\nG5.3 X1.\n");
    folder.write("broken.nc", broken);
    let refused =
        text(&folder.precomp(&["compensate", "broken.nc", "-m", "machine.model", "-o", "broken-out.nc", "--strict"]).stderr);
    assert!(refused.contains(&format!("broken.nc:{line}")), "{refused}");
}

#[test]
fn references_of_every_length_are_predicted() {
    // Samples are predicted in blocks of 2048: the last one may hold a single sample.
    let folder = Folder::with_model();
    for samples in [2047, 2048, 2049, 2050, 4097] {
        let mut reference = String::from("t,x,y,z\n");
        for k in 0..samples {
            writeln!(reference, "{:.3},{:.6},0,0", 0.002 * f64::from(k), 10.0 - 10.0 * (0.002 * f64::from(k)).cos()).unwrap();
        }
        folder.write("reference.csv", reference);
        folder.figures(&["predict", "reference.csv", "-m", "machine.model"]);
    }
}
