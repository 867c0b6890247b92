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
    /// A code, in tenths, under which programmed coordinates are not those of the path, or after whose moves others follow.
    Transform(u16),
    /// What opened it has a name.
    Named(Section),
    /// A cause without a known cancelling code.
    Lasting,
}

impl Sections<Cause> {
    /// Ends the sections that the code `off` (in tenths) cancels. Returns whether there were any.
    pub(super) fn close_by(&mut self, off: u16) -> bool {
        self.close_where(|cause| match cause {
            Cause::G(on) => ends(off, *on),
            Cause::Transform(on) => cancels(off, *on),
            Cause::Named(_) | Cause::Lasting => false,
        })
    }

    /// Whether programmed coordinates may differ from those of the path.
    pub(super) fn transforms(&self) -> bool {
        self.any(|cause| matches!(cause, Cause::Transform(_)))
    }
}

/// Whether a code cancels the unknown code `on` (in tenths).
pub(super) fn has_end(on: u16) -> bool {
    [400, 490].iter().any(|off| ends(*off, on))
}

/// Whether the code `off` cancels the unknown code `on` (both in tenths).
fn ends(off: u16, on: u16) -> bool {
    match off {
        400 => matches!(on, 412..=419 | 422..=429 | 1410 | 1420),
        490 => matches!(on, 433..=439 | 2340),
        _ => cancels(off, on),
    }
}
