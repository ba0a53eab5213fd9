//! Conversion of Python objects to values of descriptions and back, by the kinds of fields.

use std::path::PathBuf;
use std::sync::Arc;

use numpy::PyArray2;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyMapping, PySequence, PyString, PyTuple};

use super::meant::{along_z, misplaced, part_of_numbers, quaternion_of};
use super::object::{PyPart, wrapped};
use crate::description::schema::{
    AnyPart, Data as _, Field, Kind, Schema, Value, suggestion, unexpected, within,
};
use crate::description::signal::{Drive, Signal};
use crate::python::convert;
use crate::python::errors::at_place;
use crate::python::model::of_file;
use crate::python::profile::{
    self, along_rod, along_rod_out, along_segment, along_segment_out, table_along_rod,
};
use crate::python::signal::{Functions, on_signal, signal_of, signal_out};
use crate::python::words::no_missing;
use crate::robot::effects::actuator::AlongRod;

/// The arguments of a call, by the fields of the part. None may select a default that is not a number.
pub(super) fn arguments(
    schema: &'static Schema,
    args: &Bound<'_, PyTuple>,
    kwargs: Option<&Bound<'_, PyDict>>,
    is_none_default: bool,
    functions: &mut Functions,
) -> PyResult<Vec<Option<Value>>> {
    let given = given_to(schema, args, kwargs)?;
    let fits = |object: &Bound<'_, PyAny>, field: &Field| {
        value_of(object, field.name, &field.kind, &mut Functions::default()).map(|_| ())
    };
    let refused = |error: PyErr| misplaced(schema, args, fits).unwrap_or(error);
    let fields = schema.fields.iter().zip(&given);
    let of_field =
        |(field, object): (&Field, &Option<_>)| (field.name, object.is_none() && field.is_required());
    no_missing(&schema.maker(), &fields.map(of_field).collect::<Vec<_>>()).map_err(refused)?;
    let length = || length_of(schema, &given);
    let mut values = vec![None; given.len()];
    for ((field, object), value) in schema.fields.iter().zip(&given).zip(&mut values) {
        let Some(object) = object else { continue };
        if is_none_default && object.is_none() && !field.is_required() && !matches!(field.kind, Kind::Number)
        {
            continue;
        }
        let read = match field.kind.along_segment() {
            Some(kind) if !object.is_none() => along_segment(object, field.name, kind, length),
            _ => value_of(object, field.name, &field.kind, functions),
        };
        *value = Some(read.map_err(refused)?);
    }
    // A table or a profile determines the length of the part.
    if let Some(i) = schema.index("length").filter(|i| values[*i].is_none()) {
        values[i] = length()?.map(Value::Number);
    }
    Ok(values)
}

/// The objects given for the fields of the part; refuses those for which there are none.
fn given_to<'py>(
    schema: &'static Schema,
    args: &Bound<'py, PyTuple>,
    kwargs: Option<&Bound<'py, PyDict>>,
) -> PyResult<Vec<Option<Bound<'py, PyAny>>>> {
    let refuse = |what: String| PyTypeError::new_err(format!("{}() {what}", schema.maker()));
    let mut given: Vec<Option<Bound<'py, PyAny>>> = vec![None; schema.fields.len()];
    if args.len() > schema.positional {
        let known = schema.names().collect::<Vec<_>>().join(", ");
        let (most, given) = (schema.positional, args.len());
        return Err(refuse(match most {
            0 => format!("takes no positional arguments: give them by name, of {known}"),
            _ => format!("takes {most} positional arguments but {given} were given, expected {known}"),
        }));
    }
    for (given, object) in given.iter_mut().zip(args.iter()) {
        *given = Some(object);
    }
    let mut others: Vec<String> = Vec::new();
    for (key, object) in kwargs.into_iter().flatten() {
        let key = key.cast::<PyString>()?.to_str()?;
        match schema.index(key) {
            Some(i) if given[i].replace(object).is_some() => {
                return Err(refuse(format!("got multiple values for argument '{key}'")));
            }
            Some(_) => {}
            None => others.push(key.to_owned()),
        }
    }
    if !others.is_empty() {
        let others: Vec<_> = others.iter().map(String::as_str).collect();
        return Err(refuse(unexpected(&others, &schema.names().collect::<Vec<_>>(), |word| {
            within(schema, word)
        })));
    }
    Ok(given)
}

/// The length of the segment that these arguments describe: given, or that of a table or a profile among them.
fn length_of(schema: &Schema, given: &[Option<Bound<'_, PyAny>>]) -> PyResult<Option<f64>> {
    let Some(i) = schema.index("length") else { return Ok(None) };
    if let Some(length) = given[i].as_ref().filter(|length| !length.is_none()) {
        return convert::number(length, "length").map(Some);
    }
    let fields = schema.fields.iter().zip(given).filter(|(field, _)| field.kind.along_segment().is_some());
    for object in fields.filter_map(|(_, object)| object.as_ref()) {
        let length = profile::length_of(object)?;
        if length.is_some() {
            return Ok(length);
        }
    }
    Ok(None)
}

/// The value of an argument, whose functions are added to those of its owner.
pub(super) fn value_of(
    object: &Bound<'_, PyAny>,
    name: &str,
    kind: &Kind,
    functions: &mut Functions,
) -> PyResult<Value> {
    match kind {
        Kind::Number => convert::number(object, name).map(Value::Number),
        Kind::Integer => convert::whole(object, name).map(Value::Integer),
        Kind::Flag => convert::flag(object, name).map(Value::Flag),
        Kind::Text | Kind::Word(..) | Kind::Reference(_) => text_of(object, name),
        Kind::Array(Kind::Array(..), _) => {
            let rows = convert::symmetric_of::<3>(object, name)?;
            Ok(Value::Rows { numbers: rows.concat(), columns: 3 })
        }
        Kind::Array(distance @ Kind::AlongRod(_), count) => {
            distances_of(object, name, distance, *count, functions)
        }
        Kind::Array(_, count) => array_of(object, name, *count),
        Kind::List(Kind::Number) => Ok(numbers(convert::vector(object, name)?)),
        Kind::List(inner @ (Kind::Part(_) | Kind::OneOf(..))) => {
            parts_of_list(object, name, inner, functions)
        }
        Kind::List(Kind::List(Kind::List(_))) => layers_of(object, name),
        Kind::List(rows) => rows_of(object, name, rows),
        Kind::OneOrEach(count) => one_or_some(object, name, &[*count]),
        Kind::AtRestOrEach(count) => one_or_some(object, name, &[2, *count]),
        Kind::OneOrMany => Ok(match convert::scalar_or_vector(object, name)? {
            (values, true) => Value::Number(values[0]),
            (values, false) => numbers(values),
        }),
        Kind::Optional(_) if object.is_none() => Ok(Value::None),
        Kind::Optional(inner @ Kind::Part(schema)) if schema.is_list => {
            value_of(object, name, inner, functions)
        }
        Kind::Optional(inner @ (Kind::Part(_) | Kind::OneOf(_, [Kind::Part(_), ..]))) => {
            let inner = if let Kind::OneOf(_, kinds) = inner { kinds } else { std::slice::from_ref(*inner) };
            one_of(object, name, inner, kind, functions)
        }
        Kind::Optional(inner) => value_of(object, name, inner, functions),
        Kind::OneOf(_, [number @ (Kind::Number | Kind::OneOrEach(_)), Kind::Word(_, words)]) => {
            number_or_word(object, name, number, words, functions)
        }
        Kind::OneOf(_, [each @ Kind::AtRestOrEach(_), _]) => number_or_table(object, name, each, functions),
        Kind::OneOf(_, kinds) => one_of(object, name, kinds, kind, functions),
        Kind::Open(_) if object.is_instance_of::<PyString>() => text_of(object, name),
        Kind::Open(inner) => value_of(object, name, inner, functions),
        Kind::Part(schema) if schema.is_dict => dict_of(object, name, schema),
        Kind::Part(schema) if schema.is_list => {
            let Field { name: key, kind, .. } = &schema.fields[0];
            let list = value_of(object, name, kind, functions)?;
            Ok(Value::Table(vec![((*key).into(), list)]))
        }
        Kind::Part(_) => one_of(object, name, std::slice::from_ref(kind), kind, functions),
        Kind::AlongRod(_) => Ok(along_rod(object, name, functions)?.write()),
        // Functions are sampled where the length is known.
        Kind::Symmetric(_) => along_segment(object, name, kind, || Ok(None)),
        Kind::Profile(values, _) => along_segment(object, name, values, || Ok(None)),
        Kind::Signal(sort, numbers, _) => Ok(Value::Part(match (sort.is_empty(), numbers) {
            (false, Kind::Number) => Arc::new(signal_of::<1>(object, name, functions)?),
            (false, _) => Arc::new(signal_of::<3>(object, name, functions)?),
            (true, Kind::Number) => Arc::new(Drive(signal_of::<1>(object, name, functions)?)),
            (true, Kind::Array(_, 4)) => Arc::new(Drive(signal_of::<4>(object, name, functions)?)),
            (true, _) => Arc::new(Drive(signal_of::<3>(object, name, functions)?)),
        })),
    }
}

/// A number, or one of these numbers of them.
fn one_or_some(object: &Bound<'_, PyAny>, name: &str, counts: &[usize]) -> PyResult<Value> {
    let (values, is_one) = convert::scalar_or_vector(object, name)?;
    if is_one {
        return Ok(Value::Number(values[0]));
    }
    let found = values.len();
    if counts.contains(&found) {
        return Ok(numbers(values));
    }
    let counts: Vec<_> = counts.iter().map(usize::to_string).collect();
    Err(PyValueError::new_err(format!("{name}: expected {} values, got {found}", counts.join(" or "))))
}

/// A vector of this number of entries.
fn array_of(object: &Bound<'_, PyAny>, name: &str, count: usize) -> PyResult<Value> {
    let meant = |error| {
        let quaternion = quaternion_of(object, count, &error);
        quaternion.or_else(|| along_z(object, name, count, &error)).unwrap_or(error)
    };
    convert::vector_of(object, count, name).map(numbers).map_err(meant)
}

/// A sequence of parts of this kind.
fn parts_of_list(
    object: &Bound<'_, PyAny>,
    name: &str,
    inner: &Kind,
    functions: &mut Functions,
) -> PyResult<Value> {
    let expected = format!("a sequence of lissom.{}", classes_of(inner));
    if matches!(inner.schema().map(Schema::class), Some("Link" | "Segment"))
        && let Some(reader) = object.extract::<PathBuf>().ok().and_then(|path| of_file(&path))
    {
        let found = convert::describe(object);
        return Err(PyTypeError::new_err(format!("{name}: expected {expected}, got {found}; {reader}")));
    }
    if object.is_instance_of::<PyPart>() {
        let found = convert::describe(object);
        let message =
            format!("{name}: expected {expected}, got {found}; one of them stands in brackets: [...]");
        return Err(PyTypeError::new_err(message));
    }
    let items = items_of(object, name, &expected)?;
    list_of(&items, name, inner, functions).map_err(|error| {
        // Numbers without the part and the list around them.
        part_of_numbers(object, kinds_of(inner)).map_or(error, |meant| {
            let classes = classes_of(inner);
            PyTypeError::new_err(format!(
                "{name}: expected a sequence of lissom.{classes}, got numbers{meant}"
            ))
        })
    })
}

/// Numbers of that kind, or a table of them along a rod.
fn number_or_table(
    object: &Bound<'_, PyAny>,
    name: &str,
    number: &Kind,
    functions: &mut Functions,
) -> PyResult<Value> {
    match table_along_rod(object, name)? {
        Some(table) => Ok(table.write()),
        None => value_of(object, name, number, functions),
    }
}

/// A number of that kind, or one of the words.
fn number_or_word(
    object: &Bound<'_, PyAny>,
    name: &str,
    number: &Kind,
    words: &[&str],
    functions: &mut Functions,
) -> PyResult<Value> {
    if object.is_instance_of::<PyString>() {
        return text_of(object, name);
    }
    value_of(object, name, number, functions).map_err(|_| {
        let each =
            if let Kind::OneOrEach(count) = number { format!(", {count} numbers") } else { String::new() };
        let expected = format!("a number{each} or '{}'", words.join("', '"));
        PyTypeError::new_err(format!("{name}: expected {expected}, got {}", convert::describe(object)))
    })
}

fn text_of(object: &Bound<'_, PyAny>, name: &str) -> PyResult<Value> {
    Ok(Value::Text(convert::text(object, name)?.to_owned()))
}

/// Distances from the axis of a rod, of that kind and number.
fn distances_of(
    object: &Bound<'_, PyAny>,
    name: &str,
    distance: &Kind,
    count: usize,
    functions: &mut Functions,
) -> PyResult<Value> {
    const EXPECTED: &str = "the pair (y, z) of distances from the rod's axis";
    let items = items_of(object, name, EXPECTED)?;
    if items.len() != count {
        let found = items.len();
        return Err(PyValueError::new_err(format!("{name}: got {found} of them, expected {EXPECTED}")));
    }
    list_of(&items, name, distance, functions)
}

/// The table of a part of integers that Python has as a dict.
fn dict_of(object: &Bound<'_, PyAny>, name: &str, schema: &'static Schema) -> PyResult<Value> {
    let Ok(dict) = object.cast::<PyDict>() else {
        let found = convert::describe(object);
        let expected = format!("a dict such as {{'{}': 3}}", schema.fields[1].name);
        return Err(PyTypeError::new_err(format!("{name}: got {found}, expected {expected}")));
    };
    let pair = |(key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
        let key = key.str()?.to_string();
        let Ok(number) = convert::whole(&value, name) else {
            let (found, expected) = (value.repr()?, "a whole number >= 0");
            return Err(PyValueError::new_err(format!("{name}['{key}']: got {found}, expected {expected}")));
        };
        Ok((key.into(), Value::Integer(number)))
    };
    dict.iter().map(pair).collect::<PyResult<_>>().map(Value::Table)
}

/// The items of a sequence.
fn items_of<'py>(object: &Bound<'py, PyAny>, name: &str, expected: &str) -> PyResult<Vec<Bound<'py, PyAny>>> {
    let items = object.try_iter().map_err(|_| {
        PyTypeError::new_err(format!("{name}: expected {expected}, got {}", convert::describe(object)))
    })?;
    items.collect()
}

fn list_of(
    items: &[Bound<'_, PyAny>],
    name: &str,
    kind: &Kind,
    functions: &mut Functions,
) -> PyResult<Value> {
    let item = |(i, item)| value_of(item, &format!("{name}[{i}]"), kind, functions);
    items.iter().enumerate().map(item).collect::<PyResult<_>>().map(Value::List)
}

/// The kinds of which a value is one.
fn kinds_of(kind: &Kind) -> &[Kind] {
    if let Kind::OneOf(_, kinds) = kind { kinds } else { std::slice::from_ref(kind) }
}

/// Names of the classes of a kind.
fn classes_of(kind: &Kind) -> String {
    if let Kind::Optional(inner) = kind {
        return format!("{} or None", classes_of(inner));
    }
    let mut classes: Vec<_> = kinds_of(kind).iter().filter_map(Kind::schema).map(Schema::class).collect();
    classes.dedup();
    match classes.split_last() {
        Some((last, first)) if !first.is_empty() => format!("{} or {last}", first.join(", ")),
        _ => classes.concat(),
    }
}

fn numbers(values: Vec<f64>) -> Value {
    Value::List(values.into_iter().map(Value::Number).collect())
}

/// Numbers in rows, whose length the kind of a row defines.
fn rows_of(object: &Bound<'_, PyAny>, name: &str, row: &Kind) -> PyResult<Value> {
    let expected = match row {
        Kind::Array(Kind::Integer, count) => format!("rows of {count} integers"),
        Kind::Array(_, count) => format!("rows of {count} numbers"),
        _ => "rows of numbers".to_owned(),
    };
    let found = convert::numbers(object, name, &expected).map_err(|error| {
        let lengths: Vec<_> =
            object.try_iter().into_iter().flatten().flatten().map(|row| row.len()).collect();
        let known: Vec<_> = lengths.iter().flatten().collect();
        match known.len() == lengths.len() && known.iter().any(|length| *length != known[0]) {
            true => PyValueError::new_err(format!(
                "{name}: rows of different lengths, expected {expected} of one length"
            )),
            false if error.is_instance_of::<PyTypeError>(object.py()) => {
                PyTypeError::new_err(format!("{}; {name} are {expected}", error.value(object.py())))
            }
            false => error,
        }
    })?;
    let [_, columns] = found.shape[..] else {
        let dimensions = found.shape.len();
        return Err(PyValueError::new_err(format!(
            "{name}: {dimensions} dimensions, expected two: {expected}"
        )));
    };
    if let Kind::Array(items, count) = row {
        if columns != *count {
            return Err(PyValueError::new_err(format!(
                "{name}: shape {:?}, expected {expected}",
                found.shape
            )));
        }
        // Indices, which arrays of numbers may hold as well.
        let is_index = |x: &f64| x.fract() == 0.0 && *x >= 0.0 && x.is_finite();
        if let (Kind::Integer, Some(x)) = (items, found.values.iter().find(|x| !is_index(x))) {
            return Err(PyValueError::new_err(format!(
                "{name}: {x} is no place of a point, expected an integer from 0"
            )));
        }
    }
    Ok(Value::Rows { numbers: found.values, columns })
}

/// Numbers in layers of rows.
fn layers_of(object: &Bound<'_, PyAny>, name: &str) -> PyResult<Value> {
    const EXPECTED: &str = "numbers along three axes";
    let found = convert::numbers(object, name, EXPECTED)?;
    let [_, rows, columns] = found.shape[..] else {
        let dimensions = found.shape.len();
        return Err(PyValueError::new_err(format!(
            "{name}: dimensions {dimensions}, expected three: {EXPECTED}"
        )));
    };
    let layer = |numbers: &[f64]| Value::Rows { numbers: numbers.to_vec(), columns };
    Ok(Value::List(found.values.chunks((rows * columns).max(1)).map(layer).collect()))
}

/// A part, or the name of a part.
fn one_of(
    object: &Bound<'_, PyAny>,
    name: &str,
    kinds: &[Kind],
    whole: &Kind,
    functions: &mut Functions,
) -> PyResult<Value> {
    if let Ok(part) = object.cast::<PyPart>() {
        let PyPart { part, functions: own } = part.get();
        let schema = part.schema();
        if kinds.iter().any(|kind| kind.schema().is_some_and(|known| std::ptr::eq(known, schema))) {
            functions.add_all(object.py(), own);
            return Ok(Value::Part(part.clone()));
        }
    }
    let short = kinds.iter().filter_map(Kind::schema).find(|schema| schema.is_short);
    if let Some(schema) = short
        && let Some(found) = from_arguments(object, name, schema, functions)?
    {
        return Ok(found);
    }
    let is_named = kinds.iter().any(|kind| matches!(kind, Kind::Text | Kind::Reference(_)));
    if is_named && object.is_instance_of::<PyString>() {
        return Ok(Value::Text(convert::text(object, name)?.to_owned()));
    }
    let named = match kinds.iter().find(|kind| matches!(kind, Kind::Text | Kind::Reference(_))) {
        Some(Kind::Text) => "a name, lissom.",
        Some(_) => "the name of a link with a rod, lissom.",
        None => "lissom.",
    };
    let classes = classes_of(whole);
    let found = convert::describe(object);
    let meant = class_meant(object, kinds).map(|class| format!("; did you mean lissom.{class}(...)?"));
    let meant = meant.or_else(|| part_of_numbers(object, kinds)).unwrap_or_default();
    Err(PyTypeError::new_err(format!("{name}: expected {named}{classes}, got {found}{meant}")))
}

/// The class whose name in scenes is given in place of an object, such as "weld".
fn class_meant(object: &Bound<'_, PyAny>, kinds: &[Kind]) -> Option<&'static str> {
    let word: String = object.extract().ok()?;
    let parts: Vec<_> = kinds.iter().filter_map(Kind::schema).filter(|part| !part.tag.is_empty()).collect();
    let tag = suggestion(&word, parts.iter().map(|part| part.tag))?;
    parts.iter().find(|part| part.tag == tag).map(|part| part.class())
}

/// The table of a part from its arguments, as a tuple or a dict, or None for none.
fn from_arguments(
    object: &Bound<'_, PyAny>,
    name: &str,
    schema: &'static Schema,
    functions: &mut Functions,
) -> PyResult<Option<Value>> {
    let py = object.py();
    let (args, kwargs) = if object.is_none() {
        (PyTuple::empty(py), None)
    } else if let Ok(mapping) = object.cast::<PyMapping>() {
        let named = PyDict::new(py);
        named.update(mapping)?;
        (PyTuple::empty(py), Some(named))
    } else if let Ok(sequence) = object.cast::<PySequence>()
        && !object.is_instance_of::<PyString>()
    {
        (sequence.to_tuple()?, None)
    } else {
        return Ok(None);
    };
    let values = arguments(schema, &args, kwargs.as_ref(), false, functions)
        .map_err(|error| at_place(py, name, error))?;
    let given = schema.names().zip(values).filter_map(|(name, value)| Some((name.into(), value?)));
    Ok(Some(Value::Table(given.collect())))
}

/// The object of an attribute: of square matrices an array, of a size the pair at base and tip.
pub(super) fn attribute_of<'py>(
    py: Python<'py>,
    part: &dyn AnyPart,
    index: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let kind = &part.schema().fields[index].kind;
    let value = match part.field(index) {
        Value::None => part.derived(index),
        value => value,
    };
    let array = |rows: &[Vec<f64>]| Ok(PyArray2::from_vec2(py, rows)?.into_any());
    match (kind, kind.along_segment(), &value) {
        (_, Some(Kind::OneOrEach(_)), Value::Number(size)) => Ok(PyTuple::new(py, [size, size])?.into_any()),
        (_, Some(Kind::Symmetric(_)), Value::List(diagonal)) => {
            let entry = |value: &Value| if let Value::Number(entry) = value { *entry } else { 0.0 };
            let row = |i: usize| {
                let mut row = vec![0.0; diagonal.len()];
                row[i] = entry(&diagonal[i]);
                row
            };
            array(&(0..diagonal.len()).map(row).collect::<Vec<_>>())
        }
        (Kind::Array(Kind::Array(..), _), _, Value::Rows { numbers, columns })
        | (_, Some(Kind::Symmetric(_)), Value::Rows { numbers, columns }) => {
            array(&numbers.chunks(*columns).map(<[f64]>::to_vec).collect::<Vec<_>>())
        }
        _ => field_of(py, part, &value),
    }
}

/// The object of a value of a field of this part.
pub(super) fn field_of<'py>(
    py: Python<'py>,
    part: &dyn AnyPart,
    value: &Value,
) -> PyResult<Bound<'py, PyAny>> {
    if let Value::Part(_) = value
        && let Some(i) = part.schema().index("length")
        && let Value::Number(length) = part.field(i)
        && let Some(profile) = along_segment_out(value, length)
    {
        return Ok(Bound::new(py, profile)?.into_any());
    }
    object_of(py, value)
}

/// The object of a value.
pub(in crate::python) fn object_of<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    match value {
        Value::None => Ok(py.None().into_bound(py)),
        Value::Flag(flag) => Ok(PyBool::new(py, *flag).to_owned().into_any()),
        Value::Integer(number) => Ok(number.into_pyobject(py)?.into_any()),
        Value::Number(number) => Ok(PyFloat::new(py, *number).into_any()),
        Value::Text(text) | Value::Other(text) => Ok(PyString::new(py, text).into_any()),
        Value::List(items) => {
            let items = items.iter().map(|item| object_of(py, item)).collect::<PyResult<Vec<_>>>()?;
            Ok(PyTuple::new(py, items)?.into_any())
        }
        Value::Rows { numbers, columns } => {
            let rows = numbers.chunks((*columns).max(1)).map(|row| PyTuple::new(py, row));
            Ok(PyTuple::new(py, rows.collect::<PyResult<Vec<_>>>()?)?.into_any())
        }
        Value::Table(pairs) => {
            let made = PyDict::new(py);
            pairs.iter().try_for_each(|(key, value)| made.set_item(&**key, object_of(py, value)?))?;
            Ok(made.into_any())
        }
        Value::Part(part) if part.schema().is_dict => {
            let made = PyDict::new(py);
            for (field, value) in part.given() {
                made.set_item(field.name, object_of(py, &value)?)?;
            }
            Ok(made.into_any())
        }
        Value::Part(part) if part.schema().is_list => object_of(py, &part.field(0)),
        Value::Part(part) => match value.part::<AlongRod>() {
            Some(along) => along_rod_out(py, along),
            None => on_signal!(value, signal => signal_out(py, signal), wrapped(py, part.clone())),
        },
    }
}
