//! What every mechanical system of lissom offers to the integrators.

use crate::linalg::{Cholesky, Matrix};

/// The energies of a state, in joules.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// Kinetic energy.
    pub kinetic: f64,
    /// Elastic (strain) energy.
    pub elastic: f64,
    /// Potential energy in the gravity field, zero at the world's origin.
    pub gravitational: f64,
    /// Potential energy of the dead loads.
    pub loads: f64,
}

impl Energy {
    /// The sum of all parts: constant in free motion without damping.
    pub fn total(&self) -> f64 {
        self.kinetic + self.elastic + self.gravitational + self.loads
    }
}

/// The mass matrix was not positive definite (or not finite), so that no acceleration exists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SingularMass;

/// A mechanical system with generalised coordinates `q` (n of them), velocities `qd`, accelerations `qdd`.
///
/// `tau(q, qd, qdd)` is the generalised force that the motion needs, elasticity, damping and dead loads
/// included: it is zero in free motion. A model owns its scratch memory, hence `&mut self`; all its methods
/// are pure functions of their arguments otherwise (and of the time last set), and none of them allocates.
/// Slices of the wrong length are a programming error and panic; the bindings check them first.
pub trait Model {
    /// Number of generalised coordinates.
    fn n(&self) -> usize;

    /// Generalised forces `tau` of a motion.
    fn inverse_dynamics(&mut self, q: &[f64], qd: &[f64], qdd: &[f64], tau: &mut [f64]);

    /// `weights[0] dtau/dq + weights[1] dtau/dqd + weights[2] dtau/dqdd`, exact, in one sweep.
    /// With the weights of an implicit step this is that step's Jacobian.
    fn weighted_tangent(
        &mut self,
        q: &[f64],
        qd: &[f64],
        qdd: &[f64],
        weights: [f64; 3],
        tangent: &mut Matrix,
    );

    /// The part of `tau` at rest that is there without any load: that of elasticity, `K q` of a rod.
    fn elastic_forces(&mut self, q: &[f64], tau: &mut [f64]);

    /// The derivative of [`Self::elastic_forces`], symmetric.
    fn elastic_tangent(&mut self, q: &[f64], tangent: &mut Matrix);

    /// Changes of the coordinates that count as large, all > 0: what makes coordinates of different units comparable.
    fn typical_coordinates(&self, sizes: &mut [f64]) {
        sizes.fill(1.0);
    }

    /// About how many inverse dynamics cost as much as a weighted tangent: decides when an implicit step renews its
    /// Jacobian.
    fn tangent_cost(&self) -> f64 {
        3.0
    }

    /// The symmetric positive definite mass matrix.
    fn mass_matrix(&mut self, q: &[f64], mass: &mut Matrix);

    /// The energies of a state.
    fn energy(&mut self, q: &[f64], qd: &[f64]) -> Energy;

    /// Power that damping takes out of the motion, in watts, never negative.
    fn dissipated_power(&mut self, q: &[f64], qd: &[f64]) -> f64;

    /// Where the tip is, in the frame of the model, in metres: what an accuracy is measured at.
    fn tip(&mut self, q: &[f64]) -> [f64; 3];

    /// The length of the model, in metres: what errors of the tip are relative to.
    fn length(&self) -> f64;

    /// The same system with more modes and nodes, and which of its coordinates are those of this one; `None` for a system that is not
    /// discretised.
    fn refined(&self) -> Option<(Self, Vec<usize>)>
    where
        Self: Sized,
    {
        None
    }

    /// False where [`Self::dissipated_power`] is zero whatever the state, so that a run does not integrate it.
    fn is_damped(&self) -> bool {
        true
    }

    /// Power that what has no potential (moments of fixed direction, say) puts into the motion, in watts.
    fn supplied_power(&mut self, _q: &[f64], _qd: &[f64]) -> f64 {
        0.0
    }

    /// False where [`Self::supplied_power`] is zero whatever the state, so that a run does not integrate it.
    fn is_driven(&self) -> bool {
        false
    }

    /// The time at which explicitly time-dependent parts (loads, base motion) are evaluated from now on.
    fn set_time(&mut self, _t: f64) {}

    /// Accelerations of the free motion: `qdd` with `tau(q, qd, qdd) = 0`, by a Cholesky solve of
    /// `M qdd = -tau(q, qd, 0)`. `scratch` must be of this model's size.
    fn forward_dynamics(
        &mut self,
        q: &[f64],
        qd: &[f64],
        qdd: &mut [f64],
        scratch: &mut ForwardScratch,
    ) -> Result<(), SingularMass> {
        qdd.fill(0.0);
        self.inverse_dynamics(q, qd, qdd, &mut scratch.bias);
        self.mass_matrix(q, &mut scratch.mass);
        scratch.cholesky.factorise(&scratch.mass).map_err(|_| SingularMass)?;
        for (acceleration, bias) in qdd.iter_mut().zip(&scratch.bias) {
            *acceleration = -bias;
        }
        scratch.cholesky.solve(qdd);
        Ok(())
    }
}

/// Memory for [`Model::forward_dynamics`].
#[derive(Clone, Debug)]
pub struct ForwardScratch {
    bias: Vec<f64>,
    mass: Matrix,
    cholesky: Cholesky,
}

impl ForwardScratch {
    /// Scratch for a model of `n` coordinates.
    pub fn new(n: usize) -> Self {
        Self { bias: vec![0.0; n], mass: Matrix::zeros(n, n), cholesky: Cholesky::new(n) }
    }
}
