//! How far a long job is, and whether it goes on.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::error::{Error, Result};

/// What is reported on the way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event<'a> {
    /// A forecast on the way to a reference.
    Forecast {
        /// Its number in its series, from 1; a program that is replanned begins a second series.
        number: usize,
        /// Forecasts that the series has at most.
        most: usize,
        /// What the learning lowers, mm.
        cost_mm: f64,
    },
    /// Where a job of several steps is.
    Step {
        /// The job.
        job: Job,
        /// Steps that are done.
        done: usize,
        /// Steps in all.
        of: usize,
        /// What was done last, or is done now.
        note: &'a str,
    },
}

/// A job of several steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Job {
    /// A step an axis.
    Training,
    /// A step a law.
    TuningIlc,
    /// A step a path and noise seed.
    Comparing,
    /// A step a program and noise seed.
    ComparingPrograms,
}

/// Is told of everything on the way; the job ends with [`Error::Cancelled`] at the next step after it breaks.
pub type Progress<'a> = &'a (dyn Fn(Event<'_>) -> ControlFlow<()> + Sync);

/// Reports nothing and goes on.
pub const SILENT: Progress<'static> = &|_| ControlFlow::Continue(());

/// Counts the steps of a job.
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

    /// What the job is at within a step.
    pub(crate) fn at(&self, note: &str) -> Result<()> {
        self.report(self.done.load(Ordering::Relaxed), note)
    }

    /// One step more.
    pub(crate) fn step(&self, note: &str) -> Result<()> {
        self.report(self.done.fetch_add(1, Ordering::Relaxed) + 1, note)
    }

    fn report(&self, done: usize, note: &str) -> Result<()> {
        match (self.progress)(Event::Step { job: self.job, done, of: self.of, note }) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(Error::Cancelled),
        }
    }
}
