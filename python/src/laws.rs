//! Laws of iterative learning on a machine: those of the house, and those written in Python.

use compensation::laws::{Gain, OneShot, SpatialIlc, TrackingIlc};
use compensation::{CompensationError, CompensationLaw, ImpulseResponse, LowPass};
use machine::{Machine, MachineError};
use motion::contour::Exact;
use motion::{DesiredPath, Trajectory};
use pipeline::model_based_ilc::{PROBE, RESPONSE_S, norm_optimal};
use pyo3::prelude::*;

use crate::arrays;
use crate::errors::UsageError;
use crate::progress::Failure;

/// A law as an object of Python states it.
pub enum Law {
    /// Contour error at foot points.
    Spatial { gain: Gain, low_pass_hz: Option<f64> },
    /// Tracking error of every axis.
    Tracking { gain: Gain, low_pass_hz: Option<f64> },
    /// Paper D's shift.
    OneShot,
    /// Norm-optimal; the share of the contour error.
    NormOptimal { contour_share: f64 },
    /// An object with `update(desired, reference, actual, period_s)`.
    Own(Py<PyAny>),
}

impl Law {
    /// The law that `object` is: an instance of one of `precomp.laws`, or an object with `update`.
    pub fn of(object: &Bound<'_, PyAny>) -> PyResult<Self> {
        let kind = object.getattr("kind").and_then(|kind| kind.extract::<String>()).unwrap_or_default();
        let number = |name: &str| -> PyResult<Option<f64>> { object.getattr(name)?.extract() };
        let gain = || -> PyResult<Gain> {
            let is_decreasing: bool = object.getattr("decreasing")?.extract()?;
            Ok(if is_decreasing { Gain::Decreasing } else { Gain::Constant(object.getattr("gain")?.extract()?) })
        };
        Ok(match kind.as_str() {
            "spatial" => Self::Spatial { gain: gain()?, low_pass_hz: number("low_pass_hz")? },
            "tracking" => Self::Tracking { gain: gain()?, low_pass_hz: number("low_pass_hz")? },
            "one-shot" => Self::OneShot,
            "norm-optimal" => Self::NormOptimal { contour_share: object.getattr("contour_share")?.extract()? },
            _ if object.hasattr("update")? => Self::Own(object.clone().unbind()),
            _ => {
                let why = "a law is an object of precomp.laws, or one with `update(desired, reference, actual, period_s)`";
                return Err(UsageError::new_err(why));
            }
        })
    }

    /// The law for a path on a machine; some probe it first.
    pub fn on(self, machine: &mut dyn Machine, path: &Trajectory, failure: &Failure) -> anyhow::Result<Box<dyn CompensationLaw>> {
        let filter = |hz: Option<f64>| hz.map_or(Ok(None), |hz| LowPass::new(hz, path.period_s()));
        Ok(match self {
            Self::Spatial { gain, low_pass_hz } => {
                Box::new(SpatialIlc::new(gain, filter(low_pass_hz)?)?.with_estimator(Box::new(Exact::default())))
            }
            Self::Tracking { gain, low_pass_hz } => Box::new(TrackingIlc::new(gain, filter(low_pass_hz)?)),
            Self::OneShot => Box::new(OneShot::default()),
            Self::NormOptimal { contour_share } => {
                Box::new(norm_optimal(contour_share, ImpulseResponse::probe(machine, path, PROBE, RESPONSE_S)?)?)
            }
            Self::Own(object) => Box::new(PythonLaw { object, failure: failure.clone() }),
        })
    }
}

/// A law that is an object of Python.
struct PythonLaw {
    object: Py<PyAny>,
    failure: Failure,
}

impl PythonLaw {
    fn columns(&self, desired: &Trajectory, reference: &Trajectory, actual: &Trajectory) -> PyResult<Vec<Vec<f64>>> {
        Python::attach(|py| {
            let of = |trajectory| arrays::array(py, trajectory);
            let given = (of(desired)?, of(reference)?, of(actual)?, reference.period_s());
            let next = self.object.bind(py).call_method1("update", given)?;
            let columns = arrays::columns(&next, reference.axes().len())?;
            if columns.iter().any(|column| column.len() != reference.len()) {
                return Err(UsageError::new_err(format!(
                    "`update` has to return {} samples, as the reference has",
                    reference.len()
                )));
            }
            Ok(columns)
        })
    }
}

impl CompensationLaw for PythonLaw {
    fn name(&self) -> &'static str {
        "python"
    }

    fn update(
        &mut self,
        desired: &DesiredPath,
        reference: &Trajectory,
        actual: &Trajectory,
    ) -> Result<Trajectory, CompensationError> {
        let columns = self.columns(desired.trajectory(), reference, actual).map_err(|error| {
            let text = error.to_string();
            self.failure.set(error);
            MachineError::Misfit(text)
        })?;
        Ok(reference.with_columns(columns)?)
    }
}
