//! What an axis does on the test circle.

use std::f64::consts::TAU;

use crate::context::TestCircle;
use servo::{Servo, simulate};

/// Sampling period of the simulated circle, s, and revolutions before the one that counts.
const PERIOD_S: f64 = 1e-3;
const BEFORE: usize = 1;

/// Amplitude of the axis on the circle less the radius, mm: the mean over both axes is the radial deviation.
#[must_use]
pub fn radius_deviation_mm(servo: &Servo, circle: TestCircle) -> f64 {
    let (cosine, sine) = amplitude(&servo.linear(), circle);
    cosine.hypot(sine) - circle.radius_mm
}

/// Largest contouring deviation along the axis by friction and backlash on the circle, mm: the quadrant glitch.
#[must_use]
pub fn glitch_mm(servo: &Servo, circle: TestCircle) -> f64 {
    let whole = run(servo, circle);
    let linear = run(&servo.linear(), circle);
    let (low, high) = whole
        .iter()
        .zip(&linear)
        .map(|(a, b)| a - b)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), d| (low.min(d), high.max(d)));
    0.5 * (high - low).max(0.0)
}

/// Last revolution of the axis on the circle.
fn run(servo: &Servo, circle: TestCircle) -> Vec<f64> {
    let per_turn = samples(circle);
    let reference: Vec<f64> = (0..=(BEFORE + 1) * per_turn).map(|k| circle.radius_mm * angle(k, per_turn).cos()).collect();
    simulate(servo, &reference, PERIOD_S, (circle.radius_mm, 0.0)).split_off(BEFORE * per_turn)
}

fn amplitude(servo: &Servo, circle: TestCircle) -> (f64, f64) {
    let per_turn = samples(circle);
    let positions = run(servo, circle);
    let part = |of: fn(f64) -> f64| {
        positions.iter().take(per_turn).enumerate().map(|(k, x)| x * of(angle(k, per_turn))).sum::<f64>() * 2.0 / per_turn as f64
    };
    (part(f64::cos), part(f64::sin))
}

fn samples(circle: TestCircle) -> usize {
    ((TAU * circle.radius_mm / circle.feed_mm_s / PERIOD_S).round() as usize).clamp(50, 200_000)
}

fn angle(k: usize, per_turn: usize) -> f64 {
    TAU * k as f64 / per_turn as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lagging_loop_cuts_the_circle() {
        let circle = TestCircle { radius_mm: 20.0, feed_mm_s: 50.0 };
        let servo = Servo { integral: 0.0, loop_delay_s: 0.0, bandwidth_1_s: 5000.0, ..Servo::usual(50.0, 0.0) };
        // A first-order loop of 1/Kv and 1/ω_b: |G|² = 1 / ((1 − ω²/(Kv ω_b))² + (ω/Kv)²).
        let omega: f64 = 2.5;
        let gain = ((1.0 - omega * omega / 2.5e5).powi(2) + (omega / 50.0).powi(2)).sqrt().recip();
        // The step of the integration delays the loop by about half its length: 1.3 of 25 µm.
        assert!((radius_deviation_mm(&servo, circle) - 20.0 * (gain - 1.0)).abs() < 2e-3);
        assert!(radius_deviation_mm(&Servo { feed_forward: 1.0, ..servo }, circle).abs() < 2e-3);
        assert!(glitch_mm(&Servo { coulomb_mm: 5e-3, ..servo }, circle) > 3e-3);
    }
}
