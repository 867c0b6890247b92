//! Path position of a run with different timing: a replanned, compensated or recorded program.

use std::f64::consts::TAU;
use std::ops::Range;

use crate::contour::spline::hermite;
use crate::contour::turns::{LEVER_MM, Turned, turned, turns};
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
/// How far ahead of its position a turn is sought, as a multiple of what the run has turned since.
const AHEAD: f64 = 2.0;
/// Way of the tip between two turns up to which they are at one place, mm: corrections move it by less.
const ONE_PLACE_MM: f64 = 0.2;

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

/// Finds the positions of the turns of `run` in those of `desired`: the way of the angles is followed there as that of tips elsewhere.
fn turn(positions: &mut [f64], run: &[Turned], desired: &[Turned]) {
    let mut there = places(desired).into_iter().peekable();
    if there.peek().is_none() {
        return;
    }
    let mut ways_mm = vec![0.0; desired.len()];
    (1..desired.len()).for_each(|k| ways_mm[k] = ways_mm[k - 1] + (desired[k].tip - desired[k - 1].tip).norm());
    let way_mm = |position: f64| ways_mm[(position as usize).min(ways_mm.len() - 1)];
    for own in places(run) {
        let turned_rad: f64 = run[own.clone()].windows(2).map(|pair| (pair[1].angles - pair[0].angles).norm()).sum();
        if turned_rad < LEAST_TURN_RAD {
            continue;
        }
        let (first, last) = (&run[own.start], &run[own.end - 1]);
        let at_mm = way_mm(positions[own.start + own.len() / 2]);
        // A control may count whole turns of an axis otherwise.
        let turns_of = |turn: &Range<usize>| (first.angles - desired[turn.start].angles).map(|angle| (angle / TAU).round() * TAU);
        let is_same = |turn: &Range<usize>| {
            let turns = turns_of(turn);
            let apart = |a: &Turned, b: &Turned| (a.angles - turns - b.angles).norm();
            (ways_mm[turn.start] - at_mm).abs() <= SAME_PLACE_MM
                && apart(first, &desired[turn.start]) <= SAME_ANGLE_RAD
                && apart(last, &desired[turn.end - 1]) <= SAME_ANGLE_RAD
        };
        while there.peek().is_some_and(|turn| ways_mm[turn.start] < at_mm + SAME_PLACE_MM && !is_same(turn)) {
            there.next();
        }
        let Some(turn) = there.next_if(|turn| is_same(turn)) else { continue };
        let turns = turns_of(&turn);
        let on_lever = |places: &[Turned], less: Vec3| -> Vec<Vec3> {
            places.iter().map(|place| (place.angles - less) * LEVER_MM).collect()
        };
        let found = follow_turn(&on_lever(&run[own.clone()], turns), &on_lever(&desired[turn.clone()], Vec3::zeros()));
        // Another turn than that of the path keeps the positions of its tip.
        let Some(found) = found else { continue };
        positions[own.clone()].iter_mut().zip(found).for_each(|(position, found)| *position = turn.start as f64 + found);
        let (begins, ends) = (positions[own.start], positions[own.end - 1]);
        positions[..own.start].iter_mut().rev().take_while(|at| **at > begins).for_each(|at| *at = begins);
        positions[own.end..].iter_mut().take_while(|at| **at < ends).for_each(|at| *at = ends);
    }
}

/// Path position of every sample of a turn, angles at a lever, mm: the nearest one ahead, as far as the run has turned since the last. A run that turns beyond
/// the end of a leg and comes back waits there, and one that does not reach it goes on with the next leg. `None` where the run does not reach the end.
fn follow_turn(run: &[Vec3], path: &[Vec3]) -> Option<Vec<f64>> {
    let mut positions = Vec::with_capacity(run.len());
    let (mut at, mut reach_mm, mut before) = (0.0_f64, 0.0, run.first()?);
    for place in run {
        let step_mm = (place - before).norm();
        before = place;
        reach_mm += AHEAD * step_mm;
        let (mut best, mut passed_mm) = ((at, f64::INFINITY, 0.0), 0.0);
        let mut segment = at as usize;
        let mut share = at - segment as f64;
        while segment + 1 < path.len() && passed_mm <= reach_mm {
            let chord = path[segment + 1] - path[segment];
            let length = chord.norm();
            let last = if length > 0.0 { (share + (reach_mm - passed_mm) / length).min(1.0) } else { 1.0 };
            let nearest =
                if length > 0.0 { ((place - path[segment]).dot(&chord) / (length * length)).clamp(share, last) } else { share };
            let apart = (path[segment] + chord * nearest - place).norm();
            if apart < best.1 {
                best = (segment as f64 + nearest, apart, passed_mm + (nearest - share) * length);
            }
            passed_mm += (1.0 - share) * length;
            (segment, share) = (segment + 1, 0.0);
        }
        if best.1.is_finite() {
            at = best.0;
        }
        if best.2 >= 0.5 * step_mm {
            reach_mm = 0.0;
        }
        positions.push(at);
    }
    let end = path.last()?;
    let (segment, share) = (at as usize, at.fract());
    let reached = path[segment].lerp(&path[(segment + 1).min(path.len() - 1)], share);
    ((reached - end).norm() <= FARTHEST_MM).then_some(positions)
}

/// The turns of a path, those at one place together: a run may rest between them where the path does not.
fn places(path: &[Turned]) -> Vec<Range<usize>> {
    let mut places: Vec<Range<usize>> = Vec::new();
    for turn in turns(path) {
        let is_near = |last: &Range<usize>| {
            let between = &path[last.end - 1..=turn.start.max(last.end - 1)];
            between.windows(2).map(|pair| (pair[1].tip - pair[0].tip).norm()).sum::<f64>() <= ONE_PLACE_MM
        };
        match places.last_mut() {
            Some(last) if is_near(last) => last.end = turn.end,
            _ => places.push(turn),
        }
    }
    places
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

/// The same for contour errors: with the corners and cusps of the path that a command does not reach, so that its positions leap over them. There the nearest
/// of the samples takes the place of the corner.
#[must_use]
pub fn at_places_and_corners(desired: &[Vec3], positions: &[f64]) -> Vec<Vec3> {
    let mut points = at_places(desired, positions);
    let mut last_taken = None;
    for (k, pair) in positions.windows(2).enumerate() {
        let (from, to) = (pair[0], pair[1]);
        let skipped = (from.floor() as usize + 1)..(to.ceil() as usize).min(desired.len());
        let (start, end) = (points[k], points[k + 1]);
        let turns = |at: &usize| (desired[*at] - start).dot(&(end - desired[*at])) <= 0.0;
        let far = |at: &usize| (desired[*at] - start).norm() + (end - desired[*at]).norm();
        let is_corner = |at: &usize| turns(at) && (LEAST_CORNER_MM..MOST_CORNER_MM).contains(&far(at));
        let Some(corner) = skipped.filter(is_corner).max_by(|a, b| far(a).total_cmp(&far(b))) else { continue };
        let is_first = (desired[corner] - start).norm() < (end - desired[corner]).norm();
        let taken = if is_first && last_taken != Some(k) { k } else { k + 1 };
        points[taken] = desired[corner];
        last_taken = Some(taken);
    }
    points
}

/// Way to a corner and back below which it is not one, and above which it is no correction that leaves it out, mm.
const LEAST_CORNER_MM: f64 = 1e-4;
const MOST_CORNER_MM: f64 = 0.5;

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
    fn a_cusp_that_the_command_does_not_reach_stays_on_the_path() {
        // To the cusp and back beside it; the command turns 8 µm before.
        let path = |k: u32| {
            Vec3::new(if k > 100 { 1e-3 * f64::from(k - 100) } else { 0.0 }, 0.02 * (100.0 - (f64::from(k) - 100.0).abs()), 0.0)
        };
        let desired: Vec<Vec3> = (0..=200).map(path).collect();
        let positions: Vec<f64> =
            (0..=200).map(f64::from).filter(|at| (at - 100.0).abs() > 0.4).map(|at| at + 0.3 * f64::from(at < 100.0)).collect();
        let plain = at_places(&desired, &positions);
        let points = at_places_and_corners(&desired, &positions);
        let highest = |points: &[Vec3]| points.iter().map(|point| point.y).fold(0.0, f64::max);
        assert!(highest(&plain) < 1.999 && highest(&points) == 2.0, "{} {}", highest(&plain), highest(&points));
        assert_eq!(points.iter().zip(&plain).filter(|(one, other)| one != other).count(), 1);
        // What reaches it stays as it is.
        let all: Vec<f64> = (0..=200).map(f64::from).collect();
        assert_eq!(at_places_and_corners(&desired, &all), at_places(&desired, &all));
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

    /// A line of 10 mm, a rest, legs of turns to these angles about its end within `turn` samples each, a rest and a line; the tip off by up to `off_mm`.
    fn turned_to(legs: &[f64], turn: usize, rest: usize, off_mm: f64) -> Vec<Turned> {
        let ramp = |k: usize, from: usize, samples: usize| (k.saturating_sub(from) as f64 / samples as f64).min(1.0);
        let ends = 300 + legs.len() * (turn + rest);
        let place = |k: usize| {
            let (x, y) = (10.0 * ramp(k, 0, 200), 10.0 * ramp(k, ends + 100, 200));
            let off = off_mm * (0.05 * k as f64).sin();
            let starts = std::iter::once(&0.0).chain(legs);
            let steps = legs.iter().zip(starts).enumerate();
            let angle = steps.map(|(leg, (to, from))| (to - from) * ramp(k, 300 + leg * (turn + rest), turn)).sum::<f64>();
            Turned { tip: Vec3::new(x + off, y, off), angles: Vec3::new(0.0, angle, 0.0) }
        };
        (0..ends + 300).map(place).collect()
    }

    #[test]
    fn turns_about_a_standing_tip_are_followed_by_their_angles() {
        let tips = |places: &[Turned]| places.iter().map(|place| place.tip).collect::<Vec<_>>();
        // Forward; there and back; several legs with and without an end elsewhere.
        for legs in [&[0.3][..], &[-0.3, 0.0], &[-0.3, 0.0, -0.3], &[0.2, -0.4, 0.1, 0.0]] {
            for (rest, whole_turns) in [(0, 0.0), (40, 0.0), (0, TAU), (40, -TAU)] {
                let desired = turned_to(legs, 200, rest, 0.0);
                for samples in [100, 200, 350] {
                    let mut run = turned_to(legs, samples, rest, 0.002);
                    run.iter_mut().for_each(|place| place.angles.y += whole_turns);
                    let mut positions = follow(&tips(&run), &tips(&desired)).unwrap();
                    turn(&mut positions, &run, &desired);
                    assert!(positions.windows(2).all(|pair| pair[0] <= pair[1]));
                    for leg in 0..legs.len() {
                        let begins = 300 + leg * (samples + rest);
                        for (k, position) in positions.iter().enumerate().take(begins + samples - 10).skip(begins + 10) {
                            let expected = (300 + leg * (200 + rest)) as f64 + (k - begins) as f64 * 200.0 / samples as f64;
                            let off = (position - expected).abs();
                            assert!(off < 2.0, "{legs:?} {rest} {samples}: {position} for {expected}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn a_turn_that_goes_beyond_its_end_or_not_so_far_is_followed() {
        // Out by 0.3 rad and back, at a lever; the run turns at 0.302 or 0.299 rad.
        let path: Vec<Vec3> =
            (0..=400).map(|k| Vec3::new(20.0 * 0.3 * (1.0 - (f64::from(k) / 200.0 - 1.0).abs()), 0.0, 0.0)).collect();
        for end in [0.302, 0.299] {
            let run: Vec<Vec3> =
                (0..=600).map(|k| Vec3::new(20.0 * end * (1.0 - (f64::from(k) / 300.0 - 1.0).abs()), 0.0, 0.0)).collect();
            let positions = follow_turn(&run, &path).unwrap();
            assert!(positions.windows(2).all(|pair| pair[0] <= pair[1]));
            for (k, position) in positions.iter().enumerate() {
                let there = path[position.round() as usize];
                assert!((there - run[k]).norm() < 20.0 * 0.003, "{end} {k}: {position}");
                assert!((*position > 205.0) == (k > 308) || (290..330).contains(&k), "{end} {k}: {position}");
            }
        }
        assert!(follow_turn(&path[..250], &path).is_none());
    }

    #[test]
    fn another_path_and_half_a_path_are_refused() {
        let desired = out_and_back(4000, 0.0);
        let elsewhere: Vec<Vec3> = desired.iter().map(|p| p * 1.5).collect();
        assert!(follow(&elsewhere, &desired).is_err());
        assert!(follow(&desired[..1000], &desired).is_err());
    }
}
