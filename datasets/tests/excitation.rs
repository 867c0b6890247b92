//! Excitation keeps its limits, starts and ends at a standstill, and is varied.

use datasets::{DatasetError, ExcitationPlan, RunPlan, excite};
use motion::{Axis, Limits, Trajectory};

const PERIOD_S: f64 = 0.002;

fn limits() -> Limits {
    Limits::uniform(3, 80.0, 800.0, 0.02)
}

fn runs(plan: &ExcitationPlan, limits: &Limits, axes: &[Axis], half: f64) -> Vec<(String, Trajectory)> {
    let travel = vec![(-half, half); axes.len()];
    excite(plan, limits, axes, &travel, PERIOD_S, 7).unwrap()
}

/// Finite differences of an axis, of one order, with standstill before and after.
fn differences(column: &[f64], order: i32) -> Vec<f64> {
    let mut values = vec![column[0]; 3];
    values.extend(column);
    values.extend([column[column.len() - 1]; 3]);
    for _ in 0..order {
        values = values.windows(2).map(|pair| (pair[1] - pair[0]) / PERIOD_S).collect();
    }
    values
}

fn assert_within(trajectory: &Trajectory, limits: &Limits, share: f64) -> [f64; 3] {
    let mut reached = [0.0_f64; 3];
    for order in 1..=3 {
        let axes: Vec<Vec<f64>> = trajectory.columns().iter().map(|column| differences(column, order)).collect();
        for (axis, limits) in axes.iter().zip(&limits.axes) {
            let limit = [limits.velocity * share, limits.acceleration, limits.jerk][order as usize - 1];
            let most = axis.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
            assert!(most <= limit * (1.0 + 1e-6), "order {order}: {most} above {limit}");
            reached[order as usize - 1] = reached[order as usize - 1].max(most / limit);
        }
    }
    reached
}

#[test]
fn the_default_plan_makes_thirty_thousand_samples_within_the_limits() {
    let plan = ExcitationPlan::default();
    let runs = runs(&plan, &limits(), &Axis::xyz(), 100.0);
    let samples: usize = runs.iter().map(|(_, run)| run.len()).sum();
    println!("{} runs, {samples} samples", runs.len());
    assert!(runs.len() >= 8 && (24_000..38_000).contains(&samples), "{samples}");
    let mut reversals = 0;
    for ((name, run), planned) in runs.iter().zip(&plan.runs) {
        let reached = assert_within(run, &limits(), planned.speed_share);
        let speed = differences(&run.columns()[0], 1);
        let rms = (speed.iter().map(|v| v * v).sum::<f64>() / speed.len() as f64).sqrt();
        let turns = speed.windows(2).filter(|pair| pair[0] * pair[1] < 0.0).count();
        println!(
            "{name}: {:.2} s, x speed {rms:.1} mm/s RMS, {turns} reversals, of the limits {:.3} {:.3} {:.3}",
            run.duration_s(),
            reached[0],
            reached[1],
            reached[2]
        );
        // One of the limits is reached.
        assert!(reached.iter().any(|share| *share > 0.9), "{reached:?}");
        assert!(run.duration_s() > 0.5 * planned.seconds && run.duration_s() < 2.0 * planned.seconds);
        reversals += turns;
        for column in run.columns() {
            assert_eq!(column[0], 0.0);
            assert!(column[column.len() - 1].abs() < 1e-9);
            let lead = &column[..50];
            assert!(lead.iter().all(|position| *position == 0.0));
            let tail = &column[column.len() - 50..];
            assert!(tail.iter().all(|position| position == &tail[0]));
        }
    }
    assert!(reversals > 60, "{reversals}");
    assert!(!runs.windows(2).any(|pair| pair[0].1 == pair[1].1));
}

#[test]
fn a_short_travel_is_kept() {
    let runs = runs(&ExcitationPlan::of_seconds(20.0), &limits(), &Axis::xyz(), 5.0);
    for position in runs.iter().flat_map(|(_, run)| run.columns().iter().flatten()) {
        assert!(position.abs() <= 5.0 + 1e-12, "{position}");
    }
}

#[test]
fn approaches_keep_a_travel_shorter_than_they_are() {
    for (name, run) in runs(&ExcitationPlan { runs: vec![RunPlan::lines("lines", 6.0)] }, &limits(), &Axis::xyz(), 0.5) {
        assert!(run.columns().iter().flatten().all(|position| position.abs() <= 0.5 + 1e-9), "{name}");
    }
}

#[test]
fn an_off_centre_travel_and_rotary_axes_are_kept() {
    let axes: Vec<Axis> = ["x", "y", "z", "b", "c"].map(Axis::named).to_vec();
    let mut limits = Limits::uniform(5, 200.0, 2000.0, 0.02);
    for rotary in &mut limits.axes[3..] {
        (rotary.velocity, rotary.acceleration, rotary.jerk) = (1.0, 10.0, 500.0);
    }
    let travel = [(0.0, 300.0), (0.0, 200.0), (-150.0, -50.0), (-0.5, 1.5), (-3.0, 3.0)];
    let plan = ExcitationPlan { runs: vec![RunPlan::standard("five", 6.0, 1.0)] };
    let runs = excite(&plan, &limits, &axes, &travel, PERIOD_S, 3).unwrap();
    assert_within(&runs[0].1, &limits, 1.0);
    for (column, (low, high)) in runs[0].1.columns().iter().zip(travel) {
        assert!(column.iter().all(|position| (low..=high).contains(position)));
        assert!(column.iter().any(|position| (position - column[0]).abs() > 0.05));
    }
}

#[test]
fn every_axis_is_seen_near_its_top_speed_whatever_the_path_may() {
    let mut limits = limits();
    limits.path_velocity_mm_s = 40.0;
    let runs = runs(&ExcitationPlan::default(), &limits, &Axis::xyz(), 60.0);
    for axis in 0..3 {
        let top = runs.iter().flat_map(|(_, run)| differences(&run.columns()[axis], 1)).fold(0.0_f64, |top, v| top.max(v.abs()));
        assert!(top > 0.9 * limits.axes[axis].velocity, "axis {axis}: {top}");
    }
}

#[test]
fn every_axis_is_seen_near_its_acceleration_however_soon_it_reaches_its_speed() {
    // Full speed within half a millimetre.
    let limits = Limits::uniform(3, 48.0, 2500.0, 0.015);
    let runs = runs(&ExcitationPlan::of_seconds(120.0), &limits, &Axis::xyz(), 60.0);
    for axis in 0..3 {
        let accelerations = runs.iter().flat_map(|(_, run)| differences(&run.columns()[axis], 2));
        let top = accelerations.fold(0.0_f64, |top, a| top.max(a.abs()));
        assert!(top > 0.9 * limits.axes[axis].acceleration, "axis {axis}: {top}");
    }
}

#[test]
fn every_axis_rests_while_others_move() {
    let rest_s = |axes: &[Axis], axis: usize| {
        let (limits, travel) = (Limits::uniform(axes.len(), 200.0, 2000.0, 0.02), vec![(-50.0, 50.0); axes.len()]);
        let runs = excite(&ExcitationPlan::of_seconds(120.0), &limits, axes, &travel, PERIOD_S, 1).unwrap();
        let rests = |run: &Trajectory, k: usize| {
            let moves = |column: &Vec<f64>| column[k] != column[k - 1];
            // Not at home, where every run begins.
            !moves(&run.columns()[axis]) && run.columns()[axis][k] != 0.0 && run.columns().iter().any(moves)
        };
        let longest = |run: &Trajectory| {
            let resting: Vec<bool> = (1..run.len()).map(|k| rests(run, k)).collect();
            resting.split(|rests| !rests).map(<[bool]>::len).max().unwrap_or_default()
        };
        runs.iter().map(|(_, run)| longest(run)).max().unwrap_or_default() as f64 * PERIOD_S
    };
    let five: Vec<Axis> = ["x", "y", "z", "b", "c"].map(Axis::named).to_vec();
    for axes in [Axis::xyz(), five, vec![Axis::named("x"), Axis::named("y")]] {
        for axis in 0..axes.len() {
            let longest_s = rest_s(&axes, axis);
            assert!(longest_s > 1.0, "axis {axis} of {}: {longest_s} s", axes.len());
        }
    }
}

#[test]
fn the_same_seed_gives_the_same_runs() {
    let plan = ExcitationPlan::of_seconds(10.0);
    let once = |seed| excite(&plan, &limits(), &Axis::xyz(), &[(-50.0, 50.0); 3], PERIOD_S, seed).unwrap();
    assert_eq!(once(1), once(1));
    assert_ne!(once(1), once(2));
}

#[test]
fn settings_out_of_range_are_refused() {
    let plan = ExcitationPlan::default();
    let try_with =
        |plan: &ExcitationPlan, travel: &[(f64, f64)], period_s: f64| excite(plan, &limits(), &Axis::xyz(), travel, period_s, 1);
    assert!(matches!(try_with(&plan, &[(0.0, 1.0)], 0.002), Err(DatasetError::Runs(_))));
    assert!(matches!(try_with(&plan, &[(1.0, 0.0); 3], 0.002), Err(DatasetError::BadSetting { .. })));
    assert!(matches!(try_with(&plan, &[(0.0, 1.0); 3], f64::NAN), Err(DatasetError::BadSetting { .. })));
    assert!(matches!(try_with(&ExcitationPlan { runs: vec![] }, &[(0.0, 1.0); 3], 0.002), Err(DatasetError::Runs(_))));
    for seconds in [0.0, 1e9, f64::NAN] {
        let plan = ExcitationPlan::of_seconds(seconds);
        assert!(try_with(&plan, &[(0.0, 1.0); 3], 0.002).unwrap_err().to_string().contains("at most 400"), "{seconds}");
    }
    let mut bad = plan.clone();
    bad.runs[0].speed_share = 0.0;
    assert!(matches!(try_with(&bad, &[(0.0, 1.0); 3], 0.002), Err(DatasetError::BadSetting { .. })));
}
