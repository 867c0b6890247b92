//! Progress: a bar on a terminal, a line now and then elsewhere.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

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
        match &self.bar {
            Some(bar) => {
                bar.set_message(format!("{} {note}", self.what));
                bar.inc(1);
            }
            None if self.told.elapsed() >= TELL_EVERY => {
                eprintln!("{} {}/{} {note}", self.what, self.done, self.total);
                self.told = Instant::now();
            }
            None => {}
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
