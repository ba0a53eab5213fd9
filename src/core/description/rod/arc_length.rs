//! Arc lengths along rods.

use crate::error::Checker;

/// Whether `x` is an arc length of a rod of this length. The length is a sum over segments: ten of 0.15 m are 1.4999999999999998 m
/// long, and yet 1.5 m is their tip. A model moves places that are beyond the tip by rounding to the tip.
pub fn is_on_rod(x: f64, length: f64) -> bool {
    /// Rounding of a sum of n lengths is below `n eps` times the sum (Higham 2002, section 4.2): this suffices for thousands.
    const ROUNDING: f64 = 1e-12;
    x >= 0.0 && x <= length * (1.0 + ROUNDING)
}

/// Reports an arc length beyond the end of a rod; other invalid numbers are reported with their part.
pub(crate) fn check_end(check: &mut Checker, x: f64, place: &str, length: f64) {
    if x.is_finite() && x >= 0.0 {
        check_place(check, x, place, length);
    }
}

/// `x` must be an arc length of a rod of this length, or any arc length if the length is infinite. Reports
/// nothing if the length itself is invalid.
pub fn check_place(check: &mut Checker, x: f64, place: &str, length: f64) -> bool {
    let is_inside = x.is_finite() && is_on_rod(x, length);
    if length == f64::INFINITY {
        return check.require(is_inside, place, x, "an arc length >= 0 (metres)");
    }
    let expected = format!("an arc length in [0, {length}] (metres)");
    check.require(is_inside || length.is_nan() || length <= 0.0, place, x, &expected)
}
