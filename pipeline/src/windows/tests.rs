//! Wherever a program is cut, a window moves the machine as the whole program does.

use std::f64::consts::TAU;
use std::fmt::Write;
use std::ops::Range;
use std::sync::Arc;

use machine::{Machine, MachineSpec, SimulatedMachine, SimulationOptions};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::cuts::scan;
use crate::input::Input;
use crate::part::{Part, ReadSettings, Whole};
use crate::setup::Setup;
use crate::statistics::{SampleErrors, counts, rms_max};

/// Programs drawn, and windows of each.
const PROGRAMS: u64 = 8;
const WINDOWS: usize = 6;
/// Largest difference of a window's figures, µm and relative: where the samples lie at other places of the path, a peak is met or missed
/// by a little, and a limit binds a sample earlier or later.
const FLOOR_UM: f64 = 0.01;
const RMS: f64 = 0.01;
const MAX: f64 = 0.05;
/// Largest relative difference of a window's time, and samples at its ends.
const TIME: f64 = 0.02;
const ENDS: f64 = 2.0;

/// About a minute of what milling programs are made of, within ±25 mm.
fn program(seed: u64) -> String {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut out = String::from("G21 G90 G17 G40 G49 G80\nG54\nG0 X0. Y0. Z5.\nG1 Z0. F600.\n");
    let (mut x, mut y, mut feed) = (0.0_f64, 0.0_f64, 1500.0);
    for _ in 0..40 {
        match random.random_range(0..20) {
            0..10 => {
                let mut angle = random.random_range(0.0..TAU);
                let step = random.random_range(0.2..1.5);
                for _ in 0..random.random_range(10..60) {
                    angle += random.random_range(-0.3..0.3);
                    let next = (x + step * angle.cos(), y + step * angle.sin());
                    if next.0.abs() > 20.0 || next.1.abs() > 20.0 {
                        angle += TAU / 2.0;
                        continue;
                    }
                    (x, y) = next;
                    let z = random.random_range(-0.05..0.05);
                    writeln!(out, "G1 X{x:.3} Y{y:.3} Z{z:.3} F{feed:.1}").unwrap();
                }
            }
            10..13 if x < 10.0 => {
                let radius = random.random_range(1.0..5.0);
                writeln!(out, "G{} X{:.3} I{radius:.3} J0.", random.random_range(2..4), x + 2.0 * radius).unwrap();
                x += 2.0 * radius;
            }
            13 => {
                (x, y) = (random.random_range(-20.0..20.0), random.random_range(-20.0..20.0));
                writeln!(out, "G0 Z5.\nX{x:.3} Y{y:.3}\nG1 Z0. F300.\nF{feed:.1}").unwrap();
            }
            14 => out.push_str("G4 P0.3\n"),
            15 => out.push_str("M8\n(COMMENT G1 X5.)\nM9\n"),
            16 => out.push_str("G91\nG1 X0.5 Y-0.5\nX-0.5 Y0.5\nG90\n"),
            17 => {
                writeln!(out, "G0 Z5.\nG81 X0. Y0. Z-2. R2. F100.\nX5.\nG80\nG1 Z0. F{feed:.1}").unwrap();
                (x, y) = (5.0, 0.0);
            }
            18 => {
                writeln!(out, "G61\nG1 X{:.3}\nX{x:.3}\nG64", x - 0.6).unwrap();
            }
            _ => feed = [600.0, 1500.0, 3000.0][random.random_range(0..3)],
        }
    }
    out.push_str("G0 Z5.\nM30\n");
    out
}

/// A run of a part: the block and the contour error (µm) of every sample of a feed move.
fn run(part: Part, machine: &mut SimulatedMachine) -> Vec<(usize, f64)> {
    let input = Input::from(part);
    let part = input.program().unwrap();
    let actual = machine.run(input.command()).unwrap();
    let costs_mm = SampleErrors::of(input.desired(), &actual).unwrap().costs_mm();
    let counted = (0..costs_mm.len()).filter(|k| counts(Some(part), *k));
    counted.filter_map(|k| Some((part.toolpath.moves[part.move_at(k)?].block as usize, 1e3 * costs_mm[k]))).collect()
}

/// RMS and MAX (µm) of the samples within `blocks`, and their number.
fn figures(run: &[(usize, f64)], blocks: &Range<usize>) -> ((f64, f64), usize) {
    let errors: Vec<f64> = run.iter().filter(|(block, _)| blocks.contains(block)).map(|(_, error)| *error).collect();
    (rms_max(&errors), errors.len())
}

#[test]
fn windows_cut_at_random_run_as_the_whole_does() {
    let settings = ReadSettings { at_zero: true, ..ReadSettings::default() };
    let options = SimulationOptions { quantised: false, ..SimulationOptions::noise_free() };
    for seed in 0..PROGRAMS {
        let mut random = ChaCha8Rng::seed_from_u64(1000 + seed);
        // Every other machine has a structure that is drawn.
        let spec = if seed % 2 == 0 { MachineSpec::builtin("ballscrew").unwrap() } else { MachineSpec::random(seed).unwrap() };
        let setup = Setup::new(&spec, None).unwrap();
        let mut machine = SimulatedMachine::new(&spec, 1).unwrap().with_options(options).unwrap();
        let text = Arc::new(gcode::parse(program(seed).into_bytes()));
        let of_whole = run(Part::read("part.nc", text.bytes(), &setup, &settings).unwrap(), &mut machine);
        let whole = Arc::new(Whole::new("part.nc", Arc::clone(&text), &setup, &settings).unwrap());
        let mut cuts = scan(&whole, &setup).unwrap().unwrap();
        let mut places: Vec<usize> = (1..WINDOWS).map(|_| random.random_range(1..cuts.places())).chain([0]).collect();
        places.sort_unstable();
        places.dedup();
        cuts.begin_at(places);
        let placement = whole.placement(cuts.systems(), &setup, &settings);
        for section in cuts.sections(&whole, &placement, &setup) {
            let core = section.core.clone();
            let (window, samples) = figures(&run(section.part(&placement, &setup).unwrap(), &mut machine), &core);
            let (whole, of) = figures(&of_whole, &core);
            println!("seed {seed}, blocks {core:?}: {window:.4?} in {samples} samples; in the whole {whole:.4?} in {of}");
            let is_near = |a: f64, b: f64, share: f64| (a - b).abs() <= FLOOR_UM + share * b;
            assert!(is_near(window.0, whole.0, RMS) && is_near(window.1, whole.1, MAX), "seed {seed}, blocks {core:?}");
            assert!(samples.abs_diff(of) as f64 <= TIME * of as f64 + ENDS, "seed {seed}, blocks {core:?}");
        }
    }
}

#[test]
fn every_window_has_a_feed_move() {
    let rapids = "G0 X0.\nG0 X50.\n".repeat(200);
    let text = format!("G21 G90 G17\nG0 X0. Y0. Z5.\nG1 Z0. F60.\nG1 X20.\n{rapids}G1 X0. F60.\n{rapids}M30\n");
    let setup = Setup::new(&MachineSpec::builtin("ballscrew").unwrap(), None).unwrap();
    let settings = ReadSettings { at_zero: true, ..ReadSettings::default() };
    let program = Arc::new(gcode::parse(text.into_bytes()));
    let whole = Arc::new(Whole::new("part.nc", program, &setup, &settings).unwrap());
    let cuts = scan(&whole, &setup).unwrap().unwrap();
    let placement = whole.placement(cuts.systems(), &setup, &settings);
    assert!(cuts.windows() > 1 && cuts.seconds() > 200.0, "{} windows, {} s", cuts.windows(), cuts.seconds());
    for section in cuts.sections(&whole, &placement, &setup) {
        let core = section.core.clone();
        let part = section.part(&placement, &setup).unwrap();
        assert!(
            part.toolpath.moves.iter().any(|step| step.is_feed() && core.contains(&(step.block as usize))),
            "blocks {core:?}"
        );
    }
}
