//! What the desired motion does at a sample: the usual causes of an error there.

use std::fmt;

use motion::{AxisKind, DesiredPath, Vec3};

use crate::measure::reversal_samples;

/// Time before a sample in which a corner or start counts as its cause, s: a slow position loop settles within.
const BEFORE_S: f64 = 0.1;
/// The same of a reversal, s: the window in which `measure` looks for its glitch.
const REVERSAL_S: f64 = 0.06;
/// Time after a sample in which an event counts as its cause, s: corrections act ahead of the event.
const AFTER_S: f64 = 0.02;
/// Length of path on either side of a corner over which its angle is measured, mm.
const CORNER_SPAN_MM: f64 = 0.1;
/// Least angle of a corner, degrees, and largest radius on which a turn still counts as a corner, mm.
const CORNER_DEG: f64 = 15.0;
const CORNER_RADIUS_MM: f64 = 1.0;
/// Radius above which a path counts as straight, mm.
const STRAIGHT_MM: f64 = 2000.0;
/// Speed below which the tool stands still, mm/s.
const STILL_MM_S: f64 = 0.05;

/// What the motion does at a sample.
#[derive(Debug, Clone, PartialEq)]
pub enum MotionAt {
    /// An axis reverses nearby in time.
    Reversal {
        /// Name of the axis.
        axis: String,
        /// Time from the reversal to the sample, s; negative before it.
        after_s: f64,
    },
    /// The path turns sharply.
    Corner {
        /// Change of direction, degrees.
        angle_deg: f64,
        /// Time from the corner to the sample, s; negative before it.
        after_s: f64,
    },
    /// The tool starts from a standstill.
    Start {
        /// Time from the start to the sample, s.
        after_s: f64,
    },
    /// The tool stands still.
    Standstill,
    /// Motion on a curve.
    Curve {
        /// Radius, mm.
        radius_mm: f64,
        /// Speed of the tip, mm/s.
        speed_mm_s: f64,
        /// Unit vector to the centre of the curve.
        inward: Vec3,
    },
    /// Motion on a straight line.
    Straight {
        /// Speed of the tip, mm/s.
        speed_mm_s: f64,
    },
}

impl fmt::Display for MotionAt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let when = |after_s: f64| {
            let ms = (after_s * 1e3).round();
            if ms < 0.0 { format!("{:.0} ms before", -ms) } else { format!("{ms:.0} ms after") }
        };
        match self {
            Self::Reversal { axis, after_s } => write!(f, "{} axis {axis} reverses", when(*after_s)),
            Self::Corner { angle_deg, after_s } => write!(f, "{} a corner of {angle_deg:.0}°", when(*after_s)),
            Self::Start { after_s } => write!(f, "{:.0} ms after the start from a standstill", after_s * 1e3),
            Self::Standstill => f.write_str("at standstill"),
            Self::Curve { radius_mm, speed_mm_s, .. } => {
                let digits = usize::from(*radius_mm < 10.0);
                write!(f, "on a curve of radius {radius_mm:.digits$} mm at {speed_mm_s:.0} mm/s")
            }
            Self::Straight { speed_mm_s } => write!(f, "on a straight line at {speed_mm_s:.0} mm/s"),
        }
    }
}

/// What the motion does at sample `k` of `path`. Of the events nearby in time the nearest counts; a corner goes before the reversals that it
/// brings about.
#[must_use]
pub fn motion_at(path: &DesiredPath, k: usize) -> MotionAt {
    let period = path.trajectory().period_s();
    let poses = path.poses();
    if poses.is_empty() {
        return MotionAt::Standstill;
    }
    let k = k.min(poses.len() - 1);
    let samples = |time_s: f64| (time_s / period).round() as usize;
    let near = k.saturating_sub(samples(BEFORE_S))..(k + samples(AFTER_S) + 1).min(poses.len());
    let after_s = |event: usize| (k as f64 - event as f64) * period;
    if let Some((at, angle_deg)) = nearest_corner(path, &near, k) {
        return MotionAt::Corner { angle_deg, after_s: after_s(at) };
    }
    let reversing = k.saturating_sub(samples(REVERSAL_S))..near.end;
    let reversal = reversals_in(path, &reversing).min_by_key(|(at, _)| at.abs_diff(k));
    if let Some((at, axis)) = reversal {
        return MotionAt::Reversal { axis, after_s: after_s(at) };
    }
    let speed = |at: usize| speed_mm_s(path, at);
    if speed(k) < STILL_MM_S {
        return MotionAt::Standstill;
    }
    if let Some(rest) = (near.start..k).rev().find(|at| speed(*at) < STILL_MM_S) {
        return MotionAt::Start { after_s: after_s(rest) };
    }
    match curvature(path, k) {
        Some((radius_mm, inward)) if radius_mm < STRAIGHT_MM => MotionAt::Curve { radius_mm, speed_mm_s: speed(k), inward },
        _ => MotionAt::Straight { speed_mm_s: speed(k) },
    }
}

/// Reversals of all axes within `near`: sample and axis.
fn reversals_in<'a>(path: &'a DesiredPath, near: &'a std::ops::Range<usize>) -> impl Iterator<Item = (usize, String)> + 'a {
    let trajectory = path.trajectory();
    // An axis that reverses has moved before: a second of the motion shows it.
    let before = near.start.saturating_sub((1.0 / trajectory.period_s()) as usize);
    trajectory.axes().iter().zip(trajectory.columns()).flat_map(move |(axis, column)| {
        let found = reversal_samples(&column[before..near.end], trajectory.period_s());
        let at = found.into_iter().map(move |(sample, _)| sample + before).filter(|at| *at >= near.start);
        let name = if axis.kind == AxisKind::Rotary { format!("{} (rotary)", axis.name) } else { axis.name.clone() };
        at.map(move |at| (at, name.clone())).collect::<Vec<_>>()
    })
}

fn speed_mm_s(path: &DesiredPath, at: usize) -> f64 {
    let poses = path.poses();
    let (from, to) = (at.saturating_sub(1), (at + 1).min(poses.len() - 1));
    (poses[to].tip - poses[from].tip).norm() / ((to - from).max(1) as f64 * path.trajectory().period_s())
}

/// The first point before and the first point behind a sample that lie at least `span_mm` away from it.
fn around(path: &DesiredPath, at: usize, span_mm: f64) -> Option<[Vec3; 3]> {
    let poses = path.poses();
    let here = poses[at].tip;
    let far = |pose: &&motion::Pose| (pose.tip - here).norm() >= span_mm;
    let before = poses[..at].iter().rev().find(far)?.tip;
    let behind = poses[at..].iter().find(far)?.tip;
    Some([before, here, behind])
}

/// Of the corners within `near` the one nearest to sample `k`, with its angle, degrees. Small ones beside a large one do not count.
fn nearest_corner(path: &DesiredPath, near: &std::ops::Range<usize>, k: usize) -> Option<(usize, f64)> {
    let angles: Vec<(usize, f64)> = near.clone().filter_map(|at| Some((at, corner_deg(path, at)?))).collect();
    // Around a corner several samples show some of its angle.
    let corners = angles.chunk_by(|a, b| a.0 + 1 == b.0).filter_map(|chunk| chunk.iter().max_by(|a, b| a.1.total_cmp(&b.1)));
    let corners: Vec<(usize, f64)> = corners.copied().collect();
    let largest = corners.iter().map(|(_, angle)| *angle).fold(0.0, f64::max);
    corners.into_iter().filter(|(_, angle)| *angle >= 0.5 * largest).min_by_key(|(at, _)| at.abs_diff(k))
}

/// Angle of a corner at a sample, degrees; `None` where there is none.
fn corner_deg(path: &DesiredPath, at: usize) -> Option<f64> {
    let [before, here, behind] = around(path, at, CORNER_SPAN_MM)?;
    let (one, other) = (here - before, behind - here);
    let angle = one.cross(&other).norm().atan2(one.dot(&other));
    let radius_mm = 0.5 * (one.norm() + other.norm()) / angle.max(1e-12);
    (angle.to_degrees() > CORNER_DEG && radius_mm < CORNER_RADIUS_MM).then_some(angle.to_degrees())
}

/// Radius of the circle through a sample and its neighbours half a millimetre away, mm, and the direction to its centre.
fn curvature(path: &DesiredPath, at: usize) -> Option<(f64, Vec3)> {
    let [before, here, behind] = around(path, at, 0.5)?;
    let (a, b, c) = ((here - before).norm(), (behind - here).norm(), (behind - before).norm());
    let twice_area = (here - before).cross(&(behind - here)).norm();
    let inward = (0.5 * (before + behind) - here).try_normalize(0.0)?;
    (twice_area > 0.0).then(|| (a * b * c / (2.0 * twice_area), inward))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use motion::{Axis, Cartesian, Trajectory};

    use super::*;

    const PERIOD_S: f64 = 0.002;

    fn path(of: impl Fn(f64) -> (f64, f64)) -> DesiredPath {
        let axes = vec![Axis::named("x"), Axis::named("y")];
        let points: Vec<(f64, f64)> = (0..1000).map(|k| of(f64::from(k) * PERIOD_S)).collect();
        let columns = vec![points.iter().map(|p| p.0).collect(), points.iter().map(|p| p.1).collect()];
        let trajectory = Trajectory::new(PERIOD_S, axes.clone(), columns).unwrap();
        DesiredPath::new(trajectory, Arc::new(Cartesian::new(axes))).unwrap()
    }

    #[test]
    fn circles_show_reversals_and_between_them_their_radius() {
        // Once around in 2 s: x reverses at 0 and 1 s, y at 0.5 and 1.5 s.
        let circle = path(|t| (20.0 * (std::f64::consts::PI * t).cos(), 20.0 * (std::f64::consts::PI * t).sin()));
        let MotionAt::Reversal { axis, after_s } = motion_at(&circle, 260) else { panic!("{:?}", motion_at(&circle, 260)) };
        assert!(axis == "y" && (after_s - 0.02).abs() < 0.003, "{axis} {after_s}");
        let MotionAt::Curve { radius_mm, speed_mm_s, inward } = motion_at(&circle, 375) else { panic!() };
        assert!((radius_mm - 20.0).abs() < 0.1 && (speed_mm_s - 62.8).abs() < 0.1);
        let outward = circle.poses()[375].tip.normalize();
        assert!((inward + outward).norm() < 0.02, "{inward} {outward}");
    }

    #[test]
    fn corners_starts_and_lines() {
        // 40 mm along x from 0.2 s on, then along y.
        let bent = path(|t| {
            let s = 50.0 * (t - 0.2).max(0.0);
            (s.min(40.0), (s - 40.0).max(0.0))
        });
        assert!(matches!(motion_at(&bent, 20), MotionAt::Standstill));
        assert!(matches!(motion_at(&bent, 110), MotionAt::Start { after_s } if (after_s - 0.02).abs() < 0.005));
        assert!(matches!(motion_at(&bent, 300), MotionAt::Straight { speed_mm_s } if (speed_mm_s - 50.0).abs() < 0.1));
        let corner = motion_at(&bent, 510);
        assert!(matches!(corner, MotionAt::Corner { angle_deg, .. } if (angle_deg - 90.0).abs() < 1.0), "{corner:?}");
        assert_eq!(corner.to_string(), "20 ms after a corner of 90°");
    }
}
