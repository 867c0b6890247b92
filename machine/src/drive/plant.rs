//! Motor, screw and table as constants of two masses.

use crate::spec::DriveSpec;

/// Constants of the two masses, SI.
#[derive(Debug, Clone)]
pub(super) struct Plant {
    /// Travel per rad of the motor, `lead/2π`.
    pub per_rad: f64,
    pub motor_inertia: f64,
    pub motor_viscous: f64,
    pub table_inertia: f64,
    pub table_viscous: f64,
    pub stiffness: f64,
    pub damping: f64,
    pub half_width: f64,
    /// Motor and table form one mass.
    pub rigid: bool,
}

impl Plant {
    pub(super) fn new(spec: &DriveSpec) -> Self {
        Self {
            per_rad: spec.screw.lead_mm * 1e-3 / std::f64::consts::TAU,
            motor_inertia: spec.motor.inertia_kg_m2,
            motor_viscous: spec.motor.viscous_n_m_s_rad,
            table_inertia: spec.table.mass_kg,
            table_viscous: spec.table.viscous_n_s_m,
            stiffness: spec.screw.stiffness_n_m,
            damping: spec.screw.damping_n_s_m,
            half_width: spec.screw.backlash_half_width_um * 1e-6,
            rigid: spec.screw.rigid,
        }
    }
}
