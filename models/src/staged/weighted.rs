//! Columns times weights without the columns: every regressor through the single response that its
//! weights give with the basis.

use std::ops::Range;

use rayon::prelude::*;

use super::features::FeatureSet;
use super::fir::Fir;
use super::regressor::{Harmonics, Regressor};
use super::signals::Signals;
use super::taps::{Tap, add_bent, add_taps};

/// Rows per block: the block's regressors stay in the cache, and the lags around it cost little.
const BLOCK_ROWS: usize = 2048;

impl FeatureSet {
    /// Prediction at every sample of a run: columns times `weights`.
    #[must_use]
    pub fn predict(&self, signals: &Signals, weights: &[f64]) -> Vec<f64> {
        Weighted::new(self, weights).predict(signals)
    }
}

/// A feature set with its weights, arranged for prediction.
struct Weighted<'a> {
    features: &'a FeatureSet,
    regressors: Vec<Regressor>,
    /// First and last lag of any response.
    first: isize,
    last: isize,
    /// Taps of responses that are summed directly.
    straight: Vec<Tap>,
    /// Taps of the second differences of responses with few corners, and these responses.
    bends: Vec<Tap>,
    bent: Vec<(usize, Fir)>,
}

impl<'a> Weighted<'a> {
    /// One weight a column.
    fn new(features: &'a FeatureSet, weights: &[f64]) -> Self {
        let spans = features.groups.iter().map(|group| group.basis.span());
        let (first, last) = spans.fold((0, 0), |(first, last), span| (first.min(span.0), last.max(span.1)));
        let (mut regressors, mut straight, mut bends, mut bent) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut taken = 0;
        for group in &features.groups {
            for regressor in &group.channels {
                let response = group.basis.combine(&weights[taken..taken + group.basis.len()]);
                taken += group.basis.len();
                let input = regressors.len();
                let tap = |lag: isize, weight| Tap { input, offset: (lag - first) as usize, weight };
                let corners = response.corners();
                if corners.len() < response.taps.len() {
                    // The first second difference that is needed is around the second row.
                    bends.extend(corners.into_iter().map(|(lag, weight)| tap(lag + 1, weight)));
                    bent.push((input, response));
                } else {
                    straight.extend((response.first_lag..).zip(&response.taps).map(|(lag, weight)| tap(lag, *weight)));
                }
                regressors.push(*regressor);
            }
        }
        Self { features, regressors, first, last, straight, bends, bent }
    }

    /// Prediction at every sample of a run.
    fn predict(&self, signals: &Signals) -> Vec<f64> {
        let mut out = vec![0.0; signals.len()];
        let blocks = out.par_chunks_mut(BLOCK_ROWS).enumerate();
        blocks.for_each_init(Scratch::default, |scratch, (index, rows)| {
            self.predict_block(signals, index * BLOCK_ROWS, rows, scratch)
        });
        out
    }

    fn predict_block(&self, signals: &Signals, start: usize, out: &mut [f64], scratch: &mut Scratch) {
        let origin = (signals.pad() as isize + start as isize + self.first) as usize;
        let rows = origin..origin + out.len() + (self.last - self.first) as usize;
        let harmonics = Harmonics::new(signals, rows.clone(), &self.features.scales);
        let inputs = scratch.inputs(&self.regressors, signals, &harmonics, rows);
        add_taps(&self.straight, &inputs, out);
        if self.bent.is_empty() {
            return;
        }
        let at = |row: usize| -> f64 {
            let of = |(input, response): &(usize, Fir)| -> f64 {
                let input = &inputs[*input][row + (response.first_lag - self.first) as usize..];
                response.taps.iter().zip(input).map(|(tap, u)| tap * u).sum()
            };
            self.bent.iter().map(of).sum()
        };
        let mut bends = vec![0.0; out.len().saturating_sub(2)];
        // A block of one row has no second difference, nor the inputs for one.
        if !bends.is_empty() {
            add_taps(&self.bends, &inputs, &mut bends);
        }
        let second = if out.len() > 1 { at(1) } else { 0.0 };
        add_bent([at(0), second], &bends, out);
    }
}

/// Memory for the regressors that are not stored signals.
#[derive(Default)]
struct Scratch(Vec<f64>);

impl Scratch {
    /// The regressors over the padded samples `rows`.
    fn inputs<'a>(
        &'a mut self,
        regressors: &[Regressor],
        signals: &'a Signals,
        harmonics: &Harmonics,
        rows: Range<usize>,
    ) -> Vec<&'a [f64]> {
        let made = regressors.iter().filter(|regressor| regressor.signal(signals).is_none()).count();
        self.0.resize(made * rows.len(), 0.0);
        let mut free = self.0.chunks_exact_mut(rows.len());
        let of = |regressor: &Regressor| match regressor.signal(signals) {
            Some(signal) => &signal[rows.clone()],
            None => free.next().map_or(&[][..], |out| {
                regressor.fill(signals, harmonics, rows.start, out);
                out
            }),
        };
        regressors.iter().map(of).collect()
    }
}
