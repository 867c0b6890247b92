//! Long programs in windows: sections of some tens of seconds, each with the motion before and after it, are compensated on their own and
//! joined in their order.
//!
//! A window begins and ends between two blocks at which the modal state is known and the next move is a line or a rapid in absolute
//! coordinates. Its surroundings cover what the planner looks ahead, the memory of the model and the low-pass of the law; an approach from
//! the direction of every axis's last motion puts backlash and friction on their side. Memory is that of the program's words and of as many
//! windows as there are threads.

mod cuts;
mod joined;
#[cfg(test)]
mod tests;
mod window;

use std::ops::ControlFlow;
use std::sync::Arc;

use gcode::{Diagnostic, Program};
use models::Bundle;
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::model_based_ilc::{FewerPoints, Settings};
use crate::output::OutputSettings;
use crate::part::{ReadSettings, Section, Whole};
use crate::progress::{Event, Job, Progress};
use crate::refit::{Mark, marked_line};
use crate::setup::Setup;

use cuts::{Cuts, scan};
use window::Window;

pub use joined::Joined;
pub use window::OutsideLines;

/// Estimated time from which on a program is compensated in windows, s. Below it, one plan of all takes less than 100 MB.
const LONG_S: f64 = 120.0;

/// A long program with the places at which it can be cut.
#[derive(Debug)]
pub struct LongProgram {
    whole: Arc<Whole>,
    setup: Setup,
    read: ReadSettings,
    cuts: Cuts,
}

impl LongProgram {
    /// Finds the cuts of a program for a setup. `None` for a short program, and for one that cannot be cut: in another language than RS-274, with
    /// parameters or subprograms, in increments throughout, or for a machine with rotary axes.
    ///
    /// # Errors
    /// Faults of the program, as [`Part::read`](crate::Part::read).
    pub fn new(name: &str, program: &Arc<Program>, setup: &Setup, settings: &ReadSettings) -> Result<Option<Self>> {
        if settings.expand || setup.kinematics.has_rotary_axes() || gcode::recognise(program).is_some() {
            return Ok(None);
        }
        let whole = Whole::new(name, Arc::clone(program), setup, settings)?;
        let Some(cuts) = scan(&whole, setup)? else { return Ok(None) };
        let is_long = cuts.seconds() >= LONG_S && cuts.windows() > 1;
        let (setup, read) = (setup.clone(), settings.clone());
        Ok(is_long.then(|| Self { whole: Arc::new(whole), setup, read, cuts }))
    }

    /// What is known of the whole program.
    #[must_use]
    pub fn whole(&self) -> &Whole {
        &self.whole
    }

    /// Warnings of the interpreter.
    #[must_use]
    pub fn warnings(&self) -> &[Diagnostic] {
        &self.cuts.warnings
    }

    /// Number of windows.
    #[must_use]
    pub fn windows(&self) -> usize {
        self.cuts.windows()
    }

    /// Compensates all windows and joins them, to be written in `format`. A `Step` event follows every window.
    ///
    /// # Errors
    /// As [`model_based_ilc`](crate::model_based_ilc()) and [`Outcome::write`](crate::model_based_ilc::Outcome::write), of the first window that
    /// fails.
    pub fn compensate<'a>(
        &self,
        model: &'a Bundle,
        settings: &Settings,
        format: &OutputSettings,
        progress: Progress<'_>,
    ) -> Result<Joined<'a>> {
        if let Some(line) = marked_line(&self.whole.program) {
            return Err(Error::AlreadyCompensated { name: self.whole.name.clone(), line });
        }
        let placement = self.whole.placement(self.cuts.systems(), &self.setup, &self.read);
        let sections: Vec<Section> = self.cuts.sections(&self.whole, &placement, &self.setup);
        let window = |section: &Section, settings: &Settings| {
            Window { section, placement: &placement, setup: &self.setup, model, settings, format }.compensate()
        };
        let mut settings = Settings { written: format.program(), ..*settings };
        let mut joined = Joined::new(&self.whole, placement.known());
        let (first, others) = sections.split_at(1);
        for some in std::iter::once(first).chain(others.chunks(rayon::current_num_threads().max(1))) {
            for done in some.par_iter().map(|section| window(section, &settings)).collect::<Vec<_>>() {
                joined.add(done?);
                let event = Event::Step { job: Job::Windows, done: joined.windows(), of: sections.len(), note: &joined.note() };
                if progress(event) == ControlFlow::Break(()) {
                    return Err(Error::Cancelled);
                }
            }
            // The search of points in the other windows begins with those that suit the first one.
            if let (1, Some((points, _))) = (joined.windows(), joined.points)
                && settings.fewer_points != FewerPoints::Never
            {
                settings = Settings { written: Some(points), fewer_points: FewerPoints::WhereTooSlow, ..settings };
            }
        }
        let mark = format.clone().marked(Mark::of_model(model, &settings)?).mark;
        joined.finish(&self.whole, &sections[0], mark.as_ref())?;
        Ok(joined)
    }
}
