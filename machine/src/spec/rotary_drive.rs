//! Simulated rotary drives in a machine file.

use serde::{Deserialize, Serialize};

use super::check::{Names, finite, positive};
use super::{DriveSpec, FrictionSpec, Harmonic, LoopSpec, MotorSpec, Patch, PreslidingSpec, ScrewSpec, TableSpec, Wave};
use crate::MachineError;

/// A simulated rotary drive: loops, motor, gear, table and friction.
///
/// The equations are those of the linear drive, with rad for m, N·m for N and kg·m² for kg. Forces
/// become torques about the table axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RotaryDriveSpec {
    /// The cascaded controller.
    pub loops: LoopSpec,
    /// The motor and its encoder.
    pub motor: MotorSpec,
    /// Gear between motor and table.
    pub gear: GearSpec,
    /// The table and its scale.
    pub table: RotaryTableSpec,
    /// Friction on both sides of the gear, as torques about the table axis.
    pub friction: RotaryFrictionSpec,
}

/// A worm or a belt, or the shaft of a direct drive.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GearSpec {
    /// Turns of the motor per turn of the table; 1 for a direct drive.
    pub turns_per_turn: f64,
    /// Stiffness `K_s` at the table, N·m/rad.
    pub stiffness_n_m_rad: f64,
    /// Damping `C_s` at the table, N·m·s/rad.
    pub damping_n_m_s_rad: f64,
    /// Half the width of the dead zone at the table, µrad.
    pub backlash_half_width_urad: f64,
}

/// A rotary table with a scale.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RotaryTableSpec {
    /// Moved inertia about the axis, kg·m².
    pub inertia_kg_m2: f64,
    /// Viscous friction `B_t`, N·m·s/rad.
    pub viscous_n_m_s_rad: f64,
    /// Standard deviation of the torque noise at the table, N·m.
    pub torque_noise_n_m: f64,
    /// Correlation time of the torque noise, ms.
    pub noise_time_ms: f64,
    /// Resolution of the table's scale, µrad.
    pub scale_resolution_urad: f64,
}

/// Friction of a rotary axis, divided between the motor side and the table side. Scaled as a
/// [`FrictionSpec`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RotaryFrictionSpec {
    /// Coulomb friction of both sides together, at the table, N·m.
    pub coulomb_n_m: f64,
    /// Static friction of both sides together, at the table, N·m.
    pub static_n_m: f64,
    /// Stribeck velocity of the table, rad/s.
    pub stribeck_rad_s: f64,
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
    pub presliding: RotaryPreslidingSpec,
    /// Waves over the table turn.
    pub waves: Vec<RotaryWave>,
    /// Waves over the motor (worm) turn.
    pub motor_waves: Vec<Harmonic>,
    /// Worn or tight spots.
    #[serde(default)]
    pub patches: Vec<RotaryPatch>,
}

/// Friction of a rotary axis before sliding.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "model", rename_all = "lowercase", deny_unknown_fields)]
pub enum RotaryPreslidingSpec {
    /// LuGre: one bristle of exponential build-up.
    Lugre {
        /// Bristle stiffness `σ0` of each side, N·m/rad.
        stiffness_n_m_rad: f64,
        /// Bristle damping `σ1` of each side, N·m·s/rad. Fades with the Stribeck curve.
        damping_n_m_s_rad: f64,
    },
    /// Maxwell-slip: elastic elements in parallel, each with a slip limit.
    Maxwell {
        /// Fraction of the friction torque per element. The sum is 1.
        shares: Vec<f64>,
        /// Slip angle of each element at Coulomb level, µrad.
        slip_urad: Vec<f64>,
        /// Damping while sticking, N·m·s/rad of each side. Fades with the Stribeck curve.
        damping_n_m_s_rad: f64,
    },
}

/// A wave along a rotary axis: `amplitude · sin(2π φ / period + phase)`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RotaryWave {
    /// Relative amplitude.
    pub amplitude: f64,
    /// Wavelength, rad of the table.
    pub period_rad: f64,
    /// Phase, rad.
    pub phase_rad: f64,
}

/// A worn or tight spot of a rotary axis: `amplitude · exp(−((φ − centre)/width)²)`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RotaryPatch {
    /// Relative amplitude. Negative for lower friction.
    pub amplitude: f64,
    /// Centre, rad.
    pub centre_rad: f64,
    /// Width, rad.
    pub width_rad: f64,
}

/// Milliradians per radian: the linear drive uses mm, so its rotary form uses mrad.
pub(crate) const MRAD: f64 = 1e3;

/// Keys of a rotary drive for the checks of [`DriveSpec::check`]. Values with another unit prefix
/// are checked in [`RotaryDriveSpec::check_angles`] first, so that no error displays a converted
/// number.
const NAMES: Names = Names(&[
    ("screw.stiffness_n_m", "gear.stiffness_n_m_rad"),
    ("screw.damping_n_s_m", "gear.damping_n_m_s_rad"),
    ("screw.backlash_half_width_um", "gear.backlash_half_width_urad"),
    ("table.mass_kg", "table.inertia_kg_m2"),
    ("table.viscous_n_s_m", "table.viscous_n_m_s_rad"),
    ("table.force_noise_n", "table.torque_noise_n_m"),
    ("table.scale_resolution_um", "table.scale_resolution_urad"),
    ("friction.coulomb_n", "friction.coulomb_n_m"),
    ("friction.static_n", "friction.static_n_m"),
    ("friction.presliding.stiffness_n_m", "friction.presliding.stiffness_n_m_rad"),
    ("friction.presliding.damping_n_s_m", "friction.presliding.damping_n_m_s_rad"),
    ("friction.presliding.slip_um", "friction.presliding.slip_urad"),
    ("friction.screw_waves", "friction.motor_waves"),
]);

impl RotaryDriveSpec {
    /// Refuses values out of range. `at` is the path of the drive in the file.
    pub(super) fn check(&self, at: &str, sampling_period_ms: f64) -> Result<(), MachineError> {
        self.check_angles(at)?;
        self.in_mrad().check(at, NAMES, sampling_period_ms)
    }

    fn check_angles(&self, at: &str) -> Result<(), MachineError> {
        positive(&format!("{at}.gear.turns_per_turn"), self.gear.turns_per_turn)?;
        positive(&format!("{at}.friction.stribeck_rad_s"), self.friction.stribeck_rad_s)?;
        for (i, wave) in self.friction.waves.iter().enumerate() {
            positive(&format!("{at}.friction.waves[{i}].period_rad"), wave.period_rad)?;
        }
        for (i, patch) in self.friction.patches.iter().enumerate() {
            finite(&format!("{at}.friction.patches[{i}].centre_rad"), patch.centre_rad)?;
            positive(&format!("{at}.friction.patches[{i}].width_rad"), patch.width_rad)?;
        }
        Ok(())
    }

    /// The same drive as a linear one with mrad for mm, N·m for N and kg·m² for kg.
    pub(crate) fn in_mrad(&self) -> DriveSpec {
        let (gear, table, friction) = (&self.gear, &self.table, &self.friction);
        DriveSpec {
            loops: self.loops.clone(),
            motor: self.motor.clone(),
            screw: ScrewSpec {
                lead_mm: MRAD * std::f64::consts::TAU / gear.turns_per_turn,
                stiffness_n_m: gear.stiffness_n_m_rad,
                damping_n_s_m: gear.damping_n_m_s_rad,
                backlash_half_width_um: gear.backlash_half_width_urad,
                rigid: false,
            },
            table: TableSpec {
                mass_kg: table.inertia_kg_m2,
                viscous_n_s_m: table.viscous_n_m_s_rad,
                force_noise_n: table.torque_noise_n_m,
                noise_time_ms: table.noise_time_ms,
                scale_resolution_um: table.scale_resolution_urad,
            },
            friction: FrictionSpec {
                coulomb_n: friction.coulomb_n_m,
                static_n: friction.static_n_m,
                stribeck_mm_s: MRAD * friction.stribeck_rad_s,
                motor_share: friction.motor_share,
                direction_asymmetry: friction.direction_asymmetry,
                run_level: friction.run_level,
                drift: friction.drift,
                drift_time_s: friction.drift_time_s,
                presliding: friction.presliding.in_mrad(),
                waves: friction.waves.iter().map(RotaryWave::in_mrad).collect(),
                screw_waves: friction.motor_waves.clone(),
                patches: friction.patches.iter().map(RotaryPatch::in_mrad).collect(),
                warming: None,
            },
        }
    }
}

impl RotaryPreslidingSpec {
    fn in_mrad(&self) -> PreslidingSpec {
        match self {
            Self::Lugre { stiffness_n_m_rad, damping_n_m_s_rad } => {
                PreslidingSpec::Lugre { stiffness_n_m: *stiffness_n_m_rad, damping_n_s_m: *damping_n_m_s_rad }
            }
            Self::Maxwell { shares, slip_urad, damping_n_m_s_rad } => {
                PreslidingSpec::Maxwell { shares: shares.clone(), slip_um: slip_urad.clone(), damping_n_s_m: *damping_n_m_s_rad }
            }
        }
    }
}

impl RotaryWave {
    fn in_mrad(&self) -> Wave {
        Wave { amplitude: self.amplitude, period_mm: MRAD * self.period_rad, phase_rad: self.phase_rad }
    }
}

impl RotaryPatch {
    fn in_mrad(&self) -> Patch {
        Patch { amplitude: self.amplitude, centre_mm: MRAD * self.centre_rad, width_mm: MRAD * self.width_rad }
    }
}
