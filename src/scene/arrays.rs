//! Arrays in files beside a scene: `heights = { file = "heights.csv" }`, a row of the array on each line.

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::imports::FileProblem;
use crate::description::schema::Value;

/// The key of a table that refers to an array in a file.
const FILE: &str = "file";

/// Numbers from which on arrays are set aside when a scene is saved: several screens of text.
const LARGE: usize = 1000;

/// Characters of a line that messages show.
const LONGEST_LINE: usize = 100;

/// The file that stands for an array.
pub(super) fn file_of<'a>(table: &'a DeTable<'_>) -> Option<&'a str> {
    let (key, value) = table.iter().next().filter(|_| table.len() == 1)?;
    match value.get_ref() {
        DeValue::String(file) if key.get_ref() == FILE => Some(file),
        _ => None,
    }
}

/// The array in a text: rows of numbers that commas or blanks separate, or a plain list where each line has one number. Empty lines
/// and those that begin with `#` are skipped.
pub(super) fn read(text: &str, file: &str) -> Result<Value, Box<FileProblem>> {
    let mut rows: Vec<Vec<Value>> = Vec::new();
    // Spreadsheets begin a file with a mark of its byte order.
    for (i, line) in text.strip_prefix('\u{feff}').unwrap_or(text).lines().enumerate() {
        if line.trim().is_empty() || line.trim_start().starts_with('#') {
            continue;
        }
        let refuse =
            |word: &str, [wrong, right]: [String; 2]| problem_of((file, i + 1, line), word, [wrong, right]);
        let words: Vec<&str> = match line.contains(',') {
            true => line.split(',').map(str::trim).collect(),
            false => line.split_whitespace().collect(),
        };
        let number = |word: &&str| {
            number(word).ok_or_else(|| {
                refuse(
                    word,
                    [
                        format!("got \"{word}\""),
                        "expected a number: commas or blanks separate them, decimals have a point".to_owned(),
                    ],
                )
            })
        };
        let row = words.iter().map(number).collect::<Result<Vec<_>, _>>()?;
        if let Some(first) = rows.first()
            && first.len() != row.len()
        {
            let wrong = format!("got {} numbers", row.len());
            return Err(refuse(line, [wrong, format!("expected {}, as in the rows above", first.len())]));
        }
        rows.push(row);
    }
    let is_plain = rows.first().is_some_and(|row| row.len() == 1);
    Ok(Value::List(match is_plain {
        true => rows.into_iter().flatten().collect(),
        false => rows.into_iter().map(Value::List).collect(),
    }))
}

/// A problem of a word in a numbered line of a file.
fn problem_of(
    (file, number, line): (&str, usize, &str),
    word: &str,
    [wrong, right]: [String; 2],
) -> Box<FileProblem> {
    // The same word may occur twice in the line: its address identifies it.
    let start = word.as_ptr() as usize - line.as_ptr() as usize;
    let column = 1 + line[..start].chars().count();
    let shown: String = line.chars().take(LONGEST_LINE).collect();
    let margin = " ".repeat(number.to_string().len());
    // Words beyond what is shown have no mark.
    let width = word.chars().count().max(1).min(LONGEST_LINE.saturating_sub(column - 1));
    let mark = format!("{}{}", " ".repeat(column.min(LONGEST_LINE) - 1), "^".repeat(width));
    let snippet = format!("{margin} |\n{number} | {shown}\n{margin} | {mark}");
    let (file, line, key) = (file.to_owned(), number, String::new());
    Box::new(FileProblem { file, line, column, key, wrong, right, snippet })
}

/// A number, an integer if TOML reads it as one.
fn number(word: &str) -> Option<Value> {
    let integer = word.parse().ok().map(Value::Integer);
    integer.or_else(|| word.parse().ok().map(Value::Number))
}

/// A text without its large arrays, which are in files of their own, with the names and contents of these. Names begin with `stem`.
pub fn set_aside(text: &str, stem: &str) -> (String, Vec<(String, String)>) {
    let (table, _) = DeTable::parse_recoverable(text);
    let mut large = Vec::new();
    for (key, value) in table.get_ref() {
        find(key.get_ref(), value, &mut large);
    }
    large.sort_by_key(|(_, value)| value.span().start);
    let (mut rest, mut files, mut end) = (String::new(), Vec::<(String, String)>::new(), 0);
    for (key, value) in large {
        let alike = |number: usize| match number {
            1 => format!("{stem}-{key}.csv"),
            number => format!("{stem}-{key}-{number}.csv"),
        };
        let is_new = |name: &String| files.iter().all(|(known, _)| known != name);
        let name = (1..).map(alike).find(is_new).expect("there are more numbers than files");
        rest.push_str(&text[end..value.span().start]);
        rest.push_str(&format!("{{ {FILE} = {} }}", toml::Value::from(name.as_str())));
        end = value.span().end;
        files.push((name, lines(value)));
    }
    rest.push_str(&text[end..]);
    (rest, files)
}

/// Finds large arrays of numbers, with the keys that hold them.
fn find<'a>(
    key: &'a str,
    value: &'a Spanned<DeValue<'a>>,
    found: &mut Vec<(&'a str, &'a Spanned<DeValue<'a>>)>,
) {
    match value.get_ref() {
        DeValue::Table(table) => table.iter().for_each(|(key, value)| find(key.get_ref(), value, found)),
        DeValue::Array(array) => match numbers(value.get_ref()) {
            Some(count) if count >= LARGE => found.push((key, value)),
            Some(_) => {}
            None => array.iter().for_each(|item| find(key, item, found)),
        },
        _ => {}
    }
}

/// How many numbers an array has that a file can hold: a list of numbers, or rows of two and more of one length.
fn numbers(array: &DeValue<'_>) -> Option<usize> {
    let rows = array.as_array()?;
    let width = |row: &Spanned<DeValue<'_>>| match row.get_ref() {
        DeValue::Integer(_) | DeValue::Float(_) => Some(1),
        DeValue::Array(row) if row.len() > 1 => {
            row.iter().all(|item| is_number(item.get_ref())).then_some(row.len())
        }
        _ => None,
    };
    let first = width(rows.first()?)?;
    rows.iter().all(|row| width(row) == Some(first)).then_some(first * rows.len())
}

fn is_number(value: &DeValue<'_>) -> bool {
    matches!(value, DeValue::Integer(_) | DeValue::Float(_))
}

/// The lines of a file: the numbers as they are written.
fn lines(array: &Spanned<DeValue<'_>>) -> String {
    let word = |value: &DeValue<'_>| match value {
        DeValue::Integer(integer) => i64::from_str_radix(integer.as_str(), integer.radix())
            .map_or_else(|_| integer.to_string(), |number| number.to_string()),
        DeValue::Float(float) => float.as_str().to_owned(),
        _ => unreachable!("an array of numbers"),
    };
    let line = |row: &Spanned<DeValue<'_>>| match row.get_ref() {
        DeValue::Array(row) => {
            row.iter().map(|item| word(item.get_ref())).collect::<Vec<_>>().join(",") + "\n"
        }
        number => word(number) + "\n",
    };
    array.get_ref().as_array().into_iter().flatten().map(line).collect()
}
