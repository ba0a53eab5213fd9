//! Newton's method on the bordered equations, watched by its contraction: it either stays close to where it starts or
//! gives up. A search for any root, from anywhere, is the business of [`crate::roots`].

use super::equations::{Equations, Linear, State, Step};
use crate::error::Interrupted;
use crate::linalg::{Lu, Matrix, norm};

/// Iterations that contract more slowly are not on their way to the nearest solution (Deuflhard 2011, section 2.1).
const SLOWEST_RATE: f64 = 0.5;

/// At that rate a correction takes about 30 iterations to rounding; one that contracts at all takes far less.
const MAX_ITERATIONS: usize = 30;

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

/// Moves a state to equilibrium, orthogonally to `constraint` (scaled, shape (n + 1,)). `None` when it does not
/// contract; the state is then of no use.
pub(super) fn correct(
    equations: &mut Equations<'_>,
    state: &mut State,
    constraint: &[f64],
    tolerance: f64,
) -> Result<Option<Corrected>, Interrupted> {
    let mut first_rate = 0.0;
    let mut previous = f64::INFINITY;
    for iteration in 0..MAX_ITERATIONS {
        let Some(linear) = equations.linearise(state)? else { return Ok(None) };
        equations.counters.iterations += 1;
        let Some(mut lu) = bordered(&linear, constraint) else { return Ok(None) };
        let mut x: Vec<f64> = linear.residual.iter().map(|residual| -residual).chain([0.0]).collect();
        lu.solve(&mut x);
        let step = linear.step(&x[..state.q.len()], x[state.q.len()]);
        let size = norm(&step.scaled);
        if !size.is_finite() {
            return Ok(None);
        }
        linear.advance(state, &step, &equations.sizes);
        let rate = size / previous;
        if iteration == 1 {
            first_rate = rate;
        }
        // Newton's method left what is small small: steps that no longer fall are rounding.
        let is_rounding = rate > SLOWEST_RATE && size.max(previous) <= tolerance.sqrt();
        if size <= tolerance || is_rounding {
            let residual_norm = linear.residual_norm;
            return Ok(Some(Corrected { rate: first_rate, step_norm: size, residual_norm }));
        }
        if rate > SLOWEST_RATE && iteration > 0 {
            return Ok(None);
        }
        previous = size;
    }
    Ok(None)
}

/// The direction of the path, of scaled norm one, at a state, such that its product with `forward` is positive. `None` where the path
/// has no single direction: at bifurcations.
pub(super) fn direction(linear: &Linear, forward: &[f64]) -> Option<Step> {
    let n = linear.load.len();
    let mut lu = bordered(linear, forward)?;
    let mut x = vec![0.0; n + 1];
    x[n] = 1.0;
    lu.solve(&mut x);
    let mut step = linear.step(&x[..n], x[n]);
    let size = norm(&step.scaled);
    if !size.is_finite() {
        return None;
    }
    step.scaled.iter_mut().chain(&mut step.forces).for_each(|x| *x /= size);
    Some(step)
}

/// The factors of `[K l; c^T]`, in natural coordinates.
fn bordered(linear: &Linear, constraint: &[f64]) -> Option<Lu> {
    let n = linear.load.len();
    let mut bordered = Matrix::zeros(n + 1, n + 1);
    bordered.view_mut((0, 0), (n, n)).copy_from(&linear.tangent);
    let natural = linear.natural.forces(&constraint[..n]);
    for i in 0..n {
        bordered[(i, n)] = linear.load[i];
        bordered[(n, i)] = natural[i];
    }
    bordered[(n, n)] = constraint[n];
    let mut lu = Lu::new(n + 1);
    lu.factorise(&bordered).is_ok().then_some(lu)
}
