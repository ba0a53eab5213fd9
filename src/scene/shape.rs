//! Validates the structure of a scene (keys, types, sizes, names) against its JSON Schema in one pass.
//!
//! The resulting table can always be deserialised: an unreadable value of an optional key is omitted, an
//! unreadable or missing value of a required key is replaced by the schema's example. The rest can thus be
//! checked too, and the user sees all problems at once.

use std::collections::{BTreeSet, HashMap};
use std::ops::Range;
use std::sync::LazyLock;

use serde_json::Value as Json;
use toml::Spanned;
use toml::de::{DeFloat, DeInteger, DeTable, DeValue};

use super::diagnostics::{Elsewhere, SceneProblem};
use super::imports::FileProblem;
use super::tables::is_described;
use super::words::{self, OldWord};
use crate::description::schema::{expected_one_of, quoted, suggestion};
use crate::error::InvalidInput;

/// What scene files may hold, by which they are checked. A test keeps the file equal to what `document` says: generating it
/// here would make the library a fiftieth larger.
pub(super) static SCHEMA: LazyLock<serde_json::Value> =
    LazyLock::new(|| serde_json::from_str(include_str!("schema.json")).expect("the schema is JSON"));

/// Headers of its tables with a key of this name. A file may have thousands of unknown keys.
static TABLES: LazyLock<HashMap<&'static str, Vec<String>>> = LazyLock::new(|| {
    let mut tables = HashMap::new();
    Reader { root: &SCHEMA, shape: Shape::default() }.find_tables(&SCHEMA, "", false, &mut tables);
    tables
});

/// A document after validation of its structure.
#[derive(Debug, Default)]
pub(super) struct Shape {
    /// The document, with unreadable values omitted or replaced.
    pub(super) table: toml::Table,
    /// Problems found so far.
    pub(super) problems: Vec<SceneProblem>,
    /// Position of each value in the file, by its path.
    pub(super) spans: HashMap<String, Range<usize>>,
    /// Position of the key of each value that `description` reads.
    pub(super) keys: HashMap<String, Range<usize>>,
    /// Paths of omitted or replaced values.
    pub(super) replaced: BTreeSet<String>,
    /// Deprecated keys.
    pub(super) deprecations: Vec<SceneProblem>,
}

impl Shape {
    /// Checks a document against a schema.
    pub(super) fn check(document: &Spanned<DeTable<'_>>, schema: &Json) -> Self {
        let mut reader = Reader { root: schema, shape: Self::default() };
        let table = reader.table(document.get_ref(), schema, "");
        Self { table, ..reader.shape }
    }

    /// Position of a value; if it is absent, of the innermost enclosing value that is present.
    pub(super) fn span(&self, place: &str) -> Range<usize> {
        around(place).find_map(|place| self.spans.get(place)).cloned().unwrap_or_default()
    }

    /// True if the value at `place`, all values in it and all enclosing values could be read.
    pub(super) fn is_readable(&self, place: &str) -> bool {
        let within = |separator: &str| {
            let first = format!("{place}{separator}");
            self.replaced.range(first.clone()..).next().is_some_and(|other| other.starts_with(&first))
        };
        !around(place).any(|place| self.replaced.contains(place)) && !within(".") && !within("[")
    }

    /// Reports a problem with the value at `place`.
    pub(super) fn refuse(&mut self, place: &str, wrong: impl Into<String>, right: impl Into<String>) {
        self.problems.push(self.problem(place, wrong, right));
    }

    /// Reports a problem in a file imported at `place`.
    pub(super) fn refuse_file(&mut self, place: &str, problem: FileProblem) {
        let FileProblem { file, line, column, key, wrong, right, snippet } = problem;
        let elsewhere = Some(Elsewhere { file, snippet });
        let span = self.span(place);
        self.problems.push(SceneProblem { line, column, key, wrong, right, span, elsewhere });
    }

    /// Advice about the unknown key at a place, where these are known.
    pub(super) fn advice(&self, place: &str, known: Vec<&'static str>) -> String {
        let (table, name) = place.rsplit_once('.').unwrap_or(("", place));
        Reader { root: &SCHEMA, shape: Self::default() }.advice(name, known.into_iter(), table).0
    }

    /// Reports a deprecated key.
    fn deprecate(&mut self, place: &str, right: &str) {
        let wrong = "an old name that the next version refuses";
        self.deprecations.push(self.problem(place, wrong, right));
    }

    fn problem(&self, place: &str, wrong: impl Into<String>, right: impl Into<String>) -> SceneProblem {
        let span = self.span(place);
        SceneProblem {
            line: 0,
            column: 0,
            key: place.to_owned(),
            wrong: wrong.into(),
            right: right.into(),
            span,
            elsewhere: None,
        }
    }
}

/// Reports the problems found by a constructor at the keys of the file, except for stand-ins.
pub(super) fn report<T>(
    result: Result<T, InvalidInput>,
    shape: &mut Shape,
    key: impl Fn(&str) -> String,
) -> Option<T> {
    let error = match result {
        Ok(value) => return Some(value),
        Err(error) => error,
    };
    for problem in error.problems {
        let key = key(&problem.place);
        if shape.is_readable(&key) {
            shape.refuse(&key, format!("got {}", problem.found), format!("expected {}", problem.expected));
        }
    }
    None
}

/// A path and those of the enclosing tables and arrays, innermost first.
fn around(place: &str) -> impl Iterator<Item = &str> {
    std::iter::successors(Some(place), |place| place.rfind(['.', '[']).map(|end| &place[..end]))
}

struct Reader<'a> {
    root: &'a Json,
    shape: Shape,
}

impl<'a> Reader<'a> {
    fn table(&mut self, table: &DeTable<'_>, schema: &'a Json, place: &str) -> toml::Table {
        let properties = schema["properties"].as_object().expect("every table of the schema lists its keys");
        let mut read = toml::Table::new();
        let mut old_words = Vec::new();
        for (key, value) in table {
            let mut name = key.get_ref().as_ref();
            if let Some(word) = words::old_word(place, name) {
                let old = join(place, name);
                self.shape.spans.insert(old.clone(), key.span());
                if table.contains_key(word.new) {
                    let wrong = format!("the old name of {}, which is given, too", word.new);
                    self.shape.refuse(&old, wrong, "remove it");
                    continue;
                }
                self.shape.deprecate(&old, word.instead);
                old_words.push(word);
                name = word.new;
            }
            let inner = join(place, name);
            let Some(property) = properties.get(name) else {
                self.shape.spans.insert(inner.clone(), key.span());
                let known = properties.keys().map(String::as_str);
                let (right, meant) = self.advice(name, known, place);
                self.shape.refuse(&inner, "unknown key", right);
                // Neither the misspelt key nor the intended one can be checked further.
                self.shape.replaced.extend(meant.map(|meant| join(place, meant)));
                self.shape.replaced.insert(inner);
                continue;
            };
            // Tables are underlined at their key, because their contents may be spread over the file.
            let span = if is_table_like(value.get_ref()) { key.span() } else { value.span() };
            self.shape.spans.insert(inner.clone(), span);
            match self.value(value, property, &inner) {
                Some(value) => _ = read.insert(name.to_owned(), value),
                None => _ = self.shape.replaced.insert(inner),
            }
        }
        for word in old_words {
            self.adapt(word, &mut read);
        }
        for name in required(schema) {
            if read.contains_key(name) {
                continue;
            }
            let inner = join(place, name);
            let property = &properties[name];
            if !self.shape.replaced.contains(&inner) {
                self.shape.refuse(&inner, "missing", format!("add {name}: {}", sentence(property)));
                self.shape.replaced.insert(inner);
            }
            // What `description` reads needs none.
            let Some(example) = property["examples"].get(0) else { continue };
            let example = toml::Value::try_from(example).expect("examples have TOML's types");
            read.insert(name.to_owned(), example);
        }
        read
    }

    /// Converts the value of an old word in a table.
    fn adapt(&mut self, word: &OldWord, read: &mut toml::Table) {
        if !read.contains_key(word.new) {
            return;
        }
        if let Err([wrong, right]) = (word.adapt)(read) {
            self.shape.refuse(&join(word.table, word.old), wrong, right);
        }
    }

    /// The value in TOML's own types, or `None` after reporting a problem. What `description` reads is only converted, with
    /// the positions of all that is in it; instead of a part there must be a table.
    fn value(&mut self, value: &Spanned<DeValue<'_>>, schema: &'a Json, place: &str) -> Option<toml::Value> {
        let is_described = definition(schema).is_some_and(is_described);
        let schema = self.resolve(schema);
        if is_described && (schema["type"] != "object" || value.get_ref().is_table()) {
            return self.value_as_it_is(value, place);
        }
        if let Some(branches) = schema["anyOf"].as_array() {
            let mut branches = branches.iter().map(|branch| self.resolve(branch));
            // Among several kinds of arrays, the one with the matching item type, if any.
            let accepted = branches.clone().filter(|branch| accepts(branch, value.get_ref()));
            let best = accepted.clone().find(|branch| accepts_first_item(branch, value.get_ref()));
            if let Some(branch) = best.or_else(|| accepted.clone().next()) {
                return self.value(value, branch, place);
            }
            let expected: Vec<String> = branches.by_ref().map(|branch| self.expected(branch)).collect();
            return self.wrong_type(value, place, &expected.join(" or "));
        }
        if let Some(words) = words(schema) {
            return self.word(value, &words, place);
        }
        if !accepts(schema, value.get_ref()) {
            let expected = match value.get_ref() {
                // [[rod.segment]] without [[rod]], or below [rod].
                DeValue::Table(table) if schema["type"] == "array" && has_only_tables(table) => {
                    let header = without_indices(place);
                    let below = table.keys().next().map_or("", |key| key.get_ref().as_ref());
                    let expected = format!("[[{header}]], in double brackets, above [[{header}.{below}]]");
                    return self.wrong_type(value, place, &expected);
                }
                // [rod] instead of [[rod]], the most common mistake in TOML.
                DeValue::Table(_) if schema["type"] == "array" => {
                    format!("double brackets: [[{}]]", without_indices(place))
                }
                DeValue::Array(_) if schema["type"] == "object" => {
                    format!("single brackets: [{}]", without_indices(place))
                }
                _ => self.expected(schema),
            };
            return self.wrong_type(value, place, &expected);
        }
        match value.get_ref() {
            DeValue::Table(table) => Some(self.table(table, schema, place).into()),
            DeValue::Array(array) => self.array(array, schema, place),
            DeValue::Integer(integer) => self.integer(integer, schema, place),
            DeValue::Float(float) => self.float(float, place),
            DeValue::String(text) => Some(text.as_ref().into()),
            DeValue::Boolean(value) => Some((*value).into()),
            DeValue::Datetime(_) => unreachable!("no key of a scene has this type"),
        }
    }

    fn array(&mut self, array: &toml::de::DeArray<'_>, schema: &'a Json, place: &str) -> Option<toml::Value> {
        let least = schema["minItems"].as_u64().unwrap_or(0) as usize;
        let most = schema["maxItems"].as_u64().map_or(usize::MAX, |most| most as usize);
        let mut read = Vec::with_capacity(array.len());
        for (i, item) in array.iter().enumerate() {
            let inner = format!("{place}[{i}]");
            self.shape.spans.insert(inner.clone(), item.span());
            match self.value(item, &schema["items"], &inner) {
                Some(item) => read.push(item),
                None => _ = self.shape.replaced.insert(inner),
            }
        }
        if !(least..=most).contains(&array.len()) {
            let right = format!("expected {}", self.expected(schema));
            self.shape.refuse(place, format!("got an array of {}", array.len()), right);
            return None;
        }
        (read.len() == array.len()).then(|| read.into())
    }

    /// A table with all that is in it; what TOML's own types cannot hold is reported and omitted.
    fn as_it_is(&mut self, table: &DeTable<'_>, place: &str) -> toml::Table {
        let mut read = toml::Table::new();
        for (key, value) in table {
            let inner = join(place, key.get_ref());
            let span = if is_table_like(value.get_ref()) { key.span() } else { value.span() };
            self.shape.spans.insert(inner.clone(), span);
            self.shape.keys.insert(inner.clone(), key.span());
            match self.value_as_it_is(value, &inner) {
                Some(value) => _ = read.insert(key.get_ref().to_string(), value),
                None => _ = self.shape.replaced.insert(inner),
            }
        }
        read
    }

    fn value_as_it_is(&mut self, value: &Spanned<DeValue<'_>>, place: &str) -> Option<toml::Value> {
        match value.get_ref() {
            DeValue::Table(table) => Some(self.as_it_is(table, place).into()),
            DeValue::Array(array) => {
                let mut read = Vec::with_capacity(array.len());
                for (i, item) in array.iter().enumerate() {
                    let inner = format!("{place}[{i}]");
                    self.shape.spans.insert(inner.clone(), item.span());
                    read.extend(self.value_as_it_is(item, &inner));
                }
                (read.len() == array.len()).then(|| read.into())
            }
            DeValue::Integer(integer) => self.whole(integer, place).map(Into::into),
            DeValue::Float(float) => self.float(float, place),
            DeValue::String(text) => Some(text.as_ref().into()),
            DeValue::Boolean(value) => Some((*value).into()),
            DeValue::Datetime(_) => self.wrong_type(value, place, "something else: no key takes a date"),
        }
    }

    fn float(&mut self, float: &DeFloat<'_>, place: &str) -> Option<toml::Value> {
        let number: f64 = float.as_str().parse().unwrap_or(f64::NAN);
        if number.is_infinite() && !float.as_str().contains("inf") {
            let right = "expected a double, at most 1.8e308";
            self.shape.refuse(place, format!("{float} is too large"), right);
            return None;
        }
        Some(number.into())
    }

    fn whole(&mut self, integer: &DeInteger<'_>, place: &str) -> Option<i64> {
        let number = i64::from_str_radix(integer.as_str(), integer.radix()).ok();
        if number.is_none() {
            self.shape.refuse(place, format!("{integer} is too large"), "expected an integer below 9.2e18");
        }
        number
    }

    fn integer(&mut self, integer: &DeInteger<'_>, schema: &'a Json, place: &str) -> Option<toml::Value> {
        let number = self.whole(integer, place)?;
        if schema["type"] == "integer" && number < 0 {
            self.shape.refuse(place, format!("got {number}"), format!("expected {}", self.expected(schema)));
            return None;
        }
        // An integer is valid where a real number is expected.
        Some(if schema["type"] == "integer" { number.into() } else { (number as f64).into() })
    }

    fn word(&mut self, value: &Spanned<DeValue<'_>>, words: &[&str], place: &str) -> Option<toml::Value> {
        let DeValue::String(word) = value.get_ref() else {
            return self.wrong_type(value, place, &quoted(words, " or "));
        };
        if words.contains(&word.as_ref()) {
            return Some(word.as_ref().into());
        }
        self.shape.refuse(place, format!("got \"{word}\""), expected_one_of(word, words));
        None
    }

    fn wrong_type(
        &mut self,
        value: &Spanned<DeValue<'_>>,
        place: &str,
        expected: &str,
    ) -> Option<toml::Value> {
        let found = match value.get_ref() {
            DeValue::String(text) => format!("the text \"{text}\""),
            DeValue::Integer(number) => number.to_string(),
            DeValue::Float(number) => number.to_string(),
            DeValue::Boolean(value) => value.to_string(),
            DeValue::Datetime(_) => "a date".to_owned(),
            DeValue::Array(_) => "an array".to_owned(),
            DeValue::Table(_) => "a table".to_owned(),
        };
        self.shape.refuse(place, format!("got {found}"), format!("expected {expected}"));
        None
    }

    /// Advice about an unknown key, and the known key that it may mean.
    fn advice(
        &self,
        name: &str,
        known: impl Iterator<Item = &'a str> + Clone,
        place: &str,
    ) -> (String, Option<&'a str>) {
        if let Some(similar) = suggestion(name, known.clone()) {
            return (format!("did you mean `{similar}`?"), Some(similar));
        }
        if let Some(elsewhere) = TABLES.get(name) {
            return (format!("it belongs in {}", elsewhere.join(" or ")), None);
        }
        let here = if place.is_empty() { "at the top level" } else { "here" };
        let known: Vec<&str> = known.collect();
        (format!("keys {here} are {}", known.join(", ")), None)
    }

    fn find_tables(
        &self,
        schema: &'a Json,
        path: &str,
        repeated: bool,
        tables: &mut HashMap<&'a str, Vec<String>>,
    ) {
        let schema = self.resolve(schema);
        if let Some(properties) = schema["properties"].as_object() {
            let header = match (path, repeated) {
                ("", _) => "the top level".to_owned(),
                (path, true) => format!("[[{path}]]"),
                (path, false) => format!("[{path}]"),
            };
            for (key, property) in properties {
                tables.entry(key).or_default().push(header.clone());
                self.find_tables(property, &join(path, key), false, tables);
            }
        } else if schema["type"] == "array" {
            self.find_tables(&schema["items"], path, true, tables);
        }
    }

    /// Resolves references in the schema.
    fn resolve(&self, mut schema: &'a Json) -> &'a Json {
        loop {
            if let Some(reference) = schema["$ref"].as_str() {
                let pointer = reference.trim_start_matches('#');
                schema = self.root.pointer(pointer).expect("the schema's references lead somewhere");
            } else if let Some([only]) = schema["allOf"].as_array().map(Vec::as_slice) {
                schema = only;
            } else {
                return schema;
            }
        }
    }

    /// Describes what a schema expects.
    fn expected(&self, schema: &'a Json) -> String {
        let schema = self.resolve(schema);
        if let Some(words) = words(schema) {
            return quoted(&words, " or ");
        }
        match schema["type"].as_str() {
            Some("number") => "a number".to_owned(),
            Some("integer") => "an integer >= 0".to_owned(),
            Some("string") => "text in quotes".to_owned(),
            Some("boolean") => "true or false".to_owned(),
            Some("object") => "a table".to_owned(),
            Some("array") => {
                let items = self.resolve(&schema["items"]);
                let items = match (words(items), items["type"].as_str()) {
                    (Some(words), _) => format!("words out of {}", words.join(", ")),
                    (None, Some("number")) => "numbers".to_owned(),
                    (None, Some("array")) => "rows".to_owned(),
                    _ if items["anyOf"].is_array() => "entries".to_owned(),
                    _ => "tables".to_owned(),
                };
                match (schema["minItems"].as_u64(), schema["maxItems"].as_u64()) {
                    (_, Some(count)) => format!("an array of {count} {items}"),
                    (Some(least), None) => format!("an array of at least {least} of the {items}"),
                    (None, None) => format!("an array of {items}"),
                }
            }
            _ => "another type".to_owned(),
        }
    }
}

/// Name of the definition to which a schema refers.
fn definition(schema: &Json) -> Option<&str> {
    let reference = schema["$ref"].as_str().or_else(|| schema["allOf"][0]["$ref"].as_str());
    reference?.strip_prefix("#/definitions/")
}

/// True if the type of `value` matches the schema.
fn accepts(schema: &Json, value: &DeValue<'_>) -> bool {
    match schema["type"].as_str() {
        Some("number") => value.is_float() || value.is_integer(),
        Some("integer") => value.is_integer(),
        Some("string") => value.is_str(),
        Some("boolean") => value.is_bool(),
        Some("array") => value.is_array(),
        Some("object") => value.is_table(),
        _ => false,
    }
}

/// True if an array is empty or its first item has the type required by the schema.
fn accepts_first_item(schema: &Json, value: &DeValue<'_>) -> bool {
    let first = value.as_array().and_then(|array| array.first());
    first.is_none_or(|item| accepts(&schema["items"], item.get_ref()))
}

/// True for tables and arrays of tables.
fn is_table_like(value: &DeValue<'_>) -> bool {
    match value {
        DeValue::Table(_) => true,
        DeValue::Array(array) => array.first().is_some_and(|item| item.get_ref().is_table()),
        _ => false,
    }
}

/// Values of an enumeration.
fn words(schema: &Json) -> Option<Vec<&str>> {
    if let Some(branches) = schema["oneOf"].as_array() {
        return branches.iter().map(|branch| branch["const"].as_str()).collect();
    }
    schema["enum"].as_array()?.iter().map(Json::as_str).collect()
}

fn required(schema: &Json) -> impl Iterator<Item = &str> {
    schema["required"].as_array().into_iter().flatten().filter_map(Json::as_str)
}

/// First sentence of a schema's description.
fn sentence(schema: &Json) -> String {
    let description = schema["description"].as_str().unwrap_or("required");
    description.split_once(". ").map_or(description, |(first, _)| first).trim_end_matches('.').to_owned()
}

/// Whether a table has no other content than arrays of tables.
fn has_only_tables(table: &DeTable<'_>) -> bool {
    let is_of_tables = |value: &Spanned<DeValue<'_>>| match value.get_ref() {
        DeValue::Array(array) => array.iter().any(|item| matches!(item.get_ref(), DeValue::Table(_))),
        _ => false,
    };
    !table.is_empty() && table.values().all(is_of_tables)
}

/// The path as in the header of a table, without indices.
fn without_indices(place: &str) -> String {
    place.split('.').map(|key| key.split('[').next().unwrap_or(key)).collect::<Vec<_>>().join(".")
}

fn join(place: &str, key: &str) -> String {
    if place.is_empty() { key.to_owned() } else { format!("{place}.{key}") }
}
