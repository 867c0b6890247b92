//! SINUMERIK programs: compensated and written as such.

use crate::common::{Folder, PART, without_mark};

/// A program of `gcode/tests/sinumerik`.
fn sample(name: &str) -> Vec<u8> {
    std::fs::read(std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("gcode/tests/sinumerik").join(name)).unwrap()
}

fn folder_with(names: &[&str]) -> Folder {
    let folder = Folder::with_model();
    names.iter().for_each(|name| folder.write(name, sample(name)));
    folder
}

/// Compensates a program. Returns the share of the feed length that is left alone, and the program without its mark.
fn compensated(folder: &Folder, name: &str, more: &[&str]) -> (f64, String) {
    let words = [&["compensate", name, "-m", "machine.model", "-o", "out.mpf"], more].concat();
    let figures = folder.figures(&words);
    assert_eq!(figures["changed"], true, "{name}: {figures}");
    (figures["left_alone"]["feed_length_share"].as_f64().unwrap(), without_mark(&folder.read("out.mpf")))
}

#[test]
fn a_pocket_is_compensated_in_its_own_syntax() {
    let folder = folder_with(&["pocket.mpf"]);
    let (share, out) = compensated(&folder, "pocket.mpf", &[]);
    assert_eq!(share, 0.0);
    let lines: Vec<&str> = out.split_terminator("\r\n").collect();
    assert_eq!(
        lines[..3],
        ["%_N_TASCHE_MPF", ";$PATH=/_N_WKS_DIR/_N_HALTER_WPD", "; Halter, Tasche 60 x 40, Bearbeitung mit Schaftfräser D10"]
    );
    let marked = folder.read("out.mpf");
    assert!(marked.starts_with("%_N_TASCHE_MPF\r\n;$PATH=/_N_WKS_DIR/_N_HALTER_WPD\r\n; PRECOMP "), "{marked}");
    let original = String::from_utf8(sample("pocket.mpf")).unwrap();
    let is_cut = |line: &str| {
        line.contains("G1") && !line.contains("G17") && !line.contains("G0") || line.contains("G2 ") || line.contains("G3 ")
    };
    for line in original.split_terminator("\r\n").filter(|line| !is_cut(line)) {
        assert!(lines.contains(&line), "{line} is missing\n{out}");
    }
    // Arcs stay arcs, with centres from their start; no other word has an equals sign.
    assert!(out.contains("G3X") && out.contains("I") && !out.contains("CR=") && !out.contains("AC("), "{out}");
    let cuts = lines.iter().filter(|line| line.contains("G1X") || line.contains("G3X") || line.contains("G2X"));
    assert!(cuts.clone().count() > 5 && cuts.clone().all(|line| !line.contains('=')), "{out}");
}

#[test]
fn a_compensated_pocket_cuts_closer_and_is_not_compensated_again() {
    let folder = folder_with(&["pocket.mpf"]);
    compensated(&folder, "pocket.mpf", &[]);
    let rms = |name: &str| {
        let figures = folder.figures(&["simulate", name, "--against", "pocket.mpf", "-o", "run.csv", "--seed", "3"]);
        figures["contour_um"]["rms"].as_f64().unwrap()
    };
    let (before, after) = (rms("pocket.mpf"), rms("out.mpf"));
    assert!(after < 0.3 * before, "{before} {after}");
    let said = folder.fails(1, &["compensate", "out.mpf", "-m", "machine.model", "-o", "again.mpf"]);
    assert!(said.contains("compensated"), "{said}");
}

#[test]
fn parameters_and_decided_branches_stay_as_they_are() {
    let folder = folder_with(&["constants.mpf"]);
    let (share, out) = compensated(&folder, "constants.mpf", &[]);
    assert_eq!(share, 0.0);
    assert!(out.contains("DEF REAL TIEFE=-1.5, RADIUS=10\nR1=20 ; halbe Länge\nR2=R1/2\n"), "{out}");
    assert!(
        out.contains("\nIF TIEFE<0\nG1") && out.contains("\nELSE\nG1 X-99\nENDIF\n") && out.contains("\nANFAHREN: G1X"),
        "{out}"
    );
    assert!(!out.contains("X=R1*2") && out.ends_with("\nG0 Z5\nM30\n"), "{out}");
}

#[test]
fn loops_and_subprograms_are_written_flat_on_request() {
    let folder = folder_with(&["loops.mpf", "subprograms.mpf", "START.SPF", "tasche.spf"]);
    for name in ["loops.mpf", "subprograms.mpf"] {
        let said = folder.fails(1, &["compensate", name, "-m", "machine.model", "-o", "out.mpf"]);
        assert!(said.contains("give --expand"), "{said}");
        let (share, out) = compensated(&folder, name, &["--expand"]);
        assert_eq!(share, 0.0, "{out}");
        assert!(out.contains("; from ") && !out.contains("ENDFOR") && !out.contains("PROC") && !out.contains("R1"), "{out}");
        assert!(out.ends_with("M30\n"), "{out}");
    }
    assert_eq!(folder.read("tasche.spf").into_bytes(), sample("tasche.spf"));
}

#[test]
fn what_is_not_interpreted_is_left_alone_and_the_rest_is_not() {
    let folder = Folder::with_model();
    for (name, least, most) in [
        ("frames.mpf", 0.05, 0.5),
        ("freeform.mpf", 0.0, 0.0),
        ("swivel.mpf", 0.3, 0.6),
        ("five_axis.mpf", 0.03, 0.4),
        ("shopmill.mpf", 0.3, 0.9),
        ("inch.mpf", 0.0, 0.0),
        ("lower.mpf", 0.0, 0.4),
        ("splines.mpf", 0.2, 0.8),
        ("synchronized.mpf", 0.2, 0.8),
    ] {
        folder.write(name, sample(name));
        let figures = folder.figures(&["compensate", name, "-m", "machine.model", "-o", "out.mpf"]);
        let share = figures["left_alone"]["feed_length_share"].as_f64().unwrap();
        let rms = |when: &str| figures["predicted_contour_um"][when]["rms"].as_f64().unwrap();
        println!("{name}: {share:.3} of the feed length left alone, {:.3} -> {:.3} um", rms("before"), rms("after"));
        assert!((least..=most).contains(&share), "{name}: {figures}");
    }
}

#[test]
fn no_line_is_added_where_the_control_stops() {
    let folder = folder_with(&["lower.mpf"]);
    let (_, out) = compensated(&folder, "lower.mpf", &[]);
    let lines: Vec<&str> = out.lines().collect();
    let at = |start: &str| lines.iter().position(|line| line.starts_with(start)).unwrap_or_else(|| panic!("{start}\n{out}"));
    assert_eq!((at("g60") - at("g9"), at("g64") - at("g60")), (1, 2), "{out}");
}

#[test]
fn the_end_of_a_cut_stays_where_the_path_waits() {
    let folder = Folder::with_model();
    folder.write("waits.mpf", "N1 G17 G90 G71 G64\nN2 G0 X0 Y1 Z0\nN3 G1 X15 F1500\nN4 SPOS=0\nN5 X30\nN6 WAITM(1,1,2)\nN7 Y20\nN8 STOPRE\nN9 X0\nN10 M30\n");
    let (_, out) = compensated(&folder, "waits.mpf", &["--dialect", "sinumerik", "--decimal-point", "unit"]);
    let before = |block: &str| {
        let at = out.find(block).unwrap_or_else(|| panic!("{block}\n{out}"));
        out[..at].lines().last().unwrap().to_owned()
    };
    for (block, end) in [("N4 SPOS=0", "X15"), ("N6 WAITM", "X30"), ("N8 STOPRE", "Y20.")] {
        assert!(before(block).contains(end), "{block}\n{out}");
    }
}

#[test]
fn the_dialect_can_be_stated() {
    let folder = Folder::with_model();
    folder.write("plain.mpf", "G90 G94\nG0 X0 Y0 Z0\nG1 X30 F2400\nY20\nX0\nG4 F2\nG0 Z5\nM30\n");
    // The name of the file states it too.
    let words = ["compensate", "plain.mpf", "-m", "machine.model", "-o", "out.mpf"];
    assert!(folder.prints(&words).contains("dialect: sinumerik, found"));
    assert_eq!(folder.figures(&words)["program"]["dialect"], "sinumerik");
    folder.write("plain.nc", "G90 G94\nG0 X0 Y0 Z0\nG1 X30 F2400\nY20\nX0\nG0 Z5\nM30\n");
    let words = ["compensate", "plain.nc", "-m", "machine.model", "-o", "out.nc", "--decimal-point", "unit"];
    assert!(folder.prints(&words).contains("dialect: fanuc, a guess"));
    let words = ["compensate", "plain.mpf", "-m", "machine.model", "-o", "out.mpf", "--dialect", "sinumerik"];
    assert_eq!(folder.figures(&words)["changed"], true);
    let words = ["compensate", "plain.mpf", "-m", "machine.model", "-o", "out.mpf", "--controller", "siemens"];
    assert_eq!(folder.figures(&words)["changed"], true);
    assert!(folder.read("out.mpf").starts_with("; PRECOMP "));
    // A program of the control's ISO dialect is read as such.
    folder.write("iso.nc", PART);
    let words = ["compensate", "iso.nc", "-m", "machine.model", "-o", "out.nc", "--controller", "siemens"];
    let figures = folder.figures(&words);
    assert_eq!((&figures["changed"], &figures["left_alone"]["feed_length_share"]), (&true.into(), &0.0.into()));
}
