//! What was done: a run along a path, measured or predicted.

use anyhow::Result;
use motion::contour::{ContourError, ContourSummary, orientation_errors};
use motion::{Trajectory, Vec3, poses_of};
use pipeline::analysis::LagMismatch;
use pipeline::measure::Measurement;
use pipeline::statistics::{self, OrientationSummary};
use pipeline::units::ErrorUnit;
use pipeline::{Input, Log};

use super::track::Track;

/// One run, sample by sample.
pub struct Run {
    /// Name.
    pub name: String,
    /// Contour error of the tool tip.
    pub errors: Vec<ContourError>,
    /// Error of the tool's direction, µrad; `None` on a machine without rotary axes.
    pub turn_urad: Option<Vec<f64>>,
    /// Tracking error of every axis, command minus actual position, µm or µrad.
    pub tracking: Vec<Vec<f64>>,
    /// Correction of every axis, command minus desired position, µm or µrad; `None` where the desired path is the command.
    pub correction: Option<Vec<Vec<f64>>>,
    /// How differently its axes lag; `None` on a machine with rotary axes, whose linear axes are no directions of the workpiece.
    pub lags: Option<LagMismatch>,
    /// Figures over the samples that count.
    pub figures: ContourSummary,
    /// Figures of the tool's direction.
    pub turn: Option<OrientationSummary>,
}

impl Run {
    /// The run `actual` of `command` along a path, both in the path's time; without a command the path itself is the command.
    ///
    /// # Errors
    /// When they do not match the path, or no sample counts.
    pub fn of(name: &str, track: &Track<'_>, command: Option<&Trajectory>, actual: &Trajectory) -> Result<Self> {
        let desired = track.desired;
        let errors = statistics::contour_errors(desired, actual)?;
        let correction = command.map(|command| in_units(desired.trajectory(), command)).transpose()?;
        let correction = correction.filter(|columns| columns.iter().flatten().any(|value| value.abs() > LEAST_CORRECTION));
        let tracking = in_units(actual, command.unwrap_or(desired.trajectory()))?;
        Self::new(name, track, errors, (tracking, correction), (desired.trajectory(), actual))
    }

    /// The run that was measured, in its own time.
    ///
    /// # Errors
    /// As [`Run::of`].
    pub fn measured(name: &str, track: &Track<'_>, input: &Input, log: &Log, measured: &Measurement) -> Result<Self> {
        let tracking = in_units(&log.actual, &log.reference)?;
        let offsets = measured.matched.offsets(log.axes());
        let path = input.trajectory();
        let desired_at = |axis: usize, place: usize| path.columns().get(axis).map_or(f64::NAN, |column| column[place]);
        let of_axis = |(index, (axis, column)): (usize, (&motion::Axis, &Vec<f64>))| -> Vec<f64> {
            let unit = ErrorUnit::from(axis);
            let at = |(k, x): (usize, &f64)| unit.value(x - offsets[index] - desired_at(index, track.places[k]));
            column.iter().enumerate().map(at).collect()
        };
        // In a time of its own a command runs beside the samples of the path: what is along it is no correction.
        let in_time = measured.matched.delay_s.is_some_and(|delay| delay.abs() < 1e-3 * log.period_s());
        let correction: Option<Vec<Vec<f64>>> =
            in_time.then(|| log.axes().iter().zip(log.reference.columns()).enumerate().map(of_axis).collect());
        let correction = correction.filter(|columns| columns.iter().flatten().any(|value| value.abs() > LEAST_CORRECTION));
        Self::new(name, track, measured.errors.clone(), (tracking, correction), (&log.reference, &log.actual))
    }

    fn new(
        name: &str,
        track: &Track<'_>,
        errors: Vec<ContourError>,
        (tracking, correction): (Vec<Vec<f64>>, Option<Vec<Vec<f64>>>),
        (wanted, actual): (&Trajectory, &Trajectory),
    ) -> Result<Self> {
        let figures = statistics::weighted(&errors, &track.weights)?;
        let turn_urad = if track.turns() {
            let poses = poses_of(actual, track.desired.kinematics().as_ref())?;
            Some(orientation_errors(&errors, &poses, &track.poses).iter().map(|error| error.angle_rad * 1e6).collect())
        } else {
            None
        };
        let turn = statistics::orientation(track.desired, &errors, &track.poses, actual, &track.weights)?;
        let lags = if track.turns() { None } else { LagMismatch::of(wanted, actual) };
        Ok(Self { name: name.to_owned(), errors, turn_urad, tracking, correction, lags, figures, turn })
    }

    /// Contour error of every sample, µm; not a number where the sample does not count.
    #[must_use]
    pub fn contour_um(&self, track: &Track<'_>) -> Vec<f64> {
        let of = |(error, weight): (&ContourError, &Option<f64>)| weight.map_or(f64::NAN, |_| error.magnitude_mm * 1e3);
        self.errors.iter().zip(&track.weights).map(of).collect()
    }

    /// Contour error vectors, mm.
    #[must_use]
    pub fn vectors(&self) -> Vec<Vec3> {
        self.errors.iter().map(|error| error.vector).collect()
    }
}

/// Size above which a difference of command and path is a correction, µm or µrad: far above the rounding of logs' numbers.
const LEAST_CORRECTION: f64 = 0.01;

/// `to` minus `from`, axis by axis, µm or µrad.
fn in_units(from: &Trajectory, to: &Trajectory) -> Result<Vec<Vec<f64>>> {
    let differences = to.tracking_error(from)?;
    let scaled = |(axis, column): (&motion::Axis, Vec<f64>)| {
        let unit = ErrorUnit::from(axis);
        column.into_iter().map(|value| unit.value(value)).collect()
    };
    Ok(to.axes().iter().zip(differences).map(scaled).collect())
}
