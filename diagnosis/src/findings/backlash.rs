//! Backlash.

use crate::context::{AxisContext, SPREAD, Sensor};
use crate::finding::{Estimate, Finding, Quantity, Verdict};
use crate::threshold;
use servo::Servo;

/// Standard deviation of what the contacts of the model get wrong: a table that coasts through part of the backlash hides that part. From
/// the blind test's development machines.
const STRUCTURAL_MM: f64 = 1e-3;
/// See [`STRUCTURAL_MM`]; relative, below and above the value. The fit finds too little backlash: on machines 280 to 319 of the blind test, 0.6 of it in
/// the median and less than 0.4 in one case of five.
const STRUCTURAL: (f64, f64) = (0.35, 0.8);

/// Backlash of an axis; only a scale at the table sees it.
pub fn finding(axis: &AxisContext<'_>) -> Finding {
    let hidden = "a motor encoder sits before the backlash and cannot see it: its log is the same with and without";
    let measure = "read the table with a dial gauge or ballbar at reversals, or log the table scale (--sensor table)";
    if axis.sensor == Sensor::Motor {
        return Finding::not_observable(Quantity::Backlash, axis.name(), "µm", hidden, measure);
    }
    let width = |servo: &Servo| servo.backlash_mm + servo.outer_backlash_mm;
    let value = width(&axis.fit.servo);
    let deviation = STRUCTURAL_MM.hypot(axis.fit.deviation(width));
    let [below, above] = [STRUCTURAL.0, STRUCTURAL.1].map(|share| SPREAD * deviation.hypot(share * value));
    let estimate = Estimate { value, low: value - below, high: value + above }.times(1e3).not_negative();
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
