//! Programs written through the library with a smooth pseudo-random correction in place of a learned one.

use std::collections::BTreeSet;
use std::f64::consts::TAU;
use std::path::Path;

use gcode::{Dialect, PathMode};
use machine::ControllerSpec;
use motion::Trajectory;
use pipeline::refit::TimeEncoding;
use pipeline::{Error, Input, MachineSpec, OutputFormat, OutputSettings, Part, ReadSettings, Setup};

use crate::random::Random;

/// Written lines may lie this far from the corrected curve, mm (`CHORD_TOLERANCE_MM`), and are rounded to four decimals or more.
const WRITTEN_MM: f64 = 5e-4;

/// How a program is written.
#[derive(Debug, Clone, Copy)]
pub struct Way {
    pub controller: &'static str,
    pub encoding: TimeEncoding,
    pub decimals: usize,
    pub block_delete: Option<bool>,
}

pub struct Compensated {
    pub bytes: Vec<u8>,
    /// N words of blocks whose moves may be shifted.
    pub shiftable: BTreeSet<u32>,
    /// Largest distance of a written point from the original path, mm.
    pub off_mm: f64,
    /// Least time between points within a move, s.
    pub spacing_s: f64,
    /// That part of `off_mm` which is the control's own rounding of corners.
    pub corner_mm: f64,
}

/// The machine of all programs: three axes.
pub fn setup(controller: &str) -> Setup {
    let machine = MachineSpec::builtin("ballscrew").unwrap();
    Setup::new(&machine, Some(ControllerSpec::builtin(controller).unwrap())).unwrap()
}

pub fn read(program: &[u8], way: &Way) -> Result<Part, Error> {
    read_with(program, way, false)
}

/// The same, with loops and subprograms written flat where `expand` is set.
pub fn read_with(program: &[u8], way: &Way, expand: bool) -> Result<Part, Error> {
    let dialect = Some(Dialect::LinuxCnc);
    let settings = ReadSettings { dialect, block_delete: way.block_delete, expand, ..ReadSettings::default() };
    Part::read("oracle.ngc", program, &setup(way.controller), &settings)
}

/// Writes the program that was read with a correction drawn from `seed`.
pub fn write(mut part: Part, way: &Way, seed: u64) -> Result<Compensated, Error> {
    let settings =
        OutputSettings::new(&setup(way.controller), Some(OutputFormat::Program(way.encoding)), Some(way.decimals), None);
    settings.prepare(&mut part);
    let mut random = Random(seed);
    let max_shift_mm = random.pick(&[0.003, 0.01, 0.05]);
    let weights = part.taper();
    let wanted = shifted(&part, max_shift_mm, &mut random);
    let input = Input::from(part);
    let reference = input.correction_limits(max_shift_mm, 0.0, weights).apply(input.desired(), &wanted)?;
    let output = input.write(&reference, &settings, max_shift_mm, Path::new("oracle.ngc"))?;
    let part = input.program()?;
    let moves = part.toolpath.moves.iter().filter(|step| step.is_feed() && part.is_shiftable(step));
    Ok(Compensated {
        bytes: output.content,
        shiftable: moves.filter_map(|step| number(part, step.block as usize)).collect(),
        off_mm: max_shift_mm + WRITTEN_MM + corner_mm(part),
        spacing_s: settings.refit().spacing_s,
        corner_mm: corner_mm(part),
    })
}

/// Length of all feed moves, and of those that may be shifted, mm.
pub fn lengths_mm(part: &Part) -> [f64; 2] {
    let feeds = || part.toolpath.moves.iter().filter(|step| step.is_feed());
    let length = |moves: &mut dyn Iterator<Item = &gcode::Move>| {
        moves.filter_map(gcode::Move::length_mm).fold(0.0, |sum, length| sum + length)
    };
    [length(&mut feeds()), length(&mut feeds().filter(|step| part.is_shiftable(step)))]
}

/// The N word of a block.
fn number(part: &Part, block: usize) -> Option<u32> {
    part.program.block_words(block).iter().find(|word| word.is(b'N')).and_then(gcode::Word::number).map(|value| value as u32)
}

/// The largest corner tolerance of the program, mm. Where segments state a smaller one, their points include the rounding that the program
/// allowed.
fn corner_mm(part: &Part) -> f64 {
    let tolerance = |step: &gcode::Move| match part.toolpath.modal(step).path {
        PathMode::Continuous { tolerance_mm: Some(mm), .. } if part.states_path => mm,
        _ => part.settings.corner_tolerance_mm,
    };
    part.toolpath.moves.iter().map(tolerance).fold(0.0, f64::max)
}

/// The plan plus sums of sines of the path coordinate, at most `max_shift_mm` long.
fn shifted(part: &Part, max_shift_mm: f64, random: &mut Random) -> Trajectory {
    let plan = part.plan.desired.trajectory();
    let columns = plan.columns().iter().map(|column| {
        let waves: [(f64, f64, f64); 3] =
            std::array::from_fn(|_| (random.between(0.1, 0.33), random.between(3.0, 80.0), random.between(0.0, TAU)));
        let shift = |position_mm: f64| -> f64 {
            waves
                .iter()
                .map(|(share, period_mm, phase)| share * max_shift_mm * (position_mm / period_mm * TAU + phase).sin())
                .sum()
        };
        column.iter().zip(&part.plan.samples).map(|(at, sample)| at + shift(sample.position_mm)).collect()
    });
    plan.with_columns(columns.collect()).unwrap()
}
