//! Rotations: unit quaternions to compose them, matrices to apply them.

use super::sine_cosine::sine_cosine;
use super::{Lanes, Scalar, Vector};

/// Quaternions whose norm differs from one by more than this are rejected rather than normalised.
pub const QUATERNION_TOLERANCE: f64 = 1e-3;

/// A unit quaternion (w, x, y, z) that turns body axes into world axes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs, reason = "the components of a quaternion")]
pub struct Quaternion<T> {
    pub w: T,
    pub v: Vector<T>,
}

/// Up to this squared half-angle the exponential is a Taylor polynomial, which avoids a division by small
/// angles.
const TAYLOR_LIMIT: f64 = 0.25;

/// Taylor coefficients of cos(sqrt x): (-1)^k / (2k)!. With x up to [`TAYLOR_LIMIT`] the remainder is below 1e-18.
const COSINE: [f64; 9] = [
    1.0,
    -1.0 / 2.0,
    1.0 / 24.0,
    -1.0 / 720.0,
    1.0 / 40_320.0,
    -1.0 / 3_628_800.0,
    1.0 / 479_001_600.0,
    -1.0 / 87_178_291_200.0,
    1.0 / 20_922_789_888_000.0,
];

/// Taylor coefficients of sin(sqrt x) / sqrt x: (-1)^k / (2k+1)!.
const SINE: [f64; 9] = [
    1.0,
    -1.0 / 6.0,
    1.0 / 120.0,
    -1.0 / 5_040.0,
    1.0 / 362_880.0,
    -1.0 / 39_916_800.0,
    1.0 / 6_227_020_800.0,
    -1.0 / 1_307_674_368_000.0,
    1.0 / 355_687_428_096_000.0,
];

#[inline(always)]
fn polynomial<T: Scalar>(coefficients: &[f64; 9], x: T) -> T {
    coefficients.iter().rev().fold(T::splat(0.0), |sum, &c| sum.mul_add(x, T::splat(c)))
}

impl<T: Scalar> Quaternion<T> {
    /// The rotation by the rotation vector `omega` (radians).
    #[inline(always)]
    pub fn exp(omega: Vector<T>) -> Self {
        let squared_half_angle = omega.dot(omega) * 0.25;
        let (cosine, sine_over_angle) = if squared_half_angle.largest() <= TAYLOR_LIMIT {
            (polynomial(&COSINE, squared_half_angle), polynomial(&SINE, squared_half_angle))
        } else {
            // Avoids a division by zero in lanes with a vanishing angle, whose rotation vector vanishes too.
            let half_angle = (squared_half_angle + T::splat(f64::MIN_POSITIVE)).sqrt();
            let (sine, cosine) = sine_cosine(half_angle);
            (cosine, sine * half_angle.reciprocal())
        };
        Self { w: cosine, v: omega * (sine_over_angle * 0.5) }
    }

    /// Composition: first `other`, then `self`.
    #[inline(always)]
    pub fn times(self, other: Self) -> Self {
        Self {
            w: (-self.v).dot_add(other.v, self.w * other.w),
            v: self.v.cross_add(other.v, (other.v * self.w).add_scaled(self.v, other.w)),
        }
    }

    /// The same rotation, normalised to rounding.
    #[inline(always)]
    pub fn normalised(self) -> Self {
        let factor = self.v.dot_add(self.v, self.w * self.w).sqrt().reciprocal();
        Self { w: self.w * factor, v: self.v * factor }
    }

    /// The rotation matrix.
    #[inline(always)]
    pub fn rotation(self) -> Rotation<T> {
        let Self { w, v: Vector { x, y, z } } = self;
        let one = T::splat(1.0);
        let two = |a: T| a + a;
        Rotation {
            x: Vector::new(one - two(y * y + z * z), two(x * y + w * z), two(x * z - w * y)),
            y: Vector::new(two(x * y - w * z), one - two(x * x + z * z), two(y * z + w * x)),
            z: Vector::new(two(x * z + w * y), two(y * z - w * x), one - two(x * x + y * y)),
        }
    }
}

impl Quaternion<f64> {
    /// From a rotation matrix, by the largest of the four squares, so that no divisor is small (Shepperd
    /// 1978).
    pub fn of_rotation(r: &Rotation<f64>) -> Self {
        let [xx, yy, zz] = [r.x.x, r.y.y, r.z.z];
        let squares = [1.0 + xx + yy + zz, 1.0 + xx - yy - zz, 1.0 - xx + yy - zz, 1.0 - xx - yy + zz];
        let largest = (1..4).fold(0, |i, k| if squares[k] > squares[i] { k } else { i });
        let [x, y, z] = [r.y.z - r.z.y, r.z.x - r.x.z, r.x.y - r.y.x];
        let [xy, xz, yz] = [r.x.y + r.y.x, r.x.z + r.z.x, r.y.z + r.z.y];
        let products = match largest {
            0 => [squares[0], x, y, z],
            1 => [x, squares[1], xy, xz],
            2 => [y, xy, squares[2], yz],
            _ => [z, xz, yz, squares[3]],
        };
        Self::from_array(products)
    }

    /// From (w, x, y, z), which need not be normalised exactly.
    pub fn from_array([w, x, y, z]: [f64; 4]) -> Self {
        Self { w, v: Vector { x, y, z } }.normalised()
    }
}

impl<P: Lanes> Quaternion<P> {
    /// The quaternion in one lane.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> Quaternion<f64> {
        Quaternion { w: self.w.lane(lane), v: self.v.lane(lane) }
    }

    /// Sets the quaternion in one lane.
    #[inline(always)]
    pub fn set_lane(&mut self, lane: usize, quaternion: Quaternion<f64>) {
        self.w.set_lane(lane, quaternion.w);
        self.v.set_lane(lane, quaternion.v);
    }
}

/// A rotation matrix by its columns: the body axes in world coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs, reason = "the body axes")]
pub struct Rotation<T> {
    pub x: Vector<T>,
    pub y: Vector<T>,
    pub z: Vector<T>,
}

impl<T: Scalar> Rotation<T> {
    /// No rotation.
    #[inline(always)]
    pub fn identity() -> Self {
        let axis = |entries: [f64; 3]| Vector::splat(entries);
        Self { x: axis([1.0, 0.0, 0.0]), y: axis([0.0, 1.0, 0.0]), z: axis([0.0, 0.0, 1.0]) }
    }

    /// Composition: first `other`, then `self`.
    #[inline(always)]
    pub fn times(&self, other: &Self) -> Self {
        Self { x: self.apply(other.x), y: self.apply(other.y), z: self.apply(other.z) }
    }

    /// World coordinates of a vector given in body axes.
    #[inline(always)]
    pub fn apply(&self, v: Vector<T>) -> Vector<T> {
        (self.x * v.x).add_scaled(self.y, v.y).add_scaled(self.z, v.z)
    }

    /// Body coordinates of a vector given in world axes.
    #[inline(always)]
    pub fn apply_transposed(&self, v: Vector<T>) -> Vector<T> {
        Vector::new(self.x.dot(v), self.y.dot(v), self.z.dot(v))
    }

    /// Body axis 0, 1 or 2.
    #[inline(always)]
    pub fn axis(&self, index: usize) -> Vector<T> {
        [self.x, self.y, self.z][index]
    }
}

impl<P: Lanes> Rotation<P> {
    /// The rotation in one lane.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> Rotation<f64> {
        Rotation { x: self.x.lane(lane), y: self.y.lane(lane), z: self.z.lane(lane) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Pack;
    use super::*;

    #[test]
    fn the_exponential_agrees_with_the_formula_of_rodrigues_on_both_branches() {
        let axis = Vector { x: 2.0 / 7.0, y: -3.0 / 7.0, z: 6.0 / 7.0 };
        for angle in [0.0, 1e-300, 1e-12, 1e-3, 0.5, 0.999_999, 1.0, 1.000_001, 3.0, 6.3, 40.0, -2.0] {
            let rotation = Quaternion::exp(axis * angle).rotation();
            let v = Vector { x: 0.3, y: -1.0, z: 0.7 };
            let wanted =
                v * angle.cos() + axis.cross(v) * angle.sin() + axis * (axis.dot(v) * (1.0 - angle.cos()));
            let difference = rotation.apply(v) - wanted;
            assert!(difference.dot(difference).sqrt() < 4e-15, "angle {angle}: {difference:?}");
            let omega = Vector::<Pack<false>>::splat((axis * angle).to_array());
            assert_eq!(Quaternion::exp(omega).rotation().lane(2), rotation, "lanes do what scalars do");
        }
    }

    #[test]
    fn quaternions_are_found_from_their_matrices() {
        for omega in [[0.0; 3], [0.3, -0.2, 0.9], [3.1, 0.1, 0.0], [0.0, 3.15, 0.0], [0.1, 0.2, -3.1]] {
            let quaternion = Quaternion::exp(Vector::from(omega));
            let found = Quaternion::of_rotation(&quaternion.rotation());
            let sign = if found.w * quaternion.w + found.v.dot(quaternion.v) < 0.0 { -1.0 } else { 1.0 };
            let difference = found.v * sign - quaternion.v;
            assert!(difference.dot(difference).sqrt() < 1e-15, "{omega:?}: {found:?}");
            assert!((found.w * sign - quaternion.w).abs() < 1e-15);
        }
    }

    #[test]
    fn composition_applies_the_right_factor_first() {
        let quarter = std::f64::consts::FRAC_PI_2;
        let about_x = Quaternion::exp(Vector { x: quarter, y: 0.0, z: 0.0 });
        let about_z = Quaternion::exp(Vector { x: 0.0, y: 0.0, z: quarter });
        // e_y rotated about x gives e_z, which a rotation about z does not change.
        let v = about_z.times(about_x).rotation().apply(Vector { x: 0.0, y: 1.0, z: 0.0 });
        assert!((v.z - 1.0).abs() < 1e-15 && v.x.abs() < 1e-15 && v.y.abs() < 1e-15);
    }
}
