//! Forces, inertia and energies of a robot.

use super::RobotModel;
use super::any_sweeps::AnySweeps;
use crate::model::constraint::one_sided;
use crate::model::{
    Dynamics, Energy, Facts, ForwardScratch, InvalidShape, SingularMass, Tree, forward_dynamics,
};
use crate::numerics::linalg::{Matrix, TreeMatrix};
use crate::robot::choice::Solve;
use crate::robot::explain::Multiplications;
use crate::robot::kernel::{tree, validity};
use crate::robot::state::tangent::Tangent;

impl Dynamics for RobotModel {
    fn facts(&self) -> &Facts {
        &self.facts
    }

    fn inverse_dynamics(&mut self, q: &[f64], qd: &[f64], qdd: &[f64], tau: &mut [f64]) {
        let Self { sweeps, coordinates, .. } = self;
        coordinates.forces([q, qd, qdd], tau, |state, tau| {
            on_sweeps!(sweeps, sweeps => sweeps.inverse_dynamics(state, tau));
        });
    }

    fn weighted_tangent(
        &mut self,
        q: &[f64],
        qd: &[f64],
        qdd: &[f64],
        weights: [f64; 3],
        tangent: &mut Matrix,
    ) {
        let Self { sweeps, coordinates, .. } = self;
        coordinates.matrix([q, qd, qdd], tangent, |state, tangent| {
            let tangent = Tangent::Dense(tangent);
            on_sweeps!(sweeps, sweeps => sweeps.weighted_tangent(state, weights, tangent));
        });
    }

    fn invalid_shape(&mut self, q: &[f64]) -> Option<InvalidShape> {
        let own = q;
        let q = self.coordinates.only_own(q);
        on_sweeps!(&self.sweeps, sweeps => validity::invalid_shape(sweeps.plan(), q))
            .or_else(|| self.collapsed(own))
    }

    fn forward_dynamics(
        &mut self,
        q: &[f64],
        qd: &[f64],
        qdd: &mut [f64],
        scratch: &mut ForwardScratch,
    ) -> Result<(), SingularMass> {
        if on_sweeps!(&self.sweeps, sweeps => sweeps.is_lone_rod())
            && let Some((bias, mass)) = scratch.dense()
        {
            on_sweeps!(&mut self.sweeps, sweeps => sweeps.forces_and_mass([q, qd], bias, mass));
            return scratch.solve(qdd);
        }
        match self.facts.constraints() {
            0 => forward_dynamics(self, q, qd, qdd, scratch),
            m => one_sided::accelerations(self, q, qd, qdd, &mut vec![0.0; m]),
        }
    }

    /// Ratio of the products of both, including the factorisation.
    fn tangent_cost(&self) -> f64 {
        let Multiplications { residual, tangent, factorisation, .. } = self.multiplications();
        (tangent + factorisation) as f64 / residual.max(1) as f64
    }

    /// `M = int Psi^T N Psi`, the tangent with respect to `qdd`. Symmetric to rounding, because summation by
    /// parts is exact for the quadrature; therefore only half of it is computed.
    fn mass_matrix(&mut self, q: &[f64], mass: &mut Matrix) {
        let Self { sweeps, coordinates, .. } = self;
        coordinates.matrix([q], mass, |[q], mass| {
            on_sweeps!(sweeps, sweeps => sweeps.mass_matrix(q, Tangent::Dense(mass)));
        });
    }

    fn tree(&self) -> Option<Tree> {
        (self.solve == Solve::Tree).then(|| {
            on_sweeps!(&self.sweeps, sweeps => {
                let plan = sweeps.plan();
                Tree { tangent: tree::tangent(plan), mass: tree::mass(plan) }
            })
        })
    }

    fn tree_tangent(
        &mut self,
        q: &[f64],
        qd: &[f64],
        qdd: &[f64],
        weights: [f64; 3],
        tangent: &mut TreeMatrix,
    ) {
        let tangent = Tangent::Tree(tangent);
        on_sweeps!(&mut self.sweeps, sweeps => sweeps.weighted_tangent([q, qd, qdd], weights, tangent));
    }

    fn tree_mass_matrix(&mut self, q: &[f64], mass: &mut TreeMatrix) {
        on_sweeps!(&mut self.sweeps, sweeps => sweeps.mass_matrix(q, Tangent::Tree(mass)));
    }

    fn energy(&mut self, q: &[f64], qd: &[f64]) -> Energy {
        let has_left = on_sweeps!(&self.sweeps, sweeps => sweeps.has_left_contact());
        if !has_left && let Some(known) = self.cached.of([q, qd]) {
            return known.energy;
        }
        let Self { sweeps, coordinates, .. } = self;
        coordinates.all([q, qd], |[q, qd]| on_sweeps!(sweeps, sweeps => sweeps.energy(q, qd)))
    }

    fn dissipated_power(&mut self, q: &[f64], qd: &[f64]) -> f64 {
        let Self { sweeps, coordinates, .. } = self;
        coordinates.all([q, qd], |[q, qd]| on_sweeps!(sweeps, sweeps => sweeps.dissipated_power(q, qd)))
    }

    fn tip(&mut self, q: &[f64]) -> [f64; 3] {
        let tip = self.tip_place();
        let Self { sweeps, coordinates, .. } = self;
        coordinates.all([q], |[q]| on_sweeps!(sweeps, sweeps => sweeps.position(q, &tip))).to_array()
    }

    /// Tips of rods; for rigid links three points around the centre of mass, at the distance of the radius of
    /// gyration.
    fn places(&mut self, q: &[f64], places: &mut Vec<[f64; 3]>) {
        let Self { sweeps, coordinates, measured_places, .. } = self;
        coordinates.all([q], |[q]| {
            for place in &**measured_places {
                let position =
                    on_sweeps!(&mut *sweeps, sweeps => sweeps.beside(q, &place.place, place.offset));
                places.push(position.to_array());
            }
        });
    }

    /// Power of follower loads, of varying loads, of moments (a moment fixed in space has no potential), of a
    /// moving base, and of prescribed joints.
    fn supplied_power(&mut self, q: &[f64], qd: &[f64], qdd: &[f64]) -> f64 {
        let state = [q, qd, qdd];
        let power = |model: &mut Self| {
            let Self { sweeps, coordinates, .. } = model;
            let power = coordinates
                .all(state, |state| on_sweeps!(&mut *sweeps, sweeps => sweeps.supplied_power(state)));
            let of_joints = coordinates.power(state, |state, tau| {
                on_sweeps!(&mut *sweeps, sweeps => sweeps.inverse_dynamics(state, tau));
            });
            power + of_joints
        };
        // Constraint forces do no work, but prescribed joints, a moving base and winches work against them.
        let is_against = self.robot.is_tied_to_world() || self.facts.is_one_sided;
        match self.coordinates.vary_in_time() || is_against {
            true => self.with_loops_held(state, power),
            false => power(self),
        }
    }
}
