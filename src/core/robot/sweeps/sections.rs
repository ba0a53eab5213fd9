//! Sections of rods and joints: strains, transmitted wrenches, and derivatives with respect to inertia and lengths.

use super::Sweeps;
use crate::description::rod::STRAINS;
use crate::model::{InertiaMatrix, MissingStrain, SectionPlace};
use crate::numerics::lie::{Cross, LANES, Lanes, Vector, Wrench};
use crate::robot::description::Robot;
use crate::robot::kernel::by_length::ByLength;
use crate::robot::kernel::{by_inertia, by_length, missing_strain, section};
use crate::robot::plan::point::Place;
use crate::robot::turning::Turning;

impl<G: Turning> Sweeps<G> {
    /// Places of the nodes of rods.
    pub(crate) fn section_places(&self) -> Vec<SectionPlace> {
        by_inertia::places(&self.plan)
    }

    /// Adds the derivatives of the power in a virtual motion with respect to the inertia of sections. Allocates.
    pub(crate) fn add_power_by_inertia(
        &mut self,
        state: [&[f64]; 3],
        rates: &[f64],
        by_inertia: &mut [InertiaMatrix],
    ) {
        self.update_motion(state);
        let motion = by_inertia::Motion::of(&self.work);
        self.update_velocities(state[0], rates);
        motion.add(&self.plan, &self.work, by_inertia);
    }

    /// Number of segments whose lengths affect only their rods.
    pub(crate) fn free_lengths(&self) -> usize {
        by_length::segments(&self.plan)
    }

    /// Adds the derivatives of the power in a virtual motion with respect to the lengths of segments. Allocates.
    pub(crate) fn add_power_by_length(&mut self, state: [&[f64]; 3], rates: &[f64], by_length: &mut [f64]) {
        let mut tau = vec![0.0; self.plan.n];
        self.inverse_dynamics(state, &mut tau);
        let Self { plan, work, .. } = self;
        let [q, ..] = state;
        plan.instructions.run::<G::Pack, _>(ByLength { plan, work, q, rates, tau: &tau, by_length });
    }

    /// Strains that the modes leave out of a shape at rest.
    pub(crate) fn missing_strain(&mut self, robot: &Robot, q: &[f64], load_factor: f64) -> MissingStrain {
        let mut tau = vec![0.0; self.plan.n];
        self.forces_at_rest(q, &mut tau);
        let (missing, rigid_stretch) =
            missing_strain::of_balance(&self.plan, &self.work, robot, (q, load_factor));
        let turn = missing_strain::largest_turn(&self.plan, q);
        let effect = missing_strain::effect(&self.plan, &self.work, &missing);
        let rigid_shear = missing_strain::rigid_shear(robot, effect.segment);
        MissingStrain { turn, rigid_shear, rigid_stretch, ..effect }
    }

    /// Effect of a change of the strains of the modes in a shape.
    pub(crate) fn effect_of_strains(&mut self, q: &[f64], change: &[f64]) -> MissingStrain {
        self.update_kinematics(q);
        let strains = missing_strain::of_modes(&self.plan, change);
        let turn = missing_strain::largest_turn(&self.plan, q);
        MissingStrain { turn, ..missing_strain::effect(&self.plan, &self.work, &strains) }
    }

    /// Adds the positions, in the frame of the plan, of all nodes of rods.
    pub(crate) fn outline(&mut self, q: &[f64], positions: &mut Vec<[f64; 3]>) {
        self.update_kinematics(q);
        for piece in self.plan.pieces.iter().filter(|piece| !piece.is_joint) {
            for (pack, position) in self.work.position[piece.node_packs()].iter().enumerate() {
                for lane in 0..LANES.min(piece.gauss.nodes.len() - LANES * pack) {
                    let position = G::map_vector(position, |x: &G::Pack| x.lane(lane));
                    positions.push(G::in_space(self.plan.frame, position).to_array());
                }
            }
        }
    }

    /// Strain at a place of a rod.
    pub(crate) fn strain(&self, q: &[f64], place: &Place) -> [f64; STRAINS] {
        section::strain(&self.plan, q, place)
    }

    /// Moment and force through a section, about its point and in its axes, from the balance of everything
    /// beyond.
    pub(crate) fn internal_wrench(&mut self, state: [&[f64]; 3], place: &Place) -> [Vector<f64>; 2] {
        self.update_motion(state);
        let Wrench { moment, force } = section::internal_wrench(&self.plan, &self.work, state[0], place);
        let frame = self.plan.frame;
        [G::axial_in_space(frame, moment), G::in_space(frame, force)]
    }

    /// The same from the law of the material.
    pub(crate) fn material_wrench(&self, q: &[f64], qd: &[f64], place: &Place) -> [Vector<f64>; 2] {
        let [about_x, about_y, about_z, x, y, z] =
            section::material_wrench(&self.plan, &self.work, q, qd, place);
        [Vector { x: about_x, y: about_y, z: about_z }, Vector { x, y, z }]
    }

    /// Moment, about the place where a link's joint begins, and force transmitted through the joint, in world
    /// axes.
    pub(crate) fn joint_wrench(&mut self, state: [&[f64]; 3], link: usize) -> [Vector<f64>; 2] {
        self.update_motion(state);
        let joined = &self.plan.pieces[self.plan.links[link].pieces.start].joined;
        let Wrench { moment, force } = self.work.through[joined.end];
        let about = moment - self.work.stations[joined.begin].position.cross(force);
        let rotation = &self.work.surroundings.base.rotation;
        let frame = self.plan.frame;
        [G::axial_in_space(frame, about), G::in_space(frame, force)].map(|v| rotation.apply(v))
    }

    /// Moment and force that the base exerts on the rod, in world axes.
    pub(crate) fn base_wrench(&mut self, state: [&[f64]; 3]) -> [Vector<f64>; 2] {
        self.update_motion(state);
        let Wrench { moment, force } = self.work.carried[0];
        let rotation = &self.work.surroundings.base.rotation;
        let frame = self.plan.frame;
        [G::axial_in_space(frame, moment), G::in_space(frame, force)].map(|v| rotation.apply(v))
    }
}
