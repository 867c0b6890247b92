//! Circular test results after ISO 230-4.

use std::f64::consts::{PI, TAU};

use nalgebra::{Matrix3, Vector2, Vector3};

use crate::{MotionError, Vec3};

/// Change of angle that distinguishes a reversal from noise, rad.
const TURN_RAD: f64 = 0.1;
/// Angle that may be missing from a full circle, rad.
const GAP_RAD: f64 = 0.1;
/// Points farther from the circle than this multiple of the spread, and at least this distance in
/// mm, are lead-in or lead-out.
const FAR: (f64, f64) = (4.0, 0.02);

/// A point of the path with the path length that it represents, mm. Standstill has no weight.
type Weighted = (Vector2<f64>, f64);

/// Plane of the circle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum CirclePlane {
    /// `x` to `y` is counterclockwise.
    #[default]
    Xy,
    /// `y` to `z` is counterclockwise.
    Yz,
    /// `z` to `x` is counterclockwise.
    Zx,
}

impl CirclePlane {
    fn project(self, point: &Vec3) -> Vector2<f64> {
        match self {
            Self::Xy => Vector2::new(point.x, point.y),
            Self::Yz => Vector2::new(point.y, point.z),
            Self::Zx => Vector2::new(point.z, point.x),
        }
    }
}

/// The programmed circle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NominalCircle {
    /// Centre in the two plane coordinates, mm. `None`: radial deviations refer to the
    /// least-squares centre.
    pub centre: Option<[f64; 2]>,
    /// Radius, mm.
    pub radius_mm: f64,
}

/// Results for one direction of travel, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DirectionFigures {
    /// Circular deviation `G`: range of the radius about this direction's least-squares centre.
    pub circular_deviation_mm: f64,
    /// Largest radial deviation `F_max` from the nominal circle, positive away from the centre.
    pub radial_max_mm: f64,
    /// Smallest radial deviation `F_min` from the nominal circle.
    pub radial_min_mm: f64,
    /// Mean radial deviation from the nominal circle, weighted by path length.
    pub radial_mean_mm: f64,
    /// Least-squares centre in the two plane coordinates.
    pub centre: [f64; 2],
    /// Least-squares radius.
    pub radius_mm: f64,
    /// Number of samples.
    pub samples: usize,
}

/// Results of a circular test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CircularTest {
    /// Least-squares centre of all samples, in the two plane coordinates, mm.
    pub centre: [f64; 2],
    /// Least-squares radius of all samples, mm.
    pub radius_mm: f64,
    /// Counterclockwise travel, if it covers a full circle.
    pub counterclockwise: Option<DirectionFigures>,
    /// Clockwise travel, if it covers a full circle.
    pub clockwise: Option<DirectionFigures>,
    /// Bidirectional circular deviation `G(b)`, mm: range of the radius of both directions about their common centre.
    pub bidirectional_mm: Option<f64>,
    /// Mean bidirectional radial deviation `D`, mm: mean of the mean radial deviations of both
    /// directions.
    pub mean_bidirectional_mm: Option<f64>,
    /// Circular hysteresis `H`, mm: largest radial distance between the paths of the two directions, about their common centre.
    pub hysteresis_mm: Option<f64>,
}

/// Circular test results of a recorded `path` (mm, time order), in one direction or in both, with
/// or without lead-in.
///
/// # Errors
/// If the path is not a circle: fewer than 8 samples, no direction with a full turn, or a spread
/// above 2 % of the radius.
pub fn circular_test(path: &[Vec3], plane: CirclePlane, nominal: NominalCircle) -> Result<CircularTest, MotionError> {
    let not_a_circle = |why: &str| MotionError::BadCurve(format!("the path is not a circle: {why}"));
    if path.len() < 8 || path.iter().any(|point| !point.iter().all(|value| value.is_finite())) {
        return Err(not_a_circle("fewer than 8 samples, or one that is not finite"));
    }
    let points = weigh(path.iter().map(|point| plane.project(point)).collect());
    let (circle, kept) = fit_without_leads(&points).ok_or_else(|| not_a_circle("no circle fits"))?;
    if mean(&kept, |p| circle.deviation(p).powi(2)).sqrt() > 0.02 * circle.radius {
        return Err(not_a_circle("its radius varies by more than 2 %"));
    }

    let mut both = [Vec::new(), Vec::new()];
    for (run, left) in same_sense(&kept, circle.centre) {
        both[usize::from(!left)].extend_from_slice(run);
    }
    let about = nominal.centre.map(Vector2::from);
    let [counterclockwise, clockwise] = both.each_ref().map(|points| figures(points, about, nominal.radius_mm));
    if counterclockwise.is_none() && clockwise.is_none() {
        return Err(not_a_circle("no direction covers a full turn"));
    }
    let pair = counterclockwise.zip(clockwise);
    let common = pair.and_then(|_| fit(&both.concat()));
    Ok(CircularTest {
        centre: circle.centre.into(),
        radius_mm: circle.radius,
        counterclockwise,
        clockwise,
        bidirectional_mm: common.map(|common| common.range(both.iter().flatten())),
        mean_bidirectional_mm: pair.map(|(one, other)| 0.5 * (one.radial_mean_mm + other.radial_mean_mm)),
        hysteresis_mm: common.map(|common| hysteresis(&common, &both)),
    })
}

/// Every point with half the distance to either neighbour.
fn weigh(points: Vec<Vector2<f64>>) -> Vec<Weighted> {
    let half = |a: usize, b: usize| 0.5 * (points[b] - points[a]).norm();
    let last = points.len() - 1;
    (0..points.len()).map(|k| (points[k], half(k.saturating_sub(1), k) + half(k, (k + 1).min(last)))).collect()
}

/// Mean weighted by path length.
fn mean(points: &[Weighted], value: impl Fn(&Vector2<f64>) -> f64) -> f64 {
    let (sum, total) =
        points.iter().fold((0.0, 0.0), |(sum, total), (point, weight)| (sum + weight * value(point), total + weight));
    sum / total
}

#[derive(Debug, Clone, Copy)]
struct Circle {
    centre: Vector2<f64>,
    radius: f64,
}

impl Circle {
    fn deviation(&self, point: &Vector2<f64>) -> f64 {
        (point - self.centre).norm() - self.radius
    }

    fn range<'a>(&self, points: impl Iterator<Item = &'a Weighted>) -> f64 {
        let (least, most) = extremes(points.map(|(point, _)| self.deviation(point)));
        most - least
    }
}

fn extremes(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), value| (least.min(value), most.max(value)))
}

/// Angles at which the two directions are compared.
const ANGLES: usize = 360;

/// Largest distance between the mean radii of both directions over a degree, mm.
fn hysteresis(common: &Circle, both: &[Vec<Weighted>; 2]) -> f64 {
    let means = both.each_ref().map(|points| {
        let mut sums = [(0.0, 0_usize); ANGLES];
        for (point, _) in points {
            let arm = point - common.centre;
            let turned = (arm.y.atan2(arm.x) / TAU).rem_euclid(1.0);
            let (sum, count) = &mut sums[((turned * ANGLES as f64) as usize).min(ANGLES - 1)];
            *sum += common.deviation(point);
            *count += 1;
        }
        sums.map(|(sum, count)| (count > 0).then(|| sum / count as f64))
    });
    let distances = means[0].iter().zip(&means[1]).filter_map(|(one, other)| Some(((*one)? - (*other)?).abs()));
    distances.fold(0.0, f64::max)
}

/// The circle with the least sum of squared radial deviations: an algebraic fit, then Gauss-Newton.
fn fit(points: &[Weighted]) -> Option<Circle> {
    let middle = Vector2::new(mean(points, |p| p.x), mean(points, |p| p.y));
    let mut normal = Matrix3::zeros();
    let mut right = Vector3::zeros();
    for (point, weight) in points {
        let p = point - middle;
        let row = Vector3::new(2.0 * p.x, 2.0 * p.y, 1.0);
        normal += row * row.transpose() * *weight;
        right += row * p.norm_squared() * *weight;
    }
    let start = normal.lu().solve(&right)?;
    let mut centre = middle + start.xy();
    let mut radius = (start.z + start.xy().norm_squared()).max(0.0).sqrt();
    for _ in 0..20 {
        let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for (point, weight) in points {
            let arm = point - centre;
            let Some(outward) = arm.try_normalize(0.0) else { continue };
            let row = Vector3::new(outward.x, outward.y, 1.0);
            normal += row * row.transpose() * *weight;
            right += row * (arm.norm() - radius) * *weight;
        }
        let step = normal.lu().solve(&right)?;
        centre += step.xy();
        radius += step.z;
        if step.norm() < 1e-13 * radius {
            break;
        }
    }
    (radius.is_finite() && radius > 0.0).then_some(Circle { centre, radius })
}

/// The circle through most of the points, and the points that belong to it.
fn fit_without_leads(points: &[Weighted]) -> Option<(Circle, Vec<Weighted>)> {
    let mut kept = points.to_vec();
    let mut circle = fit(&kept)?;
    for _ in 0..30 {
        let mut off: Vec<f64> = points.iter().map(|(point, _)| circle.deviation(point).abs()).collect();
        let middle = off.len() / 2;
        let (_, median, _) = off.select_nth_unstable_by(middle, f64::total_cmp);
        let far = (FAR.0 * 1.4826 * *median).max(FAR.1);
        let before = kept.len();
        kept = points.iter().copied().filter(|(point, _)| circle.deviation(point).abs() <= far).collect();
        let last = circle;
        circle = fit(&kept)?;
        if kept.len() == before && (circle.centre - last.centre).norm() < 1e-12 * circle.radius {
            break;
        }
    }
    Some((circle, kept))
}

/// The path split at its reversals. True for counterclockwise runs.
fn same_sense(points: &[Weighted], centre: Vector2<f64>) -> Vec<(&[Weighted], bool)> {
    let angle = |(point, _): &Weighted| (point.y - centre.y).atan2(point.x - centre.x);
    let mut runs = Vec::new();
    let (mut start, mut extreme, mut extreme_at) = (0, 0.0_f64, 0);
    let (mut turned, mut sense) = (0.0, 0.0);
    for (k, pair) in points.windows(2).enumerate() {
        turned += (angle(&pair[1]) - angle(&pair[0]) + PI).rem_euclid(TAU) - PI;
        let ahead: f64 = turned - extreme;
        if sense == 0.0 {
            if ahead.abs() > TURN_RAD {
                sense = ahead.signum();
                (extreme, extreme_at) = (turned, k + 1);
            }
        } else if ahead * sense > 0.0 {
            (extreme, extreme_at) = (turned, k + 1);
        } else if -ahead * sense > TURN_RAD {
            runs.push((&points[start..=extreme_at], sense > 0.0));
            start = extreme_at;
            sense = -sense;
            (extreme, extreme_at) = (turned, k + 1);
        }
    }
    if sense != 0.0 {
        runs.push((&points[start..=extreme_at], sense > 0.0));
    }
    runs
}

/// Results of one direction, if its points leave no gap.
fn figures(points: &[Weighted], about: Option<Vector2<f64>>, nominal_radius_mm: f64) -> Option<DirectionFigures> {
    if points.len() < 8 {
        return None;
    }
    let circle = fit(points)?;
    let mut angles: Vec<f64> =
        points.iter().map(|(point, _)| (point.y - circle.centre.y).atan2(point.x - circle.centre.x)).collect();
    angles.sort_by(f64::total_cmp);
    let seam = angles.first()? + TAU - angles.last()?;
    let widest = angles.windows(2).map(|pair| pair[1] - pair[0]).fold(seam, f64::max);
    if widest > GAP_RAD.max(3.0 * TAU / points.len() as f64) {
        return None;
    }
    let nominal = Circle { centre: about.unwrap_or(circle.centre), radius: nominal_radius_mm };
    let (least, most) = extremes(points.iter().map(|(point, _)| nominal.deviation(point)));
    Some(DirectionFigures {
        circular_deviation_mm: circle.range(points.iter()),
        radial_max_mm: most,
        radial_min_mm: least,
        radial_mean_mm: mean(points, |p| nominal.deviation(p)),
        centre: circle.centre.into(),
        radius_mm: circle.radius,
        samples: points.len(),
    })
}
