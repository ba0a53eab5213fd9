//! `lissom.Harmonic` and other functions of time: numbers, tables, callables.

use std::any::Any;
use std::sync::Arc;

use numpy::{IntoPyArray, PyArray2};
use pyo3::IntoPyObjectExt;
use pyo3::class::{PyTraverseError, PyVisit};
use pyo3::exceptions::{PyReferenceError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyString, PyTuple, PyWeakrefMethods, PyWeakrefReference};

use super::arguments;
use super::callback::{Form, call, keep, none_is_kept};
use super::convert;
use super::ode::function::read_vector;
use crate::description::schema::{AnyPart, Value};
use crate::description::signal::{
    Drive, Evaluate, Function, Harmonic, Input, Interpolation, Motion, Signal, Table,
};
use crate::description::world::{BaseMotion, BaseRotation, quaternion_motion};
use crate::error::{Checker, Interrupted};
use crate::python::errors::OrRaise as _;
use crate::python::words::{no_others, required};
use crate::robot::effects::actuator::AlongRod;
use crate::robot::{Driven, Robot, SignalOf};

/// A harmonic signal: ``mean + rate * t + amplitude * sin(2 * pi * frequency * t + phase)``.
///
/// Parameters
/// ----------
/// amplitude : float or array_like, shape (3,)
///     Amplitude of the oscillation; for a force or a moment one number per axis.
/// frequency : float
///     Oscillations per second, hertz.
/// phase : float
///     Phase at time zero, radians.
/// mean : float or array_like, shape (3,)
///     Steady part at time zero.
/// rate : float or array_like, shape (3,)
///     Growth of the steady part per second.
///
/// Raises
/// ------
/// ValueError
///     If parameters are invalid; the message lists all of them.
///
/// Examples
/// --------
/// >>> import lissom
/// >>> lissom.Load(force=lissom.Harmonic((0, 0, 0.1), 2.5))
/// Load(force=Harmonic((0.0, 0.0, 0.1), 2.5), moment=(0.0, 0.0, 0.0), frame='world')
#[pyclass(name = "Harmonic", module = "lissom", frozen, eq)]
#[derive(Clone, PartialEq)]
pub(crate) struct PyHarmonic {
    /// For a scalar, only the first component is used.
    harmonic: Harmonic<3>,
    is_number: bool,
}

#[pymethods]
impl PyHarmonic {
    #[new]
    #[pyo3(
        signature = (amplitude=None, frequency=0.0, *, phase=0.0, mean=None, rate=None, **others),
        text_signature = "(amplitude=0, frequency=0.0, *, phase=0.0, mean=0, rate=0)"
    )]
    fn new(
        amplitude: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = arguments::number::frequency)] frequency: f64,
        #[pyo3(from_py_with = arguments::number::phase)] phase: f64,
        mean: Option<&Bound<'_, PyAny>>,
        rate: Option<&Bound<'_, PyAny>>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        no_others("Harmonic", others)?;
        let mut harmonic = Harmonic { frequency, phase, ..Harmonic::zero() };
        let mut is_number = None;
        let parts = [
            (amplitude, &mut harmonic.amplitude, "amplitude"),
            (mean, &mut harmonic.mean, "mean"),
            (rate, &mut harmonic.rate, "rate"),
        ];
        for (value, part, name) in parts {
            let Some(value) = value else { continue };
            let (values, is_one) = convert::scalar_or_vector(value, name)?;
            let expected = if *is_number.get_or_insert(is_one) { 1 } else { 3 };
            if values.len() != expected || is_one != (expected == 1) {
                let wanted = if expected == 1 { "a number, as the others are" } else { "three numbers" };
                let found = convert::describe(value);
                return Err(PyValueError::new_err(format!("{name}: expected {wanted}, got {found}")));
            }
            part[..expected].copy_from_slice(&values);
        }
        harmonic.validate().or_raise()?;
        Ok(Self { harmonic, is_number: is_number.unwrap_or(true) })
    }

    /// Largest deviation from the steady part.
    #[getter]
    fn amplitude<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.part(py, self.harmonic.amplitude)
    }

    /// Oscillations per second, hertz.
    #[getter]
    fn frequency(&self) -> f64 {
        self.harmonic.frequency
    }

    /// Phase at time zero, radians.
    #[getter]
    fn phase(&self) -> f64 {
        self.harmonic.phase
    }

    /// Steady part at time zero.
    #[getter]
    fn mean<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.part(py, self.harmonic.mean)
    }

    /// Growth of the steady part per second.
    #[getter]
    fn rate<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.part(py, self.harmonic.rate)
    }

    fn __repr__(&self) -> String {
        let Harmonic { mean, rate, amplitude, frequency, phase } = self.harmonic;
        let part = |[x, y, z]: [f64; 3]| {
            if self.is_number { format!("{x:?}") } else { format!("({x:?}, {y:?}, {z:?})") }
        };
        let mut text = format!("Harmonic({}, {frequency:?}", part(amplitude));
        if phase != 0.0 {
            text += &format!(", phase={phase:?}");
        }
        for (name, value) in [("mean", mean), ("rate", rate)] {
            if value != [0.0; 3] {
                text += &format!(", {name}={}", part(value));
            }
        }
        text + ")"
    }

    /// For copies and pickles.
    #[allow(clippy::type_complexity, reason = "the arguments of the constructor")]
    fn __getnewargs_ex__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<((Bound<'py, PyAny>, f64), Bound<'py, PyDict>)> {
        let arguments = PyDict::new(py);
        arguments.set_item("phase", self.harmonic.phase)?;
        arguments.set_item("mean", self.mean(py)?)?;
        arguments.set_item("rate", self.rate(py)?)?;
        Ok(((self.amplitude(py)?, self.harmonic.frequency), arguments))
    }
}

impl PyHarmonic {
    fn part<'py>(&self, py: Python<'py>, [x, y, z]: [f64; 3]) -> PyResult<Bound<'py, PyAny>> {
        if self.is_number { x.into_bound_py_any(py) } else { (x, y, z).into_bound_py_any(py) }
    }

    /// The signal with N components; an error if it has another number.
    fn signal<const N: usize>(&self, name: &str) -> PyResult<Signal<N>> {
        let own = if self.is_number { 1 } else { 3 };
        if own != N {
            let numbers = |n: usize| if n == 1 { "one number" } else { "three numbers" };
            return Err(PyValueError::new_err(format!(
                "{name}: expected a Harmonic of {}, got one of {}",
                numbers(N),
                numbers(own)
            )));
        }
        let Harmonic { mean, rate, amplitude, frequency, phase } = self.harmonic;
        let part = |values: [f64; 3]| std::array::from_fn(|i| values[i]);
        let (mean, rate, amplitude) = (part(mean), part(rate), part(amplitude));
        Ok(Signal::Harmonic(Harmonic { mean, rate, amplitude, frequency, phase }))
    }

    fn from_core<const N: usize>(harmonic: &Harmonic<N>) -> Self {
        let Harmonic { mean, rate, amplitude, frequency, phase } = *harmonic;
        let part = |values: [f64; N]| std::array::from_fn(|i| values.get(i).copied().unwrap_or(0.0));
        let (mean, rate, amplitude) = (part(mean), part(rate), part(amplitude));
        Self { harmonic: Harmonic { mean, rate, amplitude, frequency, phase }, is_number: N == 1 }
    }
}

/// A scalar or three-component input that a controller or `Simulation.step` sets during a motion.
///
/// Use it in place of a force, a moment or the command of an actuator. `Model.inputs` lists the inputs of a model. In
/// statics, modes and runs without a controller, inputs have their defaults.
///
/// Parameters
/// ----------
/// name : str
///     Name of the input. Inputs with the same name are one input.
/// default : float or array_like, shape (3,)
///     Value unless it is set; three numbers for a force or a moment, whose entries among the inputs are ``name.x``, ``name.y``
///     and ``name.z``.
///
/// Raises
/// ------
/// ValueError
///     If the name is empty or the default is not finite.
///
/// Examples
/// --------
/// >>> import lissom
/// >>> wire = lissom.Segment(0.4, 1e-3, 2e11, 8e10, 7800, {"bend_y": 3})
/// >>> push = lissom.Load(force=lissom.Input("push", (0, 0, 0.1)))
/// >>> lissom.Rod([wire], loads=[push]).inputs
/// ('push.x', 'push.y', 'push.z')
#[pyclass(name = "Input", module = "lissom", frozen, eq)]
#[derive(Clone, PartialEq)]
pub(crate) struct PyInput {
    name: Arc<str>,
    /// For a scalar, only the first component is used.
    value: [f64; 3],
    is_number: bool,
}

#[pymethods]
impl PyInput {
    #[new]
    #[pyo3(signature = (name=None, default=None, *more, **others), text_signature = "(name, default=0.0)")]
    fn new(
        #[pyo3(from_py_with = arguments::given)] name: Option<&Bound<'_, PyAny>>,
        default: Option<&Bound<'_, PyAny>>,
        more: &Bound<'_, PyTuple>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let name = required!("Input", others; more, name);
        let Ok(name) = name.extract::<String>() else {
            let found = convert::describe(name);
            return Err(PyTypeError::new_err(format!(
                "name: expected a string, got {found}; an input has a name and one value, which `simulate` changes by `u` or `control`"
            )));
        };
        let (values, is_number) = match default {
            Some(default) => convert::scalar_or_vector(default, "default")?,
            None => (vec![0.0], true),
        };
        let mut check = Checker::new();
        check.require(!name.is_empty(), "name", "''", "a name");
        if check.finite(&values, "default") {
            let count = values.len();
            let found = format_args!("{count} numbers");
            check.require(
                values.len() == if is_number { 1 } else { 3 },
                "default",
                found,
                "one number, or three; a table of values over the time is given in place of the input, as (times, values), or by \
                 a controller: `simulate(..., control=lambda t, q, v: [numpy.interp(t, times, values)])`",
            );
        }
        check.finish().or_raise()?;
        let mut value = [0.0; 3];
        value[..values.len()].copy_from_slice(&values);
        Ok(Self { name: name.into(), value, is_number })
    }

    /// The name.
    #[getter]
    fn name(&self) -> &str {
        &self.name
    }

    /// Value unless it is set.
    #[getter]
    fn default<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let [x, y, z] = self.value;
        if self.is_number { x.into_bound_py_any(py) } else { (x, y, z).into_bound_py_any(py) }
    }

    fn __repr__(&self) -> String {
        let [x, y, z] = self.value;
        let default = if self.is_number { format!("{x:?}") } else { format!("({x:?}, {y:?}, {z:?})") };
        format!("Input('{}', {default})", self.name)
    }

    /// For copies and pickles.
    fn __getnewargs__<'py>(&self, py: Python<'py>) -> PyResult<(&str, Bound<'py, PyAny>)> {
        Ok((&self.name, self.default(py)?))
    }
}

impl PyInput {
    /// The signal with N components; an error if it has another number.
    fn signal<const N: usize>(&self, place: &str) -> PyResult<Signal<N>> {
        let own = if self.is_number { 1 } else { 3 };
        if own != N {
            let expected = match N {
                1 => "an Input of one number",
                _ => "an Input of three numbers, such as Input(name, (0, 0, 0))",
            };
            let found = if own == 1 { "one number" } else { "three numbers" };
            return Err(PyValueError::new_err(format!("{place}: expected {expected}, got one of {found}")));
        }
        let value = std::array::from_fn(|i| self.value[i]);
        Ok(Signal::Input(Input { name: Arc::clone(&self.name), value }))
    }

    fn from_core<const N: usize>(input: &Input<N>) -> Self {
        let value = std::array::from_fn(|i| input.value.get(i).copied().unwrap_or(0.0));
        Self { name: Arc::clone(&input.name), value, is_number: N == 1 }
    }
}

/// A Python function that the core calls. The core does not own a reference to it, because Python's garbage
/// collector could not see such a reference: a rod and a function that refers to this rod would keep each
/// other alive for ever. Instead, every Python object with a signal owns the functions of the signal and
/// shows them to the collector.
#[pyclass(name = "Function", module = "lissom._lissom", frozen, weakref)]
pub(super) struct Held(Py<PyAny>);

#[pymethods]
impl Held {
    // No `__clear__`, here and in other classes: as for tuples, a cycle cannot consist of immutable objects
    // alone, and clearing another object of the cycle breaks it.
    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.0)
    }
}

/// Evaluates one expression with the signal in a value, of any type, and another one if there is none.
macro_rules! on_signal {
    ($value:expr, $signal:ident => $with:expr, $without:expr) => {{
        let value: &Value = $value;
        if let Some($signal) = value.part::<Signal<1>>() {
            $with
        } else if let Some($signal) = value.part::<Signal<3>>() {
            $with
        } else if let Some(Drive($signal)) = value.part::<Drive<1>>() {
            $with
        } else if let Some(Drive($signal)) = value.part::<Drive<3>>() {
            $with
        } else if let Some(Drive($signal)) = value.part::<Drive<4>>() {
            $with
        } else {
            $without
        }
    }};
}
pub(super) use on_signal;

/// The functions that the signals of a Python object call.
#[derive(Debug, Default)]
pub(super) struct Functions(Vec<Py<Held>>);

impl Functions {
    /// The functions of a robot. The Python objects that own them must still be alive.
    pub(super) fn of_robot(py: Python<'_>, robot: &Robot) -> PyResult<Self> {
        let mut functions = Self::default();
        for placed in robot.signals_with_places() {
            match placed.signal {
                SignalOf::Number(signal) => functions.add(py, signal)?,
                SignalOf::Vector(signal) => functions.add(py, signal)?,
            }
        }
        if let Some(motion) = &robot.base_motion {
            functions.add_motion(py, motion)?;
        }
        for driven in robot.links.iter().filter_map(|link| link.driven.as_ref()) {
            match driven {
                Driven::Mimic { .. } => {}
                Driven::Coordinate(signal) => functions.add(py, signal)?,
                Driven::Base(motion) => functions.add_motion(py, motion)?,
            }
        }
        Ok(functions)
    }

    /// The functions of a part. The Python objects that own them must still be alive.
    pub(super) fn of_part(py: Python<'_>, part: &dyn AnyPart) -> PyResult<Self> {
        let mut functions = Self::default();
        functions.add_part(py, part)?;
        Ok(functions)
    }

    fn add_part(&mut self, py: Python<'_>, part: &dyn AnyPart) -> PyResult<()> {
        let fields = part.schema().fields.iter().enumerate();
        for (i, _) in fields.filter(|(_, field)| field.kind.holds_functions()) {
            self.add_value(py, &part.field(i))?;
        }
        Ok(())
    }

    fn add_value(&mut self, py: Python<'_>, value: &Value) -> PyResult<()> {
        match value {
            Value::Part(part) => match value.part::<AlongRod>() {
                Some(AlongRod::Function(function)) => self.add_function(py, function),
                Some(_) => Ok(()),
                None => on_signal!(value, signal => self.add(py, signal), self.add_part(py, part.as_ref())),
            },
            Value::List(items) => items.iter().try_for_each(|item| self.add_value(py, item)),
            _ => Ok(()),
        }
    }

    /// Adds the functions of another owner.
    pub(super) fn add_all(&mut self, py: Python<'_>, others: &Self) {
        self.0.extend(others.clone_ref(py).0);
    }

    pub(super) fn clone_ref(&self, py: Python<'_>) -> Self {
        Self(self.0.iter().map(|function| function.clone_ref(py)).collect())
    }

    fn add_motion(&mut self, py: Python<'_>, motion: &BaseMotion) -> PyResult<()> {
        self.add(py, &motion.translation)?;
        match &motion.rotation {
            BaseRotation::About { angle, .. } => self.add(py, angle),
            BaseRotation::By(quaternion) => self.add(py, quaternion),
        }
    }

    fn add<const N: usize>(&mut self, py: Python<'_>, signal: &Signal<N>) -> PyResult<()> {
        if let Signal::Function(function) = signal { self.add_function(py, function) } else { Ok(()) }
    }

    fn add_function<const N: usize>(&mut self, py: Python<'_>, function: &Function<N>) -> PyResult<()> {
        self.0.push(callable(function).held(py)?.unbind());
        Ok(())
    }

    /// The function of a callable, which is added to these; the name is that of its value in messages.
    pub(super) fn function<const N: usize>(
        &mut self,
        callable: &Bound<'_, PyAny>,
        name: String,
    ) -> PyResult<Function<N>> {
        let held = Bound::new(callable.py(), Held(callable.clone().unbind()))?;
        let function = PyWeakrefReference::new(held.as_any())?.unbind();
        self.0.push(held.unbind());
        Ok(Function(Arc::new(Callable { function, identity: callable.as_ptr() as usize, name })))
    }

    pub(super) fn traverse(&self, visit: &PyVisit<'_>) -> Result<(), PyTraverseError> {
        self.0.iter().try_for_each(|function| visit.call(function))
    }
}

/// N numbers, a table `(times, values)`, a [`PyHarmonic`], a [`PyInput`] or a callable of time. A callable is
/// added to `functions` of the owner of the signal.
pub(super) fn signal_of<const N: usize>(
    value: &Bound<'_, PyAny>,
    name: &str,
    functions: &mut Functions,
) -> PyResult<Signal<N>> {
    if let Ok(harmonic) = value.cast::<PyHarmonic>() {
        return harmonic.get().signal(name);
    }
    if let Ok(input) = value.cast::<PyInput>() {
        return input.get().signal(name);
    }
    if value.is_callable() {
        return functions.function(value, format!("{name}(t)")).map(Signal::Function);
    }
    let is_sequence = value.is_instance_of::<PyTuple>() || value.is_instance_of::<PyList>();
    // Two numbers are not a table, but a vector that is too short, and so are texts.
    let is_text = |part: &Bound<'_, PyAny>| part.is_instance_of::<PyString>();
    let is_column = |part: &Bound<'_, PyAny>| convert::is_array(part) && !is_text(part);
    let is_table = is_sequence
        && match value.len()? {
            2 => is_column(&value.get_item(0)?),
            3 => is_text(&value.get_item(2)?) && !is_text(&value.get_item(0)?),
            _ => false,
        };
    if is_table {
        table(value, name)
    } else if N == 1 {
        if let Some(number) = convert::number_if_one(value, name)? {
            return Ok(Signal::Constant([number; N]));
        }
        convert::array_of(value, name).map(Signal::Constant).map_err(|_| {
            let expected = "a number, (times, values), (times, values, interpolation), lissom.Harmonic, lissom.Input or a callable";
            PyTypeError::new_err(format!("{name}: expected {expected}, got {}", convert::describe(value)))
        })
    } else {
        Ok(Signal::Constant(convert::array_of(value, name)?))
    }
}

/// A table from times and values, and an interpolation if there are three parts.
fn table<const N: usize>(pair: &Bound<'_, PyAny>, name: &str) -> PyResult<Signal<N>> {
    let times = convert::vector(&pair.get_item(0)?, &format!("{name}.times"))?;
    let values = pair.get_item(1)?;
    let place = format!("{name}.values");
    let rows: Vec<[f64; N]> = if N == 1 {
        convert::vector(&values, &place)?.into_iter().map(|x| [x; N]).collect()
    } else {
        let expected = format!("an array of shape ({}, {N})", times.len());
        let numbers = convert::numbers(&values, &place, &expected)?;
        if !matches!(numbers.shape[..], [_, columns] if columns == N) {
            let found = convert::describe(&values);
            return Err(PyTypeError::new_err(format!("{place}: expected {expected}, got {found}")));
        }
        numbers.values.as_chunks().0.to_vec()
    };
    let mut check = Checker::new();
    let table = check.nested(name, Table::new(times, rows));
    let mut interpolation = None;
    if pair.len()? == 3 {
        let given: String = pair.get_item(2)?.extract()?;
        interpolation = Interpolation::by_name(&given);
        let expected = format!("one of {:?}", Interpolation::NAMES);
        check.require(
            interpolation.is_some(),
            &format!("{name}.interpolation"),
            format!("{given:?}"),
            &expected,
        );
    }
    check.finish().or_raise()?;
    let table = table.expect("nothing is wrong with it").interpolated(interpolation);
    Ok(Signal::Table(Arc::new(table)))
}

/// The Python object that describes a signal.
pub(super) fn signal_out<'py, const N: usize>(
    py: Python<'py>,
    signal: &Signal<N>,
) -> PyResult<Bound<'py, PyAny>> {
    match signal {
        Signal::Constant(value) if N == 1 => value[0].into_bound_py_any(py),
        Signal::Constant(value) => Ok(PyTuple::new(py, value)?.into_any()),
        Signal::Harmonic(harmonic) => PyHarmonic::from_core(harmonic).into_bound_py_any(py),
        Signal::Input(input) => PyInput::from_core(input).into_bound_py_any(py),
        Signal::Table(table) => {
            let (times, values) = if N == 1 {
                // Tuples, which compare as numbers do.
                let [times, values] = [table.times(), table.values().as_flattened()];
                (PyTuple::new(py, times)?.into_any(), PyTuple::new(py, values)?.into_any())
            } else {
                let rows: Vec<Vec<f64>> = table.values().iter().map(|row| row.to_vec()).collect();
                let times = table.times().to_vec().into_pyarray(py);
                (times.into_any(), PyArray2::from_vec2(py, &rows)?.into_any())
            };
            match table.interpolation() {
                None => (times, values).into_bound_py_any(py),
                Some(interpolation) => (times, values, interpolation.name()).into_bound_py_any(py),
            }
        }
        Signal::Function(function) => callable_of(py, function),
    }
}

/// The user's callable of a function.
pub(super) fn callable_of<'py, const N: usize>(
    py: Python<'py>,
    function: &Function<N>,
) -> PyResult<Bound<'py, PyAny>> {
    Ok(callable(function).held(py)?.get().0.bind(py).clone())
}

/// The Python callable of a function.
fn callable<const N: usize>(Function(function): &Function<N>) -> &Callable {
    let function: &dyn Any = function.as_ref();
    function.downcast_ref().expect("Python's functions are callables")
}

/// Number of components of a quaternion.
const QUATERNION: usize = 4;

/// The value and its two derivatives if a callable returned three parts in place of N numbers.
fn parts_of<'py>(value: &Bound<'py, PyAny>, n: usize) -> Option<[Bound<'py, PyAny>; 3]> {
    if value.len().ok()? != 3 {
        return None;
    }
    let parts = [value.get_item(0).ok()?, value.get_item(1).ok()?, value.get_item(2).ok()?];
    (n == 1 || convert::is_array(&parts[0])).then_some(parts)
}

/// A callable of time.
#[derive(Debug)]
struct Callable {
    /// Weak reference to [`Held`].
    function: Py<PyWeakrefReference>,
    /// Address of the Python callable.
    identity: usize,
    /// Name of its value in messages.
    name: String,
}

impl Callable {
    fn held<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, Held>> {
        let held = self.function.bind(py).upgrade_as()?;
        held.ok_or_else(|| PyReferenceError::new_err(format!("{}: the function no longer exists", self.name)))
    }

    fn call<'py>(&self, py: Python<'py>, t: f64) -> PyResult<Bound<'py, PyAny>> {
        let form = Form { name: &self.name, arguments: "t", args: None };
        call(form, self.held(py)?.get().0.bind(py), (t,))
    }
}

impl<const N: usize> Evaluate<N> for Callable {
    fn value(&self, t: f64) -> Result<[f64; N], Interrupted> {
        none_is_kept()?;
        Python::attach(|py| {
            let value = self.call(py, t)?;
            let mut values = [0.0; N];
            read_vector(&value, &mut values, &self.name)?;
            Ok(values)
        })
        .map_err(keep)
    }

    fn motion(&self, t: f64) -> Result<Option<Motion<N>>, Interrupted> {
        none_is_kept()?;
        Python::attach(|py| {
            let value = self.call(py, t)?;
            let Some(parts) = parts_of(&value, N) else { return Ok(None) };
            let mut read = [[0.0; N]; 3];
            let names = ["value", "velocity", "acceleration"].map(|part| format!("{} ({part})", self.name));
            if N == QUATERNION {
                let mut angular = [[0.0; 3]; 2];
                read_vector(&parts[0], &mut read[0], &names[0])?;
                read_vector(&parts[1], &mut angular[0], &names[1])?;
                read_vector(&parts[2], &mut angular[1], &names[2])?;
                let quaternion: [f64; QUATERNION] = std::array::from_fn(|i| read[0][i]);
                let motion = quaternion_motion(quaternion, angular);
                return Ok(Some(motion.map(|part| std::array::from_fn(|i| part[i]))));
            }
            for ((part, read), name) in parts.iter().zip(&mut read).zip(&names) {
                read_vector(part, read, name)?;
            }
            Ok(Some(read))
        })
        .map_err(keep)
    }

    fn refuse(&self, found: String, expected: &str) -> Interrupted {
        keep(PyValueError::new_err(format!("{}: got {found}, expected {expected}", self.name)))
    }

    fn identity(&self) -> usize {
        self.identity
    }
}
