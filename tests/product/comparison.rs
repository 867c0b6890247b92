//! The opponents of the first run, and the table that README prints.

use serde_json::Value;

use crate::common::Folder;

/// Mean over the paths of a method's figure, µm.
fn mean(figures: &Value, method: &str, figure: &str) -> f64 {
    let paths = figures["paths"].as_array().unwrap();
    paths.iter().map(|path| path["methods"][method][figure].as_f64().unwrap()).sum::<f64>() / paths.len() as f64
}

#[test]
fn spatial_learning_reaches_an_independent_implementations_figures() {
    // Q = 0.8, 6 runs, low-pass 100 Hz: 0.30 / 0.86, 0.28 / 0.80, 0.29 / 0.95 and 0.30 / 0.96 µm there.
    let folder = Folder::new();
    let settings = ["--gain", "0.8", "--low-pass", "100", "--runs", "6"];
    let curves = ["compare", "curve:crown", "curve:spiral", "curve:flower", "curve:nurbs-1"];
    let figures = folder.figures(&[&curves[..], &settings].concat());
    for (path, rms) in figures["paths"].as_array().unwrap().iter().zip([0.30, 0.28, 0.29, 0.30]) {
        let figure = |name: &str| path["methods"]["spatial-ilc"][name].as_f64().unwrap();
        assert!((figure("rms_um") / rms - 1.0).abs() < 0.1, "{path}");
        assert!(figure("max_um") < 1.05, "{path}");
    }
    assert!(mean(&figures, "spatial-ilc", "max_um") < 1.0, "{figures}");
    assert_eq!(figures["ilc"]["laws"]["spatial-ilc"]["low_pass_hz"], 100.0);
    assert_eq!(figures["ilc"]["tuned"], false);
}

#[test]
fn learning_is_tuned_to_a_slow_machine() {
    // A third of the gains, hardly any feed-forward: at Q = 0.8 and 100 Hz spatial learning stays far above what a law of its own settings reaches.
    let folder = Folder::new();
    let slow = include_str!("../../machine/machines/ballscrew.toml")
        .replace("position_gain_1_s = 100.0, feed_forward = 0.886", "position_gain_1_s = 33.0, feed_forward = 0.3")
        .replace("position_gain_1_s = 95.0, feed_forward = 0.8815", "position_gain_1_s = 31.0, feed_forward = 0.3")
        .replace("position_gain_1_s = 105.0, feed_forward = 0.8865", "position_gain_1_s = 35.0, feed_forward = 0.3");
    assert_eq!(slow.matches("feed_forward = 0.3,").count(), 3);
    std::fs::write(folder.path("slow.toml"), slow).unwrap();
    let compare = ["compare", "curve:polygon-5", "--machine", "slow.toml"];
    let tuned = folder.figures(&compare);
    let given = folder.figures(&[&compare[..], &["--gain", "0.8", "--low-pass", "100"]].concat());
    assert_eq!(tuned["ilc"]["tuned"], true);
    let best = |figures: &Value, figure: &str| mean(figures, "best-ilc", figure);
    assert!(best(&tuned, "rms_um") < 0.03 * mean(&tuned, "uncompensated", "rms_um"), "{tuned}");
    assert!(best(&tuned, "rms_um") <= 1.05 * best(&given, "rms_um"), "{tuned} against {given}");
    assert!(mean(&tuned, "spatial-ilc", "rms_um") < 0.6 * mean(&given, "spatial-ilc", "rms_um"), "{tuned} against {given}");
    for (law, settings) in tuned["ilc"]["laws"].as_object().unwrap() {
        assert!(mean(&tuned, law, "rms_um") < mean(&tuned, "uncompensated", "rms_um"), "{law} {settings}: {tuned}");
    }
    // The best is named, figure by figure.
    let methods = &tuned["paths"][0]["methods"];
    for (law, figure) in [("rms_law", "rms_um"), ("max_law", "max_um")] {
        let named = methods["best-ilc"][law].as_str().unwrap();
        assert_eq!(methods[named][figure], methods["best-ilc"][figure]);
    }
}

#[test]
fn part_programs_are_compared_as_programs_beside_a_perfect_model() {
    let folder = Folder::with_model();
    let arcs = "G21 G90 G94\nG0 X0 Y0 Z0\nG1 X20 F2400\nG3 X30 Y10 J10\nG1 Y20\nG1 X0 Y12\nG1 X0 Y0\nM2\n";
    folder.write("arcs.nc", arcs);
    let settings = [
        "-m",
        "machine.model",
        "--gain",
        "0.8",
        "--low-pass",
        "40",
        "--runs",
        "2",
        "--iterations",
        "1",
        "--work-offset",
        "0,0,0",
    ];
    let figures = folder.figures(&[&["compare", "arcs.nc", "--programs"][..], &settings].concat());
    let programs = &figures["programs"];
    let rms = |method: &str| mean(programs, method, "rms_um");
    let floor = rms("floor");
    assert!(floor > 0.0 && rms("perfect-model") < 0.5 * rms("uncompensated"), "{programs}");
    assert!(rms("first-run") < 0.8 * rms("uncompensated") && rms("first-run") > floor, "{programs}");
    // With the program's own points alone an arc and lines of 20 mm keep most of their error.
    assert!(rms("spatial-ilc") < 0.6 * rms("uncompensated"), "{programs}");
    assert!(mean(programs, "first-run", "seconds") <= 1.0101 * mean(programs, "uncompensated", "seconds"), "{programs}");
}

#[test]
fn the_demo_prints_what_readme_says() {
    // README's figures of the machine `ballscrew`, RMS and MAX, with a margin of 15 % (20 % for the MAX of a single noise seed).
    let folder = Folder::new();
    let figures = folder.figures(&["demo", "--out", "demo"]);
    let programs = &figures["programs"];
    let rows = [
        (&figures, "first-run", 0.242, 0.804),
        (&figures, "best-ilc", 0.250, 0.758),
        (programs, "first-run", 0.286, 1.643),
        (programs, "best-ilc", 0.286, 1.719),
    ];
    for (table, method, rms, max) in rows {
        assert!(mean(table, method, "rms_um") < 1.15 * rms, "{method}: {table}");
        assert!(mean(table, method, "max_um") < 1.2 * max, "{method}: {table}");
        assert!(mean(table, method, "rms_um") > mean(table, "floor", "rms_um"), "{method}: {table}");
    }
    assert!(mean(programs, "first-run", "seconds") < 1.01 * mean(programs, "uncompensated", "seconds"), "{programs}");
    for path in figures["paths"].as_array().unwrap() {
        assert!(path["methods"]["first-run"]["max_at"]["near"].is_string(), "{path}");
        assert!(path["methods"]["floor"]["rms_spread_um"].as_f64().unwrap() > 0.0, "{path}");
    }
}
