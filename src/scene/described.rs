//! Tables of scenes that the tables of `description` describe: reading, writing, and their JSON Schema.

use std::borrow::Cow;
use std::marker::PhantomData;

use schemars::{JsonSchema, Schema as JsonSchemaOf, SchemaGenerator};
use serde::Deserialize;
use serde_json::{Map, Value as Json, json};

use super::shape::Shape;
use super::tables::PARTS;
use crate::description::schema::{
    AnyPart, Data, Fault, Field, Kind, Limits, Part, Problem, Reader, Schema, Sign, Value, expected_one_of,
};

/// A value that the tables of `description` describe, as it stands in the file.
#[derive(Clone, Debug, Deserialize)]
#[serde(transparent, bound = "")]
pub(super) struct Written<T> {
    value: toml::Value,
    #[serde(skip)]
    kind: PhantomData<T>,
}

impl<T> Written<T> {
    /// The table.
    pub(super) fn value(&self) -> &toml::Value {
        &self.value
    }

    /// The text of a key.
    pub(super) fn text(&self, key: &str) -> Option<&str> {
        self.value.get(key)?.as_str()
    }
}

/// What is written in a table of a part at this key, if it is right by itself.
pub(super) fn key_of<T: Part, D: Data>(table: &toml::Value, key: &str) -> Option<D> {
    let field = T::SCHEMA.index(key).map(|i| &T::SCHEMA.fields[i]);
    right_in(table.get(key)?, field.map_or(&Limits::NONE, |field| &field.limits))
}

/// What is written, if it is right.
pub(super) fn right<D: Data>(value: &toml::Value) -> Option<D> {
    right_in(value, &Limits::NONE)
}

fn right_in<D: Data>(value: &toml::Value, limits: &Limits) -> Option<D> {
    let mut reader = Reader::default();
    let found = D::read(&value_of(value), &mut reader)?;
    found.check(limits, &mut reader);
    reader.problems().is_empty().then_some(found)
}

/// The value written at this place, checked by itself; `None` after reporting problems.
pub(super) fn read<T: Data>(written: &Written<T>, here: &str, shape: &mut Shape) -> Option<T> {
    read_with(written, here, shape, |place| place)
}

/// As [`read`], where places in the value have other places in the file.
pub(super) fn read_with<T: Data>(
    written: &Written<T>,
    here: &str,
    shape: &mut Shape,
    mut place: impl FnMut(String) -> String,
) -> Option<T> {
    let mut reader = Reader::default();
    let found = T::read(&value_of(&written.value), &mut reader);
    found.iter().for_each(|found| found.check(&Limits::NONE, &mut reader));
    let problems =
        reader.finish().into_iter().map(|problem| Problem { place: place(problem.place), ..problem });
    reported(problems.collect(), here, shape).and(found)
}

/// What is made of values at this place; `None` after reporting problems.
pub(super) fn made<T>(
    here: &str,
    shape: &mut Shape,
    make: impl FnOnce(&mut Reader) -> Option<T>,
) -> Option<T> {
    let mut reader = Reader::default();
    let found = make(&mut reader);
    reported(reader.finish(), here, shape).and(found)
}

/// Reports problems at this place; `None` if there are some.
pub(super) fn reported(problems: Vec<Problem>, here: &str, shape: &mut Shape) -> Option<()> {
    let is_right = problems.is_empty();
    problems.into_iter().for_each(|problem| report(problem, here, shape));
    is_right.then_some(())
}

/// What the tables of an array describe, with their keys in the file. Omits those with problems.
pub(super) fn read_all<T: Data>(
    written: &[Written<T>],
    here: &str,
    shape: &mut Shape,
) -> (Vec<T>, Vec<String>) {
    let keyed = written.iter().enumerate().filter_map(|(i, written)| {
        let key = format!("{here}[{i}]");
        Some((read(written, &key, shape)?, key))
    });
    keyed.unzip()
}

/// Key in the file for a place in one of these lists of a model, whose items have these keys.
pub(super) fn key_of_item(place: &str, lists: &[(&str, &[String])]) -> Option<String> {
    let (list, rest) = place.split_once('[')?;
    let (_, keys) = lists.iter().find(|(name, _)| *name == list)?;
    let (i, rest) = rest.split_once(']')?;
    Some(format!("{}{rest}", keys.get(i.parse::<usize>().ok()?)?))
}

fn value_of(value: &toml::Value) -> Value {
    match value {
        toml::Value::String(text) => Value::Text(text.clone()),
        toml::Value::Integer(number) => Value::Integer(*number),
        toml::Value::Float(number) => Value::Number(*number),
        toml::Value::Boolean(flag) => Value::Flag(*flag),
        toml::Value::Datetime(_) => Value::Other("a date".to_owned()),
        toml::Value::Array(items) => Value::List(items.iter().map(value_of).collect()),
        toml::Value::Table(inner) => Value::Table(
            inner.iter().map(|(key, value)| (Cow::Owned(key.clone()), value_of(value))).collect(),
        ),
    }
}

/// Reports a problem of the table at this place, except for values that could not be read.
fn report(Problem { place, fault }: Problem, here: &str, shape: &mut Shape) {
    let place = if place.is_empty() { here.to_owned() } else { format!("{here}.{place}") };
    // A key that does not belong there is underlined itself, not its value.
    if let Fault::Unknown { .. } | Fault::NotTaken { .. } = fault
        && let Some(key) = shape.keys.get(&place)
    {
        shape.spans.insert(place.clone(), key.clone());
    }
    let (wrong, right) = match fault {
        Fault::Value { found, expected } | Fault::Type { found, expected } => {
            (format!("got {found}"), format!("expected {expected}"))
        }
        Fault::Missing { key, advice } => {
            let is_at_key = place.ends_with(&format!(".{key}"));
            if !is_at_key && !shape.is_readable(&format!("{place}.{key}")) {
                return;
            }
            let wrong = if is_at_key { "missing".to_owned() } else { format!("{key} is missing") };
            (wrong, format!("add {key}{advice}"))
        }
        Fault::Absent { key, meaning, .. } => ("missing".to_owned(), format!("add {key}: {meaning}")),
        Fault::Unknown { known } => ("unknown key".to_owned(), shape.advice(&place, known)),
        Fault::NotTaken { part, taken } => {
            let part = match part.tag {
                "" => part.called.to_owned(),
                tag => format!("{} of {} \"{tag}\"", part.family, part.tag_key),
            };
            let taken = if taken.is_empty() { "nothing but its type".to_owned() } else { taken.join(", ") };
            (format!("{part} does not take it"), format!("remove it: it takes {taken}"))
        }
        Fault::Undecided { key, meaning, tags } => {
            if !shape.is_readable(&format!("{place}.{key}")) || !shape.is_readable(&format!("{place}.kind")) {
                return;
            }
            let kinds: Vec<_> = tags.iter().map(|tag| format!("\"{tag}\"")).collect();
            let right = format!("add {key}, {meaning}, or kind: {}", kinds.join(" or "));
            (format!("neither {key} nor kind"), right)
        }
        Fault::Tag { found, tags } => (format!("got \"{found}\""), expected_one_of(&found, &tags)),
        Fault::Word { found, words } => (format!("got \"{found}\""), expected_one_of(&found, words)),
        Fault::Other { wrong, right } => (wrong, right),
        Fault::Without { key, needed, .. } => (format!("{key} without {needed}"), format!("add {needed}")),
        Fault::Unused { belongs, .. } => (belongs.to_owned(), "remove it".to_owned()),
        Fault::Name { scene: [wrong, right], .. } => (wrong, right),
        // Scenes have no functions.
        Fault::Failed => return,
        Fault::NoneOf(keys) => (format!("neither {}", keys.join(" nor ")), "add one of them".to_owned()),
        Fault::Both([first, second]) => {
            (format!("both {first} and {second} are given"), "keep one of them".to_owned())
        }
    };
    if shape.is_readable(&place) {
        shape.refuse(&place, wrong, right);
    }
}

/// The keys of the table that describes a part, from which an equal one is read. Keys with their default are left out.
/// `None` if it holds a function of Python, which scenes do not have.
pub fn to_toml(part: &dyn AnyPart) -> Option<String> {
    Some(keys(part)?.map(|key| format!("{key}\n")).collect())
}

/// The keys that are given, in TOML.
fn keys(part: &dyn AnyPart) -> Option<impl Iterator<Item = String> + use<>> {
    let given = part.given().into_iter().filter(|(field, _)| !field.limits.is_by_place);
    let keys = given.map(|(field, value)| Some(format!("{} = {}", field.name, inline(&value)?)));
    Some(keys.collect::<Option<Vec<_>>>()?.into_iter())
}

/// A value in TOML.
fn inline(value: &Value) -> Option<String> {
    let list = |items: &mut dyn Iterator<Item = Option<String>>| {
        Some(format!("[{}]", items.collect::<Option<Vec<_>>>()?.join(", ")))
    };
    let number = |number: &f64| Some(toml::Value::Float(*number).to_string());
    match value {
        Value::Number(value) => number(value),
        Value::Text(text) => Some(toml::Value::from(text.as_str()).to_string()),
        Value::List(items) => list(&mut items.iter().map(inline)),
        Value::Rows { numbers, columns } => {
            list(&mut numbers.chunks((*columns).max(1)).map(|row| list(&mut row.iter().map(number))))
        }
        Value::Part(part) => {
            let tag = part.schema().tag;
            let kind = (!tag.is_empty()).then(|| format!("{} = \"{tag}\"", part.schema().tag_key));
            let keys = kind.into_iter().chain(keys(part.as_ref())?);
            Some(format!("{{ {} }}", keys.collect::<Vec<_>>().join(", ")))
        }
        Value::Other(_) => None,
        other => Some(other.to_string()),
    }
}

impl<T: Data> JsonSchema for Written<T> {
    fn schema_name() -> Cow<'static, str> {
        T::KIND.schema().expect("tables that serde reads are parts").name.into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> JsonSchemaOf {
        let mut definitions = Map::new();
        of_kind(&T::KIND, &Limits::NONE, &mut definitions);
        let own = definitions.remove(Self::schema_name().as_ref()).expect("a part has a definition");
        generator.definitions_mut().extend(definitions);
        own.try_into().expect("an object is a schema")
    }
}

/// The definitions of the JSON Schema that describe all parts and functions of time, by their names.
#[cfg(feature = "python")]
pub(crate) fn definitions() -> Map<String, Json> {
    let mut found = Map::new();
    for kind in PARTS.iter().copied().map(Kind::Part) {
        of_kind(&kind, &Limits::NONE, &mut found);
    }
    found
}

fn define(schema: &'static Schema, found: &mut Map<String, Json>) {
    if found.contains_key(schema.name) {
        return;
    }
    // A part that holds others of its kind refers to itself.
    found.insert(schema.name.to_owned(), Json::Null);
    let keys = schema.keys().map(|field| (field.name.to_owned(), of_field(field, found)));
    let mut properties: Map<String, Json> = keys.collect();
    let mut required: Vec<_> =
        schema.keys().filter(|field| field.default.is_none()).map(|field| field.name).collect();
    if !schema.tag.is_empty() {
        let family = schema.family.split_once(' ').map_or(schema.family, |(_article, family)| family);
        let kind =
            json!({ "description": format!("Kind of {family}."), "type": "string", "enum": [schema.tag] });
        properties.insert(schema.tag_key.to_owned(), kind);
        required.insert(0, schema.tag_key);
    }
    let mut own = json!({
        "description": schema.doc.trim(), "type": "object", "properties": properties, "additionalProperties": false,
    });
    if !required.is_empty() {
        own["required"] = required.into();
    }
    found.insert(schema.name.to_owned(), own);
}

fn of_field(field: &'static Field, found: &mut Map<String, Json>) -> Json {
    let mut schema = of_kind(&field.kind, &field.limits, found);
    if schema.get("$ref").is_some() {
        schema = json!({ "allOf": [schema] });
    }
    schema["description"] = field.meaning().into();
    match field.default.map(|default| default()) {
        None | Some(Value::None) => {}
        Some(Value::Text(text)) if text.is_empty() => {}
        Some(Value::Part(_)) => {}
        // Scenes have motions as tables only.
        Some(_) if matches!(field.kind, Kind::Signal("", ..)) => {}
        Some(default) => schema["default"] = in_json(&default),
    }
    schema
}

fn of_kind(kind: &Kind, limits: &Limits, found: &mut Map<String, Json>) -> Json {
    match kind {
        Kind::Number => match limits.sign {
            Sign::Any => json!({ "type": "number", "format": "double" }),
            Sign::NonNegative => json!({ "type": "number", "format": "double", "minimum": 0.0 }),
            Sign::Positive => json!({ "type": "number", "format": "double", "exclusiveMinimum": 0.0 }),
        },
        Kind::Integer => json!({ "type": "integer", "format": "uint", "minimum": 0 }),
        Kind::Flag => json!({ "type": "boolean" }),
        Kind::Text | Kind::Reference(_) => json!({ "type": "string" }),
        Kind::Word(name, words) => {
            found.insert((*name).to_owned(), json!({ "type": "string", "enum": words }));
            json!({ "$ref": format!("#/definitions/{name}") })
        }
        Kind::Array(items, count) => {
            json!({ "type": "array", "items": of_kind(items, limits, found), "minItems": count, "maxItems": count })
        }
        Kind::List(items) => json!({ "type": "array", "items": of_kind(items, limits, found) }),
        Kind::OneOrEach(count) => {
            let one = of_kind(&Kind::Number, limits, found);
            json!({ "anyOf": [one, of_kind(&Kind::Array(&Kind::Number, *count), limits, found)] })
        }
        Kind::OneOrMany => {
            let one = of_kind(&Kind::Number, limits, found);
            json!({ "anyOf": [one, of_kind(&Kind::List(&Kind::Number), limits, found)] })
        }
        Kind::Optional(inner) => of_kind(inner, limits, found),
        Kind::Open(inner) => {
            let word = json!({ "type": "string", "enum": [Kind::OPEN] });
            json!({ "anyOf": [word, of_kind(inner, limits, found)] })
        }
        Kind::OneOf(name, kinds) => {
            let all = kinds.iter().flat_map(|kind| branches(of_kind(kind, limits, found)));
            let all: Vec<_> = all.collect();
            found.insert((*name).to_owned(), json!({ "anyOf": all }));
            json!({ "$ref": format!("#/definitions/{name}") })
        }
        Kind::Part(schema) => {
            define(schema, found);
            json!({ "$ref": format!("#/definitions/{}", schema.name) })
        }
        Kind::Symmetric(size) => {
            let diagonal = of_kind(&Kind::Array(&Kind::Number, *size), limits, found);
            let rows = json!({ "type": "array", "items": diagonal, "minItems": size, "maxItems": size });
            json!({ "anyOf": [diagonal, rows] })
        }
        Kind::Profile(Kind::OneOrEach(_), table) => {
            let kinds = [Kind::Number, Kind::Array(&Kind::Number, 2), Kind::Part(table)];
            let kinds: Vec<_> = kinds.iter().map(|kind| of_kind(kind, &Limits::NONE, found)).collect();
            found.insert("SizeAlong".to_owned(), json!({ "anyOf": kinds }));
            json!({ "$ref": "#/definitions/SizeAlong" })
        }
        Kind::Profile(values, table) => {
            let mut kinds = branches(of_kind(values, limits, found));
            kinds.push(of_kind(&Kind::Part(table), limits, found));
            json!({ "anyOf": kinds })
        }
        Kind::AlongRod(table) => {
            let one = of_kind(&Kind::Number, limits, found);
            let ends = of_kind(&Kind::Array(&Kind::Number, 2), limits, found);
            let all = [one, ends, of_kind(&Kind::Part(table), limits, found)];
            found.insert("AlongRod".to_owned(), json!({ "anyOf": all }));
            json!({ "$ref": "#/definitions/AlongRod" })
        }
        Kind::Signal("", _, table) => of_kind(&Kind::Part(table), limits, found),
        Kind::Signal(name, constant, table) => {
            let both = [of_kind(constant, limits, found), of_kind(&Kind::Part(table), limits, found)];
            found.insert((*name).to_owned(), json!({ "anyOf": both }));
            json!({ "$ref": format!("#/definitions/{name}") })
        }
    }
}

/// The alternatives that a schema allows.
fn branches(schema: Json) -> Vec<Json> {
    schema["anyOf"].as_array().map_or_else(|| vec![schema.clone()], Clone::clone)
}

/// A default as JSON.
fn in_json(value: &Value) -> Json {
    match value {
        Value::Flag(flag) => (*flag).into(),
        Value::Integer(number) => (*number).into(),
        Value::Number(number) => (*number).into(),
        Value::Text(text) => text.as_str().into(),
        Value::List(items) => items.iter().map(in_json).collect(),
        Value::Rows { numbers, columns } => {
            numbers.chunks((*columns).max(1)).map(|row| row.iter().copied().collect::<Json>()).collect()
        }
        _ => Json::Null,
    }
}
