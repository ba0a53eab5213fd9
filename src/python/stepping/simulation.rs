//! `lissom.Simulation`.

use std::sync::{Mutex, MutexGuard, TryLockError};

use numpy::{IntoPyArray, PyArray1, ToPyArray};
use pyo3::class::{PyTraverseError, PyVisit};
use pyo3::exceptions::{PyRuntimeError, PyTypeError};
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyFloat, PyString, PyTuple};

use super::super::arguments;
use super::super::callback::or_raised;
use super::super::convert;
use super::super::inputs::{mapping_of, or_rows, set_named};
use super::super::model::{PyEnergy, PyModel, model_of};
use super::super::record::{self, Reduced};
use super::super::remarks;
use super::super::simulate::{MethodOf, OptionArguments, method as method_of, needs_damping};
use super::memory::{Memory, Outcome, READY, Start, start};
use crate::integrators::newmark::Parameters;
use crate::python::errors::OrRaise as _;
use crate::python::words::{no_others, required};
use crate::simulation::methods::Configuration;
use crate::simulation::time_limit::TimeLimit;

/// A simulation that you advance step by step, with inputs.
///
/// With fixed steps a simulation is bitwise equal to `simulate` over the same time, and its copies and
/// pickles continue exactly as the original. Each simulation has its own model, so several can run in
/// parallel.
///
/// Parameters
/// ----------
/// model : Model
///     A `Rod`, a `Robot` or a `SpringPendulum`.
/// dt : float
///     Default duration of a step, seconds; for the Newmark family also its step size (if adaptive, the first one).
/// method : str or one of `lissom.methods`
///     As for `simulate`. 'auto' chooses the method for the start, and estimates the error as the simulation goes on (`time_error`), with
///     a `doubt` where it exceeds `rtol`; the space error is not estimated.
/// q0, v0 : array_like, shape (n,), optional
///     Initial coordinates and velocities; by default zero.
/// t0 : float
///     Initial time, seconds.
/// rtol, atol, beta, gamma, alpha, rho_inf, adaptive, max_step, min_step : optional
///     As for `simulate`.
/// max_seconds : float, optional
///     Limit of the wall-clock time of each call of `step`, seconds, looked at after every step of the method. A call that takes longer
///     ends with the status 'time_limit' at the time `t` that it has reached; the next one continues from there.
///
/// Attributes
/// ----------
/// model : Model
///     The model.
/// t : float
///     Current time, seconds.
/// q, v, a : ndarray, shape (n,)
///     Copies of the current coordinates, velocities and accelerations.
/// u : ndarray, shape (inputs,)
///     The current inputs.
/// energy : Energy
///     Energies of the current state, joules; computed on access.
/// status : str
///     Outcome of the last step, as in `MotionResult.status`: 'finished' for success, 'ready' before the first step.
/// success : bool
///     False after a step that failed.
/// time_error : float or None
///     Estimated error so far due to the steps, relative to the model's length, with the method 'auto'.
/// message : str
///     The status in words, and what to change.
///
/// Raises
/// ------
/// ValueError, TypeError
///     If an argument is invalid.
///
/// Examples
/// --------
/// >>> import lissom
/// >>> simulation = lissom.Simulation(lissom.SpringPendulum(), dt=0.01, q0=[-0.8, 0.5])
/// >>> for _ in range(100):
/// ...     status = simulation.step()
/// >>> status, simulation.t
/// ('finished', 1.0)
#[pyclass(name = "Simulation", module = "lissom", frozen)]
pub(crate) struct PySimulation {
    pub(super) model: Py<PyModel>,
    /// Keyword arguments of the constructor except the initial state, for pickles and restarts.
    pub(super) options: Py<PyDict>,
    pub(super) configuration: Configuration,
    pub(super) memory: Mutex<Memory>,
}

impl PySimulation {
    /// Fails if a function called during a step, or another thread during a step, uses the simulation.
    pub(super) fn memory(&self) -> PyResult<MutexGuard<'_, Memory>> {
        match self.memory.try_lock() {
            Ok(memory) => Ok(memory),
            Err(TryLockError::Poisoned(poisoned)) => Ok(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => {
                Err(PyRuntimeError::new_err("the simulation is in the middle of a step"))
            }
        }
    }
}

/// Keeps a tolerance that is given.
fn set_tolerance(options: &Bound<'_, PyDict>, name: &str, given: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
    let Some(value) = given else { return Ok(()) };
    // A copy, because the caller may change the array.
    let (values, is_number) = convert::scalar_or_vector(value, name)?;
    match values[..] {
        [value] if is_number => options.set_item(name, value),
        _ => options.set_item(name, values),
    }
}

#[pymethods]
impl PySimulation {
    #[new]
    #[pyo3(
        signature = (
            model=None, *more, dt=None, method=None, q0=None, v0=None, t0=0.0, rtol=None, atol=None, beta=None, gamma=None,
            alpha=None, rho_inf=None, adaptive=None, max_step=None, min_step=0.0, max_seconds=None, **others
        ),
        text_signature = "(model, *, dt, method='newmark', q0=None, v0=None, t0=0.0, rtol=1e-06, atol=None, beta=0.25, \
                          gamma=0.5, alpha=None, rho_inf=None, adaptive=False, max_step=None, min_step=0.0, max_seconds=None)"
    )]
    #[allow(clippy::too_many_arguments, reason = "keyword-only options of a Python class")]
    fn new(
        #[pyo3(from_py_with = arguments::given)] model: Option<&Bound<'_, PyAny>>,
        more: &Bound<'_, PyTuple>,
        #[pyo3(from_py_with = arguments::given_number::dt)] dt: Option<f64>,
        method: Option<&Bound<'_, PyAny>>,
        q0: Option<&Bound<'_, PyAny>>,
        v0: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = arguments::number::t0)] t0: f64,
        rtol: Option<&Bound<'_, PyAny>>,
        atol: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_number::beta)] beta: Option<f64>,
        #[pyo3(from_py_with = arguments::optional_number::gamma)] gamma: Option<f64>,
        #[pyo3(from_py_with = arguments::optional_number::alpha)] alpha: Option<f64>,
        #[pyo3(from_py_with = arguments::optional_number::rho_inf)] rho_inf: Option<f64>,
        #[pyo3(from_py_with = arguments::optional_flag::adaptive)] adaptive: Option<bool>,
        #[pyo3(from_py_with = arguments::optional_number::max_step)] max_step: Option<f64>,
        #[pyo3(from_py_with = arguments::number::min_step)] min_step: f64,
        #[pyo3(from_py_with = arguments::optional_number::max_seconds)] max_seconds: Option<f64>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        model.map(|model| model_of(model, "model")).transpose()?;
        let (model, dt) = required!("Simulation", others; more, model, dt);
        let (py, model) = (model.py(), model_of(model, "model")?);
        let (n, options) = (model.get().n(), PyDict::new(py));
        options.set_item("dt", dt)?;
        let chosen = method.map_or_else(|| PyString::new(py, "newmark").into_any(), Clone::clone);
        options.set_item("method", chosen)?;
        let method = method.map_or(Ok(MethodOf::Name("newmark")), method_of)?;
        set_tolerance(&options, "rtol", rtol)?;
        set_tolerance(&options, "atol", atol)?;
        let numbers = [
            ("beta", beta),
            ("gamma", gamma),
            ("alpha", alpha),
            ("rho_inf", rho_inf),
            ("max_step", max_step),
            ("min_step", (min_step != 0.0).then_some(min_step)),
            ("max_seconds", max_seconds),
        ];
        for (name, value) in numbers {
            if let Some(value) = value {
                options.set_item(name, value)?;
            }
        }
        if let Some(adaptive) = adaptive {
            options.set_item("adaptive", adaptive)?;
        }
        let given = OptionArguments {
            method,
            dt,
            jac: None,
            rtol,
            atol,
            parameters: Parameters { beta, gamma, alpha, rho_inf },
            adaptive,
            max_step,
            min_step,
            max_steps: None,
            predictor: None,
            reuse_jacobian: None,
            needs_damping: model.get().inspect(needs_damping),
            returns_steps: false,
        };
        let configuration = given.configuration(n)?;
        let start = start(n, q0, v0, t0)?;
        let limit = TimeLimit::new(max_seconds, f64::INFINITY).or_raise()?;
        let memory = Memory::begin(py, model.get(), &configuration, limit, start)?;
        let model = model.clone().unbind();
        Ok(Self { model, options: options.unbind(), configuration, memory: Mutex::new(memory) })
    }

    /// Advance the simulation with constant inputs.
    ///
    /// Parameters
    /// ----------
    /// u : array_like, shape (inputs,), or dict, optional
    ///     Inputs from now on, or by name those that change; by default those of the last step.
    /// duration : float, optional
    ///     Duration, seconds; by default `dt`. Adaptive methods end a step there. The others take steps of `dt` if it divides the
    ///     duration, otherwise slightly shorter equal steps.
    ///
    /// Returns
    /// -------
    /// status : str
    ///     'finished', or the reason for a failure as in `MotionResult.status`; `message` gives details. After a failed step the
    ///     state is the one before it, at the time `t`. For the statuses 'unresolved', 'inverted' and 'collapsed' it is the
    ///     invalid shape itself, as in `simulate`.
    ///
    /// Raises
    /// ------
    /// ValueError, TypeError
    ///     If `u` or `duration` is invalid; the state is unchanged.
    /// KeyboardInterrupt
    ///     On Ctrl-C during a long step. The state is that after the last complete step, also after exceptions of functions of
    ///     time.
    /// RuntimeError
    ///     If this simulation is already in a step, in another thread or in a function that the step calls.
    #[pyo3(signature = (u=None, duration=None, **others),
           text_signature = "($self, u=None, duration=None)")]
    fn step<'py>(
        &self,
        py: Python<'py>,
        u: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_number::duration)] duration: Option<f64>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Bound<'py, PyString>> {
        no_others("Simulation.step", others)?;
        let memory = &mut *self.memory()?;
        if let Some(u) = u {
            if u.is_callable() {
                return Err(PyTypeError::new_err(
                    "u: got a function, expected its values now: write `simulation.step(u(simulation.t), dt)`",
                ));
            }
            if u.is_instance_of::<PyFloat>() && memory.inputs.len() != 1 {
                return Err(PyTypeError::new_err(
                    "u: got a number, expected inputs; the second argument is the duration: \
                     `simulation.step(None, duration)` leaves the inputs as they are",
                ));
            }
            match mapping_of(u) {
                Some(mapping) => {
                    let names = self.model.get().input_names();
                    let mut inputs = memory.inputs.clone();
                    set_named(mapping, &names, &mut inputs, "u")?;
                    memory.inputs = inputs;
                }
                None => {
                    let m = memory.inputs.len();
                    let instead = |_| "step by each row: `for row in u: simulation.step(row, dt)`".to_owned();
                    convert::finite_vector_into(u, &mut memory.inputs, "u")
                        .map_err(|error| or_rows(u, m, error, instead))?;
                }
            }
        }
        let end = memory.run.end_of(duration).or_raise()?;
        if u.is_some() {
            memory.run.set_inputs(&memory.inputs);
        }
        memory.run.begin_interval(end);
        memory.outcome = Outcome::Raised;
        let finished = memory.finish(py);
        memory.run.shorten_rotation_vectors();
        let status = finished?;
        memory.outcome = Outcome::Ended(status);
        if status.is_success() {
            return Ok(intern!(py, "finished").clone());
        }
        Ok(PyString::new(py, status.name()))
    }

    /// Restart the simulation.
    ///
    /// Parameters
    /// ----------
    /// q0, v0 : array_like, shape (n,), optional
    ///     Initial coordinates and velocities; by default those of the last start.
    /// t0 : float, optional
    ///     Initial time, seconds; by default that of the last start.
    ///
    /// Raises
    /// ------
    /// ValueError, TypeError
    ///     If an argument is invalid; the state is unchanged.
    #[pyo3(signature = (*, q0=None, v0=None, t0=None, **others),
           text_signature = "($self, *, q0=None, v0=None, t0=None)")]
    fn reset(
        &self,
        py: Python<'_>,
        q0: Option<&Bound<'_, PyAny>>,
        v0: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_number::t0)] t0: Option<f64>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<()> {
        no_others("Simulation.reset", others)?;
        let (last, limit) = {
            let memory = self.memory()?;
            (memory.start.clone(), memory.limit)
        };
        let n = last.q.len();
        let given = start(n, q0, v0, t0.unwrap_or(last.t))?;
        let start = Start {
            t: given.t,
            q: if q0.is_some() { given.q } else { last.q },
            v: if v0.is_some() { given.v } else { last.v },
        };
        let memory = Memory::begin(py, self.model.get(), &self.configuration, limit, start)?;
        *self.memory()? = memory;
        Ok(())
    }

    /// An independent copy that continues exactly as this one.
    fn copy(&self, py: Python<'_>) -> PyResult<Self> {
        let memory = self.memory()?.copy();
        Ok(Self {
            model: self.model.clone_ref(py),
            options: self.options.clone_ref(py),
            configuration: self.configuration.clone(),
            memory: Mutex::new(memory),
        })
    }

    fn __copy__(&self, py: Python<'_>) -> PyResult<Self> {
        self.copy(py)
    }

    // Models never change, so the copy can share this one.
    fn __deepcopy__(&self, py: Python<'_>, _memo: &Bound<'_, PyAny>) -> PyResult<Self> {
        self.copy(py)
    }

    /// The model.
    #[getter]
    fn model(&self, py: Python<'_>) -> Py<PyModel> {
        self.model.clone_ref(py)
    }

    /// The time, seconds.
    #[getter]
    fn t(&self) -> PyResult<f64> {
        Ok(self.memory()?.run.t())
    }

    /// Coordinates, shape (n,).
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(self.memory()?.run.state()[0].to_pyarray(py))
    }

    /// Velocities, shape (n,).
    #[getter]
    fn v<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(self.memory()?.run.state()[1].to_pyarray(py))
    }

    /// Accelerations with the inputs of the last step, shape (n,).
    #[getter]
    fn a<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(self.memory()?.run.state()[2].to_pyarray(py))
    }

    /// Current inputs, shape (inputs,).
    #[getter]
    fn u<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(self.memory()?.run.inputs().to_pyarray(py))
    }

    /// The energies of the state, joules.
    #[getter]
    fn energy(&self) -> PyResult<PyEnergy> {
        // A copy, because functions of time may be Python code that uses this simulation.
        let mut run = self.memory()?.run.boxed_clone();
        Ok(PyEnergy(or_raised(run.energy())?))
    }

    /// Outcome of the last step; 'ready' before the first one.
    #[getter]
    fn status(&self) -> PyResult<String> {
        Ok(self.memory()?.outcome.name().to_owned())
    }

    /// False after a step that failed.
    #[getter]
    fn success(&self) -> PyResult<bool> {
        Ok(self.memory()?.outcome.is_success())
    }

    /// The status in words, and what to change.
    #[getter]
    fn message(&self) -> PyResult<String> {
        let outcome = self.memory()?.message();
        Ok(remarks::with(&outcome, &remarks::questions(self.model.get())))
    }

    /// Why the motion so far may be wrong although no step failed: energy that fixed steps add or lose while inputs are those of
    /// the start, and impacts that they do not resolve. None without such a reason. The message ends with it.
    #[getter]
    fn doubt(&self) -> PyResult<Option<String>> {
        // A copy, because functions of time may be Python code that uses this simulation.
        Ok(self.memory()?.run.boxed_clone().doubt())
    }

    /// Estimated error so far of the tips and bodies due to the steps, relative to the model's length, with the method 'auto'; infinite
    /// where it is unknown, None with other methods.
    #[getter]
    fn time_error(&self) -> PyResult<Option<f64>> {
        Ok(self.memory()?.run.time_error())
    }

    fn __repr__(&self) -> PyResult<String> {
        let memory = self.memory()?;
        let (status, t) = (memory.outcome.name(), memory.run.t());
        Ok(format!("Simulation(t={t:?}, status={status:?}, n={})", memory.run.state()[0].len()))
    }

    /// For pickles.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        let memory = &mut *self.memory()?;
        let outcome = (memory.outcome.name().to_owned(), memory.outcome.is_success(), memory.message());
        let Start { t, q, v } = &memory.start;
        let start = (*t, q.to_pyarray(py), v.to_pyarray(py));
        let numbers = memory.run.memory().into_pyarray(py);
        record::reduce_to::<Self>(py, (&self.model, &self.options, start, numbers, outcome))
    }

    #[staticmethod]
    fn _restore<'py>(
        py: Python<'py>,
        model: Bound<'py, PyModel>,
        options: &Bound<'py, PyDict>,
        begun: (f64, Bound<'py, PyAny>, Bound<'py, PyAny>),
        numbers: &Bound<'py, PyAny>,
        outcome: (String, bool, String),
    ) -> PyResult<Bound<'py, Self>> {
        let (t, q, v) = begun;
        let arguments = options.copy()?;
        arguments.set_item("t0", t)?;
        arguments.set_item("q0", q)?;
        arguments.set_item("v0", v)?;
        let fresh = py.get_type::<Self>().call((model,), Some(&arguments))?.cast_into::<Self>()?;
        {
            let memory = &mut *fresh.get().memory()?;
            memory.run.recall(&convert::vector(numbers, "memory")?).or_raise()?;
            memory.inputs.copy_from_slice(memory.run.inputs());
            memory.outcome = match outcome {
                (status, ..) if status == READY => Outcome::Ready,
                (status, success, message) => Outcome::Told(status, success, message),
            };
        }
        Ok(fresh)
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.model)?;
        visit.call(&self.options)
    }
}
