//! Velocity and acceleration feed-forward.

use crate::circle::radius_deviation_mm;
use crate::context::{AxisContext, SPREAD};
use crate::finding::{Estimate, Finding, Quantity, Verdict};
use crate::findings::gain::STRUCTURAL;
use crate::threshold;
use servo::{Servo, index};

/// Standard deviations above which a share counts as not shown by the logs.
const TOO_WIDE: (f64, f64) = (0.25, 0.5);

/// Standard deviation of an acceleration feed-forward that no fit asks for.
const NONE_SEEN: f64 = 0.1;

/// Both feed-forwards of an axis.
pub fn findings(axis: &AxisContext<'_>) -> Vec<Finding> {
    vec![velocity(axis), acceleration(axis)]
}

fn velocity(axis: &AxisContext<'_>) -> Finding {
    let servo = axis.fit.servo;
    let deviation = axis.fit.deviation(|servo| servo.feed_forward);
    if deviation > TOO_WIDE.0 {
        let why = "lag and gain cannot be distinguished";
        return Finding::not_observable(
            Quantity::VelocityFeedForward,
            axis.name(),
            "share",
            why,
            "record reversals and stops at full acceleration (precomp excite)",
        );
    }
    // The lag is certain: a wrong gain makes a wrong share of it.
    let deviation = deviation.hypot(STRUCTURAL * (1.0 - servo.feed_forward));
    let estimate = Estimate::within(servo.feed_forward, SPREAD * deviation);
    let full = Servo { feed_forward: 1.0, ..servo };
    let shrinks = |servo: &Servo| {
        1e3 * (radius_deviation_mm(servo, axis.circle) - radius_deviation_mm(&Servo { feed_forward: 1.0, ..*servo }, axis.circle))
    };
    let effect = Estimate::within(shrinks(&servo), SPREAD * axis.fit.deviation(shrinks));
    let verdict = threshold::of_deviation(&effect);
    let lag_um = 1e3 * axis.circle.feed_mm_s * (servo.lag_s() - full.lag_s());
    let state = match servo.feed_forward {
        share if estimate.covers(0.0) && share < 0.2 => "no velocity feed-forward",
        share if share > 1.0 && !estimate.covers(1.0) => "too much velocity feed-forward: the axis leads its command",
        _ if estimate.covers(1.0) => "velocity feed-forward is complete",
        _ => "velocity feed-forward is incomplete",
    };
    Finding {
        quantity: Quantity::VelocityFeedForward,
        axis: axis.name().to_owned(),
        estimate: Some(estimate),
        unit: "share",
        effect_um: Some(effect),
        verdict,
        details: vec![("tracking error at the test feed that a share of 1 would remove, µm", lag_um)],
        meaning: format!("{state}; effect: radius of the test circle"),
        remedy: match verdict {
            Verdict::Good => String::new(),
            _ => "set the velocity feed-forward to 1 in small steps, all axes alike. SINUMERIK: MD32620 FFW_MODE, MD32610 VELO_FFW_WEIGHT; \
                  Fanuc: No. 2005#1 FEED, 2068, 2069; LinuxCNC: FF1"
                .to_owned(),
        },
        picture: None,
    }
}

fn acceleration(axis: &AxisContext<'_>) -> Finding {
    let servo = axis.fit.servo;
    // Where none makes the model follow better, there is none to within what the loops' other terms could hide.
    let deviation = axis.fit.coordinate_deviation(index::ACCELERATION).unwrap_or(NONE_SEEN);
    if deviation > TOO_WIDE.1 {
        let why = "too little acceleration, or hidden by the delay of the loop";
        return Finding::not_observable(
            Quantity::AccelerationFeedForward,
            axis.name(),
            "share",
            why,
            "record motion at full acceleration (precomp excite)",
        );
    }
    let estimate = Estimate::within(servo.acceleration_feed_forward, SPREAD * deviation);
    let gains = |servo: &Servo| {
        let full = Servo { acceleration_feed_forward: 1.0, ..*servo };
        1e3 * (radius_deviation_mm(servo, axis.circle) - radius_deviation_mm(&full, axis.circle))
    };
    let effect = Estimate::within(gains(&servo), SPREAD * axis.fit.deviation(gains));
    let verdict = threshold::of_deviation(&effect);
    Finding {
        quantity: Quantity::AccelerationFeedForward,
        axis: axis.name().to_owned(),
        estimate: Some(estimate),
        unit: "share",
        effect_um: Some(effect),
        verdict,
        details: Vec::new(),
        meaning: match estimate.covers(0.0) {
            true => "no acceleration feed-forward; effect: radius of the test circle",
            false => "share of the acceleration that the torque feed-forward contains; effect: radius of the test circle",
        }
        .to_owned(),
        remedy: match verdict {
            Verdict::Good => String::new(),
            _ => "set the torque feed-forward to the moved inertia. SINUMERIK: MD32620 FFW_MODE = 4, MD32650 AX_INERTIA; Fanuc: No. 2068 with \
                  advanced preview; LinuxCNC: FF2"
                .to_owned(),
        },
        picture: None,
    }
}
