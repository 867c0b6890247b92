//! Offsets of program zero, and what makes a position unknown.

use gcode::{Axis, Dialect, Fixed, Options, Shiftable, interpret, parse};

use crate::{close, feeds, last, read, read_as};

#[test]
fn shifts_leave_no_jump() {
    for shift in ["G92 X0 Y0", "G52 X10 Y5"] {
        let path = read(&format!("G21 G0 X10 Y5 Z0\nG1 X20 F100\nG0 X10 Y5\n{shift}\nG1 X10 Y0\n"));
        let step = last(&path);
        close(step.start.xyz_mm().expect("known"), [10.0, 5.0, 0.0]);
        close(step.end.xyz_mm().expect("known"), [20.0, 5.0, 0.0]);
        assert_eq!(path.modal(&step).shift[..2], [10.0, 5.0]);
        assert_eq!(path.programmed(&step, [10.0; 6], [20.0; 6])[0], 10.0);
    }
    let back = read("G21 G0 X10 Y5 Z0\nG92 X0\nG92.2\nG1 X12 F100\nG92.3\nX3\nG92.1\nX10\n");
    let ends: Vec<_> = back.moves[1..].iter().map(|m| m.end.axis(Axis::X)).collect();
    assert_eq!(ends, [Some(12.0), Some(13.0), Some(10.0)]);
    let fresh = read("G21 G92 X0 Y0 Z0\nG1 X1 F100\n");
    assert_eq!(last(&fresh).shiftable, Shiftable::Yes);
    // G52 of LinuxCNC replaces the offset of that G92, which is not known.
    let replaced = "G21 G92 X0 Y0 Z0\nG1 X1 F100\nG52 X2\nG1 Y1\nG1 X1\nG1 Y2\n";
    let unknown = [true, false, false, true];
    for (dialect, is_dialect_stated, expected) in
        [(Dialect::LinuxCnc, true, unknown), (Dialect::Fanuc, true, [true; 4]), (Dialect::Fanuc, false, unknown)]
    {
        let path = interpret(&parse(replaced), &Options { is_dialect_stated, ..dialect.into() }).unwrap();
        let shiftable: Vec<bool> = path.moves.iter().map(|m| m.shiftable == Shiftable::Yes).collect();
        assert_eq!(shiftable, expected, "{dialect:?}");
    }
}

#[test]
fn what_makes_a_start_unknown() {
    for (between, known) in [
        ("", true),
        ("G28 G91 Z0\nG90", false),
        ("G55", false),
        ("G54", true),
        ("G10 L2 P1 X1", false),
        ("G10 L2 P2 X1", true),
        ("G10 L2 P2 R0", true),
        ("G1 U5 F100", false),
        ("G1 W-5 F100", false),
        ("G4 U1.", true),
        ("G10 L2 P#1 X#2", false),
        ("G53 G0 X1", false),
        ("G0 X#1", false),
        ("M6 T1", false),
        ("T1 M6\nG0 X0 Y0", false),
        ("T1 M6\nG0 X0 Y0 Z0", true),
        ("M60", false),
        ("G43 H1", false),
        ("G43 H1 Z0", true),
        ("G43 H1 Z0\nH2", false),
        // An earlier program may have left a tool length or a shift.
        ("G49", false),
        ("G49\nG0 Z0\nG49", true),
        ("G43 H1 Z0\nG49", false),
        ("G31 Z-1 F10", false),
        ("G4 P100", true),
        ("G68 X0 Y0 R30\nG0 X1\nG69", false),
        ("G54.1 P1", false),
        ("G92.1", false),
        ("G92.1\nG0 X0 Y0 Z0\nG92.1", true),
        ("G53", false),
        ("G80", true),
    ] {
        let path = read(&format!("G21 G90 G54 G0 X0 Y0 Z0\n{between}\nG1 X1 Y1 F100\n"));
        let expected = if known { Shiftable::Yes } else { Shiftable::No(Fixed::UnknownStart) };
        assert_eq!(last(&path).shiftable, expected, "{between}");
    }
    // As an earlier program may have left another offset.
    for dialect in [Dialect::Fanuc, Dialect::LinuxCnc] {
        let path = read_as(dialect, "G21 G90 G0 X0 Y0 Z0\nG54\nG1 X1 Y1 F100\nZ1\nG54\nX2\n");
        let starts: Vec<_> = path.moves.iter().filter(|m| m.is_feed()).map(|m| m.shiftable == Shiftable::Yes).collect();
        assert_eq!(starts, [false, false, true], "{dialect:?}");
    }
    let linux = read_as(Dialect::LinuxCnc, "G21 G90 G0 X0 Y0 Z0\nG43 H1\nG1 X1 F100\nZ1\nX2\n");
    let starts: Vec<_> = linux.moves[1..].iter().map(|m| m.shiftable == Shiftable::Yes).collect();
    assert_eq!(starts, [false, false, true]);
    for change in ["T=\"B\"\nM6\nD1", "D2", "T=\"B\" M6"] {
        let of = read_as(Dialect::Sinumerik, &format!("G71 G90\nG0 X0 Y0 Z0\n{change}\nG1 X1 Y2 F100\nG1 Z0\nX2\n"));
        let feeds: Vec<_> = of.moves.iter().filter(|m| m.is_feed()).map(|m| m.shiftable == Shiftable::Yes).collect();
        assert_eq!(feeds, [false, false, true], "{change}");
    }
    // An offset that the program states may concern any axis, until the next code.
    let stated = read_as(
        Dialect::LinuxCnc,
        "G21 G90 G0 X0 Y0 Z0\nG43.1 Y1 Z-2\nG0 X0 Z0\nG1 X1 F100\nG0 X0 Y0\nG1 X1\nG49\nG0 X0 Z0\nG1 X2\nG0 Y0\nG1 X3\n",
    );
    let feeds: Vec<_> = stated.moves.iter().filter(|m| m.is_feed()).map(|m| m.shiftable == Shiftable::Yes).collect();
    assert_eq!(feeds, [false, true, false, true]);
    let flat = read("G21 G0 X0 Y0\nG1 X1 F100\n");
    assert_eq!(last(&flat).shiftable, Shiftable::Yes, "Z is never named");
}

#[test]
fn what_an_optional_block_moves_is_unknown_until_it_is_stated() {
    let text = "G21 G90\nG0 X0 Y0 Z0\n/G1 X10 F600\nG1 Y5 F600\nX20\nY9\nG91 X5\nG90 X0\n";
    let of = |block_delete: Option<bool>| -> Vec<bool> {
        let options = Options { block_delete, ..Options::default() };
        let path = interpret(&parse(text), &options).expect("valid");
        path.moves.iter().filter(|step| step.is_feed()).map(|step| step.shiftable == Shiftable::Yes).collect()
    };
    assert_eq!(of(None), [false, false, false, true, true, true]);
    assert_eq!(of(Some(false)), [true; 6]);
    assert_eq!(of(Some(true)), [true; 5]);
}

#[test]
fn after_g40_the_tool_is_beside_the_contour() {
    let part = "G21 G90 G17 F600\nG0 X0 Y0 Z0\nG41 D1\nG1 X10\nG40\nG1 X20\nG1 Y5\nX0\n";
    let (beside, comp, yes) = (Shiftable::No(Fixed::UnknownStart), Shiftable::No(Fixed::CutterCompensation), Shiftable::Yes);
    assert_eq!(feeds(part, Dialect::LinuxCnc), [comp, beside, beside, yes]);
    // A Fanuc control takes the radius back in the block with G40 if that moves.
    let part = part.replace("G40\nG1 X20", "G40 G1 X20");
    assert_eq!(feeds(&part, Dialect::Fanuc), [comp, comp, yes, yes]);
    assert_eq!(feeds(&part, Dialect::LinuxCnc), [comp, comp, beside, yes]);
}

#[test]
fn a_restored_g92_is_another_frame() {
    let part = "G21 G90 F600\nG0 X0 Y0 Z0\nG92 X5\nG1 X10\nG92.3\nG1 X20\nG1 Y5 Z1\nX0\n";
    let (unknown, yes) = (Shiftable::No(Fixed::UnknownStart), Shiftable::Yes);
    assert_eq!(feeds(part, Dialect::LinuxCnc), [yes, unknown, unknown, yes]);
}
