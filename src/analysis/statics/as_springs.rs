//! A model whose constraints are replaced by almost rigid springs, for paths of equilibria.
//!
//! Statics treats the forces of springs as separate unknowns (see [`crate::analysis::normalised`]), so that results do not depend on the
//! stiffness. The springs' deflection, force over stiffness, is at the level of rounding.

use crate::analysis::normalised;
use crate::error::Interrupted;
use crate::model::constraint::forget_unmoved;
use crate::model::springs::{LengthTendons, Springs};
use crate::model::{
    ContactText, Dynamics, Elastic, Energy, Facts, InContact, InTime, InvalidShape, OneSided, Overlap,
    Radius, Reached, Softened, Sprung, Static, Switch, Untied,
};
use crate::numerics::linalg::Matrix;

/// Stiffness of a spring in units of the stiffness of the motions that its constraint prevents: its deflection is then rounding of
/// displacements. With a tenth of that, the deflections of a clamped arch are asymmetric enough to lead its path off the symmetric
/// branch.
const STIFFNESS_OF_CONSTRAINTS: f64 = 1e13;

/// A model whose loops are closed by springs.
pub(crate) struct AsSprings<'a> {
    model: &'a mut dyn Static,
    facts: Facts,
    /// Stiffness of the spring of every constraint.
    stiffness: Vec<f64>,
    /// Sizes of the coordinates, and the resistance to a step of one size: the largest of material, tangent, and weight and loads.
    sizes: Vec<f64>,
    resistance: Vec<f64>,
    /// Prescribed multipliers, the opposite of the springs' forces.
    fixed_multipliers: Option<Vec<f64>>,
    multipliers: Vec<f64>,
    gap_jacobian: Matrix,
}

impl<'a> AsSprings<'a> {
    /// With springs that are stiff relative to the model near a shape.
    pub(crate) fn new(model: &'a mut dyn Static, q: &[f64]) -> Self {
        let (n, m) = (q.len(), model.facts().constraints());
        let facts = facts_with_springs(model.facts());
        let (mut sizes, rest) = (vec![0.0; n], vec![0.0; n]);
        model.sizes(q, &mut sizes);
        let (mut elastic, mut tangent) = (Matrix::zeros(n, n), Matrix::zeros(n, n));
        model.set_multipliers(&vec![0.0; m]);
        model.elastic_tangent(q, &mut elastic);
        model.weighted_tangent(q, &rest, &rest, [1.0, 0.0, 0.0], &mut tangent);
        let [elastic, tangent] = [elastic, tangent].map(|matrix| normalised::scaled(matrix, &sizes));
        let work = normalised::work_of_loads(model, q, &sizes);
        let material = normalised::reference(&elastic, &tangent, &work, &model.facts().parts, &[]);
        let most = |k: usize| material[k].max(tangent[(k, k)].abs()).max(work[k]);
        let mut springs = Self {
            stiffness: vec![STIFFNESS_OF_CONSTRAINTS; m],
            resistance: (0..n).map(most).collect(),
            sizes,
            facts,
            model,
            fixed_multipliers: None,
            multipliers: vec![0.0; m],
            gap_jacobian: Matrix::zeros(m, n),
        };
        springs.stiffen(q);
        springs
    }

    /// Finds the Jacobian of the gaps.
    fn find_rows(&mut self, q: &[f64]) {
        self.model.gap_jacobian(q, &mut self.gap_jacobian);
        forget_unmoved(&mut self.gap_jacobian, &self.sizes, &self.model.facts().gap_sizes);
    }

    /// Computes the stiffnesses of the springs of active constraints for a shape.
    fn stiffen(&mut self, q: &[f64]) {
        self.find_rows(q);
        for (stiffness, row) in self.stiffness.iter_mut().zip(self.gap_jacobian.row_iter()) {
            let moved = row.iter().zip(&self.sizes).map(|(x, size)| (x * size).powi(2));
            let gives: f64 =
                moved.zip(&self.resistance).map(|(square, resistance)| square / resistance).sum();
            if gives > 0.0 && gives.is_finite() {
                *stiffness = STIFFNESS_OF_CONSTRAINTS / gives;
            }
        }
    }

    /// Sets the multipliers of the model: the fixed ones, or those of the springs for its gaps.
    fn answer(&mut self, q: &[f64]) {
        match &self.fixed_multipliers {
            Some(fixed) => self.multipliers.copy_from_slice(fixed),
            None => {
                self.model.gaps(q, &mut self.multipliers);
                self.multipliers
                    .iter_mut()
                    .zip(&self.stiffness)
                    .for_each(|(gap, stiffness)| *gap *= stiffness);
            }
        }
        self.model.set_multipliers(&self.multipliers);
    }

    fn release(&mut self) {
        self.multipliers.fill(0.0);
        self.model.set_multipliers(&self.multipliers);
    }

    /// Adds the stiffness of the springs, unless their forces are fixed.
    fn add_stiffness(&mut self, q: &[f64], weight: f64, tangent: &mut Matrix) {
        if self.fixed_multipliers.is_some() || weight == 0.0 {
            return;
        }
        self.find_rows(q);
        let mut weighted = self.gap_jacobian.clone();
        for (mut row, stiffness) in weighted.row_iter_mut().zip(&self.stiffness) {
            row *= weight * stiffness;
        }
        *tangent += self.gap_jacobian.tr_mul(&weighted);
    }
}

/// Facts of a model whose constraints are springs. Its tendons are no longer tendons.
fn facts_with_springs(of_model: &Facts) -> Facts {
    Facts {
        gap_sizes: Vec::new(),
        springs: of_model.springs + of_model.constraints(),
        length_tendons: 0,
        section_places: Vec::new(),
        free_lengths: 0,
        ..of_model.clone()
    }
}

impl Elastic for AsSprings<'_> {
    fn elastic_forces(&mut self, q: &[f64], tau: &mut [f64]) {
        self.model.elastic_forces(q, tau);
        self.answer(q);
        self.find_rows(q);
        for (j, tau) in tau.iter_mut().enumerate() {
            *tau += (0..self.multipliers.len())
                .map(|i| self.gap_jacobian[(i, j)] * self.multipliers[i])
                .sum::<f64>();
        }
        self.release();
    }

    /// The part of the multipliers is the difference of the tangents with and without them.
    fn elastic_tangent(&mut self, q: &[f64], tangent: &mut Matrix) {
        self.model.elastic_tangent(q, tangent);
        self.answer(q);
        if self.multipliers.iter().any(|&multiplier| multiplier != 0.0) {
            let rest = vec![0.0; q.len()];
            let mut part = Matrix::zeros(q.len(), q.len());
            self.model.weighted_tangent(q, &rest, &rest, [1.0, 0.0, 0.0], &mut part);
            *tangent += &part;
            self.release();
            self.model.weighted_tangent(q, &rest, &rest, [1.0, 0.0, 0.0], &mut part);
            *tangent -= &part;
        }
        self.add_stiffness(q, 1.0, tangent);
    }

    fn turned_loads(&mut self, q: &[f64], forces: &mut Matrix, constraint_loads: &mut [f64]) {
        self.model.turned_loads(q, forces, constraint_loads);
    }

    fn sizes(&mut self, q: &[f64], sizes: &mut [f64]) {
        self.model.sizes(q, sizes);
    }
}

impl Sprung for AsSprings<'_> {
    fn linearise_springs(&mut self, q: &[f64], springs: &mut Springs) {
        let (n, before, m) = (q.len(), self.model.facts().springs, self.stiffness.len());
        let mut first = Springs::new(before, n);
        if before > 0 {
            self.model.linearise_springs(q, &mut first);
        }
        springs.begin_with(&first);
        let mut gaps = vec![0.0; m];
        self.model.gaps(q, &mut gaps);
        self.find_rows(q);
        springs.jacobian.view_mut((before, 0), (m, n)).copy_from(&self.gap_jacobian);
        for (i, (gap, stiffness)) in gaps.into_iter().zip(&self.stiffness).enumerate() {
            springs.stretch(before + i, *stiffness, gap);
        }
    }

    fn hold_springs(&mut self, forces: Option<&[f64]>) {
        let before = self.model.facts().springs;
        self.model.hold_springs(forces.map(|forces| &forces[..before]).filter(|_| before > 0));
        self.fixed_multipliers = forces.map(|forces| forces[before..].iter().map(|force| -force).collect());
    }

    fn linearise_length_tendons(&mut self, _q: &[f64], _tendons: &mut LengthTendons) {}

    fn hold_length_tendons(&mut self, _tensions: Option<&[f64]>) {}
}

impl InTime for AsSprings<'_> {
    fn set_time(&mut self, t: f64) -> Result<(), Interrupted> {
        self.model.set_time(t)
    }

    fn set_inputs(&mut self, u: &[f64]) {
        self.model.set_inputs(u);
    }

    fn not_finite(&self) -> Option<String> {
        self.model.not_finite()
    }

    fn input_tangent(&mut self, q: &[f64], qd: &[f64], qdd: &[f64], tangent: &mut Matrix) {
        self.model.input_tangent(q, qd, qdd, tangent);
    }
}

impl Untied for AsSprings<'_> {}

/// Its loops are springs. One-sided constraints remain one-sided; their multipliers are the opposite of the springs' forces.
impl OneSided for AsSprings<'_> {
    fn active(&self) -> Vec<bool> {
        self.model.active()
    }

    fn release(&mut self, multipliers: &[f64]) {
        self.model.release(multipliers);
    }

    fn switch(&mut self, q: &[f64], multipliers: &mut [f64]) -> Switch {
        let before = multipliers.len() - self.stiffness.len();
        let switch = self.model.switch(q, &mut multipliers[before..]);
        if switch == Switch::Activated {
            self.stiffen(q);
        }
        switch
    }

    fn release_open(&mut self, _q: &[f64], _qd: Option<&[f64]>) {}

    fn keep_active_set(&mut self, _is_kept: bool) {}

    fn passed(&mut self, _q: &[f64], _qd: &[f64]) -> Vec<[f64; 2]> {
        Vec::new()
    }
}

impl InContact for AsSprings<'_> {
    fn reached(&mut self, q: &[f64]) -> Vec<Reached> {
        self.model.reached(q)
    }

    fn decide(&mut self, reached: &[Reached]) {
        self.model.decide(reached);
    }

    fn leave_contact(&mut self, is_left: bool) {
        self.model.leave_contact(is_left);
    }

    fn soften_contact(&mut self, soft: Option<Softened<'_>>) -> bool {
        self.model.soften_contact(soft)
    }

    fn deepest_overlaps(&mut self, q: &[f64]) -> [Option<Overlap>; 2] {
        self.model.deepest_overlaps(q)
    }

    fn deepest_overlap(&mut self, q: &[f64]) -> Option<Overlap> {
        self.model.deepest_overlap(q)
    }

    fn text_of_contact(&self, contact: usize, text: ContactText) -> String {
        self.model.text_of_contact(contact, text)
    }

    fn advice_at_end(&mut self, failed: &[&[f64]], deepest: Option<Overlap>) -> String {
        self.model.advice_at_end(failed, deepest)
    }

    fn shifts_of_contact(&mut self, q: &[f64]) -> Matrix {
        self.model.shifts_of_contact(q)
    }

    fn work_of_interactions(&mut self, q: &[f64], work: &mut [f64]) {
        self.model.work_of_interactions(q, work);
    }

    fn deep_penetration(&mut self, q: &[f64]) -> Option<InvalidShape> {
        self.model.deep_penetration(q)
    }

    fn store_surfaces(&mut self, q: &[f64]) {
        self.model.store_surfaces(q);
    }

    fn have_tunnelled(&mut self, q: &[f64], radius: Radius) -> bool {
        self.model.have_tunnelled(q, radius)
    }

    fn is_touched(&self) -> bool {
        self.model.is_touched()
    }
}

impl Dynamics for AsSprings<'_> {
    fn facts(&self) -> &Facts {
        &self.facts
    }

    fn inverse_dynamics(&mut self, q: &[f64], qd: &[f64], qdd: &[f64], tau: &mut [f64]) {
        self.answer(q);
        self.model.inverse_dynamics(q, qd, qdd, tau);
        self.release();
    }

    fn weighted_tangent(
        &mut self,
        q: &[f64],
        qd: &[f64],
        qdd: &[f64],
        weights: [f64; 3],
        tangent: &mut Matrix,
    ) {
        self.answer(q);
        self.model.weighted_tangent(q, qd, qdd, weights, tangent);
        self.release();
        self.add_stiffness(q, weights[0], tangent);
    }

    fn tangent_cost(&self) -> f64 {
        self.model.tangent_cost()
    }

    fn mass_matrix(&mut self, q: &[f64], mass: &mut Matrix) {
        self.model.mass_matrix(q, mass);
    }

    fn energy(&mut self, q: &[f64], qd: &[f64]) -> Energy {
        self.model.energy(q, qd)
    }

    fn dissipated_power(&mut self, q: &[f64], qd: &[f64]) -> f64 {
        self.model.dissipated_power(q, qd)
    }

    fn tip(&mut self, q: &[f64]) -> [f64; 3] {
        self.model.tip(q)
    }

    fn places(&mut self, q: &[f64], places: &mut Vec<[f64; 3]>) {
        self.model.places(q, places);
    }

    fn supplied_power(&mut self, q: &[f64], qd: &[f64], qdd: &[f64]) -> f64 {
        self.model.supplied_power(q, qd, qdd)
    }

    fn invalid_shape(&mut self, q: &[f64]) -> Option<InvalidShape> {
        self.model.invalid_shape(q)
    }
}
