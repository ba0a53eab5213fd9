//! Inertia of a section or of a point mass, seen from the origin of the inertial frame: `N = Ad_g^-T M Ad_g^-1`.

use super::plan::{Plan, SegmentPlan};
use super::workspace::Workspace;
use crate::lie::{Pack, Scalar, Twist, Vector, Wrench};

/// Inertia (per length, or of a body) of an axisymmetric section at a place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inertia<T> {
    pub(super) mass: T,
    /// About a diameter; about the axis it is twice that, as for every circle.
    pub(super) rotary: T,
    pub(super) axis: Vector<T>,
    pub(super) position: Vector<T>,
}

impl<T: Scalar> Inertia<T> {
    /// Momentum of a twist, `N V`.
    #[inline(always)]
    pub(super) fn momentum(&self, twist: Twist<T>) -> Wrench<T> {
        let Twist { angular, linear } = twist;
        let momentum = (linear + angular.cross(self.position)) * self.mass;
        let spin = (angular + self.axis * self.axis.dot(angular)) * self.rotary;
        Wrench { moment: spin + self.position.cross(momentum), force: momentum }
    }

    /// Change of the inertial force with the variation `y = dV - ad_Psi V`: `C y = -(N ad_V + ad_V^T N) y - ad_y^T N V`.
    #[inline(always)]
    pub(super) fn gyroscopic(&self, velocity: Twist<T>, momentum: Wrench<T>, y: Twist<T>) -> Wrench<T> {
        -(self.momentum(velocity.bracket(y))
            + velocity.bracket_transposed(self.momentum(y))
            + y.bracket_transposed(momentum))
    }

    /// `C^T y` of [`Inertia::gyroscopic`].
    #[inline(always)]
    pub(super) fn gyroscopic_transposed(
        &self,
        velocity: Twist<T>,
        momentum: Wrench<T>,
        y: Twist<T>,
    ) -> Wrench<T> {
        y.bracket_transposed(momentum)
            - (self.momentum(velocity.bracket(y)) + velocity.bracket_transposed(self.momentum(y)))
    }
}

/// The inertia per length at one pack of nodes, with the kinematics up to date.
#[inline(always)]
pub(super) fn of_nodes(segment: &SegmentPlan, work: &Workspace, pack: usize) -> Inertia<Pack> {
    let node = segment.first_pack + pack;
    Inertia {
        mass: segment.mass[pack],
        rotary: segment.rotary_inertia[pack],
        axis: work.rotation[node].x,
        position: work.position[node],
    }
}

/// The point mass at the tip, with the kinematics up to date.
#[inline(always)]
pub(super) fn of_tip(plan: &Plan, work: &Workspace) -> Inertia<f64> {
    let position = work.stations[plan.segments.len()].position;
    Inertia { mass: plan.tip_mass, rotary: 0.0, axis: Vector::zero(), position }
}
