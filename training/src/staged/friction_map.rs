//! The friction level along the axis: worn and tight positions, which no harmonic describes.
//!
//! The map is linear in its contribution to the friction terms: the level at a position, times a
//! hat function around it, times the contribution of the friction terms there. The prior of its
//! values is a smooth random function, so that a position that the log hardly visits keeps the
//! level 1.

use models::staged::{Fir, FrictionMap, Harmonics, MotionFactor, Pass, Regressor, Scales, Signals};
use nalgebra::{DMatrix, DMatrixViewMut};

use super::dataset::AxisDataset;
use super::gram::{FoldErrors, FoldGrams, Penalty};
use super::linear::{Candidate, LinearLaw};
use super::operators::{FittedPass, fit_pass, penalties, right_singular};
use super::recipe::StagedRecipe;
use crate::TrainingError;

/// Maximum number of responses through which the friction terms act, and the smallest of them as a
/// share of the first.
const FILTERS: usize = 6;
const LEAST_FILTER: f64 = 1e-3;

/// Weight, relative to the deviation, that holds the mean of the map's values at zero.
const CENTRED: f64 = 1e4;
/// Smallest and largest plausible level of a map; beyond them the fit has diverged.
const LEVELS: [f64; 2] = [0.1, 10.0];

/// Adds a friction map to the last pass of `base`. `None` if the pass has no friction, or no map
/// lowers the error of held-out blocks.
pub fn with_friction_map(
    dataset: &AxisDataset<'_>,
    law: &LinearLaw,
    base: &Candidate,
    ridge: f64,
    recipe: &StagedRecipe,
) -> Result<Option<Candidate>, TrainingError> {
    let Some((last, before)) = base.passes.split_last() else { return Ok(None) };
    let expected = dataset.expected_through(before);
    let noise = base.errors.mean_square();
    let base_penalties = penalties(law, noise, dataset, &last.features, ridge, recipe);
    let knots = Knots::over(dataset.travel(), recipe.map.places);
    let mut pass = last.clone();
    let mut map = Values::flat(knots.count);
    let mut chosen: Option<DMatrix<f64>> = None;
    let mut fitted: Option<FittedPass> = None;
    for _ in 0..recipe.map.rounds {
        let Some(gathered) = gather(dataset, &pass, &expected, &knots, &map) else { return Ok(None) };
        let precision = match chosen.take() {
            Some(precision) => precision,
            None => match choose(&gathered, &base_penalties, &knots, noise, recipe) {
                Some(precision) => precision,
                None => return Ok(None),
            },
        };
        let weights = gathered.total().reduced(&base_penalties).and_then(|reduced| reduced.solve(&precision));
        let Some(weights) = weights else { return Ok(None) };
        map = Values::from(&weights[base_penalties.len()..], knots.count);
        if !map.is_plausible() {
            return Ok(None);
        }
        let mut features = last.features.clone();
        features.scales.friction_map = Some(map.on(&knots, features.scales.centre));
        let refitted = fit_pass(dataset, &features, &expected, base_penalties.clone())?;
        pass = refitted.pass.clone();
        fitted = Some(refitted);
        chosen = Some(precision);
    }
    fitted.map(|fitted| fitted.candidate("friction-map", true, before)).transpose()
}

/// Equidistant positions.
struct Knots {
    first: f64,
    spacing: f64,
    count: usize,
}

impl Knots {
    fn over((low, high): (f64, f64), count: usize) -> Self {
        Self { first: low, spacing: (high - low) / count.saturating_sub(1).max(1) as f64, count }
    }
}

/// Deviation of the level from 1: `even` in both directions, `odd` forwards and, with the opposite
/// sign, backwards.
struct Values {
    even: Vec<f64>,
    odd: Vec<f64>,
}

impl Values {
    fn flat(count: usize) -> Self {
        Self { even: vec![0.0; count], odd: vec![0.0; count] }
    }

    fn from(weights: &[f64], count: usize) -> Self {
        Self { even: weights[..count].to_vec(), odd: weights[count..].to_vec() }
    }

    /// Whether all levels are positive and plausible.
    fn is_plausible(&self) -> bool {
        let [least, most] = LEVELS;
        self.even.iter().zip(&self.odd).all(|(even, odd)| 1.0 + even - odd.abs() >= least && 1.0 + even + odd.abs() <= most)
    }

    fn on(&self, knots: &Knots, centre: f64) -> FrictionMap {
        let levels = |sign: f64| self.even.iter().zip(&self.odd).map(|(even, odd)| 1.0 + even + sign * odd).collect();
        FrictionMap { first: knots.first - centre, spacing: knots.spacing, forwards: levels(1.0), backwards: levels(-1.0) }
    }
}

/// Normal equations of the pass's columns, followed by the map's values: even ones, then odd ones.
/// The target is the tracking error plus the part that the map already explains, so that the
/// solution is the whole map.
fn gather(dataset: &AxisDataset<'_>, pass: &Pass, expected: &[Vec<f64>], knots: &Knots, map: &Values) -> Option<FoldGrams> {
    let friction = Friction::of(pass)?;
    let signals = dataset.signals(&pass.features, expected);
    let inputs: Vec<Vec<Vec<f64>>> = signals.iter().map(|signals| friction.inputs(signals)).collect();
    let fill = |run: usize, start: usize, mut columns: DMatrixViewMut<'_, f64>| {
        let part = Part { signals: &signals[run], inputs: &inputs[run], start, stride: dataset.stride() };
        friction.fill(&pass.features.scales, knots, &part, &mut columns);
        let mut explained = vec![0.0; columns.nrows()];
        for (column, value) in columns.column_iter().zip(map.even.iter().chain(&map.odd)) {
            explained.iter_mut().zip(column.iter()).for_each(|(sum, x)| *sum += value * x);
        }
        columns.column_mut(2 * knots.count).iter_mut().zip(explained).for_each(|(target, explained)| *target += explained);
    };
    Some(dataset.grams_with(&pass.features, &signals, (2 * knots.count, &fill), dataset.errors()))
}

/// The inverse covariance of the map's values that held-out blocks prefer; `None` if they prefer no
/// map.
fn choose(gathered: &FoldGrams, base: &[Penalty], knots: &Knots, noise: f64, recipe: &StagedRecipe) -> Option<DMatrix<f64>> {
    let settings = &recipe.map;
    let mut tried = Vec::new();
    for &length in &settings.lengths {
        for &deviation in &settings.deviations {
            for &odd in &settings.odd_shares {
                tried.extend(precision(knots.count, length, deviation, odd, noise * recipe.correlated));
            }
        }
    }
    let select: Vec<usize> = (0..base.len()).collect();
    let without = gathered.select(&select).cross_validate(base)?;
    let errors = gathered.cross_validate_reduced(base, &tried);
    let best: Option<(FoldErrors, DMatrix<f64>)> = errors
        .into_iter()
        .zip(tried)
        .filter_map(|(errors, precision)| Some((errors?, precision)))
        .min_by(|a, b| a.0.mean_square().total_cmp(&b.0.mean_square()));
    best.filter(|(errors, _)| errors.beats(&without, settings.least_gain, settings.standard_errors))
        .map(|(_, precision)| precision)
}

/// Inverse covariance, in units of the noise, of even and odd values that follow a Matérn-3/2
/// process of `deviation`, with `length` as a share of the travel. The odd values have `odd` of its
/// deviation. The mean of the even values is held at zero: a constant change of the level belongs
/// to the friction terms, since the map ends with the logged positions.
fn precision(count: usize, length: f64, deviation: f64, odd: f64, noise: f64) -> Option<DMatrix<f64>> {
    let steps = length * count.saturating_sub(1) as f64;
    let covariance = DMatrix::from_fn(count, count, |i, j| {
        let distance = 3f64.sqrt() * (i as f64 - j as f64).abs() / steps;
        let jitter = if i == j { 1e-6 } else { 0.0 };
        deviation * deviation * ((1.0 + distance) * (-distance).exp() + jitter)
    });
    let inverse = covariance.cholesky()?.inverse();
    let mut precision = DMatrix::zeros(2 * count, 2 * count);
    let centred = &inverse + DMatrix::from_element(count, count, CENTRED / (deviation * deviation * count as f64));
    precision.view_mut((0, 0), (count, count)).copy_from(&(centred * noise));
    precision.view_mut((count, count), (count, count)).copy_from(&(inverse * (noise / (odd * odd))));
    Some(precision)
}

/// The friction terms of a pass through a few responses: `Σ filter ∗ Σ share · regressor`.
struct Friction {
    regressors: Vec<Regressor>,
    filters: Vec<Fir>,
    /// One row per regressor, one column per filter.
    shares: DMatrix<f64>,
}

impl Friction {
    /// `None` if the pass has no friction terms.
    fn of(pass: &Pass) -> Option<Self> {
        let mut taken = 0;
        let mut found: Vec<(Regressor, Fir)> = Vec::new();
        for group in &pass.features.groups {
            for regressor in &group.channels {
                let weights = &pass.weights[taken..taken + group.basis.len()];
                taken += group.basis.len();
                let friction = match regressor.motion {
                    MotionFactor::Sign
                    | MotionFactor::Stop(_)
                    | MotionFactor::StopLessSign(_)
                    | MotionFactor::SlowStop(..)
                    | MotionFactor::StopMagnitude(_)
                    | MotionFactor::SaturatedViscous(_) => true,
                    MotionFactor::One | MotionFactor::Velocity | MotionFactor::VelocityStep | MotionFactor::Backlash(_) => false,
                };
                if friction && regressor.harmonic().is_none() {
                    found.push((*regressor, group.basis.combine(weights)));
                }
            }
        }
        let first = found.iter().map(|(_, fir)| fir.first_lag).min()?;
        let last = found.iter().map(|(_, fir)| fir.last_lag()).max()?;
        let mut table = DMatrix::zeros(found.len(), (last - first + 1) as usize);
        for (row, (_, fir)) in found.iter().enumerate() {
            for (lag, tap) in (fir.first_lag..).zip(&fir.taps) {
                table[(row, (lag - first) as usize)] = *tap;
            }
        }
        let svd = right_singular(table.clone())?;
        let directions = svd.v_t?;
        let largest = svd.singular_values.max();
        let kept = (0..directions.nrows().min(FILTERS)).filter(|&i| svd.singular_values[i] > LEAST_FILTER * largest);
        let kept: Vec<usize> = kept.collect();
        let directions = directions.select_rows(&kept);
        Some(Self {
            regressors: found.iter().map(|(regressor, _)| *regressor).collect(),
            filters: directions.row_iter().map(|row| Fir { first_lag: first, taps: row.iter().copied().collect() }).collect(),
            shares: table * directions.transpose(),
        })
    }

    /// Inputs of the filters, padded.
    fn inputs(&self, signals: &Signals) -> Vec<Vec<f64>> {
        let padded = signals.position().len();
        let mut inputs = vec![vec![0.0; padded]; self.filters.len()];
        let mut values = vec![0.0; padded];
        for (regressor, shares) in self.regressors.iter().zip(self.shares.row_iter()) {
            regressor.fill(signals, &Harmonics::default(), 0, &mut values);
            for (input, share) in inputs.iter_mut().zip(shares.iter()) {
                input.iter_mut().zip(&values).for_each(|(input, value)| *input += share * value);
            }
        }
        inputs
    }

    /// Writes the contribution of a unit of each of the map's values to the prediction, even values
    /// first, to the first of `columns`, which are zero.
    fn fill(&self, scales: &Scales, knots: &Knots, part: &Part<'_>, columns: &mut DMatrixViewMut<'_, f64>) {
        let Some((first, last)) = self.filters.first().map(|filter| (filter.first_lag, filter.last_lag())) else { return };
        let positions = Values::flat(knots.count).on(knots, scales.centre);
        let map = scales.friction_map.as_ref().unwrap_or(&positions);
        // Padded sample of the first row, and the range of padded samples that any row uses.
        let now = part.signals.pad() + part.start;
        let end = (now + columns.nrows().saturating_sub(1) * part.stride + 1).saturating_add_signed(last);
        for p in now.saturating_add_signed(first)..end.min(part.signals.position().len()) {
            let x = part.signals.position()[p];
            let narrowest = if scales.stop_half_widths.is_empty() { part.signals.sign()[p] } else { part.signals.stop(0)[p] };
            let [forwards, backwards] = map.at(x);
            let level = if narrowest < 0.0 { backwards } else { forwards };
            let (before, share) = positions.cell(x);
            for (index, hat) in [(before, 1.0 - share), (before + 1, share)] {
                let Some(index) = usize::try_from(index).ok().filter(|index| *index < knots.count && hat > 0.0) else { continue };
                let latest = p as isize - now as isize - first;
                self.scatter(part, p, hat / level, latest, columns.column_mut(index).as_mut_slice());
                let odd = hat * narrowest / (level * level);
                self.scatter(part, p, odd, latest, columns.column_mut(knots.count + index).as_mut_slice());
            }
        }
    }

    /// Adds the effect of the inputs at the padded sample `p`, times `gain`, to the rows of a part.
    /// The first tap acts `latest` samples after its first row.
    fn scatter(&self, part: &Part<'_>, p: usize, gain: f64, latest: isize, out: &mut [f64]) {
        let Ok(latest) = usize::try_from(latest) else { return };
        for (filter, input) in self.filters.iter().zip(part.inputs) {
            let value = gain * input[p];
            // Row i takes the tap at latest − i·stride.
            let first = (latest + 1).saturating_sub(filter.taps.len()).div_ceil(part.stride);
            let end = (latest / part.stride + 1).min(out.len());
            for (i, y) in out.iter_mut().enumerate().take(end).skip(first) {
                *y += value * filter.taps[latest - i * part.stride];
            }
        }
    }
}

/// Rows of a run that are collected together.
struct Part<'a> {
    signals: &'a Signals,
    /// Inputs of the filters.
    inputs: &'a [Vec<f64>],
    /// First row.
    start: usize,
    /// Distance of the rows.
    stride: usize,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_prior_falls_off_with_distance_and_its_inverse_is_one() {
        let precision = precision(9, 0.25, 0.3, 0.5, 2.0).unwrap_or_default();
        let even = precision.view((0, 0), (9, 9)).into_owned() / 2.0;
        let covariance = even.try_inverse().unwrap_or_default();
        let odd = precision.view((9, 9), (9, 9)).into_owned() / 2.0;
        let of_odd = odd.try_inverse().unwrap_or_default();
        assert!((of_odd[(3, 3)] / 0.0225 - 1.0).abs() < 1e-3, "{}", of_odd[(3, 3)]);
        assert!(of_odd[(3, 4)] < of_odd[(3, 3)] && of_odd[(3, 7)] < 0.3 * of_odd[(3, 3)]);
        // Differences of even values have twice the deviation of those of odd ones; their mean has next to none.
        let difference = |of: &DMatrix<f64>| of[(1, 1)] + of[(7, 7)] - 2.0 * of[(1, 7)];
        assert!((difference(&covariance) / difference(&of_odd) - 4.0).abs() < 0.01);
        assert!(covariance.sum() / 81.0 < 1e-4 * covariance[(3, 3)], "{}", covariance.sum());
    }

    #[test]
    fn a_map_of_levels_that_friction_cannot_have_is_refused() {
        assert!(Values { even: vec![0.5, -0.5], odd: vec![0.3, -0.3] }.is_plausible());
        for (even, odd) in [(-1.2, 0.0), (-0.5, 0.45), (-0.5, -0.45), (12.0, 0.0), (f64::NAN, 0.0)] {
            assert!(!Values { even: vec![0.0, even], odd: vec![0.0, odd] }.is_plausible(), "{even} {odd}");
        }
    }
}
