//! A curve as a program of short lines, in the form in which a CAM system writes a finishing path.

use gcode::{Dialect, Options, Units, format_angle, format_coordinate, format_number};
use machine::ProgramWords;
use motion::curves::library;
use motion::{DesiredPath, Kinematics, Vec6};

use crate::error::Result;
use crate::input::Input;
use crate::part::{Part, WorkOffsets, stated};
use crate::refit::DECIMALS;
use crate::setup::Setup;

/// A built-in curve as a program of short lines in tool tip coordinates at one feed, planned for the setup. Its
/// points are about `spacing_mm` apart.
///
/// # Errors
/// When the curve does not exist, or the machine cannot run it.
pub fn curve_program(name: &str, feed_mm_s: f64, spacing_mm: f64, setup: &Setup) -> Result<Part> {
    let curve = Input::curve(name, feed_mm_s, setup)?;
    planned(name, &points(curve.desired(), spacing_mm), feed_mm_s, setup)
}

/// As [`curve_program`], with points in equal steps of the curve's parameter, as Paper A makes its programs. For machines without rotary axes.
///
/// # Errors
/// As [`curve_program`].
pub fn curve_program_in_steps(name: &str, feed_mm_s: f64, step: f64, setup: &Setup) -> Result<Part> {
    let curve = library::by_name(name)?;
    let (from, to) = curve.domain();
    let steps = ((to - from) / step).ceil().max(1.0) as usize;
    let point = |i: usize| {
        let tip = curve.point((from + step * i as f64).min(to));
        Vec6::new(tip.x, tip.y, tip.z, 0.0, 0.0, 0.0)
    };
    planned(name, &(0..=steps).map(point).collect::<Vec<_>>(), feed_mm_s, setup)
}

/// The program through these points, planned.
fn planned(name: &str, points: &[Vec6], feed_mm_s: f64, setup: &Setup) -> Result<Part> {
    let program = gcode::parse(short_lines(points, setup.kinematics.as_ref(), feed_mm_s)?);
    let options = Options::from(Dialect::Fanuc);
    Part::planned(name, program, options, &WorkOffsets::default().or_zero(), setup, &setup.plan_settings())
}

/// Program of lines through tip and rotary coordinates.
fn short_lines(points: &[Vec6], kinematics: &dyn Kinematics, feed_mm_s: f64) -> Result<String> {
    let mut text = String::from("G21 G90 G94 G17 G40 G49 G80\n");
    if kinematics.has_rotary_axes() {
        text.push_str("G43.4 H1\n");
    }
    for (number, point) in points.iter().enumerate() {
        match number {
            0 => text.push_str("G0"),
            1 => text += &format!("G1F{}", format_number(feed_mm_s * 60.0, DECIMALS)?),
            _ => {}
        }
        for axis in kinematics.axes() {
            let Some(slot) = axis.slot() else { continue };
            let value = match slot {
                0..3 => format_coordinate(point[slot], Units::Mm, DECIMALS)?,
                _ => format_angle(point[slot], DECIMALS)?,
            };
            text += &format!("{}{value}", axis.name.to_uppercase());
        }
        text.push('\n');
    }
    text.push_str("M30\n");
    Ok(text)
}

/// Tip and rotary coordinates at the first sample, at samples at least `spacing_mm` apart, and at the last sample.
fn points(path: &DesiredPath, spacing_mm: f64) -> Vec<Vec6> {
    let (trajectory, kinematics) = (path.trajectory(), path.kinematics().as_ref());
    let at = |k: usize| stated(&trajectory.at(k).collect::<Vec<f64>>(), kinematics, ProgramWords::Tip);
    let apart = |a: &Vec6, b: &Vec6, least_mm: f64| (b - a).fixed_rows::<3>(0).norm() >= least_mm;
    let mut points: Vec<Vec6> = Vec::new();
    for point in (0..trajectory.len()).map(at) {
        if points.last().is_none_or(|before| apart(before, &point, spacing_mm)) {
            points.push(point);
        }
    }
    // Avoids a last line that is much shorter than the others.
    if let Some(end) = trajectory.len().checked_sub(1).map(at) {
        if points.len() > 1 && !points.last().is_none_or(|before| apart(before, &end, 0.5 * spacing_mm)) {
            points.pop();
        }
        points.push(end);
    }
    points
}
