//! Compensating from what a control commanded, where it plans otherwise than precomp.

use serde_json::Value;

use crate::common::Folder;

const PART: &str =
    "G21 G90 G17\nG0 X0 Y0\nG4 P0.2\nG1 X30 F3600\nG3 X30 Y20 J10\nG1 X10\nG1 X0 Y10\nG4 P0.1\nG1 X8 Y4\nG1 X0 Y0\nM30\n";

/// Rows of a CSV file, without the header.
fn rows(folder: &Folder, name: &str) -> Vec<Vec<f64>> {
    let text = folder.read(name);
    text.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect()
}

fn write_rows(folder: &Folder, name: &str, header: &str, rows: impl Iterator<Item = Vec<f64>>) {
    let rows = rows.map(|row| row.iter().map(|value| format!("{value:.6}")).collect::<Vec<_>>().join(",") + "\n");
    folder.write(name, format!("{header}\n{}", rows.collect::<String>()));
}

/// A control with other limits, which rounds corners further off and smooths its command over so many samples; the machine is the same.
struct Control {
    smoothed: usize,
}

impl Control {
    fn run(&self, folder: &Folder, program: &str, log: &str) {
        let limits = ["--machine", "control.toml", "--corner-tolerance", "0.01"];
        folder.figures(&[&["simulate", program, "-o", "plan.csv"][..], &limits].concat());
        let plan = rows(folder, "plan.csv");
        let at = |k: usize, axis: usize| plan[k.saturating_sub(self.smoothed).min(plan.len() - 1)][1 + 2 * axis];
        let mean = |k: usize, axis: usize| (k..k + self.smoothed).map(|k| at(k, axis)).sum::<f64>() / self.smoothed as f64;
        let command = (0..plan.len() + self.smoothed).map(|k| vec![k as f64 * 0.002, mean(k, 0), mean(k, 1), mean(k, 2)]);
        write_rows(folder, "command.csv", "t,x,y,z", command);
        folder.figures(&["simulate", "command.csv", "-o", log, "--seed", "7"]);
    }

    /// Contour error RMS of a run of `program`, µm.
    fn error_um(&self, folder: &Folder, program: &str) -> f64 {
        self.run(folder, program, "run.csv");
        folder.figures(&["measure", "run.csv", "--desired", "recorded.nc", "--machine", "ballscrew"])["contour_um"]["rms"]
            .as_f64()
            .unwrap()
    }
}

const HEADER: &str = "t,x_ref,x_act,y_ref,y_act,z_ref,z_act";
const CONTROLS: [Control; 2] = [Control { smoothed: 1 }, Control { smoothed: 15 }];

/// A folder with the model, `recorded.nc`, the machine file of the control and the log of its run, `recorded.csv`.
fn folder_with_record(control: &Control) -> Folder {
    let folder = Folder::with_model();
    folder.write("recorded.nc", PART);
    let limits = include_str!("../../machine/machines/ballscrew.toml");
    let slower = limits.replace("acceleration_mm_s2 = 800.0", "acceleration_mm_s2 = 300.0");
    folder.write("control.toml", slower.replace("centripetal_mm_s2 = 565.0", "centripetal_mm_s2 = 200.0"));
    control.run(&folder, "recorded.nc", "recorded.csv");
    folder
}

/// Compensates `recorded.nc`; the figures.
fn compensate(folder: &Folder, out: &str, options: &[&str]) -> Value {
    folder.figures(&[&["compensate", "recorded.nc", "-m", "machine.model", "-o", out][..], options].concat())
}

#[test]
fn a_program_compensated_from_its_recorded_command_runs_closer_than_one_from_the_planned_command() {
    for control in CONTROLS {
        let folder = folder_with_record(&control);
        compensate(&folder, "own.nc", &[]);
        let told = compensate(&folder, "by-record.nc", &["--reference", "recorded.csv"]);
        let [raw, own, recorded] = ["recorded.nc", "own.nc", "by-record.nc"].map(|program| control.error_um(&folder, program));
        println!("smoothed over {}: {raw:.2} µm raw, {own:.2} by our plan, {recorded:.2} by the record", control.smoothed);
        assert!(recorded < 0.85 * own && recorded < 0.4 * raw, "{raw} {own} {recorded}");
        // The forecast is of what the control makes of the compensated points, its rounded corners included. With short lines it rounds them less.
        let [before, told] = ["before", "after"].map(|key| told["predicted_contour_um"][key]["rms"].as_f64().unwrap());
        println!("told {before:.2} -> {told:.2} µm");
        assert!((before / raw - 1.0).abs() < 0.15, "{before} {raw}");
        assert!(told < 2.2 * recorded && told > 0.7 * recorded, "{told} {recorded}");
    }
}

#[test]
fn compensation_reports_the_readback_of_its_record() {
    for control in CONTROLS {
        let folder = folder_with_record(&control);
        let made = compensate(&folder, "by-record.nc", &["--reference", "recorded.csv"]);
        let back = folder.figures(&["measure", "recorded.csv", "--desired", "recorded.nc", "-m", "machine.model", "--readback"]);
        assert_eq!(made["reference"], back);
        let differs = |key: &str| back[key].as_f64().unwrap();
        assert!(differs("commanded_s") > 1.1 * differs("planned_s"), "{back}");
    }
}

#[test]
fn compensation_without_a_record_reports_no_readback() {
    let folder = Folder::with_model();
    folder.write("recorded.nc", PART);
    assert!(compensate(&folder, "own.nc", &[])["reference"].is_null());
}

/// Asserts that a log serves as well as the record that it was made from: programs by both leave the same error in their runs on `control`, within
/// a tenth.
fn assert_serves(control: &Control, folder: &Folder, log: &str, options: &[&str]) {
    let left_um = |log: &str, options: &[&str]| {
        compensate(folder, "w.nc", &[&["--reference", log][..], options].concat());
        control.error_um(folder, "w.nc")
    };
    let (wanted, found) = (left_um("recorded.csv", options), left_um(log, options));
    println!("{log} {options:?}: {found:.3} for {wanted:.3} µm");
    assert!((found - wanted).abs() < 0.1 * wanted, "{log}: {found} for {wanted}");
}

#[test]
fn a_record_of_another_rate_with_axes_in_another_order_is_resampled() {
    let folder = folder_with_record(&CONTROLS[1]);
    // 4 ms a sample.
    let slow = rows(&folder, "recorded.csv").into_iter().step_by(2).map(|r| vec![r[0], r[3], r[4], r[1], r[2], r[5], r[6]]);
    write_rows(&folder, "slow.csv", "t,y_ref,y_act,x_ref,x_act,z_ref,z_act", slow);
    let words = ["compensate", "recorded.nc", "-m", "machine.model", "-o", "other.nc", "--reference", "slow.csv"];
    assert!(folder.prints(&words).contains("sampled every 4.000 ms, resampled onto a uniform grid of 2.000 ms"));
    assert_serves(&CONTROLS[1], &folder, "slow.csv", &[]);
}

#[test]
fn a_record_may_be_late_shifted_and_coarse() {
    let folder = folder_with_record(&CONTROLS[1]);
    let whole = rows(&folder, "recorded.csv");
    // 60 ms later, elsewhere on the machine by a tenth of a millimetre, and rounded to 1 µm: waits stay waits.
    let rounded = |value: f64| (value * 1e3).round() * 1e-3;
    let late = (0..whole.len() + 30).map(|k| {
        let row = &whole[k.saturating_sub(30)];
        let moved = |axis: usize, by: f64| [rounded(row[1 + 2 * axis]) + by, row[2 + 2 * axis] + by];
        [vec![k as f64 * 0.002], moved(0, 0.1).into(), moved(1, -0.2).into(), moved(2, 0.0).into()].concat()
    });
    write_rows(&folder, "late.csv", HEADER, late);
    assert_serves(&CONTROLS[1], &folder, "late.csv", &[]);
    assert_serves(&CONTROLS[1], &folder, "late.csv", &["--format", "g93"]);
}

/// Words that compensate `recorded.nc` from a log, into `no.nc`.
fn from_log(log: &str) -> [&str; 8] {
    ["compensate", "recorded.nc", "-m", "machine.model", "-o", "no.nc", "--reference", log]
}

fn assert_refused(folder: &Folder, log: &str, why: &str) {
    let said = folder.fails(1, &from_log(log));
    assert!(said.contains(why), "{log}: {said}");
    assert!(!folder.path("no.nc").exists());
}

#[test]
fn a_log_of_another_program_is_refused() {
    let folder = Folder::with_model();
    folder.write("recorded.nc", PART);
    folder.write("other.nc", PART.replace("X10", "X12"));
    folder.figures(&["simulate", "other.nc", "-o", "other-run.csv"]);
    assert_refused(&folder, "other-run.csv", "is not the log of a run of recorded.nc");
    folder.write("near.nc", PART.replace("X10", "X10.4"));
    folder.figures(&["simulate", "near.nc", "-o", "near-run.csv"]);
    assert_refused(&folder, "near-run.csv", "the log is of another program");
}

#[test]
fn a_log_without_the_whole_run_or_without_an_axis_is_refused() {
    let folder = folder_with_record(&CONTROLS[1]);
    let whole = rows(&folder, "recorded.csv");
    write_rows(&folder, "half.csv", HEADER, whole.iter().take(whole.len() / 2).cloned());
    assert_refused(&folder, "half.csv", "is not the log of a run of recorded.nc");
    write_rows(&folder, "begun.csv", HEADER, whole.iter().skip(190).cloned());
    assert_refused(&folder, "begun.csv", "recorded.nc");
    write_rows(&folder, "no-z.csv", "t,x_ref,x_act,y_ref,y_act", whole.iter().map(|row| row[..5].to_vec()));
    assert_refused(&folder, "no-z.csv", "has no columns of the linear axis z; its axes are x y");
}

#[test]
fn a_record_goes_with_a_program_without_tolerance_only() {
    let folder = folder_with_record(&CONTROLS[1]);
    let reference = ["compensate", "command.csv", "-m", "machine.model", "-o", "no.csv", "--reference", "recorded.csv"];
    assert!(folder.fails(2, &reference).contains("a reference is the command itself"));
    folder.fails(2, &[&from_log("recorded.csv")[..], &["--tolerance", "2um"]].concat());
    assert!(!folder.path("no.nc").exists() && !folder.path("no.csv").exists());
}

#[test]
fn a_missing_record_is_refused() {
    let folder = Folder::with_model();
    folder.write("recorded.nc", PART);
    folder.fails(2, &from_log("none.csv"));
    assert!(!folder.path("no.nc").exists());
}
