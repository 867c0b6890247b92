//! The columns of position harmonics.

use models::staged::{FeatureGroup, FeatureSet, Fir, LagBasis, MotionFactor, Pass, Regressor};
use nalgebra::DMatrix;

use super::operators::{every, right_singular};

/// A harmonic and its effects.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Harmonic {
    /// Spatial frequency, 1/unit.
    pub frequency: f64,
    /// Modulation of the friction level: operators times cosine and sine.
    pub friction: bool,
    /// Additive force: cosine and sine.
    pub force: bool,
    /// Modulation of the drive's gain: acceleration and one operator times cosine and sine, on many
    /// lags.
    pub gain: bool,
}

/// Settings of the columns of harmonics.
#[derive(Debug, Clone)]
pub struct HarmonicBasis {
    /// Responses through which the products of operators and harmonics act.
    pub filters: LagBasis,
    /// Knots of the operators' responses, samples.
    pub knots: Vec<isize>,
    /// Operators that are multiplied by the harmonics.
    pub stops: Vec<usize>,
    /// Frequency above which a harmonic belongs to the motor, 1/unit.
    pub fine_above: f64,
}

impl HarmonicBasis {
    /// The groups of columns of the given harmonics. Regressors refer to them by index.
    pub fn groups(&self, harmonics: &[Harmonic]) -> Vec<FeatureGroup> {
        let select = |wanted: &dyn Fn(&Harmonic) -> bool, factors: &[MotionFactor]| -> Vec<Regressor> {
            harmonics
                .iter()
                .enumerate()
                .filter(|(_, harmonic)| wanted(harmonic))
                .flat_map(|(i, _)| factors.iter().flat_map(move |&c| Regressor::on_harmonic(c, i)))
                .collect()
        };
        let fine = |harmonic: &Harmonic| harmonic.frequency > self.fine_above;
        let stops: Vec<MotionFactor> = self.stops.iter().map(|&i| MotionFactor::Stop(i)).collect();
        let gains: Vec<MotionFactor> =
            self.stops.get(1).map(|&i| MotionFactor::Stop(i)).into_iter().chain([MotionFactor::VelocityStep]).collect();
        [
            (self.filters.clone(), select(&|harmonic| harmonic.friction, &stops)),
            (LagBasis::hats(&every(&self.knots, 3)), select(&|harmonic| harmonic.force && !fine(harmonic), &[MotionFactor::One])),
            (LagBasis::hats(&self.knots), select(&|harmonic| harmonic.force && fine(harmonic), &[MotionFactor::One])),
            (LagBasis::hats(&every(&self.knots, 2)), select(&|harmonic| harmonic.gain, &gains)),
        ]
        .into_iter()
        .filter(|(_, channels)| !channels.is_empty())
        .map(|(basis, channels)| FeatureGroup { basis, channels })
        .collect()
    }

    /// `base` followed by the columns of `harmonics`.
    pub fn features(&self, base: &FeatureSet, harmonics: &[Harmonic]) -> FeatureSet {
        let mut features = base.clone();
        features.scales.lines = harmonics.iter().map(|harmonic| harmonic.frequency).collect();
        features.groups.extend(self.groups(harmonics));
        features
    }
}

/// The operators' responses reduced to `count`: the leading right singular vectors of the table of
/// responses.
pub fn leading_filters(pass: &Pass, count: usize) -> Option<LagBasis> {
    let mut taken = 0;
    let mut rows: Vec<Fir> = Vec::new();
    for group in &pass.features.groups {
        let responses = group.basis.len();
        for regressor in &group.channels {
            let friction = matches!(
                regressor.motion,
                MotionFactor::Stop(_) | MotionFactor::StopLessSign(_) | MotionFactor::SaturatedViscous(_)
            );
            if friction && regressor.harmonic().is_none() {
                rows.push(group.basis.combine(&pass.weights[taken..taken + responses]));
            }
            taken += responses;
        }
    }
    let first = rows.first()?;
    let (first_lag, width) = (first.first_lag, first.taps.len());
    let table = DMatrix::from_fn(rows.len(), width, |i, j| rows[i].taps[j]);
    let directions = right_singular(table)?.v_t?;
    let filters = directions.row_iter().take(count).map(|row| Fir { first_lag, taps: row.iter().copied().collect() }).collect();
    Some(LagBasis::new(filters))
}

/// The part of a pass that belongs to one harmonic.
pub fn part_on_harmonic(pass: &Pass, harmonic: usize) -> Pass {
    let mut taken = 0;
    let mut groups = Vec::new();
    let mut weights = Vec::new();
    for group in &pass.features.groups {
        let responses = group.basis.len();
        let mut channels = Vec::new();
        for &regressor in &group.channels {
            if regressor.harmonic() == Some(harmonic) {
                channels.push(regressor);
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
