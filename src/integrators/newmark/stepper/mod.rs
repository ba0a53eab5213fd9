//! Integration step by step.

mod adaptive;
mod attempt;
mod explain;
mod fixed;
mod jump;
mod kinds;

use super::corrector::Corrector;
use super::error_estimate::ErrorEstimate;
use super::numbers::Numbers;
use super::options::{Options, Predictor, StepSize};
use super::scheme::{Scheme, Step};
use super::trial::Trial;
use crate::error::Interrupted;
use crate::integrators::attempts::{Remedy, Unilateral};
use crate::integrators::second_order::{
    Counters, Grid, SecondOrderSystem, Status, constrained_start, model_of, number_of_steps,
};
use crate::integrators::{Reason, Retries};
use crate::model::rotation_vectors;
use crate::numerics::hermite::cubic;
use crate::numerics::tape::Tape;

pub use self::kinds::Stepper;

/// Initial guess of the accelerations of the next step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Guess {
    Zero,
    Last,
    Extrapolated,
}

/// Behaviour of the lengths of inextensible tendons over a step of fixed size, within which the set of taut tendons is constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lengths {
    /// Lengths and velocities are continuous.
    Smooth,
    /// Lengths have jumped; taut tendons follow within the step.
    Jump,
    /// The same, and slack tendons become taut in the step: an inelastic impact without memory.
    TakenUp,
}

/// An integration performed step by step, with this storage of states.
#[derive(Clone, Debug)]
struct StepperOf<V> {
    options: Options,
    scheme: Scheme,
    t: f64,
    t_end: f64,
    q: V,
    v: V,
    a: V,
    t_old: f64,
    q_old: V,
    v_old: V,
    a_old: V,
    /// Algorithmic accelerations and the step size they belong to; not used by plain schemes.
    s: V,
    h_of_s: f64,
    /// The same scaled to the size of the adaptive trial step.
    s_of_trial: V,
    adapts_memory: bool,
    /// The trial step.
    step: Step,
    trial: Trial<V>,
    /// Its size, and the guess of its accelerations.
    size: f64,
    guessed: V,
    guess: Guess,
    corrector: Corrector<V>,
    /// Present for adaptive steps.
    error_estimate: Option<ErrorEstimate>,
    rtol: V,
    /// The given absolute tolerance.
    atol: Option<V>,
    /// Size of the next adaptive step.
    h: f64,
    /// Whether the system has contacts, and corners in time; determined before the first step.
    has_contact: bool,
    has_corners: bool,
    /// Whether there are one-sided constraints; the behaviour of lengths over the next step; the multipliers of the last solve.
    is_one_sided: bool,
    lengths: Lengths,
    pulls: Vec<f64>,
    /// End of the next step of fixed size, if it is within a step of the grid.
    ends_at: Option<f64>,
    /// Ends of steps of fixed size, and their number up to the end of the interval.
    grid: Grid,
    fixed_steps: usize,
    /// Whether the trial step may have another size than the next one: adaptive steps, and parts of steps with corners.
    changes_size: bool,
    counters: Counters,
    retries: Retries,
    /// Whether the trial is without memory, and whether its loads are those of the middle of its step.
    forgets: bool,
    lags: bool,
    /// Whether forces or velocities have jumped since the last step, so that the next one is [one of its own](jump).
    is_after_jump: bool,
    /// Whether the last step or trial was such a step.
    has_stages: bool,
    unilateral: Unilateral,
    /// Number of independent active constraints in the last step; all before the first step.
    rank: usize,
    /// For quasi-static motion: the largest speeds in the last two steps, in sizes of coordinates per second.
    speeds: [f64; 2],
    started: bool,
    status: Option<Status>,
}

impl<V: Numbers> StepperOf<V> {
    /// With valid options; `rtol` and `atol` are the tolerances of each coordinate.
    fn new(
        t_span: (f64, f64),
        [q0, v0]: [&[f64]; 2],
        options: &Options,
        (rtol, atol): (&[f64], Option<&[f64]>),
    ) -> Self {
        let (t0, t_end) = t_span;
        let n = q0.len();
        let (rtol, atol) = (V::of(rtol), atol.map(V::of));
        Self {
            scheme: options.scheme,
            t: t0,
            t_end,
            q: V::of(q0),
            v: V::of(v0),
            a: V::zeros(n),
            t_old: t0,
            q_old: V::of(q0),
            v_old: V::of(v0),
            a_old: V::zeros(n),
            s: V::zeros(n),
            h_of_s: options.dt,
            s_of_trial: V::zeros(n),
            adapts_memory: options.step_size != StepSize::Fixed && !options.scheme.is_plain(),
            step: options.scheme.step(options.dt, Some(1.0)),
            trial: Trial::new(n),
            size: 0.0,
            guessed: V::zeros(n),
            guess: if options.predictor == Predictor::Zero { Guess::Zero } else { Guess::Last },
            corrector: Corrector::new(options, rtol.clone(), atol.clone()),
            error_estimate: match options.step_size {
                StepSize::Fixed => None,
                StepSize::Adaptive { .. } => Some(ErrorEstimate::new(&options.scheme)),
            },
            rtol,
            atol,
            h: match options.step_size {
                StepSize::Fixed => options.dt,
                StepSize::Adaptive { max_step, .. } => options.dt.min(max_step),
            },
            grid: Grid::new(t0, options.dt),
            fixed_steps: number_of_steps(t_end - t0, options.dt),
            changes_size: options.step_size != StepSize::Fixed,
            counters: Counters::default(),
            retries: Retries::default(),
            forgets: false,
            lags: false,
            is_after_jump: false,
            has_stages: false,
            has_contact: false,
            has_corners: false,
            is_one_sided: false,
            lengths: Lengths::Smooth,
            pulls: Vec::new(),
            ends_at: None,
            unilateral: Unilateral::default(),
            rank: 0,
            speeds: [f64::INFINITY; 2],
            started: false,
            status: None,
            options: options.clone(),
        }
    }

    /// Solves for the accelerations at the start. [`Self::step`] calls this if necessary. Returns
    /// `Some(status)` if there are none.
    fn start<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
    ) -> Result<Option<Status>, Interrupted> {
        if self.started {
            return Ok(self.status);
        }
        self.prepare(system);
        rotation_vectors::wrap(&system.facts().rotation_vectors, &mut self.q, &mut self.v, &mut []);
        if !self.scheme.has_inertia() {
            self.started = true;
            return Ok(None);
        }
        if let Some(a0) = &self.options.initial_acceleration {
            self.a[..a0.len()].copy_from_slice(a0);
        } else if system.facts().constraints() > 0 {
            let Self { t, q, v, a, .. } = self;
            if let Err(failure) = constrained_start(model_of(system), *t, q, v, a)? {
                self.status = Some(Status::NoInitialAcceleration(failure));
            }
        } else {
            let trial = &mut self.trial;
            trial.t = self.t;
            trial.weights = [0.0, 0.0, 1.0];
            trial.q_base.copy_from_slice(&self.q);
            trial.v_base.copy_from_slice(&self.v);
            self.guessed.fill(0.0);
            let (guess, h) = (&self.guessed, self.options.dt);
            let solved = self.corrector.solve(system, trial, guess, &self.a, h, &mut self.counters)?;
            self.corrector.forget_jacobian();
            match solved {
                Ok(()) => self.a.copy_from_slice(&trial.a),
                Err(failure) => self.status = Some(Status::NoInitialAcceleration(failure)),
            }
        }
        self.s.copy_from_slice(&self.a[..self.q.len()]);
        self.a_old.copy_from_slice(&self.a);
        self.started = self.status.is_none();
        if self.has_contact && self.started {
            self.unilateral.start(model_of(system), self.t, &self.q)?;
        }
        Ok(self.status)
    }

    /// Memory for the unknowns of a step: accelerations, and multipliers of constraints.
    fn prepare<S: SecondOrderSystem + ?Sized>(&mut self, system: &mut S) {
        self.corrector.prepare(system);
        let facts = system.facts();
        (self.has_contact, self.has_corners) = (facts.has_contact, facts.varies_in_time);
        (self.is_one_sided, self.rank) = (facts.is_one_sided, facts.constraints());
        let impacts = self.options.impacts;
        // After an impact the next step is one of two stages, which only unconditionally stable members go on from.
        let follows = impacts.are_followed(facts) && self.scheme.stability_limit().is_infinite();
        self.unilateral.set_treatment([impacts.are_resolved(facts), follows]);
        self.pulls.resize(if self.is_one_sided { self.rank } else { 0 }, 0.0);
        let unknowns = self.q.len() + facts.constraints();
        for values in [&mut self.a, &mut self.a_old, &mut self.guessed] {
            values.lengthen(unknowns);
        }
        self.trial.lengthen(unknowns);
    }

    /// Makes one accepted step. Returns `Some(status)` if the integration has ended: the end was reached, or
    /// no step could be made, which leaves the state unchanged. After an interruption the state is that of
    /// the last accepted step, and the step can be repeated.
    ///
    /// # Panics
    /// If the integration had already ended.
    fn step<S: SecondOrderSystem + ?Sized>(&mut self, system: &mut S) -> Result<Option<Status>, Interrupted> {
        assert!(self.status.is_none(), "the integration is over");
        if self.start(system)?.is_some() {
            return Ok(self.status);
        }
        if self.t < self.t_end {
            self.shorten_rotation_vectors(system);
        }
        self.status = if self.t == self.t_end {
            Some(Status::Finished)
        } else if self.counters.steps >= self.options.max_steps {
            Some(Status::TooManySteps)
        } else if self.error_estimate.is_some() {
            self.adaptive_step(system)?
        } else {
            self.fixed_step(system)?
        };
        if self.status.is_none() && self.t == self.t_end {
            self.status = Some(Status::Finished);
        }
        Ok(self.status)
    }

    /// Replaces rotation vectors that come close to their singularity by equivalent shorter ones.
    fn shorten_rotation_vectors<S: SecondOrderSystem + ?Sized>(&mut self, system: &mut S) {
        let Self { q, v, a, s, .. } = self;
        if rotation_vectors::wrap(&system.facts().rotation_vectors, q, v, &mut [a, s]) {
            // These belong to the old coordinates.
            self.corrector.forget_jacobian();
            self.a_old.copy_from_slice(&self.a);
        }
    }

    /// Extends the integration to a later end, for any status. Steps of fixed size are equal: `dt` if that divides the interval.
    fn extend_to(&mut self, t_end: f64) {
        (self.status, self.t_end) = (None, t_end);
        if self.error_estimate.is_none() {
            self.fixed_steps = self.grid.begin_interval(self.t, t_end, self.options.dt);
        }
    }

    /// Makes the next step end at this time at the latest, within the last step, which was undone, or at the end of the interval.
    fn end_at(&mut self, t: f64) {
        if self.error_estimate.is_none() {
            self.ends_at = Some(t).filter(|&t| t < self.t_end);
        } else {
            (self.status, self.t_end) = (None, t);
        }
    }

    /// Sets the behaviour of lengths over the next step.
    fn expect(&mut self, lengths: Lengths) {
        self.lengths = lengths;
        if lengths == Lengths::TakenUp {
            self.unilateral.stop();
        }
    }

    /// Replaces the current accelerations after a jump of forces.
    fn jump(&mut self, a: &[f64]) {
        self.unilateral.forget();
        self.expect_jump(a);
        for (i, (new, old)) in a.iter().zip(self.a.iter_mut()).enumerate() {
            // Algorithmic and previous accelerations keep their differences from the current ones.
            self.s[i] += new - *old;
            self.a_old[i] = if self.is_after_jump { *old } else { self.a_old[i] + (new - *old) };
            *old = *new;
        }
        self.corrector.doubt_jacobian();
    }

    /// Continues from this state after a jump of velocities. `a` are accelerations, followed by multipliers.
    fn restart(&mut self, [q, v, a]: [&[f64]; 3]) {
        self.unilateral.forget();
        self.expect_jump(a);
        self.q.copy_from_slice(q);
        self.v.copy_from_slice(v);
        self.a_old.copy_from_slice(if self.is_after_jump { &self.a } else { a });
        self.a.copy_from_slice(a);
        self.s.copy_from_slice(&a[..q.len()]);
        // Accelerations before the jump are invalid after it.
        self.h_of_s = 0.0;
        self.corrector.doubt_jacobian();
        if self.is_one_sided {
            // Other tendons may be taut, after their impulses.
            self.rank = a.len() - q.len();
            self.corrector.forget_jacobian();
            self.unilateral.resume_after_stop(self.has_contact);
        }
    }

    fn doubt(&self, remedy: Remedy) -> Option<String> {
        self.unilateral.doubt(self.options.dt, remedy)
    }

    /// Replaces the end of the last step, which was repeated by another method.
    fn end_instead(&mut self, motion: [&[f64]; 3], touches: bool) {
        self.restart(motion);
        self.ignore_jump();
        self.unilateral.resolve(touches);
    }

    /// Adds the cost of a motion that resolves the impact of the last step.
    fn add_work(&mut self, work: &Counters) {
        self.counters.nfev += work.nfev;
        self.counters.njev += work.njev;
        self.counters.nlu += work.nlu;
        self.retries.attempt();
        self.retries.fail(Reason::Impact);
    }

    /// Writes or reads the state that persists between steps.
    fn serialise<S: SecondOrderSystem + ?Sized>(&mut self, system: &mut S, tape: &mut Tape<'_>) {
        if tape.reads() {
            self.prepare(system);
        }
        for number in [&mut self.t, &mut self.t_end, &mut self.t_old, &mut self.h_of_s, &mut self.h] {
            tape.number(number);
        }
        let Self { q, v, a, s, q_old, v_old, a_old, .. } = self;
        for values in [q, v, a, s, q_old, v_old, a_old] {
            tape.numbers(values);
        }
        let guesses = [Guess::Zero, Guess::Last, Guess::Extrapolated];
        let mut guess = guesses.iter().position(|&guess| guess == self.guess).unwrap_or_default();
        // In one number: simulations saved by earlier versions have the guess alone.
        guess += guesses.len() * usize::from(self.is_after_jump);
        tape.below(2 * guesses.len(), &mut guess);
        self.guess = guesses[guess % guesses.len()];
        self.is_after_jump = guess >= guesses.len();
        self.grid.serialise(tape);
        self.counters.serialise(tape);
        self.unilateral.serialise(tape);
        if !self.scheme.has_inertia() {
            self.unilateral.serialise_snaps(tape);
            tape.numbers(&mut self.speeds);
        }
        tape.count(&mut self.rank);
        tape.flag(&mut self.started);
        self.corrector.serialise(system, tape);
    }

    /// Current accelerations, which satisfy the equations of motion.
    fn a(&self) -> &[f64] {
        &self.a[..self.q.len()]
    }

    /// Whether steps have one size.
    fn has_fixed_steps(&self) -> bool {
        self.error_estimate.is_none()
    }

    /// The scheme of steps of one size that follow vibrations.
    fn fixed_scheme(&self) -> Option<Scheme> {
        Some(self.scheme).filter(|scheme| self.has_fixed_steps() && scheme.has_inertia())
    }

    /// State at a time within the last step, by cubic Hermite interpolation of displacements and of
    /// velocities and by linear interpolation of accelerations. At the ends of the step, the result is bit
    /// for bit the state there.
    fn interpolate(&self, t: f64, q: &mut [f64], v: &mut [f64], a: &mut [f64]) {
        let h = self.t - self.t_old;
        let x = if t == self.t { 1.0 } else { (t - self.t_old) / h };
        if x == 0.0 || x == 1.0 {
            let state =
                if x == 0.0 { [&self.q_old, &self.v_old, &self.a_old] } else { [&self.q, &self.v, &self.a] };
            q.copy_from_slice(state[0]);
            v.copy_from_slice(state[1]);
            // Multipliers follow the accelerations.
            a.copy_from_slice(&state[2][..a.len()]);
            return;
        }
        if !self.scheme.has_inertia() {
            // Quasi-static velocities are means over steps.
            for i in 0..q.len() {
                q[i] = self.q_old[i] + x * (self.q[i] - self.q_old[i]);
                v[i] = self.v[i];
            }
            a.fill(0.0);
            return;
        }
        for i in 0..q.len() {
            q[i] = cubic(x, h, [self.q_old[i], self.q[i]], [self.v_old[i], self.v[i]]);
            v[i] = cubic(x, h, [self.v_old[i], self.v[i]], [self.a_old[i], self.a[i]]);
            a[i] = self.a_old[i] + x * (self.a[i] - self.a_old[i]);
        }
    }
}
#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrators::attempts::Stepper as _;
    use crate::integrators::newmark::Parameters;
    use crate::integrators::second_order::ROUNDING_OF_STEPS;
    use crate::model::pendulum::SpringPendulum;

    /// A change of the step must not cost the methods with algorithmic accelerations their order.
    #[test]
    fn order_two_with_steps_that_change_all_the_time() {
        let mut pendulum = SpringPendulum::new(1.0, 1.0, 10.0, 9.81).unwrap();
        let mut angle_at_one = |scheme: Scheme, h: f64| {
            let options = Options { scheme, rtol: 1e-12.into(), ..Options::new(h) };
            let tolerances: (&[f64], _) = (&[1e-12; 2], None);
            let mut stepper: StepperOf<Vec<f64>> =
                StepperOf::new((0.0, 1.0), [&[-0.7, 0.5], &[0.0; 2]], &options, tolerances);
            stepper.start(&mut pendulum).unwrap();
            for k in 0.. {
                let step = if k % 3 == 0 { 0.25 * h } else { h };
                let is_last = stepper.t + step * (1.0 + ROUNDING_OF_STEPS) >= 1.0;
                let t_new = if is_last { 1.0 } else { stepper.t + step };
                let step = t_new - stepper.t;
                stepper.attempt(&mut pendulum, t_new, step).unwrap().unwrap();
                stepper.accept(&mut pendulum).unwrap();
                if is_last {
                    break;
                }
            }
            stepper.q[0]
        };
        for name in ["newmark", "hht", "generalised_alpha"] {
            let scheme = Scheme::by_name(name, &Parameters::default()).unwrap();
            // Richardson: differences of successive halvings fall by a factor of 4.
            let angles = [0, 1, 2, 3].map(|k| angle_at_one(scheme, 0.01 / f64::from(1 << k)));
            for k in 0..2 {
                let ratio = (angles[k] - angles[k + 1]) / (angles[k + 1] - angles[k + 2]);
                assert!((ratio - 4.0).abs() < 0.4, "{name}: {ratio}");
            }
        }
    }
}
