//! Time-independent data of the base and the world.

use crate::description::world::base_motion::{Base, MovingBase};
use crate::numerics::lie::Vector;
use crate::robot::description::{Link, Robot};
use crate::robot::effects::load::{Extent, Frame};

/// Base and world, independent of time.
#[derive(Clone, Debug)]
pub(crate) struct World {
    /// The base at rest, and its motion if it moves.
    pub(crate) base: Base,
    pub(crate) motion: Option<MovingBase>,
    pub(crate) gravity: Vector<f64>,
    /// Velocity of the fluid, if any.
    pub(crate) current: Vector<f64>,
    /// Sum of the constant dead forces.
    pub(crate) dead_force: Vector<f64>,
    /// Masses of bodies and sections times their offsets from the rod's axis.
    pub(crate) body_moment: Vector<f64>,
}

impl World {
    /// Whether the fluid flows.
    pub(crate) fn has_current(&self) -> bool {
        self.current.dot(self.current) > 0.0
    }

    pub(crate) fn new(robot: &Robot) -> Self {
        let mut dead_force = Vector::zero();
        for load in robot.acting_loads() {
            if let (Frame::World, Some(force)) = (load.frame, load.force.constant()) {
                let amount = if let Extent::Along([from, to]) = load.extent { to - from } else { 1.0 };
                dead_force += Vector::from(force) * amount;
            }
        }
        let mut body_moment = Vector::zero();
        for body in robot.all_bodies() {
            body_moment += Vector::from(body.centre) * body.mass;
        }
        for segment in robot.segments() {
            body_moment += Vector::from(segment.mass_offset());
        }
        let Link { position, orientation, .. } = &robot.links[0];
        let moving = |motion| MovingBase::new(motion, *position, *orientation);
        Self {
            base: Base::at(*position, *orientation),
            motion: robot.base_motion.as_ref().map(moving),
            gravity: robot.gravity.into(),
            current: robot.fluid.as_ref().map_or([0.0; 3], |fluid| fluid.velocity).into(),
            dead_force,
            body_moment,
        }
    }
}
