//! Progress: a bar on a terminal, a line now and then elsewhere.

use std::io::IsTerminal;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::learning::Forecast;
use crate::output::um;

/// Shows how far a long job is.
pub struct Progress {
    bar: Option<ProgressBar>,
    what: String,
    total: u64,
    done: u64,
    told: Instant,
}

/// Time between two lines where there is no terminal.
const TELL_EVERY: Duration = Duration::from_secs(15);

impl Progress {
    /// Progress of a job of `total` steps.
    pub fn new(what: &str, total: u64) -> Self {
        let bar = std::io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::new(total);
            if let Ok(style) = ProgressStyle::with_template("{msg:28} {bar:30} {pos}/{len} {eta}") {
                bar.set_style(style);
            }
            bar.set_message(what.to_owned());
            bar
        });
        Self { bar, what: what.to_owned(), total, done: 0, told: Instant::now() }
    }

    /// One step more; `note` says how it went.
    pub fn step(&mut self, note: &str) {
        self.done += 1;
        self.at(note);
    }

    /// What the job is at within a step.
    pub fn at(&mut self, note: &str) {
        match &self.bar {
            Some(bar) => {
                bar.set_message(format!("{} {note}", self.what));
                bar.set_position(self.done);
            }
            None if self.told.elapsed() >= TELL_EVERY => {
                eprintln!("{} {}/{} {note}", self.what, self.done, self.total);
                self.told = Instant::now();
            }
            None => {}
        }
    }
}

/// Shows how far learning is, by the forecasts that it reports; a series of its own for a program that is planned anew.
pub struct LearningProgress(Mutex<Option<Progress>>);

impl LearningProgress {
    /// Nothing is shown before the first forecast.
    pub fn new() -> Self {
        Self(Mutex::new(None))
    }

    /// One forecast more.
    pub fn show(&self, forecast: Forecast) {
        // A thread that panicked while it showed something leaves nothing that matters.
        let mut progress = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if forecast.number == 1 || progress.is_none() {
            let told = progress.take().map(|before| before.told);
            let mut series = Progress::new("learning", forecast.most as u64);
            series.told = told.unwrap_or(series.told);
            *progress = Some(series);
        }
        if let Some(progress) = progress.as_mut() {
            progress.step(&format!("{} µm", um(forecast.cost_mm)));
        }
    }
}

impl Drop for Progress {
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
        let shown = LearningProgress::new();
        let begun = Instant::now() - TELL_EVERY / 2;
        shown.show(Forecast { number: 1, most: 5, cost_mm: 2e-3 });
        shown.0.lock().unwrap().as_mut().unwrap().told = begun;
        shown.show(Forecast { number: 2, most: 5, cost_mm: 1e-3 });
        shown.show(Forecast { number: 1, most: 13, cost_mm: 1e-3 });
        let progress = shown.0.lock().unwrap();
        let progress = progress.as_ref().unwrap();
        assert_eq!((progress.done, progress.total, progress.told), (1, 13, begun));
    }
}
