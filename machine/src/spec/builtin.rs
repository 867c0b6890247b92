//! Built-in machines and controller profiles.

use super::{ControllerSpec, MachineSpec};
use crate::MachineError;

/// Name and machine file (TOML) of every built-in machine: `ballscrew`, `maxwell`, `worn`, `bc`, `xyzac`. The first is the default.
pub const BUILTIN_MACHINES: [(&str, &str); 5] = [
    ("ballscrew", include_str!("../../machines/ballscrew.toml")),
    ("maxwell", include_str!("../../machines/maxwell.toml")),
    ("worn", include_str!("../../machines/worn.toml")),
    ("bc", include_str!("../../machines/bc.toml")),
    ("xyzac", include_str!("../../machines/xyzac.toml")),
];

/// Name and text of every built-in controller profile.
pub const BUILTIN_CONTROLLERS: [(&str, &str); 5] = [
    ("linuxcnc", include_str!("../../controllers/linuxcnc.toml")),
    ("fanuc", include_str!("../../controllers/fanuc.toml")),
    ("siemens", include_str!("../../controllers/siemens.toml")),
    ("grbl", include_str!("../../controllers/grbl.toml")),
    ("generic", include_str!("../../controllers/generic.toml")),
];

impl ControllerSpec {
    /// The built-in profile called `name`.
    ///
    /// # Errors
    /// If there is none of that name. The error lists the names.
    pub fn builtin(name: &str) -> Result<Self, MachineError> {
        Self::from_toml(text_of("controller", &BUILTIN_CONTROLLERS, name)?)
    }
}

impl MachineSpec {
    /// The built-in machine called `name`.
    ///
    /// # Errors
    /// If there is none of that name. The error lists the names.
    pub fn builtin(name: &str) -> Result<Self, MachineError> {
        Self::from_toml(text_of("machine", &BUILTIN_MACHINES, name)?)
    }
}

/// The text called `name` among the built-in ones of a kind.
fn text_of<'a>(kind: &str, all: &[(&str, &'a str)], name: &str) -> Result<&'a str, MachineError> {
    let found = all.iter().find(|(other, _)| *other == name);
    found.map(|(_, text)| *text).ok_or_else(|| {
        let names: Vec<&str> = all.iter().map(|(name, _)| *name).collect();
        MachineError::BadDescription(format!("there is no built-in {kind} `{name}`; there are {}", names.join(", ")))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ProfileFormat;

    #[test]
    fn every_profile_is_sound_and_others_are_refused() {
        for (name, _) in BUILTIN_CONTROLLERS {
            ControllerSpec::builtin(name).unwrap();
        }
        assert_eq!(ControllerSpec::builtin("linuxcnc").unwrap().format, ProfileFormat::G93);
        assert!(ControllerSpec::builtin("abacus").unwrap_err().to_string().contains("grbl"));
        assert!(ControllerSpec::from_toml("decimals = 40\nformat = \"keep\"\npoint_spacing_ms = 4.0\n").is_err());
        assert!(ControllerSpec::from_toml("decimals = 4\n").is_err());
    }
}
