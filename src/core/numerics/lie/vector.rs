//! Three-dimensional vectors.

use std::ops::{Add, AddAssign, Mul, Neg, Sub};

use super::{Lanes, Scalar};

/// A three-dimensional vector.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[allow(missing_docs, reason = "the components of a vector")]
pub struct Vector<T> {
    pub x: T,
    pub y: T,
    pub z: T,
}

impl<T: Scalar> Vector<T> {
    /// A vector from its components.
    #[inline(always)]
    pub fn new(x: T, y: T, z: T) -> Self {
        Self { x, y, z }
    }

    /// The zero vector.
    #[inline(always)]
    pub fn zero() -> Self {
        Self::splat([0.0; 3])
    }

    /// The same vector in every lane.
    #[inline(always)]
    pub fn splat(v: [f64; 3]) -> Self {
        Self::new(T::splat(v[0]), T::splat(v[1]), T::splat(v[2]))
    }

    /// The same vector in every lane.
    #[inline(always)]
    pub fn all(v: Vector<f64>) -> Self {
        Self::splat([v.x, v.y, v.z])
    }

    /// Vector product.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self::new(
            self.z.mul_sub_from(other.y, self.y * other.z),
            self.x.mul_sub_from(other.z, self.z * other.x),
            self.y.mul_sub_from(other.x, self.x * other.y),
        )
    }

    /// `self x other + sum`.
    #[inline(always)]
    pub fn cross_add(self, other: Self, sum: Self) -> Self {
        Self::new(
            self.y.mul_add(other.z, self.z.mul_sub_from(other.y, sum.x)),
            self.z.mul_add(other.x, self.x.mul_sub_from(other.z, sum.y)),
            self.x.mul_add(other.y, self.y.mul_sub_from(other.x, sum.z)),
        )
    }

    /// `self + other * factor`.
    #[inline(always)]
    pub fn add_scaled(self, other: Self, factor: T) -> Self {
        Self::new(
            other.x.mul_add(factor, self.x),
            other.y.mul_add(factor, self.y),
            other.z.mul_add(factor, self.z),
        )
    }

    /// Component 0, 1 or 2.
    #[inline(always)]
    pub fn component_mut(&mut self, index: usize) -> &mut T {
        match index {
            0 => &mut self.x,
            1 => &mut self.y,
            _ => &mut self.z,
        }
    }

    /// Scalar product.
    #[inline(always)]
    pub fn dot(self, other: Self) -> T {
        self.x.mul_add(other.x, self.y.mul_add(other.y, self.z * other.z))
    }

    /// `self . other + sum`.
    #[inline(always)]
    pub fn dot_add(self, other: Self, sum: T) -> T {
        self.x.mul_add(other.x, self.y.mul_add(other.y, self.z.mul_add(other.z, sum)))
    }
}

impl Vector<f64> {
    /// The components in an array.
    pub fn to_array(self) -> [f64; 3] {
        [self.x, self.y, self.z]
    }
}

impl From<[f64; 3]> for Vector<f64> {
    fn from(v: [f64; 3]) -> Self {
        Self::splat(v)
    }
}

impl<P: Lanes> Vector<P> {
    /// The vector in one lane.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> Vector<f64> {
        Vector { x: self.x.lane(lane), y: self.y.lane(lane), z: self.z.lane(lane) }
    }

    /// The sum of the vectors in the lanes.
    #[inline(always)]
    pub fn sum(self) -> Vector<f64> {
        Vector { x: self.x.sum(), y: self.y.sum(), z: self.z.sum() }
    }

    /// Sets the vector in one lane.
    #[inline(always)]
    pub fn set_lane(&mut self, lane: usize, v: Vector<f64>) {
        self.x.set_lane(lane, v.x);
        self.y.set_lane(lane, v.y);
        self.z.set_lane(lane, v.z);
    }
}

impl<T: Scalar> Add for Vector<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self::new(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}

impl<T: Scalar> AddAssign for Vector<T> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<T: Scalar> Sub for Vector<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self::new(self.x - other.x, self.y - other.y, self.z - other.z)
    }
}

impl<T: Scalar> Neg for Vector<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(-self.x, -self.y, -self.z)
    }
}

impl<T: Scalar> Mul<T> for Vector<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: T) -> Self {
        Self::new(self.x * factor, self.y * factor, self.z * factor)
    }
}
