//! Right-hand sides from Python: callables, compiled functions, and lissom's models.

use std::sync::{Arc, Mutex, PoisonError};

use pyo3::class::{PyTraverseError, PyVisit};
use pyo3::exceptions::{PyTypeError, PyUserWarning};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use super::super::callback::Raised;
use super::super::compiled::CompiledFunction;
use super::super::convert;
use super::super::model::PyModel;
use super::super::motion::Ticker;
use super::function::{Function, matrix_of, read_column, read_matrix, read_vector};
use crate::error::Interrupted;
use crate::integrators::Reason;
use crate::integrators::ode::{FirstOrderSystem, JacobianKind, Method};
use crate::numerics::linalg::Matrix;

/// The exception that stopped an integration, shared by the system, the events and the monitor.
#[derive(Clone, Debug, Default)]
pub(crate) struct SharedRaised(Arc<Mutex<Raised>>);

impl SharedRaised {
    pub(crate) fn catch<T>(&self, result: PyResult<T>) -> Result<T, Interrupted> {
        match result {
            Ok(value) => Ok(value),
            Err(error) => self.0.lock().unwrap_or_else(PoisonError::into_inner).catch(Err(error)),
        }
    }

    /// Raises the stored exception, if any.
    pub(crate) fn raise(&self) -> PyResult<()> {
        std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner)).into_result()
    }
}

/// A system given by Python objects.
pub(super) struct PySystem {
    n: usize,
    rhs: RightHandSide,
    jacobian: Jacobian,
    raised: SharedRaised,
    ticker: Ticker,
}

enum RightHandSide {
    Python(Function),
    /// Takes and returns columns.
    Vectorized(Function),
    Compiled(CompiledFunction),
    /// A copy of a model, and the model, which owns the functions of time that the copy calls.
    Native(Box<dyn FirstOrderSystem + Send + Sync>, Py<PyModel>),
}

impl RightHandSide {
    /// The motion of a model.
    fn of_model(&self) -> Option<&(dyn FirstOrderSystem + Send + Sync)> {
        if let Self::Native(system, _) = self { Some(&**system) } else { None }
    }

    fn of_model_mut(&mut self) -> Option<&mut (dyn FirstOrderSystem + Send + Sync)> {
        if let Self::Native(system, _) = self { Some(&mut **system) } else { None }
    }
}

enum Jacobian {
    Differenced,
    Python(Function),
    /// A compiled function; its output by rows.
    Compiled(CompiledFunction, Vec<f64>),
    Constant(Matrix),
    Native,
}

/// The arguments of `solve_ivp` that make up the system.
pub(super) struct Parts<'a, 'py> {
    pub(super) fun: &'a Bound<'py, PyAny>,
    pub(super) args: Option<&'a Bound<'py, PyAny>>,
    pub(super) jac: Option<&'a Bound<'py, PyAny>>,
    pub(super) vectorized: bool,
    pub(super) method: Method,
    pub(super) n: usize,
}

impl PySystem {
    pub(super) fn new(parts: &Parts<'_, '_>, raised: SharedRaised) -> PyResult<Self> {
        let &Parts { fun, args, jac, vectorized, method, n } = parts;
        let implicit = method == Method::Radau;
        if jac.is_some() && !implicit {
            PyErr::warn(
                fun.py(),
                &fun.py().get_type::<PyUserWarning>(),
                c"The following arguments have no effect for a chosen solver: `jac`.",
                1,
            )?;
        }
        let jac = jac.filter(|_| implicit);
        if let Ok(model) = fun.cast::<PyModel>() {
            model.get().check_modes()?;
            return Self::from_model(model, args, jac, raised);
        }
        let numbers = args.and_then(|args| convert::vector(args, "args").ok());
        if let Some(compiled) = CompiledFunction::find(fun, (n, n), numbers.as_deref(), "fun")? {
            if args.is_some() && numbers.is_none() {
                return Err(PyTypeError::new_err(format!(
                    "args: expected numbers for a compiled function, got {}",
                    args.map_or_else(String::new, convert::describe)
                )));
            }
            let jacobian = Jacobian::find(jac, n, None, numbers.as_deref())?;
            return Ok(Self::of(n, RightHandSide::Compiled(compiled), jacobian, raised));
        }
        if !fun.is_callable() {
            return Err(PyTypeError::new_err(format!(
                "fun: expected a callable, a compiled function (numba.cfunc, scipy.LowLevelCallable, ctypes) or a model \
                 of lissom, got {}",
                convert::describe(fun)
            )));
        }
        let args = args.map(unpack).transpose()?;
        let jacobian = Jacobian::find(jac, n, args.as_ref(), numbers.as_deref())?;
        let function = Function::new("fun", fun, args.as_ref());
        let rhs =
            if vectorized { RightHandSide::Vectorized(function) } else { RightHandSide::Python(function) };
        Ok(Self::of(n, rhs, jacobian, raised))
    }

    fn of(n: usize, rhs: RightHandSide, jacobian: Jacobian, raised: SharedRaised) -> Self {
        Self { n, rhs, jacobian, raised, ticker: Ticker::new() }
    }

    /// Responds to Ctrl-C if no Python code runs. Not in a monitor, because rejected steps count too.
    fn check_signals(&mut self) -> Result<(), Interrupted> {
        if !self.ticker.tick() {
            return Ok(());
        }
        self.raised.catch(Python::attach(|py| py.check_signals()))
    }

    fn from_model(
        model: &Bound<'_, PyModel>,
        args: Option<&Bound<'_, PyAny>>,
        jac: Option<&Bound<'_, PyAny>>,
        raised: SharedRaised,
    ) -> PyResult<Self> {
        let unwanted = [("args", args), ("jac", jac)].into_iter().find(|(_, value)| value.is_some());
        if let Some((name, _)) = unwanted {
            return Err(PyTypeError::new_err(format!("{name}: has no meaning for a model; leave it out")));
        }
        let system = model.get().native().first_order();
        let n = system.n();
        let native = RightHandSide::Native(system, model.clone().unbind());
        Ok(Self::of(n, native, Jacobian::Native, raised))
    }

    /// True if no Python code runs in an evaluation.
    pub(super) fn is_native(&self) -> bool {
        matches!(self.rhs, RightHandSide::Compiled(_) | RightHandSide::Native(..))
            && !matches!(self.jacobian, Jacobian::Python(_))
    }

    pub(super) fn traverse(&self, visit: &PyVisit<'_>) -> Result<(), PyTraverseError> {
        match &self.rhs {
            RightHandSide::Python(function) | RightHandSide::Vectorized(function) => {
                function.traverse(visit)?;
            }
            RightHandSide::Compiled(function) => function.traverse(visit)?,
            RightHandSide::Native(_, model) => visit.call(model)?,
        }
        match &self.jacobian {
            Jacobian::Python(function) => function.traverse(visit),
            Jacobian::Compiled(function, _) => function.traverse(visit),
            Jacobian::Differenced | Jacobian::Constant(_) | Jacobian::Native => Ok(()),
        }
    }
}

impl Jacobian {
    fn find(
        jac: Option<&Bound<'_, PyAny>>,
        n: usize,
        args: Option<&Bound<'_, PyTuple>>,
        numbers: Option<&[f64]>,
    ) -> PyResult<Self> {
        let Some(jac) = jac else { return Ok(Self::Differenced) };
        if let Some(compiled) = CompiledFunction::find(jac, (n, n * n), numbers, "jac")? {
            return Ok(Self::Compiled(compiled, vec![0.0; n * n]));
        }
        if jac.is_callable() {
            return Ok(Self::Python(Function::new("jac", jac, args)));
        }
        Ok(Self::Constant(matrix_of(jac, (n, n), "jac")?))
    }
}

/// `args` as a tuple.
pub(crate) fn unpack<'py>(args: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyTuple>> {
    if let Ok(tuple) = args.cast::<PyTuple>() {
        return Ok(tuple.clone());
    }
    let items: PyResult<Vec<Bound<'py, PyAny>>> = args.try_iter().and_then(Iterator::collect);
    let items = items.map_err(|_| {
        PyTypeError::new_err(format!(
            "Supplied 'args' cannot be unpacked: expected a tuple, such as `args=({args},)`"
        ))
    })?;
    PyTuple::new(args.py(), items)
}

impl FirstOrderSystem for PySystem {
    fn n(&self) -> usize {
        self.n
    }

    fn wrap(&mut self, y: &mut [f64], dydt: &mut [f64]) -> bool {
        self.rhs.of_model_mut().is_some_and(|system| system.wrap(y, dydt))
    }

    fn horizon(&self, t: f64) -> f64 {
        self.rhs.of_model().map_or(f64::INFINITY, |system| system.horizon(t))
    }

    fn refusal(
        &mut self,
        t: [f64; 2],
        y: [&[f64]; 2],
        dydt: [&[f64]; 2],
        is_judged: bool,
    ) -> Result<Option<Reason>, Interrupted> {
        self.rhs.of_model_mut().map_or(Ok(None), |system| system.refusal(t, y, dydt, is_judged))
    }

    fn rhs(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) -> Result<(), Interrupted> {
        if matches!(self.rhs, RightHandSide::Compiled(_) | RightHandSide::Native(..)) {
            self.check_signals()?;
        }
        match &mut self.rhs {
            RightHandSide::Native(system, _) => system.rhs(t, y, dydt),
            RightHandSide::Compiled(function) => {
                function.call(t, y, dydt);
                Ok(())
            }
            RightHandSide::Python(function) => self.raised.catch(Python::attach(|py| {
                let value = function.call(py, t, y)?;
                read_vector(&value, dydt, "fun")
            })),
            RightHandSide::Vectorized(function) => self.raised.catch(Python::attach(|py| {
                let value = function.call_columns(py, t, &Matrix::from_column_slice(y.len(), 1, y))?;
                read_column(&value, dydt, "fun")
            })),
        }
    }

    fn rhs_columns(&mut self, t: f64, y: &Matrix, dydt: &mut Matrix) -> Result<(), Interrupted> {
        if let RightHandSide::Vectorized(function) = &self.rhs {
            return self.raised.catch(Python::attach(|py| {
                let value = function.call_columns(py, t, y)?;
                read_matrix(&value, dydt, "fun")
            }));
        }
        for (y, mut dydt) in y.column_iter().zip(dydt.column_iter_mut()) {
            self.rhs(t, y.as_slice(), dydt.as_mut_slice())?;
        }
        Ok(())
    }

    fn jacobian_kind(&self) -> JacobianKind {
        match &self.jacobian {
            Jacobian::Differenced => JacobianKind::Differenced,
            Jacobian::Python(_) | Jacobian::Compiled(..) | Jacobian::Native => JacobianKind::Supplied,
            Jacobian::Constant(_) => JacobianKind::Constant,
        }
    }

    fn jacobian(&mut self, t: f64, y: &[f64], jacobian: &mut Matrix) -> Result<(), Interrupted> {
        let n = self.n;
        match (&mut self.jacobian, &mut self.rhs) {
            (Jacobian::Constant(matrix), _) => jacobian.copy_from(matrix),
            (Jacobian::Compiled(function, rows), _) => {
                function.call(t, y, rows);
                for i in 0..n {
                    for j in 0..n {
                        jacobian[(i, j)] = rows[i * n + j];
                    }
                }
            }
            (Jacobian::Python(function), _) => {
                return self.raised.catch(Python::attach(|py| {
                    let value = function.call(py, t, y)?;
                    read_matrix(&value, jacobian, "jac")
                }));
            }
            (Jacobian::Native, RightHandSide::Native(system, _)) => return system.jacobian(t, y, jacobian),
            (Jacobian::Native | Jacobian::Differenced, _) => {
                unreachable!("asked for according to `jacobian_kind` only")
            }
        }
        Ok(())
    }
}
