//! `lissom.Section`.

use std::fmt::Debug;

use numpy::PyArray2;
use pyo3::IntoPyObjectExt;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString, PyTuple};

use super::arguments;
use super::convert;
use super::profile;
use crate::error::Checker;
use crate::rod::{GivenSection, Parts, Profile, Section, Segment, Shape, ShearCorrection};

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
#[pyclass(name = "Section", module = "lissom", frozen, eq)]
#[derive(Clone, PartialEq)]
pub(crate) struct PySection {
    pub(crate) section: Section,
    /// Length of the segment, needed if parameters are functions of the arc length.
    pub(crate) length: Option<f64>,
}

impl PySection {
    fn new(section: Section, length: Option<f64>) -> PyResult<Self> {
        // Without a length, no parameter depends on X.
        section.validate(length.unwrap_or(1.0))?;
        Ok(Self { length: length.filter(|_| varies(&section)), section })
    }

    /// The section of a segment.
    pub(super) fn of(segment: &Segment) -> Self {
        let section = segment.section.clone();
        Self { length: varies(&section).then_some(segment.length), section }
    }

    /// The shape that `make` creates from sizes, given by their names.
    fn with_sizes<const N: usize>(
        sizes: [(&Bound<'_, PyAny>, &str); N],
        length: Option<f64>,
        make: impl FnOnce([Profile<1>; N]) -> Shape<Profile<1>>,
    ) -> PyResult<Self> {
        let length = length_of(length, &sizes)?;
        let mut read = Vec::with_capacity(N);
        for (value, name) in sizes {
            read.push(size(value, length, name)?);
        }
        let read = read.try_into().expect("as many as there were");
        Self::new(Section::Shape(make(read)), length)
    }

    /// The shape at a fraction of the segment.
    fn shape_at(&self, x: f64) -> PyResult<Shape<f64>> {
        check_fraction(x)?;
        match &self.section {
            Section::Shape(shape) => Ok(shape.at(x)),
            Section::Given(_) => Err(PyValueError::new_err(
                "a given section has no shape, only its stiffness and inertia: see Segment.stiffness and Segment.inertia",
            )),
        }
    }
}

#[pymethods]
impl PySection {
    /// A full circle.
    ///
    /// Parameters
    /// ----------
    /// radius : float or (float, float) or table or callable or Profile
    ///     Radius, metres; a pair at base and tip for a linear taper, or a function of the arc length X.
    /// length : float, optional
    ///     Length of the segment, metres. Required with callables.
    ///
    /// Returns
    /// -------
    /// Section
    #[staticmethod]
    #[pyo3(signature = (radius, *, length=None))]
    fn circle(
        radius: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = arguments::optional_number::length)] length: Option<f64>,
    ) -> PyResult<Self> {
        Self::with_sizes([(radius, "radius")], length, |[radius]| Shape::Circle { radius })
    }

    /// A tube with a circular section.
    ///
    /// Parameters
    /// ----------
    /// outer, inner : float or (float, float) or table or callable or Profile
    ///     Radii in metres; the inner one may be zero.
    /// length : float, optional
    ///     Length of the segment, metres. Required with callables.
    ///
    /// Returns
    /// -------
    /// Section
    #[staticmethod]
    #[pyo3(signature = (outer, inner, *, length=None))]
    fn hollow_circle(
        outer: &Bound<'_, PyAny>,
        inner: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = arguments::optional_number::length)] length: Option<f64>,
    ) -> PyResult<Self> {
        let sizes = [(outer, "outer"), (inner, "inner")];
        Self::with_sizes(sizes, length, |[outer, inner]| Shape::HollowCircle { outer, inner })
    }

    /// A rectangle.
    ///
    /// Parameters
    /// ----------
    /// width, height : float or (float, float) or table or callable or Profile
    ///     Sides along body y and along body z, metres.
    /// length : float, optional
    ///     Length of the segment, metres. Required with callables.
    ///
    /// Returns
    /// -------
    /// Section
    #[staticmethod]
    #[pyo3(signature = (width, height, *, length=None))]
    fn rectangle(
        width: &Bound<'_, PyAny>,
        height: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = arguments::optional_number::length)] length: Option<f64>,
    ) -> PyResult<Self> {
        let sizes = [(width, "width"), (height, "height")];
        Self::with_sizes(sizes, length, |[width, height]| Shape::Rectangle { width, height })
    }

    /// An ellipse.
    ///
    /// Parameters
    /// ----------
    /// semi_axis_y, semi_axis_z : float or (float, float) or table or callable or Profile
    ///     Semi-axes along body y and along body z, metres.
    /// length : float, optional
    ///     Length of the segment, metres. Required with callables.
    ///
    /// Returns
    /// -------
    /// Section
    #[staticmethod]
    #[pyo3(signature = (semi_axis_y, semi_axis_z, *, length=None))]
    fn ellipse(
        semi_axis_y: &Bound<'_, PyAny>,
        semi_axis_z: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = arguments::optional_number::length)] length: Option<f64>,
    ) -> PyResult<Self> {
        let sizes = [(semi_axis_y, "semi_axis_y"), (semi_axis_z, "semi_axis_z")];
        Self::with_sizes(sizes, length, |[semi_axis_y, semi_axis_z]| Shape::Ellipse {
            semi_axis_y,
            semi_axis_z,
        })
    }

    /// Given stiffness and inertia, for example of composites or of sections computed elsewhere.
    ///
    /// The segment then takes neither moduli nor density. Each parameter may also be a function of the arc length X from the
    /// segment's base: a table (stations, values), a callable (which requires `length`) or a `Profile`, with values of these
    /// shapes.
    ///
    /// Parameters
    /// ----------
    /// stiffness : array_like, shape (6,) or (6, 6)
    ///     Stiffness per length in the order torsion, bend_y, bend_z, stretch, shear_y, shear_z: a symmetric matrix, or its
    ///     diagonal. N m^2 between angular strains, N between linear ones, N m between one and another. It must be positive
    ///     definite on the strains that have modes; entries of others do not matter.
    /// mass : float
    ///     Mass per length, kilograms per metre.
    /// inertia : array_like, shape (3,) or (3, 3)
    ///     Inertia tensor per length about the centre of mass, in the section's axes, kg m, or its diagonal.
    /// centre : array_like, shape (2,)
    ///     Centre of mass along body y and z, relative to the rod's axis, metres.
    /// length : float, optional
    ///     Length of the segment, metres. Required with callables.
    ///
    /// Returns
    /// -------
    /// Section
    #[staticmethod]
    #[pyo3(
        signature = (stiffness, mass, inertia=None, centre=None, *, length=None),
        text_signature = "(stiffness, mass, inertia=(0, 0, 0), centre=(0, 0), *, length=None)"
    )]
    fn given(
        stiffness: &Bound<'_, PyAny>,
        mass: &Bound<'_, PyAny>,
        inertia: Option<&Bound<'_, PyAny>>,
        centre: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_number::length)] length: Option<f64>,
    ) -> PyResult<Self> {
        let optional = [(inertia, "inertia"), (centre, "centre")];
        let optional = optional.into_iter().filter_map(|(value, name)| Some((value?, name)));
        let values: Vec<_> = [(stiffness, "stiffness"), (mass, "mass")].into_iter().chain(optional).collect();
        let length = length_of(length, &values)?;
        let given = GivenSection {
            stiffness: match function(stiffness, &[6, 6], length, "stiffness")? {
                Some(function) => function,
                None => convert::symmetric_of::<6>(stiffness, "stiffness")?.into(),
            },
            mass: match function(mass, &[], length, "mass")? {
                Some(function) => function,
                None => convert::number_if_one(mass, "mass")?
                    .ok_or_else(|| wrong("mass", "a number (kg/m)", mass))?
                    .into(),
            },
            inertia: match inertia {
                None => [0.0; 9].into(),
                Some(inertia) => match function(inertia, &[3, 3], length, "inertia")? {
                    Some(function) => function,
                    None => convert::symmetric_of::<3>(inertia, "inertia")?.into(),
                },
            },
            centre: match centre {
                None => [0.0; 2].into(),
                Some(centre) => match function(centre, &[2], length, "centre")? {
                    Some(function) => function,
                    None => convert::array_of::<2>(centre, "centre")?.into(),
                },
            },
        };
        Self::new(Section::Given(Box::new(given)), length)
    }

    /// Kind of section: 'circle', 'hollow_circle', 'rectangle', 'ellipse' or 'given'.
    #[getter]
    fn shape(&self) -> &'static str {
        match &self.section {
            Section::Shape(shape) => shape.name(),
            Section::Given(_) => "given",
        }
    }

    /// Parameters of the section by name: sizes at base and tip, or stiffness, mass, inertia and centre; a Profile for each
    /// function of X.
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let parameters = PyDict::new(py);
        let length = self.length.unwrap_or(1.0);
        match &self.section {
            Section::Shape(shape) => {
                for (name, size) in shape.sizes() {
                    parameters.set_item(name, size_out(py, size, length)?)?;
                }
            }
            Section::Given(given) => {
                let GivenSection { stiffness, mass, inertia, centre } = &**given;
                let at_base = given.at(0.0);
                let [_, y, z] = at_base.centre;
                let constant = rows(py, &at_base.stiffness)?.into_any();
                parameters.set_item("stiffness", given_out(py, stiffness, &[6, 6], length, constant)?)?;
                let constant = at_base.mass.into_pyobject(py)?.into_any();
                parameters.set_item("mass", given_out(py, mass, &[], length, constant)?)?;
                let constant = rows(py, &at_base.inertia)?.into_any();
                parameters.set_item("inertia", given_out(py, inertia, &[3, 3], length, constant)?)?;
                let constant = (y, z).into_pyobject(py)?.into_any();
                parameters.set_item("centre", given_out(py, centre, &[2], length, constant)?)?;
            }
        }
        Ok(parameters)
    }

    /// Area A, square metres.
    #[pyo3(signature = (x=0.0))]
    fn area(&self, #[pyo3(from_py_with = arguments::number::x)] x: f64) -> PyResult<f64> {
        Ok(self.shape_at(x)?.area())
    }

    /// Second moments of area (I_y, I_z), of bending about body y and about body z, metres to the fourth.
    #[pyo3(signature = (x=0.0))]
    fn second_moments(&self, #[pyo3(from_py_with = arguments::number::x)] x: f64) -> PyResult<(f64, f64)> {
        Ok(self.shape_at(x)?.second_moments().into())
    }

    /// Saint-Venant's torsion constant J_t, metres to the fourth: the torsional stiffness is G J_t.
    #[pyo3(signature = (x=0.0))]
    fn torsion_constant(&self, #[pyo3(from_py_with = arguments::number::x)] x: f64) -> PyResult<f64> {
        Ok(self.shape_at(x)?.torsion_constant())
    }

    /// Cowper's (1966) shear correction factors, for shear along y and along z, at this Poisson's ratio, above -1 and
    /// up to 0.5.
    #[pyo3(signature = (poisson_ratio, x=0.0))]
    fn cowper(
        &self,
        #[pyo3(from_py_with = arguments::number::poisson_ratio)] poisson_ratio: f64,
        #[pyo3(from_py_with = arguments::number::x)] x: f64,
    ) -> PyResult<(f64, f64)> {
        if !(-1.0 < poisson_ratio && poisson_ratio <= 0.5) {
            return Err(PyValueError::new_err(format!(
                "poisson_ratio: got {poisson_ratio}, expected a number above -1 and up to 0.5"
            )));
        }
        Ok(self.shape_at(x)?.cowper(poisson_ratio).into())
    }

    /// Half extents of the section along y and along z from the rod's axis, metres.
    ///
    /// For a section of kind 'given', those of the ellipse with the same radii of gyration.
    #[pyo3(signature = (x=0.0))]
    fn half_extents(&self, #[pyo3(from_py_with = arguments::number::x)] x: f64) -> PyResult<(f64, f64)> {
        check_fraction(x)?;
        Ok(self.section.half_extents(x).into())
    }

    pub(super) fn __repr__(&self) -> String {
        let length = self.length.unwrap_or(1.0);
        let parameters = match &self.section {
            Section::Shape(shape) => {
                shape.sizes().into_iter().map(|(name, size)| sized(name, size, length)).collect()
            }
            Section::Given(given) => {
                let GivenSection { stiffness, mass, inertia, centre } = &**given;
                let at_base = given.at(0.0);
                let [_, y, z] = at_base.centre;
                vec![
                    parameter("stiffness", stiffness, &[6, 6], length, &at_base.stiffness),
                    parameter("mass", mass, &[], length, &at_base.mass),
                    parameter("inertia", inertia, &[3, 3], length, &at_base.inertia),
                    parameter("centre", centre, &[2], length, &(y, z)),
                ]
            }
        };
        format!("Section.{}({})", self.shape(), parameters.join(", "))
    }

    /// For copies and pickles.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let maker = py.get_type::<Self>().getattr(self.shape())?;
        Ok((maker, self.parameters(py)?.values().to_tuple()))
    }
}

/// Whether parameters are functions of the arc length, other than linear sizes.
fn varies(section: &Section) -> bool {
    match section {
        Section::Shape(shape) => shape.sizes().iter().any(|(_, size)| size.ends().is_none()),
        Section::Given(given) => {
            let GivenSection { stiffness, mass, inertia, centre } = &**given;
            stiffness.constant().is_none()
                || mass.constant().is_none()
                || inertia.constant().is_none()
                || centre.constant().is_none()
        }
    }
}

/// The length of the segment: given explicitly, or that of a table or profile among the values.
fn length_of(given: Option<f64>, values: &[(&Bound<'_, PyAny>, &str)]) -> PyResult<Option<f64>> {
    if let Some(length) = given {
        let mut check = Checker::new();
        check.positive(length, "length", "metres");
        check.finish()?;
        return Ok(given);
    }
    for (value, _) in values {
        let length = profile::length_of(value)?;
        if length.is_some() {
            return Ok(length);
        }
    }
    Ok(None)
}

/// A function of the arc length, if the value is one.
fn function<const N: usize>(
    value: &Bound<'_, PyAny>,
    shape: &[usize],
    length: Option<f64>,
    name: &str,
) -> PyResult<Option<Profile<N>>> {
    if !profile::varies(value)? {
        return Ok(None);
    }
    let length = length.ok_or_else(|| {
        PyValueError::new_err(format!(
            "{name}: got a function of the arc length X, expected length= beside it, the segment's (metres)"
        ))
    })?;
    profile::profile(value, shape, length, name).map(Some)
}

fn wrong(name: &str, expected: &str, value: &Bound<'_, PyAny>) -> PyErr {
    let found = convert::describe(value);
    PyTypeError::new_err(format!(
        "{name}: expected {expected}, a table (stations, values) or a function of the arc length X, got {found}"
    ))
}

/// The Python form of a size: values at base and tip, or a profile.
pub(super) fn size_out<'py>(py: Python<'py>, size: &Profile<1>, length: f64) -> PyResult<Bound<'py, PyAny>> {
    match size.ends() {
        Some([[base], [tip]]) => Ok((base, tip).into_pyobject(py)?.into_any()),
        None => profile::to_python(size, &[], length).into_bound_py_any(py),
    }
}

/// The Python form of a given parameter: its value if it is constant, or a profile.
fn given_out<'py, const N: usize>(
    py: Python<'py>,
    profile: &Profile<N>,
    shape: &[usize],
    length: f64,
    constant: Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    match profile.parts() {
        Parts::Constant(_) => Ok(constant),
        _ => profile::to_python(profile, shape, length).into_bound_py_any(py),
    }
}

/// A given parameter in a `repr`.
fn parameter<const N: usize>(
    name: &str,
    profile: &Profile<N>,
    shape: &[usize],
    length: f64,
    constant: &dyn Debug,
) -> String {
    match profile.parts() {
        Parts::Constant(_) => format!("{name}={constant:?}"),
        _ => format!("{name}={}", profile::to_python(profile, shape, length).__repr__()),
    }
}

/// A size in a `repr`; one number if it is constant.
fn sized(name: &str, size: &Profile<1>, length: f64) -> String {
    match size.ends() {
        Some([[base], [tip]]) => pair(name, [base, tip]),
        None => format!("{name}={}", profile::to_python(size, &[], length).__repr__()),
    }
}

/// Two numbers in a `repr`; one if they are equal.
pub(super) fn pair(name: &str, [first, second]: [f64; 2]) -> String {
    if first == second { format!("{name}={first:?}") } else { format!("{name}=({first:?}, {second:?})") }
}

fn check_fraction(x: f64) -> PyResult<()> {
    if (0.0..=1.0).contains(&x) {
        return Ok(());
    }
    Err(PyValueError::new_err(format!(
        "x: got {x}, expected a fraction of the segment's length, from 0 to 1"
    )))
}

pub(super) fn rows<'py, const N: usize>(
    py: Python<'py>,
    matrix: &[[f64; N]; N],
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let rows: Vec<Vec<f64>> = matrix.iter().map(|row| row.to_vec()).collect();
    Ok(PyArray2::from_vec2(py, &rows)?)
}

/// A size along a segment of this length. A pair of numbers is (base, tip), a pair of arrays a table.
pub(super) fn size(value: &Bound<'_, PyAny>, length: Option<f64>, name: &str) -> PyResult<Profile<1>> {
    if let Some(size) = convert::number_if_one(value, name)? {
        return Ok(size.into());
    }
    if let Some(function) = function(value, &[], length, name)? {
        return Ok(function);
    }
    let ends: [f64; 2] = convert::array_of(value, name)
        .map_err(|_| wrong(name, "a number or (base, tip) in metres", value))?;
    Ok(Profile::linear(ends.map(|end| [end])))
}

/// A shear correction: a factor, a factor for each direction, or a rule.
pub(super) fn shear_correction(value: &Bound<'_, PyAny>) -> PyResult<ShearCorrection> {
    if let Ok(word) = value.cast::<PyString>() {
        return match word.to_str()? {
            "cowper" => Ok(ShearCorrection::Cowper),
            other => Err(PyValueError::new_err(format!(
                "shear_correction: got '{other}', expected a factor, one for y and one for z, or 'cowper'"
            ))),
        };
    }
    if let Some(factor) = convert::number_if_one(value, "shear_correction")? {
        return Ok(factor.into());
    }
    convert::array_of::<2>(value, "shear_correction").map(ShearCorrection::Factors).map_err(|_| {
        let found = convert::describe(value);
        PyTypeError::new_err(format!(
            "shear_correction: expected a factor, (one for y, one for z), or 'cowper', got {found}"
        ))
    })
}

/// The Python form of a shear correction; one number if both directions have the same factor.
pub(super) fn shear_correction_out<'py>(
    py: Python<'py>,
    correction: ShearCorrection,
) -> PyResult<Bound<'py, PyAny>> {
    Ok(match correction {
        ShearCorrection::Cowper => "cowper".into_pyobject(py)?.into_any(),
        ShearCorrection::Factors([y, z]) if y == z => y.into_pyobject(py)?.into_any(),
        ShearCorrection::Factors(factors) => <(f64, f64)>::from(factors).into_pyobject(py)?.into_any(),
    })
}

/// The argument `section`.
pub(super) fn optional_section<'a, 'py>(
    value: &'a Bound<'py, PyAny>,
) -> PyResult<Option<&'a Bound<'py, PySection>>> {
    arguments::optional(value, "section", |value, name| {
        convert::instance(value, name, "lissom.Section or None")
    })
}
