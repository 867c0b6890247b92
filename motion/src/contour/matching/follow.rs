//! Path position of a run with different timing: a replanned, compensated or recorded program.

use std::ops::Range;

use crate::contour::spline::hermite;
use crate::contour::turns::{Turned, nearest, turned, turns};
use crate::{DesiredPath, MotionError, Pose, Trajectory, Vec3};

/// Largest correction of a position towards the foot of the perpendicular, as a fraction of its
/// step.
const CORRECTION: f64 = 0.5;
/// A run with a larger distance follows another path, mm.
const FARTHEST_MM: f64 = 1.0;

/// Path position of every sample of `run` on `desired`, as a fractional sample index.
/// Non-decreasing.
///
/// `run` is a commanded path on or near the desired path. Each position advances by the distance
/// that the run has travelled and is corrected along the path direction. Reversing legs and
/// crossings are therefore not confused.
///
/// # Errors
/// If the run is more than 1 mm off the path, or ends before the path.
pub fn follow(run: &[Vec3], desired: &[Vec3]) -> Result<Vec<f64>, MotionError> {
    let (Some(mut before), Some(last)) = (run.first().copied(), desired.len().checked_sub(1)) else { return Ok(Vec::new()) };
    let mut position = PathPosition { desired, segment: 0, along_mm: 0.0 };
    let mut positions = Vec::with_capacity(run.len());
    for (k, point) in run.iter().enumerate() {
        let step = (point - before).norm();
        before = *point;
        position.advance(step);
        let (at, tangent) = position.point();
        let off = point - at;
        if off.norm() > FARTHEST_MM {
            return Err(MotionError::Mismatch(format!(
                "the run leaves the desired path: at its sample {k} it is {:.3} mm away from where the path has led",
                off.norm()
            )));
        }
        position.advance(off.dot(&tangent).clamp(-CORRECTION * step, CORRECTION * step));
        positions.push(position.index());
    }
    let remaining = desired[last] - position.point().0;
    if remaining.norm() > FARTHEST_MM {
        return Err(MotionError::Mismatch(format!("the run ends {:.3} mm before the desired path does", remaining.norm())));
    }
    // Corrections may step back, positions do not.
    let mut top = 0.0_f64;
    for position in &mut positions {
        top = top.max(*position);
        *position = top;
    }
    Ok(positions)
}

/// Way along the path within which a turn of the run is one of the path, mm, and how far its angles at start and end may be from those, rad.
const SAME_PLACE_MM: f64 = 0.5;
const SAME_ANGLE_RAD: f64 = 0.02;
/// Turns by less are not followed, rad.
const LEAST_TURN_RAD: f64 = 1e-3;

/// Same as [`follow`], of a command and a path in axis positions: where rotary axes turn about a tip that hardly moves, positions are found by their
/// angles.
///
/// # Errors
/// As [`follow`], and when the axes are not those of the path.
pub fn follow_axes(run: &Trajectory, desired: &DesiredPath) -> Result<Vec<f64>, MotionError> {
    let commanded = desired.tips_of(run)?;
    let path = desired.tips();
    let mut positions = follow(&commanded, &path)?;
    if !desired.kinematics().has_rotary_axes() {
        return Ok(positions);
    }
    turn(&mut positions, &turned(run, commanded), &turned(desired.trajectory(), path));
    Ok(positions)
}

/// Finds the positions of the turns of `run` in those of `desired`.
fn turn(positions: &mut [f64], run: &[Turned], desired: &[Turned]) {
    let mut there = turns(desired).into_iter().peekable();
    if there.peek().is_none() {
        return;
    }
    let mut ways_mm = vec![0.0; desired.len()];
    (1..desired.len()).for_each(|k| ways_mm[k] = ways_mm[k - 1] + (desired[k].tip - desired[k - 1].tip).norm());
    let way_mm = |position: f64| ways_mm[(position as usize).min(ways_mm.len() - 1)];
    let apart = |a: &Turned, b: &Turned| (a.angles - b.angles).norm();
    for own in turns(run) {
        let (first, last) = (&run[own.start], &run[own.end - 1]);
        if apart(first, last) < LEAST_TURN_RAD {
            continue;
        }
        let at_mm = way_mm(positions[own.start + own.len() / 2]);
        let is_same = |turn: &Range<usize>| {
            (ways_mm[turn.start] - at_mm).abs() <= SAME_PLACE_MM
                && apart(first, &desired[turn.start]) <= SAME_ANGLE_RAD
                && apart(last, &desired[turn.end - 1]) <= SAME_ANGLE_RAD
        };
        while there.peek().is_some_and(|turn| ways_mm[turn.start] < at_mm + SAME_PLACE_MM && !is_same(turn)) {
            there.next();
        }
        let Some(turn) = there.next_if(|turn| is_same(turn)) else { continue };
        for k in own.clone() {
            let guess = turn.start + (k - own.start) * turn.len() / own.len();
            if let Some(position) = nearest(desired, &turn, guess, &run[k]) {
                positions[k] = position;
            }
        }
        for k in own.start + 1..own.end {
            positions[k] = positions[k].max(positions[k - 1]);
        }
        let (begins, ends) = (positions[own.start], positions[own.end - 1]);
        positions[..own.start].iter_mut().rev().take_while(|at| **at > begins).for_each(|at| *at = begins);
        positions[own.end..].iter_mut().take_while(|at| **at < ends).for_each(|at| *at = ends);
    }
}

/// The desired path at these positions: the target of the run with the timing of the run.
#[must_use]
pub fn at_places(desired: &[Vec3], positions: &[f64]) -> Vec<Vec3> {
    positions
        .iter()
        .map(|position| {
            let segment = (position.floor() as usize).min(desired.len().saturating_sub(1));
            hermite(desired, segment, position - segment as f64).0
        })
        .collect()
}

/// Poses of a path at these positions, tip and tool axis.
#[must_use]
pub fn poses_at_places(desired: &[Pose], positions: &[f64]) -> Vec<Pose> {
    let column = |of: fn(&Pose) -> Vec3| at_places(&desired.iter().map(of).collect::<Vec<_>>(), positions);
    let tools = column(|pose| pose.tool);
    let tips = column(|pose| pose.tip);
    tips.into_iter().zip(tools).map(|(tip, tool)| Pose { tip, tool: tool.try_normalize(0.0).unwrap_or(tool) }).collect()
}

/// A position on the polyline through the samples.
struct PathPosition<'a> {
    desired: &'a [Vec3],
    segment: usize,
    /// Distance from the first sample of the segment, mm.
    along_mm: f64,
}

impl PathPosition<'_> {
    fn chord(&self, segment: usize) -> Vec3 {
        self.desired.get(segment + 1).map_or_else(Vec3::zeros, |end| end - self.desired[segment])
    }

    /// Advances by `distance_mm`, backwards if negative. Clamped to the ends.
    fn advance(&mut self, distance_mm: f64) {
        self.along_mm += distance_mm;
        while self.along_mm < 0.0 && self.segment > 0 {
            self.segment -= 1;
            self.along_mm += self.chord(self.segment).norm();
        }
        self.along_mm = self.along_mm.max(0.0);
        loop {
            let length = self.chord(self.segment).norm();
            if self.along_mm <= length {
                return;
            }
            if self.segment + 2 >= self.desired.len() {
                self.along_mm = length;
                return;
            }
            self.along_mm -= length;
            self.segment += 1;
        }
    }

    fn share(&self) -> f64 {
        let length = self.chord(self.segment).norm();
        if length > 0.0 { (self.along_mm / length).min(1.0) } else { 0.0 }
    }

    fn index(&self) -> f64 {
        self.segment as f64 + self.share()
    }

    /// The point, and the direction of the path ahead of it.
    fn point(&self) -> (Vec3, Vec3) {
        let chord = self.chord(self.segment);
        (self.desired[self.segment] + chord * self.share(), chord.try_normalize(0.0).unwrap_or_default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Along x, a corner, along y, and back on the same path, with varying speed.
    fn out_and_back(samples: usize, warp: f64) -> Vec<Vec3> {
        let point_at = |s: f64| {
            let s = if s > 20.0 { 40.0 - s } else { s };
            if s < 10.0 { Vec3::new(s, 0.0, 0.0) } else { Vec3::new(10.0, s - 10.0, 0.0) }
        };
        (0..=samples)
            .map(|k| {
                let u = k as f64 / samples as f64;
                point_at(40.0 * (u + warp * (std::f64::consts::TAU * u).sin() / std::f64::consts::TAU))
            })
            .collect()
    }

    #[test]
    fn a_run_of_another_feed_profile_is_located() {
        let desired = out_and_back(4000, 0.0);
        let run: Vec<Vec3> = out_and_back(5230, 0.6)
            .into_iter()
            .enumerate()
            .map(|(k, p)| p + Vec3::new(0.0, 0.0, 0.02 * (k as f64 * 0.01).sin()))
            .collect();
        let positions = follow(&run, &desired).unwrap();
        for ((point, nominal), position) in run.iter().zip(at_places(&desired, &positions)).zip(&positions) {
            assert!((point - nominal).norm() < 0.03, "{point} {nominal} at {position}");
        }
        assert!(positions.windows(2).all(|pair| pair[0] <= pair[1]));
        assert!(positions.last().unwrap() > &3990.0);
    }

    /// A line of 10 mm, a rest, a turn of 0.3 rad about its end within `turn` samples, a rest and a line; the tip off by up to `off_mm`.
    fn turned(turn: usize, off_mm: f64) -> Vec<Turned> {
        let ramp = |k: usize, from: usize, samples: usize| (k.saturating_sub(from) as f64 / samples as f64).min(1.0);
        let place = |k: usize| {
            let (x, y) = (10.0 * ramp(k, 0, 200), 10.0 * ramp(k, 400 + turn, 200));
            let off = off_mm * (0.05 * k as f64).sin();
            Turned { tip: Vec3::new(x + off, y, off), angles: Vec3::new(0.0, 0.3 * ramp(k, 300, turn), 0.0) }
        };
        (0..600 + turn).map(place).collect()
    }

    #[test]
    fn a_turn_about_a_standing_tip_is_followed_by_its_angles() {
        let tips = |places: &[Turned]| places.iter().map(|place| place.tip).collect::<Vec<_>>();
        let desired = turned(200, 0.0);
        for samples in [100, 200, 350] {
            let run = turned(samples, 0.002);
            let mut positions = follow(&tips(&run), &tips(&desired)).unwrap();
            turn(&mut positions, &run, &desired);
            assert!(positions.windows(2).all(|pair| pair[0] <= pair[1]));
            for (k, position) in positions.iter().enumerate().take(290 + samples).skip(310) {
                let expected = 300.0 + (k - 300) as f64 * 200.0 / samples as f64;
                assert!((position - expected).abs() < 1.0, "{samples}: {position} for {expected}");
            }
        }
    }

    #[test]
    fn another_path_and_half_a_path_are_refused() {
        let desired = out_and_back(4000, 0.0);
        let elsewhere: Vec<Vec3> = desired.iter().map(|p| p * 1.5).collect();
        assert!(follow(&elsewhere, &desired).is_err());
        assert!(follow(&desired[..1000], &desired).is_err());
    }
}
