//! Reading and checking: the place of a value, and all problems.

use std::fmt::{self, Write as _};

use super::data::{AnyPart, Data, Fault, Field, Kind, Problem, Reader, Schema, Step, Value};
use super::suggestion::{or_meant, quoted, suggestion};
use crate::error::{self, Checker};
use crate::numerics::lie::QUATERNION_TOLERANCE;

impl From<Problem> for error::Problem {
    fn from(Problem { mut place, fault }: Problem) -> Self {
        let listed = |words: &[&str]| words.join(", ");
        if let Fault::Missing { key, .. } = fault
            && !place.ends_with(key)
        {
            place = if place.is_empty() { key.to_owned() } else { format!("{place}.{key}") };
        }
        let (found, expected) = match fault {
            Fault::Value { found, expected } | Fault::Type { found, expected } => (found, expected),
            Fault::Missing { key, advice } => ("None".to_owned(), format!("{key}{advice}")),
            Fault::Absent { expected, .. } => ("none".to_owned(), expected.to_owned()),
            Fault::Unknown { known } => {
                let word = place.rsplit(['.', ']']).next().unwrap_or(&place);
                let meant = or_meant(word, known.iter().copied());
                ("an unknown name".to_owned(), format!("one of {}{meant}", listed(&known)))
            }
            Fault::NotTaken { part, taken } => {
                (format!("what {} does not take", part.called), format!("one of {}", listed(&taken)))
            }
            Fault::Undecided { key, tags, .. } => {
                (format!("neither {key} nor kind"), format!("{key}, or a kind out of {}", listed(&tags)))
            }
            Fault::Other { wrong, right } => (wrong, right),
            Fault::NoneOf(keys) => {
                place = if place.is_empty() { keys[0].to_owned() } else { format!("{place}.{}", keys[0]) };
                (format!("neither {}", keys.join(" nor ")), "one of them".to_owned())
            }
            Fault::Both([first, second]) => (format!("both {first} and {second}"), "one of them".to_owned()),
            Fault::Without { key, needed, meaning } => {
                place = format!("{}{needed}", place.strip_suffix(key).unwrap_or(&place));
                ("none".to_owned(), meaning.to_owned())
            }
            Fault::Unused { found, belongs } => (found, format!("none: {belongs}")),
            Fault::Name { python: [found, expected], .. } => (found, expected),
            Fault::Failed => ("a failure".to_owned(), "a function that returns numbers".to_owned()),
            Fault::Word { found, words } => {
                let known: Vec<_> = words.iter().map(|word| format!("'{word}'")).collect();
                let meant = or_meant(&found, words.iter().copied());
                (format!("'{found}'"), format!("{}{meant}", known.join(" or ")))
            }
            Fault::Tag { found, tags } => (format!("\"{found}\""), format!("one of {}", listed(&tags))),
        };
        Self { place, found, expected }
    }
}

/// The key by which tables choose among parts, if any of them has a tag.
fn tag_key(kinds: &[Kind]) -> Option<&'static str> {
    kinds.iter().filter_map(Kind::schema).find(|part| !part.tag.is_empty()).map(|part| part.tag_key)
}

/// The table to write where a text stands: that of the part whose tag it is, or is spelt alike.
fn table_meant(value: &Value, kinds: &[Kind]) -> Option<String> {
    let Value::Text(word) = value else { return None };
    let tags = kinds.iter().filter_map(Kind::schema).map(|part| part.tag).filter(|tag| !tag.is_empty());
    let (key, tag) = (tag_key(kinds)?, suggestion(word, tags)?);
    Some(format!("a table, such as {{ {key} = \"{tag}\" }}"))
}

impl Reader {
    /// A reader that replaces fields it cannot read by their default or [stand-in](super::Limits::stand_in), so that others can be read.
    pub fn lenient() -> Self {
        Self { replaced: Some(Vec::new()), ..Self::default() }
    }

    /// All problems of a lenient reader, and the places of replaced fields.
    pub fn finish_leniently(self) -> (Vec<Problem>, Vec<String>) {
        (self.problems, self.replaced.unwrap_or_default())
    }

    /// The problems found so far.
    pub fn problems(&self) -> &[Problem] {
        &self.problems
    }

    /// Whether all keys were known; otherwise what seems to be left out may have been given by another name.
    pub fn is_complete(&self) -> bool {
        !self.problems.iter().any(|problem| matches!(problem.fault, Fault::Unknown { .. }))
    }

    /// All problems.
    pub fn finish(self) -> Vec<Problem> {
        self.problems
    }

    /// Reports a fault at a key here, or at this place if the key is empty.
    pub fn refuse(&mut self, key: &str, fault: Fault) {
        let place = self.place_of(key);
        self.problems.push(Problem { place, fault });
    }

    /// The path of a key here.
    fn place_of(&self, key: &str) -> String {
        let mut place = String::new();
        for step in &self.place {
            _ = match step {
                Step::Key(key) if place.is_empty() => write!(place, "{key}"),
                Step::Key(key) => write!(place, ".{key}"),
                Step::Index(i) => write!(place, "[{i}]"),
            };
        }
        let dot = if place.is_empty() || key.is_empty() || key.starts_with(['[', '.']) { "" } else { "." };
        format!("{place}{dot}{key}")
    }

    /// Reports a value at a key here, or at this place if the key is empty, unless `ok`.
    pub fn require(&mut self, ok: bool, key: &str, found: impl fmt::Display, expected: &str) -> bool {
        if !ok {
            let fault = Fault::Value { found: found.to_string(), expected: expected.to_owned() };
            self.refuse(key, fault);
        }
        ok
    }

    /// Adds the problems that a checker found at this place, except at places that already have one.
    pub fn nested(&mut self, checker: Checker) {
        let before = self.problems.len();
        for problem in checker.finish().err().into_iter().flat_map(|error| error.problems) {
            let place = self.place_of(&problem.place);
            if self.problems[..before].iter().any(|known| known.place == place) {
                continue;
            }
            self.require(false, &problem.place, problem.found, &problem.expected);
        }
    }

    /// Reports a value of another type than its place requires.
    pub fn wrong_type<T>(&mut self, value: &Value, kind: &Kind) -> Option<T> {
        let kinds = if let Kind::OneOf(_, kinds) = kind { kinds } else { std::slice::from_ref(kind) };
        self.wrong_type_of(value, kind, kinds)
    }

    /// The same for a value that may be one of several parts.
    fn wrong_type_of<T>(&mut self, value: &Value, kind: &Kind, kinds: &[Kind]) -> Option<T> {
        let expected = table_meant(value, kinds).unwrap_or_else(|| kind.words());
        self.refuse("", Fault::Type { found: value.to_string(), expected });
        None
    }

    fn at<T>(&mut self, step: Step, run: impl FnOnce(&mut Self) -> T) -> T {
        self.place.push(step);
        let made = run(self);
        self.place.pop();
        made
    }

    /// Reads or checks an item of a list.
    pub fn at_item<T>(&mut self, index: usize, run: impl FnOnce(&mut Self) -> T) -> T {
        self.at(Step::Index(index), run)
    }

    /// Reads or checks what is at a key.
    pub fn at_key<T>(&mut self, key: &'static str, run: impl FnOnce(&mut Self) -> T) -> T {
        self.at(Step::Key(key), run)
    }

    /// Reads a field; a value that is absent is the default.
    pub fn field<T: Data>(&mut self, field: &'static Field, value: Option<&Value>) -> Option<T> {
        let found = match (value, field.default) {
            (Some(value), _) => self.at(Step::Key(field.name), |reader| T::read(value, reader)),
            (None, Some(default)) => T::read(&default(), self),
            (None, None) => None,
        };
        if found.is_none() && self.replaced.is_some() {
            self.replace(field.name);
            let stand_in = field.limits.stand_in.or(field.default)?;
            return T::read(&stand_in(), self);
        }
        found
    }

    /// Notes that something else stands at a key.
    fn replace(&mut self, key: &str) {
        let place = self.place_of(key);
        self.replaced.iter_mut().for_each(|replaced| replaced.push(place.clone()));
    }

    /// Checks a field.
    pub fn check<T: Data>(&mut self, field: &'static Field, value: &T) {
        self.at(Step::Key(field.name), |reader| value.check(&field.limits, reader));
    }

    /// Reports fields that are given without those that they need.
    pub fn check_needs(&mut self, part: &dyn AnyPart) {
        let schema = part.schema();
        for (i, field) in schema.fields.iter().enumerate() {
            let Some(needed) = schema.index(field.limits.needs) else { continue };
            let value = part.field(i);
            if value != Value::None && part.field(needed) == Value::None {
                let found = format!("{value} without a {}", field.limits.needs);
                self.require(false, field.name, found, "None: the shape is fixed in the world");
            }
        }
    }

    /// Reports that none of the fields is given of which one has to be.
    pub fn check_given(&mut self, schema: &'static Schema, values: &[Option<Value>]) {
        let is_given =
            |key: &&str| schema.index(key).is_some_and(|i| !matches!(values[i], None | Some(Value::None)));
        if !schema.some_of.is_empty() && !schema.some_of.iter().any(is_given) {
            self.refuse("", Fault::NoneOf(schema.some_of));
        }
    }

    /// Reports fields that exclude each other.
    pub fn check_exclusive<A, B>(&mut self, keys: [&'static str; 2], first: &Option<A>, second: &Option<B>) {
        if first.is_some() && second.is_some() {
            self.refuse(keys[1], Fault::Both(keys));
        }
    }

    /// Reports a field that is given, although it has no effect beside the other ones.
    pub fn check_unused(&mut self, key: &str, value: Option<impl fmt::Display>, belongs: &'static str) {
        if let Some(value) = value {
            self.refuse(key, Fault::Unused { found: value.to_string(), belongs });
        }
    }

    /// Reports two arc lengths that do not increase, at the key of the second one; invalid arc lengths are reported elsewhere.
    pub fn check_interval(&mut self, key: &str, [from, to]: [f64; 2]) {
        if [from, to].iter().all(|x| x.is_finite() && *x >= 0.0) {
            self.require(from < to, key, to, &format!("an arc length > along[0] = {from} (metres)"));
        }
    }

    /// Reports an `orientation` that is no unit quaternion; entries that are not finite are reported elsewhere.
    pub fn check_orientation(&mut self, orientation: &[f64; 4]) {
        let norm = orientation.iter().map(|x| x * x).sum::<f64>().sqrt();
        if norm.is_finite() {
            self.require(
                (norm - 1.0).abs() <= QUATERNION_TOLERANCE,
                "orientation",
                format_args!("a quaternion of norm {norm}"),
                "a quaternion (w, x, y, z) of norm 1",
            );
        }
    }

    /// Which of several words a value is.
    pub fn word(&mut self, kind: &Kind, value: &Value) -> Option<usize> {
        let (Kind::Word(_, words), Value::Text(found)) = (kind, value) else {
            return self.wrong_type(value, kind);
        };
        let place = words.iter().position(|word| word == found);
        if place.is_none() {
            self.refuse("", Fault::Word { found: found.clone(), words });
        }
        place
    }

    /// The values of the fields in their order, with problems for unknown keys and missing ones.
    pub fn open(&mut self, schema: &'static Schema, value: &Value) -> Option<Vec<Option<Value>>> {
        let alternatives = std::mem::take(&mut self.alternatives);
        let Value::Table(pairs) = value else {
            return self.wrong_type_of(value, &Kind::Part(schema), alternatives);
        };
        let is_given = |key: &str| pairs.iter().any(|(name, _)| name == key);
        let mut found = vec![None; schema.fields.len()];
        let mut meant = Vec::new();
        let tag_key = tag_key(alternatives);
        for (key, value) in pairs {
            let taken = || {
                let needed = |field: &&Field| field.limits.needs.is_empty() || is_given(field.limits.needs);
                schema.keys().filter(needed).map(|field| field.name)
            };
            if let Some(i) = schema.index(key).filter(|_| taken().any(|name| name == key)) {
                found[i] = Some(value.clone());
            } else if tag_key != Some(key.as_ref()) {
                let others = || alternatives.iter().filter_map(Kind::schema);
                if others().any(|other| other.index(key).is_some()) {
                    self.refuse(key, Fault::NotTaken { part: schema, taken: taken().collect() });
                } else {
                    let known: Vec<_> = taken().chain(tag_key).collect();
                    let similar = suggestion(key, known.iter().copied());
                    // Neither the misspelt key nor the intended one can be checked further.
                    similar.into_iter().chain([key.as_ref()]).for_each(|key| self.replace(key));
                    meant.extend(similar);
                    self.refuse(key, Fault::Unknown { known });
                }
            }
        }
        if !schema.some_of.iter().any(|key| meant.contains(key)) {
            self.check_given(schema, &found);
        }
        for (field, value) in schema.fields.iter().zip(&found) {
            if value.is_none() && field.default.is_none() && !meant.contains(&field.name) {
                let place = if alternatives.is_empty() { field.name } else { "" };
                let advice = format!(": {}", field.summary());
                self.refuse(place, Fault::Missing { key: field.name, advice });
                self.replace(field.name);
            }
        }
        Some(found)
    }

    /// Index of the kind of a value among several; tables are chosen by `kind`.
    pub fn choose(&mut self, kind: &'static Kind, value: &Value) -> Option<usize> {
        let Kind::OneOf(_, kinds) = kind else { return None };
        let with = |fits: &dyn Fn(&'static Schema) -> bool| {
            kinds.iter().position(|kind| kind.schema().is_some_and(fits))
        };
        let tags = || kinds.iter().filter_map(Kind::schema).map(|schema| schema.tag);
        let tags = || tags().filter(|tag| !tag.is_empty()).collect::<Vec<_>>();
        let key = tag_key(kinds).unwrap_or("kind");
        let found = match value {
            Value::Part(part) => with(&|schema| std::ptr::eq(schema, part.schema())),
            Value::Text(_) => kinds.iter().position(|kind| matches!(kind, Kind::Text | Kind::Reference(_))),
            Value::Table(pairs) => {
                self.alternatives = kinds;
                match pairs.iter().find(|(name, _)| name == key) {
                    None => {
                        // Without `kind`: the one whose first required key is given, or the one that requires none.
                        let is_given = |field: &Field| pairs.iter().any(|(key, _)| key == field.name);
                        let decisive = |schema: &Schema| schema.keys().find(|field| field.default.is_none());
                        let found =
                            with(&|schema| schema.tag.is_empty() && decisive(schema).is_some_and(is_given));
                        let found = found
                            .or_else(|| with(&|schema| schema.tag.is_empty() && decisive(schema).is_none()));
                        if found.is_none() {
                            let untagged = with(&|schema| schema.tag.is_empty());
                            let field = untagged.and_then(|i| decisive(kinds[i].schema()?));
                            self.refuse(
                                "",
                                match field.map(|field| (field.name, field.summary())) {
                                    Some((key, meaning)) => Fault::Undecided { key, meaning, tags: tags() },
                                    None => Fault::Missing {
                                        key,
                                        advice: format!(": {}", quoted(&tags(), " or ")),
                                    },
                                },
                            );
                            return None;
                        }
                        found
                    }
                    Some((_, Value::Text(tag))) => {
                        let found = with(&|schema| schema.tag == tag && !tag.is_empty());
                        if found.is_none() {
                            self.refuse(key, Fault::Tag { found: tag.clone(), tags: tags() });
                        }
                        return found;
                    }
                    Some((_, other)) => {
                        let expected = quoted(&tags(), " or ");
                        self.refuse(key, Fault::Type { found: other.to_string(), expected });
                        return None;
                    }
                }
            }
            _ => None,
        };
        found.or_else(|| self.wrong_type(value, kind))
    }
}
