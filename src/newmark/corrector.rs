//! Newton's method for the accelerations at the end of a step, with a Jacobian that is reused while it
//! converges.
//!
//! Increments, not residuals, decide when the iteration stops: they have the units of the unknowns, for any
//! units and scales of the equations. The error remaining after an increment is estimated from the
//! contraction rate. A second iteration measures this rate; after the first iteration it is predicted from
//! measurements in earlier steps ([`Contraction`]). The prediction saves an iteration that would only confirm
//! the previous one, and reveals wrong Jacobians.

use super::contraction::{Contraction, iterations_needed, remaining_error};
use super::jacobian::Jacobian;
use super::linear_system::LinearSystem;
use super::options::Options;
use super::search::Search;
use super::trial::Trial;
use crate::error::Interrupted;
use crate::linalg::dot;
use crate::second_order::{Counters, Failure, System};
use crate::tape::Tape;

/// Iterations before a solve is started anew on the next rung of the ladder, and before it is given up.
const MAX_ITERATIONS: usize = 20;
const MAX_FULL_ITERATIONS: usize = 50;

/// The error that a step leaves must be that much smaller than the tolerances: these errors have the same sign step after
/// step, so that they add up.
const SAFETY: f64 = 0.1;

/// An increment of that fraction of what is tolerated is believed without a contraction rate.
const NEGLIGIBLE: f64 = 1e-3;

/// Increments that do not contract are rounding errors when they are at most that many times as large as those which
/// changes of the state by [`ROUNDING`] of its size cause: in so many patterns of signs, since one may hide the effect.
/// Forces round by more than the state does: a stiff tendon of length l at the distance d from the axis of a rod knows its
/// stretch to `l / d` times as many units.
const ROUNDING_NOISE: f64 = 8.0;
const ROUNDING: f64 = 128.0 * f64::EPSILON;
const PATTERNS: usize = 3;

/// The same of single entries, whose noise the patterns tell less well; of what is tolerated less than this part of the most
/// tolerant one nothing is asked: where nothing moves, all is noise.
const ROUNDING_NOISE_OF_ONE: f64 = 100.0;

/// Increments that are larger than the noise of one pattern by that factor are none of another one.
const BEYOND_NOISE: f64 = 1e3;
const AT_REST: f64 = 1e-10;

/// A first increment that differs from the one of the last step by up to that fraction of it makes the steps similar. A
/// Jacobian that jumps (contact, dry friction) makes a larger difference.
const SIMILAR: f64 = 0.5;

/// Tolerances are not below that (without `atol`, where accelerations are guessed to be zero): the squares of
/// increments in units of them must not overflow. Rounding then ends the iteration.
const SMALLEST_TOLERANCE: f64 = 1e-100;

/// Increments are not shortened to less than that (NLEQ1's default for highly nonlinear problems; Nowak and Weimann
/// 1991).
const SHORTEST_INCREMENT: f64 = 1e-4;

/// Increments that no shortening makes acceptable are taken as a whole that often, where surfaces meet.
const MOST_LEAPS: usize = 20;

/// A step that needs more fresh Jacobians than that is hard. Where surfaces meet, the next one is likely to be so, too, and
/// Newton's method with one Jacobian is not tried first.
const EASY: usize = 3;

/// About as many iterations does a fresh Jacobian need.
const FRESH_ITERATIONS: f64 = 2.0;

/// The error that is left after an increment of that size. Where surfaces may touch, what touches in the place that it leads to
/// is not in any rate: the last increment itself must be small.
fn left_after<S: System + ?Sized>(system: &S, size: f64, rate: f64) -> f64 {
    if system.may_touch() { size } else { remaining_error(size, rate) }
}

/// The history of the factorised Jacobian.
#[derive(Clone, Copy, Debug)]
struct Kept {
    /// The weights it belongs to.
    weights: [f64; 3],
    /// Steps solved with it, and what they have cost in residual evaluations, its own evaluation included.
    steps: f64,
    cost: f64,
}

impl Kept {
    /// A Jacobian should be replaced when a step costs more with it than the average of those that it has served, its own
    /// evaluation included: a fresh one lowers the average.
    fn is_beaten_by(&self, cost: f64) -> bool {
        cost * self.steps > self.cost
    }
}

/// Newton's method with its memory for systems of one size.
#[derive(Clone, Debug)]
pub(super) struct Corrector {
    jacobian: Jacobian,
    reuse: bool,
    /// Whether the last step that was solved with fresh Jacobians was hard.
    was_hard: bool,
    kept: Option<Kept>,
    linear: LinearSystem,
    /// Where the Jacobian was evaluated.
    q_jacobian: Vec<f64>,
    v_jacobian: Vec<f64>,
    contraction: Contraction,
    /// The first increment of this step, of the last one, and its size.
    first: Vec<f64>,
    last_first: Vec<f64>,
    first_size: f64,
    residual: Vec<f64>,
    increment: Vec<f64>,
    /// Where an increment begins that may be shortened, and its full length.
    start: Vec<f64>,
    direction: Vec<f64>,
    perturbed: Trial,
    /// Of the displacements: see [`System::typical_displacements`].
    sizes: Vec<f64>,
    rtol: Vec<f64>,
    atol: Vec<f64>,
    /// One over what is tolerated in each acceleration.
    inverse_tolerance: Vec<f64>,
    /// An increment that may be rounding, and what rounding does to it.
    judged: Vec<f64>,
    noises: Vec<f64>,
}

impl Corrector {
    pub(super) fn new(options: &Options, rtol: Vec<f64>, atol: Vec<f64>) -> Self {
        let n = rtol.len();
        Self {
            jacobian: Jacobian::new(options.derivative, &rtol, &atol),
            reuse: options.reuse_jacobian,
            was_hard: false,
            kept: None,
            linear: LinearSystem::empty(),
            q_jacobian: vec![0.0; n],
            v_jacobian: vec![0.0; n],
            contraction: Contraction::unknown(),
            first: vec![0.0; n],
            last_first: vec![0.0; n],
            first_size: f64::INFINITY,
            residual: vec![0.0; n],
            increment: vec![0.0; n],
            start: vec![0.0; n],
            direction: vec![0.0; n],
            perturbed: Trial::new(n),
            sizes: vec![0.0; n],
            rtol,
            atol,
            inverse_tolerance: vec![0.0; n],
            judged: vec![0.0; n],
            noises: vec![0.0; n],
        }
    }

    /// Prepares the memory for the Jacobians of `system`. Comes before the first solve.
    pub(super) fn prepare<S: System + ?Sized>(&mut self, system: &S) {
        self.linear = self.jacobian.linear_system(system);
        let n = system.n();
        system.typical_displacements(&mut self.sizes[..n]);
        let unknowns = n + system.constraints();
        let Self {
            first, last_first, residual, increment, start, direction, sizes, inverse_tolerance, ..
        } = self;
        for values in [first, last_first, residual, increment, start, direction, sizes, inverse_tolerance] {
            values.resize(unknowns, 0.0);
        }
        self.judged.resize(unknowns, 0.0);
        self.noises.resize(unknowns, 0.0);
        self.perturbed.a.resize(unknowns, 0.0);
    }

    /// Forgets the kept Jacobian.
    pub(super) fn forget_jacobian(&mut self) {
        self.kept = None;
    }

    /// What acts has jumped: the kept Jacobian may serve worse than its distance tells.
    pub(super) fn doubt_jacobian(&mut self) {
        self.contraction.doubt();
    }

    /// What goes on from one solve to the next: the kept Jacobian and what is known of it.
    pub(super) fn carry<S: System + ?Sized>(&mut self, system: &S, tape: &mut Tape<'_>) {
        let blank = Kept { weights: [0.0; 3], steps: 0.0, cost: 0.0 };
        tape.optional(&mut self.kept, blank, |tape, kept| {
            tape.numbers(&mut kept.weights);
            tape.number(&mut kept.steps);
            tape.number(&mut kept.cost);
        });
        if tape.reads() {
            self.prepare(system);
        }
        if self.kept.is_some() {
            self.linear.carry(tape);
            if tape.reads() && self.linear.factorise().is_err() {
                self.kept = None;
            }
        }
        self.contraction.carry(tape);
        tape.flag(&mut self.was_hard);
        tape.number(&mut self.first_size);
        for values in [&mut self.q_jacobian, &mut self.v_jacobian, &mut self.last_first] {
            tape.numbers(values);
        }
    }

    /// One over what was tolerated in an acceleration in the last solve.
    pub(super) fn inverse_tolerance(&self, coordinate: usize) -> f64 {
        self.inverse_tolerance[coordinate]
    }

    /// Finds the accelerations of `trial` at which the residual vanishes, starting from `guess`. `last` are those at
    /// the start of the step: the larger ones of both tell what is tolerated. `h` is the step size. On failure the
    /// trial is left anywhere.
    ///
    /// The ladder: the kept Jacobian, one of this step, one in every iteration with increments that may be shortened,
    /// failure.
    pub(super) fn solve<S: System + ?Sized>(
        &mut self,
        system: &mut S,
        trial: &mut Trial,
        guess: &[f64],
        last: &[f64],
        h: f64,
        counters: &mut Counters,
    ) -> Result<Result<(), Failure>, Interrupted> {
        trial.set(guess);
        self.set_tolerances(guess, last);
        if self.kept.is_some_and(|kept| kept.weights == trial.weights) {
            if self.with_kept_jacobian(system, trial, h, counters)?.is_ok() {
                return Ok(Ok(()));
            }
            counters.reuse_failures += 1;
            self.contraction = Contraction::unknown();
            trial.set(guess);
        }
        self.kept = None;
        if self.reuse && !self.was_hard {
            if self.with_kept_jacobian(system, trial, h, counters)?.is_ok() {
                return Ok(Ok(()));
            }
            self.kept = None;
            self.contraction = Contraction::unknown();
            counters.full_newton += 1;
            trial.set(guess);
        }
        let before = counters.njev;
        let outcome = self.with_fresh_jacobians(system, trial, h, counters);
        system.follow_friction(None);
        self.was_hard = counters.njev - before > EASY && system.may_touch();
        outcome
    }

    /// Newton's method with the kept Jacobian, or with one of this step where there is none or it is too slow.
    fn with_kept_jacobian<S: System + ?Sized>(
        &mut self,
        system: &mut S,
        trial: &mut Trial,
        h: f64,
        counters: &mut Counters,
    ) -> Result<Result<(), Failure>, Interrupted> {
        let jacobian_cost = self.jacobian.cost(system);
        let mut cost = 0.0;
        let mut renew = !self.kept_jacobian_pays(system, trial, h);
        let mut is_fresh = false;
        // Size of the increment before with the same Jacobian.
        let mut last_size = None;
        // Size of the first increment, and whether it is like that of the last step.
        let mut first = None;
        for iteration in 0..MAX_ITERATIONS {
            self.evaluate_residual(system, trial, counters)?;
            cost += 1.0;
            let mut size = f64::NAN;
            let mut measured_rate = None;
            if !renew {
                size = self.compute_increment();
                measured_rate = last_size.map(|last_size| size / last_size);
            }
            if let Some(rate) = measured_rate {
                if !size.is_finite() {
                    return Ok(Err(Failure::NonFinite));
                }
                if rate >= 1.0 {
                    if !self.is_rounding(size, system, trial, counters)? {
                        return Ok(Err(Failure::NotConverged));
                    }
                    self.count_step(cost);
                    return Ok(Ok(()));
                }
                let distance = self.distance_from_jacobian(trial, h);
                // Where surfaces touch every step is measured, also next to where the Jacobian was evaluated. There the rate is that
                // of what the tangent neglects, and says nothing about places that are farther away.
                let is_bound = size <= NEGLIGIBLE || is_fresh && system.may_touch();
                self.contraction.measured(rate, distance, is_bound);
                let needed = iterations_needed(left_after(system, size, rate), rate);
                renew = match self.kept {
                    _ if needed == 1.0 => false,
                    // What begins to touch in a step makes the first rate poor; the next one is that of the Jacobian.
                    _ if iteration == 1 && system.may_touch() => false,
                    Some(kept) if !is_fresh => kept.is_beaten_by(cost - 1.0 + needed),
                    _ => needed > jacobian_cost + FRESH_ITERATIONS,
                };
            }
            if renew {
                if let Err(failure) = self.renew_jacobian(system, trial, h, counters)? {
                    return Ok(Err(failure));
                }
                cost += jacobian_cost;
                size = self.compute_increment();
                measured_rate = None;
                renew = false;
                is_fresh = true;
            }
            if !size.is_finite() {
                return Ok(Err(Failure::NonFinite));
            }
            let (first_size, is_similar) = match first {
                Some(first) => first,
                None => {
                    self.first.copy_from_slice(&self.increment);
                    *first.insert((size, self.is_similar_to_last_step()))
                }
            };
            trial.subtract(&self.increment);
            let rate = match measured_rate {
                Some(rate) => rate,
                // A step that begins unlike the last one may be of another kind.
                None if is_similar && !system.may_touch() => {
                    self.contraction.bound(self.distance_from_jacobian(trial, h))
                }
                None => f64::INFINITY,
            };
            if size <= NEGLIGIBLE || left_after(system, size, rate) <= 1.0 {
                if measured_rate.is_none() {
                    self.contraction.not_measured();
                }
                self.accept(first_size, cost);
                return Ok(Ok(()));
            }
            last_size = Some(size);
        }
        Ok(Err(Failure::NotConverged))
    }

    /// Whether the first increment is nearly that of the last step, or both are tolerable.
    fn is_similar_to_last_step(&self) -> bool {
        let difference = self.size_of((0..self.first.len()).map(|i| self.first[i] - self.last_first[i]));
        difference <= SIMILAR * self.first_size.max(1.0) && self.first_size.is_finite()
    }

    /// Whether a kept Jacobian is expected to be cheaper than a fresh one in a step that begins like the last one.
    fn kept_jacobian_pays<S: System + ?Sized>(&self, system: &S, trial: &Trial, h: f64) -> bool {
        self.kept.is_some_and(|kept| {
            let iterations = |distance| {
                let rate = self.contraction.expect(distance);
                iterations_needed(left_after(system, self.first_size, rate), rate)
            };
            let needed = iterations(self.distance_from_jacobian(trial, h));
            self.first_size <= NEGLIGIBLE || needed <= iterations(0.0) || !kept.is_beaten_by(needed)
        })
    }

    /// Counts a step that was solved with the kept Jacobian.
    fn count_step(&mut self, cost: f64) {
        if let Some(kept) = &mut self.kept {
            kept.steps += 1.0;
            kept.cost += cost;
        }
    }

    /// Newton's method with a fresh Jacobian in every iteration, and increments that are shortened until the next one
    /// with the same Jacobian would be smaller (restricted natural monotonicity test, Deuflhard 2011, section 3.3), or, where
    /// surfaces touch, until little of their work is left ([`Search`]).
    fn with_fresh_jacobians<S: System + ?Sized>(
        &mut self,
        system: &mut S,
        trial: &mut Trial,
        h: f64,
        counters: &mut Counters,
    ) -> Result<Result<(), Failure>, Interrupted> {
        self.evaluate_residual(system, trial, counters)?;
        let mut leaps = MOST_LEAPS;
        let mut length = 0.0;
        for _ in 0..MAX_FULL_ITERATIONS {
            system.follow_friction(Some(length));
            if let Err(failure) = self.evaluate_jacobian(system, trial, h, counters)? {
                return Ok(Err(failure));
            }
            let size = self.compute_increment();
            if !size.is_finite() {
                return Ok(Err(Failure::NonFinite));
            }
            self.start.copy_from_slice(&trial.a);
            self.direction.copy_from_slice(&self.increment);
            // Constraints make a saddle of what has a minimum.
            let is_minimised = system.has_contact() && system.constraints() == 0;
            let mut search =
                Search::new(if is_minimised { dot(&self.residual, &self.direction) } else { 0.0 });
            length = 1.0;
            let next_size = loop {
                for (increment, direction) in self.increment.iter_mut().zip(&self.direction) {
                    *increment = length * direction;
                }
                trial.set(&self.start);
                trial.subtract(&self.increment);
                if size <= NEGLIGIBLE {
                    return Ok(Ok(()));
                }
                self.evaluate_residual(system, trial, counters)?;
                let next_size = self.compute_increment();
                let work = dot(&self.residual, &self.direction);
                if next_size <= (1.0 - 0.25 * length) * size || search.is_done(work) {
                    break next_size;
                }
                // Two increments of Jacobians at the place are within what is tolerated, or below what can be computed.
                if length == 1.0
                    && (size.max(next_size) <= 1.0 || self.is_rounding(next_size, system, trial, counters)?)
                {
                    return Ok(Ok(()));
                }
                length = search.shorter(length, work);
                if length < SHORTEST_INCREMENT {
                    if leaps == 0 || !system.has_contact() {
                        return Ok(Err(Failure::NotConverged));
                    }
                    // Surfaces are apart here and pressed there: no test that is made on one side holds on the other, but the
                    // Jacobian of the other side leads to where they meet.
                    leaps -= 1;
                    length = 1.0;
                    trial.set(&self.start);
                    self.increment.copy_from_slice(&self.direction);
                    trial.subtract(&self.increment);
                    self.evaluate_residual(system, trial, counters)?;
                    break f64::INFINITY;
                }
            };
            let left = if system.may_touch() { next_size } else { remaining_error(size, next_size / size) };
            if length == 1.0 && left <= 1.0 {
                return Ok(Ok(()));
            }
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
        system.residual(trial.t, &trial.q, &trial.v, &trial.a, &mut self.residual)?;
        per_acceleration(trial, &mut self.residual);
        Ok(())
    }

    /// A Jacobian that is kept from now on.
    fn renew_jacobian<S: System + ?Sized>(
        &mut self,
        system: &mut S,
        trial: &Trial,
        h: f64,
        counters: &mut Counters,
    ) -> Result<Result<(), Failure>, Interrupted> {
        let outcome = self.evaluate_jacobian(system, trial, h, counters)?;
        if outcome.is_ok() {
            self.kept = Some(Kept { weights: trial.weights, steps: 0.0, cost: 0.0 });
        }
        Ok(outcome)
    }

    /// Ends a step whose Newton iteration with a kept Jacobian has converged.
    fn accept(&mut self, first_size: f64, cost: f64) {
        self.first_size = first_size;
        std::mem::swap(&mut self.first, &mut self.last_first);
        self.count_step(cost);
    }

    /// Evaluates and factorises the Jacobian at a trial whose residual has been evaluated.
    fn evaluate_jacobian<S: System + ?Sized>(
        &mut self,
        system: &mut S,
        trial: &Trial,
        h: f64,
        counters: &mut Counters,
    ) -> Result<Result<(), Failure>, Interrupted> {
        self.jacobian.evaluate(system, trial, &self.residual, h, &mut self.linear, counters)?;
        self.q_jacobian.copy_from_slice(&trial.q);
        self.v_jacobian.copy_from_slice(&trial.v);
        counters.nlu += 1;
        Ok(self.linear.factorise())
    }

    /// Computes the next increment from the residual; returns its size.
    fn compute_increment(&mut self) -> f64 {
        self.increment.copy_from_slice(&self.residual);
        self.linear.solve(&mut self.increment);
        self.size_of_increment()
    }

    /// Root mean square of the increment in units of what is tolerated; not finite where the increment is not.
    fn size_of_increment(&self) -> f64 {
        self.size_of(self.increment.iter().copied())
    }

    fn size_of(&self, accelerations: impl Iterator<Item = f64>) -> f64 {
        let sum: f64 = accelerations.zip(&self.inverse_tolerance).map(|(a, w)| (a * w) * (a * w)).sum();
        (sum / self.rtol.len().max(1) as f64).sqrt()
    }

    /// Whether the increment, of that size, at `trial`, where the residual has been evaluated, is rounding errors: all
    /// together, and none of its entries far beyond its own. Overwrites it.
    fn is_rounding<S: System + ?Sized>(
        &mut self,
        size: f64,
        system: &mut S,
        trial: &Trial,
        counters: &mut Counters,
    ) -> Result<bool, Interrupted> {
        let mut noise = 0.0;
        self.judged.copy_from_slice(&self.increment);
        self.noises.fill(0.0);
        for pattern in 0..PATTERNS {
            self.perturb(trial, pattern);
            let Trial { q, v, a, .. } = &self.perturbed;
            system.residual(trial.t, q, v, a, &mut self.increment)?;
            per_acceleration(trial, &mut self.increment);
            counters.nfev += 1;
            for (change, residual) in self.increment.iter_mut().zip(&self.residual) {
                *change -= residual;
            }
            self.linear.solve(&mut self.increment);
            noise = self.size_of_increment().hypot(noise);
            for (noise, change) in self.noises.iter_mut().zip(&self.increment) {
                *noise = change.hypot(*noise);
            }
            if size <= ROUNDING_NOISE * noise && self.is_noise_one_by_one() {
                return Ok(true);
            }
            if size > BEYOND_NOISE * ROUNDING_NOISE * noise {
                return Ok(false);
            }
        }
        Ok(false)
    }

    /// Whether no entry of the increment that is judged is far beyond its own noise, those left out in which nothing moves.
    fn is_noise_one_by_one(&self) -> bool {
        let loosest = self.inverse_tolerance.iter().copied().fold(f64::INFINITY, f64::min);
        let entries = self.judged.iter().zip(&self.noises).zip(&self.inverse_tolerance);
        entries
            .filter(|(_, w)| **w * AT_REST < loosest)
            .all(|((entry, noise), w)| entry.abs() * w <= 1.0 + ROUNDING_NOISE_OF_ONE * (noise * w))
    }

    /// A state that differs from `trial` by rounding errors, whose signs are a Walsh function.
    fn perturb(&mut self, trial: &Trial, pattern: usize) {
        let Trial { q, v, a, .. } = &mut self.perturbed;
        let least = [1.0, 0.0, 0.0];
        for (((to, from), weight), least) in
            [(q, &trial.q), (v, &trial.v), (a, &trial.a)].into_iter().zip(trial.weights).zip(least)
        {
            let size = |i: usize| from[i].abs() + weight * trial.a[i].abs();
            // What is computed from all coordinates of a kind is rounded by the largest of them.
            let largest = (0..from.len())
                .filter(|&i| self.sizes[i] > 0.0)
                .fold(least, |largest: f64, i| largest.max(size(i) / self.sizes[i]));
            for i in 0..to.len() {
                let rounding = if i >> pattern & 1 == 0 { ROUNDING } else { -ROUNDING };
                to[i] = from[i] + rounding * size(i).max(largest * self.sizes[i]);
            }
        }
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

    fn set_tolerances(&mut self, guess: &[f64], last: &[f64]) {
        // Multipliers follow from the accelerations: nothing is asked of them.
        for i in 0..self.rtol.len() {
            let size = guess[i].abs().max(last[i].abs());
            let tolerance = SAFETY * (self.atol[i] + self.rtol[i] * size);
            self.inverse_tolerance[i] = 1.0 / tolerance.max(SMALLEST_TOLERANCE);
        }
    }
}

/// Makes of constraints on displacements ones on accelerations: however small the step is, what is solved is of one size
/// (Bottasso, Dopico and Trainelli 2008).
fn per_acceleration(trial: &Trial, residual: &mut [f64]) {
    let [of_displacement, ..] = trial.weights;
    for gap in &mut residual[trial.q.len()..] {
        *gap /= of_displacement;
    }
}
