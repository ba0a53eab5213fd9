//! `lissom.EquilibriumPath` and its critical points.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods};
use pyo3::class::{PyTraverseError, PyVisit};
use pyo3::prelude::*;
use pyo3::types::PyList;

use super::record::{self, ReadOnly, Reduced};
use crate::analysis::statics::{CriticalPoint, Path, Stability};

/// A point of a path of equilibria at which the tangent stiffness is singular.
///
/// Attributes
/// ----------
/// kind : {'limit', 'bifurcation'}
///     'limit': the load factor has an extremum (snap-through). 'bifurcation': paths cross (buckling).
/// index : int
///     The critical point lies between this point of the path and the next one.
/// load_factor : float
///     Fraction of the loads; for a path of inputs, the path parameter from 0 to 1.
/// u : ndarray, shape (m,), or None
///     The inputs, if the path varies them.
/// q : ndarray, shape (n,)
///     Coordinates.
/// directions : ndarray, shape (m, n)
///     Null vectors of the tangent stiffness; m > 1 if several modes buckle at once. Each has norm one when divided by the
///     typical sizes of the coordinates, about a radian of bending.
#[pyclass(name = "CriticalPoint", module = "lissom", frozen, get_all)]
#[derive(FromPyObject)]
pub(crate) struct PyCriticalPoint {
    kind: String,
    index: usize,
    load_factor: f64,
    u: Option<ReadOnly<PyArray1<f64>>>,
    q: ReadOnly<PyArray1<f64>>,
    directions: ReadOnly<PyArray2<f64>>,
}

impl PyCriticalPoint {
    fn new(py: Python<'_>, point: CriticalPoint) -> PyResult<Self> {
        let CriticalPoint { kind, index, load_factor, inputs, q, directions } = point;
        let directions = rows(py, directions, q.len())?;
        let q = ReadOnly::new(q.into_pyarray(py))?;
        let u = if inputs.is_empty() { None } else { Some(ReadOnly::new(inputs.into_pyarray(py))?) };
        Ok(Self { kind: kind.name().to_owned(), index, load_factor, u, q, directions })
    }
}

#[pymethods]
impl PyCriticalPoint {
    fn __repr__(&self) -> String {
        format!("<CriticalPoint {} at load factor {:.6}>", self.kind, self.load_factor)
    }

    /// For copies and pickles.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        record::reduce(slf)
    }

    #[staticmethod]
    fn _restore(state: Self) -> Self {
        state
    }
}

/// A sequence of equilibria, and the critical points between them.
///
/// Attributes
/// ----------
/// load_factor : ndarray, shape (m,)
///     Fraction of the loads, including gravity; for a path of inputs, the path parameter from 0 to 1.
/// u : ndarray, shape (m, k), or None
///     The k inputs, if the path varies them.
/// q : ndarray, shape (m, n)
///     Coordinates.
/// lowest_eigenvalue : ndarray, shape (m,)
///     Smallest eigenvalue of the tangent stiffness relative to the stiffness of material and springs: one without load, zero
///     at critical points, negative at unstable equilibria.
/// stability : list of str or None
///     As in StaticsResult. Of growing loads (`statics`) only the end is judged.
/// critical_points : list of CriticalPoint
///     In the order of the path.
#[pyclass(name = "EquilibriumPath", module = "lissom", frozen, get_all)]
#[derive(FromPyObject)]
pub(crate) struct PyEquilibriumPath {
    load_factor: ReadOnly<PyArray1<f64>>,
    u: Option<ReadOnly<PyArray2<f64>>>,
    q: ReadOnly<PyArray2<f64>>,
    lowest_eigenvalue: ReadOnly<PyArray1<f64>>,
    stability: Vec<Option<String>>,
    critical_points: Py<PyList>,
}

impl PyEquilibriumPath {
    pub(super) fn new(py: Python<'_>, path: Path, n: usize) -> PyResult<Py<Self>> {
        let Path { load_factor, inputs, q, lowest, stability, critical } = path;
        let critical_points = PyList::empty(py);
        for point in critical {
            critical_points.append(Bound::new(py, PyCriticalPoint::new(py, point)?)?)?;
        }
        let q = rows(py, q, n)?;
        let entries = inputs.len() / load_factor.len().max(1);
        let u = if inputs.is_empty() { None } else { Some(rows(py, inputs, entries)?) };
        let path = Self {
            load_factor: ReadOnly::new(load_factor.into_pyarray(py))?,
            u,
            q,
            lowest_eigenvalue: ReadOnly::new(lowest.into_pyarray(py))?,
            stability: stability.into_iter().map(|stability| stability.map(named)).collect(),
            critical_points: critical_points.unbind(),
        };
        Py::new(py, path)
    }
}

#[pymethods]
impl PyEquilibriumPath {
    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.critical_points)
    }

    pub(super) fn __repr__(&self, py: Python<'_>) -> String {
        let (points, critical) = (self.stability.len(), self.critical_points.bind(py).len());
        format!("<EquilibriumPath of {points} points, {critical} of them critical in between>")
    }

    /// For copies and pickles.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        record::reduce(slf)
    }

    #[staticmethod]
    fn _restore(state: Self) -> Self {
        state
    }
}

fn rows(py: Python<'_>, values: Vec<f64>, n: usize) -> PyResult<ReadOnly<PyArray2<f64>>> {
    let count = values.len().checked_div(n).unwrap_or(0);
    ReadOnly::new(values.into_pyarray(py).reshape([count, n])?)
}

fn named(stability: Stability) -> String {
    stability.name().to_owned()
}
