//! The world in the frame of the moving base, at a time.

use crate::description::world::base_motion::Base;
use crate::numerics::lie::{Twist, Vector, VectorSpace};
use crate::robot::algebra::tie::Frame;
use crate::robot::effects::loops::state::WorldEnd;
use crate::robot::effects::support::plan::Anchor;
use crate::robot::plan::Plan;
use crate::robot::plan::space::Space;
use crate::robot::plan::world::World;

/// The world relative to the base.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surroundings<G: Space> {
    pub(crate) base: Base,
    pub(crate) gravity: G::Vector<f64>,
    /// Velocity of the frame in its own axes, which is that of the base's point.
    pub(crate) velocity: G::Vector<f64>,
    /// Velocity of the fluid in the frame, and the squared component out of the plane of motion, which only
    /// increases the speed.
    pub(crate) current: G::Vector<f64>,
    pub(crate) crossing: f64,
    /// Gravitational potential of a unit mass at the base, and potential of the mass offsets that no motion
    /// changes.
    pub(crate) gravity_potential: f64,
    pub(crate) body_potential: f64,
    /// Potential of the constant dead forces if all of them acted at the base.
    pub(crate) load_potential: f64,
}

impl<G: Space> Surroundings<G> {
    /// Before a time is set: NaN if the base moves.
    pub(crate) fn at_first(world: &World, frame: G::Frame) -> Self {
        let base = if world.motion.is_some() { world.base.unknown() } else { world.base };
        Self::new(world, frame, base)
    }

    pub(crate) fn new(world: &World, frame: G::Frame, base: Base) -> Self {
        let gravity_of_base = base.rotation.apply_transposed(world.gravity);
        let gravity = G::vector_of(frame, gravity_of_base);
        // In a plane, masses out of it have a constant height relative to it.
        let out_of_plane = |v: Vector<f64>| v - G::in_space(frame, G::vector_of(frame, v));
        let stream = base.rotation.apply_transposed(world.current - base.velocity);
        let crossing = out_of_plane(stream);
        Self {
            gravity,
            current: G::vector_of(frame, stream),
            crossing: crossing.dot(crossing),
            velocity: G::vector_of(frame, base.rotation.apply_transposed(base.velocity)),
            gravity_potential: -base.position.dot(world.gravity),
            body_potential: -out_of_plane(gravity_of_base).dot(world.body_moment),
            load_potential: -base.position.dot(world.dead_force),
            base,
        }
    }

    /// Velocity and acceleration, minus gravity, of the base in its own frame, in which its point is
    /// momentarily at rest.
    pub(crate) fn motion(&self, world: &World, frame: G::Frame) -> (Twist<G, f64>, Twist<G, f64>) {
        if world.motion.is_none() {
            return (Twist::zero(), Twist { angular: VectorSpace::zero(), linear: -self.gravity });
        }
        let seen = |v: Vector<f64>| self.base.rotation.apply_transposed(v);
        let axial = |v| G::axial_of(frame, seen(v));
        let linear = G::vector_of(frame, seen(self.base.acceleration)) - self.gravity;
        (
            Twist { angular: axial(self.base.angular_velocity), linear: VectorSpace::zero() },
            Twist { angular: axial(self.base.angular_acceleration), linear },
        )
    }
}

/// Anchors relative to a moving base.
pub(crate) fn anchors_in_base<G: Space>(plan: &Plan<G>, base: &Base) -> impl Iterator<Item = Anchor> {
    plan.effects.anchors.iter().map(|anchor| anchor.relative_to(base, &plan.world.base))
}

/// Positions and velocities, relative to a moving base, of the points of the world at which tendons end.
pub(crate) fn points_in_base<G: Space>(
    plan: &Plan<G>,
    base: &Base,
) -> impl Iterator<Item = [Vector<f64>; 2]> {
    plan.effects.actuation.world_points.iter().map(|&point| base.point_in_frame(point, &plan.world.base))
}

/// Frames of loop ends in the world, and the velocities of their origins, relative to a moving base: two for
/// each tie. Ends on links are unchanged.
pub(crate) fn ends_in_base<G: Space>(plan: &Plan<G>, base: &Base) -> impl Iterator<Item = [WorldEnd; 2]> {
    plan.effects.loops.ties.iter().map(|tie| {
        tie.ends.each_ref().map(|end| {
            if end.on.is_some() {
                return WorldEnd::at_rest(end.frame);
            }
            let [position, velocity] = base.point_in_frame(end.frame.position, &plan.world.base);
            let axes = base.sees_axes(end.frame.axes, &plan.world.base);
            WorldEnd { frame: Frame { position, axes }, velocity }
        })
    })
}
