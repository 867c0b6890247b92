//! The forecast in pieces is that of the whole.

use datasets::{ReadOptions, write_log};
use machine::{Machine, MachineSpec, SimulatedMachine};
use motion::{Axis, Trajectory};

use super::*;
use crate::measure::{self, LongLog};
use crate::position_terms::machine_for;
use crate::progress::SILENT;
use crate::statistics::rms_max;
use crate::training::{TrainSettings, train, train_on_stretches};
use datasets::{Log, Recording};

const ROWS: usize = 45_000;

/// A minute and a half of motion at 500 Hz, with a standstill of four seconds.
fn reference() -> Trajectory {
    let mut travelled = 0.0;
    let motion: Vec<f64> = (0..ROWS)
        .map(|k| {
            let to_standstill = if k < 21_000 { 20_000_i32 - k as i32 } else { k as i32 - 22_000 };
            let ramp = (f64::from(to_standstill).min(k as f64) / 1000.0).clamp(0.0, 1.0);
            travelled += 0.002 * ramp * ramp * (3.0 - 2.0 * ramp);
            travelled
        })
        .collect();
    let column = |size: f64, speed: f64| motion.iter().map(|s| size * (speed * s).sin()).collect::<Vec<f64>>();
    let columns = vec![column(30.0, 1.3), column(20.0, 2.1), column(5.0, 0.7)];
    Trajectory::new(0.002, Axis::xyz(), columns).unwrap()
}

fn simulated() -> Log {
    let mut machine = SimulatedMachine::new(&MachineSpec::builtin("ballscrew").unwrap(), 1).unwrap();
    let reference = reference();
    let actual = machine.run(&reference).unwrap();
    Log::new("run", reference, actual).unwrap()
}

fn near(a: f64, b: f64, share: f64) -> bool {
    (a - b).abs() <= share * b.abs() + 1e-9
}

/// A model, the log of the simulated machine in a file, and the log itself.
fn prepared() -> (Bundle, LongFile, Log, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.csv");
    write_log(&path, &simulated()).unwrap();
    // As it is in the file.
    let (log, _) = datasets::read_log(&path, &ReadOptions::default()).unwrap();
    let settings = TrainSettings::of(training::Recipe::builtin("linear").unwrap(), 1);
    let spec = MachineSpec::builtin("ballscrew").unwrap();
    let short = log.part("run", 0, 12_000).unwrap();
    let model = train(&[short], Some(&spec), &settings, SILENT).unwrap().bundle;
    let file = LongFile::log(&path, &ReadOptions::default(), 10_000).unwrap().unwrap();
    (model, file, log, folder)
}

#[test]
fn beyond_the_operating_range_upper_bounds_grow_and_lower_ones_do_not() {
    let (mut model, _, log, _folder) = prepared();
    let setup = Setup::of_model(&model).unwrap();
    let input = Input::reference("run", log.reference.clone(), Some(&setup)).unwrap();
    let forecast = machine_for(&model, None).unwrap().run(&log.reference).unwrap();
    let expected = |model: &Bundle| Expectation::of(model, &input, &log.reference, &forecast).unwrap().unwrap().tip;
    for axis in &mut model.manifest.axes {
        (axis.coverage.velocity, axis.coverage.acceleration) = (1e6, 1e9);
    }
    let within = expected(&model);
    for axis in &mut model.manifest.axes {
        (axis.coverage.velocity, axis.coverage.acceleration) = (1e-3, 1e-3);
    }
    let beyond = expected(&model);
    assert!(near(beyond.rms.low, within.rms.low, 1e-9) && near(beyond.max.low, within.max.low, 1e-9), "{beyond:?} {within:?}");
    assert!(beyond.rms.middle > 2.0 * within.rms.middle && beyond.rms.high > 2.0 * within.rms.high, "{beyond:?} {within:?}");
    assert!(beyond.max.high > 2.0 * within.max.high, "{beyond:?} {within:?}");
}

#[test]
fn a_forecast_in_pieces_is_that_of_the_whole() {
    let (model, _, log, folder) = prepared();
    let file = LongFile::reference(&folder.path().join("run.csv"), &ReadOptions::default(), 10_000).unwrap().unwrap();
    let setup = Setup::of_model(&model).unwrap();
    let input = Input::reference("run", log.reference.clone(), Some(&setup)).unwrap();
    let whole = machine_for(&model, None).unwrap().run(&log.reference).unwrap();
    let figures = input.figures(&whole).unwrap().tip;
    let expected = Expectation::of(&model, &input, &log.reference, &whole).unwrap();
    for piece_s in [7.0, 20.0] {
        let mut columns = vec![Vec::new(); 3];
        let mut write = |[_, actual]: Columns<'_>| {
            columns.iter_mut().zip(actual).for_each(|(all, piece)| all.extend_from_slice(piece));
            Ok(())
        };
        let found = forecast(&model, &setup, &file, Some(piece_s), &mut write, SILENT).unwrap().unwrap();
        let largest = |(found, whole): (&Vec<f64>, &Vec<f64>)| {
            found.iter().zip(whole).map(|(found, whole)| (found - whole).abs()).fold(0.0, f64::max)
        };
        let off_mm = columns.iter().zip(whole.columns()).map(largest).fold(0.0, f64::max);
        println!("{piece_s} s: {off_mm:.2e} mm, {:?} {figures:?}", found.contour);
        assert!(off_mm < 1e-5 && columns[0].len() == ROWS, "{off_mm}");
        assert!(near(found.contour.rms_mm, figures.rms_mm, 1e-3) && near(found.contour.max_mm, figures.max_mm, 1e-3));
        assert!(near(found.contour.p95_mm, figures.p95_mm, 5e-3) && found.contour.max_at == figures.max_at);
        let tracking: Vec<(f64, f64)> =
            log.reference.tracking_error(&whole).unwrap().iter().map(|error| rms_max(error)).collect();
        assert!(found.tracking.iter().zip(&tracking).all(|(a, b)| near(a.0, b.0, 1e-4) && near(a.1, b.1, 1e-4)));
        let (found, expected) = (found.expected.unwrap().tip, expected.unwrap().tip);
        assert!(near(found.rms.middle, expected.rms.middle, 1e-3) && near(found.max.high, expected.max.high, 1e-2));
    }
}

#[test]
fn a_log_measured_in_pieces_has_the_figures_of_the_whole() {
    let (model, file, log, _folder) = prepared();
    let input = Input::reference("command", log.reference.clone(), None).unwrap();
    let whole = measure::measure(&log, &input, &mut motion::contour::Exact::default()).unwrap();
    let fits = measure::fits(&model, &log).unwrap();
    for piece_s in [6.0, 25.0] {
        let (long, _) = LongLog::new(&file, None, Some(piece_s)).unwrap().unwrap();
        let (found, fitted) = long.measure(Some(&model)).unwrap();
        assert_eq!((&found.axes, &found.tracking), (&whole.axes, &whole.tracking));
        assert_eq!((found.worst, found.contour.max_at), (whole.worst.clone(), whole.contour.max_at));
        assert!(near(found.contour.rms_mm, whole.contour.rms_mm, 1e-12) && found.contour.max_mm == whole.contour.max_mm);
        assert!(near(found.contour.p95_mm, whole.contour.p95_mm, 5e-3));
        assert_eq!((&found.reversals, found.reversals_found), (&whole.reversals, whole.reversals_found));
        assert_eq!((&found.segments, found.segments_found), (&whole.segments, whole.segments_found));
        for (found, whole) in found.lags_s.iter().zip(&whole.lags_s) {
            assert!((found.unwrap() - whole.unwrap()).abs() < 2e-6, "{found:?} {whole:?}");
        }
        for (found, whole) in fitted.unwrap().iter().zip(&fits) {
            assert!(near(found.rms, whole.rms, 1e-3) && near(found.in_band, whole.in_band, 1e-3), "{found:?} {whole:?}");
            assert!(near(found.outside, whole.outside, 1e-9), "{found:?} {whole:?}");
        }
    }
}

#[test]
fn training_on_a_file_takes_the_stretches_of_the_whole() {
    let (_, file, log, _folder) = prepared();
    let settings = TrainSettings { most_samples: 15_000, ..TrainSettings::of(training::Recipe::builtin("linear").unwrap(), 1) };
    let whole = train(&[log], None, &settings, SILENT).unwrap();
    let found = train_on_stretches(&[Recording::File(file)], None, &settings, SILENT).unwrap();
    assert_eq!(found.stretches, whole.stretches);
    assert_eq!(found.bundle.to_bytes().unwrap(), whole.bundle.to_bytes().unwrap());
}
