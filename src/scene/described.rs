//! Tables of scenes that the tables of `description` describe: reading, writing, and their JSON Schema.

use std::borrow::Cow;
use std::marker::PhantomData;

use schemars::{JsonSchema, Schema as JsonSchemaOf, SchemaGenerator};
use serde::Deserialize;
use serde_json::{Map, Value as Json, json};

use super::shape::{Shape, expected_one_of};
use crate::description::{AnyPart, Fault, Field, Kind, Limits, Part, Problem, Reader, Schema, Sign, Value};

/// A table that describes a part, as it stands in the file.
#[derive(Debug, Deserialize)]
#[serde(transparent, bound = "")]
pub(super) struct Written<T> {
    table: toml::Table,
    #[serde(skip)]
    part: PhantomData<T>,
}

impl<T> Written<T> {
    /// The text of a key.
    pub(super) fn text(&self, key: &str) -> Option<&str> {
        self.table.get(key)?.as_str()
    }
}

/// The part that a table at this place describes, checked by itself; `None` after reporting problems.
pub(super) fn read<T: Part>(written: &Written<T>, here: &str, shape: &mut Shape) -> Option<T> {
    let mut reader = Reader::default();
    let found = T::read(&table(&written.table), &mut reader);
    if let Some(part) = &found {
        part.check(&Limits::NONE, &mut reader);
    }
    let problems = reader.finish();
    let is_right = problems.is_empty();
    problems.into_iter().for_each(|problem| report(problem, here, shape));
    found.filter(|_| is_right)
}

fn table(table: &toml::Table) -> Value {
    Value::Table(table.iter().map(|(key, value)| (Cow::Owned(key.clone()), value_of(value))).collect())
}

fn value_of(value: &toml::Value) -> Value {
    match value {
        toml::Value::String(text) => Value::Text(text.clone()),
        toml::Value::Integer(number) => Value::Integer(*number),
        toml::Value::Float(number) => Value::Number(*number),
        toml::Value::Boolean(flag) => Value::Flag(*flag),
        toml::Value::Datetime(_) => Value::Other("a date".to_owned()),
        toml::Value::Array(items) => Value::List(items.iter().map(value_of).collect()),
        toml::Value::Table(inner) => table(inner),
    }
}

/// Reports a problem of the table at this place, except for values that could not be read.
fn report(Problem { place, fault }: Problem, here: &str, shape: &mut Shape) {
    let place = if place.is_empty() { here.to_owned() } else { format!("{here}.{place}") };
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
        Fault::Unknown { known } => ("unknown key".to_owned(), shape.advice(&place, known)),
        Fault::NotTaken { part, taken } => {
            let part = match part.tag {
                "" => part.called.to_owned(),
                tag => format!("{} of kind \"{tag}\"", part.family),
            };
            (format!("{part} does not take it"), format!("remove it: it takes {}", taken.join(", ")))
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
    };
    if shape.is_readable(&place) {
        shape.refuse(&place, wrong, right);
    }
}

/// The keys of the table that describes a part, from which an equal one is read. Keys with their default are left out.
pub fn to_toml(part: &dyn AnyPart) -> String {
    let lines =
        part.given().into_iter().map(|(field, value)| format!("{} = {}\n", field.name, inline(&value)));
    lines.collect()
}

/// A value in TOML.
fn inline(value: &Value) -> String {
    let list =
        |items: &mut dyn Iterator<Item = String>| format!("[{}]", items.collect::<Vec<_>>().join(", "));
    match value {
        Value::Number(number) => toml::Value::Float(*number).to_string(),
        Value::Text(text) => toml::Value::from(text.as_str()).to_string(),
        Value::List(items) => list(&mut items.iter().map(inline)),
        Value::Rows { numbers, columns } => {
            let row = |row: &[f64]| list(&mut row.iter().map(|number| inline(&Value::Number(*number))));
            list(&mut numbers.chunks((*columns).max(1)).map(row))
        }
        Value::Part(part) => {
            let tag = part.schema().tag;
            let kind = (!tag.is_empty()).then(|| format!("kind = \"{tag}\""));
            let given = part.given().into_iter();
            let keys = given.map(|(field, value)| format!("{} = {}", field.name, inline(&value)));
            format!("{{ {} }}", kind.into_iter().chain(keys).collect::<Vec<_>>().join(", "))
        }
        other => other.to_string(),
    }
}

impl<T: Part> JsonSchema for Written<T> {
    fn schema_name() -> Cow<'static, str> {
        T::SCHEMA.name.into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> JsonSchemaOf {
        let definitions = definitions(T::SCHEMA);
        let own = definitions[T::SCHEMA.name].clone();
        generator.definitions_mut().extend(definitions);
        own.try_into().expect("an object is a schema")
    }
}

/// The definitions of the JSON Schema that describe a part and all parts in it, by their names.
pub(crate) fn definitions(schema: &'static Schema) -> Map<String, Json> {
    let mut found = Map::new();
    define(schema, &mut found);
    found
}

fn define(schema: &'static Schema, found: &mut Map<String, Json>) {
    if found.contains_key(schema.name) {
        return;
    }
    // A part that holds others of its kind refers to itself.
    found.insert(schema.name.to_owned(), Json::Null);
    let keys = schema.fields.iter().map(|field| (field.name.to_owned(), of_field(field, found)));
    let mut properties: Map<String, Json> = keys.collect();
    let mut required: Vec<_> =
        schema.fields.iter().filter(|field| field.default.is_none()).map(|field| field.name).collect();
    if !schema.tag.is_empty() {
        let kind = json!({ "description": "Kind of shape.", "type": "string", "enum": [schema.tag] });
        properties.insert("kind".to_owned(), kind);
        required.insert(0, "kind");
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
        Kind::Text | Kind::Reference(_) => json!({ "type": "string" }),
        Kind::Array(items, count) => {
            json!({ "type": "array", "items": of_kind(items, limits, found), "minItems": count, "maxItems": count })
        }
        Kind::List(items) => json!({ "type": "array", "items": of_kind(items, limits, found) }),
        Kind::OneOrEach(count) => {
            let one = of_kind(&Kind::Number, limits, found);
            json!({ "anyOf": [one, of_kind(&Kind::Array(&Kind::Number, *count), limits, found)] })
        }
        Kind::Optional(inner) => of_kind(inner, limits, found),
        Kind::OneOf(name, kinds) => {
            let all: Vec<_> = kinds.iter().map(|kind| of_kind(kind, limits, found)).collect();
            found.insert((*name).to_owned(), json!({ "anyOf": all }));
            json!({ "$ref": format!("#/definitions/{name}") })
        }
        Kind::Part(schema) => {
            define(schema, found);
            json!({ "$ref": format!("#/definitions/{}", schema.name) })
        }
    }
}

/// A default as JSON.
fn in_json(value: &Value) -> Json {
    match value {
        Value::Flag(flag) => (*flag).into(),
        Value::Integer(number) => (*number).into(),
        Value::Number(number) => (*number).into(),
        Value::Text(text) => text.as_str().into(),
        Value::List(items) => items.iter().map(in_json).collect(),
        _ => Json::Null,
    }
}
