//! The values of a scene file with their places in the text, and the problems found so far.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::ops::Range;

use toml::Spanned;
use toml::de::{DeFloat, DeInteger, DeTable, DeValue};

use super::diagnostics::{Elsewhere, SceneProblem};
use super::imports::{FileProblem, Imports, Refusal};
use super::{arrays, words};
use crate::description::schema::{Kind, Value};
use crate::error::InvalidInput;

/// State of a document while it is read.
#[derive(Debug, Default)]
pub(super) struct Shape {
    /// The values, without those that are reported and omitted.
    pub(super) values: Vec<(Cow<'static, str>, Value)>,
    /// Problems found so far.
    pub(super) problems: Vec<SceneProblem>,
    /// Position of each value in the file, by its path.
    pub(super) spans: HashMap<String, Range<usize>>,
    /// Position of the key of each value.
    pub(super) keys: HashMap<String, Range<usize>>,
    /// Paths of omitted or replaced values.
    pub(super) replaced: BTreeSet<String>,
    /// Deprecated keys.
    pub(super) deprecations: Vec<SceneProblem>,
    /// The contents of files that the scene names, by their names.
    pub(super) files: BTreeMap<String, Vec<u8>>,
}

impl Shape {
    /// All values of a document, with arrays from files.
    pub(super) fn of(document: &Spanned<DeTable<'_>>, imports: &mut dyn Imports) -> Self {
        let mut shape = Self::default();
        shape.values = shape.table(document.get_ref(), "", imports);
        shape
    }

    /// The bytes of a file that the value at `place` names, and what would be right there.
    pub(super) fn content(
        &mut self,
        [file, right]: [&str; 2],
        place: &str,
        imports: &mut dyn Imports,
    ) -> Option<Vec<u8>> {
        if let Some(known) = self.files.get(file) {
            return Some(known.clone());
        }
        let content = self.taken(imports.read(file), place, right)?;
        self.files.insert(file.to_owned(), content.clone());
        Some(content)
    }

    /// The contents of a file; `None` after reporting its problems at `place`.
    pub(super) fn taken<T>(&mut self, found: Result<T, Refusal>, place: &str, right: &str) -> Option<T> {
        match found {
            Ok(found) => return Some(found),
            Err(Refusal::Unreadable(why)) => self.refuse(place, why, format!("expected {right}")),
            Err(Refusal::Wrong(problems)) => {
                problems.into_iter().for_each(|problem| self.refuse_file(place, problem));
            }
        }
        None
    }

    /// The array in a file.
    fn array_of(&mut self, file: &str, place: &str, imports: &mut dyn Imports) -> Option<Value> {
        let right = "a file with rows of numbers, seen from the folder of the scene";
        let content = self.content([file, right], place, imports)?;
        let read = match str::from_utf8(&content) {
            Ok(text) => arrays::read(text, file).map_err(|problem| Refusal::Wrong(vec![*problem])),
            Err(_) => Err(Refusal::Unreadable("not text in UTF-8".to_owned())),
        };
        self.taken(read, place, right)
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

    /// The values of a table, old words under their new names. What a value cannot hold is reported and omitted.
    fn table(
        &mut self,
        table: &DeTable<'_>,
        place: &str,
        imports: &mut dyn Imports,
    ) -> Vec<(Cow<'static, str>, Value)> {
        let mut read = Vec::with_capacity(table.len());
        let mut old_words = Vec::new();
        for (key, value) in table {
            let mut name = named(key.get_ref());
            if let Some(word) = words::old_word(place, name) {
                let old = join(place, name);
                self.spans.insert(old.clone(), key.span());
                if table.contains_key(word.new) {
                    let wrong = format!("the old name of {}, which is given, too", word.new);
                    self.refuse(&old, wrong, "remove it");
                    continue;
                }
                self.deprecate(&old, word.instead);
                old_words.push(word);
                name = word.new;
            }
            let inner = join(place, name);
            // Tables are underlined at their key, because their contents may be spread over the file.
            let span = if is_table_like(value.get_ref()) { key.span() } else { value.span() };
            self.spans.insert(inner.clone(), span);
            self.keys.insert(inner.clone(), key.span());
            match self.value(value, &inner, imports) {
                Some(value) => read.push((Cow::Owned(name.to_owned()), value)),
                None => _ = self.replaced.insert(inner),
            }
        }
        for word in old_words {
            if self.is_readable(&join(place, word.new))
                && let Err([wrong, right]) = (word.adapt)(&mut read)
            {
                self.refuse(&join(word.table, word.old), wrong, right);
            }
        }
        read
    }

    fn value(
        &mut self,
        value: &Spanned<DeValue<'_>>,
        place: &str,
        imports: &mut dyn Imports,
    ) -> Option<Value> {
        match value.get_ref() {
            DeValue::Table(table) => match arrays::file_of(table) {
                Some(file) => self.array_of(file, place, imports),
                None => Some(Value::Table(self.table(table, place, imports))),
            },
            DeValue::Array(array) => {
                let mut read = Vec::with_capacity(array.len());
                for (i, item) in array.iter().enumerate() {
                    let inner = format!("{place}[{i}]");
                    self.spans.insert(inner.clone(), item.span());
                    read.extend(self.value(item, &inner, imports));
                }
                (read.len() == array.len()).then_some(Value::List(read))
            }
            DeValue::Integer(integer) => self.whole(integer, place).map(Value::Integer),
            DeValue::Float(float) => self.float(float, place).map(Value::Number),
            DeValue::String(text) => Some(Value::Text(text.as_ref().to_owned())),
            DeValue::Boolean(value) => Some(Value::Flag(*value)),
            DeValue::Datetime(_) => Some(Value::Other("a date".to_owned())),
        }
    }

    fn float(&mut self, float: &DeFloat<'_>, place: &str) -> Option<f64> {
        let number: f64 = float.as_str().parse().unwrap_or(f64::NAN);
        if number.is_infinite() && !float.as_str().contains("inf") {
            let right = "expected a double, at most 1.8e308";
            self.refuse(place, format!("{float} is too large"), right);
            return None;
        }
        Some(number)
    }

    fn whole(&mut self, integer: &DeInteger<'_>, place: &str) -> Option<i64> {
        let number = i64::from_str_radix(integer.as_str(), integer.radix()).ok();
        if number.is_none() {
            self.refuse(place, format!("{integer} is too large"), "expected an integer below 9.2e18");
        }
        number
    }

    /// The value at a path.
    fn at(&self, place: &str) -> Option<&Value> {
        let mut keys = place.split('.');
        let (first, indices) = split_indices(keys.next()?);
        let (_, value) = self.values.iter().find(|(name, _)| name == first)?;
        let mut value = item_of(value, indices)?;
        for key in keys {
            let (name, indices) = split_indices(key);
            value = item_of(value.get(name)?, indices)?;
        }
        Some(value)
    }

    /// Advice about the brackets of a table header at `place`, which should be of this kind: the most common mistake in TOML.
    pub(super) fn brackets(&self, place: &str, expected: &str) -> Option<String> {
        let header = without_indices(place);
        match self.at(place)? {
            // [[rod.segment]] without [[rod]], or below [rod].
            Value::Table(pairs) if expected == Kind::TABLES && has_only_tables(pairs) => {
                let (below, _) = pairs.first()?;
                Some(format!("[[{header}]], in double brackets, above [[{header}.{below}]]"))
            }
            // [rod] instead of [[rod]].
            Value::Table(_) if expected == Kind::TABLES => Some(format!("double brackets: [[{header}]]")),
            // [[rod.base]] instead of [rod.base].
            Value::List(items) if expected == Kind::TABLE && !place.ends_with(']') => {
                let is_table = |item: &Value| matches!(item, Value::Table(_));
                (!items.is_empty() && items.iter().all(is_table))
                    .then(|| format!("single brackets: [{header}]"))
            }
            _ => None,
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

/// True for tables and arrays of tables.
fn is_table_like(value: &DeValue<'_>) -> bool {
    match value {
        DeValue::Table(_) => true,
        DeValue::Array(array) => array.first().is_some_and(|item| item.get_ref().is_table()),
        _ => false,
    }
}

/// Whether a table has no other content than arrays of tables.
fn has_only_tables(pairs: &[(Cow<'static, str>, Value)]) -> bool {
    let is_of_tables = |value: &Value| match value {
        Value::List(items) => items.iter().any(|item| matches!(item, Value::Table(_))),
        _ => false,
    };
    !pairs.is_empty() && pairs.iter().all(|(_, value)| is_of_tables(value))
}

/// A key as messages show it: an empty one in its quotes.
fn named(key: &str) -> &str {
    if key.is_empty() { "\"\"" } else { key }
}

/// A key and the indices behind it: `segment` and `[1]`.
fn split_indices(key: &str) -> (&str, &str) {
    key.split_at(key.find('[').unwrap_or(key.len()))
}

/// The item at indices such as `[1][0]`.
fn item_of<'a>(value: &'a Value, indices: &str) -> Option<&'a Value> {
    let indices = indices.split(['[', ']']).filter(|index| !index.is_empty());
    indices.map(str::parse::<usize>).try_fold(value, |value, index| match value {
        Value::List(items) => items.get(index.ok()?),
        _ => None,
    })
}

/// The path as in the header of a table, without indices.
fn without_indices(place: &str) -> String {
    place.split('.').map(|key| split_indices(key).0).collect::<Vec<_>>().join(".")
}

pub(super) fn join(place: &str, key: &str) -> String {
    if place.is_empty() { key.to_owned() } else { format!("{place}.{key}") }
}
