//! Friction on one side of a screw.

mod level;
mod lugre;
mod maxwell;
mod sliding;

pub(super) use level::{Level, Warmth};
use lugre::LuGre;
use maxwell::MaxwellSlip;
use sliding::Sliding;

use crate::spec::{FrictionSpec, PreslidingSpec};

/// Friction model of one side. An enum avoids an indirect call in the inner loop.
#[derive(Debug, Clone)]
enum Model {
    LuGre(LuGre),
    Maxwell(MaxwellSlip),
}

/// Friction of one side: its model, its share of the axis levels, and the Stribeck curve.
#[derive(Debug, Clone)]
pub(super) struct Friction {
    model: Model,
    coulomb_n: f64,
    static_n: f64,
    per_stribeck_s_m: f64,
    asymmetry: f64,
}

impl Friction {
    /// The side with the fraction `share` of the friction.
    pub(super) fn new(spec: &FrictionSpec, share: f64) -> Self {
        let model = match &spec.presliding {
            PreslidingSpec::Lugre { stiffness_n_m, damping_n_s_m } => Model::LuGre(LuGre::new(*stiffness_n_m, *damping_n_s_m)),
            PreslidingSpec::Maxwell { shares, slip_um, damping_n_s_m } => {
                Model::Maxwell(MaxwellSlip::new(spec.coulomb_n * share, shares, slip_um, *damping_n_s_m))
            }
        };
        Self {
            model,
            coulomb_n: spec.coulomb_n * share,
            static_n: spec.static_n * share,
            per_stribeck_s_m: 1e3 / spec.stribeck_mm_s,
            asymmetry: spec.direction_asymmetry,
        }
    }

    /// Force opposing positive motion, N, after a step of `step_s` at `velocity` (m/s), at `level`
    /// times the mean friction.
    pub(super) fn step(&mut self, velocity: f64, level: f64, step_s: f64) -> f64 {
        let level = level * (1.0 + self.asymmetry * velocity.signum());
        let ratio = velocity * self.per_stribeck_s_m;
        let square = ratio * ratio;
        // exp(−40) of the static friction is far below the encoder resolution.
        let stribeck = if square < 40.0 { (-square).exp() } else { 0.0 };
        let sliding = Sliding { coulomb: self.coulomb_n * level, breakaway: self.static_n * level, stribeck };
        match &mut self.model {
            Model::LuGre(model) => model.step(velocity, sliding, step_s),
            Model::Maxwell(model) => model.step(velocity, sliding, step_s),
        }
    }
}

#[cfg(test)]
mod tests;
