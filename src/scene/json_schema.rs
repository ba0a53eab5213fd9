//! The JSON Schema of scene files, for editors.

use serde_json::{Map, Value as Json, json};

use super::document::{Document, VERSION};
use crate::description::schema::{Data, Field, Kind, Limits, Part, Schema, Sign, Value};

/// The JSON Schema of scene files.
pub(super) fn json_schema() -> Json {
    let mut definitions = Map::new();
    of_kind(&Document::KIND, &Limits::NONE, &mut definitions);
    let mut root = definitions.remove(Document::SCHEMA.name).expect("the document has a definition");
    root["$schema"] = "http://json-schema.org/draft-07/schema#".into();
    root["title"] = "lissom scene".into();
    root["properties"]["version"]["minimum"] = VERSION.into();
    root["properties"]["version"]["maximum"] = VERSION.into();
    definitions["Rod"]["properties"]["segment"]["minItems"] = 1.into();
    root["definitions"] = definitions.into();
    root
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

/// A value of one of these kinds.
fn any_of(kinds: &[Kind], limits: &Limits, found: &mut Map<String, Json>) -> Json {
    let all: Vec<_> = kinds.iter().map(|kind| of_kind(kind, limits, found)).collect();
    json!({ "anyOf": all })
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
        Kind::Array(Kind::Array(..), size) => of_kind(&Kind::Symmetric(*size), limits, found),
        Kind::Array(items, count) => {
            json!({ "type": "array", "items": of_kind(items, limits, found), "minItems": count, "maxItems": count })
        }
        Kind::List(items) => of_list(items, limits, found),
        Kind::OneOrEach(count) => any_of(&[Kind::Number, Kind::Array(&Kind::Number, *count)], limits, found),
        Kind::AtRestOrEach(count) => {
            let [two, each] = [2, *count].map(|count| Kind::Array(&Kind::Number, count));
            any_of(&[Kind::Number, two, each], limits, found)
        }
        Kind::OneOrMany => any_of(&[Kind::Number, Kind::List(&Kind::Number)], limits, found),
        Kind::Optional(inner) => of_kind(inner, limits, found),
        Kind::Open(inner) => {
            let word = json!({ "type": "string", "enum": [Kind::OPEN] });
            json!({ "anyOf": [word, of_kind(inner, limits, found)] })
        }
        Kind::OneOf(name, kinds) => {
            let all: Vec<_> = kinds.iter().flat_map(|kind| branches(of_kind(kind, limits, found))).collect();
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

/// A list of values of this kind, which may be in a file if they are numbers or rows of them.
fn of_list(items: &Kind, limits: &Limits, found: &mut Map<String, Json>) -> Json {
    let array = |items| json!({ "type": "array", "items": items });
    let whole = array(match items {
        // A file has all rows of a layer.
        Kind::List(Kind::List(_)) => return array(of_kind(items, limits, found)),
        Kind::List(inner) => array(of_kind(inner, limits, found)),
        items => of_kind(items, limits, found),
    });
    if holds_numbers(items) { json!({ "anyOf": [whole, in_file(found)] }) } else { whole }
}

fn holds_numbers(kind: &Kind) -> bool {
    match kind {
        Kind::Number | Kind::Integer => true,
        Kind::Array(items, _) | Kind::List(items) => holds_numbers(items),
        _ => false,
    }
}

/// An array in a file of its own.
fn in_file(found: &mut Map<String, Json>) -> Json {
    let file = json!({ "description": "Seen from the folder of the scene.", "type": "string" });
    let schema = json!({
        "description": "An array in a file: a row on each line, its numbers separated by commas or blanks.",
        "type": "object", "properties": { "file": file }, "additionalProperties": false, "required": ["file"],
    });
    found.insert("ArrayInFile".to_owned(), schema);
    json!({ "$ref": "#/definitions/ArrayInFile" })
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
