//! What rods lose in an impact that a step has stopped, by a motion that resolves it.
//!
//! The contact law says what a rigid body loses in an impact. A rod gives back as waves what its end has not lost in the contact: how much
//! that is depends on how fast forces rise in comparison with the time that waves take, so that the worst impact of a run is followed by
//! Radau's method, in shorter steps, until surfaces part.

use super::impact_resolver::{ContactIntervals, FIRST_STEP, budget, work_of};
use crate::error::Interrupted;
use crate::integrators::attempts::{ResolvedLoss, StoppedImpact};
use crate::integrators::radau;
use crate::integrators::second_order::{Counters, Status};
use crate::model::Model;

/// Tolerance of velocities, relative to the largest velocity in typical sizes; that of displacements is this times the duration of the impact.
const TOLERANCE: f64 = 1e-3;

/// Longest time until surfaces part, in times that the steps took that have stopped the impact.
const LONGEST: f64 = 2.0;

/// What this model loses in an impact, in a run that has taken this work.
pub(super) fn resolved_loss<M: Model>(
    model: &mut M,
    stopped: &StoppedImpact,
    work: &Counters,
) -> Result<ResolvedLoss, Interrupted> {
    let &StoppedImpact { t, h, end, ref q, ref v, .. } = stopped;
    let duration = stopped.duration();
    let allowed = budget(model.facts(), work);
    model.set_time(t)?;
    let before = model.energy(q, v).total();
    let mut found = ResolvedLoss { lost: 0.0, is_complete: false };
    let sizes = model.facts().typical_coordinates.clone();
    let fastest = v.iter().zip(&sizes).map(|(v, size)| v.abs() / size).fold(0.0, f64::max);
    let tolerances = sizes.iter().map(|size| TOLERANCE * fastest * size);
    let atol: Vec<f64> = tolerances.clone().map(|x| x * duration).chain(tolerances).collect();
    let first_step = if model.deepest_overlap(q).is_some() { h.min(FIRST_STEP * duration) } else { h };
    let options =
        radau::Options { atol: atol.into(), first_step: Some(first_step), ..radau::Options::default() };
    let t_span = (t, t + LONGEST * (end - t));
    let Ok(mut stepper) = radau::Stepper::new(q.len(), t_span, q, v, &options) else { return Ok(found) };
    stepper.set_accuracy(TOLERANCE);
    let mut intervals = ContactIntervals::new(q.len(), t_span.1, duration);
    while work_of(&stepper.counters()) <= allowed && !found.is_complete {
        if stepper.start(model)?.is_none() {
            intervals.end_at_contact(model, &mut stepper)?;
        }
        let status = stepper.step(model)?;
        model.set_time(stepper.t())?;
        let has_parted = stepper.t() >= end && model.deepest_overlap(stepper.q()).is_none();
        found.is_complete = has_parted || status == Some(Status::Finished);
        if status.is_some() {
            break;
        }
    }
    model.set_time(stepper.t())?;
    found.lost = before - model.energy(stepper.q(), stepper.v()).total();
    Ok(found)
}
