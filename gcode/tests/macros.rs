//! What is known after macros and subprograms that are not found.

use gcode::{Dialect, Fixed, Macros, Options, Shiftable, Toolpath, interpret, parse};

const YES: Shiftable = Shiftable::Yes;
const LEFT: Shiftable = Shiftable::No(Fixed::NotUnderstood);
const UNKNOWN: Shiftable = Shiftable::No(Fixed::UnknownStart);

const BEFORE: &str = "G21 G90 G17 G54\nG0 X0 Y0 Z5.\nG1 Z-1. F600\nX10.\n";
const CALLS: [&str; 6] = ["M98 P1000", "M97 P77", "M198 P5", "G65 P9810 X1. A5.", "L100", "G66 P9100\nG67"];

fn read(text: &str, dialect: Dialect, macros: Macros) -> Toolpath {
    let options = Options { macros, ..dialect.into() };
    interpret(&parse(text), &options).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// The feed moves after the call.
fn after(call: &str, rest: &str, macros: Macros) -> Vec<Shiftable> {
    let path = read(&format!("{BEFORE}{call}\n{rest}"), Dialect::Fanuc, macros);
    path.moves.iter().filter(|step| step.is_feed()).map(|step| step.shiftable).skip(2).collect()
}

#[test]
fn nothing_is_changed_after_a_macro_until_all_is_stated_again() {
    for call in CALLS {
        let rest = "G1 X5. F600\nG0 X0 Y0 Z5.\nG1 Z-1. F600\nX5.\nG2 X10. Y5. R5.\n";
        assert_eq!(after(call, rest, Macros::Unknown), [LEFT; 4], "{call}");
        let of = |rest: &str| after(call, rest, Macros::Unknown);
        // One of the groups is missing.
        for modes in ["G90 G17", "G54 G17", "G17", "/G90 G54 G17"] {
            let last = of(&format!("{modes}\nG0 X0 Y0\nG1 Z-1. F600\nX5.\n"));
            assert!(last.iter().all(|shiftable| *shiftable != YES), "{call} {modes}: {last:?}");
        }
        let late = "G17 G54\nG0 X0 Y0 Z5.\nG90 X0 Y0\nG1 Z-1. F600\nX5.\n";
        assert_eq!(of(late), [UNKNOWN, YES], "{call}: Z is not stated under G90");
        assert_eq!(of("G90 G54\nG0 X0 Y0 Z5.\nG1 Z-1. F600\nG2 X5. Y5. R5.\nG1 X0.\n"), [YES, LEFT, YES], "{call}: no plane");
        assert_eq!(of("G90 G54 G17\nG0 X0 Y0 Z5.\nG1 Z-1.\nX5. F600\n"), [LEFT, YES], "{call}: no feed");
        assert_eq!(of("G90 G54 G17 F600\nX0 Y0 Z5.\nZ-1.\nG1 X5.\n").last(), Some(&UNKNOWN), "{call}: no motion code");
    }
}

#[test]
fn a_program_that_states_its_modes_after_a_macro_is_changed() {
    for call in CALLS {
        let modes =
            ["G90 G54 G17\nG0 X0 Y0 Z5.\n", "G0 G17 G40 G49 G80 G90\nG54\nX0 Y0\nG43 H1 Z5.\n", "G90 G17 G55 G0 X0 Y0 Z5.\n"];
        for modes in modes {
            let rest = format!("{modes}G1 Z-1. F600\nX5.\nG2 X10. Y5. R5.\n");
            assert_eq!(after(call, &rest, Macros::Unknown), [YES; 3], "{call} {modes}");
        }
    }
}

#[test]
fn a_work_offset_that_no_block_names_is_left_to_the_macro() {
    let text = "G21 G90 G17\nM98 P1000\nG90 G17 G0 X0 Y0 Z5.\nG1 Z-1. F600\n";
    assert_eq!(read(text, Dialect::Fanuc, Macros::Unknown).moves.last().map(|step| step.shiftable), Some(YES));
}

#[test]
fn a_macro_that_keeps_the_modes_leaves_only_the_position_unknown() {
    for call in CALLS {
        let rest = "G1 X5.\nG0 X0 Y0 Z5.\nG1 Z-1.\nX5.\n";
        assert_eq!(after(call, rest, Macros::Keep), [UNKNOWN, YES, YES], "{call}");
    }
}

#[test]
fn the_warning_names_the_option() {
    let path = read(&format!("{BEFORE}M98 P1000\nG1 X5.\n"), Dialect::Fanuc, Macros::Unknown);
    let help = path.warnings[0].help.clone().unwrap_or_default();
    assert!(path.warnings[0].line == 5 && help.contains("--macros keep"), "{:?}", path.warnings);
    let kept = read(&format!("{BEFORE}M98 P1000\nG1 X5.\n"), Dialect::Fanuc, Macros::Keep);
    assert!(kept.warnings[0].message.contains("taken to be the same"), "{:?}", kept.warnings);
}

#[test]
fn a_doubt_refuses_nothing() {
    // Arcs from an unknown start, in another plane, feeds of another mode.
    let rest = "G2 X5. Y5. R5.\nG3 X7. Z5. R50.\nG91 G1 X1.\nG1 X1. Q5.\nG93 G1 X5.\n";
    assert_eq!(after("G65 P9000", rest, Macros::Unknown), [LEFT; 5]);
    let first = "G21\no<probe> call\nG1 X5\nG2 X9 Y9 R9\n";
    let path = read(first, Dialect::LinuxCnc, Macros::Unknown);
    assert_eq!(path.moves.iter().map(|step| step.shiftable).collect::<Vec<_>>(), [LEFT; 2]);
}
