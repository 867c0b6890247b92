//! Sections in which the program is followed but not understood: nothing in them may be changed.
//!
//! A code that is neither understood nor known to leave path and frame alone opens a section. A code that is known to cancel it ends the section; otherwise
//! the end of the program does. After a section the position is unknown until it is stated in full.

use super::codes::cancels;

/// What opened a section.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cause {
    /// A G code, in tenths.
    G(u16),
    /// Something that nothing is known to cancel.
    Lasting,
}

/// The sections that are open.
#[derive(Debug, Default)]
pub(super) struct Sections(Vec<Cause>);

impl Sections {
    pub fn is_open(&self) -> bool {
        !self.0.is_empty()
    }

    /// Opens a section; returns whether it is a new one.
    pub fn open(&mut self, cause: Cause) -> bool {
        let new = !self.0.contains(&cause);
        if new {
            self.0.push(cause);
        }
        new
    }

    /// Ends what this cause opened.
    pub fn close(&mut self, cause: Cause) {
        self.0.retain(|open| *open != cause);
    }

    /// Ends the sections that the code `off` (in tenths) cancels; returns whether there were any.
    pub fn close_by(&mut self, off: u16) -> bool {
        let open = self.0.len();
        self.0.retain(|cause| !matches!(cause, Cause::G(on) if ends(off, *on)));
        self.0.len() < open
    }
}

/// Whether the code `off` ends what the unknown code `on` began (both in tenths).
fn ends(off: u16, on: u16) -> bool {
    match off {
        400 => matches!(on, 412..=419 | 422..=429 | 1410 | 1420),
        490 => matches!(on, 433..=439 | 2340),
        690 => matches!(on, 685..=689 | 1680),
        1130 => on == 1120,
        1690 => on == 1680,
        _ => cancels(off, on),
    }
}
