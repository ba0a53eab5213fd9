//! `root`, `jacobian` and `check_jacobian`.

use numpy::{PyArray1, PyArray2, PyArrayMethods, ToPyArray};
use pyo3::class::{PyTraverseError, PyVisit};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyFloat, PyString, PyTuple};

use super::arguments;
use super::callback::{Form, Raised, call, with_result};
use super::convert::{count, describe, matrix_out, numbers, scalar_or_vector, vector_of};
use super::errors::{ConvergenceError, OrRaise as _};
use super::record::{self, ReadOnly, Reduced};
use crate::description::schema::suggestion;
use crate::error::{Checker, Interrupted, InvalidInput, Unfinished};
use crate::numerics::linalg::Matrix;
use crate::numerics::roots::{
    Derivative, Differences, Iterate, Method, Newton, NonlinearSystem, Options, Reuse, StepTolerance,
    check_jacobian,
};
use crate::python::words::required;

/// Result of `root`.
///
/// Attributes
/// ----------
/// x : float or ndarray, shape (n,)
///     The root; on failure the iterate with the smallest residual. A number if `x0` was one.
/// fun : float or ndarray, shape (m,)
///     The residual at `x`; a number if `fun` returned one.
/// success : bool
///     True if `x` is a root within the tolerances: by default, if the residual is at most `tol`, however far the root is.
/// status : str
///     How the search ended: 'converged_residual', 'converged_step', 'already_root' (successes),
///     'stationary_point', 'singular_jacobian', 'iteration_limit', 'diverged', 'stalled',
///     'line_search_failed', 'trust_region_collapsed', 'longest_steps', 'non_finite_residual',
///     'non_finite_jacobian' or 'interrupted' (in the `result` of a KeyboardInterrupt).
/// message : str
///     What happened, and after a failure what to change.
/// residual_norm : float
///     ``||fun / f_scale||_2``.
/// step_norm : float
///     ``||dx / x_scale||_2`` of the last step; NaN if none was taken.
/// nit, nfev, njev, nlu : int
///     Numbers of steps, evaluations of `fun` (including those for finite-difference Jacobians), Jacobians and factorisations.
/// nfev_jac : int
///     Number of evaluations for finite-difference Jacobians, included in `nfev`.
/// multiplicity : int or None
///     Estimated multiplicity of the root if convergence was linear.
/// doubt : str or None
///     Why `x` may be no root although the residual is below `tol`: the last steps became no shorter. The message has it, too.
/// history : dict of ndarray or None
///     Data of each iterate including the start, if requested: 'x', shape (nit + 1,) or (nit + 1, n); 'residual_norm',
///     'step_norm', 'step_length' (relative to the full Newton step) and 'rate' (of the residual norms),
///     shape (nit + 1,).
#[pyclass(frozen, get_all, name = "RootResult", module = "lissom")]
#[derive(FromPyObject)]
pub(crate) struct PyRootResult {
    x: ReadOnly,
    fun: ReadOnly,
    success: bool,
    status: String,
    message: String,
    residual_norm: f64,
    step_norm: f64,
    nit: usize,
    nfev: usize,
    njev: usize,
    nlu: usize,
    nfev_jac: usize,
    multiplicity: Option<usize>,
    doubt: Option<String>,
    history: Option<ReadOnly<PyDict>>,
}

#[pymethods]
impl PyRootResult {
    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let mut lines = vec![
            ("message", self.message.clone()),
            ("success", if self.success { "True" } else { "False" }.to_owned()),
            ("status", self.status.clone()),
            ("x", self.x.bind(py).repr()?.to_string()),
            ("fun", self.fun.bind(py).repr()?.to_string()),
            ("nit", self.nit.to_string()),
            ("nfev", self.nfev.to_string()),
            ("njev", self.njev.to_string()),
            ("nlu", self.nlu.to_string()),
        ];
        if let Some(multiplicity) = self.multiplicity {
            lines.push(("multiplicity", multiplicity.to_string()));
        }
        let lines: Vec<String> = lines.iter().map(|(name, value)| format!("{name:>12}: {value}")).collect();
        Ok(lines.join("\n"))
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(self.history.as_ref().map(ReadOnly::get))
    }

    /// For copies and pickles.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        record::reduce(slf)
    }

    #[staticmethod]
    fn _restore(state: &Bound<'_, PyAny>) -> PyResult<Self> {
        record::add_missing(state, &["doubt"])?;
        state.extract()
    }
}

/// Result of `check_jacobian`: the entry of the Jacobian that differs most from central differences.
///
/// Attributes
/// ----------
/// relative_difference : float
///     ``|given - difference|``, minus what rounding of `fun` explains, relative to the larger of the two; infinite if one of
///     them is not finite.
/// row, column : int
///     Indices of the entry.
/// given, difference : float
///     The entry from `jac` and from central differences.
#[pyclass(frozen, get_all, name = "JacobianCheck", module = "lissom")]
#[derive(FromPyObject)]
pub(crate) struct PyJacobianCheck {
    relative_difference: f64,
    row: usize,
    column: usize,
    given: f64,
    difference: f64,
}

#[pymethods]
impl PyJacobianCheck {
    fn __repr__(&self) -> String {
        format!(
            "JacobianCheck(relative_difference={:.3e}, row={}, column={}, given={:?}, difference={:?})",
            self.relative_difference, self.row, self.column, self.given, self.difference
        )
    }

    /// For copies and pickles.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        record::reduce(slf)
    }

    #[staticmethod]
    fn _restore(state: Self) -> Self {
        state
    }
}

/// A system whose residual, and optionally Jacobian, are Python functions.
struct PyFunctions<'a, 'py> {
    fun: &'a Bound<'py, PyAny>,
    jac: Option<&'a Bound<'py, PyAny>>,
    args: &'a Bound<'py, PyTuple>,
    /// Whether x0 was a number; the functions then receive a number.
    scalar: bool,
    unknowns: usize,
    /// R(x0), evaluated to determine its length and returned by the first call.
    first: Option<Vec<f64>>,
    equations: usize,
    scalar_fun: bool,
    raised: Raised,
}

impl<'a, 'py> PyFunctions<'a, 'py> {
    /// Evaluates `fun` once, at x0.
    fn new(
        fun: &'a Bound<'py, PyAny>,
        jac: Option<&'a Bound<'py, PyAny>>,
        args: &'a Bound<'py, PyTuple>,
        x0: &[f64],
        scalar: bool,
    ) -> PyResult<Self> {
        if !fun.is_callable() {
            return Err(PyTypeError::new_err(format!("fun: expected a callable, got {}", describe(fun))));
        }
        let mut functions = Self {
            fun,
            jac,
            args,
            scalar,
            unknowns: x0.len(),
            first: None,
            equations: 0,
            scalar_fun: false,
            raised: Raised::default(),
        };
        let (first, scalar_fun) = scalar_or_vector(&functions.call("fun", fun, x0)?, "fun(x)")?;
        functions.equations = first.len();
        functions.first = Some(first);
        functions.scalar_fun = scalar_fun;
        Ok(functions)
    }

    /// `function(x, *args)`, with a new x that the function may keep.
    fn call(&self, name: &str, function: &Bound<'py, PyAny>, x: &[f64]) -> PyResult<Bound<'py, PyAny>> {
        let py = function.py();
        let form = Form { name, arguments: "x", args: Some(self.args.len()) };
        py.check_signals()?;
        let x = if self.scalar { PyFloat::new(py, x[0]).into_any() } else { x.to_pyarray(py).into_any() };
        if self.args.is_empty() {
            call(form, function, (x,))
        } else {
            let arguments: Vec<_> = std::iter::once(x).chain(self.args.iter()).collect();
            call(form, function, PyTuple::new(py, arguments)?)
        }
    }

    fn evaluate(&self, x: &[f64], residual: &mut [f64]) -> PyResult<()> {
        let value = self.call("fun", self.fun, x)?;
        let (found, _) = scalar_or_vector(&value, "fun(x)")?;
        if found.len() != residual.len() {
            return Err(PyValueError::new_err(format!(
                "fun(x): expected {} values as at x0, got {}",
                residual.len(),
                found.len()
            )));
        }
        residual.copy_from_slice(&found);
        Ok(())
    }

    fn evaluate_jacobian(&self, x: &[f64], jacobian: &mut Matrix) -> PyResult<()> {
        let function = self.jac.expect("asked for only when jac is a callable");
        let value = self.call("jac", function, x)?;
        let (m, n) = jacobian.shape();
        let found = numbers(&value, "jac(x)", "an array of real numbers")?;
        // A vector or a number is accepted if m or n is one.
        if (m == 1 || n == 1) && found.shape.len() < 2 {
            if found.values.len() != m * n {
                return Err(PyValueError::new_err(format!(
                    "jac(x): expected shape ({m}, {n}), got {} values",
                    found.values.len()
                )));
            }
            // One dimension is one, so row-major and column-major order are the same.
            jacobian.as_mut_slice().copy_from_slice(&found.values);
        } else {
            jacobian.copy_from(&found.matrix((m, n), "jac(x)")?);
        }
        Ok(())
    }

    /// The residual as a number or an array, like the value returned by `fun`.
    fn output(&self, py: Python<'py>, residual: &[f64]) -> PyResult<ReadOnly> {
        number_or_array(py, residual, self.scalar_fun)
    }
}

impl NonlinearSystem for PyFunctions<'_, '_> {
    fn unknowns(&self) -> usize {
        self.unknowns
    }

    fn equations(&self) -> usize {
        self.equations
    }

    fn residual(&mut self, x: &[f64], residual: &mut [f64]) -> Result<(), Interrupted> {
        if let Some(first) = self.first.take() {
            residual.copy_from_slice(&first);
            return Ok(());
        }
        let result = self.evaluate(x, residual);
        self.raised.catch(result)
    }

    fn jacobian(&mut self, x: &[f64], jacobian: &mut Matrix) -> Result<(), Interrupted> {
        let result = self.evaluate_jacobian(x, jacobian);
        self.raised.catch(result)
    }
}

/// Find a root of a function of one or several variables by Newton's method.
///
/// Parameters
/// ----------
/// fun : callable
///     Residual ``fun(x, *args)``. x is a float if `x0` is a number, else an ndarray of shape (n,); the value is a number or an
///     array-like of shape (m,). If m and n differ, steps are minimum-norm least-squares steps.
/// x0 : float or array_like, shape (n,)
///     Initial guess.
/// args : tuple, optional
///     Additional arguments of `fun` and `jac`.
/// jac : {'forward', 'central'} or callable, optional
///     The Jacobian: forward differences (the default; n evaluations each), central differences (2n
///     evaluations, about three digits more), or ``jac(x, *args)`` of shape (m, n).
/// method : {'newton', 'line_search', 'trust_region'}, optional
///     Full Newton steps (the default), Newton steps with a line search that reduces the residual, or Powell's dogleg method in
///     a trust region.
/// tol : float, optional
///     Tolerance of the residual, ``||fun(x) / f_scale||_2 <= tol``; by default 1e-6.
/// max_iter : int, optional
///     Maximum number of steps; by default 1000.
/// xtol, xtol_abs : float, optional
///     Tolerances of the step. The search also converges if a Newton step satisfies
///     ``sqrt(mean((dx / (xtol_abs + xtol |x|))**2)) <= 1`` and the residual confirms it. Zero, the default, disables this
///     criterion.
/// x_scale : float or array_like, shape (n,), optional
///     Typical sizes of the unknowns; by default 1. Finite-difference increments are relative to ``max(|x|, x_scale)``.
/// f_scale : float or array_like, shape (m,), optional
///     Typical sizes of the residuals; by default 1.
/// max_step : float, optional
///     Maximum step, ``||dx / x_scale||_2``. By default 1000 times the norm of the start (at least 1000) for 'line_search', else
///     unlimited.
/// keep_jacobian : bool, optional
///     Reuse the factorised Jacobian as long as each step reduces the residual to a quarter or less. By default False.
/// accelerate : bool, optional
///     Lengthen the steps if they indicate a multiple root. By default False.
/// history : bool, optional
///     Keep every iterate in the result. By default False.
/// raise_on_failure : bool, optional
///     Raise `ConvergenceError` if the search fails. By default False.
///
/// Returns
/// -------
/// RootResult
///     `x`, `fun`, `success`, `status`, `message`, counters and more.
///
/// Raises
/// ------
/// ConvergenceError
///     If `raise_on_failure` is set and the search fails. Its attribute `result` is the RootResult.
/// ValueError, TypeError
///     If an argument or a value returned by `fun` or `jac` is invalid. Exceptions of `fun` and `jac` are raised unchanged.
/// KeyboardInterrupt
///     On Ctrl-C. Its attribute `result` is the RootResult with the best iterate until then; exceptions of `fun` and `jac`
///     during the search have it, too.
///
/// Examples
/// --------
/// >>> import lissom
/// >>> result = lissom.root(lambda x: x * x - 2.0, 1.0)
/// >>> result.status, round(result.x, 6)
/// ('converged_residual', 1.414214)
#[pyfunction]
#[pyo3(signature = (
    fun=None, x0=None, *more, args=None, jac=None, method="newton", tol=1e-6, max_iter=1000, xtol=0.0, xtol_abs=0.0,
    x_scale=None, f_scale=None, max_step=None, keep_jacobian=false, accelerate=false, history=false,
    raise_on_failure=false, **others
), text_signature = "(fun, x0, *, args=(), jac='forward', method='newton', tol=1e-06, max_iter=1000, \
xtol=0.0, xtol_abs=0.0, x_scale=None, f_scale=None, max_step=None, keep_jacobian=False, accelerate=False, \
history=False, raise_on_failure=False)")]
#[allow(clippy::too_many_arguments, reason = "keyword-only options of a Python function")]
pub(crate) fn root<'py>(
    py: Python<'py>,
    #[pyo3(from_py_with = arguments::given)] fun: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::given)] x0: Option<&Bound<'py, PyAny>>,
    more: &Bound<'_, PyTuple>,
    args: Option<Bound<'py, PyTuple>>,
    jac: Option<Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::text::method)] method: &str,
    #[pyo3(from_py_with = arguments::number::tol)] tol: f64,
    #[pyo3(from_py_with = arguments::whole::max_iter)] max_iter: i64,
    #[pyo3(from_py_with = arguments::number::xtol)] xtol: f64,
    #[pyo3(from_py_with = arguments::number::xtol_abs)] xtol_abs: f64,
    x_scale: Option<Bound<'py, PyAny>>,
    f_scale: Option<Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::optional_number::max_step)] max_step: Option<f64>,
    #[pyo3(from_py_with = arguments::flag::keep_jacobian)] keep_jacobian: bool,
    #[pyo3(from_py_with = arguments::flag::accelerate)] accelerate: bool,
    #[pyo3(from_py_with = arguments::flag::history)] history: bool,
    #[pyo3(from_py_with = arguments::flag::raise_on_failure)] raise_on_failure: bool,
    others: Option<&Bound<'_, PyDict>>,
) -> PyResult<Py<PyRootResult>> {
    let (fun, x0) = required!("root", others; more, fun, x0);
    let (mut x, scalar) = scalar_or_vector(x0, "x0")?;
    let mut checker = Checker::new();
    checker.finite(&x, "x0");
    checker.finish().or_raise()?;
    let jac = jac.unwrap_or_else(|| PyString::new(py, "forward").into_any());
    let options = Options {
        method: method_named(method)?,
        derivative: derivative_of(&jac)?,
        residual_tolerance: tol,
        step_tolerance: StepTolerance { absolute: xtol_abs, relative: xtol },
        max_iter: count(max_iter, "max_iter")?,
        reuse: if keep_jacobian { Reuse::WithinSolve } else { Reuse::Never },
        longest_step: max_step,
        accelerate,
        history,
        ..Options::default()
    };
    options.check().map_err(with_python_names).or_raise()?;
    let args = args.unwrap_or_else(|| PyTuple::empty(py));
    let function = (options.derivative == Derivative::Analytic).then_some(&jac);
    let mut system = PyFunctions::new(fun, function, &args, &x, scalar)?;
    Newton::check_memory(system.unknowns, system.equations).or_raise()?;
    let x_scale = scale(x_scale.as_ref(), system.unknowns, "x_scale")?;
    let f_scale = scale(f_scale.as_ref(), system.equations, "f_scale")?;
    let mut newton =
        Newton::new(system.unknowns, system.equations).with_scales(&x_scale, &f_scale).or_raise()?;
    let outcome = newton.solve(&mut system, &mut x, &options).unwrap_or_else(Unfinished::into_inner);
    let result = Py::new(
        py,
        PyRootResult {
            x: number_or_array(py, &x, scalar)?,
            fun: system.output(py, newton.residual())?,
            success: outcome.status.is_success(),
            status: outcome.status.name().to_owned(),
            message: outcome.message(),
            residual_norm: outcome.residual_norm,
            step_norm: outcome.step_norm,
            nit: outcome.iterations,
            nfev: outcome.residual_evaluations,
            njev: outcome.jacobian_evaluations,
            nlu: outcome.factorisations,
            nfev_jac: outcome.difference_evaluations,
            multiplicity: outcome.multiplicity,
            doubt: outcome.doubt(),
            history: if history { Some(history_out(py, newton.history(), scalar)?) } else { None },
        },
    )?;
    if let Err(error) = system.raised.into_result() {
        return Err(with_result(py, error, || Ok(result)));
    }
    if raise_on_failure && !outcome.status.is_success() {
        let error = ConvergenceError::new_err(outcome.message());
        error.value(py).setattr("result", result)?;
        return Err(error);
    }
    Ok(result)
}

/// Jacobian by finite differences.
///
/// Parameters
/// ----------
/// fun : callable
///     ``fun(x, *args)``, of shape (m,) or a number.
/// x : float or array_like, shape (n,)
///     Point at which the Jacobian is evaluated.
/// method : {'central', 'forward'}, optional
///     Central differences with increments ``eps**(1/3) max(|x|, x_scale)`` (error about eps**(2/3), 2n
///     evaluations; the default), or forward differences with ``eps**(1/2) max(|x|, x_scale)`` (error about
///     eps**(1/2), n + 1 evaluations).
/// x_scale : float or array_like, shape (n,), optional
///     Typical sizes of the unknowns; by default 1.
/// args : tuple, optional
///     Additional arguments of `fun`.
///
/// Returns
/// -------
/// ndarray, shape (m, n)
///
/// Raises
/// ------
/// ValueError
///     If `fun` is NaN or infinite near `x`.
#[pyfunction]
#[pyo3(signature = (fun=None, x=None, method="central", *, x_scale=None, args=None, **others),
    text_signature = "(fun, x, method='central', *, x_scale=None, args=())")]
pub(crate) fn jacobian<'py>(
    py: Python<'py>,
    #[pyo3(from_py_with = arguments::given)] fun: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::given)] x: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::text::method)] method: &str,
    x_scale: Option<Bound<'py, PyAny>>,
    args: Option<Bound<'py, PyTuple>>,
    others: Option<&Bound<'_, PyDict>>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (fun, x) = required!("jacobian", others, fun, x);
    let (x, scalar) = finite_point(x)?;
    let derivative = difference_named(method, "method", "'central' or 'forward'")?;
    let args = args.unwrap_or_else(|| PyTuple::empty(py));
    let mut system = PyFunctions::new(fun, None, &args, &x, scalar)?;
    let (m, n) = (system.equations, system.unknowns);
    let x_scale = positive_scale(x_scale.as_ref(), n)?;
    Differences::check_memory(n, m).or_raise()?;
    let mut jacobian = Matrix::zeros(m, n);
    let residual = system.first.take().expect("fun was evaluated at x");
    let mut differences = Differences::new(n, m);
    let done = match derivative {
        Derivative::Forward => differences.forward(&mut system, &x, &residual, &x_scale, &mut jacobian),
        _ => differences.central(&mut system, &x, &x_scale, &mut jacobian),
    };
    if done.is_err() {
        system.raised.into_result()?;
    }
    if let Some(at) = jacobian.as_slice().iter().position(|entry| !entry.is_finite()) {
        let (row, column) = (at % m, at / m);
        return Err(PyValueError::new_err(format!(
            "fun: component {row} is NaN or infinite at or next to x, or its derivative with respect to x[{column}] is: expected finite \
             values"
        )));
    }
    Ok(matrix_out(py, &jacobian))
}

/// Compare a Jacobian with central differences.
///
/// Parameters
/// ----------
/// fun : callable
///     ``fun(x, *args)``, of shape (m,) or a number.
/// jac : callable
///     ``jac(x, *args)``, of shape (m, n).
/// x : float or array_like, shape (n,)
///     Point at which the Jacobian is evaluated.
/// x_scale : float or array_like, shape (n,), optional
///     Typical sizes of the unknowns; by default 1.
/// args : tuple, optional
///     Additional arguments of both functions.
///
/// Returns
/// -------
/// JacobianCheck
///     The entry that differs most: `relative_difference`, `row`, `column`, `given`, `difference`. A correct Jacobian gives about
///     1e-9, a wrong one about 1.
#[pyfunction(name = "check_jacobian")]
#[pyo3(signature = (fun=None, jac=None, x=None, *, x_scale=None, args=None, **others),
    text_signature = "(fun, jac, x, *, x_scale=None, args=())")]
pub(crate) fn check_jacobian_of<'py>(
    py: Python<'py>,
    #[pyo3(from_py_with = arguments::given)] fun: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::given)] jac: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::given)] x: Option<&Bound<'py, PyAny>>,
    x_scale: Option<Bound<'py, PyAny>>,
    args: Option<Bound<'py, PyTuple>>,
    others: Option<&Bound<'_, PyDict>>,
) -> PyResult<PyJacobianCheck> {
    let (fun, jac, x) = required!("check_jacobian", others, fun, jac, x);
    let (x, scalar) = finite_point(x)?;
    if !jac.is_callable() {
        return Err(PyTypeError::new_err(format!("jac: expected a callable, got {}", describe(jac))));
    }
    let args = args.unwrap_or_else(|| PyTuple::empty(py));
    let mut system = PyFunctions::new(fun, Some(jac), &args, &x, scalar)?;
    Differences::check_memory(system.unknowns, system.equations).or_raise()?;
    let x_scale = positive_scale(x_scale.as_ref(), x.len())?;
    let checked = check_jacobian(&mut system, &x, &x_scale);
    let Ok(check) = checked else {
        system.raised.into_result()?;
        unreachable!("only a Python exception interrupts this comparison");
    };
    let check =
        check.ok_or_else(|| PyValueError::new_err("x: expected at least one unknown and one equation"))?;
    Ok(PyJacobianCheck {
        relative_difference: check.relative_difference,
        row: check.row,
        column: check.column,
        given: check.given,
        difference: check.difference,
    })
}

/// Replaces names of options by those of the arguments of `root`.
fn with_python_names(mut error: InvalidInput) -> InvalidInput {
    for problem in &mut error.problems {
        problem.place = match problem.place.as_str() {
            "residual_tolerance" => "tol",
            "step_tolerance.relative" => "xtol",
            "step_tolerance.absolute" => "xtol_abs",
            "longest_step" => "max_step",
            other => other,
        }
        .to_owned();
    }
    error
}

fn finite_point(x: &Bound<'_, PyAny>) -> PyResult<(Vec<f64>, bool)> {
    let (x, scalar) = scalar_or_vector(x, "x")?;
    let mut checker = Checker::new();
    checker.finite(&x, "x");
    checker.finish().or_raise()?;
    Ok((x, scalar))
}

/// Scales: ones by default, one number for all, or one for each.
fn scale(value: Option<&Bound<'_, PyAny>>, n: usize, name: &str) -> PyResult<Vec<f64>> {
    let Some(value) = value else { return Ok(vec![1.0; n]) };
    match scalar_or_vector(value, name)? {
        (number, true) => Ok(vec![number[0]; n]),
        _ => vector_of(value, n, name),
    }
}

fn positive_scale(value: Option<&Bound<'_, PyAny>>, n: usize) -> PyResult<Vec<f64>> {
    let scale = scale(value, n, "x_scale")?;
    let mut checker = Checker::new();
    for (j, &value) in scale.iter().enumerate() {
        checker.positive(value, &format!("x_scale[{j}]"), "units of x");
    }
    checker.finish().or_raise()?;
    Ok(scale)
}

fn method_named(name: &str) -> PyResult<Method> {
    match name {
        "newton" => Ok(Method::Newton),
        "line_search" => Ok(Method::LineSearch),
        "trust_region" => Ok(Method::TrustRegion),
        _ => {
            let meant = suggestion(name, ["newton", "line_search", "trust_region"].into_iter());
            let meant = meant.map_or_else(String::new, |meant| format!("; did you mean '{meant}'?"));
            Err(PyValueError::new_err(format!(
                "method: got '{name}', expected 'newton', 'line_search' or 'trust_region'{meant}"
            )))
        }
    }
}

fn derivative_of(jac: &Bound<'_, PyAny>) -> PyResult<Derivative> {
    const EXPECTED: &str = "'forward', 'central' or a callable";
    if jac.is_callable() {
        return Ok(Derivative::Analytic);
    }
    match jac.cast::<PyString>() {
        Ok(name) => difference_named(&name.to_string_lossy(), "jac", EXPECTED),
        Err(_) => Err(PyTypeError::new_err(format!("jac: got {}, expected {EXPECTED}", describe(jac)))),
    }
}

fn difference_named(name: &str, place: &str, expected: &str) -> PyResult<Derivative> {
    match name {
        "forward" => Ok(Derivative::Forward),
        "central" => Ok(Derivative::Central),
        _ => Err(PyValueError::new_err(format!("{place}: got '{name}', expected {expected}"))),
    }
}

fn number_or_array(py: Python<'_>, values: &[f64], number: bool) -> PyResult<ReadOnly> {
    ReadOnly::new(if number {
        PyFloat::new(py, values[0]).into_any()
    } else {
        values.to_pyarray(py).into_any()
    })
}

fn history_out(py: Python<'_>, history: &[Iterate], scalar: bool) -> PyResult<ReadOnly<PyDict>> {
    let dict = PyDict::new(py);
    let points: Vec<f64> = history.iter().flat_map(|iterate| iterate.x.iter().copied()).collect();
    let points = PyArray1::from_vec(py, points);
    if scalar {
        dict.set_item("x", points)?;
    } else {
        dict.set_item("x", points.reshape([history.len(), history[0].x.len()])?)?;
    }
    let column = |name: &str, value: fn(&Iterate) -> f64| {
        dict.set_item(name, PyArray1::from_iter(py, history.iter().map(value)))
    };
    column("residual_norm", |iterate| iterate.residual_norm)?;
    column("step_norm", |iterate| iterate.step_norm)?;
    column("step_length", |iterate| iterate.step_length)?;
    column("rate", |iterate| iterate.rate)?;
    ReadOnly::new(dict)
}
