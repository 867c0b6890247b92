//! Progress: a bar on a terminal, a line now and then elsewhere.

use std::io::IsTerminal;
use std::ops::ControlFlow;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use pipeline::Event;
use pipeline::progress::Job;
use pipeline::units::um;

/// How much of long work is shown.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Detail {
    /// Nothing.
    None,
    /// A bar on a terminal, a line now and then elsewhere.
    #[default]
    Bars,
    /// A line for every step.
    Steps,
}

/// Shows one job, or one series of forecasts.
struct Bar {
    detail: Detail,
    bar: Option<ProgressBar>,
    began: Instant,
    what: String,
    total: u64,
    done: u64,
    reported: Instant,
}

/// Time between two lines where there is no terminal.
const REPORT_EVERY: Duration = Duration::from_secs(15);

impl Bar {
    /// Progress of a job of `total` steps.
    fn new(what: &str, total: u64, detail: Detail) -> Self {
        let bar = (detail == Detail::Bars && std::io::stderr().is_terminal()).then(|| {
            let bar = ProgressBar::new(total);
            if let Ok(style) = ProgressStyle::with_template("{msg:28} {bar:30} {pos}/{len} {per_sec} {eta}") {
                bar.set_style(style);
            }
            bar.set_message(what.to_owned());
            bar
        });
        let now = Instant::now();
        Self { detail, bar, began: now, what: what.to_owned(), total, done: 0, reported: now }
    }

    /// So many steps are done; `note` says what was done last.
    fn show(&mut self, done: u64, note: &str) {
        self.done = done;
        match &self.bar {
            Some(bar) => {
                bar.set_message(format!("{} {note}", self.what));
                bar.set_position(self.done);
            }
            None if self.is_due() => {
                let seconds = self.began.elapsed().as_secs_f64();
                let time = if self.detail == Detail::Steps { format!(" [{seconds:.1} s]") } else { String::new() };
                eprintln!("{} {}/{} {note}{time}", self.what, self.done, self.total);
                self.reported = Instant::now();
            }
            None => {}
        }
    }
}

impl Bar {
    /// Whether a step is to be shown in a line.
    fn is_due(&self) -> bool {
        match self.detail {
            Detail::None => false,
            Detail::Bars => self.reported.elapsed() >= REPORT_EVERY,
            Detail::Steps => true,
        }
    }
}

/// Shows how far the library is with a long job.
#[derive(Default)]
pub struct Shown {
    detail: Detail,
    now: Mutex<Option<(What, Bar)>>,
}

/// What a bar is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum What {
    Learning,
    Job(Job),
}

impl Shown {
    /// Shows so much.
    #[must_use]
    pub fn new(detail: Detail) -> Self {
        Self { detail, now: Mutex::default() }
    }

    /// Shows an event, and goes on.
    pub fn event(&self, event: Event<'_>) -> ControlFlow<()> {
        // A thread that panicked while it showed something leaves nothing that matters.
        let mut shown = self.now.lock().unwrap_or_else(PoisonError::into_inner);
        let (what, title, of, begins) = match event {
            Event::Forecast { number, most, .. } => (What::Learning, "learning", most, number == 1),
            Event::Step { job, of, .. } => (What::Job(job), title(job), of, false),
        };
        if begins || shown.as_ref().is_none_or(|(known, _)| *known != what) {
            let before = shown.take().map(|(_, before)| (before.reported, before.began));
            let mut bar = Bar::new(title, of as u64, self.detail);
            (bar.reported, bar.began) = before.unwrap_or((bar.reported, bar.began));
            *shown = Some((what, bar));
        }
        if let Some((_, bar)) = shown.as_mut() {
            match event {
                Event::Forecast { number, cost_mm, .. } => bar.show(number as u64, &format!("{} µm", um(cost_mm))),
                Event::Step { done, note, .. } => bar.show(done as u64, note),
            }
        }
        ControlFlow::Continue(())
    }
}

/// What a job is called.
#[must_use]
pub fn title(job: Job) -> &'static str {
    match job {
        Job::Training => "training",
        Job::Identifying => "identifying the control",
        Job::TuningIlc => "tuning ILC",
        Job::Comparing => "comparing",
        Job::Windows => "compensating windows",
        Job::Forecasting => "forecasting",
        Job::ComparingPrograms => "comparing programs",
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_series_goes_on_from_the_first() {
        let shown = Shown::default();
        let begun = Instant::now() - REPORT_EVERY / 2;
        let forecast = |number, most| shown.event(Event::Forecast { number, most, cost_mm: 1e-3 });
        assert_eq!(forecast(1, 5), ControlFlow::Continue(()));
        shown.now.lock().unwrap().as_mut().unwrap().1.reported = begun;
        let _ = forecast(2, 5);
        let _ = forecast(1, 13);
        let progress = shown.now.lock().unwrap();
        let (_, bar) = progress.as_ref().unwrap();
        assert_eq!((bar.done, bar.total, bar.reported), (1, 13, begun));
    }
}
