//! A number type that counts operations, to find the cost of a formula.

use std::cell::Cell;
use std::ops::{Add, AddAssign, Mul, Neg, Sub};

use super::scalar::Scalar;

thread_local! {
    static PRODUCTS: Cell<u64> = const { Cell::new(0) };
}

/// Number of products of [`Counted`] numbers during `formula`; each one stands for a double. Sums are free,
/// as on a machine with fused multiply-adds.
pub fn products<R>(formula: impl FnOnce() -> R) -> u64 {
    let before = PRODUCTS.get();
    formula();
    PRODUCTS.get() - before
}

/// Adds to the number of products.
#[inline(always)]
pub(super) fn note(number: u64) {
    PRODUCTS.set(PRODUCTS.get() + number);
}

/// Stands for a double in formulas that are generic over a [`Scalar`]. Its value is zero in comparisons: if a
/// formula has a special branch for small numbers, that branch is counted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counted;

impl Add for Counted {
    type Output = Self;
    fn add(self, _: Self) -> Self {
        Self
    }
}

impl AddAssign for Counted {
    fn add_assign(&mut self, _: Self) {}
}

impl Sub for Counted {
    type Output = Self;
    fn sub(self, _: Self) -> Self {
        Self
    }
}

impl Neg for Counted {
    type Output = Self;
    fn neg(self) -> Self {
        Self
    }
}

impl Mul for Counted {
    type Output = Self;
    fn mul(self, _: Self) -> Self {
        note(1);
        Self
    }
}

impl Mul<f64> for Counted {
    type Output = Self;
    fn mul(self, _: f64) -> Self {
        note(1);
        Self
    }
}

impl Scalar for Counted {
    fn splat(_: f64) -> Self {
        Self
    }
    fn mul_add(self, _: Self, _: Self) -> Self {
        note(1);
        Self
    }
    fn mul_sub_from(self, _: Self, _: Self) -> Self {
        note(1);
        Self
    }
    fn sqrt(self) -> Self {
        Self
    }
    fn reciprocal(self) -> Self {
        Self
    }
    fn slow_sine_cosine(self) -> (Self, Self) {
        (Self, Self)
    }
    fn largest(self) -> f64 {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Quaternion, Vector};
    use super::*;

    #[test]
    fn textbook_numbers_of_products() {
        let v = Vector::<Counted>::zero();
        assert_eq!(products(|| v + v), 0);
        assert_eq!(products(|| v * Counted), 3);
        assert_eq!(products(|| v.dot(v)), 3);
        assert_eq!(products(|| v.cross(v)), 6);
        let quaternion = Quaternion { w: Counted, v };
        assert_eq!(products(|| quaternion.times(quaternion)), 16);
    }
}
