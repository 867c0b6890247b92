//! Tool-orientation contour error (Paper C, section II-B).

use rayon::prelude::*;

use crate::contour::ContourError;
use crate::contour::spline::hermite;
use crate::contour::turns::{apart_mm, nearest, turn_at, with_rests};
use crate::{Pose, SHARE, Vec3};

/// The orientation error of one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrientationError {
    /// From the tool axis at the foot point of the tip to that of the sample. Both are unit
    /// vectors, workpiece frame.
    pub vector: Vec3,
    /// Angle between the two, rad in `[0, π]` (Paper C, eq. 4).
    pub angle_rad: f64,
}

/// Orientation errors of the poses `from`, whose tip contour errors against `to` are `errors`. Each
/// refers to the tool axis of `to` at the foot point, `O_c ∝ O_j + λ (O_{j+1} − O_j)` (Paper C, eq.
/// 3, with the sign that interpolates), here on the cubic through four tool axes.
///
/// Where `to` turns about a tip that hardly moves, the foot point of the tip says nothing of the direction: there the nearest pose of the turn
/// counts, tip and tool axis together, if it is nearer. It is sought from the sample's own instant on, so that poses of `from` and `to` belong
/// together one by one.
///
/// One per entry of `errors`. Empty if `to` is empty.
#[must_use]
pub fn orientation_errors(errors: &[ContourError], from: &[Pose], to: &[Pose]) -> Vec<OrientationError> {
    if to.is_empty() {
        return Vec::new();
    }
    let tools: Vec<Vec3> = to.iter().map(|pose| pose.tool).collect();
    let turns = with_rests(to);
    let of = |(k, (error, pose)): (usize, (&ContourError, &Pose))| {
        let segment = error.location.segment.min(tools.len() - 1);
        let foot = hermite(&tools, segment, error.location.fraction).0;
        let foot = Pose { tip: error.foot, tool: foot.try_normalize(0.0).unwrap_or(tools[segment]) };
        let [at_foot, at_instant] = [segment, k].map(|sample| turn_at(&turns, sample));
        let near = at_foot.into_iter().chain(at_instant.filter(|turn| Some(*turn) != at_foot));
        let on = |position: f64| {
            let (at, share) = (position as usize, position.fract());
            let (from, to) = (&to[at], &to[(at + 1).min(to.len() - 1)]);
            let tool = from.tool.lerp(&to.tool, share).try_normalize(0.0).unwrap_or(from.tool);
            Pose { tip: from.tip.lerp(&to.tip, share), tool }
        };
        let near = near.filter_map(|turn| nearest(to, turn, k, pose).map(on));
        let nearest =
            near.fold(foot, |best, pose_of| if apart_mm(pose, &pose_of) < apart_mm(pose, &best) { pose_of } else { best });
        OrientationError { vector: pose.tool - nearest.tool, angle_rad: pose.angle_to(&nearest) }
    };
    errors.par_iter().zip(from).enumerate().with_min_len(SHARE).map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contour::{ContourEstimator, Exact};

    /// A circle of 40 mm with the tool leaning outwards by 0.4 rad, `lag` of a sample late.
    fn cone(lag: f64, lean: f64) -> Vec<Pose> {
        (0..600)
            .map(|k| {
                let (sin, cos) = ((f64::from(k) - lag) * 2e-3).sin_cos();
                let tool = Vec3::new(lean.sin() * cos, lean.sin() * sin, lean.cos());
                Pose { tip: Vec3::new(40.0 * cos, 40.0 * sin, 0.0), tool }
            })
            .collect()
    }

    fn tips(poses: &[Pose]) -> Vec<Vec3> {
        poses.iter().map(|pose| pose.tip).collect()
    }

    /// A line, a turn of 0.3 rad about its end while the tip moves by `tip_mm`, a line; `lag` samples late, the tip off by `off_mm`.
    fn turned(tip_mm: f64, lag: f64, off_mm: f64) -> Vec<Pose> {
        let ramp = |t: f64| t.clamp(0.0, 1.0);
        let pose = |k: u32| {
            let t = f64::from(k) - lag;
            let x = 10.0 * ramp(t / 200.0) + tip_mm * ramp((t - 200.0) / 200.0);
            let (sin, cos) = (0.3 * ramp((t - 200.0) / 200.0)).sin_cos();
            Pose {
                tip: Vec3::new(x + off_mm * (0.1 * f64::from(k)).sin(), 10.0 * ramp((t - 400.0) / 200.0), off_mm),
                tool: Vec3::new(sin, 0.0, cos),
            }
        };
        (0..600).map(pose).collect()
    }

    #[test]
    fn a_late_turn_about_a_tip_that_hardly_moves_has_no_orientation_error() {
        for (tip_mm, behind_mm) in [(0.0, 0.0), (0.05, 0.0), (0.0, 0.03)] {
            let (desired, mut actual) = (turned(tip_mm, 0.0, 0.0), turned(tip_mm, 2.5, 0.005));
            actual.iter_mut().for_each(|pose| pose.tip.x -= behind_mm);
            let errors = Exact::default().estimate(&tips(&actual), &tips(&desired)).unwrap();
            let found = orientation_errors(&errors, &actual, &desired);
            let most = found.iter().map(|error| error.angle_rad).fold(0.0, f64::max);
            assert!(most < 1.5e-4, "{tip_mm} {behind_mm}: {most}");
            // However late.
            let late = turned(tip_mm, 60.0, 0.0);
            let errors = Exact::default().estimate(&tips(&late), &tips(&desired)).unwrap();
            let found = orientation_errors(&errors, &late, &desired);
            assert!(found.iter().all(|error| error.angle_rad < 1e-6), "{tip_mm}");
            // Across the turn the direction counts as before.
            let leant: Vec<Pose> =
                actual.iter().map(|pose| Pose { tool: (pose.tool + Vec3::new(0.0, 1e-3, 0.0)).normalize(), ..*pose }).collect();
            let found = orientation_errors(&errors, &leant, &desired);
            assert!(found.iter().all(|error| (error.angle_rad - 1e-3).abs() < 1e-4), "{tip_mm}");
        }
    }

    #[test]
    fn a_run_that_is_only_late_has_no_orientation_error() {
        let (desired, actual) = (cone(0.0, 0.4), cone(3.7, 0.4));
        let errors = Exact::default().estimate(&tips(&desired), &tips(&actual)).unwrap();
        let found = orientation_errors(&errors, &desired, &actual);
        let worst = found[10..590].iter().fold(0.0_f64, |worst, error| worst.max(error.angle_rad));
        assert!(worst < 1e-9, "{worst:e}");
    }

    #[test]
    fn a_steeper_tool_is_off_by_its_angle_and_points_back() {
        let (desired, actual) = (cone(0.0, 0.4), cone(2.2, 0.4003));
        let errors = Exact::default().estimate(&tips(&desired), &tips(&actual)).unwrap();
        for (error, pose) in orientation_errors(&errors, &desired, &actual).iter().zip(&desired).skip(10).take(580) {
            assert!((error.angle_rad - 3e-4).abs() < 1e-10, "{:e}", error.angle_rad);
            assert!((error.vector.norm() - 3e-4).abs() < 1e-9);
            // The actual tool leans further out, so the correction points inwards.
            assert!(error.vector.dot(&Vec3::new(pose.tip.x, pose.tip.y, 0.0)) < 0.0);
        }
        assert!(orientation_errors(&errors, &desired, &[]).is_empty());
    }
}
