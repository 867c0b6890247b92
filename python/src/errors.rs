//! Exceptions: the texts are those of the command line.

use pyo3::create_exception;
use pyo3::exceptions::PyException;
use pyo3::prelude::*;

create_exception!(precomp, Error, PyException, "A job that precomp refuses: input or model are not fit for it.");
create_exception!(precomp, UsageError, Error, "An error in the use of precomp, such as an option out of its range.");

/// The exception for an error: [`UsageError`] where the command would end with the status 2, else [`Error`].
pub fn raised(error: anyhow::Error) -> PyErr {
    let text = precomp::text(&error);
    if precomp::status(&error) == 2 { UsageError::new_err(text) } else { Error::new_err(text) }
}

/// A result of the library as one of Python.
pub trait OrRaise<T> {
    /// The value.
    ///
    /// # Errors
    /// The exception for the error.
    fn or_raise(self) -> PyResult<T>;
}

impl<T, E: Into<anyhow::Error>> OrRaise<T> for Result<T, E> {
    fn or_raise(self) -> PyResult<T> {
        self.map_err(|error| raised(error.into()))
    }
}
