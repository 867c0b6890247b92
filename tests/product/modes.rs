//! Modes that a control's profile asks for, and the program's own.

use serde_json::Value;

use crate::common::{Folder, text, without_mark};

const PART: &str = "G21 G90 G17 G61\nG0 X0 Y0 Z0\nG4 P0.2\nG94 G1 X2 F1800\nX20\nG94\nG3 X20 Y20 I0 J10\nG61 G1 X0\nG1 X0\n\
M8 G64 P0.1\nG1 Y0\nG0 Z5\nM2\n";

/// A folder with the model and `modes.ngc`.
fn folder_with(program: &str) -> Folder {
    let folder = Folder::with_model();
    folder.write("modes.ngc", program);
    folder
}

/// Compensates `modes.ngc` with these options; the program that comes out, and the figures.
fn compensate(folder: &Folder, options: &[&str]) -> (String, Value) {
    let figures = folder.figures(&[&["compensate", "modes.ngc", "-m", "machine.model", "-o", "out.ngc"][..], options].concat());
    (without_mark(&folder.read("out.ngc")), figures)
}

#[test]
fn one_tolerance_and_inverse_time_hold_in_a_segment_and_the_programs_own_modes_behind_it() {
    let folder = folder_with(PART);
    let (out, figures) = compensate(&folder, &["--controller", "linuxcnc", "--format", "g93"]);
    assert_eq!(figures["changed"], true);
    let lines: Vec<&str> = out.lines().collect();
    assert_eq!(lines[3], "G64P0.001Q0.", "{out}");
    let end = lines.iter().position(|line| *line == "G94F1800.").unwrap();
    let segment = &lines[4..end];
    assert!(segment[0].contains("G93") && !segment.iter().any(|line| line.contains("G94")), "{out}");
    assert!(!segment.iter().any(|line| line.contains("G61") || line.contains("G64")) && segment.contains(&"M8 "), "{out}");
    assert_eq!(lines[end + 1..], ["G64P0.1", "G0 Z5", "M2"], "{out}");
}

#[test]
fn the_time_of_the_first_line_is_without_the_dwell_before_it() {
    let folder = folder_with(PART);
    let (out, _) = compensate(&folder, &["--controller", "linuxcnc", "--format", "g93"]);
    // With 0.2 s more it would be below F300.
    let first = out.lines().nth(4).unwrap();
    let feed: f64 = first.rsplit('F').next().unwrap().parse().unwrap();
    assert!(feed > 400.0, "{out}");
}

#[test]
fn a_program_keeps_its_feeds_where_the_times_of_points_cost_too_much_of_the_cycle() {
    // Smoothed acceleration: at every step of the stated speed the control takes longer.
    let folder = folder_with("G21 G90 G17\nG0 X0 Y0 Z0\nG1 X20 F3000\nX20 Y10\nX0\nY0\nG0 Z5\nM2\n");
    let words =
        ["compensate", "modes.ngc", "-m", "machine.model", "-o", "out.ngc", "--controller", "linuxcnc", "--work-offset", "0,0,0"];
    let printed = text(&folder.precomp(&words).stdout);
    assert!(printed.contains("the program keeps its feeds instead (--format g93 states the times)"));
    assert!(!folder.read("out.ngc").contains("G93"));
}

#[test]
fn lines_with_feeds_may_be_merged_within_a_twentieth_of_the_tolerance_and_lines_with_times_not_at_all() {
    let folder = folder_with(&PART.replace("G17 G61\n", "G17 G64 P0.1\n"));
    for (carrier, mode) in [("keep", "G64P0.01Q0.005"), ("g93", "G64P0.01Q0.")] {
        let (out, _) = compensate(&folder, &["--controller", "linuxcnc", "--format", carrier]);
        assert_eq!(out.lines().nth(3), Some(mode), "{out}");
    }
}

#[test]
fn one_shot_makes_one_update() {
    let (_, figures) = compensate(&folder_with(PART), &["--law", "one-shot"]);
    assert_eq!(figures["updates"], 1);
}

#[test]
fn a_generic_control_gets_the_programs_own_modes() {
    let (out, _) = compensate(&folder_with(PART), &["--controller", "generic"]);
    assert!(!out.contains("G93") && !out.contains("Q0") && out.contains("\nG94\n"), "{out}");
}

/// Options that keep the program's own time encoding.
const AS_PROGRAMMED: [&str; 6] = ["--controller", "generic", "--format", "keep", "--decimal-point", "unit"];

#[test]
fn inverse_time_and_feeds_change_within_a_segment_as_programmed() {
    let folder = folder_with(
        "G21 G90 G17\nG0 X0 Y0 Z0\nG94 G1 X10 F1800\nG93\nX14 Y3 F150\nG1 X24 Y10 F120\nG94 G1 X40 F1800\nX50\nG0 Z5\nM2\n",
    );
    let (out, figures) = compensate(&folder, &AS_PROGRAMMED);
    assert_eq!(figures["changed"], true);
    assert!(figures["cycle_s"]["after"].is_number(), "{figures}");
    let lines: Vec<&str> = out.lines().collect();
    let at = |code: &str| lines.iter().rposition(|line| line.starts_with(code)).unwrap();
    let (timed, untimed) = (at("G93"), at("G94"));
    // Every line in inverse time states its own, and those of a move come to the move's (a corner's own points take a little more);
    // behind them feeds hold again.
    let feeds: Vec<f64> =
        lines[timed + 1..untimed].iter().map(|line| line.rsplit('F').next().unwrap().parse().unwrap()).collect();
    assert!(feeds.len() > 3, "{out}");
    let seconds: f64 = feeds.iter().map(|feed| 60.0 / feed).sum();
    assert!((0.899..0.93).contains(&seconds), "{seconds} s\n{out}");
    assert!(lines[untimed].ends_with("F1800"), "{out}");
    assert!(lines[untimed + 1..].iter().all(|line| !line.contains('F')), "{out}");
    folder.prints(&["simulate", "out.ngc", "--out", "out.csv"]);
}

#[test]
fn a_program_with_only_its_approach_in_feed_per_minute_has_no_planned_time() {
    let folder = folder_with("G21 G90 G17\nG0 X0 Y0 Z0.1\nG94 G1 Z0 F1800\nG93\nX14 Y3 F20\nX24 Y10 F15\nX50 F12\nG0 Z5\nM2\n");
    // The inverse times of a Fanuc are bounded, so that not every line states its own.
    for (dialect, is_planned) in [("linuxcnc", false), ("fanuc", true)] {
        let (_, figures) = compensate(&folder, &[&AS_PROGRAMMED[..], &["--dialect", dialect]].concat());
        assert_eq!((&figures["changed"], figures["cycle_s"].is_null()), (&true.into(), !is_planned), "{figures}");
    }
}

#[test]
fn inserted_points_never_stop_the_control() {
    let folder = Folder::with_model();
    let cut = "G1 X20 F2400\nG2 X40 Y20 I0 J20\nG9 G1 X60 Y0\nG1 X20\n";
    for mode in ["G61", "G61.1", "G64 P0", "G64 P0.002"] {
        let program = format!("G21 G90 G17 {mode}\nG0 X0 Y0 Z0\n{cut}M30\n");
        folder.write("exact.nc", &program);
        let words = ["compensate", "exact.nc", "-m", "machine.model", "-o", "exact-out.nc", "--dialect", "fanuc"];
        let made = folder.figures(&words);
        let out = without_mark(&folder.read("exact-out.nc"));
        let (lines, blends) = (out.lines().count(), mode == "G64 P0.002");
        // Under an exact stop no line is put in; elsewhere only the block with G9 keeps its one line.
        assert!(if blends { lines > program.lines().count() } else { lines == program.lines().count() }, "{mode}: {out}");
        let after = out.split("G9").nth(1).unwrap();
        assert_eq!(out.matches("G9 ").count() + out.matches("G9G").count(), 1, "{mode}: {out}");
        assert!(!blends || after.lines().count() > 2, "{mode}: {out}");
        if let Some(cycle) = made["cycle_s"].as_object() {
            let (before, after) = (cycle["before"].as_f64().unwrap(), cycle["after"].as_f64().unwrap());
            assert!(after < 1.03 * before, "{mode}: {before} → {after} s");
        }
        let arcs = &made["left_alone"]["moves"];
        assert_eq!(
            arcs["arcs at whose points the control would stop (G9, G61, G64 P0)"].as_u64(),
            (!blends).then_some(1),
            "{made}"
        );
    }
}

/// A code of unknown effect after half of the feed length.
const UNKNOWN_CODE: &str =
    "G21 G90 G17 G64 P0.002\nG0 X0 Y0 Z0\nG1 X20 F2400\nG1 Y20\nG1 X0 Y0\nM428\nG0 X0 Y0\nG1 X-20\nG1 Y-20\nG1 X0 Y0\nM30\n";
const UNKNOWN_CODE_WORDS: [&str; 8] = ["compensate", "modes.ngc", "-m", "machine.model", "-o", "out.ngc", "--dialect", "fanuc"];

#[test]
fn moves_behind_an_unknown_code_stay_and_are_reported() {
    let folder = folder_with(UNKNOWN_CODE);
    let said = folder.prints(&UNKNOWN_CODE_WORDS);
    assert!(said.contains("M428: what it changes is not known") && said.contains("--passive M428"), "{said}");
    assert!(
        said.contains(
            "moves left as they are: 3 not understood, or after codes whose effect on path or frame is not known (from line 8); 50.0 % of the feed length"
        ),
        "{said}"
    );
    let out = without_mark(&folder.read("out.ngc"));
    assert!(out.ends_with("M428\nG0 X0 Y0\nG1 X-20\nG1 Y-20\nG1 X0 Y0\nM30\n"), "{out}");
    assert!(!out.starts_with("G21 G90 G17 G64 P0.002\nG0 X0 Y0 Z0\nG1 X20 F2400\nG1 Y20\n"), "{out}");
}

#[test]
fn moves_behind_a_code_given_as_passive_are_compensated() {
    let (_, figures) = compensate(&folder_with(UNKNOWN_CODE), &["--dialect", "fanuc", "--passive", "M428"]);
    assert_eq!(figures["left_alone"]["feed_length_share"], 0.0, "{figures}");
}

#[test]
fn moves_behind_a_macro_that_is_not_found_stay_unless_it_is_said_to_keep_the_modes() {
    let program = UNKNOWN_CODE.replace("M428\nG0 X0 Y0", "M98 P1000\nG0 X0 Y0 Z0");
    let said = folder_with(&program).prints(&UNKNOWN_CODE_WORDS);
    assert!(said.contains("--macros keep") && said.contains("3 not understood, or after codes whose effect"), "{said}");
    let (_, figures) = compensate(&folder_with(&program), &["--dialect", "fanuc", "--macros", "keep"]);
    assert_eq!(figures["left_alone"]["feed_length_share"], 0.0, "{figures}");
}

#[test]
fn a_turned_section_stays_and_its_warning_names_its_lines() {
    let program = UNKNOWN_CODE.replace("M428", "G68 X0 Y0 R30\nG1 X5 Y5\nG69");
    let said = folder_with(&program).prints(&UNKNOWN_CODE_WORDS);
    assert!(said.contains("G68: coordinates are not those of the path") && said.contains("up to line 8"), "{said}");
    assert!(said.contains("moves left as they are: 1 not understood, or after codes"), "{said}");
}

#[test]
fn only_m_codes_can_be_given_as_passive() {
    folder_with(UNKNOWN_CODE).fails(2, &[&UNKNOWN_CODE_WORDS[..], &["--passive", "G428"]].concat());
}

#[test]
fn a_move_that_is_left_alone_gets_back_the_motion_code_on_which_it_relies() {
    // The arcs become lines, the next one is known only when the program runs.
    let folder = folder_with(
        "%\nO1\nG21 G90 G17 G54\nG0 X0. Y0. Z5.\nG1 Z-1. F300.\nG2 X40. Y40. I20. J20. F1500.\nG4 P100\nX[#500+10.] Y10. R90.\nG1 X0. Y0.\nG0 Z5.\nM30\n%\n",
    );
    let (out, figures) = compensate(&folder, &["--dialect", "fanuc", "--format", "keep"]);
    assert_eq!(figures["changed"], true);
    assert!(out.contains("X[#500+10.] Y10. R90."), "{out}");
    let code = |line: &str| ["G1", "G2"].into_iter().rfind(|code| line.starts_with(code));
    let last = out.lines().take_while(|line| !line.starts_with("X[")).filter_map(code).last();
    assert!(out.contains("\nG2X[#500") || last == Some("G2"), "{out}");
}

#[test]
fn lines_that_share_an_inverse_time_keep_the_feed_of_their_move() {
    for dialect in ["fanuc", "linuxcnc"] {
        let folder = folder_with(
            "G21 G17 G90 G94\nG0 X0 Y0 Z0\nG93 G1 X20. Y.2 F20.\nX2. Y0 F20.\nX20. F100.\nG94 G1 X0 F500\nG0 Z5\nM2\n",
        );
        let (out, figures) = compensate(&folder, &["--dialect", dialect, "--work-offset", "0,0,0"]);
        assert_eq!(figures["changed"], true);
        let mut at = [0.0, 0.0];
        let mut lines = 0;
        for line in out.lines().skip_while(|line| !line.contains("G93")).take_while(|line| !line.contains("G94")) {
            let value = |letter: char| {
                line.rsplit_once(letter)
                    .map(|(_, rest)| rest.split(|c: char| c.is_ascii_alphabetic()).next().unwrap().trim().parse::<f64>().unwrap())
            };
            let end = [value('X').unwrap_or(at[0]), value('Y').unwrap_or(at[1])];
            let feed = (end[0] - at[0]).hypot(end[1] - at[1]) * value('F').unwrap();
            // Those of the three moves: 400, 360 and 1800 mm/min.
            assert!([400.0, 360.0, 1800.0].iter().any(|own| (feed / own - 1.0).abs() < 0.02), "{feed} {line}\n{out}");
            (at, lines) = (end, lines + 1);
        }
        assert!(lines > 4, "{out}");
    }
}

#[test]
fn inverse_times_of_fanuc_have_its_range_and_none_is_written_for_an_arc() {
    // A Fanuc counts F of an arc under G93 by its radius, others by its length.
    let folder = folder_with(
        "%\nO1000\nG21 G17 G90 G94 G54\nG0 X0 Y0\nG43 H1 Z5.\nG1 Z-1. F3000.\nG93\nG1 X20. F200.\nY20. F200.\nG2 X20. Y0. J-10. F100.\nG1 X0. F200.\nY10. F200.\nG94\nM30\n%\n",
    );
    let (out, figures) = compensate(&folder, &["--dialect", "fanuc", "--work-offset", "0,0,0"]);
    assert_eq!(figures["changed"], true);
    assert!(out.contains("\nG2 X20. Y0. J-10. F100.\n"), "{out}");
    assert!(figures["left_alone"]["moves"].to_string().contains("G93"), "{figures}");
    folder.write(
        "modes.ngc",
        "%\nO1000\nG21 G17 G90 G94 G54\nG0 X0 Y0\nG43 H1 Z0\nG1 X20. F3000.\nG2 X20. Y20. J10.\nG1 X0.\nM30\n%\n",
    );
    let (timed, _) =
        compensate(&folder, &["--dialect", "fanuc", "--format", "g93", "--work-offset", "0,0,0", "--cycle-limit", "30"]);
    let written = timed.lines().skip_while(|line| !line.contains("G93")).take_while(|line| !line.contains("G94"));
    assert!(written.clone().count() > 10 && !written.clone().any(|line| line.contains("G2") || line.contains("G3")), "{timed}");
    for line in written.chain(out.lines().skip_while(|line| !line.contains("G93")).take_while(|line| !line.contains("G94"))) {
        let Some(feed) = line.rsplit_once('F').map(|(_, feed)| feed.trim()) else { continue };
        let decimals = feed.split_once('.').map_or("", |(_, decimals)| decimals);
        assert!(feed.parse::<f64>().unwrap() <= 9999.999 && decimals.len() <= 3, "{line}");
    }
}
