//! Test curves of the papers and a few more, by name.

use std::f64::consts::PI;
use std::sync::Arc;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

use super::{Curve, Nurbs, OnSaddle, RoundedPolygon, RuledSurface, jet::Jet};
use crate::{MotionError, Vec3};

/// A curve given by formulas for its three coordinates.
#[derive(Clone, Copy)]
pub struct Formula {
    name: &'static str,
    domain: (f64, f64),
    coordinates: fn(Jet) -> [Jet; 3],
}

impl std::fmt::Debug for Formula {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {:?}", self.name, self.domain)
    }
}

impl Curve for Formula {
    fn domain(&self) -> (f64, f64) {
        self.domain
    }

    fn derivatives(&self, u: f64) -> [Vec3; 4] {
        let u = Jet::variable(u.clamp(self.domain.0, self.domain.1));
        let [x, y, z] = (self.coordinates)(u);
        std::array::from_fn(|order| Vec3::new(x.0[order], y.0[order], z.0[order]))
    }
}

fn polar(r: Jet, u: Jet, z: Jet) -> [Jet; 3] {
    [r * u.cos(), r * u.sin(), z]
}

/// Crown, `(40 cos u, 40 sin u, 10 sin 4u)`.
pub const CROWN: Formula =
    Formula { name: "crown", domain: (0.0, 2.0 * PI), coordinates: |u| polar(Jet::constant(40.0), u, (u * 4.0).sin() * 10.0) };

/// Rising spiral, `r = 8 + 4u/π`, `z = 2.5u`, three turns.
pub const SPIRAL: Formula =
    Formula { name: "spiral", domain: (0.0, 6.0 * PI), coordinates: |u| polar(u * (4.0 / PI) + 8.0, u, u * 2.5) };

/// Six-petalled flower in space, `r = 30 + 25 cos 6u`, `z = 10 sin 3u`.
pub const FLOWER: Formula = Formula {
    name: "flower",
    domain: (0.0, 2.0 * PI),
    coordinates: |u| polar((u * 6.0).cos() * 25.0 + 30.0, u, (u * 3.0).sin() * 10.0),
};

/// Six-petalled flower in the plane, `r = 30 + 25 cos 6u` (Paper D, table I).
pub const FLAT_FLOWER: Formula = Formula {
    name: "flat-flower",
    domain: (0.0, 2.0 * PI),
    coordinates: |u| polar((u * 6.0).cos() * 25.0 + 30.0, u, Jet::constant(0.0)),
};

/// Five-petalled flower in the plane, `r = 25 + 15 cos 5u` (Paper A, eq. 44; Paper B).
pub const FIVE_PETALS: Formula = Formula {
    name: "five-petals",
    domain: (0.0, 2.0 * PI),
    coordinates: |u| polar((u * 5.0).cos() * 15.0 + 25.0, u, Jet::constant(0.0)),
};

/// Fourth-order ellipse, `r = A(1 − k)/(1 − k cos 4u)`, `A = 65`, `k = 0.3` (Paper A, eq. 43).
pub const ELLIPSE: Formula = Formula {
    name: "ellipse",
    domain: (0.0, 2.0 * PI),
    coordinates: |u| {
        let r = ((u * 4.0).cos() * -0.3 + 1.0).recip() * (65.0 * 0.7);
        polar(r, u, Jet::constant(0.0))
    },
};

/// A circle of 20 mm radius in the XY plane, for circular tests.
pub const CIRCLE: Formula =
    Formula { name: "circle", domain: (0.0, 2.0 * PI), coordinates: |u| polar(Jet::constant(20.0), u, Jet::constant(0.0)) };

/// Every curve known to [`by_name`], random ones excluded.
pub const NAMES: [&str; 12] = [
    "crown",
    "spiral",
    "flower",
    "flat-flower",
    "five-petals",
    "ellipse",
    "circle",
    "butterfly",
    "eight",
    "saddle",
    "saddle-butterfly",
    "s-piece",
];

/// Families known to [`by_name`] in addition to [`NAMES`], with the meaning of `N`.
pub const FAMILIES: [&str; 4] = [
    "nurbs-N (random, seed N)",
    "saddle-nurbs-N (random on the saddle, seed N)",
    "polygon-N (N sides, rounded corners)",
    "spiral-Nmm (N mm a turn)",
];

/// Radial pitch of the [`SPIRAL`], mm per turn.
const SPIRAL_PITCH_MM: f64 = 8.0;

/// The rising spiral with another pitch: `r = 8 + pu/2π`, `z = 2.5u·p/8` with `p` in mm per turn,
/// three turns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spiral {
    /// Growth of the radius, mm per turn. Positive.
    pub pitch_mm: f64,
}

impl Curve for Spiral {
    fn domain(&self) -> (f64, f64) {
        SPIRAL.domain
    }

    fn derivatives(&self, u: f64) -> [Vec3; 4] {
        let u = Jet::variable(u.clamp(0.0, SPIRAL.domain.1));
        let [x, y, z] = polar(u * (self.pitch_mm / (2.0 * PI)) + 8.0, u, u * (2.5 * self.pitch_mm / SPIRAL_PITCH_MM));
        std::array::from_fn(|order| Vec3::new(x.0[order], y.0[order], z.0[order]))
    }
}

/// Circumradius, corner radius (mm) and tilt (rad) of `polygon-N`: within ± 35 mm, corners of a
/// finishing cut, motion of all three axes.
const POLYGON: (f64, f64, f64) = (35.0, 4.0, 0.25);
/// Maximum sides of `polygon-N`: with more the straight lines between corners become negligible.
const POLYGON_SIDES: std::ops::RangeInclusive<usize> = 3..=24;
/// Largest pitch of `spiral-Nmm`, mm: three turns stay within ± 70 mm.
const LARGEST_PITCH_MM: f64 = 20.0;

/// The test curve called `name`: one of [`NAMES`] or of [`FAMILIES`].
///
/// # Errors
/// If there is no such curve.
pub fn by_name(name: &str) -> Result<Arc<dyn Curve>, MotionError> {
    for formula in [CROWN, SPIRAL, FLOWER, FLAT_FLOWER, FIVE_PETALS, ELLIPSE, CIRCLE] {
        if formula.name == name {
            return Ok(Arc::new(formula));
        }
    }
    match name {
        "butterfly" => return Ok(Arc::new(butterfly()?)),
        "eight" => return Ok(Arc::new(eight()?)),
        "saddle" => return Ok(Arc::new(saddle())),
        "saddle-butterfly" => return Ok(Arc::new(saddle_butterfly()?)),
        "s-piece" => return Ok(Arc::new(s_piece()?)),
        _ => {}
    }
    match of_family(name) {
        Some(curve) => curve,
        None => Err(MotionError::BadCurve(format!(
            "no test curve is called `{name}`; there are {}, {}",
            NAMES.join(", "),
            FAMILIES.join(", ")
        ))),
    }
}

/// The member of one of the [`FAMILIES`] called `name`. `None` if it belongs to none.
fn of_family(name: &str) -> Option<Result<Arc<dyn Curve>, MotionError>> {
    if let Some(seed) = name.strip_prefix("nurbs-").and_then(|seed| seed.parse().ok()) {
        return Some(random_nurbs(20, 18.0, 3, seed).map(|curve| Arc::new(curve) as Arc<dyn Curve>));
    }
    if let Some(seed) = name.strip_prefix("saddle-nurbs-").and_then(|seed| seed.parse().ok()) {
        return Some(random_nurbs(8, 18.0, 2, seed).map(|curve| Arc::new(OnSaddle(curve)) as Arc<dyn Curve>));
    }
    if let Some(sides) = name.strip_prefix("polygon-").and_then(|sides| sides.parse().ok())
        && POLYGON_SIDES.contains(&sides)
    {
        let (circumradius, corner, tilt) = POLYGON;
        return Some(RoundedPolygon::new(sides, circumradius, corner, tilt).map(|curve| Arc::new(curve) as Arc<dyn Curve>));
    }
    let pitch_mm: f64 = name.strip_prefix("spiral-")?.strip_suffix("mm")?.parse().ok()?;
    (pitch_mm > 0.0 && pitch_mm <= LARGEST_PITCH_MM).then(|| Ok(Arc::new(Spiral { pitch_mm }) as Arc<dyn Curve>))
}

/// A random NURBS: quintic through `points` points, each of its first `dimensions` coordinates
/// `N(0, sigma_mm²)`.
///
/// # Errors
/// If fewer than six points are requested.
pub fn random_nurbs(points: usize, sigma_mm: f64, dimensions: usize, seed: u64) -> Result<Nurbs, MotionError> {
    let normal = Normal::new(0.0, sigma_mm).map_err(|_| MotionError::BadSetting {
        name: "sigma_mm",
        value: sigma_mm,
        remedy: "it must be positive and finite",
    })?;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let points: Vec<Vec3> = (0..points)
        .map(|_| {
            let draw: [f64; 3] = std::array::from_fn(|_| normal.sample(&mut rng));
            Vec3::from_fn(|i, _| if i < dimensions { draw[i] } else { 0.0 })
        })
        .collect();
    Nurbs::through(&points, 5)
}

/// The butterfly of Nie et al. (IEEE Access 11, 2023, table 7), moved to the origin: with corners,
/// 382.86 mm long.
///
/// # Errors
/// None for this table. Every NURBS is checked, hence the result type.
pub fn butterfly() -> Result<Nurbs, MotionError> {
    // Middle of the bounding box of the printed curve, rounded.
    butterfly_about((54.5, 36.2), 1.0)
}

/// The butterfly moved so that `centre` (mm, as printed) is the origin, then scaled.
fn butterfly_about(centre: (f64, f64), scale: f64) -> Result<Nurbs, MotionError> {
    #[rustfmt::skip]
    const POINTS: [(f64, f64); 51] = [
        (54.493, 52.139), (55.507, 52.139), (56.082, 49.615), (56.780, 44.971), (69.575, 51.358),
        (77.786, 58.573), (90.526, 67.081), (105.973, 63.801), (100.400, 47.326), (94.567, 39.913),
        (92.369, 30.485), (83.440, 33.757), (91.892, 28.509), (89.444, 20.393), (83.218, 15.446),
        (87.621, 4.830), (80.945, 9.267), (79.834, 14.535), (76.074, 8.522), (70.183, 12.550),
        (64.171, 16.865), (59.993, 22.122), (55.680, 36.359), (56.925, 24.995), (59.765, 19.828),
        (54.493, 14.940), (49.220, 19.828), (52.060, 24.994), (53.305, 36.359), (48.992, 22.122),
        (44.814, 16.865), (38.802, 12.551), (32.911, 8.521), (29.152, 14.535), (28.040, 9.267),
        (21.364, 4.830), (25.768, 15.447), (19.539, 20.391), (17.097, 28.512), (25.537, 33.750),
        (16.602, 30.496), (14.199, 39.803), (8.668, 47.408), (3.000, 63.794), (18.465, 67.084),
        (31.197, 58.572), (39.411, 51.358), (52.204, 44.971), (52.904, 49.614), (53.478, 52.139),
        (54.493, 52.139),
    ];
    #[rustfmt::skip]
    const KNOTS: [f64; 55] = [
        0.0, 0.0, 0.0, 0.0, 0.0083, 0.0150, 0.0361, 0.0855, 0.1293, 0.1509, 0.1931,
        0.2273, 0.2435, 0.2561, 0.2692, 0.2889, 0.3170, 0.3316, 0.3482, 0.3553, 0.3649, 0.3837,
        0.4005, 0.4269, 0.4510, 0.4660, 0.4891, 0.5000, 0.5109, 0.5340, 0.5489, 0.5731, 0.5994,
        0.6163, 0.6351, 0.6447, 0.6518, 0.6683, 0.6830, 0.7111, 0.7307, 0.7439, 0.7565, 0.7729,
        0.8069, 0.8491, 0.8707, 0.9145, 0.9639, 0.9850, 0.9917, 1.0, 1.0, 1.0, 1.0,
    ];
    let mut weights = [1.0; 51];
    for (index, weight) in
        [(3, 1.2), (11, 2.0), (14, 5.0), (15, 3.0), (17, 1.1), (33, 1.1), (35, 3.0), (36, 5.0), (39, 2.0), (47, 1.2)]
    {
        weights[index] = weight;
    }
    Nurbs::new(3, &POINTS.map(|(x, y)| Vec3::new((x - centre.0) * scale, (y - centre.1) * scale, 0.0)), &weights, &KNOTS)
}

/// The horizontal eight of Nie et al. (table 6).
///
/// # Errors
/// None for this table. Every NURBS is checked, hence the result type.
pub fn eight() -> Result<Nurbs, MotionError> {
    let points = [(0.0, 0.0), (-150.0, -150.0), (-150.0, 150.0), (0.0, 0.0), (150.0, -150.0), (150.0, 150.0), (0.0, 0.0)];
    Nurbs::new(
        3,
        &points.map(|(x, y)| Vec3::new(x, y, 0.0)),
        &[1.0, 25.0, 25.0, 1.0, 25.0, 25.0, 1.0],
        &[0.0, 0.0, 0.0, 0.0, 0.354, 0.5, 0.646, 1.0, 1.0, 1.0, 1.0],
    )
}

/// Circle of 40 mm radius on the saddle, `x = 40 cos u`, `y = 40 sin u`, the tool along the surface
/// normal. After Paper C, figure 8, which prints no formula.
#[must_use]
pub fn saddle() -> OnSaddle<Formula> {
    OnSaddle(Formula {
        name: "saddle",
        domain: (0.0, 2.0 * PI),
        coordinates: |u| polar(Jet::constant(40.0), u, Jet::constant(0.0)),
    })
}

/// The [`butterfly`], its box centred and its largest coordinate scaled to 40 mm, projected onto
/// the saddle with the tool along the surface normal (Paper C).
///
/// # Errors
/// None for this table. Every NURBS is checked, hence the result type.
pub fn saddle_butterfly() -> Result<OnSaddle<Nurbs>, MotionError> {
    /// Middle of the bounding box of the printed curve, mm.
    const CENTRE: (f64, f64) = (54.501794, 36.224703);
    /// Half the width of that box, mm.
    const HALF_WIDTH: f64 = 48.580959;
    Ok(OnSaddle(butterfly_about(CENTRE, 40.0 / HALF_WIDTH)?))
}

/// A flank of an S-shaped test piece, after ISO 10791-7 and GB/T 39967: a ruled surface between two
/// cubic B-splines, which bends to both sides and leans inwards and outwards in turn. The standards
/// define the kind of surface; their control points are not at hand. These are our own: 225 mm long,
/// 40 mm high, radii from 20 mm, 9° to 16° off the vertical, leaning along the path where it leans to
/// neither side, so that no pole lies on it. The flank is that of the tool's axis: the tool's radius is
/// taken into account already.
///
/// # Errors
/// None for this table. Every NURBS is checked, hence the result type.
pub fn s_piece() -> Result<RuledSurface, MotionError> {
    const HEIGHT_MM: f64 = 40.0;
    #[rustfmt::skip]
    const LOWER: [(f64, f64); 14] = [
        (62.0, 18.0), (62.0, 34.0), (46.0, 46.0), (24.0, 46.0), (4.0, 38.0), (-2.0, 22.0), (0.0, 8.0),
        (0.0, -8.0), (2.0, -22.0), (-4.0, -38.0), (-24.0, -46.0), (-46.0, -46.0), (-62.0, -34.0), (-62.0, -18.0),
    ];
    #[rustfmt::skip]
    const UPPER: [(f64, f64); 14] = [
        (71.2, 24.3), (66.6, 43.9), (42.4, 55.7), (16.5, 51.6), (-4.2, 37.5), (-6.0, 16.1), (-0.7, 1.6),
        (1.5, -14.2), (4.4, -28.7), (-5.1, -46.1), (-28.9, -53.9), (-54.5, -51.9), (-72.9, -32.9), (-71.2, -11.7),
    ];
    let edge = |points: &[(f64, f64)], z: f64| {
        let points: Vec<Vec3> = points.iter().map(|(x, y)| Vec3::new(*x, *y, z)).collect();
        let spans = points.len() - 3;
        // Clamped, with knots at equal distances between the ends.
        let knots: Vec<f64> = (0..points.len() + 4).map(|k| k.saturating_sub(3).min(spans) as f64 / spans as f64).collect();
        Nurbs::new(3, &points, &vec![1.0; points.len()], &knots)
    };
    Ok(RuledSurface { lower: edge(&LOWER, 0.0)?, upper: edge(&UPPER, HEIGHT_MM)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_and_family_has_its_curve() {
        for name in NAMES.iter().copied().chain(["nurbs-7", "saddle-nurbs-7", "polygon-5", "spiral-6mm", "spiral-7.5mm"]) {
            assert!(by_name(name).is_ok(), "{name}");
        }
        for name in
            ["nurbs-", "polygon-2", "polygon-99", "polygon-x", "spiral-6", "spiral-0mm", "spiral-NaNmm", "spiral--3mm", "spline"]
        {
            let refused = by_name(name).unwrap_err().to_string();
            assert!(refused.contains(name) && refused.contains("polygon-N"), "{refused}");
        }
    }

    #[test]
    fn the_spiral_of_eight_millimetres_is_the_spiral() {
        let of_pitch = Spiral { pitch_mm: SPIRAL_PITCH_MM };
        for u in [0.0, 1.0, 7.3, 18.0] {
            for (one, other) in of_pitch.derivatives(u).iter().zip(SPIRAL.derivatives(u)) {
                assert!((one - other).norm() < 1e-12);
            }
        }
    }
}
