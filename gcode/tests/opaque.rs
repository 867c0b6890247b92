//! Sections in which coordinates are not those of the path: their moves are left alone, those before and after them are not.

use gcode::{Dialect, Fixed, Move, Shiftable, Toolpath, interpret, parse};

const BEFORE: &str = "G21 G90 G17 G54\nG0 X0 Y0 Z5.\nG1 Z-1. F600\nX10.\n";
const AFTER: &str = "G1 X3. F600\nG0 X0 Y0 Z5.\nG1 Z-1.\nX5.\nM30\n";

const YES: Shiftable = Shiftable::Yes;
const LEFT: Shiftable = Shiftable::No(Fixed::NotUnderstood);
const UNKNOWN: Shiftable = Shiftable::No(Fixed::UnknownStart);

fn read(dialect: Dialect, text: &str) -> Toolpath {
    interpret(&parse(text), &dialect.into()).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn feeds(path: &Toolpath) -> Vec<Shiftable> {
    path.moves.iter().filter(|step| step.is_feed()).map(|step| step.shiftable).collect()
}

/// A section with the moves `body` is left alone from its first to its last line, and its warning names code and lines.
fn is_left_alone(dialect: Dialect, on: &str, body: &str, off: &str) {
    let path = read(dialect, &format!("{BEFORE}{on}\n{body}{off}\n{AFTER}"));
    let (last, here) = (5 + body.lines().count() + off.lines().count(), feeds(&path));
    let inside: Vec<&Move> = path.moves.iter().filter(|step| (4..last).contains(&(step.block as usize))).collect();
    assert!(inside.iter().any(|step| step.is_feed()), "{on}");
    assert!(inside.iter().filter(|step| step.is_feed()).all(|step| step.shiftable == LEFT), "{on}: {inside:?}");
    assert_eq!(here[..2], [YES, YES], "{on}");
    assert_eq!(here[here.len() - 3..], [UNKNOWN, YES, YES], "{on}");
    let code = on.split([' ', '\n']).next().unwrap_or_default();
    let warning = path.warnings.iter().find(|warning| warning.message.starts_with(code));
    let warning = warning.unwrap_or_else(|| panic!("{on}: {:?}", path.warnings));
    assert_eq!(warning.line, 5, "{on}");
    assert!(warning.message.ends_with(&format!("left alone up to line {last}")), "{on}: {}", warning.message);
}

#[test]
fn turned_scaled_and_polar_moves_are_left_alone() {
    let body = "G1 X20. Y5. F300\nG2 X30. Y5. R5.\nG3 X40. Y5. I5. J0\nG91 G1 X1.\nG90 G0 X1. Y1.\n";
    for (on, off) in [
        ("G68 R30.", "G69"),
        ("G68 X0 Y0 R30. I0 J0 K1.", "G69"),
        ("G68.2 X0 Y0 Z0 I30. J20. K0", "G69"),
        ("G68.2 P1 X0 Y0 Z0 I30. J20. K0", "G69"),
        ("G68.5 X0 Y0 Z0 I0 J1. K0 R45.", "G69"),
        ("G168 X0 Y0 Z0 I30. J0 K0", "G169"),
        ("G268 X0 Y0 Z0 I30. J0 K0", "G269"),
        ("G51 X0 Y0 P2000", "G50"),
        ("G51 X0 Y0 Z0 I-1000 J1000 K1000", "G50"),
        ("G51.1 X5", "G50.1 X0"),
        ("G51.1 X5 Y0", "G50.1 X0\nG50.1 Y0"),
        ("G16", "G15"),
        ("G12.1", "G13.1"),
        ("G112", "G113"),
        ("G107 A0. Y0. R2.", "G107"),
        ("G107 A0. Y0. Q4.", "G107"),
        ("G7.1 C50.", "G7.1 C0"),
        ("G107 C50.", "G107 C0."),
        ("G254", "G255"),
    ] {
        is_left_alone(Dialect::Fanuc, on, body, off);
    }
    is_left_alone(Dialect::LinuxCnc, "G7", "G1 X20. Y5. F300\n", "G8");
}

#[test]
fn words_of_the_mode_need_no_meaning_outside_it() {
    is_left_alone(Dialect::Fanuc, "G12.1", "G41 G1 X20. C10. D1 F300\nC0 ,R2.\nG3 X10. C5. K5. Q2.\nG40 X30.\n", "G13.1");
    is_left_alone(Dialect::Fanuc, "G16", "G1 X20. Y30. P5\nG91 Y30. X1. X2.\nG90\n", "G15");
    // A loop in a section is not edited.
    is_left_alone(Dialect::Fanuc, "G68 R30.", "#1=0\nWHILE[#1LT3]DO1\nG1 X#1\n#1=#1+1\nEND1\n", "G69");
}

#[test]
fn a_tilted_plane_ends_with_its_code_though_the_tool_was_turned_to_it() {
    for turn in ["G53.1", "G53.1 P1", "G53.6 H1", "G253"] {
        let body = format!("{turn}\nG43 H1\nG0 X0 Y0 Z50.\nG1 Z-1. F300\nG2 X30. Y5. R50.\nG0 Z50.\n");
        is_left_alone(Dialect::Fanuc, "G68.2 X0 Y0 Z0 I30. J20. K0", &body, "G69");
    }
}

#[test]
fn a_mirror_image_lasts_until_the_last_of_its_axes_is_named() {
    let path = read(Dialect::Fanuc, &format!("{BEFORE}G51.1 X0 Y0\nG1 X1.\nG50.1 X0\n{AFTER}"));
    assert_eq!(feeds(&path)[2..].iter().filter(|shiftable| **shiftable == YES).count(), 0);
}

#[test]
fn one_transformation_does_not_end_another() {
    let path = read(Dialect::Fanuc, &format!("{BEFORE}G68 X0 Y0 R30.\nG16\nG1 X20.\nG15\n{AFTER}"));
    assert_eq!(feeds(&path)[2..], [LEFT; 4]);
}

#[test]
fn a_cancelling_code_alone_opens_nothing() {
    for code in ["G69", "G50", "G15", "G13.1", "G113", "G107", "G67", "G169", "G269", "G255", "G8"] {
        let path = read(Dialect::Fanuc, &format!("{code}\n{BEFORE}M30\n"));
        assert_eq!(feeds(&path), [YES, YES], "{code}");
    }
}

#[test]
fn homing_leaves_the_position_unknown_until_it_is_stated() {
    for block in ["$H", " $h ; home", "$HXY", "$X"] {
        let path = read(Dialect::Fanuc, &format!("{block}\n{BEFORE}{block}\n{AFTER}"));
        assert_eq!(feeds(&path), [YES, YES, UNKNOWN, YES, YES], "{block}");
        assert!(path.warnings.is_empty(), "{:?}", path.warnings);
    }
    // Other commands with a dollar sign are not known.
    for block in ["$J=G91 X1 F100", "$RST=#", "$HELP"] {
        let text = format!("{BEFORE}{block}\n{AFTER}");
        if let Ok(path) = interpret(&parse(text), &Dialect::Fanuc.into()) {
            assert!(feeds(&path)[2..].iter().all(|shiftable| *shiftable != YES), "{block}");
        }
    }
}

#[test]
fn pockets_leave_the_position_unknown() {
    for block in ["G12 I5. D1 F300 Z-2.", "G13 I5. K20. Q2. D1 F300 Z-2. L2", "G150 P1000 G41 D1 X0 Y0 I2. Z-3. Q1. F300"] {
        let path = read(Dialect::Fanuc, &format!("{BEFORE}{block}\nG40\nG1 X3. F600\nG0 X0 Y0 Z5.\nG1 Z-1.\nX5.\nM30\n"));
        assert_eq!(feeds(&path), [YES, YES, LEFT, UNKNOWN, YES, YES], "{block}");
        let code = block.split(' ').next().unwrap_or_default();
        assert!(path.warnings.iter().any(|w| w.line == 5 && w.message.contains(code)), "{block}: {:?}", path.warnings);
    }
}

#[test]
fn a_known_code_of_another_kinematics_may_stand_beside_a_move() {
    is_left_alone(Dialect::Fanuc, "G234 H1 X0 Y0 Z5.", "G1 X20. B5. F300\n", "G49");
    is_left_alone(Dialect::Fanuc, "G141 X0 Y0 Z5. D1", "G1 X20. Y5. I0 J0 K1. F300\n", "G40");
    is_left_alone(Dialect::Fanuc, "G41.2 X0 Y0 D1", "G1 X20. Y5. F300\n", "G40");
}

#[test]
fn a_mode_that_a_switch_may_begin_or_end_is_left_alone_to_the_end() {
    for section in ["/G68 X0 Y0 R30.\nG1 X1.\nG69\n", "G68 X0 Y0 R30.\nG1 X1.\n/G69\n"] {
        let path = read(Dialect::Fanuc, &format!("{BEFORE}{section}{AFTER}"));
        assert!(feeds(&path)[2..].iter().all(|shiftable| *shiftable != YES), "{section}");
    }
}

#[test]
fn outputs_to_an_interface_and_numbers_of_spindles_change_nothing() {
    for (dialect, lines) in [
        (Dialect::Fanuc, "POPEN\nDPRNT[X#100[53]***Y10*F200]\nBPRNT[X#101[3]]\nPCLOS\n"),
        (Dialect::LinuxCnc, "M3 $0 S1000\nM5 $0\nM5 $-1\n"),
    ] {
        let path = read(dialect, &format!("{BEFORE}{lines}X20.\n{AFTER}"));
        assert!(feeds(&path).iter().all(|shiftable| *shiftable == YES) && path.warnings.is_empty(), "{:?}", path.warnings);
    }
    let path = read(Dialect::LinuxCnc, &format!("{BEFORE}$X\nX20.\n{AFTER}"));
    assert!(feeds(&path).contains(&LEFT));
}

/// Planes without shift or angle, which posts write before work in three axes: coordinates are those of the part.
#[test]
fn planes_that_are_not_tilted_are_no_sections() {
    let (fanuc, sinumerik) = (Dialect::Fanuc, Dialect::Sinumerik);
    let swivel = |numbers: &str, status: &str| format!("CYCLE800(1,\"TC1\",{status},57,{numbers},0,1,0,1)");
    let zeros = "0,0,0,0,0,0,0,0,0";
    for (on, off) in [("G68.2 X0. Y0. Z0. I0. J0. K0.", "G69"), ("G68.2 X0 Y0 Z0 I0 J0 K0\nG53.1", "G69")] {
        let text = format!("{BEFORE}{on}\nG0 X0 Y0 Z5.\nG1 Z-1.\nX9.\n{off}\n{AFTER}");
        assert_eq!(feeds(&read(fanuc, &text)), [YES, YES, YES, YES, YES, YES, YES], "{on}");
    }
    for (on, is_left) in [
        (swivel(zeros, "200000"), false),
        (swivel(",,,,,,,,", ""), false),
        (swivel(zeros, "200001"), true),
        (swivel("0,0,0,0,30,0,0,0,0", "200000"), true),
        (swivel("5,0,0,0,0,0,0,0,0", "200000"), true),
        (format!("TRANS X10\n{}", swivel(zeros, "200000")), true),
    ] {
        let text = format!("G71 G90 G17 G54\nG0 X0 Y0 Z5\nG1 Z-1 F600\n{on}\nG0 X0 Y0 Z5\nG1 Z-1\nX9\nCYCLE800()\nM30\n");
        let inside = if is_left { LEFT } else { YES };
        assert_eq!(feeds(&read(sinumerik, &text)), [YES, inside, inside], "{on}");
    }
    for (on, is_left) in [
        ("PLANE SPATIAL SPA+0 SPB+0 SPC+0 TURN MB MAX FMAX", false),
        ("PLANE SPATIAL SPA+0 SPB+30 SPC+0 TURN", true),
        ("PLANE SPATIAL SPA+0 SPB+0 TURN", true),
    ] {
        let text = format!(
            "0 BEGIN PGM A MM\n1 L X+0 Y+0 Z+5 R0 FMAX\n2 L Z-1 F600\n3 {on}\n4 L X+0 Y+0 Z+5 R0 FMAX\n5 L Z-1 F600\n6 L X+9\n7 M138 C\n8 L X+3\n9 END PGM A MM\n"
        );
        let inside = if is_left { LEFT } else { YES };
        assert_eq!(feeds(&read(fanuc, &text)), [YES, inside, inside, inside], "{on}");
    }
}

#[test]
fn arcs_after_an_unknown_code_say_nothing_about_others() {
    // M72 may have brought back other modes. Read in increments the last arc fits a circle about a position alone; the first one was written about a
    // position, too.
    let text =
        "G21 G17 G90 G94 F300\nG0 X0 Y0 Z0\nG2 X10 Y10 R20\nM73\nG91\nM72\nG0 X60 Y50\nG3 X-40 Y0 I50 J60\nG90 G1 X0 Y0\nM2\n";
    let path = interpret(&parse(text), &Dialect::LinuxCnc.into()).unwrap();
    assert!(path.warnings.iter().all(|warning| !warning.message.contains("absolute")), "{:?}", path.warnings);
    assert!(path.warnings.iter().any(|warning| warning.message.contains("fits no circle")), "{:?}", path.warnings);
    let modal = |block: u32| path.moves.iter().find(|step| step.block == block).map(|step| path.modal(step).arc_distance);
    assert_eq!(modal(2), Some(gcode::Distance::Incremental));
}

#[test]
fn a_shift_that_an_earlier_program_left_is_not_known_to_be_none() {
    for (between, kept) in [
        ("G92 X10 Y10\nG1 X20.\nY20.\nG92.1", false),
        ("G52 X10 Y10", false),
        ("G52 X0 Y0", false),
        ("G92.1\nG0 X0 Y0 Z5.\nG1 Z-1.\nG92 X10 Y10\nG1 X20.\nY20.\nG92.1", true),
    ] {
        let found = feeds(&read(Dialect::LinuxCnc, &format!("{BEFORE}{between}\nG1 X30.\nG0 X0 Y0 Z5.\nG1 Z-1.\nX5.\n")));
        assert_eq!(found[found.len() - 3] == YES, kept, "{between}");
        assert_eq!(found[found.len() - 1], YES, "{between}");
    }
}

#[test]
fn a_second_program_number_begins_another_program() {
    let path = read(Dialect::Fanuc, &format!("O1000\n{BEFORE}X20.\nO1001\nG1 X0.\nY0.\nM99\n"));
    assert_eq!(path.moves.len(), 4);
    assert!(path.warnings.iter().any(|warning| warning.message.contains("another program begins here")), "{:?}", path.warnings);
}

#[test]
fn codes_of_other_controls_with_the_same_number_leave_moves_alone() {
    // Haas: a work offset, where no G112 stands in the program.
    let path = read(Dialect::Fanuc, &format!("{BEFORE}G113\n{AFTER}"));
    assert!(feeds(&path)[2..].iter().all(|shiftable| *shiftable != YES), "G113");
    let path = read(Dialect::Fanuc, &format!("{BEFORE}G40 G80 G113\n{AFTER}"));
    assert!(feeds(&path)[2..].contains(&YES), "a line of cancelling codes");
    // Pockets of GSK, a call of Mitsubishi, return levels of Okuma's cycles.
    for block in ["G22 X20. Y20. Z-3. R2. I10. L5. Q1. D1 F300.", "G22 P1000", "G33 X20. Y20. Z-3. R2. I10. J30. L5 D1 F300."] {
        let path = read(Dialect::Fanuc, &format!("{BEFORE}{block}\nG1 X30. F500\n{AFTER}"));
        assert_ne!(feeds(&path)[2], YES, "{block}");
    }
    let cycle = |code: &str| {
        read(Dialect::Fanuc, &format!("{BEFORE}G81 X10. Y10. Z-5. R-2. F200 {code}\nG80\nG1 X30. Z-1. F500\n{AFTER}"))
    };
    assert_ne!(feeds(&cycle("M53"))[2], YES);
    assert_eq!(feeds(&cycle("M8"))[2], YES);
    let check = read(Dialect::Fanuc, &format!("{BEFORE}G22 X100. Y100. Z50. I-100. J-100. K-50.\n{AFTER}"));
    assert_eq!(feeds(&check)[2], YES);
}

#[test]
fn names_and_accuracies_of_other_controls_are_passed_over() {
    let path = read(Dialect::Fanuc, &format!("%\n<TEST-PROG>(KUNDE)\n{BEFORE}G61.1 ,K80\nG64\n{AFTER}"));
    assert!(feeds(&path).iter().all(|shiftable| *shiftable == YES), "{:?}", feeds(&path));
}
