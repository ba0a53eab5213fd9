//! Deprecated keys of the format, which are still read with a note about the new name.

use std::borrow::Cow;

use serde_json::{Value as Json, json};

use crate::description::schema::{Data as _, Reader, Value};

/// The values of a table by their keys.
type Pairs = Vec<(Cow<'static, str>, Value)>;

/// A renamed key.
#[derive(Debug)]
pub(super) struct OldWord {
    /// Path of its table, without indices.
    pub(super) table: &'static str,
    /// The old name.
    pub(super) old: &'static str,
    /// The new name, in the same table.
    pub(super) new: &'static str,
    /// The current name, for messages.
    pub(super) instead: &'static str,
    /// Converts the table, in which the value already has its new name, to the meaning of the old key; an
    /// error contains what is wrong and what would be right.
    pub(super) adapt: fn(&mut Pairs) -> Result<(), [&'static str; 2]>,
}

/// All renamed keys. The names in Python are the current ones.
pub(super) const OLD_WORDS: [OldWord; 5] = [
    OldWord {
        table: "simulation",
        old: "duration",
        new: "t_end",
        instead: "write t_end, the time at the end: duration later than t0",
        adapt: |settings| {
            let number = |key: &str| {
                let (_, value) = settings.iter().find(|(name, _)| name == key)?;
                f64::read(value, &mut Reader::default())
            };
            if let Some(t_end) = number("t_end") {
                let t_end = t_end + number("t0").unwrap_or_default();
                settings.retain(|(name, _)| name != "t_end");
                settings.push(("t_end".into(), Value::Number(t_end)));
            }
            Ok(())
        },
    },
    OldWord { old: "step", new: "dt", instead: "write dt", ..SAME },
    OldWord { old: "jacobian", new: "jac", instead: "write jac", ..SAME },
    OldWord {
        table: "simulation",
        old: "tolerance",
        new: "rtol",
        instead: "write rtol, with method = \"auto\"",
        // The old key also selected the method.
        adapt: |settings| {
            let auto = Value::Text("auto".to_owned());
            let method = settings.iter().find(|(name, _)| name == "method").map(|(_, value)| value);
            let is_auto = method.is_none_or(|method| *method == auto);
            if method.is_none() {
                settings.push(("method".into(), auto));
            }
            let right = "remove the method, or write rtol and atol, which it does take";
            is_auto.then_some(()).ok_or(["the method does not take it", right])
        },
    },
    OldWord { table: "simulation.output", old: "step", new: "dt", instead: "write dt", ..SAME },
];

/// An old word of the simulation with unchanged meaning.
const SAME: OldWord = OldWord { table: "simulation", old: "", new: "", instead: "", adapt: |_| Ok(()) };

/// The old word for a key of a table, if any.
pub(super) fn old_word(table: &str, key: &str) -> Option<&'static OldWord> {
    OLD_WORDS.iter().find(|word| word.table == table && word.old == key)
}

/// Adds deprecated keys with their replacements to a schema for editors, which would otherwise underline
/// valid files.
pub(super) fn add_old_words(schema: &mut Json) {
    for word in &OLD_WORDS {
        let place = table_of(schema, word.table);
        let table = schema.pointer_mut(&place).expect("the place of a table");
        let mut property = table["properties"][word.new].clone();
        let notes = property.as_object_mut().expect("the schema of a key");
        notes.insert("description".to_owned(), format!("Old name of {}: {}.", word.new, word.instead).into());
        notes.insert("deprecated".to_owned(), true.into());
        notes.remove("default");
        table["properties"][word.old] = property;
        // Either the old or the new name is then required.
        let required = table["required"].as_array().cloned().unwrap_or_default();
        if required.contains(&word.new.into()) {
            table["required"] = required.into_iter().filter(|key| *key != word.new).collect();
            table["oneOf"] = json!([{"required": [word.new]}, {"required": [word.old]}]);
        } else {
            table["dependentSchemas"][word.old] = json!({"not": {"required": [word.new]}});
        }
    }
}

/// JSON pointer to the part of a schema that describes a table.
fn table_of(schema: &Json, table: &str) -> String {
    table.split('.').fold(String::new(), |place, key| {
        let mut place = format!("{place}/properties/{key}");
        loop {
            let found = schema.pointer(&place).expect("a place in the schema");
            if let Some(reference) = found["$ref"].as_str() {
                place = reference.trim_start_matches('#').to_owned();
            } else if found["allOf"].is_array() {
                place.push_str("/allOf/0");
            } else {
                return place;
            }
        }
    })
}
