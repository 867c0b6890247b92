//! The whole story, by the command line: excite, log, train, compensate what training never saw, and see that it helped.

use crate::common::{Folder, shared, text};
use serde_json::Value;

fn rms(figures: &Value) -> f64 {
    figures["contour_um"]["rms"].as_f64().unwrap()
}

/// Lines, a helix, full and half circles, in a program as a user would write it.
const PART: &str = "%\r\nO0001 (BRACKET)\r\nN10 G21 G90 G17 G40 G49 G80\r\nN20 T1 M6\r\nN30 G0 G54 X-30. Y-20. S8000 M3\r\nN40 G0 Z5. (ABOVE)\r\n\
N50 G1 Z-1. F900 M8\r\nN60 G1 X30. F2400\r\nN70 G3 X30. Y20. I0. J20.\r\nN80 G1 X-30.\r\nN90 G3 X-30. Y-20. Z-3. J-20.\r\nN100 G2 I10. J10.\r\n\
N110 G0 Z5. M9\r\nN120 G81 X0. Y0. Z-5. R2. F100\r\nN130 G80\r\nN140 M30\r\n%\r\n";

#[test]
fn first_run_on_unseen_paths() {
    let folder = Folder::new();
    folder.train("40", "staged");

    // A reference.
    let before = folder.figures(&[
        "compare",
        "curve:five-petals",
        "-m",
        "machine.model",
        "--gain",
        "0.8",
        "--low-pass",
        "100",
        "--report",
        "report.html",
    ]);
    let methods = &before["paths"][0]["methods"];
    let figure = |method: &str| methods[method]["rms_um"].as_f64().unwrap();
    assert!(figure("first-run") < 0.15 * figure("uncompensated"), "{methods}");
    assert!(figure("one-shot") < 0.25 * figure("uncompensated"), "{methods}");
    assert!(figure("floor") < figure("first-run"), "{methods}");
    let page = std::fs::read_to_string(folder.path("report.html")).unwrap();
    assert!(page.len() < 1_000_000 && page.contains("five-petals") && !page.contains("http"));

    // A program.
    std::fs::write(folder.path("part.nc"), PART).unwrap();
    let made = folder.figures(&["compensate", "part.nc", "-m", "machine.model", "-o", "out.nc"]);
    assert_eq!(made["changed"], true);
    assert!(made["largest_shift_um"].as_f64().unwrap() < 100.0);
    let raw = folder.figures(&["simulate", "part.nc", "-o", "raw.csv"]);
    let cut = folder.figures(&["simulate", "out.nc", "--against", "part.nc", "-o", "cut.csv"]);
    assert!(rms(&cut) < 0.6 * rms(&raw), "{cut} against {raw}");
    let seconds = |figures: &Value| figures["seconds"].as_f64().unwrap();
    assert!(seconds(&cut) < 1.03 * seconds(&raw), "{cut} against {raw}");
    let out = std::fs::read_to_string(folder.path("out.nc")).unwrap();
    for kept in [
        "O0001 (BRACKET)\r\n",
        "N20 T1 M6\r\n",
        "N40 G0 Z5. (ABOVE)\r\n",
        "N110 G0 Z5. M9\r\n",
        "N120 G81 X0. Y0. Z-5. R2. F100\r\n",
    ] {
        assert!(out.contains(kept), "{kept:?}");
    }

    // A line to where the tool is already does not lead back to the point as programmed.
    let repeated = PART.replace("N60 G1 X30. F2400\r\n", "N60 G1 X30. F2400\r\nN65 G1 X30. Y-20.\r\n");
    std::fs::write(folder.path("repeated.nc"), repeated).unwrap();
    for carrier in ["keep", "g93", "g94"] {
        folder.figures(&["compensate", "repeated.nc", "-m", "machine.model", "-o", "r.nc", "--carrier", carrier]);
    }

    // Points that rounding puts on the one before are still lines with a word.
    folder.figures(&["compensate", "part.nc", "-m", "machine.model", "-o", "coarse.nc", "--decimals", "2", "--spacing", "1"]);

    // The same input, seed and version give the same bytes.
    folder.figures(&["compensate", "part.nc", "-m", "machine.model", "-o", "again.nc"]);
    assert_eq!(std::fs::read(folder.path("out.nc")).unwrap(), std::fs::read(folder.path("again.nc")).unwrap());

    // Nothing is written over the input, and a damaged model is refused.
    folder.fails(2, &["compensate", "part.nc", "-m", "machine.model", "-o", "part.nc"]);
    let mut model = std::fs::read(folder.path("machine.model")).unwrap();
    let middle = model.len() / 2;
    model[middle] ^= 1;
    std::fs::write(folder.path("bad.model"), model).unwrap();
    assert!(folder.fails(1, &["predict", "part.nc", "-m", "bad.model"]).contains("checksum"));

    // Far outside of what was trained, nothing is changed, and the command says where and why.
    let output = folder.precomp(&["compensate", "part.nc", "-m", "machine.model", "-o", "far.nc", "--work-offset", "5000,0,0"]);
    assert!(output.status.success());
    assert!(text(&output.stdout).contains("position of axis x lies outside"), "{}", text(&output.stdout));
    assert_eq!(std::fs::read(folder.path("far.nc")).unwrap(), PART.as_bytes());

    crate::feeds::slower_where_the_forecast_asks_for_it(&folder);
    crate::dwells::nothing_winds_up_at_a_standstill(&folder);
    crate::modes::stated_for_the_control_and_put_back(&folder);
    crate::modes::points_that_are_put_in_never_stop_the_control(&folder);
    crate::modes::what_is_not_understood_is_left_as_it_is(&folder);
    crate::modes::the_programs_own_change_within_a_stretch(&folder);
    crate::placed::what_depends_on_position_is_left_out_where_the_part_has_no_place(&folder);
    crate::placed::two_coordinate_systems_lie_each_at_its_own_place(&folder);
    crate::placed::runs_come_to_what_is_expected_of_them(&folder);
    crate::placed::report_and_terminal_give_the_same_figures(&folder);
    crate::recorded::a_recorded_command_is_gone_by_instead_of_the_plan(&folder);
    crate::rows::rows_carry_the_compensated_path(&folder);
    real_program(&folder);
    another_machine(&folder);
}

/// The model is stale on a machine of another build; ten seconds of its log bring most of it back.
fn another_machine(folder: &Folder) {
    folder.figures(&["simulate", "curve:crown", "-o", "own.csv", "--seed", "77"]);
    let own = folder.figures(&["measure", "own.csv", "-m", "machine.model"]);
    for axis in ["x", "y", "z"] {
        assert_eq!(own["model"][axis]["stale"], false, "{own}");
    }
    let mut logs = Vec::new();
    for (seed, run) in ["01-full", "03-sharp", "04-lines"].iter().enumerate() {
        let log = format!("other-{run}.csv");
        let (from, seed) = (format!("excitation/{run}.csv"), (seed + 1).to_string());
        folder.figures(&["simulate", &from, "--machine", "maxwell", "-o", &log, "--seed", &seed]);
        logs.push(log);
    }
    let other = folder.figures(&["measure", &logs[0], "-m", "machine.model"]);
    assert_eq!(other["model"]["x"]["stale"], true, "{other}");
    let mut words = vec!["train"];
    words.extend(logs.iter().map(String::as_str));
    words.extend(["--from", "machine.model", "-o", "adapted.model"]);
    let adapted = folder.figures(&words);
    for axis in ["x", "y", "z"] {
        let figure = |key: &str| adapted["axes"][axis][key].as_f64().unwrap();
        assert!(figure("held_out_rms_um") < 0.5 * figure("before_rms_um"), "{adapted}");
    }
    // What is printed as held out is what the adapted model leaves of a run that it has not seen.
    folder.figures(&["simulate", "curve:crown", "--machine", "maxwell", "-o", "unseen.csv", "--seed", "88"]);
    let unseen = folder.figures(&["measure", "unseen.csv", "-m", "adapted.model"]);
    for axis in ["x", "y", "z"] {
        let (left, held_out) = (unseen["model"][axis]["rms_um"].as_f64(), adapted["axes"][axis]["held_out_rms_um"].as_f64());
        assert!(left.unwrap() < 1.3 * held_out.unwrap(), "{unseen} {adapted}");
    }
    let compared = |model: &str| {
        let figures = folder.figures(&[
            "compare",
            "curve:crown",
            "-m",
            model,
            "--machine",
            "maxwell",
            "--runs",
            "1",
            "--gain",
            "0.8",
            "--low-pass",
            "100",
        ]);
        figures["paths"][0]["methods"]["first-run"]["rms_um"].as_f64().unwrap()
    };
    assert!(compared("adapted.model") < 0.5 * compared("machine.model"));
}

/// A production program: non-feed bytes the same, and the simulated machine follows it better.
fn real_program(folder: &Folder) {
    let Some(part) = shared("gcode/nist_plate_14.nc") else { return };
    let part = part.to_string_lossy().into_owned();
    let offset = ["--work-offset", "-40,40,0"];
    let words = [&["compensate", &part, "-m", "machine.model", "-o", "plate.nc"][..], &offset].concat();
    assert_eq!(folder.figures(&words)["changed"], true);
    let raw = rms(&folder.figures(&[&["simulate", &part, "-o", "raw.csv"][..], &offset].concat()));
    let cut = rms(&folder.figures(&[&["simulate", "plate.nc", "--against", &part, "-o", "cut.csv"][..], &offset].concat()));
    assert!(cut < raw, "{cut} µm against {raw} µm");
    let original = std::fs::read(&part).unwrap();
    let out = text(&std::fs::read(folder.path("plate.nc")).unwrap());
    for line in text(&original).lines().filter(|line| !line.contains(['X', 'Y', 'Z', 'F'])) {
        assert!(out.contains(line), "{line}");
    }
}

#[test]
fn real_logs() {
    let folder = Folder::new();
    let Some(emps) = shared("logs/emps_train_1kHz.csv") else { return };
    let figures = folder.figures(&["train", &emps.to_string_lossy(), "-o", "emps.model"]);
    let x = &figures["axes"]["x"];
    let held_out = x["held_out_rms_um"].as_f64().unwrap();
    assert!(held_out < 1.2, "{figures}");
    assert!(held_out <= x["linear_rms_um"].as_f64().unwrap(), "{figures}");
    // On every joint of an arm, some of which are little but lag, stages are shipped that hardly fall behind the linear law where they do not
    // beat it: the rows that judge a stage do not choose it.
    let Some(arm) = shared("logs/ur5_no6_125Hz.csv") else { return };
    let figures = folder.figures(&["train", &arm.to_string_lossy(), "-o", "arm.model"]);
    let joints = figures["axes"].as_object().unwrap();
    assert_eq!(joints.len(), 6);
    for (joint, held_out) in joints {
        let figure = |name: &str| held_out[name].as_f64().unwrap();
        assert!(figure("held_out_rms_urad") <= 1.1 * figure("linear_rms_urad"), "{joint}: {held_out}");
        assert!(figure("held_out_rms_urad") < figure("raw_rms_urad"), "{joint}: {held_out}");
    }
    let Some(michigan) = shared("logs/michigan_experiment_11.csv") else { return };
    let said = folder.fails(1, &["train", &michigan.to_string_lossy(), "-o", "no.model", "--period", "100"]);
    assert!(said.contains("10 Hz") || said.contains("digits"), "{said}");
    assert!(!folder.path("no.model").exists());
}

#[test]
fn the_demo_with_the_lstm_alone() {
    // Paper D's network on its features, nothing of precomp's own predictor: a quarter of the uncompensated error at most.
    let folder = Folder::new();
    let figures = folder.figures(&["demo", "--predictor", "lstm", "--seconds", "60", "--out", "demo"]);
    let mean = |method: &str| {
        let paths = figures["paths"].as_array().unwrap();
        paths.iter().map(|path| path["methods"][method]["rms_um"].as_f64().unwrap()).sum::<f64>() / paths.len() as f64
    };
    assert_eq!(figures["paths"].as_array().unwrap().len(), 4);
    assert!(mean("first-run") < 0.25 * mean("uncompensated"), "{figures}");
    assert!(mean("spatial-ilc") < 0.1 * mean("uncompensated"), "{figures}");
    assert!(folder.path("demo/report.html").exists() && folder.path("demo/machine.model").exists());
}
