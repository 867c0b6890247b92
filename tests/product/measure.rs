//! What `measure` says of recorded runs.

use crate::common::Folder;
use serde_json::Value;

fn number(figures: &Value, key: &str, of: &str) -> f64 {
    figures[key][of].as_f64().unwrap()
}

/// The rows of a log, its header kept.
fn rewritten(folder: &Folder, from: &str, to: &str, row: impl Fn(usize, Vec<f64>) -> Vec<f64>) {
    let text = std::fs::read_to_string(folder.path(from)).unwrap();
    let mut out = String::new();
    for (k, line) in text.lines().enumerate() {
        if k == 0 {
            out.push_str(line);
        } else {
            let values = row(k - 1, line.split(',').map(|value| value.parse().unwrap()).collect());
            out.push_str(&values.iter().map(|value| format!("{value:.9}")).collect::<Vec<_>>().join(","));
        }
        out.push('\n');
    }
    std::fs::write(folder.path(to), out).unwrap();
}

#[test]
fn the_way_to_the_path_and_from_it_does_not_count() {
    let folder = Folder::new();
    folder.figures(&["simulate", "curve:five-petals", "-o", "run.csv"]);
    let before = folder.figures(&["measure", "run.csv", "--desired", "curve:five-petals", "--machine", "ballscrew"]);
    let text = std::fs::read_to_string(folder.path("run.csv")).unwrap();
    let rows: Vec<Vec<f64>> =
        text.lines().skip(1).map(|line| line.split(',').map(|value| value.parse().unwrap()).collect()).collect();
    // From home to the start in a second, a wait, the path, and back home; the actual position lags by far on both ways.
    let way = |place: &[f64], share: f64| -> Vec<f64> {
        (0..3).flat_map(|axis| [place[1 + 2 * axis] * share, place[2 + 2 * axis] * share - 0.05 * (1.0 - share)]).collect()
    };
    let (first, last) = (&rows[0], &rows[rows.len() - 1]);
    let mut all: Vec<Vec<f64>> = (0..500).map(|k| way(first, f64::from(k) / 500.0)).collect();
    all.extend((0..100).map(|_| first[1..].to_vec()));
    all.extend(rows.iter().map(|row| row[1..].to_vec()));
    all.extend((0..500).map(|k| way(last, 1.0 - f64::from(k) / 500.0)));
    let mut log = text.lines().next().unwrap().to_owned() + "\n";
    for (k, row) in all.iter().enumerate() {
        let cells: Vec<String> = row.iter().map(|value| format!("{value:.9}")).collect();
        log += &format!("{:.9},{}\n", k as f64 * 0.002, cells.join(","));
    }
    std::fs::write(folder.path("long.csv"), log).unwrap();
    let after = folder.figures(&["measure", "long.csv", "--desired", "curve:five-petals", "--machine", "ballscrew"]);
    let (one, other) = (number(&before, "contour_um", "max"), number(&after, "contour_um", "max"));
    assert!((one - other).abs() < 0.05, "{one} {other}");
    let (one, other) = (number(&before, "contour_um", "rms"), number(&after, "contour_um", "rms"));
    assert!((one - other).abs() < 0.05 * one, "{one} {other}");
}

#[test]
fn a_late_and_shifted_run_is_measured_the_same() {
    let folder = Folder::new();
    folder.figures(&["simulate", "curve:five-petals", "-o", "run.csv"]);
    let before = folder.figures(&["measure", "run.csv", "--desired", "curve:five-petals", "--machine", "ballscrew"]);
    assert_eq!(before["offset_mm"], serde_json::json!([0.0, 0.0, 0.0]));

    // 8 ms late, the work offset not taken off.
    let offset = [12.345, -3.2, 0.5];
    let text = std::fs::read_to_string(folder.path("run.csv")).unwrap();
    let first: Vec<f64> = text.lines().nth(1).unwrap().split(',').map(|value| value.parse().unwrap()).collect();
    let rows: Vec<Vec<f64>> =
        text.lines().skip(1).map(|line| line.split(',').map(|value| value.parse().unwrap()).collect()).collect();
    rewritten(&folder, "run.csv", "late.csv", |k, row| {
        let source = if k < 4 { &first } else { &rows[k - 4] };
        let mut moved = source.clone();
        moved[0] = row[0];
        for axis in 0..3 {
            moved[1 + 2 * axis] += offset[axis];
            moved[2 + 2 * axis] += offset[axis];
        }
        moved
    });
    let after = folder.figures(&["measure", "late.csv", "--desired", "curve:five-petals", "--machine", "ballscrew"]);
    assert!((after["delay_ms"].as_f64().unwrap() - 8.0).abs() < 1e-3, "{after}");
    for (axis, wanted) in offset.iter().enumerate() {
        assert!((after["offset_mm"][axis].as_f64().unwrap() - wanted).abs() < 1e-9, "{after}");
    }
    for of in ["rms", "max"] {
        let (one, other) = (number(&before, "contour_um", of), number(&after, "contour_um", of));
        assert!((one - other).abs() < 0.01, "{of}: {one} {other}");
    }
}

#[test]
fn a_circle_gets_its_circular_test_and_its_reversals() {
    let folder = Folder::new();
    folder.figures(&["simulate", "curve:circle", "--feed", "50", "-o", "circle.csv"]);
    let figures =
        folder.figures(&["measure", "circle.csv", "--desired", "curve:circle", "--feed", "50", "--machine", "ballscrew"]);
    let one_way = &figures["circular_test"]["counterclockwise"];
    let round = one_way["circular_um"].as_f64().unwrap();
    assert!((2.0..40.0).contains(&round), "{figures}");
    // Once round from +x: y turns at ±y, x at −x; every one leaves a glitch.
    let reversals = figures["reversals"].as_array().unwrap();
    assert_eq!(reversals.len(), 3, "{figures}");
    assert!(reversals.iter().all(|one| one["glitch_um"].as_f64().unwrap() > 0.3), "{figures}");
    // Axes lag by (1 − k_ff)/K_pp of about 1.2 ms, and not quite alike.
    let lag = figures["common_lag_ms"].as_f64().unwrap();
    assert!((0.5..2.5).contains(&lag), "{figures}");
    // Not a circle, no circular test.
    folder.figures(&["simulate", "curve:ellipse", "-o", "ellipse.csv"]);
    assert!(folder.figures(&["measure", "ellipse.csv"])["circular_test"].is_null());
}

#[test]
fn a_program_gets_lines_and_another_program_is_refused() {
    let folder = Folder::new();
    let part = "G21 G90 G17\nG0 X0 Y0\nG1 X30 F2400\nG3 X30 Y20 J10\nG1 X0\nG1 Y0\nM30\n";
    std::fs::write(folder.path("part.nc"), part).unwrap();
    std::fs::write(folder.path("other.nc"), part.replace("X30", "X35")).unwrap();
    folder.figures(&["simulate", "part.nc", "-o", "run.csv"]);
    let figures = folder.figures(&["measure", "run.csv", "--desired", "part.nc", "--machine", "ballscrew"]);
    let lines: Vec<u64> = figures["segments"].as_array().unwrap().iter().map(|one| one["line"].as_u64().unwrap()).collect();
    assert_eq!(lines, [3, 4, 5, 6]);
    assert!(figures["worst"][0]["line"].as_u64().is_some());
    assert!(
        folder
            .fails(1, &["measure", "run.csv", "--desired", "other.nc", "--machine", "ballscrew"])
            .contains("leaves the desired path")
    );
    for estimator in ["hermite-foot", "spline-search", "circle", "tangent"] {
        let by =
            folder.figures(&["measure", "run.csv", "--desired", "part.nc", "--machine", "ballscrew", "--estimator", estimator]);
        assert!((number(&by, "contour_um", "rms") - number(&figures, "contour_um", "rms")).abs() < 3.0, "{estimator}: {by}");
    }
}

#[test]
fn readback_tells_a_control_that_keeps_path_and_time_from_others() {
    let folder = Folder::new();
    let part = "G21 G90 G17\nG0 X0 Y0 Z0\nG4 P0.3\nG1 X20 F1200\nG3 X20 Y20 J10\nG1 X0\nM2\n";
    std::fs::write(folder.path("part.nc"), part).unwrap();
    std::fs::write(folder.path("slow.nc"), part.replace("F1200", "F900")).unwrap();
    std::fs::write(folder.path("off.nc"), part.replace("X20 F1200", "X20 Y0.004 F1200")).unwrap();
    folder.figures(&["simulate", "part.nc", "-o", "run.csv"]);
    let kept = |program: &str| {
        let figures = folder.figures(&["measure", "run.csv", "--desired", program, "--machine", "ballscrew", "--readback"]);
        println!("{program}: {figures}");
        (figures["path_is_kept"].as_bool().unwrap(), figures["time_is_kept"].as_bool().unwrap(), figures)
    };
    let (path, time, figures) = kept("part.nc");
    assert!(path && time, "{figures}");
    assert!(number(&figures, "readback_um", "max") < 0.01 && figures["largest_delay_ms"].as_f64().unwrap() < 2.5, "{figures}");
    let (path, time, figures) = kept("slow.nc");
    assert!(path && !time, "{figures}");
    let (path, _, figures) = kept("off.nc");
    assert!(!path, "{figures}");
    folder.fails(2, &["measure", "run.csv", "--readback"]);
    // A rest a fraction of a micrometre before the end is not part of the path.
    std::fs::write(folder.path("short.nc"), part.replace("X0\nM2", "X0.0003\nG4 P1\nM2")).unwrap();
    folder.figures(&["simulate", "short.nc", "-o", "run.csv"]);
    let (path, time, figures) = kept("part.nc");
    assert!(path && time, "{figures}");
    // A wait within the path makes no one late.
    std::fs::write(folder.path("part.nc"), part.replace("G3 X20", "G4 P0.3\nG3 X20")).unwrap();
    folder.figures(&["simulate", "part.nc", "-o", "run.csv"]);
    let (path, time, figures) = kept("part.nc");
    assert!(path && time && figures["largest_delay_ms"].as_f64().unwrap() < 2.5, "{figures}");
}
