//! `lissom.modes`.

use numpy::{Complex64, IntoPyArray, PyArray1, PyArray2, PyArrayMethods};
use pyo3::class::{PyTraverseError, PyVisit};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyTuple};

use super::arguments;
use super::callback::or_raised;
use super::errors::{LissomError, OrRaise as _};
use super::model::{PyModel, model_of};
use super::record::{self, ReadOnly, Reduced};
use super::remarks::{questions, with};
use super::statics::{base, inputs_of, inputs_or_default, native_with};
use super::{background, convert};
use crate::analysis::modes as core;
use crate::analysis::modes::{Modes, NoModes};
use crate::analysis::stability::Stability;
use crate::python::words::required;

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
        Ok(with(&outcome, &self._refined.known(py)?.remarks))
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
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
        record::add_missing(state, &["u", "t", "_refined"])?;
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
///     Coordinates of the equilibrium, such as `q` from `statics`.
/// t : float
///     Time at which time-dependent loads are evaluated, seconds.
/// u : array_like, shape (m,), or dict, optional
///     Inputs, or some of them by name; by default `u0` of the model.
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
#[pyo3(signature = (model=None, q=None, *more, t=0.0, u=None, **others), text_signature = "(model, q, *, t=0.0, u=None)")]
pub(crate) fn modes<'py>(
    py: Python<'py>,
    #[pyo3(from_py_with = arguments::given)] model: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = arguments::given)] q: Option<&Bound<'py, PyAny>>,
    more: &Bound<'_, PyTuple>,
    #[pyo3(from_py_with = arguments::number::t)] t: f64,
    u: Option<&Bound<'py, PyAny>>,
    others: Option<&Bound<'_, PyDict>>,
) -> PyResult<PyModesResult> {
    model.map(|model| model_of(model, "model")).transpose()?;
    let (model, q) = required!("modes", others; more, model, q);
    let u = u.map(|u| inputs_of(model, u)).transpose()?;
    let held = inputs_or_default(model, u.as_deref())?;
    let of_model = base(model)?.clone().unbind();
    let mut model = native_with(model, t, u.as_deref())?;
    let q = convert::finite_vector_of(q, model.facts().n, "q")?;
    model.check_shape(&q, "q").or_raise()?;
    let n = q.len();
    let search = Search { model: of_model, q: q.clone(), t, u: held.clone() };
    let found = if n < background::LARGE {
        py.detach(|| core::modes(&mut *model, &q))
    } else {
        background::run(py, move |_| core::modes(&mut *model, &q))?
    };
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
        _refined: Refined { of: Some(search), known: PyOnceLock::new() },
    })
}
