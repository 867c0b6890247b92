//! A diagnosis, in tables and sentences.

use anyhow::Result;
use diagnosis::{Diagnosis, Finding, Quantity, Sensor, Verdict, threshold};
use serde_json::Value;

use crate::output::{Printer, table};

/// The quantity in words.
#[must_use]
pub fn name(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::VelocityGain => "velocity gain Kv",
        Quantity::FollowingLag => "following lag",
        Quantity::ServoMismatch => "servo mismatch",
        Quantity::ChannelDelay => "delay of channels",
        Quantity::VelocityFeedForward => "velocity feed-forward",
        Quantity::AccelerationFeedForward => "acceleration feed-forward",
        Quantity::CoulombFriction => "Coulomb friction",
        Quantity::StribeckFriction => "static over sliding friction",
        Quantity::Backlash => "backlash",
        Quantity::ReversalPeak => "reversal peak",
        Quantity::Ripple => "ripple",
        Quantity::PitchError => "pitch error",
        Quantity::Resonance => "resonance",
        Quantity::StickSlip => "stick–slip",
        Quantity::Repeatability => "not repeatable",
        Quantity::Drift => "drift between logs",
        Quantity::PlaceFriction => "friction by place",
    }
}

fn verdict(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Good => "good",
        Verdict::Fair => "fair",
        Verdict::Poor => "poor",
        Verdict::Figure => "",
        Verdict::NotObservable => "not observable",
    }
}

/// Three significant digits, without exponent.
#[must_use]
pub fn digits(value: f64) -> String {
    let decimals = match value.abs() {
        size if size >= 100.0 => 0,
        size if size >= 10.0 => 1,
        size if size >= 1.0 => 2,
        _ => 3,
    };
    format!("{value:.decimals$}")
}

/// Everything that was found.
pub fn show(printer: &Printer, found: &Diagnosis) {
    let sensor = match found.sensor {
        Sensor::Motor => "motor encoder",
        Sensor::Table => "table scale",
        Sensor::Unknown => "sensor not stated",
    };
    printer.line(format!(
        "{:.1} s of logs, {sensor}; deviations on a circle of {} mm radius at {} mm/s ({} mm/min)",
        found.seconds,
        digits(found.circle.radius_mm),
        digits(found.circle.feed_mm_s),
        digits(found.circle.feed_mm_s * 60.0)
    ));
    printer.line(threshold::SOURCE);
    for model in &found.models {
        let (tracking, left) = (1e3 * model.tracking_rms_mm, 1e3 * model.residual_rms_mm);
        printer.line(format!(
            "axis {}: tracking error {} µm RMS, of which the servo model leaves {} µm",
            model.axis,
            digits(tracking),
            digits(left)
        ));
    }
    if !found.doubtful_axes.is_empty() {
        let axes = found.doubtful_axes.join(", ");
        printer.line(format!("warning: the servo model does not follow axes {axes}: their findings are doubtful; check the warnings above, or log at a higher rate"));
    }
    let observed: Vec<Vec<String>> = found.findings.iter().filter(|finding| finding.estimate.is_some()).map(row).collect();
    printer.line(table(&["quantity", "axis", "value", "95 % interval", "unit", "effect µm", "verdict"], &observed));
    for finding in found.findings.iter().filter(|finding| !finding.remedy.is_empty() && finding.verdict != Verdict::NotObservable)
    {
        printer.line(format!("{} {}, {}: {}", name(finding.quantity), finding.axis, finding.meaning, finding.remedy));
    }
    let hidden: Vec<&Finding> = found.findings.iter().filter(|finding| finding.verdict == Verdict::NotObservable).collect();
    if !hidden.is_empty() {
        printer.line("not observable in these logs:");
    }
    for finding in hidden {
        printer.line(format!("{} {}: {}; {}", name(finding.quantity), finding.axis, finding.meaning, finding.remedy));
    }
}

fn row(finding: &Finding) -> Vec<String> {
    let (value, interval) = finding.estimate.map_or_else(Default::default, |estimate| {
        (digits(estimate.value), format!("{} … {}", digits(estimate.low), digits(estimate.high)))
    });
    let effect = finding.effect_um.map_or_else(String::new, |effect| digits(effect.value.abs()));
    vec![
        name(finding.quantity).to_owned(),
        finding.axis.clone(),
        value,
        interval,
        finding.unit.to_owned(),
        effect,
        verdict(finding.verdict).to_owned(),
    ]
}

/// The diagnosis as JSON.
pub fn json(found: &Diagnosis) -> Result<Value> {
    let mut figures = serde_json::to_value(found)?;
    figures["thresholds"] = Value::from(threshold::SOURCE);
    Ok(figures)
}
