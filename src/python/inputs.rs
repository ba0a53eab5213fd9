//! What Python says of the inputs of a model: mappings from their names to values.

use std::ops::Range;

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyMapping;

use super::convert;
use crate::error::shortened;
use crate::scene::suggestion::suggestion;

/// Where the input of a name stands in u: one entry, or three of a vector.
pub(super) fn entries(names: &[String], name: &str, place: &str) -> PyResult<Range<usize>> {
    if let Some(entry) = names.iter().position(|known| known == name) {
        return Ok(entry..entry + 1);
    }
    if let Some(first) = names.iter().position(|known| known.strip_prefix(name) == Some(".x")) {
        return Ok(first..first + 3);
    }
    let all = names.iter().map(|name| format!("'{name}'")).collect::<Vec<_>>().join(", ");
    let meant = suggestion(name, names.iter().map(String::as_str));
    let meant = meant.map_or_else(String::new, |meant| format!("; did you mean '{meant}'?"));
    let expected = match all.is_empty() {
        true => "nothing: the model has no inputs".to_owned(),
        false => format!("one of the inputs: {all}{meant}"),
    };
    let found = shortened(name);
    Err(PyValueError::new_err(format!("{place}: got '{found}', expected {expected}")))
}

/// Where an input stands in u, and two values for each of its entries.
pub(super) type Pair = (Range<usize>, [Vec<f64>; 2]);

/// For each name of a mapping where it stands in u, and its two values, each with so many numbers.
pub(super) fn pairs(mapping: &Bound<'_, PyAny>, names: &[String], place: &str) -> PyResult<Vec<Pair>> {
    let Ok(mapping) = mapping.cast::<PyMapping>() else {
        let found = convert::describe(mapping);
        let expected = "a mapping from names of inputs to pairs";
        return Err(PyTypeError::new_err(format!("{place}: expected {expected}, got {found}")));
    };
    let mut pairs = Vec::new();
    for item in mapping.items()? {
        let (name, value): (Bound<'_, PyAny>, Bound<'_, PyAny>) = item.extract()?;
        let Ok(name) = name.extract::<String>() else {
            let found = convert::describe(&name);
            return Err(PyTypeError::new_err(format!("{place}: expected names of inputs, got {found}")));
        };
        let of_input = entries(names, &name, place)?;
        let place = format!("{place}['{name}']");
        pairs.push((of_input.clone(), pair(&value, of_input.len(), &place)?));
    }
    Ok(pairs)
}

/// Two numbers, or two vectors of so many; of vectors a number stands for all their entries.
pub(super) fn pair(value: &Bound<'_, PyAny>, entries: usize, place: &str) -> PyResult<[Vec<f64>; 2]> {
    let wrong = || {
        let found = convert::describe(value);
        PyTypeError::new_err(format!("{place}: expected a pair of values, got {found}"))
    };
    let halves: Vec<Bound<'_, PyAny>> =
        value.try_iter().map_err(|_| wrong())?.take(3).collect::<PyResult<_>>()?;
    let [first, second] = halves.as_slice() else { return Err(wrong()) };
    let half = |value: &Bound<'_, PyAny>, k: usize| {
        let place = format!("{place}[{k}]");
        let (values, is_number) = convert::scalar_or_vector(value, &place)?;
        if is_number { Ok(vec![values[0]; entries]) } else { convert::vector_of(value, entries, &place) }
    };
    Ok([half(first, 0)?, half(second, 1)?])
}
