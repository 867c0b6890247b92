//! Time of every contour-error estimator on the same pair of three-dimensional paths, in samples
//! per second.

use std::f64::consts::TAU;
use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use motion::Vec3;
use motion::contour::{ContourEstimator, ContourQuery};
use motion::contour::{Exact, ExactStream, TimeMatch, Window, sample_estimators};

const SAMPLES: usize = 30_000;
const PERIOD_S: f64 = 0.002;

/// A flower on a wave at up to 80 mm/s, and the response of axes with a lag of 9 ms.
fn paths() -> (Vec<Vec3>, Vec<Vec3>) {
    let laps = 12.0;
    let desired: Vec<Vec3> = (0..SAMPLES)
        .map(|k| {
            let u = TAU * laps * k as f64 / SAMPLES as f64;
            let r = 45.0 + 6.0 * (6.0 * u).cos();
            Vec3::new(r * u.cos(), r * u.sin(), 10.0 * (3.0 * u).sin())
        })
        .collect();
    let lags_s = [0.0090, 0.0092, 0.0088];
    let mut at = desired[0];
    let actual = desired
        .iter()
        .map(|reference| {
            at += Vec3::from_fn(|axis, _| (reference[axis] - at[axis]) * (1.0 - (-PERIOD_S / lags_s[axis]).exp()));
            at
        })
        .collect();
    (desired, actual)
}

fn estimators(criterion: &mut Criterion) {
    let (desired, actual) = paths();
    let mut group = criterion.benchmark_group("contour");
    group.throughput(Throughput::Elements(SAMPLES as u64));
    for mut estimator in sample_estimators() {
        let mut errors = Vec::with_capacity(SAMPLES);
        group.bench_function(estimator.name(), |bencher| {
            bencher.iter(|| {
                let done = estimator.estimate_into(ContourQuery::new(&desired, &actual, TimeMatch::SAME), &mut errors);
                black_box((done, errors.last().copied()))
            });
        });
    }
    group.bench_function("exact, actual to desired", |bencher| {
        let mut estimator = Exact::default();
        let mut errors = Vec::with_capacity(SAMPLES);
        bencher.iter(|| {
            let done = estimator.estimate_into(ContourQuery::new(&actual, &desired, TimeMatch::SAME), &mut errors);
            black_box((done, errors.last().copied()))
        });
    });
    group.bench_function("exact, streamed", |bencher| {
        let window = Window { max_samples: 64, ..Window::default() };
        let mut rest = Vec::new();
        bencher.iter(|| {
            let Ok(mut stream) = ExactStream::new(window) else { return };
            for (from, to) in desired.iter().zip(&actual) {
                black_box(stream.push(*from, *to).ok());
            }
            rest.clear();
            stream.finish(&mut rest);
            black_box(rest.len());
        });
    });
    group.finish();
}

criterion_group!(benches, estimators);
criterion_main!(benches);
