//! Settings of the comparison.

use machine::SimulationOptions;

use crate::model_based_ilc::Settings;

/// Default curves of the comparison. No excitation contains them, and no product setting was chosen on them; settings
/// are developed on the curves of [`PAPER_D`].
pub const UNSEEN: [&str; 4] = ["nurbs-2", "nurbs-3", "polygon-5", "spiral-6mm"];
/// Default curves on a machine with rotary axes (Paper C).
pub const UNSEEN_TURNED: [&str; 2] = ["saddle", "saddle-butterfly"];
/// Curves of Paper D's tables IV to VI.
pub const PAPER_D: [&str; 4] = ["crown", "spiral", "flower", "nurbs-1"];

/// Feed of built-in curves, mm/s, as in Paper D.
pub const FEED_MM_S: f64 = 80.0;

/// Settings of the comparison.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CompareSettings {
    /// Number of noise seeds over which figures are averaged.
    pub seeds: u64,
    /// Runs of every ILC law; the last one counts. The papers use 5 to 8.
    pub ilc_runs: usize,
    /// Gain of laws with a constant gain; `None` tunes it on the machine.
    pub ilc_gain: Option<f64>,
    /// Cut-off of the zero-phase low-pass of ILC, Hz; `None` tunes it on the machine.
    pub ilc_low_pass_hz: Option<f64>,
    /// Options of the simulation.
    pub simulation: SimulationOptions,
    /// Settings of model-based ILC.
    pub learning: Settings,
    /// First noise seed.
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
    /// Noise seed of machine `index` of [`CompareSettings::seeds`]. It differs from the seeds of training and tuning.
    #[must_use]
    pub fn noise_seed(&self, index: u64) -> u64 {
        self.seed.wrapping_add(1000 * (index + 1))
    }
}
