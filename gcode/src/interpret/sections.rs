//! Sections that are tracked but not interpreted. Nothing in them is changed.
//!
//! A code opens a section if it is neither interpreted nor known to leave path and frame alone. A
//! known cancelling code ends the section, otherwise the end of the program. After a section the
//! position is unknown until all coordinates are stated.

use super::codes::cancels;
use crate::sections::Sections;
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

impl Sections<Cause> {
    /// Ends the sections that the code `off` (in tenths) cancels. Returns whether there were any.
    pub(super) fn close_by(&mut self, off: u16) -> bool {
        self.close_where(|cause| matches!(cause, Cause::G(on) if ends(off, *on)))
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
