//! Positions, velocities and Jacobians of places of a robot.

use super::Sweeps;
use crate::numerics::lie::Vector;
use crate::numerics::linalg::Matrix;
use crate::robot::kernel::kinematics::Pose;
use crate::robot::kernel::sizes::{Extent, Motions};
use crate::robot::kernel::{acceleration, kinematics, sizes};
use crate::robot::plan::point::Place;
use crate::robot::turning::Turning;
use crate::robot::turning::place;

impl<G: Turning> Sweeps<G> {
    /// Place at arc length `x` of a link's rod, by default its tip; the base for a rigid link.
    pub(crate) fn place(&self, link: usize, x: Option<f64>) -> Place {
        place::on_link(&self.plan.pieces, &self.plan.links[link], x)
    }

    pub(crate) fn pose(&mut self, q: &[f64], place: &Place) -> Pose {
        self.update_kinematics(q);
        kinematics::pose(&self.plan, &self.work, q, place)
    }

    /// Jacobian of the pose of a place, 6 x n, in world axes.
    pub(crate) fn jacobian(&mut self, q: &[f64], place: &Place, jacobian: &mut Matrix) {
        self.update_kinematics(q);
        kinematics::jacobian(&self.plan, &self.work, place, jacobian);
    }

    /// Motions by the coordinates in a shape of sections, these bodies, and ends of loops, tendons and contacts. Allocates.
    pub(crate) fn motions(&mut self, q: &[f64], bodies: &[Extent]) -> Motions {
        self.with_zeros(|sweeps, zeros| sweeps.update_motion([q, zeros, zeros]));
        let Self { plan, work, tangent, .. } = self;
        let extents = [&sizes::sections(plan)[..], bodies].concat();
        sizes::motions(plan, work, tangent, &extents)
    }

    /// Angular velocity of a place and velocity of its point, in world axes.
    pub(crate) fn velocity(&mut self, q: &[f64], qd: &[f64], place: &Place) -> [Vector<f64>; 2] {
        self.update_velocities(q, qd);
        kinematics::velocity(&self.plan, &self.work, place)
    }

    /// Angular acceleration of a place and acceleration of its point, in world axes.
    pub(crate) fn acceleration(&mut self, state: [&[f64]; 3], place: &Place) -> [Vector<f64>; 2] {
        self.update_motion(state);
        acceleration::acceleration(&self.plan, &self.work, place)
    }

    /// Position of a place, or of an offset from it, in the frame of the base.
    pub(crate) fn beside(&mut self, q: &[f64], place: &Place, offset: Option<Vector<f64>>) -> Vector<f64> {
        let position = self.position(q, place);
        let Some(mut offset) = offset else { return position };
        if let Some(beside) = place.beside {
            offset = beside.orientation.rotation().apply(offset);
        }
        let piece = &self.plan.pieces[place.piece];
        let rotation = place::rotation_at(piece, &self.work, q, place);
        let within = G::vector_of(self.plan.frame, offset);
        // Includes the component across a plane of motion, so that planar and spatial models of a robot agree.
        let across = offset - G::in_space(self.plan.frame, within);
        position + G::in_space(self.plan.frame, G::rotate(&rotation, within)) + across
    }

    /// Position of a place in the frame of the base.
    pub(crate) fn position(&mut self, q: &[f64], place: &Place) -> Vector<f64> {
        self.update_kinematics(q);
        G::in_space(self.plan.frame, kinematics::position(&self.plan, &self.work, place))
    }
}
