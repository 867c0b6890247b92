//! Several runs, and whether they can be used.

use datasets::{Log, ReadOptions, Severity};
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};

use crate::errors::Error;
use crate::log;
use crate::tables::Read;

/// The runs of `frames`, one or a list of them; a frame whose time stamps have gaps is several runs.
pub fn runs(frames: &Bound<'_, PyAny>, options: &ReadOptions) -> PyResult<Vec<Read>> {
    if frames.is_instance_of::<PyList>() || frames.is_instance_of::<PyTuple>() {
        let runs = frames.try_iter()?.enumerate().map(|(index, frame)| log::runs(&frame?, index, options));
        return Ok(runs.collect::<PyResult<Vec<_>>>()?.into_iter().flatten().collect());
    }
    log::runs(frames, 0, options)
}

/// The logs, and what was found in them, a line each. Logs that are refused are an error, as on the command line.
pub fn fit(runs: Vec<Read>) -> PyResult<(Vec<Log>, Vec<String>)> {
    let (mut logs, mut warnings) = (Vec::new(), Vec::new());
    for (log, report) in runs {
        if let Some(reason) = report.of(Severity::Refuse).next() {
            return Err(Error::new_err(format!("{}: {reason}", log.name)));
        }
        warnings.extend(report.findings.iter().map(|finding| format!("{}: {finding}", log.name)));
        logs.push(log);
    }
    Ok((logs, warnings))
}
