//! `lissom.Balance`.

use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::convert;
use super::record::ReadOnly;
use crate::error::Checker;
use crate::model::Energy;
use crate::python::errors::OrRaise as _;
use crate::simulation::balance::Balance;

/// Energy balance of a motion: energies at each output time, in joules, and the energy that left or entered the system.
///
/// Attributes
/// ----------
/// kinetic, elastic, gravitational, loads : ndarray, shape (m,)
///     Energies of the states; `loads` is the potential of the constant dead forces.
/// dissipated : ndarray, shape (m,)
///     Energy dissipated so far.
/// work : ndarray, shape (m,)
///     Work so far of loads without a potential: moments of fixed direction, follower loads, time-dependent forces.
/// total : ndarray, shape (m,)
///     kinetic + elastic + gravitational + loads + dissipated - work; constant for an exact motion.
/// scale : float
///     Scale of the energy exchange: the largest kinetic energy, or the largest range of another part.
/// drift : float
///     Largest change of the total relative to `scale`; zero without motion.
/// moves : bool
///     False if all changes are rounding errors.
#[pyclass(name = "Balance", module = "lissom", frozen)]
pub(crate) struct PyBalance {
    balance: Balance,
    #[pyo3(get)]
    kinetic: ReadOnly<PyArray1<f64>>,
    #[pyo3(get)]
    elastic: ReadOnly<PyArray1<f64>>,
    #[pyo3(get)]
    gravitational: ReadOnly<PyArray1<f64>>,
    #[pyo3(get)]
    loads: ReadOnly<PyArray1<f64>>,
    #[pyo3(get)]
    dissipated: ReadOnly<PyArray1<f64>>,
    #[pyo3(get)]
    work: ReadOnly<PyArray1<f64>>,
    #[pyo3(get)]
    total: ReadOnly<PyArray1<f64>>,
}

impl PyBalance {
    pub(super) fn from_core(py: Python<'_>, balance: Balance) -> PyResult<Self> {
        let array = |values: Vec<f64>| ReadOnly::new(values.into_pyarray(py));
        let energies = |part: fn(&Energy) -> f64| array(balance.energies.iter().map(part).collect());
        Ok(Self {
            kinetic: energies(|energy| energy.kinetic)?,
            elastic: energies(|energy| energy.elastic)?,
            gravitational: energies(|energy| energy.gravitational)?,
            loads: energies(|energy| energy.loads)?,
            dissipated: array(balance.dissipated.clone())?,
            work: array(balance.work.clone())?,
            total: array(balance.total())?,
            balance,
        })
    }
}

#[pymethods]
impl PyBalance {
    #[new]
    #[pyo3(signature = (*, kinetic, elastic, gravitational, loads, dissipated, work))]
    fn new(
        py: Python<'_>,
        kinetic: &Bound<'_, PyAny>,
        elastic: &Bound<'_, PyAny>,
        gravitational: &Bound<'_, PyAny>,
        loads: &Bound<'_, PyAny>,
        dissipated: &Bound<'_, PyAny>,
        work: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let kinetic = convert::vector(kinetic, "kinetic")?;
        let others = [
            (elastic, "elastic"),
            (gravitational, "gravitational"),
            (loads, "loads"),
            (dissipated, "dissipated"),
            (work, "work"),
        ];
        let mut checker = Checker::new();
        let mut values = Vec::with_capacity(others.len());
        for (value, name) in others {
            let value = convert::vector(value, name)?;
            checker.length(&value, kinetic.len(), name);
            values.push(value);
        }
        for (value, name) in
            values.iter().zip(others.iter().map(|(_, name)| name)).chain([(&kinetic, &"kinetic")])
        {
            let first = value.iter().position(|x| x.is_nan());
            if let Some(i) = first {
                checker.require(false, &format!("{name}[{i}]"), "nan", "an energy, in joules");
            }
        }
        checker.finish().or_raise()?;
        let energies = (0..kinetic.len()).map(|i| Energy {
            kinetic: kinetic[i],
            elastic: values[0][i],
            gravitational: values[1][i],
            loads: values[2][i],
        });
        let energies = energies.collect();
        let [.., dissipated, work] = &mut values[..] else { unreachable!("five parts") };
        let balance =
            Balance { energies, dissipated: std::mem::take(dissipated), work: std::mem::take(work) };
        Self::from_core(py, balance)
    }

    /// Scale of the energy exchange, joules.
    #[getter]
    fn scale(&self) -> f64 {
        self.balance.scale()
    }

    /// Largest change of the total, relative to `scale`.
    #[getter]
    fn drift(&self) -> f64 {
        self.balance.drift()
    }

    /// False if all changes are rounding errors.
    #[getter]
    fn moves(&self) -> bool {
        self.balance.moves()
    }

    fn __repr__(&self) -> String {
        format!(
            "Balance(<{} times>, drift={:.1e} of the {:.3e} J that moved)",
            self.balance.energies.len(),
            self.drift(),
            self.scale()
        )
    }

    /// For copies and pickles.
    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<((), Bound<'py, PyDict>)> {
        let arguments = PyDict::new(py);
        arguments.set_item("kinetic", &self.kinetic)?;
        arguments.set_item("elastic", &self.elastic)?;
        arguments.set_item("gravitational", &self.gravitational)?;
        arguments.set_item("loads", &self.loads)?;
        arguments.set_item("dissipated", &self.dissipated)?;
        arguments.set_item("work", &self.work)?;
        Ok(((), arguments))
    }
}
