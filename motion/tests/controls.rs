//! Rules of corners and filters of a control, beside their closed forms.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::sync::Arc;

use motion::curves::Line;
use motion::{Axis, AxisFilter, Cartesian, Corners, Kinematics, Limits, Piece, Plan, PlanSettings, ToolPath, Vec3, plan};

const PERIOD_S: f64 = 0.001;
const ACCELERATION_MM_S2: f64 = 1000.0;

/// Limits without a limit of jerk.
fn limits() -> Limits {
    Limits::uniform(3, 100.0, ACCELERATION_MM_S2, 1e-6)
}

fn xyz() -> Arc<dyn Kinematics> {
    Arc::new(Cartesian::new(Axis::xyz()))
}

fn settings(corners: Corners) -> PlanSettings {
    PlanSettings { period_s: PERIOD_S, smoothing_s: 0.0, corners, ..PlanSettings::default() }
}

/// Two lines of 30 mm with a turn by `turn_rad` at x = 30, at 50 mm/s.
fn corner(turn_rad: f64, stop: Option<f64>, settings: &PlanSettings) -> Plan {
    let at = Vec3::new(30.0, 0.0, 0.0);
    let end = at + 30.0 * Vec3::new(turn_rad.cos(), turn_rad.sin(), 0.0);
    let mut first = Piece::whole(Arc::new(Line { start: Vec3::zeros(), end: at }), 50.0);
    first.corner_tolerance_mm = stop;
    let path: ToolPath = vec![first, Piece::whole(Arc::new(Line { start: at, end }), 50.0)].into();
    plan(&path, &xyz(), &limits(), settings).unwrap()
}

/// Speed next to the corner, mm/s: it is the least one between the ends.
fn corner_speed(plan: &Plan) -> f64 {
    let tips = plan.desired.tips();
    let middle = |tip: &Vec3| (tip - Vec3::new(30.0, 0.0, 0.0)).norm() < 5.0;
    let speeds =
        tips.windows(2).filter(|pair| middle(&pair[0]) && middle(&pair[1])).map(|pair| (pair[1] - pair[0]).norm() / PERIOD_S);
    speeds.fold(f64::INFINITY, f64::min)
}

#[test]
fn corners_are_passed_themselves_at_the_speed_of_the_rule() {
    for turn_rad in [0.3, FRAC_PI_2, 2.0_f64] {
        // x changes its speed by v(1 − cos), y by v·sin.
        let jump = 8.0 / (1.0 - turn_rad.cos()).max(turn_rad.sin());
        let cos = (turn_rad / 2.0).cos();
        let deviation = (ACCELERATION_MM_S2 * 0.02 * cos / (1.0 - cos)).sqrt();
        for (rule, expected) in [(Corners::SpeedJump(8.0), jump), (Corners::JunctionDeviation(0.02), deviation)] {
            let plan = corner(turn_rad, None, &settings(rule));
            let (speed, expected) = (corner_speed(&plan), expected.min(50.0));
            // One sample lies on both lines: its chord is shorter, and it accelerates within it.
            assert!(
                speed > 0.5 * expected && speed < 1.05 * expected + ACCELERATION_MM_S2 * PERIOD_S,
                "{rule:?} {turn_rad}: {speed} for {expected}"
            );
            let tips = plan.desired.tips();
            let off = tips.iter().map(|tip| {
                tip.y.abs().min((tip - Vec3::new(30.0, 0.0, 0.0)).cross(&Vec3::new(turn_rad.cos(), turn_rad.sin(), 0.0)).norm())
            });
            assert!(off.fold(0.0, f64::max) < 1e-9, "every sample lies on one of the lines");
        }
    }
}

#[test]
fn an_exact_stop_of_the_program_stays_one_under_every_rule() {
    for rule in [Corners::Blend, Corners::SpeedJump(8.0), Corners::JunctionDeviation(0.02)] {
        assert!(corner_speed(&corner(FRAC_PI_2, Some(0.0), &settings(rule))) < 2.0, "{rule:?}");
    }
}

#[test]
fn filters_shrink_a_circle_by_their_gain_and_keep_the_path_as_the_target() {
    let (radius_mm, feed_mm_s, filter_s) = (5.0, 40.0, 0.03);
    let circle = motion::curves::Arc::new(Vec3::new(radius_mm, 0.0, 0.0), Vec3::zeros(), Vec3::z(), TAU, radius_mm, 0.0).unwrap();
    let path: ToolPath = vec![Piece::whole(Arc::new(circle), feed_mm_s)].into();
    let filtered = PlanSettings {
        filters: vec![AxisFilter { averages_s: [filter_s, 0.0], time_constant_s: 0.0 }; 3],
        ..settings(Corners::Blend)
    };
    let plan = plan(&path, &xyz(), &limits(), &filtered).unwrap();
    let command = plan.command.as_ref().unwrap();
    assert_eq!(command.len(), plan.desired.trajectory().len());
    let radii = |columns: &[Vec<f64>]| -> Vec<f64> { columns[0].iter().zip(&columns[1]).map(|(x, y)| x.hypot(*y)).collect() };
    assert!(radii(plan.desired.trajectory().columns()).iter().all(|radius| (radius - radius_mm).abs() < 1e-6));
    // A moving average of n samples passes a rotation by φ a sample with the gain sin(nφ/2) / (n·sin(φ/2)).
    let (n, phi) = (filter_s / PERIOD_S, feed_mm_s / radius_mm * PERIOD_S);
    let gain = (n * phi / 2.0).sin() / (n * (phi / 2.0).sin());
    let middle = radii(command.columns())[command.len() / 2];
    assert!((middle - gain * radius_mm).abs() < 1e-6, "{middle} for {}", gain * radius_mm);
    // Without filters the plan is the command.
    assert!(motion::plan(&path, &xyz(), &limits(), &settings(Corners::Blend)).unwrap().command.is_none());
}

#[test]
fn a_lag_shrinks_a_circle_by_its_gain() {
    let (radius_mm, feed_mm_s, time_constant_s) = (5.0, 40.0, 0.02);
    let circle =
        motion::curves::Arc::new(Vec3::new(radius_mm, 0.0, 0.0), Vec3::zeros(), Vec3::z(), 2.0 * TAU, radius_mm, 0.0).unwrap();
    let path: ToolPath = vec![Piece::whole(Arc::new(circle), feed_mm_s)].into();
    let filters = vec![AxisFilter { averages_s: [0.0; 2], time_constant_s }; 3];
    let plan = plan(&path, &xyz(), &limits(), &PlanSettings { filters, rest_s: 0.0, ..settings(Corners::Blend) }).unwrap();
    let command = plan.command.as_ref().unwrap();
    assert_eq!(command.len(), plan.desired.trajectory().len());
    // y += share·(x − y) passes a rotation by φ a sample with the gain share / |1 − (1 − share)·e^(−iφ)|.
    let (kept, phi) = ((-PERIOD_S / time_constant_s).exp(), feed_mm_s / radius_mm * PERIOD_S);
    let gain = (1.0 - kept) / (1.0 - 2.0 * kept * phi.cos() + kept * kept).sqrt();
    let middle = command.len() / 2;
    let radius = command.columns()[0][middle].hypot(command.columns()[1][middle]);
    assert!((radius - gain * radius_mm).abs() < 1e-5, "{radius} for {}", gain * radius_mm);
    // It goes on until a thousandth of the way is left, and the target is as late as the command.
    let end = |columns: &[Vec<f64>]| *columns[0].last().unwrap();
    assert!((end(command.columns()) - end(plan.desired.trajectory().columns())).abs() < 1e-3);
    let turned = |columns: &[Vec<f64>]| columns[1][middle].atan2(columns[0][middle]);
    let late = turned(plan.desired.trajectory().columns()) - turned(command.columns());
    assert!(late.abs() < 0.3 * feed_mm_s / radius_mm * time_constant_s, "{late}");
}

#[test]
fn axes_with_other_filters_leave_a_diagonal_by_the_difference_of_their_delays() {
    let end = Vec3::new(40.0, 40.0, 0.0);
    let path: ToolPath = vec![Piece::whole(Arc::new(Line { start: Vec3::zeros(), end }), 50.0)].into();
    let filter = |average_s: f64, time_constant_s: f64| AxisFilter { averages_s: [average_s, 0.0], time_constant_s };
    let filters = vec![filter(0.021, 0.0), filter(0.0, 0.015), filter(0.0, 0.0)];
    let plan = plan(&path, &xyz(), &limits(), &PlanSettings { filters, rest_s: 0.0, ..settings(Corners::Blend) }).unwrap();
    let columns = plan.command.as_ref().unwrap().columns();
    let middle = columns[0].len() / 2;
    // Each axis runs at 50/√2 mm/s, x is late by half its average, y by T·(1 − share)/share.
    let kept = (-PERIOD_S / 0.015_f64).exp();
    let late_s = [0.010, PERIOD_S * kept / (1.0 - kept)];
    let expected = 50.0 / 2.0_f64.sqrt() * (late_s[1] - late_s[0]);
    assert!((columns[0][middle] - columns[1][middle] - expected).abs() < 1e-3, "{expected}");
    for column in &columns[..2] {
        assert!((column.last().unwrap() - 40.0).abs() < 1e-3);
    }
}

/// Lines of this length along x at 50 mm/s.
fn short_lines(length_mm: f64, count: u32, settings: &PlanSettings) -> Plan {
    let at = |k: u32| Vec3::new(length_mm * f64::from(k), 0.0, 0.0);
    let lines = (0..count).map(|k| Piece::whole(Arc::new(Line { start: at(k), end: at(k + 1) }), 50.0)).collect::<Vec<_>>();
    plan(&lines.into(), &xyz(), &limits(), settings).unwrap()
}

fn speeds(plan: &Plan) -> Vec<f64> {
    plan.desired.trajectory().columns()[0].windows(2).map(|pair| (pair[1] - pair[0]) / PERIOD_S).collect()
}

#[test]
fn a_control_that_needs_time_for_a_line_passes_short_ones_slower() {
    let limited = PlanSettings { piece_time_s: 0.01, ..settings(Corners::Blend) };
    let top = |length_mm: f64| speeds(&short_lines(length_mm, 400, &limited)).into_iter().fold(0.0, f64::max);
    assert!((top(0.2) - 20.0).abs() < 0.1, "0.2 mm in 10 ms: {}", top(0.2));
    assert!((top(1.0) - 50.0).abs() < 0.1, "1 mm takes longer at its feed: {}", top(1.0));
}

#[test]
fn a_control_can_stop_within_the_lines_that_it_knows() {
    let (length_mm, ahead) = (0.1, 8);
    let known = |ahead| short_lines(length_mm, 400, &PlanSettings { look_ahead: Some(ahead), ..settings(Corners::Blend) });
    let plan = known(ahead);
    for (k, speed) in speeds(&plan).into_iter().enumerate() {
        let position = plan.desired.trajectory().columns()[0][k];
        let line = (position / length_mm + 1e-9).floor() + ahead as f64 + 1.0;
        let way_mm = (line * length_mm - position).max(0.0);
        // A sample may lie on two lines.
        let most = (2.0 * ACCELERATION_MM_S2 * way_mm).sqrt() + 2.0 * ACCELERATION_MM_S2 * PERIOD_S;
        assert!(speed <= most, "{speed} at {position}, with {way_mm} mm to stop");
    }
    let top = |plan: &Plan| speeds(plan).into_iter().fold(0.0, f64::max);
    // From the start of a line all of it and eight more are known, at its end eight.
    let least = (2.0 * ACCELERATION_MM_S2 * length_mm * ahead as f64).sqrt();
    assert!(top(&plan) >= 0.98 * least, "{} for {least}", top(&plan));
    let whole = short_lines(length_mm, 400, &settings(Corners::Blend));
    assert_eq!(known(300).desired.trajectory().columns(), whole.desired.trajectory().columns());
}
