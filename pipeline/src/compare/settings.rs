//! What is compared, and how.

use machine::SimulationOptions;

use crate::model_based_ilc::Settings;

/// The curves that are compared when none is named. No excitation holds them, and no setting of the product was chosen by them: settings are
/// developed on Paper D's curves ([`PAPER_D`]).
pub const UNSEEN: [&str; 4] = ["nurbs-2", "nurbs-3", "polygon-5", "spiral-6mm"];
/// The same on a machine that turns tool or workpiece (Paper C).
pub const UNSEEN_TURNED: [&str; 2] = ["saddle", "saddle-butterfly"];
/// The curves of Paper D's tables IV to VI.
pub const PAPER_D: [&str; 4] = ["crown", "spiral", "flower", "nurbs-1"];

/// Feed of built-in curves, mm/s: Paper D's.
pub const FEED_MM_S: f64 = 80.0;

/// Settings of the comparison.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CompareSettings {
    /// Fresh machines (noise seeds) over which figures are averaged.
    pub seeds: u64,
    /// Learning runs of every ILC; the last one counts. The papers take 5 to 8.
    pub ilc_runs: usize,
    /// Learning gain of laws with a constant one; tuned on the machine when `None`.
    pub ilc_gain: Option<f64>,
    /// Cut-off of ILC's zero-phase low-pass, Hz; tuned on the machine when `None`.
    pub ilc_low_pass_hz: Option<f64>,
    /// How the machine is simulated.
    pub simulation: SimulationOptions,
    /// Settings of model-based ILC.
    pub learning: Settings,
    /// First seed.
    pub seed: u64,
}

impl Default for CompareSettings {
    fn default() -> Self {
        Self {
            seeds: 1,
            ilc_runs: 8,
            ilc_gain: None,
            ilc_low_pass_hz: None,
            simulation: SimulationOptions::default(),
            learning: Settings::default(),
            seed: 1,
        }
    }
}

impl CompareSettings {
    /// Seed of the noise of one of [`CompareSettings::seeds`] machines; training's and the tuning's seeds are others.
    #[must_use]
    pub fn noise_seed(&self, index: u64) -> u64 {
        self.seed.wrapping_add(1000 * (index + 1))
    }
}
