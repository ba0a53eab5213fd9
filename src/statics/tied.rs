//! Equilibria of models with closed loops: loops are closed first, and then held by constraints. Of the
//! inextensible tendons, those in tension are active: a tendon that pushes is released, and a tendon that has
//! become too long is activated.

use super::{
    Continuation, ContinuationOptions, Equilibrium, Halted, Monitor, Options, Start, Status, outcome,
    tied_newton,
};
use crate::constraint::one_sided::{self, most_switches};
use crate::constraint::projection::{self, Metric};
use crate::constraint::{AsSprings, saddle};
use crate::error::{InvalidInput, Unfinished};
use crate::model::{Model, Switch};
use crate::{modes, stability};

/// Largest gap of loops that count as closed at rest: metres, or differences of cosines.
const CLOSED_AT_REST: f64 = 1e-9;

/// A shape near `q0` with closed loops. Rejects a shape from which there is none.
fn closed(model: &mut dyn Model, q0: &[f64]) -> Result<Vec<f64>, InvalidInput> {
    let mut q = q0.to_vec();
    // Without a mass matrix the shape is still valid.
    let _ = one_sided::close(model, &mut q, Metric::Elastic);
    match model.open_loop(&q) {
        None => Ok(q),
        Some(flaw) => {
            let expected =
                "one in which the loops are closed, or can be from there: loops that conflict never are";
            Err(InvalidInput::new("q0", format_args!("a start that {flaw}, as near as it gets"), expected))
        }
    }
}

/// Implements [`super::equilibrium`]. If the loops are closed without any force, loads grow from zero;
/// otherwise the shape is released from where the loops can be closed with the least energy.
pub(super) fn equilibrium(
    model: &mut dyn Model,
    options: &Options,
    monitor: Monitor<'_>,
) -> Result<Result<Equilibrium, Unfinished<Equilibrium>>, InvalidInput> {
    let rest = vec![0.0; model.n()];
    model.release_open(&rest, None);
    if let Start::Newton(q0) = &options.start
        && !model.is_one_sided()
    {
        // Newton's method on shape and multipliers together closes the loops; from nearby this is sufficient.
        match tied_newton::approach(model, q0, options, &mut *monitor) {
            Ok(found) => {
                if let Some(found) = found.judged(model) {
                    return Ok(Ok(found));
                }
            }
            Err(halted) => return Ok(Err(unfinished(model, halted, &options.start))),
        }
    }
    let mut start = match &options.start {
        Start::Unloaded { .. } => match widest(model, &rest) <= CLOSED_AT_REST {
            true => options.start.clone(),
            false => Start::Descent(closed(model, &rest)?),
        },
        Start::Descent(q0) => Start::Descent(closed(model, q0)?),
        Start::Newton(q0) => Start::Newton(closed(model, q0)?),
    };
    let mut multipliers = vec![0.0; model.constraints()];
    let mut switches = most_switches(multipliers.len());
    loop {
        if let Start::Newton(q) = &start {
            match tied_newton::approach(model, q, options, &mut *monitor) {
                Ok(found) => start = Start::Newton(found.q),
                Err(halted) => return Ok(Err(unfinished(model, halted, &start))),
            }
        }
        let q = match &start {
            Start::Unloaded { .. } => &rest,
            Start::Descent(q) | Start::Newton(q) => q,
        };
        let mut held = AsSprings::new(model, q);
        let options = Options { start: start.clone(), ..options.clone() };
        let found = match super::equilibrium(&mut held, &options, &mut *monitor)? {
            Ok(found) if found.status.is_success() && model.is_one_sided() => found,
            found => return Ok(found.map(|found| judged(model, found))),
        };
        // If multipliers are not unique, all constraints are active.
        let known = saddle::multipliers(model, [&found.q, &rest, &rest], &mut multipliers);
        if known.is_err() || model.switch(&found.q, &mut multipliers) == Switch::Nothing {
            return Ok(Ok(judged(model, found)));
        }
        if switches == 0 {
            let status = Status::Stalled;
            let message = outcome::message(status, found.load_factor, found.verdict, &found.path);
            return Ok(Ok(Equilibrium { status, message, ..found }));
        }
        switches -= 1;
        let mut q = found.q;
        // Without a mass matrix the shape is still valid.
        let _ = projection::close(model, &mut q, Metric::Elastic);
        start = if matches!(start, Start::Newton(_)) { Start::Newton(q) } else { Start::Descent(q) };
    }
}

/// The result until an interruption of Newton's method, with the loops held by springs.
fn unfinished(model: &mut dyn Model, halted: Halted, start: &Start) -> Unfinished<Equilibrium> {
    let near = start.shape(model.n());
    halted.unfinished(&mut AsSprings::new(model, &near), start)
}

/// Reports a failure if a loop is open. Judges stability by motions that keep the loops closed: motions
/// against almost rigid springs are so fast that rounding decides whether they grow.
fn judged(model: &mut dyn Model, found: Equilibrium) -> Equilibrium {
    if !found.status.is_success() {
        return found;
    }
    let status = model.open_loop(&found.q).map_or(found.status, Status::Flawed);
    let motions = modes::motions(model, &found.q).ok();
    let verdict = motions.and_then(|(motions, _)| stability::verdict(&motions)).or(found.verdict);
    let reached = found.path.load_factor.last().copied().unwrap_or(found.load_factor);
    let message = outcome::message(status, reached, verdict, &found.path);
    Equilibrium { status, message, verdict, ..found }
}

fn widest(model: &mut dyn Model, q: &[f64]) -> f64 {
    let mut gaps = vec![0.0; model.constraints()];
    model.gaps(q, &mut gaps);
    gaps.into_iter().fold(0.0, |widest, gap| if gap.abs() <= widest { widest } else { gap.abs() })
}

/// Implements [`super::continuation`].
pub(super) fn continuation(
    model: &mut dyn Model,
    options: &ContinuationOptions,
    monitor: Monitor<'_>,
) -> Result<Result<Continuation, Unfinished<Continuation>>, InvalidInput> {
    let rest = vec![0.0; model.n()];
    model.release_open(options.q0.as_deref().unwrap_or(&rest), None);
    let q0 = match &options.q0 {
        None if widest(model, &rest) <= CLOSED_AT_REST => None,
        None => Some(closed(model, &rest)?),
        Some(q0) => Some(closed(model, q0)?),
    };
    let mut held = AsSprings::new(model, q0.as_deref().unwrap_or(&rest));
    super::continuation(&mut held, &ContinuationOptions { q0, ..options.clone() }, monitor)
}
