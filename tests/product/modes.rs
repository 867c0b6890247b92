//! Modes that a control's profile asks for, and the program's own. Works on the story's model.

use crate::common::{Folder, text};

pub fn stated_for_the_control_and_put_back(folder: &Folder) {
    let part = "G21 G90 G17 G61\nG0 X0 Y0 Z0\nG4 P0.2\nG94 G1 X2 F1800\nX20\nG94\nG3 X20 Y20 I0 J10\nG61 G1 X0\nG1 X0\nM8 G64 P0.1\nG1 Y0\nG0 Z5\nM2\n";
    std::fs::write(folder.path("modes.ngc"), part).unwrap();
    let words =
        ["compensate", "modes.ngc", "-m", "machine.model", "-o", "modes-c.ngc", "--controller", "linuxcnc", "--carrier", "g93"];
    assert_eq!(folder.figures(&words)["changed"], true);
    let out = std::fs::read_to_string(folder.path("modes-c.ngc")).unwrap();
    let lines: Vec<&str> = out.lines().collect();
    // One tolerance and inverse time hold in the whole stretch, whatever the program says in it.
    assert_eq!(lines[3], "G64P0.001Q0.", "{out}");
    let end = lines.iter().position(|line| *line == "G94F1800.").unwrap();
    let stretch = &lines[4..end];
    assert!(stretch[0].contains("G93") && !stretch.iter().any(|line| line.contains("G94")), "{out}");
    assert!(!stretch.iter().any(|line| line.contains("G61") || line.contains("G64")) && stretch.contains(&"M8 "), "{out}");
    // Behind it the program's own hold again.
    assert_eq!(lines[end + 1..], ["G64P0.1", "G0 Z5", "M2"], "{out}");
    // The first line's time is its own, without the wait before it: with 0.2 s more it would be below F300.
    let first = stretch[0];
    let feed: f64 = first.rsplit('F').next().unwrap().parse().unwrap();
    assert!(feed > 400.0, "{out}");
    // Where the times of points cost too much of the cycle, the program keeps its feeds.
    let output =
        folder.precomp(&["compensate", "modes.ngc", "-m", "machine.model", "-o", "modes-f.ngc", "--controller", "linuxcnc"]);
    assert!(text(&output.stdout).contains("the program keeps its feeds instead (--carrier g93 states the times)"));
    assert!(!std::fs::read_to_string(folder.path("modes-f.ngc")).unwrap().contains("G93"));
    // Lines that keep their feeds may be merged within a twentieth of what the program allows, lines with times not at all.
    std::fs::write(folder.path("wide.ngc"), part.replace("G17 G61\n", "G17 G64 P0.1\n")).unwrap();
    for (carrier, mode) in [("keep", "G64P0.01Q0.005"), ("g93", "G64P0.01Q0.")] {
        folder.figures(&[
            "compensate",
            "wide.ngc",
            "-m",
            "machine.model",
            "-o",
            "wide-c.ngc",
            "--controller",
            "linuxcnc",
            "--carrier",
            carrier,
        ]);
        let out = std::fs::read_to_string(folder.path("wide-c.ngc")).unwrap();
        assert_eq!(out.lines().nth(3), Some(mode), "{out}");
    }
    // A law of the papers is not learned on; only its forecast is of the program as planned.
    let words = ["compensate", "modes.ngc", "-m", "machine.model", "-o", "modes-o.ngc", "--law", "one-shot"];
    assert_eq!(folder.figures(&words)["updates"], 1);
    // Whoever writes for another control gets none of it.
    folder.figures(&["compensate", "modes.ngc", "-m", "machine.model", "-o", "modes-k.ngc", "--controller", "generic"]);
    let out = std::fs::read_to_string(folder.path("modes-k.ngc")).unwrap();
    assert!(!out.contains("G93") && !out.contains("Q0") && out.contains("\nG94\n"), "{out}");
}

pub fn the_programs_own_change_within_a_stretch(folder: &Folder) {
    let part =
        "G21 G90 G17\nG0 X0 Y0 Z0\nG94 G1 X10 F1800\nG93\nX14 Y3 F150\nG1 X24 Y10 F120\nG94 G1 X40 F1800\nX50\nG0 Z5\nM2\n";
    std::fs::write(folder.path("timed.nc"), part).unwrap();
    let words =
        ["compensate", "timed.nc", "-m", "machine.model", "-o", "timed-c.nc", "--controller", "generic", "--carrier", "keep"];
    let figures = folder.figures(&words);
    assert_eq!(figures["changed"], true);
    assert!(figures["cycle_s"]["after"].is_number(), "{figures}");
    let out = std::fs::read_to_string(folder.path("timed-c.nc")).unwrap();
    let lines: Vec<&str> = out.lines().collect();
    let at = |code: &str| lines.iter().rposition(|line| line.starts_with(code)).unwrap();
    let (timed, untimed) = (at("G93"), at("G94"));
    // Every line in inverse time states its own, and those of a move come to the move's (a corner's own points take a little more);
    // behind them feeds hold again.
    let feeds: Vec<f64> =
        lines[timed + 1..untimed].iter().map(|line| line.rsplit('F').next().unwrap().parse().unwrap()).collect();
    assert!(feeds.len() > 4, "{out}");
    let seconds: f64 = feeds.iter().map(|feed| 60.0 / feed).sum();
    assert!((0.899..0.93).contains(&seconds), "{seconds} s\n{out}");
    assert!(lines[untimed].ends_with("F1800"), "{out}");
    assert!(lines[untimed + 1..].iter().all(|line| !line.contains('F')), "{out}");
    let output = folder.precomp(&["simulate", "timed-c.nc", "--out", "timed-c.csv"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    // Where only an approach goes without a time the control does not plan the time.
    let part = "G21 G90 G17\nG0 X0 Y0 Z0.1\nG94 G1 Z0 F1800\nG93\nX14 Y3 F20\nX24 Y10 F15\nX50 F12\nG0 Z5\nM2\n";
    std::fs::write(folder.path("timed.nc"), part).unwrap();
    let figures = folder.figures(&words);
    assert_eq!((&figures["changed"], figures["cycle_s"].is_null()), (&true.into(), true), "{figures}");
}

pub fn points_that_are_put_in_never_stop_the_control(folder: &Folder) {
    let cut = "G1 X20 F2400\nG2 X40 Y20 I0 J20\nG9 G1 X60 Y0\nG1 X20\n";
    for mode in ["G61", "G61.1", "G64 P0", "G64 P0.002"] {
        let program = format!("G21 G90 G17 {mode}\nG0 X0 Y0 Z0\n{cut}M30\n");
        std::fs::write(folder.path("exact.nc"), &program).unwrap();
        let words = ["compensate", "exact.nc", "-m", "machine.model", "-o", "exact-out.nc", "--dialect", "fanuc"];
        let made = folder.figures(&words);
        let out = std::fs::read_to_string(folder.path("exact-out.nc")).unwrap();
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

pub fn what_is_not_understood_is_left_as_it_is(folder: &Folder) {
    let program =
        "G21 G90 G17 G64 P0.002\nG0 X0 Y0 Z0\nG1 X20 F2400\nG1 Y20\nG1 X0 Y0\nM428\nG0 X0 Y0\nG1 X-20\nG1 Y-20\nG1 X0 Y0\nM30\n";
    std::fs::write(folder.path("tcp.nc"), program).unwrap();
    let words = ["compensate", "tcp.nc", "-m", "machine.model", "-o", "tcp-out.nc", "--dialect", "fanuc"];
    let output = folder.precomp(&words);
    let said = text(&output.stdout);
    assert!(
        output.status.success() && said.contains("M428: what it changes is not known") && said.contains("--passive M428"),
        "{said}"
    );
    assert!(
        said.contains(
            "moves left as they are: 3 after codes whose effect on path or frame is not known; 50.0 % of the feed length"
        ),
        "{said}"
    );
    let out = std::fs::read_to_string(folder.path("tcp-out.nc")).unwrap();
    assert!(out.ends_with("M428\nG0 X0 Y0\nG1 X-20\nG1 Y-20\nG1 X0 Y0\nM30\n"), "{out}");
    assert!(!out.starts_with("G21 G90 G17 G64 P0.002\nG0 X0 Y0 Z0\nG1 X20 F2400\nG1 Y20\n"), "{out}");
    let told = folder.figures(&[&words[..], &["--passive", "M428"]].concat());
    assert_eq!(told["left_alone"]["feed_length_share"], 0.0, "{told}");
    folder.fails(2, &[&words[..], &["--passive", "G428"]].concat());
}
