//! Steps of fixed size at whose ends surfaces may have met, or slack tendons become taut.

use super::super::numbers::Numbers;
use super::super::trial::Trial;
use super::{STEPS_AFTER_STOP, StepperOf};
use crate::error::Interrupted;
use crate::integrators::second_order::{Failure, System, model_at, model_of, set_motion};
use crate::model::{Beside, Facts, Holding, InContact, InImpact, Model, Radius, have_passed};

impl<V: Numbers> StepperOf<V> {
    /// A step at whose end surfaces may have met, or slack tendons become taut. Where it does not see the impact rise and fall,
    /// its end is stiff and its beginning is not: what the scheme remembers of the accelerations would throw the surfaces apart
    /// faster than they came (Acary 2015). Such steps, and those right after, are made without memory: in them surfaces that
    /// meet do not rebound.
    pub(super) fn step_into_contact<S: System + ?Sized>(
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
            // One that is invalid whatever its size says why.
            let Trial { t, q, .. } = &self.trial;
            let model = model_at(system, *t)?;
            if !is_invalid(model, q)
                && (self.passes(model, (*t, q), Radius::Smaller)?
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
        let model = model_of(system);
        let before = match self.holding.take() {
            Some(holding) => Some(holding),
            None => holding(model, self.t, [&self.q, &self.v, &self.a])?,
        };
        let Trial { t, q, v, a, .. } = &self.trial;
        let after = holding(model, *t, [q, v, a])?;
        if let (Some(before), Some(after)) = (&before, &after) {
            // Where surfaces touch tells what takes part.
            let motion = if self.will_touch { [&q[..], v, a] } else { [&self.q[..], &self.v, &self.a] };
            self.pressed.find(model, motion);
            let kinetic = [(&self.q, &self.v, before), (q, v, after)]
                .map(|(q, v, holding)| self.pressed.kinetic(model, [q, v], holding.kinetic));
            let gain = after.total - before.total;
            let gain = self.pressed.gain(model, [&self.q, &self.v], [q, v], gain);
            let lost = 0.5 * h * (before.supplied + after.supplied) - gain;
            self.impacts.follow(lost, kinetic[0].max(kinetic[1]), after.elastic);
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
        if model_of(system).is_touched() {
            let Trial { t, q, v, a, .. } = &self.trial;
            let motion = [&q[..], &v[..], &a[..q.len()]];
            if let Some(impact) = model_at(system, *t)?.impact([&self.q, &self.v], motion, h) {
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

    /// Whether the end of the trial means nothing, or surfaces have passed through each other on the way to it. Where they touch at
    /// that end they might have been pushed aside: then they must not pass on the way straight on either.
    fn is_flawed<S: System + ?Sized>(&mut self, system: &mut S) -> Result<bool, Interrupted> {
        let Trial { t, q, .. } = &self.trial;
        let model = model_at(system, *t)?;
        if is_invalid(model, q) || self.passes(model, (*t, q), Radius::Smaller)? {
            return Ok(true);
        }
        if !self.has_contact || !model.is_touched() {
            return Ok(false);
        }
        let h = *t - self.t;
        self.straight_on.clear();
        self.straight_on.extend(self.q.iter().zip(self.v.iter()).map(|(q, v)| q + h * v));
        self.passes(model, (*t, &self.straight_on), Radius::Larger)
    }

    /// Whether surfaces pass through each other on the straight way from the state to a later one.
    fn passes<M: Model + ?Sized>(
        &self,
        model: &mut M,
        end: (f64, &[f64]),
        radius: Radius,
    ) -> Result<bool, Interrupted> {
        Ok(self.has_contact && have_passed(model, [(self.t, &self.q[..]), end].into_iter(), radius)?)
    }

    fn is_jolted<S: System + ?Sized>(&mut self, system: &mut S, h: f64) -> Result<bool, Interrupted> {
        let has_stopped = self.has_stopped && system.facts().is_one_sided;
        if !self.has_contact {
            return Ok(has_stopped);
        }
        let Trial { t, q, v, a, .. } = &self.trial;
        let model = model_of(system);
        let a = set_motion(model, *t, q, a)?;
        let is_jolted = model.is_jolted([&self.q, &self.v], [q, v, a], h);
        self.will_touch = model.is_touched();
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
        if !self.has_contact || !(self.touches || self.has_touched || model_of(system).is_touched()) {
            return Ok(false);
        }
        let Trial { t, q, v, a, .. } = &self.trial;
        let motion = [&q[..], &v[..], &a[..q.len()]];
        Ok(model_at(system, *t)?.gains_energy([&self.q, &self.v], motion, h, beside))
    }
}

/// Whether a shape is invalid, including sunk surfaces.
fn is_invalid<M: Model + ?Sized>(model: &mut M, q: &[f64]) -> bool {
    model.flaw(q).is_some() || model.sunk(q).is_some()
}

/// What such a motion has; `None` where something dissipates, which steps of an impact tell badly, and where what moves it from
/// outside is known at single times alone.
fn holding<M: Model + ?Sized>(
    model: &mut M,
    t: f64,
    [q, v, a]: [&[f64]; 3],
) -> Result<Option<Holding>, Interrupted> {
    let Facts { is_damped, is_driven, is_carried, varies_in_time, .. } = *model.facts();
    if is_carried || varies_in_time || is_damped {
        return Ok(None);
    }
    model.set_time(t)?;
    let energy = model.energy(q, v);
    let supplied = if is_driven { model.supplied_power(q, v, &a[..q.len()]) } else { 0.0 };
    Ok(Some(Holding { total: energy.total(), kinetic: energy.kinetic, elastic: energy.elastic, supplied }))
}
