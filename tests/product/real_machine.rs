//! Which machine a user's program is planned for, where a log of a real machine is read.

use crate::common::{Folder, text};

const PART: &str =
    "G21 G90 G17\nG0 X0 Y0 Z5\nG1 Z0 F600\nG1 X30 F2400\nG3 X30 Y20 J10\nG0 Z5\nG0 X-40\nG1 Z0 F600\nG1 Y0 F2400\nM30\n";

fn folder_with_run() -> Folder {
    let folder = Folder::new();
    std::fs::write(folder.path("part.nc"), PART).unwrap();
    folder.figures(&["simulate", "part.nc", "-o", "run.csv"]);
    folder
}

#[test]
fn a_users_program_is_never_planned_for_a_built_in_machine_in_silence() {
    let folder = folder_with_run();
    for words in [
        &["measure", "run.csv", "--desired", "part.nc"][..],
        &["measure", "run.csv", "--desired", "curve:circle"],
        &["refine", "part.nc", "--log", "run.csv", "-o", "next.nc"],
    ] {
        let said = folder.fails(2, words);
        assert!(said.contains("--machine") && said.contains("--model"), "{said}");
    }
    assert!(!folder.path("next.nc").exists());
    // A log's own command needs no machine, neither does a reference.
    folder.figures(&["measure", "run.csv"]);
}

#[test]
fn the_machine_that_was_used_is_named() {
    let folder = folder_with_run();
    folder.figures(&["simulate", "curve:crown", "-o", "crown.csv"]);
    folder.figures(&["train", "crown.csv", "--machine", "ballscrew", "--predictor", "linear", "-o", "mill.model"]);
    let said = |words: &[&str]| {
        let output = folder.precomp(words);
        assert!(output.status.success(), "{words:?}: {}", text(&output.stderr));
        text(&output.stdout)
    };
    let by_model = said(&["measure", "run.csv", "--desired", "part.nc", "-m", "mill.model"]);
    assert!(by_model.contains("from the model mill.model"), "{by_model}");
    let by_name = said(&["measure", "run.csv", "--desired", "part.nc", "-m", "mill.model", "--machine", "ballscrew"]);
    assert!(by_name.contains("from --machine ballscrew"), "{by_name}");
    let refined = said(&["refine", "part.nc", "--log", "run.csv", "-m", "mill.model", "-o", "next.nc"]);
    assert!(refined.contains("from the model mill.model") && folder.path("next.nc").exists(), "{refined}");
    let simulated = said(&["simulate", "part.nc", "-o", "again.csv"]);
    assert!(simulated.contains("on the machine `"), "{simulated}");
}

#[test]
fn rapids_are_no_worst_places() {
    let folder = folder_with_run();
    let figures = folder.figures(&["measure", "run.csv", "--desired", "part.nc", "--machine", "ballscrew"]);
    let max = figures["contour_um"]["max"].as_f64().unwrap();
    let worst = figures["worst"].as_array().unwrap();
    assert!(worst.iter().all(|place| place["um"].as_f64().unwrap() <= max), "{figures}");
    assert!((worst[0]["um"].as_f64().unwrap() - max).abs() < 1e-9, "{figures}");
    let lines: Vec<u64> = figures["segments"].as_array().unwrap().iter().map(|one| one["line"].as_u64().unwrap()).collect();
    assert_eq!(lines, [3, 4, 5, 8, 9]);
}
