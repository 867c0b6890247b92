//! What a fitting procedure reaches on rows that neither fitted nor chose its result.

use std::ops::Range;

use datasets::Fold;
use models::{AxisPredictor, AxisSignal, PredictionInterval, Spread};
use training::AxisRun;

use crate::statistics::rms_max;

/// Errors of a prediction over rows of a run that were held out from it: prediction minus measurement, mm or rad.
#[derive(Debug, Clone, PartialEq)]
pub struct Piece {
    /// Index of the run.
    pub run: usize,
    /// The rows.
    pub rows: Range<usize>,
    /// One a row.
    pub errors: Vec<f64>,
}

/// One fold, judged: what a rich predictor and what a simpler one, neither fitted to it, make of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Judged {
    /// Errors of the rich predictor.
    pub rich: Vec<Piece>,
    /// Errors of the simpler one on the same rows.
    pub simple: Vec<Piece>,
}

/// Which of the two is kept, and the errors that speak for it.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// Whether the simpler one is kept.
    pub simple: bool,
    /// On every row held out, the errors of the predictor that the other rows chose.
    pub pieces: Vec<Piece>,
}

/// All runs with the rows that the fold does not hold out; runs of which nothing is left are left out.
#[must_use]
pub fn without(runs: &[AxisRun], fold: &Fold) -> Vec<AxisRun> {
    let kept = runs.iter().zip(fold).map(|(run, rows)| run.without(rows));
    kept.filter(|run| !run.rows.is_empty()).collect()
}

/// All runs, each with the rows that the fold holds out of it, which may be none.
#[must_use]
pub fn only(runs: &[AxisRun], fold: &Fold) -> Vec<AxisRun> {
    runs.iter().zip(fold).map(|(run, rows)| run.only(rows)).collect()
}

/// Errors on the scored rows of `runs`, in order; `runs` hold those rows alone.
#[must_use]
pub fn pieces(predictor: &dyn AxisPredictor, runs: &[AxisRun]) -> Vec<Piece> {
    let of = |(index, run): (usize, &AxisRun)| -> Vec<Piece> {
        let rows = run.scored();
        if rows.is_empty() {
            return Vec::new();
        }
        let predicted = predictor.predict(&AxisSignal::uncompensated(&run.reference, run.period_s));
        let error = |k: usize| predicted[k] - (run.reference[k] - run.actual[k]);
        rows.into_iter().map(|rows| Piece { run: index, errors: rows.clone().map(error).collect(), rows }).collect()
    };
    runs.iter().enumerate().flat_map(of).collect()
}

/// Keeps the simpler predictor where the rich predictor does worse on the rows held out, if there is a choice.
///
/// A part of the rows is judged by what the other parts choose, so that the figures are not those of a choice made by themselves. The
/// parts are the folds, or the two halves of a single one.
#[must_use]
pub fn choose(folds: &[Judged], free: bool) -> Choice {
    let parts: Vec<Judged> = match folds {
        [only] => halves(only),
        _ => folds.to_vec(),
    };
    let costs: Vec<f64> = parts.iter().map(gain_of_simple).collect();
    let prefers_simple = |without: Option<usize>| {
        let others = costs.iter().enumerate().filter(|(index, _)| Some(*index) != without);
        free && others.map(|(_, cost)| cost).sum::<f64>() > 0.0
    };
    let judged =
        |(index, part): (usize, &Judged)| if prefers_simple(Some(index)) { part.simple.clone() } else { part.rich.clone() };
    Choice { simple: prefers_simple(None), pieces: parts.iter().enumerate().flat_map(judged).collect() }
}

/// Largest ratio of two errors that counts.
const MOST_RATIO: f64 = 5.0;

/// Sum over the rows of the logarithm of the rich predictor's error over the simpler one's, both over a piece.
///
/// Logarithms let every run speak: sums of squares are those of the one run whose kind the others lack, and the kept predictor is fitted to that one too.
fn gain_of_simple(judged: &Judged) -> f64 {
    let gain = |(rich, simple): (&Piece, &Piece)| {
        let (rich_rms, simple_rms) = (rms_max(&rich.errors).0, rms_max(&simple.errors).0);
        let ratio = if rich_rms > 0.0 || simple_rms > 0.0 { rich_rms / simple_rms } else { 1.0 };
        ratio.clamp(1.0 / MOST_RATIO, MOST_RATIO).ln() * rich.errors.len() as f64
    };
    judged.rich.iter().zip(&judged.simple).map(gain).sum()
}

/// A fold in two, by rows.
fn halves(fold: &Judged) -> Vec<Judged> {
    let half = |of: &[Piece], second: bool| -> Vec<Piece> {
        let total: usize = of.iter().map(|piece| piece.errors.len()).sum();
        let mut seen = 0;
        let mut out = Vec::new();
        for piece in of {
            let cut = (total / 2).saturating_sub(seen).min(piece.errors.len());
            seen += piece.errors.len();
            let part = if second { cut..piece.errors.len() } else { 0..cut };
            if !part.is_empty() {
                let rows = piece.rows.start + part.start..piece.rows.start + part.end;
                out.push(Piece { run: piece.run, rows, errors: piece.errors[part].to_vec() });
            }
        }
        out
    };
    [false, true].map(|second| Judged { rich: half(&fold.rich, second), simple: half(&fold.simple, second) }).to_vec()
}

/// Tracking errors of the rows of `pieces`.
#[must_use]
pub fn tracking_errors(runs: &[AxisRun], pieces: &[Piece]) -> Vec<f64> {
    let error = |run: &AxisRun, k: usize| run.reference[k] - run.actual[k];
    pieces.iter().flat_map(|piece| piece.rows.clone().map(|k| error(&runs[piece.run], k))).collect()
}

/// The band of all pieces, and the share of errors in a quarter of each piece that a band of the other three holds, over all four.
#[must_use]
pub fn bands(runs: &[AxisRun], pieces: &[Piece], top_speed: f64) -> (PredictionInterval, f64) {
    let part = |from: f64, to: f64| -> Vec<(AxisSignal<'_>, Vec<f64>)> {
        pieces
            .iter()
            .map(|piece| {
                let cut = |share: f64| (piece.errors.len() as f64 * share) as usize;
                let rows = piece.rows.start + cut(from)..piece.rows.start + cut(to);
                let run = &runs[piece.run];
                (AxisSignal::uncompensated(&run.reference[rows], run.period_s), piece.errors[cut(from)..cut(to)].to_vec())
            })
            .collect()
    };
    let (mut held, mut all) = (0.0, 0.0);
    for quarter in [0.0, 0.25, 0.5, 0.75] {
        let others = [part(0.0, quarter), part(quarter + 0.25, 1.0)].concat();
        let check = PredictionInterval::fit(&others, top_speed);
        for (signal, errors) in part(quarter, quarter + 0.25) {
            held += check.held(&signal, &errors) * errors.len() as f64;
            all += errors.len() as f64;
        }
    }
    (PredictionInterval::fit(&part(0.0, 1.0), top_speed), if all > 0.0 { held / all } else { 0.0 })
}

/// What errors like those of `pieces` are like where they are as large as `expected` and at most as large as on the `held_out` ones, mm or rad.
#[must_use]
pub fn spread(runs: &[AxisRun], pieces: &[Piece], top_speed: f64, expected: f64, held_out: &[Piece]) -> Option<Spread> {
    let of = |piece: &Piece| {
        let run = &runs[piece.run];
        (AxisSignal::uncompensated(&run.reference[piece.rows.clone()], run.period_s), piece.errors.clone())
    };
    Spread::fit(&pieces.iter().map(of).collect::<Vec<_>>(), top_speed, expected, figures(held_out).0)
}

/// Time over which errors are summed up to see how unevenly they fall, s: a short motion, some reversals.
const WINDOW_S: f64 = 2.0;

/// Largest RMS error over a window of two seconds, over the RMS of all; 1 where no piece is as long.
#[must_use]
pub fn worst_window(pieces: &[Piece], period_s: f64) -> f64 {
    let samples = (WINDOW_S / period_s).round().max(1.0) as usize;
    let overall = figures(pieces).0;
    let windows = pieces.iter().flat_map(|piece| piece.errors.chunks_exact(samples)).map(|window| rms_max(window).0);
    let worst = windows.fold(overall, f64::max);
    if overall > 0.0 { worst / overall } else { 1.0 }
}

/// Root mean square and largest magnitude of the errors of `pieces`.
#[must_use]
pub fn figures(pieces: &[Piece]) -> (f64, f64) {
    rms_max(&pieces.iter().flat_map(|piece| &piece.errors).copied().collect::<Vec<f64>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fold(rich: f64, simple: f64) -> Judged {
        let pieces = |error: f64| vec![Piece { run: 0, rows: 0..10, errors: vec![error; 10] }];
        Judged { rich: pieces(rich), simple: pieces(simple) }
    }

    #[test]
    fn each_fold_is_judged_by_what_the_others_choose() {
        // Together the folds keep the rich predictor; without the second one they would keep the simpler one, so that one judges it.
        let folds = [fold(1.2, 1.0), fold(1.0, 5.0), fold(1.2, 1.0)];
        let choice = choose(&folds, true);
        assert!(!choice.simple);
        let judged: Vec<f64> = choice.pieces.iter().map(|piece| piece.errors[0]).collect();
        assert_eq!(judged, [1.2, 5.0, 1.2]);
        assert!(choose(&[fold(2.0, 1.0), fold(2.0, 1.0)], true).simple);
        assert!(!choose(&[fold(2.0, 1.0), fold(2.0, 1.0)], false).simple);
    }

    #[test]
    fn a_single_fold_is_judged_by_halves() {
        let choice = choose(&[fold(2.0, 1.0)], true);
        assert!(choice.simple);
        assert_eq!(choice.pieces.iter().map(|piece| piece.rows.clone()).collect::<Vec<_>>(), [0..5, 5..10]);
        assert!(figures(&choice.pieces) == (1.0, 1.0));
    }
}
