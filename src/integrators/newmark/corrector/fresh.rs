//! The last fallback of Newton's method: fresh Jacobians and increments that may be shortened.

use super::super::numbers::Numbers;
use super::super::search::Search;
use super::super::trial::Trial;
use super::{
    Corrector, FRESH_ITERATIONS, Friction, JacobianHistory, NEGLIGIBLE, larger_rate, left_after, may_touch,
};
use crate::error::Interrupted;
use crate::integrators::chord::{SLOWEST_RATE, iterations_needed};
use crate::integrators::second_order::{Counters, Failure, SecondOrderSystem, Solved};
use crate::model::{FrictionTreatment, InImpact};
use crate::numerics::linalg::dot;

/// Maximum number of iterations of a solve.
const MAX_FULL_ITERATIONS: usize = 25;
/// Smallest factor by which increments are shortened (NLEQ1's default for highly nonlinear problems; Nowak and Weimann 1991).
const SHORTEST_INCREMENT: f64 = 1e-4;

/// Where surfaces may touch, a solve fails after so many iterations unless increments have become shorter by this factor: shorter steps
/// find what increments that wander do not.
const WANDERING: usize = 10;
const SHORTER: f64 = 0.5;

/// If a step took more Jacobians than this, the last one is not kept for the next step.
const MOST_KEPT: usize = 2;

/// An increment at its full length: its size, how far it moves coordinates, and whether the Jacobian was evaluated at its start.
#[derive(Clone, Copy, Debug)]
struct Along {
    size: f64,
    moved: f64,
    is_fresh: bool,
}

/// Outcome of a search along an increment.
#[derive(Clone, Copy, Debug)]
enum LineSearch {
    /// The trial solves the equations.
    Solved,
    /// The next increment with the same Jacobian is shorter: its size and how far it moves coordinates.
    Shorter([f64; 2]),
    /// The Jacobian is too old to judge increments here.
    JacobianTooOld,
    Fails(Failure),
}

impl<V: Numbers> Corrector<V> {
    /// Newton's method with increments that are shortened until the next one with the same Jacobian would be smaller (restricted
    /// natural monotonicity test, Deuflhard 2011, section 3.3), or, with contacts, until little of their work is left
    /// ([`Search`]). A Jacobian is reused if that is cheaper than a fresh one. Begins at the trial; `friction` is how that is linearised.
    pub(super) fn with_fresh_jacobians<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        trial: &mut Trial<V>,
        [guess, last]: [&[f64]; 2],
        h: f64,
        friction: Friction,
        counters: &mut Counters,
    ) -> Solved {
        (self.kept, self.increments) = (None, 0);
        self.evaluate_residual(system, trial, counters)?;
        let (mut length, mut renew, mut first) = (0.0, true, f64::INFINITY);
        let (mut jacobians, mut is_full) = (0, false);
        for iteration in 0..MAX_FULL_ITERATIONS {
            if renew {
                if let Some(model) = system.model().filter(|_| friction == Friction::Followed) {
                    model.treat_friction(FrictionTreatment::Followed(length));
                }
                if let Err(failure) = self.evaluate_jacobian(system, trial, h, counters)? {
                    return Ok(Err(failure));
                }
                jacobians += 1;
                // A further Jacobian counts as a refresh.
                if jacobians > 1 && !std::mem::replace(&mut is_full, true) {
                    counters.full_newton += 1;
                }
            }
            self.set_displacements(trial, h);
            // Accelerations of iterates may be far larger than the first ones.
            self.set_tolerances(&[guess, last, &trial.a]);
            let (size, moved) = (self.size_of_increment(), self.displacement());
            if !size.is_finite() {
                return Ok(Err(Failure::NonFinite));
            }
            if iteration == 0 {
                first = moved;
            } else if iteration >= WANDERING
                && moved > SHORTER * first
                && !self.is_at_rest
                && may_touch::<_, V>(system)
            {
                return Ok(Err(Failure::NotConverged));
            }
            self.start.copy_from_slice(&trial.a);
            self.direction.copy_from_slice(&self.increment);
            (length, self.increments) = (1.0, iteration + 1);
            let along = Along { size, moved, is_fresh: renew };
            let [next_size, next_moved] =
                match self.search(system, trial, h, along, &mut length, &mut is_full, counters)? {
                    LineSearch::Solved => {
                        self.keep(trial, jacobians);
                        return Ok(Ok(()));
                    }
                    LineSearch::Shorter(next) => next,
                    LineSearch::JacobianTooOld => {
                        renew = true;
                        continue;
                    }
                    LineSearch::Fails(failure) => return Ok(Err(failure)),
                };
            let rate = larger_rate(next_size / size, [moved, next_moved]);
            // Without inertia, only a Jacobian evaluated at the trial gives a reliable estimate of the remaining error.
            if !V::IS_PLAIN && self.is_at_rest {
                renew = true;
                continue;
            }
            // The next increment is already known and costs nothing.
            if length == 1.0 && left_after::<_, V>(system, next_size, rate) <= 1.0 {
                trial.subtract(&self.increment);
                self.keep(trial, jacobians);
                return Ok(Ok(()));
            }
            // With contacts, the rate of one iteration does not predict many.
            let patience =
                FRESH_ITERATIONS + if may_touch::<_, V>(system) { 0.0 } else { self.jacobian_cost };
            renew = length < 1.0
                || iterations_needed(left_after::<_, V>(system, next_size, rate), rate) > patience;
        }
        Ok(Err(Failure::NotConverged))
    }

    /// Tries the increment and shortens it until it is acceptable.
    #[allow(clippy::too_many_arguments, reason = "what the iteration knows of it")]
    fn search<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        trial: &mut Trial<V>,
        h: f64,
        Along { size, moved, is_fresh }: Along,
        length: &mut f64,
        is_full: &mut bool,
        counters: &mut Counters,
    ) -> Result<LineSearch, Interrupted> {
        let n = trial.q.len();
        // Contact forces have a potential with a minimum along the increment; constraint forces do no work.
        let work =
            if system.facts().has_contact { dot(&self.residual[..n], &self.direction[..n]) } else { 0.0 };
        let mut search = Search::new(work);
        loop {
            for (increment, direction) in self.increment.iter_mut().zip(self.direction.iter()) {
                *increment = *length * direction;
            }
            trial.set(&self.start);
            trial.subtract(&self.increment);
            if size <= NEGLIGIBLE || !V::IS_PLAIN && self.is_at_rest && size <= 1.0 {
                return Ok(LineSearch::Solved);
            }
            self.evaluate_residual(system, trial, counters)?;
            let next_size = self.compute_increment();
            let work = dot(&self.residual[..n], &self.direction[..n]);
            let next_moved = self.displacement();
            if self.misses_open_constraints(trial) {
                return Ok(LineSearch::JacobianTooOld);
            }
            if next_size > SLOWEST_RATE * size {
                // Two increments are within tolerance or at the level of rounding.
                for (previous, direction) in self.previous.iter_mut().zip(self.direction.iter()) {
                    *previous = *length * direction;
                }
                if *length == 1.0 && size <= 1.0 && next_size <= 1.0
                    || self.is_rounding(system, trial, h, counters)?
                {
                    return Ok(LineSearch::Solved);
                }
            }
            if next_moved <= (1.0 - 0.25 * *length) * moved || search.is_done(work) {
                return Ok(LineSearch::Shorter([next_size, next_moved]));
            }
            // An old Jacobian does not determine how long its increments may be.
            if !is_fresh {
                trial.set(&self.start);
                self.evaluate_residual(system, trial, counters)?;
                return Ok(LineSearch::JacobianTooOld);
            }
            if !std::mem::replace(is_full, true) {
                counters.full_newton += 1;
            }
            *length = search.shorter(*length, work);
            if *length < SHORTEST_INCREMENT {
                return Ok(LineSearch::Fails(Failure::NotConverged));
            }
        }
    }

    /// Keeps the Jacobian for the next step, unless it changed so much within this step that several were needed.
    fn keep(&mut self, trial: &Trial<V>, jacobians: usize) {
        if self.reuse && jacobians <= MOST_KEPT {
            self.kept = Some(JacobianHistory { weights: trial.weights, steps: 0.0, cost: 0.0 });
        }
    }
}
