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

use crate::lanes::Lanes;
use crate::parameters::Servo;
use crate::scales::{ELEMENTS, SLIPS};

/// Contacts of one side of several axes.
#[derive(Debug, Clone, Copy)]
pub struct Contacts<const L: usize> {
    /// LuGre's deflection over the presliding distance, or the force of each element.
    elements: [Lanes<L>; ELEMENTS],
    /// Share of each element; the first alone for LuGre.
    shares: [Lanes<L>; ELEMENTS],
    /// Part of the force that each element at rest keeps over a step.
    kept: [Lanes<L>; ELEMENTS],
    slips: bool,
    stribeck: Lanes<L>,
    /// One over the Stribeck velocity, s/mm.
    stribeck_s_mm: Lanes<L>,
    /// Presliding distances per step and speed, s/mm.
    travelled_s_mm: Lanes<L>,
    /// Square of the speed of vibrations, mm²/s².
    creep_square: Lanes<L>,
    /// Damping at a speed over the Stribeck velocity, s/mm.
    damping_s_mm: Lanes<L>,
    /// Presliding distance per step, mm/s.
    distance_mm_s: Lanes<L>,
    asymmetry: Lanes<L>,
}

/// Squared ratio of speed and Stribeck velocity from which static friction has gone, and presliding distances after which only the settled deflection is left.
const GONE: f64 = 20.0;

impl<const L: usize> Contacts<L> {
    /// Contacts of axes that slide at `velocity`, or rest.
    pub fn at(servos: &[Servo; L], velocity: Lanes<L>, step_s: f64) -> Self {
        let slips = servos[0].slips;
        let start = |lane: usize, slip: f64| {
            let velocity = velocity.0[lane];
            if velocity != 0.0 {
                return 1f64.copysign(velocity);
            }
            let deflection = servos[lane].start_deflection;
            if slips { (deflection / slip).clamp(-1.0, 1.0) } else { deflection }
        };
        let share = |servo: &Servo, element: usize| {
            let of_lugre = if element == 0 { 1.0 } else { 0.0 };
            if slips { servo.shares[element] / servo.shares.iter().sum::<f64>() } else { of_lugre }
        };
        let kept = |servo: &Servo, slip: f64| (-servo.creep_mm_s * step_s / servo.presliding_mm / slip).exp();
        Self {
            elements: SLIPS.map(|slip| Lanes::of(|lane| start(lane, slip))),
            shares: std::array::from_fn(|element| Lanes::each(servos, |servo| share(servo, element))),
            kept: SLIPS.map(|slip| Lanes::each(servos, |servo| kept(servo, slip))),
            slips,
            stribeck: Lanes::each(servos, |servo| servo.stribeck),
            stribeck_s_mm: Lanes::each(servos, |servo| servo.stribeck_mm_s.recip()),
            travelled_s_mm: Lanes::each(servos, |servo| step_s / servo.presliding_mm),
            creep_square: Lanes::each(servos, |servo| servo.creep_mm_s.powi(2)),
            damping_s_mm: Lanes::each(servos, |servo| servo.contact_damping / servo.stribeck_mm_s),
            distance_mm_s: Lanes::each(servos, |servo| servo.presliding_mm / step_s),
            asymmetry: Lanes::each(servos, |servo| servo.asymmetry),
        }
    }

    /// Friction against positive motion, as a multiple of Coulomb friction.
    #[inline(always)]
    pub fn force(&self) -> Lanes<L> {
        if !self.slips {
            return self.elements[0];
        }
        self.elements.iter().zip(&self.shares).fold(Lanes::all(0.0), |sum, (element, share)| sum + *element * *share)
    }

    /// That friction after a step at a velocity.
    #[inline(always)]
    pub fn step(&mut self, velocity: Lanes<L>) -> Lanes<L> {
        let (none, one) = (Lanes::all(0.0), Lanes::all(1.0));
        let ratio = velocity * self.stribeck_s_mm;
        let square = ratio * ratio;
        let slow = square.where_below(GONE, square.decay(), none);
        let level = one + self.stribeck * slow;
        let (force, rate) = if self.slips {
            let travelled = velocity * self.travelled_s_mm;
            for ((element, kept), slip) in self.elements.iter_mut().zip(&self.kept).zip(&SLIPS) {
                *element = (*element * *kept + travelled * slip.recip()).within(level);
            }
            (self.force(), velocity)
        } else {
            let speed = (velocity * velocity + self.creep_square).sqrt();
            let settled = speed.where_below(f64::MIN_POSITIVE, none, level * velocity / speed);
            let part = speed * self.travelled_s_mm / level;
            let before = self.elements[0];
            let left = part.where_below(GONE, part.decay(), none);
            self.elements[0] = settled + (before - settled) * left;
            (self.elements[0], (self.elements[0] - before) * self.distance_mm_s)
        };
        (force + self.damping_s_mm * slow * rate) * (one + self.asymmetry * one.copysign(velocity))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(servo: &Servo) -> Vec<f64> {
        // A thousand steps over five presliding distances, fast enough for Coulomb friction.
        let step_s = 5.0 * servo.presliding_mm / 1e3 / 100.0;
        let mut contacts = Contacts::at(&[*servo], Lanes([0.0]), step_s);
        (0..1000).map(|_| contacts.step(Lanes([100.0])).0[0]).collect()
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
        let mut contacts = Contacts::at(&[servo], Lanes([velocity]), 5e-4);
        (0..(seconds / 5e-4) as usize).fold(0.0, |_, _| contacts.step(Lanes([velocity])).0[0])
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
        let mut contacts = Contacts::at(&[Servo { start_deflection: 0.0, ..servo }], Lanes([0.0]), 5e-5);
        (0..(seconds / 5e-5).round() as usize).fold(0.0, |_, _| contacts.step(Lanes([velocity])).0[0])
    }

    #[test]
    fn contacts_turn_over_between_both_directions() {
        let servo = Servo { slips: true, asymmetry: 0.1, ..Servo::usual(50.0, 1.0) };
        let mut contacts = Contacts::at(&[servo], Lanes([30.0]), 5e-4);
        assert!((contacts.force().0[0] - 1.0).abs() < 1e-12);
        let mut last = 0.0;
        for _ in 0..1000 {
            last = contacts.step(Lanes([-30.0])).0[0];
        }
        assert!((last + 0.9).abs() < 1e-9, "{last}");
    }
}
