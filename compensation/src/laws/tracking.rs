//! Time-domain ILC of every axis on its own.

use motion::{DesiredPath, Trajectory};

use crate::laws::Gain;
use crate::{CompensationError, CompensationLaw, LowPass};

/// `x_r ← x_r + γ·Q(x_d − x)` with a zero-phase low-pass `Q`: moves each axis to its desired
/// position at its time.
pub struct TrackingIlc {
    gain: Gain,
    low_pass: Option<LowPass>,
    updates: usize,
}

impl TrackingIlc {
    /// The law with learning gain `γ` and, where given, the Q-filter.
    #[must_use]
    pub fn new(gain: Gain, low_pass: Option<LowPass>) -> Self {
        Self { gain, low_pass, updates: 0 }
    }
}

impl CompensationLaw for TrackingIlc {
    fn name(&self) -> &'static str {
        "tracking-ilc"
    }

    fn update(
        &mut self,
        desired: &DesiredPath,
        reference: &Trajectory,
        actual: &Trajectory,
    ) -> Result<Trajectory, CompensationError> {
        let gain = self.gain.at(self.updates);
        self.updates += 1;
        let errors = desired.trajectory().tracking_error(actual)?;
        let columns = reference
            .columns()
            .iter()
            .zip(errors)
            .map(|(column, error)| {
                let error = self.low_pass.map_or(error.clone(), |filter| filter.zero_phase(&error));
                column.iter().zip(error).map(|(r, e)| r + gain * e).collect()
            })
            .collect();
        Ok(reference.with_columns(columns)?)
    }
}
