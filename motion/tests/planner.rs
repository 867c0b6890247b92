//! The planner satisfies every limit on every curve, and reaches the closed-form time if there is
//! one.

use std::sync::Arc;

use motion::curves::{Arc as CircularArc, Line, library};
use motion::{
    Axis, AxisLimits, Cartesian, Curve, DesiredPath, FiveAxis, Kinematics, Limits, MotionError, Piece, Plan, PlanSettings,
    RotaryJoint, RotaryMount, RotaryPath, ToolPath, Turning, Vec3, plan, plan_curve, plan_curve_on,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

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
    // A slow plan would satisfy the limits too: on the crown speed or acceleration must reach nine
    // tenths.
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
    // Too short for the feed: acceleration and deceleration at the limit.
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
fn a_dwell_lasts_its_time() {
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

/// A staircase with steps of this length, each turned by a small angle against the one before.
fn zigzag(step_mm: f64, tolerance_mm: Option<f64>, settings: &PlanSettings) -> Plan {
    let mut path = ToolPath::default();
    let mut at = Vec3::zeros();
    for k in 0..(60.0 / step_mm) as usize {
        let end = at + step_mm * Vec3::new(1.0, if k % 2 == 0 { 0.05 } else { -0.05 }, 0.0);
        let mut piece = Piece::whole(Arc::new(Line { start: at, end }), 80.0);
        piece.corner_tolerance_mm = tolerance_mm;
        path.push(piece);
        at = end;
    }
    plan(&path, &xyz(), &limits(), settings).unwrap()
}

#[test]
fn a_control_may_use_less_of_its_acceleration_along_short_lines() {
    let settings = |share| PlanSettings { corner_tolerance_mm: 0.01, short_line_acceleration: share, ..PlanSettings::default() };
    let seconds = |step_mm, share| zigzag(step_mm, None, &settings(share)).desired.trajectory().duration_s();
    // The blend of a corner of 0.1 rad uses 0.4 mm of either line: half a millimetre is too short
    // for two of them.
    let (half, whole) = (seconds(0.5, 0.5), seconds(0.5, 1.0));
    assert!(half > whole + 0.05, "{half} {whole}");
    // Of long lines only the last one, which ends the program, is slower.
    let (half, whole) = (seconds(5.0, 0.5), seconds(5.0, 1.0));
    assert!(half > whole && half < whole + 0.05, "{half} {whole}");
}

#[test]
fn a_piece_may_have_a_tolerance_of_its_own() {
    let settings = PlanSettings { corner_tolerance_mm: 0.05, ..PlanSettings::default() };
    let corner = Vec3::new(5.0, 0.25, 0.0);
    let off = |tolerance_mm| distance_to(&zigzag(5.0, tolerance_mm, &settings), corner);
    assert!(off(Some(0.002)) < 0.3 * off(None), "{} {}", off(Some(0.002)), off(None));
}

#[test]
fn unsound_settings_are_refused() {
    let curve: Arc<dyn Curve> = Arc::new(library::CROWN);
    let with = |settings: PlanSettings, limits: Limits| plan_curve(Arc::clone(&curve), 80.0, &limits, &settings);
    let settings = PlanSettings::default;
    assert!(matches!(with(PlanSettings { period_s: 0.0, ..settings() }, limits()), Err(MotionError::BadPeriod(_))));
    assert!(matches!(with(PlanSettings { rest_s: f64::NAN, ..settings() }, limits()), Err(MotionError::BadSetting { .. })));
    let none = PlanSettings { short_line_acceleration: 0.0, ..settings() };
    assert!(matches!(with(none, limits()), Err(MotionError::BadSetting { name: "short_line_acceleration", .. })));
    let none = PlanSettings { arc_acceleration_mm_s2: 0.0, ..settings() };
    assert!(matches!(with(none, limits()), Err(MotionError::BadSetting { name: "arc_acceleration_mm_s2", .. })));
    assert!(matches!(with(settings(), Limits::uniform(2, 80.0, 800.0, 0.02)), Err(MotionError::Mismatch(_))));
    assert!(matches!(with(settings(), Limits::uniform(3, 80.0, -1.0, 0.02)), Err(MotionError::BadSetting { .. })));
}

/// Tables B about Y carrying C about Z, their axes 50 mm under workpiece zero; B within ±110°.
fn tilting_tables() -> Arc<dyn Kinematics> {
    let joint = |axis: &str, direction: Vec3, travel_rad| RotaryJoint {
        axis: axis.to_owned(),
        mount: RotaryMount::Table,
        direction,
        pivot_mm: Vec3::new(0.0, 0.0, -50.0),
        travel_rad,
    };
    let axes = ["x", "y", "z", "b", "c"].map(Axis::named).to_vec();
    let joints = vec![joint("b", Vec3::y(), Some([-1.92, 1.92])), joint("c", Vec3::z(), None)];
    Arc::new(FiveAxis::new(axes, joints, 80.0, [None; 3]).unwrap())
}

fn limits_of_tables() -> Limits {
    let rotary = |velocity, acceleration| AxisLimits { velocity, acceleration, jerk: 100.0 * acceleration };
    let mut limits = Limits::uniform(3, 80.0, 800.0, 0.02);
    limits.axes.extend([rotary(2.0, 20.0), rotary(3.0, 40.0)]);
    limits
}

#[test]
fn five_axes_keep_their_limits_and_the_tool_its_feed() {
    let (kinematics, limits) = (tilting_tables(), limits_of_tables());
    for (name, feed) in [("saddle", 16.7), ("saddle", 80.0), ("saddle-butterfly", 25.0), ("saddle-butterfly", 80.0)] {
        let curve = library::by_name(name).unwrap();
        let desired = plan_curve_on(Arc::clone(&curve), feed, &kinematics, &limits, &PlanSettings::default()).unwrap();
        assert_held(name, &desired, &limits);
        let tips = desired.tips();
        let fastest = tips.windows(2).map(|pair| (pair[1] - pair[0]).norm() / 0.002).fold(0.0, f64::max);
        assert!(fastest < feed * 1.0001 && (feed > 20.0 || fastest > 0.99 * feed), "{name}: {fastest} mm/s");
        let leans = desired.poses().iter().map(|pose| pose.tool.z);
        assert!(leans.clone().fold(1.0, f64::min) < 0.95, "{name} leans");
    }
}

#[test]
fn lines_of_five_axes_are_rounded_within_the_tolerance_and_keep_all_limits() {
    let (kinematics, limits) = (tilting_tables(), limits_of_tables());
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for tip_words in [false, true] {
        for _ in 0..40 {
            let mut draw = |most: f64| Vec3::from_fn(|_, _| rng.random_range(-most..most));
            let points: Vec<(Vec3, Vec3)> = (0..8)
                .map(|_| {
                    let (linear, turned) = (draw(40.0), draw(1.0));
                    (linear, Vec3::new(0.0, 1.0 + 0.6 * turned.y, 2.0 * turned.z))
                })
                .collect();
            let mut path = ToolPath::default();
            for pair in points.windows(2) {
                let turn = RotaryPath::linear(pair[0].1, pair[1].1);
                let turning = if tip_words { Turning::Tip(turn) } else { Turning::Axes(turn) };
                path.push(Piece::whole(Arc::new(Line { start: pair[0].0, end: pair[1].0 }), 60.0).turning(turning));
            }
            let made = plan(&path, &kinematics, &limits, &PlanSettings::default()).unwrap();
            assert_held("lines", &made.desired, &limits);
            // Both ends are exact, and every corner is within the tolerance, a degree counting as a
            // millimetre.
            let coordinates = |k: usize| -> Vec<f64> {
                let joints: Vec<f64> = made.desired.trajectory().at(k).collect();
                let tip = if tip_words { kinematics.forward(&joints).tip } else { Vec3::new(joints[0], joints[1], joints[2]) };
                vec![tip.x, tip.y, tip.z, joints[3].to_degrees(), joints[4].to_degrees()]
            };
            for (linear, rotary) in &points {
                let corner = [linear.x, linear.y, linear.z, rotary.y.to_degrees(), rotary.z.to_degrees()];
                let off = |k: usize| coordinates(k).iter().zip(corner).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
                let nearest = (0..made.samples.len()).map(off).fold(f64::INFINITY, f64::min);
                // Samples are up to 0.2 mm apart at 60 mm/s, a degree counting as a millimetre.
                assert!(nearest < 0.15, "{nearest} mm from a corner");
            }
        }
    }
}

/// Along x with the tool tilted against it, `aside_rad` from the pole.
#[derive(Debug)]
struct OverThePole {
    aside_rad: f64,
}

impl Curve for OverThePole {
    fn domain(&self) -> (f64, f64) {
        (-20.0, 20.0)
    }

    fn derivatives(&self, u: f64) -> [Vec3; 4] {
        [Vec3::new(u, 0.0, 0.0), Vec3::x(), Vec3::zeros(), Vec3::zeros()]
    }

    fn tool(&self, u: f64) -> Vec3 {
        Vec3::new(-u / 80.0, self.aside_rad, 1.0).normalize()
    }
}

#[test]
fn a_path_over_the_pole_is_refused_and_one_well_beside_it_is_slowed() {
    let (kinematics, limits) = (tilting_tables(), limits_of_tables());
    let run =
        |aside_rad| plan_curve_on(Arc::new(OverThePole { aside_rad }), 40.0, &kinematics, &limits, &PlanSettings::default());
    for aside_rad in [1e-9, 1e-5, 3e-4] {
        let refusal = run(aside_rad).unwrap_err();
        assert!(matches!(refusal, MotionError::Infeasible { .. }) && refusal.to_string().contains("pole"), "{refusal}");
    }
    let slowed = run(0.01).unwrap();
    assert_held("beside the pole", &slowed, &limits);
    assert!(slowed.trajectory().duration_s() > 1.1 * run(0.5).unwrap().trajectory().duration_s());
}

#[test]
fn axes_beyond_their_travel_are_refused_with_their_piece() {
    let (kinematics, limits) = (tilting_tables(), limits_of_tables());
    for tip_words in [false, true] {
        let mut path = ToolPath::default();
        for b in [0.5, 1.5, 2.5] {
            let turn = RotaryPath::linear(Vec3::new(0.0, b - 1.0, 0.3), Vec3::new(0.0, b, 0.3));
            let turning = if tip_words { Turning::Tip(turn) } else { Turning::Axes(turn) };
            let line = Line { start: Vec3::new(b - 1.0, 0.0, 0.0), end: Vec3::new(b, 0.0, 0.0) };
            path.push(Piece::whole(Arc::new(line), 10.0).turning(turning));
        }
        let refusal = plan(&path, &kinematics, &limits, &PlanSettings::default()).unwrap_err();
        assert_eq!(refusal.piece(), Some(2), "{refusal}");
        assert!(refusal.to_string().contains("axis `b`"), "{refusal}");
    }
}

#[test]
fn a_path_that_takes_days_is_refused_with_its_piece_before_it_is_planned() {
    let line = |from: f64, to: f64| Arc::new(Line { start: Vec3::new(from, 0.0, 0.0), end: Vec3::new(to, 0.0, 0.0) });
    let mut path = ToolPath::default();
    path.push(Piece::whole(line(0.0, 100.0), 20.0));
    path.push(Piece::whole(line(100.0, 500.0), 1e-9));
    path.push(Piece::whole(line(500.0, 600.0), 20.0));
    let kinematics: Arc<dyn Kinematics> = xyz();
    let refusal = plan(&path, &kinematics, &limits(), &PlanSettings::default()).unwrap_err();
    assert!(
        matches!(refusal, MotionError::TooLong { piece: 1, position_mm, .. } if position_mm > 100.0 && position_mm < 500.0),
        "{refusal}"
    );
    let mut path = ToolPath::default();
    let mut dwelling = Piece::whole(line(0.0, 100.0), 20.0);
    (dwelling.stop_after, dwelling.dwell_s) = (true, 1e9);
    path.push(dwelling);
    assert!(matches!(plan(&path, &kinematics, &limits(), &PlanSettings::default()), Err(MotionError::TooLong { piece: 0, .. })));
}
