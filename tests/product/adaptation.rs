//! A model on a machine of another build: it is reported as stale, and ten seconds of that machine's log bring most of it back.

use std::sync::LazyLock;

use serde_json::Value;

use crate::common::{BALLSCREW, Folder};

const AXES: [&str; 3] = ["x", "y", "z"];

/// The model of [`BALLSCREW`] adapted to the machine `maxwell`.
struct Adapted {
    model: Vec<u8>,
    /// What `train` reported.
    figures: Value,
}

static MAXWELL: LazyLock<Adapted> = LazyLock::new(|| {
    let folder = Folder::with_model();
    let mut words = vec!["train"];
    let logs = ["01-full", "03-sharp", "04-lines"];
    let logs: Vec<String> = (1..).zip(logs).map(|(seed, run)| log_of_another_machine(&folder, run, seed)).collect();
    words.extend(logs.iter().map(String::as_str));
    words.extend(["--from", "machine.model", "-o", "adapted.model"]);
    let figures = folder.figures(&words);
    Adapted { model: std::fs::read(folder.path("adapted.model")).unwrap(), figures }
});

/// Runs one of the excitation's references on `maxwell`; the name of the log.
fn log_of_another_machine(folder: &Folder, run: &str, seed: usize) -> String {
    let reference = format!("{run}.csv");
    let (_, content) = BALLSCREW.excitation.iter().find(|(name, _)| *name == reference).unwrap();
    folder.write(&reference, content);
    let log = format!("other-{run}.csv");
    folder.figures(&["simulate", &reference, "--machine", "maxwell", "-o", &log, "--seed", &seed.to_string()]);
    log
}

/// With the adapted model beside the one that it came from.
fn folder_with_both_models() -> Folder {
    let folder = Folder::with_model();
    folder.write("adapted.model", &MAXWELL.model);
    folder
}

#[test]
fn a_model_is_not_stale_on_its_own_machine() {
    let folder = Folder::with_model();
    folder.figures(&["simulate", "curve:crown", "-o", "own.csv", "--seed", "77"]);
    let own = folder.figures(&["measure", "own.csv", "-m", "machine.model"]);
    for axis in AXES {
        assert_eq!(own["model"][axis]["stale"], false, "{own}");
    }
}

#[test]
fn a_model_is_stale_on_another_machine() {
    let folder = Folder::with_model();
    let log = log_of_another_machine(&folder, "01-full", 1);
    let other = folder.figures(&["measure", &log, "-m", "machine.model"]);
    assert_eq!(other["model"]["x"]["stale"], true, "{other}");
}

#[test]
fn adaptation_halves_the_held_out_error_of_every_axis() {
    let adapted = &MAXWELL.figures;
    for axis in AXES {
        let figure = |key: &str| adapted["axes"][axis][key].as_f64().unwrap();
        assert!(figure("held_out_rms_um") < 0.5 * figure("before_rms_um"), "{adapted}");
    }
}

#[test]
fn the_held_out_error_is_what_the_adapted_model_leaves_of_an_unseen_run() {
    let (folder, adapted) = (folder_with_both_models(), &MAXWELL.figures);
    folder.figures(&["simulate", "curve:crown", "--machine", "maxwell", "-o", "unseen.csv", "--seed", "88"]);
    let unseen = folder.figures(&["measure", "unseen.csv", "-m", "adapted.model"]);
    for axis in AXES {
        let (left, held_out) = (unseen["model"][axis]["rms_um"].as_f64(), adapted["axes"][axis]["held_out_rms_um"].as_f64());
        assert!(left.unwrap() < 1.3 * held_out.unwrap(), "{unseen} {adapted}");
    }
}

#[test]
fn an_adapted_model_halves_the_error_of_the_first_run() {
    let folder = folder_with_both_models();
    let settings = ["--machine", "maxwell", "--runs", "1", "--gain", "0.8", "--low-pass", "100"];
    let compared = |model: &str| {
        let figures = folder.figures(&[&["compare", "curve:crown", "-m", model][..], &settings].concat());
        figures["paths"][0]["methods"]["first-run"]["rms_um"].as_f64().unwrap()
    };
    assert!(compared("adapted.model") < 0.5 * compared("machine.model"));
}

#[test]
fn a_model_that_was_adapted_with_seconds_states_what_it_expects() {
    let folder = Folder::with_model();
    let log = log_of_another_machine(&folder, "04-lines", 3);
    folder.figures(&["train", &log, "--from", "machine.model", "-o", "adapted.model"]);
    let forecast = folder.figures(&["predict", "curve:crown", "-m", "adapted.model"]);
    let expected = &forecast["expected_contour_um"]["rms"];
    assert!(expected["low"].as_f64() < expected["middle"].as_f64(), "{forecast}");
    assert!(expected["middle"].as_f64() > forecast["contour_um"]["rms"].as_f64(), "{forecast}");
}
