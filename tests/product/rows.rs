//! Compensated paths as rows of positions for controls that stream them. Works on the story's model.

use datasets::{ReadOptions, read_reference};
use serde_json::Value;

use crate::common::{Folder, text};

const PART: &str = "G21 G90 G17\nG0 X0 Y0\nG1 X30 F3600\nG3 X30 Y20 J10\nG1 X10\nG4 P0.1\nG1 X0 Y10\nG1 X0 Y0\nM30\n";

fn table(folder: &Folder, name: &str) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(folder.path(name)).unwrap();
    let rows = text.lines().filter(|line| !line.starts_with(['#', 't']));
    rows.map(|row| row.split(',').map(|cell| cell.parse().unwrap()).collect()).collect()
}

pub fn rows_carry_the_compensated_path(folder: &Folder) {
    std::fs::write(folder.path("rows.nc"), PART).unwrap();
    let compensate = |out: &str, more: &[&str]| -> Value {
        folder.figures(&[&["compensate", "rows.nc", "-m", "machine.model", "-o", out][..], more].concat())
    };
    let rms = |figures: &Value| figures["contour_um"]["rms"].as_f64().unwrap();

    // A table read as a reference is a better path than the program.
    let made = compensate("table.csv", &["--carrier", "table"]);
    assert_eq!((&made["carrier"], &made["rows"]["interval_ms"]), (&"table".into(), &2.0.into()));
    let raw = folder.figures(&["simulate", "rows.nc", "-o", "raw.csv"]);
    let cut = folder.figures(&["simulate", "table.csv", "--against", "rows.nc", "-o", "cut.csv"]);
    println!("{:.3} µm of the program, {:.3} µm of the table", rms(&raw), rms(&cut));
    assert!(rms(&cut) < 0.25 * rms(&raw), "{cut} against {raw}");

    // Rows with velocities lead along the table, at 6 ms as well as they say.
    let (dense, _) = read_reference(&folder.path("table.csv"), &ReadOptions::default()).unwrap();
    let made = compensate("pvt.csv", &["--carrier", "pvt", "--spacing", "6"]);
    let said_um = made["rows"]["off_um"].as_f64().unwrap();
    let rows = table(folder, "pvt.csv");
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
    the_axes_limits_hold(folder);

    // Too coarse an interval is told, with one that is not.
    let coarse = compensate("pvt.csv", &["--carrier", "pvt", "--spacing", "50"]);
    let finer = coarse["rows"]["finer_interval_ms"].as_f64().unwrap().to_string();
    let made = compensate("pvt.csv", &["--carrier", "pvt", "--spacing", &finer]);
    assert!(made["rows"]["finer_interval_ms"].is_null(), "{made}");
    assert!(made["rows"]["off_um"].as_f64() < made["rows"]["tolerance_um"].as_f64(), "{made}");

    // Coordinates are the program's wherever the part lies; a profile may say what is written.
    let profile = "decimals = 5\ncarrier = \"pvt\"\npoint_spacing_ms = 5.0\n";
    std::fs::write(folder.path("stream.toml"), profile).unwrap();
    let made = compensate("pvt.csv", &["--controller", "stream.toml", "--work-offset", "10,-5,1"]);
    assert_eq!((&made["carrier"], &made["rows"]["interval_ms"]), (&"pvt".into(), &5.0.into()));
    let rows = table(folder, "pvt.csv");
    assert!(rows[0][1..4].iter().all(|at| at.abs() < 1e-3), "{:?}", rows[0]);
    what_rows_cannot_stand_for_is_refused(folder);
}

/// As they do for every reference that passed the guard.
fn the_axes_limits_hold(folder: &Folder) {
    let largest = |values: &dyn Fn(usize) -> f64, of: std::ops::Range<usize>| of.map(|k| values(k).abs()).fold(0.0, f64::max);
    let rows = table(folder, "table.csv");
    for axis in 1..4 {
        let speed = |k: usize| (rows[k][axis] - rows[k - 1][axis]) / 0.002;
        let acceleration = |k: usize| (speed(k + 1) - speed(k)) / 0.002;
        assert!(largest(&speed, 1..rows.len()) < 1.1 * 80.0);
        assert!(largest(&acceleration, 1..rows.len() - 1) < 1.51 * 800.0);
    }
    let rows = table(folder, "pvt.csv");
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

fn what_rows_cannot_stand_for_is_refused(folder: &Folder) {
    let words = |program: &'static str| ["compensate", program, "-m", "machine.model", "-o", "no.csv", "--carrier", "table"];
    for (name, line, why) in [
        ("cycle.nc", "G81 X5 Y5 Z-5 R2 F100", "is a canned cycle"),
        ("home.nc", "G28 Z0", "leads to a place that only the control knows"),
        ("turn.nc", "G1 A10", "turns axes that the machine description does not hold"),
        ("cutter.nc", "G41 D1 G1 X40 Y40", "is shifted by the control's cutter compensation"),
    ] {
        std::fs::write(folder.path(name), PART.replace("M30", &format!("{line}\nM30"))).unwrap();
        let said = folder.fails(1, &words(name));
        assert!(said.contains(&format!("{name}: line 9 {why}")), "{said}");
    }
    let program = ["compensate", "rows.nc", "-m", "machine.model", "-o", "no.nc", "--carrier", "pvt"];
    assert!(folder.fails(2, &program).contains("name OUT with the ending .csv"));
    let said = folder.fails(2, &["compensate", "rows.nc", "-m", "machine.model", "-o", "no.csv"]);
    assert!(said.contains("--carrier table or pvt"), "{said}");
    assert!(folder.fails(2, &[&words("rows.nc")[..], &["--decimals", "13"]].concat()).contains("from 0 to 12"));
    assert!(!folder.path("no.csv").exists() && !folder.path("no.nc").exists());
    let help = text(&folder.precomp(&["compensate", "--help"]).stdout);
    assert!(help.contains("pvt:") && help.contains("table:"), "{help}");
}
