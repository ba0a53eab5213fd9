//! Reading of the parts of a scene, with problems at their places in the file; writing of parts.

use super::advice::advice;
use super::shape::Shape;
use super::written::Written;
use crate::description::schema::{
    AnyPart, Data, Fault, Limits, Part, Problem, Reader, Value, expected_one_of,
};

/// A document as far as it can be read, after reporting problems.
pub(super) fn document<T: Part>(shape: &mut Shape) -> Option<T> {
    let mut reader = Reader::lenient();
    let values = Value::Table(std::mem::take(&mut shape.values));
    let found = T::read(&values, &mut reader);
    if let Value::Table(values) = values {
        shape.values = values;
    }
    let (problems, replaced) = reader.finish_leniently();
    reported(problems, "", shape);
    shape.replaced.extend(replaced);
    found
}

/// The value of a key in the table of a part, if it is valid by itself.
pub(super) fn key_of<T: Part, D: Data>(table: &Value, key: &str) -> Option<D> {
    let field = T::SCHEMA.index(key).map(|i| &T::SCHEMA.fields[i]);
    right_in(table.get(key)?, field.map_or(&Limits::NONE, |field| &field.limits))
}

/// The value, if it is valid.
pub(super) fn right<D: Data>(value: &Value) -> Option<D> {
    right_in(value, &Limits::NONE)
}

fn right_in<D: Data>(value: &Value, limits: &Limits) -> Option<D> {
    let mut reader = Reader::default();
    let found = D::read(value, &mut reader)?;
    found.check(limits, &mut reader);
    reader.problems().is_empty().then_some(found)
}

/// The value written at this place, checked by itself; `None` after reporting problems.
pub(super) fn read<T: Data>(written: &Written<T>, here: &str, shape: &mut Shape) -> Option<T> {
    read_with(written, here, shape, |place| place)
}

/// As [`read`], if places in the value differ from those in the file.
pub(super) fn read_with<T: Data>(
    written: &Written<T>,
    here: &str,
    shape: &mut Shape,
    mut place: impl FnMut(String) -> String,
) -> Option<T> {
    let mut reader = Reader::default();
    let found = T::read(written.value(), &mut reader);
    found.iter().for_each(|found| found.check(&Limits::NONE, &mut reader));
    let problems =
        reader.finish().into_iter().map(|problem| Problem { place: place(problem.place), ..problem });
    reported(problems.collect(), here, shape).and(found)
}

/// Reports problems at this place; `None` if there are some.
pub(super) fn reported(problems: Vec<Problem>, here: &str, shape: &mut Shape) -> Option<()> {
    let is_right = problems.is_empty();
    problems.into_iter().for_each(|problem| report(problem, here, shape));
    is_right.then_some(())
}

/// Reports a problem of the table at this place, except for values that could not be read.
fn report(Problem { place, fault }: Problem, here: &str, shape: &mut Shape) {
    let place = match (here, place.as_str()) {
        (here, "") => here.to_owned(),
        ("", _) => place,
        _ => format!("{here}.{place}"),
    };
    // A key that does not belong there is underlined itself, not its value.
    if let Fault::Unknown { .. } | Fault::NotTaken { .. } = fault
        && let Some(key) = shape.keys.get(&place)
    {
        shape.spans.insert(place.clone(), key.clone());
    }
    let (wrong, right) = match fault {
        Fault::Value { found, expected } => (format!("got {found}"), format!("expected {expected}")),
        Fault::Type { found, expected } => {
            let expected = shape.brackets(&place, &expected).unwrap_or(expected);
            (format!("got {found}"), format!("expected {expected}"))
        }
        Fault::Missing { key, advice } => {
            let is_at_key = place == key || place.ends_with(&format!(".{key}"));
            if !is_at_key && !shape.is_readable(&format!("{place}.{key}")) {
                return;
            }
            let wrong = if is_at_key { "missing".to_owned() } else { format!("{key} is missing") };
            (wrong, format!("add {key}{advice}"))
        }
        Fault::Absent { key, meaning, .. } => ("missing".to_owned(), format!("add {key}: {meaning}")),
        Fault::Unknown { known } => ("unknown key".to_owned(), advice(&place, &known)),
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
