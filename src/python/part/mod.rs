//! One class for all described parts. At import each table of `description` becomes a subclass, with docstring, signature
//! and properties.

mod meant;
mod object;
mod text;
mod values;

use std::any::Any;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

use pyo3::PyTypeInfo;
use pyo3::class::{PyTraverseError, PyVisit};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString, PyTuple, PyType};

use super::callback::raised_by_function;
use super::signal::Functions;
use crate::description::schema::{
    AnyPart, Data as _, Fault, Field, Item, Part, Problem, Reader, Schema, Value,
};
use crate::error::InvalidInput;
use crate::python::errors::raise;
use crate::robot::described;
use crate::scene::{self, PARTS};

pub(crate) use object::PyPart;
use object::{CLASSES, METHODS};
pub(super) use values::object_of;
use values::{arguments, attribute_of, field_of, value_of};

/// The description in an object, if it has one.
pub(super) type DescriptionOf = fn(&Bound<'_, PyAny>) -> Option<Arc<dyn AnyPart>>;

/// The property that reads one field of a description.
#[pyclass(name = "Field", module = "lissom", frozen)]
#[derive(Debug)]
struct PyField {
    index: usize,
    description: DescriptionOf,
    #[pyo3(get, name = "__doc__")]
    doc: String,
}

/// The table of a class.
#[pyclass(frozen)]
struct PySchema(&'static Schema);

/// The fields as `dataclasses` reads them: all fields of a class; of a part those that are given or not derived from others.
#[pyclass(name = "Fields", module = "lissom", frozen)]
#[derive(Debug)]
struct PyFields(Py<PyDict>);

/// The parts of a sequence, whose functions are added to those of their owner.
pub(super) fn parts_of<T: Item>(
    objects: &Bound<'_, PyAny>,
    name: &str,
    functions: &mut Functions,
) -> PyResult<Vec<T>> {
    let value = value_of(objects, name, &<Vec<T>>::KIND, functions)?;
    Ok(<Vec<T>>::read(&value, &mut Reader::default()).expect("these parts have been read before"))
}

/// The description of a model from the arguments of its class; None selects the default. The functions of its parts are
/// added to those of their owner.
pub(super) fn model_of<T: Part>(
    args: &Bound<'_, PyTuple>,
    kwargs: Option<&Bound<'_, PyDict>>,
    functions: &mut Functions,
) -> PyResult<Arc<T>> {
    let values = arguments(T::SCHEMA, args, kwargs, true, functions)?;
    let mut reader = Reader::default();
    let part: Option<Arc<dyn Any + Send + Sync>> =
        (T::SCHEMA.make)(&values, &mut reader).map(|part| part as _);
    let found = part.and_then(|part| part.downcast().ok());
    Ok(found.expect("what the arguments hold has been read before"))
}

/// Resolves a description; raises all problems. The first exception of a user's function is raised as it is, with a note
/// of its place.
pub(super) fn resolved<R>(py: Python<'_>, resolve: impl FnOnce(&mut Reader) -> R) -> PyResult<R> {
    let mut reader = Reader::default();
    let found = resolve(&mut reader);
    let problems = reader.finish();
    if let Err(error) = raised_by_function() {
        let failed = problems.iter().find(|problem| matches!(problem.fault, Fault::Failed));
        if let Some(Problem { place, .. }) = failed {
            // Some exceptions do not accept notes.
            _ = error.value(py).call_method1("add_note", (format!("in {place}"),));
        }
        return Err(error);
    }
    match problems.is_empty() {
        true => Ok(found),
        false => Err(raise(InvalidInput { problems: problems.into_iter().map(Into::into).collect() })),
    }
}

/// Reads a part from the values of its fields, checks it, and raises all its problems.
fn made(schema: &'static Schema, values: &[Option<Value>]) -> PyResult<Arc<dyn AnyPart>> {
    let mut reader = Reader::default();
    let found = (schema.make)(values, &mut reader);
    if let Some(part) = found.as_ref().filter(|_| !schema.is_checked_later) {
        part.check_any(&mut reader);
    }
    let problems = reader.finish();
    let is_type = |problem: &Problem| matches!(problem.fault, Fault::Type { .. });
    match found {
        Some(part) if problems.is_empty() => Ok(part),
        _ => {
            let is_type = problems.iter().all(is_type);
            let error = InvalidInput { problems: problems.into_iter().map(Into::into).collect() };
            let message = error.to_string();
            Err(if is_type { PyTypeError::new_err(message) } else { PyValueError::new_err(message) })
        }
    }
}

/// The fields of a part as Python objects by their names.
fn fields<'py>(py: Python<'py>, part: &dyn AnyPart) -> PyResult<Vec<(&'static str, Bound<'py, PyAny>)>> {
    let names = part.schema().names().enumerate();
    names.map(|(i, name)| Ok((name, field_of(py, part, &part.field(i))?))).collect()
}

/// The arguments from which the class of a part makes an equal one.
pub(super) fn new_arguments<'py>(
    py: Python<'py>,
    part: &dyn AnyPart,
) -> PyResult<(Bound<'py, PyTuple>, Bound<'py, PyDict>)> {
    let named = PyDict::new(py);
    for (name, value) in fields(py, part)? {
        named.set_item(name, value)?;
    }
    Ok((PyTuple::empty(py), named))
}

#[pymethods]
impl PyPart {
    #[new]
    #[classmethod]
    #[pyo3(signature = (*args, **kwargs))]
    pub(super) fn new(
        cls: &Bound<'_, PyType>,
        args: &Bound<'_, PyTuple>,
        kwargs: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        if let Ok(ready) = args.get_item(0)
            && let Ok(part) = ready.cast_exact::<Self>()
        {
            let Self { part, functions } = part.get();
            return Ok(Self { part: part.clone(), functions: functions.clone_ref(cls.py()) });
        }
        let Some(schema) = cls.getattr_opt(pyo3::intern!(cls.py(), "_schema"))? else {
            return Err(base_of_others(cls)?);
        };
        let schema = schema.cast::<PySchema>()?.get().0;
        let mut functions = Functions::default();
        let part = made(schema, &arguments(schema, args, kwargs, false, &mut functions)?)?;
        Ok(Self { part, functions })
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let schema = self.part.schema();
        let is_shown = |(field, value): &(&Field, Value)| {
            let default = field.default.map(|default| default());
            let is_plain = matches!(default, Some(Value::None | Value::Number(_)));
            let is_hidden = schema.is_concise || schema.is_brief && is_plain;
            !(is_hidden && default.as_ref() == Some(value))
        };
        let fields = schema.fields.iter().enumerate().map(|(i, field)| (field, self.part.field(i)));
        let shown = |(field, value): (&Field, Value)| {
            Ok(format!("{}={}", field.name, field_of(py, self.part.as_ref(), &value)?.repr()?))
        };
        let fields = fields.filter(is_shown).map(shown);
        let fields = fields.collect::<PyResult<Vec<_>>>()?;
        Ok(format!("{}({})", schema.maker(), fields.join(", ")))
    }

    fn __eq__(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.part, &other.part) || self.part.same(other.part.as_ref())
    }

    fn __hash__(&self, py: Python<'_>) -> PyResult<u64> {
        let mut hasher = DefaultHasher::new();
        self.part.schema().name.hash(&mut hasher);
        // Functions may have no hash.
        let fields = self.part.schema().fields.iter().zip(fields(py, self.part.as_ref())?);
        for (_, (_, value)) in fields.filter(|(field, _)| !field.kind.holds_functions()) {
            // The modes of a segment are a dict.
            let value = match value.cast::<PyDict>() {
                Ok(dict) => dict.items().to_tuple().into_any(),
                Err(_) => value,
            };
            value.hash()?.hash(&mut hasher);
        }
        Ok(hasher.finish())
    }

    fn __copy__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __deepcopy__(slf: Py<Self>, _memo: &Bound<'_, PyAny>) -> Py<Self> {
        slf
    }

    /// For pickles.
    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyTuple>, Bound<'py, PyDict>)> {
        new_arguments(py, self.part.as_ref())
    }

    /// The keys of the table that describes this part in a scene.
    fn to_toml(&self) -> PyResult<String> {
        let refuse = || PyValueError::new_err("a function of Python cannot be written to a scene");
        scene::to_toml(self.part.as_ref()).ok_or_else(refuse)
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        self.functions.traverse(&visit)
    }
}

#[pymethods]
impl PyFields {
    fn __get__<'py>(
        slf: &Bound<'py, Self>,
        part: &Bound<'py, PyAny>,
        _class: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let all = slf.get().0.bind(slf.py());
        let Ok(part) = part.cast::<PyPart>() else { return Ok(all.clone()) };
        let part = &part.get().part;
        let follows = |i: usize| part.field(i) == Value::None && part.derived(i) != Value::None;
        let given = all.copy()?;
        for (_, name) in part.schema().names().enumerate().filter(|(i, _)| follows(*i)) {
            given.del_item(name)?;
        }
        Ok(given)
    }
}

#[pymethods]
impl PyField {
    fn __get__<'py>(
        slf: &Bound<'py, Self>,
        part: &Bound<'py, PyAny>,
        _class: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        match (slf.get().description)(part) {
            Some(part) => attribute_of(slf.py(), part.as_ref(), slf.get().index),
            None => Ok(slf.clone().into_any()),
        }
    }

    // A property, too, for `help` and documentation tools.
    fn __set__(&self, part: &Bound<'_, PyAny>, _value: &Bound<'_, PyAny>) -> PyResult<()> {
        Err(self.frozen(part, "assign to"))
    }

    fn __delete__(&self, part: &Bound<'_, PyAny>) -> PyResult<()> {
        Err(self.frozen(part, "delete"))
    }
}

impl PyField {
    fn frozen(&self, part: &Bound<'_, PyAny>, what: &str) -> PyErr {
        let part_of = (self.description)(part);
        let field = part_of.map_or("", |part| part.schema().fields[self.index].name);
        let kind = part.py().import("dataclasses").and_then(|module| module.getattr("FrozenInstanceError"));
        let message = format!("cannot {what} field '{field}'; dataclasses.replace makes another object");
        match kind.and_then(|kind| Ok(kind.cast_into::<PyType>()?)) {
            Ok(kind) => PyErr::from_type(kind, message),
            Err(error) => error,
        }
    }
}

fn part_in(object: &Bound<'_, PyAny>) -> Option<Arc<dyn AnyPart>> {
    object.cast::<PyPart>().ok().map(|part| part.get().part.clone())
}

/// Gives the compiled class of a model what follows from the table of its description: docstring, signature, attributes, and
/// what `dataclasses.replace` reads.
pub(super) fn describe_model(
    class: &Bound<'_, PyType>,
    schema: &'static Schema,
    description: DescriptionOf,
) -> PyResult<()> {
    let fields: Bound<'_, PyDict> = dataclass_fields(class.py(), schema)?.cast_into()?;
    class.setattr("__doc__", text::docstring(schema))?;
    class.setattr("__signature__", signature_of(schema, &fields)?)?;
    class.setattr("__dataclass_fields__", fields)?;
    for (index, field) in schema.fields.iter().enumerate() {
        class.setattr(field.name, PyField { index, description, doc: field.meaning() })?;
    }
    Ok(())
}

/// The error of a call of a base class, with the classes that can be called.
fn base_of_others(cls: &Bound<'_, PyType>) -> PyResult<PyErr> {
    let name = cls.name()?.to_string();
    let of_base = PARTS.iter().filter(|schema| schema.base == name);
    let shown = |schema: &&Schema| {
        let arguments: Vec<_> = schema.names().take(schema.positional).collect();
        format!("lissom.{}({})", schema.maker(), arguments.join(", "))
    };
    let makers: Vec<_> = of_base.map(shown).collect();
    let others = if makers.is_empty() { String::new() } else { format!(": {}", makers.join(", ")) };
    Ok(PyTypeError::new_err(format!("{name} is the base of other classes{others}")))
}

/// The class of a part, as users find it in this module.
fn class<'py>(
    schema: &'static Schema,
    kind: &Bound<'py, PyType>,
    base: &Bound<'py, PyType>,
    module: &str,
) -> PyResult<Bound<'py, PyType>> {
    let py = base.py();
    let (items, doc) = (PyDict::new(py), text::docstring(schema));
    let maker = schema.maker();
    let name = maker.rsplit('.').next().expect("one part at least");
    items.set_item("__module__", module)?;
    items.set_item("__qualname__", &maker)?;
    items.set_item("__slots__", ())?;
    // Python takes the signature of a class from the head of its first docstring.
    let signature = text::signature(schema);
    items.set_item("__doc__", format!("{name}({signature})\n--\n\n{doc}"))?;
    items.set_item("_schema", PySchema(schema))?;
    let positional = schema.names().take(schema.positional);
    items.set_item("__match_args__", PyTuple::new(py, positional.collect::<Vec<_>>())?)?;
    if schema.base.starts_with('_') {
        // Documentation shows what follows from a part in its own class.
        for (name, method) in base.getattr("__dict__")?.call_method0("copy")?.cast_into::<PyDict>()? {
            if !name.cast::<PyString>()?.to_str()?.starts_with('_') {
                items.set_item(name, method)?;
            }
        }
    }
    for (index, field) in schema.fields.iter().enumerate() {
        items.set_item(field.name, PyField { index, description: part_in, doc: field.meaning() })?;
    }
    let made = kind.call1((name, (base,), items))?;
    made.setattr("__doc__", doc)?;
    Ok(made.cast_into()?)
}

/// The class of the classes of parts, to which the package adds what it says of names that these do not have.
fn kind_of_classes(py: Python<'_>) -> PyResult<Bound<'_, PyType>> {
    let kind = PyType::type_object(py);
    Ok(kind.call1(("PartType", (&kind,), PyDict::new(py)))?.cast_into()?)
}

/// The fields as `dataclasses.fields` and `dataclasses.replace` read them.
fn dataclass_fields<'py>(py: Python<'py>, schema: &'static Schema) -> PyResult<Bound<'py, PyAny>> {
    let dataclasses = py.import("dataclasses")?;
    let mut specification = Vec::with_capacity(schema.fields.len());
    for (i, field) in schema.fields.iter().enumerate() {
        let options = PyDict::new(py);
        options.set_item("kw_only", i >= schema.positional)?;
        if let Some(default) = field.default.filter(|_| !field.is_required()) {
            options.set_item("default", object_of(py, &default())?)?;
        }
        let made = dataclasses.getattr("field")?.call((), Some(&options))?;
        specification.push((field.name, text::annotation(&field.kind, true), made));
    }
    let options = PyDict::new(py);
    for option in ["init", "repr", "eq"] {
        options.set_item(option, false)?;
    }
    let likeness =
        dataclasses.getattr("make_dataclass")?.call((schema.name, specification), Some(&options))?;
    likeness.getattr("__dataclass_fields__")
}

/// The signature of a class with a default that texts of signatures cannot hold.
fn signature_of<'py>(schema: &Schema, fields: &Bound<'py, PyDict>) -> PyResult<Bound<'py, PyAny>> {
    let py = fields.py();
    let inspect = py.import("inspect")?;
    let parameter = inspect.getattr("Parameter")?;
    let parameters = schema.fields.iter().enumerate().map(|(i, field)| {
        let kind = if i < schema.positional { "POSITIONAL_OR_KEYWORD" } else { "KEYWORD_ONLY" };
        let options = PyDict::new(py);
        if !field.is_required() {
            let known = fields.get_item(field.name)?.expect("each field of the table is one");
            options.set_item("default", known.getattr("default")?)?;
        }
        parameter.call((field.name, parameter.getattr(kind)?), Some(&options))
    });
    inspect.getattr("Signature")?.call1((parameters.collect::<PyResult<Vec<_>>>()?,))
}

/// The base class of this name, created on first use.
fn base<'py>(module: &Bound<'py, PyModule>, name: &'static str) -> PyResult<Bound<'py, PyType>> {
    let part = PyPart::type_object(module.py());
    if name.is_empty() {
        return Ok(part);
    }
    if let Some(known) = module.getattr_opt(name)? {
        return Ok(known.cast_into()?);
    }
    let items = PyDict::new(module.py());
    items.set_item("__module__", "lissom")?;
    items.set_item("__slots__", ())?;
    items.set_item("__doc__", format!("Base class of all {}s.", name.to_lowercase()))?;
    let made = PyType::type_object(module.py()).call1((name, (part,), items))?.cast_into()?;
    module.add(name, &made)?;
    Ok(made)
}

/// The classes of the parts.
pub(super) fn add_classes(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    // All parts are dataclasses for `dataclasses.replace`, whichever they are.
    PyPart::type_object(py).setattr("__dataclass_fields__", PyDict::new(py))?;
    let kind = kind_of_classes(py)?;
    // Methods have names of other classes of this module.
    let methods = PyModule::new(py, "lissom._lissom._methods")?;
    let lists = [(&PARTS[..], module, "lissom"), (&METHODS[..], &methods, "lissom.methods")];
    let mut classes = Vec::with_capacity(PARTS.len() + METHODS.len());
    for (schemas, module, name) in lists {
        for schema in schemas {
            let base = base(module, schema.base)?;
            let class = class(schema, &kind, &base, name)?;
            match schema.is_nested {
                true => base.setattr(schema.tag, &class)?,
                false => module.add(schema.name, &class)?,
            }
            classes.push(class.unbind());
        }
    }
    // Defaults may be parts.
    for (schema, class) in PARTS.iter().chain(&METHODS).zip(CLASSES.get_or_init(py, || classes)) {
        let fields: Bound<'_, PyDict> = dataclass_fields(py, schema)?.cast_into()?;
        let has_part = |field: &Field| matches!(field.default.map(|default| default()), Some(Value::Part(_)));
        if schema.fields.iter().any(|field| !field.is_required() && has_part(field)) {
            class.bind(py).setattr("__signature__", signature_of(schema, &fields)?)?;
        }
        class.bind(py).setattr("__dataclass_fields__", PyFields(fields.unbind()))?;
    }
    module.add("_methods", methods)
}

/// Text of the classes of the parts for the stub of this module.
#[pyfunction]
pub(crate) fn _stub_of_parts() -> String {
    text::stub(&PARTS)
}

/// Text of the classes of the methods for the stub of their module.
#[pyfunction]
pub(crate) fn _stub_of_methods() -> String {
    text::stub(&METHODS)
}

/// Text of constructor and attributes of the classes of models for the stub of this module, by the names of the classes.
#[pyfunction]
pub(crate) fn _stub_of_models() -> Vec<(&'static str, String)> {
    [described::Robot::SCHEMA, described::Rod::SCHEMA]
        .map(|schema| (schema.name, text::stub_of(schema, true)))
        .into()
}
