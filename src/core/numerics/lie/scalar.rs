//! The scalar types of the vectors and matrices of this module.

use std::ops::{Add, AddAssign, Mul, Neg, Sub};

/// Number type of the vectors of this module: `f64` or [`super::Pack`].
pub trait Scalar:
    Copy
    + std::fmt::Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + Mul<f64, Output = Self>
{
    /// Sets every lane to this number.
    fn splat(value: f64) -> Self;
    /// `self * factor + addend`.
    fn mul_add(self, factor: Self, addend: Self) -> Self;
    /// `minuend - self * factor`.
    fn mul_sub_from(self, factor: Self, minuend: Self) -> Self;
    /// Square root of every lane.
    fn sqrt(self) -> Self;
    /// Reciprocal of every lane.
    fn reciprocal(self) -> Self;
    /// Sine and cosine lane by lane, for angles of any size.
    fn slow_sine_cosine(self) -> (Self, Self);
    /// Largest lane; NaN if a lane is NaN.
    fn largest(self) -> f64;
}

impl Scalar for f64 {
    #[inline(always)]
    fn splat(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        self * factor + addend
    }
    #[inline(always)]
    fn mul_sub_from(self, factor: Self, minuend: Self) -> Self {
        minuend - self * factor
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }
    #[inline(always)]
    fn reciprocal(self) -> Self {
        1.0 / self
    }
    #[inline(always)]
    fn slow_sine_cosine(self) -> (Self, Self) {
        self.sin_cos()
    }
    #[inline(always)]
    fn largest(self) -> f64 {
        self
    }
}
