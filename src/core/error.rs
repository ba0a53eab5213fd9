//! Invalid input: lists of problems with place, value and expectation.
//!
//! lissom reports only invalid input as an error. A numerical outcome (no convergence, a step too small, a
//! non-finite value) is a *status* with a reason in the result of the computation.
//!
//! ```
//! use lissom::rod::Segment;
//!
//! let wrong = Segment::straight(-1.0, 1e-3, 210e9, 80e9, 7800.0).validate().expect_err("no length is negative");
//! assert!(wrong.to_string().contains("length"));
//! ```

use std::borrow::Cow;
use std::fmt;

/// A problem of an input.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// Where: the path of the value, such as `segments[0].radius`.
    pub place: String,
    /// What was found, such as `-0.1`.
    pub found: String,
    /// What would be right, such as `a finite number > 0 (metres)`.
    pub expected: String,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: got {}, expected {}", self.place, shortened(&self.found), self.expected)
    }
}

/// Maximum number of problems in one message; inputs can have millions.
pub const MAX_PROBLEMS: usize = 100;

/// The text, or its beginning and its end if it is too long to read.
pub fn shortened(text: &str) -> Cow<'_, str> {
    /// Maximum number of characters of the whole text, and of each part of a shortened one.
    const LONGEST: usize = 200;
    const LONGEST_PART: usize = 80;
    let Some((at, _)) = text.char_indices().nth(LONGEST_PART).filter(|_| text.chars().nth(LONGEST).is_some())
    else {
        return text.into();
    };
    let end = text.char_indices().rev().nth(LONGEST_PART - 1).map_or(at, |(end, _)| end);
    format!("{} ... {}", &text[..at], &text[end..]).into()
}

/// End of a message that omits some problems.
pub fn rest_of(problems: usize) -> String {
    format!("and {problems} more problem{}", if problems == 1 { "" } else { "s" })
}

/// A rejected input with all its problems. Never empty.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InvalidInput {
    /// The problems, in the order of the input.
    pub problems: Vec<Problem>,
}

impl InvalidInput {
    /// An error with a single problem.
    pub fn new(place: impl Into<String>, found: impl fmt::Display, expected: impl Into<String>) -> Self {
        Self {
            problems: vec![Problem {
                place: place.into(),
                found: found.to_string(),
                expected: expected.into(),
            }],
        }
    }
}

impl fmt::Display for InvalidInput {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (first, rest) = self.problems.split_at(self.problems.len().min(MAX_PROBLEMS));
        for (i, problem) in first.iter().enumerate() {
            if i > 0 {
                writeln!(f)?;
            }
            write!(f, "{problem}")?;
        }
        if rest.is_empty() { Ok(()) } else { write!(f, "\n{}", rest_of(rest.len())) }
    }
}

impl std::error::Error for InvalidInput {}

/// Formats a number for messages: very large and very small values with an exponent.
#[derive(Clone, Copy, Debug)]
pub struct Number(pub f64);

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(value) = *self;
        let is_handy = value == 0.0 || !value.is_finite() || (1e-6..1e16).contains(&value.abs());
        if is_handy { write!(f, "{value}") } else { write!(f, "{value:e}") }
    }
}

/// A computed number in messages, to three digits.
#[derive(Clone, Copy, Debug)]
pub struct Rounded(pub f64);

impl fmt::Display for Rounded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        rounded(self.0, 3).fmt(f)
    }
}

/// The time in a run in messages, without what steps add by rounding: `0.142`, not `0.14200000000000002`.
#[derive(Clone, Copy, Debug)]
pub struct Time(pub f64);

impl fmt::Display for Time {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        rounded(self.0, 10).fmt(f)
    }
}

fn rounded(number: f64, digits: usize) -> Number {
    Number(format!("{number:.*e}", digits - 1).parse().unwrap_or(number))
}

/// Collects the problems of an input, so that all of them are reported at once.
#[derive(Debug, Default)]
pub struct Checker {
    problems: Vec<Problem>,
}

impl Checker {
    /// A checker without problems.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a problem.
    pub fn refuse(
        &mut self,
        place: impl Into<String>,
        found: impl fmt::Display,
        expected: impl Into<String>,
    ) {
        let (place, expected) = (place.into(), expected.into());
        self.problems.push(Problem { place, found: found.to_string(), expected });
    }

    /// Adds a problem unless `ok`; returns `ok`.
    pub fn require(&mut self, ok: bool, place: &str, found: impl fmt::Display, expected: &str) -> bool {
        if !ok {
            self.refuse(place, found, expected);
        }
        ok
    }

    /// `value` must be finite and positive; `unit` ends the sentence, such as `metres`.
    pub fn positive(&mut self, value: f64, place: &str, unit: &str) -> bool {
        let ok = value.is_finite() && value > 0.0;
        if !ok {
            self.refuse(place, Number(value), format!("a finite number > 0 ({unit})"));
        }
        ok
    }

    /// `value` must be finite and not negative.
    pub fn non_negative(&mut self, value: f64, place: &str, unit: &str) -> bool {
        let ok = value.is_finite() && value >= 0.0;
        if !ok {
            self.refuse(place, Number(value), format!("a finite number >= 0 ({unit})"));
        }
        ok
    }

    /// Every entry of `values` must be finite; a problem is reported at `place[i]`.
    pub fn finite(&mut self, values: &[f64], place: &str) -> bool {
        // Formats names only for offending entries, because every array from Python passes through this
        // check.
        let mut offenders = values.iter().enumerate().filter(|(_, value)| !value.is_finite()).peekable();
        let ok = offenders.peek().is_none();
        for (i, &value) in offenders {
            self.require(false, &format!("{place}[{i}]"), Number(value), "a finite number");
        }
        ok
    }

    /// `values` must have `expected` entries.
    pub fn length(&mut self, values: &[f64], expected: usize, place: &str) -> bool {
        let ok = values.len() == expected;
        if !ok {
            self.refuse(place, format_args!("{} values", values.len()), format!("{expected} values"));
        }
        ok
    }

    /// Adds the problems of a nested input located at `place`.
    pub fn nested<T>(&mut self, place: &str, result: Result<T, InvalidInput>) -> Option<T> {
        match result {
            Ok(value) => Some(value),
            Err(error) => {
                self.problems.extend(
                    error
                        .problems
                        .into_iter()
                        .map(|problem| Problem { place: format!("{place}.{}", problem.place), ..problem }),
                );
                None
            }
        }
    }

    /// Adds problems of the same input that were found elsewhere.
    pub fn all(&mut self, result: Result<(), InvalidInput>) {
        if let Err(error) = result {
            self.problems.extend(error.problems);
        }
    }

    /// True if no problem was found so far.
    pub fn is_ok(&self) -> bool {
        self.problems.is_empty()
    }

    /// `Ok` without problems, otherwise all of them.
    pub fn finish(self) -> Result<(), InvalidInput> {
        if self.problems.is_empty() { Ok(()) } else { Err(InvalidInput { problems: self.problems }) }
    }
}

/// A request to stop the computation, such as Ctrl-C or a failed callback. The caller that requested the stop
/// keeps the reason; the core only passes the request on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Interrupted;

impl fmt::Display for Interrupted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the computation was asked to stop")
    }
}

impl std::error::Error for Interrupted {}

/// The result of an interrupted computation ([`Interrupted`]): what it had computed by then, in the
/// type of its complete result.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unfinished<T>(Box<T>);

impl<T> Unfinished<T> {
    /// An unfinished result.
    pub fn new(result: T) -> Self {
        Self(Box::new(result))
    }

    /// What was computed.
    pub fn into_inner(self) -> T {
        *self.0
    }

    /// For functions that need the complete result, and pass on the interruption alone.
    pub fn interrupted(self) -> Interrupted {
        Interrupted
    }

    /// Converts what was computed.
    pub fn map<U>(self, convert: impl FnOnce(T) -> U) -> Unfinished<U> {
        Unfinished::new(convert(*self.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_have_the_first_hundred_problems_and_the_number_of_the_rest() {
        let mut checker = Checker::new();
        checker.finite(&[f64::NAN; 100], "x");
        assert!(!checker.finish().unwrap_err().to_string().contains("more"));
        let mut checker = Checker::new();
        checker.finite(&[f64::NAN; 1234], "x");
        let message = checker.finish().unwrap_err().to_string();
        assert_eq!(message.lines().count(), 101);
        assert!(message.contains("x[99]: ") && message.ends_with("\nand 1134 more problems"), "{message}");
    }

    #[test]
    fn numbers_in_messages_are_short() {
        let texts = [0.0, -0.000001, 0.1, -12.5, 9e15, f64::INFINITY, 1e-300, -1e300, 5e-324]
            .map(|value| Number(value).to_string());
        assert_eq!(
            texts,
            ["0", "-0.000001", "0.1", "-12.5", "9000000000000000", "inf", "1e-300", "-1e300", "5e-324"]
        );
        let mut checker = Checker::new();
        checker.positive(-1e-300, "dt", "seconds");
        let error = checker.finish().unwrap_err();
        assert_eq!(error.to_string(), "dt: got -1e-300, expected a finite number > 0 (seconds)");
    }
}
