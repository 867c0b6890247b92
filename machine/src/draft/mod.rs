//! Drafts of machine files, from what a control's own settings say: a LinuxCNC INI file, Grbl's `$$` list, a Klipper configuration.
//!
//! A draft holds what is known with where it was found, and names what is missing; [`Draft::to_toml`] writes the commented file.

mod grbl;
mod klipper;
mod known;
mod linuxcnc;
mod sections;
mod write;

use crate::MachineError;

pub use known::{AxisDraft, Draft, Known, Missing, MissingValue};

/// The draft that a settings file gives; `file` is its name, for the comments, and `beside` the content of a file that it includes, by name.
///
/// # Errors
/// [`MachineError::BadDescription`] with the line where the file is of no known kind, or a value in it is no number.
pub fn draft(file: &str, text: &str, beside: &dyn Fn(&str) -> Option<String>) -> Result<Draft, MachineError> {
    let recognised = linuxcnc::read(file, text, beside).or_else(|| klipper::read(file, text, beside));
    recognised.or_else(|| grbl::read(file, text)).unwrap_or_else(|| {
        let known = "a LinuxCNC INI file, the list that Grbl prints for `$$`, or a Klipper printer.cfg";
        Err(MachineError::BadDescription(format!("{file} holds no settings that are known; give {known}")))
    })
}
