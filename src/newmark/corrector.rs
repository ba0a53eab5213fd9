//! Newton's method for the accelerations at the end of a step, with a Jacobian that is kept while it serves.
//!
//! The iteration stops by its increments, not by the residual: they have the units of the unknowns, whatever the units
//! and sizes of the equations. The error that remains after an increment is estimated from the contraction rate, which a
//! second iteration measures and a first one predicts from what earlier steps have measured ([`Contraction`]). This
//! saves the iteration that would only confirm the last one, and makes a wrong Jacobian visible.

use super::contraction::{Contraction, iterations_needed, remaining_error};
use super::jacobian::Jacobian;
use super::options::Options;
use super::trial::Trial;
use super::{Counters, Failure, System};
use crate::error::Interrupted;
use crate::linalg::{Lu, Matrix};

/// Iterations before a solve is given up, or started anew on the next rung of the ladder.
const MAX_ITERATIONS: usize = 20;

/// The error that a step leaves must be that much smaller than the tolerances: these errors have the same sign step after
/// step, so that they add up.
const SAFETY: f64 = 0.01;

/// An increment of that fraction of what is tolerated is believed without a contraction rate.
const NEGLIGIBLE: f64 = 1e-3;

/// Accelerations are not asked to be better than that many rounding units of the displacements would be felt after a step.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// About as many iterations does a fresh Jacobian need.
const FRESH_ITERATIONS: f64 = 2.0;

/// The history of the factorised Jacobian.
#[derive(Clone, Copy, Debug)]
struct Kept {
    /// The weights it belongs to.
    weights: [f64; 3],
    /// Steps solved with it, and what they have cost in residual evaluations, its own evaluation included.
    steps: f64,
    cost: f64,
}

/// Newton's method with its memory for systems of one size.
#[derive(Clone, Debug)]
pub(super) struct Corrector {
    jacobian: Jacobian,
    reuse: bool,
    kept: Option<Kept>,
    matrix: Matrix,
    lu: Lu,
    /// Where the Jacobian was evaluated.
    q_jacobian: Vec<f64>,
    v_jacobian: Vec<f64>,
    contraction: Contraction,
    residual: Vec<f64>,
    increment: Vec<f64>,
    rtol: Vec<f64>,
    atol: Vec<f64>,
    /// One over what is tolerated in each acceleration.
    inverse_tolerance: Vec<f64>,
}

impl Corrector {
    pub(super) fn new(options: &Options, rtol: Vec<f64>, atol: Vec<f64>) -> Self {
        let n = rtol.len();
        Self {
            jacobian: Jacobian::new(options.derivative, &rtol, &atol),
            reuse: options.reuse_jacobian,
            kept: None,
            matrix: Matrix::zeros(n, n),
            lu: Lu::new(n),
            q_jacobian: vec![0.0; n],
            v_jacobian: vec![0.0; n],
            contraction: Contraction::unknown(),
            residual: vec![0.0; n],
            increment: vec![0.0; n],
            rtol,
            atol,
            inverse_tolerance: vec![0.0; n],
        }
    }

    /// Forgets the kept Jacobian.
    pub(super) fn forget_jacobian(&mut self) {
        self.kept = None;
    }

    /// One over what was tolerated in an acceleration in the last solve.
    pub(super) fn inverse_tolerance(&self, coordinate: usize) -> f64 {
        self.inverse_tolerance[coordinate]
    }

    /// Finds the accelerations of `trial` at which the residual vanishes, starting from `guess`. `h` is the step size.
    /// On failure the trial is left anywhere.
    ///
    /// The ladder: the kept Jacobian, one of this step, one in every iteration, failure.
    pub(super) fn solve<S: System + ?Sized>(
        &mut self,
        system: &mut S,
        trial: &mut Trial,
        guess: &[f64],
        h: f64,
        counters: &mut Counters,
    ) -> Result<Result<(), Failure>, Interrupted> {
        trial.set(guess);
        self.set_tolerances(trial, h);
        if self.kept.is_some_and(|kept| kept.weights == trial.weights) {
            if self.with_kept_jacobian(system, trial, h, counters)?.is_ok() {
                return Ok(Ok(()));
            }
            counters.reuse_failures += 1;
            trial.set(guess);
        }
        self.kept = None;
        if self.reuse {
            if self.with_kept_jacobian(system, trial, h, counters)?.is_ok() {
                return Ok(Ok(()));
            }
            self.kept = None;
            counters.full_newton += 1;
            trial.set(guess);
        }
        self.with_fresh_jacobians(system, trial, h, counters)
    }

    /// Newton's method with the kept Jacobian, or with one of this step if there is none or it turns out to be slow.
    fn with_kept_jacobian<S: System + ?Sized>(
        &mut self,
        system: &mut S,
        trial: &mut Trial,
        h: f64,
        counters: &mut Counters,
    ) -> Result<Result<(), Failure>, Interrupted> {
        let jacobian_cost = self.jacobian.cost(system);
        let mut cost = 0.0;
        let mut is_fresh = false;
        // Of the increment before, with the same Jacobian.
        let mut last_size = f64::NAN;
        for _ in 0..MAX_ITERATIONS {
            self.evaluate_residual(system, trial, counters)?;
            cost += 1.0;
            let (mut size, mut rate) = (f64::NAN, f64::NAN);
            let must_renew = match self.kept {
                None => true,
                Some(kept) => {
                    size = self.compute_increment();
                    if !size.is_finite() {
                        return Ok(Err(Failure::NonFinite));
                    }
                    rate = size / last_size;
                    let expected_rate = if rate.is_nan() {
                        self.contraction.predict(self.distance_from_jacobian(trial, h))
                    } else {
                        self.contraction.measured(rate, self.distance_from_jacobian(trial, h));
                        rate
                    };
                    if rate >= 1.0 && !(size <= 1.0 && last_size <= 1.0) {
                        return Ok(Err(Failure::NotConverged));
                    }
                    let needed = iterations_needed(size, expected_rate);
                    if is_fresh {
                        needed > jacobian_cost + FRESH_ITERATIONS
                    } else {
                        // A Jacobian is replaced when a step costs more with it than the average of the steps that it
                        // has served, its own evaluation included: a fresh one lowers the average.
                        (cost - 1.0 + needed) * kept.steps > kept.cost
                    }
                }
            };
            // No contraction between tolerable increments: they are rounding errors. (A Jacobian that is far too large does
            // contract, if slowly.)
            let is_rounding = rate >= 1.0;
            let is_negligible = size <= NEGLIGIBLE;
            if must_renew && !is_rounding && !is_negligible {
                if let Err(failure) = self.evaluate_jacobian(system, trial, h, counters)? {
                    return Ok(Err(failure));
                }
                cost += jacobian_cost;
                is_fresh = true;
                self.kept = Some(Kept { weights: trial.weights, steps: 0.0, cost: 0.0 });
                size = self.compute_increment();
                rate = f64::NAN;
                if !size.is_finite() {
                    return Ok(Err(Failure::NonFinite));
                }
            }
            trial.subtract(&self.increment);
            let is_measured = !rate.is_nan();
            if !is_measured {
                rate = self.contraction.predict(self.distance_from_jacobian(trial, h));
            }
            if is_rounding || size <= NEGLIGIBLE || remaining_error(size, rate) <= 1.0 {
                if !is_measured {
                    self.contraction.age();
                }
                if let Some(kept) = &mut self.kept {
                    kept.steps += 1.0;
                    kept.cost += cost;
                }
                return Ok(Ok(()));
            }
            last_size = size;
        }
        Ok(Err(Failure::NotConverged))
    }

    /// Newton's method as in the textbook.
    fn with_fresh_jacobians<S: System + ?Sized>(
        &mut self,
        system: &mut S,
        trial: &mut Trial,
        h: f64,
        counters: &mut Counters,
    ) -> Result<Result<(), Failure>, Interrupted> {
        let mut last_size = f64::NAN;
        for _ in 0..MAX_ITERATIONS {
            self.evaluate_residual(system, trial, counters)?;
            if let Err(failure) = self.evaluate_jacobian(system, trial, h, counters)? {
                return Ok(Err(failure));
            }
            let size = self.compute_increment();
            if !size.is_finite() {
                return Ok(Err(Failure::NonFinite));
            }
            trial.subtract(&self.increment);
            let rate = size / last_size;
            let is_rounding = rate >= 1.0 && size <= 1.0 && last_size <= 1.0;
            if is_rounding || size <= NEGLIGIBLE || remaining_error(size, rate) <= 1.0 {
                return Ok(Ok(()));
            }
            last_size = size;
        }
        Ok(Err(Failure::NotConverged))
    }

    fn evaluate_residual<S: System + ?Sized>(
        &mut self,
        system: &mut S,
        trial: &Trial,
        counters: &mut Counters,
    ) -> Result<(), Interrupted> {
        counters.nfev += 1;
        counters.newton_iterations += 1;
        system.residual(trial.t, &trial.q, &trial.v, &trial.a, &mut self.residual)
    }

    /// Evaluates and factorises the Jacobian at a trial whose residual has been evaluated.
    fn evaluate_jacobian<S: System + ?Sized>(
        &mut self,
        system: &mut S,
        trial: &Trial,
        h: f64,
        counters: &mut Counters,
    ) -> Result<Result<(), Failure>, Interrupted> {
        if !self.residual.iter().all(|r| r.is_finite()) {
            return Ok(Err(Failure::NonFinite));
        }
        self.jacobian.evaluate(system, trial, &self.residual, h, &mut self.matrix, counters)?;
        self.q_jacobian.copy_from_slice(&trial.q);
        self.v_jacobian.copy_from_slice(&trial.v);
        counters.nlu += 1;
        Ok(match self.lu.factorise(&self.matrix) {
            Ok(()) => Ok(()),
            Err(_) if self.matrix.iter().all(|entry| entry.is_finite()) => Err(Failure::SingularJacobian),
            Err(_) => Err(Failure::NonFinite),
        })
    }

    /// Computes the next increment from the residual; returns its root mean square in units of what is tolerated, not finite
    /// where the increment is not.
    fn compute_increment(&mut self) -> f64 {
        self.increment.copy_from_slice(&self.residual);
        self.lu.solve(&mut self.increment);
        let sum: f64 =
            self.increment.iter().zip(&self.inverse_tolerance).map(|(d, w)| (d * w) * (d * w)).sum();
        (sum / self.increment.len().max(1) as f64).sqrt()
    }

    /// How far displacements, and what velocities move in a step, are from where the Jacobian was evaluated.
    fn distance_from_jacobian(&self, trial: &Trial, h: f64) -> f64 {
        let (mut displacement, mut velocity) = (0.0, 0.0);
        for i in 0..trial.q.len() {
            displacement += (trial.q[i] - self.q_jacobian[i]).powi(2);
            velocity += (trial.v[i] - self.v_jacobian[i]).powi(2);
        }
        (displacement + h * h * velocity).sqrt()
    }

    fn set_tolerances(&mut self, trial: &Trial, h: f64) {
        let rounding = ROUNDING / (h * h);
        for i in 0..self.inverse_tolerance.len() {
            let tolerance = SAFETY * (self.atol[i] + self.rtol[i] * trial.a[i].abs())
                + rounding * (trial.q[i].abs() + h * trial.v[i].abs());
            self.inverse_tolerance[i] = 1.0 / tolerance.max(f64::MIN_POSITIVE);
        }
    }
}
