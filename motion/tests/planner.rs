//! The planner holds every limit on every curve, and takes the closed-form time where there is one.

use std::sync::Arc;

use motion::curves::{Arc as CircularArc, Line, library};
use motion::{
    Axis, Cartesian, Curve, DesiredPath, Kinematics, Limits, MotionError, Piece, Plan, PlanSettings, ToolPath, Vec3, plan,
    plan_curve,
};

fn xyz() -> Arc<dyn Kinematics> {
    Arc::new(Cartesian::new(Axis::xyz()))
}

fn limits() -> Limits {
    Limits::uniform(3, 80.0, 800.0, 0.02)
}

/// Largest speed, acceleration and jerk of any axis over its limit, from backward differences of the samples.
fn worst(desired: &DesiredPath, limits: &Limits) -> [f64; 3] {
    let t = desired.trajectory();
    let h = t.period_s();
    let mut worst = [0.0_f64; 3];
    for (column, limit) in t.columns().iter().zip(&limits.axes) {
        let mut values = column.clone();
        for (order, bound) in [limit.velocity, limit.acceleration, limit.jerk].iter().enumerate() {
            values = values.windows(2).map(|w| (w[1] - w[0]) / h).collect();
            let top = values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            worst[order] = worst[order].max(top / bound);
        }
    }
    worst
}

fn assert_held(name: &str, desired: &DesiredPath, limits: &Limits) {
    let worst = worst(desired, limits);
    assert!(worst.iter().all(|w| *w <= 1.0 + 1e-5), "{name}: {worst:?}");
}

#[test]
fn limits_are_held_on_every_curve() {
    let limits = limits();
    let mut names: Vec<String> = library::NAMES.map(String::from).to_vec();
    names.extend((1..4).map(|seed| format!("nurbs-{seed}")));
    for name in names {
        for feed in [20.0, 80.0] {
            let curve = library::by_name(&name).unwrap();
            let desired =
                plan_curve(curve, feed, &limits, &PlanSettings::default()).unwrap_or_else(|e| panic!("{name} at {feed}: {e}"));
            assert_held(&name, &desired, &limits);
            println!(
                "{name} at {feed} mm/s: {:.2} s, use of limits {:?}",
                desired.trajectory().duration_s(),
                worst(&desired, &limits)
            );
        }
    }
}

#[test]
fn plans_use_what_the_limits_allow() {
    // Held limits alone could be had by crawling: on the crown speed or acceleration is used to nine tenths.
    let limits = limits();
    let desired = plan_curve(Arc::new(library::CROWN), 80.0, &limits, &PlanSettings::default()).unwrap();
    let worst = worst(&desired, &limits);
    assert!(worst[0] > 0.9 || worst[1] > 0.9, "{worst:?}");
}

fn line(length_mm: f64, feed_mm_s: f64, settings: &PlanSettings) -> DesiredPath {
    let direction = Vec3::new(2.0, -1.0, 2.0) / 3.0;
    let curve = Line { start: Vec3::new(1.0, 2.0, 3.0), end: Vec3::new(1.0, 2.0, 3.0) + direction * length_mm };
    plan_curve(Arc::new(curve), feed_mm_s, &limits(), settings).unwrap()
}

#[test]
fn a_straight_line_takes_the_closed_form_time() {
    let settings = PlanSettings { rest_s: 0.0, ..PlanSettings::default() };
    // Two averages over ten samples: nine more each.
    let smoothing = 2.0 * 9.0 * 0.002;
    for (length, feed) in [(50.0, 40.0), (20.0, 80.0), (120.0, 10.0)] {
        let expected = length / feed + feed / 800.0 + smoothing;
        let duration = line(length, feed, &settings).trajectory().duration_s();
        // The last sample is the first one at or after the end.
        assert!((-1e-9..0.002 + 1e-9).contains(&(duration - expected)), "{length} mm: {duration} s, {expected} s");
    }
    // Too short for the feed: up and down at full acceleration.
    let expected = 2.0 * (1.0_f64 / 800.0).sqrt() + smoothing;
    let duration = line(1.0, 80.0, &settings).trajectory().duration_s();
    assert!((-1e-9..0.002 + 1e-9).contains(&(duration - expected)), "{duration} s, {expected} s");
}

#[test]
fn every_sample_lies_on_the_curve() {
    let desired = plan_curve(Arc::new(library::FIVE_PETALS), 40.0, &limits(), &PlanSettings::default()).unwrap();
    for tip in desired.tips() {
        let u = tip.y.atan2(tip.x);
        assert!((tip.xy().norm() - (25.0 + 15.0 * (5.0 * u).cos())).abs() < 1e-9);
    }
}

fn square(tolerance: f64, dwell_s: f64) -> Plan {
    let corners = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0), (0.0, 0.0)].map(|(x, y)| Vec3::new(x, y, 0.0));
    let mut path = ToolPath::default();
    for pair in corners.windows(2) {
        let mut piece = Piece::whole(Arc::new(Line { start: pair[0], end: pair[1] }), 50.0);
        piece.dwell_s = dwell_s;
        path.push(piece);
    }
    let settings = PlanSettings { corner_tolerance_mm: tolerance, ..PlanSettings::default() };
    plan(&path, &xyz(), &limits(), &settings).unwrap()
}

fn distance_to(plan: &Plan, point: Vec3) -> f64 {
    plan.desired.tips().iter().map(|tip| (tip - point).norm()).fold(f64::INFINITY, f64::min)
}

#[test]
fn corners_are_rounded_within_the_tolerance_and_never_more() {
    let corner = Vec3::new(10.0, 10.0, 0.0);
    for tolerance in [0.005, 0.05] {
        let rounded = square(tolerance, 0.0);
        assert_held("square", &rounded.desired, &limits());
        let left = distance_to(&rounded, corner);
        assert!(left > 0.5 * tolerance && left < 1.2 * tolerance, "{left}");
    }
    let exact = square(0.0, 0.0);
    assert!(distance_to(&exact, corner) < 1e-12);
    assert!(square(0.05, 0.0).desired.trajectory().duration_s() < exact.desired.trajectory().duration_s());
}

#[test]
fn a_dwell_rests_for_its_time() {
    let (with, without) = (square(0.0, 0.5), square(0.0, 0.0));
    let more = with.desired.trajectory().duration_s() - without.desired.trajectory().duration_s();
    assert!((more - 4.0 * 0.5).abs() < 1e-9, "{more}");
}

#[test]
fn samples_know_their_piece() {
    let plan = square(0.01, 0.0);
    assert_eq!(plan.samples.len(), plan.desired.trajectory().len());
    assert!(plan.samples.windows(2).all(|w| w[0].piece <= w[1].piece && w[0].position_mm <= w[1].position_mm));
    for (tip, sample) in plan.desired.tips().iter().zip(&plan.samples) {
        let off_side = [tip.y, tip.x - 10.0, tip.y - 10.0, tip.x][sample.piece];
        assert!(off_side.abs() < 0.011, "{tip:?} on side {}", sample.piece);
    }
}

#[test]
fn a_dense_polyline_is_followed_like_its_curve() {
    let mut path = ToolPath::default();
    let points: Vec<Vec3> = (0..=400)
        .map(|i| f64::from(i) * std::f64::consts::TAU / 400.0)
        .map(|u| Vec3::new(20.0 * u.cos(), 20.0 * u.sin(), 0.0))
        .collect();
    for pair in points.windows(2) {
        path.push(Piece::whole(Arc::new(Line { start: pair[0], end: pair[1] }), 50.0));
    }
    let polyline = plan(&path, &xyz(), &limits(), &PlanSettings::default()).unwrap().desired;
    assert_held("polyline", &polyline, &limits());
    let mut path = ToolPath::default();
    let circle = CircularArc::new(points[0], Vec3::zeros(), Vec3::z(), std::f64::consts::TAU, 20.0, 0.0).unwrap();
    path.push(Piece::whole(Arc::new(circle), 50.0));
    let circle = plan(&path, &xyz(), &limits(), &PlanSettings::default()).unwrap().desired;
    assert_held("circle", &circle, &limits());
    let ratio = polyline.trajectory().duration_s() / circle.trajectory().duration_s();
    assert!((0.99..1.05).contains(&ratio), "{ratio}");
}

#[test]
fn unsound_settings_are_refused() {
    let curve: Arc<dyn Curve> = Arc::new(library::CROWN);
    let with = |settings: PlanSettings, limits: Limits| plan_curve(Arc::clone(&curve), 80.0, &limits, &settings);
    let settings = PlanSettings::default;
    assert!(matches!(with(PlanSettings { period_s: 0.0, ..settings() }, limits()), Err(MotionError::BadPeriod(_))));
    assert!(matches!(with(PlanSettings { rest_s: f64::NAN, ..settings() }, limits()), Err(MotionError::BadSetting { .. })));
    assert!(matches!(with(settings(), Limits::uniform(2, 80.0, 800.0, 0.02)), Err(MotionError::Mismatch(_))));
    assert!(matches!(with(settings(), Limits::uniform(3, 80.0, -1.0, 0.02)), Err(MotionError::BadSetting { .. })));
}
