//! `lissom.Fluid`.

use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::arguments;
use super::convert;
use crate::world::Fluid;

/// An unbounded fluid around the whole rod, with uniform and steady flow far from it.
///
/// By default, buoyancy and the added mass of a circular section in an inviscid fluid act, and there is no drag, because the
/// drag coefficients depend on the Reynolds number and the roughness of the rod.
/// With the velocity of a section relative to the fluid, ``v_n`` across the axis of the section and ``v_t`` along it,
/// and the section's diameter d (that of the circle of the same area), the drag per metre of the unstretched rod is
///
/// ``- c_n v_n - c_t v_t - 1/2 density d (C_n |v_n| v_n + pi C_t |v_t| v_t)``
///
/// Parameters
/// ----------
/// density : float
///     Density, kilograms per cubic metre.
/// velocity : array_like, shape (3,)
///     Velocity of the fluid far from the rod in world axes, metres per second.
/// viscous_drag : (float, float)
///     ``c_n`` and ``c_t``: drag per length and velocity, across and along the axis, newton seconds per square metre.
/// drag_coefficients : (float, float)
///     ``C_n`` and ``C_t`` of the quadratic drag. Water around a smooth cable at Reynolds numbers from 1e3 to 1e5: about (1.2, 0.01).
/// added_mass_coefficient : float
///     Added mass across the axis, relative to the mass of the displaced fluid.
/// buoyancy : bool
///     Whether buoyancy acts.
///
/// Raises
/// ------
/// ValueError
///     If parameters are invalid; the message lists all of them.
///
/// Examples
/// --------
/// >>> import lissom
/// >>> sea = lissom.Fluid(1025.0, (0.1, 0, 0), drag_coefficients=(1.2, 0.01))
/// >>> arm = lissom.Segment(0.4, 0.01, 3e5, 1e5, 1070.0, {"bend_y": 4})
/// >>> rod = lissom.Rod([arm], fluid=sea)
#[pyclass(name = "Fluid", module = "lissom", frozen, eq)]
#[derive(Clone, PartialEq)]
pub(crate) struct PyFluid(pub(crate) Fluid);

#[pymethods]
impl PyFluid {
    #[new]
    #[pyo3(
        signature = (density, velocity=None, *, viscous_drag=None, drag_coefficients=None, added_mass_coefficient=1.0, buoyancy=true),
        text_signature = "(density, velocity=(0, 0, 0), *, viscous_drag=(0, 0), drag_coefficients=(0, 0), added_mass_coefficient=1.0, buoyancy=True)"
    )]
    fn new(
        #[pyo3(from_py_with = arguments::number::density)] density: f64,
        velocity: Option<&Bound<'_, PyAny>>,
        viscous_drag: Option<&Bound<'_, PyAny>>,
        drag_coefficients: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = arguments::number::added_mass_coefficient)] added_mass_coefficient: f64,
        #[pyo3(from_py_with = arguments::flag::buoyancy)] buoyancy: bool,
    ) -> PyResult<Self> {
        let mut fluid = Fluid { added_mass_coefficient, is_buoyant: buoyancy, ..Fluid::ideal(density) };
        if let Some(velocity) = velocity {
            fluid.velocity = convert::array_of(velocity, "velocity")?;
        }
        if let Some(drag) = viscous_drag {
            fluid.viscous_drag = convert::array_of(drag, "viscous_drag")?;
        }
        if let Some(coefficients) = drag_coefficients {
            fluid.drag_coefficients = convert::array_of(coefficients, "drag_coefficients")?;
        }
        fluid.validate()?;
        Ok(Self(fluid))
    }

    /// Kilograms per cubic metre.
    #[getter]
    fn density(&self) -> f64 {
        self.0.density
    }

    /// Velocity far from the rod, metres per second.
    #[getter]
    fn velocity(&self) -> (f64, f64, f64) {
        self.0.velocity.into()
    }

    /// Viscous drag across the axis and along it, newton seconds per square metre.
    #[getter]
    fn viscous_drag(&self) -> (f64, f64) {
        self.0.viscous_drag.into()
    }

    /// Coefficients of the quadratic drag across the axis and along it.
    #[getter]
    fn drag_coefficients(&self) -> (f64, f64) {
        self.0.drag_coefficients.into()
    }

    /// Added mass across the axis, relative to the mass of the displaced fluid.
    #[getter]
    fn added_mass_coefficient(&self) -> f64 {
        self.0.added_mass_coefficient
    }

    /// Whether buoyancy acts.
    #[getter]
    fn buoyancy(&self) -> bool {
        self.0.is_buoyant
    }

    fn __repr__(&self) -> String {
        let buoyancy = if self.0.is_buoyant { "True" } else { "False" };
        format!(
            "Fluid(density={:?}, velocity={:?}, viscous_drag={:?}, drag_coefficients={:?}, \
             added_mass_coefficient={:?}, buoyancy={buoyancy})",
            self.0.density,
            self.velocity(),
            self.viscous_drag(),
            self.drag_coefficients(),
            self.0.added_mass_coefficient,
        )
    }

    /// For copies and pickles.
    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<((f64,), Bound<'py, PyDict>)> {
        let arguments = PyDict::new(py);
        arguments.set_item("velocity", self.velocity())?;
        arguments.set_item("viscous_drag", self.viscous_drag())?;
        arguments.set_item("drag_coefficients", self.drag_coefficients())?;
        arguments.set_item("added_mass_coefficient", self.0.added_mass_coefficient)?;
        arguments.set_item("buoyancy", self.0.is_buoyant)?;
        Ok(((self.0.density,), arguments))
    }
}

/// The argument `fluid`.
pub(super) fn optional_fluid<'a, 'py>(
    value: &'a Bound<'py, PyAny>,
) -> PyResult<Option<&'a Bound<'py, PyFluid>>> {
    arguments::optional(value, "fluid", |value, name| convert::instance(value, name, "lissom.Fluid or None"))
}
