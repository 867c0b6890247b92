//! Mismatch of the following lags of two axes.

use std::f64::consts::TAU;

use crate::context::{AxisContext, SPREAD};
use crate::finding::{Estimate, Finding, Label, Mark, Picture, Quantity, Series, Verdict};
use crate::threshold;
use servo::Servo;

/// Points of the picture.
const POINTS: usize = 180;

/// Findings for every pair of linear axes.
pub fn mismatches(axes: &[AxisContext<'_>]) -> Vec<Finding> {
    let linear: Vec<&AxisContext<'_>> = axes.iter().filter(|axis| !axis.record.rotary).collect();
    let pairs = linear.iter().enumerate().flat_map(|(i, one)| linear[i + 1..].iter().map(move |other| (*one, *other)));
    pairs.map(|(one, other)| mismatch(one, other)).collect()
}

/// On a circle the difference `Δτ` of two lags moves the path by `v Δτ sin θ cos θ` across: an ellipse at 45°, `± v Δτ / 2`.
fn mismatch(one: &AxisContext<'_>, other: &AxisContext<'_>) -> Finding {
    let name = format!("{}-{}", one.name(), other.name());
    let difference_s = one.fit.servo.lag_s() - other.fit.servo.lag_s();
    let deviation_s = one.fit.deviation(Servo::lag_s).hypot(other.fit.deviation(Servo::lag_s));
    let estimate = Estimate::within(difference_s, SPREAD * deviation_s).times(1e3);
    let feed = one.circle.feed_mm_s;
    let effect = estimate.times(0.5 * feed);
    let verdict = threshold::of_deviation(&effect);
    let (slower, faster) = if difference_s > 0.0 { (one, other) } else { (other, one) };
    let remedy = match verdict {
        Verdict::Good => String::new(),
        _ => format!(
            "match the lags: raise gain or feed-forward of {} (now Kv {:.1} 1/s, feed-forward {:.3}) or lower those of {} (Kv {:.1} 1/s, {:.3}). \
             SINUMERIK: MD32200 POSCTRL_GAIN, MD32610 VELO_FFW_WEIGHT, MD32900 DYN_MATCH_ENABLE; Fanuc: No. 1825, 2069; LinuxCNC: P, FF1",
            slower.name(),
            slower.fit.servo.position_gain_1_s,
            slower.fit.servo.feed_forward,
            faster.name(),
            faster.fit.servo.position_gain_1_s,
            faster.fit.servo.feed_forward,
        ),
    };
    let points = (0..=POINTS).map(|i| {
        let angle = TAU * i as f64 / POINTS as f64;
        (angle.to_degrees(), effect.value * (2.0 * angle).sin())
    });
    Finding {
        quantity: Quantity::ServoMismatch,
        axis: name.clone(),
        estimate: Some(estimate),
        unit: "ms",
        effect_um: Some(effect),
        verdict,
        details: vec![("radial deviation at 45° on the test circle, µm", effect.value)],
        meaning: "difference of the following lags: it makes an ellipse at 45° of a circle (ISO 230-4; ballbar: servo mismatch)"
            .to_owned(),
        remedy,
        picture: Some(Picture {
            title: format!("{name}: radial deviation on the test circle by the mismatch"),
            x: Label::new("angle, counterclockwise", "deg"),
            y: Label::new("radial deviation", "µm"),
            series: vec![Series::new(name, Mark::Line, points)],
        }),
    }
}
