//! Mechanical systems as systems of first order equations.

use super::{FirstOrderSystem, JacobianKind};
use crate::error::Interrupted;
use crate::integrators::Reason;
use crate::integrators::attempts::{Ends, Kind, Unilateral};
use crate::model::constraint::projection;
use crate::model::constraint::projection::Fit;
use crate::model::{ForwardScratch, Model, rotation_vectors};
use crate::numerics::linalg::{Cholesky, Matrix};

/// Largest relative change of velocities, with respect to the largest ones so far, that step errors cause
/// when loops are closed. A jump to another branch of the motion changes about all of them.
const LARGEST_CHANGE: f64 = 0.05;

/// Changes of velocities below this, in typical sizes of the coordinates per second, are rounding errors of a
/// system at rest.
const ROUNDING: f64 = 1e-9;

/// The free motion of a model as `y' = f(t, y)` with `y = (q, qd)`, 2n equations, and its exact Jacobian.
///
/// The right-hand side is NaN if the mass matrix is singular.
#[derive(Clone, Debug)]
pub struct FirstOrder<M> {
    model: M,
    n: usize,
    scratch: ForwardScratch,
    mass: Matrix,
    tangent: Matrix,
    acceleration: Vec<f64>,
    column: Vec<f64>,
    cholesky: Cholesky,
    /// Twice the largest kinetic energy so far: the scale for changes of velocities.
    fastest: f64,
    /// Largest number of independent constraints so far.
    rank: usize,
    unilateral: Unilateral,
}

impl<M: Model> FirstOrder<M> {
    /// The system for the free motion of `model`.
    pub fn new(model: M) -> Self {
        let n = model.facts().n;
        Self {
            n,
            scratch: ForwardScratch::of(&model),
            model,
            mass: Matrix::zeros(n, n),
            tangent: Matrix::zeros(n, n),
            acceleration: vec![0.0; n],
            column: vec![0.0; n],
            cholesky: Cholesky::new(n),
            fastest: 0.0,
            rank: 0,
            unilateral: Unilateral::default(),
        }
    }

    /// Projects the state after a step onto closed loops, with the right-hand side there. False if that changes more than errors of a
    /// step do: at a singular position the motion has several branches.
    pub(crate) fn hold(&mut self, t: f64, y: &mut [f64], dydt: &mut [f64]) -> Result<bool, Interrupted> {
        let Self { model, n, scratch, fastest, rank, .. } = self;
        if model.facts().constraints() == 0 {
            return Ok(true);
        }
        if model.facts().is_one_sided {
            // At a corner of a command, this step uses the command before it.
            model.set_time(t.next_down())?;
        }
        let ((q, v), (velocity, acceleration)) = (y.split_at_mut(*n), dydt.split_at_mut(*n));
        *fastest = fastest.max(2.0 * model.energy(q, v).kinetic);
        let projected = projection::close(model, q)
            .and_then(|_| projection::fit_velocities(model, q, v))
            .and_then(|fit| {
                model.forward_dynamics(q, v, acceleration, scratch)?;
                Ok(fit)
            });
        velocity.copy_from_slice(v);
        Ok(projected.is_ok_and(|fit| {
            let Fit { change, largest, rank: now, .. } = fit;
            let is_regular = now >= *rank && !fit.is_singular();
            *rank = now.max(*rank);
            let is_small = change <= LARGEST_CHANGE * LARGEST_CHANGE * *fastest || largest <= ROUNDING;
            is_regular && is_small
        }))
    }

    /// Forgets the number of independent constraints after a change of the active set.
    pub(crate) fn forget_rank(&mut self) {
        self.rank = 0;
    }

    /// Whether a state is so close to a singular position that no step from there may be small enough.
    pub(crate) fn is_nearly_singular(&mut self, y: &[f64]) -> bool {
        let (q, v) = y.split_at(self.n);
        self.model.facts().constraints() > 0
            && projection::fit_velocities(&mut self.model, q, &mut v.to_vec())
                .is_ok_and(|fit| fit.rank < self.rank || fit.is_nearly_singular())
    }

    /// The model.
    pub fn model(&mut self) -> &mut M {
        &mut self.model
    }
}

impl<M: Model> FirstOrderSystem for FirstOrder<M> {
    fn n(&self) -> usize {
        2 * self.n
    }

    fn rhs(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) -> Result<(), Interrupted> {
        let (q, qd) = y.split_at(self.n);
        let (velocity, acceleration) = dydt.split_at_mut(self.n);
        velocity.copy_from_slice(qd);
        self.model.set_time(t)?;
        if self.model.forward_dynamics(q, qd, acceleration, &mut self.scratch).is_err() {
            acceleration.fill(f64::NAN);
        }
        Ok(())
    }

    fn wrap(&mut self, y: &mut [f64], dydt: &mut [f64]) -> bool {
        let ((q, v), (_, a)) = (y.split_at_mut(self.n), dydt.split_at_mut(self.n));
        let has_wrapped = rotation_vectors::wrap(&self.model.facts().rotation_vectors, q, v, &mut [a]);
        dydt[..self.n].copy_from_slice(v);
        has_wrapped
    }

    fn horizon(&self, t: f64) -> f64 {
        self.model.horizon(t)
    }

    fn refusal(
        &mut self,
        t: [f64; 2],
        y: [&[f64]; 2],
        dydt: [&[f64]; 2],
        is_judged: bool,
    ) -> Result<Option<Reason>, Interrupted> {
        let n = self.n;
        let ends = Ends {
            t,
            h: t[1] - t[0],
            q: y.map(|y| &y[..n]),
            v: y.map(|y| &y[n..]),
            a: dydt.map(|f| &f[n..]),
        };
        let kind = Kind::Adaptive { bends: true, is_judged };
        Ok(self.unilateral.diagnose(&mut self.model, &ends, kind)?.reason())
    }

    fn jacobian_kind(&self) -> JacobianKind {
        JacobianKind::Supplied
    }

    /// From `tau(q, qd, qdd(q, qd)) = 0`: `dqdd/dq = -M^-1 dtau/dq`, and similarly for qd.
    fn jacobian(&mut self, t: f64, y: &[f64], jacobian: &mut Matrix) -> Result<(), Interrupted> {
        let n = self.n;
        let (q, qd) = y.split_at(n);
        self.model.set_time(t)?;
        self.model.mass_matrix(q, &mut self.mass);
        let regular = self.model.forward_dynamics(q, qd, &mut self.acceleration, &mut self.scratch).is_ok()
            && self.cholesky.factorise(&self.mass).is_ok();
        jacobian.fill(0.0);
        for i in 0..n {
            jacobian[(i, n + i)] = 1.0;
        }
        for (block, weights) in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].into_iter().enumerate() {
            self.model.weighted_tangent(q, qd, &self.acceleration, weights, &mut self.tangent);
            for j in 0..n {
                self.column.copy_from_slice(self.tangent.column(j).as_slice());
                if regular {
                    self.cholesky.solve(&mut self.column);
                } else {
                    self.column.fill(f64::NAN);
                }
                for i in 0..n {
                    jacobian[(n + i, block * n + j)] = -self.column[i];
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::pendulum::SpringPendulum;

    #[test]
    fn the_jacobian_is_the_derivative_of_the_right_hand_side() {
        let mut system = FirstOrder::new(SpringPendulum::new(1.0, 2.0, 30.0, 9.81).unwrap());
        let y = [0.3, -0.1, 0.7, 1.1];
        let mut jacobian = Matrix::zeros(4, 4);
        system.jacobian(0.0, &y, &mut jacobian).unwrap();
        let increment = 1e-6;
        for j in 0..4 {
            let mut at = |sign: f64| {
                let mut y = y;
                y[j] += sign * increment;
                let mut dydt = [0.0; 4];
                system.rhs(0.0, &y, &mut dydt).unwrap();
                dydt
            };
            let (plus, minus) = (at(1.0), at(-1.0));
            for i in 0..4 {
                let difference = (plus[i] - minus[i]) / (2.0 * increment);
                assert!((jacobian[(i, j)] - difference).abs() < 1e-7, "{i} {j}: {jacobian} {difference}");
            }
        }
    }
}
