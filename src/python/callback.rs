//! Exceptions of Python callbacks and Ctrl-C, stored here while the core unwinds with [`Interrupted`].

use std::cell::{Cell, RefCell};

use pyo3::IntoPyObjectExt;
use pyo3::call::PyCallArgs;
use pyo3::exceptions::{PyKeyboardInterrupt, PyRecursionError, PyStopIteration, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::error::Interrupted;

/// Maximum number of nested computations in one thread: a function called by one computation starts the next,
/// and so on. Python limits the depth of its own calls, but a thousand of them with a computation in each
/// would overflow the stack of a thread. Sixteen levels exceed any reasonable shooting method and use a tenth
/// of the smallest common stack size, one megabyte.
const MAX_NESTED: usize = 16;

thread_local! {
    static NESTED: Cell<usize> = const { Cell::new(0) };
}

/// Counts Python code that runs within a computation, for the lifetime of this value.
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

/// How a user function is called: its name, its arguments such as `t, q, v`, and how many of the user's own `args` follow them, or `None`
/// where a function takes none of these.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Form<'a> {
    pub(crate) name: &'a str,
    pub(crate) arguments: &'a str,
    pub(crate) args: Option<usize>,
}

impl Form<'_> {
    /// The error of a function that cannot be called like this; `None` if it can, as far as its signature is known.
    pub(crate) fn refusal(&self, function: &Bound<'_, PyAny>) -> Option<PyErr> {
        let (py, count) = (function.py(), self.args.unwrap_or(0));
        let signature = py.import("inspect").ok()?.call_method1("signature", (function,)).ok()?;
        let known = self.arguments.split(", ").count();
        let own = (0..count).map(|i| format!("arg{i}"));
        let arguments: Vec<_> = self.arguments.split(", ").map(str::to_owned).chain(own).collect();
        let error = signature.call_method1("bind", PyTuple::new(py, &arguments).ok()?).err()?;
        if !error.is_instance_of::<PyTypeError>(py) {
            return None;
        }
        let (name, arguments) = (self.name, arguments.join(", "));
        let is_word = name.chars().all(|letter| letter.is_alphanumeric() || letter == '_');
        let defined = if is_word { name } else { "f" };
        let takes_more =
            signature.getattr("parameters").and_then(|all| all.len()).is_ok_and(|all| all > count + known);
        let others = match self.args {
            Some(0) if takes_more => ", or give the others as `args=(...)`",
            _ => "",
        };
        Some(PyTypeError::new_err(format!(
            "{name}: is called as {defined}({arguments}), but takes {}: write `def {defined}({arguments}): ...`{others}",
            signature.str().ok()?
        )))
    }
}

/// Calls a user function; all calls out of a computation go through this function. A function that takes other arguments is told so;
/// its own exceptions are returned unchanged.
pub(crate) fn call<'py>(
    form: Form<'_>,
    function: &Bound<'py, PyAny>,
    arguments: impl PyCallArgs<'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let _nested = Nested::enter()?;
    function.call1(arguments).map_err(|error| {
        let py = function.py();
        // Without a traceback the call itself has failed.
        let is_of_call = error.is_instance_of::<PyTypeError>(py) && error.traceback(py).is_none();
        is_of_call.then(|| form.refusal(function)).flatten().unwrap_or(error)
    })
}

/// Stores the exception that stopped a computation, to raise it unchanged afterwards.
#[derive(Debug, Default)]
pub(crate) struct Raised(Option<PyErr>);

impl Raised {
    /// Converts a Python exception to a request to stop the core.
    pub(crate) fn catch<T>(&mut self, result: PyResult<T>) -> Result<T, Interrupted> {
        result.map_err(|error| {
            self.0 = Some(error);
            Interrupted
        })
    }

    /// Stops a computation after an exception, even if it has missed the request to stop.
    pub(crate) fn none_yet(&self) -> Result<(), Interrupted> {
        if self.0.is_some() { Err(Interrupted) } else { Ok(()) }
    }

    /// The stored exception, if any, of this value or of a function of time.
    pub(crate) fn into_result(self) -> PyResult<()> {
        let of_function = raised_by_function();
        self.0.map_or(of_function, Err)
    }
}

thread_local! {
    /// Exception of a function of time called by the core in this thread. The function belongs to a model
    /// that several threads may run at once, and therefore cannot store the exception itself.
    static RAISED_BY_FUNCTION: RefCell<Option<PyErr>> = const { RefCell::new(None) };
}

/// Rejects calls of functions of time while an exception of one is stored: the core may call another one
/// while it unwinds, and only the first exception should be raised.
pub(crate) fn none_is_kept() -> Result<(), Interrupted> {
    let is_kept = RAISED_BY_FUNCTION.with_borrow(Option::is_some);
    if is_kept { Err(Interrupted) } else { Ok(()) }
}

/// Stores the exception of a function of time.
pub(crate) fn keep(error: PyErr) -> Interrupted {
    RAISED_BY_FUNCTION.replace(Some(error));
    Interrupted
}

/// Takes the exception stored in this thread by a function of time, if any.
pub(crate) fn raised_by_function() -> PyResult<()> {
    RAISED_BY_FUNCTION.take().map_or(Ok(()), Err)
}

/// The result of a computation, or the exception of the function of time that stopped it.
pub(crate) fn or_raised<T>(result: Result<T, Interrupted>) -> PyResult<T> {
    raised_by_function()?;
    Ok(result.expect("only functions of time stop it, and they keep their exceptions"))
}

/// Whether a callback requests a stop, by returning True or raising StopIteration. Other values, such as
/// arrays, are ignored.
pub(crate) fn requests_stop(py: Python<'_>, returned: PyResult<Bound<'_, PyAny>>) -> PyResult<bool> {
    match returned {
        Ok(value) => Ok(value.extract::<bool>().unwrap_or(false)),
        Err(error) if error.is_instance_of::<PyStopIteration>(py) => Ok(true),
        Err(error) => Err(error),
    }
}

/// The exception that ended a computation, with the partial result as its attribute `result`. The attribute
/// is omitted if the exception does not accept attributes or already has this one.
pub(crate) fn with_result<'py, T: IntoPyObject<'py>>(
    py: Python<'py>,
    error: PyErr,
    result: impl FnOnce() -> PyResult<T>,
) -> PyErr {
    let exception = error.value(py);
    if exception.hasattr("result").unwrap_or(true) {
        return error;
    }
    let kept = result()
        .and_then(|result| result.into_bound_py_any(py))
        .and_then(|result| exception.setattr("result", result));
    match kept {
        Err(failure) if error.is_instance_of::<PyKeyboardInterrupt>(py) => failure,
        _ => error,
    }
}
