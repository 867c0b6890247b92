//! Five axes: a model of every axis, tool tip and direction on unseen paths, programs in axis words and in tip words, refusals.

use std::f64::consts::PI;
use std::fmt::Write;

use serde_json::Value;

use crate::common::{Folder, csv_files};

fn figure(figures: &Value, kind: &str) -> f64 {
    figures[kind]["rms"].as_f64().unwrap()
}

/// Rows across a saddle, tool along its normal, on the built-in machine `bc` in inverse time; `tip`: in words of the tool tip under G43.4.
fn saddle_rows(rows: usize, step_mm: f64, tip: bool) -> String {
    let mut text = String::from("%\r\nO0007 (SADDLE)\r\nN1 G21 G90 G17 G40 G49 G80\r\nN2 T1 M6 (BALL)\r\nN3 S12000 M3\r\n");
    if tip {
        text.push_str("N5 G43.4 H1\r\n");
    }
    let (mut number, mut c_before) = (10, 0.0);
    let mut before: Option<[f64; 3]> = None;
    for row in 0..rows {
        let y = -20.0 + 40.0 * row as f64 / (rows - 1).max(1) as f64;
        let count = (60.0 / step_mm) as usize;
        for k in 0..=count {
            let k = if row % 2 == 0 { k } else { count - k };
            let x = 12.0 + step_mm * k as f64;
            let z = (x * x - y * y) / 160.0;
            let normal = [-x / 80.0, y / 80.0, 1.0];
            let length = normal.iter().map(|v| v * v).sum::<f64>().sqrt();
            let (b, mut c) = ((normal[2] / length).acos(), normal[1].atan2(normal[0]));
            while c - c_before > PI {
                c -= 2.0 * PI;
            }
            while c - c_before < -PI {
                c += 2.0 * PI;
            }
            c_before = c;
            let at = if tip { [x, y, z] } else { under_the_tool([x, y, z], b, c) };
            let words = format!("X{:.4} Y{:.4} Z{:.4} B{:.4} C{:.4}", at[0], at[1], at[2], b.to_degrees(), c.to_degrees());
            match before {
                None => writeln!(text, "N{number} G0 {words}\r\nG4 P0.3\r\nG93\r").unwrap(),
                Some(last) => {
                    let way = last.iter().zip([x, y, z]).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
                    let g1 = if text.ends_with("G93\r\n") { "G1 " } else { "" };
                    writeln!(text, "N{number} {g1}{words} F{:.3}\r", 60.0 * 20.0 / way).unwrap();
                }
            }
            before = Some([x, y, z]);
            number += 1;
        }
        writeln!(text, "(ROW {row})\r").unwrap();
    }
    text.push_str("G94\r\nM5\r\nM30\r\n%\r\n");
    text
}

/// Where the axes of `bc` stand with its tables at `b` and `c` and the tool tip at a point of the workpiece: worked out by hand.
fn under_the_tool([x, y, z]: [f64; 3], b: f64, c: f64) -> [f64; 3] {
    let (x, y) = (c.cos() * x + c.sin() * y, c.cos() * y - c.sin() * x);
    let z = z + 50.0;
    let (x, z) = (b.cos() * x - b.sin() * z, b.sin() * x + b.cos() * z);
    [x, y, z - 50.0]
}

#[test]
fn first_run_on_unseen_paths_and_programs() {
    let folder = Folder::new();
    folder.train_on("bc", "60", "staged");

    // Paper C's paths: as good as spatial learning that has converged on the machine.
    for (curve, feed) in [("curve:saddle", "16.667"), ("curve:saddle-butterfly", "25")] {
        let found = folder.figures(&[
            "compare",
            curve,
            "--machine",
            "bc",
            "-m",
            "machine.model",
            "--feed",
            feed,
            "--gain",
            "0.8",
            "--low-pass",
            "100",
        ]);
        let methods = &found["paths"][0]["methods"];
        let of = |method: &str, figure: &str| methods[method][figure].as_f64().unwrap();
        println!("{curve}: {methods}");
        assert!(of("first-run", "rms_um") < 1.1 * of("spatial-ilc", "rms_um"), "{methods}");
        // A minute of log; with two, `reproduce five-axis` stays within 1.2.
        assert!(of("first-run", "orientation_rms_urad") < 1.7 * of("spatial-ilc", "orientation_rms_urad"), "{methods}");
        assert!(of("spatial-ilc", "rms_um") < 0.15 * of("uncompensated", "rms_um"), "{methods}");
        assert!(of("spatial-ilc", "orientation_rms_urad") < 0.1 * of("uncompensated", "orientation_rms_urad"), "{methods}");
        assert!(of("first-run", "max_um") < 2.0 * of("spatial-ilc", "max_um"), "{methods}");
    }

    // A path that is neither Paper C's nor of the excitation: the smaller sibling of the test of the S-shaped piece as G-code.
    let s_piece = ["curve:s-piece", "--feed", "33.333"];
    folder.figures(&[&["compensate"], &s_piece[..], &["-m", "machine.model", "-o", "s.csv"]].concat());
    let run = |name: &str, reference: &[&str]| {
        folder.figures(&[&["simulate"], reference, &["--machine", "bc", "-o", name]].concat());
        folder.figures(&[&["measure", name, "--machine", "bc", "--desired"], &s_piece[..]].concat())
    };
    let (raw, cut) = (run("s-raw.csv", &s_piece), run("s-cut.csv", &["s.csv"]));
    println!("S-shaped piece: {raw} → {cut}");
    for name in ["contour_um", "orientation_urad"] {
        assert!(figure(&cut, name) < 0.1 * figure(&raw, name), "{name}: {cut} against {raw}");
    }

    for tip in [false, true] {
        let original = saddle_rows(3, 0.5, tip);
        std::fs::write(folder.path("part.nc"), &original).unwrap();
        let made = folder.figures(&["compensate", "part.nc", "-m", "machine.model", "-o", "out.nc"]);
        assert_eq!(made["changed"], true);
        assert!(made["largest_shift_um"].as_f64().unwrap() < 100.0);
        let raw = folder.figures(&["simulate", "part.nc", "--machine", "bc", "-o", "raw.csv"]);
        let cut = folder.figures(&["simulate", "out.nc", "--machine", "bc", "--against", "part.nc", "-o", "cut.csv"]);
        println!("tip words {tip}: {raw} → {cut}");
        assert!(figure(&cut, "contour_um") < 0.2 * figure(&raw, "contour_um"), "{cut} against {raw}");
        assert!(figure(&cut, "orientation_urad") < 0.2 * figure(&raw, "orientation_urad"), "{cut} against {raw}");
        assert!(cut["seconds"].as_f64().unwrap() < 1.03 * raw["seconds"].as_f64().unwrap());

        // What does not move stays, byte by byte; numbers of lines and comments too.
        let out = std::fs::read_to_string(folder.path("out.nc")).unwrap();
        for kept in original.lines().filter(|line| !line.contains(" B") || line.contains("G0")) {
            assert!(out.contains(&format!("{kept}\r\n")), "{kept:?}");
        }
        steps_keep_the_limits(&out, tip);

        // The log measures as the run did.
        let again = folder.figures(&["measure", "raw.csv", "--desired", "part.nc", "--machine", "bc"]);
        assert!((figure(&again, "contour_um") / figure(&raw, "contour_um") - 1.0).abs() < 0.01, "{again} against {raw}");
        assert!(
            (figure(&again, "orientation_urad") / figure(&raw, "orientation_urad") - 1.0).abs() < 0.01,
            "{again} against {raw}"
        );
    }
    let next = folder.figures(&["refine", "part.nc", "--log", "raw.csv", "--machine", "bc", "-o", "next.nc"]);
    assert!(next["largest_shift_um"].as_f64().unwrap() > 1.0);
    folder.figures(&["simulate", "next.nc", "--machine", "bc", "--against", "part.nc", "-o", "next.csv"]);
}

/// No line of a program in inverse time moves an axis faster than 1.1 times its limit.
fn steps_keep_the_limits(program: &str, tip: bool) {
    // Tip words are the tip's own coordinates: its limits follow from the axes' and are not looked at here.
    let axes: &[(char, f64)] =
        if tip { &[('B', 2.0), ('C', 3.0)] } else { &[('X', 80.0), ('Y', 80.0), ('Z', 80.0), ('B', 2.0), ('C', 3.0)] };
    let mut at = [None; 5];
    let mut lines = 0;
    for line in program.lines() {
        let word = |letter: char| {
            let start = line.find(letter)? + 1;
            let rest = &line[start..];
            let end = rest.find(|c: char| !(c.is_ascii_digit() || c == '.' || c == '-')).unwrap_or(rest.len());
            rest[..end].parse::<f64>().ok()
        };
        if line.starts_with('(') || (word('B').is_none() && word('X').is_none()) {
            continue;
        }
        let seconds = word('F').map(|f| 60.0 / f);
        for (slot, (letter, most)) in axes.iter().enumerate() {
            let Some(value) = word(*letter) else { continue };
            let value = if "BC".contains(*letter) { value.to_radians() } else { value };
            if let (Some(before), Some(seconds)) = (at[slot], seconds) {
                let before: f64 = before;
                assert!(
                    (value - before).abs() < 1.1 * most * seconds + 2e-5,
                    "{letter} in {line}: {before} to {value} in {seconds} s"
                );
            }
            at[slot] = Some(value);
        }
        lines += 1;
    }
    assert!(lines > 300, "{lines}");
}

/// A square with turns about its corners, then a hole and a slot at an indexed position with the rotary axes clamped.
const TURNS: &str = "G21 G90 G94\nG43.4 H1\nG0 X15 Y-15 Z0 B15 C0\nG4 P0.3\nG1 Y15 F1500\nC-20 F2400\nX-15 F1500\nX-15 C-40 F2400\nY-15 F1500\n\
    M11\nG0 B30 C-40\nM10\nG4 P0.3\nG1 X-12 Y-12 F1000\nX-2\nY-4\nG4 P0.3\nM5\nM30\n";

#[test]
fn turns_about_a_standing_tip_keep_their_feed_and_clamped_axes_are_left_alone() {
    let folder = Folder::new();
    folder.train_on("bc", "40", "linear");
    // Limits in another unit than the logs.
    let slow = include_str!("../../machine/machines/bc.toml").replace("velocity_rad_s = 2.0", "velocity_rad_s = 0.035");
    folder.write("slow.toml", slow);
    let logs = csv_files(&folder.path("")).into_iter().map(|log| log.to_string_lossy().into_owned()).collect::<Vec<_>>();
    let words: Vec<&str> = logs.iter().map(String::as_str).filter(|log| log.contains("log-")).collect();
    let refused = folder.fails(1, &[&["train"], &words[..], &["--machine", "slow.toml", "-o", "no.model"]].concat());
    assert!(refused.contains("axis b: the logs move it at up to") && refused.contains("b:deg"), "{refused}");
    std::fs::write(folder.path("part.nc"), TURNS).unwrap();
    let measured = |program: &str| {
        folder.figures(&["simulate", program, "--machine", "bc", "-o", "run.csv"]);
        folder.figures(&["measure", "run.csv", "--desired", "part.nc", "--machine", "bc"])
    };
    let raw = measured("part.nc");
    // The tool leads and lags in a turn; that is no error of its direction.
    assert!(raw["orientation_urad"]["max"].as_f64().unwrap() < 1000.0, "{raw}");

    let made = folder.figures(&["compensate", "part.nc", "-m", "machine.model", "-o", "out.nc", "--work-offset", "0,0,0"]);
    let out = folder.read("out.nc");
    // With words of linear axes F would be theirs.
    assert!(out.contains("\nC-20 F2400\n") || out.contains("\nG1C-20 F2400\n"), "{out}");
    let clamped = out.split("M10").nth(1).unwrap();
    assert!(clamped.contains("X-2") && !clamped.contains('B') && !clamped.contains('C'), "{clamped}");
    let cut = measured("out.nc");
    println!("{raw} → {cut}, {made}");
    assert!(figure(&cut, "contour_um") < figure(&raw, "contour_um"), "{cut} against {raw}");

    let timed = ["compensate", "part.nc", "-m", "machine.model", "-o", "timed.nc", "--work-offset", "0,0,0", "--format", "g93"];
    let made = folder.figures(&timed);
    let cut = measured("timed.nc");
    println!("{cut}, {made}");
    assert!(figure(&cut, "contour_um") < 0.3 * figure(&raw, "contour_um"), "{cut} against {raw}");
}

/// Turns of the table about an upright tool.
const UPRIGHT: &str = "G21 G90 G94\nG43.4 H1\nG0 X15 Y-15 Z0 B0 C0\nG4 P0.3\nG1 Y15 F1500\nC-20 F2400\nX-15 F1500\nC-50 F2400\nY-15 F1500\nG4 P0.3\nM30\n";

#[test]
fn turns_about_an_upright_tool_are_told_and_corrected() {
    let folder = Folder::new();
    folder.train_on("bc", "40", "linear");
    folder.write("part.nc", UPRIGHT);
    let offset = ["--work-offset", "0,0,0", "--format", "g93"];
    let made = folder.figures(&[&["compensate", "part.nc", "-m", "machine.model", "-o", "out.nc"], &offset[..]].concat());
    let measured = |program: &str| {
        let ran = folder.figures(&["simulate", program, "--machine", "bc", "--against", "part.nc", "-o", "run.csv"]);
        let measured = folder.figures(&["measure", "run.csv", "--desired", "part.nc", "--machine", "bc"]);
        // Both count the turns as long as they last.
        assert!((figure(&ran, "contour_um") / figure(&measured, "contour_um") - 1.0).abs() < 0.05, "{ran} and {measured}");
        measured
    };
    let (raw, cut) = (measured("part.nc"), measured("out.nc"));
    println!("{raw} → {cut}, {made}");
    let told = &made["predicted_contour_um"];
    assert!((told["before"]["rms"].as_f64().unwrap() / figure(&raw, "contour_um") - 1.0).abs() < 0.1, "{told} and {raw}");
    assert!(figure(&cut, "contour_um") < 0.2 * figure(&raw, "contour_um"), "{cut} against {raw}");
    for (figures, expected) in [("contour_um", "expected_contour_um"), ("orientation_urad", "expected_orientation_urad")] {
        let high = made[expected]["rms"]["high"].as_f64().unwrap();
        assert!(figure(&cut, figures) < 1.5 * high, "{figures}: {cut} for {}", made[expected]);
    }
}

#[test]
fn what_the_machine_cannot_reach_is_refused_with_its_line() {
    let folder = Folder::new();
    let run = |program: &str| {
        std::fs::write(folder.path("part.nc"), program).unwrap();
        folder.fails(1, &["simulate", "part.nc", "--machine", "bc", "-o", "out.csv"])
    };
    let said = run("G21 G90 G94\nG0 X0 Y0 Z0 B0 C0\nG1 X10 F1000\nG1 B150 F600\n");
    assert!(said.contains("part.nc:4:") && said.contains("axis `b`") && said.contains("110"), "{said}");
    let said = run("G21 G90 G94\nG43.4 H1\nG0 X0 Y0 Z0 B0 C0\nG1 X10 F1000\nG1 X12 B-130\n");
    assert!(said.contains("part.nc:5:") && said.contains("axis `b`"), "{said}");
}
