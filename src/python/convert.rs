//! Conversion of arrays, with messages that name the argument.

use numpy::{PyArray2, PyArrayDyn, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods, ToPyArray};
use pyo3::PyTypeCheck;
use pyo3::exceptions::{PyOverflowError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyBool, PyBytes, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple, PyType};

use super::callback::Nested;
use crate::description::rod::diagonal;
use crate::error::{Checker, Number};
use crate::numerics::lie::Rotation;
use crate::numerics::linalg::Matrix;
use crate::python::errors::OrRaise as _;
use crate::robot::Pose;

/// Real numbers in row-major order, with the shape of the input.
pub(crate) struct Numbers {
    pub(crate) values: Vec<f64>,
    pub(crate) shape: Vec<usize>,
}

/// Maximum nesting of arrays in NumPy.
const MAX_DIMENSIONS: usize = 64;

/// Converts everything from which NumPy can create an array of doubles: lists, arrays of any layout, byte
/// order and numeric type, subclasses, objects with `__array__`. Always makes a copy, so that foreign memory
/// layouts do not matter. Other values are rejected with their place: NumPy itself would convert booleans,
/// strings, dates and None, discard imaginary parts, and ignore masks.
///
/// `expected` describes the expected value in messages.
pub(crate) fn numbers(value: &Bound<'_, PyAny>, name: &str, expected: &str) -> PyResult<Numbers> {
    if let Some(array) = plain(value) {
        return Ok(Numbers { values: array.to_vec()?, shape: array.shape().to_vec() });
    }
    if let Some(values) = plain_numbers(value) {
        return Ok(Numbers { shape: vec![values.len()], values });
    }
    // `__array__` and similar methods are user code.
    let _nested = Nested::enter()?;
    let py = value.py();
    let wrong = || {
        let instead = coordinates_in(value);
        PyTypeError::new_err(format!("{name}: expected {expected}, got {}{instead}", describe(value)))
    };
    let entry = |place: &[usize]| {
        let place: Vec<String> = place.iter().map(|i| format!("[{i}]")).collect();
        format!("{name}{}", place.concat())
    };
    check_numbers(value, &mut Vec::new()).map_err(|refusal| match refusal {
        Refused::Failed(error) => error,
        Refused::Whole => wrong(),
        Refused::TooLarge(place) => beyond_doubles(&entry(&place)),
        Refused::Entry(place, found) => {
            PyTypeError::new_err(format!("{}: expected a real number, got {found}", entry(&place)))
        }
    })?;
    let options = PyDict::new(py);
    options.set_item("dtype", numpy::dtype::<f64>(py))?;
    options.set_item("order", "C")?;
    // Ragged lists, and numbers of other types beyond the range of doubles.
    let copy = py.import("numpy")?.call_method("array", (value,), Some(&options)).map_err(|error| {
        if error.is_instance_of::<PyOverflowError>(py) {
            return beyond_doubles(name);
        }
        let is_of_values =
            error.is_instance_of::<PyValueError>(py) || error.is_instance_of::<PyTypeError>(py);
        if is_of_values { wrong() } else { error }
    })?;
    let array = plain(&copy).ok_or_else(wrong)?;
    Ok(Numbers { values: array.to_vec()?, shape: array.shape().to_vec() })
}

/// What to write for a result or a simulation in place of its coordinates.
fn coordinates_in(value: &Bound<'_, PyAny>) -> &'static str {
    let dimensions = value.getattr("q").and_then(|q| q.getattr("ndim")?.extract::<usize>());
    match dimensions {
        Ok(1) => "; its coordinates are its `q`",
        Ok(2) => "; its last coordinates are its `q[-1]`",
        _ => "",
    }
}

/// The entries of a tuple or list of floats and integers, which need no NumPy: short ones are the most common arguments.
fn plain_numbers(value: &Bound<'_, PyAny>) -> Option<Vec<f64>> {
    let entry = |entry: Bound<'_, PyAny>| match entry.cast_exact::<PyFloat>() {
        Ok(number) => Some(number.value()),
        Err(_) => entry.cast_exact::<PyInt>().ok()?.extract().ok(),
    };
    if let Ok(tuple) = value.cast_exact::<PyTuple>() {
        return tuple.iter().map(entry).collect();
    }
    value.cast_exact::<PyList>().ok()?.iter().map(entry).collect()
}

/// The value if it is a plain, aligned array of native doubles in C order, which can be read directly.
pub(crate) fn plain<'a, 'py>(value: &'a Bound<'py, PyAny>) -> Option<&'a Bound<'py, PyArrayDyn<f64>>> {
    // Subclasses may have a mask.
    value.cast_exact::<PyUntypedArray>().ok()?;
    let array = value.cast::<PyArrayDyn<f64>>().ok()?;
    (array.is_c_contiguous() && array.is_aligned()).then_some(array)
}

/// Reason why a value is rejected.
enum Refused {
    /// The whole value, with its description.
    Whole,
    /// One entry.
    Entry(Vec<usize>, String),
    /// An entry that no double can hold.
    TooLarge(Vec<usize>),
    /// The check itself failed.
    Failed(PyErr),
}

impl From<PyErr> for Refused {
    fn from(error: PyErr) -> Self {
        Self::Failed(error)
    }
}

/// Searches for entries that are not real numbers.
fn check_numbers(value: &Bound<'_, PyAny>, place: &mut Vec<usize>) -> Result<(), Refused> {
    // The common entries of lists.
    if value.is_exact_instance_of::<PyFloat>() {
        return Ok(());
    }
    if value.is_exact_instance_of::<PyInt>() {
        return value.extract::<f64>().map(drop).map_err(|_| Refused::TooLarge(place.clone()));
    }
    if let Ok(list) = value.cast::<PyList>() {
        return check_entries(list.iter(), place);
    }
    if let Ok(tuple) = value.cast::<PyTuple>() {
        return check_entries(tuple.iter(), place);
    }
    let refused = || match place.is_empty() {
        true => Refused::Whole,
        false => Refused::Entry(place.clone(), describe_entry(value)),
    };
    if is_masked(value)? {
        return Err(refused());
    }
    match kind_of(value) {
        Some('f' | 'i' | 'u') => return Ok(()),
        Some('O') => {}
        None if is_number(value)? => return Ok(()),
        // Text is a sequence of text.
        None if !value.is_instance_of::<PyString>() && !value.is_instance_of::<PyBytes>() => {}
        _ => return Err(refused()),
    }
    let array = value.py().import("numpy")?.call_method1("asarray", (value,)).map_err(|error| {
        if error.is_instance_of::<PyValueError>(value.py()) { refused() } else { Refused::Failed(error) }
    })?;
    match kind_of(&array) {
        Some('f' | 'i' | 'u') => Ok(()),
        Some('O') => {
            let entries = array.call_method0("tolist")?;
            match entries.cast::<PyList>() {
                Ok(entries) => check_entries(entries.iter(), place),
                // An entry of an array without dimensions, or a value without an array type in NumPy.
                Err(_) if is_number(&entries)? => Ok(()),
                Err(_) => Err(refused()),
            }
        }
        _ => Err(refused()),
    }
}

fn check_entries<'py>(
    entries: impl Iterator<Item = Bound<'py, PyAny>>,
    place: &mut Vec<usize>,
) -> Result<(), Refused> {
    if place.len() == MAX_DIMENSIONS {
        return Err(Refused::Whole);
    }
    for (i, entry) in entries.enumerate() {
        place.push(i);
        check_numbers(&entry, place)?;
        place.pop();
    }
    Ok(())
}

/// NumPy's letter for the kind of an array or scalar.
pub(crate) fn kind_of(value: &Bound<'_, PyAny>) -> Option<char> {
    let kind = value.getattr("dtype").ok()?.getattr("kind").ok()?;
    kind.extract().ok()
}

/// Whether a value has entries and is not a number.
pub(crate) fn is_array(value: &Bound<'_, PyAny>) -> bool {
    // NumPy scalars have `__array__` too, but no dimensions.
    let is_scalar = || value.getattr("ndim").is_ok_and(|ndim| ndim.eq(0).unwrap_or(false));
    value.len().is_ok() || (value.hasattr("__array__").unwrap_or(false) && !is_scalar())
}

/// Whether a value other than an array is a number: fractions and decimals are, booleans are not.
fn is_number(value: &Bound<'_, PyAny>) -> PyResult<bool> {
    if value.is_instance_of::<PyBool>() || value.hasattr("__array__")? {
        return Ok(false);
    }
    Ok(value.hasattr("__float__")? || value.hasattr("__index__")?)
}

fn is_masked(value: &Bound<'_, PyAny>) -> PyResult<bool> {
    static MASKED_ARRAY: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    // Avoids the import for other values.
    if !value.is_instance_of::<PyUntypedArray>() {
        return Ok(false);
    }
    value.is_instance(MASKED_ARRAY.import(value.py(), "numpy.ma", "MaskedArray")?)
}

/// Refusal of a number that no double can hold.
fn beyond_doubles(name: &str) -> PyErr {
    PyValueError::new_err(format!(
        "{name}: got a number beyond 1.8e308, the largest double, expected one that doubles can hold"
    ))
}

/// A number.
pub(crate) fn number(value: &Bound<'_, PyAny>, name: &str) -> PyResult<f64> {
    // The common case.
    if let Ok(number) = value.cast::<PyFloat>() {
        return Ok(number.value());
    }
    // Arrays with one entry would be accepted too.
    let dimensions = value.getattr("ndim").and_then(|ndim| ndim.extract::<usize>());
    let is_one = matches!(dimensions, Ok(0) | Err(_)) && !is_masked(value)?;
    let is_one = is_one
        && match kind_of(value) {
            Some('f' | 'i' | 'u') => true,
            Some(_) => false,
            None => is_number(value)?,
        };
    if is_one {
        return value.extract().map_err(|error: PyErr| {
            if error.is_instance_of::<PyOverflowError>(value.py()) { beyond_doubles(name) } else { error }
        });
    }
    Err(PyTypeError::new_err(format!("{name}: expected a real number, got {}", describe(value))))
}

/// A number, or `None` if the value is something else that may be allowed in its place.
pub(crate) fn number_if_one(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Option<f64>> {
    match number(value, name) {
        Ok(number) => Ok(Some(number)),
        Err(error) if error.is_instance_of::<PyTypeError>(value.py()) => Ok(None),
        Err(error) => Err(error),
    }
}

/// A whole number of 64 bits. Booleans are rejected, although they are integers in Python.
pub(crate) fn whole(value: &Bound<'_, PyAny>, name: &str) -> PyResult<i64> {
    let py = value.py();
    let wrong = || PyTypeError::new_err(format!("{name}: expected a whole number, got {}", describe(value)));
    if value.is_instance_of::<PyBool>() || kind_of(value).is_some_and(|kind| !"iu".contains(kind)) {
        return Err(wrong());
    }
    value.extract().map_err(|error: PyErr| {
        if error.is_instance_of::<PyOverflowError>(py) {
            return PyValueError::new_err(format!(
                "{name}: got a number beyond 2^63, expected a whole number that 64 bits can hold"
            ));
        }
        if error.is_instance_of::<PyTypeError>(py) { wrong() } else { error }
    })
}

/// True or False.
pub(crate) fn flag(value: &Bound<'_, PyAny>, name: &str) -> PyResult<bool> {
    value
        .extract()
        .map_err(|_| PyTypeError::new_err(format!("{name}: expected True or False, got {}", describe(value))))
}

/// A text.
pub(crate) fn text<'a>(value: &'a Bound<'_, PyAny>, name: &str) -> PyResult<&'a str> {
    let text = value.cast::<PyString>().map_err(|_| {
        // A part in place of its name.
        let is_named = value.getattr("name").is_ok_and(|name| name.is_instance_of::<PyString>());
        let hint = if is_named { "; its `name` is one" } else { "" };
        PyTypeError::new_err(format!("{name}: expected a str, got {}{hint}", describe(value)))
    })?;
    text.to_str().map_err(|_| {
        PyValueError::new_err(format!(
            "{name}: got a str with a lone surrogate, expected one that UTF-8 can encode"
        ))
    })
}

/// An object of a class; `expected` names it.
pub(crate) fn instance<'a, 'py, T: PyTypeCheck>(
    value: &'a Bound<'py, PyAny>,
    name: &str,
    expected: &str,
) -> PyResult<&'a Bound<'py, T>> {
    value
        .cast::<T>()
        .map_err(|_| PyTypeError::new_err(format!("{name}: expected {expected}, got {}", describe(value))))
}

/// A function.
pub(crate) fn function<'a, 'py>(value: &'a Bound<'py, PyAny>, name: &str) -> PyResult<&'a Bound<'py, PyAny>> {
    if value.is_callable() {
        return Ok(value);
    }
    Err(PyTypeError::new_err(format!("{name}: expected a function, got {}", describe(value))))
}

const VECTOR: &str = "a one-dimensional array of real numbers";

/// A vector from an array-like of one dimension.
pub(crate) fn vector(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec<f64>> {
    let Numbers { values, shape } = numbers(value, name, VECTOR)?;
    match shape.len() {
        1 => Ok(values),
        _ => Err(not_a_vector(value, name, (VECTOR, None), &Numbers { values, shape })),
    }
}

/// The error of an array-like that is no vector, or none of `n` entries: its shape, and what in it is one.
fn not_a_vector(
    value: &Bound<'_, PyAny>,
    name: &str,
    (expected, n): (&str, Option<usize>),
    found: &Numbers,
) -> PyErr {
    let is_size = |size: usize| n.is_none_or(|n| n == size);
    let instead = match (&found.shape[..], &found.values[..]) {
        ([], &[number]) if is_size(1) => format!("; a vector of this number is [{}]", Number(number)),
        (&[1, size], _) if is_size(size) => format!("; its single row, of shape ({size},), is one"),
        _ => String::new(),
    };
    let of_list = value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>();
    let sizes: Vec<_> = found.shape.iter().map(ToString::to_string).collect();
    let shape = if of_list { format!(" of shape ({})", sizes.join(", ")) } else { String::new() };
    PyTypeError::new_err(format!("{name}: expected {expected}, got {}{shape}{instead}", describe(value)))
}

/// A vector from an array-like, or from a single number, and which of these it was.
pub(crate) fn scalar_or_vector(value: &Bound<'_, PyAny>, name: &str) -> PyResult<(Vec<f64>, bool)> {
    if let Ok(number) = value.cast::<PyFloat>() {
        return Ok((vec![number.value()], true));
    }
    let Numbers { values, shape } = numbers(value, name, VECTOR)?;
    match shape.len() {
        0 | 1 => Ok((values, shape.is_empty())),
        _ => Err(PyTypeError::new_err(format!("{name}: expected {VECTOR}, got {}", describe(value)))),
    }
}

/// A vector of exactly `n` entries.
pub(crate) fn vector_of(value: &Bound<'_, PyAny>, n: usize, name: &str) -> PyResult<Vec<f64>> {
    if let Some(array) = plain(value)
        && array.shape() == [n]
    {
        return Ok(array.to_vec()?);
    }
    let expected = format!("a one-dimensional array of {n} real number{}", if n == 1 { "" } else { "s" });
    let Numbers { values, shape } = numbers(value, name, &expected)?;
    match shape.len() {
        1 => of_length(values, n, name),
        _ => Err(not_a_vector(value, name, (&expected, Some(n)), &Numbers { values, shape })),
    }
}

fn of_length(vector: Vec<f64>, n: usize, name: &str) -> PyResult<Vec<f64>> {
    if vector.len() == n {
        Ok(vector)
    } else {
        Err(PyValueError::new_err(format!("{name}: expected {n} values, got {}", vector.len())))
    }
}

/// A vector of exactly `n` finite entries.
pub(crate) fn finite_vector_of(value: &Bound<'_, PyAny>, n: usize, name: &str) -> PyResult<Vec<f64>> {
    finite(vector_of(value, n, name)?, name)
}

fn finite(vector: Vec<f64>, name: &str) -> PyResult<Vec<f64>> {
    let mut checker = Checker::new();
    checker.finite(&vector, name);
    checker.finish().or_raise()?;
    Ok(vector)
}

/// Reads a vector of finite entries into `out`.
pub(crate) fn finite_vector_into(value: &Bound<'_, PyAny>, out: &mut [f64], name: &str) -> PyResult<()> {
    // Called in every step of a simulation.
    if let Some(array) = plain(value)
        && array.shape() == [out.len()]
        && let Ok(values) = array.try_readonly()
        && values.as_slice()?.iter().all(|x| x.is_finite())
    {
        out.copy_from_slice(values.as_slice()?);
        return Ok(());
    }
    out.copy_from_slice(&finite_vector_of(value, out.len(), name)?);
    Ok(())
}

/// One vector of `n` finite entries, or the rows of an array, and the number of rows.
pub(crate) fn finite_rows_of(
    value: &Bound<'_, PyAny>,
    n: usize,
    name: &str,
) -> PyResult<(Vec<f64>, Option<usize>)> {
    const EXPECTED: &str = "an array of real numbers, of one or two dimensions";
    let Numbers { values, shape } = numbers(value, name, EXPECTED)?;
    match shape[..] {
        [_] => Ok((finite(of_length(values, n, name)?, name)?, None)),
        [rows, columns] if columns == n => {
            if let Some(index) = values.iter().position(|x| !x.is_finite()) {
                let (i, j, x) = (index / n, index % n, values[index]);
                let message = format!("{name}[{i}, {j}]: got {x}, expected a finite number");
                return Err(PyValueError::new_err(message));
            }
            Ok((values, Some(rows)))
        }
        [rows, columns] => {
            Err(PyValueError::new_err(format!("{name}: expected shape (k, {n}), got ({rows}, {columns})")))
        }
        _ => Err(PyTypeError::new_err(format!("{name}: expected {EXPECTED}, got {}", describe(value)))),
    }
}

const MATRIX: &str = "a two-dimensional array of real numbers";

/// A matrix of exactly `shape` (rows, columns).
pub(crate) fn matrix_of(value: &Bound<'_, PyAny>, shape: (usize, usize), name: &str) -> PyResult<Matrix> {
    let found = numbers(value, name, MATRIX)?;
    if found.shape.len() != 2 {
        return Err(PyTypeError::new_err(format!("{name}: expected {MATRIX}, got {}", describe(value))));
    }
    found.matrix(shape, name)
}

impl Numbers {
    /// As a matrix of exactly `shape` (rows, columns).
    pub(crate) fn matrix(&self, shape: (usize, usize), name: &str) -> PyResult<Matrix> {
        match self.shape[..] {
            [rows, columns] if (rows, columns) == shape => {
                Ok(Matrix::from_row_slice(rows, columns, &self.values))
            }
            [rows, columns] => Err(PyValueError::new_err(format!(
                "{name}: expected shape ({}, {}), got ({rows}, {columns})",
                shape.0, shape.1
            ))),
            _ => Err(PyTypeError::new_err(format!(
                "{name}: expected {MATRIX}, got {} dimensions",
                self.shape.len()
            ))),
        }
    }
}

/// A NumPy array of shape (rows, columns) in C order.
pub(crate) fn matrix_out<'py>(py: Python<'py>, matrix: &Matrix) -> Bound<'py, PyArray2<f64>> {
    // Column-major storage of the transpose is C order of the matrix.
    let transposed = matrix.transpose();
    numpy::ndarray::ArrayView2::from_shape(matrix.shape(), transposed.as_slice())
        .expect("a matrix has rows x columns entries")
        .to_pyarray(py)
}

/// A non-negative number; negative ones are rejected with the argument's name.
pub(crate) fn count(number: i64, name: &str) -> PyResult<usize> {
    usize::try_from(number)
        .map_err(|_| PyValueError::new_err(format!("{name}: got {number}, expected a whole number >= 0")))
}

/// The limit from the argument `max_steps`; unlimited by default.
pub(crate) fn step_limit(max_steps: Option<i64>) -> PyResult<usize> {
    max_steps.map_or(Ok(usize::MAX), |limit| count(limit, "max_steps"))
}

/// Description of a value for messages: shape and dtype, or type.
pub(crate) fn describe(value: &Bound<'_, PyAny>) -> String {
    if let Ok(class) = value.cast::<PyType>() {
        return class.name().map_or_else(|_| "a class".to_owned(), |name| format!("the class {name}"));
    }
    let attribute = |name: &str| value.getattr(name).and_then(|a| a.str()).map(|s| s.to_string()).ok();
    match (attribute("shape"), attribute("dtype")) {
        (Some(shape), Some(dtype)) => {
            let masked = if is_masked(value).unwrap_or(false) { "a masked" } else { "an" };
            format!("{masked} array of shape {shape} and dtype {dtype}")
        }
        _ => value.get_type().name().map_or_else(|_| "an unknown type".to_owned(), |name| name.to_string()),
    }
}

/// Description of an entry for messages: its text if short.
pub(crate) fn describe_entry(value: &Bound<'_, PyAny>) -> String {
    /// Length in bytes.
    const SHORT: usize = 40;
    match value.repr().map(|text| text.to_string()) {
        Ok(text) if text.len() <= SHORT && !value.is_instance_of::<PyUntypedArray>() => text,
        _ => describe(value),
    }
}

/// A vector of a fixed number of entries.
pub(crate) fn array_of<const N: usize>(value: &Bound<'_, PyAny>, name: &str) -> PyResult<[f64; N]> {
    Ok(vector_of(value, N, name)?.try_into().expect("vector_of returns exactly N values"))
}

/// Conversions for classes written in Python.
pub(crate) mod of_python {
    use super::*;

    #[pyfunction]
    pub(crate) fn as_number(value: &Bound<'_, PyAny>, name: &str) -> PyResult<f64> {
        number(value, name)
    }

    #[pyfunction]
    pub(crate) fn as_whole(value: &Bound<'_, PyAny>, name: &str) -> PyResult<i64> {
        whole(value, name)
    }

    #[pyfunction]
    pub(crate) fn as_flag(value: &Bound<'_, PyAny>, name: &str) -> PyResult<bool> {
        flag(value, name)
    }

    #[pyfunction]
    pub(crate) fn as_text(value: &Bound<'_, PyAny>, name: &str) -> PyResult<String> {
        text(value, name).map(str::to_owned)
    }
}

/// A square matrix of `N` rows, or its diagonal.
pub(crate) fn symmetric_of<const N: usize>(value: &Bound<'_, PyAny>, name: &str) -> PyResult<[[f64; N]; N]> {
    let of_another_size = |error: PyErr| {
        if error.is_instance_of::<PyTypeError>(value.py()) {
            return error;
        }
        let found = describe(value);
        PyValueError::new_err(format!("{name}: expected shape ({N},) or ({N}, {N}), got {found}"))
    };
    if let Some(number) = number_if_one(value, name)? {
        let found = describe(value);
        let all = match N {
            // Their units differ.
            6 => "they are GJ, EI_y, EI_z, EA, GA_y and GA_z".to_owned(),
            _ => format!("equal ones are ({number},) * {N}"),
        };
        return Err(PyTypeError::new_err(format!(
            "{name}: expected shape ({N},) or ({N}, {N}), got {found}; {all}"
        )));
    }
    match matrix_of(value, (N, N), name) {
        Ok(matrix) => Ok(std::array::from_fn(|i| std::array::from_fn(|j| matrix[(i, j)]))),
        // Two dimensions, but another shape.
        Err(error) if error.is_instance_of::<PyValueError>(value.py()) => Err(of_another_size(error)),
        Err(_) => array_of(value, name).map(diagonal).map_err(of_another_size),
    }
}

/// Homogeneous matrix of a pose, row by row.
pub(crate) fn homogeneous(pose: &Pose) -> [f64; 16] {
    let Pose { rotation: Rotation { x, y, z }, position: p } = *pose;
    let rows = [x.x, y.x, z.x, p.x, x.y, y.y, z.y, p.y, x.z, y.z, z.z, p.z];
    let mut matrix = [0.0; 16];
    matrix[..12].copy_from_slice(&rows);
    matrix[15] = 1.0;
    matrix
}
