//! Integration step by step.

use super::corrector::Corrector;
use super::error_estimate::{Ends, ErrorEstimate, LARGEST_FACTOR};
use super::impacts::Impacts;
use super::options::{Options, Predictor, StepSize};
use super::scheme::{Scheme, Step, memory, stretch};
use super::trial::Trial;
use crate::description::signal::end_of_step;
use crate::error::{Interrupted, InvalidInput, Number};
use crate::integrators::second_order::{
    Counters, Failure, Grid, ROUNDING_OF_STEPS, Status, System, number_of_steps,
};
use crate::model::constraint::one_sided::most_switches;
use crate::model::{Beside, Holding, Radius, Switch};
use crate::numerics::hermite::cubic;
use crate::numerics::tape::Tape;

/// A step must be that many spacings of floating-point numbers long at least.
const SMALLEST_STEP_IN_SPACINGS: f64 = 10.0;

/// A step whose equations could not be solved is tried again with this fraction of its size (CVODE's choice).
const CUT: f64 = 0.25;

/// Steps without memory after one in which a slack tendon has become taut: the first of them loses the velocity with which it
/// came to the end, and its acceleration is that of a jump.
const STEPS_AFTER_STOP: usize = 2;

/// Below this relative tolerance rounding alone can keep Newton's method from converging: accelerations are differences of much
/// larger forces, which cost some digits of sixteen.
const TIGHT: f64 = 1e-10;

/// How often a step into contact, or of a mechanism with constraints, that cannot be made is halved at most.
const MOST_HALVINGS: usize = 8;

/// Makes a step to a time, of a size.
type Part<S> = fn(&mut Stepper, &mut S, f64, f64) -> Result<Result<(), Failure>, Interrupted>;

/// What the accelerations of the next step are guessed to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Guess {
    Zero,
    Last,
    Extrapolated,
}

/// An integration performed step by step. All memory is allocated by the time the initial accelerations are
/// known.
///
/// The stepper does not own the equations of motion; pass the same ones to every call.
#[derive(Clone, Debug)]
pub struct Stepper {
    options: Options,
    scheme: Scheme,
    t: f64,
    t_end: f64,
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    t_old: f64,
    q_old: Vec<f64>,
    v_old: Vec<f64>,
    a_old: Vec<f64>,
    /// Algorithmic accelerations and the step size they belong to; not used by plain schemes.
    s: Vec<f64>,
    h_of_s: f64,
    /// The same for the adaptive step that is tried.
    s_of_trial: Vec<f64>,
    /// The step that is tried.
    step: Step,
    trial: Trial,
    guessed: Vec<f64>,
    guess: Guess,
    corrector: Corrector,
    /// Present for adaptive steps.
    error_estimate: Option<ErrorEstimate>,
    rtol: Vec<f64>,
    atol: Vec<f64>,
    /// Size of the next adaptive step.
    h: f64,
    /// Whether the system has surfaces that may touch, and corners in time: asked once, before the first step.
    has_contact: bool,
    has_corners: bool,
    /// Where steps of fixed size end, and how many of these the way to the end takes.
    grid: Grid,
    fixed_steps: usize,
    /// Whether the step that is tried may have another size than the next one: adaptive ones, and parts of one with corners.
    changes_size: bool,
    counters: Counters,
    /// Steps still to be made without memory, because one met something that it did not resolve; and whether the trial was
    /// made without.
    unsettled: usize,
    forgets: bool,
    /// Whether loads of the trial are those of the middle of its step.
    lags: bool,
    /// Whether constraints that hold one way only have stopped something in the trial.
    has_stopped: bool,
    /// Whether surfaces touch, now and in the trial.
    touches: bool,
    will_touch: bool,
    /// Whether they touched in any state that was tried for the trial.
    has_touched: bool,
    impacts: Impacts,
    /// What the motion has now, if surfaces touch and the last step followed their forces.
    holding: Option<Holding>,
    /// Where the trial would end if nothing acted.
    straight_on: Vec<f64>,
    /// How many constraints held independently of the others in the last step; all before the first one.
    rank: usize,
    started: bool,
    status: Option<Status>,
}

impl Stepper {
    /// Prepares the integration of `n` coordinates from `q0`, `v0` over `t_span`. Evaluates nothing.
    pub fn new(
        n: usize,
        t_span: (f64, f64),
        q0: &[f64],
        v0: &[f64],
        options: &Options,
    ) -> Result<Self, InvalidInput> {
        let (rtol, atol) = options.check(n, t_span, q0, v0)?;
        let (t0, t_end) = t_span;
        let zeros = vec![0.0; n];
        Ok(Self {
            scheme: options.scheme,
            t: t0,
            t_end,
            q: q0.to_vec(),
            v: v0.to_vec(),
            a: zeros.clone(),
            t_old: t0,
            q_old: q0.to_vec(),
            v_old: v0.to_vec(),
            a_old: zeros.clone(),
            s: zeros.clone(),
            h_of_s: options.dt,
            s_of_trial: match options.step_size {
                StepSize::Adaptive { .. } if !options.scheme.is_plain() => zeros.clone(),
                _ => Vec::new(),
            },
            step: options.scheme.step(options.dt, Some(1.0)),
            trial: Trial::new(n),
            guessed: zeros,
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
            unsettled: 0,
            forgets: false,
            lags: false,
            has_stopped: false,
            touches: false,
            will_touch: false,
            has_touched: false,
            has_contact: false,
            has_corners: false,
            impacts: Impacts::default(),
            holding: None,
            straight_on: Vec::new(),
            rank: 0,
            started: false,
            status: None,
            options: options.clone(),
        })
    }

    /// Solves for the accelerations at the start. [`Self::step`] calls this if necessary. Returns
    /// `Some(status)` if there are none.
    pub fn start<S: System + ?Sized>(&mut self, system: &mut S) -> Result<Option<Status>, Interrupted> {
        if self.started {
            return Ok(self.status);
        }
        self.prepare(system);
        system.wrap(&mut self.q, &mut self.v, &mut []);
        if let Some(a0) = &self.options.initial_acceleration {
            self.a[..a0.len()].copy_from_slice(a0);
        } else if system.facts().constraints() > 0 {
            let Self { t, q, v, a, .. } = self;
            if let Err(failure) = system.constrained_start(*t, q, v, a)? {
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
        Ok(self.status)
    }

    /// Memory for the unknowns of a step: accelerations, and multipliers of constraints.
    fn prepare<S: System + ?Sized>(&mut self, system: &S) {
        self.corrector.prepare(system);
        let facts = system.facts();
        (self.has_contact, self.has_corners) = (facts.has_contact, facts.varies_in_time);
        self.rank = facts.constraints();
        let unknowns = self.q.len() + facts.constraints();
        for values in [&mut self.a, &mut self.a_old, &mut self.guessed, &mut self.trial.a] {
            values.resize(unknowns, 0.0);
        }
    }

    /// Makes one accepted step. Returns `Some(status)` if the integration has ended: the end was reached, or
    /// no step could be made, which leaves the state unchanged. After an interruption the state is that of
    /// the last accepted step, and the step can be repeated.
    ///
    /// # Panics
    /// If the integration had already ended.
    pub fn step<S: System + ?Sized>(&mut self, system: &mut S) -> Result<Option<Status>, Interrupted> {
        assert!(self.status.is_none(), "the integration is over");
        if self.start(system)?.is_some() {
            return Ok(self.status);
        }
        if self.t < self.t_end {
            self.settle(system);
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

    /// Goes on in other coordinates where those at hand come near a singularity.
    pub(crate) fn settle<S: System + ?Sized>(&mut self, system: &mut S) {
        let Self { q, v, a, s, .. } = self;
        if system.wrap(q, v, &mut [a, s]) {
            // What belongs to the old coordinates.
            self.corrector.forget_jacobian();
            self.a_old.copy_from_slice(&self.a);
        }
    }

    fn fixed_step<S: System + ?Sized>(&mut self, system: &mut S) -> Result<Option<Status>, Interrupted> {
        let (t_new, h, is_on_grid) = if self.has_corners {
            let times = (self.t, self.t_end);
            let step = self.grid.step_to_corner(self.fixed_steps, times, |cell| system.corner(cell));
            self.changes_size = !step.2 || self.t > self.grid.after(0);
            step
        } else {
            let (t_new, h) = self.grid.step(self.fixed_steps, self.t_end);
            (t_new, h, true)
        };
        let solved = if self.has_contact || system.facts().is_one_sided {
            self.step_into_contact(system, t_new, h)?
        } else {
            match self.whole_step(system, t_new, h)? {
                // Mechanisms that come near a singular position, such as a rope that cracks, may take shorter steps there.
                Err(failure) if self.a.len() > self.q.len() => {
                    self.halved_steps(system, t_new, Self::whole_step)?.map_err(|_| failure)
                }
                solved => solved,
            }
        };
        match solved {
            Ok(()) => {
                if is_on_grid {
                    self.grid.count();
                }
                Ok(None)
            }
            Err(failure) => Ok(Some(Status::StepFailed(failure))),
        }
    }

    fn whole_step<S: System + ?Sized>(
        &mut self,
        system: &mut S,
        t_new: f64,
        h: f64,
    ) -> Result<Result<(), Failure>, Interrupted> {
        let solved = self.attempt(system, t_new, h)?;
        if solved.is_ok() {
            self.accept(t_new, h);
        }
        Ok(solved)
    }

    /// A step at whose end surfaces may have met, or slack tendons become taut. Where it does not see the impact rise and fall,
    /// its end is stiff and its beginning is not: what the scheme remembers of the accelerations would throw the surfaces apart
    /// faster than they came (Acary 2015). Such steps, and those right after, are made without memory: in them surfaces that
    /// meet do not rebound.
    fn step_into_contact<S: System + ?Sized>(
        &mut self,
        system: &mut S,
        t_new: f64,
        h: f64,
    ) -> Result<Result<(), Failure>, Interrupted> {
        if self.unsettled == 0
            && self.attempt(system, t_new, h)?.is_ok()
            && !self.is_jolted(system, h)?
            && !self.is_flawed(system)?
        {
            self.follow_impact(system, h)?;
            self.accept(t_new, h);
            return Ok(Ok(()));
        }
        self.holding = None;
        if self.sound_step_without_memory(system, t_new, h)?.is_ok() {
            return Ok(Ok(()));
        }
        if self.halved_steps(system, t_new, Self::sound_step_without_memory)?.is_ok() {
            self.unsettled = self.unsettled.max(1);
            return Ok(Ok(()));
        }
        let solved = self.attempt_without_memory(system, t_new, h)?;
        if solved.is_ok() {
            // One that is flawed whatever its size says why.
            let Trial { t, q, .. } = &self.trial;
            if !system.is_flawed(*t, q)?
                && (system.have_passed(&[(self.t, &self.q), (*t, q)], Radius::Smaller)?
                    || self.gains_energy(system, h, Beside::All)?)
            {
                return Ok(Err(Failure::PassedThrough));
            }
            self.accept_without_memory(system, t_new, h)?;
        }
        Ok(solved)
    }

    /// Takes note of what the trial has lost where surfaces touch at one of its ends.
    fn follow_impact<S: System + ?Sized>(&mut self, system: &mut S, h: f64) -> Result<(), Interrupted> {
        if !self.touches && !self.will_touch {
            return Ok(());
        }
        let before = match self.holding.take() {
            Some(holding) => Some(holding),
            None => system.holding(self.t, [&self.q, &self.v, &self.a])?,
        };
        let Trial { t, q, v, a, .. } = &self.trial;
        let after = system.holding(*t, [q, v, a])?;
        if let (Some(before), Some(after)) = (&before, &after) {
            self.impacts.follow([before, after], h);
        }
        self.holding = after.filter(|_| self.will_touch);
        Ok(())
    }

    /// A step without memory, if its end is one that means something.
    fn sound_step_without_memory<S: System + ?Sized>(
        &mut self,
        system: &mut S,
        t_new: f64,
        h: f64,
    ) -> Result<Result<(), Failure>, Interrupted> {
        if let Err(failure) = self.attempt_without_memory(system, t_new, h)? {
            return Ok(Err(failure));
        }
        if self.is_flawed(system)? || self.gains_energy(system, h, Beside::All)? {
            return Ok(Err(Failure::NotConverged));
        }
        self.accept_without_memory(system, t_new, h)?;
        Ok(Ok(()))
    }

    fn accept_without_memory<S: System + ?Sized>(
        &mut self,
        system: &mut S,
        t_new: f64,
        h: f64,
    ) -> Result<(), Interrupted> {
        self.unsettled = match self.is_jolted(system, h)? {
            true if self.has_stopped => STEPS_AFTER_STOP,
            true => 1,
            false => self.unsettled.saturating_sub(1),
        };
        if system.is_touched() {
            let Trial { t, q, v, a, .. } = &self.trial;
            if let Some(impact) = system.impact(*t, [&self.q, &self.v], [q, v, a], h)? {
                self.impacts.count(*t, &impact);
            }
        } else {
            // Surfaces that let go have still pressed each other at its start.
            self.follow_impact(system, h)?;
        }
        self.settle_accelerations(system, h)?;
        self.forgets = true;
        self.accept(t_new, h);
        Ok(())
    }

    /// Steps of half the size, made by `part`, and of half of that where these cannot be made either: the shorter a step, the
    /// more what moves outweighs what presses. To the outside they are one step; where it fails the state is as before.
    /// Allocates.
    fn halved_steps<S: System + ?Sized>(
        &mut self,
        system: &mut S,
        t_new: f64,
        part: Part<S>,
    ) -> Result<Result<(), Failure>, Interrupted> {
        let start = (self.t, self.q.clone(), self.v.clone(), self.a.clone());
        let before = (self.t_old, self.q_old.clone(), self.v_old.clone(), self.a_old.clone());
        let (memory, unsettled) = ((self.s.clone(), self.h_of_s, self.guess), self.unsettled);
        let (touches, steps, impacts, rank) = (self.touches, self.counters.steps, self.impacts, self.rank);
        let changes_size = std::mem::replace(&mut self.changes_size, true);
        let solved = self.halves(system, t_new, MOST_HALVINGS, part);
        self.changes_size = changes_size;
        if matches!(solved, Ok(Ok(()))) {
            (self.t_old, self.q_old, self.v_old, self.a_old) = start;
        } else {
            (self.t, self.q, self.v, self.a) = start;
            (self.t_old, self.q_old, self.v_old, self.a_old) = before;
            ((self.s, self.h_of_s, self.guess), self.unsettled) = (memory, unsettled);
            (self.touches, self.forgets, self.counters.steps) = (touches, false, steps);
            (self.impacts, self.rank) = (impacts, rank);
        }
        self.corrector.forget_jacobian();
        solved
    }

    fn halves<S: System + ?Sized>(
        &mut self,
        system: &mut S,
        t_new: f64,
        halvings: usize,
        part: Part<S>,
    ) -> Result<Result<(), Failure>, Interrupted> {
        for end in [0.5 * (self.t + t_new), t_new] {
            self.corrector.forget_jacobian();
            let h = end - self.t;
            let Err(failure) = part(self, system, end, h)? else { continue };
            if halvings == 1 {
                return Ok(Err(failure));
            }
            if let Err(failure) = self.halves(system, end, halvings - 1, part)? {
                return Ok(Err(failure));
            }
        }
        Ok(Ok(()))
    }

    /// Whether the end of the trial means nothing, or surfaces have passed through each other on the way to it. Where they touch at
    /// that end they might have been pushed aside: then they must not pass on the way straight on either.
    fn is_flawed<S: System + ?Sized>(&mut self, system: &mut S) -> Result<bool, Interrupted> {
        let Self { trial: Trial { t, q, .. }, straight_on, .. } = self;
        let start = (self.t, &self.q[..]);
        if system.is_flawed(*t, q)? || system.have_passed(&[start, (*t, q)], Radius::Smaller)? {
            return Ok(true);
        }
        if !self.has_contact || !system.is_touched() {
            return Ok(false);
        }
        let h = *t - self.t;
        straight_on.clear();
        straight_on.extend(self.q.iter().zip(&self.v).map(|(q, v)| q + h * v));
        system.have_passed(&[start, (*t, straight_on)], Radius::Larger)
    }

    fn is_jolted<S: System + ?Sized>(&mut self, system: &mut S, h: f64) -> Result<bool, Interrupted> {
        let Trial { t, q, v, a, .. } = &self.trial;
        let (before, motion) = ([&self.q[..], &self.v[..]], [&q[..], &v[..], &a[..]]);
        let has_stopped = self.has_stopped && system.facts().is_one_sided;
        if !self.has_contact {
            return Ok(has_stopped);
        }
        let is_jolted = system.is_jolted(*t, before, motion, h)?;
        self.will_touch = system.is_touched();
        Ok(has_stopped || is_jolted || self.gains_energy(system, h, Beside::Motion)?)
    }

    /// Whether surfaces that touch at one of its ends, or did on the way to the solution of its equations, make the trial gain energy:
    /// bodies that have come too deep push each other out by another side than they entered, and Newton's method may leave a
    /// surface for a solution far away from it.
    fn gains_energy<S: System + ?Sized>(
        &mut self,
        system: &mut S,
        h: f64,
        beside: Beside,
    ) -> Result<bool, Interrupted> {
        if !self.has_contact || !(self.touches || self.has_touched || system.is_touched()) {
            return Ok(false);
        }
        let Trial { t, q, v, a, .. } = &self.trial;
        system.gains_energy(*t, [&self.q, &self.v], [q, v, a], h, beside)
    }

    fn adaptive_step<S: System + ?Sized>(&mut self, system: &mut S) -> Result<Option<Status>, Interrupted> {
        let (StepSize::Adaptive { max_step, min_step }, Some(estimate)) =
            (self.options.step_size, self.error_estimate)
        else {
            unreachable!("only adaptive steps have an error estimate");
        };
        let smallest = min_step.max(SMALLEST_STEP_IN_SPACINGS * (self.t.next_up() - self.t));
        let mut h = self.h;
        let mut rejected = false;
        let end = end_of_step(self.t, self.t_end, system.horizon(self.t));
        loop {
            if h < smallest {
                return Ok(Some(Status::StepTooSmall));
            }
            let is_last = self.t + h * (1.0 + ROUNDING_OF_STEPS) >= end;
            let t_new = if is_last { end } else { self.t + h };
            let step = t_new - self.t;
            self.rescale_memory(step);
            if self.attempt(system, t_new, step)?.is_err() {
                self.counters.unsolved += 1;
                h = CUT * step;
                rejected = true;
                continue;
            }
            let ends = Ends {
                q: [&self.q, &self.trial.q],
                v: [&self.v, &self.trial.v],
                a: [&self.a, &self.trial.a],
                s: &self.s_of_trial,
            };
            let error = estimate.error(step, &ends, &self.rtol, &self.atol);
            let factor = if error == 0.0 && !rejected {
                // That says nothing of what follows. Steps which something has shortened return to the first size.
                (self.options.dt / step).clamp(1.0, LARGEST_FACTOR)
            } else {
                estimate.factor(error, rejected)
            };
            let times = [self.t, t_new];
            if error <= 1.0
                && (system.have_met_stops(times, ends.q, ends.v, &mut self.straight_on)?
                    || self.has_contact
                        && (system
                            .have_passed(&[(self.t, &self.q), (t_new, &self.trial.q)], Radius::Smaller)?
                            || system.have_touched(times, ends.q, ends.v, &mut self.straight_on)?))
            {
                self.counters.rejected += 1;
                h = CUT * step;
                rejected = true;
                continue;
            }
            if error <= 1.0 {
                // The rest of the way says nothing about the size of the step after it.
                self.h = (if is_last { h.max(factor * step) } else { factor * h }).min(max_step);
                self.accept(t_new, step);
                return Ok(None);
            }
            self.counters.rejected += 1;
            h = factor * step;
            rejected = true;
        }
    }

    /// Algorithmic accelerations at the start of an adaptive step of size `h`. They are ahead of the true ones by a fraction of
    /// the step, which grows with it (Bruels and Arnold 2008). What else they differ by is left over from something that was not
    /// smooth, an impact: it is velocity still to come and alternates, so that it becomes smaller with a step of another
    /// size. Grown with the step it would be larger from step to step.
    fn rescale_memory(&mut self, h: f64) {
        let Some(stretch) = stretch(h, self.h_of_s) else {
            self.s_of_trial.iter_mut().zip(&self.a).for_each(|(s, a)| *s = *a);
            return;
        };
        let Self { scheme, a, a_old, s, s_of_trial, .. } = self;
        for (i, start) in s_of_trial.iter_mut().enumerate() {
            let smooth = scheme.shift() * (a[i] - a_old[i]);
            let rest = s[i] - a[i] - smooth;
            *start = a[i] + stretch * smooth + stretch.min(stretch.recip()) * rest;
        }
    }

    /// Solves the equations of motion at the end of a step of size `h`; the result is in `trial`.
    fn attempt<S: System + ?Sized>(
        &mut self,
        system: &mut S,
        t_new: f64,
        h: f64,
    ) -> Result<Result<(), Failure>, Interrupted> {
        let is_plain = self.scheme.is_plain();
        let memory = if is_plain { Some(1.0) } else { self.memory(system, t_new, h) };
        if self.step.made_for != (h, memory) {
            self.step = self.scheme.step(h, memory);
        }
        let Self { step, q, v, a, s, s_of_trial, trial, .. } = self;
        trial.weights = step.weights;
        let ends = trial.q_base.iter_mut().zip(&mut trial.v_base);
        let motion = q.iter().zip(v.iter().zip(&*a));
        if is_plain {
            let ([_, bq], [_, bv]) = (step.displacement, step.velocity);
            for ((q_base, v_base), (q, (v, a))) in ends.zip(motion) {
                *q_base = q + h * v + bq * a;
                *v_base = v + bv * a;
            }
        } else {
            let s = if s_of_trial.is_empty() { s } else { s_of_trial };
            for (((q_base, v_base), (q, (v, a))), s) in ends.zip(motion).zip(&*s) {
                *q_base = q + h * v + step.displacement[0] * a + step.displacement[1] * s;
                *v_base = v + step.velocity[0] * a + step.velocity[1] * s;
            }
        }
        self.trial.t = t_new;
        self.forgets = false;
        let solved = self.correct(system, h)?;
        // Without constraints there are no multipliers behind the accelerations.
        if self.a.len() == self.q.len() || solved.is_err() {
            return Ok(solved);
        }
        // A row that begins to hold has been open by what it did not hold before. Closed within one step this is a blow, whose
        // velocity would stay.
        let begins_to_hold = self.corrector.rank() > self.rank;
        if self.changes_size || begins_to_hold {
            // Velocities and accelerations of a step with constraints on displacements have errors normal to these, which cancel
            // while the step keeps its size. Divided by that of a shorter step they would grow the more it is shortened
            // (Arnold, Bruels and Cardona 2015).
            let Trial { t, q, v, a, .. } = &mut self.trial;
            self.forgets |= system.fit_to_constraints(*t, q, v, a, begins_to_hold)? && begins_to_hold;
        }
        Ok(solved)
    }

    /// What the step from here to `t_new` keeps of algorithmic accelerations ([`Scheme::step`]).
    fn memory<S: System + ?Sized>(&self, system: &S, t_new: f64, h: f64) -> Option<f64> {
        if !self.s_of_trial.is_empty() {
            // Those of an adaptive step are made for its size.
            return Some(1.0);
        }
        let stretch = stretch(h, self.h_of_s);
        if stretch.is_none() || !self.has_corners {
            return stretch;
        }
        let before = (self.t > self.t_old).then_some(self.t_old);
        memory(|cell| system.corner(cell), before, [self.t, t_new]).and(stretch)
    }

    /// The same by the backward Euler method: of order 1, and without memory of accelerations. What a step meets stops there.
    fn attempt_without_memory<S: System + ?Sized>(
        &mut self,
        system: &mut S,
        t_new: f64,
        h: f64,
    ) -> Result<Result<(), Failure>, Interrupted> {
        let trial = &mut self.trial;
        trial.t = t_new;
        trial.weights = [h * h, h, 1.0];
        for i in 0..self.q.len() {
            trial.q_base[i] = self.q[i] + h * self.v[i];
            trial.v_base[i] = self.v[i];
        }
        // Forces of contact are those of the end, and loads those of the middle: steps end at corners of these, between which
        // that is their mean.
        self.lags = self.has_corners && !system.facts().is_one_sided && system.lag_loads(0.5 * h);
        let solved = self.correct(system, h);
        if self.lags {
            system.lag_loads(0.0);
        }
        solved
    }

    /// Accelerations of the trial by the loads of its end, where those that led to it are by others.
    fn settle_accelerations<S: System + ?Sized>(
        &mut self,
        system: &mut S,
        h: f64,
    ) -> Result<(), Interrupted> {
        if !self.lags {
            return Ok(());
        }
        let Self { trial, corrector, guessed, counters, .. } = self;
        if trial.a.len() > trial.q.len() {
            let Trial { t, q, v, a, .. } = trial;
            guessed.copy_from_slice(a);
            if system.constrained_start(*t, q, v, a)?.is_err() {
                a.copy_from_slice(guessed);
            }
            return Ok(());
        }
        trial.weights = [0.0, 0.0, 1.0];
        trial.q_base.copy_from_slice(&trial.q);
        trial.v_base.copy_from_slice(&trial.v);
        guessed.copy_from_slice(&trial.a);
        corrector.forget_jacobian();
        if corrector.solve(system, trial, guessed, guessed, h, counters)?.is_err() {
            trial.set(guessed);
        }
        corrector.forget_jacobian();
        Ok(())
    }

    /// Solves the equations of motion for the accelerations of the trial.
    fn correct<S: System + ?Sized>(
        &mut self,
        system: &mut S,
        h: f64,
    ) -> Result<Result<(), Failure>, Interrupted> {
        match self.guess {
            Guess::Zero => {
                // Multipliers of a robot at rest are not zero: their full size would drown what accelerations are looked for.
                let n = self.q.len();
                self.guessed[..n].fill(0.0);
                self.guessed[n..].copy_from_slice(&self.a[n..]);
            }
            Guess::Last => self.guessed.copy_from_slice(&self.a),
            Guess::Extrapolated => {
                let ratio = h / (self.t - self.t_old);
                for i in 0..self.a.len() {
                    self.guessed[i] = self.a[i] + ratio * (self.a[i] - self.a_old[i]);
                }
            }
        }
        if self.has_contact {
            system.take_touched();
        }
        let solved = if system.facts().is_one_sided {
            self.correct_one_sided(system, h)
        } else {
            let Self { corrector, trial, guessed, a, counters, .. } = self;
            corrector.solve(system, trial, guessed, a, h, counters)
        };
        self.has_touched = self.has_contact && system.take_touched();
        solved
    }

    /// The same with constraints that hold one way only: those that held at the start of the step, until the end says
    /// otherwise.
    fn correct_one_sided<S: System + ?Sized>(
        &mut self,
        system: &mut S,
        h: f64,
    ) -> Result<Result<(), Failure>, Interrupted> {
        let Self { a, guessed, trial, corrector, counters, .. } = self;
        let n = self.q.len();
        system.release(&a[n..]);
        self.has_stopped = false;
        // What does not hold keeps the multiplier that it starts from.
        for (guess, last) in guessed[n..].iter_mut().zip(&a[n..]) {
            *guess = if *last == 0.0 { 0.0 } else { *guess };
        }
        for _ in 0..most_switches(system.facts().constraints()) {
            if let Err(failure) = corrector.solve(system, trial, guessed, a, h, counters)? {
                return Ok(Err(failure));
            }
            let switch = system.switch(trial.t, &trial.q, &mut trial.a[n..])?;
            if switch == Switch::Nothing {
                return Ok(Ok(()));
            }
            self.has_stopped |= switch == Switch::TakenUp;
            guessed.copy_from_slice(&trial.a);
            corrector.forget_jacobian();
        }
        Ok(Err(Failure::NotConverged))
    }

    /// Takes the trial as the new state.
    fn accept(&mut self, t_new: f64, h: f64) {
        self.touches = self.will_touch;
        self.rank = self.corrector.rank();
        if self.options.predictor == Predictor::Best {
            self.guess = self.best_guess(h);
        }
        if std::mem::take(&mut self.forgets) {
            let n = self.q.len();
            self.s.copy_from_slice(&self.trial.a[..n]);
            self.h_of_s = h;
        } else if !self.scheme.is_plain() {
            if !self.s_of_trial.is_empty() {
                self.s.copy_from_slice(&self.s_of_trial);
            }
            let Self { step: Step { rest, gain, .. }, s, a, trial, .. } = self;
            for (i, s) in s.iter_mut().enumerate() {
                *s = *gain * trial.a[i] + rest[0] * a[i] + rest[1] * *s;
            }
            self.h_of_s = h;
        }
        self.t_old = self.t;
        self.t = t_new;
        std::mem::swap(&mut self.q_old, &mut self.q);
        std::mem::swap(&mut self.v_old, &mut self.v);
        std::mem::swap(&mut self.a_old, &mut self.a);
        std::mem::swap(&mut self.q, &mut self.trial.q);
        std::mem::swap(&mut self.v, &mut self.trial.v);
        std::mem::swap(&mut self.a, &mut self.trial.a);
        self.counters.steps += 1;
    }

    /// The guess that would have been nearest to the accelerations of the step that ends in the trial.
    fn best_guess(&self, h: f64) -> Guess {
        // Before the first step there is nothing to extrapolate from.
        let ratio = if self.t > self.t_old { h / (self.t - self.t_old) } else { 0.0 };
        let (mut zero, mut last, mut extrapolated) = (0.0, 0.0, 0.0);
        let weights = self.corrector.inverse_tolerances();
        let found = weights.iter().zip(&self.trial.a);
        for ((weight, found), (a, a_old)) in found.zip(self.a.iter().zip(&self.a_old)) {
            let change = found - a;
            let surprise = change - ratio * (a - a_old);
            zero += (weight * found) * (weight * found);
            last += (weight * change) * (weight * change);
            extrapolated += (weight * surprise) * (weight * surprise);
        }
        // Those of surfaces that press against each other are not zero, but the ones of an impact do not go on.
        let zero = if self.has_contact && !self.forgets { f64::INFINITY } else { zero };
        if extrapolated < last && extrapolated < zero {
            Guess::Extrapolated
        } else if last <= zero {
            Guess::Last
        } else {
            Guess::Zero
        }
    }

    /// Goes on to a later end, whatever the status was. Steps of fixed size are as many as it takes, all of one size: `dt`
    /// where that divides the way.
    pub(crate) fn go_on(&mut self, t_end: f64) {
        (self.status, self.t_end) = (None, t_end);
        if self.error_estimate.is_none() {
            self.fixed_steps = self.grid.set_out(self.t, t_end, self.options.dt);
        }
    }

    /// Takes these accelerations for the current ones: what acts has jumped.
    pub(crate) fn jump(&mut self, a: &[f64]) {
        self.holding = None;
        for (i, (new, old)) in a.iter().zip(&mut self.a).enumerate() {
            // Those of the method, and those before, are ahead and behind by as much as without.
            self.s[i] += new - *old;
            self.a_old[i] += new - *old;
            *old = *new;
        }
        self.corrector.doubt_jacobian();
    }

    /// Goes on from this state: velocities have jumped. `a` are accelerations, and multipliers behind them.
    pub(crate) fn restart(&mut self, [q, v, a]: [&[f64]; 3]) {
        self.holding = None;
        self.q.copy_from_slice(q);
        self.v.copy_from_slice(v);
        self.a.copy_from_slice(a);
        self.a_old.copy_from_slice(a);
        self.s.copy_from_slice(&a[..q.len()]);
        // The accelerations before say nothing of those after.
        self.h_of_s = 0.0;
        self.corrector.doubt_jacobian();
    }

    /// What goes on from step to step.
    pub(crate) fn carry<S: System + ?Sized>(&mut self, system: &S, tape: &mut Tape<'_>) {
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
        tape.below(guesses.len(), &mut guess);
        self.guess = guesses[guess];
        self.grid.carry(tape);
        self.counters.carry(tape);
        tape.below(STEPS_AFTER_STOP + 1, &mut self.unsettled);
        tape.flag(&mut self.touches);
        self.impacts.carry(tape);
        tape.count(&mut self.rank);
        tape.flag(&mut self.started);
        self.corrector.carry(system, tape);
    }

    /// Current time.
    pub fn t(&self) -> f64 {
        self.t
    }

    /// Current displacements.
    pub fn q(&self) -> &[f64] {
        &self.q
    }

    /// Current velocities.
    pub fn v(&self) -> &[f64] {
        &self.v
    }

    /// Current accelerations, which satisfy the equations of motion.
    pub fn a(&self) -> &[f64] {
        &self.a[..self.q.len()]
    }

    /// These, and the multipliers of constraints behind them.
    pub(crate) fn unknowns(&self) -> &[f64] {
        &self.a
    }

    /// Time before the last step; the start if no step was made.
    pub fn t_old(&self) -> f64 {
        self.t_old
    }

    /// End of the interval.
    pub fn t_end(&self) -> f64 {
        self.t_end
    }

    /// Cost of the integration so far.
    pub fn counters(&self) -> Counters {
        self.counters
    }

    /// `None` while the integration is running.
    pub fn status(&self) -> Option<Status> {
        self.status
    }

    /// Why the motion so far may be wrong although all steps were made: impacts that these do not resolve.
    pub fn doubt(&self) -> Option<String> {
        self.impacts.doubt(self.options.dt)
    }

    /// The scheme of steps of one size.
    pub(crate) fn fixed_scheme(&self) -> Option<Scheme> {
        self.error_estimate.is_none().then_some(self.scheme)
    }

    /// Number of steps of fixed size that the interval takes; saturates.
    pub(super) fn fixed_steps(&self) -> usize {
        self.fixed_steps
    }

    /// State at a time within the last step, by cubic Hermite interpolation of displacements and of
    /// velocities and by linear interpolation of accelerations. At the ends of the step, the result is bit
    /// for bit the state there.
    pub fn interpolate(&self, t: f64, q: &mut [f64], v: &mut [f64], a: &mut [f64]) {
        let h = self.t - self.t_old;
        let x = if t == self.t { 1.0 } else { (t - self.t_old) / h };
        if x == 0.0 || x == 1.0 {
            let state =
                if x == 0.0 { [&self.q_old, &self.v_old, &self.a_old] } else { [&self.q, &self.v, &self.a] };
            q.copy_from_slice(state[0]);
            v.copy_from_slice(state[1]);
            // Multipliers stand behind accelerations.
            a.copy_from_slice(&state[2][..a.len()]);
            return;
        }
        for i in 0..q.len() {
            q[i] = cubic(x, h, [self.q_old[i], self.q[i]], [self.v_old[i], self.v[i]]);
            v[i] = cubic(x, h, [self.v_old[i], self.v[i]], [self.a_old[i], self.a[i]]);
            a[i] = self.a_old[i] + x * (self.a[i] - self.a_old[i]);
        }
    }

    /// What a step did that could not be solved, and what helps.
    fn unsolved(&self) -> (&'static str, &'static str) {
        if self.has_touched {
            return (
                ", in which surfaces touch",
                "Take a `dt` that is shorter than the impact, or give the contact less `stiffness`; adaptive steps and \
                 `method=\"radau\"` find the step size themselves.",
            );
        }
        if self.has_stopped {
            return (
                ", in which a tendon that does not stretch becomes taut",
                "Take a smaller `dt`, change the tendon's `length` more slowly, or give it a `stiffness`.",
            );
        }
        if self.a.len() > self.q.len() {
            return (
                ", with closed loops or tendons that do not stretch",
                "Take a smaller `dt`. If that ends at the same place, the mechanism cannot go on there: look at the last state, \
                 whose loops may lock or conflict with each other.",
            );
        }
        if self.rtol.iter().any(|&rtol| rtol < TIGHT) {
            return ("", "Loosen `rtol`, which rounding may not let it reach, or reduce `dt`.");
        }
        ("", "Reduce `dt` or use adaptive steps.")
    }

    /// Describes a status of this integration, with advice unless it is a success.
    pub fn explain(&self, status: Status) -> String {
        let [t, t_end, h] = [self.t, self.t_end, self.options.dt].map(Number);
        let limit = self.scheme.stability_limit();
        match status {
            Status::Finished => "The end of the interval was reached.".to_owned(),
            Status::NoInitialAcceleration(Failure::SingularJacobian) => format!(
                "The accelerations at t = {t} could not be found: the mass matrix (the derivative of the residual with \
                 respect to them) is singular at the start. Change the initial state, give every coordinate a mass, or \
                 give the accelerations (`a0` of `newmark`)."
            ),
            Status::NoInitialAcceleration(Failure::NonFinite) => format!(
                "The accelerations at t = {t} could not be found: the residual or its derivative is NaN or infinite at \
                 the initial state. Check the equations of motion there."
            ),
            Status::NoInitialAcceleration(Failure::NotConverged | Failure::PassedThrough) => format!(
                "The accelerations at t = {t} could not be found: Newton's method did not converge from zero. Check the \
                 Jacobian, loosen `atol` or `rtol`, or give the accelerations (`a0` of `newmark`)."
            ),
            Status::StepFailed(Failure::NotConverged) => {
                let (doing, cure) = self.unsolved();
                format!(
                    "Newton's method did not converge in the step from t = {t} (step size {h}){doing}; the result ends there. {cure}"
                )
            }
            Status::StepFailed(Failure::SingularJacobian) => format!(
                "The Jacobian of the step from t = {t} (step size {h}) is singular; the result ends there. Change `dt` or \
                 use adaptive steps; if that does not help the equations of motion do not determine the accelerations."
            ),
            Status::StepFailed(Failure::NonFinite) if limit.is_finite() => format!(
                "The residual became NaN or infinite in the step from t = {t} (step size {h}); the result ends there. This \
                 scheme is stable only for step sizes below {limit:.4} / (largest natural frequency in rad/s): reduce `dt` \
                 or use average acceleration."
            ),
            Status::StepFailed(Failure::NonFinite) => format!(
                "The residual or its Jacobian became NaN or infinite in the step from t = {t} (step size {h}); the result \
                 ends there. Reduce `dt` or use adaptive steps, and check the equations of motion near the last state."
            ),
            Status::StepFailed(Failure::PassedThrough) => format!(
                "Surfaces pass through each other, or come so deep that they push each other out by another side, in the step from \
                 t = {t} (step size {h}), in parts of it as well; the result ends there. Give the contact more `stiffness`, or \
                 reduce `dt`."
            ),
            Status::StepTooSmall => format!(
                "The step size fell below its limit at t = {t} after {} rejected and {} unsolved steps: loosen `rtol` and \
                 `atol`, reduce `min_step`, or check the equations of motion there for a singularity.",
                self.counters.rejected, self.counters.unsolved
            ),
            Status::TooManySteps => format!(
                "The limit of {} steps was reached at t = {t}, before the end of the interval, {t_end}: increase \
                 `max_steps`, or take larger steps.",
                self.options.max_steps
            ),
            Status::Interrupted => format!("The integration was stopped at t = {t}, as asked for."),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrators::newmark::Parameters;
    use crate::integrators::second_order::FreeMotion;
    use crate::model::pendulum::SpringPendulum;

    /// Advice about a step that could not be solved is for what it did.
    #[test]
    fn advice_is_for_what_the_step_did() {
        let options = Options::new(0.1);
        let mut stepper = Stepper::new(1, (0.0, 1.0), &[0.0], &[0.0], &options).unwrap();
        let told = |stepper: &Stepper| stepper.explain(Status::StepFailed(Failure::NotConverged));
        let plain = told(&stepper);
        assert!(plain.ends_with("the result ends there. Reduce `dt` or use adaptive steps."), "{plain}");
        assert!(["contact", "tendon", "loop"].iter().all(|other| !plain.contains(other)), "{plain}");
        stepper.rtol[0] = 1e-14;
        assert!(told(&stepper).contains("Loosen `rtol`"));
        stepper.a.push(0.0);
        assert!(told(&stepper).contains("with closed loops or tendons that do not stretch"));
        stepper.has_stopped = true;
        assert!(told(&stepper).contains("becomes taut; the result ends there. Take a smaller `dt`, change"));
        stepper.has_touched = true;
        assert!(
            told(&stepper)
                .contains("in which surfaces touch; the result ends there. Take a `dt` that is shorter")
        );
    }

    /// A change of the step must not cost the methods with algorithmic accelerations their order.
    #[test]
    fn order_two_with_steps_that_change_all_the_time() {
        let mut pendulum = SpringPendulum::new(1.0, 1.0, 10.0, 9.81).unwrap();
        let mut angle_at_one = |scheme: Scheme, h: f64| {
            let options = Options { scheme, rtol: 1e-12.into(), ..Options::new(h) };
            let mut stepper = Stepper::new(2, (0.0, 1.0), &[-0.7, 0.5], &[0.0, 0.0], &options).unwrap();
            let mut system = FreeMotion(&mut pendulum);
            stepper.start(&mut system).unwrap();
            for k in 0.. {
                let step = if k % 3 == 0 { 0.25 * h } else { h };
                let is_last = stepper.t() + step * (1.0 + ROUNDING_OF_STEPS) >= 1.0;
                let t_new = if is_last { 1.0 } else { stepper.t() + step };
                let step = t_new - stepper.t();
                stepper.attempt(&mut system, t_new, step).unwrap().unwrap();
                stepper.accept(t_new, step);
                if is_last {
                    break;
                }
            }
            stepper.q()[0]
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
