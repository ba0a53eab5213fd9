//! SIMD packs: several doubles processed together.

use super::scalar::Scalar;
use std::ops::{Add, AddAssign, Mul, Neg, Sub};

#[cfg(test)]
use super::counted::count_product;

/// Number of doubles in a [`Pack`]: one 256-bit register, small enough to keep the padding of node counts
/// cheap.
pub const LANES: usize = 4;

/// Several doubles, such as the values of a quantity at neighbouring nodes of a rod.
pub trait Lanes: Scalar + Default {
    /// Whether [`Scalar::mul_add`] is one instruction.
    const FUSED: bool;
    /// Creates a pack from the numbers in the lanes.
    fn from_lanes(lanes: [f64; LANES]) -> Self;
    /// The number in one lane.
    fn lane(&self, lane: usize) -> f64;
    /// Sets the number in one lane.
    fn set_lane(&mut self, lane: usize, value: f64);
    /// Sum of the lanes.
    fn sum(self) -> f64;
}

/// [`LANES`] doubles in a register. `FUSED` packs multiply and add in one instruction with one rounding. On
/// machines without this instruction that would be a slow function call; hence the two kinds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(align(32))]
pub struct Pack<const FUSED: bool>([f64; LANES]);

impl<const FUSED: bool> Lanes for Pack<FUSED> {
    const FUSED: bool = FUSED;

    #[inline(always)]
    fn from_lanes(lanes: [f64; LANES]) -> Self {
        Self(lanes)
    }
    #[inline(always)]
    fn lane(&self, lane: usize) -> f64 {
        self.0[lane]
    }
    #[inline(always)]
    fn set_lane(&mut self, lane: usize, value: f64) {
        self.0[lane] = value;
    }
    #[inline(always)]
    fn sum(self) -> f64 {
        // Pairwise by halves, as hardware reductions do.
        (self.0[0] + self.0[2]) + (self.0[1] + self.0[3])
    }
}

impl<const FUSED: bool> Pack<FUSED> {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        // A plain loop: array::from_fn is not always inlined, and only vectorised when inlined.
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
}

impl<const FUSED: bool> Add for Pack<FUSED> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl<const FUSED: bool> AddAssign for Pack<FUSED> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<const FUSED: bool> Sub for Pack<FUSED> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl<const FUSED: bool> Mul for Pack<FUSED> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        #[cfg(test)]
        count_product();
        self.zip(other, |a, b| a * b)
    }
}

impl<const FUSED: bool> Mul<f64> for Pack<FUSED> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        #[cfg(test)]
        count_product();
        self.map(|a| a * factor)
    }
}

impl<const FUSED: bool> Neg for Pack<FUSED> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|a| -a)
    }
}

impl<const FUSED: bool> Scalar for Pack<FUSED> {
    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self([value; LANES])
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        #[cfg(test)]
        count_product();
        let mut result = addend;
        for ((c, &a), &b) in result.0.iter_mut().zip(&self.0).zip(&factor.0) {
            *c = if FUSED { a.mul_add(b, *c) } else { a * b + *c };
        }
        result
    }
    #[inline(always)]
    fn mul_sub_from(self, factor: Self, minuend: Self) -> Self {
        #[cfg(test)]
        count_product();
        let mut result = minuend;
        for ((c, &a), &b) in result.0.iter_mut().zip(&self.0).zip(&factor.0) {
            *c = if FUSED { (-a).mul_add(b, *c) } else { *c - a * b };
        }
        result
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

/// `start + sum_l weights[l] values_l`, where `values_l` is the quantity in lane `l`, counted through all
/// packs. With rows of an integration matrix as weights this is the integral up to [`LANES`] nodes at once.
/// `add_lane` adds one lane times a weight to every lane.
#[inline(always)]
pub fn weighted_sum<P: Lanes, V: Copy>(
    start: V,
    weights: &[P],
    values: &[V],
    add_lane: impl Fn(V, &V, usize, P) -> V,
) -> V {
    let mut sum = start;
    for (weights, value) in weights.chunks_exact(LANES).zip(values) {
        for (lane, &weight) in weights.iter().enumerate() {
            sum = add_lane(sum, value, lane, weight);
        }
    }
    sum
}
