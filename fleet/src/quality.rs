//! Quality of the logs of a day: lengths, gaps, missing values, tracking errors, by lazy scans of whole files.

use std::path::Path;

use datasets::{ColumnMap, Source, Table};
use polars::prelude::{DataType, Expr, NULL, RollingOptionsFixedWindow, col, len, lit};
use polars::series::ops::NullBehavior;
use serde::Serialize;

use crate::error::Result;
use crate::store::Day;
use crate::table::{collect, numbers, read_table, scan};

/// Window of the rolling statistics, s.
const WINDOW_S: f64 = 10.0;
/// Rows by which columns are recognised and the sampling period is found.
const HEAD: usize = 2000;
/// A step of the time stamps above so many periods is a gap.
const GAP: f64 = 1.5;
/// Lever arm at which a rotary axis is treated as a linear one, mm; the same as in the diagnosis.
pub(crate) const LEVER_MM: f64 = 100.0;

/// Quality of the logs of one axis on one day.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Quality {
    /// Name of the axis.
    pub axis: String,
    /// Rows of all files.
    pub rows: usize,
    /// Logged time, s.
    pub seconds: f64,
    /// Gaps in the time stamps.
    pub gaps: usize,
    /// Rows in which command or actual position is missing.
    pub missing: usize,
    /// RMS tracking error, µm (a rotary axis: on a lever arm of 100 mm).
    pub tracking_rms_um: f64,
    /// Largest RMS tracking error over any 10 s, µm.
    pub tracking_worst_rms_um: f64,
}

/// Quality of the logs of a day, by axis. Files are scanned one after the other, in memory that does not grow with their number.
///
/// # Errors
/// When a file cannot be read or its columns are not recognised.
pub fn quality(day: &Day) -> Result<Vec<Quality>> {
    let mut all: Vec<Quality> = Vec::new();
    for file in &day.files {
        for found in of_file(file)? {
            match all.iter_mut().find(|known| known.axis == found.axis) {
                Some(known) => known.add(&found),
                None => all.push(found),
            }
        }
    }
    Ok(all)
}

impl Quality {
    /// The same of both together.
    fn add(&mut self, other: &Self) {
        let counted = |quality: &Self| quality.rows.saturating_sub(quality.missing) as f64;
        let (own, others) = (counted(self), counted(other));
        let squares = own * self.tracking_rms_um.powi(2) + others * other.tracking_rms_um.powi(2);
        self.tracking_rms_um = (squares / (own + others).max(1.0)).sqrt();
        self.tracking_worst_rms_um = self.tracking_worst_rms_um.max(other.tracking_worst_rms_um);
        self.rows += other.rows;
        self.seconds += other.seconds;
        self.gaps += other.gaps;
        self.missing += other.missing;
    }
}

/// Columns of the figures of one axis in the query.
const FIGURES: usize = 3;

fn of_file(file: &Path) -> Result<Vec<Quality>> {
    let head = read_table(file, HEAD)?;
    let map = ColumnMap::recognise(file, &head)?;
    let period_s = period_s(&head, map.time);
    let window = (WINDOW_S / period_s.unwrap_or(1e-3)).round().max(2.0) as usize;
    let rolling =
        RollingOptionsFixedWindow { window_size: window, min_periods: window / 2, ..RollingOptionsFixedWindow::default() };
    let number = |source: Source| col(head.names[source.column].as_str()).cast(DataType::Float64) * lit(source.scale);
    let mut figures: Vec<Expr> =
        vec![len().cast(DataType::Float64).alias("rows"), gaps(map.time.map(number), period_s).alias("gaps")];
    for columns in &map.axes {
        let name = columns.axis.name.as_str();
        let per_um = if columns.axis.kind == motion::AxisKind::Rotary { LEVER_MM * 1e3 } else { 1e3 };
        let error = ((number(columns.reference) - number(columns.actual)) * lit(per_um)).fill_nan(lit(NULL));
        let square = error.clone() * error.clone();
        figures.push(error.is_null().sum().cast(DataType::Float64).alias(format!("{name} missing")));
        let worst = square.clone().rolling_mean(rolling.clone()).max().sqrt();
        figures.push(square.mean().sqrt().alias(format!("{name} rms")));
        figures.push(worst.alias(format!("{name} worst")));
    }
    let found = numbers(&collect(scan(file)?.select(figures), file)?, file)?;
    let figure = |column: usize| found.get(column).and_then(|column| column.first()).copied().unwrap_or(f64::NAN);
    let (rows, gaps) = (figure(0), figure(1));
    let axis = |(index, columns): (usize, &datasets::columns::AxisColumns)| {
        let at = 2 + FIGURES * index;
        let rms = figure(at + 1);
        Quality {
            axis: columns.axis.name.clone(),
            rows: rows as usize,
            seconds: rows * period_s.unwrap_or(f64::NAN),
            gaps: gaps as usize,
            missing: figure(at) as usize,
            tracking_rms_um: rms,
            // Files shorter than half of the window have one window.
            tracking_worst_rms_um: Some(figure(at + 2)).filter(|worst| worst.is_finite()).unwrap_or(rms),
        }
    };
    Ok(map.axes.iter().enumerate().map(axis).collect())
}

/// Number of gaps in the time stamps; none without time stamps.
fn gaps(time: Option<Expr>, period_s: Option<f64>) -> Expr {
    match (time, period_s) {
        (Some(time), Some(period_s)) => {
            time.diff(lit(1), NullBehavior::Drop).gt(lit(GAP * period_s)).sum().cast(DataType::Float64)
        }
        _ => lit(0.0),
    }
}

/// Median step of the time stamps, s.
fn period_s(head: &Table, time: Option<Source>) -> Option<f64> {
    let time = time?;
    let column = head.columns.get(time.column)?;
    let mut steps: Vec<f64> = column.windows(2).map(|pair| (pair[1] - pair[0]) * time.scale).filter(|step| *step > 0.0).collect();
    if steps.is_empty() {
        return head.period_s;
    }
    let middle = steps.len() / 2;
    Some(*steps.select_nth_unstable_by(middle, f64::total_cmp).1)
}
