//! Problems of a scene file with file, line, column and source lines.

use std::fmt;
use std::ops::Range;

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};

use crate::error::{MAX_PROBLEMS, rest_of};

/// Maximum number of bytes of a problem's key, and of each sentence about it: names and texts in a file may
/// have any length.
const LONGEST_KEY: usize = 200;
const LONGEST_SENTENCE: usize = 1000;

/// Number of bytes of a source line passed to the renderer on either side of a problem's start: more than it
/// shows.
const LINE_AROUND: usize = 400;

/// A problem of a scene file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneProblem {
    /// Line in the file, from 1; 0 for a problem without a position in the file (such as a missing file).
    pub line: usize,
    /// Column in the line, in characters, from 1.
    pub column: usize,
    /// Path of the key, such as `rod[0].segment[1].radius`; empty for a syntax error.
    pub key: String,
    /// What was found.
    pub wrong: String,
    /// What was expected; may be empty for a syntax error.
    pub right: String,
    /// Byte range of the problem in the file.
    pub span: Range<usize>,
    /// Position in an imported file, which the span imports.
    pub elsewhere: Option<Elsewhere>,
}

/// A file other than the scene's.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Elsewhere {
    /// Its name in messages.
    pub file: String,
    /// The line with the problem, with a mark at the position.
    pub snippet: String,
}

impl SceneProblem {
    /// `key: what is wrong; what would be right`.
    pub fn message(&self) -> String {
        let mut message = String::new();
        if !self.key.is_empty() {
            message.push_str(&self.key);
            message.push_str(": ");
        }
        message.push_str(&self.wrong);
        if !self.right.is_empty() {
            message.push_str("; ");
            message.push_str(&self.right);
        }
        message
    }

    /// `file:line:column: key: what is wrong; what would be right`; `file` is that of the scene.
    pub fn header(&self, file: &str) -> String {
        format!("{}:{}:{}: {}", self.file(file), self.line, self.column, self.message())
    }

    /// Name of the file with the problem; `scene` is the name of the scene's file.
    pub fn file<'a>(&'a self, scene: &'a str) -> &'a str {
        self.elsewhere.as_ref().map_or(scene, |elsewhere| &elsewhere.file)
    }
}

/// The first [`MAX_PROBLEMS`] problems, whose spans are known, with lines and columns, in the order of the
/// text.
pub(super) fn placed(text: &str, mut problems: Vec<SceneProblem>) -> Vec<SceneProblem> {
    // Problems of imported files keep their order.
    let key = |problem: &SceneProblem| match problem.elsewhere {
        Some(_) => String::new(),
        None => problem.key.clone(),
    };
    problems.sort_by_key(|problem| (problem.span.start, key(problem)));
    problems.truncate(MAX_PROBLEMS);
    for problem in &mut problems {
        if problem.elsewhere.is_none() {
            (problem.line, problem.column) = line_and_column(text, problem.span.start);
        }
        problem.span = first_line(text, &problem.span);
        shorten(&mut problem.key, LONGEST_KEY);
        shorten(&mut problem.wrong, LONGEST_SENTENCE);
        shorten(&mut problem.right, LONGEST_SENTENCE);
    }
    problems
}

/// A rejected scene file with its problems in the order of the file. Never empty.
#[derive(Clone, Debug)]
pub struct SceneError {
    /// Name of the file as passed by the caller.
    pub file: String,
    /// The first [`MAX_PROBLEMS`] problems.
    pub problems: Vec<SceneProblem>,
    /// Number of omitted problems.
    pub omitted: usize,
    text: String,
}

impl SceneError {
    /// Computes the positions of problems, whose spans are known, in the text.
    pub(super) fn new(file: &str, text: &str, problems: Vec<SceneProblem>) -> Self {
        let omitted = problems.len().saturating_sub(MAX_PROBLEMS);
        Self { file: file.to_owned(), problems: placed(text, problems), omitted, text: text.to_owned() }
    }

    /// `file:line:column: key: what is wrong; what would be right`.
    pub fn header(&self, problem: &SceneProblem) -> String {
        problem.header(&self.file)
    }

    /// The source line of a problem with the offending part underlined.
    pub fn snippet(&self, problem: &SceneProblem) -> String {
        if let Some(elsewhere) = &problem.elsewhere {
            return elsewhere.snippet.clone();
        }
        let Range { start, end } = problem.span;
        // Only this line, or the part around the problem of a long line, because the renderer reads its whole
        // input.
        let line_start = self.text[..start].rfind('\n').map_or(0, |newline| newline + 1);
        let from = boundary(&self.text, start.saturating_sub(LINE_AROUND).max(line_start));
        let to = boundary(&self.text, start.saturating_add(LINE_AROUND));
        let source = &self.text[from..to];
        let line_end = source[start - from..].find('\n').map_or(to, |newline| start + newline);
        let annotation = AnnotationKind::Primary.span(start - from..end.min(line_end) - from);
        let source = Snippet::source(&self.text[from..line_end]).line_start(problem.line);
        let group = Group::with_level(Level::ERROR).element(source.annotation(annotation));
        Renderer::plain().render(&[group])
    }
}

impl fmt::Display for SceneError {
    /// Every problem with its source line, followed by the number of omitted problems.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, problem) in self.problems.iter().enumerate() {
            if i > 0 {
                writeln!(f)?;
            }
            write!(f, "{}\n{}", self.header(problem), self.snippet(problem))?;
        }
        if self.omitted == 0 { Ok(()) } else { write!(f, "\n{}", rest_of(self.omitted)) }
    }
}

impl std::error::Error for SceneError {}

/// Shortens a text to at most this number of bytes.
fn shorten(text: &mut String, most: usize) {
    if text.len() > most {
        text.truncate(boundary(text, most));
        text.push_str("...");
    }
}

/// Line and column of a byte, both from 1; the column counts characters.
fn line_and_column(text: &str, byte: usize) -> (usize, usize) {
    let before = &text[..boundary(text, byte)];
    let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
    (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
}

/// The last character boundary at or before `byte`.
fn boundary(text: &str, byte: usize) -> usize {
    (0..=byte.min(text.len())).rev().find(|&byte| text.is_char_boundary(byte)).unwrap_or(0)
}

/// The part of a span on its first line.
fn first_line(text: &str, span: &Range<usize>) -> Range<usize> {
    let start = boundary(text, span.start);
    let end = boundary(text, span.end).max(start);
    let length = text[start..end].find('\n').unwrap_or(end - start);
    start..start + length
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_count_characters_not_bytes() {
        assert_eq!(line_and_column("a\n é = x", 8), (2, 6));
        assert_eq!(line_and_column("", 0), (1, 1));
        assert_eq!(line_and_column("a", 99), (1, 2));
    }

    #[test]
    fn only_the_first_line_of_a_span_is_shown() {
        assert_eq!(first_line("ab\ncd", &(1..5)), 1..2);
        assert_eq!(first_line("ab\ncd", &(3..5)), 3..5);
    }
}
