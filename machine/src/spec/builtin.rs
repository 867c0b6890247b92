//! Machines that come with the crate.

use super::MachineSpec;
use crate::MachineError;

/// Name and description of every built-in machine; the first is the default.
pub const BUILTIN_MACHINES: [(&str, &str); 5] = [
    ("ballscrew", include_str!("../../machines/ballscrew.toml")),
    ("maxwell", include_str!("../../machines/maxwell.toml")),
    ("worn", include_str!("../../machines/worn.toml")),
    ("bc", include_str!("../../machines/bc.toml")),
    ("xyzac", include_str!("../../machines/xyzac.toml")),
];

impl MachineSpec {
    /// The built-in machine called `name`.
    ///
    /// # Errors
    /// When there is none of that name; the error lists the names.
    pub fn builtin(name: &str) -> Result<Self, MachineError> {
        match BUILTIN_MACHINES.iter().find(|(other, _)| *other == name) {
            Some((_, text)) => Self::from_toml(text),
            None => {
                let names: Vec<&str> = BUILTIN_MACHINES.iter().map(|(name, _)| *name).collect();
                Err(MachineError::BadDescription(format!(
                    "there is no built-in machine `{name}`; there are {}",
                    names.join(", ")
                )))
            }
        }
    }
}
