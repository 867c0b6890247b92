//! The feature columns of a pass.

use nalgebra::{DMatrix, DMatrixView};
use serde::{Deserialize, Serialize};

use super::fir::{Fir, LagBasis};
use super::regressor::{Harmonics, MotionFactor, Regressor};
use super::signals::{Scales, Signals};
use crate::ranges::{MOST_PRODUCTS, MOST_REGRESSORS, at_most};

/// Regressors that share a basis; one column for each regressor and response.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FeatureGroup {
    /// The responses.
    pub basis: LagBasis,
    /// The regressors, each through every response.
    pub channels: Vec<Regressor>,
}

impl FeatureGroup {
    /// Number of columns.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.basis.len() * self.channels.len()
    }
}

/// All columns of a pass, ordered by group, regressor, response.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FeatureSet {
    /// Half-widths, speeds and harmonics that the regressors refer to.
    pub scales: Scales,
    /// The groups.
    pub groups: Vec<FeatureGroup>,
}

impl FeatureSet {
    /// Number of columns.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.groups.iter().map(FeatureGroup::columns).sum()
    }

    /// Samples of standstill padding that a run needs at either end.
    #[must_use]
    pub fn pad(&self) -> usize {
        self.groups
            .iter()
            .map(|group| {
                let (first, last) = group.basis.span();
                first.unsigned_abs().max(last.unsigned_abs())
            })
            .max()
            .unwrap_or(0)
            + 1
    }

    /// Checks that every regressor refers to an existing operator, speed and harmonic, and that all
    /// numbers are valid.
    ///
    /// # Errors
    /// Describes the fault.
    pub(super) fn check(&self) -> Result<(), String> {
        self.scales.check()?;
        for group in &self.groups {
            group.basis.filters().iter().try_for_each(Fir::check)?;
            if let Some(regressor) = group.channels.iter().find(|c| !c.fits(&self.scales)) {
                return Err(format!("{regressor:?} refers to what is not there"));
            }
        }
        let products = |group: &FeatureGroup| {
            let (first, last) = group.basis.span();
            (last.abs_diff(first) + 1).saturating_mul(group.channels.len())
        };
        at_most("products per sample", self.groups.iter().map(products).fold(0, usize::saturating_add), MOST_PRODUCTS)?;
        at_most("number of regressors", self.groups.iter().map(|group| group.channels.len()).sum(), MOST_REGRESSORS)
    }

    /// Values per sample of [`Self::plain_rows`].
    pub(super) fn plain_width(&self) -> usize {
        3 + self.scales.stop_half_widths.len() + 2 * self.scales.lines.len()
    }

    /// Velocity, its increment, direction, operators, cosines and sines of the harmonics at the
    /// run's samples; row-major.
    pub(super) fn plain_rows(&self, signals: &Signals) -> Vec<f32> {
        let rows = signals.pad()..signals.pad() + signals.len();
        let harmonics = Harmonics::new(signals, rows.clone(), &self.scales);
        let mut columns = vec![&signals.velocity()[rows.clone()], &signals.step()[rows.clone()], &signals.sign()[rows.clone()]];
        columns.extend((0..self.scales.stop_half_widths.len()).map(|stop| &signals.stop(stop)[rows.clone()]));
        for harmonic in 0..self.scales.lines.len() {
            columns.extend([harmonics.cos(harmonic, rows.clone()), harmonics.sin(harmonic, rows.clone())]);
        }
        (0..signals.len()).flat_map(|k| columns.iter().map(move |column| column[k] as f32)).collect()
    }

    /// Signals of a run for these features. With backlash, the motor is off the table by `start` at
    /// the start of the run.
    #[must_use]
    pub fn signals(&self, reference: &[f64], flags: &[f64], expected: &[f64], period_s: f64, start: f64) -> Signals {
        let mut regressors = self.groups.iter().flat_map(|group| &group.channels);
        let start = if regressors.any(|regressor| matches!(regressor.motion, MotionFactor::Backlash(_))) { start } else { 0.0 };
        Signals::new(reference, flags, expected, period_s, start, self.pad(), &self.scales)
    }

    /// Columns at `rows` samples of a run, `stride` apart from `start` on, followed by `spare`
    /// columns of zeros for the caller to fill.
    #[must_use]
    pub fn block(&self, signals: &Signals, start: usize, rows: usize, stride: usize, spare: usize) -> DMatrix<f64> {
        let mut block = DMatrix::zeros(rows, self.columns() + spare);
        let samples = rows.saturating_sub(1) * stride + 1;
        let harmonics = self.harmonics(signals, start, samples);
        let (mut column, mut scratch) = (0, Vec::new());
        let mut phases = vec![Vec::new(); stride];
        for group in &self.groups {
            let (first, _) = group.basis.span();
            let inputs = regressors(group, signals, &harmonics, start, samples, &mut scratch);
            for input in inputs.column_iter() {
                for (phase, thinned) in phases.iter_mut().enumerate() {
                    thinned.clear();
                    thinned.extend(input.as_slice().iter().skip(phase).step_by(stride));
                    // Every phase has the length of the longest.
                    thinned.resize(input.len().div_ceil(stride), 0.0);
                }
                let phases: Vec<&[f64]> = phases.iter().map(Vec::as_slice).collect();
                for fir in group.basis.filters() {
                    fir.add_thinned_to(&phases, first, block.column_mut(column).as_mut_slice());
                    column += 1;
                }
            }
        }
        block
    }

    /// Contribution of the backlash to the prediction: the offset of the motor from the measured
    /// position.
    #[must_use]
    pub fn backlash(&self, signals: &Signals, weights: &[f64]) -> Option<Vec<f64>> {
        let mut out: Option<Vec<f64>> = None;
        let mut column = 0;
        for group in &self.groups {
            let responses = group.basis.len();
            for regressor in &group.channels {
                if let MotionFactor::Backlash(stop) = regressor.motion {
                    let response = group.basis.combine(&weights[column..column + responses]);
                    let start = (signals.pad() as isize + response.first_lag) as usize;
                    let out = out.get_or_insert_with(|| vec![0.0; signals.len()]);
                    let end = start + out.len() + response.taps.len() - 1;
                    response.add_to(&signals.stop(stop)[start..end], response.first_lag, 1.0, out);
                }
                column += responses;
            }
        }
        out
    }

    /// First and last lag of any regressor on a harmonic.
    fn harmonic_span(&self) -> (isize, isize) {
        let on_harmonics = |group: &&FeatureGroup| group.channels.iter().any(|c| c.harmonic().is_some());
        self.groups.iter().filter(on_harmonics).fold((0, 0), |(first, last), group| {
            let (from, to) = group.basis.span();
            (first.min(from), last.max(to))
        })
    }

    /// The position harmonics over a block and the lags around it.
    fn harmonics(&self, signals: &Signals, start: usize, rows: usize) -> Harmonics {
        let (first, last) = self.harmonic_span();
        let origin = (signals.pad() as isize + start as isize + first) as usize;
        let length = rows + (last - first) as usize;
        Harmonics::new(signals, origin..origin + length, &self.scales)
    }
}

/// Regressors of a group over a block and the lags around it, one per column, written into `scratch`.
fn regressors<'a>(
    group: &FeatureGroup,
    signals: &Signals,
    harmonics: &Harmonics,
    start: usize,
    rows: usize,
    scratch: &'a mut Vec<f64>,
) -> DMatrixView<'a, f64> {
    let (first, last) = group.basis.span();
    let length = rows + (last - first) as usize;
    let origin = (signals.pad() as isize + start as isize + first) as usize;
    scratch.resize(length * group.channels.len(), 0.0);
    for (regressor, column) in group.channels.iter().zip(scratch.chunks_exact_mut(length)) {
        regressor.fill(signals, harmonics, origin, column);
    }
    DMatrixView::from_slice(scratch, length, group.channels.len())
}
