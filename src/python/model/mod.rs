//! The base class of all models: [`crate::model::Model`] with checked arrays.

mod energy;
mod given;
mod native;
mod stepped;

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use super::arguments;
use super::callback::or_raised;
use super::convert;
use super::errors::{LissomError, OrRaise as _, check_finite};
use super::inputs::{mapping_of, set_named};
use crate::analysis::weakly_active;
use crate::description::signal::covers;
use crate::model::{ForwardScratch, SingularMass};
use crate::numerics::linalg::Matrix;
use crate::python::words::required;
use crate::robot::{Robot, RobotModel};

pub(super) use self::energy::PyEnergy;
pub(super) use self::given::{
    MODEL, any_model_of, check_model, measured_places, model_of, not_a_model, of_file, scales_of,
};
pub(super) use self::native::Native;
pub(super) use self::stepped::Stepped;

/// Base class of mechanical systems with n generalised coordinates: `SpringPendulum`, `Rod` and `Robot`.
///
/// Arguments `q`, `qd`, `qdd` are array-likes of shape (n,): coordinates, velocities and accelerations in SI units.
/// Models are immutable and can be used from several threads at once.
#[pyclass(name = "Model", module = "lissom", subclass, frozen)]
pub(crate) struct PyModel {
    n: usize,
    varies_in_time: bool,
    depends_on_time: bool,
    /// The first segment whose modes are open, in words.
    open: Option<String>,
    memory: Arc<Mutex<Memory>>,
}

/// The model and memory for results. Never locked while Python code runs.
struct Memory {
    model: Box<dyn Native>,
    /// Made on first use.
    forward: Option<ForwardScratch>,
}

impl Memory {
    fn forward_dynamics(&mut self, q: &[f64], qd: &[f64], qdd: &mut [f64]) -> Result<(), SingularMass> {
        let Self { model, forward } = self;
        let scratch = forward.get_or_insert_with(|| ForwardScratch::of(&**model));
        model.forward_dynamics(q, qd, qdd, scratch)
    }
}

/// The memory of a model from which its classes make further ones.
#[derive(Clone)]
pub(super) struct Source(Arc<Mutex<Memory>>);

impl Source {
    /// A copy of the model of a robot.
    pub(super) fn robot_model(&self) -> RobotModel {
        let mut memory = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        memory.model.robot_model().expect("the class of robots has models of robots").clone()
    }
}

impl Clone for Memory {
    fn clone(&self) -> Self {
        Self { model: self.model.boxed_clone(), forward: self.forward.clone() }
    }
}

impl PyModel {
    pub(crate) fn new(model: impl Native + 'static) -> Self {
        let (n, varies_in_time) = (model.facts().n, model.facts().varies_in_time);
        // A prescribed constant pose of the base is also applied by setting a time.
        let depends_on_time = model.robot().map_or(varies_in_time, Robot::depends_on_time);
        let open = model.robot().and_then(open_modes);
        Self {
            n,
            varies_in_time,
            depends_on_time,
            open,
            memory: Arc::new(Mutex::new(Memory { model: Box::new(model), forward: None })),
        }
    }

    /// Number of generalised coordinates; of a model with open modes, one of what stands in for it.
    pub(super) fn n(&self) -> usize {
        self.n
    }

    /// Whether modes are open, so that there are no coordinates yet.
    pub(crate) fn is_open(&self) -> bool {
        self.open.is_some()
    }

    /// Refuses a model with open modes.
    pub(crate) fn check_modes(&self) -> PyResult<()> {
        self.open.as_ref().map_or(Ok(()), |segment| Err(refusal_of_open_modes(segment)))
    }

    /// A fact of the model, without a copy.
    pub(crate) fn inspect<T>(&self, at: impl FnOnce(&dyn Native) -> T) -> T {
        at(&*self.memory().model)
    }

    /// A copy of the model for a separate run.
    pub(crate) fn native(&self) -> Box<dyn Native> {
        self.memory().model.boxed_clone()
    }

    /// For models that are made on first use.
    pub(super) fn source(&self) -> Source {
        Source(self.memory.clone())
    }

    fn memory(&self) -> MutexGuard<'_, Memory> {
        // A panic cannot break invariants of scratch memory.
        self.memory.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Evaluates the model at the time of a state with these inputs.
    fn at<T>(
        &self,
        t: Option<f64>,
        u: Option<&Bound<'_, PyAny>>,
        evaluate: impl FnOnce(&mut Memory) -> T,
    ) -> PyResult<T> {
        let t = time_of_state(t, self.depends_on_time)?;
        check_time(t, self.memory().model.facts().time_span)?;
        let u = u.map(|u| self.inputs_of(u)).transpose()?;
        if !self.varies_in_time {
            let mut memory = self.memory();
            let Some(u) = u else { return Ok(evaluate(&mut memory)) };
            memory.model.set_inputs(&u);
            let result = evaluate(&mut memory);
            let defaults = memory.model.facts().default_inputs.clone();
            memory.model.set_inputs(&defaults);
            return Ok(result);
        }
        // Evaluate on a copy: functions of time may be Python code that uses this model.
        let mut memory = self.memory().clone();
        if let Some(u) = u {
            memory.model.set_inputs(&u);
        }
        or_raised(memory.model.set_time(t))?;
        if let Some(what) = memory.model.not_finite() {
            return Err(PyValueError::new_err(format!("{what}, expected finite numbers")));
        }
        Ok(evaluate(&mut memory))
    }

    /// Names of the inputs.
    pub(super) fn input_names(&self) -> Vec<String> {
        self.memory().model.robot().map_or_else(Vec::new, |robot| robot.inputs().names())
    }

    /// Default values of the inputs.
    pub(super) fn default_inputs(&self) -> Vec<f64> {
        self.memory().model.robot().map_or_else(Vec::new, |robot| robot.inputs().defaults().to_vec())
    }

    /// Values for all inputs, from an array or from a mapping of names; the default of an input that the mapping leaves out.
    pub(super) fn inputs_of(&self, u: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
        if let Some(mapping) = mapping_of(u) {
            let mut inputs = self.default_inputs();
            return set_named(mapping, &self.input_names(), &mut inputs, "u").map(|()| inputs);
        }
        convert::finite_vector_of(u, self.memory().model.facts().inputs(), "u")
    }

    fn state(&self, value: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec<f64>> {
        self.check_modes()?;
        convert::finite_vector_of(value, self.n, name)
    }
}

/// The first segment of a robot whose modes are open, in words.
fn open_modes(robot: &Robot) -> Option<String> {
    robot.open_segments().first().map(|&segment| robot.name_of_segment(segment))
}

/// Refuses a robot with open modes.
pub(super) fn check_modes(robot: &Robot) -> PyResult<()> {
    open_modes(robot).map_or(Ok(()), |segment| Err(refusal_of_open_modes(&segment)))
}

fn refusal_of_open_modes(segment: &str) -> PyErr {
    PyValueError::new_err(format!(
        "modes: {segment} has modes=\"auto\", and coordinates belong to numbers of modes: `lissom.choose_modes(robot, rtol=1e-3)` \
         returns the robot with those that its equilibrium takes, with `t_end` those of a motion; `statics`, `modes` and \
         `simulate(..., method=\"auto\")` choose them by themselves"
    ))
}

/// Time of a state, which is required if anything depends on it.
pub(super) fn time_of_state(t: Option<f64>, matters: bool) -> PyResult<f64> {
    match t {
        Some(t) => Ok(t),
        None if matters => Err(PyTypeError::new_err(NO_TIME)),
        None => Ok(0.0),
    }
}

/// Message for a missing time.
pub(super) const NO_TIME: &str = "t: got none, expected the time of the state in seconds: this model has loads or \
                                  actuators that vary, or a base or joints that move as prescribed (of a MotionResult, the times are its attribute `t`)";

/// Rejects invalid times, and times at which a model is not defined.
pub(super) fn check_time(t: f64, [from, to]: [f64; 2]) -> PyResult<()> {
    if t.is_finite() && covers([from, to], t) {
        return Ok(());
    }
    let is_unbounded = from == f64::NEG_INFINITY && to == f64::INFINITY;
    let expected = if t.is_finite() && !is_unbounded {
        format!("a time in [{from}, {to}] (seconds), where all prescribed motion is known")
    } else {
        "a finite number (seconds)".to_owned()
    };
    Err(PyValueError::new_err(format!("t: got {t}, expected {expected}")))
}

#[pymethods]
impl PyModel {
    /// Number of generalised coordinates.
    #[getter]
    #[pyo3(name = "n")]
    fn coordinates(&self) -> PyResult<usize> {
        self.check_modes().map(|()| self.n)
    }

    /// Names of the inputs, in the order of u.
    #[getter]
    pub(super) fn inputs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.input_names())
    }

    /// Default values of the inputs, shape (m,).
    #[getter]
    fn u0<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.default_inputs().into_pyarray(py)
    }

    /// Exact derivatives of the inverse dynamics with respect to the inputs.
    ///
    /// Parameters
    /// ----------
    /// q : array_like, shape (n,)
    ///     Coordinates.
    /// qd, qdd : array_like, shape (n,), optional
    ///     Velocities and accelerations; by default zero.
    /// t : float, optional
    ///     Time of the state, seconds. Required if anything varies in time.
    /// u : array_like, shape (m,), or dict, optional
    ///     Inputs, or some of them by name; by default `u0`.
    ///
    /// Returns
    /// -------
    /// dtau_du : ndarray, shape (n, m)
    ///     Derivatives of the generalised forces. A small change of the inputs changes the accelerations by
    ///     ``-solve(mass_matrix(q), dtau_du @ change)``.
    #[pyo3(signature = (q=None, qd=None, qdd=None, *, t=None, u=None, **others),
           text_signature = "($self, q, qd=None, qdd=None, *, t=None, u=None)")]
    #[allow(clippy::too_many_arguments, reason = "keyword-only options of a Python method")]
    fn input_tangent<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = arguments::given)] q: Option<&Bound<'py, PyAny>>,
        qd: Option<&Bound<'py, PyAny>>,
        qdd: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_number::t)] t: Option<f64>,
        u: Option<&Bound<'py, PyAny>>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let q = required!("Model.input_tangent", others, q);
        let q = self.state(q, "q")?;
        let or_zero = |value: Option<&Bound<'_, PyAny>>, name| {
            value.map_or_else(|| Ok(vec![0.0; self.n]), |value| self.state(value, name))
        };
        let (qd, qdd) = (or_zero(qd, "qd")?, or_zero(qdd, "qdd")?);
        let mut tangent = Matrix::zeros(self.n, self.memory().model.facts().inputs());
        self.at(t, u, |memory| memory.model.input_tangent(&q, &qd, &qdd, &mut tangent))?;
        check_finite(tangent.as_slice(), "input_tangent")?;
        Ok(convert::matrix_out(py, &tangent))
    }

    /// Raise if the model cannot represent a shape.
    ///
    /// Results at such a shape are meaningless. `statics`, `modes`, `linearise` and `simulate` make this check themselves.
    ///
    /// Parameters
    /// ----------
    /// q : array_like, shape (n,)
    ///     Coordinates.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     If a rod turns by more than half a turn between neighbouring quadrature nodes, or its stretch is not positive.
    #[pyo3(signature = (q))]
    fn check_shape(&self, q: &Bound<'_, PyAny>) -> PyResult<()> {
        let q = self.state(q, "q")?;
        self.memory().model.check_shape(&q, "q").or_raise()
    }

    /// Inverse dynamics: the generalised forces that a motion requires.
    ///
    /// Elasticity, damping, gravity and loads are included, so the result is zero in free motion.
    ///
    /// Parameters
    /// ----------
    /// q, qd, qdd : array_like, shape (n,)
    ///     Coordinates, velocities, accelerations.
    /// t : float, optional
    ///     Time of the state, seconds. Required if loads vary or the base moves.
    /// u : array_like, shape (m,), or dict, optional
    ///     Inputs, or some of them by name; by default `u0`.
    ///
    /// Returns
    /// -------
    /// tau : ndarray, shape (n,)
    #[pyo3(signature = (q=None, qd=None, qdd=None, *, t=None, u=None, **others),
           text_signature = "($self, q, qd, qdd, *, t=None, u=None)")]
    #[allow(clippy::too_many_arguments, reason = "keyword-only options of a Python method")]
    fn inverse_dynamics<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = arguments::given)] q: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::given)] qd: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::given)] qdd: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_number::t)] t: Option<f64>,
        u: Option<&Bound<'py, PyAny>>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (q, qd, qdd) = required!("Model.inverse_dynamics", others, q, qd, qdd);
        let (q, qd, qdd) = (self.state(q, "q")?, self.state(qd, "qd")?, self.state(qdd, "qdd")?);
        let mut tau = vec![0.0; self.n];
        self.at(t, u, |memory| memory.model.inverse_dynamics(&q, &qd, &qdd, &mut tau))?;
        check_finite(&tau, "inverse_dynamics")?;
        Ok(tau.into_pyarray(py))
    }

    /// Mass matrix at a shape.
    ///
    /// Parameters
    /// ----------
    /// q : array_like, shape (n,)
    ///     Coordinates.
    /// t : float, optional
    ///     Time, seconds. Required if the motion of a joint is prescribed.
    ///
    /// Returns
    /// -------
    /// mass : ndarray, shape (n, n)
    ///     Symmetric and positive definite (up to rounding), except at singularities of the coordinates.
    #[pyo3(signature = (q=None, *, t=None, **others),
           text_signature = "($self, q, *, t=None)")]
    fn mass_matrix<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = arguments::given)] q: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_number::t)] t: Option<f64>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let q = required!("Model.mass_matrix", others, q);
        let q = self.state(q, "q")?;
        let mut mass = Matrix::zeros(self.n, self.n);
        if t.is_some() {
            self.at(t, None, |memory| memory.model.mass_matrix(&q, &mut mass))?;
        } else {
            self.memory().model.mass_matrix(&q, &mut mass);
            // Joints with prescribed motion have no position without a time; loads and bases do not affect
            // the mass matrix.
            if self.depends_on_time && mass.iter().any(|entry| entry.is_nan()) {
                return Err(PyTypeError::new_err(NO_TIME));
            }
        }
        check_finite(mass.as_slice(), "mass_matrix")?;
        Ok(convert::matrix_out(py, &mass))
    }

    /// Forward dynamics: the accelerations of the free motion.
    ///
    /// Parameters
    /// ----------
    /// q, qd : array_like, shape (n,)
    ///     Coordinates, velocities.
    /// t : float, optional
    ///     Time of the state, seconds. Required if loads vary or the base moves.
    /// u : array_like, shape (m,), or dict, optional
    ///     Inputs, or some of them by name; by default `u0`.
    ///
    /// Returns
    /// -------
    /// qdd : ndarray, shape (n,)
    ///     The accelerations with ``inverse_dynamics(q, qd, qdd) = 0``.
    ///
    /// Raises
    /// ------
    /// LissomError
    ///     If the mass matrix is not positive definite.
    #[pyo3(signature = (q=None, qd=None, *, t=None, u=None, **others),
           text_signature = "($self, q, qd, *, t=None, u=None)")]
    fn forward_dynamics<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = arguments::given)] q: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::given)] qd: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_number::t)] t: Option<f64>,
        u: Option<&Bound<'py, PyAny>>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (q, qd) = required!("Model.forward_dynamics", others, q, qd);
        let (q, qd) = (self.state(q, "q")?, self.state(qd, "qd")?);
        let mut qdd = vec![0.0; self.n];
        let found = self.at(t, u, |memory| memory.forward_dynamics(&q, &qd, &mut qdd))?;
        found.map_err(|_| {
            LissomError::new_err(format!(
                "the mass matrix at q = {q:?} is not positive definite (or not finite): no acceleration exists there; \
                 look at numpy.linalg.cond(model.mass_matrix(q))"
            ))
        })?;
        check_finite(&qdd, "forward_dynamics")?;
        Ok(qdd.into_pyarray(py))
    }

    /// Exact derivatives of the inverse dynamics.
    ///
    /// Parameters
    /// ----------
    /// q, qd, qdd : array_like, shape (n,)
    ///     Coordinates, velocities, accelerations.
    /// t : float, optional
    ///     Time of the state, seconds. Required if loads vary or the base moves.
    /// u : array_like, shape (m,), or dict, optional
    ///     Inputs, or some of them by name; by default `u0`.
    ///
    /// Returns
    /// -------
    /// dtau_dq, dtau_dqd, dtau_dqdd : ndarray, shape (n, n)
    ///     ``dtau_dq[i, j]`` is the derivative of ``tau[i]`` with respect to ``q[j]``. The last one is the mass matrix.
    #[pyo3(signature = (q=None, qd=None, qdd=None, *, t=None, u=None, **others),
           text_signature = "($self, q, qd, qdd, *, t=None, u=None)")]
    #[allow(clippy::type_complexity, reason = "the type is the documentation: three (n, n) arrays")]
    #[allow(clippy::too_many_arguments, reason = "keyword-only options of a Python method")]
    fn tangent<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = arguments::given)] q: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::given)] qd: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::given)] qdd: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_number::t)] t: Option<f64>,
        u: Option<&Bound<'py, PyAny>>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<(Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>)> {
        let (q, qd, qdd) = required!("Model.tangent", others, q, qd, qdd);
        let (q, qd, qdd) = (self.state(q, "q")?, self.state(qd, "qd")?, self.state(qdd, "qdd")?);
        let mut tangents = self.at(t, u, |memory| {
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|weights| {
                let mut tangent = Matrix::zeros(self.n, self.n);
                memory.model.weighted_tangent(&q, &qd, &qdd, weights, &mut tangent);
                tangent
            })
        })?;
        for tangent in &tangents {
            check_finite(tangent.as_slice(), "tangent")?;
        }
        let [dq, dqd, dqdd] = tangents.each_mut().map(|tangent| convert::matrix_out(py, tangent));
        Ok((dq, dqd, dqdd))
    }

    /// The same at rest, without constraints that are exactly reached and carry no force there.
    #[pyo3(signature = (q, *, t=None, u=None))]
    #[allow(clippy::type_complexity, reason = "the type is the documentation: three (n, n) arrays")]
    fn _tangent_at_rest<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = arguments::optional_number::t)] t: Option<f64>,
        u: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<(Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>)> {
        let q = self.state(q, "q")?;
        let mut tangents = self.at(t, u, |memory| weakly_active::tangents(&mut *memory.model, &q))?;
        for tangent in &tangents {
            check_finite(tangent.as_slice(), "tangent")?;
        }
        let [dq, dqd, dqdd] = tangents.each_mut().map(|tangent| convert::matrix_out(py, tangent));
        Ok((dq, dqd, dqdd))
    }

    /// Energies of a state.
    ///
    /// Parameters
    /// ----------
    /// q, qd : array_like, shape (n,)
    ///     Coordinates, velocities.
    /// t : float, optional
    ///     Time of the state, seconds. Required if loads vary or the base moves.
    /// u : array_like, shape (m,), or dict, optional
    ///     Inputs, or some of them by name; by default `u0`.
    ///
    /// Returns
    /// -------
    /// energy : Energy
    ///     In joules: ``kinetic``, ``elastic``, ``gravitational``, ``loads`` and their sum ``total``.
    #[pyo3(signature = (q=None, qd=None, *, t=None, u=None, **others),
           text_signature = "($self, q, qd, *, t=None, u=None)")]
    fn energy(
        &self,
        #[pyo3(from_py_with = arguments::given)] q: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = arguments::given)] qd: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_number::t)] t: Option<f64>,
        u: Option<&Bound<'_, PyAny>>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<PyEnergy> {
        let (q, qd) = required!("Model.energy", others, q, qd);
        let (q, qd) = (self.state(q, "q")?, self.state(qd, "qd")?);
        let energy = self.at(t, u, |memory| memory.model.energy(&q, &qd))?;
        check_finite(&[energy.total()], "energy")?;
        Ok(PyEnergy(energy))
    }

    /// Power dissipated by damping.
    ///
    /// Parameters
    /// ----------
    /// q, qd : array_like, shape (n,)
    ///     Coordinates, velocities.
    /// t : float, optional
    ///     Time of the state, seconds. Required if loads vary or the base moves, because a moving base drags the rod through its
    ///     surroundings.
    /// u : array_like, shape (m,), or dict, optional
    ///     Inputs, or some of them by name; by default `u0`.
    ///
    /// Returns
    /// -------
    /// power : float
    ///     Dissipated power, watts, >= 0.
    #[pyo3(signature = (q=None, qd=None, *, t=None, u=None, **others),
           text_signature = "($self, q, qd, *, t=None, u=None)")]
    fn dissipated_power(
        &self,
        #[pyo3(from_py_with = arguments::given)] q: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = arguments::given)] qd: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_number::t)] t: Option<f64>,
        u: Option<&Bound<'_, PyAny>>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<f64> {
        let (q, qd) = required!("Model.dissipated_power", others, q, qd);
        let (q, qd) = (self.state(q, "q")?, self.state(qd, "qd")?);
        let power = self.at(t, u, |memory| memory.model.dissipated_power(&q, &qd))?;
        check_finite(&[power], "dissipated_power")?;
        Ok(power)
    }

    /// Power supplied by forces without a potential: follower loads, moments, time-dependent forces, inputs and a moving base.
    ///
    /// Without damping, the energy of a free motion increases at this rate.
    ///
    /// Parameters
    /// ----------
    /// q, qd : array_like, shape (n,)
    ///     Coordinates, velocities.
    /// qdd : array_like, shape (n,), optional
    ///     Accelerations, used if the base moves. By default those of the free motion.
    /// t : float, optional
    ///     Time of the state, seconds. Required if loads vary or the base moves.
    /// u : array_like, shape (m,), or dict, optional
    ///     Inputs, or some of them by name; by default `u0`.
    ///
    /// Returns
    /// -------
    /// power : float
    ///     Supplied power, watts.
    #[pyo3(signature = (q=None, qd=None, qdd=None, *, t=None, u=None, **others),
           text_signature = "($self, q, qd, qdd=None, *, t=None, u=None)")]
    fn supplied_power(
        &self,
        #[pyo3(from_py_with = arguments::given)] q: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = arguments::given)] qd: Option<&Bound<'_, PyAny>>,
        qdd: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_number::t)] t: Option<f64>,
        u: Option<&Bound<'_, PyAny>>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<f64> {
        let (q, qd) = required!("Model.supplied_power", others, q, qd);
        let qdd = qdd.map(|qdd| self.state(qdd, "qdd")).transpose()?;
        let (q, qd) = (self.state(q, "q")?, self.state(qd, "qd")?);
        let power = self.at(t, u, |memory| {
            let qdd = qdd.unwrap_or_else(|| {
                let mut free = vec![0.0; q.len()];
                // If there are no accelerations, there is no free motion.
                if memory.model.facts().varies_in_time && memory.forward_dynamics(&q, &qd, &mut free).is_err()
                {
                    free.fill(f64::NAN);
                }
                free
            });
            memory.model.supplied_power(&q, &qd, &qdd)
        })?;
        check_finite(&[power], "supplied_power")?;
        Ok(power)
    }
}
