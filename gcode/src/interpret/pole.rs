//! Pole and polar coordinates of SINUMERIK between two blocks.

use crate::modal::{Plane, WorkOffset};

/// Pole and last polar coordinates.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Polar {
    pub pole: Pole,
    /// End of the last polar move.
    pub last: Option<PolarPoint>,
}

#[derive(Clone, Copy, Debug, Default)]
pub(super) enum Pole {
    /// None is programmed: the zero of the workpiece counts.
    #[default]
    Unset,
    /// In the plane's axes, mm. Whether it outlasts another plane or frame is not stated.
    Set { centre_mm: [f64; 2], plane: Plane, shift_mm: [f64; 2], work_offset: WorkOffset },
    /// It is not known which one is active.
    Unknown,
}

/// Polar coordinates, from the plane's first axis to its second.
#[derive(Clone, Copy, Debug)]
pub(super) struct PolarPoint {
    pub plane: Plane,
    pub angle_deg: f64,
    pub radius_mm: f64,
}

impl PolarPoint {
    /// The point in the plane's axes, mm.
    pub(super) fn about(&self, pole: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.angle_deg.to_radians().sin_cos();
        [pole[0] + self.radius_mm * cos, pole[1] + self.radius_mm * sin]
    }
}

impl Polar {
    /// The pole is not known from here on.
    pub(super) fn lose(&mut self) {
        *self = Self { pole: Pole::Unknown, last: None };
    }
}
