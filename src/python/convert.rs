//! Arrays in and out, with messages that name the argument.

use numpy::{AllowTypeChange, PyArray1, PyArray2, PyArrayLike1, PyArrayLike2, PyArrayMethods, ToPyArray};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyComplex, PyString};

use crate::error::{Checker, InvalidInput};
use crate::linalg::Matrix;
use crate::rod::diagonal;

impl From<InvalidInput> for PyErr {
    fn from(error: InvalidInput) -> Self {
        PyValueError::new_err(error.to_string())
    }
}

/// A vector from anything that NumPy turns into a one-dimensional array of doubles (lists, float32, strided views).
pub(crate) fn vector(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec<f64>> {
    let wrong = || {
        PyTypeError::new_err(format!(
            "{name}: expected a one-dimensional array of real numbers, got {}",
            describe(value)
        ))
    };
    if is_complex(value) {
        return Err(wrong());
    }
    let array: PyArrayLike1<'_, f64, AllowTypeChange> = value.extract().map_err(|_| wrong())?;
    Ok(array.as_array().to_vec())
}

/// A vector from an array-like, or a single number, which makes a vector of one; says which it was.
pub(crate) fn scalar_or_vector(value: &Bound<'_, PyAny>, name: &str) -> PyResult<(Vec<f64>, bool)> {
    if let Ok(array) = value.cast::<PyArray1<f64>>() {
        return Ok((array.readonly().as_array().to_vec(), false));
    }
    // Arrays of one entry would pass for numbers too, so their dimension is asked for first.
    let dimensions = value.getattr("ndim").and_then(|ndim| ndim.extract::<usize>());
    let number =
        matches!(dimensions, Ok(0) | Err(_)) && !is_complex(value) && !value.is_instance_of::<PyString>();
    match number.then(|| value.extract::<f64>()) {
        Some(Ok(number)) => Ok((vec![number], true)),
        _ => Ok((vector(value, name)?, false)),
    }
}

/// True for complex arrays and numbers, which NumPy would turn into their real parts.
pub(crate) fn is_complex(value: &Bound<'_, PyAny>) -> bool {
    let kind = value.getattr("dtype").and_then(|dtype| dtype.getattr("kind"));
    kind.is_ok_and(|kind| kind.eq("c").unwrap_or(false)) || value.is_instance_of::<PyComplex>()
}

/// A vector of exactly `n` entries.
pub(crate) fn vector_of(value: &Bound<'_, PyAny>, n: usize, name: &str) -> PyResult<Vec<f64>> {
    let vector = vector(value, name)?;
    if vector.len() == n {
        Ok(vector)
    } else {
        Err(PyValueError::new_err(format!("{name}: expected {n} values, got {}", vector.len())))
    }
}

/// A vector of exactly `n` finite entries.
pub(crate) fn finite_vector_of(value: &Bound<'_, PyAny>, n: usize, name: &str) -> PyResult<Vec<f64>> {
    let vector = vector_of(value, n, name)?;
    let mut checker = Checker::new();
    checker.finite(&vector, name);
    checker.finish()?;
    Ok(vector)
}

/// One vector of `n` finite entries, or the rows of an array of them one after the other with their number.
pub(crate) fn finite_rows_of(
    value: &Bound<'_, PyAny>,
    n: usize,
    name: &str,
) -> PyResult<(Vec<f64>, Option<usize>)> {
    let rows: Option<PyArrayLike2<'_, f64, AllowTypeChange>> =
        if is_complex(value) { None } else { value.extract().ok() };
    let Some(rows) = rows else { return Ok((finite_vector_of(value, n, name)?, None)) };
    let rows = rows.as_array();
    if rows.ncols() != n {
        let (k, columns) = rows.dim();
        return Err(PyValueError::new_err(format!("{name}: expected shape (k, {n}), got ({k}, {columns})")));
    }
    if let Some(((i, j), x)) = rows.indexed_iter().find(|(_, x)| !x.is_finite()) {
        return Err(PyValueError::new_err(format!("{name}[{i}, {j}]: got {x}, expected a finite number")));
    }
    Ok((rows.iter().copied().collect(), Some(rows.nrows())))
}

/// A matrix of exactly `shape` (rows, columns), from any memory layout.
pub(crate) fn matrix_of(value: &Bound<'_, PyAny>, shape: (usize, usize), name: &str) -> PyResult<Matrix> {
    let wrong = || {
        PyTypeError::new_err(format!(
            "{name}: expected a two-dimensional array of real numbers, got {}",
            describe(value)
        ))
    };
    if is_complex(value) {
        return Err(wrong());
    }
    let array: PyArrayLike2<'_, f64, AllowTypeChange> = value.extract().map_err(|_| wrong())?;
    let array = array.as_array();
    if array.dim() != shape {
        let (rows, columns) = array.dim();
        return Err(PyValueError::new_err(format!(
            "{name}: expected shape ({}, {}), got ({rows}, {columns})",
            shape.0, shape.1
        )));
    }
    Ok(Matrix::from_fn(shape.0, shape.1, |i, j| array[[i, j]]))
}

/// A NumPy array of shape (rows, columns) in C order.
pub(crate) fn matrix_out<'py>(py: Python<'py>, matrix: &Matrix) -> Bound<'py, PyArray2<f64>> {
    // Column-major storage of the transpose is C order of the matrix.
    let transposed = matrix.transpose();
    numpy::ndarray::ArrayView2::from_shape(matrix.shape(), transposed.as_slice())
        .expect("a matrix has rows x columns entries")
        .to_pyarray(py)
}

/// A number of things; refuses negative ones by the name of the argument.
pub(crate) fn count(number: i64, name: &str) -> PyResult<usize> {
    usize::try_from(number)
        .map_err(|_| PyValueError::new_err(format!("{name}: got {number}, expected a whole number >= 0")))
}

/// The limit from the argument `max_steps`; none by default.
pub(crate) fn step_limit(max_steps: Option<i64>) -> PyResult<usize> {
    max_steps.map_or(Ok(usize::MAX), |limit| count(limit, "max_steps"))
}

/// What a value is, for an error message: its shape and dtype, or its type.
pub(crate) fn describe(value: &Bound<'_, PyAny>) -> String {
    let attribute = |name: &str| value.getattr(name).and_then(|a| a.str()).map(|s| s.to_string()).ok();
    match (attribute("shape"), attribute("dtype")) {
        (Some(shape), Some(dtype)) => format!("an array of shape {shape} and dtype {dtype}"),
        _ => value.get_type().name().map_or_else(|_| "an unknown type".to_owned(), |name| name.to_string()),
    }
}

/// A vector of a fixed number of entries.
pub(crate) fn array_of<const N: usize>(value: &Bound<'_, PyAny>, name: &str) -> PyResult<[f64; N]> {
    Ok(vector_of(value, N, name)?.try_into().expect("vector_of returns exactly N values"))
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
    match matrix_of(value, (N, N), name) {
        Ok(matrix) => Ok(std::array::from_fn(|i| std::array::from_fn(|j| matrix[(i, j)]))),
        // Two dimensions, but not these.
        Err(error) if error.is_instance_of::<PyValueError>(value.py()) => Err(of_another_size(error)),
        Err(_) => array_of(value, name).map(diagonal).map_err(of_another_size),
    }
}
