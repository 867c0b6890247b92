//! Progress reports of long jobs, and their cancellation.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::error::{Error, Result};

/// A progress report.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event<'a> {
    /// A forecast was evaluated during model-based ILC.
    Forecast {
        /// Number of the forecast in its series, from 1. A replanned program starts a second series.
        number: usize,
        /// Largest number of forecasts in the series.
        most: usize,
        /// Cost that the iteration minimises, mm.
        cost_mm: f64,
    },
    /// A step of a job was reached.
    Step {
        /// The job.
        job: Job,
        /// Number of completed steps.
        done: usize,
        /// Total number of steps.
        of: usize,
        /// Name of the completed or current step.
        note: &'a str,
    },
}

/// A job of several steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Job {
    /// Training; one step for each axis.
    Training,
    /// Identification of a control; one step for each structure.
    Identifying,
    /// Tuning of ILC laws; one step for each law.
    TuningIlc,
    /// Comparison; one step for each path and noise seed.
    Comparing,
    /// Compensation of a long program; one step for each window.
    Windows,
    /// Forecast of a long reference; one step for each piece.
    Forecasting,
    /// Comparison of programs; one step for each program and noise seed.
    ComparingPrograms,
}

/// Callback that receives every [`Event`]. If it returns [`ControlFlow::Break`], the job ends with [`Error::Cancelled`]
/// at the next step.
pub type Progress<'a> = &'a (dyn Fn(Event<'_>) -> ControlFlow<()> + Sync);

/// A callback that ignores reports and never cancels.
pub const SILENT: Progress<'static> = &|_| ControlFlow::Continue(());

/// Counter of the steps of a job.
pub(crate) struct Steps<'a> {
    progress: Progress<'a>,
    job: Job,
    done: AtomicUsize,
    of: usize,
}

impl<'a> Steps<'a> {
    pub(crate) fn new(progress: Progress<'a>, job: Job, of: usize) -> Self {
        Self { progress, job, done: AtomicUsize::new(0), of }
    }

    /// Reports `note` within a step.
    pub(crate) fn at(&self, note: &str) -> Result<()> {
        self.report(self.done.load(Ordering::Relaxed), note)
    }

    /// Completes a step and reports it.
    pub(crate) fn step(&self, note: &str) -> Result<()> {
        self.report(self.done.fetch_add(1, Ordering::Relaxed) + 1, note)
    }

    fn report(&self, done: usize, note: &str) -> Result<()> {
        // How many steps a search takes is not always known before.
        match (self.progress)(Event::Step { job: self.job, done: done.min(self.of), of: self.of, note }) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(Error::Cancelled),
        }
    }
}
