//! Planar geometry: one angular component, two linear ones.

use std::ops::{Add, AddAssign, Mul, Neg, Sub};

use super::geometry::{Cross, Geometry, SecondMoment, VectorSpace};
use super::sine_cosine::sine_cosine;
use super::{Pack, Rotation, Scalar, Vector};

/// Motions in a plane that contains the rod, computed with [`Pack<FUSED>`].
#[derive(Clone, Copy, Debug, Default)]
pub struct Planar<const FUSED: bool>;

/// A coordinate plane by the axes of the frame (0, 1, 2 for x, y, z): `first x second = normal`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plane {
    /// Axis of all rotations.
    pub normal: usize,
    /// Axes in the plane.
    pub axes: [usize; 2],
}

impl Plane {
    /// The plane in which a rod along x bends about y.
    pub const ABOUT_Y: Self = Self { normal: 1, axes: [2, 0] };
    /// The plane in which a rod along x bends about z.
    pub const ABOUT_Z: Self = Self { normal: 2, axes: [0, 1] };
}

/// An angular velocity or a moment about the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn<T>(pub T);

/// A vector of the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs, reason = "the components of a vector")]
pub struct PlaneVector<T> {
    pub a: T,
    pub b: T,
}

/// A rotation by an angle.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs, reason = "the functions of an angle")]
pub struct PlaneRotation<T> {
    pub cos: T,
    pub sin: T,
}

macro_rules! operations {
    ($name:ident, $($component:tt),+) => {
        impl<T: Scalar> Add for $name<T> {
            type Output = Self;
            #[inline(always)]
            fn add(self, other: Self) -> Self {
                Self { $($component: self.$component + other.$component),+ }
            }
        }
        impl<T: Scalar> AddAssign for $name<T> {
            #[inline(always)]
            fn add_assign(&mut self, other: Self) {
                *self = *self + other;
            }
        }
        impl<T: Scalar> Sub for $name<T> {
            type Output = Self;
            #[inline(always)]
            fn sub(self, other: Self) -> Self {
                Self { $($component: self.$component - other.$component),+ }
            }
        }
        impl<T: Scalar> Neg for $name<T> {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                Self { $($component: -self.$component),+ }
            }
        }
        impl<T: Scalar> Mul<T> for $name<T> {
            type Output = Self;
            #[inline(always)]
            fn mul(self, factor: T) -> Self {
                Self { $($component: self.$component * factor),+ }
            }
        }
    };
}

operations!(Turn, 0);
operations!(PlaneVector, a, b);

impl<T: Scalar> VectorSpace<T> for Turn<T> {
    #[inline(always)]
    fn zero() -> Self {
        Self(T::splat(0.0))
    }
    #[inline(always)]
    fn add_scaled(self, other: Self, factor: T) -> Self {
        Self(other.0.mul_add(factor, self.0))
    }
    #[inline(always)]
    fn dot(self, other: Self) -> T {
        self.0 * other.0
    }
    #[inline(always)]
    fn dot_add(self, other: Self, sum: T) -> T {
        self.0.mul_add(other.0, sum)
    }
}

impl<T: Scalar> VectorSpace<T> for PlaneVector<T> {
    #[inline(always)]
    fn zero() -> Self {
        Self { a: T::splat(0.0), b: T::splat(0.0) }
    }
    #[inline(always)]
    fn add_scaled(self, other: Self, factor: T) -> Self {
        Self { a: other.a.mul_add(factor, self.a), b: other.b.mul_add(factor, self.b) }
    }
    #[inline(always)]
    fn dot(self, other: Self) -> T {
        self.a.mul_add(other.a, self.b * other.b)
    }
    #[inline(always)]
    fn dot_add(self, other: Self, sum: T) -> T {
        self.a.mul_add(other.a, self.b.mul_add(other.b, sum))
    }
}

impl<T: Scalar> SecondMoment for Turn<T> {
    #[inline(always)]
    fn zero() -> Self {
        Self(T::splat(0.0))
    }
}

/// Rotations about the same axis commute.
impl<T: Scalar> Cross<Self> for Turn<T> {
    type Output = Self;
    #[inline(always)]
    fn cross(self, _: Self) -> Self {
        Self(T::splat(0.0))
    }
    #[inline(always)]
    fn cross_add(self, _: Self, sum: Self) -> Self {
        sum
    }
}

impl<T: Scalar> Cross<PlaneVector<T>> for Turn<T> {
    type Output = PlaneVector<T>;
    #[inline(always)]
    fn cross(self, v: PlaneVector<T>) -> PlaneVector<T> {
        PlaneVector { a: self.0.mul_sub_from(v.b, T::splat(0.0)), b: self.0 * v.a }
    }
    #[inline(always)]
    fn cross_add(self, v: PlaneVector<T>, sum: PlaneVector<T>) -> PlaneVector<T> {
        PlaneVector { a: self.0.mul_sub_from(v.b, sum.a), b: self.0.mul_add(v.a, sum.b) }
    }
}

impl<T: Scalar> Cross<Turn<T>> for PlaneVector<T> {
    type Output = Self;
    #[inline(always)]
    fn cross(self, turn: Turn<T>) -> Self {
        Self { a: self.b * turn.0, b: self.a.mul_sub_from(turn.0, T::splat(0.0)) }
    }
    #[inline(always)]
    fn cross_add(self, turn: Turn<T>, sum: Self) -> Self {
        Self { a: self.b.mul_add(turn.0, sum.a), b: self.a.mul_sub_from(turn.0, sum.b) }
    }
}

impl<T: Scalar> Cross<Self> for PlaneVector<T> {
    type Output = Turn<T>;
    #[inline(always)]
    fn cross(self, other: Self) -> Turn<T> {
        Turn(self.b.mul_sub_from(other.a, self.a * other.b))
    }
    #[inline(always)]
    fn cross_add(self, other: Self, sum: Turn<T>) -> Turn<T> {
        Turn(self.a.mul_add(other.b, self.b.mul_sub_from(other.a, sum.0)))
    }
}

impl<T: Scalar> PlaneRotation<T> {
    /// The rotation by an angle in radians.
    #[inline(always)]
    pub fn by(angle: T) -> Self {
        let (sin, cos) = sine_cosine(angle);
        Self { cos, sin }
    }

    /// The body axes.
    #[inline(always)]
    fn axes(&self) -> [PlaneVector<T>; 2] {
        [PlaneVector { a: self.cos, b: self.sin }, PlaneVector { a: -self.sin, b: self.cos }]
    }
}

impl<const FUSED: bool> Geometry for Planar<FUSED> {
    type Pack = Pack<FUSED>;
    type Frame = Plane;
    type Axial<T: Scalar> = Turn<T>;
    type Vector<T: Scalar> = PlaneVector<T>;
    type Rotation<T: Scalar> = PlaneRotation<T>;
    type SecondMoment<T: Scalar> = Turn<T>;

    const ANGULAR: usize = 1;
    const COMPONENTS: usize = 3;

    #[inline(always)]
    fn map_axial<T: Scalar, U: Scalar>(turn: &Turn<T>, f: impl Fn(&T) -> U) -> Turn<U> {
        Turn(f(&turn.0))
    }
    #[inline(always)]
    fn map_vector<T: Scalar, U: Scalar>(v: &PlaneVector<T>, f: impl Fn(&T) -> U) -> PlaneVector<U> {
        PlaneVector { a: f(&v.a), b: f(&v.b) }
    }
    #[inline(always)]
    fn map_second_moment<T: Scalar, U: Scalar>(m: &Turn<T>, f: impl Fn(&T) -> U) -> Turn<U> {
        Turn(f(&m.0))
    }
    #[inline(always)]
    fn map_rotation<T: Scalar, U: Scalar>(r: &PlaneRotation<T>, f: impl Fn(&T) -> U) -> PlaneRotation<U> {
        PlaneRotation { cos: f(&r.cos), sin: f(&r.sin) }
    }

    #[inline(always)]
    fn axial_component<T: Scalar>(turn: &mut Turn<T>, _: usize) -> &mut T {
        &mut turn.0
    }
    #[inline(always)]
    fn vector_component<T: Scalar>(v: &mut PlaneVector<T>, index: usize) -> &mut T {
        if index == 0 { &mut v.a } else { &mut v.b }
    }

    #[inline(always)]
    fn unrotated<T: Scalar>() -> PlaneRotation<T> {
        PlaneRotation { cos: T::splat(1.0), sin: T::splat(0.0) }
    }
    #[inline(always)]
    fn rotate<T: Scalar>(r: &PlaneRotation<T>, v: PlaneVector<T>) -> PlaneVector<T> {
        let [a, b] = r.axes();
        (a * v.a).add_scaled(b, v.b)
    }
    #[inline(always)]
    fn rotate_back<T: Scalar>(r: &PlaneRotation<T>, v: PlaneVector<T>) -> PlaneVector<T> {
        let [a, b] = r.axes();
        PlaneVector { a: a.dot(v), b: b.dot(v) }
    }
    #[inline(always)]
    fn rotate_axial<T: Scalar>(_: &PlaneRotation<T>, turn: Turn<T>) -> Turn<T> {
        turn
    }
    #[inline(always)]
    fn rotate_axial_back<T: Scalar>(_: &PlaneRotation<T>, turn: Turn<T>) -> Turn<T> {
        turn
    }
    #[inline(always)]
    fn compose<T: Scalar>(first: &PlaneRotation<T>, second: &PlaneRotation<T>) -> PlaneRotation<T> {
        let PlaneVector { a: cos, b: sin } =
            Self::rotate(first, PlaneVector { a: second.cos, b: second.sin });
        PlaneRotation { cos, sin }
    }
    #[inline(always)]
    fn angular_axis<T: Scalar>(_: &PlaneRotation<T>, _: usize) -> Turn<T> {
        Turn(T::splat(1.0))
    }
    #[inline(always)]
    fn linear_axis<T: Scalar>(r: &PlaneRotation<T>, index: usize) -> PlaneVector<T> {
        let [a, b] = r.axes();
        if index == 0 { a } else { b }
    }
    #[inline(always)]
    fn rod_axis<T: Scalar>(plane: Plane, r: &PlaneRotation<T>) -> PlaneVector<T> {
        Self::linear_axis(r, usize::from(plane.axes[0] != 0))
    }

    #[inline(always)]
    fn spin<T: Scalar>(rotary: T, _: PlaneVector<T>, turn: Turn<T>) -> Turn<T> {
        turn * rotary
    }
    #[inline(always)]
    fn section<T: Scalar>(mass: T, rotary: T, _: PlaneVector<T>, position: PlaneVector<T>) -> Turn<T> {
        Turn(position.dot_add(position * mass, rotary))
    }
    #[inline(always)]
    fn rotate_second_moment<T: Scalar>(_: &PlaneRotation<T>, m: &Turn<T>) -> Turn<T> {
        *m
    }
    #[inline(always)]
    fn angular_momentum<T: Scalar>(m: &Turn<T>, turn: Turn<T>) -> Turn<T> {
        turn * m.0
    }
    #[inline(always)]
    fn gyroscopic<T: Scalar>(
        _: &Turn<T>,
        first_moment: PlaneVector<T>,
        _: Turn<T>,
        linear: PlaneVector<T>,
    ) -> Turn<T> {
        let overlap = first_moment.dot(linear);
        Turn(overlap + overlap)
    }

    fn strain_index(plane: Plane, strain: usize) -> usize {
        let axis = strain % 3;
        if strain < 3 { 0 } else { Self::ANGULAR + usize::from(axis == plane.axes[1]) }
    }
    fn axial_of(plane: Plane, a: Vector<f64>) -> Turn<f64> {
        Turn(a.to_array()[plane.normal])
    }
    fn axial_in_space(plane: Plane, a: Turn<f64>) -> Vector<f64> {
        let mut space = [0.0; 3];
        space[plane.normal] = a.0;
        space.into()
    }
    fn vector_of(plane: Plane, v: Vector<f64>) -> PlaneVector<f64> {
        let v = v.to_array();
        PlaneVector { a: v[plane.axes[0]], b: v[plane.axes[1]] }
    }
    fn rotary_inertia(plane: Plane, m: [[f64; 3]; 3]) -> Option<f64> {
        Some(m[plane.normal][plane.normal])
    }
    fn second_moment_of(plane: Plane, m: [[f64; 3]; 3]) -> Turn<f64> {
        Turn(m[plane.normal][plane.normal])
    }
    fn in_space(plane: Plane, v: PlaneVector<f64>) -> Vector<f64> {
        let mut space = [0.0; 3];
        space[plane.axes[0]] = v.a;
        space[plane.axes[1]] = v.b;
        space.into()
    }
    fn rotation_in_space(plane: Plane, r: &PlaneRotation<f64>) -> Rotation<f64> {
        let mut axes = [Vector::zero(); 3];
        let [a, b] = r.axes();
        axes[plane.axes[0]] = Self::in_space(plane, a);
        axes[plane.axes[1]] = Self::in_space(plane, b);
        *axes[plane.normal].component_mut(plane.normal) = 1.0;
        let [x, y, z] = axes;
        Rotation { x, y, z }
    }
}
