//! The staged predictor on a real UR5 arm at 125 Hz (Apache-2.0, kkufieta/ur5_modeling_force_estimate), moves left out in turn.

mod staged_common;

use staged_common::{residual, rms, run_of, shared_log};
use training::staged::{AxisRun, StagedRecipe, fit};

const PERIOD_S: f64 = 0.008;
/// Rows, 300 ms, at the start of a move that begins in motion.
const UNSCORED: usize = 38;
/// Number of segments of the log that are left out in turn.
const GROUPS: usize = 3;

/// First and last row of each move. Rows in which every command repeats, or every joint equals its
/// command, are standstills.
fn moves(rows: &[Vec<f64>]) -> Vec<std::ops::Range<usize>> {
    let resting = |k: usize| {
        (0..6).all(|joint| rows[k][1 + 2 * joint] == rows[k - 1][1 + 2 * joint])
            || (0..6).all(|joint| rows[k][1 + 2 * joint] == rows[k][2 + 2 * joint])
    };
    let mut moves = Vec::new();
    let mut start = 1;
    while let Some(first) = (start..rows.len()).find(|&k| !resting(k)) {
        let end = (first..rows.len()).find(|&k| (k..rows.len().min(k + 12)).all(resting)).unwrap_or(rows.len());
        if end - first > 100 {
            moves.push(first..end);
        }
        start = end;
    }
    moves
}

/// Held-out RMS of the prediction residual and of the raw error, millidegrees.
fn held_out(rows: &[Vec<f64>], joint: usize) -> (f64, f64) {
    let runs: Vec<AxisRun> =
        moves(rows).into_iter().map(|range| run_of(&rows[range], 2 * joint - 1, 2 * joint, PERIOD_S)).collect();
    let mut left = Vec::new();
    let mut raw = Vec::new();
    for group in 0..GROUPS {
        let (out, kept): (Vec<_>, Vec<_>) = runs.iter().enumerate().partition(|(index, _)| index * GROUPS / runs.len() == group);
        let kept: Vec<AxisRun> = kept.into_iter().map(|(_, run)| run.clone()).collect();
        let (predictor, report) = fit(&kept, &StagedRecipe::default()).unwrap();
        println!("joint {joint}, group {group}: {}", report.chosen);
        for (index, run) in out {
            // A move that begins in motion lacks the commands before it.
            let moving = (run.reference[1] - run.reference[0]).abs() > 1e-3;
            let unscored = if moving { UNSCORED } else { 0 };
            left.extend(residual(&predictor, run).into_iter().skip(unscored));
            println!("  move {index}: {:.2}", 1e3 * rms(residual(&predictor, run).into_iter().skip(unscored)));
            let errors = run.reference.iter().zip(&run.actual).map(|(r, x)| r - x);
            raw.extend(errors.skip(unscored));
        }
    }
    (1e3 * rms(left), 1e3 * rms(raw))
}

#[test]
fn joints_are_predicted_on_moves_left_out() {
    let Some(rows) = shared_log("ur5_no6_125Hz.csv") else { return };
    for (joint, bound) in [(2, 6.0), (3, 6.5), (4, 12.0), (5, 8.0)] {
        let (left, raw) = held_out(&rows, joint);
        println!("joint {joint}: {left:.2} of {raw:.2} millidegrees");
        assert!(left <= bound && left < raw, "joint {joint}: {left} of {raw}");
    }
}

#[test]
fn joints_with_command_jumps_are_not_made_worse() {
    let Some(rows) = shared_log("ur5_no6_125Hz.csv") else { return };
    for joint in [1, 6] {
        let (left, raw) = held_out(&rows, joint);
        println!("joint {joint}: {left:.2} of {raw:.2} millidegrees");
        assert!(left <= raw, "joint {joint}: {left} of {raw}");
    }
}
