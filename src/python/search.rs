//! What searches of models at rest have in common: their arguments, and how they run and stop.

use std::time::Duration;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::background;
use super::callback::{Raised, or_raised, raised_by_function, with_result};
use super::convert;
use super::errors::OrRaise as _;
use super::inputs::or_rows;
use super::model::{Native, PyModel, any_model_of, check_time, model_of};
use super::motion::Ticker;
use crate::analysis::statics::Monitor;
use crate::error::{InvalidInput, Unfinished};

/// The base class of a model.
pub(super) fn base<'a, 'py>(model: &'a Bound<'py, PyAny>) -> PyResult<&'a Bound<'py, PyModel>> {
    model_of(model, "model")
}

/// Values for all inputs of a model.
pub(super) fn inputs_of(model: &Bound<'_, PyAny>, u: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let model = any_model_of(model, "model")?.get();
    let instead = |_| "`lissom.statics_many(model, u)` takes one set of inputs in each row".to_owned();
    model.inputs_of(u).map_err(|error| or_rows(u, model.input_names().len(), error, instead))
}

/// These inputs, or the defaults of a model.
pub(super) fn inputs_or_default(model: &Bound<'_, PyAny>, u: Option<&[f64]>) -> PyResult<Vec<f64>> {
    let model = base(model)?.get();
    Ok(u.map_or_else(|| model.default_inputs(), <[f64]>::to_vec))
}

/// A separate copy of a model, at a time and with these inputs.
pub(super) fn native_with(model: &Bound<'_, PyAny>, t: f64, u: Option<&[f64]>) -> PyResult<Box<dyn Native>> {
    let mut model = base(model)?.get().native();
    check_time(t, model.facts().time_span)?;
    if let Some(u) = u {
        model.set_inputs(u);
    }
    or_raised(model.set_time(t))?;
    if let Some(what) = model.not_finite() {
        return Err(PyValueError::new_err(format!("{what}, expected finite numbers")));
    }
    Ok(model)
}

/// Runs a computation of a model of `n` coordinates without the interpreter, and converts what it found. Ctrl-C and
/// exceptions of functions of time stop it; the exception then has what was found until then as its `result`.
pub(super) fn run<'py, T: Send + 'static, R: IntoPyObject<'py>>(
    py: Python<'py>,
    n: usize,
    search: impl FnOnce(Monitor<'_>) -> Result<Result<T, Unfinished<T>>, InvalidInput> + Send + 'static,
    result: impl FnOnce(T) -> PyResult<R>,
) -> PyResult<R> {
    /// An evaluation of a model of a thousand coordinates, with its decompositions, ends within this time.
    const PATIENCE: Duration = Duration::from_secs(5);
    let (found, raised) = if n >= background::LARGE {
        let ((found, of_function), raised) = background::run_to_check(py, PATIENCE, move |abandoned| {
            let found = search(&mut || abandoned.check());
            // Functions of time keep their exceptions in the thread that called them.
            (found, raised_by_function())
        })?;
        (found, of_function.and(raised))
    } else {
        let mut raised = Raised::default();
        let mut ticker = Ticker::new();
        let found = py.detach(|| {
            search(&mut || {
                raised.none_yet()?;
                if !ticker.tick() {
                    return Ok(());
                }
                raised.catch(Python::attach(|py| py.check_signals()))
            })
        });
        (found, raised.into_result())
    };
    let found = found.or_raise()?.unwrap_or_else(Unfinished::into_inner);
    match raised {
        Ok(()) => result(found),
        Err(error) => Err(with_result(py, error, || result(found))),
    }
}

pub(super) fn count(value: Option<i64>, name: &str, default: usize) -> PyResult<usize> {
    value.map_or(Ok(default), |value| convert::count(value, name))
}
