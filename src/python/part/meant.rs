//! What may be meant by arguments that do not fit their parameters.

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyFloat, PyInt, PySequence, PyString, PyTuple};

use crate::description::schema::{Field, Kind, Schema, did_you_mean};
use crate::error::shortened;
use crate::numerics::lie::{Quaternion, Rotation, Vector};
use crate::python::convert;

/// The refusal of the first positional argument that does not fit, if it fits a later parameter, or together with those that follow it
/// fits one: whoever leaves a name out means these. `fits` reads an object as a field.
pub(super) fn misplaced(
    schema: &'static Schema,
    args: &Bound<'_, PyTuple>,
    fits: impl Fn(&Bound<'_, PyAny>, &Field) -> PyResult<()>,
) -> Option<PyErr> {
    let py = args.py();
    let (i, object, error) =
        args.iter().zip(schema.fields).enumerate().find_map(|(i, (object, field))| {
            let is_open = object.is_none() || field.kind.along_segment().is_some();
            let error = if is_open { None } else { fits(&object, field).err() };
            error.filter(|error| error.is_instance_of::<PyTypeError>(py)).map(|error| (i, object, error))
        })?;
    if object.is_instance_of::<PyString>() {
        // The name of a material in place of its numbers; other texts fit too much.
        schema.index("young_modulus")?;
        let meant = did_you_mean("material", schema.names(), "'")?;
        return Some(PyTypeError::new_err(format!("{}; {meant}", error.value(py))));
    }
    let later = &schema.fields[args.len().min(schema.positional)..schema.positional];
    let rest = args.get_slice(i, args.len()).into_any();
    let alone = later.iter().map(|field| (field, &object));
    let together = schema.fields[i..schema.positional].iter().map(|field| (field, &rest));
    let is_vector = |field: &Field| matches!(field.kind, Kind::Array(..)) && args.len() > i + 1;
    let (field, given) = alone
        .chain(together.filter(|(field, _)| is_vector(field)))
        .find(|(field, given)| field.kind.along_segment().is_none() && fits(given, field).is_ok())?;
    let (name, meaning) = (field.name, field.summary());
    let shown = given.repr().ok()?.to_string();
    let shown = shortened(&shown);
    let text = error.value(py).to_string();
    Some(PyTypeError::new_err(format!("{text}; did you mean {name}={shown}? It is the {meaning}")))
}

/// The refusal of a rotation matrix in place of a quaternion, which it has.
pub(super) fn quaternion_of(object: &Bound<'_, PyAny>, count: usize, error: &PyErr) -> Option<PyErr> {
    let matrix = if count == 4 { convert::matrix_of(object, (3, 3), "").ok()? } else { return None };
    let column = |j: usize| Vector { x: matrix[(0, j)], y: matrix[(1, j)], z: matrix[(2, j)] };
    let rotation = Rotation { x: column(0), y: column(1), z: column(2) };
    let Quaternion { w, v: Vector { x, y, z } } = Quaternion::of_rotation(&rotation);
    let text = error.value(object.py());
    let shown = [w, x, y, z].map(|entry| format!("{entry:?}")).join(", ");
    Some(PyTypeError::new_err(format!("{text}; the quaternion (w, x, y, z) of this matrix is ({shown})")))
}

/// The refusal of a number in place of a vector in space, with the vector along z, or of False in place of none.
pub(super) fn along_z(object: &Bound<'_, PyAny>, name: &str, count: usize, error: &PyErr) -> Option<PyErr> {
    let is_false = object.is_instance_of::<PyBool>() && !object.is_truthy().ok()?;
    let is_number = object.is_instance_of::<PyFloat>() || object.is_exact_instance_of::<PyInt>();
    if count != 3 || !(is_false || is_number) {
        return None;
    }
    let (text, found) = (error.value(object.py()), convert::describe_entry(object));
    let points_down = name == "gravity" && object.extract::<f64>().is_ok_and(|number| number > 0.0);
    let sign = if points_down { "-" } else { "" };
    let meant = if is_false { "none is (0, 0, 0)" } else { &format!("along z it is (0, 0, {sign}{found})") };
    Some(PyTypeError::new_err(format!("{text}; {meant}")))
}

/// The part that numbers in its place describe, if only one of these kinds has one argument of so many: "lissom.Along(offset=(0, 0.01))".
pub(super) fn part_of_numbers(object: &Bound<'_, PyAny>, kinds: &[Kind]) -> Option<String> {
    if object.is_instance_of::<PyString>() {
        return None;
    }
    let entries = object.cast::<PySequence>().ok()?.to_list().ok()?;
    let is_number =
        |entry: Bound<'_, PyAny>| entry.is_instance_of::<PyFloat>() || entry.is_instance_of::<PyInt>();
    if !entries.iter().all(is_number) {
        return None;
    }
    let fields = kinds.iter().filter_map(Kind::schema);
    let fields = fields.flat_map(|schema| schema.fields.iter().map(move |field| (schema, field)));
    let mut fitting =
        fields.filter(|(_, field)| matches!(field.kind, Kind::Array(_, count) if count == entries.len()));
    match (fitting.next(), fitting.next()) {
        (Some((schema, field)), None) => Some(format!(
            "; did you mean lissom.{}({}={})?",
            schema.maker(),
            field.name,
            convert::describe_entry(object)
        )),
        _ => None,
    }
}
