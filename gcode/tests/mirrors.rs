//! Known mirror images: the moves in them are those of the same program written out without them. What is uncertain is left alone.

use gcode::{Dialect, Fixed, Move, MoveKind, Shiftable, Toolpath, interpret, parse};

const YES: Shiftable = Shiftable::Yes;
const LEFT: Shiftable = Shiftable::No(Fixed::NotUnderstood);
/// Largest difference of a point, mm.
const NEAR_MM: f64 = 1e-9;
const HEAD: &str = "G21 G90 G17 G54\nG0 X0 Y0 Z5.\nG1 Z-1. F300.\nX7.\n";
const AFTER: &str = "G0 X1. Y2. Z5.\nG1 Z-1. F500.\nX9. Y3.\nM30\n";

fn read(text: &str) -> Toolpath {
    interpret(&parse(text), &Dialect::Fanuc.into()).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn feeds(path: &Toolpath) -> Vec<Move> {
    path.moves.iter().filter(|step| step.is_feed()).copied().collect()
}

fn shiftable(path: &Toolpath) -> Vec<Shiftable> {
    feeds(path).iter().map(|step| step.shiftable).collect()
}

/// A contour whose points are moved by `image`; `flips` exchanges G2 and G3.
fn contour(letters: [&str; 5], image: impl Fn([f64; 2]) -> [f64; 2], flips: bool) -> String {
    let [first, second, normal, i, j] = letters;
    let origin = image([0.0; 2]);
    let at = |point: [f64; 2]| {
        let [a, b] = image(point);
        format!("{first}{a:.9} {second}{b:.9}")
    };
    let vector = |names: [&str; 2], by: [f64; 2]| {
        let [a, b] = image(by);
        format!("{}{:.9} {}{:.9}", names[0], a - origin[0], names[1], b - origin[1])
    };
    let (cw, ccw) = if flips { ("G3", "G2") } else { ("G2", "G3") };
    [
        format!("G0 {}", at([2.0, 1.0])),
        format!("G1 {normal}-2. F300."),
        format!("G1 {} F600.", at([20.0, 1.0])),
        format!("{ccw} {} {}", at([30.0, 11.0]), vector([i, j], [0.0, 10.0])),
        format!("{cw} {} R4.", at([34.0, 15.0])),
        format!("{cw} {} {normal}-3.", vector([i, j], [6.0, 1.0])),
        "G91".to_owned(),
        format!("{ccw} {} {}", vector([first, second], [0.0, -6.0]), vector([i, j], [0.0, -3.0])),
        "G90".to_owned(),
        format!("G1 {}", at([2.0, 1.0])),
        String::new(),
    ]
    .join("\n")
}

#[test]
fn g51_1_is_the_program_written_out_without_it() {
    let planes = [("G17", ["X", "Y", "Z", "I", "J"]), ("G18", ["Z", "X", "Y", "K", "I"]), ("G19", ["Y", "Z", "X", "J", "K"])];
    for (plane, letters) in planes {
        for about in [[Some(0.0), None], [Some(12.5), None], [None, Some(-3.25)], [Some(4.0), Some(6.5)]] {
            let image = |point: [f64; 2]| [0, 1].map(|axis| about[axis].map_or(point[axis], |at: f64| 2.0 * at - point[axis]));
            let words: Vec<String> = (0..2).filter_map(|k| about[k].map(|at| format!("{}{at:.3}", letters[k]))).collect();
            let head = format!("G21 G90 {plane} G54\nG0 X0 Y0 Z0\n");
            let inside = contour(letters, |point| point, false);
            let on = words.join(" ");
            let mirrored = read(&format!("{head}G51.1 {on}\n{inside}G50.1 {on}\n{AFTER}"));
            let flips = about[0].is_some() != about[1].is_some();
            let plain = read(&format!("{head}{}{AFTER}", contour(letters, image, flips)));
            let (mirrored, plain) = (feeds(&mirrored), feeds(&plain));
            assert_eq!(mirrored.len(), plain.len(), "{plane} {on}");
            for (a, b) in mirrored.iter().zip(&plain) {
                assert_eq!((a.shiftable, b.shiftable, a.feed), (YES, YES, b.feed), "{plane} {on}");
                for share in [0.0, 0.3, 0.7, 1.0] {
                    let off = a.point_mm(share).iter().zip(b.point_mm(share)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                    assert!(off < NEAR_MM, "{plane} {on}: {:?} {:?}", a.point_mm(share), b.point_mm(share));
                }
            }
        }
    }
}

#[test]
fn the_modes_of_the_moves_tell_of_the_image() {
    let path = read(&format!("{HEAD}G51.1 X0\nG0 X5. Y5.\nG3 X10. Y10. R5. F300.\nG50.1 X0\n{AFTER}"));
    let arc = path.moves.iter().find(|step| matches!(step.kind, MoveKind::Arc(_))).unwrap();
    let MoveKind::Arc(of) = arc.kind else { panic!("no arc") };
    assert!(of.sweep < 0.0 && path.modal(arc).rotation.is_some_and(|image| image.is_mirrored()));
    let words = path.programmed(arc, [0.0; 6], [-8.0, 9.0, 5.0, 0.0, 0.0, 0.0]);
    assert_eq!(words[..2], [8.0, 9.0]);
    assert!(path.warnings.is_empty(), "{:?}", path.warnings);
}

#[test]
fn coordinates_are_unknown_until_one_block_states_both() {
    let path = read(&format!("{HEAD}G51.1 X0\nG1 X5.\nX5. Y5.\nX6.\nG50.1 X0\nG1 X1.\nX1. Y1.\nX2.\n{AFTER}"));
    let unknown = Shiftable::No(Fixed::UnknownStart);
    assert_eq!(shiftable(&path)[2..8], [unknown, unknown, YES, unknown, unknown, YES]);
}

#[test]
fn uncertain_images_are_left_alone() {
    let inside = "G0 X5. Y5. Z5.\nG1 Z-1. F300.\nX8.\n";
    for on in [
        "G51.1 Z0",
        "G51.1 X0 Z0",
        "G51.1 X0 A0",
        "G51.1 X5",
        "G51.1",
        "G91 G51.1 X0",
        "G90 G51.1 X0",
        "G51.1 X0 M8",
        "G51.1 X0 F300.",
        "/G51.1 X0",
        "G51.1 X#500",
        "G52 X5.\nG51.1 X0",
        "G92 X5.\nG51.1 X0",
        "G68 X0 Y0 R30.\nG51.1 X0",
        "G51.1 X0\nG51.1 Y0",
        "G51.1 X0\nG68 X0 Y0 R30.",
        "G51.1 X0\nG18",
        "G51.1 X0\nG55",
        "G51.1 X0\nG52 X1.",
        "G51.1 X0\nG92 X1.",
        "G51.1 X0\nG20",
        "G51.1 X0\nM98 P77",
        "G51.1 X0\nG51 X0 Y0 P2000",
        "G51.1 X0 Y0\nG50.1 X0",
        "G51.1 X0\nG50.1 Y0",
        "G51.1 X0\nG50.1",
        "G51.1 X0\n/G50.1 X0",
        "G51.1 X0\nG69",
        "G41 D1\nG51.1 X0",
        "G81 Z-3. R1. F100.\nG51.1 X0",
    ] {
        let path = read(&format!("{HEAD}{on}\n{inside}"));
        let of = shiftable(&path);
        assert!(of[2..].iter().all(|shiftable| *shiftable != YES), "{on}: {of:?}");
    }
    // Its end is found all the same.
    let path = read(&format!("{HEAD}G51.1 X5\n{inside}G50.1 X0\n{AFTER}"));
    assert_eq!(shiftable(&path)[2..], [LEFT, LEFT, LEFT, YES, YES]);
}

#[test]
fn an_image_that_is_lost_ends_with_its_axes() {
    let lost = "G51.1 X0 Y0\nG0 X5. Y5.\nG50.1 X0\nG1 X8.\n";
    let path = read(&format!("{HEAD}{lost}{AFTER}"));
    assert!(shiftable(&path)[2..].iter().all(|shiftable| *shiftable != YES));
    let path = read(&format!("{HEAD}{lost}G50.1 Y0\n{AFTER}"));
    assert_eq!(shiftable(&path)[2..], [LEFT, LEFT, LEFT, YES, YES]);
}
