//! Memory limits, checked before an allocation that could end the process.

use std::fmt::Display;

use crate::error::InvalidInput;

/// Largest memory for the points of a result, in bytes (4 GiB). A larger request is more likely a mistake in
/// the step size.
pub const LARGEST_RESULT: usize = 1 << 32;

/// Largest memory for one array or for the matrices of a problem, in bytes (64 GiB): factorising a matrix of
/// that size takes days. Some systems grant any request and end the process once the memory is used.
const LARGEST_PROBLEM: usize = 1 << 36;

/// Largest number of points of a result with this many numbers per point.
pub fn points_in_memory(numbers: usize) -> usize {
    LARGEST_RESULT / size_of::<f64>().saturating_mul(numbers.max(1))
}

/// Rejects a problem whose numbers cannot be allocated (the count may be saturated): `found` at `place`;
/// `instead` suggests a problem that takes less memory.
pub fn check(numbers: usize, place: &str, found: impl Display, instead: &str) -> Result<(), InvalidInput> {
    let is_sensible = numbers <= LARGEST_PROBLEM / size_of::<f64>();
    if is_sensible && Vec::<f64>::new().try_reserve_exact(numbers).is_ok() {
        return Ok(());
    }
    let gigabytes = numbers as f64 * size_of::<f64>() as f64 / 1e9;
    let expected = format!("what fits in memory; this takes {gigabytes:.1} GB: {instead}");
    Err(InvalidInput::new(place, found, expected))
}

/// The same for dense matrices of n x n numbers for a problem of `n` values.
pub fn check_square(matrices: usize, n: usize, place: &str, instead: &str) -> Result<(), InvalidInput> {
    check(matrices.saturating_mul(n).saturating_mul(n), place, format_args!("{n} values"), instead)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_allocated_is_refused_with_its_size() {
        assert!(check(1000, "x0", "1000 values", "take fewer").is_ok());
        for numbers in [usize::MAX, 1 << 60, 1 << 50] {
            let error = check(numbers, "x0", "many values", "take fewer").unwrap_err().to_string();
            assert!(
                error.starts_with("x0: got many values") && error.ends_with(" GB: take fewer"),
                "{error}"
            );
        }
        assert!(check_square(3, usize::MAX, "x0", "take fewer").is_err());
        assert_eq!(points_in_memory(0), points_in_memory(1));
        assert_eq!(points_in_memory(usize::MAX), 0);
    }
}
