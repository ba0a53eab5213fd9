//! `lissom.modes`.

use numpy::{Complex64, IntoPyArray, PyArray1, PyArray2, PyArrayMethods, ToPyArray};
use pyo3::class::{PyTraverseError, PyVisit};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyTuple};

use super::arguments;
use super::callback::or_raised;
use super::choice::{self, Chosen};
use super::errors::{LissomError, OrRaise as _};
use super::model::{PyModel, any_model_of, check_time, model_of};
use super::record::{self, ReadOnly, Reduced};
use super::remarks::{questions, with};
use super::search::{base, inputs_of, inputs_or_default, native_with, run};
use super::space_error::PySpaceError;
use super::{background, convert};
use crate::analysis::modes as core;
use crate::analysis::modes::{Modes, NoModes};
use crate::analysis::stability::Stability;
use crate::analysis::statics::{self, Rest, SpaceError};
use crate::python::words::required;
use crate::simulation::accuracy;

/// Natural vibrations about an equilibrium, slowest first.
///
/// Attributes
/// ----------
/// frequency : ndarray, shape (m,)
///     Natural frequencies, hertz: those of the undamped modes if damping does not couple them, else
///     ``abs(eigenvalue) / (2 pi)``. Zero for rigid-body motions (eigenvalue zero) and for motions that grow without
///     oscillation.
/// angular_frequency : ndarray, shape (m,)
///     The same in radians per second.
/// damping_ratio : ndarray, shape (m,)
///     Negative if the motion grows, above one if it is overdamped.
/// eigenvalues : ndarray of complex, shape (m,)
///     Eigenvalues s of the motions ``exp(s t)``, per second. Of a conjugate pair, the one with positive imaginary part; of the
///     two real eigenvalues of an overdamped mode that damping does not couple, the slower one.
/// shapes : ndarray, shape (n, m)
///     Mode shapes as columns, in generalised coordinates, with modal mass one: ``shapes.conj().T @ M @ shapes`` has ones on its
///     diagonal. Real and M-orthogonal with m = n if `is_classical`, else complex, with n <= m <= 2 n.
/// is_classical : bool
///     True if there is no damping, or if damping does not couple the undamped modes.
/// is_stable : bool
///     True if `stability` is 'stable'.
/// stability : str or None
///     'stable', 'neutral' (no stiffness in some direction), 'divergence' or 'flutter', including damping, drag and Coriolis
///     forces, as in `statics`. None if it cannot be determined.
/// residual_norm : float
///     Generalised forces at `q` times typical sizes of the coordinates, joules; nearly zero at an equilibrium. At other shapes
///     the modes are those of the model held there by constant generalised forces.
/// u : ndarray, shape (k,), or None
///     The inputs; None in results saved by versions that did not keep them.
/// t : float or None
///     The time, seconds; None as for `u`.
/// refined_frequency : ndarray, shape (m,), or None
///     Frequencies of the same vibrations with more modes of every strain of the rods, hertz: where they differ from `frequency` by more
///     than 1 %, the rods have too few modes for that vibration. Decays of coupled damping and motions of bodies as a whole are not
///     judged: they have the value of `frequency`. Computed on first access, at a few times the cost of `modes`; None without rods, for
///     more than 200 coordinates of modes, and in results saved by versions that did not know it.
/// space_error : SpaceError or None
///     Estimated error of the shape about which it vibrates due to the finite number of modes, as for `statics`; None where it is not known,
///     and if the shape is no equilibrium. From a hundredth of the length on the message says it; the warning is that of `statics`.
/// q : ndarray, shape (n,), or None
///     The shape about which it vibrates; None in results saved by versions that did not keep it.
/// model : Model or None
///     The robot with the modes that were chosen for its frequencies; None if nothing was chosen.
/// message : str
///     How many vibrations there are, which of them the modes of the rods resolve, and what the others become with more modes.
#[pyclass(name = "ModesResult", module = "lissom", frozen, get_all)]
#[derive(FromPyObject)]
pub(crate) struct PyModesResult {
    frequency: ReadOnly<PyArray1<f64>>,
    angular_frequency: ReadOnly<PyArray1<f64>>,
    damping_ratio: ReadOnly<PyArray1<f64>>,
    eigenvalues: ReadOnly<PyArray1<Complex64>>,
    shapes: ReadOnly,
    is_classical: bool,
    is_stable: bool,
    stability: Option<String>,
    residual_norm: f64,
    u: Option<ReadOnly<PyArray1<f64>>>,
    t: Option<f64>,
    space_error: Option<Py<PySpaceError>>,
    q: Option<ReadOnly<PyArray1<f64>>>,
    model: Option<Py<PyModel>>,
    _shape: String,
    _refined: Refined,
}

#[pymethods]
impl PyModesResult {
    #[getter]
    fn refined_frequency<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray1<f64>>>> {
        let Known { frequency, .. } = self._refined.known(py)?;
        Ok(frequency.as_ref().map(|frequency| frequency.bind(py).clone()))
    }

    #[getter]
    fn message(&self, py: Python<'_>) -> PyResult<String> {
        let (count, stable) = (self.frequency.bind(py).len()?, self.stability.as_deref());
        let counted = if count == 1 { "1 mode".to_owned() } else { format!("{count} modes") };
        let outcome = format!("{counted}, {}.", stable.unwrap_or("stability unknown"));
        Ok(with(&(outcome + &self._shape), &self._refined.known(py)?.remarks))
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.model)?;
        match &self._refined.of {
            Some(Search { model, .. }) => visit.call(model),
            None => Ok(()),
        }
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let frequency = self.frequency.bind(py).readonly();
        let first: Vec<String> =
            frequency.as_array().iter().take(3).map(|frequency| format!("{frequency:.6}")).collect();
        let count = frequency.len().unwrap_or(0);
        let more = if count > 3 { ", ..." } else { "" };
        let stable = self.stability.as_deref().unwrap_or("stability unknown");
        format!("<ModesResult: {count} modes, {stable}, {}{more} Hz>", first.join(", "))
    }

    /// For copies and pickles.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        record::reduce(slf)
    }

    #[staticmethod]
    fn _restore(state: &Bound<'_, PyAny>) -> PyResult<Self> {
        record::add_missing(state, &["u", "t", "space_error", "q", "model", "_shape", "_refined"])?;
        state.extract()
    }
}

/// Frequencies with more modes, and what the message says of them and of units; computed on first access.
struct Refined {
    /// `None` in a loaded result.
    of: Option<Search>,
    known: PyOnceLock<Known>,
}

/// Arguments of the search.
struct Search {
    model: Py<PyModel>,
    q: Vec<f64>,
    t: f64,
    u: Vec<f64>,
}

#[derive(Default)]
struct Known {
    frequency: Option<ReadOnly<PyArray1<f64>>>,
    remarks: Vec<String>,
}

impl Search {
    fn refined(&self, py: Python<'_>) -> PyResult<Known> {
        let Self { model, q, t, u } = self;
        let mut native = native_with(model.bind(py), *t, Some(u))?;
        let (given, at, inputs) = (q.clone(), *t, u.clone());
        let mut search = move || {
            let found = core::modes(&mut *native, &given);
            let refined = or_raised(native.refined_modes(&given, (at, Some(&inputs))));
            // Functions of time keep their exceptions in the thread that called them.
            refined.map(|refined| found.ok().zip(refined))
        };
        let found = if q.len() < background::LARGE {
            py.detach(search)?
        } else {
            background::run(py, move |_| search())??
        };
        let mut remarks = Vec::new();
        let frequency = found.map(|(found, refined)| {
            remarks.push(refined.sentence(&found.frequency));
            let hertz: Vec<f64> =
                refined.frequency.iter().map(|omega| omega / std::f64::consts::TAU).collect();
            ReadOnly::new(hertz.into_pyarray(py))
        });
        remarks.extend(questions(model.get()));
        Ok(Known { frequency: frequency.transpose()?, remarks })
    }
}

impl Refined {
    fn known(&self, py: Python<'_>) -> PyResult<&Known> {
        self.known.get_or_try_init(py, || match &self.of {
            Some(search) => search.refined(py),
            None => Ok(Known::default()),
        })
    }
}

impl<'py> IntoPyObject<'py> for &Refined {
    type Target = PyTuple;
    type Output = Bound<'py, PyTuple>;
    type Error = PyErr;

    fn into_pyobject(self, py: Python<'py>) -> PyResult<Self::Output> {
        let Known { frequency, remarks } = self.known(py)?;
        (frequency.as_ref(), remarks).into_pyobject(py)
    }
}

impl<'py> FromPyObject<'_, 'py> for Refined {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let known = PyOnceLock::new();
        if !object.is_none() {
            let (frequency, remarks) = object.extract()?;
            _ = known.set(object.py(), Known { frequency, remarks });
        }
        Ok(Self { of: None, known })
    }
}

/// Natural frequencies, damping ratios and shapes of small vibrations about an equilibrium.
///
/// Parameters
/// ----------
/// model : Model
///     A `Rod`, `Robot` or `SpringPendulum`.
/// q : array_like, shape (n,)
///     Coordinates of the equilibrium, such as `q` from `statics`; left out for a robot with ``modes="auto"``.
/// t : float
///     Time at which time-dependent loads are evaluated, seconds.
/// u : array_like, shape (m,), or dict, optional
///     Inputs, or some of them by name; by default `u0` of the model.
/// frequencies : int, optional
///     Only for a robot with ``modes="auto"``, which has no coordinates yet: `statics` finds its equilibrium, and modes are chosen so that
///     this number of frequencies, the lowest ones, change by at most 1 % with more modes; by default 3. The result has the robot with
///     these modes as its `model`, and the equilibrium as its `q`.
///
/// Returns
/// -------
/// ModesResult
///     `frequency` (hertz), `angular_frequency`, `damping_ratio`, `eigenvalues`, `shapes`, `is_classical`, `is_stable`.
///
/// Raises
/// ------
/// ValueError, TypeError
///     If an argument is invalid.
/// LissomError
///     If the mass matrix is not positive definite or the tangent is not finite.
///
/// Examples
/// --------
/// >>> import lissom
/// >>> wire = lissom.Segment(1.0, 1e-3, 210e9, 80e9, 7800, modes={"bend_y": 6})
/// >>> rod = lissom.Rod([wire], gravity=(0, 0, 0))
/// >>> lissom.modes(rod, [0] * 6).frequency[:3].round(4)
/// array([ 1.4518,  9.0983, 25.4829])
#[pyfunction]
#[pyo3(signature = (model=None, q=None, *more, t=0.0, u=None, frequencies=None, **others),
       text_signature = "(model, q=None, *, t=0.0, u=None, frequencies=None)")]
#[allow(clippy::too_many_arguments, reason = "keyword-only options of a Python function")]
pub(crate) fn modes<'py>(
    #[pyo3(from_py_with = arguments::given)] model: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::given)] q: Option<&Bound<'py, PyAny>>,
    more: &Bound<'_, PyTuple>,
    #[pyo3(from_py_with = arguments::number::t)] t: f64,
    u: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::optional_whole::frequencies)] frequencies: Option<i64>,
    others: Option<&Bound<'_, PyDict>>,
) -> PyResult<PyModesResult> {
    let given = model.map(|model| any_model_of(model, "model")).transpose()?;
    if let Some(open) = given.filter(|given| given.get().is_open()) {
        let u = u.map(|u| inputs_of(open, u)).transpose()?;
        let (chosen, q) = chosen(open, q, (t, u.clone()), frequencies)?;
        return vibrations(chosen.model.as_any(), q, (t, u), Some(&chosen));
    }
    if frequencies.is_some() {
        return Err(PyValueError::new_err(
            "frequencies: only for a robot with modes=\"auto\", whose modes are chosen for them: leave it out, all frequencies are \
             returned",
        ));
    }
    let (model, q) = required!("modes", others; more, model, q);
    let u = u.map(|u| inputs_of(model, u)).transpose()?;
    let n = model_of(model, "model")?.get().n();
    vibrations(model, convert::finite_vector_of(q, n, "q")?, (t, u), None)
}

/// The robot with modes that resolve its lowest frequencies, and its equilibrium.
fn chosen<'py>(
    open: &Bound<'py, PyModel>,
    q: Option<&Bound<'py, PyAny>>,
    (t, u): (f64, Option<Vec<f64>>),
    frequencies: Option<i64>,
) -> PyResult<(Chosen<'py>, Vec<f64>)> {
    /// Frequencies that are resolved by default.
    const LOWEST: i64 = 3;
    if q.is_some() {
        return Err(PyValueError::new_err(
            "q: the modes are open, and coordinates belong to numbers of modes: leave `q` out for the equilibrium that `statics` finds, or \
             choose the modes before with `lissom.choose_modes`",
        ));
    }
    let count = convert::count(frequencies.unwrap_or(LOWEST), "frequencies")?;
    if count == 0 {
        return Err(PyValueError::new_err("frequencies: got 0, expected a whole number > 0"));
    }
    open.get().inspect(|model| check_time(t, model.facts().time_span))?;
    let options = open.get().inspect(|model| statics::Options::of(model.facts()));
    let search = accuracy::Search { t, u, options };
    let chosen = choice::for_vibrations(open, &search, count)?;
    if let Err(raised) = &chosen.raised {
        return Err(raised.clone_ref(open.py()));
    }
    if let Some(why) = chosen.failure {
        return Err(LissomError::new_err(why));
    }
    let robots = [open, &chosen.model].map(|model| model.get().inspect(|model| model.robot().cloned()));
    let [Some(given), Some(robot)] = robots else { unreachable!("pendulums have no open modes") };
    let options = statics::Options { stability: false, ..search.options_for(&given, &robot) };
    let mut model = native_with(chosen.model.as_any(), t, search.u.as_deref())?;
    let n = model.facts().n;
    let found = run(
        open.py(),
        n,
        move |monitor| statics::equilibrium(&mut *model, &options, monitor),
        |found| Ok(found.q.into_pyarray(open.py())),
    )?;
    Ok((chosen, found.to_vec()?))
}

/// The vibrations of a model with modes.
fn vibrations(
    model: &Bound<'_, PyAny>,
    q: Vec<f64>,
    (t, u): (f64, Option<Vec<f64>>),
    chosen: Option<&Chosen<'_>>,
) -> PyResult<PyModesResult> {
    let py = model.py();
    let held = inputs_or_default(model, u.as_deref())?;
    let of_model = base(model)?.clone().unbind();
    let mut model = native_with(model, t, u.as_deref())?;
    model.check_shape(&q, "q").or_raise()?;
    let n = q.len();
    let search = Search { model: of_model, q: q.clone(), t, u: held.clone() };
    let (inputs, of_python) = (held.clone(), q.to_pyarray(py));
    let mut both = move || {
        let found = core::modes(&mut *model, &q);
        let rest = Rest::of(&q, found.as_ref().ok().and_then(|found| found.stability));
        let error = or_raised(model.error_of_shape(rest, (t, Some(&inputs))));
        // Functions of time keep their exceptions in the thread that called them.
        error.map(|error| (found, error))
    };
    let (found, error) =
        if n < background::LARGE { py.detach(both)? } else { background::run(py, move |_| both())?? };
    let found = found.map_err(|failure| {
        LissomError::new_err(match failure {
            NoModes::SingularMass => {
                "the mass matrix at q is not positive definite: there are no modes; look at \
                 numpy.linalg.cond(model.mass_matrix(q))"
            }
            NoModes::NonFinite => "masses, stiffnesses or damping at q are NaN or infinite: there are no modes; take a smaller q",
        })
    })?;
    let stability = found.stability.map(Stability::name);
    let Modes { frequency, damping, eigenvalues, shapes, is_classical, residual_norm, stability: _ } = found;
    let m = frequency.len();
    let entry = |i: usize, j: usize| shapes[j * n + i];
    let rows = (0..n).flat_map(|i| (0..m).map(move |j| (i, j)));
    let shapes = if is_classical {
        let real: Vec<f64> = rows.map(|(i, j)| entry(i, j).re).collect();
        real.into_pyarray(py).reshape([n, m]).map(Bound::<PyArray2<f64>>::into_any)?
    } else {
        let complex: Vec<Complex64> = rows.map(|(i, j)| entry(i, j)).collect();
        complex.into_pyarray(py).reshape([n, m]).map(Bound::<PyArray2<Complex64>>::into_any)?
    };
    let hertz: Vec<f64> = frequency.iter().map(|omega| omega / std::f64::consts::TAU).collect();
    let doubt = error.as_ref().and_then(SpaceError::doubt);
    let of_shape = doubt.map_or_else(String::new, |doubt| format!(" Of the shape: {doubt}"));
    let of_shape = of_shape + &chosen.map_or_else(String::new, |chosen| format!(" {}", chosen.words));
    Ok(PyModesResult {
        is_stable: stability == Some(Stability::Stable.name()),
        stability: stability.map(str::to_owned),
        frequency: ReadOnly::new(hertz.into_pyarray(py))?,
        angular_frequency: ReadOnly::new(frequency.into_pyarray(py))?,
        damping_ratio: ReadOnly::new(damping.into_pyarray(py))?,
        eigenvalues: ReadOnly::new(eigenvalues.into_pyarray(py))?,
        shapes: ReadOnly::new(shapes)?,
        is_classical,
        residual_norm,
        u: Some(ReadOnly::new(held.into_pyarray(py))?),
        t: Some(t),
        q: Some(ReadOnly::new(of_python)?),
        model: chosen.map(|chosen| chosen.model.clone().unbind()),
        space_error: error.map(|error| Py::new(py, PySpaceError::new(error))).transpose()?,
        _shape: of_shape,
        _refined: Refined { of: Some(search), known: PyOnceLock::new() },
    })
}
