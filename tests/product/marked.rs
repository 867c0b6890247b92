//! The comment by which a compensated program is known again.

use crate::common::{Folder, text};

const PART: &str = "%\nO0001 (PLATE)\nG21 G90 G94 G17\nG0 X0 Y0 Z0\nG1 X20 F2400\nG3 X20 Y20 J10\nG1 X0\nG1 Y0\nM30\n%\n";

/// A folder with the model, `part.nc`, and what `compensate` makes of it, `out.nc`.
fn folder() -> Folder {
    let folder = Folder::with_model();
    folder.write("part.nc", PART);
    let made = folder.figures(&["compensate", "part.nc", "-m", "machine.model", "-o", "out.nc"]);
    assert_eq!(made["changed"], true);
    folder
}

#[test]
fn a_compensated_program_states_what_moved_its_points() {
    let out = folder().read("out.nc");
    let lines: Vec<&str> = out.lines().collect();
    assert_eq!(lines[..2], ["%", "O0001 (PLATE)"], "{out}");
    assert!(lines[2].starts_with("(PRECOMP ") && lines[2].contains("MODEL OF BALLSCREW, DATA "), "{out}");
    assert!(lines[3].starts_with("(LARGEST SHIFT 0.0") && lines[3].contains("ORIGINAL SHA256 "), "{out}");
    let settings = lines[4].strip_prefix("(TRAINED 20").and_then(|line| line.split_once(" - ")).map(|(_, settings)| settings);
    assert_eq!(settings, Some("LAW MODEL-BASED, UPDATES 4, CYCLE UP TO 1 PERCENT)"), "{out}");
    assert!(lines[2..5].iter().all(|line| line.len() <= 80), "{out}");
}

#[test]
fn a_compensated_program_is_not_compensated_again() {
    let folder = folder();
    let why = folder.fails(1, &["compensate", "out.nc", "-m", "machine.model", "-o", "twice.nc"]);
    assert!(why.contains("out.nc: line 3") && why.contains("give the original"), "{why}");
    assert!(!folder.path("twice.nc").exists());
    folder.figures(&["simulate", "out.nc", "-o", "run.csv"]);
    let why = folder.fails(1, &["refine", "out.nc", "--log", "run.csv", "-m", "machine.model", "-o", "twice.nc"]);
    assert!(why.contains("give the original"), "{why}");
}

#[test]
fn a_program_that_stays_as_it_is_gets_no_comment() {
    let folder = folder();
    let words = ["compensate", "part.nc", "-m", "machine.model", "-o", "same.nc", "--max-shift", "0"];
    let output = folder.precomp(&words);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_eq!(folder.read("same.nc"), PART);
}

#[test]
fn old_spellings_of_options_are_accepted() {
    let folder = folder();
    let old = ["--carrier", "g94", "--max-turn", "0.5", "--law", "virtual"];
    let new = ["--format", "g94", "--max-rotation", "0.5", "--law", "model-based"];
    for (words, out) in [(old, "old.nc"), (new, "new.nc")] {
        folder.figures(&[&["compensate", "part.nc", "-m", "machine.model", "-o", out][..], &words].concat());
    }
    assert_eq!(folder.read("old.nc"), folder.read("new.nc"));
}
