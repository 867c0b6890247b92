//! Controls that use less than the limits of the axes: along short lines, before dwells and in arcs.

use std::sync::Arc;

use motion::curves::{Arc as CircularArc, Line};
use motion::{Axis, Cartesian, Kinematics, Limits, Piece, PlanSettings, ToolPath, Vec3, plan};

fn xyz() -> Arc<dyn Kinematics> {
    Arc::new(Cartesian::new(Axis::xyz()))
}

fn limits() -> Limits {
    Limits::uniform(3, 80.0, 800.0, 0.02)
}

/// Largest change of speed along a path of lines and arcs from rest to rest, mm/s².
fn peak_acceleration(pieces: &[Piece], limits: &Limits, settings: &PlanSettings) -> f64 {
    peak_acceleration_within(pieces, 0.0, limits, settings)
}

/// The same further than `ends_mm` from both ends.
fn peak_acceleration_within(pieces: &[Piece], ends_mm: f64, limits: &Limits, settings: &PlanSettings) -> f64 {
    let mut path = ToolPath::default();
    pieces.iter().for_each(|piece| path.push(piece.clone()));
    let mut samples = plan(&path, &xyz(), limits, settings).unwrap().samples;
    let length_mm = samples.last().unwrap().position_mm;
    samples.retain(|sample| (ends_mm..=length_mm - ends_mm).contains(&sample.position_mm));
    let speeds: Vec<f64> =
        samples.windows(2).map(|pair| (pair[1].position_mm - pair[0].position_mm) / settings.period_s).collect();
    speeds.windows(2).map(|pair| (pair[1] - pair[0]).abs() / settings.period_s).fold(0.0, f64::max)
}

#[test]
fn the_line_before_a_dwell_counts_as_one_whose_end_is_not_rounded() {
    let settings = PlanSettings { short_line_acceleration: 0.5, smoothing_s: 0.0, ..PlanSettings::default() };
    let line = |dwell_s, corner_tolerance_mm| {
        let line = Line { start: Vec3::zeros(), end: Vec3::new(30.0, 0.0, 0.0) };
        let piece = Piece { dwell_s, corner_tolerance_mm, ..Piece::whole(Arc::new(line), 60.0) };
        peak_acceleration(&[piece], &limits(), &settings)
    };
    let whole = line(0.0, None);
    assert!((line(0.1, None) / whole - 0.5).abs() < 0.02, "{} {whole}", line(0.1, None));
    // At an exact stop no end would be rounded.
    assert_eq!(line(0.1, Some(0.0)), whole);
    // Of two lines the last one ends the program.
    let line = |from: f64, to: f64| {
        let curve = Line { start: Vec3::new(from, 0.0, 0.0), end: Vec3::new(to, 0.0, 0.0) };
        Piece { stop_after: true, ..Piece::whole(Arc::new(curve), 60.0) }
    };
    // Away from the short line.
    let path = |pieces: &[Piece]| peak_acceleration_within(pieces, 0.2, &limits(), &settings);
    let (first, last) = (path(&[line(0.0, 30.0), line(30.0, 30.1)]), path(&[line(0.0, 0.1), line(0.1, 30.1)]));
    assert!((first / whole - 1.0).abs() < 0.02 && (last / whole - 0.5).abs() < 0.02, "{first} {last} {whole}");
}

#[test]
fn along_arcs_the_acceleration_is_what_the_fastest_passage_leaves() {
    let limits = Limits { centripetal_mm_s2: 600.0, ..Limits::uniform(3, 80.0, 2000.0, 0.002) };
    let settings = PlanSettings { arc_acceleration_mm_s2: 1000.0, smoothing_s: 0.0, ..PlanSettings::default() };
    let circle = |radius_mm: f64| {
        let turn_rad = std::f64::consts::TAU;
        let arc = CircularArc::new(Vec3::new(radius_mm, 0.0, 0.0), Vec3::zeros(), Vec3::z(), turn_rad, radius_mm, 0.0).unwrap();
        Piece::whole(Arc::new(arc), 40.0)
    };
    let of = |pieces: &[Piece]| peak_acceleration(pieces, &limits, &settings);
    // Alone it keeps the whole of the acceleration across: √(1000² − 600²).
    assert!((of(&[circle(30.0)]) - 800.0).abs() < 8.0, "{}", of(&[circle(30.0)]));
    // In a row only what the largest speed needs: 80²/30 = 213 mm/s².
    let row = of(&[circle(30.0), circle(30.0)]);
    assert!((row - (1e6 - 213.3_f64.powi(2)).sqrt()).abs() < 10.0, "{row}");
    let unlimited = PlanSettings { arc_acceleration_mm_s2: f64::INFINITY, ..settings.clone() };
    assert!(peak_acceleration(&[circle(30.0)], &limits, &unlimited) > 1900.0);
}

#[test]
fn arcs_and_short_lines_in_a_plane_with_a_slow_axis_are_as_slow_as_it_in_every_direction() {
    let mut limits = Limits { centripetal_mm_s2: 600.0, ..Limits::uniform(3, 80.0, 2000.0, 0.002) };
    limits.axes[2].acceleration = 500.0;
    let settings = PlanSettings {
        arc_acceleration_mm_s2: 1000.0,
        short_line_acceleration: 0.5,
        smoothing_s: 0.0,
        corner_tolerance_mm: 0.01,
        ..PlanSettings::default()
    };
    // A circle about `axis` that begins and ends along x, where the other axis of its plane needs little acceleration.
    let circle = |axis: Vec3| {
        let (turn_rad, from) = (std::f64::consts::TAU, Vec3::x().cross(&axis) * -30.0);
        Piece::whole(Arc::new(CircularArc::new(from, Vec3::zeros(), axis, turn_rad, 30.0, 0.0).unwrap()), 40.0)
    };
    let of = |pieces: &[Piece]| peak_acceleration(pieces, &limits, &settings);
    let (level, upright) = (of(&[circle(Vec3::z())]), of(&[circle(Vec3::y())]));
    assert!((level - 800.0).abs() < 8.0 && (upright - 400.0).abs() < 8.0, "{level} {upright}");
    let lines = |side: Vec3| -> Vec<Piece> {
        let at = |k: i32| Vec3::x() * (0.5 * f64::from(k)) + side * (0.0125 * f64::from(k % 2));
        let line = |k| Piece::whole(Arc::new(Line { start: at(k), end: at(k + 1) }), 40.0);
        (0..40).map(line).collect()
    };
    // The first and the last half of a line belong to no blend.
    let of = |pieces: &[Piece]| peak_acceleration_within(pieces, 0.3, &limits, &settings);
    let (level, upright) = (of(&lines(Vec3::y())), of(&lines(Vec3::z())));
    assert!((level - 500.0).abs() < 25.0 && (upright - 250.0).abs() < 25.0, "{level} {upright}");
}
