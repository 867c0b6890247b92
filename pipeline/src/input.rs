//! What is compensated, predicted or measured against: a part program, or a path that carries its own time.

use std::sync::Arc;

use motion::curves::library;
use motion::{Cartesian, DesiredPath, Kinematics, Limits, Trajectory, plan_curve_on};

use crate::error::{Error, Result};
use crate::part::Part;
use crate::setup::Setup;
use crate::statistics::{self, Figures};

/// A path to be run.
#[derive(Debug)]
pub enum Input {
    /// Planned from a part program.
    Program(Box<Part>),
    /// A reference or curve.
    Path(TimedPath),
}

/// A path that no program states.
#[derive(Debug)]
pub struct TimedPath {
    /// Name for tables.
    pub name: String,
    /// What the part needs.
    pub desired: DesiredPath,
    /// What the axes and the path are allowed to do, where the machine is known.
    pub limits: Option<Limits>,
}

impl From<Part> for Input {
    fn from(part: Part) -> Self {
        Self::Program(Box::new(part))
    }
}

impl Input {
    /// A reference: axis positions over time, in the setup's kinematics where the axes are the machine's, else each axis a coordinate.
    ///
    /// # Errors
    /// When the axes cannot place a tool.
    pub fn reference(name: impl Into<String>, reference: Trajectory, setup: Option<&Setup>) -> Result<Self> {
        let kinematics: Arc<dyn Kinematics> = match setup {
            Some(setup) if setup.kinematics.axes() == reference.axes() => Arc::clone(&setup.kinematics),
            _ => Arc::new(Cartesian::new(reference.axes().to_vec())),
        };
        Ok(Self::path(name, DesiredPath::new(reference, kinematics)?, setup.map(|setup| setup.limits.clone())))
    }

    /// A path that is planned already.
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

    /// Name for tables.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::Program(part) => &part.name,
            Self::Path(path) => &path.name,
        }
    }

    /// What the part needs.
    #[must_use]
    pub fn desired(&self) -> &DesiredPath {
        match self {
            Self::Program(part) => &part.plan.desired,
            Self::Path(path) => &path.desired,
        }
    }

    /// The desired path, sample by sample.
    #[must_use]
    pub fn trajectory(&self) -> &Trajectory {
        self.desired().trajectory()
    }

    /// The program that the path was planned from.
    #[must_use]
    pub fn part(&self) -> Option<&Part> {
        match self {
            Self::Program(part) => Some(part),
            Self::Path(_) => None,
        }
    }

    /// The program that the path was planned from, where one is needed.
    ///
    /// # Errors
    /// [`Error::NoProgram`] where the path comes from none.
    pub fn program(&self) -> Result<&Part> {
        self.part().ok_or(Error::NoProgram)
    }

    /// The same, to be changed.
    pub fn part_mut(&mut self) -> Option<&mut Part> {
        match self {
            Self::Program(part) => Some(part),
            Self::Path(_) => None,
        }
    }

    /// What the axes and the path are allowed to do, where the machine is known.
    #[must_use]
    pub fn limits(&self) -> Option<&Limits> {
        match self {
            Self::Program(part) => Some(&part.limits),
            Self::Path(path) => path.limits.as_ref(),
        }
    }

    /// What the control commands when the path is run as it is: what it commanded in a recorded run, where there is one.
    #[must_use]
    pub fn command(&self) -> &Trajectory {
        self.part().and_then(|part| part.command.as_ref()).unwrap_or(self.trajectory())
    }

    /// Contour error of a run in the path's own time; of a program over feed moves.
    ///
    /// # Errors
    /// When the two do not match.
    pub fn figures(&self, actual: &Trajectory) -> Result<Figures> {
        statistics::figures(self.desired(), self.part(), actual)
    }

    /// Largest difference of an axis's position from the path, mm or rad.
    #[must_use]
    pub fn largest_shift(&self, reference: &Trajectory) -> f64 {
        let columns = self.trajectory().columns().iter().zip(reference.columns());
        columns.flat_map(|(d, r)| d.iter().zip(r).map(|(d, r)| (r - d).abs())).fold(0.0, f64::max)
    }
}
