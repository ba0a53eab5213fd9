//! `lissom.Section`.

use numpy::PyArray2;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString, PyTuple};

use super::convert;
use crate::rod::{GivenSection, Section, Shape, ShearCorrection};

/// What a segment looks like across: a shape of its material, or given stiffness and inertia.
///
/// Made by `Section.circle`, `Section.hollow_circle`, `Section.rectangle`, `Section.ellipse` and `Section.given`. Sizes are
/// metres, one number or a pair (at the segment's base, at its tip) for a linear taper. Width lies along body y, height along
/// body z. Methods take the place as the fraction `x` of the segment's length, from 0 to 1.
///
/// Examples
/// --------
/// >>> import lissom
/// >>> strip = lissom.Section.rectangle(width=0.002, height=(0.02, 0.01))
/// >>> blade = lissom.Segment(0.3, section=strip, young_modulus=2e11, shear_modulus=8e10, density=7800,
/// ...                        modes={"torsion": 3, "bend_z": 4})
#[pyclass(name = "Section", module = "lissom", frozen, eq)]
#[derive(Clone, PartialEq)]
pub(crate) struct PySection(pub(crate) Section);

impl PySection {
    fn new(section: Section) -> PyResult<Self> {
        section.validate()?;
        Ok(Self(section))
    }

    /// The shape at a fraction of the segment.
    fn shape_at(&self, x: f64) -> PyResult<Shape<f64>> {
        check_fraction(x)?;
        match &self.0 {
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
    /// radius : float or (float, float)
    ///     Metres; at base and tip where it tapers.
    ///
    /// Returns
    /// -------
    /// Section
    #[staticmethod]
    fn circle(radius: &Bound<'_, PyAny>) -> PyResult<Self> {
        Self::new(Section::circle(size(radius, "radius")?))
    }

    /// A tube.
    ///
    /// Parameters
    /// ----------
    /// outer, inner : float or (float, float)
    ///     Radii in metres; the inner one may be zero.
    ///
    /// Returns
    /// -------
    /// Section
    #[staticmethod]
    fn hollow_circle(outer: &Bound<'_, PyAny>, inner: &Bound<'_, PyAny>) -> PyResult<Self> {
        let (outer, inner) = (size(outer, "outer")?, size(inner, "inner")?);
        Self::new(Section::Shape(Shape::HollowCircle { outer, inner }))
    }

    /// A rectangle.
    ///
    /// Parameters
    /// ----------
    /// width, height : float or (float, float)
    ///     Whole sides along body y and along body z, metres.
    ///
    /// Returns
    /// -------
    /// Section
    #[staticmethod]
    fn rectangle(width: &Bound<'_, PyAny>, height: &Bound<'_, PyAny>) -> PyResult<Self> {
        let (width, height) = (size(width, "width")?, size(height, "height")?);
        Self::new(Section::Shape(Shape::Rectangle { width, height }))
    }

    /// An ellipse.
    ///
    /// Parameters
    /// ----------
    /// semi_axis_y, semi_axis_z : float or (float, float)
    ///     Half its width along body y and half its height along body z, metres.
    ///
    /// Returns
    /// -------
    /// Section
    #[staticmethod]
    fn ellipse(semi_axis_y: &Bound<'_, PyAny>, semi_axis_z: &Bound<'_, PyAny>) -> PyResult<Self> {
        let semi_axis_y = size(semi_axis_y, "semi_axis_y")?;
        let semi_axis_z = size(semi_axis_z, "semi_axis_z")?;
        Self::new(Section::Shape(Shape::Ellipse { semi_axis_y, semi_axis_z }))
    }

    /// Stiffness and inertia as they are: composites, profiles computed elsewhere, test cases.
    ///
    /// Its segment takes no moduli and no density.
    ///
    /// Parameters
    /// ----------
    /// stiffness : array_like, shape (6,) or (6, 6)
    ///     Stiffness per length in the order torsion, bend_y, bend_z, stretch, shear_y, shear_z: a symmetric matrix, or its
    ///     diagonal. N m^2 between angular strains, N between linear ones, N m between one and another. It must be positive
    ///     definite on the strains that have modes; entries of others do not matter.
    /// mass : float
    ///     Kilograms per metre.
    /// inertia : array_like, shape (3,) or (3, 3)
    ///     Inertia tensor per length about the centre of mass, in the section's axes, kg m, or its diagonal.
    /// centre : array_like, shape (2,)
    ///     Centre of mass along body y and z, seen from the rod's axis, metres.
    ///
    /// Returns
    /// -------
    /// Section
    #[staticmethod]
    #[pyo3(
        signature = (stiffness, mass, inertia=None, centre=None),
        text_signature = "(stiffness, mass, inertia=(0, 0, 0), centre=(0, 0))"
    )]
    fn given(
        stiffness: &Bound<'_, PyAny>,
        mass: f64,
        inertia: Option<&Bound<'_, PyAny>>,
        centre: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        Self::new(Section::Given(Box::new(GivenSection {
            stiffness: convert::symmetric_of(stiffness, "stiffness")?,
            mass,
            inertia: inertia.map_or(Ok([[0.0; 3]; 3]), |value| convert::symmetric_of(value, "inertia"))?,
            centre: centre.map_or(Ok([0.0; 2]), |value| convert::array_of(value, "centre"))?,
        })))
    }

    /// Kind of section: 'circle', 'hollow_circle', 'rectangle', 'ellipse' or 'given'.
    #[getter]
    fn shape(&self) -> &'static str {
        match &self.0 {
            Section::Shape(shape) => shape.name(),
            Section::Given(_) => "given",
        }
    }

    /// What it was made with, by name: sizes at base and tip, or stiffness, mass, inertia and centre.
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let parameters = PyDict::new(py);
        match &self.0 {
            Section::Shape(shape) => {
                for (name, &[base, tip]) in shape.sizes() {
                    parameters.set_item(name, (base, tip))?;
                }
            }
            Section::Given(given) => {
                parameters.set_item("stiffness", rows(py, &given.stiffness)?)?;
                parameters.set_item("mass", given.mass)?;
                parameters.set_item("inertia", rows(py, &given.inertia)?)?;
                parameters.set_item("centre", <(f64, f64)>::from(given.centre))?;
            }
        }
        Ok(parameters)
    }

    /// Area A, square metres.
    #[pyo3(signature = (x=0.0))]
    fn area(&self, x: f64) -> PyResult<f64> {
        Ok(self.shape_at(x)?.area())
    }

    /// Second moments of area (I_y, I_z), of bending about body y and about body z, metres to the fourth.
    #[pyo3(signature = (x=0.0))]
    fn second_moments(&self, x: f64) -> PyResult<(f64, f64)> {
        Ok(self.shape_at(x)?.second_moments().into())
    }

    /// Saint-Venant's torsion constant J_t, metres to the fourth: the torsional stiffness is G J_t.
    #[pyo3(signature = (x=0.0))]
    fn torsion_constant(&self, x: f64) -> PyResult<f64> {
        Ok(self.shape_at(x)?.torsion_constant())
    }

    /// Cowper's (1966) shear correction factors, for shear along y and along z, at this Poisson's ratio.
    #[pyo3(signature = (poisson_ratio, x=0.0))]
    fn cowper(&self, poisson_ratio: f64, x: f64) -> PyResult<(f64, f64)> {
        Ok(self.shape_at(x)?.cowper(poisson_ratio).into())
    }

    /// How far it reaches from the rod's axis, along y and along z, metres.
    ///
    /// Of a given section that of the ellipse with the same radii of gyration.
    #[pyo3(signature = (x=0.0))]
    fn half_extents(&self, x: f64) -> PyResult<(f64, f64)> {
        check_fraction(x)?;
        Ok(self.0.half_extents(x).into())
    }

    pub(super) fn __repr__(&self) -> String {
        let parameters = match &self.0 {
            Section::Shape(shape) => shape.sizes().iter().map(|(name, ends)| sized(name, **ends)).collect(),
            Section::Given(given) => vec![
                format!("stiffness={:?}", given.stiffness),
                format!("mass={:?}", given.mass),
                format!("inertia={:?}", given.inertia),
                format!("centre={:?}", <(f64, f64)>::from(given.centre)),
            ],
        };
        format!("Section.{}({})", self.shape(), parameters.join(", "))
    }

    /// For copies and pickles.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let maker = py.get_type::<Self>().getattr(self.shape())?;
        Ok((maker, self.parameters(py)?.values().to_tuple()))
    }
}

/// A size in a `repr`: one number where it does not taper.
pub(super) fn sized(name: &str, [base, tip]: [f64; 2]) -> String {
    if base == tip { format!("{name}={base:?}") } else { format!("{name}=({base:?}, {tip:?})") }
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

/// A constant or linearly tapered size.
pub(super) fn size(value: &Bound<'_, PyAny>, name: &str) -> PyResult<[f64; 2]> {
    if let Ok(size) = value.extract::<f64>() {
        return Ok([size; 2]);
    }
    value.extract::<[f64; 2]>().map_err(|_| {
        let found = convert::describe(value);
        PyTypeError::new_err(format!("{name}: expected a number or (base, tip), in metres, got {found}"))
    })
}

/// A shear correction: a factor, one for each direction, or a rule.
pub(super) fn shear_correction(value: &Bound<'_, PyAny>) -> PyResult<ShearCorrection> {
    if let Ok(word) = value.cast::<PyString>() {
        return match word.to_str()? {
            "cowper" => Ok(ShearCorrection::Cowper),
            other => Err(PyValueError::new_err(format!(
                "shear_correction: got '{other}', expected a factor, one for y and one for z, or 'cowper'"
            ))),
        };
    }
    if let Ok(factor) = value.extract::<f64>() {
        return Ok(factor.into());
    }
    value.extract::<[f64; 2]>().map(ShearCorrection::Factors).map_err(|_| {
        let found = convert::describe(value);
        PyTypeError::new_err(format!(
            "shear_correction: expected a factor, (one for y, one for z), or 'cowper', got {found}"
        ))
    })
}

/// The way back: one number where both directions have the same.
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
