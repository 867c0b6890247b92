//! `check`: every fault by name, and none where there is none.

use datasets::{Log, write_log};
use machine::MachineSpec;
use pipeline::excitation::{TRAVEL_MM, record};
use serde_json::Value;

use crate::common::{Folder, shared};

type Columns = Vec<Vec<f64>>;

/// Twenty seconds of a simulated machine.
fn recorded() -> Vec<Log> {
    record(&MachineSpec::builtin("ballscrew").unwrap(), 20.0, TRAVEL_MM, 3).unwrap()
}

/// The longest of its logs.
fn healthy() -> Log {
    recorded().into_iter().max_by_key(Log::len).unwrap()
}

/// The log with a fault.
fn hurt(log: &Log, change: impl FnOnce(&mut Columns, &mut Columns)) -> Log {
    let (mut reference, mut actual) = (log.reference.columns().to_vec(), log.actual.columns().to_vec());
    change(&mut reference, &mut actual);
    Log::new("run", log.reference.with_columns(reference).unwrap(), log.actual.with_columns(actual).unwrap()).unwrap()
}

/// What `check` finds in files: the verdict, and the findings of a severity above a note with their checks. That one log is little is none.
fn found(folder: &Folder, files: &str) -> (String, Vec<(String, String)>) {
    let words: Vec<&str> = ["check"].into_iter().chain(files.split(' ')).chain(["--json", "figures.json"]).collect();
    let output = folder.precomp(&words);
    let figures: Value = serde_json::from_slice(&std::fs::read(folder.path("figures.json")).unwrap()).unwrap();
    let verdict = figures["verdict"].as_str().unwrap().to_owned();
    assert_eq!(output.status.code(), Some(i32::from(verdict == "unfit")), "{figures:#}");
    let text = |value: &Value| value.as_str().unwrap().to_owned();
    let of_files = figures["logs"].as_array().unwrap().iter().flat_map(|log| log["findings"].as_array().unwrap());
    let findings = of_files.chain(figures["findings"].as_array().unwrap()).filter(|finding| finding["severity"] != "note");
    let mut findings: Vec<_> = findings.map(|finding| (text(&finding["check"]), text(&finding["message"]))).collect();
    findings.retain(|(check, _)| check != "runs");
    findings.extend(figures["unread"].as_array().unwrap().iter().map(|error| ("unread".to_owned(), text(error))));
    (verdict, findings)
}

fn found_in(folder: &Folder, log: &Log) -> (String, Vec<(String, String)>) {
    write_log(&folder.path("run.csv"), log).unwrap();
    found(folder, "run.csv")
}

fn assert_unfit(what: (String, Vec<(String, String)>), check: &str, message: &str) {
    let (verdict, findings) = what;
    assert!(findings.iter().any(|(of, text)| of == check && text.contains(message)), "{message}: {findings:#?}");
    assert_eq!(verdict, "unfit", "{findings:#?}");
}

#[test]
fn a_log_that_training_finds_too_short_is_not_fit() {
    let folder = Folder::new();
    let log = healthy();
    let rows = (1.5 / log.period_s()) as usize;
    let short = log.part("run", 1000, 1000 + rows).unwrap();
    assert_unfit(found_in(&folder, &short), "rate", "2.5 s are needed to hold a part of it out");
}

#[test]
fn a_log_without_fault_is_fit_and_its_columns_are_told() {
    let folder = Folder::new();
    let logs = recorded();
    let names: Vec<String> = (0..logs.len()).map(|index| format!("run-{index}.csv")).collect();
    logs.iter().zip(&names).for_each(|(log, name)| write_log(&folder.path(name), log).unwrap());
    let (verdict, findings) = found(&folder, &names.join(" "));
    assert_eq!((verdict.as_str(), findings), ("fit", Vec::new()));
    write_log(&folder.path("run.csv"), &healthy()).unwrap();
    let text = folder.read("run.csv").replacen("t,x_ref,x_act", "time [s],x_cmd_mm,xEncoder (mm)", 1);
    folder.write("other.csv", text);
    let printed = folder.prints(&["check", "other.csv"]);
    let line = |words: [&str; 3]| printed.lines().any(|line| words.iter().all(|word| line.contains(word)));
    assert!(line(["time [s]", " time ", " s "]), "{printed}");
    assert!(line(["x_cmd_mm", "x commanded", "mm"]) && line(["xEncoder (mm)", "x actual", "mm"]), "{printed}");
    assert!(line(["x  ", "█", "-36.319 to 0.000 mm"]) && line(["command − actual", "▁", "µm RMS"]), "{printed}");
    assert!(printed.ends_with("verdict: fit for training, with the warnings above\n"), "{printed}");
}

#[test]
fn every_fault_is_named() {
    let (folder, log) = (Folder::new(), healthy());
    let of = |change: fn(&mut Columns, &mut Columns)| found_in(&folder, &hurt(&log, change));
    assert_unfit(of(std::mem::swap), "pairing", "the two columns are swapped");
    assert_unfit(of(|_, actual| actual.swap(0, 1)), "pairing", "exchanged");
    assert_unfit(of(|_, actual| actual[1].iter_mut().for_each(|x| *x = -*x)), "pairing", "wrong sign");
    assert_unfit(of(|_, actual| actual[0].iter_mut().for_each(|x| *x /= 25.4)), "units", "inch against mm");
    let (verdict, findings) = of(|_, actual| actual[2].iter_mut().for_each(|x| *x += 4.0));
    assert!(
        verdict == "fit with warnings" && findings.iter().any(|found| found.1.contains("training takes this offset off")),
        "{findings:?}"
    );
    assert_unfit(of(|_, actual| actual[0].iter_mut().for_each(|x| *x = (*x * 10.0).round() / 10.0)), "digits", "steps of 0.1 mm");
    assert_unfit(of(|reference, actual| actual[0].clone_from(&reference[0])), "copied", "a copy of it");
    let (verdict, findings) = of(|_, actual| actual[1].fill(3.0));
    let told =
        |(check, text): &(String, String)| check == "mended" && text.starts_with("axis y is left out: the command travels");
    assert!(verdict == "fit with warnings" && findings.iter().any(told), "{findings:#?}");
    let saturated = |_: &mut Columns, actual: &mut Columns| {
        let most = actual[1].iter().copied().fold(0.0, f64::max);
        actual[1].iter_mut().for_each(|y| *y = y.min(0.5 * most));
    };
    assert_unfit(of(saturated), "dropout", "repeat one value");
    let still = |reference: &mut Columns, actual: &mut Columns| {
        reference[2].fill(1.0);
        actual[2].fill(1.0);
    };
    let (verdict, findings) = of(still);
    assert_eq!((verdict.as_str(), findings), ("fit with warnings", Vec::new()));
    let printed = folder.prints(&["check", "run.csv"]);
    assert!(printed.contains("z_ref: the axis never moves"), "{printed}");
}

#[test]
fn angles_in_degrees_are_told_from_radians() {
    let (folder, log) = (Folder::new(), healthy());
    let turned = hurt(&log, |reference, actual| {
        for (column, scale) in [(&mut reference[0], 0.01), (&mut actual[0], 0.01_f64.to_degrees())] {
            column.iter_mut().for_each(|x| *x *= scale);
        }
    });
    write_log(&folder.path("mm.csv"), &turned).unwrap();
    folder.write("a.csv", folder.read("mm.csv").replacen("x_ref,x_act", "a_ref,a_act", 1));
    assert_unfit(found(&folder, "a.csv"), "units", "radians against degrees");
}

#[test]
fn faults_of_the_clock_are_named() {
    let (folder, log) = (Folder::new(), healthy());
    write_log(&folder.path("run.csv"), &log).unwrap();
    let text = folder.read("run.csv");
    let rows: Vec<&str> = text.lines().collect();
    let mut back = rows.clone();
    back.swap(500, 900);
    folder.write("back.csv", back.join("\n") + "\n");
    let (verdict, findings) = found(&folder, "back.csv");
    assert!(verdict == "unfit" && findings.iter().any(|(_, text)| text.contains("does not come after")), "{findings:#?}");
}

#[test]
fn a_gap_makes_two_runs() {
    let Some(emps) = shared("logs/emps_train_1kHz.csv") else { return };
    let (folder, text) = (Folder::new(), std::fs::read_to_string(emps).unwrap());
    let rows: Vec<&str> = text.lines().collect();
    folder.write("gap.csv", [&rows[..12_001], &rows[12_061..]].concat().join("\n") + "\n");
    let (verdict, findings) = found(&folder, "gap.csv");
    assert_eq!(verdict, "fit", "{findings:#?}");
    let printed = folder.prints(&["check", "gap.csv"]);
    let told = ["gap part 1: CSV, 12000 rows", "gap part 2: CSV, 12781 rows", "after line 12001: 60 rows are missing"];
    assert!(told.iter().all(|told| printed.contains(told)), "{printed}");
    let figures: Value = serde_json::from_slice(&std::fs::read(folder.path("figures.json")).unwrap()).unwrap();
    assert_eq!(figures["logs"].as_array().unwrap().len(), 2);
}

#[test]
fn a_file_that_cannot_be_read_does_not_hide_the_others() {
    let folder = Folder::new();
    write_log(&folder.path("run.csv"), &healthy()).unwrap();
    folder.write("bad.csv", "a,b\n1,2\n");
    let output = folder.precomp(&["check", "bad.csv", "run.csv"]);
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(1));
    assert!(printed.contains("refused: bad.csv") && printed.contains("x commanded"), "{printed}");
}

#[test]
fn real_logs_give_no_false_alarm() {
    let folder = Folder::new();
    for (name, wanted) in [
        ("emps_train_1kHz.csv", "fit"),
        ("emps_pulses_1kHz.csv", "fit"),
        ("ur5_no6_125Hz.csv", "fit with warnings"),
        ("ur5_no1_125Hz_jitter.csv", "fit with warnings"),
        ("michigan_experiment_11.csv", "unfit"),
    ] {
        let Some(path) = shared(&format!("logs/{name}")) else { return };
        let (verdict, findings) = found(&folder, &path.to_string_lossy());
        assert_eq!(verdict, wanted, "{name}: {findings:#?}");
    }
}
