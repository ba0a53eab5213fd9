//! Inertia seen from the origin of the inertial frame, `N = Ad_g^-T M Ad_g^-1`: of a section, of a point mass, of all that
//! lies behind a place.

use super::plan::{Plan, SegmentPlan};
use super::workspace::Workspace;
use crate::lie::{Pack, Scalar, Symmetric, Twist, Vector, Wrench};

/// Inertia per length of a circular section.
#[derive(Clone, Copy, Debug)]
pub(super) struct SectionInertia<T> {
    pub(super) mass: T,
    /// About a diameter; about the axis it is twice that, as for every circle.
    pub(super) rotary: T,
    pub(super) axis: Vector<T>,
    pub(super) position: Vector<T>,
}

impl<T: Scalar> SectionInertia<T> {
    /// Momentum of a twist, `N V`.
    #[inline(always)]
    pub(super) fn momentum(&self, twist: Twist<T>) -> Wrench<T> {
        let Twist { angular, linear } = twist;
        let momentum = (linear + angular.cross(self.position)) * self.mass;
        let spin = (angular + self.axis * self.axis.dot(angular)) * self.rotary;
        Wrench { moment: spin + self.position.cross(momentum), force: momentum }
    }

    /// The same inertia, times `weight`, as one that can be added to others.
    #[inline(always)]
    pub(super) fn weighted(&self, weight: T) -> Inertia<T> {
        let (mass, rotary) = (self.mass * weight, self.rotary * weight);
        let first_moment = self.position * mass;
        let second_moment = Symmetric::diagonal(rotary + self.position.dot(first_moment))
            + Symmetric::square(self.axis) * rotary
            - Symmetric::square(self.position) * mass;
        Inertia { mass, first_moment, second_moment }
    }
}

/// Any inertia: mass, first moment (mass times position of the centre) and second moment about the origin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inertia<T> {
    pub(super) mass: T,
    pub(super) first_moment: Vector<T>,
    pub(super) second_moment: Symmetric<T>,
}

impl<T: Scalar> Inertia<T> {
    #[inline(always)]
    pub(super) fn zero() -> Self {
        let zero = T::splat(0.0);
        Self { mass: zero, first_moment: Vector::zero(), second_moment: Symmetric::diagonal(zero) }
    }

    /// `N z`.
    #[inline(always)]
    pub(super) fn momentum(&self, z: Twist<T>) -> Wrench<T> {
        Wrench {
            moment: self.second_moment.times(z.angular) + self.first_moment.cross(z.linear),
            force: z.linear * self.mass + z.angular.cross(self.first_moment),
        }
    }

    #[inline(always)]
    pub(super) fn add(&mut self, other: Self) {
        self.mass += other.mass;
        self.first_moment += other.first_moment;
        self.second_moment += other.second_moment;
    }
}

impl Inertia<Pack> {
    /// The sum over the lanes.
    #[inline(always)]
    pub(super) fn sum(self) -> Inertia<f64> {
        Inertia {
            mass: self.mass.sum(),
            first_moment: self.first_moment.sum(),
            second_moment: self.second_moment.sum(),
        }
    }
}

/// Change of the inertial force of a body moving with V under the variation `Y = dV - ad_Psi V`:
/// `C Y = -(N ad_V + ad_V^T N) Y - ad_Y^T N V`. Written out with momentum `N V = (h; l)` and the moments of N, all that
/// belongs to the linear part of Y cancels, and `C Y = (B y - h x y; -2 l x y)` with the angular part y of Y and
/// `B = -(J [w] + (J [w])^T) - (c v^T + v c^T) + 2 (c . v) 1`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gyroscope<T> {
    symmetric: Symmetric<T>,
    momentum: Wrench<T>,
}

impl<T: Scalar> Gyroscope<T> {
    #[inline(always)]
    pub(super) fn zero() -> Self {
        Self { symmetric: Symmetric::diagonal(T::splat(0.0)), momentum: Wrench::zero() }
    }

    /// Of a body with this inertia, velocity and momentum.
    #[inline(always)]
    pub(super) fn new(inertia: &Inertia<T>, velocity: Twist<T>, momentum: Wrench<T>) -> Self {
        let Twist { angular, linear } = velocity;
        let turned = inertia.second_moment.rows().map(|row| row.cross(angular));
        let overlap = inertia.first_moment.dot(linear);
        let symmetric = Symmetric::diagonal(overlap + overlap)
            - Symmetric::sum_with_transpose(turned)
            - Symmetric::product(inertia.first_moment, linear);
        Self { symmetric, momentum }
    }

    /// `C Y`, given the angular part of Y.
    #[inline(always)]
    pub(super) fn times(&self, y: Vector<T>) -> Wrench<T> {
        Wrench {
            moment: self.symmetric.times(y) + y.cross(self.momentum.moment),
            force: y.cross(self.momentum.force + self.momentum.force),
        }
    }

    /// `C^T psi`: its linear part is zero, this is the angular part.
    #[inline(always)]
    pub(super) fn transposed_times(&self, psi: Twist<T>) -> Vector<T> {
        let force = self.momentum.force + self.momentum.force;
        self.symmetric.times(psi.angular) + self.momentum.moment.cross(psi.angular) + force.cross(psi.linear)
    }

    #[inline(always)]
    pub(super) fn add(&mut self, other: Self) {
        self.symmetric += other.symmetric;
        self.momentum += other.momentum;
    }
}

impl Gyroscope<Pack> {
    /// The sum over the lanes.
    #[inline(always)]
    pub(super) fn sum(self) -> Gyroscope<f64> {
        Gyroscope { symmetric: self.symmetric.sum(), momentum: self.momentum.sum() }
    }
}

/// The inertia per length at one pack of nodes, with the kinematics up to date.
#[inline(always)]
pub(super) fn of_nodes(segment: &SegmentPlan, work: &Workspace, pack: usize) -> SectionInertia<Pack> {
    let node = segment.first_pack + pack;
    SectionInertia {
        mass: segment.mass[pack],
        rotary: segment.rotary_inertia[pack],
        axis: work.rotation[node].x,
        position: work.position[node],
    }
}

/// The point mass at the tip, with the kinematics up to date.
#[inline(always)]
pub(super) fn of_tip(plan: &Plan, work: &Workspace) -> SectionInertia<f64> {
    let position = work.stations[plan.segments.len()].position;
    SectionInertia { mass: plan.tip_mass, rotary: 0.0, axis: Vector::zero(), position }
}
