//! What a path may be given as: a program, a reference, a test curve.

use std::path::{Path, PathBuf};

use datasets::reference_from_table;
use motion::Axis;
use precomp::read::Source;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyString};

use crate::compensate::{Compensated, Content};
use crate::errors::OrRaise;
use crate::excitation::ExcitationRun;
use crate::log::Log;
use crate::{arrays, tables};

/// Name of a path that has none.
const NAME: &str = "path";

/// The path of `object`: the text or bytes of a program (a text of several lines), the path of a file, `curve:NAME`, a reference as a data
/// frame or as an array of these axes with this period, a log's command, or a compensated path.
pub fn source(object: &Bound<'_, PyAny>, period_s: f64, axes: &[Axis]) -> PyResult<Source> {
    if let Ok(bytes) = object.cast::<PyBytes>() {
        return Ok(Source::of_program(NAME, bytes.as_bytes(), PathBuf::new()));
    }
    if let Ok(text) = object.cast::<PyString>() {
        let text = text.to_cow()?;
        if text.contains('\n') {
            return Ok(Source::of_program(NAME, text.as_bytes(), PathBuf::new()));
        }
    }
    if let Some(path) = tables::path(object)? {
        return Source::open(&path).or_raise();
    }
    if let Ok(log) = object.cast::<Log>() {
        let run = &log.get().run;
        return Ok(Source::of_reference(run.name.clone(), run.reference.clone()));
    }
    if let Ok(run) = object.cast::<ExcitationRun>() {
        let run = run.get();
        return Ok(Source::of_reference(run.name.clone(), run.reference.clone()));
    }
    if let Ok(compensated) = object.cast::<Compensated>() {
        let compensated = compensated.get();
        return Ok(match &compensated.content {
            Content::Text(text) => Source::of_program(compensated.name.clone(), text.clone(), PathBuf::new()),
            Content::Reference(reference) => Source::of_reference(compensated.name.clone(), reference.clone()),
        });
    }
    if let Some(table) = tables::table(object)? {
        let (reference, _) = reference_from_table(Path::new(NAME), &table, Some(period_s)).or_raise()?;
        return Ok(Source::of_reference(NAME, reference));
    }
    let reference = arrays::trajectory(object, period_s, axes)?;
    Ok(Source::of_reference(NAME, reference))
}
