//! `lissom.Section`: what follows from a section; its parameters are those of the tables of `description`.

use pyo3::class::{PyTraverseError, PyVisit};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple, PyType};

use super::arguments;
use super::part::PyPart;
use crate::description::rod;
use crate::description::rod::{Shape, described};
use crate::python::words::required;

/// Cross-section of a segment: a shape filled with its material, or given stiffness and inertia.
///
/// Create it with `Section.circle`, `Section.hollow_circle`, `Section.rectangle`, `Section.ellipse` or `Section.given`.
/// Sizes are in metres: a number; a pair (segment's base, tip) for a linear taper; or a function of the arc length X from
/// the segment's base as a table (stations, values), a callable or a `Profile`. Callables also need `length`, the length of
/// the segment in metres. Width is along body y, height along body z. Methods take the position as the fraction `x` of the
/// segment's length, from 0 to 1.
///
/// Examples
/// --------
/// >>> import lissom
/// >>> strip = lissom.Section.rectangle(width=0.002, height=(0.02, 0.01))
/// >>> blade = lissom.Segment(0.3, section=strip, young_modulus=2e11, shear_modulus=8e10, density=7800,
/// ...                        modes={"torsion": 3, "bend_z": 4})
/// >>> horn = lissom.Section.circle(lambda X: 0.01 * 2.0 ** (-X / 0.3), length=0.3)
/// >>> bulb = lissom.Section.circle(([0.0, 0.2, 0.3], [0.01, 0.02, 0.005]))
#[pyclass(name = "Section", module = "lissom", extends = PyPart, subclass, frozen)]
pub(crate) struct PySection;

impl PySection {
    /// The section of a part.
    fn of(part: &Bound<'_, Self>) -> PyResult<rod::Section> {
        let section: Option<described::Section> = part.as_super().get().read();
        let wrong = || PyTypeError::new_err("Section is the base of other classes");
        section.map(|section| section.resolved()).ok_or_else(wrong)
    }

    /// The shape at a fraction of the segment.
    fn shape_at(part: &Bound<'_, Self>, x: f64) -> PyResult<Shape<f64>> {
        check_fraction(x)?;
        match Self::of(part)? {
            rod::Section::Shape(shape) => Ok(shape.at(x)),
            rod::Section::Given(_) => Err(PyValueError::new_err(
                "a given section has no shape, only its stiffness and inertia: see Segment.stiffness and Segment.inertia",
            )),
        }
    }
}

#[pymethods]
impl PySection {
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

    /// Kind of section: 'circle', 'hollow_circle', 'rectangle', 'ellipse' or 'given'.
    #[getter]
    fn shape(slf: &Bound<'_, Self>) -> &'static str {
        slf.as_super().get().schema().tag
    }

    /// Parameters of the section by name: sizes at base and tip, or stiffness, mass, inertia and centre; a Profile for each
    /// function of X.
    #[getter]
    fn parameters<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyDict>> {
        let parameters = PyDict::new(slf.py());
        for name in slf.as_super().get().schema().names().filter(|name| *name != "length") {
            parameters.set_item(name, slf.getattr(name)?)?;
        }
        Ok(parameters)
    }

    /// Area A, square metres.
    #[pyo3(signature = (x=0.0))]
    fn area(slf: &Bound<'_, Self>, #[pyo3(from_py_with = arguments::number::x)] x: f64) -> PyResult<f64> {
        Ok(Self::shape_at(slf, x)?.area())
    }

    /// Second moments of area (I_y, I_z), of bending about body y and about body z, metres to the fourth.
    #[pyo3(signature = (x=0.0))]
    fn second_moments(
        slf: &Bound<'_, Self>,
        #[pyo3(from_py_with = arguments::number::x)] x: f64,
    ) -> PyResult<(f64, f64)> {
        Ok(Self::shape_at(slf, x)?.second_moments().into())
    }

    /// Saint-Venant's torsion constant J_t, metres to the fourth: the torsional stiffness is G J_t.
    #[pyo3(signature = (x=0.0))]
    fn torsion_constant(
        slf: &Bound<'_, Self>,
        #[pyo3(from_py_with = arguments::number::x)] x: f64,
    ) -> PyResult<f64> {
        Ok(Self::shape_at(slf, x)?.torsion_constant())
    }

    /// Cowper's (1966) shear correction factors, for shear along y and along z, at this Poisson's ratio, above -1 and
    /// up to 0.5.
    #[pyo3(signature = (poisson_ratio=None, x=0.0, **others), text_signature = "($self, poisson_ratio, x=0.0)")]
    fn cowper(
        slf: &Bound<'_, Self>,
        #[pyo3(from_py_with = arguments::given_number::poisson_ratio)] poisson_ratio: Option<f64>,
        #[pyo3(from_py_with = arguments::number::x)] x: f64,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<(f64, f64)> {
        let poisson_ratio = required!("Section.cowper", others, poisson_ratio);
        if !(-1.0 < poisson_ratio && poisson_ratio <= 0.5) {
            return Err(PyValueError::new_err(format!(
                "poisson_ratio: got {poisson_ratio}, expected a number above -1 and up to 0.5"
            )));
        }
        Ok(Self::shape_at(slf, x)?.cowper(poisson_ratio).into())
    }

    /// Half extents of the section along y and along z from the rod's axis, metres.
    ///
    /// For a section of kind 'given', those of the ellipse with the same radii of gyration.
    #[pyo3(signature = (x=0.0))]
    fn half_extents(
        slf: &Bound<'_, Self>,
        #[pyo3(from_py_with = arguments::number::x)] x: f64,
    ) -> PyResult<(f64, f64)> {
        check_fraction(x)?;
        Ok(Self::of(slf)?.half_extents(x).into())
    }

    // The base class has its own. A class without a traversal would share that of its base; PyO3 0.30 then calls it
    // recursively without end.
    #[allow(clippy::unused_self, reason = "the protocol of the collector")]
    fn __traverse__(&self, _visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        Ok(())
    }
}

fn check_fraction(x: f64) -> PyResult<()> {
    if (0.0..=1.0).contains(&x) {
        return Ok(());
    }
    Err(PyValueError::new_err(format!(
        "x: got {x}, expected a fraction of the segment's length, from 0 to 1"
    )))
}
