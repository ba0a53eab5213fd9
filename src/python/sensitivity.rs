//! The part of `lissom.sensitivity` that calls the core.

use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use super::arguments;
use super::callback::Raised;
use super::convert::{self, Numbers};
use super::errors::{LissomError, OrRaise as _};
use super::model::{Native, PyModel, model_of};
use super::motion::Ticker;
use super::segment::PySegment;
use crate::description::rod::{SectionProperties, Segment};
use crate::error::{Interrupted, Time};
use crate::integrators::newmark::{Parameters, Scheme};
use crate::model::{InertiaMatrix, SectionPlace};
use crate::numerics::linalg::Matrix;
use crate::simulation::sensitivity;
use crate::simulation::sensitivity::{
    Failure, ForceDerivative, Interval, Lengths, OfInertia, Parameter, Rule, Sections, Together, Trajectory,
};

/// Models with a varied parameter, with their weights in the derivative with respect to it.
type Terms = Vec<(Py<PyModel>, f64)>;

/// First coordinate of a segment, and the derivatives of its generalised stiffness and damping with respect
/// to a parameter.
type Material<'py> = (usize, Bound<'py, PyAny>, Bound<'py, PyAny>);

/// A `Material`, the number of the segment, and segments with varied sections, with their weights in the
/// derivative.
type OfSection<'py> = (usize, Bound<'py, PyAny>, Bound<'py, PyAny>, usize, Vec<(Py<PySegment>, f64)>);

/// How forces depend on a parameter.
#[derive(FromPyObject)]
pub(crate) enum Dependence<'py> {
    Models(Terms),
    Material(Material<'py>),
    Section(OfSection<'py>),
    /// Number of an interval and number of an input.
    Input((usize, usize)),
    /// Number of the segment whose length is the parameter.
    Length(usize),
}

/// Derivatives of a run with fixed steps of the Newmark family or with Radau IIA: forward derivatives of all
/// states, or the adjoint derivative of a number.
///
/// See `lissom.sensitivity` for their definition.
///
/// Parameters
/// ----------
/// model : Model
///     The model that was simulated.
/// t : array_like, shape (m,)
/// q, v, a : array_like, shape (m, n)
///     All accepted steps.
/// forces : list
/// For each of p parameters a list of (Model, float), models whose weighted sum of forces is their derivative, empty for what no
/// force depends on; or for a segment's material (first coordinate, dK/dp, dD/dp), its k coordinates' stiffness and damping,
/// shapes (k, k); or with `weights` for its section the same and (number of the segment, list of (Segment, float)), segments
/// whose weighted sum of inertias is the derivative; or with `weights` for a length the number of the segment; or for an input
/// (number of the interval, number of the input).
/// dq0, dv0 : array_like, shape (n, p)
///     Derivatives of the initial state with respect to the parameters.
/// intervals : list of (int, array_like of shape (inputs,)), optional
///     Indices of the states at which inputs change, beginning with 0, and the new inputs; `a` at these
///     states is with the new inputs.
/// weights : pair of array_like, shape (m, n), optional
///     Derivatives of the number with respect to `q` and `v`.
///
/// Returns
/// -------
/// tuple of ndarray
///     Two of shape (m, n, p), or with `weights` one of shape (p,).
///
/// Raises
/// ------
/// ValueError, TypeError
///     If an argument is invalid.
/// LissomError
///     If the matrix of a step is singular.
#[pyfunction]
#[pyo3(signature = (model, t, q, v, a, forces, dq0, dv0, *, method="newmark", beta=None, gamma=None, alpha=None, rho_inf=None, intervals=None, weights=None))]
#[allow(clippy::too_many_arguments, reason = "a run, and what is asked of it")]
pub(crate) fn sensitivities<'py>(
    #[pyo3(from_py_with = model)] model: &Bound<'py, PyModel>,
    t: &Bound<'py, PyAny>,
    q: &Bound<'py, PyAny>,
    v: &Bound<'py, PyAny>,
    a: &Bound<'py, PyAny>,
    forces: Vec<Dependence<'py>>,
    dq0: &Bound<'py, PyAny>,
    dv0: &Bound<'py, PyAny>,
    #[pyo3(from_py_with = arguments::text::method)] method: &str,
    beta: Option<f64>,
    gamma: Option<f64>,
    alpha: Option<f64>,
    rho_inf: Option<f64>,
    intervals: Option<Vec<(usize, Bound<'py, PyAny>)>>,
    weights: Option<(Bound<'py, PyAny>, Bound<'py, PyAny>)>,
) -> PyResult<Bound<'py, PyTuple>> {
    let py = model.py();
    let mut native = model.get().native();
    let n = native.facts().n;
    let rule = rule_of(method, &Parameters { beta, gamma, alpha, rho_inf })?;
    let t = convert::vector(t, "t")?;
    sensitivity::check(&mut *native, rule, &t).or_raise()?;
    if t.is_empty() {
        return Err(PyValueError::new_err("t: got no times, expected at least the start"));
    }
    let states = |value: &Bound<'_, PyAny>, name: &str| {
        let Numbers { values, shape } = convert::numbers(value, name, "an array of shape (m, n)")?;
        if shape == [t.len(), n] {
            return Ok(values);
        }
        Err(PyValueError::new_err(format!("{name}: got shape {shape:?}, expected [{}, {n}]", t.len())))
    };
    let (q, v, a) = (states(q, "q")?, states(v, "v")?, states(a, "a")?);
    let weights = match &weights {
        Some((on_q, on_v)) => Some((states(on_q, "weights[0]")?, states(on_v, "weights[1]")?)),
        None => None,
    };
    let p = forces.len();
    let places = native.facts().section_places.clone();
    let (dq0, dv0) = (convert::matrix_of(dq0, (n, p), "dq0")?, convert::matrix_of(dv0, (n, p), "dv0")?);
    let OfParameters { forces, sections, lengths } = of_parameters(&forces, n, &places)?;
    if !(sections.is_empty() && lengths.is_empty()) && weights.is_none() {
        return Err(PyValueError::new_err("forces: derivatives by sections or lengths need weights"));
    }
    let free = native.facts().free_lengths;
    check_lengths(&lengths, free)?;
    let together =
        Together { sections: Sections::new(sections, places.len()), lengths: Lengths::new(lengths, free) };
    let intervals = intervals_of(intervals.unwrap_or_default(), t.len(), native.facts().inputs())?;
    let trajectory = Trajectory { t: &t, q: &q, v: &v, a: &a, rule, intervals: &intervals };
    let inputs = native.facts().inputs();
    if forces.iter().any(|force| matches!(force, Force::Input(i, k) if *i >= intervals.len() || *k >= inputs))
    {
        return Err(PyValueError::new_err(
            "forces: got an input of no interval, expected one of `intervals`",
        ));
    }
    let mut raised = Raised::default();
    let mut ticker = Ticker::new();
    let computed = py.detach(|| {
        let mut monitor = || {
            if !ticker.tick() {
                return Ok(());
            }
            raised.catch(Python::attach(|py| py.check_signals()))
        };
        let weights = weights.as_ref().map(|(q, v)| [q.as_slice(), v.as_slice()]);
        compute(&mut *native, &trajectory, (forces, together), [&dq0, &dv0], weights, &mut monitor)
    });
    raised.into_result()?;
    let computed = computed.map_err(|failure| in_words(&failure, &t))?;
    let arrays = computed.into_iter().map(|values| {
        let array = values.into_pyarray(py);
        if weights.is_some() { Ok(array.into_any()) } else { Ok(array.reshape([t.len(), n, p])?.into_any()) }
    });
    PyTuple::new(py, arrays.collect::<PyResult<Vec<_>>>()?)
}

/// Refuses lengths on which other things than their rods depend.
fn check_lengths(lengths: &[[usize; 2]], free: usize) -> PyResult<()> {
    let Some([_, segment]) = lengths.iter().find(|[_, segment]| *segment >= free) else { return Ok(()) };
    Err(PyValueError::new_err(format!(
        "forces: got the length of segment {segment}, expected one of {free} on which nothing else depends"
    )))
}

/// How the steps of a run were taken.
fn rule_of(method: &str, given: &Parameters) -> PyResult<Rule> {
    match method {
        "radau" if given.is_empty() => Ok(Rule::Radau),
        "radau" => {
            let expected = "beta, gamma, alpha, rho_inf: options of the Newmark family, which Radau's method does not have: leave them out";
            Err(PyValueError::new_err(expected))
        }
        _ => Ok(Rule::Newmark(Scheme::by_name(method, given).or_raise()?)),
    }
}

/// Why a run with these times has no derivatives.
fn in_words(failure: &Failure, t: &[f64]) -> PyErr {
    match failure {
        Failure::Singular(step) => LissomError::new_err(format!(
            "the matrix of the step that ends at t = {} s is singular or not finite: there are no derivatives",
            Time(t[*step])
        )),
        Failure::Turned(step) => LissomError::new_err(format!(
            "a spherical or free joint passes half a turn at t = {} s, where its coordinates change: runs are differentiated up to there",
            Time(t[*step])
        )),
        Failure::Interrupted => {
            LissomError::new_err("a function of time failed while derivatives were computed")
        }
    }
}

/// The models of a parameter, or the derivatives of the material.
enum Force {
    Models(Vec<(Box<dyn Native>, f64)>),
    Material(usize, [Matrix; 2]),
    Input(usize, usize),
}

fn intervals_of(
    given: Vec<(usize, Bound<'_, PyAny>)>,
    states: usize,
    inputs: usize,
) -> PyResult<Vec<Interval>> {
    let mut intervals: Vec<Interval> = Vec::with_capacity(given.len());
    for (first, u) in given {
        let is_next = intervals.last().map_or(first == 0, |before| before.first < first);
        if !is_next || first >= states {
            return Err(PyValueError::new_err(format!(
                "intervals[{}]: got a beginning of {first}, expected 0 and then ascending numbers below {states}",
                intervals.len()
            )));
        }
        intervals.push(Interval { first, inputs: convert::finite_vector_of(&u, inputs, "intervals")? });
    }
    Ok(intervals)
}

/// The forces of all parameters, the contributions of the inertia of sections, and the parameters that are
/// lengths, with their segments.
struct OfParameters {
    forces: Vec<Force>,
    sections: Vec<OfInertia>,
    lengths: Vec<[usize; 2]>,
}

fn of_parameters(
    dependences: &[Dependence<'_>],
    n: usize,
    places: &[SectionPlace],
) -> PyResult<OfParameters> {
    let (mut sections, mut lengths) = (Vec::new(), Vec::new());
    let mut forces = Vec::with_capacity(dependences.len());
    for (parameter, dependence) in dependences.iter().enumerate() {
        forces.push(match dependence {
            Dependence::Models(terms) => Force::Models(of_models(terms, n)?),
            Dependence::Input((interval, input)) => Force::Input(*interval, *input),
            Dependence::Length(segment) => {
                lengths.push([parameter, *segment]);
                Force::Models(Vec::new())
            }
            Dependence::Material((first, stiffness, damping)) => {
                of_material(*first, [stiffness, damping], n)?
            }
            Dependence::Section((first, stiffness, damping, segment, terms)) => {
                sections
                    .push(OfInertia { parameter, at: of_inertia(stiffness.py(), *segment, terms, places)? });
                of_material(*first, [stiffness, damping], n)?
            }
        });
    }
    Ok(OfParameters { forces, sections, lengths })
}

fn of_material(first: usize, [stiffness, damping]: [&Bound<'_, PyAny>; 2], n: usize) -> PyResult<Force> {
    let size = convert::numbers(stiffness, "forces", "an array of shape (k, k)")?.shape;
    let k = size.first().copied().unwrap_or(0);
    if first.checked_add(k).is_none_or(|end| end > n) {
        return Err(PyValueError::new_err(format!(
            "forces: got {k} coordinates from {first} on, expected some of {n}"
        )));
    }
    let block = |value| convert::matrix_of(value, (k, k), "forces");
    Ok(Force::Material(first, [block(stiffness)?, block(damping)?]))
}

/// The weighted sums of the inertia matrices of segments, at the places of one segment, and the numbers of
/// these places.
fn of_inertia(
    py: Python<'_>,
    segment: usize,
    terms: &[(Py<PySegment>, f64)],
    places: &[SectionPlace],
) -> PyResult<Vec<(usize, InertiaMatrix)>> {
    let resolved = |(segment, weight): &(Py<PySegment>, f64)| Ok((PySegment::of(segment.bind(py))?, *weight));
    let terms = terms.iter().map(resolved).collect::<PyResult<Vec<_>>>()?;
    let own = places.iter().enumerate().filter(|(_, place)| place.segment == segment);
    let at: Vec<_> = own.map(|(number, place)| (number, change_of_inertia(&terms, place.x))).collect();
    if at.is_empty() {
        return Err(PyValueError::new_err(format!(
            "forces: got segment {segment}, expected one of a model whose sections act on forces along rods alone"
        )));
    }
    Ok(at)
}

fn change_of_inertia(terms: &[(Segment, f64)], x: f64) -> InertiaMatrix {
    let mut sum = [[0.0; 6]; 6];
    for (segment, weight) in terms {
        let inertia = SectionProperties::at(segment, x).inertia_matrix();
        for (sum, entry) in sum.iter_mut().flatten().zip(inertia.iter().flatten()) {
            *sum += weight * entry;
        }
    }
    sum
}

/// Whether the inertia of sections affects only the forces along their own rods.
#[pyfunction]
pub(crate) fn has_separate_sections(#[pyo3(from_py_with = model)] model: &Bound<'_, PyModel>) -> bool {
    model.get().inspect(|model| !model.facts().section_places.is_empty())
}

/// Whether the lengths of segments affect only their own rods.
#[pyfunction]
pub(crate) fn has_free_lengths(#[pyo3(from_py_with = model)] model: &Bound<'_, PyModel>) -> bool {
    model.get().inspect(|model| model.facts().free_lengths > 0)
}

/// Whether some forces may act only in part of the states.
#[pyfunction]
pub(crate) fn has_one_sided_forces(#[pyo3(from_py_with = model)] model: &Bound<'_, PyModel>) -> bool {
    model.get().inspect(|model| model.facts().has_one_sided_forces)
}

fn of_models(terms: &Terms, n: usize) -> PyResult<Vec<(Box<dyn Native>, f64)>> {
    let natives = terms.iter().map(|(model, weight)| (model.get().native(), *weight));
    let natives: Vec<_> = natives.collect();
    match natives.iter().find(|(model, _)| model.facts().n != n) {
        Some((model, _)) => Err(PyTypeError::new_err(format!(
            "forces: got a model of {} coordinates, expected {n}: parameters must not change their number",
            model.facts().n
        ))),
        None => Ok(natives),
    }
}

fn compute(
    model: &mut dyn Native,
    trajectory: &Trajectory<'_>,
    (forces, mut together): (Vec<Force>, Together),
    [dq0, dv0]: [&Matrix; 2],
    weights: Option<[&[f64]; 2]>,
    monitor: &mut dyn FnMut() -> Result<(), Interrupted>,
) -> Result<Vec<Vec<f64>>, Failure> {
    let n = dq0.nrows();
    let is_steered = !trajectory.intervals.is_empty();
    let parameter = |force| match force {
        Force::Models(terms) if terms.is_empty() => Ok(Parameter::Start),
        Force::Models(terms) => {
            ForceDerivative::new(terms, n, is_steered).map(Box::new).map(Parameter::Model)
        }
        Force::Material(first, [stiffness, damping]) => {
            let force = ForceDerivative::of_material(first, [&stiffness, &damping], n);
            Ok(Parameter::Model(Box::new(force)))
        }
        Force::Input(interval, input) => Ok(Parameter::Input { interval, input }),
    };
    let mut of = forces.into_iter().map(parameter).collect::<Result<Vec<_>, Interrupted>>()?;
    let mut parameters = sensitivity::Parameters { dq0, dv0, of: &mut of };
    match weights {
        Some(weights) => {
            sensitivity::adjoint(model, trajectory, weights, &mut parameters, &mut together, monitor)
                .map(|gradient| vec![gradient])
        }
        None => sensitivity::forward(model, trajectory, &mut parameters, monitor).map(Vec::from),
    }
}

/// The argument `model`.
fn model<'a, 'py>(value: &'a Bound<'py, PyAny>) -> PyResult<&'a Bound<'py, PyModel>> {
    model_of(value, "model")
}
