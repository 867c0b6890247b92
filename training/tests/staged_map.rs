//! Position-dependent friction: the gain of a map along the axis, and its levels.

mod staged_common;

use staged_common::{residual, rms};
use training::staged::{AxisRun, MapRecipe, StagedRecipe, fit};

const PERIOD_S: f64 = 0.002;

/// Friction level at a position: a worn segment of 8 mm around 12 mm, 1.5 times as high.
fn level(x: f64) -> f64 {
    1.0 + 0.5 * (-((x - 12.0) / 4.0).powi(2)).exp()
}

/// There and back over ±30 mm by three sine waves, from a standstill. The tracking error is the lag
/// plus friction through a slow loop.
fn run(number: usize, samples: usize) -> AxisRun {
    let phase = 0.7 * number as f64;
    let path = |k: usize| {
        let t = k as f64 * PERIOD_S;
        let x = |t: f64| 18.0 * (0.9 * t + phase).sin() + 8.0 * (2.3 * t + 2.0 * phase).sin() + 3.0 * (4.1 * t + phase).sin();
        (x(t) - x(0.0)) * (1.0 - (-t * t).exp()) + x(0.0)
    };
    let reference: Vec<f64> = (0..samples).map(path).collect();
    let (mut friction, mut felt, mut before) = (0.0_f64, 0.0, reference[0]);
    let late = |k: usize| {
        let moved = reference[k] - before;
        before = reference[k];
        friction = (friction + moved / 0.01).clamp(-level(reference[k]), level(reference[k]));
        felt += 0.1 * (friction - felt);
        // A little noise, so that no fit is exact.
        0.002 * moved / PERIOD_S + 0.005 * felt + 1e-5 * ((k * 7919 + number) % 101) as f64 / 101.0
    };
    let errors: Vec<f64> = (0..samples).map(late).collect();
    let actual = reference.iter().zip(errors).map(|(r, e)| r - e).collect();
    AxisRun::new(reference, actual, PERIOD_S)
}

#[test]
fn a_tight_position_is_found_and_predicted() {
    let runs: Vec<AxisRun> = (0..8).map(|number| run(number, 4000)).collect();
    let flat = StagedRecipe { map: MapRecipe { rounds: 0, ..MapRecipe::default() }, ..StagedRecipe::default() };
    let (without, _) = fit(&runs, &flat).unwrap();
    let (with, report) = fit(&runs, &StagedRecipe::default()).unwrap();
    let unseen = run(11, 4000);
    let [without, with_rms] = [&without, &with].map(|predictor| 1e3 * rms(residual(predictor, &unseen)));
    println!("{}: {with_rms:.4} µm with a map, {without:.4} µm without", report.chosen);
    assert_eq!(report.chosen, "friction-map");
    assert!(with_rms < 0.7 * without);
    let scales = &with.passes().last().unwrap().features.scales;
    let at = |x: f64| scales.friction_map.as_ref().unwrap().at(x - scales.centre)[0];
    let tight = at(12.0) / (0.5 * (at(-15.0) + at(0.0)));
    assert!(tight > 1.2 && tight < 1.6, "{tight}");
}
