//! The runs of one axis, made ready for fitting: errors, scored stretches, folds.

use std::ops::Range;

use models::staged::{FeatureSet, Pass, Signals};
use motion::quantile;
use nalgebra::{DMatrix, DMatrixViewMut, DVectorViewMut};

use super::gram::{FoldGrams, Gram};
use super::recipe::StagedRecipe;
use crate::{AxisRun, TrainingError};

/// Rows gathered at once.
const BLOCK_ROWS: usize = 1024;
/// Distance of the rows that are fitted, s, and the least number of them. Between rows so close an error hardly changes: more of them cost time and say nothing
/// new. On random machines 3 to 6, `ballscrew` and `worn` (60 s of log) fits to every second and every fourth row made first runs of 0.89 to 1.06 times the contour
/// error of fits to every row.
const ROW_DISTANCE_S: f64 = 0.004;
const LEAST_ROWS: usize = 16_000;

/// Share of the top speed below which a motion is taken to end.
const REST_SHARE: f64 = 0.02;
/// Bands of speed that are left out in turn; see [`FoldGrams::carry_over`].
const BANDS: usize = 3;

/// Rows on their way into a sum of products, a block at a time.
#[derive(Debug, Clone)]
struct Gathered {
    gram: Gram,
    block: DMatrix<f64>,
    rows: usize,
}

impl Gathered {
    fn new(columns: usize) -> Self {
        Self { gram: Gram::new(columns), block: DMatrix::zeros(BLOCK_ROWS, columns + 1), rows: 0 }
    }

    /// Rows that can be added at once.
    fn room(&self) -> usize {
        BLOCK_ROWS - self.rows
    }

    fn add(&mut self, rows: &DMatrix<f64>) {
        self.block.rows_mut(self.rows, rows.nrows()).copy_from(rows);
        self.rows += rows.nrows();
        if self.room() == 0 {
            self.gram.add(&self.block);
            self.rows = 0;
        }
    }

    fn finish(mut self) -> Gram {
        self.gram.add(&self.block.rows(0, self.rows).into_owned());
        self.gram.finish();
        self.gram
    }
}

/// Writes columns of a run from a row on; see [`AxisDataset::grams_with`].
pub type Fill<'a> = dyn Fn(usize, usize, DMatrixViewMut<'_, f64>) + Sync + 'a;

/// A stretch of a run that belongs to one fold and one band of speed.
#[derive(Debug, Clone)]
struct Stretch {
    run: usize,
    rows: Range<usize>,
    fold: usize,
    band: usize,
}

/// All runs of one axis.
#[derive(Debug)]
pub struct AxisDataset<'a> {
    runs: &'a [AxisRun],
    errors: Vec<Vec<f64>>,
    /// How far the motor is off the table when each run begins.
    starts: Vec<f64>,
    stretches: Vec<Stretch>,
    folds: usize,
    period_s: f64,
    /// Every so many rows one is fitted.
    stride: usize,
    /// Lengths and speeds of the recipe times this are those of this axis.
    pub unit: f64,
}

impl<'a> AxisDataset<'a> {
    /// Checks the runs and lays out the folds.
    ///
    /// # Errors
    /// When the runs do not fit together, are too short, or never move.
    pub fn new(runs: &'a [AxisRun], recipe: &StagedRecipe) -> Result<Self, TrainingError> {
        let period_s = runs.first().map_or(0.0, |run| run.period_s);
        if !(period_s.is_finite() && period_s > 0.0) {
            return Err(TrainingError::Unusable("no run with a period".into()));
        }
        let mut speeds = Vec::new();
        let mut errors = Vec::new();
        for (index, run) in runs.iter().enumerate() {
            let unusable = |why: &str| TrainingError::Unusable(format!("run {index}: {why}"));
            if (run.period_s / period_s - 1.0).abs() > 1e-6 {
                return Err(unusable("its sampling period is another"));
            }
            if run.reference.len() != run.actual.len() {
                return Err(unusable("reference and actual have different lengths"));
            }
            let error = run.tracking_error();
            if error.iter().any(|e| !e.is_finite()) {
                return Err(unusable("a position is not a number"));
            }
            speeds.extend(run.reference.windows(2).map(|pair| (pair[1] - pair[0]).abs() / period_s).filter(|v| *v > 0.0));
            errors.push(error);
        }
        let top = quantile(&mut speeds, 0.995).ok_or_else(|| TrainingError::Unusable("the axis never moves".into()))?;
        let scored: Vec<Vec<Range<usize>>> = runs.iter().map(AxisRun::scored).collect();
        let total: usize = scored.iter().flatten().map(ExactSizeIterator::len).sum();
        // Few runs are cut into blocks, so that there are folds enough to tell a gain from chance.
        let by_run = runs.len() >= recipe.folds;
        let folds = recipe.folds;
        if folds < 2 || total < 50 * folds {
            return Err(TrainingError::Unusable(format!("{total} samples are too few for {folds} folds")));
        }
        let unit = top / recipe.speed_unit;
        Ok(Self {
            starts: starts(runs, &errors, recipe.least_half_width(unit)),
            stretches: by_speed(stretches(&scored, folds, by_run), runs, REST_SHARE * top * period_s),
            runs,
            errors,
            folds,
            period_s,
            stride: ((ROW_DISTANCE_S / period_s).round() as usize).min(total / LEAST_ROWS).max(1),
            unit,
        })
    }

    /// Sampling period, s.
    pub fn period_s(&self) -> f64 {
        self.period_s
    }

    /// Number of folds.
    pub fn folds(&self) -> usize {
        self.folds
    }

    /// Rows that may be fitted and scored.
    pub fn samples(&self) -> usize {
        self.stretches.iter().map(|s| s.rows.len()).sum()
    }

    /// Every so many rows one is fitted.
    pub fn stride(&self) -> usize {
        self.stride
    }

    /// Copies what is fitted of a series, from its first row on.
    fn thin(&self, series: &[f64], to: &mut DVectorViewMut<'_, f64>) {
        to.iter_mut().zip(series.iter().step_by(self.stride)).for_each(|(to, from)| *to = *from);
    }

    /// Those of them that are fitted.
    pub fn fitted(&self) -> usize {
        self.samples() / self.stride
    }

    /// The references, as expected positions of a first pass.
    pub fn references(&self) -> Vec<Vec<f64>> {
        self.runs.iter().map(|run| run.reference.clone()).collect()
    }

    /// Lowest and highest commanded position.
    pub fn travel(&self) -> (f64, f64) {
        self.runs
            .iter()
            .flat_map(|run| &run.reference)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &x| (low.min(x), high.max(x)))
    }

    /// Signals of every run on its expected positions.
    pub fn signals(&self, features: &FeatureSet, expected: &[Vec<f64>]) -> Vec<Signals> {
        let of = |((run, x), start): ((&AxisRun, &Vec<f64>), &f64)| {
            features.signals(&run.reference, &run.reference, x, run.period_s, *start)
        };
        self.runs.iter().zip(expected).zip(&self.starts).map(of).collect()
    }

    /// Prediction of `pass` on each run, whose expected positions are given.
    pub fn predictions(&self, pass: &Pass, expected: &[Vec<f64>]) -> Vec<Vec<f64>> {
        self.signals(&pass.features, expected).iter().map(|signals| pass.features.predict(signals, &pass.weights)).collect()
    }

    /// Position that each run is expected to take after `pass`, which ran on `expected`.
    pub fn expected_after(&self, pass: &Pass, expected: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let after = |(run, signals): (&AxisRun, Signals)| {
            let error = pass.features.predict(&signals, &pass.weights);
            pass.position(&run.reference, &signals, &error)
        };
        self.runs.iter().zip(self.signals(&pass.features, expected)).map(after).collect()
    }

    /// Position that each run is expected to take after `passes`, one after the other.
    pub fn expected_through(&self, passes: &[Pass]) -> Vec<Vec<f64>> {
        passes.iter().fold(self.references(), |expected, pass| self.expected_after(pass, &expected))
    }

    /// Every scored row as `(run, row)`.
    pub fn rows(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.stretches.iter().flat_map(|s| s.rows.clone().map(move |row| (s.run, row)))
    }

    /// Tracking error of each run.
    pub fn errors(&self) -> &[Vec<f64>] {
        &self.errors
    }

    /// Sum of `cost` over the rows that are fitted, fold by fold, with the number of each.
    pub fn by_fold(&self, cost: impl Fn(usize, usize) -> f64) -> (Vec<f64>, Vec<usize>) {
        let mut sums = vec![0.0; self.folds];
        let mut samples = vec![0; self.folds];
        for stretch in &self.stretches {
            let rows = stretch.rows.start.next_multiple_of(self.stride)..stretch.rows.end;
            sums[stretch.fold] += rows.clone().step_by(self.stride).map(|k| cost(stretch.run, k)).sum::<f64>();
            samples[stretch.fold] += rows.len().div_ceil(self.stride);
        }
        (sums, samples)
    }

    /// What `pass` leaves of the tracking error of each run.
    pub fn left_by(&self, pass: &Pass, expected: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let predictions = self.predictions(pass, expected);
        self.errors
            .iter()
            .zip(predictions)
            .map(|(error, predicted)| error.iter().zip(predicted).map(|(e, p)| e - p).collect())
            .collect()
    }

    /// Normal equations of `target` (one series a run) on the features and on `extra` columns (one list a column, one series a run).
    pub fn grams(&self, features: &FeatureSet, signals: &[Signals], extra: &[Vec<Vec<f64>>], target: &[Vec<f64>]) -> FoldGrams {
        let fill = |run: usize, start: usize, mut columns: DMatrixViewMut<'_, f64>| {
            for (mut column, series) in columns.column_iter_mut().zip(extra) {
                self.thin(&series[run][start..], &mut column);
            }
        };
        self.grams_with(features, signals, (extra.len(), &fill), target)
    }

    /// The same with so many columns that a function writes, a block at a time: it is told the run and the first row, and given these columns at the rows
    /// that are fitted ([`Self::stride`] apart) and after them the target, which it may change.
    ///
    /// Folds are gathered each on its own, so the sums do not depend on how many threads share them.
    pub fn grams_with(
        &self,
        features: &FeatureSet,
        signals: &[Signals],
        (extra, fill): (usize, &Fill<'_>),
        target: &[Vec<f64>],
    ) -> FoldGrams {
        let columns = features.columns() + extra;
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let gather = |fold: usize| -> Vec<Gram> {
            let mut gathered = vec![Gathered::new(columns); BANDS];
            for stretch in self.stretches.iter().filter(|s| s.fold == fold) {
                // Rows keep their distance across the stretches of a run.
                let mut start = stretch.rows.start.next_multiple_of(self.stride);
                while start < stretch.rows.end {
                    let gathered = &mut gathered[stretch.band];
                    let rows = (stretch.rows.end - start).div_ceil(self.stride).min(gathered.room());
                    let mut block = features.block(&signals[stretch.run], start, rows, self.stride, extra + 1);
                    self.thin(&target[stretch.run][start..], &mut block.column_mut(columns));
                    fill(stretch.run, start, block.columns_mut(features.columns(), extra + 1));
                    gathered.add(&block);
                    start += rows * self.stride;
                }
            }
            gathered.into_iter().map(Gathered::finish).collect()
        };
        let mut cells: Vec<(usize, Vec<Gram>)> = std::thread::scope(|scope| {
            let workers: Vec<_> = (0..threads.min(self.folds))
                .map(|worker| {
                    let gather = &gather;
                    scope
                        .spawn(move || (worker..self.folds).step_by(threads).map(|fold| (fold, gather(fold))).collect::<Vec<_>>())
                })
                .collect();
            workers
                .into_iter()
                .flat_map(|worker| worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
                .collect()
        });
        cells.sort_by_key(|(fold, _)| *fold);
        let cells: Vec<Vec<Gram>> = cells.into_iter().map(|(_, grams)| grams).collect();
        FoldGrams::new(&cells, columns)
    }
}

/// Shortest rest from which the start of a run is known, s.
const REST_S: f64 = 0.02;

/// Where a table lies within the play when each run begins: the error at rest, which an integrator keeps off the motor. Known only where
/// runs begin on either side by more than `least`; an error of one sign is an offset.
fn starts(runs: &[AxisRun], errors: &[Vec<f64>], least: f64) -> Vec<f64> {
    let start = |(run, error): (&AxisRun, &Vec<f64>)| {
        let still = run.reference.iter().take_while(|x| **x == run.reference[0]).count();
        let known =
            still as f64 * run.period_s >= REST_S && run.rows.first().is_some_and(|rows| rows.start == 0 && rows.end >= still);
        if known { error[..still].iter().sum::<f64>() / still as f64 } else { 0.0 }
    };
    let starts: Vec<f64> = runs.iter().zip(errors).map(start).collect();
    let on_either_side = starts.iter().any(|start| *start > least) && starts.iter().any(|start| *start < -least);
    if on_either_side { starts } else { vec![0.0; runs.len()] }
}

/// Whole runs dealt out to folds, or contiguous blocks where there are too few runs for that.
fn stretches(scored: &[Vec<Range<usize>>], folds: usize, by_run: bool) -> Vec<Stretch> {
    let total: usize = scored.iter().flatten().map(ExactSizeIterator::len).sum();
    let block = if by_run { usize::MAX } else { total.div_ceil(folds).max(1) };
    let mut out = Vec::new();
    let mut seen = 0_usize;
    for (run, rows) in scored.iter().enumerate().flat_map(|(run, ranges)| ranges.iter().map(move |rows| (run, rows))) {
        let mut start = rows.start;
        while start < rows.end {
            let (length, fold) =
                if by_run { (rows.end - start, run % folds) } else { (block - seen % block, (seen / block).min(folds - 1)) };
            let end = rows.end.min(start.saturating_add(length));
            out.push(Stretch { run, rows: start..end, fold, band: 0 });
            seen += end - start;
            start = end;
        }
    }
    out
}

/// Cuts stretches where the axis all but stops, and sorts the pieces into bands of their top speed.
fn by_speed(stretches: Vec<Stretch>, runs: &[AxisRun], slowest: f64) -> Vec<Stretch> {
    let mut pieces: Vec<(f64, Stretch)> = Vec::new();
    for stretch in stretches {
        let reference = &runs[stretch.run].reference;
        let velocity = |k: usize| if k == 0 { 0.0 } else { reference[k] - reference[k - 1] };
        let mut start = stretch.rows.start;
        while start < stretch.rows.end {
            // A piece is a rest or slow crossing, then the motion up to the next.
            let moving = (start..stretch.rows.end).find(|&k| velocity(k).abs() > slowest);
            let end = (moving.unwrap_or(stretch.rows.end)..stretch.rows.end)
                .find(|&k| velocity(k).abs() <= slowest)
                .unwrap_or(stretch.rows.end);
            let top = (start..end).map(|k| velocity(k).abs()).fold(0.0, f64::max);
            let piece = Stretch { rows: start..end, ..stretch.clone() };
            pieces.push((top, piece));
            start = end;
        }
    }
    let mut tops: Vec<(f64, usize)> = pieces.iter().map(|(top, piece)| (*top, piece.rows.len())).collect();
    tops.sort_by(|a, b| a.0.total_cmp(&b.0));
    let total: usize = tops.iter().map(|(_, rows)| rows).sum();
    let mut limits = [f64::INFINITY; BANDS];
    let mut seen = 0;
    for (top, rows) in tops {
        let band = (seen * BANDS / total.max(1)).min(BANDS - 1);
        // Motions of the same speed stay in one band.
        limits[band] = top * (1.0 + 1e-3);
        seen += rows;
    }
    limits[BANDS - 1] = f64::INFINITY;
    pieces
        .into_iter()
        .map(|(top, piece)| Stretch { band: limits.iter().position(|limit| top <= *limit).unwrap_or(BANDS - 1), ..piece })
        .collect()
}
