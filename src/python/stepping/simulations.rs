//! `lissom.Simulations`.

use std::sync::atomic::Ordering;
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};

use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::class::{PyTraverseError, PyVisit};
use pyo3::exceptions::{PyIndexError, PyRuntimeError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use super::super::arguments;
use super::super::callback::{Raised, raised_by_function};
use super::super::convert;
use super::super::inputs::{has_names, numbered};
use super::super::model::PyModel;
use super::super::motion::signals;
use super::super::record::{self, Reduced};
use super::super::remarks;
use super::super::rows::{Vectors, check_alike, each, of_row, threads};
use super::memory::{Memory, Outcome, STEPS_WITH_INTERPRETER, Start, check_start_time};
use super::simulation::PySimulation;
use crate::error::Interrupted;
use crate::numerics::parallel;
use crate::python::errors::OrRaise as _;
use crate::python::words::{no_others, required};
use crate::simulation::methods::Configuration;
use crate::simulation::stepping::Status;
use crate::simulation::time_limit::TimeLimit;

/// Memory of the smallest row, in numbers: measured as 1.4 kB for a spring pendulum.
const NUMBERS_OF_A_ROW: usize = 170;

/// Many simulations that you advance together step by step, in parallel.
///
/// Each motion is a row, bitwise equal to a `Simulation` with the same model, initial state and inputs, for
/// any number of threads. A row that fails keeps the state before the failed step and does not affect the
/// others.
///
/// Parameters
/// ----------
/// model : Model or sequence of Model
///     One model for `count` rows, or one per row. All must have the same number of coordinates and the same
///     inputs.
/// count : int, optional
///     Number of rows; by default the number of models.
/// dt : float
///     As for `Simulation`.
/// q0, v0 : array_like, shape (n,) or (count, n), optional
///     Initial coordinates and velocities for all rows or one row each; by default zero.
/// t0 : float
///     Initial time, seconds.
/// workers : int, optional
///     Maximum number of threads; by default the number of processors. Steps that take less than about 0.2 ms
///     in total run in the calling thread.
/// method, rtol, atol, beta, gamma, alpha, rho_inf, adaptive, max_step, min_step, max_seconds : optional
///     As for `Simulation`.
///
/// Attributes
/// ----------
/// models : tuple of Model
///     The models, one per row.
/// count, workers : int
///     Number of rows and maximum number of threads.
/// t : ndarray, shape (count,)
///     Current times, seconds.
/// q, v, a : ndarray, shape (count, n)
///     Copies of the current coordinates, velocities and accelerations.
/// u : ndarray, shape (count, inputs)
///     The current inputs.
/// status : list of str
///     Outcome of the last step of each row, as in `Simulation`.
/// success : ndarray of bool, shape (count,)
///     False after a step that failed.
///
/// Raises
/// ------
/// ValueError, TypeError
///     If an argument is invalid.
///
/// Examples
/// --------
/// >>> import lissom, numpy as np
/// >>> starts = [[-0.8, 0.1 * i] for i in range(5)]
/// >>> swarm = lissom.Simulations(lissom.SpringPendulum(), 5, dt=0.01, q0=starts)
/// >>> for _ in range(100):
/// ...     success = swarm.step()
/// >>> success.all(), swarm.t, swarm.q.shape
/// (np.True_, array([1., 1., 1., 1., 1.]), (5, 2))
///
/// `swarm[2]` is a `Simulation` that continues from the state of that row.
#[pyclass(name = "Simulations", module = "lissom", frozen)]
pub(crate) struct PySimulations {
    models: Vec<Py<PyModel>>,
    /// As in `Simulation`.
    options: Py<PyDict>,
    configuration: Configuration,
    workers: usize,
    n: usize,
    inputs: usize,
    rows: Mutex<Vec<Memory>>,
}

impl PySimulations {
    /// Fails if a function called during a step, or another thread during a step, uses the simulations.
    fn rows(&self) -> PyResult<MutexGuard<'_, Vec<Memory>>> {
        match self.rows.try_lock() {
            Ok(rows) => Ok(rows),
            Err(TryLockError::Poisoned(poisoned)) => Ok(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => {
                Err(PyRuntimeError::new_err("the simulations are in the middle of a step"))
            }
        }
    }

    /// Rows from these initial states. A row with the same start as the previous one is copied from it.
    fn begin<'a>(
        py: Python<'_>,
        configuration: &Configuration,
        limit: TimeLimit,
        starts: impl Iterator<Item = (&'a Py<PyModel>, Start)>,
    ) -> PyResult<Vec<Memory>> {
        let mut rows: Vec<Memory> = Vec::with_capacity(starts.size_hint().0);
        let mut before = None;
        for (model, start) in starts {
            let row = match rows.last() {
                Some(last) if before == Some(model.as_ptr()) && last.start == start => last.copy(),
                _ => Memory::begin(py, model.get(), configuration, limit, start)
                    .map_err(|error| of_row(py, rows.len(), &error))?,
            };
            before = Some(model.as_ptr());
            rows.push(row);
        }
        Ok(rows)
    }

    /// The rows selected by `which`: a mask of all rows, or their indices.
    fn chosen(&self, which: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<usize>> {
        let count = self.models.len();
        let Some(which) = which else {
            return Ok((0..count).collect());
        };
        let refused = |found: &Bound<'_, PyAny>| {
            PyTypeError::new_err(format!(
                "which: expected a mask of shape ({count},) or numbers of rows, got {}",
                convert::describe(found)
            ))
        };
        let array = which.py().import("numpy")?.call_method1("atleast_1d", (which,));
        let array = array.map_err(|_| refused(which))?;
        let wrong = || refused(&array);
        if array.len()? == 0 {
            return Ok(Vec::new());
        }
        match convert::kind_of(&array) {
            Some('b') => {
                let mask: Vec<bool> = array.call_method0("tolist")?.extract().map_err(|_| wrong())?;
                if mask.len() != count {
                    return Err(wrong());
                }
                Ok((0..count).filter(|&row| mask[row]).collect())
            }
            Some('i' | 'u') => {
                let numbers: Vec<i64> = array.call_method0("tolist")?.extract().map_err(|_| wrong())?;
                let (mut chosen, mut is_chosen) = (Vec::with_capacity(numbers.len()), vec![false; count]);
                for (i, number) in numbers.into_iter().enumerate() {
                    let row = self.row(number).ok_or_else(|| {
                        let expected = format!("a row, from 0 to {}", count - 1);
                        PyValueError::new_err(format!("which[{i}]: got {number}, expected {expected}"))
                    })?;
                    if std::mem::replace(&mut is_chosen[row], true) {
                        return Err(PyValueError::new_err(format!(
                            "which[{i}]: row {number} is listed twice: give each row once"
                        )));
                    }
                    chosen.push(row);
                }
                Ok(chosen)
            }
            _ => Err(wrong()),
        }
    }

    /// The index of a row; negative numbers count from the end.
    fn row(&self, number: i64) -> Option<usize> {
        let count = i64::try_from(self.models.len()).ok()?;
        let number = if number < 0 { number + count } else { number };
        (0..count).contains(&number).then(|| usize::try_from(number).expect("it is not negative"))
    }

    fn existing_row(&self, number: i64) -> PyResult<usize> {
        let count = self.models.len();
        self.row(number).ok_or_else(|| {
            PyIndexError::new_err(format!(
                "row: got {number}, expected a row of {count} simulations, {} to {}",
                -(count as i64),
                count as i64 - 1
            ))
        })
    }

    /// A number for each row.
    fn of_rows<'py, T: numpy::Element>(
        &self,
        py: Python<'py>,
        number: impl Fn(&Memory) -> T,
    ) -> PyResult<Bound<'py, PyArray1<T>>> {
        Ok(self.rows()?.iter().map(number).collect::<Vec<_>>().into_pyarray(py))
    }

    /// A vector for each row.
    fn vectors<'py>(
        &self,
        py: Python<'py>,
        width: usize,
        vector: impl Fn(&Memory) -> &[f64],
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let rows = self.rows()?;
        let mut values = Vec::with_capacity(rows.len() * width);
        for row in &*rows {
            values.extend_from_slice(vector(row));
        }
        let values = Array2::from_shape_vec((rows.len(), width), values);
        Ok(values.expect("every row has a vector of this width").into_pyarray(py))
    }

    /// Advances all rows to their end times, distributed over the threads.
    fn finish(&self, py: Python<'_>, rows: &mut [Memory]) -> PyResult<()> {
        // The first exception of a function of time.
        let of_function = Mutex::new(None);
        let mut raised = Raised::default();
        let finished = py.detach(|| {
            let mut watch = signals(&mut raised);
            parallel::for_each(
                rows,
                self.workers,
                |row, is_over| {
                    let mut limit = row.limit.again();
                    let outcome = row.run.finish(&mut |t| {
                        if is_over.load(Ordering::Relaxed) { Err(Interrupted) } else { limit.check(t) }
                    });
                    row.run.shorten_rotation_vectors();
                    if let Err(error) = raised_by_function() {
                        of_function.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
                    }
                    row.outcome =
                        Outcome::Ended(if limit.is_reached() { Status::TimeLimit } else { outcome? });
                    Ok(())
                },
                &mut || watch(0.0),
            )
        });
        raised.into_result()?;
        if let Some(error) = of_function.into_inner().unwrap_or_else(PoisonError::into_inner) {
            return Err(error);
        }
        finished.expect("only exceptions end it");
        Ok(())
    }
}

/// The models of all rows.
fn models_of(model: &Bound<'_, PyAny>, count: Option<i64>) -> PyResult<Vec<Py<PyModel>>> {
    let count = match count {
        Some(count) if count > 0 => Some(convert::count(count, "count")?),
        Some(count) => {
            return Err(PyValueError::new_err(format!("count: got {count}, expected a whole number > 0")));
        }
        None => None,
    };
    if let Ok(model) = model.cast::<PyModel>() {
        model.get().check_modes()?;
        let Some(count) = count else {
            return Err(PyTypeError::new_err("count: missing, expected the number of rows of one model"));
        };
        crate::numerics::memory::check(count.saturating_mul(NUMBERS_OF_A_ROW), "count", count, "take fewer")
            .or_raise()?;
        return Ok((0..count).map(|_| model.clone().unbind()).collect());
    }
    let models = each(model)?;
    if models.is_empty() || count.is_some_and(|count| count != models.len()) {
        let found = models.len();
        let expected = count.map_or_else(|| "at least one".to_owned(), |count| count.to_string());
        return Err(PyValueError::new_err(format!("model: got {found} models, expected {expected}")));
    }
    Ok(models)
}

#[pymethods]
impl PySimulations {
    #[new]
    #[pyo3(
        signature = (model=None, count=None, *more, q0=None, v0=None, t0=0.0, workers=None, **options),
        text_signature = "(model, count=None, *, dt, method='newmark', q0=None, v0=None, t0=0.0, workers=None, rtol=1e-06, \
                          atol=None, beta=0.25, gamma=0.5, alpha=None, rho_inf=None, adaptive=False, max_step=None, \
                          min_step=0.0, max_seconds=None)"
    )]
    #[allow(clippy::too_many_arguments, reason = "keyword-only options of a Python class")]
    fn new(
        py: Python<'_>,
        #[pyo3(from_py_with = arguments::given)] model: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_whole::count)] count: Option<i64>,
        more: &Bound<'_, PyTuple>,
        q0: Option<&Bound<'_, PyAny>>,
        v0: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = arguments::number::t0)] t0: f64,
        #[pyo3(from_py_with = arguments::optional_whole::workers)] workers: Option<i64>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let model = required!("Simulations", options; more, model);
        check_start_time(t0).or_raise()?;
        let workers = threads(workers)?;
        let models = models_of(model, count)?;
        let (count, first) = (models.len(), models[0].bind(py));
        let (n, inputs) = (first.get().n(), first.get().default_inputs().len());
        let q0 = Vectors::read_optional(q0, count, n, "q0")?;
        let v0 = Vectors::read_optional(v0, count, n, "v0")?;
        let start = |row| Start {
            t: t0,
            q: q0.as_ref().map_or_else(|| vec![0.0; n], |q0| q0.of(row).to_vec()),
            v: v0.as_ref().map_or_else(|| vec![0.0; n], |v0| v0.of(row).to_vec()),
        };
        // The constructor validates the options.
        let (pattern, Start { t, q, v }) = (py.get_type::<PySimulation>(), start(0));
        let arguments = options.map_or_else(|| Ok(PyDict::new(py)), |options| options.copy())?;
        arguments.set_item("t0", t)?;
        arguments.set_item("q0", q)?;
        arguments.set_item("v0", v)?;
        let pattern = pattern.call((first,), Some(&arguments))?.cast_into::<PySimulation>()?;
        let PySimulation { options, configuration, .. } = pattern.get();
        let limit = pattern.get().memory()?.limit;
        let rows = Self::begin(
            py,
            configuration,
            limit,
            models.iter().enumerate().map(|(i, model)| (model, start(i))),
        )?;
        let (options, configuration) = (options.clone_ref(py), configuration.clone());
        Ok(Self { models, options, configuration, workers, n, inputs, rows: Mutex::new(rows) })
    }

    /// Advance all rows with constant inputs.
    ///
    /// Parameters
    /// ----------
    /// u : array_like, shape (inputs,) or (count, inputs), or dicts, optional
    ///     Inputs from now on, for all rows or one row each; by default those of the last step.
    /// duration : float, optional
    ///     Duration, seconds, as for `Simulation.step`; by default `dt`.
    ///
    /// Returns
    /// -------
    /// success : ndarray of bool, shape (count,)
    ///     False for rows whose step failed; `status` and `message` give the reason.
    ///
    /// Raises
    /// ------
    /// ValueError, TypeError
    ///     If `u` or `duration` is invalid; the state is unchanged.
    /// KeyboardInterrupt
    ///     On Ctrl-C during a long step. Each row is at its end or after its last complete step, also after exceptions of
    ///     functions of time.
    /// RuntimeError
    ///     If these simulations are already in a step, in another thread or in a function that the step calls.
    #[pyo3(signature = (u=None, duration=None, **others),
           text_signature = "($self, u=None, duration=None)")]
    fn step<'py>(
        &self,
        py: Python<'py>,
        u: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_number::duration)] duration: Option<f64>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Bound<'py, PyArray1<bool>>> {
        no_others("Simulations.step", others)?;
        let rows = &mut **self.rows()?;
        let u = match u {
            Some(u) if has_names(u) => {
                let held: Vec<_> = rows.iter().map(|row| row.run.inputs().to_vec()).collect();
                Some(numbered(u, &self.models[0].get().input_names(), &held, "u")?)
            }
            _ => u.cloned(),
        };
        let u = Vectors::read_optional(u.as_ref(), rows.len(), self.inputs, "u")?;
        let ends: Vec<f64> =
            rows.iter().map(|row| row.run.end_of(duration)).collect::<Result<_, _>>().or_raise()?;
        for (i, (row, &end)) in rows.iter_mut().zip(&ends).enumerate() {
            if let Some(u) = &u {
                row.run.set_inputs(u.of(i));
            }
            row.run.begin_interval(end);
            row.outcome = Outcome::Raised;
        }
        let dt = self.configuration.dt();
        let steps = duration.unwrap_or(dt) / dt * rows.len() as f64;
        if steps * self.n as f64 <= 2.0 * STEPS_WITH_INTERPRETER as f64 {
            for row in rows.iter_mut() {
                let finished = row.finish(py);
                row.run.shorten_rotation_vectors();
                row.outcome = Outcome::Ended(finished?);
            }
        } else {
            self.finish(py, rows)?;
        }
        let success: Vec<bool> = rows.iter().map(|row| row.outcome.is_success()).collect();
        Ok(success.into_pyarray(py))
    }

    /// Restart some or all rows.
    ///
    /// Parameters
    /// ----------
    /// which : array_like of bool, shape (count,), or of int, optional
    ///     A mask or the indices of rows; by default all.
    /// q0, v0 : array_like, shape (n,) or (k, n), optional
    ///     Initial coordinates and velocities for all of these k rows or one row each; by default those of their last start.
    /// t0 : float, optional
    ///     Initial time, seconds; by default that of their last start.
    ///
    /// Raises
    /// ------
    /// ValueError, TypeError
    ///     If an argument is invalid; the state is unchanged.
    #[pyo3(signature = (which=None, *, q0=None, v0=None, t0=None, **others),
           text_signature = "($self, which=None, *, q0=None, v0=None, t0=None)")]
    fn reset(
        &self,
        py: Python<'_>,
        which: Option<&Bound<'_, PyAny>>,
        q0: Option<&Bound<'_, PyAny>>,
        v0: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = arguments::optional_number::t0)] t0: Option<f64>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<()> {
        no_others("Simulations.reset", others)?;
        t0.map_or(Ok(()), check_start_time).or_raise()?;
        let chosen = self.chosen(which)?;
        let q0 = Vectors::read_optional(q0, chosen.len(), self.n, "q0")?;
        let v0 = Vectors::read_optional(v0, chosen.len(), self.n, "v0")?;
        let (last, limit): (Vec<Start>, _) = {
            let rows = self.rows()?;
            let limit = rows.first().map(|row| row.limit);
            (chosen.iter().map(|&row| rows[row].start.clone()).collect(), limit)
        };
        let Some(limit) = limit else { return Ok(()) };
        let starts = chosen.iter().zip(last).enumerate().map(|(i, (&row, last))| {
            let start = Start {
                t: t0.unwrap_or(last.t),
                q: q0.as_ref().map_or(last.q, |q0| q0.of(i).to_vec()),
                v: v0.as_ref().map_or(last.v, |v0| v0.of(i).to_vec()),
            };
            (&self.models[row], start)
        });
        let begun = Self::begin(py, &self.configuration, limit, starts)?;
        let mut rows = self.rows()?;
        for (row, memory) in chosen.into_iter().zip(begun) {
            rows[row] = memory;
        }
        Ok(())
    }

    /// An independent copy that continues exactly as this one.
    fn copy(&self, py: Python<'_>) -> PyResult<Self> {
        let rows = self.rows()?.iter().map(Memory::copy).collect();
        Ok(Self {
            models: self.models.iter().map(|model| model.clone_ref(py)).collect(),
            options: self.options.clone_ref(py),
            configuration: self.configuration.clone(),
            rows: Mutex::new(rows),
            ..*self
        })
    }

    fn __copy__(&self, py: Python<'_>) -> PyResult<Self> {
        self.copy(py)
    }

    // Models never change, so the copy can share these.
    fn __deepcopy__(&self, py: Python<'_>, _memo: &Bound<'_, PyAny>) -> PyResult<Self> {
        self.copy(py)
    }

    fn __len__(&self) -> usize {
        self.models.len()
    }

    /// An independent simulation that continues from the state of a row.
    fn __getitem__(&self, py: Python<'_>, row: i64) -> PyResult<PySimulation> {
        let row = self.existing_row(row)?;
        let memory = self.rows()?[row].copy();
        Ok(PySimulation {
            model: self.models[row].clone_ref(py),
            options: self.options.clone_ref(py),
            configuration: self.configuration.clone(),
            memory: Mutex::new(memory),
        })
    }

    /// Status of a row in words, and what to change.
    ///
    /// Parameters
    /// ----------
    /// row : int
    ///     Index of the row.
    ///
    /// Returns
    /// -------
    /// message : str
    ///     As in `Simulation`.
    ///
    /// Raises
    /// ------
    /// IndexError
    ///     If there is no such row.
    fn message(&self, #[pyo3(from_py_with = arguments::whole::row)] row: i64) -> PyResult<String> {
        let row = self.existing_row(row)?;
        let outcome = self.rows()?[row].message();
        Ok(remarks::with(&outcome, &remarks::questions(self.models[row].get())))
    }

    /// The models, one per row.
    #[getter]
    fn models<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, &self.models)
    }

    /// Number of rows.
    #[getter]
    fn count(&self) -> usize {
        self.models.len()
    }

    /// Maximum number of threads.
    #[getter]
    fn workers(&self) -> usize {
        self.workers
    }

    /// The times, seconds, shape (count,).
    #[getter]
    fn t<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.of_rows(py, |row| row.run.t())
    }

    /// Coordinates, shape (count, n).
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.vectors(py, self.n, |row| row.run.state()[0])
    }

    /// Velocities, shape (count, n).
    #[getter]
    fn v<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.vectors(py, self.n, |row| row.run.state()[1])
    }

    /// Accelerations with the inputs of the last step, shape (count, n).
    #[getter]
    fn a<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.vectors(py, self.n, |row| row.run.state()[2])
    }

    /// Current inputs, shape (count, inputs).
    #[getter]
    fn u<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.vectors(py, self.inputs, |row| row.run.inputs())
    }

    /// Outcome of the last step of each row; 'ready' before the first one.
    #[getter]
    fn status(&self) -> PyResult<Vec<String>> {
        Ok(self.rows()?.iter().map(|row| row.outcome.name().to_owned()).collect())
    }

    /// False after a step that failed, shape (count,).
    #[getter]
    fn success<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<bool>>> {
        self.of_rows(py, |row| row.outcome.is_success())
    }

    fn __repr__(&self) -> String {
        format!("Simulations(count={}, n={}, workers={})", self.models.len(), self.n, self.workers)
    }

    /// For pickles.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        let rows = (0..self.models.len() as i64).map(|row| self.__getitem__(py, row));
        let rows: Vec<PySimulation> = rows.collect::<PyResult<_>>()?;
        record::reduce_to::<Self>(py, (rows, self.workers))
    }

    #[staticmethod]
    fn _restore(py: Python<'_>, simulations: Vec<Bound<'_, PySimulation>>, workers: usize) -> PyResult<Self> {
        let Some(first) = simulations.first().map(Bound::get) else {
            return Err(PyValueError::new_err("simulations: got none, expected at least one"));
        };
        let model = first.model.get();
        let mut rows = Vec::with_capacity(simulations.len());
        for (i, simulation) in simulations.iter().enumerate() {
            check_alike(i, simulation.get().model.get(), model)?;
            rows.push(simulation.get().memory()?.copy());
        }
        Ok(Self {
            models: simulations.iter().map(|simulation| simulation.get().model.clone_ref(py)).collect(),
            options: first.options.clone_ref(py),
            configuration: first.configuration.clone(),
            workers: workers.max(1),
            n: model.n(),
            inputs: model.default_inputs().len(),
            rows: Mutex::new(rows),
        })
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        self.models.iter().try_for_each(|model| visit.call(model))?;
        visit.call(&self.options)
    }
}
