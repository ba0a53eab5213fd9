//! The equations of equilibrium of a model under a part of its loads.

use crate::error::Interrupted;
use crate::linalg::Matrix;
use crate::model::Model;
use crate::modes::{SmallMotions, scaled};

/// What a search has cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Newton iterations.
    pub iterations: usize,
    /// Evaluations of the generalised forces.
    pub forces: usize,
    /// Evaluations of their tangent.
    pub tangents: usize,
}

/// `R(q, lambda) = tau_elastic(q) + lambda (tau(q) - tau_elastic(q)) = 0` at rest: the load factor lambda scales all loads
/// at once, gravity included, and nothing of it needs a potential.
///
/// Coordinates and forces have different units, so that norms make sense only of `q_i / s_i` and `s_i R_i` with the typical
/// sizes s of the model: numbers without unit, and joules. What is called *scaled* below is meant so; scaled tangents are
/// `S (dR/dq) S`, symmetric where the loads have a potential.
pub(super) struct Equations<'a> {
    model: &'a mut dyn Model,
    monitor: &'a mut dyn FnMut() -> Result<(), Interrupted>,
    pub(super) sizes: Vec<f64>,
    pub(super) counters: Counters,
    rest: Vec<f64>,
    elastic: Vec<f64>,
    elastic_tangent: Matrix,
}

impl<'a> Equations<'a> {
    /// `monitor` is asked before every evaluation of forces whether to go on.
    pub(super) fn new(
        model: &'a mut dyn Model,
        monitor: &'a mut dyn FnMut() -> Result<(), Interrupted>,
    ) -> Self {
        let n = model.n();
        let mut sizes = vec![0.0; n];
        model.typical_coordinates(&mut sizes);
        Self {
            model,
            monitor,
            sizes,
            counters: Counters::default(),
            rest: vec![0.0; n],
            elastic: vec![0.0; n],
            elastic_tangent: Matrix::zeros(n, n),
        }
    }

    pub(super) fn n(&self) -> usize {
        self.sizes.len()
    }

    /// How many times as many nodes a shape takes that the model does not resolve.
    pub(super) fn shortage_of_nodes(&self, q: &[f64]) -> Option<f64> {
        self.model.shortage_of_nodes(q)
    }

    /// The scaled residual, and its derivative with respect to the load factor.
    pub(super) fn residual(
        &mut self,
        q: &[f64],
        load_factor: f64,
        residual: &mut [f64],
        load: &mut [f64],
    ) -> Result<(), Interrupted> {
        (self.monitor)()?;
        self.counters.forces += 1;
        self.model.inverse_dynamics(q, &self.rest, &self.rest, load);
        self.model.elastic_forces(q, &mut self.elastic);
        for i in 0..q.len() {
            let size = self.sizes[i];
            load[i] = size * (load[i] - self.elastic[i]);
            residual[i] = size * self.elastic[i] + load_factor * load[i];
        }
        Ok(())
    }

    /// The scaled tangent `dR/dq`.
    pub(super) fn tangent(&mut self, q: &[f64], load_factor: f64, tangent: &mut Matrix) {
        self.counters.tangents += 1;
        self.model.weighted_tangent(q, &self.rest, &self.rest, [1.0, 0.0, 0.0], tangent);
        self.model.elastic_tangent(q, &mut self.elastic_tangent);
        for k in 0..q.len() {
            for j in 0..q.len() {
                let elastic = self.elastic_tangent[(j, k)];
                let value = elastic + load_factor * (tangent[(j, k)] - elastic);
                tangent[(j, k)] = self.sizes[j] * value * self.sizes[k];
            }
        }
    }

    /// Scaled stiffnesses that those of a tangent, the last one, can be compared with: the elastic ones, and where there is no
    /// elasticity what the tangent itself has in that row. All > 0.
    pub(super) fn reference_stiffness(&self, tangent: &Matrix) -> Vec<f64> {
        (0..self.n())
            .map(|i| {
                let elastic = self.sizes[i] * self.elastic_tangent[(i, i)] * self.sizes[i];
                let row = || tangent.row(i).iter().map(|entry| entry.abs()).sum();
                let reference: f64 = if elastic > 0.0 { elastic } else { row() };
                if reference > 0.0 { reference } else { 1.0 }
            })
            .collect()
    }

    /// Whether the model has forces that depend on velocities, besides the damping of its material.
    pub(super) fn has_velocity_forces(&self) -> bool {
        self.model.has_velocity_forces()
    }

    /// The mass matrix in scaled coordinates.
    pub(super) fn mass(&mut self, q: &[f64]) -> Matrix {
        let mut mass = Matrix::zeros(q.len(), q.len());
        self.model.mass_matrix(q, &mut mass);
        scaled(mass, &self.sizes)
    }

    /// Small motions about an equilibrium with its scaled tangent. What depends on velocities is not scaled by the load factor.
    pub(super) fn small_motions(&mut self, q: &[f64], tangent: &Matrix) -> SmallMotions {
        let mut damping = Matrix::zeros(q.len(), q.len());
        self.model.weighted_tangent(q, &self.rest, &self.rest, [0.0, 1.0, 0.0], &mut damping);
        SmallMotions {
            mass: self.mass(q),
            damping: scaled(damping, &self.sizes),
            stiffness: tangent.clone(),
            sizes: self.sizes.clone(),
        }
    }
}
