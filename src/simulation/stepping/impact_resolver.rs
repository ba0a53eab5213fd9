//! Resolves impacts that steps of fixed size do not: such a step is repeated by a method with shorter steps.
//!
//! Bodies that collide within a step should rebound according to the contact law. Impulses computed from the masses of the model would be
//! wrong: the effective mass of a rod at an impact depends on the discretisation, and its rebound is due to waves. Therefore the contact
//! law is integrated, but only in steps with a rebound, by Radau's method with an error estimate.

use std::f64::consts::PI;

use super::resolved::ResolvedMotion;
use crate::error::Interrupted;
use crate::integrators::attempts::{Unilateral, matters};
use crate::integrators::radau;
use crate::integrators::second_order::{Counters, Status};
use crate::model::{Facts, Model, Separation};
use crate::numerics::tape::Tape;

/// Tolerance of velocities in the short steps, relative to the change of velocities over the fixed step: balls rebound with 1.0000 of their
/// energy, and gains of energy are at most 2e-4. The tolerance of displacements is that of velocities times the fixed step.
const TOLERANCE: f64 = 1e-4;

/// The change of a velocity counts as at least this part of the largest change, in typical sizes: coordinates that hardly take part in an
/// impact need no accuracy.
const NEGLIGIBLE_CHANGE: f64 = 1e-4;

/// The first step of an impact, relative to the duration of the impact.
pub(super) const FIRST_STEP: f64 = 0.1;

/// Tolerance of the time at which surfaces begin or cease to touch, relative to the duration of the impact.
const CONTACT_TIME_TOLERANCE: f64 = 1e-3;

/// Maximum number of bisections to find this time.
const MOST_HALVINGS: usize = 40;

/// Changes of coordinates by less than this part of their typical sizes are rounding.
const ROUNDING: f64 = 1e-12;

/// Rounding of a coordinate relative to its value, and to its displacement in a step: two units in the last place.
const TWO_ULPS: f64 = 2.0 * f64::EPSILON;

/// Rounding of coordinates causes a warning if it changes velocities in an impact by more than this part of the largest change of velocity in
/// an impact so far: the relative error of that rebound is about as large, and impacts with far smaller changes do not matter.
const LARGEST_ROUNDING: f64 = 1e-2;

/// Work on impacts that is allowed whatever the rest of the run takes, in microseconds by [`work_of_evaluation`]: one or two tenths of a second.
const FREE_WORK: f64 = 150_000.0;

/// Number of other evaluations of the run for each further evaluation that impacts may take.
const OTHERS_PER_EVALUATION: usize = 2;

/// A step is attempted if the allowed work is at least the work of the last failed attempt divided by this.
const RETRY_RATIO: usize = 4;

/// State of the resolution of impacts in a run.
#[derive(Clone, Debug)]
pub(super) struct ImpactResolver {
    /// Evaluations so far.
    used: usize,
    /// Evaluations of the last attempt that exceeded its allowance.
    failed_work: usize,
    /// Whether an impact that matters has not been resolved, because it would have taken too much work.
    is_exhausted: bool,
    /// Duration in seconds of an impact that had not ended at the end of the last resolved step; zero if there is none.
    unfinished_impact: f64,
    /// Tolerances of velocities in the last resolved step.
    tolerances: Vec<f64>,
    /// The motion during the last step, if it was resolved.
    within: ResolvedMotion,
    rounding: Rounding,
}

/// Rounding of coordinates in impacts.
#[derive(Clone, Copy, Debug, Default)]
struct Rounding {
    /// The largest change of a velocity in an impact, in typical sizes per second; zero if it is not known.
    change: f64,
    /// The largest change of a velocity by rounding, as a part of that, and its time.
    part: f64,
    t: f64,
}

impl Rounding {
    /// Records the rounding of the coordinate whose velocity changes most in a resolved step to `t` with an impact of this duration. Given
    /// are the places at its end, the velocities at both ends, and the typical sizes.
    fn follow(&mut self, [q, before, after, sizes]: [&[f64]; 4], impact: f64, t: f64) {
        let changes = before.iter().zip(after).zip(sizes).map(|((v, w), size)| (w - v).abs() / size);
        let most = changes.zip(q.iter().zip(sizes)).max_by(|(one, _), (other, _)| one.total_cmp(other));
        let Some((change, (q, size))) = most else { return };
        if change > self.change {
            // Memories of earlier versions do not know the change.
            self.part *= if self.change > 0.0 { self.change / change } else { 1.0 };
            self.change = change;
        }
        if self.change == 0.0 {
            return;
        }
        let part = TWO_ULPS * q.abs() * PI / (impact * size * self.change);
        if part > self.part {
            (self.part, self.t) = (part, t);
        }
    }
}

/// A step to be repeated: its times, the displacements and velocities at its start, and the duration of the shortest impact in it.
pub(super) struct Step<'a> {
    pub(super) t_span: (f64, f64),
    pub(super) before: [&'a [f64]; 2],
    pub(super) impact: f64,
}

/// A repeated step.
pub(super) struct Resolved {
    /// Displacements, velocities, and accelerations with multipliers behind them.
    pub(super) motion: [Vec<f64>; 3],
    /// Whether surfaces touch at its end.
    pub(super) touches: bool,
}

/// Cost of a tangent, in evaluations.
const TANGENT: usize = 5;

/// Tolerance of single coordinates: error norms are means over all coordinates, of which few may take part in an impact.
fn single_tolerance(n: usize) -> f64 {
    TOLERANCE / (n as f64).sqrt()
}

/// Estimated time of an evaluation with its share of the linear algebra, in microseconds. Fitted, within a factor of three, to runs of
/// Radau's method with up to 40 balls or boxes in a row (1 to 240 coordinates). Rods in contact take at least `RODS` times as long.
fn work_of_evaluation(facts: &Facts) -> f64 {
    const RODS: f64 = 3.0;
    let (n, parts) = (facts.n as f64, facts.parts.len() as f64);
    let work = 1.0 + 3.0 * parts + 0.3 * n + 0.007 * n * n;
    if facts.has_rods_in_contact { RODS * work } else { work }
}

pub(super) fn work_of(counters: &Counters) -> usize {
    counters.nfev + TANGENT * counters.njev
}

/// Number of evaluations that impacts may take in a run of this model whose other steps have taken this work.
fn allowance(facts: &Facts, others: usize) -> usize {
    (FREE_WORK / work_of_evaluation(facts)) as usize + others / OTHERS_PER_EVALUATION
}

/// The same for a single impact, after the run.
pub(super) fn budget(facts: &Facts, work: &Counters) -> usize {
    allowance(facts, work_of(work))
}

impl ImpactResolver {
    /// For a run of `n` coordinates.
    pub(super) fn new(n: usize) -> Self {
        Self {
            used: 0,
            failed_work: 0,
            is_exhausted: false,
            unfinished_impact: 0.0,
            tolerances: vec![0.0; n],
            within: ResolvedMotion::new(n),
            rounding: Rounding::default(),
        }
    }

    /// Another step begins.
    pub(super) fn begin_step(&mut self) {
        self.within.clear();
    }

    /// The motion during the last step, if it was resolved.
    pub(super) fn within(&self) -> Option<&ResolvedMotion> {
        Some(&self.within).filter(|within| !within.is_empty())
    }

    /// Duration in seconds of the shortest impact for which the last step must be repeated, if any. `before` and `found` are the velocities
    /// at both ends of the step of size `h`.
    pub(super) fn impact_to_follow(
        &mut self,
        unilateral: &Unilateral,
        facts: &Facts,
        [before, found]: [&[f64]; 2],
        h: f64,
    ) -> Option<f64> {
        let separation = &unilateral.separation();
        let unfinished_impact = std::mem::take(&mut self.unfinished_impact);
        // Vibrations that an impact has excited are resolved as long as the fixed steps do not resolve them.
        let follows = if unilateral.is_excited() { h } else { unfinished_impact };
        if !matters(separation) && follows == 0.0 {
            return None;
        }
        if unfinished_impact == 0.0 {
            self.tolerances.fill(0.0);
        }
        // While surfaces separate, velocities hardly change, so tolerances must not shrink.
        let sizes = &facts.typical_coordinates;
        let changes = before.iter().zip(found).map(|(before, found)| (found - before).abs());
        let largest = changes.clone().zip(sizes).map(|(change, size)| change / size);
        let largest = largest.fold((separation.speed / facts.length).max(ROUNDING / h), f64::max);
        let single = single_tolerance(sizes.len());
        for ((tolerance, change), size) in self.tolerances.iter_mut().zip(changes).zip(sizes) {
            *tolerance = tolerance.max(single * change.max(NEGLIGIBLE_CHANGE * largest * size));
        }
        Some(if matters(separation) { separation.impact } else { follows })
    }

    /// Records how surfaces that touch at the end of a resolved step will separate.
    pub(super) fn set_unfinished_impact(&mut self, separation: &Separation) {
        self.unfinished_impact = if matters(separation) { separation.impact } else { 0.0 };
    }

    /// Whether an impact that matters has not been resolved, because it would have taken too much work.
    pub(super) fn is_exhausted(&self) -> bool {
        self.is_exhausted
    }

    /// Number of evaluations allowed for a step of this model, in a run with this total work; zero if an attempt is not worthwhile.
    pub(super) fn allowed(&mut self, facts: &Facts, work: &Counters) -> usize {
        let others = work_of(work).saturating_sub(self.used);
        let allowed = allowance(facts, others).saturating_sub(self.used);
        if allowed <= self.failed_work / RETRY_RATIO {
            self.is_exhausted = true;
            return 0;
        }
        allowed
    }

    /// Repeats a step of `model`. Returns the work too; no step if it takes more evaluations than are allowed.
    pub(super) fn resolve<M: Model>(
        &mut self,
        model: &mut M,
        &Step { t_span, before: [q, v], impact }: &Step<'_>,
        allowed: usize,
    ) -> Result<(Option<Resolved>, Counters), Interrupted> {
        let (n, h) = (q.len(), t_span.1 - t_span.0);
        model.set_time(t_span.0)?;
        // What flies is stopped by `end_at_contact`.
        let first_step = if model.deepest_overlap(q).is_some() { h.min(FIRST_STEP * impact) } else { h };
        let options = radau::Options {
            atol: self.atol([q, v], impact, h).into(),
            first_step: Some(first_step),
            ..radau::Options::default()
        };
        let Ok(mut stepper) = radau::Stepper::new(n, t_span, q, v, &options) else {
            return Ok((None, Counters::default()));
        };
        stepper.set_accuracy(TOLERANCE);
        let mut intervals = ContactIntervals::new(n, t_span.1, impact);
        let status = loop {
            if stepper.start(model)?.is_none() {
                intervals.end_at_contact(model, &mut stepper)?;
            }
            let mut status = stepper.step(model)?;
            if intervals.has_separated(model, &mut stepper)? {
                status = stepper.step(model)?;
            }
            self.within.add(&stepper);
            if status.is_some() || work_of(&stepper.counters()) > allowed {
                break status;
            }
        };
        let work = stepper.counters();
        self.used += work_of(&work);
        model.set_time(t_span.1)?;
        if status != Some(Status::Finished) {
            (self.failed_work, self.is_exhausted) = (work_of(&work), true);
            self.within.clear();
            return Ok((None, work));
        }
        let sizes = &model.facts().typical_coordinates;
        self.rounding.follow([stepper.q(), v, stepper.v(), sizes], impact, t_span.1);
        let touches = model.deepest_overlap(stepper.q()).is_some();
        let motion = [stepper.q(), stepper.v(), stepper.unknowns()].map(<[f64]>::to_vec);
        Ok((Some(Resolved { motion, touches }), work))
    }

    /// Absolute tolerances of displacements and velocities in a step of this size from a state. They include the rounding of coordinates and
    /// its effect on velocities in an impact.
    fn atol(&self, [q, v]: [&[f64]; 2], impact: f64, h: f64) -> Vec<f64> {
        let rounding = || q.iter().zip(v).map(|(q, v)| TWO_ULPS * q.abs().max(h * v.abs()));
        let of_places =
            self.tolerances.iter().zip(rounding()).map(|(of_rate, rounding)| h * of_rate + rounding);
        let of_rates = self.tolerances.iter().zip(rounding()).zip(v);
        let of_rates =
            of_rates.map(|((of_rate, rounding), v)| of_rate + PI / impact * rounding + TWO_ULPS * v.abs());
        of_places.chain(of_rates).collect()
    }

    /// Why rebounds may be wrong although they were resolved.
    pub(super) fn doubt(&self) -> Option<String> {
        let Rounding { part, t, .. } = self.rounding;
        (part > LARGEST_ROUNDING).then(|| {
            format!(
                "At t = {t:.3} s the rounding of coordinates changes a velocity in an impact by {part:.0e} of the largest change of velocity in impacts. Start \
                 closer to the origin, in a frame that moves along, or with a lower `stiffness`."
            )
        })
    }

    /// Serialises the rounding, which earlier memories lack, or have without the largest change.
    pub(super) fn serialise_rounding(&mut self, tape: &mut Tape<'_>) {
        let Rounding { part, t, change } = &mut self.rounding;
        tape.number(part);
        tape.number(t);
        if tape.is_over() {
            *change = 0.0;
        } else {
            tape.number(change);
        }
    }

    /// Serialises all data that persist from step to step, except for the rounding.
    pub(super) fn serialise(&mut self, tape: &mut Tape<'_>) {
        tape.count(&mut self.used);
        tape.count(&mut self.failed_work);
        tape.flag(&mut self.is_exhausted);
        tape.number(&mut self.unfinished_impact);
        tape.numbers(&mut self.tolerances);
    }
}

/// Divides a step at the times at which surfaces begin or cease to touch: forces have kinks there, and error estimates of steps across
/// kinks are unreliable.
pub(super) struct ContactIntervals {
    t_end: f64,
    /// Duration of the shortest impact.
    impact: f64,
    /// Whether surfaces touch at the start of the next step.
    touches: bool,
    /// Memory for displacements, velocities and accelerations.
    q: Vec<f64>,
    rates: [Vec<f64>; 2],
}

impl ContactIntervals {
    /// Of `n` coordinates, up to this time, with impacts of this duration.
    pub(super) fn new(n: usize, t_end: f64, impact: f64) -> Self {
        Self { t_end, impact, touches: false, q: vec![0.0; n], rates: [vec![0.0; n], vec![0.0; n]] }
    }

    /// Ends the next step, at whose start no surfaces touch, where surfaces begin to touch: a step across this time is too long by orders of
    /// magnitude and would be rejected several times. The step after it is short.
    pub(super) fn end_at_contact<M: Model>(
        &mut self,
        model: &mut M,
        stepper: &mut radau::Stepper,
    ) -> Result<(), Interrupted> {
        let (t, impact) = (stepper.t(), self.impact);
        let end = (*stepper.next_step()).min(self.t_end - t);
        let Self { q: place, .. } = self;
        let mut overlap = |h: f64| {
            let motion = stepper.q().iter().zip(stepper.v().iter().zip(stepper.a()));
            place.iter_mut().zip(motion).for_each(|(place, (q, (v, a)))| *place = q + h * (v + 0.5 * h * a));
            model.set_time(t + h)?;
            Ok(model.deepest_overlap(place).is_some())
        };
        self.touches = overlap(0.0)?;
        if end <= FIRST_STEP * impact || self.touches || !overlap(end)? {
            return Ok(());
        }
        let [before, behind] = bisect([0.0, end], CONTACT_TIME_TOLERANCE * impact, overlap)?;
        *stepper.next_step() =
            if before > CONTACT_TIME_TOLERANCE * impact { before } else { behind + FIRST_STEP * impact };
        Ok(())
    }

    /// Whether surfaces have separated during the step: it is then undone, and the next one ends at that time.
    fn has_separated<M: Model>(
        &mut self,
        model: &mut M,
        stepper: &mut radau::Stepper,
    ) -> Result<bool, Interrupted> {
        let (before, t, shortest) = (stepper.t_old(), stepper.t(), CONTACT_TIME_TOLERANCE * self.impact);
        let Self { q, rates: [v, a], .. } = self;
        if !self.touches || t == before {
            return Ok(false);
        }
        model.set_time(t)?;
        if model.deepest_overlap(stepper.q()).is_some() {
            return Ok(false);
        }
        let apart = |t: f64| {
            stepper.interpolate(t, q, v, a);
            model.set_time(t)?;
            Ok(model.deepest_overlap(q).is_none())
        };
        let [_, behind] = bisect([before, t], shortest, apart)?;
        if t - behind <= shortest {
            return Ok(false);
        }
        stepper.undo_step();
        *stepper.next_step() = behind - before;
        Ok(true)
    }
}

/// Bisects an interval to this length; a condition holds at its end, but not at its beginning.
fn bisect(
    [mut before, mut behind]: [f64; 2],
    length: f64,
    mut is_found: impl FnMut(f64) -> Result<bool, Interrupted>,
) -> Result<[f64; 2], Interrupted> {
    for _ in 0..MOST_HALVINGS {
        if behind - before <= length {
            break;
        }
        let middle = 0.5 * (before + behind);
        if is_found(middle)? { behind = middle } else { before = middle }
    }
    Ok([before, behind])
}
