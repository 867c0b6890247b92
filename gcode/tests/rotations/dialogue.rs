//! Frames of dialogue: rotations of CYCL DEF 10, mirror images of CYCL DEF 8, datum shifts.

use super::{YES, are_alike, feeds, turned};
use gcode::{Dialect, Toolpath};

fn read(text: &str) -> Toolpath {
    super::read(Dialect::Fanuc, text)
}

/// A program whose two last moves follow these blocks and a position.
fn around(blocks: &str) -> String {
    format!(
        "0 BEGIN PGM A MM\nTOOL CALL 1 Z S5000 F600\nL X+0 Y+0 Z+0 FMAX\n{blocks}\nL X+1 Y+1 Z+0 FMAX\nL X+5 F100\nL Y+7\nEND PGM A MM\n"
    )
}

#[test]
fn cycle_10_turns_the_working_plane_about_the_datum() {
    let write = |on: &str, off: &str, turn: &dyn Fn([f64; 2]) -> [f64; 2]| {
        let at = |point: [f64; 2]| {
            let [x, y] = turn(point);
            format!("X{x:+.12} Y{y:+.12}")
        };
        let by = |point: [f64; 2]| {
            let (from, to) = (turn([0.0; 2]), turn(point));
            format!("IX{:+.12} IY{:+.12}", to[0] - from[0], to[1] - from[1])
        };
        let blocks = [
            format!("L {} Z+5 R0 FMAX", at([0.0, 0.0])),
            "L Z-1 F300".to_owned(),
            format!("L {} F600", at([20.0, 0.0])),
            format!("CC {}", at([20.0, 10.0])),
            format!("C {} DR+", at([30.0, 10.0])),
            format!("CR {} R+5 DR-", at([34.0, 14.0])),
            format!("L {}", by([-3.0, 8.0])),
            format!("CT {}", at([20.0, 40.0])),
            format!("L {}", at([0.0, 40.0])),
        ];
        format!(
            "0 BEGIN PGM A MM\nTOOL CALL 1 Z S5000 F600\nL X+0 Y+0 Z+5 FMAX\n{on}{}\n{off}L X+1 Y+2 Z+5 FMAX\nL Z-1\nL X+9\nEND PGM A MM\n",
            blocks.join("\n")
        )
    };
    let plain = |point: [f64; 2]| point;
    let off = "CYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT+0\n";
    let on = "CYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT+37\n";
    are_alike(&read(&write(on, off, &plain)), &read(&write("", "", &|point| turned([0.0; 2], 37.0, point))), on);
    let shift = "CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+12\nCYCL DEF 7.2 Y-8\n";
    let back = "CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+0\nCYCL DEF 7.2 Y+0\n";
    let shifted = |point: [f64; 2]| [point[0] + 12.0, point[1] - 8.0];
    // An angle replaces the one before.
    let on = format!("{shift}CYCL DEF 10.1 ROT+5\nL X+0 Y+0 FMAX\n{on}");
    let path = read(&write(&on, &format!("{off}{back}"), &plain));
    are_alike(&path, &read(&write("", "", &|point| shifted(turned([0.0; 2], 37.0, point)))), &on);
    assert!(feeds(&path).iter().all(|shiftable| *shiftable == YES), "{:?}", path.warnings);
}

#[test]
fn cycle_8_mirrors_the_plane_about_the_datum() {
    let head = "0 BEGIN PGM A MM\nTOOL CALL 1 Z S5000 F600\nL X+0 Y+0 Z+5 FMAX\n";
    let tail = "L X+1 Y+2 Z+5 FMAX\nL Z-1\nL X+9\nEND PGM A MM\n";
    let shift = "CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+12\nCYCL DEF 7.2 Y-8\n";
    let contour = |place: &dyn Fn([f64; 2]) -> [f64; 2], flips: bool| {
        let at = |point: [f64; 2]| {
            let [x, y] = place(point);
            format!("X{x:+} Y{y:+}")
        };
        let [left, right] = if flips { ["DR-", "DR+"] } else { ["DR+", "DR-"] };
        let by = |point: [f64; 2]| {
            let (from, to) = (place([0.0; 2]), place(point));
            format!("IX{:+} IY{:+}", to[0] - from[0], to[1] - from[1])
        };
        [
            format!("L {} Z+5 R0 FMAX", at([0.0, 0.0])),
            "L Z-1 F300".to_owned(),
            format!("L {} F600", at([20.0, 0.0])),
            format!("CC {}", at([20.0, 10.0])),
            format!("C {} {left}", at([30.0, 10.0])),
            format!("CR {} R+5 {right}", at([34.0, 14.0])),
            format!("L {}", by([-3.0, 8.0])),
            format!("CT {}\n", at([20.0, 40.0])),
        ]
        .join("\n")
    };
    let plain = contour(&|point| point, false);
    type Place<'a> = &'a dyn Fn([f64; 2]) -> [f64; 2];
    let cases: [(&str, Place<'_>, bool); 3] =
        [("X", &|[x, y]| [-x, y], true), ("Y", &|[x, y]| [x, -y], true), ("X Y", &|[x, y]| [-x, -y], false)];
    for (axes, place, flips) in cases {
        for (shift, by) in [("", [0.0; 2]), (shift, [12.0, -8.0])] {
            let back = if shift.is_empty() { "" } else { "CYCL DEF 7.1 X+0\nCYCL DEF 7.2 Y+0\n" };
            let on = format!("{shift}CYCL DEF 8.0 MIRROR IMAGE\nCYCL DEF 8.1 {axes}\n");
            let path = read(&format!("{head}{on}{plain}CYCL DEF 8.0 MIRROR IMAGE\nCYCL DEF 8.1\n{back}{tail}"));
            let moved = |point: [f64; 2]| {
                let [x, y] = place(point);
                [x + by[0], y + by[1]]
            };
            are_alike(&path, &read(&format!("{head}{}{tail}", contour(&moved, flips))), &on);
            assert!(feeds(&path).iter().all(|shiftable| *shiftable == YES), "{on}: {:?}", path.warnings);
            assert!(path.warnings.is_empty(), "{on}: {:?}", path.warnings);
        }
    }
}

#[test]
fn a_datum_shift_is_known_again_when_all_its_axes_are_stated() {
    for between in [
        "CYCL DEF 7.1 #5\nCYCL DEF 7.0\nCYCL DEF 7.1 X+0\nCYCL DEF 7.2 Y+0\nCYCL DEF 7.3 Z+1",
        "CYCL DEF 7.1 X+Q5\nCYCL DEF 7.1 X+3",
        "CYCL DEF 7.1 X+Q5 Y+2\nTRANS DATUM RESET",
        "CYCL DEF 8.1 X\nCYCL DEF 7.1 X+10\nCYCL DEF 8.1\nCYCL DEF 7.1 X+4",
        // None is none in every frame.
        "CYCL DEF 7.1 X+9\nCYCL DEF 10.1 ROT+30\nCYCL DEF 7.1 X+0\nCYCL DEF 10.1 ROT+0",
    ] {
        let path = read(&around(between));
        assert_eq!(feeds(&path), [YES; 2], "{between}: {:?}", path.warnings);
    }
}

#[test]
fn uncertain_rotations_of_dialogue_are_left_alone() {
    for body in [
        "CYCL DEF 10.1 IROT+30",
        "CYCL DEF 10.1 ROT+Q1",
        "CYCL DEF 10.1 ROT+30 X+5",
        "CYCL DEF 8.1 X\nCYCL DEF 10.1 ROT+30",
        "CYCL DEF 10.1 ROT+30\nCYCL DEF 8.1 X",
        "CYCL DEF 10.1 ROT+30\nCYCL DEF 8.1 X\nCYCL DEF 8.1",
        "CYCL DEF 8.1 Z",
        "CYCL DEF 8.1 X Z",
        "CYCL DEF 8.1 X X",
        "CYCL DEF 8.1 X+5",
        "CYCL DEF 8.1 Q1",
        "CYCL DEF 8.1 X\nCYCL DEF 8.1 Y",
        "CYCL DEF 8.1 X\nCYCL DEF 7.1 X+5",
        "CYCL DEF 8.1 X\nCYCL DEF 7.0\nCYCL DEF 7.1 X+10\nCYCL DEF 8.0\nCYCL DEF 8.1",
        "CYCL DEF 10.1 ROT+30\nCYCL DEF 7.1 X+10\nCYCL DEF 10.1 ROT+0",
        "CYCL DEF 10.1 ROT+30\nTRANS DATUM AXIS X+10\nCYCL DEF 10.1 ROT+0",
        "CYCL DEF 11.1 SCL2\nCYCL DEF 7.1 X+10\nCYCL DEF 11.1 SCL1",
        "CYCL DEF 7.1 X+Q5\nCYCL DEF 7.0\nCYCL DEF 7.1 Y+10\nCYCL DEF 8.1 X",
        "CYCL DEF 7.1 X+Q5\nCYCL DEF 7.0\nCYCL DEF 7.1 IX+10",
        "CYCL DEF 7.1 #5\nCYCL DEF 7.0\nCYCL DEF 7.1 X+0\nCYCL DEF 7.2 Y+0",
        "CYCL DEF 8.1 X\nCYCL DEF 11.1 SCL2",
        "CYCL DEF 8.1 X\nCYCL DEF 10.1 ROT+0",
        "CYCL DEF 8.1 X\nCYCL DEF 10.1 ROT+30\nCYCL DEF 10.1 ROT+0",
        "CYCL DEF 8.1 X\nCYCL DEF 10.1 ROT+30\nCYCL DEF 8.1",
        "CYCL DEF 8.1 X\nPLANE RESET STAY",
        "CYCL DEF 8.1 X\nTOOL CALL 2 Y S100",
        "CYCL DEF 8.1 X\nTRANS DATUM AXIS X+5",
        "L X+5 RL F100\nCYCL DEF 8.1 X\nL X+6 R0",
        "/CYCL DEF 8.1 X",
        "CYCL DEF 8.1 X\n/CYCL DEF 8.1",
        "CYCL DEF 10.1 ROT+30\nCYCL DEF 11.1 SCL2",
        "CYCL DEF 10.1 ROT+30\nCYCL DEF 7.1 X+5",
        "CYCL DEF 10.1 ROT+30\nTRANS DATUM AXIS X+5",
        "CYCL DEF 10.1 ROT+30\nCYCL DEF 247 DATUM SETTING ~\n  Q339=+2 ;DATUM NUMBER",
        "CYCL DEF 10.1 ROT+30\nTOOL CALL 2 Y S100",
        "CYCL DEF 10.1 ROT+30\nPLANE RESET STAY",
        "CYCL DEF 10.1 ROT+30\nL M143",
        "L X+5 RL F100\nCYCL DEF 10.1 ROT+30\nL X+6 R0",
        "/CYCL DEF 10.1 ROT+30",
        "/CYCL DEF 7.1 X+30",
        "CYCL DEF 10.1 ROT+30\n/CYCL DEF 10.1 ROT+0",
    ] {
        let path = read(&around(body));
        let last = feeds(&path);
        assert!(last[last.len() - 2..].iter().all(|shiftable| *shiftable != YES), "{body}: {last:?}");
        assert!(!path.warnings.is_empty(), "{body}");
    }
    // With a rotary axis anywhere.
    let text = "0 BEGIN PGM A MM\nL X+0 Y+0 Z+0 F600\nCYCL DEF 10.1 ROT+30\nL X+1 Y+1 Z+0\nL X+5\nCYCL DEF 10.1 ROT+0\nL B+5\nEND PGM A MM\n";
    let path = read(text);
    assert_ne!(feeds(&path)[2], YES);
}
