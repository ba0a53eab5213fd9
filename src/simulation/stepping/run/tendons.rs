//! Steps with inextensible tendons, which end where a tendon becomes slack or taut.

use super::super::changes::{Changes, LARGEST_LENGTH_ERROR, Verdict, judge};
use super::super::following::Search;
use super::super::integrator::Integrator;
use super::super::status::{Status, Stop};
use super::Run;
use crate::description::signal::rounding_of_times;
use crate::error::Interrupted;
use crate::integrators::newmark::Lengths;
use crate::integrators::second_order::Failure;
use crate::model::Model;
use crate::model::constraint::one_sided::{self, ActiveSetFailure, TAUT};
use crate::simulation::balance::State;

/// If a taut tendon misses its length in a step of this part of the interval, the length jumps: the step is not shortened further.
const SHORTEST_STEP: f64 = 1e-9;

/// The change of a length over a step is a jump if it differs from that by the rates at both ends by more than this part; for resolved
/// motions the difference is at most half of this.
const JUMP_RATIO: f64 = 0.25;

impl<M: Model> Run<M> {
    /// Makes a step that ends at the latest where the active set of one-sided constraints changes.
    pub(super) fn step_to_change(
        &mut self,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Option<Status>, Interrupted> {
        let Some(changes) = &mut self.changes else { unreachable!("there are none") };
        if let Some(without) = changes.due.take() {
            return self.change(without);
        }
        changes.has_jumped = false;
        let (t_end, mut planned, mut corrections) = (changes.t_span.1, None, 0);
        loop {
            let steps = self.integrator.steps();
            let status = self.single_step(Lengths::Smooth, monitor)?;
            let Self { integrator, changes: Some(changes), stop: None, .. } = self else { return Ok(status) };
            if integrator.steps() == steps {
                return Ok(status);
            }
            let times = [integrator.t_old(), integrator.t()];
            let n = integrator.state().1[0].len();
            let mut states = [vec![0.0; n], vec![0.0; n], vec![0.0; n]];
            let planned_so = planned.map(|event| (event, corrections));
            let is_fixed = integrator.pulls().is_some();
            let verdict = judge(times, t_end, is_fixed, planned_so, &mut |t| {
                let [q, v, a] = &mut states;
                if t == times[1] {
                    let (_, [at_end, rate, _]) = integrator.state();
                    q.copy_from_slice(at_end);
                    v.copy_from_slice(rate);
                } else {
                    integrator.interpolate(&[t], [q, v, a])?;
                }
                let known = integrator.multipliers(t);
                changes.indicator(integrator.model(), t, [q, v], known)
            })?;
            match verdict {
                Verdict::Done | Verdict::Change(_) if has_pushed(integrator, changes) => {
                    integrator.undo_step();
                    changes.jumps = true;
                    return self.step_over_jump(monitor);
                }
                Verdict::Done => {}
                Verdict::Change(without) => changes.due = Some(without),
                Verdict::ChangeAtStart(without) => {
                    integrator.undo_step();
                    return self.change(without);
                }
                // No step of fixed size is that short.
                Verdict::EndAt(event)
                    if is_fixed && event.t - times[0] <= rounding_of_times(self.dt, event.t) =>
                {
                    integrator.undo_step();
                    return self.change(event.is_released.then_some(event.which));
                }
                Verdict::EndAt(event) => {
                    integrator.undo_step();
                    integrator.end_at(event.t);
                    (planned, corrections) = (Some(event), corrections + 1);
                    continue;
                }
                Verdict::LengthError(by) => {
                    integrator.undo_step();
                    let middle = 0.5 * (times[0] + times[1]);
                    if times[1] - times[0] <= SHORTEST_STEP * (t_end - times[0]) {
                        return Ok(self.active_set_failure(ActiveSetFailure::Violated(by)));
                    }
                    integrator.end_at(middle);
                    planned = None;
                    continue;
                }
            }
            let is_over = times[1] == t_end;
            if !is_over {
                integrator.end_at(t_end);
            }
            if is_fixed && self.lengths_have_jumped()? {
                self.balance_jump()?;
            }
            return Ok(status.filter(|_| is_over));
        }
    }

    /// Whether the next step is of fixed size and lengths have jumped with the inputs.
    pub(super) fn lengths_jump(&mut self) -> Result<bool, Interrupted> {
        let Self { integrator, changes: Some(changes), inputs, inputs_before, .. } = self else {
            return Ok(false);
        };
        if integrator.pulls().is_none() {
            return Ok(false);
        }
        changes.jumps = integrator.observe(|model, State { t, q, v, .. }| {
            model.set_inputs(inputs_before);
            let before = model.set_time(t).map(|()| model.passed(q, v));
            model.set_inputs(inputs);
            model.set_time(t)?;
            Ok(before? != model.passed(q, v))
        })?;
        if changes.jumps {
            changes.due = None;
        }
        Ok(changes.jumps)
    }

    /// Makes a step of fixed size over which lengths jump, with the active set that fits best; without memory if a slack tendon becomes
    /// taut. Forces are impulses there, whose work is known from the gain of energy only.
    pub(super) fn step_over_jump(
        &mut self,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Option<Status>, Interrupted> {
        let steps = self.steps();
        let status = self.follow_jump(monitor)?;
        if self.steps() > steps {
            self.balance_jump()?;
        }
        Ok(status)
    }

    /// Counts a gain of energy over the last step as work, and a loss as dissipated.
    fn balance_jump(&mut self) -> Result<(), Interrupted> {
        let [gained, damped] = self.integrator.gain()?;
        let work = gained + damped;
        if let Some(changes) = &mut self.changes {
            changes.add_flow([damped + (-work).max(0.0), work.max(0.0)]);
        }
        Ok(())
    }

    /// Whether lengths of taut tendons have jumped within the last step, or their changes do not follow from the rates at its ends.
    fn lengths_have_jumped(&mut self) -> Result<bool, Interrupted> {
        let t_old = self.integrator.t_old();
        self.integrator.observe(|model, State { t, q, .. }| {
            if !model.facts().varies_in_time {
                return Ok(false);
            }
            let (h, rest) = (t - t_old, vec![0.0; q.len()]);
            model.set_time(t_old)?;
            let before = model.passed(q, &rest);
            model.set_time(t)?;
            let after = model.passed(q, &rest);
            let active = taut_tendons(model, after.len());
            let has_jumped = |(([from, rate], [to, next]), is_active): ((&[f64; 2], &[f64; 2]), bool)| {
                let (change, by_rates) = (to - from, 0.5 * h * (rate + next));
                let most = change.abs() + 0.5 * h * (rate.abs() + next.abs());
                is_active && (change - by_rates).abs() > TAUT.max(JUMP_RATIO * most)
            };
            Ok(before.iter().zip(&after).zip(active).any(has_jumped))
        })
    }

    fn follow_jump(
        &mut self,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<Option<Status>, Interrupted> {
        let start = self.integrator.observe(|model, State { q, v, .. }| {
            let tendons = model.passed(q, v).len();
            taut_tendons(model, tendons)
        });
        let (mut search, mut lengths) = (Search::new(&start), Lengths::Jump);
        let status = loop {
            let active = search.active().to_vec();
            let (status, end) = self.step_with(&start, &active, lengths, monitor)?;
            let end = end.as_ref().map(|[pulls, excesses]| [&pulls[..], &excesses[..]]);
            if search.fits(end) {
                break status;
            }
            let has_next = search.next(end);
            let is_taken_up =
                search.active().iter().zip(&start).any(|(is_active, was_active)| *is_active && !was_active);
            if lengths == Lengths::Jump && (is_taken_up || !has_next) {
                self.integrator.undo_step();
                (search, lengths) = (Search::new(&start), Lengths::TakenUp);
                continue;
            }
            if has_next {
                self.integrator.undo_step();
                continue;
            }
            let Some((misfit, best)) = search.best().cloned() else {
                set_taut_tendons(self.integrator.model(), &start);
                return Ok(status);
            };
            if misfit.excess > LARGEST_LENGTH_ERROR {
                self.integrator.undo_step();
                set_taut_tendons(self.integrator.model(), &start);
                return Ok(Some(self.stop.insert(Stop::at_conflict(self.integrator.t())).status));
            }
            self.miss(misfit.excess);
            if best == active {
                break status;
            }
            self.integrator.undo_step();
            break self.step_with(&start, &best, lengths, monitor)?.0;
        };
        if let Some(changes) = &mut self.changes {
            (changes.jumps, changes.has_jumped, changes.due) = (false, true, Some(None));
        }
        Ok(status)
    }

    /// Makes a step with the tendons `active` taut; at its start those in `start` are. Returns tensions and excesses at its end if it was
    /// made and the end is valid.
    #[allow(clippy::type_complexity, reason = "a status and the end")]
    fn step_with(
        &mut self,
        start: &[bool],
        active: &[bool],
        lengths: Lengths,
        monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
    ) -> Result<(Option<Status>, Option<[Vec<f64>; 2]>), Interrupted> {
        set_taut_tendons(self.integrator.model(), active);
        let steps = self.steps();
        let Ok(status) = self.single_step(lengths, monitor) else {
            set_taut_tendons(self.integrator.model(), start);
            return Err(Interrupted);
        };
        if self.steps() == steps || self.stop.is_some() {
            return Ok((status, None));
        }
        let pulls = self.integrator.pulls().unwrap_or_default();
        let pulls = pulls[pulls.len() - active.len()..].to_vec();
        let excesses = self.integrator.observe(|model, state| {
            model.set_time(state.t)?;
            Ok(model.passed(state.q, state.v).into_iter().map(|[by, _]| by).collect())
        })?;
        Ok((status, Some([pulls, excesses])))
    }

    /// Records the excess of a tendon over its length, in units of the length of what it joins.
    fn miss(&mut self, by: f64) {
        let t = self.t();
        if let Some(changes) = &mut self.changes
            && changes.missed.is_none_or(|(most, _)| by > most)
        {
            changes.missed = Some((by, t));
        }
    }

    /// Finds the active constraints at the start.
    pub(super) fn find_active_set(&mut self) -> Result<Option<Status>, Interrupted> {
        let found = self.integrator.observe(|model, state| {
            model.set_time(state.t)?;
            Ok(one_sided::change(model, [state.q, state.v], None))
        })?;
        let is_fixed = self.integrator.pulls().is_some();
        if let Some(changes) = &mut self.changes {
            changes.has_begun = true;
        }
        Ok(match found {
            // Inputs were set before the start.
            Err(ActiveSetFailure::Violated(_)) if is_fixed => None,
            found => found.err().and_then(|why| self.active_set_failure(why)),
        })
    }

    /// Changes the active set here; `without` is released, if given.
    pub(super) fn change(&mut self, without: Option<usize>) -> Result<Option<Status>, Interrupted> {
        let found = self.integrator.observe(|model, state| {
            model.set_time(state.t)?;
            Ok(one_sided::change(model, [state.q, state.v], without))
        })?;
        let is_fixed = self.integrator.pulls().is_some();
        let changed = match found {
            Ok(changed) => changed,
            Err(ActiveSetFailure::Violated(_) | ActiveSetFailure::Undecided) if is_fixed => {
                let Some(changes) = &mut self.changes else { unreachable!("there are none") };
                changes.jumps = true;
                return Ok(None);
            }
            Err(why) => {
                let status = self.active_set_failure(why);
                let none = self.integrator.no_acceleration(Failure::SingularJacobian);
                return Ok(Some(status.unwrap_or(none)));
            }
        };
        let t = self.integrator.t();
        let Some(changes) = &mut self.changes else { unreachable!("there are none") };
        self.integrator.end_at(changes.t_span.1);
        self.integrator.restart([&changed.q, &changed.v, &changed.a])?;
        if changes.count(t, changed.flow, is_fixed.then_some(self.dt)) {
            return Ok(None);
        }
        if is_fixed {
            // A plate that rocks on two tendons comes to rest through infinitely many impacts: each tendon pulls over the rest of this step, or
            // not at all.
            changes.jumps = true;
            return Ok(None);
        }
        Ok(Some(self.stop.insert(Stop::at_chatter(t)).status))
    }

    /// Ends the interval if no active set was found; `None` if the mass is singular.
    fn active_set_failure(&mut self, why: ActiveSetFailure) -> Option<Status> {
        let t = self.t();
        let stop = match why {
            ActiveSetFailure::Violated(by) => Stop::where_too_long(t, by),
            ActiveSetFailure::Undecided => Stop::at_conflict(t),
            ActiveSetFailure::SingularMass => return None,
        };
        Some(self.stop.insert(stop).status)
    }
}

/// For each of this number of tendons, whether it is taut.
fn taut_tendons<M: Model>(model: &M, tendons: usize) -> Vec<bool> {
    let active = model.active();
    active[active.len() - tendons..].to_vec()
}

/// Makes exactly these tendons taut.
fn set_taut_tendons<M: Model>(model: &mut M, active: &[bool]) {
    let closed = std::iter::repeat_n(true, model.facts().constraints() - active.len());
    let all: Vec<f64> =
        closed.chain(active.iter().copied()).map(|is_active| f64::from(u8::from(is_active))).collect();
    model.release(&all);
}

/// Whether a tendon pushed over the last step of fixed size with more than the largest tension so far: its length has jumped.
fn has_pushed<M: Model>(integrator: &Integrator<M>, changes: &Changes) -> bool {
    integrator.pulls().is_some_and(|pulls| pulls.iter().any(|pull| -pull > changes.largest_tension))
}
