//! The columns of position lines.

use models::staged::{FeatureGroup, FeatureSet, Fir, LagBasis, MotionFactor, Pass, Regressor};
use nalgebra::DMatrix;

use super::operators::every;

/// A line and the ways in which it acts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Spatial frequency, 1/unit.
    pub frequency: f64,
    /// As a wave of the friction level: operators times cosine and sine.
    pub friction: bool,
    /// As a force: cosine and sine.
    pub force: bool,
    /// As a gain of the drive: acceleration and one operator times cosine and sine, on many lags.
    pub gain: bool,
}

/// What the columns of lines are made of.
#[derive(Debug, Clone)]
pub struct WaveBasis {
    /// Responses through which the operators times a wave act.
    pub filters: LagBasis,
    /// Knots of the operators' responses, samples.
    pub knots: Vec<isize>,
    /// Operators that are multiplied by the waves.
    pub stops: Vec<usize>,
    /// Frequency above which a line is a matter of the motor, 1/unit.
    pub fine_above: f64,
}

impl WaveBasis {
    /// The groups of columns of the given lines; channels refer to them by their place in the list.
    pub fn groups(&self, lines: &[Line]) -> Vec<FeatureGroup> {
        let select = |wanted: &dyn Fn(&Line) -> bool, carriers: &[MotionFactor]| -> Vec<Regressor> {
            lines
                .iter()
                .enumerate()
                .filter(|(_, line)| wanted(line))
                .flat_map(|(i, _)| carriers.iter().flat_map(move |&c| Regressor::on_line(c, i)))
                .collect()
        };
        let fine = |line: &Line| line.frequency > self.fine_above;
        let stops: Vec<MotionFactor> = self.stops.iter().map(|&i| MotionFactor::Stop(i)).collect();
        let gains: Vec<MotionFactor> =
            self.stops.get(1).map(|&i| MotionFactor::Stop(i)).into_iter().chain([MotionFactor::VelocityStep]).collect();
        [
            (self.filters.clone(), select(&|line| line.friction, &stops)),
            (LagBasis::hats(&every(&self.knots, 3)), select(&|line| line.force && !fine(line), &[MotionFactor::One])),
            (LagBasis::hats(&self.knots), select(&|line| line.force && fine(line), &[MotionFactor::One])),
            (LagBasis::hats(&every(&self.knots, 2)), select(&|line| line.gain, &gains)),
        ]
        .into_iter()
        .filter(|(_, channels)| !channels.is_empty())
        .map(|(basis, channels)| FeatureGroup { basis, channels })
        .collect()
    }

    /// `base` with the columns of `lines` after its own.
    pub fn features(&self, base: &FeatureSet, lines: &[Line]) -> FeatureSet {
        let mut features = base.clone();
        features.scales.lines = lines.iter().map(|line| line.frequency).collect();
        features.groups.extend(self.groups(lines));
        features
    }
}

/// The operators' responses boiled down to `count`: the leading right singular vectors of the table of responses.
pub fn leading_filters(pass: &Pass, count: usize) -> Option<LagBasis> {
    let mut taken = 0;
    let mut rows: Vec<Fir> = Vec::new();
    for group in &pass.features.groups {
        let responses = group.basis.len();
        for channel in &group.channels {
            let friction = matches!(
                channel.motion,
                MotionFactor::Stop(_) | MotionFactor::StopLessSign(_) | MotionFactor::SaturatedViscous(_)
            );
            if friction && channel.line().is_none() {
                rows.push(group.basis.combine(&pass.weights[taken..taken + responses]));
            }
            taken += responses;
        }
    }
    let first = rows.first()?;
    let (first_lag, width) = (first.first_lag, first.taps.len());
    let table = DMatrix::from_fn(rows.len(), width, |i, j| rows[i].taps[j]);
    let directions = table.svd(false, true).v_t?;
    let filters = directions.row_iter().take(count).map(|row| Fir { first_lag, taps: row.iter().copied().collect() }).collect();
    Some(LagBasis::new(filters))
}

/// The part of a pass that follows one line.
pub fn part_on_line(pass: &Pass, line: usize) -> Pass {
    let mut taken = 0;
    let mut groups = Vec::new();
    let mut weights = Vec::new();
    for group in &pass.features.groups {
        let responses = group.basis.len();
        let mut channels = Vec::new();
        for &channel in &group.channels {
            if channel.line() == Some(line) {
                channels.push(channel);
                weights.extend_from_slice(&pass.weights[taken..taken + responses]);
            }
            taken += responses;
        }
        if !channels.is_empty() {
            let basis = group.basis.clone();
            groups.push(FeatureGroup { basis, channels });
        }
    }
    let scales = pass.features.scales.clone();
    Pass { features: FeatureSet { scales, groups }, weights }
}
