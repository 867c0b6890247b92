//! Compensated paths as rows of positions for controls that stream them.

use datasets::{ReadOptions, read_reference};
use serde_json::Value;

use crate::common::Folder;

const PART: &str = "G21 G90 G17\nG0 X0 Y0\nG1 X30 F3600\nG3 X30 Y20 J10\nG1 X10\nG4 P0.1\nG1 X0 Y10\nG1 X0 Y0\nM30\n";

fn table(folder: &Folder, name: &str) -> Vec<Vec<f64>> {
    let text = folder.read(name);
    let rows = text.lines().filter(|line| !line.starts_with(['#', 't']));
    rows.map(|row| row.split(',').map(|cell| cell.parse().unwrap()).collect()).collect()
}

/// Largest absolute value over a range of rows.
fn largest(values: &dyn Fn(usize) -> f64, of: std::ops::Range<usize>) -> f64 {
    of.map(|k| values(k).abs()).fold(0.0, f64::max)
}

/// A folder with the model and `rows.nc`.
fn folder_with_program() -> Folder {
    let folder = Folder::with_model();
    folder.write("rows.nc", PART);
    folder
}

/// Compensates `rows.nc`; the figures.
fn compensate(folder: &Folder, out: &str, options: &[&str]) -> Value {
    folder.figures(&[&["compensate", "rows.nc", "-m", "machine.model", "-o", out][..], options].concat())
}

#[test]
fn a_table_run_as_a_reference_is_closer_to_the_path_than_the_program() {
    let folder = folder_with_program();
    let made = compensate(&folder, "table.csv", &["--format", "table"]);
    assert_eq!((&made["format"], &made["setpoints"]["interval_ms"]), (&"table".into(), &2.0.into()));
    let raw = folder.figures(&["simulate", "rows.nc", "-o", "raw.csv"]);
    let cut = folder.figures(&["simulate", "table.csv", "--against", "rows.nc", "-o", "cut.csv"]);
    let rms = |figures: &Value| figures["contour_um"]["rms"].as_f64().unwrap();
    println!("{:.3} µm of the program, {:.3} µm of the table", rms(&raw), rms(&cut));
    assert!(rms(&cut) < 0.25 * rms(&raw), "{cut} against {raw}");
}

#[test]
fn the_interpolation_error_between_rows_with_velocities_is_the_reported_one() {
    let folder = folder_with_program();
    compensate(&folder, "table.csv", &["--format", "table"]);
    let (dense, _) = read_reference(&folder.path("table.csv"), &ReadOptions::default()).unwrap();
    let made = compensate(&folder, "pvt.csv", &["--format", "pvt", "--spacing", "6"]);
    let said_um = made["rows"]["off_um"].as_f64().unwrap();
    let rows = table(&folder, "pvt.csv");
    let mut worst_mm = 0.0_f64;
    for (axis, column) in dense.columns().iter().enumerate() {
        for (k, wanted) in column.iter().enumerate() {
            let (row, u) = (k / 3, (k % 3) as f64 / 3.0);
            let ends = [&rows[row], &rows[(row + 1).min(rows.len() - 1)]].map(|row| (row[1 + axis], 0.006 * row[4 + axis]));
            let [(p, v), (q, w)] = ends;
            let basis = [
                2.0 * u * u * u - 3.0 * u * u + 1.0,
                u * u * u - 2.0 * u * u + u,
                3.0 * u * u - 2.0 * u * u * u,
                u * u * u - u * u,
            ];
            worst_mm = worst_mm.max((p * basis[0] + v * basis[1] + q * basis[2] + w * basis[3] - wanted).abs());
        }
    }
    println!("rows every 6 ms: {:.3} µm beside the table, {said_um:.3} µm said", worst_mm * 1e3);
    assert!((worst_mm * 1e3 - said_um).abs() < 5e-3, "{worst_mm} {said_um}");
}

#[test]
fn a_table_keeps_the_axis_limits() {
    let folder = folder_with_program();
    compensate(&folder, "table.csv", &["--format", "table"]);
    let rows = table(&folder, "table.csv");
    for axis in 1..4 {
        let speed = |k: usize| (rows[k][axis] - rows[k - 1][axis]) / 0.002;
        let acceleration = |k: usize| (speed(k + 1) - speed(k)) / 0.002;
        assert!(largest(&speed, 1..rows.len()) < 1.1 * 80.0);
        assert!(largest(&acceleration, 1..rows.len() - 1) < 1.51 * 800.0);
    }
}

#[test]
fn rows_with_velocities_keep_the_axis_limits_and_end_at_standstill() {
    let folder = folder_with_program();
    compensate(&folder, "pvt.csv", &["--format", "pvt", "--spacing", "6"]);
    let rows = table(&folder, "pvt.csv");
    for axis in 1..4 {
        assert!(largest(&|k| rows[k][3 + axis], 0..rows.len()) < 1.1 * 80.0);
        // Of the cubic, at the beginning of every interval.
        let at_start = |k: usize| {
            let (h, v, w) = (0.006, rows[k][3 + axis], rows[k + 1][3 + axis]);
            (6.0 * (rows[k + 1][axis] - rows[k][axis]) / h - 4.0 * v - 2.0 * w) / h
        };
        assert!(largest(&at_start, 0..rows.len() - 1) < 1.6 * 800.0);
    }
    let last = rows.last().unwrap();
    assert!(last[4..].iter().all(|velocity| *velocity == 0.0), "{last:?}");
}

#[test]
fn the_interval_suggested_for_one_that_is_too_coarse_keeps_the_tolerance() {
    let folder = folder_with_program();
    let coarse = compensate(&folder, "pvt.csv", &["--format", "pvt", "--spacing", "50"]);
    let finer = coarse["rows"]["finer_interval_ms"].as_f64().unwrap().to_string();
    let made = compensate(&folder, "pvt.csv", &["--format", "pvt", "--spacing", &finer]);
    assert!(made["rows"]["finer_interval_ms"].is_null(), "{made}");
    assert!(made["rows"]["off_um"].as_f64() < made["rows"]["tolerance_um"].as_f64(), "{made}");
}

#[test]
fn a_profile_chooses_rows_and_a_work_offset_leaves_them_in_program_coordinates() {
    let folder = folder_with_program();
    folder.write("stream.toml", "decimals = 5\ncarrier = \"pvt\"\npoint_spacing_ms = 5.0\n");
    let made =
        compensate(&folder, "pvt.csv", &["--controller", "stream.toml", "--work-offset", "10,-5,1", "--decimal-point", "unit"]);
    assert_eq!((&made["carrier"], &made["rows"]["interval_ms"]), (&"pvt".into(), &5.0.into()));
    let rows = table(&folder, "pvt.csv");
    assert!(rows[0][1..4].iter().all(|at| at.abs() < 1e-3), "{:?}", rows[0]);
}

/// Words that compensate a program into a table `no.csv`.
fn into_table(program: &str) -> [&str; 8] {
    ["compensate", program, "-m", "machine.model", "-o", "no.csv", "--format", "table"]
}

#[test]
fn blocks_that_rows_cannot_express_are_refused_with_their_line() {
    let folder = Folder::with_model();
    for (name, line, why) in [
        ("cycle.nc", "G81 X5 Y5 Z-5 R2 F100", "is a canned cycle"),
        ("home.nc", "G28 Z0", "leads to a place that only the control knows"),
        ("turn.nc", "G1 A10", "turns axes that the machine description does not hold"),
        ("cutter.nc", "G41 D1 G1 X40 Y40", "is shifted by the control's cutter compensation"),
    ] {
        folder.write(name, PART.replace("M30", &format!("{line}\nM30")));
        let said = folder.fails(1, &into_table(name));
        assert!(said.contains(&format!("{name}: line 9 {why}")), "{said}");
    }
    assert!(!folder.path("no.csv").exists());
}

#[test]
fn rows_go_into_a_csv_file_and_a_csv_file_takes_rows_only() {
    let folder = folder_with_program();
    let program = ["compensate", "rows.nc", "-m", "machine.model", "-o", "no.nc", "--format", "pvt"];
    assert!(folder.fails(2, &program).contains("name OUT with the ending .csv"));
    let said = folder.fails(2, &["compensate", "rows.nc", "-m", "machine.model", "-o", "no.csv"]);
    assert!(said.contains("--format table or pvt"), "{said}");
    assert!(!folder.path("no.csv").exists() && !folder.path("no.nc").exists());
}

#[test]
fn rows_with_more_than_twelve_decimals_are_refused() {
    let folder = folder_with_program();
    assert!(folder.fails(2, &[&into_table("rows.nc")[..], &["--decimals", "13"]].concat()).contains("from 0 to 12"));
    assert!(!folder.path("no.csv").exists());
}

#[test]
fn help_names_both_forms_of_rows() {
    let help = Folder::new().prints(&["compensate", "--help"]);
    assert!(help.contains("pvt:") && help.contains("table:"), "{help}");
}
