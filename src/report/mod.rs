//! The report: one self-contained page with the path, the errors over time and the table.

mod draw;

use anyhow::Result;
use minijinja::{Environment, context};
use motion::contour::{ContourError, summary};
use motion::{DesiredPath, Trajectory, Vec3};
use serde::Serialize;

use crate::evaluate;
use draw::{Chart, PathDrawing};

/// One run of a path.
pub struct Series {
    name: String,
    errors: Vec<ContourError>,
}

impl Series {
    /// The run `actual` of `desired`.
    ///
    /// # Errors
    /// When the two do not match.
    pub fn of(name: &str, desired: &DesiredPath, actual: &Trajectory) -> Result<Self> {
        Ok(Self { name: name.to_owned(), errors: evaluate::contour_errors(desired, actual)? })
    }
}

/// Everything that the page shows of one path.
#[derive(Debug, Serialize)]
pub struct PathReport {
    name: String,
    drawings: Vec<PathDrawing>,
    chart: Chart,
    rows: Vec<Row>,
}

#[derive(Debug, Serialize)]
struct Row {
    name: String,
    rms_um: String,
    max_um: String,
    p95_um: String,
    color: &'static str,
}

impl PathReport {
    /// The report of a path and its runs, the first of which sets the scale of the drawing.
    #[must_use]
    pub fn new(name: &str, desired: &DesiredPath, series: Vec<Series>) -> Self {
        let tips = desired.tips();
        let period_s = desired.trajectory().period_s();
        let worst = series.first().map_or(0.0, |first| first.errors.iter().map(|e| e.magnitude_mm).fold(0.0, f64::max));
        let drawings = series.iter().map(|run| PathDrawing::new(&run.name, &tips, &displaced(run), worst)).collect();
        let lines: Vec<(String, Vec<f64>)> =
            series.iter().map(|run| (run.name.clone(), run.errors.iter().map(|e| e.magnitude_mm * 1e3).collect())).collect();
        let rows = series
            .iter()
            .enumerate()
            .filter_map(|(i, run)| {
                let figures = summary(&run.errors)?;
                let um = |value: f64| format!("{:.2}", value * 1e3);
                Some(Row {
                    name: run.name.clone(),
                    rms_um: um(figures.rms_mm),
                    max_um: um(figures.max_mm),
                    p95_um: um(figures.p95_mm),
                    color: draw::COLORS[i % draw::COLORS.len()],
                })
            })
            .collect();
        Self { name: name.to_owned(), drawings, chart: Chart::new(&lines, period_s), rows }
    }
}

/// Foot point and error vector of every sample.
fn displaced(run: &Series) -> Vec<(Vec3, Vec3)> {
    run.errors.iter().map(|error| (error.foot, error.vector)).collect()
}

/// The page.
///
/// # Errors
/// When it cannot be rendered.
pub fn report_page(title: &str, paths: &[PathReport]) -> Result<String> {
    let mut environment = Environment::new();
    environment.add_template("report.html", include_str!("report.html"))?;
    Ok(environment.get_template("report.html")?.render(
        context! { title => title, paths => minijinja::Value::from(minijinja::value::Serde(paths)), version => env!("CARGO_PKG_VERSION") },
    )?)
}
