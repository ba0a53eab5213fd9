//! Conversion of inputs: mappings from names to values.

use std::ops::Range;

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyMapping};

use super::convert;
use crate::description::schema::suggestion;
use crate::error::{Checker, Number, shortened};
use crate::python::errors::OrRaise as _;

/// Indices in u of the input with this name: one entry, or three for a vector.
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

/// Indices of an input in u, and two values for each entry.
pub(super) type Pair = (Range<usize>, [Vec<f64>; 2]);

/// Reads the value of an input with this number of entries.
pub(super) type Read = fn(&Bound<'_, PyAny>, usize, &str) -> PyResult<Vec<f64>>;

/// A finite value: a number, or a vector.
pub(super) fn value(value: &Bound<'_, PyAny>, entries: usize, place: &str) -> PyResult<Vec<f64>> {
    let (values, is_number) = convert::scalar_or_vector(value, place)?;
    let mut check = Checker::new();
    if is_number && entries > 1 {
        let expected = format!("{entries} numbers: the input is a vector");
        check.require(false, place, Number(values[0]), &expected);
    } else if check.length(&values, entries, place) && is_number {
        check.require(values[0].is_finite(), place, Number(values[0]), "a finite number");
    } else {
        check.finite(&values, place);
    }
    check.finish().or_raise()?;
    Ok(values)
}

/// A limit, which may be infinite: a number for all entries, or a vector.
pub(super) fn limit(value: &Bound<'_, PyAny>, entries: usize, place: &str) -> PyResult<Vec<f64>> {
    let (values, is_number) = convert::scalar_or_vector(value, place)?;
    if is_number { Ok(vec![values[0]; entries]) } else { convert::vector_of(value, entries, place) }
}

/// For each name of a mapping its indices in u and both values. No entry may occur twice.
pub(super) fn pairs(
    mapping: &Bound<'_, PyAny>,
    names: &[String],
    place: &str,
    read: Read,
) -> PyResult<Vec<Pair>> {
    let Ok(mapping) = mapping.cast::<PyMapping>() else {
        let found = convert::describe(mapping);
        let expected = "a mapping from names of inputs to pairs";
        return Err(PyTypeError::new_err(format!("{place}: expected {expected}, got {found}")));
    };
    by_name(mapping, names, place, |value, entries, place| pair(value, entries, place, read))
}

/// The mapping by which inputs are given by their names, unless they are an array.
pub(super) fn mapping_of<'a, 'py>(u: &'a Bound<'py, PyAny>) -> Option<&'a Bound<'py, PyMapping>> {
    u.cast::<PyDict>().ok().map(|mapping| mapping.as_mapping())
}

/// Values for all inputs: those that a mapping names, and `u` for the others.
pub(super) fn named(mapping: &Bound<'_, PyMapping>, names: &[String], mut u: Vec<f64>) -> PyResult<Vec<f64>> {
    for (of_input, values) in by_name(mapping, names, "u", value)? {
        u[of_input].copy_from_slice(&values);
    }
    Ok(u)
}

/// For each name of a mapping its indices in u and what its value is read as. No entry may occur twice.
fn by_name<T>(
    mapping: &Bound<'_, PyMapping>,
    names: &[String],
    place: &str,
    read: impl Fn(&Bound<'_, PyAny>, usize, &str) -> PyResult<T>,
) -> PyResult<Vec<(Range<usize>, T)>> {
    let mut found: Vec<((Range<usize>, T), String)> = Vec::new();
    for item in mapping.items()? {
        let (name, value): (Bound<'_, PyAny>, Bound<'_, PyAny>) = item.extract()?;
        let Ok(name) = name.extract::<String>() else {
            let found = convert::describe(&name);
            return Err(PyTypeError::new_err(format!("{place}: expected names of inputs, got {found}")));
        };
        let of_input = entries(names, &name, place)?;
        let overlaps = |((other, _), _): &&((Range<usize>, T), String)| {
            other.start < of_input.end && of_input.start < other.end
        };
        if let Some((_, other)) = found.iter().find(overlaps) {
            let shared = names[of_input].join("', '");
            let message =
                format!("{place}: '{other}' and '{name}' both set '{shared}': give only one of them");
            return Err(PyValueError::new_err(message));
        }
        let place = format!("{place}['{name}']");
        let value = read(&value, of_input.len(), &place)?;
        found.push(((of_input, value), name));
    }
    Ok(found.into_iter().map(|(found, _)| found).collect())
}

/// Two values for an input with this number of entries.
pub(super) fn pair(
    value: &Bound<'_, PyAny>,
    entries: usize,
    place: &str,
    read: Read,
) -> PyResult<[Vec<f64>; 2]> {
    let wrong = || {
        let found = convert::describe(value);
        PyTypeError::new_err(format!("{place}: expected a pair of values, got {found}"))
    };
    let halves: Vec<Bound<'_, PyAny>> =
        value.try_iter().map_err(|_| wrong())?.take(3).collect::<PyResult<_>>()?;
    let [first, second] = halves.as_slice() else { return Err(wrong()) };
    Ok([read(first, entries, &format!("{place}[0]"))?, read(second, entries, &format!("{place}[1]"))?])
}
