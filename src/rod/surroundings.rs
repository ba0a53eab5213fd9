//! What depends on the time by itself, taken at a time: the base, the world seen from it, and the loads that vary.

use super::anchor::Anchor;
use super::base::{Base, MovingBase};
use super::description::Rod;
use super::load::{Extent, Frame};
use super::plan::{self, Plan};
use super::turning::Turning;
use super::workspace::Workspace;
use crate::error::Interrupted;
use crate::lie::{Twist, Vector, VectorSpace};

/// What the base and the world are, whatever the time.
#[derive(Clone, Debug)]
pub(super) struct World {
    /// The base at rest, and how it moves if it does.
    pub(super) base: Base,
    pub(super) motion: Option<MovingBase>,
    gravity: Vector<f64>,
    /// Velocity of the fluid, if there is any.
    current: Vector<f64>,
    /// The sum of the constant dead forces.
    pub(super) dead_force: Vector<f64>,
    /// Masses of bodies and sections times their offsets from the rod's axis.
    body_moment: Vector<f64>,
}

impl World {
    /// Whether the fluid flows.
    pub(super) fn has_current(&self) -> bool {
        self.current.dot(self.current) > 0.0
    }

    pub(super) fn new(rod: &Rod) -> Self {
        let mut dead_force = Vector::zero();
        for load in rod.all_loads() {
            if let (Frame::World, Some(force)) = (load.frame, load.force.constant()) {
                let amount = if let Extent::Along([from, to]) = load.extent { to - from } else { 1.0 };
                dead_force += Vector::from(force) * amount;
            }
        }
        let mut body_moment = Vector::zero();
        for body in rod.all_bodies() {
            body_moment += Vector::from(body.centre) * body.mass;
        }
        for segment in &rod.segments {
            body_moment += Vector::from(segment.mass_offset());
        }
        let moving = |motion| MovingBase::new(motion, rod.base_position, rod.base_orientation);
        Self {
            base: Base::at(rod.base_position, rod.base_orientation),
            motion: rod.base_motion.as_ref().map(moving),
            gravity: rod.gravity.into(),
            current: rod.fluid.as_ref().map_or([0.0; 3], |fluid| fluid.velocity).into(),
            dead_force,
            body_moment,
        }
    }
}

/// The world seen from the base.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surroundings<G: Turning> {
    pub(super) base: Base,
    pub(super) gravity: G::Vector<f64>,
    /// Velocity of the frame, in its own axes: that of the base's point.
    pub(super) velocity: G::Vector<f64>,
    /// Velocity of the fluid in the frame, and the square of what is out of the plane that the rod moves in: it only adds to the
    /// speed.
    pub(super) current: G::Vector<f64>,
    pub(super) crossing: f64,
    /// Potential of gravity of a kilogram at the base; potential of the masses that no motion changes.
    pub(super) gravity_potential: f64,
    pub(super) body_potential: f64,
    /// Potential of the constant dead forces if all of them acted at the base.
    pub(super) load_potential: f64,
}

impl<G: Turning> Surroundings<G> {
    /// Before any time is set: NaN where the base moves.
    pub(super) fn at_first(world: &World, frame: G::Frame) -> Self {
        let base = if world.motion.is_some() { world.base.unknown() } else { world.base };
        Self::new(world, frame, base)
    }

    fn new(world: &World, frame: G::Frame, base: Base) -> Self {
        let gravity_of_base = base.rotation.apply_transposed(world.gravity);
        let gravity = G::vector_of(frame, gravity_of_base);
        // In a plane, masses beside it lie higher or lower by the same whatever the rod does.
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

    /// Velocity and acceleration, minus gravity, of the base in its own frame, in which its point rests for the moment.
    pub(super) fn motion(&self, world: &World, frame: G::Frame) -> (Twist<G, f64>, Twist<G, f64>) {
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

/// The anchors as a base that moves sees them.
pub(super) fn seen_anchors<G: Turning>(plan: &Plan<G>, base: &Base) -> impl Iterator<Item = Anchor> {
    plan.anchors.iter().map(|anchor| anchor.seen_from(base, &plan.world.base))
}

/// Moves a rod without base motion, without velocity, to where the base of another one is.
pub(super) fn place<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>, base: &Base) {
    work.motion_is_known = false;
    see(plan, work, base.at_rest());
}

fn see<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>, base: Base) {
    work.surroundings = Surroundings::new(&plan.world, plan.frame, base);
    for (anchor, seen) in work.anchors.iter_mut().zip(seen_anchors(plan, &base)) {
        *anchor = seen;
    }
}

/// Takes base and loads at the time `t`. Where a function of time fails, no time is set.
pub(super) fn set<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>, t: f64) -> Result<(), Interrupted> {
    work.time = f64::NAN;
    work.motion_is_known = false;
    if let Some(motion) = &plan.world.motion {
        see(plan, work, motion.at(t)?);
        let base = &mut work.stations[0];
        (base.velocity, base.acceleration) = work.surroundings.motion(&plan.world, plan.frame);
    }
    for (load, acting) in plan.loads.iter().zip(&mut work.acting) {
        if let Some([force, moment]) = &load.signals {
            let now = [force.at(t)?, moment.at(t)?];
            *acting = plan::wrench(now, load.frame, plan.frame, &work.surroundings.base.rotation);
        }
    }
    work.time = t;
    Ok(())
}
