//! Step-by-step integrations: the classes `RK45`, `DOP853` and `Radau`.

use std::sync::{Mutex, MutexGuard, TryLockError};

use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, ToPyArray};
use pyo3::class::{PyTraverseError, PyVisit};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::super::arguments;
use super::options;
use super::result::PyDenseOutput;
use super::system::{Parts, PySystem, SharedRaised};
use crate::integrators::ode::{FirstOrderSystem, Method, Options, Status, Stepper, tableau};
use crate::python::convert;
use crate::python::errors::OrRaise as _;
use crate::python::words::required;

/// A step-by-step integration: the base class of `RK45`, `DOP853` and `Radau`.
///
/// Attributes
/// ----------
/// n : int
///     Number of equations.
/// status : str
///     'running', 'finished' or 'failed'.
/// t, y : float, ndarray of shape (n,)
///     Current time and state.
/// t_old : float or None
///     Time before the last step; None before the first.
/// t_bound : float
///     End of the interval.
/// direction : float
///     1 forward, -1 backward in time.
/// step_size : float or None
///     Size of the last step; None before the first.
/// nfev, nfev_jac, njev, nlu : int
///     Numbers of evaluations of the right-hand side, of evaluations for finite-difference Jacobians, of
///     Jacobians and of LU factorisations.
/// naccepted, nrejected : int
///     Accepted and rejected steps.
#[pyclass(name = "OdeSolver", module = "lissom", subclass, frozen)]
pub(crate) struct PyOdeSolver {
    memory: Mutex<Memory>,
}

struct Memory {
    system: PySystem,
    stepper: Stepper,
    raised: SharedRaised,
    has_stepped: bool,
}

/// Arguments common to all three classes.
struct Arguments<'a, 'py> {
    fun: &'a Bound<'py, PyAny>,
    t0: f64,
    y0: &'a Bound<'py, PyAny>,
    t_bound: f64,
    args: Option<&'a Bound<'py, PyAny>>,
    jac: Option<&'a Bound<'py, PyAny>>,
    vectorized: bool,
    rtol: Option<&'a Bound<'py, PyAny>>,
    atol: Option<&'a Bound<'py, PyAny>>,
}

impl PyOdeSolver {
    fn new(arguments: &Arguments<'_, '_>, options: Options) -> PyResult<Self> {
        let &Arguments { fun, t0, y0, t_bound, args, jac, vectorized, rtol, atol } = arguments;
        let y0 = options::initial_state(y0)?;
        let raised = SharedRaised::default();
        let parts = Parts { fun, args, jac, vectorized, method: options.method, n: y0.len() };
        let mut system = PySystem::new(&parts, raised.clone())?;
        let mut options = options;
        if let Some(rtol) = rtol {
            options.rtol = options::tolerance(rtol, "rtol")?;
        }
        if let Some(atol) = atol {
            options.atol = options::tolerance(atol, "atol")?;
        }
        let mut stepper = Stepper::new(system.n(), (t0, t_bound), &y0, &options).or_raise()?;
        if stepper.rtol_raised() {
            options::warn_of_raised_rtol(fun.py())?;
        }
        let py = fun.py();
        let started = if system.is_native() {
            py.detach(|| stepper.start(&mut system))
        } else {
            stepper.start(&mut system)
        };
        if started.is_err() {
            raised.raise()?;
        }
        Ok(Self { memory: Mutex::new(Memory { system, stepper, raised, has_stepped: false }) })
    }

    /// Fails if a callback of the current step calls it.
    fn memory(&self) -> PyResult<MutexGuard<'_, Memory>> {
        match self.memory.try_lock() {
            Ok(memory) => Ok(memory),
            Err(TryLockError::Poisoned(poisoned)) => Ok(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => {
                Err(PyRuntimeError::new_err("the solver is in the middle of a step"))
            }
        }
    }

    fn counter(&self, counter: impl Fn(crate::integrators::ode::Counters) -> usize) -> PyResult<usize> {
        Ok(counter(self.memory()?.stepper.counters()))
    }
}

#[pymethods]
impl PyOdeSolver {
    /// Make one accepted step.
    ///
    /// Returns
    /// -------
    /// message : str or None
    ///     Reason of the failure and advice, if `status` is 'failed' afterwards.
    ///
    /// Raises
    /// ------
    /// RuntimeError
    ///     If the integration had already ended.
    fn step(&self, py: Python<'_>) -> PyResult<Option<String>> {
        let Memory { system, stepper, raised, has_stepped } = &mut *self.memory()?;
        if stepper.status().is_some() {
            return Err(PyRuntimeError::new_err("Attempt to step on a failed or finished solver."));
        }
        let step = if system.is_native() { py.detach(|| stepper.step(system)) } else { stepper.step(system) };
        let Ok(status) = step else {
            raised.raise()?;
            unreachable!("only a Python exception interrupts a step");
        };
        match status {
            None | Some(Status::Finished) => {
                *has_stepped = true;
                Ok(None)
            }
            Some(failure) => Ok(Some(stepper.explain(failure))),
        }
    }

    /// The solution over the last step.
    ///
    /// Returns
    /// -------
    /// DenseOutput
    ///
    /// Raises
    /// ------
    /// RuntimeError
    ///     If no step has been made.
    fn dense_output(&self) -> PyResult<PyDenseOutput> {
        let Memory { system, stepper, raised, has_stepped } = &mut *self.memory()?;
        if !*has_stepped {
            return Err(PyRuntimeError::new_err(
                "Dense output is available after a successful step was made.",
            ));
        }
        match stepper.dense_output(system) {
            Ok(dense) => Ok(PyDenseOutput::new(dense)),
            Err(_) => {
                raised.raise()?;
                unreachable!("only a Python exception interrupts the dense output")
            }
        }
    }

    /// Estimated error of the last step, shape (n,): for RK45 the embedded solution minus the solution.
    ///
    /// Raises
    /// ------
    /// RuntimeError
    ///     If no step has been made.
    fn error_estimate<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let memory = self.memory()?;
        if !memory.has_stepped {
            return Err(PyRuntimeError::new_err(
                "An error estimate is available after a successful step was made.",
            ));
        }
        Ok(memory.stepper.error_estimate().into_pyarray(py))
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        // The memory is in use during a step.
        match self.memory.try_lock() {
            Ok(memory) => memory.system.traverse(&visit),
            Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner().system.traverse(&visit),
            Err(TryLockError::WouldBlock) => Ok(()),
        }
    }

    /// Number of equations.
    #[getter]
    fn n(&self) -> PyResult<usize> {
        Ok(self.memory()?.stepper.y().len())
    }

    /// 'running', 'finished' or 'failed'.
    #[getter]
    fn status(&self) -> PyResult<&'static str> {
        Ok(match self.memory()?.stepper.status() {
            None => "running",
            Some(Status::Finished) => "finished",
            Some(_) => "failed",
        })
    }

    /// Current time.
    #[getter]
    fn t(&self) -> PyResult<f64> {
        Ok(self.memory()?.stepper.t())
    }

    /// Current state, shape (n,).
    #[getter]
    fn y<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(self.memory()?.stepper.y().to_pyarray(py))
    }

    /// Time before the last step; None before the first.
    #[getter]
    fn t_old(&self) -> PyResult<Option<f64>> {
        let memory = self.memory()?;
        Ok(memory.has_stepped.then(|| memory.stepper.t_old()))
    }

    /// End of the interval.
    #[getter]
    fn t_bound(&self) -> PyResult<f64> {
        Ok(self.memory()?.stepper.t_end())
    }

    /// 1 forward, -1 backward in time.
    #[getter]
    fn direction(&self) -> PyResult<f64> {
        Ok(self.memory()?.stepper.direction())
    }

    /// Size of the last step; None before the first.
    #[getter]
    fn step_size(&self) -> PyResult<Option<f64>> {
        let memory = self.memory()?;
        Ok(memory.has_stepped.then(|| (memory.stepper.t() - memory.stepper.t_old()).abs()))
    }

    /// Evaluations of the right-hand side, excluding those for finite-difference Jacobians.
    #[getter]
    fn nfev(&self) -> PyResult<usize> {
        self.counter(|counters| counters.nfev)
    }

    /// Evaluations of the right-hand side for finite-difference Jacobians.
    #[getter]
    fn nfev_jac(&self) -> PyResult<usize> {
        self.counter(|counters| counters.nfev_jacobian)
    }

    /// Number of Jacobians, given or by finite differences.
    #[getter]
    fn njev(&self) -> PyResult<usize> {
        self.counter(|counters| counters.njev)
    }

    /// LU factorisations, real and complex.
    #[getter]
    fn nlu(&self) -> PyResult<usize> {
        self.counter(|counters| counters.nlu)
    }

    /// Accepted steps.
    #[getter]
    fn naccepted(&self) -> PyResult<usize> {
        self.counter(|counters| counters.accepted)
    }

    /// Rejected steps.
    #[getter]
    fn nrejected(&self) -> PyResult<usize> {
        self.counter(|counters| counters.rejected)
    }
}

/// The explicit Runge-Kutta pair 5(4) of Dormand and Prince, step by step.
///
/// Parameters
/// ----------
/// fun : callable, compiled function or Model
///     Right-hand side ``fun(t, y, *args)``, as for `solve_ivp`.
/// t0 : float
///     Initial time.
/// y0 : array_like, shape (n,)
///     Initial state.
/// t_bound : float
///     End of the interval; may be infinite, or before `t0`.
/// args : tuple, optional
///     Further arguments of `fun`.
/// rtol, atol : float or array_like of shape (n,)
///     Tolerances; by default 1e-3 and 1e-6.
/// first_step, max_step, min_step : float, optional
///     Size of the first step, and bounds of all steps.
/// max_steps : int, optional
///     Maximum number of accepted steps.
/// vectorized : bool
///     Whether `fun` accepts states of shape (n, k).
/// controller : {'I', 'PI'}
///     Step-size control.
///
/// Attributes
/// ----------
/// A, B, C : ndarray
///     The tableau: shapes (6, 6), (6,) and (6,).
///
/// Examples
/// --------
/// >>> import lissom
/// >>> solver = lissom.RK45(lambda t, y: -y, 0.0, [1.0], 1.0)
/// >>> while solver.status == "running":
/// ...     message = solver.step()
/// >>> solver.t, solver.y.round(3)
/// (1.0, array([0.368]))
#[pyclass(name = "RK45", module = "lissom", extends = PyOdeSolver, subclass, frozen)]
pub(crate) struct PyRk45;

/// The explicit Runge-Kutta method of order 8(5,3) of Dormand and Prince, step by step.
///
/// Parameters
/// ----------
/// fun : callable, compiled function or Model
///     Right-hand side ``fun(t, y, *args)``, as for `solve_ivp`.
/// t0 : float
///     Initial time.
/// y0 : array_like, shape (n,)
///     Initial state.
/// t_bound : float
///     End of the interval; may be infinite, or before `t0`.
/// args : tuple, optional
///     Further arguments of `fun`.
/// rtol, atol : float or array_like of shape (n,)
///     Tolerances; by default 1e-3 and 1e-6.
/// first_step, max_step, min_step : float, optional
///     Size of the first step, and bounds of all steps.
/// max_steps : int, optional
///     Maximum number of accepted steps.
/// vectorized : bool
///     Whether `fun` accepts states of shape (n, k).
/// controller : {'I', 'PI'}
///     Step-size control.
///
/// Attributes
/// ----------
/// A, B, C : ndarray
///     The tableau: shapes (12, 12), (12,) and (12,).
#[pyclass(name = "DOP853", module = "lissom", extends = PyOdeSolver, subclass, frozen)]
pub(crate) struct PyDop853;

/// The implicit Radau IIA method of order 5, step by step.
///
/// Parameters
/// ----------
/// fun : callable, compiled function or Model
///     Right-hand side ``fun(t, y, *args)``, as for `solve_ivp`.
/// t0 : float
///     Initial time.
/// y0 : array_like, shape (n,)
///     Initial state.
/// t_bound : float
///     End of the interval; may be infinite, or before `t0`.
/// args : tuple, optional
///     Further arguments of `fun` and `jac`.
/// rtol, atol : float or array_like of shape (n,)
///     Tolerances; by default 1e-3 and 1e-6.
/// first_step, max_step, min_step : float, optional
///     Size of the first step, and bounds of all steps.
/// max_steps : int, optional
///     Maximum number of accepted steps.
/// vectorized : bool
///     Whether `fun` accepts states of shape (n, k).
/// jac : callable, compiled function or matrix, optional
///     Jacobian, as for `solve_ivp`.
/// jac_sparsity : array_like or sparse matrix, shape (n, n), optional
///     Entries of the Jacobian that can be nonzero.
#[pyclass(name = "Radau", module = "lissom", extends = PyOdeSolver, subclass, frozen)]
pub(crate) struct PyRadau;

macro_rules! explicit_solver {
    ($class:ident, $name:literal, $method:expr) => {
        #[pymethods]
        impl $class {
            #[new]
            #[pyo3(
                signature = (
                    fun=None, t0=None, y0=None, t_bound=None, *, args=None, rtol=None, atol=None, first_step=None,
                    max_step=None, min_step=0.0, max_steps=None, vectorized=false, controller="I", **others
                ),
                text_signature = "(fun, t0, y0, t_bound, *, args=None, rtol=0.001, atol=1e-06, first_step=None, \
                                  max_step=None, min_step=0.0, max_steps=None, vectorized=False, controller='I')"
            )]
            #[allow(clippy::too_many_arguments, reason = "keyword-only options of a Python class")]
            fn new(
                #[pyo3(from_py_with = arguments::given)] fun: Option<&Bound<'_, PyAny>>,
                #[pyo3(from_py_with = arguments::given_number::t0)] t0: Option<f64>,
                #[pyo3(from_py_with = arguments::given)] y0: Option<&Bound<'_, PyAny>>,
                #[pyo3(from_py_with = arguments::given_number::t_bound)] t_bound: Option<f64>,
                args: Option<&Bound<'_, PyAny>>,
                rtol: Option<&Bound<'_, PyAny>>,
                atol: Option<&Bound<'_, PyAny>>,
                #[pyo3(from_py_with = arguments::optional_number::first_step)] first_step: Option<f64>,
                #[pyo3(from_py_with = arguments::optional_number::max_step)] max_step: Option<f64>,
                #[pyo3(from_py_with = arguments::number::min_step)] min_step: f64,
                #[pyo3(from_py_with = arguments::optional_whole::max_steps)] max_steps: Option<i64>,
                #[pyo3(from_py_with = arguments::flag::vectorized)] vectorized: bool,
                #[pyo3(from_py_with = arguments::text::controller)] controller: &str,
                others: Option<&Bound<'_, PyDict>>,
            ) -> PyResult<PyClassInitializer<Self>> {
                let (fun, t0, y0, t_bound) = required!($name, others, fun, t0, y0, t_bound);
                let options = Options {
                    method: $method,
                    first_step,
                    max_step: max_step.unwrap_or(f64::INFINITY),
                    min_step,
                    max_steps: convert::step_limit(max_steps)?,
                    controller: options::controller(controller)?,
                    ..Options::default()
                };
                let arguments = Arguments { fun, t0, y0, t_bound, args, jac: None, vectorized, rtol, atol };
                Ok(PyClassInitializer::from(PyOdeSolver::new(&arguments, options)?).add_subclass(Self))
            }

            /// Coefficients of the stages.
            #[classattr]
            #[pyo3(name = "A")]
            fn a(py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
                let tableau = tableau($method).expect("an explicit method has a tableau");
                let stages = tableau.c.len();
                Ok(tableau.a.concat().into_pyarray(py).reshape([stages, stages])?.unbind())
            }

            /// Weights of the stages.
            #[classattr]
            #[pyo3(name = "B")]
            fn b(py: Python<'_>) -> Py<PyArray1<f64>> {
                tableau($method).expect("an explicit method has a tableau").b.into_pyarray(py).unbind()
            }

            /// Times of the stages.
            #[classattr]
            #[pyo3(name = "C")]
            fn c(py: Python<'_>) -> Py<PyArray1<f64>> {
                tableau($method).expect("an explicit method has a tableau").c.into_pyarray(py).unbind()
            }
        }
    };
}
explicit_solver!(PyRk45, "RK45", Method::Rk45);
explicit_solver!(PyDop853, "DOP853", Method::Dop853);

#[pymethods]
impl PyRadau {
    #[new]
    #[pyo3(
        signature = (
            fun=None, t0=None, y0=None, t_bound=None, *, args=None, rtol=None, atol=None, first_step=None, max_step=None,
            min_step=0.0, max_steps=None, vectorized=false, jac=None, jac_sparsity=None, **others
        ),
        text_signature = "(fun, t0, y0, t_bound, *, args=None, rtol=0.001, atol=1e-06, first_step=None, max_step=None, \
                          min_step=0.0, max_steps=None, vectorized=False, jac=None, jac_sparsity=None)"
    )]
    #[allow(clippy::too_many_arguments, reason = "keyword-only options of a Python class")]
    fn new(
        #[pyo3(from_py_with = arguments::given)] fun: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = arguments::given_number::t0)] t0: Option<f64>,
        #[pyo3(from_py_with = arguments::given)] y0: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = arguments::given_number::t_bound)] t_bound: Option<f64>,
        args: Option<&Bound<'_, PyAny>>,
        rtol: Option<&Bound<'_, PyAny>>,
        atol: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_number::first_step)] first_step: Option<f64>,
        #[pyo3(from_py_with = arguments::optional_number::max_step)] max_step: Option<f64>,
        #[pyo3(from_py_with = arguments::number::min_step)] min_step: f64,
        #[pyo3(from_py_with = arguments::optional_whole::max_steps)] max_steps: Option<i64>,
        #[pyo3(from_py_with = arguments::flag::vectorized)] vectorized: bool,
        jac: Option<&Bound<'_, PyAny>>,
        jac_sparsity: Option<&Bound<'_, PyAny>>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<PyClassInitializer<Self>> {
        let (fun, t0, y0, t_bound) = required!("Radau", others, fun, t0, y0, t_bound);
        let options = Options {
            method: Method::Radau,
            first_step,
            max_step: max_step.unwrap_or(f64::INFINITY),
            min_step,
            max_steps: convert::step_limit(max_steps)?,
            sparsity: jac_sparsity
                .map(|pattern| options::sparsity(pattern, options::initial_state(y0)?.len()))
                .transpose()?,
            ..Options::default()
        };
        let arguments = Arguments { fun, t0, y0, t_bound, args, jac, vectorized, rtol, atol };
        Ok(PyClassInitializer::from(PyOdeSolver::new(&arguments, options)?).add_subclass(Self))
    }
}
