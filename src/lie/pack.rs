//! Several doubles that take every operation together.

use std::ops::{Add, AddAssign, Mul, Neg, Sub};

#[cfg(test)]
use super::counted::note;

/// Number of doubles in a [`Pack`]: one 256-bit register, and few enough that node counts round up cheaply.
pub const LANES: usize = 4;

/// What the vectors of this module are made of: `f64` or [`Pack`].
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
    /// The number in every lane.
    fn splat(value: f64) -> Self;
    /// The square root of every lane.
    fn sqrt(self) -> Self;
    /// One over every lane.
    fn reciprocal(self) -> Self;
    /// Sine and cosine of every lane, one by one, for angles of any size.
    fn slow_sine_cosine(self) -> (Self, Self);
    /// Largest lane; NaN where a lane is NaN.
    fn largest(self) -> f64;
}

impl Scalar for f64 {
    #[inline(always)]
    fn splat(value: f64) -> Self {
        value
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

/// [`LANES`] doubles, such as the values of a quantity at neighbouring nodes of a rod.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(align(32))]
pub struct Pack(pub [f64; LANES]);

impl Pack {
    /// Zero in every lane.
    pub const ZERO: Self = Self([0.0; LANES]);

    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        // A plain loop: array::from_fn is not always inlined, and vectorised only where it is.
        let mut result = self;
        for (a, &b) in result.0.iter_mut().zip(&other.0) {
            *a = f(*a, b);
        }
        result
    }

    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        let mut result = self;
        for a in &mut result.0 {
            *a = f(*a);
        }
        result
    }

    /// The sum of the lanes.
    #[inline(always)]
    pub fn sum(self) -> f64 {
        (self.0[0] + self.0[1]) + (self.0[2] + self.0[3])
    }
}

impl Add for Pack {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl AddAssign for Pack {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for Pack {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl Mul for Pack {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        #[cfg(test)]
        note(1);
        self.zip(other, |a, b| a * b)
    }
}

impl Mul<f64> for Pack {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        #[cfg(test)]
        note(1);
        self.map(|a| a * factor)
    }
}

impl Neg for Pack {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|a| -a)
    }
}

impl Scalar for Pack {
    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self([value; LANES])
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.map(f64::sqrt)
    }
    #[inline(always)]
    fn reciprocal(self) -> Self {
        self.map(|a| 1.0 / a)
    }
    #[inline(always)]
    fn slow_sine_cosine(self) -> (Self, Self) {
        (self.map(f64::sin), self.map(f64::cos))
    }
    #[inline(always)]
    fn largest(self) -> f64 {
        let [a, b, c, d] = self.0;
        let larger = |a: f64, b: f64| if a > b || a.is_nan() { a } else { b };
        larger(larger(a, b), larger(c, d))
    }
}

/// `start + sum_l weights[l] values_l`, where `values_l` is the quantity in lane `l` counted through all packs:
/// with the rows of an integration matrix as weights, the integral up to [`LANES`] nodes at once. `broadcast` puts what
/// stands in one lane into every lane.
#[inline(always)]
pub fn weighted_sum<V: Copy + AddAssign + Mul<Pack, Output = V>>(
    start: V,
    weights: &[Pack],
    values: &[V],
    broadcast: impl Fn(&V, usize) -> V,
) -> V {
    let mut sum = start;
    for (weights, value) in weights.chunks_exact(LANES).zip(values) {
        for (lane, &weight) in weights.iter().enumerate() {
            sum += broadcast(value, lane) * weight;
        }
    }
    sum
}
