//! Maxwell-slip friction.

use super::sliding::Sliding;

/// Elastic elements in parallel. Element `i` follows the motion with stiffness `k_i` until its
/// force reaches its share of the sliding force `F_c + (F_s − F_c)·exp(−(v/v_s)²)`, then slips.
/// Slipping elements weaken with speed.
///
/// Passive: an element stores `k δ²/2` and dissipates energy whenever it is clipped.
#[derive(Debug, Clone)]
pub(super) struct MaxwellSlip {
    elements: Vec<Element>,
    damping: f64,
}

#[derive(Debug, Clone)]
struct Element {
    stiffness: f64,
    share: f64,
    force: f64,
}

impl MaxwellSlip {
    /// Elements that carry `shares` of `coulomb_n` (N) and slip after `slip_um` (µm).
    pub(super) fn new(coulomb_n: f64, shares: &[f64], slip_um: &[f64], damping: f64) -> Self {
        let elements = shares
            .iter()
            .zip(slip_um)
            .map(|(share, slip)| Element { stiffness: coulomb_n * share / (slip * 1e-6), share: *share, force: 0.0 })
            .collect();
        Self { elements, damping }
    }

    /// Force after a step at constant velocity.
    pub(super) fn step(&mut self, velocity: f64, sliding: Sliding, step_s: f64) -> f64 {
        let travelled = velocity * step_s;
        let steady = sliding.steady();
        let mut force = self.damping * sliding.stribeck * velocity;
        for element in &mut self.elements {
            let limit = steady * element.share;
            element.force = (element.force + element.stiffness * travelled).min(limit).max(-limit);
            force += element.force;
        }
        force
    }
}
