//! One trial step: its equations, their solution and its projection onto constraints.

use super::super::corrector::Origin;
use super::super::error_estimate::LARGEST_FACTOR;
use super::super::numbers::Numbers;
use super::super::options::Predictor;
use super::super::scheme::{SLOWED, Step, memory, stretch};
use super::super::trial::Trial;
use super::{Guess, Lengths, StepperOf};
use crate::error::Interrupted;
use crate::integrators::Retries;
use crate::integrators::attempts::{Ends, Stepper, Unilateral};
use crate::integrators::second_order::{
    Failure, SecondOrderSystem, Solved, constrained_start, model_at, model_of,
};
use crate::model::constraint::projection;
use crate::model::{Excitation, OneSided};
use crate::numerics::linalg::Matrix;

/// Largest correction of velocities, in typical sizes of the coordinates per second, that can be an error of a step. Larger ones are due
/// to a jump of a commanded tendon length at its end or within it, which the rate of the function does not show.
const JUMP_CORRECTION: f64 = 10.0;

/// A quasi-static step has snapped if it moves a coordinate by more than this part of its size, and faster than the neighbouring steps by
/// the second factor.
const SNAP_DISPLACEMENT: f64 = 1e-2;
const SNAP_SPEED: f64 = 10.0;

/// Stiffnesses below this part of those of single coordinates count as zero.
const ZERO_STIFFNESS: f64 = 1e-8;

impl<V: Numbers> StepperOf<V> {
    /// Solves the equations of motion at the end of a step of size `h`; the result is in `trial`.
    pub(super) fn attempt<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        t_new: f64,
        h: f64,
    ) -> Solved {
        if !V::IS_PLAIN && !self.scheme.has_inertia() {
            return self.attempt_without_inertia(system, t_new, h);
        }
        // What jumps at the start belongs to the start. What one of both steps cannot solve, the other one may.
        if self.is_after_jump && self.counters.steps > 0 && self.attempt_after_jump(system, t_new, h)?.is_ok()
        {
            return Ok(Ok(()));
        }
        let is_plain = self.scheme.is_plain();
        let memory = if is_plain { Some(1.0) } else { self.memory(system, t_new, h) };
        if self.step.made_for != (h, memory) {
            self.step = self.scheme.step(h, memory);
        }
        let Self { step, q, v, a, s, s_of_trial, adapts_memory, trial, .. } = self;
        trial.weights = step.weights;
        let ends = trial.q_base.iter_mut().zip(trial.v_base.iter_mut());
        let motion = q.iter().zip(v.iter().zip(a.iter()));
        if is_plain {
            let ([_, bq], [_, bv]) = (step.displacement, step.velocity);
            for ((q_base, v_base), (q, (v, a))) in ends.zip(motion) {
                *q_base = q + h * v + bq * a;
                *v_base = v + bv * a;
            }
        } else {
            let s = if *adapts_memory { s_of_trial } else { s };
            for (((q_base, v_base), (q, (v, a))), s) in ends.zip(motion).zip(s.iter()) {
                *q_base = q + h * v + step.displacement[0] * a + step.displacement[1] * s;
                *v_base = v + step.velocity[0] * a + step.velocity[1] * s;
            }
        }
        self.trial.t = t_new;
        self.size = h;
        (self.forgets, self.lags, self.has_stages) = (false, false, false);
        let solved = self.correct(system, h)?;
        if solved.is_err() && self.is_after_jump && self.counters.steps == 0 {
            return self.attempt_after_jump(system, t_new, h);
        }
        // Without constraints there are no multipliers behind the accelerations.
        if V::IS_PLAIN || self.a.len() == self.q.len() || solved.is_err() {
            return Ok(solved);
        }
        // A constraint row that becomes independent has a gap from earlier steps. Closing it within one step is an impulse, whose velocity
        // would remain.
        let begins_to_hold = self.corrector.rank() > self.rank;
        // With constraints on displacements, velocities and accelerations of a step have errors normal to the constraints, which cancel
        // while the step size is constant but grow when steps are shortened (Arnold, Bruels and Cardona 2015). Locating where tendons
        // become slack or taut also requires velocities that satisfy the constraints.
        if self.changes_size || begins_to_hold || self.ends_at_changes() {
            self.forgets |= self.fit_to_constraints(system, begins_to_hold)? && begins_to_hold;
        }
        Ok(solved)
    }

    /// The same for quasi-static motion: the velocity at the end is the change of the shape over the step, and accelerations are zero.
    fn attempt_without_inertia<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        t_new: f64,
        h: f64,
    ) -> Solved {
        self.begin_without_inertia(system, t_new, h);
        self.correct(system, h)
    }

    /// The same, to the equilibrium downhill. Not of models with loops.
    pub(super) fn attempt_downhill<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        t_new: f64,
        h: f64,
    ) -> Solved {
        if self.a.len() > self.q.len() {
            return Ok(Err(Failure::NotConverged));
        }
        self.begin_without_inertia(system, t_new, h);
        let Self { corrector, trial, t, q, v, a, counters, .. } = self;
        corrector.go_downhill(system, trial, Origin { t: *t, q, v }, a, h, counters)
    }

    fn begin_without_inertia<S: SecondOrderSystem + ?Sized>(&mut self, system: &mut S, t_new: f64, h: f64) {
        // Rates of prescribed motions are means over the step, like those of the coordinates.
        model_of(system).mean_rates_over(h);
        let trial = &mut self.trial;
        trial.t = t_new;
        self.size = h;
        trial.weights = [h * h, h, 0.0];
        trial.q_base.copy_from_slice(&self.q);
        trial.v_base.iter_mut().for_each(|v| *v = 0.0);
    }

    /// Memory of algorithmic accelerations of the step from here to `t_new` ([`Scheme::step`]).
    fn memory<S: SecondOrderSystem + ?Sized>(&self, system: &mut S, t_new: f64, h: f64) -> Option<f64> {
        if self.adapts_memory {
            // `rescale_memory` has scaled those of an adaptive step.
            return Some(1.0);
        }
        let stretch = stretch(h, self.h_of_s);
        if V::IS_PLAIN || stretch.is_none() || !self.has_corners {
            return stretch;
        }
        let before = (self.t > self.t_old).then_some(self.t_old);
        let corner = |cell| system.model().and_then(|model| model.corner(cell));
        memory(corner, before, [self.t, t_new]).and(stretch)
    }

    /// The same by the backward Euler method: of order 1, without memory of accelerations, and with inelastic impacts.
    pub(super) fn attempt_without_memory<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        t_new: f64,
        h: f64,
    ) -> Solved {
        let trial = &mut self.trial;
        trial.t = t_new;
        self.size = h;
        (self.forgets, self.has_stages) = (true, false);
        if !self.scheme.has_inertia() {
            model_of(system).mean_rates_over(h);
        }
        trial.weights = [h * h, h, if self.scheme.has_inertia() { 1.0 } else { SLOWED.recip() }];
        for i in 0..self.q.len() {
            trial.q_base[i] = self.q[i] + h * self.v[i];
            trial.v_base[i] = self.v[i];
        }
        // Contact forces are those at the end, loads those at the middle of the step, their mean: steps end at corners of loads.
        self.lags = self.has_corners && !system.facts().is_one_sided && model_of(system).lag_loads(0.5 * h);
        let solved = self.correct(system, h);
        if self.lags {
            model_of(system).lag_loads(0.0);
        }
        let solved = solved?;
        if solved.is_ok() && self.ends_at_changes() {
            self.fit_to_constraints(system, false)?;
        }
        Ok(solved)
    }

    /// Whether steps end where inextensible tendons become slack or taut.
    fn ends_at_changes(&self) -> bool {
        self.is_one_sided && self.lengths == Lengths::Smooth
    }

    /// Projects velocities of the trial onto the constraints in the metric of the mass matrix, and sets accelerations and multipliers to
    /// those of that state. Returns whether it succeeded; near singular positions it changes nothing, unless `even_singular`.
    /// Allocates.
    fn fit_to_constraints<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        even_singular: bool,
    ) -> Result<bool, Interrupted> {
        let Trial { t, q, v, a, .. } = &mut self.trial;
        // At a corner of a commanded length, this step uses the command before it.
        let before = if self.is_one_sided { t.next_down() } else { *t };
        let (mut fitted, mut found) = (v.to_vec(), a.to_vec());
        let mut fit = projection::fit_motion(model_at(system, before)?, q, &mut fitted, &mut found);
        if before != *t && !fit.as_ref().is_ok_and(|fit| fit.largest <= JUMP_CORRECTION) {
            fitted.copy_from_slice(v);
            fit = projection::fit_motion(model_at(system, *t)?, q, &mut fitted, &mut found);
        }
        let is_regular = fit.is_ok_and(|fit| even_singular || !fit.is_nearly_singular());
        if !is_regular || !fitted.iter().chain(&found).all(|x| x.is_finite()) {
            return Ok(false);
        }
        v.copy_from_slice(&fitted);
        a.copy_from_slice(&found);
        Ok(true)
    }

    /// Recomputes the accelerations of the trial with the loads of its end, if it was solved with lagged loads.
    fn recompute_accelerations<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
    ) -> Result<(), Interrupted> {
        let h = self.size;
        let Self { trial, corrector, guessed, counters, .. } = self;
        if trial.a.len() > trial.q.len() {
            let Trial { t, q, v, a, .. } = trial;
            guessed.copy_from_slice(a);
            if constrained_start(model_of(system), *t, q, v, a)?.is_err() {
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
    fn correct<S: SecondOrderSystem + ?Sized>(&mut self, system: &mut S, h: f64) -> Solved {
        match self.guess {
            _ if !V::IS_PLAIN && self.trial.weights[2] == 0.0 => {
                // Constant velocity of the shape.
                let n = self.q.len();
                self.guessed[n..].copy_from_slice(&self.a[n..]);
                for (guess, v) in self.guessed.iter_mut().zip(self.v.iter()) {
                    *guess = v / h;
                }
            }
            Guess::Zero => {
                // Multipliers of a robot at rest are not zero: starting from zero, their size would hide the accelerations.
                let n = self.q.len();
                self.guessed[..n].fill(0.0);
                self.guessed[n..].copy_from_slice(&self.a[n..]);
            }
            // A step much longer than the last one, as after a steep edge, would extrapolate the slope of that edge.
            Guess::Extrapolated if h <= LARGEST_FACTOR * (self.t - self.t_old) => {
                let ratio = h / (self.t - self.t_old);
                for i in 0..self.a.len() {
                    self.guessed[i] = self.a[i] + ratio * (self.a[i] - self.a_old[i]);
                }
            }
            Guess::Last | Guess::Extrapolated => self.guessed.copy_from_slice(&self.a),
        }
        let n = self.q.len();
        if !V::IS_PLAIN && self.is_one_sided {
            // Inactive constraints keep their initial multipliers.
            let guesses = self.guessed[n..].iter_mut().zip(model_of(system).active());
            guesses.filter(|(_, is_held)| !is_held).for_each(|(guess, _)| *guess = 0.0);
        }
        let Self { corrector, trial, guessed, a, counters, .. } = self;
        let solved = corrector.solve(system, trial, guessed, a, h, counters);
        if !V::IS_PLAIN && self.is_one_sided {
            self.pulls.copy_from_slice(&self.trial.a[n..]);
        }
        solved
    }

    /// Whether a quasi-static trial is a stable equilibrium within its step: no direction has a negative stiffness, including damping and
    /// friction by the velocities of the step. Models with loops and directions without stiffness count as stable. Allocates.
    fn is_stable<S: SecondOrderSystem + ?Sized>(&self, system: &mut S) -> Result<bool, Interrupted> {
        let (Trial { t, q, v, weights, .. }, n) = (&self.trial, self.q.len());
        if self.a.len() > n || weights[2] != 0.0 {
            return Ok(true);
        }
        let mut tangent = Matrix::zeros(n, n);
        system.tangent(*t, q, v, &self.trial.a, *weights, &mut tangent)?;
        // Scaled to ones on the diagonal, with a shift slightly above rounding.
        let scale: Vec<f64> =
            (0..n).map(|k| tangent[(k, k)].abs().max(f64::MIN_POSITIVE).sqrt().recip()).collect();
        let scaled = Matrix::from_fn(n, n, |i, j| {
            0.5 * (tangent[(i, j)] + tangent[(j, i)]) * scale[i] * scale[j]
                + if i == j { ZERO_STIFFNESS } else { 0.0 }
        });
        if scaled.clone().cholesky().is_some() {
            return Ok(true);
        }
        // Follower loads and friction are not symmetric: real eigenvalues decide.
        let own = Matrix::from_fn(n, n, |i, j| tangent[(i, j)] * scale[i] * scale[j]);
        Ok(own.complex_eigenvalues().iter().all(|value| value.re > -ZERO_STIFFNESS))
    }

    /// For quasi-static motion: records a step before the trial that was far faster than its neighbours.
    fn detect_snap(&mut self, sizes: &[f64]) {
        let fraction = |(x, size): (&f64, &f64)| if *size > 0.0 { (x / size).abs() } else { x.abs() };
        let speed = self.trial.v.iter().zip(sizes).map(fraction).fold(0.0, f64::max);
        let [before, last] = self.speeds;
        let moved = last * (self.t - self.t_old);
        if moved > SNAP_DISPLACEMENT && last > SNAP_SPEED * before.max(speed) {
            self.unilateral.record_snap(self.t);
        }
        self.speeds = [last, speed];
    }

    /// The guess that would have been closest to the accelerations of the trial.
    fn best_guess(&self, h: f64) -> Guess {
        // Before the first step there is nothing to extrapolate.
        let ratio = if self.t > self.t_old { h / (self.t - self.t_old) } else { 0.0 };
        let (mut zero, mut last, mut extrapolated) = (0.0, 0.0, 0.0);
        let weights = self.corrector.inverse_tolerances();
        let found = weights.iter().zip(self.trial.a.iter());
        for ((weight, found), (a, a_old)) in found.zip(self.a.iter().zip(self.a_old.iter())) {
            let change = found - a;
            let surprise = change - ratio * (a - a_old);
            zero += (weight * found) * (weight * found);
            last += (weight * change) * (weight * change);
            extrapolated += (weight * surprise) * (weight * surprise);
        }
        // With contacts zero is a poor guess, except after a step without memory, whose accelerations do not continue.
        let zero = if self.has_contact && !self.forgets { f64::INFINITY } else { zero };
        if extrapolated < last && extrapolated < zero {
            Guess::Extrapolated
        } else if last <= zero {
            Guess::Last
        } else {
            Guess::Zero
        }
    }
}

impl<V: Numbers> Stepper for StepperOf<V> {
    fn tried(&mut self) -> (Ends<'_>, &mut Unilateral) {
        let Self { t, q, v, a, trial, size, unilateral, .. } = self;
        let ends = Ends { t: [*t, trial.t], h: *size, q: [q, &trial.q], v: [v, &trial.v], a: [a, &trial.a] };
        (ends, unilateral)
    }

    fn retries(&mut self) -> &mut Retries {
        &mut self.retries
    }

    fn accept<S: SecondOrderSystem + ?Sized>(&mut self, system: &mut S) -> Result<(), Interrupted> {
        if !V::IS_PLAIN && self.lags {
            self.recompute_accelerations(system)?;
        }
        let h = self.size;
        if !V::IS_PLAIN && !self.scheme.has_inertia() {
            let n = self.q.len();
            self.trial.a[..n].fill(0.0);
            self.detect_snap(&system.facts().typical_coordinates);
            let is_stable = self.is_stable(system)?;
            self.unilateral.record_stability(self.trial.t, is_stable);
        }
        self.rank = self.corrector.rank();
        if self.options.predictor == Predictor::Best {
            // Accelerations do not continue those at a jump.
            self.guess = if self.is_after_jump { Guess::Last } else { self.best_guess(h) };
        }
        self.is_after_jump = false;
        let forgets = std::mem::take(&mut self.forgets);
        if forgets && self.has_stages {
            self.begin_memory();
        } else if forgets {
            let n = self.q.len();
            self.s.copy_from_slice(&self.trial.a[..n]);
            self.h_of_s = h;
        } else if !self.scheme.is_plain() {
            if self.adapts_memory {
                self.s.copy_from_slice(&self.s_of_trial);
            }
            let Self { step: Step { rest, gain, .. }, s, a, trial, .. } = self;
            for (i, s) in s.iter_mut().enumerate() {
                *s = *gain * trial.a[i] + rest[0] * a[i] + rest[1] * *s;
            }
            self.h_of_s = h;
        }
        self.t_old = self.t;
        self.t = self.trial.t;
        std::mem::swap(&mut self.q_old, &mut self.q);
        std::mem::swap(&mut self.v_old, &mut self.v);
        std::mem::swap(&mut self.a_old, &mut self.a);
        std::mem::swap(&mut self.q, &mut self.trial.q);
        std::mem::swap(&mut self.v, &mut self.trial.v);
        std::mem::swap(&mut self.a, &mut self.trial.a);
        self.counters.steps += 1;
        Ok(())
    }
}
