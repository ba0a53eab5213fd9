//! Three-dimensional geometry.

use super::geometry::{Cross, Geometry, SecondMoment, VectorSpace};
use super::{Pack, Rotation, Scalar, Symmetric, Vector};

/// Motions in three dimensions, computed with [`Pack<FUSED>`].
#[derive(Clone, Copy, Debug, Default)]
pub struct Spatial<const FUSED: bool>;

impl<T: Scalar> VectorSpace<T> for Vector<T> {
    #[inline(always)]
    fn zero() -> Self {
        Self::zero()
    }
    #[inline(always)]
    fn add_scaled(self, other: Self, factor: T) -> Self {
        self.add_scaled(other, factor)
    }
    #[inline(always)]
    fn dot(self, other: Self) -> T {
        self.dot(other)
    }
    #[inline(always)]
    fn dot_add(self, other: Self, sum: T) -> T {
        self.dot_add(other, sum)
    }
}

impl<T: Scalar> Cross<Self> for Vector<T> {
    type Output = Self;
    #[inline(always)]
    fn cross(self, other: Self) -> Self {
        self.cross(other)
    }
    #[inline(always)]
    fn cross_add(self, other: Self, sum: Self) -> Self {
        self.cross_add(other, sum)
    }
}

impl<T: Scalar> SecondMoment for Symmetric<T> {
    #[inline(always)]
    fn zero() -> Self {
        Self::diagonal(T::splat(0.0))
    }
}

impl<const FUSED: bool> Geometry for Spatial<FUSED> {
    type Pack = Pack<FUSED>;
    type Frame = ();
    type Axial<T: Scalar> = Vector<T>;
    type Vector<T: Scalar> = Vector<T>;
    type Rotation<T: Scalar> = Rotation<T>;
    type SecondMoment<T: Scalar> = Symmetric<T>;

    const ANGULAR: usize = 3;
    const COMPONENTS: usize = 6;

    #[inline(always)]
    fn map_axial<T: Scalar, U: Scalar>(a: &Vector<T>, f: impl Fn(&T) -> U) -> Vector<U> {
        Vector { x: f(&a.x), y: f(&a.y), z: f(&a.z) }
    }
    #[inline(always)]
    fn map_vector<T: Scalar, U: Scalar>(v: &Vector<T>, f: impl Fn(&T) -> U) -> Vector<U> {
        Vector { x: f(&v.x), y: f(&v.y), z: f(&v.z) }
    }
    #[inline(always)]
    fn map_second_moment<T: Scalar, U: Scalar>(m: &Symmetric<T>, f: impl Fn(&T) -> U) -> Symmetric<U> {
        Symmetric { xx: f(&m.xx), yy: f(&m.yy), zz: f(&m.zz), xy: f(&m.xy), xz: f(&m.xz), yz: f(&m.yz) }
    }
    #[inline(always)]
    fn map_rotation<T: Scalar, U: Scalar>(r: &Rotation<T>, f: impl Fn(&T) -> U) -> Rotation<U> {
        let map = |v: &Vector<T>| Vector { x: f(&v.x), y: f(&v.y), z: f(&v.z) };
        Rotation { x: map(&r.x), y: map(&r.y), z: map(&r.z) }
    }

    #[inline(always)]
    fn axial_component<T: Scalar>(a: &mut Vector<T>, index: usize) -> &mut T {
        a.component_mut(index)
    }
    #[inline(always)]
    fn vector_component<T: Scalar>(v: &mut Vector<T>, index: usize) -> &mut T {
        v.component_mut(index)
    }

    #[inline(always)]
    fn unrotated<T: Scalar>() -> Rotation<T> {
        let axis = |x, y, z| Vector::splat([x, y, z]);
        Rotation { x: axis(1.0, 0.0, 0.0), y: axis(0.0, 1.0, 0.0), z: axis(0.0, 0.0, 1.0) }
    }
    #[inline(always)]
    fn rotate<T: Scalar>(r: &Rotation<T>, v: Vector<T>) -> Vector<T> {
        r.apply(v)
    }
    #[inline(always)]
    fn rotate_back<T: Scalar>(r: &Rotation<T>, v: Vector<T>) -> Vector<T> {
        r.apply_transposed(v)
    }
    #[inline(always)]
    fn rotate_axial<T: Scalar>(r: &Rotation<T>, a: Vector<T>) -> Vector<T> {
        r.apply(a)
    }
    #[inline(always)]
    fn rotate_axial_back<T: Scalar>(r: &Rotation<T>, a: Vector<T>) -> Vector<T> {
        r.apply_transposed(a)
    }
    #[inline(always)]
    fn compose<T: Scalar>(first: &Rotation<T>, second: &Rotation<T>) -> Rotation<T> {
        Rotation { x: first.apply(second.x), y: first.apply(second.y), z: first.apply(second.z) }
    }
    #[inline(always)]
    fn angular_axis<T: Scalar>(r: &Rotation<T>, index: usize) -> Vector<T> {
        r.axis(index)
    }
    #[inline(always)]
    fn linear_axis<T: Scalar>(r: &Rotation<T>, index: usize) -> Vector<T> {
        r.axis(index)
    }
    #[inline(always)]
    fn rod_axis<T: Scalar>((): (), r: &Rotation<T>) -> Vector<T> {
        r.x
    }

    #[inline(always)]
    fn spin<T: Scalar>(rotary: T, axis: Vector<T>, angular: Vector<T>) -> Vector<T> {
        angular.add_scaled(axis, axis.dot(angular)) * rotary
    }
    #[inline(always)]
    fn section<T: Scalar>(mass: T, rotary: T, axis: Vector<T>, position: Vector<T>) -> Symmetric<T> {
        Symmetric::diagonal(rotary + position.dot(position * mass)) + Symmetric::square(axis) * rotary
            - Symmetric::square(position) * mass
    }
    #[inline(always)]
    fn rotate_second_moment<T: Scalar>(r: &Rotation<T>, m: &Symmetric<T>) -> Symmetric<T> {
        Symmetric::square(r.x) * m.xx
            + Symmetric::square(r.y) * m.yy
            + Symmetric::square(r.z) * m.zz
            + Symmetric::product(r.x, r.y) * m.xy
            + Symmetric::product(r.x, r.z) * m.xz
            + Symmetric::product(r.y, r.z) * m.yz
    }
    #[inline(always)]
    fn angular_momentum<T: Scalar>(m: &Symmetric<T>, angular: Vector<T>) -> Vector<T> {
        m.times(angular)
    }
    #[inline(always)]
    fn gyroscopic<T: Scalar>(
        m: &Symmetric<T>,
        first_moment: Vector<T>,
        angular: Vector<T>,
        linear: Vector<T>,
    ) -> Symmetric<T> {
        let [x, y, z] = m.rows();
        let turned = [x.cross(angular), y.cross(angular), z.cross(angular)];
        let overlap = first_moment.dot(linear);
        Symmetric::diagonal(overlap + overlap)
            - Symmetric::sum_with_transpose(turned)
            - Symmetric::product(first_moment, linear)
    }

    #[inline(always)]
    fn strain_index((): (), strain: usize) -> usize {
        strain
    }
    #[inline(always)]
    fn axial_of((): (), a: Vector<f64>) -> Vector<f64> {
        a
    }
    #[inline(always)]
    fn axial_in_space((): (), a: Vector<f64>) -> Vector<f64> {
        a
    }
    #[inline(always)]
    fn vector_of((): (), v: Vector<f64>) -> Vector<f64> {
        v
    }
    fn rotary_inertia((): (), m: [[f64; 3]; 3]) -> Option<f64> {
        let about_diameter = m[1][1];
        let circle =
            [[2.0 * about_diameter, 0.0, 0.0], [0.0, about_diameter, 0.0], [0.0, 0.0, about_diameter]];
        (m == circle).then_some(about_diameter)
    }
    #[inline(always)]
    fn second_moment_of((): (), m: [[f64; 3]; 3]) -> Symmetric<f64> {
        Symmetric { xx: m[0][0], yy: m[1][1], zz: m[2][2], xy: m[0][1], xz: m[0][2], yz: m[1][2] }
    }
    #[inline(always)]
    fn in_space((): (), v: Vector<f64>) -> Vector<f64> {
        v
    }
    #[inline(always)]
    fn rotation_in_space((): (), r: &Rotation<f64>) -> Rotation<f64> {
        *r
    }
}
