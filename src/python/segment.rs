//! `lissom.Segment`: what follows from a segment; its parameters are those of its table in `description`.

use numpy::PyArray2;
use pyo3::class::{PyTraverseError, PyVisit};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple, PyType};

use super::arguments;
use super::convert;
use super::part::PyPart;
use crate::description::rod::{SectionProperties, Segment, described, generalised_stiffness};

/// Base class of segments, with what follows from their parameters.
#[pyclass(name = "_Segment", module = "lissom._lissom", extends = PyPart, subclass, frozen)]
pub(crate) struct PySegment;

impl PySegment {
    /// The segment of a part.
    pub(super) fn of(part: &Bound<'_, Self>) -> PyResult<Segment> {
        let segment = part.as_super().get().of_type::<described::Segment>();
        let wrong = || PyTypeError::new_err("_Segment is the base of another class");
        segment.map(described::Segment::resolved).ok_or_else(wrong)
    }

    fn properties(part: &Bound<'_, Self>, at: f64) -> PyResult<SectionProperties> {
        let segment = Self::of(part)?;
        let length = segment.length;
        if (0.0..=length).contains(&at) {
            return Ok(SectionProperties::at(&segment, at / length));
        }
        Err(PyValueError::new_err(format!("X: got {at}, expected an arc length from 0 to {length} (metres)")))
    }
}

#[pymethods]
impl PySegment {
    #[new]
    #[classmethod]
    #[pyo3(signature = (*args, **kwargs))]
    fn new(
        cls: &Bound<'_, PyType>,
        args: &Bound<'_, PyTuple>,
        kwargs: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<PyClassInitializer<Self>> {
        Ok(PyClassInitializer::from(PyPart::new(cls, args, kwargs)?).add_subclass(Self))
    }

    /// Sectional stiffness at arc length X from the segment's base.
    ///
    /// Parameters
    /// ----------
    /// X : float
    ///     Arc length, metres, from 0 to the segment's length.
    ///
    /// Returns
    /// -------
    /// numpy.ndarray, shape (6, 6)
    ///     Stiffness in the order torsion, bend_y, bend_z, stretch, shear_y, shear_z; diagonal unless the section is of kind
    ///     'given'.
    #[pyo3(signature = (X=0.0))]
    #[allow(non_snake_case, reason = "arc length is X everywhere")]
    fn stiffness<'py>(
        slf: &Bound<'py, Self>,
        #[pyo3(from_py_with = arguments::number::X)] X: f64,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows(slf.py(), &Self::properties(slf, X)?.stiffness)
    }

    /// Generalised stiffness K of the segment: its coordinates q give the generalised elastic forces ``K @ q`` and their
    /// rates v the damping forces ``retardation_time * K @ v``.
    ///
    /// Returns
    /// -------
    /// numpy.ndarray, shape (k, k)
    ///     Symmetric matrix for the segment's k coordinates. Entries are in N m^3 for modes of torsion and bending, in N m for
    ///     modes of stretch and shear.
    fn generalised_stiffness<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        Ok(convert::matrix_out(slf.py(), &generalised_stiffness(&Self::of(slf)?)))
    }

    /// Sectional inertia at arc length X from the segment's base.
    ///
    /// Parameters
    /// ----------
    /// X : float
    ///     Arc length, metres, from 0 to the segment's length.
    ///
    /// Returns
    /// -------
    /// numpy.ndarray, shape (6, 6)
    ///     Maps a twist (angular velocity, velocity of the axis) to the momentum per length (angular about the axis, linear), all
    ///     in the axes of the section.
    #[pyo3(signature = (X=0.0))]
    #[allow(non_snake_case, reason = "arc length is X everywhere")]
    fn inertia<'py>(
        slf: &Bound<'py, Self>,
        #[pyo3(from_py_with = arguments::number::X)] X: f64,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows(slf.py(), &Self::properties(slf, X)?.inertia_matrix())
    }

    // As in `section`.
    #[allow(clippy::unused_self, reason = "the protocol of the collector")]
    fn __traverse__(&self, _visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        Ok(())
    }
}

fn rows<'py, const N: usize>(py: Python<'py>, matrix: &[[f64; N]; N]) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let rows: Vec<Vec<f64>> = matrix.iter().map(|row| row.to_vec()).collect();
    Ok(PyArray2::from_vec2(py, &rows)?)
}
