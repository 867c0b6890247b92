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
const STRUCTURAL: (f64, f64) = (0.025, 0.15);
/// Amplitude above which the friction does not explain what is seen.
const MOST_AMPLITUDE: f64 = 0.9;

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
        .map(|place| responses(axis, |run, k| -axis.friction_mm[run][k] * hat(place, record.runs[run].actual[k])))
        .collect();
    let Some(levels) = Regression::of(&axis.residuals, &regressors, record.first_scored(), record.period_s) else {
        return Finding::not_observable(quantity, axis.name(), "%", "the places are passed too seldom", "record more strokes");
    };
    // Weighted by how well each place is known: the ends of the travel are passed seldom.
    let variance = |i: usize| levels.covariance[(i, i)].max(1e-12);
    let total: f64 = (0..places).map(|i| variance(i).recip()).sum();
    let mean = (0..places).map(|i| levels.weights[i] / variance(i)).sum::<f64>() / total;
    let spread = (0..places).map(|i| (levels.weights[i] - mean).powi(2) / variance(i)).sum::<f64>() / total;
    // Noise alone spreads the levels by this much.
    let noise = (places - 1) as f64 / total;
    let amplitude = (2.0 * (spread - noise).max(0.0)).sqrt();
    // Of a sum of squares about its mean: twice the square of the noise, and four times its product with the spread.
    let deviation =
        (2.0 * noise * noise / (places - 1) as f64 + 4.0 * noise * (spread - noise).max(0.0) / (places - 1) as f64).sqrt();
    let half = |square: f64| (2.0 * square.max(0.0)).sqrt();
    let (least, most) = (half(spread - noise - SPREAD * deviation), half(spread - noise + SPREAD * deviation));
    let structural = SPREAD * (STRUCTURAL.0 + STRUCTURAL.1 * amplitude);
    let estimate = Estimate { value: amplitude, low: (least - structural).max(0.0), high: most + structural }.times(100.0);
    if amplitude > MOST_AMPLITUDE {
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
