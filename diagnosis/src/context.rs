//! What the analyses of an axis share.

use serde::Serialize;

use crate::record::{AxisRecord, Run};
use servo::{Fit, simulate, simulate_with_friction};

/// Half-width of a 95 % interval in standard deviations.
pub const SPREAD: f64 = 1.96;

/// Where the logged actual position is measured.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sensor {
    /// The encoder of the motor.
    Motor,
    /// A scale at the table.
    Table,
    /// Not stated.
    #[default]
    Unknown,
}

/// Circle on which deviations are stated: as in a circular test (ISO 230-4).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TestCircle {
    /// Radius, mm.
    pub radius_mm: f64,
    /// Feed, mm/s.
    pub feed_mm_s: f64,
}

/// Radius of the test circle, mm: small enough for small machines.
const RADIUS_MM: f64 = 20.0;
/// Share of the slowest axis's largest logged speed, and of the largest logged acceleration: the circle lies well within what was logged.
const OF_SPEED: f64 = 0.6;
const OF_ACCELERATION: f64 = 0.3;

impl TestCircle {
    /// A circle within the speeds and accelerations of the records.
    #[must_use]
    pub fn within(records: &[AxisRecord]) -> Self {
        let speed = records.iter().map(AxisRecord::top_speed_mm_s).fold(f64::INFINITY, f64::min);
        let acceleration = records.iter().map(AxisRecord::usual_top_acceleration_mm_s2).fold(f64::INFINITY, f64::min);
        let feed = (OF_SPEED * speed).min((OF_ACCELERATION * acceleration * RADIUS_MM).sqrt());
        // A feed that a person would program.
        let digit = 10f64.powf((feed.log10() - 1.0).floor());
        Self { radius_mm: RADIUS_MM, feed_mm_s: (feed / digit).floor() * digit }
    }
}

/// An axis with its fitted model.
pub struct AxisContext<'a> {
    /// Its runs.
    pub record: &'a AxisRecord,
    /// Its model.
    pub fit: &'a Fit,
    /// Actual position less that of the model without friction, backlash and constant force, for every run and sample, mm.
    pub beyond_linear: Vec<Vec<f64>>,
    /// Actual position less that of the whole model, mm.
    pub residuals: Vec<Vec<f64>>,
    /// Friction of the model as a deflection, mm.
    pub friction_mm: Vec<Vec<f64>>,
    /// The test circle.
    pub circle: TestCircle,
    /// The sensor.
    pub sensor: Sensor,
}

impl<'a> AxisContext<'a> {
    /// The context of an axis.
    #[must_use]
    pub fn new(record: &'a AxisRecord, fit: &'a Fit, circle: TestCircle, sensor: Sensor) -> Self {
        let linear = fit.servo.linear();
        let less =
            |run: &Run, expected: &[f64]| run.actual.iter().zip(expected).map(|(actual, expected)| actual - expected).collect();
        let (mut beyond_linear, mut residuals, mut friction_mm) = (Vec::new(), Vec::new(), Vec::new());
        for run in &record.runs {
            let start = run.start(record.period_s);
            beyond_linear.push(less(run, &simulate(&linear, &run.reference, record.period_s, start)));
            let whole = simulate_with_friction(&fit.servo, &run.reference, record.period_s, start);
            residuals.push(less(run, &whole.positions));
            friction_mm.push(whole.friction_mm);
        }
        Self { record, fit, beyond_linear, residuals, friction_mm, circle, sensor }
    }

    /// Name of the axis.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.record.name
    }
}
