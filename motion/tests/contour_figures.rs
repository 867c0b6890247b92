//! Corners, circular tests and alignment.

mod contour_common;

use std::f64::consts::TAU;

use contour_common::*;
use motion::contour::{
    AlignSettings, AlignedBy, Alignment, CirclePlane, ContourEstimator, ContourQuery, Exact, NominalCircle, PAPER_B_RATIO,
    PAPER_B_SUPPORT, SupportRegion, align, circular_test, corner_flags, stretches,
};
use motion::curves::library;
use motion::{Curve, Vec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Fourth-order ellipse (Paper A, eq. 43).
fn fourth_order_ellipse() -> Analytic {
    let k = 0.3;
    let p = 65.0 * (1.0 - k);
    polar(
        (0.0, TAU),
        move |u| {
            let (sin, cos) = (4.0 * u).sin_cos();
            let (q, q1, q2) = (1.0 - k * cos, 4.0 * k * sin, 16.0 * k * cos);
            [p / q, -p * q1 / (q * q), p * (2.0 * q1 * q1 / (q * q * q) - q2 / (q * q))]
        },
        |_| [0.0; 3],
    )
}

/// Samples one period of a constant feed apart.
fn at_feed(curve: &dyn Curve, feed_mm_min: f64, period_s: f64) -> Vec<Vec3> {
    let step = feed_mm_min / 60.0 * period_s;
    let (first, last) = curve.domain();
    let fine = 400_000;
    let point = |i: usize| curve.point(first + (last - first) * i as f64 / fine as f64);
    let mut samples = vec![point(0)];
    let mut travelled = 0.0;
    for i in 1..=fine {
        travelled += (point(i) - point(i - 1)).norm();
        if travelled >= step {
            travelled -= step;
            samples.push(point(i));
        }
    }
    samples
}

#[test]
fn corners_by_paper_b() {
    let count = |curve: &dyn Curve| {
        let path = at_feed(curve, 1000.0, PERIOD_S);
        stretches(&corner_flags(&path, PAPER_B_SUPPORT, PAPER_B_RATIO)).len()
    };
    let found = [count(&fourth_order_ellipse()), count(&flower(25.0, 15.0, 5.0)), count(&library::butterfly().unwrap())];
    println!("corner stretches: ellipse {}, flower {}, butterfly {}", found[0], found[1], found[2]);
    assert_eq!(found[0], 0);
    // One where each pair of petals meets.
    assert_eq!(found[1], 5);
    assert!(found[2] >= 6);
}

#[test]
fn corners_by_length_do_not_depend_on_sampling() {
    let curve = flower(25.0, 15.0, 5.0);
    let support = SupportRegion::LengthMm(4.0 / 60.0);
    let ends: Vec<Vec<f64>> = [1.0, 2.0, 0.37]
        .iter()
        .map(|times| {
            let path = at_feed(&curve, 1000.0, PERIOD_S * times);
            let arcs: Vec<f64> = (0..path.len()).map(|k| k as f64 / path.len() as f64).collect();
            stretches(&corner_flags(&path, support, PAPER_B_RATIO))
                .into_iter()
                .flat_map(|range| [arcs[range.start], arcs[range.end - 1]])
                .collect()
        })
        .collect();
    assert_eq!(ends[0].len(), 10);
    for other in &ends[1..] {
        assert_eq!(other.len(), ends[0].len());
        assert!(other.iter().zip(&ends[0]).all(|(a, b)| (a - b).abs() < 1e-3));
    }
}

#[test]
fn figures_of_an_oval_circle_with_lead_in() {
    // Radius 30 mm, 4 µm oval, 2 µm larger clockwise, centre off by a work offset; lead-in and lead-out from the centre.
    let centre = Vec3::new(100.0, -40.0, 7.0);
    let at = |angle: f64, radius: f64| centre + radius * Vec3::new(angle.cos(), angle.sin(), 0.0);
    let radius = |angle: f64, larger: f64| 30.0 + 0.003 + larger + 0.004 * (2.0 * angle).cos();
    let lead: Vec<Vec3> = (0..200).map(|k| at(0.0, 30.0 * f64::from(k) / 200.0)).collect();
    let lap = |larger: f64, sense: f64| {
        (0..=4000).map(move |k| {
            let angle = sense * TAU * f64::from(k) / 4000.0;
            at(angle, radius(angle, larger))
        })
    };
    let rest = vec![at(0.0, radius(0.0, 0.0)); 300];
    let path: Vec<Vec3> =
        lead.iter().copied().chain(lap(0.0, 1.0)).chain(rest).chain(lap(0.002, -1.0)).chain(lead.iter().rev().copied()).collect();
    let nominal = NominalCircle { centre: None, radius_mm: 30.0 };
    let test = circular_test(&path, CirclePlane::Xy, nominal).unwrap();
    println!("{test:?}");
    let close = |a: f64, b: f64| (a - b).abs() < 2e-5;
    assert!(close(test.centre[0], 100.0) && close(test.centre[1], -40.0));
    let (ccw, cw) = (test.counterclockwise.unwrap(), test.clockwise.unwrap());
    assert!(close(ccw.circular_deviation_mm, 0.008) && close(cw.circular_deviation_mm, 0.008));
    assert!(close(ccw.radial_max_mm, 0.007) && close(ccw.radial_min_mm, -0.001));
    assert!(close(cw.radial_max_mm, 0.009) && close(cw.radial_min_mm, 0.001));
    assert!(close(test.bidirectional_mm.unwrap(), 0.010));
    assert!((test.mean_bidirectional_mm.unwrap() - 0.004).abs() < 3e-4);
    assert!((test.hysteresis_mm.unwrap() - 0.002).abs() < 1e-4);

    let one_way = circular_test(&path[..4200], CirclePlane::Xy, nominal).unwrap();
    assert!(one_way.clockwise.is_none() && one_way.bidirectional_mm.is_none() && one_way.hysteresis_mm.is_none());
    let (_, wavy) = travel(&wave(60.0, 5.0, 4.0), 80.0, 800.0, PERIOD_S);
    assert!(circular_test(&wavy, CirclePlane::Xy, nominal).is_err());
    assert!(circular_test(&path[..2000], CirclePlane::Xy, nominal).is_err());
}

/// The desired path with `rest` samples of standstill at both ends, the run without delay and
/// offset, and the recorded run: `late_s` late, with a work offset.
fn late_run(curve: &dyn Curve, offset: Vec3, late_s: f64, rest: usize) -> (Vec<Vec3>, Vec<Vec3>, Vec<Vec3>) {
    let (_, moving) = travel(curve, 80.0, 800.0, PERIOD_S);
    let mut desired = vec![moving[0]; rest];
    desired.extend(&moving);
    desired.extend(vec![*moving.last().unwrap(); rest]);
    let per = 20;
    let fine = lagged(&desired, [0.0090, 0.0093, 0.0088], PERIOD_S, per);
    let late = (late_s / PERIOD_S * per as f64).round() as usize;
    let true_actual: Vec<Vec3> = fine.iter().copied().step_by(per).collect();
    let recorded = (0..desired.len() + 10).map(|k| fine[(k * per).saturating_sub(late).min(fine.len() - 1)] + offset).collect();
    (desired, true_actual, recorded)
}

/// Largest difference, µm, between contour errors after alignment and the true ones.
fn difference_um(desired: &[Vec3], truth: &[Vec3], recorded: &[Vec3], found: &Alignment) -> f64 {
    let expected = Exact::default().estimate(desired, truth).unwrap();
    let mut measured = Vec::new();
    Exact::default()
        .estimate_into(ContourQuery::new(desired, &found.apply(recorded), found.desired_to_actual()), &mut measured)
        .unwrap();
    1e3 * largest(
        measured
            .iter()
            .zip(&expected)
            .filter(|(one, other)| !one.at_end && !other.at_end)
            .map(|(one, other)| (one.magnitude_mm - other.magnitude_mm).abs()),
    )
}

#[test]
fn a_late_and_shifted_run_measures_the_same() {
    let offset = Vec3::new(12.345, -3.2, 0.7);
    let straight = Analytic {
        domain: (0.0, 40.0),
        formula: Box::new(|u| [Vec3::new(0.8 * u, 0.6 * u, 0.0), Vec3::new(0.8, 0.6, 0.0), Vec3::zeros(), Vec3::zeros()]),
    };
    let curves: [(&str, &dyn Curve, bool); 5] = [
        ("spiral", &spiral(), false),
        ("circle", &circle(20.0), true),
        ("wave", &wave(60.0, 5.0, 4.0), false),
        ("flower", &flower(25.0, 15.0, 5.0), true),
        ("straight line", &straight, false),
    ];
    for (name, curve, closed) in curves {
        for rest in [0, 100] {
            let (desired, truth, recorded) = late_run(curve, offset, 0.0037, rest);
            let found = align(&desired, &recorded, PERIOD_S, &AlignSettings::default()).unwrap();
            let off_um = 1e3 * (found.offset - offset).norm();
            let different_um = difference_um(&desired, &truth, &recorded, &found);
            println!(
                "{name}, rests of {rest} samples: delay {:.3} ms, offset off by {off_um:.1e} µm, contour error by {different_um:.1e} µm",
                1e3 * found.delay_s
            );
            assert_eq!((found.by, found.closed, found.ambiguous), (AlignedBy::Rests, closed, false));
            assert!(different_um < 0.01);
            // Late by 3.7 ms plus the mean lag.
            assert!((found.delay_s - 0.0037 - 0.0091).abs() < 4e-4);
        }
    }
}

#[test]
fn encoder_steps_are_overcome_by_the_controls_resolution() {
    let offset = Vec3::new(12.345, -3.2, 0.7);
    let (desired, truth, recorded) = late_run(&spiral(), offset, 0.0037, 100);
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let step = 5.0 / 32_768.0;
    let counted: Vec<Vec3> =
        recorded.iter().map(|p| p.map(|value| ((value + rng.random_range(-2e-4..2e-4)) / step).round() * step)).collect();
    let plain = align(&desired, &counted, PERIOD_S, &AlignSettings::default()).unwrap();
    let settings = AlignSettings { offset_step_mm: Some(1e-3), ..AlignSettings::default() };
    let rounded = align(&desired, &counted, PERIOD_S, &settings).unwrap();
    println!(
        "with counts and noise: off by {:.3} µm, rounded {:.1e} µm",
        1e3 * (plain.offset - offset).norm(),
        1e3 * (rounded.offset - offset).norm()
    );
    assert!((plain.offset - offset).norm() < 2e-4);
    assert!((rounded.offset - offset).norm() < 1e-9);
    assert!(difference_um(&desired, &truth, &recorded, &rounded) < 0.01);
}

#[test]
fn a_record_without_standstill_is_aligned_by_its_contour() {
    let offset = Vec3::new(12.345, -3.2, 0.7);
    let (desired, truth, recorded) = late_run(&flower(25.0, 15.0, 5.0), offset, 0.0037, 0);
    let cut = 300..desired.len() - 300;
    let found = align(&desired[cut.clone()], &recorded[cut.clone()], PERIOD_S, &AlignSettings::default()).unwrap();
    let off_um = 1e3 * (found.offset - offset).norm();
    println!("without rests: offset off by {off_um:.3} µm");
    assert_eq!(found.by, AlignedBy::Contour);
    // The mean contour error remains. It cannot be separated from an offset.
    let contour = Exact::default().estimate(&desired, &truth).unwrap();
    let mean_um = 1e3 * contour.iter().map(|e| e.magnitude_mm).sum::<f64>() / contour.len() as f64;
    assert!(off_um < mean_um, "{off_um} against {mean_um}");

    let turning: Vec<Vec3> = (0..2000)
        .map(|k| {
            let angle = TAU * f64::from(k) / 1600.0;
            20.0 * Vec3::new(angle.cos(), angle.sin(), 0.0)
        })
        .collect();
    let closed = align(&turning[..1601], &turning[200..1801], PERIOD_S, &AlignSettings::default()).unwrap();
    assert!(closed.closed && closed.ambiguous, "{closed:?}");
}

#[test]
fn what_cannot_be_aligned_is_refused() {
    let path = vec![Vec3::zeros(), Vec3::x(), Vec3::y()];
    let settings = AlignSettings::default();
    assert!(align(&path, &path, 0.0, &settings).is_err());
    assert!(align(&path[..1], &path, PERIOD_S, &settings).is_err());
    assert!(align(&path, &[Vec3::zeros(), Vec3::new(f64::INFINITY, 0.0, 0.0)], PERIOD_S, &settings).is_err());
    let bad = AlignSettings { rest_mm: -1.0, ..settings };
    assert!(align(&path, &path, PERIOD_S, &bad).is_err());
    assert!(align(&path, &path, PERIOD_S, &settings).is_ok());
}
