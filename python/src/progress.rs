//! Long jobs: progress by a callback, Ctrl-C, and the interpreter free meanwhile.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::Builder;
use std::time::Duration;

use pipeline::units::um;
use pipeline::{Event, Progress};
use pyo3::prelude::*;

use crate::errors::{OrRaise, raised};

/// Time between two looks for signals.
const LOOK_EVERY: Duration = Duration::from_millis(50);
/// Stack of the thread of a job, as that of a command.
const STACK_BYTES: usize = 8 << 20;

/// The exception of an object of Python that a job called.
#[derive(Debug, Clone, Default)]
pub struct Failure(Arc<Mutex<Option<PyErr>>>);

impl Failure {
    /// Keeps the first exception.
    pub fn set(&self, error: PyErr) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
    }

    fn take(&self) -> Option<PyErr> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

/// What a callback is called with: steps done, steps in all, and what was done last.
type Report = (usize, usize, String);

fn report(event: Event<'_>) -> Report {
    match event {
        Event::Forecast { number, most, cost_mm } => (number, most, format!("learning: {} µm", um(cost_mm))),
        Event::Step { job, done, of, note } => (done, of, format!("{}: {note}", precomp::title(job))),
    }
}

/// Runs `job` on a thread of its own. This one reports to `callback` and looks for signals; an exception of either cancels the job at its
/// next step, and is raised. So is one in `failure`.
pub fn run<T: Send>(
    py: Python<'_>,
    callback: Option<Py<PyAny>>,
    failure: &Failure,
    job: impl FnOnce(Progress<'_>) -> anyhow::Result<T> + Send,
) -> PyResult<T> {
    py.detach(move || {
        let (sender, events) = channel();
        let (cancelled, is_watched) = (AtomicBool::new(false), callback.is_some());
        let work = || {
            // Dropped at the end, which ends the watch.
            let sender: Sender<Report> = sender;
            let progress = |event: Event<'_>| {
                if is_watched {
                    // The other side is gone only after the job.
                    let _ = sender.send(report(event));
                }
                if cancelled.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            };
            job(&progress)
        };
        std::thread::scope(|scope| {
            let worker = Builder::new().stack_size(STACK_BYTES).spawn_scoped(scope, work).or_raise()?;
            let watched = watch(&events, callback.as_ref());
            cancelled.store(watched.is_err(), Ordering::Relaxed);
            let result = worker.join();
            watched?;
            match (failure.take(), result) {
                (Some(error), _) => Err(error),
                (None, Ok(result)) => result.map_err(raised),
                (None, Err(panic)) => std::panic::resume_unwind(panic),
            }
        })
    })
}

/// Hands reports on and looks for signals until the job has ended.
fn watch(events: &Receiver<Report>, callback: Option<&Py<PyAny>>) -> PyResult<()> {
    loop {
        match (events.recv_timeout(LOOK_EVERY), callback) {
            (Ok(report), Some(callback)) => Python::attach(|py| callback.call1(py, report).map(drop))?,
            (Err(RecvTimeoutError::Disconnected), _) => return Ok(()),
            _ => {}
        }
        Python::attach(|py| py.check_signals())?;
    }
}
