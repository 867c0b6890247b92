//! The report: one self-contained page with the path, the errors over time and the table.

mod draw;

use anyhow::Result;
use minijinja::{Environment, context};
use motion::contour::{ContourError, ContourSummary};
use motion::{DesiredPath, Trajectory, Vec3};
use pipeline::statistics::{self, COUNTED};
use pipeline::units::um;
use pipeline::{Input, Part};
use serde::Serialize;

use draw::{Chart, PathDrawing};

/// One run of a path.
pub struct Series {
    name: String,
    /// One for every sample; without magnitude where the sample does not count, as on rapids.
    errors: Vec<ContourError>,
    /// Figures over the samples that count.
    figures: ContourSummary,
}

impl Series {
    /// The run `actual` of `input`: only what counts there is shown ([`statistics::counts`]).
    ///
    /// # Errors
    /// When the two do not match, or nothing counts.
    pub fn of(name: &str, input: &Input, actual: &Trajectory) -> Result<Self> {
        Self::with(name, input.desired(), input.part(), actual)
    }

    /// As [`Series::of`], of a path that no program states.
    ///
    /// # Errors
    /// As [`Series::of`].
    pub fn of_path(name: &str, desired: &DesiredPath, actual: &Trajectory) -> Result<Self> {
        Self::with(name, desired, None, actual)
    }

    fn with(name: &str, desired: &DesiredPath, part: Option<&Part>, actual: &Trajectory) -> Result<Self> {
        let mut errors = statistics::contour_errors(desired, actual)?;
        let figures = statistics::summary_of_feed_moves(part, errors.iter().copied().enumerate())?;
        for (_, error) in errors.iter_mut().enumerate().filter(|(k, _)| !statistics::counts(part, *k)) {
            (error.magnitude_mm, error.vector) = (0.0, Vec3::zeros());
        }
        Ok(Self { name: name.to_owned(), errors, figures })
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
            .map(|(i, run)| Row {
                name: run.name.clone(),
                rms_um: um(run.figures.rms_mm),
                max_um: um(run.figures.max_mm),
                p95_um: um(run.figures.p95_mm),
                color: draw::COLORS[i % draw::COLORS.len()],
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
        context! { title => title, counted => COUNTED, paths => minijinja::Value::from(minijinja::value::Serde(paths)), version => env!("CARGO_PKG_VERSION") },
    )?)
}
