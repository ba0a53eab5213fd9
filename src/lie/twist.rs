//! Twists and wrenches: se(3) and its dual.

use std::ops::{Add, AddAssign, Mul, Neg, Sub};

use super::{Pack, Packed, Scalar, Vector};

/// A velocity-like element of se(3): (angular; linear).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Twist<T> {
    /// Angular part.
    pub angular: Vector<T>,
    /// Linear part, of the point of the body that passes the origin.
    pub linear: Vector<T>,
}

/// A force-like element of the dual of se(3): (moment; force).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wrench<T> {
    /// Moment about the origin.
    pub moment: Vector<T>,
    /// Force.
    pub force: Vector<T>,
}

impl<T: Scalar> Twist<T> {
    /// The zero twist.
    #[inline(always)]
    pub fn zero() -> Self {
        Self { angular: Vector::zero(), linear: Vector::zero() }
    }

    /// Lie bracket: `ad_self other`.
    #[inline(always)]
    pub fn bracket(self, other: Self) -> Self {
        Self {
            angular: self.angular.cross(other.angular),
            linear: self.linear.cross(other.angular) + self.angular.cross(other.linear),
        }
    }

    /// The adjoint of the bracket on wrenches: `ad_self^T wrench`.
    #[inline(always)]
    pub fn bracket_transposed(self, wrench: Wrench<T>) -> Wrench<T> {
        Wrench {
            moment: wrench.moment.cross(self.angular) + wrench.force.cross(self.linear),
            force: wrench.force.cross(self.angular),
        }
    }

    /// Power of a wrench on this twist.
    #[inline(always)]
    pub fn dot(self, wrench: Wrench<T>) -> T {
        self.angular.dot(wrench.moment) + self.linear.dot(wrench.force)
    }
}

impl<T: Scalar> Wrench<T> {
    /// The zero wrench.
    #[inline(always)]
    pub fn zero() -> Self {
        Self { moment: Vector::zero(), force: Vector::zero() }
    }
}

macro_rules! linear_operations {
    ($name:ident, $first:ident, $second:ident) => {
        impl<T: Scalar> Add for $name<T> {
            type Output = Self;
            #[inline(always)]
            fn add(self, other: Self) -> Self {
                Self { $first: self.$first + other.$first, $second: self.$second + other.$second }
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
                Self { $first: self.$first - other.$first, $second: self.$second - other.$second }
            }
        }

        impl<T: Scalar> Neg for $name<T> {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                Self { $first: -self.$first, $second: -self.$second }
            }
        }

        impl<T: Scalar> Mul<T> for $name<T> {
            type Output = Self;
            #[inline(always)]
            fn mul(self, factor: T) -> Self {
                Self { $first: self.$first * factor, $second: self.$second * factor }
            }
        }

        impl $name<f64> {
            /// The six components in an array.
            pub fn to_array(self) -> [f64; 6] {
                let ([a, b, c], [d, e, f]) = (self.$first.to_array(), self.$second.to_array());
                [a, b, c, d, e, f]
            }

            /// From its six components.
            pub fn from_array([a, b, c, d, e, f]: [f64; 6]) -> Self {
                Self { $first: [a, b, c].into(), $second: [d, e, f].into() }
            }

            /// The same in every lane.
            #[inline(always)]
            pub fn splat(self) -> $name<Pack> {
                $name {
                    $first: Vector::splat(self.$first.to_array()),
                    $second: Vector::splat(self.$second.to_array()),
                }
            }
        }

        impl Packed for $name<Pack> {
            #[inline(always)]
            fn broadcast(&self, lane: usize) -> Self {
                Self { $first: self.$first.broadcast(lane), $second: self.$second.broadcast(lane) }
            }
        }

        impl $name<Pack> {
            /// What stands in one lane.
            #[inline(always)]
            pub fn lane(&self, lane: usize) -> $name<f64> {
                $name { $first: self.$first.lane(lane), $second: self.$second.lane(lane) }
            }

            /// The sum over the lanes.
            #[inline(always)]
            pub fn sum(self) -> $name<f64> {
                $name { $first: self.$first.sum(), $second: self.$second.sum() }
            }
        }
    };
}

linear_operations!(Twist, angular, linear);
linear_operations!(Wrench, moment, force);
