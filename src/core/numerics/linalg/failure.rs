//! Failures of factorisations.

use std::fmt;

/// A pivot is zero or not finite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Singular;

impl fmt::Display for Singular {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the matrix is singular: a pivot is zero or not finite")
    }
}

impl std::error::Error for Singular {}

/// The matrix is not positive definite (or not finite).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotPositiveDefinite;

impl fmt::Display for NotPositiveDefinite {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the matrix is not positive definite, or not finite")
    }
}

impl std::error::Error for NotPositiveDefinite {}
