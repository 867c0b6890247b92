//! Noise and what does not repeat: no compensation removes it.

use std::collections::BTreeMap;

use crate::bootstrap::interval;
use crate::context::AxisContext;
use crate::finding::{Estimate, Finding, Quantity};
use crate::record::Run;
use crate::threshold;

/// Distance up to which two commands are the same, mm, and shortest run that is compared, s.
const SAME_MM: f64 = 1e-6;
const SHORTEST_S: f64 = 1.0;
/// Length of the exchangeable stretches, s.
const STRETCH_S: f64 = 0.5;

/// What does not repeat from run to run; without a repeated run an upper bound.
pub fn finding(axis: &AxisContext<'_>) -> Finding {
    let (squares, repeats) = repeated(axis);
    let stretch = (STRETCH_S / axis.record.period_s) as usize;
    let first = axis.record.first_scored();
    let (stretches, meaning): (Vec<f64>, _) = if repeats > 0 {
        (
            squares,
            format!(
                "standard deviation of a run about the mean of equal runs, from {repeats} repeated runs: the floor of every compensation"
            ),
        )
    } else {
        let runs = axis.residuals.iter().map(|run| run.get(first..).unwrap_or_default());
        let parts = runs.flat_map(|run| run.chunks(stretch.max(1)));
        let squares = parts.map(|part| part.iter().map(|r| r * r).sum::<f64>() / part.len() as f64).collect();
        let meaning = "upper bound: what the servo model leaves, RMS; a trained model predicts more of it (precomp train)";
        (squares, meaning.to_owned())
    };
    let root = |drawn: &[&f64]| 1e3 * (drawn.iter().copied().sum::<f64>() / drawn.len() as f64).sqrt();
    let Some(estimate) = interval(&stretches, root) else {
        return Finding::not_observable(
            Quantity::Repeatability,
            axis.name(),
            "µm",
            "the logs are too short",
            "record some seconds more",
        );
    };
    // Without repeats nothing is said of what lies below.
    let estimate = if repeats > 0 { estimate } else { Estimate { low: 0.0, ..estimate } };
    Finding {
        quantity: Quantity::Repeatability,
        axis: axis.name().to_owned(),
        estimate: Some(estimate),
        unit: "µm",
        effect_um: Some(estimate),
        verdict: if repeats > 0 { threshold::of_deviation(&estimate) } else { crate::finding::Verdict::Figure },
        details: vec![("repeated runs", repeats as f64)],
        meaning,
        remedy: if repeats > 0 { String::new() } else { "for the floor itself record the same program twice".to_owned() },
        picture: None,
    }
}

/// Variance about the mean of equal runs, by stretches, and the number of runs that have an equal one.
fn repeated(axis: &AxisContext<'_>) -> (Vec<f64>, usize) {
    let record = axis.record;
    let (stretch, first) = ((STRETCH_S / record.period_s) as usize, record.first_scored());
    let mut groups: BTreeMap<usize, Vec<&Run>> = BTreeMap::new();
    for (index, run) in record.runs.iter().enumerate() {
        let equal = groups.iter_mut().find(|(_, runs)| runs.first().is_some_and(|known| is_equal(known, run)));
        match equal {
            Some((_, runs)) => runs.push(run),
            None => drop(groups.insert(index, vec![run])),
        }
    }
    let (mut squares, mut repeats) = (Vec::new(), 0);
    for runs in groups.values().filter(|runs| runs.len() > 1 && runs[0].len() as f64 * record.period_s > SHORTEST_S) {
        repeats += runs.len();
        let count = runs.len() as f64;
        let variance = |k: usize| {
            let mean = runs.iter().map(|run| run.actual[k]).sum::<f64>() / count;
            runs.iter().map(|run| (run.actual[k] - mean).powi(2)).sum::<f64>() / (count - 1.0)
        };
        let all: Vec<f64> = (first..runs[0].len()).map(variance).collect();
        squares.extend(all.chunks(stretch.max(1)).map(|part| part.iter().sum::<f64>() / part.len() as f64));
    }
    (squares, repeats)
}

fn is_equal(one: &Run, other: &Run) -> bool {
    one.len() == other.len() && one.reference.iter().zip(&other.reference).all(|(a, b)| (a - b).abs() < SAME_MM)
}
