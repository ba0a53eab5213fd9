//! Exceptions of Python callbacks and Ctrl-C: kept here while the core unwinds with [`Interrupted`].

use std::cell::{Cell, RefCell};

use pyo3::PyClass;
use pyo3::call::PyCallArgs;
use pyo3::exceptions::{PyKeyboardInterrupt, PyRecursionError, PyStopIteration};
use pyo3::prelude::*;

use crate::error::Interrupted;

/// Most computations that wait for Python code in one thread: a function of one that begins the next, and so on. Python counts its
/// own calls, but a thousand of them with a computation in each is more than the stack of a thread. Sixteen are deeper than any
/// shooting method of somebody sane and take a tenth of the smallest usual stack, one megabyte.
const MAX_NESTED: usize = 16;

thread_local! {
    static NESTED: Cell<usize> = const { Cell::new(0) };
}

/// Python code that runs within a computation: counted as long as this lives.
#[derive(Debug)]
pub(crate) struct Nested(());

impl Nested {
    pub(crate) fn enter() -> PyResult<Self> {
        let depth = NESTED.get();
        if depth == MAX_NESTED {
            return Err(PyRecursionError::new_err(format!(
                "a function that lissom calls has called lissom again, {MAX_NESTED} levels deep"
            )));
        }
        NESTED.set(depth + 1);
        Ok(Self(()))
    }
}

impl Drop for Nested {
    fn drop(&mut self) {
        NESTED.set(NESTED.get() - 1);
    }
}

/// Calls a function of the user: every call out of a computation goes through here.
pub(crate) fn call<'py>(
    function: &Bound<'py, PyAny>,
    arguments: impl PyCallArgs<'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let _nested = Nested::enter()?;
    function.call1(arguments)
}

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

    /// The exception that was caught, if any, here or by a function of time.
    pub(crate) fn into_result(self) -> PyResult<()> {
        let of_function = raised_by_function();
        self.0.map_or(of_function, Err)
    }
}

thread_local! {
    /// The exception of a function of time that the core called in this thread: such a function belongs to a model that several threads
    /// may run at once, and so cannot keep it.
    static RAISED_BY_FUNCTION: RefCell<Option<PyErr>> = const { RefCell::new(None) };
}

/// Refuses to call a function of time while the exception of one waits to be raised: the core may be on its way out through code that
/// asks once more, and the first exception is the one that matters.
pub(crate) fn none_is_kept() -> Result<(), Interrupted> {
    let is_kept = RAISED_BY_FUNCTION.with_borrow(Option::is_some);
    if is_kept { Err(Interrupted) } else { Ok(()) }
}

/// Keeps the exception of a function of time.
pub(crate) fn keep(error: PyErr) -> Interrupted {
    RAISED_BY_FUNCTION.replace(Some(error));
    Interrupted
}

/// The exception that a function of time has raised in this thread since this was last asked, if any.
pub(crate) fn raised_by_function() -> PyResult<()> {
    RAISED_BY_FUNCTION.take().map_or(Ok(()), Err)
}

/// What a computation found, or the exception of the function of time that stopped it.
pub(crate) fn or_raised<T>(result: Result<T, Interrupted>) -> PyResult<T> {
    raised_by_function()?;
    Ok(result.expect("only functions of time stop it, and they keep their exceptions"))
}

/// What a callback that watches a computation wants: it goes on unless the callback has returned True or raised StopIteration.
/// Other values, such as arrays, have no meaning.
pub(crate) fn wants_to_stop(py: Python<'_>, returned: PyResult<Bound<'_, PyAny>>) -> PyResult<bool> {
    match returned {
        Ok(value) => Ok(value.extract::<bool>().unwrap_or(false)),
        Err(error) if error.is_instance_of::<PyStopIteration>(py) => Ok(true),
        Err(error) => Err(error),
    }
}

/// The exception that ended a computation, with what was computed as its attribute `result`. Exceptions that take no attributes come
/// without it, and so does one that has such an attribute of its own.
pub(crate) fn with_result<T>(py: Python<'_>, error: PyErr, result: impl FnOnce() -> PyResult<T>) -> PyErr
where
    T: PyClass + Into<PyClassInitializer<T>>,
{
    let exception = error.value(py);
    if exception.hasattr("result").unwrap_or(true) {
        return error;
    }
    let kept = result()
        .and_then(|result| Py::new(py, result))
        .and_then(|result| exception.setattr("result", result));
    match kept {
        Err(failure) if error.is_instance_of::<PyKeyboardInterrupt>(py) => failure,
        _ => error,
    }
}
