//! The step after a jump of forces or velocities.
//!
//! At the jump, accelerations are no measure of the motion: what is stiffly damped loses its part of the jump long before the end of
//! the step, and what vibrates fast returns many times. Members of the family that start from these accelerations let both alternate
//! from step to step, hardly damped, and turn their products with the slow motion into errors of it. The step after a jump is therefore one
//! of the singly diagonally implicit Runge-Kutta method of two stages and order 2 (Alexander 1977), which uses no accelerations at
//! its start, and leaves nothing of what is infinitely fast.

use super::super::numbers::Numbers;
use super::StepperOf;
use crate::integrators::newmark::scheme::FIRST_STAGE;
use crate::integrators::second_order::{Failure, SecondOrderSystem, Solved};
use crate::model::Dynamics;

impl<V: Numbers> StepperOf<V> {
    /// Forces have jumped, and with them accelerations to these: remembers whether the next step is to be one of two stages.
    pub(super) fn expect_jump(&mut self, a: &[f64]) {
        let is_held = !V::IS_PLAIN && (self.a.len() > self.q.len() || self.unilateral.touches());
        let h = if self.t < self.t_end {
            self.grid.step(self.fixed_steps, self.t_end).1
        } else {
            self.options.dt
        };
        self.is_after_jump = self.error_estimate.is_none()
            && !is_held
            && self.scheme.bridges_jump([&self.a, a], self.corrector.sizes(), h);
    }

    /// Goes on by the scheme after a jump.
    pub(super) fn ignore_jump(&mut self) {
        self.is_after_jump = false;
        self.a_old.copy_from_slice(&self.a);
    }

    /// Algorithmic accelerations begin anew at the end of a step of two stages.
    pub(super) fn begin_memory(&mut self) {
        let [of_first, of_end] = self.scheme.after_stages();
        // The guess of the last solve is the first stage.
        let stages = self.guessed.iter().zip(self.trial.a.iter());
        for (s, (first, end)) in self.s.iter_mut().zip(stages) {
            *s = of_first * first + of_end * end;
        }
        self.h_of_s = self.size;
    }

    /// Solves the equations of the two stages of a step of size `h` after a jump; the result is in `trial`.
    pub(super) fn attempt_after_jump<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        t_new: f64,
        h: f64,
    ) -> Solved {
        let stage = FIRST_STAGE * h;
        let rest = h - stage;
        let Self { t, q, v, a_old, trial, guessed, corrector, counters, .. } = self;
        trial.weights = [stage * stage, stage, 1.0];
        trial.t = *t + stage;
        for i in 0..q.len() {
            trial.q_base[i] = q[i] + stage * v[i];
            trial.v_base[i] = v[i];
        }
        guessed.copy_from_slice(a_old);
        if let Err(failure) = corrector.solve(system, trial, guessed, a_old, h, counters)? {
            return Ok(Err(failure));
        }
        trial.t = t_new;
        for i in 0..q.len() {
            trial.v_base[i] = v[i] + rest * trial.a[i];
            trial.q_base[i] = q[i] + rest * trial.v[i] + stage * trial.v_base[i];
        }
        guessed.copy_from_slice(&trial.a);
        let solved = corrector.solve(system, trial, guessed, guessed, h, counters)?;
        self.size = h;
        (self.forgets, self.lags, self.has_stages) = (true, false, true);
        // Both stages have a solution for any force, however far it throws the shape.
        let is_meaningless = system.model().is_some_and(|model| model.invalid_shape(&self.trial.q).is_some());
        Ok(if is_meaningless { Err(Failure::NotConverged) } else { solved })
    }
}
