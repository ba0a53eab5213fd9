//! State of a point.

use crate::numerics::lie::{Twist, VectorSpace, Wrench};
use crate::robot::algebra::inertia::Inertia;
use crate::robot::plan::space::Space;

/// State of a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PointState<G: Space> {
    pub(crate) position: G::Vector<f64>,
    pub(crate) rotation: G::Rotation<f64>,
    /// Inertia of the bodies, about the origin.
    pub(crate) inertia: Inertia<G, f64>,
    pub(crate) velocity: Twist<G, f64>,
    /// Acceleration minus gravity.
    pub(crate) acceleration: Twist<G, f64>,
    pub(crate) momentum: Wrench<G, f64>,
    /// Wrench required by the motion of the bodies, minus the loads.
    pub(crate) force: Wrench<G, f64>,
}

impl<G: Space> PointState<G> {
    pub(crate) fn new() -> Self {
        Self {
            position: VectorSpace::zero(),
            rotation: G::unrotated(),
            inertia: Inertia::zero(),
            velocity: Twist::zero(),
            acceleration: Twist::zero(),
            momentum: Wrench::zero(),
            force: Wrench::zero(),
        }
    }
}
