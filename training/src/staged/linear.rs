//! The linear candidates: pure delay, the law in velocity, acceleration and jerk, and the anchored linear law.

use std::ops::Range;

use models::staged::{FeatureGroup, FeatureSet, Fir, LagBasis, MotionFactor, Pass, Scales};

use super::dataset::AxisDataset;
use super::gram::{FoldErrors, Penalty};
use super::recipe::StagedRecipe;
use crate::TrainingError;

/// Longest delay of the search, s.
const LONGEST_DELAY_S: f64 = 0.1;
/// Delays per sampling period.
const DELAYS_PER_PERIOD: usize = 10;

/// A pass, and its held-out errors.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// Name in the report.
    pub name: &'static str,
    /// Passes, first to last.
    pub passes: Vec<Pass>,
    /// Cross-validated errors on each fold.
    pub errors: FoldErrors,
    /// Errors on each speed band, fitted without it; `None` if the law has too few columns to need
    /// the check.
    pub carried: Option<FoldErrors>,
    /// Whether it has columns that may act differently at each speed or position.
    pub free: bool,
}

/// No error at all; and `e(t) = r(t) − r(t − τ)` with the best `τ`, linear between samples.
pub fn pure_delays(dataset: &AxisDataset<'_>) -> Result<[Candidate; 2], TrainingError> {
    let delays: Vec<f64> = (0..)
        .map(|i| f64::from(i) / DELAYS_PER_PERIOD as f64)
        .take_while(|delay| delay * dataset.period_s() <= LONGEST_DELAY_S)
        .collect();
    let tables: Vec<(Vec<f64>, Vec<usize>)> = delays
        .iter()
        .map(|&delay| {
            let whole = delay.floor() as usize;
            let part = delay - delay.floor();
            dataset.by_fold(|run, k| {
                let reference = dataset.reference(run);
                let late = reference[k.saturating_sub(whole)] * (1.0 - part) + reference[k.saturating_sub(whole + 1)] * part;
                (dataset.errors()[run][k] - (reference[k] - late)).powi(2)
            })
        })
        .collect();
    let best = |left_out: Option<usize>| {
        let cost = |table: &(Vec<f64>, Vec<usize>)| table.0.iter().sum::<f64>() - left_out.map_or(0.0, |fold| table.0[fold]);
        (0..tables.len()).min_by(|&a, &b| cost(&tables[a]).total_cmp(&cost(&tables[b])))
    };
    let none = || TrainingError::Unusable("no delay can be tried".into());
    let chosen = best(None).ok_or_else(none)?;
    let squares = (0..dataset.folds())
        .map(|fold| best(Some(fold)).map(|delay| tables[delay].0[fold]))
        .collect::<Option<_>>()
        .ok_or_else(none)?;
    let delayed = FoldErrors { squares, samples: tables[chosen].1.clone() };
    let nothing = FoldErrors { squares: tables[0].0.clone(), samples: tables[0].1.clone() };
    Ok([
        delay_candidate("none", 0.0, dataset.period_s(), nothing),
        delay_candidate("delay", delays[chosen], dataset.period_s(), delayed),
    ])
}

/// A delay of `delay` samples: `r(k) − r(k − d)` is the sum of the last `d` velocities times the period.
fn delay_candidate(name: &'static str, delay: f64, period_s: f64, errors: FoldErrors) -> Candidate {
    let whole = delay.floor();
    let mut taps = vec![period_s; whole as usize + 1];
    taps[0] *= delay - whole;
    let response = Fir { first_lag: -(whole as isize), taps };
    let features =
        FeatureSet { scales: Scales::linear(), groups: vec![group(LagBasis::new(vec![response]), &[MotionFactor::Velocity])] };
    Candidate { name, passes: vec![Pass { features, weights: vec![1.0] }], errors, carried: None, free: false }
}

/// `e = c + c_v·v + c_a·a + c_j·j`, from the velocity and its increments at the present and the next sample.
pub fn velocity_acceleration_jerk(
    dataset: &AxisDataset<'_>,
    bases: &[Vec<f64>],
    recipe: &StagedRecipe,
) -> Result<Candidate, TrainingError> {
    let features = FeatureSet {
        scales: Scales::linear(),
        groups: vec![
            group(LagBasis::now(), &[MotionFactor::Velocity, MotionFactor::One]),
            group(LagBasis::dense(0, 1), &[MotionFactor::VelocityStep]),
        ],
    };
    let signals = dataset.signals(&features, bases);
    let grams = dataset.grams(&features, &signals, &[], dataset.errors());
    let penalties = vec![Penalty::ridge(recipe.linear_ridge); features.columns()];
    let weights = grams.total().solve(&penalties);
    let errors = grams.cross_validate(&penalties);
    let carried = grams.carry_over(&penalties);
    let (Some(weights), Some(errors)) = (weights, errors) else {
        return Err(TrainingError::Singular("v-a-j"));
    };
    Ok(Candidate { name: "v-a-j", passes: vec![Pass { features, weights }], errors, carried, free: false })
}

/// Columns of the anchored linear law and the prior of their weights.
///
/// The prior of the response to a velocity step: it differs from its steady value by about the
/// steady lag at first, and by less as time goes on. Its increments are independent with
/// exponentially decreasing variance (the stable-spline or TC prior of system identification). A
/// log of smooth motion contains little information on fast changes; the prior regularises them.
#[derive(Debug, Clone)]
pub struct LinearLaw {
    /// `v`, 1, `v(k) − v(k − m − 1)`, increments ahead.
    pub features: FeatureSet,
    /// Prior variance of each weight; infinite for `v` and 1.
    variances: Vec<f64>,
    /// Lags between which the responses to friction are linear, samples. They last as long as this
    /// law's response.
    pub knots: Vec<isize>,
}

impl LinearLaw {
    /// The law with a response that decays with time constant `memory_s`, around a steady lag of
    /// `lag_s`.
    pub fn new(memory_s: f64, lag_s: f64, period_s: f64, recipe: &StagedRecipe) -> Self {
        let longest = (recipe.memories * memory_s / period_s).ceil().max(2.0) as usize;
        let groups = lag_groups(longest, (recipe.dense_s / period_s).round() as usize, recipe.lag_growth);
        let ahead_s = recipe.future_s.min(recipe.memories * memory_s);
        let future = (ahead_s / period_s).round().max(1.0) as usize;
        let decay = (-2.0 * period_s / memory_s).exp();
        let size = lag_s.abs().max(period_s).powi(2);
        let variance = |m: usize| size * (1.0 - decay) * decay.powi(m as i32);
        let back = groups.iter().map(|group| group.clone().map(variance).sum());
        let ahead = (0..future).map(variance);
        Self {
            features: FeatureSet {
                scales: Scales::linear(),
                groups: vec![
                    group(LagBasis::now(), &[MotionFactor::Velocity, MotionFactor::One]),
                    group(LagBasis::sums(&groups, future), &[MotionFactor::VelocityStep]),
                ],
            },
            variances: [f64::INFINITY; 2].into_iter().chain(back).chain(ahead).collect(),
            knots: knots(&recipe.knots_s, recipe.memories * memory_s, period_s),
        }
    }

    /// Penalties of the law's columns for a residual of mean square `noise`.
    pub fn penalties(&self, noise: f64, recipe: &StagedRecipe) -> Vec<Penalty> {
        self.variances
            .iter()
            .map(|variance| Penalty { ridge: recipe.linear_ridge, prior: noise * recipe.correlated / variance })
            .collect()
    }
}

/// Lags `0..=longest` in groups: single lags up to `dense`, then widths that grow by the share
/// `growth` of the distance beyond it, since late responses are slow.
fn lag_groups(longest: usize, dense: usize, growth: f64) -> Vec<Range<usize>> {
    let mut groups = Vec::new();
    let mut start = 0;
    while start <= longest {
        let width = (growth * start.saturating_sub(dense) as f64).round().max(1.0) as usize;
        let end = (start + width).min(longest + 1);
        groups.push(start..end);
        start = end;
    }
    groups
}

/// Ratio of the lags of successive knots beyond those of the recipe.
const KNOT_GROWTH: f64 = 1.35;

/// Knots in whole samples: those of the recipe, and further ones up to `longest_s` back.
fn knots(seconds: &[f64], longest_s: f64, period_s: f64) -> Vec<isize> {
    let earliest = seconds.iter().copied().fold(0.0, f64::min);
    let further = std::iter::successors(Some(earliest * KNOT_GROWTH), |knot| Some(knot * KNOT_GROWTH));
    let further = further.take_while(|knot| *knot < 0.0 && -knot <= longest_s);
    let mut knots: Vec<isize> = seconds.iter().copied().chain(further).map(|s| (s / period_s).round() as isize).collect();
    knots.sort_unstable();
    knots.dedup();
    knots
}

/// The anchored linear law with a response that decays with time constant `memory_s`.
pub fn anchored(
    dataset: &AxisDataset<'_>,
    bases: &[Vec<f64>],
    recipe: &StagedRecipe,
    simpler: &Candidate,
    memory_s: f64,
) -> Result<(Candidate, LinearLaw), TrainingError> {
    let lag_s = simpler.passes.first().and_then(|pass| pass.weights.first()).copied().unwrap_or_default();
    let law = LinearLaw::new(memory_s, lag_s, dataset.period_s(), recipe);
    let signals = dataset.signals(&law.features, bases);
    let grams = dataset.grams(&law.features, &signals, &[], dataset.errors());
    let penalties = law.penalties(simpler.errors.mean_square(), recipe);
    let weights = grams.total().solve(&penalties);
    let errors = grams.cross_validate(&penalties);
    let (Some(weights), Some(errors)) = (weights, errors) else {
        return Err(TrainingError::Singular("linear"));
    };
    let candidate = Candidate {
        name: "linear",
        passes: vec![Pass { features: law.features.clone(), weights }],
        errors,
        carried: grams.carry_over(&penalties),
        free: false,
    };
    Ok((candidate, law))
}

/// Motion factors through one basis.
pub fn group(basis: LagBasis, factors: &[MotionFactor]) -> FeatureGroup {
    FeatureGroup { basis, channels: factors.iter().map(|&factor| factor.into()).collect() }
}
