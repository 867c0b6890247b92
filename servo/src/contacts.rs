//! Contacts between sliding surfaces: friction before and during sliding.
//!
//! ```text
//! LuGre      ż = v − √(v² + v_c²) z / (d g(v)),  c = z/d
//! elements   ċ_i = (v − v_c c_i) / w_i, |c_i| ≤ g(v),  c = Σ s_i c_i / Σ s_i      (Maxwell slip)
//! both       g(v) = 1 + s exp(−(v/v_s)²),  force c + b u/v_s exp(−(v/v_s)²) with u = ż of LuGre, v of elements
//! ```
//! `d` is the presliding distance, `w_i` the slip distances [`SLIPS`] times it, `v_c` the mean speed of vibrations: under them contacts at
//! rest give way, so that an integrator brings the axis home that dry friction alone would hold. `b` is the damping of the contacts (LuGre's `σ₁`),
//! which vanishes with sliding.

use crate::parameters::Servo;
use crate::scales::{ELEMENTS, SLIPS};

/// Force of the contacts of one side.
#[derive(Debug, Clone, Copy)]
pub struct Contacts {
    /// LuGre's deflection over the presliding distance, or the force of each element.
    elements: [f64; ELEMENTS],
    /// Share of each element; the first alone for LuGre.
    shares: [f64; ELEMENTS],
}

impl Contacts {
    /// Contacts of an axis that slides at `velocity`, or rests.
    pub fn at(servo: &Servo, velocity: f64) -> Self {
        let deflection = if velocity == 0.0 { servo.start_deflection } else { 1f64.copysign(velocity) };
        if !servo.slips {
            let mut elements = [0.0; ELEMENTS];
            elements[0] = deflection;
            let mut shares = [0.0; ELEMENTS];
            shares[0] = 1.0;
            return Self { elements, shares };
        }
        let sum: f64 = servo.shares.iter().sum();
        let elements = SLIPS.map(|slip| if velocity == 0.0 { (deflection / slip).clamp(-1.0, 1.0) } else { deflection });
        Self { elements, shares: servo.shares.map(|share| share / sum) }
    }

    /// Friction against positive motion, as a multiple of Coulomb friction.
    pub fn force(&self) -> f64 {
        self.elements.iter().zip(&self.shares).map(|(element, share)| element * share).sum()
    }

    /// That friction after a step at a velocity.
    pub fn step(&mut self, servo: &Servo, velocity: f64, step_s: f64) -> f64 {
        let Servo { stribeck, stribeck_mm_s, presliding_mm, asymmetry, slips, creep_mm_s, contact_damping, .. } = *servo;
        let ratio = velocity / stribeck_mm_s;
        let square = ratio * ratio;
        let slow = if square < 20.0 { (-square).exp() } else { 0.0 };
        let level = 1.0 + stribeck * slow;
        let travelled = velocity * step_s / presliding_mm;
        let (force, rate) = if slips {
            let given_way = creep_mm_s * step_s / presliding_mm;
            for (element, slip) in self.elements.iter_mut().zip(&SLIPS) {
                let kept = if given_way > 0.0 { (-given_way / slip).exp() } else { 1.0 };
                *element = (*element * kept + travelled / slip).clamp(-level, level);
            }
            (self.force(), velocity)
        } else {
            let speed = if creep_mm_s > 0.0 { velocity.hypot(creep_mm_s) } else { velocity.abs() };
            let settled = if speed > 0.0 { level * velocity / speed } else { 0.0 };
            let part = speed * step_s / presliding_mm / level;
            let before = self.elements[0];
            // Past a few presliding distances only the settled value is left.
            self.elements[0] = if part > 20.0 { settled } else { settled + (before - settled) * (-part).exp() };
            (self.elements[0], (self.elements[0] - before) / step_s * presliding_mm)
        };
        (force + contact_damping * slow * rate / stribeck_mm_s) * (1.0 + asymmetry.copysign(asymmetry * velocity))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(servo: &Servo) -> Vec<f64> {
        let mut contacts = Contacts::at(servo, 0.0);
        // A thousand steps over five presliding distances, fast enough for Coulomb friction.
        let step_s = 5.0 * servo.presliding_mm / 1e3 / 100.0;
        (0..1000).map(|_| contacts.step(servo, 100.0, step_s)).collect()
    }

    #[test]
    fn elements_with_their_usual_shares_slip_like_lugre() {
        let servo = Servo::usual(50.0, 1.0);
        let (lugre, elements) = (curve(&servo), curve(&Servo { slips: true, ..servo }));
        let apart = lugre.iter().zip(&elements).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < 0.03, "{apart}");
        assert!((lugre[199] - (1.0 - (-1f64).exp())).abs() < 1e-3);
    }

    /// Force of contacts that start fully deflected, after a time at a velocity.
    fn force_after(mut servo: Servo, creep_mm_s: f64, velocity: f64, seconds: f64) -> f64 {
        servo.creep_mm_s = creep_mm_s;
        let mut contacts = Contacts::at(&servo, velocity);
        (0..(seconds / 5e-4) as usize).fold(0.0, |_, _| contacts.step(&servo, velocity, 5e-4))
    }

    #[test]
    fn contacts_at_rest_give_way_under_vibrations_and_sliding_ones_do_not() {
        for slips in [false, true] {
            let servo = Servo { start_deflection: 1.0, slips, ..Servo::usual(50.0, 1.0) };
            let before = force_after(servo, 0.0, 0.0, 0.5);
            assert!(before > 0.5, "{before}");
            // 5 µm of presliding at 10 µm/s.
            let kept = force_after(servo, 0.01, 0.0, 0.5) / before;
            assert!((0.2..0.6).contains(&kept), "{kept}");
            assert!(force_after(servo, 0.01, 0.0, 20.0).abs() < 0.05);
            assert!((force_after(servo, 0.01, 10.0, 0.5) - 1.0).abs() < 1e-3);
        }
    }

    #[test]
    fn damping_acts_before_sliding_and_vanishes_with_it() {
        for slips in [false, true] {
            let servo = Servo { stribeck: 0.0, stribeck_mm_s: 4.0, presliding_mm: 5e-3, slips, ..Servo::usual(50.0, 1.0) };
            let damped = Servo { contact_damping: 0.8, ..servo };
            let more = |velocity: f64, seconds: f64| {
                force_after_rest(damped, velocity, seconds) - force_after_rest(servo, velocity, seconds)
            };
            // 2 µm at a quarter of the Stribeck velocity, of 5 µm of presliding.
            let expected = 0.8 * 0.25 * (-0.0625f64).exp();
            let (before, rate) = (more(1.0, 2e-3), if slips { 1.0 } else { (-0.4f64).exp() });
            assert!((before - expected * rate).abs() < 0.06, "{before} {expected}");
            assert!(more(40.0, 0.1).abs() < 1e-6);
        }
        let lugre = Servo { contact_damping: 0.8, ..Servo::usual(50.0, 1.0) };
        let sliding = force_after_rest(lugre, 1.0, 0.5) - force_after_rest(Servo { contact_damping: 0.0, ..lugre }, 1.0, 0.5);
        assert!(sliding.abs() < 1e-6, "a bristle of constant deflection has no damping: {sliding}");
    }

    /// Force of contacts without deflection after a time at a velocity.
    fn force_after_rest(servo: Servo, velocity: f64, seconds: f64) -> f64 {
        let mut contacts = Contacts::at(&Servo { start_deflection: 0.0, ..servo }, 0.0);
        (0..(seconds / 5e-5).round() as usize).fold(0.0, |_, _| contacts.step(&servo, velocity, 5e-5))
    }

    #[test]
    fn contacts_turn_over_between_both_directions() {
        let servo = Servo { slips: true, asymmetry: 0.1, ..Servo::usual(50.0, 1.0) };
        let mut contacts = Contacts::at(&servo, 30.0);
        assert!((contacts.force() - 1.0).abs() < 1e-12);
        let mut last = 0.0;
        for _ in 0..1000 {
            last = contacts.step(&servo, -30.0, 5e-4);
        }
        assert!((last + 0.9).abs() < 1e-9, "{last}");
    }
}
