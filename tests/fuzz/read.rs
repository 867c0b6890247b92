//! Mutated inputs in the readers of the library.

use std::path::Path;

use datasets::ReadOptions;
use gcode::{Dialect, Edits, Options};
use machine::{ControllerSpec, MachineSpec};
use models::Bundle;

use crate::seeds::Kind;

/// Reads an input; what is wrong with it is an error that nobody looks at.
pub fn read(kind: Kind, bytes: &[u8]) {
    match kind {
        Kind::Program(_) => program(bytes),
        Kind::Log(name) | Kind::Reference(name) => {
            let options = ReadOptions { columns: None, period_s: Some(0.002) };
            let _ = datasets::log_from_bytes(Path::new(name), bytes.to_vec(), &options);
        }
        Kind::Machine => drop(MachineSpec::from_toml(&String::from_utf8_lossy(bytes))),
        Kind::Controller => drop(ControllerSpec::from_toml(&String::from_utf8_lossy(bytes))),
        Kind::Model => drop(Bundle::from_bytes(bytes)),
    }
}

fn program(bytes: &[u8]) {
    let program = gcode::parse(bytes);
    let _ = gcode::recognise(&program);
    assert!(gcode::edit(&program, &Edits::default()).is_ok_and(|same| same == bytes), "parsing changed a byte");
    for dialect in [Dialect::Fanuc, Dialect::LinuxCnc, Dialect::Sinumerik] {
        let _ = gcode::interpret(&program, &Options::from(dialect));
    }
}
