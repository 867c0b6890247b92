//! Known rotations: the moves in them are those of the same program written out without rotation. What is uncertain is left alone.

mod dialogue;

use gcode::{Dialect, Fixed, Move, MoveKind, Shiftable, Toolpath, interpret, parse};

/// Largest difference of a point, mm.
const NEAR_MM: f64 = 1e-9;

const YES: Shiftable = Shiftable::Yes;

fn read(dialect: Dialect, text: &str) -> Toolpath {
    interpret(&dialect.read(parse(text)), &dialect.into()).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn feeds(path: &Toolpath) -> Vec<Shiftable> {
    path.moves.iter().filter(|step| step.is_feed()).map(|step| step.shiftable).collect()
}

/// Turns a point of a plane about a centre.
fn turned(centre: [f64; 2], angle_deg: f64, point: [f64; 2]) -> [f64; 2] {
    let (sin, cos) = (angle_deg / 180.0 * std::f64::consts::PI).sin_cos();
    let from = [point[0] - centre[0], point[1] - centre[1]];
    [centre[0] + cos * from[0] - sin * from[1], centre[1] + sin * from[0] + cos * from[1]]
}

/// The feed moves of two programs have the same paths, feeds and reasons.
fn are_alike(turned: &Toolpath, plain: &Toolpath, what: &str) {
    let of = |path: &Toolpath| -> Vec<Move> { path.moves.iter().filter(|step| step.is_feed()).copied().collect() };
    let (turned, plain) = (of(turned), of(plain));
    assert_eq!(turned.len(), plain.len(), "{what}");
    for (index, (a, b)) in turned.iter().zip(&plain).enumerate() {
        assert_eq!((a.shiftable, a.start.xyz_mm().is_some()), (b.shiftable, b.start.xyz_mm().is_some()), "{what}: move {index}");
        for share in [0.0, 0.3, 0.7, 1.0] {
            let off: f64 = a.point_mm(share).iter().zip(b.point_mm(share)).map(|(a, b)| (a - b) * (a - b)).sum();
            assert!(off.sqrt() < NEAR_MM, "{what}: move {index} at {share}: {:?} {:?}", a.point_mm(share), b.point_mm(share));
        }
        assert_eq!(a.feed, b.feed, "{what}: move {index}");
    }
}

/// A contour in a plane with the letters of its axes, written in coordinates turned by `turn`.
fn contour(letters: [&str; 5], turn: impl Fn([f64; 2]) -> [f64; 2]) -> String {
    scaled_contour(letters, turn, 1.0, |depth| depth)
}

/// The same where `turn` scales by `factor`, and the normal is mapped by `deep`.
fn scaled_contour(letters: [&str; 5], turn: impl Fn([f64; 2]) -> [f64; 2], factor: f64, deep: impl Fn(f64) -> f64) -> String {
    let [first, second, normal, i, j] = letters;
    let down = |to: f64| format!("{normal}{:.12}", deep(to));
    let vector = |by: [f64; 2]| {
        let (from, to) = (turn([0.0; 2]), turn(by));
        [to[0] - from[0], to[1] - from[1]]
    };
    let at = |point: [f64; 2]| {
        let [a, b] = turn(point);
        format!("{first}{a:.12} {second}{b:.12}")
    };
    let by = |point: [f64; 2]| {
        let [a, b] = vector(point);
        format!("{first}{a:.12} {second}{b:.12}")
    };
    let centre = |point: [f64; 2]| {
        let [a, b] = vector(point);
        format!("{i}{a:.12} {j}{b:.12}")
    };
    [
        format!("G0 {}", at([2.0, 1.0])),
        format!("G0 {}", down(5.0)),
        format!("G1 {} F300.", down(-1.0)),
        format!("G1 {} F600.", at([20.0, 1.0])),
        format!("G3 {} {}", at([30.0, 11.0]), centre([0.0, 10.0])),
        format!("G2 {} R{:.12}", at([34.0, 15.0]), 4.0 * factor),
        format!("G2 {} {}", centre([6.0, 1.0]), down(-2.0)),
        format!("G1 {} {}", at([2.0, 15.0]), down(-1.5)),
        "G91".to_owned(),
        format!("G1 {}", by([3.0, -4.0])),
        format!("G3 {} {}", by([0.0, -6.0]), centre([0.0, -3.0])),
        "G90".to_owned(),
        format!("G1 {}", at([2.0, 1.0])),
        format!("G0 {}", down(5.0)),
        String::new(),
    ]
    .join("\n")
}

/// Radii as SINUMERIK writes them.
fn sinumerik(text: &str) -> String {
    text.replace(" R", " CR=")
}

const XY: [&str; 5] = ["X", "Y", "Z", "I", "J"];
const ZX: [&str; 5] = ["Z", "X", "Y", "K", "I"];
const YZ: [&str; 5] = ["Y", "Z", "X", "J", "K"];
const AFTER: &str = "G0 X1. Y2. Z5.\nG1 Z-1. F500.\nX9. Y3.\nM30\n";

#[test]
fn g68_is_the_program_written_out_without_it() {
    let plain = |point: [f64; 2]| point;
    for (plane, letters) in [("G17", XY), ("G18", ZX), ("G19", YZ)] {
        for (centre, angle) in [([0.0, 0.0], 90.0), ([5.0, -3.0], 37.0), ([-40.25, 7.0], -123.456), ([1.0, 1.0], 0.0)] {
            let head = format!("G21 G90 {plane} G54\nG0 X0 Y0 Z5.\n");
            let on = format!("G68 {}{:.3} {}{:.3} R{angle:.3}\n", letters[0], centre[0], letters[1], centre[1]);
            let path = read(Dialect::Fanuc, &format!("{head}{on}{}G69\n{AFTER}", contour(letters, plain)));
            // Without the rotation the first rapid of the rest may begin where it ends.
            let text = format!("{head}{}{AFTER}", contour(letters, |point| turned(centre, angle, point)));
            are_alike(&path, &read(Dialect::Fanuc, &text), &on);
            assert!(feeds(&path).iter().all(|shiftable| *shiftable == YES), "{on}: {:?}", feeds(&path));
            assert!(path.warnings.is_empty(), "{:?}", path.warnings);
        }
    }
}

#[test]
fn rotations_of_sinumerik_add_up_about_the_zero_of_the_frame() {
    let head = "G710 G90 G17 G54\nG0 X0 Y0 Z5\n";
    let plain = sinumerik(&contour(XY, |point| point));
    let tail = format!("TRANS\n{AFTER}");
    let about_zero = |angle: f64| move |point: [f64; 2]| turned([0.0; 2], angle, point);
    let shifted = |by: [f64; 2], point: [f64; 2]| [point[0] + by[0], point[1] + by[1]];
    let place = |point: [f64; 2]| shifted([10.0, 5.0], about_zero(30.0)(point));
    type Place<'a> = &'a dyn Fn([f64; 2]) -> [f64; 2];
    let cases: [(&str, Place<'_>); 8] = [
        ("ROT RPL=37", &about_zero(37.0)),
        ("ROT Z37", &about_zero(37.0)),
        ("N10 AROT RPL=-37 ; turned", &about_zero(-37.0)),
        ("TRANS X10 Y5\nROT RPL=30", &about_zero(30.0)),
        ("TRANS X10 Y5\nAROT RPL=30", &place),
        ("TRANS X10 Y5\nAROT RPL=10\nAROT Z20", &place),
        ("TRANS X10 Y5\nAROT RPL=30\nATRANS X3 Y-2", &|point| place(shifted([3.0, -2.0], point))),
        ("TRANS X10 Y5\nAROT RPL=30\nATRANS X3 Y-2\nAROT RPL=45", &|point| place(shifted([3.0, -2.0], about_zero(45.0)(point)))),
    ];
    for (on, turn) in cases {
        let path = read(Dialect::Sinumerik, &format!("{head}{on}\n{plain}{tail}"));
        are_alike(&path, &read(Dialect::Sinumerik, &format!("{head}{}{AFTER}", sinumerik(&contour(XY, turn)))), on);
        assert!(feeds(&path).iter().all(|shiftable| *shiftable == YES), "{on}: {:?}", path.warnings);
    }
    // Absolute centres and an end of the rotation without TRANS.
    let path = read(Dialect::Sinumerik, &format!("{head}ROT RPL=90\nG0 X10 Y0 Z0\nG3 X0 Y10 I=AC(0) J=AC(0) F500\nROT\n{AFTER}"));
    let MoveKind::Arc(arc) = path.moves[2].kind else { panic!("an arc") };
    assert!(arc.centre_mm[0].hypot(arc.centre_mm[1]) < NEAR_MM);
    assert!(path.moves[2].end.nominal_mm()[0] + 10.0 < NEAR_MM && path.moves.last().unwrap().shiftable == YES);
}

#[test]
fn scalings_of_sinumerik_are_those_of_their_frame() {
    let head = "G710 G90 G17 G54\nG0 X0 Y0 Z5\n";
    let plain = sinumerik(&contour(XY, |point| point));
    let by = |factor: f64, point: [f64; 2]| [factor * point[0], factor * point[1]];
    let place = |point: [f64; 2]| [point[0] + 10.0, point[1] + 5.0];
    let quarter = |point: [f64; 2]| turned([0.0; 2], 90.0, point);
    let once = |point: [f64; 2]| by(1.02, point);
    let placed = |point: [f64; 2]| place(by(1.5, point));
    let shifted = |point: [f64; 2]| place(by(1.5, [point[0] + 2.0, point[1] - 3.0]));
    let both = |point: [f64; 2]| place(by(1.5, quarter(point)));
    type Place<'a> = &'a dyn Fn([f64; 2]) -> [f64; 2];
    // Frame, place of a point, factor in the plane, and factor and shift of Z.
    let cases: [(&str, Place<'_>, f64, [f64; 2]); 8] = [
        ("SCALE X1.02 Y1.02 Z1.02", &once, 1.02, [1.02, 0.0]),
        ("SCALE X1.02 Y1.02", &once, 1.02, [1.0, 0.0]),
        ("ASCALE Z0.75", &|point| point, 1.0, [0.75, 0.0]),
        ("TRANS X10 Y5 Z1\nASCALE X1.5 Y1.5 Z0.5", &placed, 1.5, [0.5, 1.0]),
        ("TRANS X10 Y5\nSCALE X1.02 Y1.02", &once, 1.02, [1.0, 0.0]),
        ("TRANS X10 Y5\nASCALE X1.5 Y1.5 Z0.5\nATRANS X2 Y-3 Z1", &shifted, 1.5, [0.5, 0.5]),
        ("TRANS X10 Y5\nASCALE X1.5 Y1.5\nAROT RPL=90", &both, 1.5, [1.0, 0.0]),
        ("TRANS X10 Y5\nAROT RPL=90\nASCALE X1.2 Y1.2 ; shrinkage\nASCALE X1.25 Y1.25", &both, 1.5, [1.0, 0.0]),
    ];
    for (on, turn, factor, [along, shift]) in cases {
        let path = read(Dialect::Sinumerik, &format!("{head}{on}\nG0 Z5\n{plain}TRANS\n{AFTER}"));
        let text = scaled_contour(XY, turn, factor, |depth| along * depth + shift);
        let deep = 5.0 * along + shift;
        let text = format!("{head}G0 Z{deep}\n{}{AFTER}", sinumerik(&text));
        are_alike(&path, &read(Dialect::Sinumerik, &text), on);
        assert!(feeds(&path).iter().all(|shiftable| *shiftable == YES), "{on}: {:?}", path.warnings);
        assert!(path.warnings.is_empty(), "{on}: {:?}", path.warnings);
    }
}

#[test]
fn mirror_images_of_sinumerik_are_those_of_their_frame() {
    let head = "G710 G90 G17 G54\nG0 X0 Y0 Z5\n";
    let plain = sinumerik(&contour(XY, |point| point));
    let place = |point: [f64; 2]| [point[0] + 10.0, point[1] + 5.0];
    let of_x = |point: [f64; 2]| [-point[0], point[1]];
    let of_y = |point: [f64; 2]| [point[0], -point[1]];
    let of_both = |point: [f64; 2]| [-point[0], -point[1]];
    let by_30 = |point: [f64; 2]| turned([0.0; 2], 30.0, point);
    let moved = |point: [f64; 2]| [point[0] + 3.0, point[1] - 2.0];
    type Place<'a> = &'a dyn Fn([f64; 2]) -> [f64; 2];
    // Frame, place of a point, and whether arcs run the other way round.
    let cases: [(&str, Place<'_>, bool); 11] = [
        ("MIRROR X0", &of_x, true),
        ("MIRROR Y0 ; the other side", &of_y, true),
        ("MIRROR X0 Y0", &of_both, false),
        ("AMIRROR X1", &of_x, true),
        ("MIRROR X1\nTRANS\nMIRROR Y2", &of_y, true),
        ("TRANS X10 Y5\nMIRROR X0", &of_x, true),
        ("TRANS X10 Y5\nAMIRROR X0", &|point| place(of_x(point)), true),
        ("TRANS X10 Y5\nAMIRROR Y0\nATRANS X3 Y-2", &|point| place(of_y(moved(point))), true),
        ("TRANS X10 Y5\nAMIRROR X0\nAROT RPL=30", &|point| place(of_x(by_30(point))), true),
        ("TRANS X10 Y5\nAMIRROR Y0\nAROT RPL=30\nATRANS X3 Y-2", &|point| place(of_y(by_30(moved(point)))), true),
        ("TRANS X10 Y5\nAROT RPL=30\nATRANS X3 Y-2\nAMIRROR Y0", &|point| place(by_30(moved(of_y(point)))), true),
    ];
    for (on, turn, is_mirrored) in cases {
        let path = read(Dialect::Sinumerik, &format!("{head}{on}\n{plain}TRANS\n{AFTER}"));
        let contour = contour(XY, turn);
        let contour =
            if is_mirrored { contour.replace("G2 ", "G% ").replace("G3 ", "G2 ").replace("G% ", "G3 ") } else { contour };
        are_alike(&path, &read(Dialect::Sinumerik, &format!("{head}{}{AFTER}", sinumerik(&contour))), on);
        assert!(feeds(&path).iter().all(|shiftable| *shiftable == YES), "{on}: {:?}", path.warnings);
        assert!(path.warnings.is_empty(), "{on}: {:?}", path.warnings);
    }
    // Without axes it deletes the frame.
    let text = format!("{head}TRANS X10 Y5\nAMIRROR X0\nG0 X1 Y1\nMIRROR\n{AFTER}");
    assert!(feeds(&read(Dialect::Sinumerik, &text)).iter().all(|shiftable| *shiftable == YES));
}

#[test]
fn uncertain_scalings_are_left_alone() {
    let inside = "G0 X5 Y5 Z0\nG1 X9 F500\n";
    for on in [
        "SCALE X1.5",
        "SCALE X1.5 Y1.2",
        "SCALE X1.5 Y1.5 Z0",
        "SCALE X-1.5 Y-1.5",
        "SCALE X3 Y3",
        "SCALE X=AC(1.5) Y=AC(1.5)",
        "SCALE X1.5 Y1.5 C2",
        "SCALE X1.5 Y1.5 RPL=30",
        "SCALE X=R99 Y=R99",
        "SCALE X1.5 Y1.5 M8",
        "G1 SCALE X1.5 Y1.5",
        "/SCALE X1.5 Y1.5",
        "G41 D1 G1 X1 F100\nSCALE X1.5 Y1.5\nG40",
        "ASCALE X2 Y2\nASCALE X2 Y2",
        "ASCALE Z0.7\nASCALE Z0.7",
        "SCALE X1.5 Y1.5\nG18",
        "SCALE X1.5 Y1.5\nG55",
        "SCALE X1.5 Y1.5\nAMIRROR Z0",
        "SCALE X1.5 Y1.5\nG700",
    ] {
        let path = read(Dialect::Sinumerik, &format!("G710 G90 G17 G54\nG0 X0 Y0 Z0\n{on}\n{inside}TRANS\nG0 X1 Y1 Z1\nM30\n"));
        let found = feeds(&path);
        assert!(*found.last().unwrap() != YES, "{on}: {found:?}");
    }
    // A scaled Z has to be stated as the axes of the plane have.
    let path = |moves: &str| {
        let text = format!("G710 G90 G17 G54\nG0 X0 Y0 Z0\nSCALE X1.5 Y1.5 Z1.5\n{moves}\nM30\n");
        feeds(&read(Dialect::Sinumerik, &text))
    };
    assert_eq!(path("G0 X1 Y1\nG1 X2 F500"), [Shiftable::No(Fixed::UnknownStart)]);
    assert_eq!(path("G0 X1 Y1 Z1\nG1 X2 F500"), [YES]);
}

#[test]
fn after_a_rotation_begins_or_ends_one_block_states_both_coordinates() {
    const UNKNOWN: Shiftable = Shiftable::No(Fixed::UnknownStart);
    let head = "G21 G90 G17\nG0 X0 Y0 Z0\n";
    for (body, wanted) in [
        ("G68 X0 Y0 R30.\nG1 X5. F100.\nY5.\nX1.\n", &[UNKNOWN; 3][..]),
        ("G68 X0 Y0 R30.\nG1 X5. Y5. F100.\nX1.\n", &[UNKNOWN, YES]),
        ("G68 X0 Y0 R30.\nG91 G1 X5. Y5. F100.\nX1.\n", &[UNKNOWN; 2]),
        ("G68 X0 Y0 R30.\nG0 X5. Y5.\nG69\nG1 X1. F100.\nY1.\nX3.\n", &[UNKNOWN, UNKNOWN, YES]),
        // A machine axis that moves alone changes both.
        ("G68 X0 Y0 R30.\nG0 X5. Y5.\nG53 G0 X0.\nG1 X1. F100.\nX2.\n", &[UNKNOWN; 2]),
        ("G68 X0 Y0 R30.\nG0 X5. Y5.\nG91 G28 Y0.\nG90 G1 Y1. F100.\nX2.\n", &[UNKNOWN; 2]),
        ("G68 X0 Y0 R30.\nG0 X5. Y5.\nG53 G0 Z0.\nG0 Z1.\nG1 X1. F100.\n", &[YES]),
    ] {
        assert_eq!(feeds(&read(Dialect::Fanuc, &format!("{head}{body}M30\n"))), wanted, "{body}");
    }
}

#[test]
fn loops_are_left_alone_in_a_rotation_and_followed_where_they_are_written_out() {
    let head = "O1\nG21 G90 G17\nG0 X0 Y0 Z0\n";
    let inside =
        format!("{head}G68 X0 Y0 R30.\nG0 X5. Y5.\n#1=0\nWHILE[#1LT3]DO1\nG1 X[10.+#1] F100.\n#1=#1+1\nEND1\nG69\n{AFTER}");
    let around =
        format!("{head}#1=1\nWHILE[#1LT4]DO1\nG68 X0 Y0 R[#1*30.]\nG0 X5. Y5.\nG1 X9. F100.\nG69\n#1=#1+1\nEND1\n{AFTER}");
    for (text, moves) in [(inside, 3), (around, 3)] {
        let path = read(Dialect::Fanuc, &text);
        let found = feeds(&path);
        assert!(
            found[..moves].iter().all(|shiftable| *shiftable != YES) && found[found.len() - 2..] == [YES, YES],
            "{text}: {found:?}"
        );
        let flat = gcode::expand(&parse(text), &Dialect::Fanuc.into(), &|_| None).unwrap();
        let path = read(Dialect::Fanuc, std::str::from_utf8(&flat).unwrap());
        assert!(feeds(&path).iter().all(|shiftable| *shiftable == YES), "{:?}", path.warnings);
    }
}

#[test]
fn a_cycle_ends_where_it_drills() {
    let path = read(
        Dialect::Fanuc,
        "G21 G90 G17\nG0 X0 Y0 Z5.\nG68 X0 Y0 R90.\nG81 X10. Y0. Z-5. R2. F100.\nX20.\nG80\nG1 X30. F500.\nM30\n",
    );
    let ends: Vec<[f64; 3]> = path.moves.iter().map(|step| step.end.nominal_mm()).collect();
    assert_eq!(ends[1..], [[0.0, 10.0, 5.0], [0.0, 20.0, 5.0], [0.0, 30.0, 5.0]]);
    assert_eq!(feeds(&path), [YES]);
}

/// Whatever is not certain leaves the moves alone up to the end of the rotation, or of the program.
#[test]
fn uncertain_rotations_of_fanuc_are_left_alone() {
    let head = "G21 G90 G17 G54\nG0 X0 Y0 Z0\n";
    for body in [
        "G68 R30.\n",
        "G68 X0 R30.\n",
        "G68 X0 Y0\n",
        "G68 X0 Y0 R30\n",
        "G68 X0 Y0 R400.\n",
        "G68 X0 Y0 Z0 R30.\n",
        "G68 X0 Y0 R30. I0 J0 K1.\n",
        "G68 X0 Z0 R30.\n",
        "G68 X0 Y0 R#500\n",
        "G68 X0 Y0 R30. M8\n",
        "G68 X0 Y0 R30. F100.\n",
        "G0 G68 X0 Y0 R30.\n",
        "G91 G68 X0 Y0 R30.\nG90\n",
        "G91\nG68 X0 Y0 R30.\nG90\n",
        "G52 X5.\nG68 X0 Y0 R30.\n",
        "G92 X5.\nG68 X0 Y0 R30.\n",
        "G81 X0 Y0 Z-1. R1. F100.\nG68 X0 Y0 R30.\nG80\n",
        "G41 D1 G1 X1. F100.\nG68 X0 Y0 R30.\nG40\n",
        "G51 X0 Y0 P2000\nG68 X0 Y0 R30.\nG50\n",
        "G51.1 X0\nG68 X0 Y0 R30.\nG50.1 X0\n",
        "G16\nG68 X0 Y0 R30.\nG15\n",
        "G68 X0 Y0 R30.\nG16\nG15\n",
        "G68 X0 Y0 R30.\nG51.1 X0\nG50.1 X0\n",
        "G68 X0 Y0 R30.\nG68 X0 Y0 R40.\n",
        "G68 X0 Y0 R30.\nG52 X5.\n",
        "G68 X0 Y0 R30.\nG55\n",
        "G68 X0 Y0 R30.\nG54\n",
        "G68 X0 Y0 R30.\nG18\n",
        "G68 X0 Y0 R30.\nG20\n",
        "G68 X0 Y0 R30.\nG10 L2 P1 X0 Y0\n",
        "G68 X0 Y0 R30.\nG43.4 H1\n",
        "G68 X0 Y0 R30.\nG31 X1. F100.\n",
        "/G68 X0 Y0 R30.\n",
        "G68 X0 Y0 R30.\n/G52 X5.\n",
        "G68 X0 Y0 R30.\nM98 P77\nG90 G54 G17\n",
        "G65 P77\nG68 X0 Y0 R30.\nG90 G54 G17\n",
    ] {
        let path = read(Dialect::Fanuc, &format!("{head}{body}G0 X5. Y5. Z5.\nG1 Z0 F100.\nX9.\nG2 X19. R5.\nG0 Z5.\nM30\n"));
        let last = feeds(&path);
        assert!(last[last.len() - 3..].iter().all(|shiftable| *shiftable != YES), "{body}: {last:?}");
        assert!(!path.warnings.is_empty(), "{body}");
    }
    // Behind the end of the rotation the moves are read again.
    let text = format!("{head}G68 X0 Y0 R30.\nG52 X5.\nG52 X0\nG69\n{AFTER}");
    assert_eq!(feeds(&read(Dialect::Fanuc, &text)), [YES; 2]);
    // A rotary axis may carry the part.
    let rotary = read(Dialect::Fanuc, &format!("{head}G68 X0 Y0 R30.\nG0 X5. Y5. Z5.\nG1 X9. F100.\nG69\nG0 A90.\nM30\n"));
    assert!(feeds(&rotary).iter().all(|shiftable| *shiftable != YES));
}

#[test]
fn uncertain_rotations_of_sinumerik_are_left_alone() {
    for body in [
        "ROT X30",
        "ROT X30 Z20",
        "ROT RPL=R9",
        "ROT RPL=30 X5",
        "ROT RPL=400",
        "ROTS X10 Y20",
        "G18\nROT Z30",
        "ROT RPL=30\nG18",
        "ROT RPL=30\nG55",
        "ROT RPL=30\nSCALE X2\nAROT RPL=5",
        "ROT RPL=30\nASCALE X2",
        "ROT RPL=30\nAMIRROR Z0",
        "G18\nMIRROR Z0\nG17",
        "MIRROR X0\nAROT Y30",
        "MIRROR X0\nAMIRROR X0",
        "MIRROR X0\nAMIRROR Y0",
        "MIRROR X0 M8",
        "MIRROR X=R9",
        "MIRROR X=AC(0)",
        "/MIRROR X0",
        "MIRROR X0\nG55",
        "G41 D1 G1 X1 F100\nMIRROR X0\nG40",
        "MIRROR X1\nMIRROR X0",
        "MIRROR Y1\nTRANS\nMIRROR X0",
        "ROT RPL=30\nG58 X5",
        "ROT RPL=30\nCYCLE800(1,\"A\",0,57,0,0,0,0,0,0,0,0,0,1)",
        "ROT RPL=30\nTRAORI",
        "/ROT RPL=30",
        "ROT RPL=30\n$P_PFRAME=CTRANS(X,5)",
        "ROT RPL=30\nNOSUCH",
        "G41 D1 G1 X1 F100\nROT RPL=30\nG40",
    ] {
        let text = format!("G710 G90 G17 G54\nG0 X0 Y0 Z0\n{body}\nG0 X5 Y5 Z5\nG1 Z0 F100\nX9\nG0 Z5\nM30\n");
        let path = read(Dialect::Sinumerik, &text);
        let last = feeds(&path);
        assert!(last[last.len() - 2..].iter().all(|shiftable| *shiftable != YES), "{body}: {last:?}");
        assert!(!path.warnings.is_empty(), "{body}");
    }
}
