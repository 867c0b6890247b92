//! Sections that are tracked but not interpreted. Nothing in them is changed.
//!
//! A code opens a section if it is neither interpreted nor known to leave path and frame alone. A
//! known cancelling code ends the section, otherwise the end of the program. After a section the
//! position is unknown until all coordinates are stated.

use super::codes::cancels;
use crate::sinumerik::names::Section;

/// Cause of a section.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cause {
    /// A G code, in tenths.
    G(u16),
    /// What opened it has a name.
    Named(Section),
    /// A cause without a known cancelling code.
    Lasting,
}

/// The open sections.
#[derive(Debug, Default)]
pub(super) struct Sections(Vec<Cause>);

impl Sections {
    pub fn is_open(&self) -> bool {
        !self.0.is_empty()
    }

    /// Opens a section. Returns whether it is new.
    pub fn open(&mut self, cause: Cause) -> bool {
        let new = !self.0.contains(&cause);
        if new {
            self.0.push(cause);
        }
        new
    }

    /// Ends the sections opened by this cause. Returns whether there were any.
    pub fn close(&mut self, cause: Cause) -> bool {
        let open = self.0.len();
        self.0.retain(|other| *other != cause);
        self.0.len() < open
    }

    /// Ends the sections that the code `off` (in tenths) cancels. Returns whether there were any.
    pub fn close_by(&mut self, off: u16) -> bool {
        let open = self.0.len();
        self.0.retain(|cause| !matches!(cause, Cause::G(on) if ends(off, *on)));
        self.0.len() < open
    }
}

/// Whether the code `off` cancels the unknown code `on` (both in tenths).
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
