//! Backlash.

use crate::context::{AxisContext, SPREAD, Sensor};
use crate::finding::{Estimate, Finding, Quantity, Verdict};
use crate::threshold;
use servo::Servo;

/// Standard deviation of what the contacts of the model get wrong: a table that coasts through part of the backlash hides that part. From
/// the blind test's development machines.
const STRUCTURAL_MM: f64 = 1e-3;
/// See [`STRUCTURAL_MM`]; relative.
const STRUCTURAL: f64 = 0.35;

/// Backlash of an axis; only a scale at the table sees it.
pub fn finding(axis: &AxisContext<'_>) -> Finding {
    let hidden = "a motor encoder sits before the backlash and cannot see it: its log is the same with and without";
    let measure = "read the table with a dial gauge or ballbar at reversals, or log the table scale (--sensor table)";
    if axis.sensor == Sensor::Motor {
        return Finding::not_observable(Quantity::Backlash, axis.name(), "µm", hidden, measure);
    }
    let width = |servo: &Servo| servo.backlash_mm + servo.outer_backlash_mm;
    let value = width(&axis.fit.servo);
    let structural = STRUCTURAL_MM.hypot(STRUCTURAL * value);
    let estimate = Estimate::within(value, SPREAD * axis.fit.deviation(width).hypot(structural)).times(1e3).not_negative();
    if axis.sensor == Sensor::Unknown && estimate.low <= 0.0 {
        let why = format!("none is seen; if the logged position is a motor encoder's, it could not be: {hidden}");
        return Finding::not_observable(
            Quantity::Backlash,
            axis.name(),
            "µm",
            why,
            "say where the sensor is (--sensor motor|table)",
        );
    }
    let verdict = threshold::of_deviation(&estimate);
    let unsure = if axis.sensor == Sensor::Unknown { "; holds for a table scale, say so with --sensor table" } else { "" };
    Finding {
        quantity: Quantity::Backlash,
        axis: axis.name().to_owned(),
        estimate: Some(estimate),
        unit: "µm",
        effect_um: Some(estimate),
        verdict,
        details: Vec::new(),
        meaning: format!("way of the motor before the table follows (reversal value of ISO 230-2){unsure}"),
        remedy: match verdict {
            Verdict::Good => String::new(),
            _ => "check nut preload, bearings and coupling; then compensate. SINUMERIK: MD32450 BACKLASH; Fanuc: No. 1851, 1852; LinuxCNC: BACKLASH".to_owned(),
        },
        picture: None,
    }
}
