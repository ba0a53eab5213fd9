//! `lissom.Segment`.

use numpy::PyArray2;
use pyo3::IntoPyObjectExt;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use super::arguments;
use super::convert;
use super::part::{object_of, part_of};
use super::profile;
use super::section;
use super::signal::Functions;
use crate::description::Data as _;
use crate::error::Checker;
use crate::rod::{
    self, Basis, STRAIN_NAMES, STRAINS, Section, SectionProperties, Segment, Shape, ShearCorrection,
    described, generalised_stiffness,
};

/// A segment of a rod with one kind of section and one material.
///
/// Parameters
/// ----------
/// length : float
///     Length, metres.
/// radius : float or (float, float) or table or callable or Profile, optional
///     Radius of a circular section, metres: a number, a pair of radii at the segment's base and tip, or a function of the arc
///     length X in one of the forms of `reference_strain`. Give either `radius` or `section`.
/// young_modulus, shear_modulus : float, optional
///     Moduli E and G, pascals, with Poisson's ratio E/(2G) - 1 in (-1, 0.5]. Required unless the section is of kind 'given'.
///     `poisson_ratio` can replace the shear modulus.
/// density : float, optional
///     Density, kilograms per cubic metre. Required unless the section is of kind 'given'.
/// modes : dict of str to int
///     Number of modes of each strain: keys ``"torsion"``, ``"bend_y"``, ``"bend_z"``, ``"stretch"``,
///     ``"shear_y"``, ``"shear_z"``. Strains that are not named have no modes and keep their reference values.
/// retardation_time : float
///     Retardation time of Kelvin-Voigt damping, seconds: the damping matrix is this time multiplied by the stiffness matrix.
/// reference_strain : array_like, shape (6,), or table or callable or Profile
///     Stress-free strain: torsion, bend_y, bend_z (radians per metre), stretch, shear_y, shear_z. To vary it along the
///     segment, give a table of stations (arc lengths from 0 to `length`, metres) and values, shape (m, 6), which is
///     interpolated without overshoot; a callable of the arc length from the segment's base; or a `Profile`.
/// shear_correction : float, (float, float) or 'cowper'
///     Shear correction factor: one number, two numbers for shear along y and along z, or 'cowper' for the factors of Cowper
///     (1966), which depend on the shape of the section and Poisson's ratio.
/// nodes : int, optional
///     Number of quadrature nodes, rounded up to a multiple of four. The default is accurate for bending up to about half a turn.
/// basis : {'legendre', 'chebyshev', 'monomial', 'piecewise_constant', 'hermite'}
///     Shape functions of the modes, with x = X / length: Legendre or Chebyshev polynomials of 2 x - 1; powers of x; constants
///     on equal pieces; or Hermite cubics on equally spaced knots, with two modes per knot for value and slope (times the
///     knot spacing). With the last two, all strains that have modes have the same number.
/// section : Section, optional
///     Section of another shape, or with given stiffness and inertia.
/// poisson_ratio : float, optional
///     Poisson's ratio nu in (-1, 0.5], instead of the shear modulus: G = E/(2 (1 + nu)). Then the shear modulus follows Young's
///     modulus where that is swept, fitted or differentiated with respect to.
///
/// Raises
/// ------
/// ValueError
///     If parameters are invalid; the message lists all of them.
#[pyclass(name = "Segment", module = "lissom", frozen, eq)]
#[derive(Clone, PartialEq)]
pub(crate) struct PySegment(pub(crate) Segment);

/// The shear modulus of a material, from the one of it and Poisson's ratio that is given.
fn shear_modulus_of(
    young_modulus: Option<f64>,
    shear_modulus: Option<f64>,
    poisson_ratio: Option<f64>,
    check: &mut Checker,
) -> Option<f64> {
    match (shear_modulus, poisson_ratio) {
        (Some(_), Some(_)) => {
            check.require(false, "poisson_ratio", "both poisson_ratio and shear_modulus", "one of them");
        }
        (None, None) => {
            let expected = "one of them, unless the section is given";
            check.require(false, "shear_modulus", "neither shear_modulus nor poisson_ratio", expected);
        }
        (Some(modulus), None) => return Some(modulus),
        (None, Some(ratio)) => {
            // an invalid Young's modulus is refused for itself.
            let young_modulus = young_modulus.filter(|modulus| *modulus > 0.0).unwrap_or(1.0);
            let found = rod::shear_modulus(young_modulus, ratio);
            let modulus = found.as_ref().ok().copied();
            check.all(found.map(|_| ()));
            return modulus;
        }
    }
    None
}

fn dict_of_modes<'a, 'py>(modes: &'a Bound<'py, PyAny>) -> PyResult<&'a Bound<'py, PyDict>> {
    modes.cast::<PyDict>().map_err(|_| {
        let expected = "a dict such as {'bend_y': 3}; choose_modes finds the numbers";
        PyTypeError::new_err(format!("modes: got {}, expected {expected}", convert::describe(modes)))
    })
}

#[pymethods]
impl PySegment {
    #[new]
    #[pyo3(signature = (length, radius=None, young_modulus=None, shear_modulus=None, density=None, modes=None, retardation_time=0.0, reference_strain=None, shear_correction=None, nodes=None, *, basis="legendre", section=None, poisson_ratio=None),
           text_signature = "(length, radius=None, young_modulus=None, shear_modulus=None, density=None, modes=None, retardation_time=0.0, reference_strain=(0, 0, 0, 1, 0, 0), shear_correction=1.0, nodes=None, *, basis='legendre', section=None, poisson_ratio=None)")]
    #[allow(clippy::too_many_arguments, reason = "the signature of the Python class")]
    fn new(
        #[pyo3(from_py_with = arguments::number::length)] length: f64,
        radius: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_number::young_modulus)] young_modulus: Option<f64>,
        #[pyo3(from_py_with = arguments::optional_number::shear_modulus)] shear_modulus: Option<f64>,
        #[pyo3(from_py_with = arguments::optional_number::density)] density: Option<f64>,
        modes: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = arguments::number::retardation_time)] retardation_time: f64,
        reference_strain: Option<&Bound<'_, PyAny>>,
        shear_correction: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_whole::nodes)] nodes: Option<i64>,
        #[pyo3(from_py_with = arguments::text::basis)] basis: &str,
        section: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_number::poisson_ratio)] poisson_ratio: Option<f64>,
    ) -> PyResult<Self> {
        let basis = Basis::named(basis).ok_or_else(|| {
            let names = Basis::ALL.map(Basis::name);
            PyValueError::new_err(format!("basis: got '{basis}', expected one of {names:?}"))
        })?;
        let modes = modes.map(dict_of_modes).transpose()?;
        let section: Option<described::Section> = match section {
            None => None,
            Some(section) => Some(part_of(section, "section", &mut Functions::default())?),
        };
        let mut check = Checker::new();
        let section = match (radius, section) {
            (Some(radius), None) => {
                Section::Shape(Shape::Circle { radius: profile::size(radius, length, "radius")? })
            }
            (None, Some(section)) => {
                if let Some(over) = section.length() {
                    let expected = format!("one for the segment's length, {length} m");
                    check.require(over == length, "section", format_args!("one for {over} m"), &expected);
                }
                section.resolved()
            }
            (radius, _) => {
                let found =
                    if radius.is_some() { "both radius and section" } else { "neither radius nor section" };
                check.require(false, "radius", found, "one of them");
                Section::circle([1.0; 2])
            }
        };
        let shear_modulus = match section {
            Section::Given(_) => {
                let found = poisson_ratio.unwrap_or_default();
                let expected = "nothing: a given section has all that it needs";
                check.require(poisson_ratio.is_none(), "poisson_ratio", found, expected);
                shear_modulus
            }
            Section::Shape(_) => {
                let expected = "a number, unless the section is given";
                check.require(young_modulus.is_some(), "young_modulus", "none", expected);
                let found = shear_modulus_of(young_modulus, shear_modulus, poisson_ratio, &mut check);
                check.require(density.is_some(), "density", "none", expected);
                found
            }
        };
        let expected = "a dict such as {'bend_y': 3}";
        check.require(modes.is_some(), "modes", "none", expected);
        check.finish()?;
        let [young_modulus, shear_modulus, density] =
            [young_modulus, shear_modulus, density].map(Option::unwrap_or_default);
        let mut segment = Segment {
            section,
            modes: modes.map_or(Ok([0; STRAINS]), mode_numbers)?,
            basis,
            retardation_time,
            given_poisson_ratio: poisson_ratio,
            nodes: nodes.map(|nodes| convert::count(nodes, "nodes")).transpose()?,
            ..Segment::straight(length, 0.0, young_modulus, shear_modulus, density)
        };
        if let Some(strain) = reference_strain {
            segment.reference_strain = profile::profile(strain, &[STRAINS], length, "reference_strain")?;
        }
        if let Some(correction) = shear_correction {
            segment.shear_correction = section::shear_correction(correction)?;
        }
        segment.validate()?;
        Ok(Self(segment))
    }

    /// Length in metres.
    #[getter]
    fn length(&self) -> f64 {
        self.0.length
    }

    /// Radius of a circular section at the base and at the tip, in metres, or a Profile; None for other sections.
    #[getter]
    fn radius<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        match &self.0.section {
            Section::Shape(Shape::Circle { radius }) => {
                profile::size_out(py, radius, self.0.length).map(Some)
            }
            _ => Ok(None),
        }
    }

    /// The cross-section.
    #[getter]
    fn section<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        object_of(py, &self.0.section.described(self.0.length).write())
    }

    /// Young's modulus in pascals; None for a section of kind 'given'.
    #[getter]
    fn young_modulus(&self) -> Option<f64> {
        self.of_material(self.0.young_modulus)
    }

    /// Shear modulus in pascals; None for a section of kind 'given'.
    #[getter]
    fn shear_modulus(&self) -> Option<f64> {
        self.of_material(self.0.shear_modulus)
    }

    /// Poisson's ratio E/(2G) - 1; None for a section of kind 'given'.
    #[getter]
    fn poisson_ratio(&self) -> Option<f64> {
        self.of_material(self.0.given_poisson_ratio.unwrap_or_else(|| self.0.poisson_ratio()))
    }

    /// Density in kilograms per cubic metre; None for a section of kind 'given'.
    #[getter]
    fn density(&self) -> Option<f64> {
        self.of_material(self.0.density)
    }

    /// Number of modes of each strain that has modes.
    #[getter]
    fn modes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let modes = PyDict::new(py);
        for (name, number) in STRAIN_NAMES.iter().zip(self.0.modes).filter(|(_, number)| *number > 0) {
            modes.set_item(name, number)?;
        }
        Ok(modes)
    }

    /// Kelvin-Voigt retardation time in seconds.
    #[getter]
    fn retardation_time(&self) -> f64 {
        self.0.retardation_time
    }

    /// Shape functions of the modes: 'legendre', 'chebyshev', 'monomial', 'piecewise_constant' or 'hermite'.
    #[getter]
    fn basis(&self) -> &'static str {
        self.0.basis.name()
    }

    /// Stress-free strain: torsion, bend_y, bend_z, stretch, shear_y, shear_z; a Profile if it varies.
    #[getter]
    fn reference_strain<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let profile = &self.0.reference_strain;
        match profile.constant() {
            Some(strain) => Ok(PyTuple::new(py, strain)?.into_any()),
            None => profile::to_python(profile, &[STRAINS], self.0.length).into_bound_py_any(py),
        }
    }

    /// Shear correction factor, factors for y and z, or 'cowper'.
    #[getter]
    fn shear_correction<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        section::shear_correction_out(py, self.0.shear_correction)
    }

    /// Requested number of quadrature nodes; None for the default. `Rod.nodes` returns the number in use.
    #[getter]
    fn nodes(&self) -> Option<usize> {
        self.0.nodes
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
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = arguments::number::X)] X: f64,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        section::rows(py, &self.properties(X)?.stiffness)
    }

    /// Generalised stiffness K of the segment: its coordinates q give the generalised elastic forces ``K @ q`` and their
    /// rates v the damping forces ``retardation_time * K @ v``.
    ///
    /// Returns
    /// -------
    /// numpy.ndarray, shape (k, k)
    ///     Symmetric matrix for the segment's k coordinates. Entries are in N m^3 for modes of torsion and bending, in N m for
    ///     modes of stretch and shear.
    fn generalised_stiffness<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        convert::matrix_out(py, &generalised_stiffness(&self.0))
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
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = arguments::number::X)] X: f64,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        section::rows(py, &self.properties(X)?.inertia_matrix())
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let Segment { length, section, modes, retardation_time, nodes, .. } = &self.0;
        let modes: Vec<String> = STRAIN_NAMES
            .iter()
            .zip(modes)
            .filter(|(_, number)| **number > 0)
            .map(|(name, number)| format!("'{name}': {number}"))
            .collect();
        let strain = match self.0.reference_strain.constant() {
            Some([a, b, c, d, e, f]) => format!("({a:?}, {b:?}, {c:?}, {d:?}, {e:?}, {f:?})"),
            None => self.reference_strain(py)?.repr()?.to_string(),
        };
        let mut arguments = vec![format!("length={length:?}")];
        match section {
            Section::Shape(Shape::Circle { radius }) => {
                let radius = profile::size_out(py, radius, *length)?;
                arguments.push(format!("radius={}", radius.repr()?));
            }
            _ => arguments.push(format!("section={}", self.section(py)?.repr()?)),
        }
        if let Section::Shape(_) = section {
            let Segment { young_modulus, shear_modulus, given_poisson_ratio, density, .. } = &self.0;
            arguments.push(format!("young_modulus={young_modulus:?}"));
            arguments.push(match given_poisson_ratio {
                Some(ratio) => format!("poisson_ratio={ratio:?}"),
                None => format!("shear_modulus={shear_modulus:?}"),
            });
            arguments.push(format!("density={density:?}"));
        }
        arguments.push(format!("modes={{{}}}, retardation_time={retardation_time:?}", modes.join(", ")));
        arguments.push(format!("reference_strain={strain}"));
        arguments.push(match self.0.shear_correction {
            ShearCorrection::Cowper => "shear_correction='cowper'".to_owned(),
            ShearCorrection::Factors(factors) => section::pair("shear_correction", factors),
        });
        arguments.push(format!("nodes={}", nodes.map_or("None".to_owned(), |nodes| nodes.to_string())));
        arguments.push(format!("basis='{}'", self.basis()));
        Ok(format!("Segment({})", arguments.join(", ")))
    }

    /// For copies and pickles.
    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<((), Bound<'py, PyDict>)> {
        let arguments = PyDict::new(py);
        arguments.set_item("length", self.0.length)?;
        match self.radius(py)? {
            Some(radius) => arguments.set_item("radius", radius)?,
            None => arguments.set_item("section", self.section(py)?)?,
        }
        arguments.set_item("young_modulus", self.young_modulus())?;
        match self.0.given_poisson_ratio {
            Some(ratio) => arguments.set_item("poisson_ratio", ratio)?,
            None => arguments.set_item("shear_modulus", self.shear_modulus())?,
        }
        arguments.set_item("density", self.density())?;
        arguments.set_item("modes", self.modes(py)?)?;
        arguments.set_item("retardation_time", self.0.retardation_time)?;
        arguments.set_item("reference_strain", self.reference_strain(py)?)?;
        arguments.set_item("shear_correction", self.shear_correction(py)?)?;
        arguments.set_item("nodes", self.0.nodes)?;
        arguments.set_item("basis", self.basis())?;
        Ok(((), arguments))
    }
}

impl PySegment {
    /// A material property; none for a section of kind 'given'.
    fn of_material(&self, value: f64) -> Option<f64> {
        matches!(self.0.section, Section::Shape(_)).then_some(value)
    }

    fn properties(&self, at: f64) -> PyResult<SectionProperties> {
        let length = self.0.length;
        if (0.0..=length).contains(&at) {
            return Ok(SectionProperties::at(&self.0, at / length));
        }
        Err(PyValueError::new_err(format!("X: got {at}, expected an arc length from 0 to {length} (metres)")))
    }
}

fn mode_numbers(modes: &Bound<'_, PyDict>) -> PyResult<[usize; STRAINS]> {
    let mut numbers = [0; STRAINS];
    let mut check = Checker::new();
    for (key, value) in modes {
        let name = key.str()?.to_string();
        let Some(index) = STRAIN_NAMES.iter().position(|&known| known == name) else {
            check.require(
                false,
                "modes",
                format_args!("the key '{name}'"),
                &format!("keys among {STRAIN_NAMES:?}"),
            );
            continue;
        };
        match value.extract::<usize>() {
            Ok(number) => numbers[index] = number,
            Err(_) => {
                let found = value.repr()?;
                check.require(false, &format!("modes['{name}']"), found, "a whole number >= 0");
            }
        }
    }
    check.finish()?;
    Ok(numbers)
}
