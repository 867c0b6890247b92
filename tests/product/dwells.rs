//! Dwells within a reference trajectory.

use serde_json::Value;

use crate::common::Folder;

/// Columns of a CSV file, without the header.
fn columns(text: &str) -> Vec<Vec<f64>> {
    let rows: Vec<Vec<f64>> =
        text.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    (0..rows[0].len()).map(|column| rows.iter().map(|row| row[column]).collect()).collect()
}

const DESIRED: &str = "rests/01-full.csv";

/// A folder with the model, a reference with dwells and its compensated reference `rests.csv`.
fn compensated() -> Folder {
    let folder = Folder::with_model();
    folder.figures(&["excite", "-o", "rests", "--seconds", "12", "--seed", "9"]);
    folder.figures(&["compensate", DESIRED, "-m", "machine.model", "-o", "rests.csv", "--iterations", "12"]);
    folder
}

#[test]
fn an_axis_at_standstill_has_a_compensated_reference_at_standstill() {
    let folder = compensated();
    let read = |path: &str| columns(&folder.read(path));
    let (desired, learned) = (read(DESIRED), read("rests.csv"));
    let period = desired[0][1] - desired[0][0];
    let (before, after) = ((0.04 / period) as usize, (0.04 / period) as usize);
    let mut rests = 0;
    for (desired, learned) in desired.iter().zip(&learned).skip(1) {
        for k in before..desired.len() - after {
            // The axis has rested for a while and goes on resting: so does the reference, a little off at most.
            if desired[k - before..=k + after].iter().all(|x| *x == desired[k]) {
                rests += 1;
                assert!((learned[k] - desired[k]).abs() < 1e-3, "sample {k}: {} for {}", learned[k], desired[k]);
                assert!((learned[k] - learned[k - 1]).abs() < 1e-7, "sample {k}: {} after {}", learned[k], learned[k - 1]);
            }
        }
    }
    assert!(rests > 15, "{rests}");
}

#[test]
fn compensation_halves_the_error_of_a_reference_with_dwells() {
    let folder = compensated();
    let raw = folder.figures(&["simulate", DESIRED, "-o", "raw-rests.csv"]);
    let cut = folder.figures(&["simulate", "rests.csv", "--against", DESIRED, "-o", "cut-rests.csv"]);
    let rms = |figures: &Value| figures["contour_um"]["rms"].as_f64().unwrap();
    assert!(rms(&cut) < 0.5 * rms(&raw), "{cut} against {raw}");
}

#[test]
fn a_dwell_on_a_straight_line_is_where_the_program_states_it() {
    let folder = Folder::with_model();
    for seconds in ["0.7", "0.9"] {
        folder.write(
            "line.ngc",
            format!("G21 G90 G17 G64 P0.01\nG0 X0 Y0 Z10\nG1 Z-1 F300\nG1 X30 Y0 F1500\nG4 P{seconds}\nX60\nX10\nG0 Z10\nM2\n"),
        );
        folder.figures(&["compensate", "line.ngc", "-m", "machine.model", "-o", "out.ngc", "--dialect", "linuxcnc"]);
        let out = folder.read("out.ngc");
        let before = out.lines().take_while(|line| !line.starts_with("G4")).last().unwrap();
        assert!(before.contains("X30.Z-1.") || before.ends_with("X30 Y0 F1500"), "{out}");
    }
}
