//! Steps of fixed size.

use super::diagnosis::{Diagnosis, Kind, knows_losses};
use super::impacts::{self, FollowedImpact};
use super::{Stepper, Unilateral};
use crate::error::Interrupted;
use crate::integrators::Reason;
use crate::integrators::second_order::{Failure, SecondOrderSystem, Solved, model_at, model_of};
use crate::model::{Impact, InImpact};

/// Maximum number of halvings of a step with constraints that fails.
const MOST_HALVINGS: usize = 8;

/// The same with contact. Surfaces that move less than a fifth of a radius in a step cannot pass through each other: with 8 halvings of
/// 5 ms the whipping end of a wire of 1 mm, at 12 m/s, moves half of its radius.
const MOST_HALVINGS_IN_CONTACT: usize = 10;

/// The same for a step without inertia in which a shape snaps: 1/16384 of a step of one second is short compared with the snap.
const MOST_HALVINGS_OF_SNAPS: usize = 14;

/// What a step uses of the steps before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Memory {
    Kept,
    /// Nothing: a backward Euler step of order 1, in which colliding bodies do not rebound.
    Dropped,
}

/// A stepper with steps of prescribed size.
pub(crate) trait Fixed: Stepper + Clone {
    /// Whether its systems are plain equations, without contact, stops and constraints, so that steps need no diagnosis.
    const IS_PLAIN: bool;

    /// Whether accelerations act.
    fn has_inertia(&self) -> bool;

    /// Attempts a step of size `h` to `t_new`.
    fn try_step<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        t_new: f64,
        h: f64,
        memory: Memory,
    ) -> Solved;

    /// Attempts a step without inertia to the equilibrium downhill from its start, without passing through surfaces on the way there.
    fn try_downhill<S: SecondOrderSystem + ?Sized>(&mut self, system: &mut S, t_new: f64, h: f64) -> Solved;

    /// Announces parts of a step, of different sizes.
    fn begin_parts(&mut self);

    /// Joins the parts into one step that began in `start`. If it could not be made, restores that state.
    fn end_parts(&mut self, start: Self, is_made: bool);

    /// Marks tangents and factors as those of another step.
    fn forget(&mut self);

    /// Makes the next step one that does not use the accelerations at its start.
    fn distrust_accelerations(&mut self);
}

/// Makes a step; without memory, or in parts, if necessary. Allocates if it is made in parts.
pub(crate) fn fixed_step<T: Fixed, S: SecondOrderSystem + ?Sized>(
    stepper: &mut T,
    system: &mut S,
    t_new: f64,
    h: f64,
) -> Solved {
    let is_one_sided = !T::IS_PLAIN && is_one_sided(system);
    let facts = system.facts();
    let has_constraints = !T::IS_PLAIN && facts.constraints() > 0;
    let has_inertia = T::IS_PLAIN || stepper.has_inertia();
    let mut steps = FallbackSteps { stepper, system };
    if !has_inertia {
        return steps.step_without_inertia(t_new, h);
    }
    if is_one_sided {
        steps.unilateral().begin_step(h);
        return steps.step(t_new, h);
    }
    match steps.part(t_new, h, Memory::Kept)? {
        // Near singular positions, such as those of a cracking whip, mechanisms may need shorter steps (`test_loops`).
        Err(failure) if has_constraints => {
            Ok(steps.in_parts(t_new, Memory::Kept, MOST_HALVINGS)?.map_err(|_| failure))
        }
        solved => Ok(solved),
    }
}

/// Whether surfaces may touch, or tendons become slack.
fn is_one_sided<S: SecondOrderSystem + ?Sized>(system: &S) -> bool {
    let facts = system.facts();
    facts.has_contact || facts.is_one_sided
}

struct FallbackSteps<'a, T, S: ?Sized> {
    stepper: &'a mut T,
    system: &'a mut S,
}

impl<T: Fixed, S: SecondOrderSystem + ?Sized> FallbackSteps<'_, T, S> {
    /// A step in which surfaces may meet.
    fn step(&mut self, t_new: f64, h: f64) -> Solved {
        // 1. By the scheme of the method. If the step is too long for an impact, it is rejected: the accelerations that the scheme
        // remembers would throw the surfaces apart faster than they approached (Acary 2015).
        let resumes = self.unilateral().resumes;
        if (self.unilateral().steps_without_memory == 0 || resumes)
            && self.try_step(t_new, h, Memory::Kept)?.is_ok()
            && self.diagnose(Memory::Kept)? == Diagnosis::Valid
            && !(resumes && self.excites()?)
        {
            self.accept_with_memory()?;
            self.unilateral().followed = None;
            return Ok(Ok(()));
        }
        self.unilateral().forget();
        // 2. In parts, if an impact goes on that was followed up to here.
        if let Some(impact) = self.unilateral().unfinished(t_new - h)
            && self.follow(impact, t_new)?
        {
            return Ok(Ok(()));
        }
        self.unilateral().followed = None;
        if !self.unilateral().tries_whole() {
            self.stepper.retries().fail(Reason::InParts);
        }
        // 3. Without memory, like the next step then: colliding bodies do not rebound
        // (`test_what_meets_within_a_step_does_not_rebound`), unless they are followed in parts. What has just been made in parts
        // mostly fails again.
        if self.unilateral().tries_whole() && self.try_valid(t_new, h, Memory::Dropped)?.is_ok() {
            let impact = self.stopped_impact()?;
            let followed = impact.as_ref().and_then(|impact| self.unilateral().to_follow(impact, t_new, h));
            if let Some(impact) = followed
                && self.follow(impact, t_new)?
            {
                return Ok(Ok(()));
            }
            // Parts that could not be made have replaced the attempt.
            if followed.is_none() || self.try_valid(t_new, h, Memory::Dropped)?.is_ok() {
                self.accept_without_memory(impact)?;
                self.unilateral().parts = 0;
                return Ok(Ok(()));
            }
        }
        // 4. In parts: the shorter a step, the more inertia dominates over contact stiffness. Wedged rods and steep friction need
        // that (`test_contact_hard`), and so do surfaces that would pass through each other (`test_contact_passing`).
        if self.in_parts(t_new, Memory::Dropped, MOST_HALVINGS_IN_CONTACT)?.is_ok() {
            let unilateral = self.unilateral();
            unilateral.steps_without_memory = unilateral.steps_without_memory.max(1);
            unilateral.parts += 1;
            return Ok(Ok(()));
        }
        // 5. The whole step without memory: if its end is invalid for any size, the run reports why (`deep_penetration`, `unresolved`).
        let solved = self.try_step(t_new, h, Memory::Dropped)?;
        if solved.is_ok() {
            let (ends, unilateral) = self.stepper.tried();
            let found = unilateral.diagnose(model_of(self.system), &ends, Kind::Last)?;
            if matches!(found, Diagnosis::Crossed | Diagnosis::Explodes) {
                return Ok(Err(Failure::PassedThrough));
            }
            let impact = self.stopped_impact()?;
            self.accept_without_memory(impact)?;
        }
        Ok(solved)
    }

    /// Makes a step with an impact in parts by the scheme of the method. Returns whether they could be made; if not, the step has not begun.
    fn follow(&mut self, impact: FollowedImpact, t_new: f64) -> Result<bool, Interrupted> {
        self.stepper.retries().fail(Reason::Impact);
        self.unilateral().followed = Some(impact);
        let is_made = self.in_parts(t_new, Memory::Kept, impacts::MOST_HALVINGS)?.is_ok();
        let unilateral = self.unilateral();
        if !is_made || !unilateral.touches {
            unilateral.followed = None;
        }
        if is_made && !unilateral.touches {
            // Those of vibrations after an impact make whole steps gain energy.
            self.stepper.distrust_accelerations();
        }
        Ok(is_made)
    }

    /// A step without inertia, to an equilibrium, so that impacts have no energy. In shorter steps loads change less, and damping and
    /// friction resist more.
    fn step_without_inertia(&mut self, t_new: f64, h: f64) -> Solved {
        // 1. To the nearby equilibrium.
        let Err(failure) = self.part(t_new, h, Memory::Kept)? else { return Ok(Ok(())) };
        // 2. To the one downhill, where contacts begin (`test_catheters_end_each_step_in_equilibrium`); chains of hinges that snap
        // take twice the work so. What damps strains holds them in short parts.
        let facts = self.system.facts();
        if facts.has_contact && !facts.has_retardation && self.downhill(t_new, h)?.is_ok() {
            return Ok(Ok(()));
        }
        // 3. In parts.
        if self.in_parts(t_new, Memory::Kept, MOST_HALVINGS)?.is_ok() {
            return Ok(Ok(()));
        }
        // 4. If there is none, the shape snaps to another one, or falls until something holds it: parts with inertia, by the backward
        // Euler method, which removes the energy (`test_static_friction_lets_go`, `test_what_snaps_goes_over_to_the_next_equilibrium`).
        if self.in_parts(t_new, Memory::Dropped, MOST_HALVINGS_OF_SNAPS)?.is_ok() {
            self.unilateral().record_snap(t_new);
            return Ok(Ok(()));
        }
        Ok(Err(failure))
    }

    fn downhill(&mut self, t_new: f64, h: f64) -> Solved {
        self.stepper.retries().attempt();
        if let Err(failure) = self.stepper.try_downhill(self.system, t_new, h)? {
            self.stepper.retries().fail(failure);
            return Ok(Err(failure));
        }
        let (ends, unilateral) = self.stepper.tried();
        let found = unilateral.diagnose(model_of(self.system), &ends, Kind::Downhill)?;
        if self.record(found) != Diagnosis::Valid {
            return Ok(Err(Failure::NotConverged));
        }
        self.accept()?;
        Ok(Ok(()))
    }

    fn unilateral(&mut self) -> &mut Unilateral {
        self.stepper.tried().1
    }

    /// Attempts a step, and records whether surfaces touch in any iterate of its solution.
    fn try_step(&mut self, t_new: f64, h: f64, memory: Memory) -> Solved {
        let has_contact = !T::IS_PLAIN && self.system.facts().has_contact;
        if has_contact {
            model_of(self.system).take_touched();
        }
        self.stepper.retries().attempt();
        let solved = self.stepper.try_step(self.system, t_new, h, memory)?;
        if let Err(failure) = solved {
            self.stepper.retries().fail(failure);
        }
        if has_contact {
            self.unilateral().has_touched = model_of(self.system).take_touched();
        }
        Ok(solved)
    }

    fn excites(&mut self) -> Result<bool, Interrupted> {
        let (ends, unilateral) = self.stepper.tried();
        let excites = unilateral.excites(model_of(self.system), &ends)?;
        if excites {
            self.stepper.retries().fail(Reason::Impact);
        }
        Ok(excites)
    }

    /// Records why an attempt with this diagnosis does not make the step.
    fn record(&mut self, found: Diagnosis) -> Diagnosis {
        found.reason().into_iter().for_each(|reason| self.stepper.retries().fail(reason));
        found
    }

    fn diagnose(&mut self, memory: Memory) -> Result<Diagnosis, Interrupted> {
        let kind = match memory {
            _ if !self.stepper.has_inertia() => Kind::WithoutInertia,
            Memory::Kept => Kind::WithMemory,
            Memory::Dropped => Kind::WithoutMemory,
        };
        let (ends, unilateral) = self.stepper.tried();
        let found = unilateral.diagnose(model_of(self.system), &ends, kind)?;
        Ok(self.record(found))
    }

    /// Attempts a step that must be valid.
    fn try_valid(&mut self, t_new: f64, h: f64, memory: Memory) -> Solved {
        if let Err(failure) = self.try_step(t_new, h, memory)? {
            return Ok(Err(failure));
        }
        let is_valid = self.diagnose(memory)? == Diagnosis::Valid;
        Ok(if is_valid { Ok(()) } else { Err(Failure::NotConverged) })
    }

    /// Makes a step, or a part of one. Where surfaces or tendons act, it must be valid.
    fn part(&mut self, t_new: f64, h: f64, memory: Memory) -> Solved {
        let has_inertia = T::IS_PLAIN || self.stepper.has_inertia();
        if memory == Memory::Kept && has_inertia && (T::IS_PLAIN || !is_one_sided(self.system)) {
            if let Err(failure) = self.try_step(t_new, h, memory)? {
                return Ok(Err(failure));
            }
            self.stepper.accept(self.system)?;
            return Ok(Ok(()));
        }
        let unilateral = self.unilateral();
        if unilateral.is_too_long(unilateral.touches, h) {
            return Ok(Err(Failure::NotConverged));
        }
        if let Err(failure) = self.try_valid(t_new, h, memory)? {
            return Ok(Err(failure));
        }
        let unilateral = self.unilateral();
        if unilateral.is_too_long(unilateral.will_touch, h) {
            return Ok(Err(Failure::NotConverged));
        }
        match memory {
            _ if !has_inertia => self.accept()?,
            Memory::Kept => self.accept_with_memory()?,
            Memory::Dropped => {
                let impact = self.stopped_impact()?;
                self.accept_without_memory(impact)?;
            }
        }
        Ok(Ok(()))
    }

    /// Accepts a step in which surfaces may touch, by the scheme of the method.
    fn accept_with_memory(&mut self) -> Result<(), Interrupted> {
        let (ends, unilateral) = self.stepper.tried();
        (unilateral.steps_without_memory, unilateral.parts) = (0, 0);
        unilateral.follow_impact(model_of(self.system), &ends)?;
        unilateral.follow_separation(model_of(self.system), &ends)?;
        self.accept()
    }

    /// Examines an attempted step without memory; returns the impact that it has stopped, if that may matter.
    fn stopped_impact(&mut self) -> Result<Option<Impact>, Interrupted> {
        let (ends, unilateral) = self.stepper.tried();
        let model = model_of(self.system);
        unilateral.steps_without_memory = match unilateral.is_unresolved(model, &ends)? {
            true => unilateral.steps_without_memory.saturating_sub(1).max(1),
            false => unilateral.steps_without_memory.saturating_sub(1),
        };
        unilateral.follow_separation(model, &ends)?;
        if !unilateral.will_touch || !(unilateral.counts() || model.facts().has_rods_in_contact) {
            return Ok(None);
        }
        Ok(model_at(self.system, ends.t[1])?.impact(ends.before(), ends.after(), ends.h))
    }

    /// Accepts a step without memory, which may have stopped an impact.
    fn accept_without_memory(&mut self, impact: Option<Impact>) -> Result<(), Interrupted> {
        let (ends, unilateral) = self.stepper.tried();
        let has_rods = model_of(self.system).facts().has_rods_in_contact;
        if let Some(impact) = impact.as_ref().filter(|_| has_rods) {
            unilateral.record_stopped(impact, &ends);
        }
        match impact.filter(|_| unilateral.counts()) {
            Some(impact) => {
                unilateral.impacts.count(ends.t[1], &impact, knows_losses(self.system.facts()));
                unilateral.forget();
            }
            // Surfaces that separate have still touched at its start, and many impacts that do not matter may matter together.
            None => unilateral.follow_impact(model_of(self.system), &ends)?,
        }
        self.accept()
    }

    fn accept(&mut self) -> Result<(), Interrupted> {
        self.stepper.accept(self.system)?;
        let unilateral = self.unilateral();
        unilateral.touches = unilateral.will_touch;
        unilateral.resumes = false;
        Ok(())
    }

    /// Makes the step in halves, and halves again those that fail, this often.
    fn in_parts(&mut self, t_new: f64, memory: Memory, halvings: usize) -> Solved {
        let start = self.stepper.clone();
        self.stepper.begin_parts();
        let solved = self.halves(t_new, [1, halvings], memory);
        self.stepper.end_parts(start, matches!(solved, Ok(Ok(()))));
        self.stepper.forget();
        solved
    }

    /// The halves after so many halvings.
    fn halves(&mut self, t_new: f64, [halvings, most]: [usize; 2], memory: Memory) -> Solved {
        let t = self.stepper.tried().0.t[0];
        let retries = self.stepper.retries();
        retries.halvings = retries.halvings.max(halvings);
        for end in [0.5 * (t + t_new), t_new] {
            self.stepper.forget();
            let h = end - self.stepper.tried().0.t[0];
            let Err(failure) = self.part(end, h, memory)? else { continue };
            if halvings == most {
                return Ok(Err(failure));
            }
            if let Err(failure) = self.halves(end, [halvings + 1, most], memory)? {
                return Ok(Err(failure));
            }
        }
        Ok(Ok(()))
    }
}
