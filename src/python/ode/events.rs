//! Event functions from Python.

use std::num::NonZeroUsize;

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use super::super::convert;
use super::function::Function;
use super::system::SharedRaised;
use crate::integrators::ode::{Direction, Event};

/// The events of the argument `events`: a callable or a sequence of callables, with SciPy's attributes
/// `terminal` and `direction`.
pub(super) fn from_python(
    events: &Bound<'_, PyAny>,
    args: Option<&Bound<'_, PyTuple>>,
    raised: &SharedRaised,
) -> PyResult<Vec<Event<'static>>> {
    let of = |index: usize, event: &Bound<'_, PyAny>| {
        from_callable(event, &format!("events[{index}]"), args, raised.clone())
    };
    if events.is_callable() {
        return Ok(vec![of(0, events)?]);
    }
    let wrong = |_| {
        PyTypeError::new_err(format!(
            "events: expected a callable or a list of them, got {}",
            convert::describe(events)
        ))
    };
    // One at a time: the first invalid event ends the iteration, whose length may be unlimited.
    events.try_iter().map_err(wrong)?.enumerate().map(|(index, event)| of(index, &event?)).collect()
}

fn from_callable(
    event: &Bound<'_, PyAny>,
    place: &str,
    args: Option<&Bound<'_, PyTuple>>,
    raised: SharedRaised,
) -> PyResult<Event<'static>> {
    if !event.is_callable() {
        return Err(PyTypeError::new_err(format!(
            "{place}: expected a callable, got {}",
            convert::describe(event)
        )));
    }
    let direction: f64 = match event.getattr_opt("direction")? {
        Some(value) => convert::number(&value, &format!("{place}.direction"))?,
        None => 0.0,
    };
    let direction = if direction > 0.0 {
        Direction::Rising
    } else if direction < 0.0 {
        Direction::Falling
    } else {
        Direction::Any
    };
    let terminal = match event.getattr_opt("terminal")? {
        Some(value) if !value.is_none() => count(&value, place)?,
        _ => None,
    };
    let function = Function::new("event", event, args);
    let name = place.to_owned();
    let evaluate = move |t: f64, y: &[f64]| {
        raised.catch(Python::attach(|py| {
            let value = function.call(py, t, y)?;
            match convert::scalar_or_vector(&value, &name) {
                // An array with one entry is accepted.
                Ok((number, _)) if number.len() == 1 => Ok(number[0]),
                Err(error) if !error.is_instance_of::<PyTypeError>(py) => Err(error),
                _ => Err(PyTypeError::new_err(format!(
                    "{name}: expected a real number, got {}",
                    convert::describe(&value)
                ))),
            }
        }))
    };
    Ok(Event { terminal, ..Event::new(evaluate).direction(direction) })
}

/// A boolean or a positive whole number.
fn count(value: &Bound<'_, PyAny>, place: &str) -> PyResult<Option<NonZeroUsize>> {
    let number: Option<f64> = value.extract().ok();
    match number {
        Some(number) if number >= 0.0 && number.fract() == 0.0 => Ok(NonZeroUsize::new(number as usize)),
        _ => Err(PyValueError::new_err(format!(
            "{place}: The `terminal` attribute of each event must be a boolean or a positive integer, got {value}"
        ))),
    }
}
