//! The exact estimators against closed forms and brute force.

mod contour_common;

use std::sync::Arc;

use contour_common::*;
use motion::contour::{ContourError, ContourEstimator, ContourQuery, Exact, ExactOnCurve, SampledSpline, TimeMatch};
use motion::curves::library;
use motion::{Curve, Vec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Accuracy of "exact", mm.
const EXACT_MM: f64 = 1e-9;

/// Actual → desired on the curve of a run with three different lags.
fn run(curve: &Arc<dyn Curve>, feed: f64) -> (Vec<f64>, Vec<Vec3>, Vec<Vec3>, Vec<ContourError>) {
    let (parameters, desired) = travel(curve.as_ref(), feed, 800.0, PERIOD_S);
    let actual = lagged(&desired, [0.0090, 0.0094, 0.0087], PERIOD_S, 1);
    let mut estimator = ExactOnCurve::new(curve.clone()).with_parameters(parameters.clone()).unwrap();
    let errors = estimator.estimate(&actual, &desired).unwrap();
    (parameters, desired, actual, errors)
}

/// Largest difference from brute force over the part of the curve between three lags ago and
/// shortly after now.
fn worst_against_brute_force(name: &str, curve: Arc<dyn Curve>, feed: f64, every: usize) -> f64 {
    let (parameters, _, actual, errors) = run(&curve, feed);
    let point_at = |u: f64| curve.point(u);
    let mut worst = 0.0_f64;
    for k in (0..actual.len()).step_by(every) {
        let low = parameters[k.saturating_sub(15)];
        let high = parameters[(k + 3).min(parameters.len() - 1)];
        let (distance, _) = brute_force(&point_at, low, high, 400, &actual[k]);
        worst = worst.max((errors[k].magnitude_mm - distance).abs());
        assert!((errors[k].vector - (actual[k] - errors[k].foot)).norm() == 0.0);
    }
    println!(
        "{name}: {} samples, largest contour error {:.3} µm, exact − brute force {worst:.1e} mm",
        actual.len(),
        1e3 * largest(errors.iter().map(|e| e.magnitude_mm))
    );
    worst
}

#[test]
fn on_a_circle_the_error_is_the_radial_deviation() {
    let curve: Arc<dyn Curve> = Arc::new(circle(20.0));
    let (_, _, actual, errors) = run(&curve, 80.0);
    for (p, error) in actual.iter().zip(&errors) {
        let outside = p.norm() - 20.0;
        assert!((error.magnitude_mm - outside.abs()).abs() < EXACT_MM);
        assert!((error.vector.norm() - error.magnitude_mm).abs() < 1e-12);
        // Counterclockwise: inside is left.
        assert!(outside.abs() < 1e-6 || (error.left_mm() + outside).abs() < EXACT_MM);
    }
}

#[test]
fn on_a_helix_the_error_of_an_offset_is_its_length() {
    let curve: Arc<dyn Curve> = Arc::new(helix(10.0, 4.0, 3.0));
    let (parameters, desired) = travel(curve.as_ref(), 80.0, 800.0, PERIOD_S);
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut estimator = ExactOnCurve::new(curve.clone()).with_parameters(parameters.clone()).unwrap();
    // Offsets within the normal plane of an earlier point, up to 2 mm: below the radius of
    // curvature and half the pitch.
    let mut offsets = Vec::new();
    let actual: Vec<Vec3> = (0..desired.len())
        .map(|k| {
            let [point, slope, ..] = curve.derivatives(parameters[k.saturating_sub(5)]);
            let normal = slope.cross(&Vec3::from_fn(|_, _| rng.random_range(-1.0..1.0))).normalize();
            offsets.push(rng.random_range(0.0..1.9));
            point + normal * offsets[k]
        })
        .collect();
    let errors = estimator.estimate(&actual, &desired).unwrap();
    for (error, offset) in errors.iter().zip(&offsets) {
        assert!((error.magnitude_mm - offset).abs() < EXACT_MM, "{} against {offset}", error.magnitude_mm);
    }
}

#[test]
fn exact_on_curves_that_turn_cross_and_wind() {
    for (name, curve) in [
        ("helix", Arc::new(helix(10.0, 4.0, 3.0)) as Arc<dyn Curve>),
        ("wave", Arc::new(wave(60.0, 5.0, 4.0))),
        ("figure eight", Arc::new(eight(30.0))),
        ("spiral", Arc::new(spiral())),
        ("flower 30/25/6", Arc::new(flower(30.0, 25.0, 6.0))),
        ("flower 25/15/5", Arc::new(flower(25.0, 15.0, 5.0))),
    ] {
        assert!(worst_against_brute_force(name, curve, 80.0, 3) < EXACT_MM, "{name}");
    }
}

#[test]
fn exact_in_the_butterflys_corners() {
    let curve: Arc<dyn Curve> = Arc::new(library::butterfly().unwrap());
    assert!(worst_against_brute_force("butterfly", curve, 25.0, 11) < EXACT_MM);
}

#[test]
fn projected_parameters_give_the_same_errors_as_given_ones() {
    for curve in
        [Arc::new(eight(30.0)) as Arc<dyn Curve>, Arc::new(hairpins(2.0, 0.01, 4)), Arc::new(library::butterfly().unwrap())]
    {
        let (_, desired, actual, given) = run(&curve, 40.0);
        let found = ExactOnCurve::new(curve).estimate(&actual, &desired).unwrap();
        let worst = largest(found.iter().zip(&given).map(|(a, b)| (a.magnitude_mm - b.magnitude_mm).abs()));
        assert!(worst < EXACT_MM, "{worst:e}");
    }
}

#[test]
fn never_on_a_hairpins_other_leg() {
    const GAP_MM: f64 = 0.01;
    let curve: Arc<dyn Curve> = Arc::new(hairpins(3.0, GAP_MM, 6));
    let (parameters, desired) = travel(curve.as_ref(), 80.0, 800.0, PERIOD_S);
    let plain = lagged(&desired, [0.009, 0.0093, 0.009], PERIOD_S, 1);
    // 7 µm off the path the neighbouring leg is nearer than the true one.
    for shift_mm in [0.0, 0.004, -0.004, 0.007, -0.007] {
        let actual: Vec<Vec3> = plain.iter().map(|p| p + Vec3::new(0.0, shift_mm, 0.0)).collect();
        let mut on_curve = ExactOnCurve::new(curve.clone()).with_parameters(parameters.clone()).unwrap();
        let runs = [
            (Exact::default().estimate(&desired, &actual).unwrap(), &desired, 1.0),
            (Exact::default().estimate(&actual, &desired).unwrap(), &actual, -1.0),
            (on_curve.estimate(&actual, &desired).unwrap(), &actual, -1.0),
        ];
        let mut checked = 0;
        for (errors, from, sign) in &runs {
            for (error, sample) in errors.iter().zip(*from) {
                // Near the tips the legs meet and either is correct. Beyond, the lag across the
                // legs is still decaying, but is far below the 10 µm between two legs.
                if sample.x < 0.2 || sample.x > 2.8 {
                    continue;
                }
                checked += 1;
                let across = error.vector.y + sign * shift_mm;
                assert!(across.abs() < 2e-3, "at {sample:?}: {across} mm, shift {shift_mm}, direction {sign}, {error:?}");
            }
        }
        assert!(checked > 500);
    }
}

/// A smooth random path: sums of sines, sometimes with a standstill or a sharp turn.
fn random_path(rng: &mut ChaCha8Rng, count: usize) -> Vec<Vec3> {
    let waves: Vec<(Vec3, f64, f64)> = (0..4)
        .map(|_| {
            let size = Vec3::from_fn(|_, _| rng.random_range(-1.0..1.0)) * rng.random_range(0.1..6.0);
            (size, rng.random_range(0.02..0.6), rng.random_range(0.0..6.3))
        })
        .collect();
    let rest = rng.random_range(0..3 * count);
    let mirror = rng.random_range(0..3 * count);
    let noise = if rng.random_bool(0.3) { 1e-4 } else { 0.0 };
    (0..count)
        .map(|k| {
            let k = if k > rest { rest.max(k.saturating_sub(6)) } else { k };
            let k = if k > mirror { 2 * mirror - k.min(2 * mirror) } else { k };
            let jitter = Vec3::from_fn(|_, _| rng.random_range(-1.0..1.0)) * noise;
            jitter + waves.iter().map(|(size, rate, phase)| size * (rate * k as f64 + phase).sin()).sum::<Vec3>()
        })
        .collect()
}

#[test]
fn nearest_on_a_spline_is_the_global_minimum() {
    let mut rng = ChaCha8Rng::seed_from_u64(20_261_121);
    let mut worst = 0.0_f64;
    for case in 0..4000 {
        let count = rng.random_range(2..40);
        let path = random_path(&mut rng, count);
        let spline = SampledSpline::new(&path).unwrap();
        let point_at = |x: f64| {
            let segment = (x as usize).min(spline.segments() - 1);
            spline.point(segment, x - segment as f64)
        };
        let low = rng.random_range(0..spline.segments());
        let high = (low + rng.random_range(1..15)).min(spline.segments());
        let reach = [0.02, 0.2, 2.0][case % 3];
        let off = Vec3::from_fn(|_, _| rng.random_range(-1.0..1.0)) * reach;
        let p = point_at(rng.random_range(low as f64..high as f64)) + off;
        let found = spline.nearest(low..high, &p);
        let (distance, _) = brute_force(&point_at, low as f64, high as f64, 64 * (high - low), &p);
        let miss = found.magnitude_mm - distance;
        worst = worst.max(miss);
        // Brute force may stop in a local minimum. It is never below the truth.
        assert!(miss < EXACT_MM, "case {case}: {miss:e} of {distance}");
        assert!(((found.foot - p).norm() - found.magnitude_mm).abs() < EXACT_MM);
    }
    println!("4000 random windows: exact − brute force at most {worst:.1e} mm");
}

#[test]
fn random_curves_with_lags_up_to_two_millimetres() {
    let mut cases = 0;
    let mut differ = 0;
    let mut largest_tracking = 0.0_f64;
    for seed in 0..12 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let curve = library::random_nurbs(12, 18.0, 3, seed).unwrap();
        let (_, desired) = travel(&curve, 80.0, 800.0, PERIOD_S);
        let lag = rng.random_range(0.004..0.025);
        let lags = [0, 1, 2].map(|_| lag * rng.random_range(0.9..1.1));
        let actual = lagged(&desired, lags, PERIOD_S, 1);
        let spline = SampledSpline::new(&actual).unwrap();
        let errors = Exact::default().estimate(&desired, &actual).unwrap();
        let behind = (4.0 * lag / PERIOD_S) as usize + 2;
        for (k, (sample, error)) in desired.iter().zip(&errors).enumerate() {
            cases += 1;
            let tracking = (sample - actual[k]).norm();
            largest_tracking = largest_tracking.max(tracking);
            assert!(error.magnitude_mm <= tracking + EXACT_MM, "contour error above tracking error at {k}");
            // The part of the curve from now until four lags later.
            let wide = spline.nearest(k.saturating_sub(2)..(k + behind).min(spline.segments()), sample);
            if (wide.magnitude_mm - error.magnitude_mm).abs() > EXACT_MM {
                differ += 1;
                println!(
                    "curve {seed} sample {k}: {:.6} mm on segment {}, {:.6} on {}",
                    error.magnitude_mm, error.location.segment, wide.magnitude_mm, wide.location.segment
                );
            }
        }
    }
    println!("{cases} samples, tracking errors up to {largest_tracking:.2} mm, {differ} differ from a search four lags wide");
    assert!(largest_tracking > 1.5);
    assert!(differ * 1000 <= cases);
}

#[test]
fn the_spline_through_500_hz_samples_is_close_to_the_curve() {
    for (name, curve, bound_um) in [
        ("circle 20", Arc::new(circle(20.0)) as Arc<dyn Curve>, 1e-3),
        ("spiral", Arc::new(spiral()), 1e-3),
        ("flower 30/25/6", Arc::new(flower(30.0, 25.0, 6.0)), 2e-1),
        ("butterfly", Arc::new(library::butterfly().unwrap()), 5e-1),
    ] {
        for (hz, times) in [(500.0, 1), (250.0, 2), (125.0, 4)] {
            let (_, fine) = travel(curve.as_ref(), 80.0, 800.0, PERIOD_S / 10.0);
            let samples: Vec<Vec3> = fine.iter().copied().step_by(10 * times).collect();
            let matching = TimeMatch { first: 0.0, rate: 0.1 / times as f64 };
            let mut errors = Vec::new();
            Exact::default().estimate_into(ContourQuery::new(&fine, &samples, matching), &mut errors).unwrap();
            let worst_um = 1e3 * largest(errors.iter().filter(|e| !e.at_end).map(|e| e.magnitude_mm));
            println!("{name} at {hz} Hz: spline within {worst_um:.2e} µm of the curve");
            assert!(times > 1 || worst_um < bound_um);
        }
    }
}
