//! Radial deviations in polar form, as the page holds them.

use serde::Serialize;

use super::column::Column;

/// Radial deviations of runs of a circle.
#[derive(Debug, Serialize)]
pub struct Polar {
    /// Radius of the programmed circle.
    pub radius_mm: f64,
    /// Names of the two coordinates.
    pub plane: [String; 2],
    /// The runs.
    pub runs: Vec<PolarRun>,
    /// Headings of the table of figures.
    pub header: Vec<&'static str>,
    /// Its rows, one for each run and direction.
    pub rows: Vec<Vec<String>>,
}

/// A run of a circle.
#[derive(Debug, Serialize)]
pub struct PolarRun {
    /// Name.
    pub name: String,
    /// Angle of the actual position about the programmed centre.
    pub angle_rad: Column,
    /// Its radial deviation, positive away from the centre.
    pub radial_um: Column,
    /// Whether the desired motion is counterclockwise there.
    pub counterclockwise: Column,
}
