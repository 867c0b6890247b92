//! A toy axis with lag and backlash.

#![allow(dead_code)] // Each test file uses its own part.

use models::FeatureSet;
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use training::network::{NetworkKind, NetworkRecipe};
use training::staged::AxisRun;

pub const PERIOD_S: f64 = 0.004;

/// A run of random motion between standstills: lag of 8 ms and backlash of ±0.03 mm.
pub fn toy_run(seed: u64, samples: usize) -> AxisRun {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let waves: Vec<(f64, f64)> =
        (0..5).map(|i| (rng.random_range(0.3..1.0), 2.0 + 1.5 * f64::from(i) + rng.random_range(0.0..1.0))).collect();
    let last = (samples - 1) as f64 * PERIOD_S;
    let reference: Vec<f64> = (0..samples)
        .map(|k| {
            let t = k as f64 * PERIOD_S;
            let ease = (t / 0.3).min((last - t) / 0.3).clamp(0.0, 1.0);
            let ease = ease * ease * (3.0 - 2.0 * ease);
            ease * waves.iter().map(|(size, rate)| size * (rate * t).sin()).sum::<f64>()
        })
        .collect();
    let mut held = reference[0];
    let mut lagging = reference[0];
    let actual = reference
        .iter()
        .map(|x| {
            lagging += (x - lagging) * (1.0 - (-PERIOD_S / 0.008_f64).exp());
            held = held.clamp(lagging - 0.03, lagging + 0.03);
            held
        })
        .collect();
    AxisRun::new(reference, actual, PERIOD_S)
}

pub fn toy_runs(first_seed: u64, count: u64) -> Vec<AxisRun> {
    (0..count).map(|i| toy_run(first_seed + i, 700)).collect()
}

/// A network small enough for tests.
pub fn tiny(kind: NetworkKind) -> NetworkRecipe {
    NetworkRecipe {
        features: FeatureSet::Iii,
        hidden: 12,
        layers: 1,
        dropout: 0.0,
        drop_every: 20,
        drop_factor: 0.4,
        batch: 8,
        epochs: 40,
        validate_every: 4,
        patience: 6,
        ..NetworkRecipe::quick(kind)
    }
}

/// Root mean square error on `held_out` of the best linear law on `v(k−25…k+25)`, fitted to `runs`.
pub fn linear_rms(runs: &[AxisRun], held_out: &[AxisRun]) -> f64 {
    let rows = |run: &AxisRun| {
        let at = |k: isize| run.reference[k.clamp(0, run.reference.len() as isize - 1) as usize];
        DMatrix::from_fn(run.reference.len(), 52, |k, j| {
            if j == 51 {
                return 1.0;
            }
            let k = k as isize + j as isize - 25;
            at(k) - at(k - 1)
        })
    };
    let errors =
        |run: &AxisRun| DVector::from_iterator(run.reference.len(), run.reference.iter().zip(&run.actual).map(|(r, x)| r - x));
    let mut gram = DMatrix::identity(52, 52) * 1e-9;
    let mut right = DVector::zeros(52);
    for run in runs {
        let rows = rows(run);
        gram += rows.tr_mul(&rows);
        right += rows.tr_mul(&errors(run));
    }
    let law = gram.cholesky().expect("a ridge makes it definite").solve(&right);
    let (squares, count) = held_out.iter().fold((0.0, 0), |(squares, count), run| {
        let left = errors(run) - rows(run) * &law;
        (squares + left.norm_squared(), count + left.len())
    });
    (squares / count as f64).sqrt()
}
