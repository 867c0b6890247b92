//! Standstill, seams, ends, spikes, retraced lines, streams and invalid input.

mod contour_common;

use contour_common::*;
use motion::Vec3;
use motion::contour::{
    ContourEstimator, ContourQuery, Exact, ExactStream, HermiteFootPoint, Horizon, OsculatingCircle, SampledSpline, SplineSearch,
    Tangent, TimeMatch, Window, sample_estimators,
};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A flower with standstill before, after and within the motion, and the response of lagging,
/// jittering axes.
fn path_with_standstill(jitter_mm: f64) -> (Vec<Vec3>, Vec<Vec3>) {
    let (_, moving) = travel(&flower(25.0, 15.0, 5.0), 60.0, 800.0, PERIOD_S);
    let mut desired = vec![moving[0]; 300];
    desired.extend_from_slice(&moving[..900]);
    desired.extend(vec![moving[900]; 700]);
    desired.extend(&moving[900..]);
    desired.extend(vec![*moving.last().unwrap(); 400]);
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let actual = lagged(&desired, [0.0090, 0.0093, 0.0088], PERIOD_S, 1)
        .into_iter()
        .map(|p| p + Vec3::from_fn(|_, _| rng.random_range(-1.0..1.0)) * jitter_mm)
        .collect();
    (desired, actual)
}

#[test]
fn a_stream_gives_what_the_whole_path_gives() {
    let window = Window { max_samples: 64, ..Window::default() };
    for jitter_mm in [0.0, 2e-4] {
        let (desired, actual) = path_with_standstill(jitter_mm);
        let whole = Exact::with_window(window).unwrap().estimate(&desired, &actual).unwrap();
        let mut stream = ExactStream::new(window).unwrap();
        for round in 0..2 {
            let mut streamed = Vec::new();
            let mut buffered = 0;
            for (from, to) in desired.iter().zip(&actual) {
                streamed.extend(stream.push(*from, *to).unwrap());
                buffered = buffered.max(stream.buffered());
            }
            stream.finish(&mut streamed);
            assert_eq!(streamed, whole, "round {round}");
            assert!(buffered < 8 * window.max_samples, "{buffered} pieces kept");
        }
        assert!(stream.push(Vec3::new(f64::NAN, 0.0, 0.0), Vec3::zeros()).is_err());
    }
}

#[test]
fn standstill_does_not_mislead_the_estimators() {
    for jitter_mm in [0.0, 2e-4] {
        let (desired, actual) = path_with_standstill(jitter_mm);
        let errors = Exact::default().estimate(&desired, &actual).unwrap();
        let spline = SampledSpline::new(&actual).unwrap();
        for (k, error) in errors.iter().enumerate() {
            // Sharp petals and a stop within a motion: the error is never above the best point
            // within a generous time window.
            let range = k.saturating_sub(3)..(k + 30).min(spline.segments());
            let wide = spline.nearest(range, &desired[k]);
            let best = wide.magnitude_mm;
            let slack = if jitter_mm > 0.0 { 2e-4 } else { 1e-9 };
            assert!(
                error.magnitude_mm <= best + slack,
                "sample {k}: {} at {:?} against {best} at {:?}",
                error.magnitude_mm,
                error.location,
                wide.location
            );
        }
    }
}

#[test]
fn a_closed_paths_seam_is_not_crossed() {
    let (_, desired) = travel(&circle(10.0), 60.0, 800.0, PERIOD_S);
    let actual = lagged(&desired, [0.009; 3], PERIOD_S, 1);
    let length = std::f64::consts::TAU * 10.0;
    for (from, to) in [(&desired, &actual), (&actual, &desired)] {
        let errors = Exact::default().estimate(from, to).unwrap();
        let count = errors.len();
        assert!(errors[..count / 4].iter().all(|e| e.location.arc_mm < 0.3 * length));
        assert!(errors[3 * count / 4..].iter().all(|e| e.location.arc_mm > 0.6 * length));
        assert!(errors[0].at_end && errors[0].location.segment == 0);
    }
}

#[test]
fn beyond_the_end_the_end_is_the_foot_point() {
    let line = |from: f64, to: f64, count: usize| -> Vec<Vec3> {
        (0..count).map(|k| Vec3::new(from + (to - from) * k as f64 / (count - 1) as f64, 0.0, 0.0)).collect()
    };
    let to = line(0.0, 10.0, 101);
    let from: Vec<Vec3> = line(-1.0, 11.0, 121).iter().map(|p| p + Vec3::new(0.0, 0.5, 0.0)).collect();
    let matching = TimeMatch { first: -10.0, rate: 1.0 };
    let mut errors = Vec::new();
    Exact::default().estimate_into(ContourQuery::new(&from, &to, matching), &mut errors).unwrap();
    for (sample, error) in from.iter().zip(&errors) {
        let beyond = (sample.x - sample.x.clamp(0.0, 10.0)).abs();
        assert!((error.magnitude_mm - beyond.hypot(0.5)).abs() < 1e-9);
        if ((sample.x - 5.0).abs() - 5.0).abs() > 1e-9 {
            assert_eq!(error.at_end, beyond > 0.0, "{}", sample.x);
        }
        assert!((error.left_mm() - error.magnitude_mm).abs() < 1e-12);
    }
}

#[test]
fn one_wild_sample_spoils_only_itself() {
    let (_, desired) = travel(&wave(60.0, 5.0, 4.0), 80.0, 800.0, PERIOD_S);
    let actual = lagged(&desired, [0.009; 3], PERIOD_S, 1);
    let clean = Exact::default().estimate(&actual, &desired).unwrap();
    for jump in [Vec3::new(5.0, 0.0, 0.0), Vec3::new(-5.0, 3.0, 0.0)] {
        let mut spoilt = actual.clone();
        spoilt[400] += jump;
        let errors = Exact::default().estimate(&spoilt, &desired).unwrap();
        let differing: Vec<usize> =
            (0..errors.len()).filter(|k| (errors[*k].magnitude_mm - clean[*k].magnitude_mm).abs() > 1e-9).collect();
        println!("{jump:?}: {differing:?} differ");
        assert!(differing.len() <= 3 && differing.contains(&400));
    }
}

#[test]
fn a_retraced_line_is_followed_there_and_back() {
    let desired: Vec<Vec3> = (0..2000).map(|k| Vec3::new(20.0 * (1.0 - (k as f64 * 0.01).cos()), 0.0, 0.0)).collect();
    let actual = lagged(&desired, [0.009; 3], PERIOD_S, 1);
    let errors = Exact::default().estimate(&desired, &actual).unwrap();
    for (k, error) in errors.iter().enumerate() {
        let index = error.location.segment as f64 + error.location.fraction;
        // A lag of about 4.5 samples at the reversals, where both branches coincide.
        assert!((index - k as f64) > -12.0 && (index - k as f64) < 25.0, "sample {k} on {index}");
    }
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let path = vec![Vec3::zeros(), Vec3::x()];
    for mut estimator in sample_estimators() {
        assert!(estimator.estimate(&path, &[]).is_err());
        assert!(estimator.estimate(&[], &path).unwrap().is_empty());
        assert!(estimator.estimate(&[], &[]).unwrap().is_empty());
        assert!(estimator.estimate(&[Vec3::new(0.0, f64::NAN, 0.0)], &path).is_err());
        assert!(estimator.estimate(&path, &[Vec3::new(1e10, 0.0, 0.0)]).is_err());
        let mut out = Vec::new();
        for matching in [TimeMatch { first: f64::NAN, rate: 1.0 }, TimeMatch { first: 0.0, rate: 0.0 }] {
            assert!(estimator.estimate_into(ContourQuery::new(&path, &path, matching), &mut out).is_err());
        }
    }
    for window in [
        Window { margin: -1.0, ..Window::default() },
        Window { max_samples: 0, ..Window::default() },
        Window { noise_mm: f64::NAN, ..Window::default() },
    ] {
        assert!(Exact::with_window(window).is_err());
    }
    assert!(SampledSpline::new(&[]).is_err());
}

#[test]
fn paper_as_horizon_agrees_where_a_path_does_not_cross_itself() {
    let (_, desired) = travel(&spiral(), 80.0, 800.0, PERIOD_S);
    let actual = lagged(&desired, [0.009; 3], PERIOD_S, 1);
    let near = HermiteFootPoint::default().estimate(&desired, &actual).unwrap();
    let whole = HermiteFootPoint::new(Horizon::ToEnd).estimate(&desired, &actual).unwrap();
    let apart = largest(near.iter().zip(&whole).map(|(a, b)| (a.magnitude_mm - b.magnitude_mm).abs()));
    assert!(apart < 1e-6, "{apart}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, rng_seed: RngSeed::Fixed(11), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_pair_of_paths_is_measured(
        from in path(), to in path(), first in -40.0..40.0_f64, rate in 0.05..5.0_f64,
    ) {
        let matching = TimeMatch { first, rate };
        let estimators: [&mut dyn ContourEstimator; 5] = [
            &mut Exact::default(), &mut HermiteFootPoint::default(), &mut SplineSearch::default(),
            &mut OsculatingCircle::default(), &mut Tangent::default(),
        ];
        for estimator in estimators {
            let mut errors = Vec::new();
            estimator.estimate_into(ContourQuery::new(&from, &to, matching), &mut errors).unwrap();
            prop_assert_eq!(errors.len(), from.len());
            for (sample, error) in from.iter().zip(&errors) {
                prop_assert!((error.foot + error.vector - sample).norm() <= 1e-9 * (1.0 + sample.norm()));
                prop_assert!((error.vector.norm() - error.magnitude_mm).abs() <= 1e-9 * (1.0 + sample.norm()));
                prop_assert!(error.location.segment < to.len());
                prop_assert!((0.0..=1.0).contains(&error.location.fraction));
            }
        }
    }
}

/// Up to 40 points, sometimes repeated, sometimes extreme.
fn path() -> impl Strategy<Value = Vec<Vec3>> {
    let step = prop_oneof![
        4 => (-0.2..0.2_f64, -0.2..0.2_f64, -0.2..0.2_f64).prop_map(|(x, y, z)| Vec3::new(x, y, z)),
        2 => Just(Vec3::zeros()),
        1 => (-300.0..300.0_f64, -300.0..300.0_f64).prop_map(|(x, y)| Vec3::new(x, y, 0.0)),
        1 => (-1e-6..1e-6_f64).prop_map(|x| Vec3::new(x, 0.0, x)),
    ];
    prop::collection::vec(step, 1..40).prop_map(|steps| {
        let mut at = Vec3::zeros();
        steps
            .into_iter()
            .map(|step| {
                at += step;
                at
            })
            .collect()
    })
}
