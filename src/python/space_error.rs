//! `lissom.SpaceError`.

use std::ffi::CString;

use pyo3::prelude::*;

use super::callback::with_result;
use super::errors::AccuracyWarning;
use super::record::{self, Reduced};
use crate::analysis::statics::{Estimate, SpaceError};

/// Estimated error of an equilibrium due to the finite number of modes of its rods. Strains without modes count as rigid.
///
/// Attributes
/// ----------
/// tip : float
///     Largest error of the tips of rods and of bodies, metres. With method 'balance' it is bounded by that of the shape.
/// shape : float
///     Largest error of the position of any section, metres.
/// relative : float
///     The same relative to the length of the model.
/// curvature : float
///     Largest error of the curvature, torsion included, radians per metre.
/// moment : float
///     Largest error of the moment that the material transmits, newton metres.
/// segment : int
///     The segment, counted through all rods, that contributes most to the error of the shape.
/// name : str
///     Its name, with that of its link if there are several.
/// strain : str
///     The strain of this segment that lacks most, such as 'bend_y'.
/// method : {'balance', 'more_modes'}
///     'balance': from the strains that the balance of forces requires in the shape that was found. 'more_modes': by a step of
///     Newton's method of a model with more modes.
/// rigid_stretch : float or None
///     Part of the length of a segment by which the axial forces in it would stretch it if its stretch, which has no modes, were not
///     rigid: that of the segment with the largest. Not counted in the errors above; None in results saved by versions without it.
#[pyclass(name = "SpaceError", module = "lissom", frozen, get_all)]
#[derive(FromPyObject)]
pub(crate) struct PySpaceError {
    tip: f64,
    shape: f64,
    relative: f64,
    curvature: f64,
    moment: f64,
    segment: usize,
    name: String,
    strain: String,
    method: String,
    rigid_stretch: Option<f64>,
}

impl PySpaceError {
    pub(super) fn new(error: SpaceError) -> Self {
        let rigid_stretch = Some(error.rigid_stretch.strain);
        let SpaceError { tip, shape, relative, curvature, moment, segment, name, strain, estimate, .. } =
            error;
        let method = match estimate {
            Estimate::Balance => "balance",
            Estimate::MoreModes => "more_modes",
        };
        let (strain, method) = (strain.to_owned(), method.to_owned());
        Self { tip, shape, relative, curvature, moment, segment, name, strain, method, rigid_stretch }
    }
}

#[pymethods]
impl PySpaceError {
    fn __repr__(&self) -> String {
        format!(
            "<SpaceError: {:.1e} of the length, tip {:.1e} m, most by {} of {}>",
            self.relative, self.tip, self.strain, self.name
        )
    }

    /// For copies and pickles.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        record::reduce(slf)
    }

    #[staticmethod]
    fn _restore(state: &Bound<'_, PyAny>) -> PyResult<Self> {
        record::add_missing(state, &["rigid_stretch"])?;
        state.extract()
    }
}

/// A result, after a warning if the error of its shape is large. If the warning is raised as an exception, that has the result.
pub(super) fn warned<'py, R: IntoPyObject<'py>>(
    py: Python<'py>,
    error: Option<&SpaceError>,
    result: impl FnOnce() -> PyResult<R>,
) -> PyResult<R> {
    let Some(doubt) = error.and_then(SpaceError::doubt) else { return result() };
    match PyErr::warn(py, &py.get_type::<AccuracyWarning>(), &CString::new(doubt)?, 1) {
        Ok(()) => result(),
        Err(raised) => Err(with_result(py, raised, result)),
    }
}
