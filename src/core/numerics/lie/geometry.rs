//! The interface of the sweeps to the geometry of motion: in space or in a plane.
//!
//! In a plane, angular velocities and moments have one component and rotations commute, so that the same
//! formulas need fewer numbers.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Mul, Neg, Sub};

use super::{Lanes, Rotation, Scalar, Vector};

/// Linear combinations.
pub trait VectorSpace<T: Scalar>:
    Copy
    + Debug
    + Add<Output = Self>
    + AddAssign
    + Sub<Output = Self>
    + Neg<Output = Self>
    + Mul<T, Output = Self>
{
    /// The zero vector.
    fn zero() -> Self;
    /// `self + other * factor`.
    fn add_scaled(self, other: Self, factor: T) -> Self;
    /// Scalar product.
    fn dot(self, other: Self) -> T;
    /// `self . other + sum`.
    fn dot_add(self, other: Self, sum: T) -> T;
}

/// The vector product of two types for which it is defined.
pub trait Cross<Other> {
    /// Type of the product.
    type Output;
    /// Vector product.
    fn cross(self, other: Other) -> Self::Output;
    /// `self x other + sum`.
    fn cross_add(self, other: Other, sum: Self::Output) -> Self::Output;
}

/// Second moments about the origin, which map angular velocities to angular momenta.
pub trait SecondMoment: Copy + Debug + Add<Output = Self> + AddAssign {
    /// No inertia.
    fn zero() -> Self;
}

/// The space of a rod, [`super::Spatial`] or [`super::Planar`], and its number types.
pub trait Geometry: Copy + Debug + Default + Send + Sync + 'static {
    /// Number type for the values at neighbouring nodes.
    type Pack: Lanes;
    /// Position of this space in the three-dimensional one.
    type Frame: Copy + Debug + Send + Sync;
    /// Angular velocities and moments.
    type Axial<T: Scalar>: VectorSpace<T>
        + Cross<Self::Axial<T>, Output = Self::Axial<T>>
        + Cross<Self::Vector<T>, Output = Self::Vector<T>>;
    /// Positions, velocities and forces.
    type Vector<T: Scalar>: VectorSpace<T>
        + Cross<Self::Axial<T>, Output = Self::Vector<T>>
        + Cross<Self::Vector<T>, Output = Self::Axial<T>>;
    /// Rotations ready to be applied.
    type Rotation<T: Scalar>: Copy + Debug;
    /// Second moments of inertia.
    type SecondMoment<T: Scalar>: SecondMoment + Mul<T, Output = Self::SecondMoment<T>>;

    /// Number of components of an angular velocity; a strain has these followed by the components of a
    /// vector.
    const ANGULAR: usize;
    /// Number of components of a twist.
    const COMPONENTS: usize;

    /// Applies a function to every component.
    fn map_axial<T: Scalar, U: Scalar>(a: &Self::Axial<T>, f: impl Fn(&T) -> U) -> Self::Axial<U>;
    /// Applies a function to every component.
    fn map_vector<T: Scalar, U: Scalar>(v: &Self::Vector<T>, f: impl Fn(&T) -> U) -> Self::Vector<U>;
    /// Applies a function to every entry.
    fn map_second_moment<T: Scalar, U: Scalar>(
        m: &Self::SecondMoment<T>,
        f: impl Fn(&T) -> U,
    ) -> Self::SecondMoment<U>;
    /// Applies a function to every entry.
    fn map_rotation<T: Scalar, U: Scalar>(r: &Self::Rotation<T>, f: impl Fn(&T) -> U) -> Self::Rotation<U>;

    /// Component of an angular velocity.
    fn axial_component<T: Scalar>(a: &mut Self::Axial<T>, index: usize) -> &mut T;
    /// Component of a vector.
    fn vector_component<T: Scalar>(v: &mut Self::Vector<T>, index: usize) -> &mut T;

    /// No rotation.
    fn unrotated<T: Scalar>() -> Self::Rotation<T>;
    /// Maps from body axes to the axes of the frame.
    fn rotate<T: Scalar>(r: &Self::Rotation<T>, v: Self::Vector<T>) -> Self::Vector<T>;
    /// Maps from the axes of the frame to body axes.
    fn rotate_back<T: Scalar>(r: &Self::Rotation<T>, v: Self::Vector<T>) -> Self::Vector<T>;
    /// [`Self::rotate`] of angular velocities and moments.
    fn rotate_axial<T: Scalar>(r: &Self::Rotation<T>, a: Self::Axial<T>) -> Self::Axial<T>;
    /// [`Self::rotate_back`] of angular velocities and moments.
    fn rotate_axial_back<T: Scalar>(r: &Self::Rotation<T>, a: Self::Axial<T>) -> Self::Axial<T>;
    /// Composition: the second rotation, then the first one.
    fn compose<T: Scalar>(first: &Self::Rotation<T>, second: &Self::Rotation<T>) -> Self::Rotation<T>;
    /// Angular velocity about one body axis.
    fn angular_axis<T: Scalar>(r: &Self::Rotation<T>, index: usize) -> Self::Axial<T>;
    /// Direction of one body axis.
    fn linear_axis<T: Scalar>(r: &Self::Rotation<T>, index: usize) -> Self::Vector<T>;
    /// Direction of the body axis along the rod.
    fn rod_axis<T: Scalar>(frame: Self::Frame, r: &Self::Rotation<T>) -> Self::Vector<T>;

    /// Angular momentum of a circular section about its centre, with rotary inertia `rotary` about a diameter and
    /// twice that about its axis.
    fn spin<T: Scalar>(rotary: T, axis: Self::Vector<T>, angular: Self::Axial<T>) -> Self::Axial<T>;
    /// Second moments of such a circular section about the origin.
    fn section<T: Scalar>(
        mass: T,
        rotary: T,
        axis: Self::Vector<T>,
        position: Self::Vector<T>,
    ) -> Self::SecondMoment<T>;
    /// Rotates second moments from body axes to the axes of the frame.
    fn rotate_second_moment<T: Scalar>(
        r: &Self::Rotation<T>,
        m: &Self::SecondMoment<T>,
    ) -> Self::SecondMoment<T>;
    /// Angular momentum of second moments at an angular velocity.
    fn angular_momentum<T: Scalar>(m: &Self::SecondMoment<T>, angular: Self::Axial<T>) -> Self::Axial<T>;
    /// `-(J [w] + (J [w])^T) - (c v^T + v c^T) + 2 (c . v) 1` with second moments J, first moment c, angular
    /// velocity w and linear velocity v.
    fn gyroscopic<T: Scalar>(
        m: &Self::SecondMoment<T>,
        first_moment: Self::Vector<T>,
        angular: Self::Axial<T>,
        linear: Self::Vector<T>,
    ) -> Self::SecondMoment<T>;

    /// Index of a strain (0..6) among the components of this space.
    fn strain_index(frame: Self::Frame, strain: usize) -> usize;
    /// Components of a three-dimensional angular velocity or moment in this space.
    fn axial_of(frame: Self::Frame, a: Vector<f64>) -> Self::Axial<f64>;
    /// The angular velocity or moment in three dimensions.
    fn axial_in_space(frame: Self::Frame, a: Self::Axial<f64>) -> Vector<f64>;
    /// Components of a three-dimensional vector in this space.
    fn vector_of(frame: Self::Frame, v: Vector<f64>) -> Self::Vector<f64>;
    /// Rotary inertia of a section with this inertia tensor, if the section is equivalent to a circle in this
    /// space: the same inertia about all diameters about which it can rotate, and twice that about its axis.
    fn rotary_inertia(frame: Self::Frame, m: [[f64; 3]; 3]) -> Option<f64>;
    /// Components of three-dimensional second moments (a symmetric matrix by rows) in this space.
    fn second_moment_of(frame: Self::Frame, m: [[f64; 3]; 3]) -> Self::SecondMoment<f64>;
    /// The vector in three dimensions.
    fn in_space(frame: Self::Frame, v: Self::Vector<f64>) -> Vector<f64>;
    /// The rotation in three dimensions.
    fn rotation_in_space(frame: Self::Frame, r: &Self::Rotation<f64>) -> Rotation<f64>;
}
