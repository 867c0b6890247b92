//! Where on the desired path a run is that does not keep its time: a re-planned, compensated or recorded program.

use crate::contour::spline::hermite;
use crate::{MotionError, Pose, Vec3};

/// Share of its own step by which a place is corrected towards the foot of the perpendicular, at most.
const CORRECTION: f64 = 0.5;
/// A run further off than this follows another path, mm.
const FARTHEST_MM: f64 = 1.0;

/// For every sample of `run` its place on `desired`, as a sample index with fraction; never decreasing.
///
/// `run` is what was commanded, on or near the desired path. Each place advances by the way that the run has gone and is corrected along the
/// path's direction, so that neither a leg that turns back on itself nor a crossing is mistaken for another.
///
/// # Errors
/// When the run leaves the path by more than 1 mm, or ends before the path does.
pub fn follow(run: &[Vec3], desired: &[Vec3]) -> Result<Vec<f64>, MotionError> {
    let (Some(mut before), Some(last)) = (run.first().copied(), desired.len().checked_sub(1)) else { return Ok(Vec::new()) };
    let mut place = Place { desired, segment: 0, along_mm: 0.0 };
    let mut places = Vec::with_capacity(run.len());
    for (k, point) in run.iter().enumerate() {
        let step = (point - before).norm();
        before = *point;
        place.advance(step);
        let (at, tangent) = place.point();
        let off = point - at;
        if off.norm() > FARTHEST_MM {
            return Err(MotionError::Mismatch(format!(
                "the run leaves the desired path: at its sample {k} it is {:.3} mm away from where the path has led",
                off.norm()
            )));
        }
        place.advance(off.dot(&tangent).clamp(-CORRECTION * step, CORRECTION * step));
        places.push(place.index());
    }
    let rest = desired[last] - place.point().0;
    if rest.norm() > FARTHEST_MM {
        return Err(MotionError::Mismatch(format!("the run ends {:.3} mm before the desired path does", rest.norm())));
    }
    // Corrections go back a little at times; places do not.
    let mut top = 0.0_f64;
    for place in &mut places {
        top = top.max(*place);
        *place = top;
    }
    Ok(places)
}

/// The desired path at these places: what the run should have been, at its own time.
#[must_use]
pub fn at_places(desired: &[Vec3], places: &[f64]) -> Vec<Vec3> {
    places
        .iter()
        .map(|place| {
            let segment = (place.floor() as usize).min(desired.len().saturating_sub(1));
            hermite(desired, segment, place - segment as f64).0
        })
        .collect()
}

/// The poses of a path at these places, tip and tool axis alike.
#[must_use]
pub fn poses_at_places(desired: &[Pose], places: &[f64]) -> Vec<Pose> {
    let column = |of: fn(&Pose) -> Vec3| at_places(&desired.iter().map(of).collect::<Vec<_>>(), places);
    let tools = column(|pose| pose.tool);
    let tips = column(|pose| pose.tip);
    tips.into_iter().zip(tools).map(|(tip, tool)| Pose { tip, tool: tool.try_normalize(0.0).unwrap_or(tool) }).collect()
}

/// A place on the polyline of the samples.
struct Place<'a> {
    desired: &'a [Vec3],
    segment: usize,
    /// Way from the segment's first sample, mm.
    along_mm: f64,
}

impl Place<'_> {
    fn chord(&self, segment: usize) -> Vec3 {
        self.desired.get(segment + 1).map_or_else(Vec3::zeros, |end| end - self.desired[segment])
    }

    /// Goes on by `way_mm`, backwards where it is negative; stays at the ends.
    fn advance(&mut self, way_mm: f64) {
        self.along_mm += way_mm;
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

    /// The place, and the direction in which the path leads on.
    fn point(&self) -> (Vec3, Vec3) {
        let chord = self.chord(self.segment);
        (self.desired[self.segment] + chord * self.share(), chord.try_normalize(0.0).unwrap_or_default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Out along x, a corner, along y, and all the way back, at varying speed.
    fn out_and_back(samples: usize, warp: f64) -> Vec<Vec3> {
        let way = |s: f64| {
            let s = if s > 20.0 { 40.0 - s } else { s };
            if s < 10.0 { Vec3::new(s, 0.0, 0.0) } else { Vec3::new(10.0, s - 10.0, 0.0) }
        };
        (0..=samples)
            .map(|k| {
                let u = k as f64 / samples as f64;
                way(40.0 * (u + warp * (std::f64::consts::TAU * u).sin() / std::f64::consts::TAU))
            })
            .collect()
    }

    #[test]
    fn a_run_of_another_time_law_is_found_again() {
        let desired = out_and_back(4000, 0.0);
        let run: Vec<Vec3> = out_and_back(5230, 0.6)
            .into_iter()
            .enumerate()
            .map(|(k, p)| p + Vec3::new(0.0, 0.0, 0.02 * (k as f64 * 0.01).sin()))
            .collect();
        let places = follow(&run, &desired).unwrap();
        for ((point, nominal), place) in run.iter().zip(at_places(&desired, &places)).zip(&places) {
            assert!((point - nominal).norm() < 0.03, "{point} {nominal} at {place}");
        }
        assert!(places.windows(2).all(|pair| pair[0] <= pair[1]));
        assert!(places.last().unwrap() > &3990.0);
    }

    #[test]
    fn another_path_and_half_a_path_are_refused() {
        let desired = out_and_back(4000, 0.0);
        let elsewhere: Vec<Vec3> = desired.iter().map(|p| p * 1.5).collect();
        assert!(follow(&elsewhere, &desired).is_err());
        assert!(follow(&desired[..1000], &desired).is_err());
    }
}
