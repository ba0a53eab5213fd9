//! A compiled rod with its memory: what the integrators work with.

use std::sync::Arc;

use super::description::Rod;
use super::kinematics::{self, Pose};
use super::plan::Plan;
use super::tangent::{self, TangentWorkspace};
use super::workspace::Workspace;
use super::{energy, inverse_dynamics};
use crate::error::InvalidInput;
use crate::linalg::Matrix;
use crate::model::{Energy, Model};

/// A Cosserat rod ready to be moved. Clones share the plan and have memory of their own.
#[derive(Clone, Debug)]
pub struct RodModel {
    arch: pulp::Arch,
    plan: Arc<Plan>,
    work: Workspace,
    tangent: TangentWorkspace,
    zeros: Vec<f64>,
}

impl RodModel {
    /// Compiles `rod`; refuses one that is not valid, with everything that is wrong with it.
    pub fn new(rod: &Rod) -> Result<Self, InvalidInput> {
        let plan = Arc::new(Plan::new(rod)?);
        Ok(Self {
            arch: pulp::Arch::new(),
            work: Workspace::new(&plan),
            tangent: TangentWorkspace::new(&plan),
            zeros: vec![0.0; plan.n],
            plan,
        })
    }

    /// What was computed once.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// The pose at arc length `x` of the unstretched rod, 0 <= x <= L (clamped there): the body axes and the position in
    /// the world.
    pub fn pose(&mut self, q: &[f64], x: f64) -> Pose {
        kinematics::update(&self.plan, &mut self.work, q);
        kinematics::pose(&self.plan, &self.work, q, x)
    }
}

// The sweeps are compiled once for every instruction set that pulp knows and run with the best the machine has. They are
// structs, not closures: what pulp compiles must be inlined into its caller, which a closure promises to nobody.

struct InverseDynamics<'a> {
    plan: &'a Plan,
    work: &'a mut Workspace,
    state: [&'a [f64]; 3],
    tau: &'a mut [f64],
}

impl pulp::NullaryFnOnce for InverseDynamics<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let [q, qd, qdd] = self.state;
        inverse_dynamics::update(self.plan, self.work, q, qd, qdd);
        inverse_dynamics::project(self.plan, self.work, q, qd, self.tau);
    }
}

struct Tangent<'a> {
    plan: &'a Plan,
    work: &'a mut Workspace,
    memory: &'a mut TangentWorkspace,
    state: [&'a [f64]; 3],
    weights: [f64; 3],
    tangent: &'a mut Matrix,
}

impl pulp::NullaryFnOnce for Tangent<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let [q, qd, qdd] = self.state;
        inverse_dynamics::update(self.plan, self.work, q, qd, qdd);
        tangent::weighted_tangent(self.plan, self.work, self.memory, self.weights, self.tangent);
    }
}

struct MassMatrix<'a> {
    plan: &'a Plan,
    work: &'a mut Workspace,
    memory: &'a mut TangentWorkspace,
    q: &'a [f64],
    mass: &'a mut Matrix,
}

impl pulp::NullaryFnOnce for MassMatrix<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        kinematics::update(self.plan, self.work, self.q);
        tangent::weighted_tangent(self.plan, self.work, self.memory, [0.0, 0.0, 1.0], self.mass);
    }
}

impl Model for RodModel {
    fn n(&self) -> usize {
        self.plan.n
    }

    fn inverse_dynamics(&mut self, q: &[f64], qd: &[f64], qdd: &[f64], tau: &mut [f64]) {
        let Self { arch, plan, work, .. } = self;
        arch.dispatch(InverseDynamics { plan, work, state: [q, qd, qdd], tau });
    }

    fn weighted_tangent(
        &mut self,
        q: &[f64],
        qd: &[f64],
        qdd: &[f64],
        weights: [f64; 3],
        tangent: &mut Matrix,
    ) {
        let Self { arch, plan, work, tangent: memory, .. } = self;
        let state = [q, qd, qdd];
        arch.dispatch(Tangent { plan, work, memory, state, weights, tangent });
    }

    /// `M = int Psi^T N Psi`, which is the tangent with respect to `qdd`: symmetric to rounding because the quadrature
    /// sums by parts exactly, and made so to the last bit.
    fn mass_matrix(&mut self, q: &[f64], mass: &mut Matrix) {
        let Self { arch, plan, work, tangent: memory, .. } = self;
        arch.dispatch(MassMatrix { plan, work, memory, q, mass });
        for k in 0..self.plan.n {
            for j in 0..k {
                let mean = 0.5 * (mass[(j, k)] + mass[(k, j)]);
                mass[(j, k)] = mean;
                mass[(k, j)] = mean;
            }
        }
    }

    fn energy(&mut self, q: &[f64], qd: &[f64]) -> Energy {
        inverse_dynamics::update(&self.plan, &mut self.work, q, qd, &self.zeros);
        energy::energy(&self.plan, &self.work, q)
    }

    fn dissipated_power(&mut self, _q: &[f64], qd: &[f64]) -> f64 {
        energy::dissipated_power(&self.plan, qd)
    }
}
