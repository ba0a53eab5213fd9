//! `lissom.newmark`.

use std::time::Instant;

use numpy::ToPyArray;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString, PyTuple};

use super::arguments;
use super::callback::{Form, call, requests_stop};
use super::convert;
use super::motion::{PyMotionResult, finish, times};
use super::ode::function::{matrix_of, read_vector};
use super::ode::options::tolerance;
use super::ode::system::{SharedRaised, unpack};
use super::simulate::{name_methods, word};
use crate::error::Interrupted;
use crate::integrators::newmark::{Options, Parameters, Scheme, StepSize, Stepper, solve};
use crate::integrators::second_order::{Failure, SecondOrderSystem, Status};
use crate::model::{Facts, Model};
use crate::numerics::linalg::Matrix;
use crate::numerics::roots::Derivative;
use crate::python::errors::OrRaise as _;
use crate::python::words::required;
use crate::simulation::simulate::Simulation;
use crate::simulation::stepping;

/// Integrate second-order equations of motion ``residual(t, q, v, a) = 0`` with the Newmark family.
///
/// Parameters
/// ----------
/// residual : callable
///     ``residual(t, q, v, a, *args)`` of the time and of displacements, velocities and accelerations of shape (n,); returns n
///     numbers, such as ``M @ a + D @ v + K @ q - f(t)``. Any units.
/// t_span : (t0, tf)
///     The interval, tf >= t0.
/// q0, v0 : array_like, shape (n,)
///     Displacements and velocities at t0. The accelerations at t0 are computed from the residual.
/// dt : float
///     Step size, or with `adaptive` the first one. The last step may be shorter.
/// beta, gamma : float
///     Parameters of method 'newmark'; other methods do not accept them. The defaults give the average acceleration method.
/// jac : {'forward', 'central'} or callable
///     Jacobian of a step: by forward differences (n additional evaluations), by central differences (2n), or from
///     ``jac(t, q, v, a, *args)``, which returns the three (n, n) derivatives of the residual with respect to q, v and a.
/// method : str
///     'newmark', 'average_acceleration', 'linear_acceleration', 'fox_goodwin', 'central_difference', 'hht' (takes
///     `alpha`) or 'generalised_alpha' (takes `rho_inf`).
/// alpha : float, optional
///     Parameter of method 'hht', in [-1/3, 0]; by default -0.1. With it, 'newmark' is that method.
/// rho_inf : float, optional
///     Parameter of method 'generalised_alpha', which 'newmark' is with it, in [0, 1]: the spectral radius at infinite
///     frequency, that is, the factor by which a step multiplies infinitely fast oscillations. By default 0.8.
/// rtol, atol : float or array_like of shape (n,)
///     A step is solved until the estimated error of the acceleration i is far below ``atol[i] + rtol[i] * abs(a[i])``. With
///     `adaptive` the local errors of displacement and velocity i are kept below ``atol[i] + rtol[i] * abs(q[i])`` and
///     ``atol[i] + rtol[i] * abs(v[i])``, in the root mean square. The unit of `atol` is that of q, of q per time, and of q per
///     time squared, respectively. By default errors of accelerations near zero move coordinates by rounding alone, in any
///     units, and local errors are controlled with 1e-9.
/// adaptive : bool
///     Whether an error estimate controls the step size.
/// max_step, min_step : float, optional
///     Bounds of adaptive steps.
/// max_steps : int, optional
///     Maximum number of accepted steps; by default unlimited.
/// t_eval : array_like, optional
///     Increasing output times. By default every step.
/// a0 : array_like, shape (n,), optional
///     Accelerations at t0, if they shall not be computed from the residual.
/// predictor : {'best', 'last', 'zero'}
///     Initial guess of the accelerations for Newton's method. 'last': those of the last step; 'zero'; 'best': zero, the last
///     ones or an extrapolation of the last two, whichever was best in the last step.
/// reuse_jacobian : bool
///     Whether factorised Jacobians are reused while they converge; otherwise every Newton iteration evaluates one.
/// args : tuple, optional
///     Additional arguments of `residual` and `jac`.
/// callback : callable, optional
///     Called as ``callback(t, q, v, a)`` after every accepted step. Returning True or raising StopIteration ends the
///     integration, whose result then has the status 'interrupted'.
///
/// Returns
/// -------
/// MotionResult
///     `t` of shape (m,), `q`, `v`, `a` of shape (m, n), `stats`, `success`, `status`, `message`. A numerical failure does not
///     raise: `success` is False, and the result contains everything up to the failure.
///
/// Raises
/// ------
/// ValueError, TypeError
///     If an argument or a value returned by `residual` or `jac` is invalid. Exceptions of the callables are raised unchanged.
/// KeyboardInterrupt
///     On Ctrl-C. Its attribute `result` is the MotionResult up to then.
///
/// Examples
/// --------
/// >>> import lissom
/// >>> result = lissom.newmark(lambda t, q, v, a: a + 4.0 * q, (0.0, 1.0), [1.0], [0.0], dt=0.1)
/// >>> result.success, result.q.shape
/// (True, (11, 1))
#[pyfunction]
#[pyo3(
    signature = (
        residual=None, t_span=None, q0=None, v0=None, *more, dt=None, beta=None, gamma=None, jac=None, method="newmark", alpha=None, rho_inf=None,
        rtol=None, atol=None, adaptive=false, max_step=None, min_step=0.0, max_steps=None, t_eval=None,
        a0=None, predictor="best", reuse_jacobian=true, args=None, callback=None, **others
    ),
    text_signature = "(residual, t_span, q0, v0, *, dt, beta=0.25, gamma=0.5, jac='forward', method='newmark', \
                      alpha=None, rho_inf=None, rtol=1e-06, atol=None, adaptive=False, max_step=None, min_step=0.0, \
                      max_steps=None, t_eval=None, a0=None, predictor='best', reuse_jacobian=True, args=None, \
                      callback=None)"
)]
#[allow(clippy::too_many_arguments, reason = "keyword-only options of a Python function")]
pub(crate) fn newmark<'py>(
    py: Python<'py>,
    #[pyo3(from_py_with = arguments::given)] residual: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::given)] t_span: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::given)] q0: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::given)] v0: Option<&Bound<'py, PyAny>>,
    more: &Bound<'_, PyTuple>,
    #[pyo3(from_py_with = arguments::given_number::dt)] dt: Option<f64>,
    #[pyo3(from_py_with = arguments::optional_number::beta)] beta: Option<f64>,
    #[pyo3(from_py_with = arguments::optional_number::gamma)] gamma: Option<f64>,
    jac: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::text::method)] method: &str,
    #[pyo3(from_py_with = arguments::optional_number::alpha)] alpha: Option<f64>,
    #[pyo3(from_py_with = arguments::optional_number::rho_inf)] rho_inf: Option<f64>,
    rtol: Option<&Bound<'py, PyAny>>,
    atol: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::flag::adaptive)] adaptive: bool,
    #[pyo3(from_py_with = arguments::optional_number::max_step)] max_step: Option<f64>,
    #[pyo3(from_py_with = arguments::number::min_step)] min_step: f64,
    #[pyo3(from_py_with = arguments::optional_whole::max_steps)] max_steps: Option<i64>,
    t_eval: Option<&Bound<'py, PyAny>>,
    a0: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::text::predictor)] predictor: &str,
    #[pyo3(from_py_with = arguments::flag::reuse_jacobian)] reuse_jacobian: bool,
    args: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::callback)] callback: Option<&Bound<'py, PyAny>>,
    others: Option<&Bound<'_, PyDict>>,
) -> PyResult<PyMotionResult> {
    let (residual, t_span, q0, v0, dt) = required!("newmark", others; more, residual, t_span, q0, v0, dt);
    let start = Instant::now();
    if !residual.is_callable() {
        return Err(PyTypeError::new_err(format!(
            "residual: expected a callable, got {}; the motion of a Model is for simulate, matrices are \
             `lambda t, q, v, a: M @ a + C @ v + K @ q - f(t)`",
            convert::describe(residual)
        )));
    }
    let t_span = super::ode::interval(t_span)?;
    let q0 = convert::vector(q0, "q0")?;
    let v0 = convert::vector_of(v0, q0.len(), "v0")?;
    let defaults = Options::new(dt);
    let (derivative, jac) = derivative(jac)?;
    let options = Options {
        scheme: scheme(method, &Parameters { beta, gamma, alpha, rho_inf })?,
        step_size: StepSize::new(adaptive, max_step, min_step).or_raise()?,
        derivative,
        rtol: rtol.map_or(Ok(defaults.rtol.clone()), |rtol| tolerance(rtol, "rtol"))?,
        atol: atol.map(|atol| tolerance(atol, "atol")).transpose()?,
        predictor: word(predictor, "predictor")?,
        reuse_jacobian,
        initial_acceleration: a0.map(|a0| convert::vector(a0, "a0")).transpose()?,
        max_steps: convert::step_limit(max_steps)?,
        ..defaults
    };
    let t_eval = times(t_eval)?;
    let has_own_jacobian = jac.is_some();
    let raised = SharedRaised::default();
    let args = args.map(unpack).transpose()?;
    let mut system =
        Equations { facts: Facts::of_equations(q0.len()), residual, jac, args, raised: raised.clone() };
    let mut monitor = |_: &mut Equations<'_, 'py>, stepper: &Stepper| {
        let Some(callback) = callback else { return Ok(()) };
        let (q, v, a) = (stepper.q(), stepper.v(), stepper.a());
        let state = (stepper.t(), q.to_pyarray(py), v.to_pyarray(py), a.to_pyarray(py));
        let stop = raised.catch(requests_stop(py, call(CALLBACK, callback, state)))?;
        if stop { Err(Interrupted) } else { Ok(()) }
    };
    let solution =
        solve(&mut system, t_span, &q0, &v0, &options, t_eval.as_deref(), &mut monitor).or_raise()?;
    let mut simulation = Simulation::from(solution);
    simulation.statistics.wall_time = start.elapsed().as_secs_f64();
    if has_own_jacobian
        && simulation.status == stepping::Status::SecondOrder(Status::StepFailed(Failure::NotConverged))
    {
        simulation
            .message
            .push_str(" Check `jac`, too: `lissom.check_jacobian` compares it with differences.");
    }
    finish(py, simulation, &[], None, raised.raise())
}

/// Arguments of functions of a state.
const STATE: &str = "t, q, v, a";

/// How a `callback` is called.
const CALLBACK: Form<'_> = Form { name: "callback", arguments: STATE, args: None };

/// The member of the family with this name.
fn scheme(method: &str, parameters: &Parameters) -> PyResult<Scheme> {
    Scheme::by_name(method, parameters).map_err(|error| name_methods(error, method, &[])).or_raise()
}

/// The source of the Jacobian from the argument `jac`, and the callable if it is one.
fn derivative<'a, 'py>(
    jac: Option<&'a Bound<'py, PyAny>>,
) -> PyResult<(Derivative, Option<&'a Bound<'py, PyAny>>)> {
    let Some(jac) = jac else { return Ok((Derivative::Forward, None)) };
    if jac.is_callable() {
        return Ok((Derivative::Analytic, Some(jac)));
    }
    match jac.cast::<PyString>().map(|name| name.to_string_lossy().into_owned()).as_deref() {
        Ok("forward") => Ok((Derivative::Forward, None)),
        Ok("central") => Ok((Derivative::Central, None)),
        _ => Err(PyValueError::new_err(format!(
            "jac: got {}, expected 'forward', 'central' or a callable",
            jac.repr()?
        ))),
    }
}

/// Equations of motion given by Python functions.
struct Equations<'a, 'py> {
    facts: Facts,
    residual: &'a Bound<'py, PyAny>,
    jac: Option<&'a Bound<'py, PyAny>>,
    args: Option<Bound<'py, PyTuple>>,
    raised: SharedRaised,
}

impl<'py> Equations<'_, 'py> {
    /// Calls `function(t, q, v, a, *args)` with new arrays that the function may keep.
    fn call(
        &self,
        name: &str,
        function: &Bound<'py, PyAny>,
        t: f64,
        state: [&[f64]; 3],
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = function.py();
        let args = self.args.as_ref().map_or(0, |args| args.len());
        let form = Form { name, arguments: STATE, args: Some(args) };
        py.check_signals()?;
        let [q, v, a] = state.map(|x| x.to_pyarray(py).into_any());
        let t = t.into_pyobject(py)?.into_any();
        match &self.args {
            None => call(form, function, (t, q, v, a)),
            Some(args) => {
                let arguments: Vec<_> = [t, q, v, a].into_iter().chain(args.iter()).collect();
                call(form, function, PyTuple::new(py, arguments)?)
            }
        }
    }

    fn tangents(&self, t: f64, state: [&[f64]; 3]) -> PyResult<[Matrix; 3]> {
        let jac = self.jac.expect("asked for only when jac is a callable");
        let value = self.call("jac", jac, t, state)?;
        let wrong = || {
            PyTypeError::new_err(format!(
                "jac: expected three ({n}, {n}) arrays, dr/dq, dr/dv, dr/da, got {}",
                convert::describe(&value),
                n = self.facts.n
            ))
        };
        let parts: Vec<Bound<'py, PyAny>> =
            value.try_iter().and_then(Iterator::collect).map_err(|_| wrong())?;
        let [dq, dv, da] = <[_; 3]>::try_from(parts).map_err(|_| wrong())?;
        let shape = (self.facts.n, self.facts.n);
        Ok([
            matrix_of(&dq, shape, "jac[0], dr/dq")?,
            matrix_of(&dv, shape, "jac[1], dr/dv")?,
            matrix_of(&da, shape, "jac[2], dr/da")?,
        ])
    }
}

impl SecondOrderSystem for Equations<'_, '_> {
    type Model = dyn Model;

    fn facts(&self) -> &Facts {
        &self.facts
    }

    fn residual(
        &mut self,
        t: f64,
        q: &[f64],
        v: &[f64],
        a: &[f64],
        residual: &mut [f64],
    ) -> Result<(), Interrupted> {
        let value = self
            .call("residual", self.residual, t, [q, v, a])
            .and_then(|value| read_vector(&value, residual, "residual"));
        self.raised.catch(value)
    }

    fn tangent(
        &mut self,
        t: f64,
        q: &[f64],
        v: &[f64],
        a: &[f64],
        weights: [f64; 3],
        tangent: &mut Matrix,
    ) -> Result<(), Interrupted> {
        let parts = self.raised.catch(self.tangents(t, [q, v, a]))?;
        tangent.fill(0.0);
        for (part, weight) in parts.iter().zip(weights) {
            tangent.zip_apply(part, |sum, entry| *sum += weight * entry);
        }
        Ok(())
    }

    fn model(&mut self) -> Option<&mut Self::Model> {
        None
    }
}
