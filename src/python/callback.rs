//! Exceptions of Python callbacks and Ctrl-C: kept here while the core unwinds with [`Interrupted`].

use pyo3::prelude::*;

use crate::error::Interrupted;

/// Keeps the exception that stopped a computation, to raise it unchanged afterwards.
#[derive(Debug, Default)]
pub(crate) struct Raised(Option<PyErr>);

impl Raised {
    /// Turns a Python failure into the core's request to stop.
    pub(crate) fn catch<T>(&mut self, result: PyResult<T>) -> Result<T, Interrupted> {
        result.map_err(|error| {
            self.0 = Some(error);
            Interrupted
        })
    }

    /// The exception that was caught, if any.
    pub(crate) fn into_result(self) -> PyResult<()> {
        match self.0 {
            Some(error) => Err(error),
            None => Ok(()),
        }
    }
}
