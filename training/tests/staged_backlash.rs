//! Backlash between the motor and the measured table, on a drive with known parameters.

use models::AxisPredictor;
use models::staged::{MotionFactor, StagedPredictor};
use training::staged::{AxisRun, HarmonicRecipe, StagedRecipe, StagedReport, fit};

const PERIOD_S: f64 = 1e-3;

/// Table of a cascade (P position with feed-forward, PI velocity) with Coulomb friction at the
/// motor and backlash of `half_width` behind it. The table starts off the motor by `start`.
fn table(reference: &[f64], half_width: f64, start: f64) -> Vec<f64> {
    let (mut position, mut speed, mut integral) = (reference[0], 0.0, 0.0);
    let (mut command, mut wanted, mut table) = (position, 0.0, position + start);
    reference
        .iter()
        .map(|&r| {
            integral += (wanted - speed) * PERIOD_S;
            let force = 250.0 * (wanted - speed) + 8000.0 * integral;
            wanted = 100.0 * (command - position) + 0.88 * (r - command) / PERIOD_S;
            command = r;
            speed += (force - (400.0_f64 * speed).clamp(-60.0, 60.0)) * PERIOD_S;
            position += speed * PERIOD_S;
            table = f64::clamp(table, position - half_width, position + half_width);
            table
        })
        .collect()
}

/// Moves of various lengths and speeds back and forth, some of them with a dwell between. Before
/// most of them the table lies on one side of the backlash, before a few on the other.
fn run(seed: u32, half_width: f64) -> AxisRun {
    let mut state = seed;
    let mut random = move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 8) / f64::from(1 << 24)
    };
    let mut reference = vec![0.0; 200];
    let mut x = 0.0;
    for _ in 0..14 {
        let target = 40.0 * random() - 20.0;
        let length: f64 = target - x;
        let samples = (1.9 * length.abs() / (5.0 + 75.0 * random().powi(2)) / PERIOD_S).max(60.0) as usize;
        reference.extend((1..=samples).map(|k| {
            let t = k as f64 / samples as f64;
            x + length * t.powi(3) * (10.0 - 15.0 * t + 6.0 * t * t)
        }));
        x = target;
        let rest = if random() < 0.5 { (300.0 * random()) as usize } else { 0 };
        reference.extend(std::iter::repeat_n(x, rest));
    }
    reference.extend(std::iter::repeat_n(x, 300));
    let start = if seed.is_multiple_of(4) { -half_width } else { half_width };
    let actual = table(&reference, half_width, start);
    AxisRun::new(reference, actual, PERIOD_S)
}

fn fitted(half_width: f64) -> (StagedPredictor, StagedReport) {
    let runs: Vec<AxisRun> = (1..7).map(|seed| run(seed, half_width)).collect();
    // One memory and no search for harmonics, which the drive does not have; defaults otherwise.
    let recipe = StagedRecipe { memory_s: vec![0.05], ..StagedRecipe::default() };
    let harmonics = HarmonicRecipe { rounds: 0, ..recipe.harmonics.clone() };
    fit(&runs, &StagedRecipe { harmonics, ..recipe }).unwrap()
}

/// RMS of the residual on an unseen run, µm: of all samples, and of the standstills.
fn left(predictor: &StagedPredictor, half_width: f64) -> [f64; 2] {
    let run = run(77, half_width);
    let predicted = predictor.predict(&models::AxisSignal::uncompensated(&run.reference, PERIOD_S));
    let standstill = |k: usize| run.reference[k - 20..k].iter().all(|x| *x == run.reference[k]);
    let rms = |rows: &dyn Fn(usize) -> bool| {
        let squares: Vec<f64> = (400..run.reference.len())
            .filter(|k| rows(*k))
            .map(|k| (1e3 * (run.reference[k] - run.actual[k] - predicted[k])).powi(2))
            .collect();
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    };
    [rms(&|_| true), rms(&standstill)]
}

/// Half-width of the backlash in the last pass, µm.
fn backlash_of(predictor: &StagedPredictor) -> Option<f64> {
    let features = &predictor.passes().last()?.features;
    let mut regressors = features.groups.iter().flat_map(|group| &group.channels);
    regressors.find_map(|regressor| match regressor.motion {
        MotionFactor::Backlash(stop) => Some(1e3 * features.scales.stop_half_widths[stop]),
        _ => None,
    })
}

#[test]
fn the_half_width_and_the_standstill_position_of_the_table_are_found() {
    for half_width in [2e-3, 8e-3] {
        let (predictor, report) = fitted(half_width);
        let [all, standstill] = left(&predictor, half_width);
        println!(
            "{}: half-width {:?} of {} µm, left {all:.3} µm, at standstill {standstill:.3} µm",
            report.chosen,
            backlash_of(&predictor),
            1e3 * half_width
        );
        assert!(backlash_of(&predictor).is_some_and(|found| (found / (1e3 * half_width) - 1.0).abs() < 0.01));
        assert!(all < 0.1 && standstill < 0.15);
    }
}

#[test]
fn without_backlash_none_is_found() {
    let (predictor, report) = fitted(0.0);
    let [all, standstill] = left(&predictor, 0.0);
    println!("{}: {:?}, left {all:.3} µm, at standstill {standstill:.3} µm", report.chosen, backlash_of(&predictor));
    assert!(backlash_of(&predictor).is_none_or(|found| found < 0.3));
    assert!(all < 0.1 && standstill < 0.1);
}
