//! Paths to compensate, predict or measure against: a part program, or a path with its own time.

use std::sync::Arc;

use compensation::{CorrectionLimits, Held};
use motion::curves::library;
use motion::{Cartesian, DesiredPath, Kinematics, Limits, Trajectory, plan_curve_on};

use crate::error::{Error, Result};
use crate::part::Part;
use crate::path_time;
use crate::refit::marked_line;
use crate::setup::Setup;
use crate::statistics::{self, Figures};

/// Ratio to the speed limit of an axis above which a reference is refused: references may exceed the limits of a machine file,
/// but a jump has no forecast.
const LARGEST_SPEED_RATIO: f64 = 10.0;

fn check_speed(name: &str, reference: &Trajectory, limits: &Limits) -> Result<()> {
    for ((axis, column), limits) in reference.axes().iter().zip(reference.columns()).zip(&limits.axes) {
        let speed = |pair: &[f64]| (pair[1] - pair[0]).abs() / reference.period_s();
        let limit = limits.velocity;
        if let Some(sample) = column.windows(2).position(|pair| speed(pair) > LARGEST_SPEED_RATIO * limit) {
            let (name, axis, speed) = (name.to_owned(), axis.name.clone(), speed(&column[sample..sample + 2]));
            let (time_s, times) = ((sample + 1) as f64 * reference.period_s(), LARGEST_SPEED_RATIO);
            return Err(Error::TooFast { name, time_s, axis, speed, limit, times });
        }
    }
    Ok(())
}

/// A path that a machine is to run.
#[derive(Debug)]
pub enum Input {
    /// A path planned from a part program.
    Program(Box<Part>),
    /// A reference trajectory or a test curve.
    Path(TimedPath),
}

/// A path without a program.
#[derive(Debug)]
pub struct TimedPath {
    /// Name for tables.
    pub name: String,
    /// Desired path.
    pub desired: DesiredPath,
    /// Limits of axes and path; `None` where the machine is not known.
    pub limits: Option<Limits>,
}

impl From<Part> for Input {
    fn from(part: Part) -> Self {
        Self::Program(Box::new(part))
    }
}

impl Input {
    /// A reference: axis positions over time. The setup's kinematics apply where its axes are those of the reference;
    /// otherwise every axis is a Cartesian coordinate.
    ///
    /// # Errors
    /// When the axes do not define a tool tip position, or one moves far above the setup's limits.
    pub fn reference(name: impl Into<String>, reference: Trajectory, setup: Option<&Setup>) -> Result<Self> {
        let name = name.into();
        if let Some(setup) = setup.filter(|setup| setup.kinematics.axes() == reference.axes()) {
            check_speed(&name, &reference, &setup.limits)?;
        }
        let kinematics: Arc<dyn Kinematics> = match setup {
            Some(setup) if setup.kinematics.axes() == reference.axes() => Arc::clone(&setup.kinematics),
            _ => Arc::new(Cartesian::new(reference.axes().to_vec())),
        };
        Ok(Self::path(name, DesiredPath::new(reference, kinematics)?, setup.map(|setup| setup.limits.clone())))
    }

    /// A path that is already planned.
    #[must_use]
    pub fn path(name: impl Into<String>, desired: DesiredPath, limits: Option<Limits>) -> Self {
        Self::Path(TimedPath { name: name.into(), desired, limits })
    }

    /// The built-in test curve `name`, at `feed_mm_s`.
    ///
    /// # Errors
    /// When there is no such curve, or the machine cannot run it.
    pub fn curve(name: &str, feed_mm_s: f64, setup: &Setup) -> Result<Self> {
        let curve = library::by_name(name)?;
        let desired = plan_curve_on(curve, feed_mm_s, &setup.kinematics, &setup.limits, &setup.plan_settings())?;
        Ok(Self::path(name, desired, Some(setup.limits.clone())))
    }

    /// Name of the path, for tables.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::Program(part) => &part.name,
            Self::Path(path) => &path.name,
        }
    }

    /// Desired path of the tool.
    #[must_use]
    pub fn desired(&self) -> &DesiredPath {
        match self {
            Self::Program(part) => &part.plan.desired,
            Self::Path(path) => &path.desired,
        }
    }

    /// Desired axis positions, one sample a period.
    #[must_use]
    pub fn trajectory(&self) -> &Trajectory {
        self.desired().trajectory()
    }

    /// The part program of the path; `None` for a reference or curve.
    #[must_use]
    pub fn part(&self) -> Option<&Part> {
        match self {
            Self::Program(part) => Some(part),
            Self::Path(_) => None,
        }
    }

    /// The part program of the path.
    ///
    /// # Errors
    /// [`Error::NoProgram`] for a reference or curve.
    pub fn program(&self) -> Result<&Part> {
        self.part().ok_or(Error::NoProgram)
    }

    /// The part program of the path, mutable; `None` for a reference or curve.
    pub fn part_mut(&mut self) -> Option<&mut Part> {
        match self {
            Self::Program(part) => Some(part),
            Self::Path(_) => None,
        }
    }

    /// Limits of axes and path; `None` where the machine is not known.
    #[must_use]
    pub fn limits(&self) -> Option<&Limits> {
        match self {
            Self::Program(part) => Some(&part.limits),
            Self::Path(path) => path.limits.as_ref(),
        }
    }

    /// Command of the control for the uncompensated path: the recorded command where there is one, else the desired
    /// path.
    #[must_use]
    pub fn command(&self) -> &Trajectory {
        self.part().and_then(|part| part.command.as_ref()).unwrap_or(self.trajectory())
    }

    /// Contour error of a run in the path's own time. For a program it is evaluated over feed moves.
    ///
    /// # Errors
    /// When the samples or axes of `actual` are not those of the path.
    pub fn figures(&self, actual: &Trajectory) -> Result<Figures> {
        statistics::figures(self.desired(), self.part(), actual)
    }

    /// Planned path of the program, in the input's time. It is [`Input::desired`] but for the corners of a recorded run, which are to stay as they
    /// were recorded.
    #[must_use]
    pub fn program_path(&self) -> &DesiredPath {
        self.part().and_then(|part| part.recording.as_ref()).map_or(self.desired(), |recording| &recording.desired)
    }

    /// Same as [`Input::figures`], against the [planned path](Self::program_path). Of a recorded run every sample of the planned path counts once,
    /// as when a log is measured.
    ///
    /// # Errors
    /// As [`Input::figures`].
    pub fn figures_of_program(&self, actual: &Trajectory) -> Result<Figures> {
        match self.part().and_then(|part| Some((part, part.recording.as_ref()?))) {
            Some((part, recording)) => {
                let weights = path_time::weights(&recording.plan.desired, &recording.path_positions);
                statistics::weighted_figures(&recording.desired, part, &weights, actual)
            }
            None => self.figures(actual),
        }
    }

    /// Limits of corrections of this input: shift of the tool tip, mm, rotation of the tool, rad, share of the correction that each sample
    /// takes (all of it where empty), and the limits of the machine.
    #[must_use]
    pub fn correction_limits(&self, max_shift: f64, max_rotation_rad: f64, weights: Vec<f64>) -> CorrectionLimits {
        let limits = self.limits().cloned();
        let held = if self.part().is_some() { Held::EachAxis } else { Held::AllAxes };
        let resting = self.part().map(Part::resting).unwrap_or_default();
        CorrectionLimits { max_shift, max_rotation_rad, limits, held, weights, resting, ..CorrectionLimits::default() }
    }

    /// Refuses a program that carries the comment of [`OutputSettings::marked`](crate::OutputSettings::marked), as every program does that
    /// [`Outcome::write`](crate::model_based_ilc::Outcome::write) changed. A program written without a mark is not recognised.
    ///
    /// # Errors
    /// [`Error::AlreadyCompensated`] with the line of the statement.
    pub fn check_original(&self) -> Result<()> {
        match self.part().and_then(|part| Some((part.name.clone(), marked_line(&part.program)?))) {
            Some((name, line)) => Err(Error::AlreadyCompensated { name, line }),
            None => Ok(()),
        }
    }

    /// Largest axis difference between `reference` and the path, mm or rad.
    #[must_use]
    pub fn largest_shift(&self, reference: &Trajectory) -> f64 {
        let columns = self.trajectory().columns().iter().zip(reference.columns());
        columns.flat_map(|(d, r)| d.iter().zip(r).map(|(d, r)| (r - d).abs())).fold(0.0, f64::max)
    }
}
