//! Values on their way into and out of descriptions, the tables of fields that the derive writes, and what is found wrong.

use std::any::Any;
use std::borrow::Cow;
use std::fmt::{self, Debug};
use std::sync::Arc;

use crate::error::InvalidInput;

/// A value on its way between a struct and TOML or Python.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Nothing: an optional field that is not given.
    None,
    /// True or false.
    Flag(bool),
    /// An integer.
    Integer(i64),
    /// A number.
    Number(f64),
    /// A text.
    Text(String),
    /// Several values.
    List(Vec<Self>),
    /// Numbers in rows of one length, one row after the other.
    Rows {
        /// All numbers.
        numbers: Vec<f64>,
        /// Length of each row.
        columns: usize,
    },
    /// Values by name, in the order in which they were given.
    Table(Vec<(Cow<'static, str>, Self)>),
    /// A part that has been read before.
    Part(Arc<dyn AnyPart>),
    /// A value that no description can contain, described for messages.
    Other(String),
}

impl Value {
    /// The value at a key of a table.
    pub fn get(&self, key: &str) -> Option<&Self> {
        let Self::Table(pairs) = self else { return None };
        pairs.iter().find(|(name, _)| name == key).map(|(_, value)| value)
    }

    /// The text, if it is one.
    pub fn text(&self) -> Option<&str> {
        if let Self::Text(text) = self { Some(text) } else { None }
    }

    /// The part, if it is one of this type.
    pub fn part<T: 'static>(&self) -> Option<&T> {
        if let Self::Part(part) = self { (part.as_ref() as &dyn Any).downcast_ref() } else { None }
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::None => f.write_str("None"),
            Self::Flag(flag) => write!(f, "{flag}"),
            Self::Integer(number) => write!(f, "{number}"),
            Self::Number(number) => write!(f, "{number:?}"),
            Self::Text(text) => write!(f, "the text \"{text}\""),
            Self::List(_) | Self::Rows { .. } => f.write_str("an array"),
            Self::Table(_) => f.write_str("a table"),
            Self::Part(part) => write!(f, "a {}", part.schema().name),
            Self::Other(what) => f.write_str(what),
        }
    }
}

/// The type of a field, for reading it and for the JSON Schema, docstrings and stubs.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// A number.
    Number,
    /// An integer, not negative.
    Integer,
    /// True or false.
    Flag,
    /// A text.
    Text,
    /// One of some words, with a common name of them.
    Word(&'static str, &'static [&'static str]),
    /// The name of an item of this list of a robot.
    Reference(&'static str),
    /// This many values.
    Array(&'static Self, usize),
    /// Any number of values.
    List(&'static Self),
    /// This many numbers, or one for all of them.
    OneOrEach(usize),
    /// The same, or two numbers, of which the first is for rest.
    AtRestOrEach(usize),
    /// A number, or any number of them.
    OneOrMany,
    /// A value, or none.
    Optional(&'static Self),
    /// One of several kinds, with a common name of them; tables choose among parts by `kind`.
    OneOf(&'static str, &'static [Self]),
    /// A part.
    Part(&'static Schema),
    /// A value of this kind, or a function of time, which in scenes is a table with these fields; with a common name of both, which is
    /// empty for a motion, always a table in scenes.
    Signal(&'static str, &'static Self, &'static Schema),
    /// A number along a rod: one, two for its ends, or a function of the arc length, which in scenes is a table with these
    /// fields.
    AlongRod(&'static Schema),
    /// A symmetric matrix of this size, or its diagonal.
    Symmetric(usize),
    /// A value of this kind along a segment, or a function of the arc length, which in scenes is a table with these fields and
    /// in Python is sampled over the `length` of the part.
    Profile(&'static Self, &'static Schema),
    /// A value of this kind, which scenes may leave open by the word "auto".
    Open(&'static Self),
}

impl Kind {
    /// The word by which scenes leave a value open.
    pub const OPEN: &str = "auto";
    /// What is expected of a part.
    pub const TABLE: &str = "a table";
    /// What is expected of a list of parts.
    pub const TABLES: &str = "an array of tables";

    /// What is expected, in words of scene files.
    pub fn words(&self) -> String {
        match self {
            Self::Number => "a number".to_owned(),
            Self::Integer => "an integer >= 0".to_owned(),
            Self::Flag => "true or false".to_owned(),
            Self::Text | Self::Reference(_) => "text in quotes".to_owned(),
            Self::Word(_, words) => {
                words.iter().map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(" or ")
            }
            Self::Array(Self::Number, count) => format!("an array of {count} numbers"),
            Self::Array(Self::Integer, count) => format!("an array of {count} integers"),
            Self::Array(Self::AlongRod(_), count) => format!("an array of {count} entries"),
            Self::Array(Self::Array(..), size) => Self::Symmetric(*size).words(),
            Self::Array(_, count) => format!("an array of {count} rows"),
            Self::List(Self::Number) => "an array of numbers".to_owned(),
            Self::List(Self::Part(_) | Self::OneOf(..)) => Self::TABLES.to_owned(),
            Self::List(Self::Word(_, words)) => format!("an array of words out of {}", words.join(", ")),
            Self::List(_) => "an array of rows".to_owned(),
            Self::OneOrEach(count) => format!("a number or an array of {count} numbers"),
            Self::AtRestOrEach(count) => format!("a number or an array of 2 or {count} numbers"),
            Self::OneOrMany => "a number or an array of numbers".to_owned(),
            Self::Optional(kind) => kind.words(),
            Self::OneOf(_, kinds) => {
                let mut words: Vec<_> = kinds.iter().map(Self::words).collect();
                words.dedup();
                words.join(" or ")
            }
            Self::Part(_) => Self::TABLE.to_owned(),
            Self::Signal("", ..) => "a table".to_owned(),
            Self::Signal(_, constant, _) => format!("{} or a table", constant.words()),
            Self::AlongRod(_) => "a number or an array of 2 numbers or a table".to_owned(),
            Self::Symmetric(size) => format!("an array of {size} numbers or of {size} rows"),
            Self::Profile(value, _) => format!("{} or a table", value.words()),
            Self::Open(value) => format!("\"{}\" or {}", Self::OPEN, value.words()),
        }
    }

    /// Whether a value of this kind may hold functions.
    pub fn holds_functions(&self) -> bool {
        match self {
            Self::Signal(..) | Self::AlongRod(_) | Self::Profile(..) => true,
            Self::Array(inner, _) | Self::List(inner) | Self::Optional(inner) => inner.holds_functions(),
            Self::OneOf(_, kinds) => kinds.iter().any(Self::holds_functions),
            Self::Part(schema) => schema.fields.iter().any(|field| field.kind.holds_functions()),
            _ => false,
        }
    }

    /// The kind of the values along a segment, if it has some.
    pub const fn along_segment(&self) -> Option<&'static Self> {
        match self {
            Self::Profile(values, _) => Some(values),
            Self::Optional(inner) => inner.along_segment(),
            _ => None,
        }
    }

    /// The table of fields, if it is a part.
    pub fn schema(&self) -> Option<&'static Schema> {
        if let Self::Part(schema) = self { Some(schema) } else { None }
    }
}

/// Makes a part from the values of its fields, in their order; its type is known at run time only.
pub type Make = fn(&[Option<Value>], &mut Reader) -> Option<Arc<dyn AnyPart>>;

/// The table of the fields of a struct.
#[derive(Debug)]
pub struct Schema {
    /// Name of the class in Python.
    pub name: &'static str,
    /// Its `kind` in scenes, where one of several structs is chosen; empty for the one without `kind`.
    pub tag: &'static str,
    /// The key in scenes whose value is the tag.
    pub tag_key: &'static str,
    /// Name of the class of Python from which it and others derive; empty for none.
    pub base: &'static str,
    /// Its name in messages, such as `a box`.
    pub called: &'static str,
    /// Common name in messages of all with a `kind` of their own, such as `an obstacle`.
    pub family: &'static str,
    /// Documentation of the struct.
    pub doc: &'static str,
    /// An example in Python, for the docstring.
    pub example: &'static str,
    /// The fields.
    pub fields: &'static [Field],
    /// How many arguments may be positional in Python; by default those that are required.
    pub positional: usize,
    /// Whether its class is nested in that of its base, with the tag as its name.
    pub is_nested: bool,
    /// Whether Python has a dict in its place.
    pub is_dict: bool,
    /// Whether Python has its only field, a list, in its place.
    pub is_list: bool,
    /// Whether it is checked by the part that holds it, and not when it is made.
    pub is_checked_later: bool,
    /// Whether Python also takes its arguments in its place, as a tuple or a dict, and None for none.
    pub is_short: bool,
    /// Whether Python shows it without the numbers and options that have their defaults.
    pub is_brief: bool,
    /// Whether Python shows nothing that has its default.
    pub is_concise: bool,
    /// Fields at least one of which has to be given.
    pub some_of: &'static [&'static str],
    /// Makes a part.
    pub make: Make,
}

impl Schema {
    /// A table without options.
    pub const fn new(name: &'static str, doc: &'static str, fields: &'static [Field], make: Make) -> Self {
        let mut positional = 0;
        while positional < fields.len() && fields[positional].is_required() {
            positional += 1;
        }
        Self {
            name,
            tag: "",
            tag_key: "kind",
            base: "",
            called: "",
            family: "",
            doc,
            example: "",
            fields,
            positional,
            is_nested: false,
            is_dict: false,
            is_list: false,
            is_checked_later: false,
            is_short: false,
            is_brief: false,
            is_concise: false,
            some_of: &[],
            make,
        }
    }

    /// Another name in Python than in Rust.
    pub const fn name(self, name: &'static str) -> Self {
        Self { name, ..self }
    }

    /// The `kind` in scenes.
    pub const fn tag(self, tag: &'static str) -> Self {
        Self { tag, ..self }
    }

    /// The key of the tag in scenes.
    pub const fn tag_key(self, tag_key: &'static str) -> Self {
        Self { tag_key, ..self }
    }

    /// The class of Python from which it and others derive.
    pub const fn base(self, base: &'static str) -> Self {
        Self { base, ..self }
    }

    /// What messages call it.
    pub const fn called(self, called: &'static str) -> Self {
        Self { called, ..self }
    }

    /// What messages call all with a `kind` of their own.
    pub const fn family(self, family: &'static str) -> Self {
        Self { family, ..self }
    }

    /// An example in Python.
    pub const fn example(self, example: &'static str) -> Self {
        Self { example, ..self }
    }

    /// The number of positional arguments in Python.
    pub const fn positional(self, positional: usize) -> Self {
        Self { positional, ..self }
    }

    /// Its class is nested in that of its base.
    pub const fn nested(self) -> Self {
        Self { is_nested: true, ..self }
    }

    /// Python has a dict in its place.
    pub const fn dict(self) -> Self {
        Self { is_dict: true, ..self }
    }

    /// Python has its only field, a list, in its place.
    pub const fn list(self) -> Self {
        Self { is_list: true, ..self }
    }

    /// The part that holds it checks it.
    pub const fn checked_later(self) -> Self {
        Self { is_checked_later: true, ..self }
    }

    /// Python also takes its arguments in its place.
    pub const fn short(self) -> Self {
        Self { is_short: true, ..self }
    }

    /// Python shows it without the numbers and options that have their defaults.
    pub const fn brief(self) -> Self {
        Self { is_brief: true, ..self }
    }

    /// Python shows nothing that has its default.
    pub const fn concise(self) -> Self {
        Self { is_concise: true, ..self }
    }

    /// At least one of these fields has to be given.
    pub const fn some_of(self, some_of: &'static [&'static str]) -> Self {
        Self { some_of, ..self }
    }

    /// The expression that makes it in Python.
    pub fn maker(&self) -> String {
        if self.is_nested { format!("{}.{}", self.base, self.tag) } else { self.name.to_owned() }
    }

    /// The class of Python that messages and annotations name.
    pub const fn class(&self) -> &'static str {
        if self.is_nested { self.base } else { self.name }
    }

    /// Place of the field with this name.
    pub fn index(&self, key: &str) -> Option<usize> {
        self.fields.iter().position(|field| field.name == key)
    }

    /// The fields that scenes have as keys.
    pub fn keys(&self) -> impl Iterator<Item = &'static Field> + Clone {
        self.fields.iter().filter(|field| !field.limits.is_by_place)
    }

    /// Names of the fields.
    pub fn names(&self) -> impl Iterator<Item = &'static str> + Clone {
        self.fields.iter().map(|field| field.name)
    }
}

/// A field of a struct.
#[derive(Clone, Copy, Debug)]
pub struct Field {
    /// Its name, in Rust, Python and scenes.
    pub name: &'static str,
    /// Its doc comment.
    pub doc: &'static str,
    /// Its type.
    pub kind: Kind,
    /// `None` for required fields.
    pub default: Option<fn() -> Value>,
    /// Unit and range.
    pub limits: Limits,
}

impl Field {
    /// Whether callers of Python have to give it.
    pub const fn is_required(&self) -> bool {
        self.default.is_none() || self.limits.is_explicit
    }

    /// What the field means, with unit and range after the first sentence: `Radius (metres, > 0).`
    pub fn meaning(&self) -> String {
        let (doc, words) = (self.doc.trim().replace('\n', " "), self.limits.words());
        let end = doc.find(". ").or_else(|| doc.rfind('.')).unwrap_or(doc.len());
        let end = doc[..end].find(';').unwrap_or(end);
        if words.is_empty() { doc } else { format!("{} ({words}){}", &doc[..end], &doc[end..]) }
    }

    /// The first sentence of its meaning, as a part of another one.
    pub fn summary(&self) -> String {
        let meaning = self.meaning();
        let first = meaning.split_once(". ").map_or(meaning.as_str(), |(first, _)| first);
        let first = first.trim_end_matches('.');
        let mut letters = first.chars();
        let is_word = first.chars().nth(1).is_some_and(char::is_lowercase);
        match letters.next() {
            Some(letter) if is_word => format!("{}{}", letter.to_lowercase(), letters.as_str()),
            _ => first.to_owned(),
        }
    }
}

/// Unit and range of the numbers of a field, and when the field is given.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// The name of a number, such as `a finite number`.
    pub noun: &'static str,
    /// The unit in words; empty for numbers without a unit.
    pub unit: &'static str,
    /// Whether numbers must be positive, or not negative.
    pub sign: Sign,
    /// Whether numbers may be infinite.
    pub is_unbounded: bool,
    /// The field that has to be given as well.
    pub needs: &'static str,
    /// Whether scenes express it by the place of the table.
    pub is_by_place: bool,
    /// Whether callers of Python have to give it, although scenes may leave it out.
    pub is_explicit: bool,
    /// Whether all valid parts have it, although it may be left out.
    pub is_always: bool,
    /// The value with which lenient readers replace a required field after problems.
    pub stand_in: Option<fn() -> Value>,
}

/// Which signs numbers may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sign {
    /// Any.
    Any,
    /// Positive or zero.
    NonNegative,
    /// Positive.
    Positive,
}

impl Limits {
    /// Finite numbers without a unit.
    pub const NONE: Self = Self {
        noun: "a finite number",
        unit: "",
        sign: Sign::Any,
        is_unbounded: false,
        needs: "",
        is_by_place: false,
        is_explicit: false,
        is_always: false,
        stand_in: None,
    };

    /// With a unit.
    pub const fn unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    /// Numbers > 0.
    pub const fn positive(self) -> Self {
        Self { sign: Sign::Positive, ..self }
    }

    /// Numbers >= 0.
    pub const fn non_negative(self) -> Self {
        Self { sign: Sign::NonNegative, ..self }
    }

    /// Numbers that may be infinite.
    pub const fn unbounded(self) -> Self {
        Self { noun: "a number", is_unbounded: true, ..self }
    }

    /// Arc lengths of an unstretched rod.
    pub const fn arc_length(self) -> Self {
        Self { noun: "an arc length", ..self.unit("metres").non_negative() }
    }

    /// Scenes express it by the place of the table.
    pub const fn by_place(self) -> Self {
        Self { is_by_place: true, ..self }
    }

    /// Callers of Python have to give it, if only None; scenes may leave it out.
    pub const fn explicit(self) -> Self {
        Self { is_explicit: true, ..self }
    }

    /// All valid parts have it, given or derived.
    pub const fn always(self) -> Self {
        Self { is_always: true, ..self }
    }

    /// Sets the value that replaces it after problems.
    pub const fn stand_in(self, stand_in: fn() -> Value) -> Self {
        Self { stand_in: Some(stand_in), ..self }
    }

    /// The field is given only together with this one.
    pub const fn needs(self, needs: &'static str) -> Self {
        Self { needs, ..self }
    }

    fn relation(&self) -> &'static str {
        match self.sign {
            Sign::Any => "",
            Sign::NonNegative => ">= 0",
            Sign::Positive => "> 0",
        }
    }

    /// Unit and range, such as `metres, > 0`.
    pub fn words(&self) -> String {
        let words = [self.unit, self.relation()];
        words.into_iter().filter(|word| !word.is_empty()).collect::<Vec<_>>().join(", ")
    }

    /// What a number must be, such as `a finite number > 0 (metres)`.
    pub fn expected(&self) -> String {
        let mut text = self.noun.to_owned();
        if self.sign != Sign::Any {
            text = format!("{text} {}", self.relation());
        }
        if self.unit.is_empty() { text } else { format!("{text} ({})", self.unit) }
    }

    /// Whether a number is in range, and finite where it must be.
    pub fn contain(&self, number: f64) -> bool {
        let has_sign = match self.sign {
            Sign::Any => true,
            Sign::NonNegative => number >= 0.0,
            Sign::Positive => number > 0.0,
        };
        (number.is_finite() || (self.is_unbounded && !number.is_nan())) && has_sign
    }
}

/// A fault of a value.
#[derive(Clone, Debug)]
pub enum Fault {
    /// A value of the right type that is out of range or does not fit.
    Value {
        /// What was found.
        found: String,
        /// What would be right.
        expected: String,
    },
    /// A value of another type.
    Type {
        /// What was found.
        found: String,
        /// What would be right.
        expected: String,
    },
    /// A field that has to be given; the place is the field, or the part where it is missing.
    Missing {
        /// The field.
        key: &'static str,
        /// What to add, after the name of the field.
        advice: String,
    },
    /// A field that this part needs, although others do not.
    Absent {
        /// The field.
        key: &'static str,
        /// Its meaning.
        meaning: String,
        /// What would be right, in words of Python.
        expected: &'static str,
    },
    /// The place is an unknown key.
    Unknown {
        /// The keys that could be meant.
        known: Vec<&'static str>,
    },
    /// The place is a key that only other kinds of parts take, or that needs another one.
    NotTaken {
        /// The part that does not take it.
        part: &'static Schema,
        /// The keys that it takes.
        taken: Vec<&'static str>,
    },
    /// A table without the `kind` that chooses among parts, and without the first key of the only one that has no `kind`.
    Undecided {
        /// That key.
        key: &'static str,
        /// The meaning of that key.
        meaning: String,
        /// The possible words for `kind`.
        tags: Vec<&'static str>,
    },
    /// None of these fields is given, but one of them is required.
    NoneOf(&'static [&'static str]),
    /// Both of these fields are given, although they exclude each other; the place is the second one.
    Both([&'static str; 2]),
    /// The field at this place is given, but not the one that it needs.
    Without {
        /// The field.
        key: &'static str,
        /// The one that it needs.
        needed: &'static str,
        /// The meaning of that one.
        meaning: &'static str,
    },
    /// A field that has no effect beside the other ones.
    Unused {
        /// Its value.
        found: String,
        /// The part to which it belongs, in a sentence.
        belongs: &'static str,
    },
    /// A name that refers to nothing.
    Name {
        /// The name, and what would be right, in words of Python.
        python: [String; 2],
        /// What is wrong, and what would be right, in words of scenes.
        scene: [String; 2],
    },
    /// A function of the user failed and has kept the reason.
    Failed,
    /// A word that is none of these.
    Word {
        /// The word.
        found: String,
        /// The possible words.
        words: &'static [&'static str],
    },
    /// Keys that make no sense together.
    Other {
        /// What is wrong.
        wrong: String,
        /// What to do.
        right: String,
    },
    /// A word for `kind` that no part has.
    Tag {
        /// The word.
        found: String,
        /// The possible words.
        tags: Vec<&'static str>,
    },
}

/// A problem of a value.
#[derive(Clone, Debug)]
pub struct Problem {
    /// Where: the path of the value, such as `b.radius`.
    pub place: String,
    /// What is wrong.
    pub fault: Fault,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum Step {
    Key(&'static str),
    Index(usize),
}

/// Keeps the place and the problems while values are read and checked.
#[derive(Debug, Default)]
pub struct Reader {
    pub(super) place: Vec<Step>,
    pub(super) problems: Vec<Problem>,
    /// The parts among which the one that is read next was chosen.
    pub(super) alternatives: &'static [Kind],
    /// Places of fields that were replaced, if the reader continues after problems.
    pub(super) replaced: Option<Vec<String>>,
}

/// A type that a field may have.
pub trait Data: Clone + PartialEq + Send + Sync + Debug + 'static {
    /// Its kind.
    const KIND: Kind;

    /// The default of fields of this type that give none.
    const ABSENT: Option<fn() -> Value> = None;

    /// Reads without checking ranges, except in a part that cannot be completed.
    fn read(value: &Value, reader: &mut Reader) -> Option<Self>;

    /// Reports what is out of range or does not fit together.
    fn check(&self, limits: &Limits, reader: &mut Reader);

    /// The value from which `read` makes an equal one.
    fn write(&self) -> Value;
}

/// A struct with the derive, or a choice among some: what lists may hold.
pub trait Item: Data {
    /// Checks a struct that was made in Rust.
    ///
    /// # Errors
    /// All problems.
    fn validate(&self) -> Result<(), InvalidInput> {
        let mut reader = Reader::default();
        self.check(&Limits::NONE, &mut reader);
        let problems: Vec<_> = reader.finish().into_iter().map(Into::into).collect();
        if problems.is_empty() { Ok(()) } else { Err(InvalidInput { problems }) }
    }
}

/// A struct with the derive.
pub trait Part: Item + AnyPart {
    /// The table of its fields.
    const SCHEMA: &'static Schema;

    /// Reads and checks.
    ///
    /// # Errors
    /// All problems.
    fn from_value(value: &Value) -> Result<Self, Vec<Problem>> {
        let mut reader = Reader::default();
        let found = Self::read(value, &mut reader);
        if let Some(part) = &found {
            part.check(&Limits::NONE, &mut reader);
        }
        found.filter(|_| reader.problems().is_empty()).ok_or(reader.finish())
    }
}

/// A struct with the derive, whichever it is.
pub trait AnyPart: Any + Send + Sync + Debug {
    /// The table of its fields.
    fn schema(&self) -> &'static Schema;

    /// The value of a field by its place in the table.
    fn field(&self, index: usize) -> Value;

    /// The value of a field that is not given, derived from the others.
    fn derived(&self, _index: usize) -> Value {
        Value::None
    }

    /// Whether both are equal.
    fn same(&self, other: &dyn AnyPart) -> bool;

    /// Reports what is out of range or does not fit together.
    fn check_any(&self, reader: &mut Reader);

    /// The fields with their values that differ from their defaults.
    fn given(&self) -> Vec<(&'static Field, Value)> {
        let fields = self.schema().fields.iter().enumerate();
        fields
            .map(|(i, field)| (field, self.field(i)))
            .filter(|(field, value)| field.default.is_none_or(|default| default() != *value))
            .collect()
    }
}

impl PartialEq for dyn AnyPart {
    fn eq(&self, other: &Self) -> bool {
        self.same(other)
    }
}
