//! `lissom.Profile`, and numbers along a segment from Python values: an array, a table, a callable.

use numpy::{IntoPyArray, PyArray1, PyArrayDyn, PyArrayMethods};
use pyo3::IntoPyObjectExt;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};

use super::arguments;
use super::callback::{Form, call};
use super::convert::{self, Numbers};
use super::signal::{Functions, callable_of};
use crate::description::rod::{Parts, Profile, Unsampled};
use crate::description::schema::{Data as _, Kind, Symmetric, Value};
use crate::error::{Checker, InvalidInput};
use crate::python::errors::{OrRaise as _, raise};
use crate::python::words::required;
use crate::robot::effects::actuator::{AlongRod, AlongRodTable};

/// A function of the arc length of a segment, as `Segment` creates it from a table or a callable.
///
/// A table is interpolated by cubics that do not overshoot (as by SciPy's ``PchipInterpolator``). A callable is approximated
/// by a Chebyshev polynomial to rounding, with a degree of at most 128. Give either `stations` and `values` or
/// `coefficients`. Calling a profile evaluates it.
///
/// Parameters
/// ----------
/// length : float
///     Length of the segment, metres.
/// stations : array_like, shape (m,)
///     Increasing arc lengths from 0 to `length`, metres.
/// values : array_like, shape (m, ...)
///     Values at the stations.
/// coefficients : array_like, shape (d + 1, ...)
///     Coefficients of the Chebyshev polynomials ``T_k(2 X / length - 1)``.
///
/// Raises
/// ------
/// ValueError
///     If parameters are invalid; the message lists all of them.
///
/// Examples
/// --------
/// >>> import lissom
/// >>> line = lissom.Profile(2.0, stations=(0, 2), values=(1, 3))
/// >>> line([0, 0.5, 2]).tolist()
/// [1.0, 1.5, 3.0]
/// >>> wire = lissom.Segment(2.0, 1e-3, 2e11, 8e10, 7800, {"bend_y": 3},
/// ...                       reference_strain=lambda X: (0, 0.3 * X, 0, 1, 0, 0))
/// >>> round(float(wire.reference_strain(1.5)[1]), 12)
/// 0.45
#[pyclass(name = "Profile", module = "lissom", frozen, eq)]
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PyProfile {
    length: f64,
    /// Shape of the values at one point.
    shape: Vec<usize>,
    /// Stations of a table; `None` for a polynomial.
    stations: Option<Vec<f64>>,
    /// Values at the stations, or coefficients, row by row.
    rows: Vec<Vec<f64>>,
}

#[pymethods]
impl PyProfile {
    #[new]
    #[pyo3(signature = (length=None, *, stations=None, values=None, coefficients=None, **others),
           text_signature = "(length, *, stations=None, values=None, coefficients=None)")]
    fn new(
        #[pyo3(from_py_with = arguments::given_number::length)] length: Option<f64>,
        stations: Option<&Bound<'_, PyAny>>,
        values: Option<&Bound<'_, PyAny>>,
        coefficients: Option<&Bound<'_, PyAny>>,
        others: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let length = required!("Profile", others, length);
        let mut check = Checker::new();
        check.positive(length, "length", "metres");
        check.finish().or_raise()?;
        let (stations, (rows, shape)) = match (stations, values, coefficients) {
            (Some(stations), Some(values), None) => {
                (Some(convert::vector(stations, "stations")?), rows(values, "values")?)
            }
            (None, None, Some(coefficients)) => (None, rows(coefficients, "coefficients")?),
            _ => {
                return Err(PyValueError::new_err(
                    "a profile: expected either stations and values, or coefficients",
                ));
            }
        };
        let profile = Self { length, shape, stations, rows };
        for column in 0..profile.width() {
            profile.column(column).or_raise()?.validate(length).or_raise()?;
        }
        Ok(profile)
    }

    /// Length of the segment, metres.
    #[getter]
    fn length(&self) -> f64 {
        self.length
    }

    /// Arc lengths of a table, metres, or None.
    #[getter]
    fn stations<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        self.stations.as_ref().map(|stations| PyArray1::from_slice(py, stations))
    }

    /// Values of a table, shape (m, ...), or None.
    #[getter]
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArrayDyn<f64>>>> {
        self.stations.as_ref().map(|_| self.array(py)).transpose()
    }

    /// Coefficients of a polynomial, shape (d + 1, ...), or None.
    #[getter]
    fn coefficients<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArrayDyn<f64>>>> {
        if self.stations.is_some() { Ok(None) } else { self.array(py).map(Some) }
    }

    /// The values at arc lengths.
    ///
    /// Parameters
    /// ----------
    /// X : float or array_like, shape (k,)
    ///     Arc lengths from the segment's base, 0 <= X <= length, metres.
    ///
    /// Returns
    /// -------
    /// values : ndarray, of the shape of a value, or shape (k, ...)
    #[pyo3(signature = (X))]
    #[allow(non_snake_case, reason = "X is the arc length of the unstretched rod everywhere in this field")]
    fn __call__<'py>(&self, X: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let (places, is_number) = convert::scalar_or_vector(X, "X")?;
        let length = self.length;
        if let Some(place) = places.iter().find(|place| !(0.0..=length).contains(*place)) {
            return Err(PyValueError::new_err(format!(
                "X: got {place}, expected arc lengths in [0, {length}] (metres)"
            )));
        }
        let columns =
            (0..self.width()).map(|column| self.column(column)).collect::<Result<Vec<_>, _>>().or_raise()?;
        let values: Vec<f64> =
            places.iter().flat_map(|x| columns.iter().map(move |column| column.at(x / length)[0])).collect();
        let leading = (!is_number).then_some(places.len());
        let shape: Vec<usize> = leading.into_iter().chain(self.shape.iter().copied()).collect();
        values.into_pyarray(X.py()).reshape(shape)
    }

    pub(super) fn __repr__(&self) -> String {
        let number = self.rows.len();
        let kind = match self.stations {
            Some(_) => format!("table of {number} stations"),
            None => format!("polynomial of degree {}", number - 1),
        };
        format!("<lissom.Profile: {kind} over {:?} m, values of shape {:?}>", self.length, self.shape)
    }

    /// For copies and pickles.
    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<((f64,), Bound<'py, PyDict>)> {
        let arguments = PyDict::new(py);
        match self.stations(py) {
            Some(stations) => {
                arguments.set_item("stations", stations)?;
                arguments.set_item("values", self.array(py)?)?;
            }
            None => arguments.set_item("coefficients", self.array(py)?)?,
        }
        Ok(((self.length,), arguments))
    }
}

impl PyProfile {
    /// Number of components of a value.
    fn width(&self) -> usize {
        self.shape.iter().product()
    }

    fn array<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let shape: Vec<usize> = [self.rows.len()].into_iter().chain(self.shape.iter().copied()).collect();
        self.rows.concat().into_pyarray(py).reshape(shape)
    }

    /// One component.
    fn column(&self, column: usize) -> Result<Profile<1>, InvalidInput> {
        let rows: Vec<[f64; 1]> = self.rows.iter().map(|row| [row[column]]).collect();
        match &self.stations {
            Some(stations) => Profile::table(stations, &rows),
            None => Profile::polynomial(&rows),
        }
    }
}

/// Rows of numbers, and the shape of a row.
fn rows(value: &Bound<'_, PyAny>, name: &str) -> PyResult<(Vec<Vec<f64>>, Vec<usize>)> {
    const EXPECTED: &str = "an array of real numbers";
    let Numbers { values, shape } = convert::numbers(value, name, EXPECTED)?;
    let Some((&number, shape)) = shape.split_first() else {
        let found = convert::describe(value);
        return Err(PyTypeError::new_err(format!("{name}: expected {EXPECTED}, got {found}")));
    };
    let width: usize = shape.iter().product();
    if width == 0 {
        let message = format!("{name}: expected at least one number in a row, got rows of shape {shape:?}");
        return Err(PyValueError::new_err(message));
    }
    let rows: Vec<Vec<f64>> = values.chunks_exact(width).map(<[f64]>::to_vec).collect();
    debug_assert_eq!(rows.len(), number);
    Ok((rows, shape.to_vec()))
}

/// One value of this shape with `N` numbers.
fn value_of<const N: usize>(value: &Bound<'_, PyAny>, shape: &[usize], name: &str) -> PyResult<[f64; N]> {
    let wrong = |_| PyTypeError::new_err(wrong_value(name, shape, &convert::describe(value)));
    let Numbers { values, shape: found } = convert::numbers(value, name, "").map_err(wrong)?;
    if !stands_for(&found, shape) {
        if let ([expected], [found]) = (shape, &found[..]) {
            return Err(PyValueError::new_err(format!("{name}: expected {expected} values, got {found}")));
        }
        let message = wrong_value(name, shape, &format!("an array of shape {found:?}"));
        return Err(PyValueError::new_err(message));
    }
    Ok(numbers(&values))
}

/// Whether a value of one shape can replace one of another: the same shape, or the diagonal of a square
/// matrix.
fn stands_for(found: &[usize], shape: &[usize]) -> bool {
    found == shape || matches!((found, shape), ([n], [rows, _]) if n == rows)
}

/// The numbers of a value, expanded to `N` numbers.
fn numbers<const N: usize>(value: &[f64]) -> [f64; N] {
    let n = value.len();
    // Every n + 1st entry of n x n lies on the diagonal.
    std::array::from_fn(|i| match n == N {
        true => value[i],
        false if i % (n + 1) == 0 => value[i / (n + 1)],
        false => 0.0,
    })
}

fn wrong_value(name: &str, shape: &[usize], found: &str) -> String {
    let expected = match shape {
        [] => "a number".to_owned(),
        [rows, columns] => format!("an array of shape ({rows},) or ({rows}, {columns})"),
        shape => format!("an array of shape {shape:?}"),
    };
    format!(
        "{name}: expected {expected}, a table (stations, values) or a function of the arc length X, got {found}"
    )
}

/// The value of a function along a segment, whose constant values have this kind; the length of the segment in metres is
/// needed for functions only.
pub(super) fn along_segment(
    value: &Bound<'_, PyAny>,
    name: &str,
    kind: &Kind,
    length: impl FnOnce() -> PyResult<Option<f64>>,
) -> PyResult<Value> {
    if let Kind::OneOrEach(_) = kind {
        if let Some(number) = convert::number_if_one(value, name)? {
            return Ok(Value::Number(number));
        }
        if !varies(value)? {
            let ends = convert::array_of::<2>(value, name);
            let expected = "a number or (base, tip) in metres";
            return Ok(ends.map_err(|_| wrong(name, expected, value))?.write());
        }
    }
    if !varies(value)? {
        return Ok(match kind {
            Kind::Symmetric(3) => Symmetric(convert::symmetric_of::<3>(value, name)?).write(),
            Kind::Symmetric(_) => Symmetric(convert::symmetric_of::<6>(value, name)?).write(),
            Kind::Array(_, 2) => value_of::<2>(value, &[2], name)?.write(),
            Kind::Array(_, 3) => value_of::<3>(value, &[3], name)?.write(),
            Kind::Array(..) => value_of::<6>(value, &[6], name)?.write(),
            _ => value_of::<1>(value, &[], name)?[0].write(),
        });
    }
    let length = length()?.ok_or_else(|| {
        PyValueError::new_err(format!(
            "{name}: a function of the arc length X needs `length`, that of the segment (metres)"
        ))
    })?;
    Ok(match kind {
        Kind::Symmetric(3) => profile::<9>(value, &[3, 3], length, name)?.write(),
        Kind::Symmetric(_) => profile::<36>(value, &[6, 6], length, name)?.write(),
        Kind::Array(_, 2) => profile::<2>(value, &[2], length, name)?.write(),
        Kind::Array(_, 3) => profile::<3>(value, &[3], length, name)?.write(),
        Kind::Array(..) => profile::<6>(value, &[6], length, name)?.write(),
        _ => profile::<1>(value, &[], length, name)?.write(),
    })
}

/// The profile of a value along a segment of this length, if it is a function.
pub(super) fn along_segment_out(value: &Value, length: f64) -> Option<PyProfile> {
    if let Some(profile) = value.part::<Profile<1>>() {
        Some(to_python(profile, &[], length))
    } else if let Some(profile) = value.part::<Profile<2>>() {
        Some(to_python(profile, &[2], length))
    } else if let Some(profile) = value.part::<Profile<3>>() {
        Some(to_python(profile, &[3], length))
    } else if let Some(profile) = value.part::<Profile<6>>() {
        Some(to_python(profile, &[6], length))
    } else if let Some(profile) = value.part::<Profile<9>>() {
        Some(to_python(profile, &[3, 3], length))
    } else {
        value.part::<Profile<36>>().map(|profile| to_python(profile, &[6, 6], length))
    }
}

fn wrong(name: &str, expected: &str, value: &Bound<'_, PyAny>) -> PyErr {
    let found = convert::describe_entry(value);
    PyTypeError::new_err(format!(
        "{name}: expected {expected}, a table (stations, values) or a function of the arc length X, got {found}"
    ))
}

/// Numbers along a segment of this length from Python, a value of which has this shape with `N` entries: a constant
/// value, a pair of stations (metres) and values, a function of the arc length from the segment's base in metres, or
/// a `lissom.Profile`.
fn profile<const N: usize>(
    value: &Bound<'_, PyAny>,
    shape: &[usize],
    length: f64,
    name: &str,
) -> PyResult<Profile<N>> {
    if let Ok(profile) = value.cast::<PyProfile>() {
        return of_profile(profile.get(), shape, length, name);
    }
    if value.is_callable() {
        return of_function(value, shape, length, name);
    }
    if let Some((stations, values)) = table(value)? {
        let stations = convert::vector(&stations, &format!("{name}, stations"))?;
        let (rows, found) = rows(&values, &format!("{name}, values"))?;
        let number = rows.len();
        let profile = PyProfile { length, shape: found, stations: Some(stations), rows };
        if !stands_for(&profile.shape, shape) {
            return Err(PyValueError::new_err(format!(
                "{name}, values: expected {} of shape {shape:?}, one for each station, got {number} of shape {:?}",
                profile.stations.map_or(0, |stations| stations.len()),
                profile.shape,
            )));
        }
        return of_profile(&profile, shape, length, name);
    }
    Ok(value_of(value, shape, name)?.into())
}

/// The profile as a Python object.
fn to_python<const N: usize>(profile: &Profile<N>, shape: &[usize], length: f64) -> PyProfile {
    let rows = |rows: &[[f64; N]]| rows.iter().map(|row| row.to_vec()).collect();
    let (stations, rows) = match profile.parts() {
        Parts::Constant(value) => (None, vec![value.to_vec()]),
        // (base + tip)/2 and (tip - base)/2 are the coefficients of one and 2 x - 1.
        Parts::Linear([base, tip]) => {
            let [mean, slope] = [1.0, -1.0].map(|sign| (0..N).map(move |i| 0.5 * (tip[i] + sign * base[i])));
            (None, vec![mean.collect(), slope.collect()])
        }
        Parts::Table(stations, values) => (Some(stations.to_vec()), rows(values)),
        Parts::Polynomial(coefficients) => (None, rows(coefficients)),
    };
    PyProfile { length, shape: shape.to_vec(), stations, rows }
}

/// The length in metres that a table or a `lissom.Profile` is over; none of anything else.
pub(super) fn length_of(value: &Bound<'_, PyAny>) -> PyResult<Option<f64>> {
    if let Ok(profile) = value.cast::<PyProfile>() {
        return Ok(Some(profile.get().length));
    }
    let Some((stations, _)) = table(value)? else { return Ok(None) };
    // Stations that are none are refused when the table is read.
    Ok(convert::vector(&stations, "stations").ok().and_then(|stations| stations.last().copied()))
}

/// A number along a rod whose length is not known yet; a callable is added to the functions of its owner.
pub(super) fn along_rod(
    value: &Bound<'_, PyAny>,
    name: &str,
    functions: &mut Functions,
) -> PyResult<AlongRod> {
    if let Ok(profile) = value.cast::<PyProfile>() {
        let PyProfile { length, shape, stations, rows } = profile.get().clone();
        if !shape.is_empty() {
            let found = format!("a profile with values of shape {shape:?}");
            return Err(PyValueError::new_err(wrong_value(name, &[], &found)));
        }
        let numbers = rows.concat();
        return Ok(match stations {
            Some(stations) => AlongRod::Table(AlongRodTable { stations, values: numbers }),
            None => AlongRod::Polynomial(length, numbers),
        });
    }
    if value.is_callable() {
        return functions.function(value, format!("{name}(X)")).map(AlongRod::Function);
    }
    if let Some(table) = table_along_rod(value, name)? {
        return Ok(table);
    }
    let is_sequence = value.is_instance_of::<PyTuple>() || value.is_instance_of::<PyList>();
    if is_sequence && value.len()? == 2 {
        return convert::array_of(value, name).map(AlongRod::Linear);
    }
    let [number] = value_of(value, &[], name)?;
    Ok(AlongRod::Constant(number))
}

/// Numbers at stations along a rod, where `value` is a pair of arrays.
pub(super) fn table_along_rod(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Option<AlongRod>> {
    let Some((stations, values)) = table(value)? else { return Ok(None) };
    let stations = convert::vector(&stations, &format!("{name}, stations"))?;
    let values = convert::vector(&values, &format!("{name}, values"))?;
    Ok(Some(AlongRod::Table(AlongRodTable { stations, values })))
}

/// The Python object of a number along a rod.
pub(super) fn along_rod_out<'py>(py: Python<'py>, along: &AlongRod) -> PyResult<Bound<'py, PyAny>> {
    match along {
        AlongRod::Constant(number) => number.into_bound_py_any(py),
        AlongRod::Linear([base, tip]) => (base, tip).into_bound_py_any(py),
        AlongRod::Table(AlongRodTable { stations, values }) => {
            Ok((PyTuple::new(py, stations)?, PyTuple::new(py, values)?).into_pyobject(py)?.into_any())
        }
        AlongRod::Polynomial(length, numbers) => {
            let rows = numbers.iter().map(|number| vec![*number]).collect();
            let profile = PyProfile { length: *length, shape: Vec::new(), stations: None, rows };
            profile.into_bound_py_any(py)
        }
        AlongRod::Function(function) => callable_of(py, function),
    }
}

/// Whether `value` is a function of the arc length: a table, a callable or a `lissom.Profile`.
fn varies(value: &Bound<'_, PyAny>) -> PyResult<bool> {
    Ok(value.is_instance_of::<PyProfile>() || value.is_callable() || table(value)?.is_some())
}

/// Stations and values, where `value` is a pair of arrays.
fn table<'py>(value: &Bound<'py, PyAny>) -> PyResult<Option<(Bound<'py, PyAny>, Bound<'py, PyAny>)>> {
    if !value.is_instance_of::<PyTuple>() && !value.is_instance_of::<PyList>() {
        return Ok(None);
    }
    let items = value.try_iter()?.collect::<PyResult<Vec<_>>>()?;
    match <[_; 2]>::try_from(items) {
        Ok([stations, values]) if convert::is_array(&stations) => Ok(Some((stations, values))),
        _ => Ok(None),
    }
}

fn of_profile<const N: usize>(
    profile: &PyProfile,
    shape: &[usize],
    length: f64,
    name: &str,
) -> PyResult<Profile<N>> {
    if !stands_for(&profile.shape, shape) {
        let found = format!("a profile with values of shape {:?}", profile.shape);
        return Err(PyValueError::new_err(wrong_value(name, shape, &found)));
    }
    if profile.length != length {
        return Err(PyValueError::new_err(format!(
            "{name}: got a profile over {} m, expected one over the segment's length, {length} m",
            profile.length
        )));
    }
    let rows: Vec<[f64; N]> = profile.rows.iter().map(|row| numbers(row)).collect();
    let found = match &profile.stations {
        Some(stations) => Profile::table(stations, &rows).and_then(|profile| {
            profile.validate(length)?;
            Ok(profile)
        }),
        None => Profile::polynomial(&rows),
    };
    let mut check = Checker::new();
    match check.nested(name, found) {
        Some(profile) => Ok(profile),
        None => Err(raise(check.finish().expect_err("nothing was found"))),
    }
}

fn of_function<const N: usize>(
    function: &Bound<'_, PyAny>,
    shape: &[usize],
    length: f64,
    name: &str,
) -> PyResult<Profile<N>> {
    if !(length.is_finite() && length > 0.0) {
        // The length is refused with the other parameters.
        return Ok([0.0; N].into());
    }
    let sampled = Profile::sampled(|x| {
        function.py().check_signals()?;
        let value = call(Form { name, arguments: "X", args: None }, function, (x * length,))?;
        value_of(&value, shape, &format!("{name}(X)"))
    });
    sampled.map_err(|problem| match problem {
        Unsampled::Failed(error) => error,
        Unsampled::NonFinite { x, value, .. } => PyValueError::new_err(format!(
            "{name}: got {value} at X = {}, expected finite numbers",
            x * length
        )),
        Unsampled::NotSmooth { x } => PyValueError::new_err(format!(
            "{name}: does not become smooth at X = {:.4}: split the segment there, or give a table (stations, values)",
            x * length
        )),
    })
}
