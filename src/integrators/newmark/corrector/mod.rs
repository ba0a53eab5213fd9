//! Newton's method for the accelerations at the end of a step, with a Jacobian that is reused while it
//! converges.
//!
//! Increments, not residuals, decide when the iteration stops: they have the units of the unknowns, for any
//! units and scales of the equations. The error remaining after an increment is estimated from the
//! contraction rate. A second iteration measures this rate; after the first iteration it is predicted from
//! measurements in earlier steps ([`Contraction`]). The prediction saves an iteration that would only confirm
//! the previous one, and reveals wrong Jacobians.
//!
//! Sizes of increments are relative to single accelerations, since errors of accelerations add up from step to step. An
//! acceleration near zero may therefore dominate the size and its rate. The rate is the larger one of these sizes and of the
//! displacements by the increments.

mod downhill;
mod fresh;
mod gaps;
mod softer_contacts;

pub(super) use downhill::Origin;

use super::contraction::Contraction;
use super::jacobian::Jacobian;
use super::linear_system::LinearSystem;
use super::numbers::Numbers;
use super::options::{Options, UNRESOLVED_MOTION};
use super::trial::Trial;
use crate::error::Interrupted;
use crate::integrators::chord::{SLOWEST_RATE, iterations_needed, remaining_error};
use crate::integrators::second_order::{Counters, Failure, SecondOrderSystem, Solved};
use crate::model::{FrictionTreatment, InImpact};
use crate::numerics::tape::Tape;

/// Maximum number of iterations before the next fallback of [`Corrector::solve`].
const MAX_ITERATIONS: usize = 20;

/// Bound of the remaining error of a step, relative to the tolerances: these errors have the same sign in successive steps and add up.
const SAFETY: f64 = 0.1;

/// An increment below this fraction of the tolerances is accepted without a contraction rate.
const NEGLIGIBLE: f64 = 1e-3;

/// Increments that do not contract may be rounding errors if they move coordinates by no more than this part of the relative
/// tolerance (RADAU5 stops there: Hairer and Wanner 1996, section IV.8).
const TOLERABLE_MOTION: f64 = 0.05;

/// Such increments are rounding errors if, in a step of the usual size, they would move coordinates by less than this part of their
/// sizes: gaps of loops and forces are multiples of floating-point spacings, and a hundred spacings of a coordinate may not change them.
const SPACINGS: f64 = 4096.0 * f64::EPSILON;

/// A continuous residual hardly changes over this part of an increment, with any Jacobian and with contacts; the larger part is used if
/// the smaller one would be only a few spacings.
const NEARBY: f64 = 1.0 / 64.0;
const FARTHEST: f64 = 1.0 / 16.0;

/// Over that part of an increment, rounding changes by at least this part of its norm, and single entries by the second part.
const ROUNDING_CHANGES: f64 = 0.25;
const ONE_CHANGES: f64 = 0.01;

/// After an increment of more than this part of the accelerations, tolerances are relative to the new ones: at the start from rest,
/// accelerations may be zero.
const FAR: f64 = 0.1;

/// Steps are similar if their first increments differ by at most this fraction. A Jacobian that jumps (contact, dry friction) causes a
/// larger difference.
const SIMILAR_INCREMENTS: f64 = 0.5;

/// Smallest tolerance, for `atol = 0` and an initial guess of zero: the squares of increments in units of the tolerances must not
/// overflow. Rounding then ends the iteration.
const SMALLEST_TOLERANCE: f64 = 1e-100;

/// Without inertia steps are solved to this part of the sizes of coordinates, whatever their duration.
const QUASI_STATIC_TOLERANCE: f64 = 1e-9;

/// Solves that needed softer contacts are followed by ones that begin with these; after so many the contacts of the model are tried first
/// again. With 4 a wire over an edge takes a tenth more iterations. Solves that softer contacts did not help are followed by so many without.
const STIFF_AGAIN: usize = 16;

/// Typical number of iterations with a fresh Jacobian.
const FRESH_ITERATIONS: f64 = 2.0;

/// The remaining error after an increment of this size. If surfaces may touch, new contacts at its end are not contained in any rate:
/// the last increment itself must be small.
fn left_after<S: SecondOrderSystem + ?Sized, V: Numbers>(system: &mut S, size: f64, rate: f64) -> f64 {
    if may_touch::<_, V>(system) { size } else { remaining_error(size, rate) }
}

/// Whether surfaces in the state evaluated last are so close that they may touch in the next one.
#[inline]
fn may_touch<S: SecondOrderSystem + ?Sized, V: Numbers>(system: &mut S) -> bool {
    !V::IS_PLAIN && system.model().is_some_and(|model| model.may_touch())
}

/// The history of the factorised Jacobian.
#[derive(Clone, Copy, Debug)]
struct JacobianHistory {
    /// The weights with which it was evaluated.
    weights: [f64; 3],
    /// Steps solved with it, and their cost in residual evaluations, including that of the Jacobian.
    steps: f64,
    cost: f64,
}

impl JacobianHistory {
    /// A Jacobian should be replaced when a step costs more with it than the average step so far, including the evaluation of the
    /// Jacobian: a fresh one lowers the average.
    fn should_be_replaced(&self, cost: f64) -> bool {
        cost * self.steps > self.cost
    }
}

/// Progress of a solve with the kept Jacobian: iterations, their cost in residual evaluations, and whether the Jacobian was evaluated
/// in this step.
#[derive(Clone, Copy, Debug)]
struct SolveProgress {
    iteration: usize,
    cost: f64,
    is_fresh: bool,
}

/// The linearisation of friction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Friction {
    Exact,
    /// As an unknown of its own ([`FrictionTreatment::Followed`]), which finds where sliding reverses.
    Followed,
}

/// Comparison of an increment with the previous one.
#[derive(Clone, Copy, Debug)]
enum Judgement {
    /// The contraction rate, and whether a fresh Jacobian is cheaper from here on.
    Rate(f64, bool),
    IsRounding,
    Fails(Failure),
}

/// Newton's method with its memory for systems of one size.
#[derive(Clone, Debug)]
pub(super) struct Corrector<V> {
    jacobian: Jacobian,
    /// Cost of a Jacobian in residual evaluations.
    jacobian_cost: f64,
    reuse: bool,
    /// The usual size of a step.
    dt: f64,
    kept: Option<JacobianHistory>,
    /// Whether surfaces could touch at the end of the last solve; the system may have evaluated another state since.
    might_touch: bool,
    /// Number of the last solves, one after the other, by way of softer contacts.
    softly_solved: usize,
    /// Number of the next solves that do without, after one that they did not help.
    softly_failed: usize,
    linear: LinearSystem,
    /// Displacements at which the Jacobian was evaluated.
    q_jacobian: V,
    v_jacobian: V,
    contraction: Contraction,
    /// The first increment of this step, that of the last step, and the size of the latter.
    first: V,
    last_first: V,
    first_size: f64,
    residual: V,
    increment: V,
    /// The previous increment.
    previous: V,
    /// Start and full length of an increment that may be shortened.
    start: V,
    direction: V,
    /// Sizes of the displacements and of the gaps: see [`Facts`](crate::model::Facts).
    sizes: V,
    /// One over the sizes of displacements, one if these are unknown, and zero for multipliers.
    inverse_sizes: V,
    /// Displacement by a unit acceleration in the step, or by the velocity that it causes.
    reach: f64,
    /// Whether inertia is left out: stops, contacts and friction then dominate, and rates at one state do not predict those at another.
    is_at_rest: bool,
    /// Root mean square of the displacements by the increment, in units of typical sizes.
    moved: f64,
    gap_sizes: Vec<f64>,
    /// What may be rounding of each gap, by the Jacobian, and the number of increments in the solve before the residual was evaluated.
    gap_roundings: Vec<f64>,
    increments: usize,
    /// The gaps of dependent rows, in units of sizes, where the Jacobian was evaluated.
    left_open: f64,
    /// Displacement by a unit acceleration, in units of the coordinate's size ([`Self::set_displacements`]).
    displacements: V,
    /// An increment that may be rounding, and the trial at which it was computed.
    judged: V,
    place: V,
    rtol: V,
    /// Absolute tolerances: the given ones, or those of [`UNRESOLVED_MOTION`].
    atol: V,
    has_given_atol: bool,
    /// One over the tolerance of each acceleration, and the size of increments that are [`FAR`].
    inverse_tolerance: V,
    far: f64,
}

impl<V: Numbers> Corrector<V> {
    /// For tolerances of each coordinate; without absolute ones these follow from the sizes of coordinates.
    pub(super) fn new(options: &Options, rtol: V, atol: Option<V>) -> Self {
        let n = rtol.len();
        let loosest = rtol.iter().copied().fold(0.0, f64::max);
        Self {
            jacobian: Jacobian::new(options, &rtol, atol.as_deref()),
            jacobian_cost: 0.0,
            reuse: options.reuse_jacobian,
            dt: options.dt,
            kept: None,
            might_touch: false,
            softly_solved: 0,
            softly_failed: 0,
            linear: LinearSystem::empty(),
            q_jacobian: V::zeros(n),
            v_jacobian: V::zeros(n),
            contraction: Contraction::unknown(),
            first: V::zeros(n),
            last_first: V::zeros(n),
            first_size: f64::INFINITY,
            residual: V::zeros(n),
            increment: V::zeros(n),
            previous: V::zeros(n),
            start: V::zeros(n),
            direction: V::zeros(n),
            sizes: V::zeros(n),
            inverse_sizes: V::zeros(n),
            reach: 0.0,
            is_at_rest: false,
            moved: 0.0,
            gap_sizes: Vec::new(),
            gap_roundings: Vec::new(),
            increments: 0,
            left_open: 0.0,
            displacements: V::zeros(n),
            judged: V::zeros(n),
            place: V::zeros(n),
            rtol,
            has_given_atol: atol.is_some(),
            atol: atol.unwrap_or_else(|| V::zeros(n)),
            inverse_tolerance: V::zeros(n),
            far: FAR / (SAFETY * loosest),
        }
    }

    /// Prepares the memory for the Jacobians of `system`. Call before the first solve.
    pub(super) fn prepare<S: SecondOrderSystem + ?Sized>(&mut self, system: &mut S) {
        self.linear = self.jacobian.linear_system(system);
        self.jacobian_cost = self.jacobian.cost(system);
        let n = system.facts().n;
        self.sizes.copy_from_slice(&system.facts().typical_coordinates);
        for (inverse, size) in self.inverse_sizes.iter_mut().zip(self.sizes.iter()) {
            *inverse = if *size > 0.0 { size.recip() } else { 1.0 };
        }
        self.gap_sizes.clone_from(&system.facts().gap_sizes);
        self.gap_roundings = vec![0.0; self.gap_sizes.len()];
        let unknowns = n + system.facts().constraints();
        // Multipliers move nothing.
        self.inverse_sizes.lengthen(unknowns);
        let Self { first, last_first, residual, increment, previous, start, direction, .. } = self;
        for values in [first, last_first, residual, increment, previous, start, direction] {
            values.lengthen(unknowns);
        }
        let Self { inverse_tolerance, judged, place, .. } = self;
        for values in [inverse_tolerance, judged, place] {
            values.lengthen(unknowns);
        }
    }

    /// Number of independent constraints where the last Jacobian was evaluated.
    pub(super) fn rank(&self) -> usize {
        self.linear.rank()
    }

    /// Forgets the kept Jacobian.
    pub(super) fn forget_jacobian(&mut self) {
        self.kept = None;
    }

    /// Forces have jumped: the kept Jacobian may converge more slowly than its distance predicts.
    pub(super) fn doubt_jacobian(&mut self) {
        self.contraction.doubt();
    }

    /// Writes or reads the state between solves: the kept Jacobian and its measurements.
    pub(super) fn serialise<S: SecondOrderSystem + ?Sized>(&mut self, system: &mut S, tape: &mut Tape<'_>) {
        let blank = JacobianHistory { weights: [0.0; 3], steps: 0.0, cost: 0.0 };
        tape.optional(&mut self.kept, blank, |tape, kept| {
            tape.numbers(&mut kept.weights);
            tape.number(&mut kept.steps);
            tape.number(&mut kept.cost);
        });
        // In one number: simulations saved by earlier versions have the flag alone. Of the counts, none of which is larger than
        // `STIFF_AGAIN`, one at least is zero.
        let mut touching =
            usize::from(self.might_touch) + 2 * (self.softly_solved + (STIFF_AGAIN + 1) * self.softly_failed);
        tape.count(&mut touching);
        self.might_touch = touching % 2 == 1;
        (self.softly_solved, self.softly_failed) =
            (touching / 2 % (STIFF_AGAIN + 1), touching / 2 / (STIFF_AGAIN + 1));
        if tape.reads() {
            self.prepare(system);
        }
        if self.kept.is_some() {
            self.linear.serialise(tape);
            if tape.reads() {
                match self.linear.factorise() {
                    Ok(()) => self.find_gap_roundings(),
                    Err(_) => self.kept = None,
                }
            }
        }
        self.contraction.serialise(tape);
        tape.number(&mut self.first_size);
        for values in [&mut self.q_jacobian, &mut self.v_jacobian, &mut self.last_first] {
            tape.numbers(values);
        }
    }

    /// One over the tolerance of each acceleration in the last solve.
    pub(super) fn inverse_tolerances(&self) -> &[f64] {
        &self.inverse_tolerance
    }

    /// Typical sizes of coordinates.
    pub(super) fn sizes(&self) -> &[f64] {
        &self.sizes
    }

    /// Finds the accelerations of `trial` at which the residual vanishes, starting from `guess`. `last` are those at
    /// the start of the step; tolerances are relative to the larger ones of both. `h` is the step size. After a failure
    /// the trial is undefined.
    ///
    /// Tries in turn: the kept Jacobian, one of this step, fresh Jacobians with increments that may be shortened, and these by way of softer
    /// contacts, with which solves begin after one that needed them.
    pub(super) fn solve<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        trial: &mut Trial<V>,
        guess: &[f64],
        last: &[f64],
        h: f64,
        counters: &mut Counters,
    ) -> Solved {
        self.begin(trial, guess, last, h);
        let is_kept = self.kept.is_some_and(|kept| kept.weights == trial.weights);
        if !is_kept {
            self.kept = None;
        }
        if (V::IS_PLAIN || !self.is_at_rest) && (is_kept || self.reuse && !self.might_touch) {
            if self.with_kept_jacobian(system, trial, [guess, last], h, counters)?.is_ok() {
                self.might_touch = may_touch::<_, V>(system);
                return Ok(Ok(()));
            }
            counters.reuse_failures += usize::from(is_kept);
            self.contraction = Contraction::unknown();
            trial.set(guess);
        }
        let may_soften =
            !V::IS_PLAIN && !self.is_at_rest && system.facts().has_contact && self.softly_failed == 0;
        self.softly_failed = self.softly_failed.saturating_sub(1);
        let begins_softly = may_soften && !self.softly_solved.is_multiple_of(STIFF_AGAIN);
        let mut outcome = Err(Failure::NotConverged);
        if begins_softly {
            outcome = self.with_softer_contacts(system, trial, [guess, last], h, counters)?;
        }
        if outcome.is_err() {
            trial.set(guess);
            let solved =
                self.with_fresh_jacobians(system, trial, [guess, last], h, Friction::Followed, counters);
            if !V::IS_PLAIN
                && let Some(model) = system.model()
            {
                model.treat_friction(FrictionTreatment::Exact);
            }
            outcome = solved?;
            if outcome.is_err() && may_soften && !begins_softly && may_touch::<_, V>(system) {
                outcome = self.with_softer_contacts(system, trial, [guess, last], h, counters)?;
            } else if !begins_softly {
                self.softly_solved = 0;
            }
        }
        self.might_touch = may_touch::<_, V>(system);
        Ok(outcome)
    }

    /// Sets a trial to the guess, and tolerances.
    fn begin(&mut self, trial: &mut Trial<V>, guess: &[f64], last: &[f64], h: f64) {
        trial.set(guess);
        let [of_displacement, of_velocity, _] = trial.weights;
        let reach = of_displacement.max(h * of_velocity);
        self.reach = if reach > 0.0 { reach } else { h * h };
        self.is_at_rest = !V::IS_PLAIN && trial.weights[2] == 0.0;
        if !self.has_given_atol {
            self.set_tolerances_by_sizes(trial, h);
        }
        self.set_tolerances(&[guess, last]);
    }

    /// Newton's method with the kept Jacobian, or with one of this step if there is none or it converges too slowly.
    fn with_kept_jacobian<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        trial: &mut Trial<V>,
        [guess, last_accelerations]: [&[f64]; 2],
        h: f64,
        counters: &mut Counters,
    ) -> Solved {
        let mut cost = 0.0;
        let mut renew = !self.kept_jacobian_pays(system, trial, h);
        let mut is_fresh = false;
        // Size of the previous increment with the same Jacobian, and its displacements.
        let mut last: Option<[f64; 2]> = None;
        // Size of the first increment, and whether it is similar to that of the last step.
        let mut first = None;
        for iteration in 0..MAX_ITERATIONS {
            self.increments = iteration;
            self.evaluate_residual(system, trial, counters)?;
            cost += 1.0;
            let mut size = f64::NAN;
            let mut measured_rate = None;
            if !renew {
                std::mem::swap(&mut self.previous, &mut self.increment);
                size = self.compute_increment();
                renew = self.misses_open_constraints(trial);
            }
            if let Some(last) = last
                && !renew
            {
                let so_far = SolveProgress { iteration, cost, is_fresh };
                match self.judge(system, trial, (last, size), h, so_far, counters)? {
                    Judgement::Rate(rate, shall_renew) => (measured_rate, renew) = (Some(rate), shall_renew),
                    Judgement::IsRounding => {
                        self.count_step(cost);
                        return Ok(Ok(()));
                    }
                    Judgement::Fails(failure) => return Ok(Err(failure)),
                }
            }
            if renew {
                if let Err(failure) = self.renew_jacobian(system, trial, h, counters)? {
                    return Ok(Err(failure));
                }
                cost += self.jacobian_cost;
                size = self.size_of_increment();
                measured_rate = None;
                renew = false;
                is_fresh = true;
            }
            if !size.is_finite() {
                return Ok(Err(Failure::NonFinite));
            }
            trial.subtract(&self.increment);
            if size > self.far {
                self.set_tolerances(&[guess, last_accelerations, &trial.a]);
                size = self.size_of_increment();
            }
            let (first_size, is_similar) =
                *first.get_or_insert_with(|| (size, self.is_similar_to_last_step()));
            let rate = match measured_rate {
                Some(rate) => rate,
                // Only for steps that begin like the last one.
                None if is_similar && !may_touch::<_, V>(system) => {
                    self.contraction.bound(self.distance_from_jacobian(trial, h))
                }
                None => f64::INFINITY,
            };
            if size <= NEGLIGIBLE || left_after::<_, V>(system, size, rate) <= 1.0 {
                if measured_rate.is_none() {
                    self.contraction.not_measured();
                }
                self.accept(first_size, cost);
                return Ok(Ok(()));
            }
            last = Some([size, self.moved]);
        }
        Ok(Err(Failure::NotConverged))
    }

    /// Judges an increment of this size by the size and the displacements of the previous one with the same Jacobian.
    #[inline]
    fn judge<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        trial: &mut Trial<V>,
        ([last_size, last_moved], size): ([f64; 2], f64),
        h: f64,
        SolveProgress { iteration, cost, is_fresh }: SolveProgress,
        counters: &mut Counters,
    ) -> Result<Judgement, Interrupted> {
        if !size.is_finite() {
            return Ok(Judgement::Fails(Failure::NonFinite));
        }
        let of_size = size / last_size;
        if of_size >= 1.0 || is_fresh && of_size > SLOWEST_RATE {
            self.set_displacements(trial, h);
            if self.is_rounding(system, trial, h, counters)? {
                return Ok(Judgement::IsRounding);
            }
            if of_size >= 1.0 {
                return Ok(Judgement::Fails(Failure::NotConverged));
            }
        }
        let rate = larger_rate(of_size, [last_moved, self.moved]);
        let distance = self.distance_from_jacobian(trial, h);
        // With contacts every step is measured, also close to where the Jacobian was evaluated. There the rate is due to the terms
        // that the tangent neglects, and does not predict rates farther away.
        let is_bound = size <= NEGLIGIBLE || is_fresh && may_touch::<_, V>(system);
        self.contraction.measured(rate, distance, is_bound);
        let needed = iterations_needed(left_after::<_, V>(system, size, rate), rate);
        let shall_renew = match self.kept {
            _ if needed == 1.0 => false,
            // New contacts in a step make the first rate poor; the next one is that of the Jacobian.
            _ if iteration == 1 && may_touch::<_, V>(system) => false,
            Some(kept) if !is_fresh => kept.should_be_replaced(cost - 1.0 + needed),
            _ => needed > self.jacobian_cost + FRESH_ITERATIONS,
        };
        Ok(Judgement::Rate(rate, shall_renew))
    }

    /// Whether the first increment is similar to that of the last step, or both are within tolerance.
    fn is_similar_to_last_step(&mut self) -> bool {
        self.first.copy_from_slice(&self.increment);
        let differences = self.first.iter().zip(self.last_first.iter()).map(|(first, last)| first - last);
        let difference = self.size_of(differences);
        difference <= SIMILAR_INCREMENTS * self.first_size.max(1.0) && self.first_size.is_finite()
    }

    /// Whether a kept Jacobian is expected to be cheaper than a fresh one in a step that begins like the last one.
    fn kept_jacobian_pays<S: SecondOrderSystem + ?Sized>(
        &self,
        system: &mut S,
        trial: &Trial<V>,
        h: f64,
    ) -> bool {
        self.kept.is_some_and(|kept| {
            let mut iterations = |distance| {
                let rate = self.contraction.expect(distance);
                iterations_needed(left_after::<_, V>(system, self.first_size, rate), rate)
            };
            let needed = iterations(self.distance_from_jacobian(trial, h));
            self.first_size <= NEGLIGIBLE || needed <= iterations(0.0) || !kept.should_be_replaced(needed)
        })
    }

    /// Counts a step that was solved with the kept Jacobian.
    fn count_step(&mut self, cost: f64) {
        if let Some(kept) = &mut self.kept {
            kept.steps += 1.0;
            kept.cost += cost;
        }
    }

    fn evaluate_residual<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        trial: &Trial<V>,
        counters: &mut Counters,
    ) -> Result<(), Interrupted> {
        counters.nfev += 1;
        counters.newton_iterations += 1;
        system.residual(trial.t, &trial.q, &trial.v, trial.accelerations(), &mut self.residual)?;
        self.scale_gaps(trial);
        Ok(())
    }

    /// Evaluates a Jacobian and keeps it.
    fn renew_jacobian<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        trial: &Trial<V>,
        h: f64,
        counters: &mut Counters,
    ) -> Solved {
        let outcome = self.evaluate_jacobian(system, trial, h, counters)?;
        if outcome.is_ok() {
            self.kept = Some(JacobianHistory { weights: trial.weights, steps: 0.0, cost: 0.0 });
        }
        Ok(outcome)
    }

    /// Ends a step whose Newton iteration with a kept Jacobian has converged.
    fn accept(&mut self, first_size: f64, cost: f64) {
        self.first_size = first_size;
        std::mem::swap(&mut self.first, &mut self.last_first);
        self.count_step(cost);
    }

    /// Evaluates and factorises the Jacobian at a trial whose residual has been evaluated, and computes the increment.
    fn evaluate_jacobian<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        trial: &Trial<V>,
        h: f64,
        counters: &mut Counters,
    ) -> Solved {
        self.jacobian.evaluate(system, trial, &self.residual, h, &mut self.linear, counters)?;
        self.q_jacobian.copy_from_slice(&trial.q);
        self.v_jacobian.copy_from_slice(&trial.v);
        counters.nlu += 1;
        if let Err(failure) = self.linear.factorise() {
            return Ok(Err(failure));
        }
        self.find_gap_roundings();
        self.compute_increment();
        self.left_open = self.left_open(trial);
        Ok(Ok(()))
    }

    /// Computes the next increment from the residual; returns its size.
    fn compute_increment(&mut self) -> f64 {
        self.increment.copy_from_slice(&self.residual);
        self.linear.solve(&mut self.increment);
        self.size_of_increment()
    }

    /// Root mean square of the increment in units of the tolerances; not finite if the increment is not. Sets
    /// [`Self::moved`].
    fn size_of_increment(&mut self) -> f64 {
        let Self { increment, inverse_tolerance, inverse_sizes, .. } = self;
        let (mut size, mut moved) = (0.0, 0.0);
        for ((a, w), inverse_size) in increment.iter().zip(inverse_tolerance.iter()).zip(inverse_sizes.iter())
        {
            size += (a * *w) * (a * *w);
            moved += (a * *inverse_size) * (a * *inverse_size);
        }
        let n = self.rtol.len().max(1) as f64;
        self.moved = self.reach * (moved / n).sqrt();
        (size / n).sqrt()
    }

    fn size_of(&self, accelerations: impl Iterator<Item = f64>) -> f64 {
        let sum: f64 = accelerations.zip(self.inverse_tolerance.iter()).map(|(a, w)| (a * w) * (a * w)).sum();
        (sum / self.rtol.len().max(1) as f64).sqrt()
    }

    /// Whether the increment at `trial`, the end of [`Self::previous`], consists of rounding errors: its displacements are within tolerance,
    /// and it is a different one at a point slightly before. A continuous increment would be nearly the same there, even if it is large
    /// because of a wrong Jacobian or new contacts. Overwrites the residual.
    fn is_rounding<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        trial: &mut Trial<V>,
        h: f64,
        counters: &mut Counters,
    ) -> Result<bool, Interrupted> {
        let step = self.displacement_of(&self.previous);
        let largest = self.displacement().max(step);
        // Relative to a step of the usual size, so that very short steps do not count as solved.
        let spacings = SPACINGS * (h / self.dt).powi(2).min(1.0);
        if largest <= spacings {
            return Ok(true);
        }
        let rtol = self.rtol.iter().copied().fold(1.0, f64::min);
        if largest.is_nan() || largest > TOLERABLE_MOTION * rtol {
            return Ok(false);
        }
        self.judged.copy_from_slice(&self.increment);
        self.place.copy_from_slice(&trial.a);
        let (back, moved) = (-(spacings / step).clamp(NEARBY, FARTHEST), self.moved);
        for (increment, previous) in self.increment.iter_mut().zip(self.previous.iter()) {
            *increment = back * previous;
        }
        trial.subtract(&self.increment);
        counters.nfev += 1;
        system.residual(trial.t, &trial.q, &trial.v, trial.accelerations(), &mut self.residual)?;
        self.scale_gaps(trial);
        self.compute_increment();
        self.moved = moved;
        trial.set(&self.place);
        let Self { increment, judged, inverse_tolerance, .. } = self;
        let mut of_all = [0.0, 0.0];
        let mut is_one_by_one = true;
        for ((increment, judged), w) in increment.iter_mut().zip(judged.iter()).zip(inverse_tolerance.iter())
        {
            let [size, change] = [judged.abs() * *w, (*increment - *judged).abs() * *w];
            is_one_by_one &= ONE_CHANGES * size <= ONE_CHANGES.max(change);
            of_all = [of_all[0] + size * size, of_all[1] + change * change];
            *increment = *judged;
        }
        Ok(is_one_by_one && ROUNDING_CHANGES * of_all[0].sqrt() <= of_all[1].sqrt())
    }

    /// Computes displacements by unit accelerations in a step, or by the velocities that they cause, in units of the larger one of a
    /// coordinate and its typical size; if that is unknown, of the largest coordinate. At the start, where a step of any length may
    /// follow, in units of the largest one of all in its size.
    fn set_displacements(&mut self, trial: &Trial<V>, h: f64) {
        let reach = self.reach;
        let moved = |i: usize| trial.q[i].abs().max(h * trial.v[i].abs()).max(reach * trial.a[i].abs());
        let largest = (0..trial.q.len()).map(moved).fold(0.0, f64::max);
        let is_start = trial.weights[..2] == [0.0; 2];
        let in_sizes = self.sizes.iter().enumerate().filter(|(_, size)| is_start && **size > 0.0);
        let farthest = in_sizes.map(|(i, size)| moved(i) / size).fold(1.0, f64::max);
        for (i, (to, size)) in self.displacements.iter_mut().zip(self.sizes.iter()).enumerate() {
            let size = if *size > 0.0 { moved(i).max(farthest * *size) } else { largest };
            *to = reach / size.max(SMALLEST_TOLERANCE);
        }
    }

    /// Root mean square of the displacements by the increment, in units of sizes.
    fn displacement(&self) -> f64 {
        self.displacement_of(&self.increment)
    }

    fn displacement_of(&self, increment: &[f64]) -> f64 {
        let moved = increment.iter().zip(self.displacements.iter()).map(|(a, w)| (a * w) * (a * w));
        (moved.sum::<f64>() / self.displacements.len().max(1) as f64).sqrt()
    }

    /// Distance of displacements, and of velocities times the step size, from those at which the Jacobian was evaluated, in units of sizes
    /// if these are known.
    fn distance_from_jacobian(&self, trial: &Trial<V>, h: f64) -> f64 {
        let Self { q_jacobian, v_jacobian, inverse_sizes, .. } = self;
        let from = q_jacobian.iter().zip(v_jacobian.iter()).zip(inverse_sizes.iter());
        let (mut displacement, mut velocity) = (0.0, 0.0);
        for ((q, v), ((q_jacobian, v_jacobian), inverse_size)) in trial.q.iter().zip(trial.v.iter()).zip(from)
        {
            displacement += ((q - q_jacobian) * inverse_size).powi(2);
            velocity += ((v - v_jacobian) * inverse_size).powi(2);
        }
        (displacement + h * h * velocity).sqrt()
    }

    /// Sets absolute tolerances by the sizes of coordinates; of those whose size is unknown by how large they are in the trial.
    fn set_tolerances_by_sizes(&mut self, trial: &Trial<V>, h: f64) {
        let of_sizes = if !V::IS_PLAIN && self.is_at_rest {
            QUASI_STATIC_TOLERANCE / self.reach
        } else {
            UNRESOLVED_MOTION / self.dt.max(h).powi(2)
        };
        for (i, (atol, size)) in self.atol.iter_mut().zip(self.sizes.iter()).enumerate() {
            let size = if *size > 0.0 { *size } else { trial.q[i].abs().max(h * trial.v[i].abs()) };
            *atol = of_sizes * size;
        }
    }

    /// Sets tolerances relative to the largest of these accelerations.
    fn set_tolerances<const N: usize>(&mut self, accelerations: &[&[f64]; N]) {
        // Multipliers follow from the accelerations and have no tolerance.
        let Self { rtol, atol, inverse_tolerance, .. } = self;
        let (sizes, is_at_rest, reach) = (&self.sizes, !V::IS_PLAIN && self.is_at_rest, self.reach);
        for (i, (inverse, (rtol, atol))) in
            inverse_tolerance.iter_mut().zip(rtol.iter().zip(atol.iter())).enumerate()
        {
            let size = accelerations.iter().fold(0.0, |size: f64, a| size.max(a[i].abs()));
            // Without inertia an acceleration is a displacement over the square of a step of any size.
            let atol = if is_at_rest { atol.min(QUASI_STATIC_TOLERANCE * sizes[i] / reach) } else { *atol };
            let tolerance = SAFETY * (atol + rtol * size);
            *inverse = 1.0 / tolerance.max(SMALLEST_TOLERANCE);
        }
    }
}

/// The contraction rate of two increments with these displacements: the larger one of the rates of sizes and, above rounding, of
/// displacements.
fn larger_rate(of_size: f64, [last_moved, moved]: [f64; 2]) -> f64 {
    if moved > SPACINGS.max(of_size * last_moved) { moved / last_moved } else { of_size }
}
