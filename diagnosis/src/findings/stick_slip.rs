//! Stick–slip: an axis that stands and jumps while its command moves slowly.

use crate::bootstrap::interval;
use crate::context::AxisContext;
use crate::finding::{Finding, Quantity, Verdict};
use crate::threshold;

/// Slowest and fastest command that counts as slow, mm/s.
const SLOW_MM_S: (f64, f64) = (0.05, 3.0);
/// Time at the same direction before a sample counts, and shortest time of slow motion in all, s.
const SETTLED_S: f64 = 0.15;
const LEAST_S: f64 = 1.5;
/// Length of the exchangeable stretches, s.
const STRETCH_S: f64 = 0.25;

/// Stick–slip of an axis.
pub fn finding(axis: &AxisContext<'_>) -> Finding {
    let stretches = stretches(axis);
    if (stretches.len() as f64) * STRETCH_S < LEAST_S {
        let why = format!("{:.1} s of steady motion below {} mm/s", stretches.len() as f64 * STRETCH_S, SLOW_MM_S.1);
        return Finding::not_observable(
            Quantity::StickSlip,
            axis.name(),
            "µm",
            why,
            "record strokes of a few mm at 0.2 to 2 mm/s in both directions",
        );
    }
    let Some(estimate) = interval(&stretches, |drawn| 1e3 * drawn.iter().map(|jump| **jump).sum::<f64>() / drawn.len() as f64)
    else {
        return Finding::not_observable(Quantity::StickSlip, axis.name(), "µm", "too little slow motion", "record slow strokes");
    };
    let verdict = threshold::of_deviation(&estimate);
    Finding {
        quantity: Quantity::StickSlip,
        axis: axis.name().to_owned(),
        estimate: Some(estimate),
        unit: "µm",
        effect_um: Some(estimate),
        verdict,
        details: vec![("slow motion, s", stretches.len() as f64 * STRETCH_S)],
        meaning: "mean range of the error beyond the model within a quarter of a second of slow, steady motion".to_owned(),
        remedy: match verdict {
            Verdict::Good => String::new(),
            _ => {
                "way lubrication, gib adjustment, seals; a higher velocity-loop gain; slow feeds only in one direction".to_owned()
            }
        },
        picture: None,
    }
}

/// Range of the residual within each stretch of slow motion without reversal, mm.
fn stretches(axis: &AxisContext<'_>) -> Vec<f64> {
    let record = axis.record;
    let (settled, length) = ((SETTLED_S / record.period_s) as usize, ((STRETCH_S / record.period_s) as usize).max(1));
    let mut ranges = Vec::new();
    for (run, residual) in record.runs.iter().zip(&axis.residuals) {
        // Samples of slow motion in the same direction up to here.
        let (mut steady, mut direction) = (0_usize, 0.0);
        for k in record.first_scored()..run.len() {
            let velocity = run.velocity(k, record.period_s);
            let is_slow = (SLOW_MM_S.0..SLOW_MM_S.1).contains(&velocity.abs());
            steady = if is_slow && velocity.signum() == direction { steady + 1 } else { 0 };
            direction = velocity.signum();
            if steady >= settled + length {
                let part = &residual[k + 1 - length..=k];
                let (low, high) =
                    part.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), r| (low.min(*r), high.max(*r)));
                ranges.push(high - low);
                steady -= length;
            }
        }
    }
    ranges
}
