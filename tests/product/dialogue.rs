//! Heidenhain dialogue: read, compensated and written as dialogue.

use crate::common::{Folder, text};

const PART: &str = "0 BEGIN PGM BRACKET MM\r\n1 BLK FORM 0.1 Z X-40 Y-30 Z-20\r\n2 BLK FORM 0.2 X+40 Y+30 Z+0\r\n\
3 TOOL CALL 1 Z S8000 F2400\r\n4 L Z+50 R0 FMAX M3\r\n5 L X-30 Y-20 R0 FMAX\r\n6 L Z+5 R0 FMAX\r\n7 L Z-1 R0 F900 M8\r\n\
8 L X+30 R0 F AUTO ; first side\r\n9 CC X+30 Y+0\r\n10 C X+30 Y+20 DR+\r\n11 L IX-60\r\n12 CC X-30 Y+0\r\n13 CP IPA+180 IZ-2 DR+\r\n\
14 CC X-20 Y-10\r\n15 C X-30 Y-20 DR- F1200,5\r\n16 L Z+5 FMAX M9\r\n17 CYCL DEF 200 DRILLING ~\r\n    Q200=+2    ;SET-UP ~\r\n    Q201=-20   ;DEPTH\r\n\
18 L X+0 Y+0 R0 FMAX M99\r\n19 L Z+50 R0 FMAX M30\r\n20 END PGM BRACKET MM\r\n";

/// The same part as G-code.
const G_CODE: &str = "G21 G90 G17\nT1 M6\nG0 Z50 S8000 M3\nG0 X-30 Y-20\nG0 Z5\nG1 Z-1 F900 M8\nX30 F2400\nG3 X30 Y20 J20\nG1 X-30\n\
G3 X-30 Y-20 Z-3 J-20\nG2 X-30 Y-20 I10 J10 F1200.5\nG0 Z5 M9\nG0 X0 Y0\nG81 X0 Y0 Z-20 R2 F100\nG80\nG0 Z50\nM30\n";

fn folder() -> Folder {
    let folder = Folder::with_model();
    folder.write("part.h", PART);
    folder.write("part.nc", G_CODE);
    folder
}

#[test]
fn dialogue_is_compensated_as_dialogue() {
    let folder = folder();
    let figures = folder.figures(&["compensate", "part.h", "-m", "machine.model", "-o", "out.h"]);
    assert_eq!(figures["changed"], true);
    assert_eq!(figures["left_alone"]["feed_length_share"], 0.0, "{figures}");
    let g_code = folder.figures(&["compensate", "part.nc", "-m", "machine.model", "-o", "out.nc"]);
    let rms = |of: &serde_json::Value, when: &str| of["predicted_contour_um"][when]["rms"].as_f64().unwrap();
    assert!((rms(&figures, "before") / rms(&g_code, "before") - 1.0).abs() < 0.02, "{figures}{g_code}");
    assert!(rms(&figures, "after") < 0.2 * rms(&figures, "before"), "{figures}");

    let out = folder.read("out.h");
    let lines: Vec<&str> = out.split_terminator("\r\n").collect();
    assert!(lines[1].starts_with("1 ; PRECOMP ") && lines[2].starts_with("2 ; LARGEST SHIFT 0.0"), "{out}");
    assert!(lines[3].starts_with("3 ; TRAINED 20"), "{out}");
    // Blocks are numbered one by one, a line behind ~ has no number.
    let numbers =
        lines.iter().filter(|line| !line.starts_with(' ')).map(|line| line.split(' ').next().unwrap().parse::<usize>().unwrap());
    assert!(numbers.enumerate().all(|(index, number)| index == number), "{out}");
    // Circles are lines, with the decimal mark of the program. Everything but the cut is as it was.
    let first = lines.iter().find(|line| line.contains("; first side")).unwrap();
    assert!(first.contains(" L X-29,9") && first.contains(" R0 F AUTO ; first side"), "{first}");
    let blocks = |text: &str| -> Vec<String> {
        text.lines().map(|line| line.trim_start_matches(|c: char| c.is_ascii_digit()).to_owned()).collect()
    };
    let kept = blocks(PART)
        .into_iter()
        .filter(|line| ["FMAX", "CC", "CYCL", "Q2", "BLK", "TOOL", "PGM"].iter().any(|word| line.contains(word)));
    let written = blocks(&out);
    let mut rest = written.iter();
    kept.for_each(|line| assert!(rest.any(|other| *other == line), "{line} is missing\n{out}"));
    assert!(!written.iter().any(|line| line.starts_with(" C ") || line.starts_with(" CP ")), "{out}");
}

#[test]
fn a_compensated_dialogue_cuts_closer_and_is_not_compensated_again() {
    let folder = folder();
    folder.figures(&["compensate", "part.h", "-m", "machine.model", "-o", "out.h"]);
    let rms = |name: &str| {
        let figures = folder.figures(&["simulate", name, "--against", "part.h", "-o", "run.csv", "--seed", "3"]);
        figures["contour_um"]["rms"].as_f64().unwrap()
    };
    let (before, after) = (rms("part.h"), rms("out.h"));
    assert!(after < 0.5 * before, "{before} → {after} µm");
    let error = folder.fails(1, &["compensate", "out.h", "-m", "machine.model", "-o", "twice.h"]);
    assert!(error.contains("out.h: line 2") && error.contains("give the original"), "{error}");
    rms("part.h");
    folder.figures(&["refine", "part.h", "--log", "run.csv", "-m", "machine.model", "-o", "next.h"]);
    assert!(folder.read("next.h").starts_with("0 BEGIN PGM BRACKET MM\r\n1 ; PRECOMP "));
}

#[test]
fn a_program_without_numbers_and_in_inches_gets_none() {
    let folder = folder();
    let part = "BEGIN PGM A INCH\nTOOL CALL 1 Z S1000\nL X+0 Y+0 Z+0 R0 FMAX\nL X+1.5 F80\nL Y+1.5\nL X+0 Y+0 FMAX M30\nEND PGM A INCH\n";
    folder.write("inch.h", part);
    folder.figures(&["compensate", "inch.h", "-m", "machine.model", "-o", "out.h"]);
    let out = folder.read("out.h");
    assert!(out.starts_with("BEGIN PGM A INCH\n; PRECOMP ") && out.ends_with("\nL X+0 Y+0 FMAX M30\nEND PGM A INCH\n"), "{out}");
    assert!(out.lines().all(|line| !line.starts_with(|c: char| c.is_ascii_digit())), "{out}");
}

#[test]
fn what_is_not_interpreted_stays_and_is_reported() {
    let folder = folder();
    let tilted = PART.replace("11 L IX-60", "11 PLANE SPATIAL SPA+0 SPB+30 SPC+0 STAY\r\n11 L IX-60");
    folder.write("tilted.h", &tilted);
    let said = folder.prints(&["compensate", "tilted.h", "-m", "machine.model", "-o", "out.h"]);
    assert!(said.contains("a tilted working plane is not interpreted") && said.contains("tilted.h:12:4"), "{said}");
    let out = folder.read("out.h");
    assert!(out.contains(" C X-30 Y-20 DR- F1200,5\r\n") && out.contains(" CP IPA+180 IZ-2 DR+\r\n"), "{out}");
}

#[test]
fn feeds_a_turn_under_m136_are_planned_as_such() {
    let folder = folder();
    folder.write(
        "turn.h",
        "0 BEGIN PGM T MM\n1 TOOL CALL 1 Z S5000 F900\n2 L X+0 Y+0 Z+0 R0 FMAX M3\n3 L X+20 F AUTO\n4 L X+0 F0.2 M136\n5 L X+20\n6 L Z+9 FMAX M30\n7 END PGM T MM\n",
    );
    // 20 mm at 900 mm/min and 40 mm at 1000 mm/min.
    let seconds = folder.figures(&["simulate", "turn.h", "-o", "turn.csv"])["seconds"].as_f64().unwrap();
    assert!((3.7..4.6).contains(&seconds), "{seconds}");
    folder.figures(&["compensate", "turn.h", "-m", "machine.model", "-o", "out.h"]);
    assert!(folder.read("out.h").contains(" L X+0 F0.2 M136\n"));
}

#[test]
fn times_of_points_and_a_missing_feed_are_refused() {
    let folder = folder();
    for format in ["g93", "g94"] {
        let error = folder.fails(1, &["compensate", "part.h", "-m", "machine.model", "-o", "out.h", "--format", format]);
        assert!(error.contains("part.h: Heidenhain dialogue keeps its feeds") && error.contains("--format keep"), "{error}");
    }
    folder.write("slow.h", "0 BEGIN PGM A MM\n1 L X+0 Y+0 Z+0 FMAX\n2 L X+10\n3 END PGM A MM\n");
    let error = text(&folder.precomp(&["simulate", "slow.h", "-o", "x.csv"]).stderr);
    assert!(error.starts_with("error: no feed was given") && error.contains("slow.h:3:3"), "{error}");
    assert!(!folder.path("out.h").exists() && !folder.path("x.csv").exists());
}
