//! Advice about unknown keys.

use std::collections::HashMap;
use std::sync::LazyLock;

use super::document::Document;
use super::shape::join;
use crate::description::schema::{Kind, Part, Schema, did_you_mean};

/// Headers of the tables with a key of this name. A file may have thousands of unknown keys.
static TABLES: LazyLock<HashMap<&'static str, Vec<String>>> = LazyLock::new(|| {
    let mut tables = HashMap::new();
    find_tables(Document::SCHEMA, "", false, &mut tables);
    tables
});

/// Keys by which other programs are told their units.
const OF_UNITS: [&str; 5] = ["units", "unit", "unit_system", "length_unit", "length_units"];

/// Advice about an unknown key at a place, where these are known.
pub(super) fn advice(place: &str, known: &[&'static str]) -> String {
    let (table, name) = place.rsplit_once('.').unwrap_or(("", place));
    if OF_UNITS.contains(&name) {
        return "leave it out: all numbers are in SI units (metres, kilograms, seconds, newtons, pascals, radians)".to_owned();
    }
    if let Some(meant) = did_you_mean(name, known.iter().copied(), "`") {
        return meant;
    }
    if let Some(elsewhere) = TABLES.get(name) {
        return format!("it belongs in {}", elsewhere.join(" or "));
    }
    format!("keys {} are {}", if table.is_empty() { "at the top level" } else { "here" }, known.join(", "))
}

/// Adds the headers of a table and of those in it, by their keys.
fn find_tables(
    schema: &'static Schema,
    path: &str,
    repeated: bool,
    tables: &mut HashMap<&'static str, Vec<String>>,
) {
    let header = match (path, repeated) {
        ("", _) => "the top level".to_owned(),
        (path, true) => format!("[[{path}]]"),
        (path, false) => format!("[{path}]"),
    };
    let mut fields: Vec<_> = schema.keys().collect();
    fields.sort_by_key(|field| field.name);
    for field in fields {
        tables.entry(field.name).or_default().push(header.clone());
        let (kind, repeated) = match field.kind {
            Kind::List(items) => (*items, true),
            Kind::Optional(inner) => (*inner, false),
            kind => (kind, false),
        };
        if let Kind::Part(inner) | Kind::Signal("", _, inner) = kind {
            find_tables(inner, &join(path, field.name), repeated, tables);
        }
    }
}
