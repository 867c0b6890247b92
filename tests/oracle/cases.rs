//! Blocks that were once written wrongly, each with what the output has to hold. Needs no LinuxCNC.

use gcode::{DecimalPoint, Dialect};
use pipeline::refit::TimeEncoding;
use pipeline::{Error, Part, ReadSettings};

use crate::compensate::{Way, read, setup, write};

fn way(controller: &'static str, encoding: TimeEncoding) -> Way {
    Way { controller, encoding, decimals: 4, block_delete: None }
}

/// The program, written with a correction of up to 50 µm.
fn written(program: &str, way: Way) -> String {
    let part = read(program.as_bytes(), &way).unwrap();
    let shifted = (1..20).map(|seed| write(read(program.as_bytes(), &way).unwrap(), &way, seed).unwrap());
    let largest = shifted.max_by_key(|output| output.bytes.len()).unwrap();
    assert!(part.borders().iter().any(|border| *border));
    assert_ne!(largest.bytes, program.as_bytes(), "nothing was shifted");
    String::from_utf8(largest.bytes).unwrap()
}

/// The program in the feeds of its own, on a control of no profile.
fn kept(program: &str) -> String {
    written(program, way("generic", TimeEncoding::Keep))
}

/// The line before the one that begins with `head`.
fn before<'a>(text: &'a str, head: &str) -> &'a str {
    let at = text.lines().position(|line| line.starts_with(head)).unwrap();
    text.lines().nth(at - 1).unwrap()
}

#[test]
fn a_move_left_alone_starts_where_the_program_states_it() {
    for after in [
        "G92 X0\nG1 X10",
        "G91 G28 Z0\nG90 G1 X10 Y10 Z0",
        "G1 A90\nG1 X0",
        "G10 L20 P1 X5\nG1 X5",
        "M6 T2\nG1 X0",
        "G28.1\nG1 X0",
        "G43 H1\nG1 X0",
        "#1=#5420\nG1 X0",
    ] {
        let text = kept(&format!("G21 G90 G17\nG0 X0 Y0 Z0\nG1 X40.12345 F2400\nY20.54321\n{after}\nG1 Y0\nM2\n"));
        let head = after.lines().next().unwrap();
        assert!(before(&text, head).contains("Y20.54321"), "{after}: {text}");
    }
}

#[test]
fn an_arc_left_alone_starts_where_the_program_states_it() {
    let text = kept("G21 G90 G17\nG0 X0 Y0 Z0\nG1 X40.12345 F2400\nG61 G3 X41.12345 Y1 I0 J1\nG64 G1 X60\nM2\n");
    assert!(before(&text, "G61").contains("X40.12345"), "{text}");
}

#[test]
fn an_axis_without_words_gets_none() {
    for encoding in [TimeEncoding::Keep, TimeEncoding::G93, TimeEncoding::G94] {
        let text = written("G21 G90 G17\nG0 X0 Y0\nG1 X40 F2400\nG3 X40 Y20 I0 J10\nG1 X0\nM2\n", way("linuxcnc", encoding));
        assert!(!text.contains('Z'), "{text}");
        let text = written("G21 G90 G17\nG0 Y0 Z5\nG1 Y40 F2400\nG1 Z2\nY0\nM2\n", way("linuxcnc", encoding));
        assert!(!text.contains('X'), "{text}");
    }
}

#[test]
fn coolant_and_spindle_stop_where_they_did() {
    let text = kept("G21 G90\nG0 X0 Y0 Z0\nG1 X40 F2400 M9\nG1 Y40 M0\nG1 X0\nM2\n");
    let (stop, off) = (text.find("M0").unwrap(), text.find("M9").unwrap());
    assert!(text[..off].matches("X").count() == 2, "M9 acts before its motion: {text}");
    assert!(text[..stop].contains("Y40.") || before(&text, "G1 X").contains("M0"), "M0 acts after its motion: {text}");
}

#[test]
fn the_p_of_an_m_code_stays_beside_a_path_mode() {
    let text = written("G21 G90\nG0 X0 Y0 Z0\nG1 X40 F2400\nG64 Y40 M63 P1\nX0\nM2\n", way("linuxcnc", TimeEncoding::Keep));
    assert!(text.lines().any(|line| line.contains("M63 P1")), "{text}");
}

#[test]
fn the_turns_of_an_arc_are_written_out() {
    let text = kept("G21 G90 G17\nG0 X0 Y0 Z0\nG1 X10 F2400\nG3 X10 Y0 Z2 I-5 J0 P3\nG1 X0\nM2\n");
    assert!(!text.contains('P'), "{text}");
}

#[test]
fn a_motion_code_alone_in_its_block_does_not_govern_written_lines() {
    let part = "G21 G90 G17\nG0 X0 Y0 Z0\nG1 X10 F2400\nG3\nX10 Y20 I0 J10\nG1\nX0\nM2\n";
    let text = kept(part);
    let after = text.lines().skip_while(|line| *line != "G3").nth(1).unwrap();
    assert!(after.starts_with("G3X"), "{text}");
    // LinuxCNC refuses a motion code without F in inverse time.
    let timed = written(part, way("linuxcnc", TimeEncoding::G93));
    assert!(!timed.lines().any(|line| line == "G3" || line == "G1"), "{timed}");
}

#[test]
fn a_change_of_the_path_mode_starts_where_the_program_states_it() {
    let text = kept("G21 G90 G17\nG0 X0 Y0 Z0\nG1 X10 Y5.43215 F2400\nG61.1\nG1 X30\nX40\nM2\n");
    assert!(before(&text, "G61.1").contains("Y5.43215"), "{text}");
}

/// A program read for the control of this profile, which is no LinuxCNC.
fn read_fanuc(program: &str, profile: &'static str, decimal_point: Option<DecimalPoint>) -> Result<Part, Error> {
    let settings = ReadSettings { dialect: Some(Dialect::Fanuc), decimal_point, ..ReadSettings::default() };
    Part::read("integers.nc", program, &setup(profile), &settings)
}

const INTEGERS: &str = "G21 G90 G17\nG0 X0 Y0 Z0\nG1 X40000 F2400\nG3 Y20000 J10000\nG1 X0\nG0 Z5000\nM30\n";

#[test]
fn a_program_without_decimal_points_is_a_question_unless_the_control_answers_it() {
    let Err(Error::Program { text, .. }) = read_fanuc(INTEGERS, "fanuc", None) else { panic!("it is read") };
    assert!(text.contains("X40000 has no decimal point") && text.contains("--decimal-point least-increment"), "{text}");
    // This control reads mm, and no machine is 40 m long: the program was written for another one.
    assert!(read_fanuc(INTEGERS, "grbl", None).is_err());
    assert!(read_fanuc(&INTEGERS.replace("0000", "00"), "grbl", None).is_ok());
    assert!(read_fanuc(INTEGERS, "fanuc", Some(DecimalPoint::Unit)).is_ok());
    let mixed = INTEGERS.replace("Z5000", "Z5.");
    assert!(read_fanuc(&mixed, "generic", None).is_err());
}

#[test]
fn a_program_in_increments_stays_in_increments() {
    let part = read_fanuc(INTEGERS, "fanuc", Some(DecimalPoint::LeastIncrement)).unwrap();
    assert_eq!(part.toolpath.moves[1].end.nominal_mm(), [40.0, 0.0, 0.0]);
    let output = write(part, &way("generic", TimeEncoding::Keep), 3).unwrap();
    let text = String::from_utf8(output.bytes).unwrap();
    let written: Vec<&str> =
        text.lines().skip(2).filter(|line| ["G1X", "G3X", "X"].iter().any(|start| line.starts_with(start))).collect();
    assert!(written.len() > 5 && !written.iter().any(|line| line.contains('.')), "{text}");
    let largest = text.split(|c: char| !c.is_ascii_digit()).filter_map(|number| number.parse::<u32>().ok()).max();
    assert!(largest.is_some_and(|largest| (45_000..=50_100).contains(&largest)), "an arc of 10 mm ends right of X40000: {text}");
}
