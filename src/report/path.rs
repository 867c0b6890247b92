//! A path with its runs: what the drawing, the time series and the table of worst places show.

use pipeline::units::ErrorUnit;
use serde::Serialize;

use super::column::Column;
use super::run::Run;
use super::thin::thinned;
use super::track::Track;
use super::worst::{Worst, worst};

/// Samples that the page holds of a run: four minutes at 500 Hz whole.
const MOST_SAMPLES: usize = 120_000;

/// A path and its runs, one entry for each sample that the page holds.
#[derive(Debug, Serialize)]
pub struct PathView {
    period_s: f64,
    /// Number of samples of the runs.
    samples: usize,
    /// Which of them the page holds.
    sample: Column,
    line: Option<Column>,
    arc_mm: Column,
    tip_mm: [Column; 3],
    tool: Option<[Column; 3]>,
    counts: Column,
    speed_mm_s: Column,
    acceleration_mm_s2: Column,
    feed_mm_s: Option<Column>,
    axes: Vec<AxisView>,
    runs: Vec<RunView>,
    /// The lines that the path passes, ascending, with their texts.
    lines: Lines,
    /// The worst lines or places of every run.
    worst: Vec<Vec<Worst>>,
}

#[derive(Debug, Serialize)]
struct AxisView {
    name: String,
    unit: &'static str,
}

#[derive(Debug, Serialize)]
struct RunView {
    name: String,
    /// From the tip to the foot point of the error, mm.
    foot_mm: [Column; 3],
    error_um: [Column; 3],
    turn_urad: Option<Column>,
    tracking: Vec<Column>,
    correction: Option<Vec<Column>>,
    max_um: f64,
}

#[derive(Debug, Default, Serialize)]
struct Lines {
    numbers: Vec<usize>,
    texts: Vec<String>,
}

impl PathView {
    /// The view of a path and its runs.
    #[must_use]
    pub fn new(track: &Track<'_>, runs: &[Run]) -> Self {
        let (speed, acceleration) = track.speed_and_acceleration();
        let contour: Vec<Vec<f64>> = runs.iter().map(|run| run.contour_um(track)).collect();
        let kept = kept(track, runs, &contour, [&speed, &acceleration]);
        let scaled = |values: &[f64]| Column::scaled(&picked(&kept, values));
        let tips = track.tips();
        let float = |of: &dyn Fn(usize) -> f64| Column::float(&kept.iter().map(|k| of(*k)).collect::<Vec<f64>>());
        let lines = track.lines();
        let worst = worst(track, runs, &contour, &lines);
        let run_view = |run: &Run| {
            let vector = |of: &dyn Fn(usize) -> f64| {
                let values = kept.iter().map(|k| if track.weights[*k].is_some() { of(*k) } else { f64::NAN });
                Column::scaled(&values.collect::<Vec<f64>>())
            };
            RunView {
                name: run.name.clone(),
                foot_mm: [0, 1, 2].map(|c| vector(&|k| run.errors[k].foot[c] - tips[k][c])),
                error_um: [0, 1, 2].map(|c| vector(&|k| run.errors[k].vector[c] * 1e3)),
                turn_urad: run.turn_urad.as_deref().map(scaled),
                tracking: run.tracking.iter().map(|values| scaled(values)).collect(),
                correction: run.correction.as_ref().map(|columns| columns.iter().map(|values| scaled(values)).collect()),
                max_um: run.figures.max_mm * 1e3,
            }
        };
        Self {
            period_s: track.period_s,
            samples: tips.len(),
            line: track.has_lines().then(|| Column::whole(&kept.iter().map(|k| lines[*k]).collect::<Vec<usize>>())),
            arc_mm: Column::float(&picked(&kept, &track.arc_mm())),
            tip_mm: [0, 1, 2].map(|c| float(&|k| tips[k][c])),
            tool: track
                .turns()
                .then(|| [0, 1, 2].map(|c| scaled(&track.poses.iter().map(|pose| pose.tool[c]).collect::<Vec<f64>>()))),
            counts: Column::flags(&kept.iter().map(|k| track.weights[*k].is_some()).collect::<Vec<bool>>()),
            speed_mm_s: scaled(&speed),
            acceleration_mm_s2: scaled(&acceleration),
            feed_mm_s: track.feeds_mm_s().as_deref().map(scaled),
            axes: track
                .axes()
                .iter()
                .map(|axis| AxisView { name: axis.name.clone(), unit: ErrorUnit::from(axis).sign() })
                .collect(),
            runs: runs.iter().map(run_view).collect(),
            lines: passed(track, kept.iter().map(|k| lines[*k]).chain(worst.iter().flatten().map(|place| place.line)).collect()),
            worst,
            sample: Column::whole(&kept),
        }
    }
}

/// The samples that the page holds.
fn kept(track: &Track<'_>, runs: &[Run], contour: &[Vec<f64>], of_path: [&[f64]; 2]) -> Vec<usize> {
    let mut columns: Vec<&[f64]> = of_path.to_vec();
    columns.extend(contour.iter().map(Vec::as_slice));
    for run in runs {
        columns.extend(run.tracking.iter().chain(run.correction.iter().flatten()).map(Vec::as_slice));
        columns.extend(run.turn_urad.as_deref());
    }
    thinned(MOST_SAMPLES, &columns, &track.tips())
}

fn picked(kept: &[usize], values: &[f64]) -> Vec<f64> {
    kept.iter().map(|k| values[*k]).collect()
}

fn passed(track: &Track<'_>, mut numbers: Vec<usize>) -> Lines {
    numbers.retain(|line| *line > 0);
    numbers.sort_unstable();
    numbers.dedup();
    Lines { texts: numbers.iter().map(|line| track.text(*line)).collect(), numbers }
}
