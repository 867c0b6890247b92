//! Runs that follow a path in a time of their own, in the time of the path.

use motion::{DesiredPath, MotionError, Trajectory, cubic};

/// Resamples a run with path positions `path_positions` to the instants at which it passes the path's samples; standstills last as
/// long as in the run.
///
/// # Errors
/// When the axes of the run are not those of the path.
pub fn in_time_of(path: &Trajectory, run: &Trajectory, path_positions: &[f64]) -> Result<Trajectory, MotionError> {
    at_instants(path, run, &instants(path, path_positions, Stop::Passed))
}

/// The same, with all of a standstill whose place the command does not quite reach: what the axes do after their stop counts. Learning leaves it out: no
/// shift of a resting command takes it away.
///
/// # Errors
/// As [`in_time_of`].
pub fn in_time_of_standing(path: &Trajectory, run: &Trajectory, path_positions: &[f64]) -> Result<Trajectory, MotionError> {
    at_instants(path, run, &instants(path, path_positions, Stop::Stood))
}

fn at_instants(path: &Trajectory, run: &Trajectory, instants: &[f64]) -> Result<Trajectory, MotionError> {
    path.with_columns(run.columns().iter().map(|column| instants.iter().map(|at| cubic(column, *at).0).collect()).collect())
}

/// Weights of the samples of a run with path positions `path_positions`, with which every sample of the path counts once: a control that slows
/// down for a correction gives the place no more weight, and one figure compares the runs of different programs of a path. A standstill of the path
/// counts as long as the run stands still there, and no longer than in the path. Samples of the path before the first and after the last position of
/// the run count in none.
#[must_use]
pub fn weights(desired: &DesiredPath, path_positions: &[f64]) -> Vec<f64> {
    let path = desired.trajectory();
    let mut weights = vec![0.0; path_positions.len()];
    let (Some(first), Some(last)) = (path_positions.first(), path_positions.last()) else { return weights };
    let places = places(desired);
    let at_sample = |at: f64| places.get(at as usize).copied().flatten();
    let place = |at: f64| at_sample((at + NEAR).floor()).filter(|place| at_sample((at - NEAR).ceil()) == Some(*place));
    let is_one = |a: f64, b: f64| (a - b).abs() < SAME || (place(a).is_some() && place(a) == place(b));
    let within = (first.round() as usize)..=(last.round() as usize);
    let mut before = f64::NAN;
    for (sample, at) in
        instants(path, path_positions, Stop::Stood).into_iter().enumerate().filter(|(sample, _)| within.contains(sample))
    {
        let is_left = at == before && sample > 0 && path.at(sample).eq(path.at(sample - 1));
        before = at;
        if !is_left {
            // Where the run stood still, and goes on far away, it is where it stood.
            let floor = at as usize;
            let stood = floor > 0 && is_one(path_positions[floor], path_positions[floor - 1]);
            weights[if stood { floor } else { at.round() as usize }] += 1.0;
        }
    }
    // A turn about a standing tip is one place in the run, and many samples of the path.
    let mut from = 0;
    for same in path_positions.chunk_by(|a, b| is_one(*a, *b)) {
        let of_place = &mut weights[from..from + same.len()];
        let mean = of_place.iter().sum::<f64>() / same.len() as f64;
        of_place.fill(mean);
        from += same.len();
    }
    weights
}

/// Difference of path positions below which they are one, samples: of a run at a thousandth of the feed.
const SAME: f64 = 1e-3;
/// Distance from a sample up to which a position is at it, samples.
const NEAR: f64 = 0.01;
/// Way of a tip from one sample to the next below which it stands still, mm.
const STANDS_MM: f64 = 1e-6;

/// For every sample of a path at which the tip stands still the first one there.
fn places(desired: &DesiredPath) -> Vec<Option<usize>> {
    let poses = desired.poses();
    let moves = |k: usize| k >= poses.len() || k == 0 || (poses[k].tip - poses[k - 1].tip).norm() > STANDS_MM;
    let mut first = 0;
    let of = |k: usize| {
        if moves(k) {
            first = k;
        }
        (first < k || !moves(k + 1)).then_some(first)
    };
    (0..poses.len()).map(of).collect()
}

/// What a run does at a standstill of the path before whose place it stops.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stop {
    /// It passes the place when it goes on.
    Passed,
    /// It stands there.
    Stood,
}

/// Instants, in samples of the run, at which a run with path positions `path_positions` passes every sample of the path.
pub(crate) fn instants(path: &Trajectory, path_positions: &[f64], stop: Stop) -> Vec<f64> {
    let mut k = 0;
    let mut passes = |sample: usize| {
        let wanted = sample as f64;
        while k + 1 < path_positions.len() && path_positions[k + 1] < wanted {
            k += 1;
        }
        let (before, after) = (path_positions[k], path_positions.get(k + 1).copied().unwrap_or(path_positions[k]));
        let share = if after > before { ((wanted - before) / (after - before)).clamp(0.0, 1.0) } else { 0.0 };
        (k, k as f64 + share)
    };
    let samples: Vec<usize> = (0..path.len()).collect();
    let mut instants = Vec::with_capacity(samples.len());
    for standstill in samples.chunk_by(|a, b| path.at(*a).eq(path.at(*b))) {
        let ((stands, passes), last) = (passes(standstill[0]), standstill[standstill.len() - 1] as f64);
        let leaves = path_positions.partition_point(|at| *at <= last).saturating_sub(1);
        // A command that is corrected may stop before the place at which the path stops, and go on from beyond it.
        let stops_before = stop == Stop::Stood && leaves == stands && standstill.len() > 1;
        let stopped = || path_positions[..=stands].iter().rev().take_while(|at| path_positions[stands] - **at < SAME).count();
        let arrives = match stops_before.then(stopped) {
            Some(stopped) if stopped > 1 => (stands + 1 - stopped) as f64,
            _ => passes,
        };
        // The path between the two is passed at the stop.
        instants.iter_mut().rev().take_while(|at| **at > arrives).for_each(|at| *at = arrives);
        let leaves = (leaves as f64).max(arrives);
        instants.extend((0..standstill.len()).map(|waited| (arrives + waited as f64).min(leaves)));
    }
    instants
}

/// Value at a sample index with fraction, between its neighbours on a line.
pub(crate) fn linear(column: &[f64], position: f64) -> f64 {
    let before = (position as usize).min(column.len() - 1);
    let after = (before + 1).min(column.len() - 1);
    column[before] + (column[after] - column[before]) * (position - before as f64)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use motion::{Axis, Cartesian};

    use super::*;

    fn desired(path: Trajectory) -> DesiredPath {
        let kinematics = Arc::new(Cartesian::new(path.axes().to_vec()));
        DesiredPath::new(path, kinematics).unwrap()
    }

    #[test]
    fn a_run_that_stops_before_the_place_of_a_standstill_stands_there() {
        let path = |positions: &[f64]| Trajectory::new(0.002, vec![Axis::named("x")], vec![positions.to_vec()]).unwrap();
        let desired = path(&[0.0, 1.0, 2.0, 2.0, 2.0, 3.0, 4.0]);
        // It stops at 1.9 of 2, and goes on from beyond the standstill.
        let path_positions = [0.0, 1.0, 1.9, 1.9, 1.9, 5.0, 6.0];
        assert_eq!(instants(&desired, &path_positions, Stop::Stood), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        let of_path = self::desired(path(&[0.0, 1.0, 2.0, 2.0, 2.0, 3.0, 4.0]));
        assert_eq!(weights(&of_path, &path_positions).iter().sum::<f64>(), 7.0);
        // So it does from further away; instants never decrease.
        assert_eq!(instants(&desired, &[0.0, 0.5, 0.5, 0.5, 5.0, 6.0], Stop::Stood), [0.0, 1.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
        // Without a stop it passes.
        assert_eq!(instants(&desired, &[0.0, 1.0, 1.9, 5.0, 6.0], Stop::Stood)[2..5], [2.0 + 0.1 / 3.1; 3]);
    }

    #[test]
    fn a_standstill_lasts_as_long_as_in_the_run() {
        let path = |positions: &[f64]| Trajectory::new(0.002, vec![Axis::named("x")], vec![positions.to_vec()]).unwrap();
        let desired = path(&[0.0, 1.0, 2.0, 2.0, 2.0, 3.0, 4.0, 4.0, 4.0]);
        // Half as fast, with a shorter standstill in between and a longer one at the end.
        let path_positions = [0.0, 0.5, 1.0, 1.5, 2.0, 2.0, 4.5, 5.0, 5.5, 6.0, 6.0, 6.0, 6.0];
        assert_eq!(instants(&desired, &path_positions, Stop::Stood), [0.0, 2.0, 4.0, 5.0, 5.0, 7.0, 9.0, 10.0, 11.0]);
        assert_eq!(
            instants(&desired, &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0], Stop::Stood),
            [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]
        );
    }

    #[test]
    fn every_sample_of_the_path_counts_once() {
        let path = |positions: &[f64]| Trajectory::new(0.002, vec![Axis::named("x")], vec![positions.to_vec()]).unwrap();
        let desired = desired(path(&[0.0, 1.0, 2.0, 2.0, 2.0, 3.0, 4.0]));
        let of = |positions: &[f64]| weights(&desired, positions);
        assert_eq!(of(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]), [1.0; 7]);
        // Four times as slow in the first half: the path has as much weight there as elsewhere.
        let slow = of(&[0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!(slow[..8].iter().sum::<f64>(), 2.0);
        assert_eq!(slow.iter().sum::<f64>(), 7.0);
        // A run that ends early says nothing of the rest.
        assert_eq!(of(&[0.0, 1.0, 2.0]).iter().sum::<f64>(), 3.0);
        assert!(of(&[]).is_empty());
        // A standstill that the run lacks counts as one sample, and one that it holds for longer as three.
        assert_eq!(of(&[0.0, 1.0, 2.0, 5.0, 6.0]), [1.0; 5]);
        let longer = of(&[0.0, 1.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 5.0, 6.0]);
        assert!((longer[2..8].iter().sum::<f64>() - 3.0).abs() < 1e-12 && longer[2] == longer[7], "{longer:?}");
    }

    #[test]
    fn a_turn_about_a_standing_tip_counts_over_all_of_its_samples() {
        let columns = vec![vec![0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 2.0], vec![0.0, 0.0, 0.1, 0.2, 0.3, 0.4, 0.4]];
        let path = Trajectory::new(0.002, vec![Axis::named("x"), Axis::named("a")], columns).unwrap();
        // The run turns for seven samples, wherever its standing tip is found.
        let found = weights(&desired(path), &[0.0, 1.0, 1.0, 1.0, 3.0, 3.0, 3.0, 4.0, 6.0]);
        assert!(found[1..8].iter().all(|weight| (weight - 5.0 / 7.0).abs() < 1e-12), "{found:?}");
        assert_eq!((found[0], found[8]), (1.0, 1.0));
    }
}
