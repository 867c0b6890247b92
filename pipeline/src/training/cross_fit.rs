//! Cross-fit: errors of a fitting procedure on samples that neither fitted nor chose its result.

use std::ops::Range;

use datasets::Fold;
use models::{AxisPredictor, AxisSignal, PredictionInterval, Spread};
use training::AxisRun;

use crate::statistics::rms_max;

/// Errors over a range of held-out samples of one run: prediction minus measurement, mm or rad.
#[derive(Debug, Clone, PartialEq)]
pub struct Piece {
    /// Index of the run.
    pub run: usize,
    /// Sample range in the run.
    pub rows: Range<usize>,
    /// Error of every sample, mm or rad.
    pub errors: Vec<f64>,
}

/// Errors on one held-out fold of a rich and of a simpler predictor, neither fitted to it.
#[derive(Debug, Clone, PartialEq)]
pub struct FoldErrors {
    /// Errors of the rich predictor.
    pub rich: Vec<Piece>,
    /// Errors of the simpler predictor on the same samples.
    pub simple: Vec<Piece>,
}

/// Choice between the two predictors, and the held-out errors that belong to it.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// Whether the simpler predictor is chosen.
    pub simple: bool,
    /// Errors on every held-out sample, of the predictor that the other samples choose.
    pub pieces: Vec<Piece>,
}

/// All runs without the samples of the fold. Empty runs are removed.
#[must_use]
pub fn without(runs: &[AxisRun], fold: &Fold) -> Vec<AxisRun> {
    let kept = runs.iter().zip(fold).map(|(run, rows)| run.without(rows));
    kept.filter(|run| !run.rows.is_empty()).collect()
}

/// All runs, each with only the samples of the fold, possibly none.
#[must_use]
pub fn only(runs: &[AxisRun], fold: &Fold) -> Vec<AxisRun> {
    runs.iter().zip(fold).map(|(run, rows)| run.only(rows)).collect()
}

/// Errors on the scored samples of `runs`, in order. `runs` must hold held-out samples only.
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

/// Chooses the simpler predictor where the rich one is worse on held-out samples; with `free` false always the rich
/// one.
///
/// Each part of the samples is evaluated with the choice of the other parts, so that the figures do not come from their
/// own choice. The parts are the folds, or the two halves of a single fold.
#[must_use]
pub fn choose(folds: &[FoldErrors], free: bool) -> Choice {
    let parts: Vec<FoldErrors> = match folds {
        [only] => halves(only),
        _ => folds.to_vec(),
    };
    let costs: Vec<f64> = parts.iter().map(gain_of_simple).collect();
    let prefers_simple = |without: Option<usize>| {
        let others = costs.iter().enumerate().filter(|(index, _)| Some(*index) != without);
        free && others.map(|(_, cost)| cost).sum::<f64>() > 0.0
    };
    let fold_errors =
        |(index, part): (usize, &FoldErrors)| if prefers_simple(Some(index)) { part.simple.clone() } else { part.rich.clone() };
    Choice { simple: prefers_simple(None), pieces: parts.iter().enumerate().flat_map(fold_errors).collect() }
}

/// Bound of the error ratio of a piece.
const MAX_RATIO: f64 = 5.0;

/// Sum over the samples of ln(RMS of the rich predictor / RMS of the simpler one), each RMS over a piece.
///
/// The logarithm weighs all runs alike. A sum of squares would follow the single run of a kind that the others lack, to
/// which the final predictor is fitted too.
fn gain_of_simple(fold_errors: &FoldErrors) -> f64 {
    let gain = |(rich, simple): (&Piece, &Piece)| {
        let (rich_rms, simple_rms) = (rms_max(&rich.errors).0, rms_max(&simple.errors).0);
        let ratio = if rich_rms > 0.0 || simple_rms > 0.0 { rich_rms / simple_rms } else { 1.0 };
        ratio.clamp(1.0 / MAX_RATIO, MAX_RATIO).ln() * rich.errors.len() as f64
    };
    fold_errors.rich.iter().zip(&fold_errors.simple).map(gain).sum()
}

/// Splits a fold into two halves by samples.
fn halves(fold: &FoldErrors) -> Vec<FoldErrors> {
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
    [false, true].map(|second| FoldErrors { rich: half(&fold.rich, second), simple: half(&fold.simple, second) }).to_vec()
}

/// Tracking errors of the samples of `pieces`, mm or rad.
#[must_use]
pub fn tracking_errors(runs: &[AxisRun], pieces: &[Piece]) -> Vec<f64> {
    let error = |run: &AxisRun, k: usize| run.reference[k] - run.actual[k];
    pieces.iter().flat_map(|piece| piece.rows.clone().map(|k| error(&runs[piece.run], k))).collect()
}

/// Prediction interval of all pieces, and its coverage probability by fourfold cross-validation: each quarter of every
/// piece is tested with an interval fitted to the other three.
#[must_use]
pub fn prediction_interval(runs: &[AxisRun], pieces: &[Piece], top_speed: f64) -> (PredictionInterval, f64) {
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

/// Error distribution fitted to `pieces`, scaled to the RMS `expected` and at most to the RMS of `held_out`, mm or rad.
#[must_use]
pub fn spread(runs: &[AxisRun], pieces: &[Piece], top_speed: f64, expected: f64, held_out: &[Piece]) -> Option<Spread> {
    let of = |piece: &Piece| {
        let run = &runs[piece.run];
        (AxisSignal::uncompensated(&run.reference[piece.rows.clone()], run.period_s), piece.errors.clone())
    };
    Spread::fit(&pieces.iter().map(of).collect::<Vec<_>>(), top_speed, expected, figures(held_out).0)
}

/// Window for the unevenness of errors, s: a short motion with some reversals.
const WINDOW_S: f64 = 2.0;

/// Largest RMS error of a two-second window divided by the overall RMS; 1 where no piece is as long.
#[must_use]
pub fn worst_window(pieces: &[Piece], period_s: f64) -> f64 {
    let samples = (WINDOW_S / period_s).round().max(1.0) as usize;
    let overall = figures(pieces).0;
    let windows = pieces.iter().flat_map(|piece| piece.errors.chunks_exact(samples)).map(|window| rms_max(window).0);
    let worst = windows.fold(overall, f64::max);
    if overall > 0.0 { worst / overall } else { 1.0 }
}

/// RMS and largest magnitude of the errors of `pieces`, mm or rad.
#[must_use]
pub fn figures(pieces: &[Piece]) -> (f64, f64) {
    rms_max(&pieces.iter().flat_map(|piece| &piece.errors).copied().collect::<Vec<f64>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fold(rich: f64, simple: f64) -> FoldErrors {
        let pieces = |error: f64| vec![Piece { run: 0, rows: 0..10, errors: vec![error; 10] }];
        FoldErrors { rich: pieces(rich), simple: pieces(simple) }
    }

    #[test]
    fn each_fold_is_evaluated_with_the_choice_of_the_others() {
        // All folds together choose the rich predictor. Without the second fold they would choose the simpler one,
        // which is therefore evaluated on it.
        let folds = [fold(1.2, 1.0), fold(1.0, 5.0), fold(1.2, 1.0)];
        let choice = choose(&folds, true);
        assert!(!choice.simple);
        let fold_errors: Vec<f64> = choice.pieces.iter().map(|piece| piece.errors[0]).collect();
        assert_eq!(fold_errors, [1.2, 5.0, 1.2]);
        assert!(choose(&[fold(2.0, 1.0), fold(2.0, 1.0)], true).simple);
        assert!(!choose(&[fold(2.0, 1.0), fold(2.0, 1.0)], false).simple);
    }

    #[test]
    fn a_single_fold_is_evaluated_by_halves() {
        let choice = choose(&[fold(2.0, 1.0)], true);
        assert!(choice.simple);
        assert_eq!(choice.pieces.iter().map(|piece| piece.rows.clone()).collect::<Vec<_>>(), [0..5, 5..10]);
        assert!(figures(&choice.pieces) == (1.0, 1.0));
    }
}
