//! Twists and wrenches: se(3) or se(2), and its dual.

use std::ops::{Add, AddAssign, Mul, Neg, Sub};

use super::{Cross, Geometry, Lanes, Scalar, VectorSpace};

/// A velocity-like element of the Lie algebra: (angular; linear).
#[derive(Clone, Copy, Debug)]
pub struct Twist<G: Geometry, T: Scalar> {
    /// Angular part.
    pub angular: G::Axial<T>,
    /// Linear part: velocity of the body's point at the origin.
    pub linear: G::Vector<T>,
}

/// A force-like element of the dual of the Lie algebra: (moment; force).
#[derive(Clone, Copy, Debug)]
pub struct Wrench<G: Geometry, T: Scalar> {
    /// Moment about the origin.
    pub moment: G::Axial<T>,
    /// Force.
    pub force: G::Vector<T>,
}

impl<G: Geometry, T: Scalar> Twist<G, T> {
    /// Lie bracket: `ad_self other`.
    #[inline(always)]
    pub fn bracket(self, other: Self) -> Self {
        Self {
            angular: self.angular.cross(other.angular),
            linear: self.linear.cross_add(other.angular, self.angular.cross(other.linear)),
        }
    }

    /// `ad_self other + sum`.
    #[inline(always)]
    pub fn bracket_add(self, other: Self, sum: Self) -> Self {
        Self {
            angular: self.angular.cross_add(other.angular, sum.angular),
            linear: self.linear.cross_add(other.angular, self.angular.cross_add(other.linear, sum.linear)),
        }
    }

    /// The adjoint of the bracket on wrenches: `ad_self^T wrench`.
    #[inline(always)]
    pub fn bracket_transposed(self, wrench: Wrench<G, T>) -> Wrench<G, T> {
        Wrench {
            moment: wrench.moment.cross_add(self.angular, wrench.force.cross(self.linear)),
            force: wrench.force.cross(self.angular),
        }
    }

    /// Power of a wrench on this twist.
    #[inline(always)]
    pub fn dot(self, wrench: Wrench<G, T>) -> T {
        self.dot_add(wrench, T::splat(0.0))
    }

    /// Power of a wrench on this twist, added to `sum`.
    #[inline(always)]
    pub fn dot_add(self, wrench: Wrench<G, T>, sum: T) -> T {
        self.angular.dot_add(wrench.moment, self.linear.dot_add(wrench.force, sum))
    }
}

impl<G: Geometry, T: Scalar> Wrench<G, T> {
    /// Converts a moment and a force at `position` to the wrench about the origin.
    #[inline(always)]
    pub fn at(self, position: G::Vector<T>) -> Self {
        Self { moment: position.cross(self.force) + self.moment, force: self.force }
    }

    /// Rotates from body axes to the axes of the frame.
    #[inline(always)]
    pub fn rotated(self, rotation: &G::Rotation<T>) -> Self {
        Self { moment: G::rotate_axial(rotation, self.moment), force: G::rotate(rotation, self.force) }
    }
}

macro_rules! linear_operations {
    ($name:ident, $first:ident, $second:ident) => {
        impl<G: Geometry, T: Scalar> $name<G, T> {
            /// Zero.
            #[inline(always)]
            pub fn zero() -> Self {
                Self { $first: VectorSpace::zero(), $second: VectorSpace::zero() }
            }

            /// Applies a function to every component.
            #[inline(always)]
            pub fn map<U: Scalar>(&self, f: impl Fn(&T) -> U) -> $name<G, U> {
                $name { $first: G::map_axial(&self.$first, &f), $second: G::map_vector(&self.$second, &f) }
            }

            /// `self + other * factor`.
            #[inline(always)]
            pub fn add_scaled(self, other: Self, factor: T) -> Self {
                Self {
                    $first: self.$first.add_scaled(other.$first, factor),
                    $second: self.$second.add_scaled(other.$second, factor),
                }
            }

            /// Component `index`, angular components first.
            #[inline(always)]
            pub fn component_mut(&mut self, index: usize) -> &mut T {
                if index < G::ANGULAR {
                    G::axial_component(&mut self.$first, index)
                } else {
                    G::vector_component(&mut self.$second, index - G::ANGULAR)
                }
            }
        }

        impl<G: Geometry, T: Scalar> Add for $name<G, T> {
            type Output = Self;
            #[inline(always)]
            fn add(self, other: Self) -> Self {
                Self { $first: self.$first + other.$first, $second: self.$second + other.$second }
            }
        }

        impl<G: Geometry, T: Scalar> AddAssign for $name<G, T> {
            #[inline(always)]
            fn add_assign(&mut self, other: Self) {
                *self = *self + other;
            }
        }

        impl<G: Geometry, T: Scalar> Sub for $name<G, T> {
            type Output = Self;
            #[inline(always)]
            fn sub(self, other: Self) -> Self {
                Self { $first: self.$first - other.$first, $second: self.$second - other.$second }
            }
        }

        impl<G: Geometry, T: Scalar> Neg for $name<G, T> {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                Self { $first: -self.$first, $second: -self.$second }
            }
        }

        impl<G: Geometry, T: Scalar> Mul<T> for $name<G, T> {
            type Output = Self;
            #[inline(always)]
            fn mul(self, factor: T) -> Self {
                Self { $first: self.$first * factor, $second: self.$second * factor }
            }
        }

        impl<G: Geometry> $name<G, f64> {
            /// Sets every lane to these components.
            #[inline(always)]
            pub fn splat(self) -> $name<G, G::Pack> {
                self.map(|&component| G::Pack::splat(component))
            }
        }

        impl<G: Geometry, P: Lanes> $name<G, P> {
            /// Adds `weight` times one lane of `other` to every lane.
            #[inline(always)]
            pub fn add_lane(self, other: &Self, lane: usize, weight: P) -> Self {
                self.add_scaled(other.map(|pack| P::splat(pack.lane(lane))), weight)
            }

            /// Sum over the lanes.
            #[inline(always)]
            pub fn sum(self) -> $name<G, f64> {
                self.map(|pack| pack.sum())
            }
        }
    };
}

linear_operations!(Twist, angular, linear);
linear_operations!(Wrench, moment, force);
