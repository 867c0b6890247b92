//! The command line's contract: help, exit status, messages.

use crate::common::{Folder, text};

#[test]
fn every_command_has_help_with_an_example() {
    let folder = Folder::new();
    for command in ["demo", "excite", "simulate", "train", "predict", "compensate", "measure", "refine", "compare", "reproduce"] {
        let output = folder.precomp(&[command, "--help"]);
        assert!(output.status.success());
        let help = text(&output.stdout);
        assert!(help.contains("Example") && help.contains("--json") && help.contains("--seed"), "{command}: {help}");
    }
}

#[test]
fn errors_in_use_and_refusals_have_their_own_status() {
    let folder = Folder::new();
    folder.fails(2, &["nonsense"]);
    if cfg!(not(feature = "fleet")) {
        assert!(folder.fails(2, &["fleet", "watch", "-m", "x", "--help"]).contains("--features fleet"));
    }
    folder.fails(2, &["train", "-o", "x.model"]);
    assert!(folder.fails(2, &["train", "missing.csv", "-o", "x.model"]).contains("missing.csv"));
    assert!(folder.fails(2, &["simulate", "curve:nothing", "-o", "x.csv"]).contains("crown"));
    assert!(folder.fails(2, &["excite", "--machine", "nothing.toml", "-o", "x"]).contains("ballscrew"));
    std::fs::write(folder.path("m.toml"), "name = \"m\"\nsampling_period_ms = 2.0\nwobble = 1\n").unwrap();
    assert!(folder.fails(1, &["excite", "--machine", "m.toml", "-o", "x"]).contains("wobble"));
    assert!(folder.fails(2, &["demo", "--predictor", "crystal-ball"]).contains("lstm-paper"));
    std::fs::write(folder.path("r.toml"), "[staged]\nfoldz = 3\n").unwrap();
    assert!(folder.fails(1, &["demo", "--predictor", "r.toml"]).contains("foldz"));
    for words in [
        ["simulate", "curve:crown", "-o", "x.csv", "--feed", "nan"],
        ["simulate", "curve:crown", "-o", "x.csv", "--feed", "0"],
        ["simulate", "curve:crown", "-o", "x.csv", "--feed", "1e-9"],
        ["simulate", "curve:crown", "-o", "x.csv", "--noise", "-1"],
        ["simulate", "curve:crown", "-o", "x.csv", "--work-offset", "0,inf,0"],
        ["compensate", "part.nc", "-m", "m.model", "-oo.nc", "--max-shift=nan"],
        ["compensate", "part.nc", "-m", "m.model", "-oo.nc", "--max-shift=-1"],
        ["compensate", "part.nc", "-m", "m.model", "-oo.nc", "--max-turn=inf"],
    ] {
        assert!(folder.fails(2, &words).contains("is not a"), "{words:?}");
    }
    let filter = |text| ["refine", "part.nc", "--log", "run.csv", "-o", "out.nc", "--low-pass", text];
    assert!(folder.fails(2, &filter("1e-300")).contains("is not a number from 0.1 to 100000"));
    // A feed or dwell in the wrong unit ends in a message instead of in an endless plan.
    std::fs::write(folder.path("slow.nc"), "G21 G90\nG1 X10 F0.0001\nX0\nM2\n").unwrap();
    assert!(folder.fails(1, &["simulate", "slow.nc", "-o", "x.csv"]).contains("check the feed"));
    std::fs::write(folder.path("dwell.nc"), "G21 G90\nG1 X10 F600\nG4 P1000000000000\nG1 X0\nM2\n").unwrap();
    let said = folder.fails(1, &["simulate", "dwell.nc", "-o", "x.csv"]);
    assert!(said.contains("dwell.nc") && said.contains("samples"), "{said}");
    std::fs::write(folder.path("turn.nc"), "G21 G90\nG1 X10 F600\nM2\n").unwrap();
    let words = ["simulate", "turn.nc", "--machine", "bc", "--tool-length", "5", "-o", "x.csv"];
    assert!(folder.fails(2, &words).contains("tool_length_mm"));
    std::fs::write(folder.path("not.model"), b"PK nothing").unwrap();
    assert!(folder.fails(1, &["predict", "curve:crown", "-m", "not.model"]).contains("not a model"));
    std::fs::write(folder.path("swapped.model"), b"PK\x03\x04\0\0").unwrap();
    assert!(folder.fails(2, &["simulate", "swapped.model", "-o", "x.csv"]).contains("no part program"));
}

#[test]
fn excitation_says_how_far_each_axis_goes() {
    let folder = Folder::new();
    let said = |seconds: &str| {
        let words =
            ["excite", "--machine", "bc", "-o", "e", "--seed", "3", "--travel", "50", "--json", "e.json", "--seconds", seconds];
        text(&folder.precomp(&words).stdout)
    };
    let short = said("10");
    let figures: serde_json::Value = serde_json::from_slice(&std::fs::read(folder.path("e.json")).unwrap()).unwrap();
    let covered = &figures["covered"];
    let ends = |axis: &str| [0, 1].map(|end| covered[axis][end].as_f64().unwrap());
    let ([x, x_end], [c, c_end]) = (ends("x"), ends("c").map(f64::to_degrees));
    assert!(short.contains(&format!("x: {x:.1} to {x_end:.1} of -50.0 to 50.0 mm")), "{short}");
    assert!(short.contains(&format!("c: {c:.1} to {c_end:.1} of -180.0 to 180.0 deg")), "{short}");
    let further = "for parts that go further";
    assert!(x > -50.0 && x_end < 50.0 && short.contains(further), "{short}");
    let long = said("200");
    assert!(long.contains("x: ") && !long.contains(further), "{long}");
    // Short lines slow this control down: what the programs take is said beside the time of the references.
    let [references_s, programs_s] = ["seconds", "program_seconds"].map(|key| figures[key].as_f64().unwrap());
    assert!(programs_s > 1.3 * references_s && short.contains(&format!("the runs take about {programs_s:.0} s")), "{short}");
}

#[test]
fn a_feed_move_that_cannot_be_predicted_is_refused_with_a_caret() {
    let folder = Folder::new();
    std::fs::write(folder.path("macro.nc"), "G21 G90\nG0 X0 Y0 Z0\nG1 X[#101*2] F500\nM30\n").unwrap();
    let said = folder.fails(1, &["simulate", "macro.nc", "-o", "x.csv"]);
    assert!(said.contains("macro.nc:3:1") && said.contains('^'), "{said}");
    assert!(said.starts_with("error: only the running program knows") && said.matches("error:").count() == 1, "{said}");
    assert!(!folder.path("x.csv").exists());
    std::fs::write(folder.path("empty.nc"), "").unwrap();
    assert!(folder.fails(1, &["simulate", "empty.nc", "-o", "x.csv"]).contains("is empty"));
}

#[test]
fn a_reader_that_goes_away_is_no_failure() {
    let folder = Folder::new();
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_precomp"))
        .args(["simulate", "curve:circle", "-o", "x.csv"])
        .current_dir(&folder.0)
        .stdout(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    assert!(child.wait().unwrap().success());
    assert!(folder.path("x.csv").exists());
}

#[test]
fn json_on_standard_output_is_alone_there() {
    let folder = Folder::new();
    let output = folder.precomp(&["simulate", "curve:circle", "--feed", "50", "-o", "x.csv", "--json", "-"]);
    assert!(output.status.success());
    let figures: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(figures["contour_um"]["rms"].as_f64().unwrap() > 1.0);
    // The log measures the same by itself.
    let again = folder.figures(&["measure", "x.csv"]);
    let (a, b) = (figures["contour_um"]["rms"].as_f64().unwrap(), again["contour_um"]["rms"].as_f64().unwrap());
    assert!((a - b).abs() < 0.02, "{a} {b}");
}

#[test]
fn a_program_that_stays_as_it_is_says_why() {
    let folder = Folder::new();
    folder.train("20", "linear");
    let compensate = |lines: &str| {
        std::fs::write(folder.path("part.nc"), format!("G21 G90 G17\nG0 X0 Y0 Z5\n{lines}M30\n")).unwrap();
        folder.precomp(&["compensate", "part.nc", "-m", "machine.model", "-o", "out.nc"])
    };
    let output = compensate("G41 D1\nG1 X30 F2400\nG1 X30 Y20\nG81 X5 Y5 Z-5 R2 F100\nG80\nG40\n");
    let said = text(&output.stdout);
    assert!(said.contains("no move that may be changed (1 in canned cycles (line 6), 2 under cutter compensation"), "{said}");
    assert_eq!(std::fs::read(folder.path("out.nc")).unwrap(), std::fs::read(folder.path("part.nc")).unwrap());
    // Where there is nothing to gain on moves that may be changed, that is another matter.
    let said = text(&compensate("G1 X0.002 F1\nG53 G1 X5 F100\n").stdout);
    assert!(said.contains("no gain worth having on the 1 moves") && said.contains("1 in machine coordinates (G53"), "{said}");
    std::fs::write(folder.path("turn.nc"), "G21 G90\nG0 X0\nG1 A30 F100\nM30\n").unwrap();
    let said = folder.fails(1, &["simulate", "turn.nc", "-o", "x.csv"]);
    assert!(said.contains("no move of the program moves an axis of the machine (x, y, z)"), "{said}");
}

#[test]
fn excitation_is_written_in_the_words_of_the_control() {
    let folder = Folder::new();
    let lines = |controller: &str| -> Vec<String> {
        folder.figures(&["excite", "-o", "e", "--seconds", "10", "--controller", controller]);
        let text = std::fs::read_to_string(folder.path("e/04-lines.nc")).unwrap();
        // Its control plans it without a complaint.
        folder.figures(&["simulate", "e/04-lines.nc", "-o", "run.csv"]);
        text.lines().map(str::to_owned).collect()
    };
    for controller in ["linuxcnc", "fanuc", "siemens", "grbl", "generic"] {
        let program = lines(controller);
        let has = |what: &str| program.iter().any(|line| line.contains(what));
        assert_eq!((has("G64"), has("G93")), (controller == "linuxcnc", controller == "linuxcnc"), "{controller}");
        assert_eq!(has("G4 P500"), controller == "fanuc", "{controller}");
        let comment = if controller == "siemens" { "; Z " } else { "(Z " };
        assert!(has("MACHINE BALLSCREW") && has(comment) && has("WORK OFFSET") && has("MM/MIN"), "{controller}");
        let moves: Vec<&String> =
            program.iter().filter(|line| ["G0 ", "G1 "].iter().any(|code| line.starts_with(code))).collect();
        assert!(moves[0].starts_with("G0 Z") && !moves[0].contains('X'), "{controller}: {}", moves[0]);
        assert!(moves[1].starts_with("G0 X") && !moves[1].contains('Z'), "{controller}: {}", moves[1]);
        assert!(moves[2].starts_with("G1 Z") && moves[2].ends_with(" F600."), "{controller}: {}", moves[2]);
        assert!(moves[3..].iter().all(|line| line.starts_with("G1 ") && line.contains(" F")), "{controller}");
    }
}
