//! Newton's method on the bordered equations, watched by its contraction: it either stays close to where it starts or
//! gives up. A search for any root, from anywhere, is the business of [`crate::roots`].

use super::equations::Equations;
use crate::error::Interrupted;
use crate::linalg::{Lu, Matrix, norm};

/// Iterations that contract more slowly are not on their way to the nearest solution (Deuflhard 2011, section 2.1).
const SLOWEST_RATE: f64 = 0.5;

/// At that rate a correction takes about 30 iterations to rounding; one that contracts at all takes far less.
const MAX_ITERATIONS: usize = 30;

/// A state on its way to equilibrium: coordinates and load factor.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct State {
    pub(super) q: Vec<f64>,
    pub(super) load_factor: f64,
}

/// A correction that converged.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corrected {
    /// How fast it contracted at first; zero when there was nothing to see.
    pub(super) rate: f64,
    /// Scaled norm of the last step.
    pub(super) step_norm: f64,
    /// Scaled norm of the residual before that step.
    pub(super) residual_norm: f64,
}

/// Memory for corrections of n coordinates and the load factor.
#[derive(Debug)]
pub(super) struct Corrector {
    pub(super) residual: Vec<f64>,
    pub(super) load: Vec<f64>,
    pub(super) tangent: Matrix,
    bordered: Matrix,
    lu: Lu,
    step: Vec<f64>,
}

impl Corrector {
    pub(super) fn new(n: usize) -> Self {
        Self {
            residual: vec![0.0; n],
            load: vec![0.0; n],
            tangent: Matrix::zeros(n, n),
            bordered: Matrix::zeros(n + 1, n + 1),
            lu: Lu::new(n + 1),
            step: vec![0.0; n + 1],
        }
    }

    /// Moves a state to equilibrium, orthogonally to `constraint` (scaled, shape (n + 1,)). `None` when it does not
    /// contract; the state is then of no use.
    pub(super) fn correct(
        &mut self,
        equations: &mut Equations<'_>,
        state: &mut State,
        constraint: &[f64],
        tolerance: f64,
    ) -> Result<Option<Corrected>, Interrupted> {
        let n = equations.n();
        let mut first_rate = 0.0;
        let mut previous = f64::INFINITY;
        for iteration in 0..MAX_ITERATIONS {
            equations.residual(&state.q, state.load_factor, &mut self.residual, &mut self.load)?;
            equations.tangent(&state.q, state.load_factor, &mut self.tangent);
            equations.counters.iterations += 1;
            if !self.factorise(constraint) {
                return Ok(None);
            }
            let residual_norm = norm(&self.residual);
            for (step, residual) in self.step.iter_mut().zip(&self.residual) {
                *step = -residual;
            }
            self.step[n] = 0.0;
            self.lu.solve(&mut self.step);
            let size = norm(&self.step);
            if !size.is_finite() {
                return Ok(None);
            }
            state.advance(&self.step, 1.0, &equations.sizes);
            let rate = size / previous;
            if iteration == 1 {
                first_rate = rate;
            }
            // Newton's method left what is small small: steps that no longer fall are rounding.
            let is_rounding = rate > SLOWEST_RATE && size.max(previous) <= tolerance.sqrt();
            if size <= tolerance || is_rounding {
                return Ok(Some(Corrected { rate: first_rate, step_norm: size, residual_norm }));
            }
            if rate > SLOWEST_RATE && iteration > 0 {
                return Ok(None);
            }
            previous = size;
        }
        Ok(None)
    }

    /// Evaluates residual, load and tangent at a state.
    pub(super) fn evaluate(
        &mut self,
        equations: &mut Equations<'_>,
        state: &State,
    ) -> Result<(), Interrupted> {
        equations.residual(&state.q, state.load_factor, &mut self.residual, &mut self.load)?;
        equations.tangent(&state.q, state.load_factor, &mut self.tangent);
        Ok(())
    }

    /// The direction of the path, of scaled norm one, at the state of the last evaluation, such that its product with
    /// `forward` is positive. `None` where the path has no single direction: at bifurcations.
    pub(super) fn direction(&mut self, forward: &[f64]) -> Option<Vec<f64>> {
        if !self.factorise(forward) {
            return None;
        }
        let mut direction = vec![0.0; forward.len()];
        direction[forward.len() - 1] = 1.0;
        self.lu.solve(&mut direction);
        let size = norm(&direction);
        if !size.is_finite() {
            return None;
        }
        direction.iter_mut().for_each(|x| *x /= size);
        Some(direction)
    }

    /// Factorises `[K l; c^T]`.
    fn factorise(&mut self, constraint: &[f64]) -> bool {
        let n = self.load.len();
        self.bordered.view_mut((0, 0), (n, n)).copy_from(&self.tangent);
        for i in 0..n {
            self.bordered[(i, n)] = self.load[i];
            self.bordered[(n, i)] = constraint[i];
        }
        self.bordered[(n, n)] = constraint[n];
        self.lu.factorise(&self.bordered).is_ok()
    }
}

impl State {
    /// Moves by a multiple of a scaled step.
    pub(super) fn advance(&mut self, step: &[f64], length: f64, sizes: &[f64]) {
        for (i, q) in self.q.iter_mut().enumerate() {
            *q += length * step[i] * sizes[i];
        }
        self.load_factor += length * step[self.q.len()];
    }

    /// The scaled step from another state to this one.
    pub(super) fn since(&self, other: &Self, sizes: &[f64]) -> Vec<f64> {
        let coordinates = (0..self.q.len()).map(|i| (self.q[i] - other.q[i]) / sizes[i]);
        coordinates.chain([self.load_factor - other.load_factor]).collect()
    }
}
