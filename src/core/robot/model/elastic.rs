//! Elasticity of a robot.

use super::{AnySweeps, RobotModel};
use crate::model::springs::{LengthTendons, Springs};
use crate::model::{Elastic, Sprung, chart};
use crate::numerics::linalg::Matrix;
use crate::robot::effects::support::force::Held;
use crate::robot::kernel::{elasticity, sizes};
use crate::robot::state::tangent::Tangent;

impl Sprung for RobotModel {
    fn linearise_springs(&mut self, q: &[f64], springs: &mut Springs) {
        let Self { sweeps, coordinates, .. } = self;
        let found = coordinates.all([q], |[q]| on_sweeps!(sweeps, sweeps => sweeps.springs(q)));
        springs.energy = found.iter().map(|springs| springs.energy).sum();
        for (a, Held { forces, stiffness, firm, .. }) in found.into_iter().enumerate() {
            for half in 0..2 {
                let first = 6 * a + 3 * half;
                springs.forces[first..first + 3].copy_from_slice(&forces[half].to_array());
                elasticity::write_roots(&stiffness[half], firm[half], first, springs);
            }
        }
        self.find_jacobian_of_springs(q, &mut springs.jacobian);
    }

    fn hold_springs(&mut self, forces: Option<&[f64]>) {
        self.fixed_spring_forces = forces.map(<[f64]>::to_vec);
        on_sweeps!(&mut self.sweeps, sweeps => sweeps.hold_springs(forces));
        if let Some(unloaded) = &mut self.unloaded {
            on_sweeps!(&mut **unloaded, sweeps => sweeps.hold_springs(forces));
        }
    }

    fn linearise_length_tendons(&mut self, q: &[f64], length_tendons: &mut LengthTendons) {
        let Self { sweeps, coordinates, .. } = self;
        let mut of_all = LengthTendons::new(
            length_tendons.stiffness.len(),
            on_sweeps!(&*sweeps, sweeps => sweeps.plan().n),
        );
        coordinates.all(
            [q],
            |[q]| on_sweeps!(&mut *sweeps, sweeps => sweeps.linearise_length_tendons(q, &mut of_all)),
        );
        length_tendons.jacobian = coordinates.own_columns(of_all.jacobian);
        length_tendons.reach = coordinates.own_columns(of_all.reach);
        length_tendons.stiffness = of_all.stiffness;
        length_tendons.excesses = of_all.excesses;
        length_tendons.spans = of_all.spans;
    }

    fn hold_length_tendons(&mut self, tensions: Option<&[f64]>) {
        self.cached.forget();
        on_sweeps!(&mut self.sweeps, sweeps => sweeps.hold_length_tendons(tensions));
    }
}

impl Elastic for RobotModel {
    /// `K q`, and forces of the supports.
    fn elastic_forces(&mut self, q: &[f64], tau: &mut [f64]) {
        self.place_unloaded();
        let Self { sweeps, unloaded, coordinates, .. } = self;
        coordinates.forces([q], tau, |[q], tau| match unloaded.as_deref_mut() {
            Some(unloaded) => on_sweeps!(unloaded, sweeps => sweeps.forces_at_rest(q, tau)),
            None => on_sweeps!(&*sweeps, sweeps => elasticity::forces(sweeps.plan(), q, tau)),
        });
    }

    fn elastic_tangent(&mut self, q: &[f64], tangent: &mut Matrix) {
        self.place_unloaded();
        let Self { sweeps, unloaded, coordinates, .. } = self;
        coordinates.matrix([q], tangent, |[q], tangent| match unloaded.as_deref_mut() {
            Some(unloaded) => {
                on_sweeps!(unloaded, sweeps => sweeps.tangent_at_rest(q, Tangent::Dense(tangent)));
            }
            None => on_sweeps!(&*sweeps, sweeps => elasticity::stiffness(sweeps.plan(), q, tangent)),
        });
    }

    fn turned_loads(&mut self, q: &[f64], forces: &mut Matrix, constraint_loads: &mut [f64]) {
        let Self { sweeps, coordinates, .. } = self;
        let n = on_sweeps!(&*sweeps, sweeps => sweeps.plan().n);
        let (mut of_all, mut all_constraint_loads) = (Matrix::zeros(3, n), Matrix::zeros(1, n));
        coordinates.all([q], |[q]| {
            let constraint_loads = all_constraint_loads.as_mut_slice();
            on_sweeps!(&mut *sweeps, sweeps => sweeps.turned_loads(q, &mut of_all, constraint_loads));
        });
        forces.copy_from(&coordinates.own_columns(of_all).transpose());
        let own = coordinates.own_columns(all_constraint_loads);
        constraint_loads.iter_mut().zip(own.iter()).for_each(|(load, own)| *load = own.abs());
    }

    fn sizes(&mut self, q: &[f64], sizes: &mut [f64]) {
        if q.is_empty() {
            return;
        }
        let fallback = self.facts.length;
        let bodies = self.bodies();
        let Self { sweeps, coordinates, facts, .. } = self;
        on_sweeps!(sweeps, sweeps => {
            let motions = coordinates.all([q], |[q]| sweeps.motions(q, &bodies));
            let plan = sweeps.plan();
            let mut rows = coordinates.own_columns(motions.rows(plan.n));
            chart::rows(&facts.rotation_vectors, q, &mut rows);
            let are_strains = coordinates.own_of(&sizes::are_strains(plan));
            motions.sizes(&rows, &are_strains, fallback, sizes);
        });
    }
}
