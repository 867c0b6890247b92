//! Coulomb friction and the Stribeck effect, as deflections of the loops.

use crate::circle::glitch_mm;
use crate::context::{AxisContext, SPREAD};
use crate::finding::{Estimate, Finding, Label, Mark, Picture, Quantity, Series, Verdict};
use crate::threshold;
use servo::{Servo, index};

/// Standard deviation of the ratio of static to sliding friction above which it counts as not shown.
const TOO_WIDE: f64 = 0.5;
/// Standard deviation of what the curve of the model gets wrong of that ratio. From the machines 280 to 319 of the blind test, of which 53 of 60 lay within
/// without it.
const STRUCTURAL_STRIBECK: f64 = 0.15;
/// Share of Coulomb friction in its standard deviation below which the rest of the curve is not shown.
const CERTAIN: f64 = 3.0;
/// Standard deviation of what the contacts of the model get wrong where the position is that of a table: backlash and elasticity may stand for
/// friction. From the blind test's development machines; mm, and relative.
const STRUCTURAL_TABLE: (f64, f64) = (3e-4, 0.25);
/// Points of the picture, and its largest speed in Stribeck velocities.
const POINTS: usize = 120;
const SPEEDS: f64 = 6.0;

/// Friction of an axis.
pub fn findings(axis: &AxisContext<'_>) -> Vec<Finding> {
    vec![coulomb(axis), stribeck(axis)]
}

fn coulomb(axis: &AxisContext<'_>) -> Finding {
    let servo = axis.fit.servo;
    let structural =
        if servo.table_pulsation_1_s > 0.0 { STRUCTURAL_TABLE.0.hypot(STRUCTURAL_TABLE.1 * servo.coulomb_mm) } else { 0.0 };
    let deviation = axis.fit.deviation(|servo| servo.coulomb_mm).hypot(structural);
    let estimate = Estimate::within(servo.coulomb_mm, SPREAD * deviation).times(1e3).not_negative();
    let glitch = |servo: &Servo| 1e3 * glitch_mm(&Servo { backlash_mm: 0.0, ..*servo }, axis.circle);
    let effect = Estimate::within(glitch(&servo), SPREAD * axis.fit.deviation(glitch)).not_negative();
    let verdict = threshold::of_deviation(&effect);
    let removed = match servo.integral > 0.0 || servo.position_integral_1_s > 0.0 {
        true => "the integrator removes it within some hundredths of a second after a reversal",
        false => "no integrator removes it: the axis stands off by it at every stop",
    };
    Finding {
        quantity: Quantity::CoulombFriction,
        axis: axis.name().to_owned(),
        estimate: Some(estimate),
        unit: "µm",
        effect_um: Some(effect),
        verdict,
        details: vec![
            ("presliding distance, µm", 1e3 * servo.presliding_mm),
            ("difference of the directions from their mean, %", 100.0 * servo.asymmetry),
        ],
        meaning: format!("deflection of the loops without integrator, F/(M ω_b Kv); {removed}; effect: quadrant glitch on the test circle"),
        remedy: match verdict {
            Verdict::Good => String::new(),
            _ => "check lubrication, gib and nut preload, covers; then compensate. SINUMERIK: MD32490 FRICT_COMP_MODE, MD32500 FRICT_COMP_ENABLE, \
                  MD32520, MD32540; Fanuc: No. 2003#5 BLEN, 2048 (backlash acceleration), 2071; or precomp compensate"
                .to_owned(),
        },
        picture: Some(curve(axis)),
    }
}

fn stribeck(axis: &AxisContext<'_>) -> Finding {
    let servo = axis.fit.servo;
    let deviation = axis.fit.coordinate_deviation(index::STRIBECK).unwrap_or(f64::INFINITY);
    let certain = servo.coulomb_mm > CERTAIN * axis.fit.deviation(|servo| servo.coulomb_mm);
    if deviation > TOO_WIDE || !certain {
        let why = if certain { "too little slow motion" } else { "friction itself is hardly seen" };
        return Finding::not_observable(
            Quantity::StribeckFriction,
            axis.name(),
            "share",
            why,
            "record slow reversals, at a few mm/s",
        );
    }
    Finding {
        quantity: Quantity::StribeckFriction,
        axis: axis.name().to_owned(),
        estimate: Some(Estimate::within(servo.stribeck, SPREAD * deviation.hypot(STRUCTURAL_STRIBECK)).not_negative()),
        unit: "share",
        effect_um: None,
        verdict: Verdict::Figure,
        details: vec![("Stribeck velocity, mm/s", servo.stribeck_mm_s)],
        meaning: "static friction above sliding friction; above the Stribeck velocity it fades. A large share makes stick–slip"
            .to_owned(),
        remedy: String::new(),
        picture: None,
    }
}

/// Friction against speed.
fn curve(axis: &AxisContext<'_>) -> Picture {
    let servo = axis.fit.servo;
    let top = SPEEDS * servo.stribeck_mm_s;
    let points = (0..=POINTS).map(|i| {
        let speed = top * (2.0 * i as f64 / POINTS as f64 - 1.0);
        let level = 1.0 + servo.stribeck * (-(speed / servo.stribeck_mm_s).powi(2)).exp();
        (speed, 1e3 * servo.coulomb_mm * level * speed.signum() * (1.0 + servo.asymmetry * speed.signum()))
    });
    Picture {
        title: format!("{}: friction over speed", axis.name()),
        x: Label::new("speed", "mm/s"),
        y: Label::new("deflection without integrator", "µm"),
        series: vec![Series::new("friction", Mark::Line, points)],
    }
}
