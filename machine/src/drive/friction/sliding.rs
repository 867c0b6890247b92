//! Sliding force, common to all friction models.

/// Sliding friction of one side at the present position, direction and time. Levels in N.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sliding {
    pub coulomb: f64,
    pub breakaway: f64,
    /// `exp(−(v/v_s)²)`.
    pub stribeck: f64,
}

impl Sliding {
    /// Force in steady sliding: `F_c + (F_s − F_c) exp(−(v/v_s)²)`.
    pub(super) fn steady(&self) -> f64 {
        self.coulomb + (self.breakaway - self.coulomb) * self.stribeck
    }
}
