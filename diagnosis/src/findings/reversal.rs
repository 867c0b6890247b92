//! Peaks after reversals.

use crate::bootstrap::{interval, median};
use crate::context::AxisContext;
use crate::finding::{Finding, Label, Mark, Picture, Quantity, Series, Verdict};
use crate::reversals::{AFTER_S, BEFORE_S, Peak, peak, reversals};
use crate::threshold;

/// Fewest reversals for a figure.
const FEWEST: usize = 5;

/// Height and time of the peaks after reversals of an axis.
pub fn finding(axis: &AxisContext<'_>) -> Finding {
    let peaks = peaks(axis);
    let median_of = |of: fn(&Peak) -> f64| move |peaks: &[&Peak]| median(peaks.iter().map(|peak| of(peak)).collect());
    let height = if peaks.len() < FEWEST { None } else { interval(&peaks, median_of(|peak| 1e3 * peak.height_mm)) };
    let Some(estimate) = height else {
        let why = format!("{} reversals stand {:.2} s apart from others", peaks.len(), BEFORE_S + AFTER_S);
        return Finding::not_observable(
            Quantity::ReversalPeak,
            axis.name(),
            "µm",
            why,
            "record a run with reversals at some mm/s, a circle for instance",
        );
    };
    let all: Vec<&Peak> = peaks.iter().collect();
    let verdict = threshold::of_deviation(&estimate);
    Finding {
        quantity: Quantity::ReversalPeak,
        axis: axis.name().to_owned(),
        estimate: Some(estimate),
        unit: "µm",
        effect_um: Some(estimate),
        verdict,
        details: vec![
            ("time to the peak, ms", median_of(|peak| 1e3 * peak.time_s)(&all)),
            ("duration at half height, ms", median_of(|peak| 1e3 * peak.duration_s)(&all)),
            ("reversals", peaks.len() as f64),
        ],
        meaning: "median peak after a reversal: friction turns round, backlash is crossed (ballbar: reversal spike; quadrant glitch)".to_owned(),
        remedy: match verdict {
            Verdict::Good => String::new(),
            _ => "friction compensation at the zero crossing of speed. SINUMERIK: MD32500 FRICT_COMP_ENABLE, MD32520 (height), MD32540 (time); Fanuc: \
                  No. 2048, 2071; or precomp compensate, which needs no access to the drives"
                .to_owned(),
        },
        picture: Some(picture(axis, &peaks)),
    }
}

/// The peaks of all runs.
fn peaks(axis: &AxisContext<'_>) -> Vec<Peak> {
    let record = axis.record;
    let late = (axis.fit.servo.lag_s().max(0.0) / record.period_s).round() as usize;
    let runs = record.runs.iter().zip(&axis.beyond_linear);
    runs.flat_map(|(run, deviation)| {
        // The axis turns later than its command.
        let turned = reversals(&run.reference, record.period_s).into_iter();
        let turned = turned.filter(|turn| turn.sample >= record.first_scored());
        turned.filter_map(|turn| {
            peak(deviation, crate::reversals::Reversal { sample: turn.sample + late, ..turn }, record.period_s)
        })
    })
    .collect()
}

/// Mean course after the reversals of either direction.
fn picture(axis: &AxisContext<'_>, peaks: &[Peak]) -> Picture {
    let mean = |direction: f64, name: &str| {
        let courses: Vec<&Vec<f64>> =
            peaks.iter().filter(|peak| peak.direction == direction).map(|peak| &peak.course_mm).collect();
        let count = courses.iter().map(|course| course.len()).min().unwrap_or(0);
        let points = (0..count).map(|k| {
            let sum: f64 = courses.iter().map(|course| course[k]).sum();
            (1e3 * (k as f64 * axis.record.period_s - BEFORE_S), 1e3 * sum / courses.len() as f64)
        });
        Series::new(name, Mark::Line, points)
    };
    Picture {
        title: format!("{}: mean course after reversals", axis.name()),
        x: Label::new("time after the reversal", "ms"),
        y: Label::new("behind the frictionless axis", "µm"),
        series: vec![mean(1.0, "− → +"), mean(-1.0, "+ → −")],
    }
}
