//! The control test of `excite`: its content as read back, its extent, and what training makes of its log.

use std::path::Path;

use gcode::{Dialect, Feed, Move, MoveKind};

use crate::common::{Folder, TRAINING_SEED, csv_files};

const PROGRAM: &str = "e/control-test.nc";

/// Excites a machine in the folder `e` and returns the duration of the control test, s.
fn excite(folder: &Folder, words: &[&str]) -> f64 {
    let figures = folder.figures(&[&["excite", "-o", "e", "--seconds", "10"], words].concat());
    figures["control_test"]["seconds"].as_f64().unwrap()
}

/// Moves of the program.
fn moves(program: &Path) -> Vec<Move> {
    let program = gcode::parse(std::fs::read(program).unwrap());
    let options = Dialect::detect(&program).into();
    gcode::interpret(&program, &options).unwrap().moves
}

/// The moves of the program for `ballscrew`.
fn of_ballscrew() -> Vec<Move> {
    let folder = Folder::new();
    excite(&folder, &[]);
    moves(&folder.path(PROGRAM))
}

/// Displacement, mm and rad.
fn displacement(of: &Move) -> [f64; 6] {
    let ([x, y, z], [a, b, c]) = (of.end.nominal_mm(), of.end.nominal_rotary_rad());
    let ([u, v, w], [d, e, f]) = (of.start.nominal_mm(), of.start.nominal_rotary_rad());
    [x - u, y - v, z - w, a - d, b - e, c - f]
}

/// Axes that move, as a mask: bit 0 is x.
fn mask(of: &Move) -> u8 {
    displacement(of).iter().enumerate().map(|(slot, way)| u8::from(way.abs() > 1e-9) << slot).sum()
}

fn length(of: &Move) -> f64 {
    displacement(of).iter().map(|way| way * way).sum::<f64>().sqrt()
}

fn feed_mm_s(of: &Move) -> f64 {
    match of.feed {
        Some(Feed::Linear { mm_s }) => mm_s,
        other => panic!("{other:?}"),
    }
}

/// Number of values that differ by more than a hundredth.
fn distinct(values: impl IntoIterator<Item = f64>) -> usize {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    values.dedup_by(|a, b| (*a - *b).abs() < 0.01 * b.abs());
    values.len()
}

fn is_dwell(of: &Move) -> bool {
    matches!(of.kind, MoveKind::Dwell { .. })
}

/// Moves of a kind that begin and end at a standstill.
fn between_dwells(moves: &[Move], is_kind: impl Fn(&Move) -> bool) -> Vec<&Move> {
    let alone = moves.windows(3).filter(|row| is_dwell(&row[0]) && is_dwell(&row[2]) && is_kind(&row[1]));
    alone.map(|row| &row[1]).collect()
}

fn is_line(of: &Move) -> bool {
    matches!(of.kind, MoveKind::Line)
}

#[test]
fn single_moves_have_many_lengths_on_each_axis_and_on_diagonals() {
    let moves = of_ballscrew();
    let lines = between_dwells(&moves, is_line);
    for axes in [0b1, 0b10, 0b100] {
        let lengths = distinct(lines.iter().filter(|of| mask(of) == axes).map(|of| length(of)));
        assert!(lengths >= 4, "{lengths} lengths of axes {axes:#b}");
    }
    for axes in [0b11, 0b101, 0b110, 0b111] {
        assert!(lines.iter().any(|of| mask(of) == axes), "{axes:#b}");
    }
    // At 4320 mm/min the shortest ones end long before the feed is reached, the longest ones hold it.
    let reach_mm = 72.0_f64.powi(2) / 800.0;
    let single: Vec<f64> = lines.iter().filter(|of| mask(of) == 1).map(|of| length(of)).collect();
    assert!(single.iter().any(|way| *way < 0.2 * reach_mm) && single.iter().any(|way| *way > 1.5 * reach_mm), "{single:?}");
}

#[test]
fn corners_have_angles_from_15_to_165_degrees_at_three_feeds_and_in_two_planes() {
    let moves = of_ballscrew();
    let mut corners: Vec<(u8, f64, i64)> = Vec::new();
    let rows = moves.chunk_by(|a, b| is_line(a) && is_line(b)).filter(|row| [7, 12].contains(&row.len()));
    for pair in rows.flat_map(|row| row.windows(2)) {
        // Long enough for the feed with three quarters of the acceleration.
        assert!(length(&pair[0]) > feed_mm_s(&pair[0]).powi(2) / 600.0);
        let (a, b) = (displacement(&pair[0]), displacement(&pair[1]));
        let cosine = a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / (length(&pair[0]) * length(&pair[1]));
        let angle_deg = cosine.clamp(-1.0, 1.0).acos().to_degrees();
        corners.push((mask(&pair[0]) | mask(&pair[1]), feed_mm_s(&pair[0]), angle_deg.round() as i64));
    }
    let angles_at = |plane: u8, share: f64| {
        let is_in = |(of, feed, _): &&(u8, f64, i64)| *of == plane && (feed - share * 80.0).abs() < 0.1;
        let mut angles: Vec<i64> = corners.iter().filter(is_in).map(|(.., angle)| *angle).collect();
        angles.sort_unstable();
        angles
    };
    let all: Vec<i64> = (1..=11).map(|k| 15 * k).collect();
    for share in [0.9, 0.45, 0.2] {
        assert_eq!(angles_at(0b11, share), all, "{share}");
    }
    let elsewhere = [0b101, 0b110].map(|plane| angles_at(plane, 0.45));
    assert!(elsewhere.iter().any(|angles| *angles == [15, 45, 75, 105, 135, 165]), "{elsewhere:?}");
}

#[test]
fn arcs_have_many_radii_at_three_feeds_in_both_directions_and_with_tangents() {
    let moves = of_ballscrew();
    let arcs: Vec<(&Move, gcode::Arc)> = moves
        .iter()
        .filter_map(|of| match of.kind {
            MoveKind::Arc(arc) => Some((of, arc)),
            _ => None,
        })
        .collect();
    assert!(distinct(arcs.iter().map(|(_, arc)| arc.radius_start_mm)) >= 12);
    assert_eq!(distinct(arcs.iter().map(|(of, _)| feed_mm_s(of))), 3);
    let count = |is_counted: &dyn Fn(&gcode::Arc) -> bool| arcs.iter().filter(|(_, arc)| is_counted(arc)).count();
    assert_eq!(count(&|arc| (arc.sweep.abs() - std::f64::consts::TAU).abs() < 1e-9), 9);
    assert!(count(&|arc| arc.sweep > 0.0) >= 3 && count(&|arc| arc.sweep < 0.0) >= 3);
    // Centripetal acceleration below and above that of the machine.
    let across: Vec<f64> = arcs.iter().map(|(of, arc)| feed_mm_s(of).powi(2) / arc.radius_start_mm).collect();
    assert!(across.iter().any(|a| *a < 400.0) && across.iter().any(|a| *a > 1500.0), "{across:?}");
    let tangent = moves.windows(3).filter(|row| is_line(&row[0]) && matches!(row[1].kind, MoveKind::Arc(_)) && is_line(&row[2]));
    assert_eq!(tangent.count(), 3);
    for row in moves.windows(2).filter(|row| is_line(&row[0])) {
        if let MoveKind::Arc(arc) = row[1].kind {
            let [x, y, ..] = displacement(&row[0]);
            let [start_x, start_y, _] = row[1].start.nominal_mm();
            let along =
                (x * (arc.centre_mm[0] - start_x) + y * (arc.centre_mm[1] - start_y)) / (x.hypot(y) * arc.radius_start_mm);
            assert!(along.abs() < 1e-3, "{along}");
        }
    }
}

#[test]
fn short_lines_are_a_tenth_to_half_a_millimetre_long() {
    let moves = of_ballscrew();
    // Rows of lines without a stop between them.
    let rows: Vec<&[Move]> = moves.chunk_by(|a, b| is_line(a) && is_line(b)).filter(|row| row.len() > 20).collect();
    assert_eq!(rows.len(), 5);
    let mut lengths = Vec::new();
    for row in rows {
        let mean = row.iter().map(length).sum::<f64>() / row.len() as f64;
        assert!(row.iter().all(|of| (length(of) - mean).abs() < 1e-3), "{mean}");
        lengths.push(mean);
    }
    assert_eq!(distinct(lengths.iter().copied()), 5);
    assert!(lengths.iter().all(|mm| (0.09..0.52).contains(mm)), "{lengths:?}");
}

#[test]
fn rapids_have_many_lengths_on_each_axis_and_on_two_axes() {
    let moves = of_ballscrew();
    let rapids = between_dwells(&moves, |of| matches!(of.kind, MoveKind::Rapid));
    for axes in [0b1, 0b10, 0b100] {
        let lengths = distinct(rapids.iter().filter(|of| mask(of) == axes).map(|of| length(of)));
        assert!(lengths >= 3, "{lengths} lengths of axes {axes:#b}");
    }
    for axes in [0b11, 0b101, 0b110] {
        assert!(rapids.iter().any(|of| mask(of) == axes), "{axes:#b}");
    }
}

#[test]
fn the_program_returns_to_its_start_and_states_its_duration() {
    let folder = Folder::new();
    let seconds = excite(&folder, &[]);
    assert!((40.0..65.0).contains(&seconds), "{seconds}");
    assert!(folder.read(PROGRAM).contains(&format!(" MM/MIN, {seconds:.1} S)")));
    let simulated = folder.figures(&["simulate", PROGRAM, "-o", "run.csv"]);
    assert!((simulated["seconds"].as_f64().unwrap() - seconds).abs() < 1e-6);
    let moves = moves(&folder.path(PROGRAM));
    assert_eq!(moves.last().unwrap().end.xyz_mm(), Some([0.0; 3]));
    // The control decides how the program runs: there is no reference.
    assert!(!folder.path("e/control-test.csv").exists());
}

#[test]
fn the_seed_repeats_the_bytes() {
    let folder = Folder::new();
    let written = |seed: &str| {
        excite(&folder, &["--seed", seed]);
        folder.read(PROGRAM)
    };
    let first = written("3");
    assert_eq!(first, written("3"));
    assert_ne!(first, written("4"));
}

#[test]
fn rotary_axes_move_alone() {
    for (machine, axes) in [("bc", [0b10000_u8, 0b100000]), ("xyzac", [0b1000, 0b100000])] {
        let folder = Folder::new();
        excite(&folder, &["--machine", machine]);
        let moves = moves(&folder.path(PROGRAM));
        for is_kind in [is_line, |of: &Move| matches!(of.kind, MoveKind::Rapid)] {
            let alone = between_dwells(&moves, is_kind);
            assert!(axes.iter().all(|axis| alone.iter().filter(|of| mask(of) == *axis).count() >= 4), "{machine}");
        }
        assert!(moves.iter().filter(|of| mask(of) > 7 && is_line(of)).all(|of| matches!(of.feed, Some(Feed::Angular { .. }))));
        folder.figures(&["simulate", PROGRAM, "--machine", machine, "-o", "run.csv"]);
    }
}

#[test]
fn the_travel_of_the_machine_and_the_range_of_the_options_are_kept() {
    let folder = Folder::new();
    let machine = include_str!("../../machine/machines/ballscrew.toml");
    // Off the centre, and short in y.
    let mut travels = ["[0.0, 300.0]", "[-8.0, 2.0]", "[-90.0, -50.0]"].into_iter();
    let mut of_axis = |line: &str| if line == "kind = \"linear\"" { travels.next() } else { None };
    let lines =
        machine.lines().map(|line| of_axis(line).map_or(line.to_owned(), |travel| format!("{line}\ntravel_mm = {travel}")));
    folder.write("mill.toml", lines.collect::<Vec<_>>().join("\n"));
    excite(&folder, &["--machine", "mill.toml", "--travel", "70"]);
    folder.figures(&["simulate", PROGRAM, "--machine", "mill.toml", "-o", "run.csv"]);
    let moves = moves(&folder.path(PROGRAM));
    // About 0, or as near to it as ±70 mm fits.
    let ranges = [(15.0, 155.0), (-7.5, 1.5), (-88.0, -52.0)];
    for of in moves.iter().skip(3).filter(|of| !is_dwell(of)) {
        for k in 0..=32 {
            let at = of.point_mm(f64::from(k) / 32.0);
            for (position, (low, high)) in at.iter().zip(ranges) {
                assert!((low - 1e-6..=high + 1e-6).contains(position), "{position} beyond {low} to {high}: {of:?}");
            }
        }
    }
}

#[test]
fn sluggish_machines_take_less_than_two_minutes() {
    for seed in ["random:3", "random:16", "random:26"] {
        let folder = Folder::new();
        let seconds = excite(&folder, &["--machine", seed]);
        assert!(seconds < 110.0, "{seed}: {seconds}");
        assert!(moves(&folder.path(PROGRAM)).iter().any(|of| matches!(of.kind, MoveKind::Arc(_))), "{seed}");
    }
}

#[test]
fn every_control_reads_its_words() {
    for controller in ["linuxcnc", "fanuc", "siemens", "grbl", "generic"] {
        let folder = Folder::new();
        excite(&folder, &["--controller", controller]);
        let text = folder.read(PROGRAM);
        let dwell = match controller {
            "fanuc" => "G4 P100\n",
            "siemens" => "G4 F0.1\n",
            _ => "G4 P0.1\n",
        };
        assert!(text.contains(dwell) && text.contains("\nG2 X") && text.contains("\nG3 X"), "{controller}");
        assert_eq!((text.contains("G64 P"), text.contains("O7011\n")), (controller == "linuxcnc", controller == "fanuc"));
        // Its times are those of the control.
        assert!(!text.contains("G93"), "{controller}");
        folder.figures(&["simulate", PROGRAM, "-o", "run.csv"]);
    }
}

#[test]
fn its_log_may_be_among_the_logs_of_training() {
    let folder = Folder::new();
    folder.figures(&["excite", "-o", "e", "--seconds", "20"]);
    let mut logs = Vec::new();
    for path in csv_files(&folder.path("e")).into_iter().chain([folder.path(PROGRAM)]) {
        let log = format!("log-{}.csv", path.file_stem().unwrap().to_string_lossy());
        let seed = (TRAINING_SEED + logs.len()).to_string();
        folder.figures(&["simulate", &path.to_string_lossy(), "-o", &log, "--seed", &seed]);
        logs.push(log);
    }
    folder.figures(&["simulate", "curve:nurbs-2", "-o", "unseen.csv"]);
    let error_um = |logs: &[String]| {
        let logs = logs.iter().map(String::as_str);
        let words: Vec<&str> = ["train"]
            .into_iter()
            .chain(logs)
            .chain(["--machine", "ballscrew", "--predictor", "linear", "-o", "m.model"])
            .collect();
        folder.figures(&words);
        let fit = folder.figures(&["measure", "unseen.csv", "-m", "m.model"]);
        ["x", "y", "z"].map(|axis| fit["model"][axis]["rms_um"].as_f64().unwrap())
    };
    let (without, with) = (error_um(&logs[..logs.len() - 1]), error_um(&logs));
    assert!(with.iter().zip(&without).all(|(with, without)| *with < 1.1 * without), "{with:?} against {without:?}");
}
