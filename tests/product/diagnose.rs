//! `diagnose` on logs of simulated machines with one known fault each: the fault is found within its interval, and rated.

use serde_json::Value;
use toml::{Table, Value as Setting};

use crate::common::{Folder, csv_files};
use crate::report::{data, section};

/// Length of the excitation, s.
const SECONDS: &str = "16";

/// `ballscrew` without its z axis and without faults: complete feed-forward, equal loops, little friction, no backlash, no cogging.
fn sound() -> Table {
    let mut machine: Table = include_str!("../../machine/machines/ballscrew.toml").parse().unwrap();
    machine["axes"].as_array_mut().unwrap().truncate(2);
    for (part, key) in [("motor", "cogging"), ("friction", "waves"), ("friction", "screw_waves")] {
        machine["drive"][part].as_table_mut().unwrap().insert(key.to_owned(), Setting::Array(Vec::new()));
    }
    for axis in ["x", "y"] {
        set(&mut machine, axis, "loops", "position_gain_1_s", 100.0);
        set(&mut machine, axis, "loops", "feed_forward", 1.0);
        set(&mut machine, axis, "screw", "backlash_half_width_um", 0.0);
        set(&mut machine, axis, "friction", "coulomb_n", 20.0);
        set(&mut machine, axis, "friction", "static_n", 26.0);
    }
    machine
}

fn set(machine: &mut Table, axis: &str, part: &str, key: &str, value: f64) {
    let axes = machine["axes"].as_array_mut().unwrap();
    let of_axis = axes.iter_mut().find(|known| known["name"].as_str() == Some(axis)).unwrap();
    of_axis["drive"][part].as_table_mut().unwrap().insert(key.to_owned(), Setting::Float(value));
}

/// Deflection of the loops without integrator by a force on axis y, µm: `F / (M ω_b Kv)`, the velocity gain per turn being `M ω_b (lead/2π)²`.
fn deflection_um(force_n: f64) -> f64 {
    let per_rad = 5e-3 / std::f64::consts::TAU;
    1e6 * force_n * per_rad * per_rad / (0.36 * 100.0)
}

/// Logs of the excitation of a machine, in a folder.
fn logged(machine: &Table) -> (Folder, Vec<String>) {
    let folder = Folder::new();
    folder.write("machine.toml", machine.to_string());
    folder.figures(&["excite", "--machine", "machine.toml", "-o", "excitation", "--seconds", SECONDS]);
    let mut logs = Vec::new();
    for path in csv_files(&folder.path("excitation")) {
        logs.push(format!("log-{}", path.file_name().unwrap().to_string_lossy()));
        let (reference, seed) = (path.to_string_lossy().into_owned(), logs.len().to_string());
        folder.figures(&["simulate", &reference, "--machine", "machine.toml", "-o", logs.last().unwrap(), "--seed", &seed]);
    }
    (folder, logs)
}

/// The words of `diagnose` on all logs.
fn words<'a>(logs: &'a [String], more: &[&'a str]) -> Vec<&'a str> {
    ["diagnose"].into_iter().chain(logs.iter().map(String::as_str)).chain(more.iter().copied()).collect()
}

/// The finding of a quantity of an axis.
fn finding<'a>(figures: &'a Value, quantity: &str, axis: &str) -> &'a Value {
    let findings = figures["findings"].as_array().unwrap();
    findings.iter().find(|finding| finding["quantity"] == quantity && finding["axis"] == axis).unwrap()
}

/// The true value lies in the interval of the finding, and the interval says something.
fn holds(finding: &Value, truth: f64, widest: f64) {
    let [value, low, high] = ["value", "low", "high"].map(|key| finding["estimate"][key].as_f64().unwrap());
    assert!(low <= value && value <= high && (low..=high).contains(&truth), "{truth}: {finding}");
    assert!(high - low < widest, "{finding}");
}

#[test]
fn an_axis_that_lags_more_than_the_other() {
    let mut machine = sound();
    // (1 − 0.8) / 80 s.
    set(&mut machine, "y", "loops", "position_gain_1_s", 80.0);
    set(&mut machine, "y", "loops", "feed_forward", 0.8);
    let (folder, logs) = logged(&machine);
    let figures = folder.figures(&words(&logs, &["--machine", "machine.toml"]));
    assert_eq!(figures["sensor"], "motor");
    holds(finding(&figures, "following-lag", "y"), 2.5, 0.2);
    holds(finding(&figures, "following-lag", "x"), 0.0, 0.2);
    let mismatch = finding(&figures, "servo-mismatch", "x-y");
    holds(mismatch, -2.5, 0.3);
    assert_eq!(mismatch["verdict"], "poor");
    assert!(mismatch["remedy"].as_str().unwrap().contains("MD32200"), "{mismatch}");
    // What cannot be seen is said, with what to record.
    let pitch = finding(&figures, "pitch-error", "y");
    assert!(pitch["estimate"].is_null() && pitch["remedy"].as_str().unwrap().contains("laser"), "{pitch}");
    let backlash = finding(&figures, "backlash", "y");
    assert!(backlash["estimate"].is_null() && backlash["verdict"] == "not-observable", "{backlash}");
}

#[test]
fn a_missing_feed_forward_and_what_linuxcnc_should_set() {
    let mut machine = sound();
    ["x", "y"].iter().for_each(|axis| set(&mut machine, axis, "loops", "feed_forward", 0.0));
    let (folder, logs) = logged(&machine);
    let more = ["--sensor", "motor", "--controller", "linuxcnc", "-o", "suggestion.ini"];
    let figures = folder.figures(&words(&logs, &more));
    for axis in ["x", "y"] {
        let missing = finding(&figures, "velocity-feed-forward", axis);
        holds(missing, 0.0, 0.5);
        assert_eq!(missing["verdict"], "poor", "{missing}");
        holds(finding(&figures, "velocity-gain", axis), 100.0, 60.0);
    }
    let joint = &figures["linuxcnc"][1];
    assert_eq!((&joint["axis"], &joint["joint"]), (&Value::from("y"), &Value::from(1)));
    let first = &joint["settings"][0];
    assert_eq!(first["key"], "FF1", "{joint}");
    assert!((0.85..1.15).contains(&first["value"].as_f64().unwrap()), "{joint}");
    let (forecast, logged) = (first["forecast_um"].as_f64().unwrap(), joint["logged_um"].as_f64().unwrap());
    assert!(forecast < 0.2 * logged, "{joint}");
    let ini = folder.read("suggestion.ini");
    assert!(
        ini.contains("[JOINT_0]") && ini.contains("[JOINT_1]") && ini.contains("\nFF1 = ") && ini.contains("Review every line")
    );
    // A motor encoder does not show backlash: none is suggested.
    assert!(!ini.contains("\nBACKLASH = ") && ini.contains("# a motor encoder does not show backlash"), "{ini}");
}

#[test]
fn friction_of_one_axis() {
    let mut machine = sound();
    set(&mut machine, "y", "friction", "coulomb_n", 600.0);
    set(&mut machine, "y", "friction", "static_n", 780.0);
    let (folder, logs) = logged(&machine);
    let printed = folder.prints(&words(&logs, &["--sensor", "motor", "--json", "figures.json"]));
    let figures: Value = serde_json::from_str(&folder.read("figures.json")).unwrap();
    let friction = finding(&figures, "coulomb-friction", "y");
    holds(friction, deflection_um(600.0), 15.0);
    let effect = |axis: &str| finding(&figures, "coulomb-friction", axis)["effect_um"]["value"].as_f64().unwrap();
    assert!(effect("y") > 1.6 && effect("x") < 1.6 && effect("y") > 3.0 * effect("x"), "{} {}", effect("x"), effect("y"));
    assert_eq!(finding(&figures, "coulomb-friction", "x")["verdict"], "good");
    // The terminal names it with its interval and its verdict, and the source of the thresholds.
    let row = printed.lines().find(|line| line.starts_with(" Coulomb friction") && line.contains(" y ")).unwrap();
    assert!(row.contains(" … ") && row.contains(friction["verdict"].as_str().unwrap()), "{row}");
    assert!(printed.contains("ISO 286-1") && printed.contains("MD32500"), "{printed}");
    assert!(figures["thresholds"].as_str().unwrap().contains("1.6 µm"));
}

#[test]
fn backlash_behind_a_scale() {
    let mut machine = sound();
    machine.insert("sensor".to_owned(), Setting::String("table".to_owned()));
    set(&mut machine, "y", "screw", "backlash_half_width_um", 6.0);
    // Enough that the table does not coast through it.
    for axis in ["x", "y"] {
        set(&mut machine, axis, "friction", "coulomb_n", 200.0);
        set(&mut machine, axis, "friction", "static_n", 280.0);
    }
    let (folder, logs) = logged(&machine);
    let more = ["--machine", "machine.toml", "--controller", "linuxcnc", "--report", "page.html"];
    let figures = folder.figures(&words(&logs, &more));
    assert_eq!(figures["sensor"], "table");
    let backlash = finding(&figures, "backlash", "y");
    holds(backlash, 12.0, 24.0);
    assert_eq!(backlash["verdict"], "poor");
    assert!(finding(&figures, "backlash", "x")["estimate"]["value"].as_f64().unwrap() < 1.6);
    // Within the loop the scale closes it: no setting, but a note where it is certain.
    let joint = &figures["linuxcnc"][1];
    assert!(joint["settings"].as_array().unwrap().iter().all(|setting| setting["key"] != "BACKLASH"), "{joint}");
    if backlash["estimate"]["low"].as_f64().unwrap() > 0.0 {
        assert!(joint["note"].as_str().unwrap().contains("inside the loop"), "{joint}");
    }
    shows(&data(&folder, "page.html"), &figures);
}

/// The page holds the verdicts of the JSON, a picture for every finding that has one, and what is not observable.
fn shows(page: &Value, figures: &Value) {
    let findings = figures["findings"].as_array().unwrap();
    let count = |is: &dyn Fn(&Value) -> bool| findings.iter().filter(|finding| is(finding)).count();
    let rated = section(page, 0, "What the logs say about the machine");
    let is_rated = |finding: &Value| ["good", "fair", "poor"].iter().any(|verdict| finding["verdict"] == *verdict);
    assert_eq!(rated["rows"].as_array().unwrap().len(), count(&is_rated));
    assert_eq!(
        rated["verdicts"].as_array().unwrap().iter().filter(|verdict| **verdict == "poor").count(),
        count(&|f| f["verdict"] == "poor")
    );
    assert!(rated["note"].as_str().unwrap().contains("ISO 286-1"));
    let hidden = section(page, 0, "Not observable in these logs")["rows"].as_array().unwrap();
    assert_eq!(hidden.len(), count(&|finding| finding["estimate"].is_null()));
    let sections = page["groups"][0]["sections"].as_array().unwrap();
    let pictured = sections.iter().filter(|section| section["kind"] == "chart" || section["kind"] == "polar").count();
    assert_eq!(pictured, count(&|finding| !finding["picture"].is_null() && !finding["estimate"].is_null()));
    let circle = section(page, 0, "Servo mismatch: x-y: radial deviation on the test circle by the mismatch");
    assert_eq!((&circle["plane"][0], &circle["plane"][1]), (&Value::from("X"), &Value::from("Y")));
    let settings = section(page, 0, "Suggested settings of LinuxCNC")["rows"].as_array().unwrap();
    assert!(settings[0][0] == "JOINT_0 (x)" && settings.iter().any(|row| row[0] == "JOINT_1 (y)"), "{settings:?}");
}

#[test]
fn wrong_input_is_refused_with_its_reason() {
    let folder = Folder::new();
    folder.figures(&["simulate", "curve:circle", "-o", "circle.csv"]);
    folder.fails(2, &["diagnose"]);
    assert!(folder.fails(2, &["diagnose", "missing.csv"]).contains("missing.csv"));
    assert!(folder.fails(2, &["diagnose", "circle.csv", "--sensor", "thumb"]).contains("motor, table"));
    assert!(folder.fails(2, &["diagnose", "circle.csv", "-o", "x.ini"]).contains("--controller"));
    let over = ["diagnose", "circle.csv", "--controller", "linuxcnc", "-o", "circle.csv"];
    assert!(folder.fails(2, &over).contains("would write over"));
    folder.write("text.csv", "t,x_ref,x_act\n0,1,2\n0.002,one,2\n");
    let said = folder.fails(1, &["diagnose", "text.csv"]);
    assert!(said.contains("text.csv") && said.contains("line 3"), "{said}");
    // Nothing moves.
    let rest: String = (0..2000).map(|k| format!("{:.3},5.0,5.0\n", 0.002 * f64::from(k))).collect();
    folder.write("rest.csv", format!("t,x_ref,x_act\n{rest}"));
    folder.fails(1, &["diagnose", "rest.csv"]);
    // Logs of different rates.
    let line = |k: i32, period: f64| {
        let t = period * f64::from(k);
        format!("{t:.4},{:.6},{:.6}\n", 10.0 * (3.0 * t).sin(), 9.99 * (3.0 * (t - 0.004)).sin())
    };
    for (name, period) in [("slow.csv", 0.002), ("fast.csv", 0.001)] {
        folder.write(name, format!("t,x_ref,x_act\n{}", (0..5000).map(|k| line(k, period)).collect::<String>()));
    }
    assert!(folder.fails(1, &["diagnose", "slow.csv", "fast.csv"]).contains("record all logs at one rate"));
}
