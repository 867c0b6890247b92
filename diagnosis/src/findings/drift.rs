//! Drift of friction and lag between the logs.

use crate::circle::glitch_mm;
use crate::context::{AxisContext, SPREAD};
use crate::disturbance::{Regression, responses};
use crate::finding::{Estimate, Finding, Label, Mark, Picture, Quantity, Series, Verdict};
use crate::threshold;
use servo::Servo;

/// Most logs that are compared; of more, neighbours are taken together.
const MOST: usize = 24;

/// Change of the friction level from log to log.
pub fn finding(axis: &AxisContext<'_>) -> Finding {
    let record = axis.record;
    let groups = record.runs.len().min(MOST);
    if groups < 2 {
        let why = "there is one log only";
        return Finding::not_observable(Quantity::Drift, axis.name(), "%", why, "give logs of several runs, cold and warm");
    }
    let group = |run: usize| run * groups / record.runs.len();
    let mut regressors: Vec<Vec<Vec<f64>>> = (0..groups)
        .map(|wanted| {
            responses(
                axis,
                axis.fit.servo.table_friction,
                |run, k| if group(run) == wanted { -axis.friction_mm[run][k] } else { 0.0 },
            )
        })
        .collect();
    for wanted in 0..groups {
        let speed = |(index, run): (usize, &crate::record::Run)| {
            (0..run.len()).map(|k| if group(index) == wanted { -run.velocity(k, record.period_s) } else { 0.0 }).collect()
        };
        regressors.push(record.runs.iter().enumerate().map(speed).collect());
    }
    let Some(levels) = Regression::of(&axis.residuals, &regressors, record.first_scored(), record.period_s) else {
        return Finding::not_observable(
            Quantity::Drift,
            axis.name(),
            "%",
            "a log moves the axis too little",
            "give logs that move every axis",
        );
    };
    let (friction, lag) = (spread(&levels, 0, groups), spread(&levels, groups, 2 * groups));
    let estimate = friction.times(100.0);
    let glitch = 1e3 * glitch_mm(&Servo { backlash_mm: 0.0, ..axis.fit.servo }, axis.circle);
    let effect = friction.times(glitch);
    let verdict = threshold::of_deviation(&effect);
    let points = (0..groups).map(|i| ((i + 1) as f64, 100.0 * (1.0 + levels.weights[i])));
    Finding {
        quantity: Quantity::Drift,
        axis: axis.name().to_owned(),
        estimate: Some(estimate),
        unit: "%",
        effect_um: Some(effect),
        verdict,
        details: vec![("of the lag, ms", 1e3 * lag.value), ("logs", record.runs.len() as f64)],
        meaning:
            "standard deviation of the friction level from log to log, noise taken off; effect: change of the quadrant glitch"
                .to_owned(),
        remedy: match verdict {
            Verdict::Good => String::new(),
            _ => "warm the machine up before it cuts and before logs are made; adapt the model with precomp train --from"
                .to_owned(),
        },
        picture: Some(Picture {
            title: format!("{}: friction level by log", axis.name()),
            x: Label::new("log", ""),
            y: Label::new("friction against its mean", "%"),
            series: vec![Series::new("level", Mark::Points, points)],
        }),
    }
}

/// Standard deviation of weights about their mean, less what noise alone makes of it.
fn spread(levels: &Regression, from: usize, to: usize) -> Estimate {
    let count = (to - from) as f64;
    let mean = (from..to).map(|i| levels.weights[i]).sum::<f64>() / count;
    let total = (from..to).map(|i| (levels.weights[i] - mean).powi(2)).sum::<f64>() / (count - 1.0);
    let noise = (from..to).map(|i| levels.covariance[(i, i)]).sum::<f64>() / count;
    let deviation = total * (2.0 / (count - 1.0)).sqrt();
    let root = |square: f64| square.max(0.0).sqrt();
    Estimate {
        value: root(total - noise),
        low: root(total - noise - SPREAD * deviation),
        high: root(total - noise + SPREAD * deviation),
    }
}
