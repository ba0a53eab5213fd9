//! The spring pendulum: a point mass on a massless spring that swings in a vertical plane.
//!
//! ```
//! use lissom::model::Dynamics;
//! use lissom::pendulum::SpringPendulum;
//!
//! let mut pendulum = SpringPendulum::new(1.0, 1.0, 10.0, 9.81)?;
//! let energy = pendulum.energy(&[0.0, 0.2], &[0.0, 0.0]);
//! assert!((energy.elastic - 0.2).abs() < 1e-12); // joules: half the stiffness times the square of the elongation
//! # Ok::<(), lissom::error::InvalidInput>(())
//! ```

use crate::error::{Checker, InvalidInput, Number};
use crate::model::{
    Autonomous, Dynamics, Elastic, Energy, Facts, ForwardScratch, InvalidShape, SingularMass, Smooth,
};
use crate::numerics::lie::sine_cosine;
use crate::numerics::linalg::Matrix;

/// A point mass `m` at the end of a spring of rest length `l` and stiffness `k`, hinged at the origin, in gravity `g`.
///
/// Coordinates: `q1` is the angle of the spring from the horizontal axis +x, counter-clockwise positive (so that the
/// mass hangs at `-pi/2`), in radians; `q2` is the elongation, in metres. With `r = l + q2` the Lagrangian is
///
/// ```text
/// 1/2 m (q2d^2 + r^2 q1d^2) - 1/2 k q2^2 - m g r sin q1
/// ```
///
/// and the generalised forces are a moment (newton metres) and a force (newtons).
/// At `r = 0` the angle has no meaning and the mass matrix is singular.
#[derive(Clone, Debug, PartialEq)]
pub struct SpringPendulum {
    length: f64,
    mass: f64,
    stiffness: f64,
    gravity: f64,
    facts: Facts,
}

impl Default for SpringPendulum {
    /// 1 m, 1 kg, 10 N/m, with standard gravity.
    fn default() -> Self {
        Self::of(1.0, 1.0, 10.0, 9.81)
    }
}

impl SpringPendulum {
    /// A pendulum of rest length `length > 0` (metres), `mass > 0` (kilograms), `stiffness >= 0` (newtons per
    /// metre), in downward `gravity` (metres per second squared, any sign).
    pub fn new(length: f64, mass: f64, stiffness: f64, gravity: f64) -> Result<Self, InvalidInput> {
        let mut checker = Checker::new();
        checker.positive(length, "length", "metres");
        checker.positive(mass, "mass", "kilograms");
        checker.non_negative(stiffness, "stiffness", "newtons per metre");
        checker.require(
            gravity.is_finite(),
            "gravity",
            gravity,
            "a finite number (metres per second squared)",
        );
        checker.finish()?;
        Ok(Self::of(length, mass, stiffness, gravity))
    }

    fn of(length: f64, mass: f64, stiffness: f64, gravity: f64) -> Self {
        // One radian, and the rest length of the spring.
        let facts =
            Facts { is_damped: false, typical_coordinates: vec![1.0, length], ..Facts::smooth(2, length) };
        Self { length, mass, stiffness, gravity, facts }
    }

    /// Rest length of the spring, metres.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Mass, kilograms.
    pub fn mass(&self) -> f64 {
        self.mass
    }

    /// Stiffness of the spring, newtons per metre.
    pub fn stiffness(&self) -> f64 {
        self.stiffness
    }

    /// Downward gravity, metres per second squared.
    pub fn gravity(&self) -> f64 {
        self.gravity
    }
}

impl Dynamics for SpringPendulum {
    fn facts(&self) -> &Facts {
        &self.facts
    }

    #[inline]
    fn inverse_dynamics(&mut self, q: &[f64], qd: &[f64], qdd: &[f64], tau: &mut [f64]) {
        let Self { length, mass: m, stiffness: k, gravity: g, .. } = *self;
        let r = length + q[1];
        let (sin, cos) = sine_cosine(q[0]);
        tau[0] = m * r * (r * qdd[0] + 2.0 * qd[1] * qd[0] + g * cos);
        tau[1] = m * (qdd[1] - r * qd[0] * qd[0] + g * sin) + k * q[1];
    }

    #[inline]
    fn weighted_tangent(
        &mut self,
        q: &[f64],
        qd: &[f64],
        qdd: &[f64],
        weights: [f64; 3],
        tangent: &mut Matrix,
    ) {
        let Self { length, mass: m, stiffness: k, gravity: g, .. } = *self;
        let [wq, wqd, wqdd] = weights;
        let r = length + q[1];
        let (sin, cos) = sine_cosine(q[0]);
        let [t11, t21, t12, t22] = tangent.as_mut_slice() else { panic!("a tangent of two coordinates") };
        *t11 = m * r * (-wq * g * sin + wqd * 2.0 * qd[1] + wqdd * r);
        *t12 = m * (wq * (2.0 * (r * qdd[0] + qd[1] * qd[0]) + g * cos) + wqd * 2.0 * r * qd[0]);
        *t21 = m * (wq * g * cos - wqd * 2.0 * r * qd[0]);
        *t22 = wq * (k - m * qd[0] * qd[0]) + wqdd * m;
    }

    fn tangent_cost(&self) -> f64 {
        1.0
    }

    fn mass_matrix(&mut self, q: &[f64], mass: &mut Matrix) {
        let r = self.length + q[1];
        mass[(0, 0)] = self.mass * r * r;
        mass[(0, 1)] = 0.0;
        mass[(1, 0)] = 0.0;
        mass[(1, 1)] = self.mass;
    }

    fn energy(&mut self, q: &[f64], qd: &[f64]) -> Energy {
        let r = self.length + q[1];
        Energy {
            kinetic: 0.5 * self.mass * (qd[1] * qd[1] + (r * qd[0]) * (r * qd[0])),
            elastic: 0.5 * self.stiffness * q[1] * q[1],
            gravitational: self.mass * self.gravity * r * q[0].sin(),
            loads: 0.0,
        }
    }

    fn tip(&mut self, q: &[f64]) -> [f64; 3] {
        let (r, (sin, cos)) = (self.length + q[1], q[0].sin_cos());
        [r * cos, r * sin, 0.0]
    }

    fn dissipated_power(&mut self, _q: &[f64], _qd: &[f64]) -> f64 {
        0.0
    }

    fn supplied_power(&mut self, _q: &[f64], _qd: &[f64], _qdd: &[f64]) -> f64 {
        0.0
    }

    fn invalid_shape(&mut self, _q: &[f64]) -> Option<InvalidShape> {
        None
    }

    /// Starts beyond the hinge are refused; motions may pass it. At the hinge the mass matrix is singular.
    fn check_shape(&mut self, q: &[f64], place: &str) -> Result<(), InvalidInput> {
        if q[1] >= -self.length {
            return Ok(());
        }
        let expected =
            format!("an elongation of at least -{} m, where the spring has no length", Number(self.length));
        Err(InvalidInput::new(format!("{place}[1]"), Number(q[1]), expected))
    }

    /// In closed form: the mass matrix is diagonal.
    #[inline]
    fn forward_dynamics(
        &mut self,
        q: &[f64],
        qd: &[f64],
        qdd: &mut [f64],
        _scratch: &mut ForwardScratch,
    ) -> Result<(), SingularMass> {
        let r = self.length + q[1];
        let (sin, cos) = sine_cosine(q[0]);
        qdd[0] = -(2.0 * qd[1] * qd[0] + self.gravity * cos) / r;
        qdd[1] = r * qd[0] * qd[0] - self.gravity * sin - self.stiffness / self.mass * q[1];
        if qdd[0].is_finite() && qdd[1].is_finite() { Ok(()) } else { Err(SingularMass) }
    }
}

impl Elastic for SpringPendulum {
    fn elastic_forces(&mut self, q: &[f64], tau: &mut [f64]) {
        tau[0] = 0.0;
        tau[1] = self.stiffness * q[1];
    }

    fn elastic_tangent(&mut self, _q: &[f64], tangent: &mut Matrix) {
        tangent.fill(0.0);
        tangent[(1, 1)] = self.stiffness;
    }

    /// Sizes of coordinates need no help by those of the loads.
    fn turned_loads(&mut self, _q: &[f64], forces: &mut Matrix, constraint_loads: &mut [f64]) {
        constraint_loads.fill(0.0);
        forces.fill(0.0);
    }

    fn sizes(&mut self, _q: &[f64], sizes: &mut [f64]) {
        sizes.copy_from_slice(&self.facts.typical_coordinates);
    }
}

impl Autonomous for SpringPendulum {}

impl Smooth for SpringPendulum {}
