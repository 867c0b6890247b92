//! What the terminal shows: drawings, more and less of what is printed, completions and manual pages.

use std::process::{Command, Output};

use crate::common::{Folder, text};

/// Runs `precomp` in the folder with these variables.
fn with(folder: &Folder, variables: &[(&str, &str)], words: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_precomp"));
    command.args(words).current_dir(folder.0.path()).env_remove("NO_COLOR").env_remove("CLICOLOR_FORCE").env_remove("COLUMNS");
    let output = command.envs(variables.iter().copied()).output().unwrap();
    assert!(output.status.success(), "{words:?}: {}", text(&output.stderr));
    output
}

const ESCAPE: char = '\u{1b}';

fn is_braille(c: char) -> bool {
    ('\u{2801}'..='\u{28ff}').contains(&c)
}

#[test]
fn errors_are_drawn_as_wide_as_the_terminal() {
    let folder = Folder::new();
    folder.figures(&["simulate", "curve:circle", "-o", "circle.csv"]);
    let measure = ["measure", "circle.csv", "--plot"];
    for columns in ["60", "110"] {
        let drawn = text(&with(&folder, &[("COLUMNS", columns)], &measure).stdout);
        let of_drawing: Vec<&str> = drawn.lines().filter(|line| line.contains('█') || line.chars().any(is_braille)).collect();
        assert!(of_drawing.len() > 12, "{drawn}");
        let widest = of_drawing.iter().map(|line| line.chars().count()).max().unwrap();
        let wanted: usize = columns.parse().unwrap();
        assert!((wanted - 16..=wanted).contains(&widest), "{widest} of {columns}: {drawn}");
        // The largest error stands at the ordinate and in the histogram's last bin.
        let max = drawn.lines().find(|line| line.starts_with("contour error along the path")).unwrap();
        let max: f64 = max.split(", ").last().unwrap().strip_suffix(" µm MAX").unwrap().parse().unwrap();
        assert_eq!(drawn.matches(&format!(" {max:.2} µm")).count(), 2, "{drawn}");
        assert!(!drawn.contains(ESCAPE));
    }
    assert!(!text(&with(&folder, &[], &["measure", "circle.csv"]).stdout).contains('█'));
    // Colours where they are asked for.
    assert!(text(&with(&folder, &[("CLICOLOR_FORCE", "1")], &measure).stdout).contains(ESCAPE));
}

#[test]
fn a_forecast_is_drawn_before_and_after() {
    let folder = Folder::with_model_and_part();
    let words = ["compensate", "part.nc", "-m", "machine.model", "-o", "out.nc", "--effort", "fast", "--plot"];
    let drawn = text(&with(&folder, &[("NO_COLOR", "1")], &words).stdout);
    for run in ["before", "after"] {
        assert!(drawn.contains(&format!("contour error along the path, {run}: ")), "{drawn}");
    }
    assert!(!drawn.contains(ESCAPE) && drawn.contains("share of the samples by contour error"), "{drawn}");
}

#[test]
fn less_and_more_is_printed() {
    let folder = Folder::with_model_and_part();
    let words = |more: &[&'static str]| {
        [&["compensate", "part.nc", "-m", "machine.model", "-o", "out.nc", "--effort", "fast"][..], more].concat()
    };
    let quiet = with(&folder, &[], &words(&["--quiet"]));
    let warnings = text(&quiet.stderr);
    assert!(quiet.stdout.is_empty() && warnings.lines().all(|line| line.starts_with("warning")), "{warnings}");
    let written = folder.read("out.nc");
    let usual = with(&folder, &[], &words(&[]));
    assert!(!usual.stdout.is_empty() && folder.read("out.nc") == written);
    let verbose = text(&with(&folder, &[], &words(&["-v"])).stderr);
    let steps: Vec<&str> = verbose.lines().filter(|line| line.starts_with("learning ")).collect();
    assert!(steps.len() >= 2 && steps.iter().all(|line| line.contains(" µm [") && line.ends_with(" s]")), "{verbose}");
    assert!(folder.fails(2, &words(&["-q", "-v"])).contains("cannot be used with"));
}

#[test]
fn warnings_of_the_same_text_are_one_and_the_others_are_counted() {
    let folder = Folder::with_model();
    let mut program = String::from("O1\nG21 G90 G17\nG0 X0. Y0. Z0.\nG1 X50. F1800\n");
    // Each section has its own last line; the L of forty moves is the same.
    (0..30).for_each(|_| program.push_str("G16\nG1 X5. Y30.\nG15\n"));
    program.push_str("G0 X0. Y0. Z0.\n");
    (0..40).for_each(|k| program.push_str(&format!("G1 X{}. Y{}. L2\n", 50 * (k % 2), k)));
    program.push_str("M30\n");
    folder.write("part.nc", program);
    let words = |more: &[&'static str]| {
        let own = ["compensate", "part.nc", "-m", "machine.model", "-o", "out.nc", "--effort", "fast", "--decimal-point", "unit"];
        [&own[..], more].concat()
    };
    let count = |printed: &str| printed.lines().filter(|line| line.starts_with("warning")).count();
    let usual = text(&with(&folder, &[], &words(&[])).stdout);
    assert!(usual.contains("\nwarning: 50 more warnings; --verbose shows all\n"), "{usual}");
    let quiet = text(&with(&folder, &[], &words(&["--quiet"])).stderr);
    assert!(quiet.lines().all(|line| line.starts_with("warning")) && count(&quiet) == count(&usual), "{quiet}");
    let verbose = text(&with(&folder, &[], &words(&["--verbose"])).stdout);
    assert_eq!(count(&verbose) - count(&usual), 70 - 21, "{verbose}");
    assert!(!verbose.contains("more warnings"));
    // Without the sections all moves stand in one warning.
    folder.write("part.nc", folder.read("part.nc").replace("G16\n", "").replace("G15\n", ""));
    let merged = text(&with(&folder, &[], &words(&[])).stdout);
    assert!(merged.contains("is left as it is (lines 36-75)\n"), "{merged}");
}

#[test]
fn shells_and_man_know_every_command() {
    let folder = Folder::new();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = folder.prints(&["completions", shell]);
        assert!(["compensate", "diagnose", "max-shift"].iter().all(|word| script.contains(word)), "{shell}");
    }
    assert!(folder.fails(2, &["completions", "abacus"]).contains("bash"));
    folder.prints(&["man", "pages"]);
    let page = folder.read("pages/precomp-compensate.1");
    assert!(
        page.contains(".TH precomp-compensate 1") && page.contains("max\\-shift") && page.contains("precomp compensate part.nc"),
        "{page}"
    );
    let main = folder.read("pages/precomp.1");
    assert!(main.contains("precomp\\-diagnose(1)") || main.contains("precomp-diagnose(1)"), "{main}");
    let pages = std::fs::read_dir(folder.path("pages")).unwrap().count();
    assert_eq!(pages, 16, "one for precomp, one for each of its commands");
}
