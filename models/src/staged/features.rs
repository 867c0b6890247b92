//! The feature columns of a pass.

use nalgebra::{DMatrix, DMatrixView};
use serde::{Deserialize, Serialize};

use super::fir::LagBasis;
use super::regressor::{MotionFactor, Regressor, Waves};
use super::signals::{Scales, Signals};

/// Channels that share a basis; one column for each channel and response.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FeatureGroup {
    /// The responses.
    pub basis: LagBasis,
    /// The channels, each through every response.
    pub channels: Vec<Regressor>,
}

impl FeatureGroup {
    /// Number of columns.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.basis.len() * self.channels.len()
    }
}

/// All columns of a pass, group after group, channel after channel, response after response.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FeatureSet {
    /// Widths, speeds and lines that the channels refer to.
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

    /// Samples of rest that a run needs at either end.
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

    /// Whether every channel refers to an operator, speed and line that there is, and every number is usable.
    ///
    /// # Errors
    /// Says what is wrong.
    pub(super) fn check(&self) -> Result<(), String> {
        self.scales.check()?;
        for group in &self.groups {
            if group.basis.filters().iter().any(|fir| fir.taps.is_empty() || fir.taps.iter().any(|tap| !tap.is_finite())) {
                return Err("a response without usable taps".into());
            }
            if let Some(channel) = group.channels.iter().find(|c| !c.fits(&self.scales)) {
                return Err(format!("{channel:?} refers to what is not there"));
            }
        }
        Ok(())
    }

    /// Values a sample of [`Self::plain_rows`].
    pub(super) fn plain_width(&self) -> usize {
        3 + self.scales.stop_half_widths.len() + 2 * self.scales.lines.len()
    }

    /// Velocity, its increment, direction, operators, cosines and sines of the lines at the run's samples; row-major.
    pub(super) fn plain_rows(&self, signals: &Signals) -> Vec<f32> {
        let rows = signals.pad()..signals.pad() + signals.len();
        let waves = Waves::new(signals, rows.clone(), &self.scales);
        let mut columns = vec![&signals.velocity()[rows.clone()], &signals.step()[rows.clone()], &signals.sign()[rows.clone()]];
        columns.extend((0..self.scales.stop_half_widths.len()).map(|stop| &signals.stop(stop)[rows.clone()]));
        for line in 0..self.scales.lines.len() {
            columns.extend([waves.cos(line, rows.clone()), waves.sin(line, rows.clone())]);
        }
        (0..signals.len()).flat_map(|k| columns.iter().map(move |column| column[k] as f32)).collect()
    }

    /// Signals of a run, as these features need them. Where there is play, the run starts with the motor off the table by `start`.
    #[must_use]
    pub fn signals(&self, reference: &[f64], flags: &[f64], expected: &[f64], period_s: f64, start: f64) -> Signals {
        let mut channels = self.groups.iter().flat_map(|group| &group.channels);
        let start = if channels.any(|channel| matches!(channel.motion, MotionFactor::Backlash(_))) { start } else { 0.0 };
        Signals::new(reference, flags, expected, period_s, start, self.pad(), &self.scales)
    }

    /// Columns at `rows` samples of a run, `stride` apart from `start` on, followed by `spare` columns of zeros for the caller to fill.
    #[must_use]
    pub fn block(&self, signals: &Signals, start: usize, rows: usize, stride: usize, spare: usize) -> DMatrix<f64> {
        let mut block = DMatrix::zeros(rows, self.columns() + spare);
        let samples = rows.saturating_sub(1) * stride + 1;
        let waves = self.waves(signals, start, samples);
        let (mut column, mut room) = (0, Vec::new());
        let mut phases = vec![Vec::new(); stride];
        for group in &self.groups {
            let (first, _) = group.basis.span();
            let inputs = channels(group, signals, &waves, start, samples, &mut room);
            for input in inputs.column_iter() {
                for (phase, thinned) in phases.iter_mut().enumerate() {
                    thinned.clear();
                    thinned.extend(input.as_slice().iter().skip(phase).step_by(stride));
                    // Every phase reaches as far as the longest.
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

    /// What play contributes to the prediction: the part by which the motor is elsewhere than what is measured.
    #[must_use]
    pub fn play(&self, signals: &Signals, weights: &[f64]) -> Option<Vec<f64>> {
        let mut out: Option<Vec<f64>> = None;
        let mut column = 0;
        for group in &self.groups {
            let responses = group.basis.len();
            for channel in &group.channels {
                if let MotionFactor::Backlash(stop) = channel.motion {
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

    /// First and last lag that any channel on a line is looked at.
    fn wave_span(&self) -> (isize, isize) {
        let on_lines = |group: &&FeatureGroup| group.channels.iter().any(|c| c.line().is_some());
        self.groups.iter().filter(on_lines).fold((0, 0), |(first, last), group| {
            let (from, to) = group.basis.span();
            (first.min(from), last.max(to))
        })
    }

    /// Waves of the position lines over a block and the lags around it.
    fn waves(&self, signals: &Signals, start: usize, rows: usize) -> Waves {
        let (first, last) = self.wave_span();
        let origin = (signals.pad() as isize + start as isize + first) as usize;
        let length = rows + (last - first) as usize;
        Waves::new(signals, origin..origin + length, &self.scales)
    }
}

/// Channels of a group over a block and the lags around it, one a column, written into `room`.
fn channels<'a>(
    group: &FeatureGroup,
    signals: &Signals,
    waves: &Waves,
    start: usize,
    rows: usize,
    room: &'a mut Vec<f64>,
) -> DMatrixView<'a, f64> {
    let (first, last) = group.basis.span();
    let length = rows + (last - first) as usize;
    let origin = (signals.pad() as isize + start as isize + first) as usize;
    room.resize(length * group.channels.len(), 0.0);
    for (channel, column) in group.channels.iter().zip(room.chunks_exact_mut(length)) {
        channel.fill(signals, waves, origin, column);
    }
    DMatrixView::from_slice(room, length, group.channels.len())
}
