//! Production programs: kept byte for byte, interpreted or refused for the expected reason.

use std::collections::HashMap;

use gcode::{Dialect, Edits, Fixed, GcodeError, MoveKind, Plane, Program, Shiftable, Toolpath, edit, interpret, parse};

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data/gcode/");

fn load(name: &str) -> Option<Program> {
    match std::fs::read(format!("{FOLDER}{name}")) {
        Ok(bytes) => Some(parse(bytes)),
        Err(error) if std::env::var("CI").as_deref() == Ok("true") => panic!("{name}: {error}"),
        Err(_) => {
            println!("skipped: ../shared is not there");
            None
        }
    }
}

fn read(program: &Program) -> Toolpath {
    match interpret(program, &Dialect::detect(program).into()) {
        Ok(toolpath) => toolpath,
        Err(error) => panic!("{error}"),
    }
}

fn feed_length_mm(toolpath: &Toolpath) -> f64 {
    toolpath.moves.iter().filter(|m| m.is_feed()).filter_map(|m| m.length_mm()).sum()
}

/// File, blocks, lines, arcs, cycles, shiftable moves.
const FILES: [(&str, usize, usize, usize, usize, usize); 11] = [
    ("cncjs_helical-thread-milling.gcode", 16, 2, 10, 0, 0),
    ("cncjs_tball.gcode", 2708, 2681, 0, 0, 2679),
    ("easyplot_BOTTLE.nc", 3461, 1315, 2051, 0, 3366),
    ("easyplot_TEST_G91.nc", 168, 45, 76, 0, 9),
    ("easyplot_VINT_360arc.nc", 47, 2, 26, 0, 28),
    ("gcoders__program_3.gcode", 411, 85, 286, 0, 371),
    ("nist_827-9999-904_op2.nc", 2226, 1263, 509, 8, 1262),
    ("nist_box_op4_engraving.nc", 5223, 5094, 27, 0, 5121),
    ("nist_box_op5_cavity.nc", 18767, 16171, 1860, 24, 18031),
    ("nist_cover.nc", 1465, 1402, 0, 0, 1402),
    ("nist_plate_14.nc", 4161, 1491, 2223, 4, 3714),
];

#[test]
fn every_file_comes_back_byte_for_byte() {
    let names = FILES.iter().map(|file| file.0).chain(["cncjs_Circle_Diamond_Square_Calibration.gcode"]);
    for program in names.filter_map(load) {
        assert_eq!(edit(&program, &Edits::new()).as_deref(), Ok(program.bytes()));
    }
}

#[test]
fn moves_are_counted() {
    for (name, blocks, lines, arcs, cycles, shiftable) in FILES {
        let Some(program) = load(name) else { return };
        let path = read(&program);
        let count = |wanted: fn(&MoveKind) -> bool| path.moves.iter().filter(|m| wanted(&m.kind)).count();
        let counted = (
            program.blocks().len(),
            count(|kind| matches!(kind, MoveKind::Line)),
            count(|kind| matches!(kind, MoveKind::Arc(_))),
            count(|kind| matches!(kind, MoveKind::Cycle(_))),
            path.moves.iter().filter(|m| m.shiftable == Shiftable::Yes).count(),
        );
        assert_eq!(counted, (blocks, lines, arcs, cycles, shiftable), "{name}");
        // The path is continuous: if both are known, a move starts at the end of the last one.
        for pair in path.moves.windows(2) {
            if let (Some(end), Some(start)) = (pair[0].end.xyz_mm(), pair[1].start.xyz_mm()) {
                assert_eq!(end, start, "{name}, line {}", pair[1].block + 1);
            }
        }
        for step in path.moves.iter().filter(|m| m.is_feed()) {
            let (reached, end) = (step.point_mm(1.0), step.end.nominal_mm());
            assert!(reached.iter().zip(end).all(|(a, b)| (a - b).abs() < 1e-6), "{name}, line {}", step.block + 1);
        }
    }
}

/// Path length by independent code: no tokens, no modal tables, arc angles from cross and dot
/// product.
fn plain_length_mm(text: &str) -> f64 {
    let (mut total, mut unit, mut mode, mut position) = (0.0, 1.0, 0, [0.0_f64; 3]);
    for line in text.lines() {
        let line = line.split(['(', ';']).next().unwrap_or_default();
        let mut words: HashMap<char, f64> = HashMap::new();
        let mut codes = Vec::new();
        for piece in line.split_inclusive(char::is_alphabetic).collect::<Vec<_>>().windows(2) {
            let letter = piece[0].chars().last().unwrap_or(' ').to_ascii_uppercase();
            let number = piece[1].trim_end_matches(char::is_alphabetic).trim().parse().unwrap_or(f64::NAN);
            if letter == 'G' {
                codes.push(number);
            } else {
                words.insert(letter, number);
            }
        }
        for code in &codes {
            match *code {
                20.0 => unit = 25.4,
                21.0 => unit = 1.0,
                0.0 | 1.0 | 2.0 | 3.0 | 81.0 => mode = *code as i32,
                80.0 => mode = 0,
                _ => {}
            }
        }
        if codes.contains(&28.0) {
            continue;
        }
        let from = position;
        for (axis, letter) in ['X', 'Y', 'Z'].iter().enumerate() {
            if let (Some(value), true) = (words.get(letter), mode != 81 || axis != 2) {
                position[axis] = value * unit;
            }
        }
        let rise = position[2] - from[2];
        let moved = ["X", "Y", "Z", "I", "J"].iter().any(|w| words.contains_key(&w.chars().next().unwrap_or(' ')));
        total += match mode {
            1 => (position[0] - from[0]).hypot(position[1] - from[1]).hypot(rise),
            2 | 3 if moved => {
                let offset = ['I', 'J'].map(|w| words.get(&w).copied().unwrap_or(0.0) * unit);
                let a = [-offset[0], -offset[1]];
                let b = [position[0] - from[0] - offset[0], position[1] - from[1] - offset[1]];
                let turn = if mode == 3 { 1.0 } else { -1.0 };
                let angle = (turn * (a[0] * b[1] - a[1] * b[0])).atan2(a[0] * b[0] + a[1] * b[1]);
                let closed = (position[0] - from[0]).hypot(position[1] - from[1]) < 1e-9;
                let angle = if closed { std::f64::consts::TAU } else { angle.rem_euclid(std::f64::consts::TAU) };
                (angle * 0.5 * (a[0].hypot(a[1]) + b[0].hypot(b[1]))).hypot(rise)
            }
            _ => 0.0,
        };
    }
    total
}

/// Rounded arcs are spirals. The independent code ignores their change of radius: a few µm over 14
/// m.
#[test]
fn path_lengths_agree_with_a_plain_computation() {
    for (name, tolerance_mm) in
        [("cncjs_tball.gcode", 1e-6), ("nist_cover.nc", 1e-6), ("nist_plate_14.nc", 1e-2), ("nist_box_op4_engraving.nc", 1e-3)]
    {
        let Some(program) = load(name) else { return };
        let (found, plain) = (feed_length_mm(&read(&program)), plain_length_mm(&String::from_utf8_lossy(program.bytes())));
        assert!(found > 100.0 && (found - plain).abs() < tolerance_mm, "{name}: {found} mm, plainly {plain} mm");
    }
}

#[test]
fn a_helix_of_turns_has_the_length_of_its_turns() {
    let Some(program) = load("easyplot_VINT_360arc.nc") else { return };
    let length = feed_length_mm(&read(&program));
    // 23 helical turns of radius 15 and pitch 1, one flat turn, and each lead-in and lead-out a
    // line and an arc of radius 5.867.
    let turns = 23.0 * (std::f64::consts::TAU * 15.0).hypot(1.0) + std::f64::consts::TAU * 15.0;
    let leads = 5.365_f64.hypot(4.496) + (std::f64::consts::PI - 4.496_f64.atan2(3.768)) * 5.8665;
    assert!((length - turns - 2.0 * leads).abs() < 0.01, "{length} against {}", turns + 2.0 * leads);
}

#[test]
fn a_faulty_arc_in_a_published_file_is_found() {
    let Some(program) = load("cncjs_Circle_Diamond_Square_Calibration.gcode") else { return };
    let Err(GcodeError::Refused { diagnostics }) = interpret(&program, &Dialect::Fanuc.into()) else {
        panic!("line 624 is faulty")
    };
    let lines: Vec<_> = diagnostics.iter().filter(|d| d.is_error()).map(|d| d.line).collect();
    assert_eq!(lines, [624, 696, 768, 840, 912]);
    assert!(diagnostics[0].render(&program, "c.nc").contains("29.0000 mm at the start and 27.5862 mm at the end"));
    // The sign of I is wrong in this block. With the sign of the other three corners the program is
    // accepted.
    let mended = String::from_utf8_lossy(program.bytes()).replace("X21 Y-20 I20 J21", "X21 Y-20 I-20 J21");
    let path = read(&parse(mended));
    assert_eq!(path.moves.iter().filter(|m| matches!(m.kind, MoveKind::Arc(_))).count(), 80);
}

#[test]
fn a_sphere_in_the_zx_plane_turns_the_short_way() {
    let Some(program) = load("easyplot_BOTTLE.nc") else { return };
    let path = read(&program);
    assert!(path.warnings.iter().any(|w| w.message.contains("arc centres are read as absolute")));
    let mut seen = 0;
    for step in &path.moves {
        if let MoveKind::Arc(arc) = step.kind
            && arc.plane != Plane::Xy
        {
            seen += 1;
            assert!(arc.sweep.abs() < std::f64::consts::PI, "line {}", step.block + 1);
        }
    }
    assert!(seen > 300, "{seen} arcs in G18 and G19");
}

#[test]
fn cutter_compensation_is_left_to_the_control() {
    for (name, fixed) in [("cncjs_helical-thread-milling.gcode", 11), ("nist_827-9999-904_op2.nc", 510)] {
        let Some(program) = load(name) else { return };
        let path = read(&program);
        assert_eq!(path.moves.iter().filter(|m| m.shiftable == Shiftable::No(Fixed::CutterCompensation)).count(), fixed);
    }
}
