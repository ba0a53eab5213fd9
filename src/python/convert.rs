//! Arrays in and out, with messages that name the argument.

use numpy::{AllowTypeChange, PyArray2, PyArrayLike1, PyArrayLike2, ToPyArray};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

use crate::error::{Checker, InvalidInput};
use crate::linalg::Matrix;

impl From<InvalidInput> for PyErr {
    fn from(error: InvalidInput) -> Self {
        PyValueError::new_err(error.to_string())
    }
}

/// A vector from anything that NumPy turns into a one-dimensional array of doubles (lists, float32, strided views).
pub(crate) fn vector(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec<f64>> {
    let array: PyArrayLike1<'_, f64, AllowTypeChange> = value.extract().map_err(|_| {
        PyTypeError::new_err(format!(
            "{name}: expected a one-dimensional array of real numbers, got {}",
            describe(value)
        ))
    })?;
    Ok(array.as_array().to_vec())
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

/// A matrix of exactly `shape` (rows, columns), from any memory layout.
pub(crate) fn matrix_of(value: &Bound<'_, PyAny>, shape: (usize, usize), name: &str) -> PyResult<Matrix> {
    let array: PyArrayLike2<'_, f64, AllowTypeChange> = value.extract().map_err(|_| {
        PyTypeError::new_err(format!(
            "{name}: expected a two-dimensional array of real numbers, got {}",
            describe(value)
        ))
    })?;
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

/// What a value is, for an error message: its shape and dtype, or its type.
pub(crate) fn describe(value: &Bound<'_, PyAny>) -> String {
    let attribute = |name: &str| value.getattr(name).and_then(|a| a.str()).map(|s| s.to_string()).ok();
    match (attribute("shape"), attribute("dtype")) {
        (Some(shape), Some(dtype)) => format!("an array of shape {shape} and dtype {dtype}"),
        _ => value.get_type().name().map_or_else(|_| "an unknown type".to_owned(), |name| name.to_string()),
    }
}
