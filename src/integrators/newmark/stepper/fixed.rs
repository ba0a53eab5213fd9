//! Steps of fixed size.

use super::super::numbers::Numbers;
use super::{Lengths, StepperOf};
use crate::error::Interrupted;
use crate::integrators::attempts::{Fixed, Memory, fixed_step};
use crate::integrators::second_order::{Counters, SecondOrderSystem, Solved, Status};
use crate::model::Excitation;

impl<V: Numbers> StepperOf<V> {
    pub(super) fn fixed_step<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
    ) -> Result<Option<Status>, Interrupted> {
        let (t_new, h, is_on_grid) = if !V::IS_PLAIN && (self.has_corners || self.is_one_sided) {
            let (times, event) = ((self.t, self.t_end), self.ends_at.take());
            let corner = |cell| {
                let corner = system.model().and_then(|model| model.corner(cell));
                corner.into_iter().chain(event).reduce(f64::min)
            };
            let step = self.grid.step_to_corner(self.fixed_steps, times, corner);
            self.changes_size = !step.2 || self.t > self.grid.after(0);
            step
        } else {
            let (t_new, h) = self.grid.step(self.fixed_steps, self.t_end);
            (t_new, h, true)
        };
        match fixed_step(self, system, t_new, h)? {
            Ok(()) => {
                self.lengths = Lengths::Smooth;
                if is_on_grid {
                    self.grid.count();
                }
                Ok(None)
            }
            Err(failure) => Ok(Some(Status::StepFailed(failure))),
        }
    }
}

impl<V: Numbers> Fixed for StepperOf<V> {
    const IS_PLAIN: bool = V::IS_PLAIN;

    fn has_inertia(&self) -> bool {
        self.scheme.has_inertia()
    }

    fn try_step<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        t_new: f64,
        h: f64,
        memory: Memory,
    ) -> Solved {
        match memory {
            Memory::Kept => self.attempt(system, t_new, h),
            Memory::Dropped => self.attempt_without_memory(system, t_new, h),
        }
    }

    fn try_downhill<S: SecondOrderSystem + ?Sized>(&mut self, system: &mut S, t_new: f64, h: f64) -> Solved {
        self.attempt_downhill(system, t_new, h)
    }

    fn begin_parts(&mut self) {
        self.changes_size = true;
    }

    fn end_parts(&mut self, mut start: Self, is_made: bool) {
        if is_made {
            self.changes_size = start.changes_size;
            self.t_old = start.t;
            [self.q_old, self.v_old, self.a_old] = [start.q, start.v, start.a];
            return;
        }
        start.counters = Counters { steps: start.counters.steps, ..self.counters };
        start.retries = self.retries;
        std::mem::swap(&mut self.corrector, &mut start.corrector);
        *self = start;
    }

    fn forget(&mut self) {
        self.corrector.forget_jacobian();
    }

    fn distrust_accelerations(&mut self) {
        self.is_after_jump = true;
    }
}
