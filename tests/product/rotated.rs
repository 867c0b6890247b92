//! Programs in rotated, mirrored and scaled coordinates: what is written, turned, mirrored or scaled by hand, is what the same program without becomes.

use std::fmt::Write;

use crate::common::{Folder, without_mark};

/// Centre and angle of the rotations.
const CENTRE: [f64; 2] = [12.0, -7.0];
const ANGLE_DEG: f64 = 37.0;

/// One update, and no search of points: roundings in two frames would lead it to others.
const FIXED: [&str; 4] = ["--law", "one-shot", "--spacing", "8"];
/// Decimals that are written, and the largest difference of points that are rounded in two frames, mm.
const DECIMALS: &str = "6";
const ROUNDED_MM: f64 = 2e-6;
/// The same with the four decimals of dialogue, mm.
const ROUNDED_IN_DIALOGUE_MM: f64 = 1.5e-4;

fn turned(point: [f64; 2]) -> [f64; 2] {
    let (sin, cos) = ANGLE_DEG.to_radians().sin_cos();
    let from = [point[0] - CENTRE[0], point[1] - CENTRE[1]];
    [CENTRE[0] + cos * from[0] - sin * from[1], CENTRE[1] + sin * from[0] + cos * from[1]]
}

/// Mirror image about X = 12.
fn mirrored([x, y]: [f64; 2]) -> [f64; 2] {
    [2.0 * CENTRE[0] - x, y]
}

/// Scaled by 1.25 about the centre.
fn scaled(point: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|axis| CENTRE[axis] + 1.25 * (point[axis] - CENTRE[axis]))
}

/// How a control writes a contour.
struct Control {
    head: &'static str,
    on: &'static str,
    off: &'static str,
    is_dialogue: bool,
    /// What the codes do with a point, and whether arcs then run the other way round.
    image: fn([f64; 2]) -> [f64; 2],
    flips: bool,
    /// Of words relative to the start of a block.
    is_incremental: bool,
}

/// The contour in coordinates that `place` leads to.
fn program(control: &Control, with: bool, place: impl Fn([f64; 2]) -> [f64; 2]) -> String {
    let mut out = String::from(control.head);
    out.push_str(if with { control.on } else { "" });
    let mut at = place([0.0; 2]);
    let mut go = |code: &str, to: [f64; 2], centre: Option<[f64; 2]>, rest: &str| {
        let end = place(to);
        let code = match code {
            "G2" if control.flips && !with => "G3",
            "G3" if control.flips && !with => "G2",
            code => code,
        };
        let from = if control.is_incremental && code != "G0" { at } else { [0.0; 2] };
        let [x, y] = [end[0] - from[0], end[1] - from[1]];
        if control.is_dialogue {
            if let Some(centre) = centre.map(&place) {
                writeln!(out, "CC X{:+.9} Y{:+.9}", centre[0], centre[1]).unwrap();
            }
            let (name, direction) = match code {
                "G3" => ("C", " DR+"),
                "G2" => ("C", " DR-"),
                _ => ("L", ""),
            };
            writeln!(out, "{name} X{x:+.9} Y{y:+.9}{direction}{rest}").unwrap();
        } else {
            let centre = centre.map(&place).map(|centre| format!("I{:.9} J{:.9}", centre[0] - at[0], centre[1] - at[1]));
            let mode = if !control.is_incremental {
                ""
            } else if code == "G0" {
                "G90 "
            } else {
                "G91 "
            };
            writeln!(out, "{mode}{code} X{x:.9} Y{y:.9} {}{rest}", centre.unwrap_or_default()).unwrap();
        }
        at = end;
    };
    let rapid = if control.is_dialogue { " Z+0 FMAX" } else { " Z0." };
    go("G0", [0.0, 0.0], None, rapid);
    go("G1", [40.0, 0.0], None, if control.is_dialogue { " F2400" } else { "F2400." });
    go("G1", [40.0, 20.0], None, "");
    go("G3", [20.0, 40.0], Some([20.0, 20.0]), "");
    go("G1", [10.0, 40.0], None, "");
    go("G2", [0.0, 30.0], Some([10.0, 30.0]), "");
    go("G1", [0.0, 0.0], None, "");
    go("G0", [0.0, 0.0], None, if control.is_dialogue { " Z+5 FMAX" } else { "Z5." });
    out.push_str(if with { control.off } else { "" });
    out.push_str(if control.is_dialogue { "END PGM A MM\n" } else { "M30\n" });
    out
}

/// X and Y of every block that names one of them, by its words alone.
fn points(text: &str) -> Vec<[f64; 2]> {
    let (mut at, mut incremental, mut points) = ([0.0; 2], false, Vec::new());
    let is_frame = |line: &&str| {
        ["G68", "G51.1", "G50.1", "TRANS", "MIRROR", "SCALE", "CYCL"].iter().any(|name| line.contains(name))
            || line.starts_with("CC")
    };
    for line in text.lines().filter(|line| !is_frame(line)) {
        incremental = line.contains("G91") || (incremental && !line.contains("G90"));
        let value = |letter: char| {
            let rest = &line[line.find(letter)? + 1..];
            let end = rest.find(|c: char| !c.is_ascii_digit() && !"+-.".contains(c)).unwrap_or(rest.len());
            rest[..end].parse::<f64>().ok()
        };
        let named = [value('X'), value('Y')];
        for (axis, value) in named.iter().enumerate() {
            let from = if incremental { at[axis] } else { 0.0 };
            at[axis] = value.map_or(at[axis], |value| from + value);
        }
        if named.iter().any(Option::is_some) {
            points.push(at);
        }
    }
    points
}

/// Largest distance of two lists of points, in order. One may have a point more: what is rounded in two frames may lie on either side of the tolerance of
/// an arc.
fn apart(one: &[[f64; 2]], other: &[[f64; 2]]) -> f64 {
    let (fewer, more) = if one.len() <= other.len() { (one, other) } else { (other, one) };
    assert!(more.len() - fewer.len() <= 1, "{} and {} points", one.len(), other.len());
    let far = |a: &[f64; 2], b: &[f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    let (mut at, mut most) = (0, 0.0_f64);
    for (index, point) in fewer.iter().enumerate() {
        let left = more.len() - fewer.len() + index - at;
        let nearest = (at..=at + left).min_by(|a, b| far(&more[*a], point).total_cmp(&far(&more[*b], point))).unwrap();
        most = most.max(far(&more[nearest], point));
        at = nearest + 1;
    }
    most
}

fn check(name: &str, control: &Control, options: &[&str]) {
    let folder = Folder::with_model();
    let compensated = |text: String, name: &str| {
        folder.write(name, text);
        let words = ["compensate", name, "-m", "machine.model", "-o", "out.nc", "--decimals", DECIMALS];
        let figures = folder.figures(&[&words[..], &FIXED, options].concat());
        assert_eq!((&figures["changed"], &figures["left_alone"]["feed_length_share"]), (&true.into(), &0.0.into()), "{figures}");
        without_mark(&folder.read("out.nc"))
    };
    let rotated = compensated(program(control, true, |point| point), name);
    let plain = compensated(program(control, false, control.image), name);
    let of_rotated: Vec<[f64; 2]> = points(&rotated).into_iter().map(control.image).collect();
    let of_plain = points(&plain);
    assert!(of_plain.len() > 20, "{plain}");
    let most = apart(&of_rotated, &of_plain);
    println!("{name} {options:?}: {} points, at most {:.2e} mm apart", of_plain.len(), most);
    assert!(most <= ROUNDED_MM * if control.is_incremental { 20.0 } else { 1.0 }, "{most} mm\n{rotated}\n{plain}");
}

const FANUC: Control = Control {
    head: "O1\nG21 G90 G17 G54\n",
    on: "G68 X12. Y-7. R37.\n",
    off: "G69\n",
    is_dialogue: false,
    image: turned,
    flips: false,
    is_incremental: false,
};

#[test]
fn g68() {
    for options in [&["--format", "keep"][..], &["--format", "g93"], &["--controller", "linuxcnc", "--format", "g94"]] {
        check("part.nc", &FANUC, &[&["--dialect", "fanuc", "--decimal-point", "unit"][..], options].concat());
    }
}

#[test]
fn g68_in_increments() {
    check("part.nc", &Control { is_incremental: true, ..FANUC }, &["--dialect", "fanuc", "--decimal-point", "unit"]);
}

#[test]
fn g51_1() {
    let control = Control { on: "G51.1 X12.\n", off: "G50.1 X12.\n", image: mirrored, flips: true, ..FANUC };
    let words = &["--dialect", "fanuc", "--decimal-point", "unit"][..];
    for options in [&["--format", "keep"][..], &["--format", "g93"]] {
        check("part.nc", &control, &[words, options].concat());
    }
    check("part.nc", &Control { is_incremental: true, ..control }, words);
}

#[test]
fn a_frame_of_sinumerik() {
    // The zero of the frame is where the rotation about the centre leaves the zero of the part.
    let on = "TRANS X12 Y-7\nAROT RPL=37\nATRANS X-12 Y7\n";
    let control = Control { head: "G710 G90 G17 G54\n", on, off: "TRANS\n", ..FANUC };
    check("part.mpf", &control, &[]);
}

#[test]
fn a_scaled_frame_of_sinumerik() {
    let on = "TRANS X12 Y-7\nASCALE X1.25 Y1.25\nATRANS X-12 Y7\n";
    let control = Control { head: "G710 G90 G17 G54\n", on, off: "TRANS\n", image: scaled, ..FANUC };
    for options in [&["--format", "keep"][..], &["--format", "g93"]] {
        check("part.mpf", &control, options);
    }
    check("part.mpf", &Control { is_incremental: true, ..control }, &[]);
}

#[test]
fn a_mirrored_frame_of_sinumerik() {
    let on = "TRANS X12 Y-7\nAMIRROR X0\nATRANS X-12 Y7\n";
    let control = Control { head: "G710 G90 G17 G54\n", on, off: "TRANS\n", image: mirrored, flips: true, ..FANUC };
    for options in [&["--format", "keep"][..], &["--format", "g93"]] {
        check("part.mpf", &control, options);
    }
    check("part.mpf", &Control { is_incremental: true, ..control }, &[]);
}

#[test]
fn cycle_10_of_dialogue() {
    let on = "CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+12\nCYCL DEF 7.2 Y-7\nCYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT+37\n";
    check_dialogue(&Control { on, off: "CYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT+0\n", ..DIALOGUE });
}

#[test]
fn cycle_8_of_dialogue() {
    let on = "CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+12\nCYCL DEF 7.2 Y-7\nCYCL DEF 8.0 MIRROR IMAGE\nCYCL DEF 8.1 X\n";
    let off = "CYCL DEF 8.0 MIRROR IMAGE\nCYCL DEF 8.1\n";
    check_dialogue(&Control { on, off, image: mirrored, flips: true, ..DIALOGUE });
}

/// `on` has the datum at the centre.
const DIALOGUE: Control = Control { head: "BEGIN PGM A MM\nTOOL CALL 1 Z S5000 F2400\n", is_dialogue: true, ..FANUC };

fn check_dialogue(control: &Control) {
    let folder = Folder::with_model();
    let compensated = |text: String| {
        folder.write("part.h", text);
        let words = ["compensate", "part.h", "-m", "machine.model", "-o", "out.h", "--decimals", DECIMALS];
        let figures = folder.figures(&[&words[..], &FIXED].concat());
        assert_eq!((&figures["changed"], &figures["left_alone"]["feed_length_share"]), (&true.into(), &0.0.into()), "{figures}");
        points(&without_mark(&folder.read("out.h")))
    };
    let about_datum = |point: [f64; 2]| [point[0] - CENTRE[0], point[1] - CENTRE[1]];
    let rotated = compensated(program(control, true, about_datum));
    let plain = compensated(program(control, false, control.image));
    let back = |point: [f64; 2]| (control.image)([point[0] + CENTRE[0], point[1] + CENTRE[1]]);
    let most = apart(&rotated.into_iter().map(back).collect::<Vec<_>>(), &plain);
    assert!(most <= ROUNDED_IN_DIALOGUE_MM, "{most} mm");
}
