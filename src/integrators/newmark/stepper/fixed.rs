//! Steps of fixed size.

use super::StepperOf;
use crate::error::Interrupted;
use crate::integrators::newmark::numbers::Numbers;
use crate::integrators::second_order::{Failure, Status, System};
use crate::model::Excitation;

/// How often a step into contact, or of a mechanism with constraints, that cannot be made is halved at most.
const MOST_HALVINGS: usize = 8;

/// Makes a step to a time, of a size.
type Part<V, S> = fn(&mut StepperOf<V>, &mut S, f64, f64) -> Result<Result<(), Failure>, Interrupted>;

impl<V: Numbers> StepperOf<V> {
    pub(super) fn fixed_step<S: System + ?Sized>(
        &mut self,
        system: &mut S,
    ) -> Result<Option<Status>, Interrupted> {
        let (t_new, h, is_on_grid) = if !V::IS_PLAIN && self.has_corners {
            let times = (self.t, self.t_end);
            let corner = |cell| system.model().and_then(|model| model.corner(cell));
            let step = self.grid.step_to_corner(self.fixed_steps, times, corner);
            self.changes_size = !step.2 || self.t > self.grid.after(0);
            step
        } else {
            let (t_new, h) = self.grid.step(self.fixed_steps, self.t_end);
            (t_new, h, true)
        };
        let solved = if !V::IS_PLAIN && (self.has_contact || system.facts().is_one_sided) {
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

    /// Steps of half the size, made by `part`, and of half of that where these cannot be made either: the shorter a step, the
    /// more what moves outweighs what presses. To the outside they are one step; where it fails the state is as before.
    /// Allocates.
    pub(super) fn halved_steps<S: System + ?Sized>(
        &mut self,
        system: &mut S,
        t_new: f64,
        part: Part<V, S>,
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
        part: Part<V, S>,
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
}
