//! Learning on a machine that is given programs: every reference is written as G-code, whose time the control plans anew.

use std::fmt::Write;

use anyhow::Result;
use compensation::{CompensationLaw, Guard};
use gcode::{Dialect, Options, Units, format_angle, format_coordinate, format_number};
use machine::{Machine, ProgramWords};
use motion::{DesiredPath, Trajectory, Vec6};

use crate::evaluate::{self, Figures};
use crate::input::{Frame, Input};
use crate::measurement::in_time_of;
use crate::pipeline::tool_path::stated;
use crate::pipeline::{Carrier, Part, RefitSettings, Replanned, WorkOffsets};

/// Digits after the point, mm and degrees: far below an encoder's count.
const DECIMALS: usize = 6;

/// Points are moved, none is added: more of them where a program is slow would only bring noise there, which a control slows down for.
pub const MOVE_POINTS: RefitSettings = RefitSettings {
    carrier: Carrier::Keep,
    decimals: DECIMALS,
    spacing_s: f64::INFINITY,
    chord_tolerance_mm: f64::INFINITY,
    path_tolerance_mm: None,
};

/// How a law sees a run that does not keep the path's time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pairing {
    /// At the instants at which its own command passes the path's places.
    Place,
    /// At the path's instants, as if it had kept them.
    Time,
}

/// One run of a program.
#[derive(Debug, Clone)]
pub struct Run {
    /// What the control commanded.
    pub command: Trajectory,
    /// For every sample its place on the path, as a sample index with fraction.
    pub places: Vec<f64>,
    /// What the machine did, at the same instants.
    pub actual: Trajectory,
    /// Against the program's own path.
    pub figures: Figures,
}

/// A program, and the control that plans what becomes of it.
#[derive(Debug)]
pub struct Programmed {
    part: Part,
    frame: Frame,
}

impl Programmed {
    /// A built-in curve as short lines in words of the tool tip at one feed.
    ///
    /// # Errors
    /// When there is no such curve, or the machine cannot run it.
    pub fn curve(name: &str, feed_mm_s: f64, spacing_mm: f64, frame: &Frame) -> Result<Self> {
        let curve = Input::curve(name, feed_mm_s, frame)?.desired;
        let text = short_lines(&curve, feed_mm_s, spacing_mm)?;
        let settings = frame.plan_settings();
        let options = Options::from(Dialect::Fanuc);
        let part = Part::read(name, gcode::parse(text), Some(&options), &WorkOffsets::default().or_zero(), frame, &settings)?;
        Ok(Self { part, frame: frame.clone() })
    }

    /// The program as planned uncompensated: its path is what the part needs.
    #[must_use]
    pub fn part(&self) -> &Part {
        &self.part
    }

    /// Runs the program with its points moved as `reference` says.
    ///
    /// # Errors
    /// When the program cannot be written or planned, or the run fails.
    pub fn run(&self, machine: &mut dyn Machine, reference: &Trajectory) -> Result<Run> {
        let Replanned { command, places, .. } = Replanned::new(&self.part, reference, &MOVE_POINTS, &self.frame.limits)?;
        let actual = machine.run(&command)?;
        let figures = evaluate::figures_along(&self.part.plan.desired, Some(&self.part), &command, &actual)?;
        Ok(Run { command, places, actual, figures })
    }

    /// Runs the program, lets `law` move its points within `bounds`, and runs it again, `updates` times. Nothing moves at a standstill.
    ///
    /// # Errors
    /// As [`Programmed::run`], and when the law or the guard fails.
    pub fn learn(
        &self,
        machine: &mut dyn Machine,
        law: &mut dyn CompensationLaw,
        pairing: Pairing,
        updates: usize,
        bounds: &Guard,
    ) -> Result<Vec<Run>> {
        let desired = &self.part.plan.desired;
        let guard = Guard { weights: weights(desired.trajectory()), ..bounds.clone() };
        let mut reference = desired.trajectory().clone();
        let mut runs: Vec<Run> = Vec::with_capacity(updates + 1);
        for _ in 0..=updates {
            if let Some(last) = runs.last() {
                let seen = self.seen(last, pairing)?;
                reference = guard.apply(desired, &law.update(desired, &reference, &seen)?)?;
            }
            runs.push(self.run(machine, &reference)?);
        }
        Ok(runs)
    }

    /// The run with one sample for every sample of the path.
    fn seen(&self, run: &Run, pairing: Pairing) -> Result<Trajectory> {
        let desired = &self.part.plan.desired;
        match pairing {
            Pairing::Time => in_step(&run.actual, desired.trajectory().len()),
            // The command tells where the run should have been, to the micrometre: better than a delay of the whole run.
            Pairing::Place => Ok(in_time_of(desired.trajectory(), &run.actual, &run.places)?),
        }
    }
}

/// The first `samples` of a run, the last one held where there are fewer: beside a path as if it had kept its time.
///
/// # Errors
/// As [`Trajectory::new`].
pub fn in_step(run: &Trajectory, samples: usize) -> Result<Trajectory> {
    let columns = run.columns().iter().map(|column| {
        let last = column.last().copied().unwrap_or_default();
        column.iter().copied().chain(std::iter::repeat(last)).take(samples).collect()
    });
    Ok(Trajectory::new(run.period_s(), run.axes().to_vec(), columns.collect())?)
}

/// None of a correction where the path stands still, all of it elsewhere: a program begins and ends where it says, and there a servo's
/// integrator brings the axes to where they are commanded.
fn weights(path: &Trajectory) -> Vec<f64> {
    let moves = |k: usize| k + 1 < path.len() && path.at(k).ne(path.at(k + 1));
    (0..path.len()).map(|k| f64::from(u8::from(k > 0 && moves(k - 1) && moves(k)))).collect()
}

/// A program through the path's places at least `spacing_mm` apart, its ends included.
fn short_lines(path: &DesiredPath, feed_mm_s: f64, spacing_mm: f64) -> Result<String> {
    let mut text = String::from("G21 G90 G94 G17 G40 G49 G80\n");
    let kinematics = path.kinematics().as_ref();
    if kinematics.turns() {
        text.push_str("G43.4 H1\n");
    }
    for (number, point) in points(path, spacing_mm).into_iter().enumerate() {
        match number {
            0 => text.push_str("G0"),
            1 => write!(text, "G1F{}", format_number(feed_mm_s * 60.0, DECIMALS)?)?,
            _ => {}
        }
        for axis in kinematics.axes() {
            let Some(slot) = axis.slot() else { continue };
            let value = match slot {
                0..3 => format_coordinate(point[slot], Units::Mm, DECIMALS)?,
                _ => format_angle(point[slot], DECIMALS)?,
            };
            write!(text, "{}{value}", axis.name.to_uppercase())?;
        }
        text.push('\n');
    }
    text.push_str("M30\n");
    Ok(text)
}

/// Tip and rotary axes at the path's first sample, at every one `spacing_mm` after the one before, and at its last.
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
    // No line at the end is much shorter than the others.
    if let Some(end) = trajectory.len().checked_sub(1).map(at) {
        if points.len() > 1 && !points.last().is_none_or(|before| apart(before, &end, 0.5 * spacing_mm)) {
            points.pop();
        }
        points.push(end);
    }
    points
}
