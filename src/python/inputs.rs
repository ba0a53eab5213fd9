//! Conversion of inputs: mappings from names to values.

use std::ops::Range;

use numpy::{IntoPyArray as _, PyArrayMethods as _};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyMapping, PyTuple};

use super::convert;
use crate::description::schema::or_meant;
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
    let meant = or_meant(name, names.iter().map(String::as_str));
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

/// The error of inputs of one moment, with what takes rows of them, if these were given for `m` inputs.
pub(super) fn or_rows(
    u: &Bound<'_, PyAny>,
    m: usize,
    error: PyErr,
    instead: impl Fn(Rows) -> String,
) -> PyErr {
    let py = u.py();
    let is_of_value = error.is_instance_of::<PyTypeError>(py) || error.is_instance_of::<PyValueError>(py);
    match Rows::of(u, m).filter(|_| is_of_value) {
        Some(rows) => PyErr::from_type(error.get_type(py), format!("{}; {}", error.value(py), instead(rows))),
        None => error,
    }
}

/// Inputs of several moments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rows {
    /// A row for each moment.
    Array,
    /// A column for each name.
    Mapping,
    /// The pair of times and values.
    Table,
}

impl Rows {
    fn of(u: &Bound<'_, PyAny>, m: usize) -> Option<Self> {
        if let Some(mapping) = mapping_of(u) {
            // An input may be a vector.
            let is_column = |value: Bound<'_, PyAny>| value.len().is_ok_and(|length| length > 3);
            return mapping.values().ok()?.iter().any(is_column).then_some(Self::Mapping);
        }
        if let Ok(pair) = u.cast::<PyTuple>()
            && pair.len() == 2
            && pair.iter().all(|part| convert::is_array(&part))
        {
            return Some(Self::Table);
        }
        match convert::numbers(u, "u", "numbers").ok()?.shape[..] {
            [rows] => rows > 1 && m == 1,
            [rows, _] => rows > 1,
            _ => false,
        }
        .then_some(Self::Array)
    }
}

/// The mapping by which inputs are given by their names, unless they are an array.
pub(super) fn mapping_of<'a, 'py>(u: &'a Bound<'py, PyAny>) -> Option<&'a Bound<'py, PyMapping>> {
    u.cast::<PyDict>().ok().map(|mapping| mapping.as_mapping())
}

/// Sets the inputs that a mapping names; the others stay as they are.
pub(super) fn set_named(
    mapping: &Bound<'_, PyMapping>,
    names: &[String],
    u: &mut [f64],
    place: &str,
) -> PyResult<()> {
    for (of_input, values) in by_name(mapping, names, place, value)? {
        u[of_input].copy_from_slice(&values);
    }
    Ok(())
}

/// Depth of lists in which inputs may be given by names: rows, and control steps of rows.
const LISTS: usize = 2;

/// Whether inputs are given by names: as a mapping, or as lists with mappings among their entries.
pub(super) fn has_names(u: &Bound<'_, PyAny>) -> bool {
    has_names_within(u, LISTS)
}

fn has_names_within(u: &Bound<'_, PyAny>, depth: usize) -> bool {
    let of_entry = |entry: Bound<'_, PyAny>| has_names_within(&entry, depth - 1);
    if depth > 0
        && let Ok(list) = u.cast::<PyList>()
    {
        return list.iter().any(of_entry);
    }
    if depth > 0
        && let Ok(tuple) = u.cast::<PyTuple>()
    {
        return tuple.iter().any(of_entry);
    }
    u.is_instance_of::<PyDict>()
}

/// Inputs of one or many rows with numbers in place of mappings, as an array-like; without names they stay as they are.
///
/// Inputs that a mapping leaves out have the values of `held`, one vector for all rows or one for each. A value of a mapping may have
/// rows, too: its first axes, before that of a vector, become those of the inputs.
pub(super) fn numbered<'py>(
    u: &Bound<'py, PyAny>,
    names: &[String],
    held: &[Vec<f64>],
    place: &str,
) -> PyResult<Bound<'py, PyAny>> {
    if let Some(mapping) = mapping_of(u) {
        return rows_of_names(mapping, names, held, place);
    }
    if !has_names(u) {
        return Ok(u.clone());
    }
    let row = |(i, row): (usize, PyResult<Bound<'py, PyAny>>)| {
        let held = held.get(i).or(held.first()).map_or(&[][..], std::slice::from_ref);
        numbered(&row?, names, held, &format!("{place}[{i}]"))
    };
    let rows: Vec<_> = u.try_iter()?.enumerate().map(row).collect::<PyResult<_>>()?;
    Ok(PyList::new(u.py(), rows)?.into_any())
}

/// The inputs of a mapping whose values may have rows: an array of these rows, whose last axis is that of the inputs.
fn rows_of_names<'py>(
    mapping: &Bound<'py, PyMapping>,
    names: &[String],
    held: &[Vec<f64>],
    place: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let found = by_name(mapping, names, place, rows_of_value)?;
    let mut shape = if held.len() > 1 { vec![held.len()] } else { Vec::new() };
    let with_rows = found.iter().filter(|(_, (_, rows))| !rows.is_empty());
    for (i, (of_input, (_, rows))) in with_rows.enumerate() {
        if i > 0 && *rows != shape {
            let name = &names[of_input.start];
            return Err(PyValueError::new_err(format!(
                "{place}: got rows of shape {rows:?} of '{name}' and of {shape:?} of another input, expected the same of all"
            )));
        }
        shape.clone_from(rows);
    }
    let count: usize = shape.iter().product();
    let of_first_axis: usize = shape.iter().skip(1).product();
    let mut u = Vec::with_capacity(count * names.len());
    for row in 0..count {
        let start = u.len();
        u.extend_from_slice(held.get(row / of_first_axis).or(held.first()).map_or(&[], Vec::as_slice));
        for (of_input, (values, rows)) in &found {
            let first = if rows.is_empty() { 0 } else { row * of_input.len() };
            u[start + of_input.start..start + of_input.end]
                .copy_from_slice(&values[first..first + of_input.len()]);
        }
    }
    shape.push(names.len());
    Ok(u.into_pyarray(mapping.py()).reshape(shape)?.into_any())
}

/// Finite values of an input with this number of entries, and the shape of its rows: none for a single value.
fn rows_of_value(value: &Bound<'_, PyAny>, entries: usize, place: &str) -> PyResult<(Vec<f64>, Vec<usize>)> {
    let convert::Numbers { values, mut shape } = convert::numbers(value, place, "real numbers")?;
    let mut check = Checker::new();
    if entries > 1 && shape.pop() != Some(entries) {
        let expected = format!("{entries} numbers, or rows of them: the input is a vector");
        check.require(false, place, convert::describe(value), &expected);
    }
    match shape.is_empty() && entries == 1 {
        true => check.require(values[0].is_finite(), place, Number(values[0]), "a finite number"),
        false => check.finite(&values, place),
    };
    check.finish().or_raise()?;
    Ok((values, shape))
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
