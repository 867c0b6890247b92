//! The circular test in polar form.

use motion::Vec3;
use motion::contour::{CirclePlane, DirectionFigures};
use pipeline::measure::{circle, nominal_circle};
use pipeline::units::um;

use super::column::Column;
use super::polar::{Polar, PolarRun};
use super::run::Run;
use super::section::{Content, Section};
use super::thin::thinned;
use super::track::Track;

/// Points that are drawn of a run.
const MOST_POINTS: usize = 8000;
/// Distance from the programmed circle beyond which a desired point belongs to a lead-in or lead-out, mm.
const ON_CIRCLE_MM: f64 = 1e-3;

/// The section on a path that is a circle in a main plane.
#[must_use]
pub fn polar(track: &Track<'_>, runs: &[Run]) -> Option<Section> {
    let desired = track.tips();
    let (plane, nominal) = nominal_circle(&desired)?;
    let (slots, names) = match plane {
        CirclePlane::Xy => ([0, 1], ["X", "Y"]),
        CirclePlane::Yz => ([1, 2], ["Y", "Z"]),
        CirclePlane::Zx => ([2, 0], ["Z", "X"]),
    };
    let centre = nominal.centre?;
    let arm = |point: &Vec3| [point[slots[0]] - centre[0], point[slots[1]] - centre[1]];
    let radius = |point: &Vec3| arm(point)[0].hypot(arm(point)[1]);
    let on_circle: Vec<usize> = (1..desired.len())
        .filter(|k| (radius(&desired[*k]) - nominal.radius_mm).abs() < ON_CIRCLE_MM && desired[*k] != desired[*k - 1])
        .collect();
    let of_run = |run: &Run| {
        let actual: Vec<Vec3> = on_circle.iter().map(|k| run.errors[*k].foot + run.errors[*k].vector).collect();
        let radial: Vec<f64> = actual.iter().map(|point| (radius(point) - nominal.radius_mm) * 1e3).collect();
        let kept = thinned(MOST_POINTS, &[&radial], &actual);
        let angle = |k: &usize| arm(&actual[*k])[1].atan2(arm(&actual[*k])[0]);
        let turns_left = |k: &usize| {
            let ([x, y], before) = (arm(&desired[on_circle[*k]]), arm(&desired[on_circle[*k] - 1]));
            before[0] * y - before[1] * x > 0.0
        };
        PolarRun {
            name: run.name.clone(),
            angle_rad: Column::float(&kept.iter().map(angle).collect::<Vec<f64>>()),
            radial_um: Column::float(&kept.iter().map(|k| radial[*k]).collect::<Vec<f64>>()),
            counterclockwise: Column::flags(&kept.iter().map(turns_left).collect::<Vec<bool>>()),
        }
    };
    let rows: Vec<Vec<String>> = runs.iter().flat_map(|run| rows(run, &desired)).collect();
    let header = vec!["run, direction", "G µm", "F max µm", "F min µm", "mean radial µm", "G(b) µm", "D µm", "hysteresis H µm"];
    let content = Polar {
        radius_mm: nominal.radius_mm,
        plane: names.map(str::to_owned),
        runs: runs.iter().map(of_run).collect(),
        header,
        rows,
    };
    let note = format!(
        "Radial deviation from the circle of {:.3} mm, drawn larger than it is. Figures after ISO 230-4: circular deviation G, radial \
         deviations F; with both directions the bidirectional G(b), the mean bidirectional D and the hysteresis H, the largest distance \
         between the two directions. Steps at the quadrants are reversal errors. An oval at 45° whose direction changes with the sense of \
         travel is a mismatch of the axes' gains, one that stays is squareness; an oval along the axes is a mismatch of scales.",
        nominal.radius_mm
    );
    Some(Section::new("Circular test", note, Content::Polar(content)))
}

/// The figures of a run, a row for each direction.
fn rows(run: &Run, desired: &[Vec3]) -> Vec<Vec<String>> {
    let actual: Vec<Vec3> = run.errors.iter().map(|error| error.foot + error.vector).collect();
    let Some(found) = circle(desired, &actual) else { return Vec::new() };
    let optional = |value: Option<f64>| value.map_or("–".to_owned(), um);
    let row = |(direction, figures): (&str, Option<DirectionFigures>)| {
        let f = figures?;
        let own = [f.circular_deviation_mm, f.radial_max_mm, f.radial_min_mm, f.radial_mean_mm].map(um);
        let both = [found.bidirectional_mm, found.mean_bidirectional_mm, found.hysteresis_mm].map(optional);
        Some(std::iter::once(format!("{}, {direction}", run.name)).chain(own).chain(both).collect())
    };
    [("counterclockwise", found.counterclockwise), ("clockwise", found.clockwise)].into_iter().filter_map(row).collect()
}
