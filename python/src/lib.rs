//! `precomp` for Python: the module `precomp._precomp`.
//!
//! The package calls the library as the command line does: the same log, seed and program give the same bytes. Options are those of the
//! commands, read by the same parser; paths, machines and models are read by the same functions, so that errors have the same texts.

mod arrays;
mod arrow;
mod compare;
mod compensate;
mod contour;
mod errors;
mod excitation;
mod excite;
mod frames;
mod json;
mod laws;
mod learn;
mod log;
mod machine;
mod measure;
mod measurement;
mod model;
mod options;
mod path;
mod progress;
mod report;
mod run;
mod tables;
mod train;

use std::ffi::OsString;
use std::io::Write;

use pyo3::prelude::*;

/// Runs the command line `arguments`, of which the first is the name of the program; returns its exit status.
#[pyfunction]
fn main(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| {
        let status = precomp::main(arguments);
        // A closed pipe leaves nothing to report to.
        let _ = std::io::stdout().flush();
        status
    })
}

/// The compiled part of `precomp`.
#[pymodule]
fn _precomp(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    models::keep_memory();
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("Error", py.get_type::<errors::Error>())?;
    module.add("UsageError", py.get_type::<errors::UsageError>())?;
    module.add_class::<log::Log>()?;
    module.add_class::<machine::MachineSpec>()?;
    module.add_class::<machine::SimulatedMachine>()?;
    module.add_class::<machine::LearnedMachine>()?;
    module.add_class::<model::Model>()?;
    module.add_class::<run::Run>()?;
    module.add_class::<compensate::Compensated>()?;
    module.add_class::<measurement::Measurement>()?;
    module.add_class::<excitation::Excitation>()?;
    module.add_class::<excitation::ExcitationRun>()?;
    module.add_class::<compare::Comparison>()?;
    module.add_class::<learn::Learned>()?;
    module.add_class::<learn::Iteration>()?;
    module.add_function(wrap_pyfunction!(main, module)?)?;
    module.add_function(wrap_pyfunction!(train::train, module)?)?;
    module.add_function(wrap_pyfunction!(measure::measure, module)?)?;
    module.add_function(wrap_pyfunction!(excite::excite, module)?)?;
    module.add_function(wrap_pyfunction!(excite::record, module)?)?;
    module.add_function(wrap_pyfunction!(run::simulate, module)?)?;
    module.add_function(wrap_pyfunction!(compare::compare, module)?)?;
    module.add_function(wrap_pyfunction!(learn::learn, module)?)?;
    Ok(())
}
