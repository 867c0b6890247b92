//! Compensating from what a control commanded, where it plans otherwise than precomp. Works on the story's model.

use serde_json::Value;

use crate::common::{Folder, text};

const PART: &str =
    "G21 G90 G17\nG0 X0 Y0\nG4 P0.2\nG1 X30 F3600\nG3 X30 Y20 J10\nG1 X10\nG1 X0 Y10\nG4 P0.1\nG1 X8 Y4\nG1 X0 Y0\nM30\n";

/// Rows of a CSV file, without the header.
fn rows(folder: &Folder, name: &str) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(folder.path(name)).unwrap();
    text.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect()
}

fn write_rows(folder: &Folder, name: &str, header: &str, rows: impl Iterator<Item = Vec<f64>>) {
    let rows = rows.map(|row| row.iter().map(|value| format!("{value:.6}")).collect::<Vec<_>>().join(",") + "\n");
    std::fs::write(folder.path(name), format!("{header}\n{}", rows.collect::<String>())).unwrap();
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

pub fn a_recorded_command_is_gone_by_instead_of_the_plan(folder: &Folder) {
    std::fs::write(folder.path("recorded.nc"), PART).unwrap();
    let limits = include_str!("../../machine/machines/ballscrew.toml");
    let slower = limits.replace("acceleration_mm_s2 = 800.0", "acceleration_mm_s2 = 300.0");
    std::fs::write(folder.path("control.toml"), slower.replace("centripetal_mm_s2 = 565.0", "centripetal_mm_s2 = 200.0"))
        .unwrap();
    let compensate = |out: &str, more: &[&str]| -> Value {
        folder.figures(&[&["compensate", "recorded.nc", "-m", "machine.model", "-o", out][..], more].concat())
    };
    assert!(compensate("own.nc", &[])["reference"].is_null());
    for control in [Control { smoothed: 1 }, Control { smoothed: 15 }] {
        control.run(folder, "recorded.nc", "recorded.csv");
        let made = compensate("by-record.nc", &["--reference", "recorded.csv"]);
        let back = folder.figures(&["measure", "recorded.csv", "--desired", "recorded.nc", "-m", "machine.model", "--readback"]);
        assert_eq!(made["reference"], back);
        let differs = |key: &str| back[key].as_f64().unwrap();
        assert!(differs("commanded_s") > 1.1 * differs("planned_s"), "{back}");
        let [raw, own, recorded] = ["recorded.nc", "own.nc", "by-record.nc"].map(|program| control.error_um(folder, program));
        println!("smoothed over {}: {raw:.2} µm raw, {own:.2} by our plan, {recorded:.2} by the record", control.smoothed);
        assert!(recorded < 0.85 * own && recorded < 0.4 * raw, "{raw} {own} {recorded}");
    }
    the_record_may_be_late_shifted_coarse_and_of_another_rate(folder);
    what_is_no_record_of_the_program_is_refused(folder);
}

fn shift_um(figures: &Value) -> f64 {
    figures["largest_shift_um"].as_f64().unwrap()
}

fn the_record_may_be_late_shifted_coarse_and_of_another_rate(folder: &Folder) {
    const HEADER: &str = "t,x_ref,x_act,y_ref,y_act,z_ref,z_act";
    let whole = rows(folder, "recorded.csv");
    let compensate = |log: &str, more: &[&str]| {
        let words = ["compensate", "recorded.nc", "-m", "machine.model", "-o", "other.nc", "--reference", log];
        let output = folder.precomp(&[&words[..], more].concat());
        assert!(output.status.success(), "{}", text(&output.stderr));
        text(&output.stdout)
    };
    let wanted = shift_um(&folder.figures(&[
        "compensate",
        "recorded.nc",
        "-m",
        "machine.model",
        "-o",
        "w.nc",
        "--reference",
        "recorded.csv",
    ]));
    let near = |name: &str, more: &[&str]| {
        let found = shift_um(&folder.figures(
            &[&["compensate", "recorded.nc", "-m", "machine.model", "-o", "w.nc", "--reference", name][..], more].concat(),
        ));
        assert!((found - wanted).abs() < 0.1 * wanted, "{name}: {found} for {wanted}");
    };
    // 4 ms a sample, and the axes in another order.
    let slow = whole.iter().step_by(2).map(|r| vec![r[0], r[3], r[4], r[1], r[2], r[5], r[6]]);
    write_rows(folder, "slow.csv", "t,y_ref,y_act,x_ref,x_act,z_ref,z_act", slow);
    assert!(compensate("slow.csv", &[]).contains("sampled every 4.000 ms, resampled onto a uniform grid of 2.000 ms"));
    near("slow.csv", &[]);
    // 60 ms later, elsewhere on the machine by a tenth of a millimetre, and rounded to 1 µm: waits stay waits.
    let rounded = |value: f64| (value * 1e3).round() * 1e-3;
    let late = (0..whole.len() + 30).map(|k| {
        let row = &whole[k.saturating_sub(30)];
        let moved = |axis: usize, by: f64| [rounded(row[1 + 2 * axis]) + by, row[2 + 2 * axis] + by];
        [vec![k as f64 * 0.002], moved(0, 0.1).into(), moved(1, -0.2).into(), moved(2, 0.0).into()].concat()
    });
    write_rows(folder, "late.csv", HEADER, late);
    near("late.csv", &[]);
    near("late.csv", &["--carrier", "g93"]);
}

fn what_is_no_record_of_the_program_is_refused(folder: &Folder) {
    let words = |log: &'static str| ["compensate", "recorded.nc", "-m", "machine.model", "-o", "no.nc", "--reference", log];
    let refuses = |log: &'static str, why: &str| {
        let said = folder.fails(1, &words(log));
        assert!(said.contains(why), "{log}: {said}");
    };
    let whole = rows(folder, "recorded.csv");
    let header = "t,x_ref,x_act,y_ref,y_act,z_ref,z_act";
    std::fs::write(folder.path("other.nc"), PART.replace("X10", "X12")).unwrap();
    folder.figures(&["simulate", "other.nc", "-o", "other-run.csv"]);
    refuses("other-run.csv", "is not the log of a run of recorded.nc");
    std::fs::write(folder.path("near.nc"), PART.replace("X10", "X10.4")).unwrap();
    folder.figures(&["simulate", "near.nc", "-o", "near-run.csv"]);
    refuses("near-run.csv", "the log is of another program");
    write_rows(folder, "half.csv", header, whole.iter().take(whole.len() / 2).cloned());
    refuses("half.csv", "is not the log of a run of recorded.nc");
    write_rows(folder, "begun.csv", header, whole.iter().skip(190).cloned());
    refuses("begun.csv", "recorded.nc");
    write_rows(folder, "no-z.csv", "t,x_ref,x_act,y_ref,y_act", whole.iter().map(|row| row[..5].to_vec()));
    refuses("no-z.csv", "has no columns of the linear axis z; its axes are x y");
    std::fs::write(folder.path("path.csv"), std::fs::read(folder.path("command.csv")).unwrap()).unwrap();
    let reference = ["compensate", "path.csv", "-m", "machine.model", "-o", "no.csv", "--reference", "recorded.csv"];
    assert!(folder.fails(2, &reference).contains("a reference is the command itself"));
    folder.fails(2, &[&words("recorded.csv")[..], &["--tolerance", "2um"]].concat());
    folder.fails(2, &words("none.csv"));
    assert!(!folder.path("no.nc").exists() && !folder.path("no.csv").exists());
}
