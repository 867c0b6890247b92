//! The runs of one axis, prepared for fitting: errors, scored segments, folds.

use std::ops::Range;

use models::AxisSignal;
use models::staged::{FeatureSet, Pass, ServoBase, Signals};
use motion::quantile;
use nalgebra::{DMatrix, DMatrixViewMut, DVectorViewMut};

use super::gram::{FoldGrams, Gram};
use super::recipe::StagedRecipe;
use crate::{AxisRun, TrainingError};

/// Rows per block.
const BLOCK_ROWS: usize = 1024;
/// Distance of the fitted rows, s, and their minimum number. The error hardly changes between
/// closer rows: more rows cost time without new information. On random machines 3 to 6, `ballscrew`
/// and `worn` (60 s of log), fits to every second and every fourth row gave first runs with 0.89 to
/// 1.06 times the contour error of fits to every row.
const ROW_DISTANCE_S: f64 = 0.004;
const LEAST_ROWS: usize = 16_000;

/// Share of the top speed below which a motion ends.
const STANDSTILL_SHARE: f64 = 0.02;
/// Number of speed bands that are left out in turn; see [`FoldGrams::carry_over`].
const BANDS: usize = 3;

/// Rows collected for a sum of products, a block at a time.
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

    /// Number of rows that can be added at once.
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

/// Writes columns of a run from a given row on; see [`AxisDataset::grams_with`].
pub type Fill<'a> = dyn Fn(usize, usize, DMatrixViewMut<'_, f64>) + Sync + 'a;

/// A segment of a run that belongs to one fold and one speed band.
#[derive(Debug, Clone)]
struct Segment {
    run: usize,
    rows: Range<usize>,
    fold: usize,
    band: usize,
}

/// All runs of one axis.
#[derive(Debug)]
pub struct AxisDataset<'a> {
    runs: &'a [AxisRun],
    /// Position that the passes start from: the reference, or that of a servo model.
    bases: Vec<Vec<f64>>,
    /// That position less the actual one.
    errors: Vec<Vec<f64>>,
    /// Offset of the motor from the table at the start of each run.
    starts: Vec<f64>,
    segments: Vec<Segment>,
    folds: usize,
    period_s: f64,
    /// One of this many rows is fitted.
    stride: usize,
    /// Scale of this axis: lengths and speeds of the recipe are multiplied by it.
    pub unit: f64,
}

impl<'a> AxisDataset<'a> {
    /// Checks the runs and assigns the folds. The passes start from the position of `servo`, or from the reference.
    ///
    /// # Errors
    /// When the runs do not fit together, are too short, or never move.
    pub fn new(runs: &'a [AxisRun], servo: Option<&ServoBase>, recipe: &StagedRecipe) -> Result<Self, TrainingError> {
        let period_s = runs.first().map_or(0.0, |run| run.period_s);
        if !(period_s.is_finite() && period_s > 0.0) {
            return Err(TrainingError::Unusable("no run with a period".into()));
        }
        let mut speeds = Vec::new();
        let (mut bases, mut errors) = (Vec::new(), Vec::new());
        for (index, run) in runs.iter().enumerate() {
            let unusable = |why: &str| TrainingError::Unusable(format!("run {index}: {why}"));
            if (run.period_s / period_s - 1.0).abs() > 1e-6 {
                return Err(unusable("its sampling period is another"));
            }
            if run.reference.len() != run.actual.len() {
                return Err(unusable("reference and actual have different lengths"));
            }
            let base = match servo {
                Some(servo) => servo.follow(&AxisSignal::uncompensated(&run.reference, run.period_s)),
                None => run.reference.clone(),
            };
            let error: Vec<f64> = base.iter().zip(&run.actual).map(|(x, actual)| x - actual).collect();
            bases.push(base);
            if error.iter().any(|e| !e.is_finite()) {
                return Err(unusable("a position is not a number"));
            }
            speeds.extend(run.reference.windows(2).map(|pair| (pair[1] - pair[0]).abs() / period_s).filter(|v| *v > 0.0));
            errors.push(error);
        }
        let top = quantile(&mut speeds, 0.995).ok_or_else(|| TrainingError::Unusable("the axis never moves".into()))?;
        let scored: Vec<Vec<Range<usize>>> = runs.iter().map(AxisRun::scored).collect();
        let total: usize = scored.iter().flatten().map(ExactSizeIterator::len).sum();
        // A few runs are cut into blocks, so that there are enough folds for a significance test.
        let by_run = runs.len() >= recipe.folds;
        let folds = recipe.folds;
        if folds < 2 || total < 50 * folds {
            return Err(TrainingError::Unusable(format!("{total} samples are too few for {folds} folds")));
        }
        let unit = top / recipe.speed_unit;
        Ok(Self {
            starts: starts(runs, &errors, recipe.least_half_width(unit)),
            segments: by_speed(segments(&scored, folds, by_run), runs, STANDSTILL_SHARE * top * period_s),
            runs,
            bases,
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

    /// Number of rows that may be fitted and scored.
    pub fn samples(&self) -> usize {
        self.segments.iter().map(|s| s.rows.len()).sum()
    }

    /// One of this many rows is fitted.
    pub fn stride(&self) -> usize {
        self.stride
    }

    /// Copies the fitted rows of a series, from its first row on.
    fn thin(&self, series: &[f64], to: &mut DVectorViewMut<'_, f64>) {
        to.iter_mut().zip(series.iter().step_by(self.stride)).for_each(|(to, from)| *to = *from);
    }

    /// Number of fitted rows.
    pub fn fitted(&self) -> usize {
        self.samples() / self.stride
    }

    /// The reference of a run.
    pub fn reference(&self, run: usize) -> &[f64] {
        &self.runs[run].reference
    }

    /// Expected positions of the first pass.
    pub fn bases(&self) -> Vec<Vec<f64>> {
        self.bases.clone()
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

    /// Prediction of `pass` on each run at the given expected positions.
    pub fn predictions(&self, pass: &Pass, expected: &[Vec<f64>]) -> Vec<Vec<f64>> {
        self.signals(&pass.features, expected).iter().map(|signals| pass.features.predict(signals, &pass.weights)).collect()
    }

    /// Expected position of each run after `pass`, which ran on `expected`.
    pub fn expected_after(&self, pass: &Pass, expected: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let after = |(base, signals): (&Vec<f64>, Signals)| {
            let error = pass.features.predict(&signals, &pass.weights);
            pass.position(base, &signals, &error)
        };
        self.bases.iter().zip(self.signals(&pass.features, expected)).map(after).collect()
    }

    /// Expected position of each run after `passes` in order.
    pub fn expected_through(&self, passes: &[Pass]) -> Vec<Vec<f64>> {
        passes.iter().fold(self.bases(), |expected, pass| self.expected_after(pass, &expected))
    }

    /// Every scored row as `(run, row)`.
    pub fn rows(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.segments.iter().flat_map(|s| s.rows.clone().map(move |row| (s.run, row)))
    }

    /// What the passes predict in each run: the tracking error, less what the servo model explains.
    pub fn errors(&self) -> &[Vec<f64>] {
        &self.errors
    }

    /// Sum of `cost` over the fitted rows and number of these rows, per fold.
    pub fn by_fold(&self, cost: impl Fn(usize, usize) -> f64) -> (Vec<f64>, Vec<usize>) {
        let mut sums = vec![0.0; self.folds];
        let mut samples = vec![0; self.folds];
        for segment in &self.segments {
            let rows = segment.rows.start.next_multiple_of(self.stride)..segment.rows.end;
            sums[segment.fold] += rows.clone().step_by(self.stride).map(|k| cost(segment.run, k)).sum::<f64>();
            samples[segment.fold] += rows.len().div_ceil(self.stride);
        }
        (sums, samples)
    }

    /// Residual of `pass` for each run: [`Self::errors`] less prediction.
    pub fn left_by(&self, pass: &Pass, expected: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let predictions = self.predictions(pass, expected);
        self.errors
            .iter()
            .zip(predictions)
            .map(|(error, predicted)| error.iter().zip(predicted).map(|(e, p)| e - p).collect())
            .collect()
    }

    /// Normal equations of `target` (one series per run) on the features and on `extra` columns
    /// (one list per column, one series per run).
    pub fn grams(&self, features: &FeatureSet, signals: &[Signals], extra: &[Vec<Vec<f64>>], target: &[Vec<f64>]) -> FoldGrams {
        let fill = |run: usize, start: usize, mut columns: DMatrixViewMut<'_, f64>| {
            for (mut column, series) in columns.column_iter_mut().zip(extra) {
                self.thin(&series[run][start..], &mut column);
            }
        };
        self.grams_with(features, signals, (extra.len(), &fill), target)
    }

    /// As [`Self::grams`], with extra columns written by a function, block by block. It receives
    /// the run, the first row, and these columns at the fitted rows ([`Self::stride`] apart),
    /// followed by the target, which it may change.
    ///
    /// Each fold is collected separately, so that the sums do not depend on the number of threads.
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
            for segment in self.segments.iter().filter(|s| s.fold == fold) {
                // Rows keep their distance across the segments of a run.
                let mut start = segment.rows.start.next_multiple_of(self.stride);
                while start < segment.rows.end {
                    let gathered = &mut gathered[segment.band];
                    let rows = (segment.rows.end - start).div_ceil(self.stride).min(gathered.room());
                    let mut block = features.block(&signals[segment.run], start, rows, self.stride, extra + 1);
                    self.thin(&target[segment.run][start..], &mut block.column_mut(columns));
                    fill(segment.run, start, block.columns_mut(features.columns(), extra + 1));
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

/// Shortest standstill after which the start of a run is known, s.
const STANDSTILL_S: f64 = 0.02;

/// Position of the table within the backlash at the start of each run: the tracking error at
/// standstill, where an integrator holds the motor on its command. Known only if runs start on both
/// sides by more than `least`; an error of one sign is an offset.
fn starts(runs: &[AxisRun], errors: &[Vec<f64>], least: f64) -> Vec<f64> {
    let start = |(run, error): (&AxisRun, &Vec<f64>)| {
        let still = run.reference.iter().take_while(|x| **x == run.reference[0]).count();
        let known = still as f64 * run.period_s >= STANDSTILL_S
            && run.rows.first().is_some_and(|rows| rows.start == 0 && rows.end >= still);
        if known { error[..still].iter().sum::<f64>() / still as f64 } else { 0.0 }
    };
    let starts: Vec<f64> = runs.iter().zip(errors).map(start).collect();
    let on_either_side = starts.iter().any(|start| *start > least) && starts.iter().any(|start| *start < -least);
    if on_either_side { starts } else { vec![0.0; runs.len()] }
}

/// Assigns whole runs to folds, or contiguous blocks if there are too few runs.
fn segments(scored: &[Vec<Range<usize>>], folds: usize, by_run: bool) -> Vec<Segment> {
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
            out.push(Segment { run, rows: start..end, fold, band: 0 });
            seen += end - start;
            start = end;
        }
    }
    out
}

/// Cuts segments where the axis nearly stops, and sorts the pieces into bands of their top speed.
fn by_speed(segments: Vec<Segment>, runs: &[AxisRun], slowest: f64) -> Vec<Segment> {
    let mut pieces: Vec<(f64, Segment)> = Vec::new();
    for segment in segments {
        let reference = &runs[segment.run].reference;
        let velocity = |k: usize| if k == 0 { 0.0 } else { reference[k] - reference[k - 1] };
        let mut start = segment.rows.start;
        while start < segment.rows.end {
            // A piece is a standstill or slow crossing, then the motion up to the next.
            let moving = (start..segment.rows.end).find(|&k| velocity(k).abs() > slowest);
            let end = (moving.unwrap_or(segment.rows.end)..segment.rows.end)
                .find(|&k| velocity(k).abs() <= slowest)
                .unwrap_or(segment.rows.end);
            let top = (start..end).map(|k| velocity(k).abs()).fold(0.0, f64::max);
            let piece = Segment { rows: start..end, ..segment.clone() };
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
        .map(|(top, piece)| Segment { band: limits.iter().position(|limit| top <= *limit).unwrap_or(BANDS - 1), ..piece })
        .collect()
}
