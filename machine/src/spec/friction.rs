//! Friction in a machine file.

use serde::{Deserialize, Serialize};

use super::check::{finite, not_negative, positive, share, within};
use super::waves::{Harmonic, Wave};
use crate::MachineError;

/// Friction of an axis, divided between the motor side and the table side.
///
/// On each side the level is scaled by `(1 ± direction_asymmetry)` with the sign of the speed, by
/// `1 + Σ waves + Σ screw_waves + Σ patches` with position, by `1 + run_level·N(0,1)` per run and
/// by `1 + drift(t)`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrictionSpec {
    /// Coulomb friction `F_c` of both sides together, N.
    pub coulomb_n: f64,
    /// Static friction `F_s` of both sides together, N.
    pub static_n: f64,
    /// Stribeck velocity `v_s`, mm/s.
    pub stribeck_mm_s: f64,
    /// Fraction of the friction that acts on the motor side.
    pub motor_share: f64,
    /// Relative difference of the two directions from their mean.
    pub direction_asymmetry: f64,
    /// Relative standard deviation of the level per run.
    pub run_level: f64,
    /// Relative standard deviation of the slow drift.
    pub drift: f64,
    /// Correlation time of the drift, s.
    pub drift_time_s: f64,
    /// Presliding model.
    pub presliding: PreslidingSpec,
    /// Waves along the axis.
    pub waves: Vec<Wave>,
    /// Waves over the screw turn.
    pub screw_waves: Vec<Harmonic>,
    /// Worn or tight spots.
    #[serde(default)]
    pub patches: Vec<Patch>,
    /// Decrease of the level while the machine warms up. Absent: constant.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub warming: Option<Warming>,
}

/// Friction while a machine warms up: the level is scaled by `1 + share·(2·exp(−t/time) − 1)`, `t` from the first run on.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Warming {
    /// Excess of the cold machine over the mean level, and deficit of the warm one, relative.
    pub share: f64,
    /// Time constant, s.
    pub time_s: f64,
}

/// Friction before sliding.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "model", rename_all = "lowercase", deny_unknown_fields)]
pub enum PreslidingSpec {
    /// LuGre: one bristle of exponential build-up.
    Lugre {
        /// Bristle stiffness `σ0` of each side, N/m.
        stiffness_n_m: f64,
        /// Bristle damping `σ1` of each side, N·s/m. Fades with the Stribeck curve.
        damping_n_s_m: f64,
    },
    /// Maxwell-slip: elastic elements in parallel, each with a slip limit.
    Maxwell {
        /// Fraction of the friction force per element. The sum is 1.
        shares: Vec<f64>,
        /// Slip displacement of each element at Coulomb level, µm.
        slip_um: Vec<f64>,
        /// Damping while sticking, N·s/m of each side. Fades with the Stribeck curve.
        damping_n_s_m: f64,
    },
}

/// A worn or tight spot: `amplitude · exp(−((x − centre)/width)²)`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Patch {
    /// Relative amplitude. Negative for lower friction.
    pub amplitude: f64,
    /// Centre, mm.
    pub centre_mm: f64,
    /// Width, mm.
    pub width_mm: f64,
}

impl FrictionSpec {
    /// Refuses values out of range. `key` makes the full key of a value from its name.
    pub(super) fn check(&self, key: &dyn Fn(&str) -> String) -> Result<(), MachineError> {
        not_negative(&key("coulomb_n"), self.coulomb_n)?;
        not_negative(&key("static_n"), self.static_n)?;
        within(&key("static_n"), self.static_n, self.static_n >= self.coulomb_n, &format!("at least `{}`", key("coulomb_n")))?;
        positive(&key("stribeck_mm_s"), self.stribeck_mm_s)?;
        share(&key("motor_share"), self.motor_share)?;
        for (name, value) in
            [("direction_asymmetry", self.direction_asymmetry.abs()), ("run_level", self.run_level), ("drift", self.drift)]
        {
            within(&key(name), value, (0.0..0.2).contains(&value), "below 0.2")?;
        }
        positive(&key("drift_time_s"), self.drift_time_s)?;
        if let Some(Warming { share, time_s }) = self.warming {
            within(&key("warming.share"), share, (0.0..0.5).contains(&share), "zero or more, and below 0.5")?;
            positive(&key("warming.time_s"), time_s)?;
        }
        let mut lowest = 1.0;
        for (i, wave) in self.waves.iter().enumerate() {
            finite(&key(&format!("waves[{i}].amplitude")), wave.amplitude)?;
            positive(&key(&format!("waves[{i}].period_mm")), wave.period_mm)?;
            finite(&key(&format!("waves[{i}].phase_rad")), wave.phase_rad)?;
            lowest -= wave.amplitude.abs();
        }
        for (i, wave) in self.screw_waves.iter().enumerate() {
            wave.check(&format!("{}[{i}]", key("screw_waves")))?;
            lowest -= wave.amplitude.abs();
        }
        for (i, patch) in self.patches.iter().enumerate() {
            finite(&key(&format!("patches[{i}].amplitude")), patch.amplitude)?;
            finite(&key(&format!("patches[{i}].centre_mm")), patch.centre_mm)?;
            positive(&key(&format!("patches[{i}].width_mm")), patch.width_mm)?;
            lowest += patch.amplitude.min(0.0);
        }
        within(
            &format!("lowest level of `{}`, `{}` and `{}`", key("waves"), key("screw_waves"), key("patches")),
            lowest,
            lowest > 0.05,
            "above 0.05 of the mean; lower their amplitudes",
        )?;
        self.presliding.check(&|name| key(&format!("presliding.{name}")))
    }

    /// Largest stiffness that friction adds on one side, N/m.
    pub(super) fn presliding_stiffness_n_m(&self) -> f64 {
        match &self.presliding {
            PreslidingSpec::Lugre { stiffness_n_m, .. } => *stiffness_n_m,
            PreslidingSpec::Maxwell { shares, slip_um, .. } => {
                shares.iter().zip(slip_um).map(|(share, slip)| self.coulomb_n * share / (slip * 1e-6)).sum()
            }
        }
    }
}

impl PreslidingSpec {
    fn check(&self, key: &dyn Fn(&str) -> String) -> Result<(), MachineError> {
        match self {
            Self::Lugre { stiffness_n_m, damping_n_s_m } => {
                positive(&key("stiffness_n_m"), *stiffness_n_m)?;
                not_negative(&key("damping_n_s_m"), *damping_n_s_m)
            }
            Self::Maxwell { shares, slip_um, damping_n_s_m } => {
                not_negative(&key("damping_n_s_m"), *damping_n_s_m)?;
                for (i, value) in shares.iter().enumerate() {
                    positive(&format!("{}[{i}]", key("shares")), *value)?;
                }
                for (i, value) in slip_um.iter().enumerate() {
                    positive(&format!("{}[{i}]", key("slip_um")), *value)?;
                }
                if shares.len() != slip_um.len() || shares.is_empty() {
                    return Err(MachineError::BadDescription(format!(
                        "`{}` has {} values and `{}` has {}; give one of each for every element, at least one element",
                        key("shares"),
                        shares.len(),
                        key("slip_um"),
                        slip_um.len()
                    )));
                }
                let sum: f64 = shares.iter().sum();
                within(&format!("{}: sum", key("shares")), sum, (sum - 1.0).abs() < 1e-6, "1")
            }
        }
    }
}
