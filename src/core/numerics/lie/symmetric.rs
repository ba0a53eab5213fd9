//! Symmetric 3 x 3 matrices.

use std::ops::{Add, AddAssign, Mul, Sub};

use super::{Lanes, Scalar, Vector};

/// A symmetric matrix, stored as six entries.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[allow(missing_docs, reason = "the entries of a matrix")]
pub struct Symmetric<T> {
    pub xx: T,
    pub yy: T,
    pub zz: T,
    pub xy: T,
    pub xz: T,
    pub yz: T,
}

impl<T: Scalar> Symmetric<T> {
    /// A multiple of the identity.
    #[inline(always)]
    pub fn diagonal(value: T) -> Self {
        let zero = T::splat(0.0);
        Self { xx: value, yy: value, zz: value, xy: zero, xz: zero, yz: zero }
    }

    /// The same matrix in every lane.
    #[inline(always)]
    pub fn all(a: Symmetric<f64>) -> Self {
        Self {
            xx: T::splat(a.xx),
            yy: T::splat(a.yy),
            zz: T::splat(a.zz),
            xy: T::splat(a.xy),
            xz: T::splat(a.xz),
            yz: T::splat(a.yz),
        }
    }

    /// `v v^T`.
    #[inline(always)]
    pub fn square(v: Vector<T>) -> Self {
        Self { xx: v.x * v.x, yy: v.y * v.y, zz: v.z * v.z, xy: v.x * v.y, xz: v.x * v.z, yz: v.y * v.z }
    }

    /// `a b^T + b a^T`.
    #[inline(always)]
    pub fn product(a: Vector<T>, b: Vector<T>) -> Self {
        let twice = |p: T| p + p;
        Self {
            xx: twice(a.x * b.x),
            yy: twice(a.y * b.y),
            zz: twice(a.z * b.z),
            xy: a.x * b.y + a.y * b.x,
            xz: a.x * b.z + a.z * b.x,
            yz: a.y * b.z + a.z * b.y,
        }
    }

    /// `A + A^T` of the matrix A with these rows.
    #[inline(always)]
    pub fn sum_with_transpose(rows: [Vector<T>; 3]) -> Self {
        let [x, y, z] = rows;
        Self { xx: x.x + x.x, yy: y.y + y.y, zz: z.z + z.z, xy: x.y + y.x, xz: x.z + z.x, yz: y.z + z.y }
    }

    /// The rows.
    #[inline(always)]
    pub fn rows(&self) -> [Vector<T>; 3] {
        [
            Vector::new(self.xx, self.xy, self.xz),
            Vector::new(self.xy, self.yy, self.yz),
            Vector::new(self.xz, self.yz, self.zz),
        ]
    }

    /// Matrix times vector.
    #[inline(always)]
    pub fn times(&self, v: Vector<T>) -> Vector<T> {
        let [x, y, z] = self.rows();
        Vector::new(x.dot(v), y.dot(v), z.dot(v))
    }
}

impl<P: Lanes> Symmetric<P> {
    /// Sum of the matrices in the lanes.
    #[inline(always)]
    pub fn sum(self) -> Symmetric<f64> {
        Symmetric {
            xx: self.xx.sum(),
            yy: self.yy.sum(),
            zz: self.zz.sum(),
            xy: self.xy.sum(),
            xz: self.xz.sum(),
            yz: self.yz.sum(),
        }
    }
}

impl<T: Scalar> Add for Symmetric<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self {
            xx: self.xx + other.xx,
            yy: self.yy + other.yy,
            zz: self.zz + other.zz,
            xy: self.xy + other.xy,
            xz: self.xz + other.xz,
            yz: self.yz + other.yz,
        }
    }
}

impl<T: Scalar> AddAssign for Symmetric<T> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<T: Scalar> Sub for Symmetric<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self + other * T::splat(-1.0)
    }
}

impl<T: Scalar> Mul<T> for Symmetric<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: T) -> Self {
        Self {
            xx: self.xx * factor,
            yy: self.yy * factor,
            zz: self.zz * factor,
            xy: self.xy * factor,
            xz: self.xz * factor,
            yz: self.yz * factor,
        }
    }
}
