//! Docstrings in the style of numpydoc, signatures and the stub, from the tables of parts.

use std::fmt::Write as _;

use crate::description::schema::{Field, Kind, Schema, Value};

/// The longest line of docstrings.
const WIDTH: usize = 105;

/// The longest line of the sources in Python.
const LINE: usize = 110;

/// A default in Python.
fn literal(value: &Value) -> String {
    match value {
        Value::None => "None".to_owned(),
        Value::Flag(true) => "True".to_owned(),
        Value::Flag(false) => "False".to_owned(),
        Value::Text(text) => format!("\"{text}\""),
        Value::Number(number) if number.abs() < 1e-4 && *number != 0.0 => format!("{number:e}"),
        Value::List(items) => {
            format!("({})", items.iter().map(literal).collect::<Vec<_>>().join(", "))
        }
        Value::Rows { numbers, columns } => {
            let row = |row: &[f64]| literal(&Value::List(row.iter().copied().map(Value::Number).collect()));
            format!("({})", numbers.chunks((*columns).max(1)).map(row).collect::<Vec<_>>().join(", "))
        }
        // Signatures have the part itself.
        Value::Part(_) => "...".to_owned(),
        other => other.to_string(),
    }
}

/// The default of a field in Python; equal numbers for each direction are one number.
fn default_of(field: &Field) -> Option<String> {
    let default = field.default.filter(|_| !field.is_required())?();
    match (&field.kind, default) {
        (
            Kind::OneOrEach(_) | Kind::AtRestOrEach(_) | Kind::OneOf(_, [Kind::AtRestOrEach(_), _]),
            Value::List(items),
        ) if items.iter().all(|item| *item == items[0]) => Some(literal(&items[0])),
        (_, default) => Some(literal(&default)),
    }
}

/// The class of Python from which all of these parts derive, if there is one.
fn base_of(kinds: &[Kind]) -> Option<&'static str> {
    let mut bases = kinds.iter().map(|kind| kind.schema().map_or("", |schema| schema.base));
    let first = bases.next().filter(|base| !base.is_empty())?;
    bases.all(|base| base == first).then_some(first)
}

/// The type of an argument, or of an attribute.
pub(super) fn annotation(kind: &Kind, is_argument: bool) -> String {
    let inner = |kind: &Kind| annotation(kind, is_argument);
    match kind {
        Kind::Number => "float".to_owned(),
        Kind::Integer => "int".to_owned(),
        Kind::Flag => "bool".to_owned(),
        Kind::Text | Kind::Reference(_) => "str".to_owned(),
        Kind::Word(_, words) => {
            let words: Vec<_> = words.iter().map(|word| format!("\"{word}\"")).collect();
            format!("Literal[{}]", words.join(", "))
        }
        Kind::List(items @ (Kind::Part(_) | Kind::OneOf(..))) if is_argument => {
            format!("Iterable[{}]", inner(items))
        }
        Kind::Array(items @ Kind::AlongRod(_), _) if is_argument => format!("Sequence[{}]", inner(items)),
        Kind::Array(..) | Kind::List(_) if is_argument => "ArrayLike".to_owned(),
        Kind::Array(Kind::Array(..), _) => "NDArray[np.float64]".to_owned(),
        Kind::Array(items, count) => format!("tuple[{}]", vec![inner(items); *count].join(", ")),
        Kind::List(items) => format!("tuple[{}, ...]", inner(items)),
        Kind::OneOf(_, [Kind::AtRestOrEach(_), Kind::Part(_)]) if is_argument => {
            "ArrayLike | tuple[ArrayLike, ArrayLike]".to_owned()
        }
        Kind::OneOf(_, [each @ Kind::AtRestOrEach(_), Kind::Part(_)]) => {
            format!("{} | tuple[tuple[float, ...], tuple[float, ...]]", inner(each))
        }
        Kind::OneOrEach(_) | Kind::AtRestOrEach(_) | Kind::OneOrMany if is_argument => "ArrayLike".to_owned(),
        Kind::OneOrMany => "float | tuple[float, ...]".to_owned(),
        Kind::OneOrEach(count) | Kind::AtRestOrEach(count) => {
            annotation(&Kind::Array(&Kind::Number, *count), false)
        }
        Kind::Optional(kind) => format!("{} | None", inner(kind)),
        // One number stands for equal ones.
        Kind::OneOf(_, [each @ Kind::OneOrEach(_), word]) if !is_argument => {
            format!("float | {} | {}", inner(each), inner(word))
        }
        Kind::OneOf(_, kinds) => match base_of(kinds) {
            Some(base) => base.to_owned(),
            None => {
                let mut kinds: Vec<_> = kinds.iter().map(inner).collect();
                kinds.dedup();
                kinds.join(" | ")
            }
        },
        Kind::Open(kind) if is_argument => {
            format!("{} | {}", inner(kind), inner(&Kind::Word("", &[Kind::OPEN])))
        }
        Kind::Open(kind) => inner(kind),
        Kind::Part(schema) if schema.is_dict => "dict[str, int]".to_owned(),
        Kind::Part(schema) if schema.is_list => inner(&schema.fields[0].kind),
        Kind::Part(schema) if is_argument && schema.is_short => {
            format!("{} | Sequence[object] | Mapping[str, object] | None", schema.name)
        }
        Kind::Part(schema) => schema.class().to_owned(),
        Kind::Signal(_, Kind::Number, _) if is_argument => "_Number".to_owned(),
        Kind::Signal(..) if is_argument => "_Vector".to_owned(),
        Kind::AlongRod(_) if is_argument => "_AlongRod".to_owned(),
        Kind::Signal(..) | Kind::AlongRod(_) => "Any".to_owned(),
        Kind::Symmetric(_) => if is_argument { "ArrayLike" } else { "NDArray[np.float64]" }.to_owned(),
        Kind::Profile(Kind::OneOrEach(_), _) if is_argument => "_Size".to_owned(),
        Kind::Profile(..) if is_argument => "_Along".to_owned(),
        Kind::Profile(values, _) => format!("{} | Profile", inner(values)),
    }
}

/// The type of an argument in docstrings.
fn words(kind: &Kind) -> String {
    let of = |items: &Kind| if matches!(items, Kind::Integer) { " of int" } else { "" };
    match kind {
        Kind::Word(_, words) => {
            let words: Vec<_> = words.iter().map(|word| format!("'{word}'")).collect();
            format!("{{{}}}", words.join(", "))
        }
        Kind::Array(Kind::Array(..), count) => format!("array_like, shape ({count},) or ({count}, {count})"),
        Kind::Signal(_, constant, _) => {
            format!("{}; or (times, values), Harmonic, Input or callable", words(constant))
        }
        Kind::Array(items @ Kind::AlongRod(_), _) => format!("pair of {}", words(items)),
        Kind::Array(items, count) => format!("array_like{}, shape ({count},)", of(items)),
        Kind::List(Kind::Array(items, count)) => format!("array_like{}, shape (k, {count})", of(items)),
        Kind::AlongRod(_) => "float, (float, float), (stations, values), Profile or callable".to_owned(),
        Kind::List(items @ (Kind::Part(_) | Kind::OneOf(..))) => format!("sequence of {}", words(items)),
        Kind::List(Kind::List(_)) => "array_like, shape (k, l)".to_owned(),
        Kind::List(_) => "array_like, shape (k,)".to_owned(),
        Kind::OneOrEach(count) => format!("float or array_like, shape ({count},)"),
        Kind::AtRestOrEach(count) => format!("float or array_like, shape (2,) or ({count},)"),
        Kind::OneOrMany => "float or array_like, shape (n,)".to_owned(),
        Kind::Optional(kind) => format!("{}, optional", words(kind)),
        Kind::OneOf(_, [each @ Kind::AtRestOrEach(_), Kind::Part(_)]) => {
            format!("{}; or (stations, values)", words(each))
        }
        Kind::OneOf(_, kinds) if base_of(kinds).is_some() => annotation(kind, true),
        Kind::OneOf(_, kinds) => {
            let mut kinds: Vec<_> = kinds.iter().map(words).collect();
            kinds.dedup();
            match kinds.split_last() {
                Some((last, first)) if !first.is_empty() => format!("{} or {last}", first.join(", ")),
                _ => kinds.concat(),
            }
        }
        Kind::Symmetric(size) => format!("array_like, shape ({size},) or ({size}, {size})"),
        Kind::Profile(Kind::OneOrEach(_), _) => {
            "float, (float, float), (stations, values), callable or Profile".to_owned()
        }
        Kind::Profile(values, _) => format!("{}; or (stations, values), callable or Profile", words(values)),
        Kind::Part(schema) if schema.is_short => format!("{}, tuple, dict or None", schema.name),
        Kind::Part(schema) if schema.is_dict => "dict of str to int".to_owned(),
        Kind::Part(schema) if schema.is_list => words(&schema.fields[0].kind),
        Kind::Open(kind) => format!("{} or '{}'", words(kind), Kind::OPEN),
        kind => annotation(kind, true),
    }
}

/// The arguments of the constructor; with types for the stub.
fn arguments(schema: &Schema, is_typed: bool) -> Vec<String> {
    let mut arguments = Vec::with_capacity(schema.fields.len() + 1);
    for (i, field) in schema.fields.iter().enumerate() {
        if i == schema.positional {
            arguments.push("*".to_owned());
        }
        let kind = if is_typed { format!(": {}", annotation(&field.kind, true)) } else { String::new() };
        let equals = if is_typed { " = " } else { "=" };
        let default = default_of(field).map(|default| format!("{equals}{default}"));
        arguments.push(format!("{}{kind}{}", field.name, default.unwrap_or_default()));
    }
    arguments
}

/// The signature of the constructor, as Python reads it from a docstring.
pub(super) fn signature(schema: &Schema) -> String {
    arguments(schema, false).join(", ")
}

/// A paragraph in lines that are not too long, each of them after this many spaces.
fn wrapped(paragraph: &str, indent: usize) -> String {
    let (mut text, mut column) = (" ".repeat(indent), indent);
    for word in paragraph.split_whitespace() {
        let width = word.chars().count();
        if column > indent {
            if column + 1 + width > WIDTH {
                text.push('\n');
                text.push_str(&" ".repeat(indent));
                column = indent;
            } else {
                text.push(' ');
                column += 1;
            }
        }
        text.push_str(word);
        column += width;
    }
    text
}

/// The docstring.
pub(super) fn docstring(schema: &Schema) -> String {
    let example = schema.example.trim();
    let paragraphs: Vec<_> = schema.doc.trim().split("\n\n").map(|text| wrapped(text, 0)).collect();
    let mut text = paragraphs.join("\n\n");
    if schema.fields.is_empty() {
        return text;
    }
    text.push_str("\n\nParameters\n----------\n");
    for field in schema.fields {
        _ = writeln!(text, "{} : {}\n{}", field.name, words(&field.kind), wrapped(&field.meaning(), 4));
    }
    text.push_str(
        "\nRaises\n------\nValueError\n    If parameters are invalid; the message lists all of them.\n",
    );
    if !example.is_empty() {
        _ = writeln!(text, "\nExamples\n--------\n{example}");
    }
    text
}

/// Derived attributes in the stub of the base of nested classes.
const VIEWS: [(&str, &str); 2] =
    [("Section", include_str!("../section_views.txt")), ("_Segment", include_str!("../segment_views.txt"))];

/// Constructor and attributes of a class of the stub, which may have a compiled constructor of its own.
pub(super) fn stub_of(schema: &Schema, is_compiled: bool) -> String {
    let [name, this, made] =
        if is_compiled { ["__new__", "cls", "Self"] } else { ["__init__", "self", "None"] };
    let mut text = format!("    def {name}(\n        {this},\n");
    for argument in arguments(schema, true) {
        let line = format!("        {argument},");
        let line = if line.len() > LINE { line.replace(" | ", "\n        | ") } else { line };
        _ = writeln!(text, "{line}");
    }
    _ = writeln!(text, "    ) -> {made}: ...");
    for field in schema.fields {
        let kind = match &field.kind {
            Kind::Optional(inner) if field.limits.is_always => annotation(inner, false),
            kind => annotation(kind, false),
        };
        let line = format!("    def {}(self) -> {kind}: ...", field.name);
        // As the formatter breaks it.
        let end = format!("    ) -> {kind}: ...");
        let line = if line.len() <= LINE {
            line
        } else if end.len() <= LINE {
            line.replace("(self)", "(\n        self,\n    )")
        } else {
            let each = kind.replace(" | ", "\n        | ");
            format!("    def {}(\n        self,\n    ) -> (\n        {each}\n    ): ...", field.name)
        };
        _ = writeln!(text, "    @property\n{line}");
    }
    text
}

/// The classes of the stub.
pub(super) fn stub(parts: &[&'static Schema]) -> String {
    let mut text = String::new();
    let mut bases = Vec::new();
    for schema in parts {
        let views = VIEWS.iter().find(|(name, _)| *name == schema.base).map(|(_, views)| *views);
        // A private base has nothing but what its only class has.
        let base = if schema.base.is_empty() || schema.base.starts_with('_') { "Part" } else { schema.base };
        if base != "Part" && !bases.contains(&base) {
            match views {
                Some(views) => _ = write!(text, "class {base}(Part):\n{views}"),
                None => _ = writeln!(text, "class {base}(Part): ...\n"),
            }
            bases.push(base);
        }
        if schema.is_nested {
            // A class, which is called as a function.
            _ = writeln!(text, "    @staticmethod\n    def {}(", schema.tag);
            for argument in arguments(schema, true) {
                _ = writeln!(text, "        {argument},");
            }
            _ = writeln!(text, "    ) -> {}: ...", schema.base);
            if parts
                .iter()
                .rfind(|part| part.base == schema.base)
                .is_some_and(|last| std::ptr::eq(*last, *schema))
            {
                text.push('\n');
            }
            continue;
        }
        let positional = schema.names().take(schema.positional).map(|name| format!("\"{name}\""));
        let positional: Vec<_> = positional.collect();
        let line = format!("    __match_args__ = ({})", positional.join(", "));
        let line = match schema.positional {
            // Also of one argument a tuple.
            1 => line.replace(')', ",)"),
            // As the formatter breaks it.
            _ if line.len() > LINE => {
                format!("    __match_args__ = (\n        {},\n    )", positional.join(",\n        "))
            }
            _ => line,
        };
        _ = writeln!(text, "class {}({base}):\n{line}", schema.name);
        text.push_str(&stub_of(schema, false));
        if base == "Part" {
            text.push_str(views.unwrap_or_default());
        }
        text.push('\n');
    }
    text
}
