//! Laws of model-based ILC with their settings.

use compensation::laws::{Gain, NormOptimalIlc, NormOptimalSettings, OneShot, SpatialIlc, TrackingIlc};
use compensation::{CompensationLaw, ImpulseResponse, LowPass};
use machine::Machine;
use motion::Trajectory;
use motion::contour::Exact;

use super::settings::{LawName, Settings};
use crate::error::Result;

/// Size of the shifts that identify impulse responses, mm: far above the noise, and small enough for the motor torque.
pub const PROBE: f64 = 0.005;
/// Length of a drive's impulse response, s.
pub const RESPONSE_S: f64 = 0.2;

/// The law that `settings` select.
pub(super) fn law(settings: &Settings, path: &Trajectory, machine: &mut dyn Machine) -> Result<Box<dyn CompensationLaw>> {
    let low_pass = LowPass::new(settings.low_pass_hz, path.period_s())?;
    Ok(match settings.law {
        LawName::ModelBased => Box::new(spatial(settings.gain, low_pass)?),
        LawName::OneShot => Box::new(OneShot::default()),
        LawName::Tracking => Box::new(TrackingIlc::new(Gain::Constant(settings.gain), low_pass)),
        LawName::NormOptimal => Box::new(norm_optimal(0.0, ImpulseResponse::probe(machine, path, PROBE, RESPONSE_S)?)?),
        LawName::CrossCoupled => Box::new(norm_optimal(1.0, ImpulseResponse::probe(machine, path, PROBE, RESPONSE_S)?)?),
    })
}

/// Spatial ILC with exact foot points.
pub(super) fn spatial(gain: f64, low_pass: Option<LowPass>) -> Result<SpatialIlc> {
    Ok(SpatialIlc::new(Gain::Constant(gain), low_pass)?.with_estimator(Box::new(Exact::default())))
}

/// Norm-optimal law of Paper E with its printed weights; `a` is the share of the contour error, 0…1.
///
/// # Errors
/// When `a` is not within 0…1.
pub fn norm_optimal(a: f64, responses: Vec<ImpulseResponse>) -> Result<NormOptimalIlc> {
    Ok(NormOptimalIlc::new(NormOptimalSettings { a, ..NormOptimalSettings::default() }, responses)?)
}
