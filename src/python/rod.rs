//! `lissom.Segment` and `lissom.Rod`.

use std::sync::{Mutex, OnceLock, PoisonError};

use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods};
use pyo3::class::{PyTraverseError, PyVisit};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::pyclass::boolean_struct::True;
use pyo3::types::{PyDict, PyTuple};
use pyo3::{IntoPyObjectExt, PyClass};

use super::base::PyBaseMotion;
use super::callback::or_raised;
use super::convert;
use super::errors::check_finite;
use super::fluid::PyFluid;
use super::load::{PyBody, PyLoad};
use super::model::{PyModel, check_time, time_of_state};
use super::profile;
use super::section::{self, PySection};
use super::signal::Functions;
use super::support::PySupport;
use crate::error::{Checker, InvalidInput};
use crate::lie::Rotation;
use crate::linalg::Matrix;
use crate::model::InTime as _;
use crate::robot::{Kernel, Multiplications, Place, Pose, Rod, RodModel};
use crate::rod::{
    self, Basis, STRAIN_NAMES, STRAINS, Section, SectionProperties, Segment, Shape, ShearCorrection,
};

/// A piece of rod with one kind of section.
///
/// Parameters
/// ----------
/// length : float
///     Metres.
/// radius : float or (float, float) or table or callable or Profile, optional
///     Radius of a circular section in metres: one number, radii at the segment's base and tip, or a function of the arc length X
///     as `reference_strain` takes it. Either this or `section`.
/// young_modulus, shear_modulus : float, optional
///     E and G in pascals, with Poisson's ratio E/(2G) - 1 in (-1, 0.5]. Needed unless the section is given; in place of the
///     shear modulus there may be `poisson_ratio`.
/// density : float, optional
///     Kilograms per cubic metre. Needed unless the section is given.
/// modes : dict of str to int
///     Number of modes of each strain: keys ``"torsion"``, ``"bend_y"``, ``"bend_z"``, ``"stretch"``,
///     ``"shear_y"``, ``"shear_z"``; what is not named has none and keeps its reference strain.
/// retardation_time : float
///     Kelvin-Voigt damping is this time, in seconds, times the stiffness.
/// reference_strain : array_like, shape (6,), or table or callable or Profile
///     Strain free of stress: torsion, bend_y, bend_z (radians per metre), stretch, shear_y, shear_z. A table is a pair of
///     stations (arc lengths from 0 to `length`, metres) and values, shape (m, 6), interpolated without overshoot; a callable is
///     given the arc length from the segment's base. See `Profile`.
/// shear_correction : float, (float, float) or 'cowper'
///     Factor of the shear stiffness G A, factors for shear along y and along z, or those of Cowper (1966) for the shape and
///     Poisson's ratio.
/// nodes : int, optional
///     Quadrature nodes, rounded up to a multiple of four; by default what the modes need for bends up to about half a turn.
/// basis : {'legendre', 'chebyshev', 'monomial', 'piecewise_constant', 'hermite'}
///     What the modes are, as functions of x = X / length: Legendre or Chebyshev polynomials of 2 x - 1, powers of x, one on
///     each of so many equal pieces, or cubics with value and slope (times the distance of the knots) at equally spaced knots, two
///     modes a knot. In the last two all strains have the same number of modes, or none.
/// section : Section, optional
///     A section of another shape, or one of given stiffness and inertia.
/// poisson_ratio : float, optional
///     Poisson's ratio nu in (-1, 0.5], instead of the shear modulus: G = E/(2 (1 + nu)).
///
/// Raises
/// ------
/// ValueError
///     Naming every parameter that is out of its range.
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
            // A Young's modulus that makes no sense is refused for itself.
            let young_modulus = young_modulus.filter(|modulus| *modulus > 0.0).unwrap_or(1.0);
            let found = rod::shear_modulus(young_modulus, ratio);
            let modulus = found.as_ref().ok().copied();
            check.all(found.map(|_| ()));
            return modulus;
        }
    }
    None
}

#[pymethods]
impl PySegment {
    #[new]
    #[pyo3(signature = (length, radius=None, young_modulus=None, shear_modulus=None, density=None, modes=None, retardation_time=0.0, reference_strain=None, shear_correction=None, nodes=None, *, basis="legendre", section=None, poisson_ratio=None),
           text_signature = "(length, radius=None, young_modulus=None, shear_modulus=None, density=None, modes=None, retardation_time=0.0, reference_strain=(0, 0, 0, 1, 0, 0), shear_correction=1.0, nodes=None, *, basis='legendre', section=None, poisson_ratio=None)")]
    #[allow(clippy::too_many_arguments, reason = "the signature of the Python class")]
    fn new(
        #[pyo3(from_py_with = convert::number)] length: f64,
        radius: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = convert::optional_number)] young_modulus: Option<f64>,
        #[pyo3(from_py_with = convert::optional_number)] shear_modulus: Option<f64>,
        #[pyo3(from_py_with = convert::optional_number)] density: Option<f64>,
        modes: Option<&Bound<'_, PyDict>>,
        #[pyo3(from_py_with = convert::number)] retardation_time: f64,
        reference_strain: Option<&Bound<'_, PyAny>>,
        shear_correction: Option<&Bound<'_, PyAny>>,
        nodes: Option<i64>,
        basis: &str,
        section: Option<&PySection>,
        #[pyo3(from_py_with = convert::optional_number)] poisson_ratio: Option<f64>,
    ) -> PyResult<Self> {
        let basis = Basis::named(basis).ok_or_else(|| {
            let names = Basis::ALL.map(Basis::name);
            PyValueError::new_err(format!("basis: got '{basis}', expected one of {names:?}"))
        })?;
        let mut check = Checker::new();
        let section = match (radius, section) {
            (Some(radius), None) => {
                Section::Shape(Shape::Circle { radius: section::size(radius, Some(length), "radius")? })
            }
            (None, Some(PySection { section, length: over })) => {
                if let Some(over) = *over {
                    let expected = format!("one for the segment's length, {length} m");
                    check.require(over == length, "section", format_args!("one for {over} m"), &expected);
                }
                section.clone()
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
                section::size_out(py, radius, self.0.length).map(Some)
            }
            _ => Ok(None),
        }
    }

    /// What it looks like across.
    #[getter]
    fn section(&self) -> PySection {
        PySection::of(&self.0)
    }

    /// Young's modulus in pascals; None where the section is given.
    #[getter]
    fn young_modulus(&self) -> Option<f64> {
        self.of_material(self.0.young_modulus)
    }

    /// Shear modulus in pascals; None where the section is given.
    #[getter]
    fn shear_modulus(&self) -> Option<f64> {
        self.of_material(self.0.shear_modulus)
    }

    /// Poisson's ratio E/(2G) - 1; None where the section is given.
    #[getter]
    fn poisson_ratio(&self) -> Option<f64> {
        self.of_material(self.0.poisson_ratio())
    }

    /// Density in kilograms per cubic metre; None where the section is given.
    #[getter]
    fn density(&self) -> Option<f64> {
        self.of_material(self.0.density)
    }

    /// Number of modes of each strain that has any.
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

    /// What the modes are: 'legendre', 'chebyshev', 'monomial', 'piecewise_constant' or 'hermite'.
    #[getter]
    fn basis(&self) -> &'static str {
        self.0.basis.name()
    }

    /// Strain free of stress: torsion, bend_y, bend_z, stretch, shear_y, shear_z; a Profile where it varies.
    #[getter]
    fn reference_strain<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let profile = &self.0.reference_strain;
        match profile.constant() {
            Some(strain) => Ok(PyTuple::new(py, strain)?.into_any()),
            None => profile::to_python(profile, &[STRAINS], self.0.length).into_bound_py_any(py),
        }
    }

    /// Factor of the shear stiffness G A, factors for y and for z, or 'cowper'.
    #[getter]
    fn shear_correction<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        section::shear_correction_out(py, self.0.shear_correction)
    }

    /// Quadrature nodes asked for; None for what the modes need. `Rod.nodes` tells what is used.
    #[getter]
    fn nodes(&self) -> Option<usize> {
        self.0.nodes
    }

    /// Stiffness per length of the strains at arc length X from the segment's base.
    ///
    /// Parameters
    /// ----------
    /// X : float
    ///     Metres, from 0 to the segment's length.
    ///
    /// Returns
    /// -------
    /// numpy.ndarray, shape (6, 6)
    ///     In the order torsion, bend_y, bend_z, stretch, shear_y, shear_z; of shapes diagonal.
    #[pyo3(signature = (X=0.0))]
    #[allow(non_snake_case, reason = "arc length is X everywhere")]
    fn stiffness<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = convert::number)] X: f64,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        section::rows(py, &self.properties(X)?.stiffness)
    }

    /// Inertia per length at arc length X from the segment's base.
    ///
    /// Parameters
    /// ----------
    /// X : float
    ///     Metres, from 0 to the segment's length.
    ///
    /// Returns
    /// -------
    /// numpy.ndarray, shape (6, 6)
    ///     Takes a twist (angular velocity, velocity of the rod's axis) to the momentum per length (angular about the axis, linear),
    ///     all in the section's axes.
    #[pyo3(signature = (X=0.0))]
    #[allow(non_snake_case, reason = "arc length is X everywhere")]
    fn inertia<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = convert::number)] X: f64,
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
                let radius = section::size_out(py, radius, *length)?;
                arguments.push(format!("radius={}", radius.repr()?));
            }
            _ => arguments.push(format!("section={}", self.section().__repr__())),
        }
        if let Section::Shape(_) = section {
            let Segment { young_modulus, shear_modulus, density, .. } = &self.0;
            arguments.push(format!(
                "young_modulus={young_modulus:?}, shear_modulus={shear_modulus:?}, density={density:?}"
            ));
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
            None => arguments.set_item("section", self.section())?,
        }
        arguments.set_item("young_modulus", self.young_modulus())?;
        arguments.set_item("shear_modulus", self.shear_modulus())?;
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
    /// What belongs to a material: nothing where the section is given.
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

/// So many poses of the largest rods take some milliseconds.
const POSES_BETWEEN_SIGNALS: usize = 256;

/// The homogeneous matrix of a pose, row by row.
fn homogeneous(pose: &Pose) -> [f64; 16] {
    let Pose { rotation: Rotation { x, y, z }, position: p } = *pose;
    let rows = [x.x, y.x, z.x, p.x, x.y, y.y, z.y, p.y, x.z, y.z, z.z, p.z];
    let mut matrix = [0.0; 16];
    matrix[..12].copy_from_slice(&rows);
    matrix[15] = 1.0;
    matrix
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

/// A Cosserat rod: segments in a row, clamped at the base, with loads and rigid bodies on it.
///
/// The coordinates are the strain modes: segment by segment, then strain by strain (torsion, bend_y, bend_z, stretch,
/// shear_y, shear_z), then by number of the mode (for Legendre polynomials by degree). Segments of piecewise constant
/// strain are ordered piece by piece first, as if they were segments.
///
/// Parameters
/// ----------
/// segments : sequence of Segment
///     From base to tip, at least one.
/// base_position : array_like, shape (3,)
///     Metres.
/// base_orientation : array_like, shape (4,)
///     Unit quaternion (w, x, y, z) that turns body axes into world axes; the rod leaves the base along its body x axis.
/// gravity : array_like, shape (3,)
///     In the world, metres per second squared.
/// tip_force, tip_moment : array_like, shape (3,)
///     Dead loads in world axes, newtons and newton metres. A dead moment has no potential: it does not appear in the
///     energy.
/// tip_mass : float
///     Point mass at the tip, kilograms.
/// loads : sequence of Load
///     Further forces and moments, anywhere on the rod.
/// bodies : sequence of Body
///     Further rigid bodies, anywhere on the rod.
/// base_motion : BaseMotion, optional
///     How the base moves from its position and orientation; it rests by default.
/// supports : sequence of Support
///     Springs and dampers to the world, anywhere on the rod.
/// fluid : Fluid, optional
///     What surrounds the rod; by default nothing does.
///
/// Raises
/// ------
/// ValueError
///     Naming every parameter that is out of its range.
#[pyclass(name = "Rod", module = "lissom", extends = PyModel, frozen)]
pub(crate) struct PyRod {
    description: Rod,
    functions: Functions,
    // A model of its own for kinematics: that of the base class is only known as a Model.
    kinematics: Mutex<RodModel>,
    // What holds a rod in its plane is known in space alone; compiled when it is asked for.
    spatial: OnceLock<RodModel>,
}

impl PyRod {
    /// What it was made from.
    pub(crate) fn description(&self) -> &Rod {
        &self.description
    }

    /// Python objects with the functions of this rod must still be alive.
    pub(crate) fn initializer(description: Rod) -> PyResult<PyClassInitializer<Self>> {
        Python::attach(|py| {
            let functions = Functions::of_rod(py, &description)?;
            let (model, kinematics) = py.detach(|| {
                let model = RodModel::new(&description)?;
                let kinematics = Mutex::new(model.clone());
                Ok::<_, InvalidInput>((PyModel::new(model), kinematics))
            })?;
            Ok(PyClassInitializer::from(model).add_subclass(Self {
                description,
                functions,
                kinematics,
                spatial: OnceLock::new(),
            }))
        })
    }
}

impl PyRod {
    /// The times between which the motion of the base is known.
    fn span(&self) -> [f64; 2] {
        self.kinematics.lock().unwrap_or_else(PoisonError::into_inner).time_span()
    }

    /// A copy of the model in space.
    fn spatial(&self) -> PyResult<RodModel> {
        if let Some(model) = self.spatial.get() {
            return Ok(model.clone());
        }
        let model = RodModel::spatial(&self.description)?;
        Ok(self.spatial.get_or_init(|| model).clone())
    }

    /// A copy of the model at a time.
    fn at(&self, t: Option<f64>) -> PyResult<RodModel> {
        let t = time_of_state(t, self.description.is_moved())?;
        check_time(t, self.span())?;
        let mut model = self.kinematics.lock().unwrap_or_else(PoisonError::into_inner).clone();
        if self.description.base_motion.is_some() {
            or_raised(model.set_time(t))?;
        }
        Ok(model)
    }

    /// Refuses an arc length beyond the rod.
    fn check_place(&self, x: f64) -> PyResult<()> {
        let length = self.description.length();
        if (0.0..=length).contains(&x) {
            return Ok(());
        }
        Err(PyValueError::new_err(format!("X: got {x}, expected an arc length in [0, {length}] (metres)")))
    }

    /// The times of so many states, or one for all of them.
    fn times(&self, t: Option<&Bound<'_, PyAny>>, states: Option<usize>) -> PyResult<Vec<f64>> {
        let Some(t) = t else {
            return time_of_state(None, self.description.is_moved()).map(|t| vec![t]);
        };
        let (times, is_number) = convert::scalar_or_vector(t, "t")?;
        if !is_number && Some(times.len()) != states {
            let expected =
                states.map_or("a number".to_owned(), |k| format!("a number or {k} times, one a state"));
            return Err(PyValueError::new_err(format!(
                "t: expected {expected}, got {}",
                convert::describe(t)
            )));
        }
        times.iter().try_for_each(|&t| check_time(t, self.span()))?;
        Ok(times)
    }
}

#[pymethods]
impl PyRod {
    #[new]
    #[pyo3(signature = (segments, base_position=None, base_orientation=None, gravity=None, tip_force=None, tip_moment=None, tip_mass=0.0, *, loads=None, bodies=None, base_motion=None, supports=None, fluid=None),
           text_signature = "(segments, base_position=(0, 0, 0), base_orientation=(1, 0, 0, 0), gravity=(0, 0, -9.81), tip_force=(0, 0, 0), tip_moment=(0, 0, 0), tip_mass=0.0, *, loads=(), bodies=(), base_motion=None, supports=(), fluid=None)")]
    #[allow(clippy::too_many_arguments, reason = "the signature of the Python class")]
    fn new(
        segments: &Bound<'_, PyAny>,
        base_position: Option<&Bound<'_, PyAny>>,
        base_orientation: Option<&Bound<'_, PyAny>>,
        gravity: Option<&Bound<'_, PyAny>>,
        tip_force: Option<&Bound<'_, PyAny>>,
        tip_moment: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = convert::number)] tip_mass: f64,
        loads: Option<&Bound<'_, PyAny>>,
        bodies: Option<&Bound<'_, PyAny>>,
        base_motion: Option<&Bound<'_, PyBaseMotion>>,
        supports: Option<&Bound<'_, PyAny>>,
        fluid: Option<&Bound<'_, PyFluid>>,
    ) -> PyResult<PyClassInitializer<Self>> {
        let segments = instances(segments, "segments", |segment: &PySegment| segment.0.clone())?;
        let fluid = fluid.map(|fluid| fluid.get().0.clone());
        let mut rod = Rod { tip_mass, fluid, ..Rod::new(segments) };
        if let Some(loads) = loads {
            rod.loads = instances(loads, "loads", |load: &PyLoad| load.load().clone())?;
        }
        if let Some(bodies) = bodies {
            rod.bodies = instances(bodies, "bodies", |body: &PyBody| body.0.clone())?;
        }
        rod.base_motion = base_motion.map(|motion| motion.get().motion().clone());
        if let Some(supports) = supports {
            rod.supports = instances(supports, "supports", |support: &PySupport| support.0.clone())?;
        }
        let mut vectors = [
            (base_position, &mut rod.base_position, "base_position"),
            (gravity, &mut rod.gravity, "gravity"),
            (tip_force, &mut rod.tip_force, "tip_force"),
            (tip_moment, &mut rod.tip_moment, "tip_moment"),
        ];
        for (value, field, name) in &mut vectors {
            if let Some(value) = value {
                **field = convert::array_of(value, name)?;
            }
        }
        if let Some(orientation) = base_orientation {
            rod.base_orientation = convert::array_of(orientation, "base_orientation")?;
        }
        Self::initializer(rod)
    }

    /// The segments, from base to tip.
    #[getter]
    fn segments<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.description.segments.iter().cloned().map(PySegment))
    }

    /// Length of the unstretched rod, metres.
    #[getter]
    fn length(&self) -> f64 {
        self.description.length()
    }

    /// Position of the base, metres.
    #[getter]
    fn base_position(&self) -> (f64, f64, f64) {
        self.description.base_position.into()
    }

    /// Orientation of the base, quaternion (w, x, y, z) as given.
    #[getter]
    fn base_orientation(&self) -> (f64, f64, f64, f64) {
        self.description.base_orientation.into()
    }

    /// How the base moves; None where it rests.
    #[getter]
    fn base_motion(&self, py: Python<'_>) -> PyResult<Option<PyBaseMotion>> {
        self.description.base_motion.as_ref().map(|motion| PyBaseMotion::of(py, motion)).transpose()
    }

    /// Gravity in the world, metres per second squared.
    #[getter]
    fn gravity(&self) -> (f64, f64, f64) {
        self.description.gravity.into()
    }

    /// Dead force at the tip in world axes, newtons.
    #[getter]
    fn tip_force(&self) -> (f64, f64, f64) {
        self.description.tip_force.into()
    }

    /// Dead moment at the tip in world axes, newton metres.
    #[getter]
    fn tip_moment(&self) -> (f64, f64, f64) {
        self.description.tip_moment.into()
    }

    /// Point mass at the tip, kilograms.
    #[getter]
    fn tip_mass(&self) -> f64 {
        self.description.tip_mass
    }

    /// Further loads.
    #[getter]
    fn loads<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let loads = self.description.loads.iter().map(|load| PyLoad::of(py, load));
        PyTuple::new(py, loads.collect::<PyResult<Vec<_>>>()?)
    }

    /// Further rigid bodies.
    #[getter]
    fn bodies<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.description.bodies.iter().cloned().map(PyBody))
    }

    /// Springs and dampers to the world.
    #[getter]
    fn supports<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.description.supports.iter().cloned().map(PySupport))
    }

    /// What surrounds the rod, or None.
    #[getter]
    fn fluid(&self) -> Option<PyFluid> {
        self.description.fluid.clone().map(PyFluid)
    }

    /// Number of quadrature nodes of each segment.
    #[getter]
    fn nodes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let kinematics = self.kinematics.lock().unwrap_or_else(PoisonError::into_inner);
        PyTuple::new(py, kinematics.nodes())
    }

    /// What the rod is computed by: "planar" where its modes and reference strains keep it in one plane, else "spatial".
    #[getter]
    fn kernel(&self) -> &'static str {
        match self.kinematics.lock().unwrap_or_else(PoisonError::into_inner).kernel() {
            Kernel::Planar => "planar",
            Kernel::Spatial => "spatial",
        }
    }

    /// Multiplications of doubles that one evaluation takes, by what is evaluated.
    ///
    /// ``"residual"``: inverse dynamics; ``"tangent"``: the Jacobian of an implicit step, where the residual is
    /// known; ``"mass_matrix"``: where the shape is known; ``"factorisation"`` (LU) and ``"solution"`` of a step's
    /// linear system. A multiply-add counts as one.
    #[getter]
    fn multiplications<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let kinematics = self.kinematics.lock().unwrap_or_else(PoisonError::into_inner);
        let Multiplications { residual, tangent, mass_matrix, factorisation, solution } =
            kinematics.multiplications();
        let counts = PyDict::new(py);
        counts.set_item("residual", residual)?;
        counts.set_item("tangent", tangent)?;
        counts.set_item("mass_matrix", mass_matrix)?;
        counts.set_item("factorisation", factorisation)?;
        counts.set_item("solution", solution)?;
        Ok(counts)
    }

    /// What is computed for this rod, what is skipped because it has no part in it, and why, and how many multiplications
    /// the evaluations take; to be printed.
    fn explain(&self) -> String {
        self.kinematics.lock().unwrap_or_else(PoisonError::into_inner).explanation().to_string()
    }

    /// Poses of sections.
    ///
    /// Parameters
    /// ----------
    /// q : array_like, shape (n,) or (k, n)
    ///     Coordinates, or those of k states.
    /// X : float or array_like, shape (m,)
    ///     Arc lengths of the unstretched rod, 0 <= X <= length, metres.
    /// t : float or array_like, shape (k,), optional
    ///     The time, or those of k states, seconds; needed where the base moves.
    ///
    /// Returns
    /// -------
    /// pose : ndarray, shape (4, 4) for a number, (m, 4, 4) for an array; (k, 4, 4) and (k, m, 4, 4) for k states
    ///     Homogeneous transformations from body to world: ``pose[..., :3, :3]`` has the body axes as columns,
    ///     ``pose[..., :3, 3]`` is the position in metres.
    #[pyo3(signature = (q, X, *, t=None))]
    #[allow(non_snake_case, reason = "X is the arc length of the unstretched rod everywhere in this field")]
    fn pose<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        X: &Bound<'py, PyAny>,
        t: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = q.py();
        let n = self.description.coordinates();
        let (states, number_of_states) = convert::finite_rows_of(q, n, "q")?;
        let (places, is_number) = convert::scalar_or_vector(X, "X")?;
        let length = self.description.length();
        if let Some(place) = places.iter().find(|place| !(0.0..=length).contains(*place)) {
            return Err(PyValueError::new_err(format!(
                "X: got {place}, expected arc lengths in [0, {length}] (metres)"
            )));
        }
        let rows = number_of_states.unwrap_or(1);
        let times = self.times(t, number_of_states)?;
        let shape: Vec<usize> =
            number_of_states.into_iter().chain((!is_number).then_some(places.len())).chain([4, 4]).collect();
        // Locked without the interpreter, and for one place or pose at a time: signal handlers may ask this very rod.
        let model = || self.kinematics.lock().unwrap_or_else(PoisonError::into_inner);
        let answer_signals = |done: usize| {
            let is_time = done > 0 && done.is_multiple_of(POSES_BETWEEN_SIGNALS);
            if is_time { Python::attach(|py| py.check_signals()) } else { Ok(()) }
        };
        let poses = py.detach(|| {
            // Functions of time may ask it while they are called.
            let mut moving = self.description.base_motion.is_some().then(|| model().clone());
            let places = places
                .into_iter()
                .enumerate()
                .map(|(i, x)| answer_signals(i).map(|()| model().place(x)))
                .collect::<PyResult<Vec<Place>>>()?;
            let mut poses = Vec::with_capacity(16 * rows * places.len());
            for row in 0..rows {
                let q = &states[row * n..(row + 1) * n];
                if let Some(moving) = &mut moving {
                    or_raised(moving.set_time(times[row % times.len()]))?;
                }
                for place in &places {
                    answer_signals(poses.len() / 16)?;
                    let pose = match &mut moving {
                        Some(moving) => moving.pose_at(q, place),
                        None => model().pose_at(q, place),
                    };
                    poses.extend(homogeneous(&pose));
                }
            }
            Ok::<_, PyErr>(poses)
        })?;
        check_finite(&poses, "pose")?;
        Ok(poses.into_pyarray(py).reshape(shape)?.into_any())
    }

    /// Jacobian of the pose at a place along the rod.
    ///
    /// Parameters
    /// ----------
    /// q : array_like, shape (n,)
    ///     Coordinates.
    /// X : float
    ///     Arc length of the unstretched rod from its base, metres.
    /// t : float, optional
    ///     The time of the state, seconds; needed where the base moves.
    ///
    /// Returns
    /// -------
    /// jacobian : ndarray, shape (6, n)
    ///     ``jacobian @ qd`` is the angular velocity of the section at X and the velocity of its centre, in world axes, on a base
    ///     that does not move (else `velocity` adds that of the base);
    ///     ``jacobian.T @ wrench`` are the generalised forces of a moment and a force that act there.
    #[pyo3(signature = (q, X, *, t=None))]
    #[allow(non_snake_case, reason = "X is the arc length of the unstretched rod everywhere in this field")]
    fn jacobian<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = convert::number)] X: f64,
        #[pyo3(from_py_with = convert::optional_number)] t: Option<f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let q_values = convert::finite_vector_of(q, self.description.coordinates(), "q")?;
        self.check_place(X)?;
        let mut jacobian = Matrix::zeros(6, q_values.len());
        let mut model = self.at(t)?;
        let place = model.place(X);
        model.jacobian_at(&q_values, &place, &mut jacobian);
        check_finite(jacobian.as_slice(), "jacobian")?;
        Ok(convert::matrix_out(q.py(), &jacobian))
    }

    /// Velocity of a place along the rod.
    ///
    /// Parameters
    /// ----------
    /// q, qd : array_like, shape (n,)
    ///     Coordinates, velocities.
    /// X : float
    ///     Arc length of the unstretched rod from its base, metres.
    /// t : float, optional
    ///     The time of the state, seconds; needed where the base moves.
    ///
    /// Returns
    /// -------
    /// velocity : ndarray, shape (6,)
    ///     Angular velocity of the section at X, rad/s, and velocity of its centre, m/s, in world axes, with those of the base.
    #[pyo3(signature = (q, qd, X, *, t=None))]
    #[allow(non_snake_case, reason = "X is the arc length of the unstretched rod everywhere in this field")]
    fn velocity<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = convert::number)] X: f64,
        #[pyo3(from_py_with = convert::optional_number)] t: Option<f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let n = self.description.coordinates();
        let (q, qd) = (convert::finite_vector_of(q, n, "q")?, convert::finite_vector_of(qd, n, "qd")?);
        self.check_place(X)?;
        let mut model = self.at(t)?;
        let place = model.place(X);
        let velocity: Vec<f64> =
            model.velocity_at(&q, &qd, &place).into_iter().flat_map(|half| half.to_array()).collect();
        check_finite(&velocity, "velocity")?;
        Ok(velocity.into_pyarray(py))
    }

    /// Moment and force that the base exerts on the rod in a motion.
    ///
    /// Parameters
    /// ----------
    /// q, qd, qdd : array_like, shape (n,)
    ///     Coordinates, velocities, accelerations.
    /// t : float, optional
    ///     The time of the state, seconds; needed where loads vary or the base moves.
    ///
    /// Returns
    /// -------
    /// wrench : ndarray, shape (6,)
    ///     Moment about the base, newton metres, and force, newtons, in world axes.
    #[pyo3(signature = (q, qd, qdd, *, t=None))]
    fn base_wrench<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qd: &Bound<'py, PyAny>,
        qdd: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = convert::optional_number)] t: Option<f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let n = self.description.coordinates();
        let state = |value, name| convert::finite_vector_of(value, n, name);
        let (q, qd, qdd) = (state(q, "q")?, state(qd, "qd")?, state(qdd, "qdd")?);
        let mut model = self.spatial()?;
        let t = time_of_state(t, self.description.depends_on_time())?;
        check_time(t, self.span())?;
        or_raised(model.set_time(t))?;
        let wrench = model.base_wrench(&q, &qd, &qdd);
        let wrench: Vec<f64> = wrench.into_iter().flat_map(|half| half.to_array()).collect();
        check_finite(&wrench, "base_wrench")?;
        Ok(wrench.into_pyarray(py))
    }

    fn __repr__(&self) -> String {
        let segments = self.description.segments.len();
        let plural = if segments == 1 { "" } else { "s" };
        format!(
            "<lissom.Rod of {segments} segment{plural}, {:?} m long, n = {}>",
            self.description.length(),
            self.description.coordinates()
        )
    }

    /// For copies and pickles.
    fn __getnewargs_ex__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<((Bound<'py, PyTuple>,), Bound<'py, PyDict>)> {
        let rod = &self.description;
        let arguments = PyDict::new(py);
        arguments.set_item("base_position", rod.base_position)?;
        arguments.set_item("base_orientation", rod.base_orientation)?;
        arguments.set_item("gravity", rod.gravity)?;
        arguments.set_item("tip_force", rod.tip_force)?;
        arguments.set_item("tip_moment", rod.tip_moment)?;
        arguments.set_item("tip_mass", rod.tip_mass)?;
        arguments.set_item("loads", self.loads(py)?)?;
        arguments.set_item("bodies", self.bodies(py)?)?;
        arguments.set_item("base_motion", self.base_motion(py)?)?;
        arguments.set_item("supports", self.supports(py)?)?;
        arguments.set_item("fluid", self.fluid())?;
        Ok(((self.segments(py)?,), arguments))
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        self.functions.traverse(&visit)
    }
}

/// What `core` makes of the instances of a class of ours in a sequence.
fn instances<C: PyClass<Frozen = True> + Sync, T>(
    value: &Bound<'_, PyAny>,
    name: &str,
    core: impl Fn(&C) -> T,
) -> PyResult<Vec<T>> {
    let wrong = |found: &Bound<'_, PyAny>| {
        PyTypeError::new_err(format!(
            "{name}: expected a sequence of lissom.{}, got {}",
            C::NAME,
            convert::describe(found)
        ))
    };
    let mut instances = Vec::new();
    for item in value.try_iter().map_err(|_| wrong(value))? {
        let item = item?;
        instances.push(core(item.cast::<C>().map_err(|_| wrong(&item))?.get()));
    }
    Ok(instances)
}
