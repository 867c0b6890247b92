//! Friction that depends on the place.

use crate::context::{AxisContext, SPREAD};
use crate::disturbance::{Regression, responses};
use crate::finding::{Estimate, Finding, Label, Mark, Picture, Quantity, Series};
use crate::threshold;

/// Distance of the places at which the level is found, at least, mm, and their largest number.
const LEAST_MM: f64 = 6.0;
const MOST: usize = 16;
/// Fewest places for a figure.
const FEWEST: usize = 4;
/// Least Coulomb friction, mm, that has a level.
const LEAST_FRICTION_MM: f64 = 2e-4;

/// Standard deviation of what the model gets wrong, absolute and relative: from the blind test's development machines.
const STRUCTURAL: (f64, f64) = (0.025, 0.1);
/// Share of the residual that levels may explain by chance, because it repeats with the motion: from the same machines.
const UNLIKE: f64 = 0.15;
/// Upper bound of the variance between places.
const LARGEST_SPREAD: f64 = 100.0;
/// Upper end of an amplitude above which the friction does not explain what is seen.
const MOST_AMPLITUDE: f64 = 0.9;

/// Values of one quantity at several places, each with its variance.
struct Levels {
    values: Vec<(f64, f64)>,
}

impl Levels {
    /// Mean, weighted for a variance between places.
    fn mean(&self, between: f64) -> f64 {
        let weight = |variance: f64| (variance + between).max(f64::MIN_POSITIVE).recip();
        let total: f64 = self.values.iter().map(|(_, variance)| weight(*variance)).sum();
        self.values.iter().map(|(value, variance)| value * weight(*variance)).sum::<f64>() / total
    }

    /// Harmonic mean of the variances.
    fn variance(&self) -> f64 {
        let precisions: f64 = self.values.iter().map(|(_, variance)| variance.max(f64::MIN_POSITIVE).recip()).sum();
        self.values.len() as f64 / precisions
    }

    /// Sum of squares about the mean over their variances.
    fn squares(&self, between: f64) -> f64 {
        let mean = self.mean(between);
        let one = |(value, variance): &(f64, f64)| (value - mean).powi(2) / (variance + between).max(f64::MIN_POSITIVE);
        self.values.iter().map(one).sum()
    }

    /// Variance between places, the lower end of its 95 % interval, value and upper end: that at which the squares are as large as χ² of the
    /// degrees of freedom on average (Paule and Mandel 1982), and at the ends of its 95 % interval (Viechtbauer 2007).
    fn spreads(&self) -> [f64; 3] {
        let freedom = (self.values.len() - 1) as f64;
        [chi_squared(freedom, SPREAD), freedom, chi_squared(freedom, -SPREAD)].map(|wanted| self.spread(wanted))
    }

    /// Variance between places at which the squares are `wanted`; 0 where they are less without any. They fall with it.
    fn spread(&self, wanted: f64) -> f64 {
        let (mut low, mut high) = (0.0, LARGEST_SPREAD);
        if self.squares(low) <= wanted {
            return 0.0;
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.squares(middle) > wanted { low = middle } else { high = middle }
        }
        high
    }
}

/// Quantile of χ² where a normal variable has `deviations` (Wilson and Hilferty 1931).
fn chi_squared(freedom: f64, deviations: f64) -> f64 {
    let part = 2.0 / (9.0 * freedom);
    freedom * (1.0 - part + deviations * part.sqrt()).max(0.0).powi(3)
}

/// RMS of what all places together show in the logs, for a level of 1, mm.
fn shown_mm(regressors: &[Vec<Vec<f64>>], first: usize) -> f64 {
    let runs = regressors.first().map_or(0, Vec::len);
    let (mut squares, mut count) = (0.0, 0_usize);
    for run in 0..runs {
        for k in first..regressors[0][run].len() {
            squares += regressors.iter().map(|places| places[run][k]).sum::<f64>().powi(2);
            count += 1;
        }
    }
    (squares / count.max(1) as f64).sqrt()
}

/// Level of friction along the axis.
pub fn finding(axis: &AxisContext<'_>) -> Finding {
    let record = axis.record;
    let quantity = Quantity::PlaceFriction;
    let actual = || record.runs.iter().flat_map(|run| run.actual.iter().copied());
    let (low, high) = actual().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    let places = (((high - low) / LEAST_MM) as usize + 1).min(MOST);
    if places < FEWEST {
        let why = format!("the axis moves over {:.1} mm only", high - low);
        return Finding::not_observable(quantity, axis.name(), "%", why, "record strokes over the whole travel");
    }
    if axis.fit.servo.coulomb_mm < LEAST_FRICTION_MM {
        return Finding::not_observable(quantity, axis.name(), "%", "friction itself is hardly seen", "nothing: it does no harm");
    }
    let spacing = (high - low) / (places - 1) as f64;
    let hat = |place: usize, x: f64| (1.0 - ((x - low) / spacing - place as f64).abs()).max(0.0);
    let regressors: Vec<Vec<Vec<f64>>> = (0..places)
        .map(|place| {
            responses(axis, axis.fit.servo.table_friction, |run, k| {
                -axis.friction_mm[run][k] * hat(place, record.runs[run].actual[k])
            })
        })
        .collect();
    let Some(levels) = Regression::of(&axis.residuals, &regressors, record.first_scored(), record.period_s) else {
        return Finding::not_observable(quantity, axis.name(), "%", "the places are passed too seldom", "record more strokes");
    };
    let unlike = UNLIKE * axis.fit.mean_square.sqrt() / shown_mm(&regressors, record.first_scored()).max(f64::MIN_POSITIVE);
    let variance = |i: usize| levels.covariance[(i, i)].max(0.0) + unlike * unlike;
    let measured = Levels { values: (0..places).map(|i| (levels.weights[i], variance(i))).collect() };
    // Amplitude of a wave of this spread.
    let amplitude_of = |spread: f64| (2.0 * spread).sqrt();
    let [least, amplitude, most] = measured.spreads().map(amplitude_of);
    // A spread as large as that of the values alone would not be seen.
    let most = most.max(amplitude_of(measured.variance()));
    let mean = measured.mean(0.5 * amplitude * amplitude);
    let structural = SPREAD * (STRUCTURAL.0 + STRUCTURAL.1 * amplitude);
    let estimate = Estimate { value: amplitude, low: (least - structural).max(0.0), high: most + structural }.times(100.0);
    if most > MOST_AMPLITUDE {
        let why = "what the servo model leaves is larger than the friction";
        return Finding::not_observable(quantity, axis.name(), "%", why, "record slower strokes over the whole travel");
    }
    let effect =
        estimate.times(0.01 * 1e3 * crate::circle::glitch_mm(&servo::Servo { backlash_mm: 0.0, ..axis.fit.servo }, axis.circle));
    let points = |by: f64| (0..places).map(move |i| (low + spacing * i as f64, by, i));
    let series = |name: &str, mark: Mark, by: f64| {
        Series::new(
            name,
            mark,
            points(by).map(|(x, by, i)| (x, 100.0 * (1.0 + levels.weights[i] - mean + by * variance(i).sqrt()))),
        )
    };
    Finding {
        quantity,
        axis: axis.name().to_owned(),
        estimate: Some(estimate),
        unit: "%",
        effect_um: Some(effect),
        verdict: threshold::of_deviation(&effect),
        details: vec![("from, mm", low), ("to, mm", high)],
        meaning: "amplitude by which friction differs along the axis (√2 times its RMS about the mean); effect: change of the quadrant glitch".to_owned(),
        remedy: match threshold::of_deviation(&effect) {
            crate::finding::Verdict::Good => String::new(),
            _ => "look at guide, cover and screw where the level is high; precomp compensate takes the place into account".to_owned(),
        },
        picture: Some(Picture {
            title: format!("{}: level of friction along the axis", axis.name()),
            x: Label::new("position", "mm"),
            y: Label::new("friction against its mean", "%"),
            series: vec![
                series("95 % interval, from", Mark::Lower, -SPREAD),
                series("to", Mark::Upper, SPREAD),
                series("level", Mark::Line, 0.0),
            ],
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_spread_between_places_is_found_beside_that_of_their_values() {
        // Levels 1 ± 0.2, known to 0.05; one place is hardly known.
        let mut values = [(1.2, 0.05 * 0.05), (0.8, 0.05 * 0.05)].repeat(8);
        values.push((9.0, 100.0));
        let levels = Levels { values };
        let [least, found, most] = levels.spreads().map(f64::sqrt);
        assert!((found - 0.2).abs() < 0.02 && least > 0.13 && most < 0.33, "{least} {found} {most}");
        let equal = Levels { values: (0..10).map(|i| (1.0 + 0.01 * f64::from(i % 2), 0.01)).collect() };
        assert_eq!(equal.spreads()[..2], [0.0, 0.0]);
    }

    #[test]
    fn quantiles_are_those_of_tables() {
        for (freedom, deviations, quantile) in [(10.0, SPREAD, 20.48), (10.0, -SPREAD, 3.25), (3.0, SPREAD, 9.35)] {
            assert!((chi_squared(freedom, deviations) / quantile - 1.0).abs() < 0.03, "{freedom} {deviations}");
        }
    }
}
