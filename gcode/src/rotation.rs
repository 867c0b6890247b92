//! Rotation, scaling and mirror images of programmed coordinates in a main plane.

use crate::plane::Plane;
use crate::position::Position;

/// A rotation of the coordinates in a plane (G68, ROT and AROT, CYCL DEF 10), a mirror image (G51.1, MIRROR and AMIRROR, CYCL DEF 8), or a scaling (SCALE and ASCALE). Turned coordinates
/// are programmed ones plus their shift; a point of the work frame is `s·R(angle)·turned + offset` in the plane, `s·R(angle)·F·turned + offset` where
/// `F` reverses the first axis, and `n·turned + offset` along the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotation {
    plane: Plane,
    /// Sum of the programmed angles, from the plane's first axis to its second.
    angle_deg: f64,
    /// Scale factor in the plane.
    factor: f64,
    offset_mm: [f64; 2],
    /// Whether the first axis is reversed.
    is_mirrored: bool,
    normal: Normal,
}

/// Map of the coordinate along the normal of the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Normal {
    factor: f64,
    offset_mm: f64,
}

impl Normal {
    const SAME: Self = Self { factor: 1.0, offset_mm: 0.0 };

    fn in_work(self, turned: f64) -> f64 {
        self.factor * turned + self.offset_mm
    }
}

impl Rotation {
    /// A rotation about a point of the plane, mm.
    pub(crate) fn about(plane: Plane, centre_mm: [f64; 2], angle_deg: f64) -> Self {
        let turned = turned(centre_mm, angle_deg);
        let offset_mm = [0, 1].map(|axis| centre_mm[axis] - turned[axis]);
        Self { plane, angle_deg, factor: 1.0, offset_mm, is_mirrored: false, normal: Normal::SAME }
    }

    /// A scaling about a point, mm: the factors in the plane, and along its normal. The point's coordinates are those of the plane, then of the normal.
    pub(crate) fn scaling(plane: Plane, centre_mm: [f64; 3], factors: [f64; 2]) -> Self {
        let [factor, along] = factors;
        let fixed = |axis: usize, factor: f64| centre_mm[axis] * (1.0 - factor);
        let normal = Normal { factor: along, offset_mm: fixed(2, along) };
        Self { plane, angle_deg: 0.0, factor, offset_mm: [fixed(0, factor), fixed(1, factor)], is_mirrored: false, normal }
    }

    /// The mirror image by which a coordinate of the plane changes sides of its entry in `about_mm`; one without an entry stays.
    pub(crate) fn mirror(plane: Plane, about_mm: [Option<f64>; 2]) -> Self {
        let angle_deg = if about_mm[1].is_some() { 180.0 } else { 0.0 };
        let offset_mm = about_mm.map(|about| about.map_or(0.0, |about| 2.0 * about));
        let is_mirrored = about_mm[0].is_some() != about_mm[1].is_some();
        Self { plane, angle_deg, factor: 1.0, offset_mm, is_mirrored, normal: Normal::SAME }
    }

    /// A further rotation, scaling or mirror image of the turned coordinates, in the same plane. In a mirror image rotations run the other way round.
    pub(crate) fn then(&self, further: &Self) -> Self {
        let turns_deg = if self.is_mirrored { -further.angle_deg } else { further.angle_deg };
        let normal = Normal {
            factor: self.normal.factor * further.normal.factor,
            offset_mm: self.normal.in_work(further.normal.offset_mm),
        };
        Self {
            angle_deg: self.angle_deg + turns_deg,
            factor: self.factor * further.factor,
            is_mirrored: self.is_mirrored != further.is_mirrored,
            offset_mm: self.point_in_work(further.offset_mm),
            normal,
            ..*self
        }
    }

    /// Factor on lengths in the plane.
    pub(crate) fn factor(&self) -> f64 {
        self.factor
    }

    /// Factors on lengths in the plane, and along its normal.
    pub(crate) fn factors(&self) -> [f64; 2] {
        [self.factor, self.normal.factor]
    }

    /// Whether the coordinate along the normal of the plane is another one.
    pub(crate) fn scales_normal(&self) -> bool {
        self.normal != Normal::SAME
    }

    /// The plane that is turned.
    pub fn plane(&self) -> Plane {
        self.plane
    }

    /// Angle, rad.
    pub fn angle_rad(&self) -> f64 {
        self.angle_deg.to_radians()
    }

    /// Whether arcs run the other way round in the work frame.
    pub fn is_mirrored(&self) -> bool {
        self.is_mirrored
    }

    /// A vector of the plane in the work frame.
    fn vector_in_work(&self, [first, second]: [f64; 2]) -> [f64; 2] {
        turned([if self.is_mirrored { -first } else { first }, second], self.angle_deg).map(|along| self.factor * along)
    }

    /// A vector of the work frame in turned coordinates.
    fn vector_unturned(&self, vector: [f64; 2]) -> [f64; 2] {
        let [first, second] = turned(vector, -self.angle_deg).map(|along| along / self.factor);
        [if self.is_mirrored { -first } else { first }, second]
    }

    /// A point in the plane's axes, mm, in the work frame.
    pub(crate) fn point_in_work(&self, point: [f64; 2]) -> [f64; 2] {
        let turned = self.vector_in_work(point);
        [0, 1].map(|axis| turned[axis] + self.offset_mm[axis])
    }

    /// Coordinates (X, Y, Z, A, B, C) of a point of the work frame, mm and rad, before the rotation.
    pub fn unturned(&self, work: [f64; 6]) -> [f64; 6] {
        let [first, second, normal] = self.plane.axes();
        let mut from = work;
        from[first] -= self.offset_mm[0];
        from[second] -= self.offset_mm[1];
        from[normal] -= self.normal.offset_mm;
        self.displacement_unturned(from)
    }

    /// Displacement in the work frame of one of turned coordinates.
    pub fn displacement(&self, of: [f64; 6]) -> [f64; 6] {
        let [first, second, normal] = self.plane.axes();
        let mut out = of;
        [out[first], out[second]] = self.vector_in_work([of[first], of[second]]);
        out[normal] *= self.normal.factor;
        out
    }

    /// Displacement of turned coordinates that leads to one in the work frame.
    pub fn displacement_unturned(&self, of: [f64; 6]) -> [f64; 6] {
        let [first, second, normal] = self.plane.axes();
        let mut out = of;
        [out[first], out[second]] = self.vector_unturned([of[first], of[second]]);
        out[normal] /= self.normal.factor;
        out
    }

    /// A position in the work frame. Without one of the two turned coordinates neither is known there.
    pub(crate) fn in_work(&self, turned: Position) -> Position {
        let [first, second, normal] = self.plane.axes();
        let mut out = turned;
        [out.nominal[first], out.nominal[second]] = self.point_in_work([turned.nominal[first], turned.nominal[second]]);
        out.nominal[normal] = self.normal.in_work(turned.nominal[normal]);
        out.keep_pair(first, second);
        out
    }

    /// Turned coordinates of a position of the work frame.
    pub(crate) fn out_of_work(&self, work: Position) -> Position {
        let [first, second, _] = self.plane.axes();
        let mut out = Position { nominal: self.unturned(work.nominal), ..work };
        out.keep_pair(first, second);
        out
    }
}

/// A vector turned by an angle. Multiples of 90° are exact.
fn turned([x, y]: [f64; 2], angle_deg: f64) -> [f64; 2] {
    let (sin, cos) = match angle_deg.rem_euclid(360.0) {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        _ => angle_deg.to_radians().sin_cos(),
    };
    [cos * x - sin * y, sin * x + cos * y]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: [f64; 2], b: [f64; 2]) -> bool {
        (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-12
    }

    #[test]
    fn the_centre_stays_and_the_first_axis_turns_towards_the_second() {
        let quarter = Rotation::about(Plane::Xy, [10.0, 5.0], 90.0);
        assert_eq!(quarter.point_in_work([10.0, 5.0]), [10.0, 5.0]);
        assert_eq!(quarter.point_in_work([12.0, 5.0]), [10.0, 7.0]);
        // Z is the first axis of G18.
        let turned = Rotation::about(Plane::Zx, [0.0; 2], 90.0).displacement([0.0, 3.0, 1.0, 0.5, 0.0, 0.0]);
        assert_eq!(turned, [1.0, 3.0, 0.0, 0.5, 0.0, 0.0]);
    }

    #[test]
    fn a_further_rotation_is_one_of_turned_coordinates() {
        let (first, centre) = (Rotation::about(Plane::Xy, [3.0, -2.0], 25.0), [7.0, 1.0]);
        let further = Rotation::about(Plane::Xy, centre, -70.0);
        let both = first.then(&further);
        for point in [[0.0, 0.0], [4.0, 9.0], centre] {
            assert!(near(both.point_in_work(point), first.point_in_work(further.point_in_work(point))));
        }
    }

    #[test]
    fn a_scaling_keeps_its_centre_and_acts_on_what_follows() {
        let scaling = Rotation::scaling(Plane::Zx, [3.0, 10.0, -1.0], [2.0, 0.5]);
        // Z and X are the plane, Y the normal.
        let at = |of: &Rotation, nominal: [f64; 6]| of.in_work(Position { nominal, known: 0b111111 }).nominal;
        assert_eq!(at(&scaling, [10.0, -1.0, 3.0, 0.0, 0.0, 0.0]), [10.0, -1.0, 3.0, 0.0, 0.0, 0.0]);
        assert_eq!(at(&scaling, [11.0, 1.0, 5.0, 0.1, 0.0, 0.0]), [12.0, 0.0, 7.0, 0.1, 0.0, 0.0]);
        assert!(scaling.scales_normal() && scaling.factor() == 2.0);
        let further = Rotation::about(Plane::Zx, [1.0, 2.0], 90.0).then(&Rotation::scaling(Plane::Zx, [0.0; 3], [3.0, 3.0]));
        let both = scaling.then(&further);
        let point = [4.0, 5.0, 6.0, 0.0, 0.0, 0.0];
        let wanted = at(&scaling, at(&further, point));
        assert!(at(&both, point).iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-12));
        assert_eq!(both.factor(), 6.0);
    }

    #[test]
    fn a_mirror_image_changes_sides_of_its_axis() {
        let image = |about_mm| Rotation::mirror(Plane::Xy, about_mm).point_in_work([4.0, 7.0]);
        assert!(near(image([Some(1.0), None]), [-2.0, 7.0]));
        assert!(near(image([None, Some(10.0)]), [4.0, 13.0]));
        assert!(near(image([Some(1.0), Some(10.0)]), [-2.0, 13.0]));
    }

    #[test]
    fn points_and_displacements_are_turned_back() {
        are_turned_back(Rotation::about(Plane::Yz, [1.0, 2.0], 33.0));
        are_turned_back(Rotation::mirror(Plane::Yz, [Some(3.0), None]));
        are_turned_back(Rotation::mirror(Plane::Yz, [None, Some(-4.0)]));
        are_turned_back(Rotation::about(Plane::Yz, [1.0, 2.0], 33.0).then(&Rotation::scaling(Plane::Yz, [5.0; 3], [1.5, 0.75])));
    }

    fn are_turned_back(rotation: Rotation) {
        let turned = Position { nominal: [5.0, 6.0, 7.0, 0.1, 0.2, 0.3], known: 0b111111 };
        let back = rotation.out_of_work(rotation.in_work(turned));
        assert!(back.nominal.iter().zip(turned.nominal).all(|(a, b)| (a - b).abs() < 1e-12) && back.known == turned.known);
        let half = Position { known: 0b000011, ..turned };
        assert_eq!(rotation.in_work(half).known, 0b000001, "X is not turned, Y needs Z");
        let there = rotation.displacement_unturned(rotation.displacement(turned.nominal));
        assert!(there.iter().zip(turned.nominal).all(|(a, b)| (a - b).abs() < 1e-12));
    }
}
