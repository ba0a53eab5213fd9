//! Models with closed loops and inextensible tendons: closed starts, and verdicts by motions that keep them closed.

use super::{
    AsSprings, Continuation, ContinuationOptions, Counters, Equilibrium, Monitor, Options, Status, outcome,
    search,
};
use crate::analysis::small_motions::{SmallMotions, small_motions};
use crate::analysis::{modes, stability};
use crate::error::{InvalidInput, Unfinished};
use crate::model::Static;
use crate::model::constraint::closing;
use crate::numerics::linalg::{symmetric_eigenvalues, symmetric_part};

/// Largest gap of loops that count as closed at rest, relative to the lengths of the joined parts.
const CLOSED_AT_REST: f64 = 1e-9;

/// Whether all loops are closed at zero coordinates.
pub(super) fn is_closed_at_rest(model: &mut dyn Static) -> bool {
    let rest = vec![0.0; model.facts().n];
    model.release_open(&rest, None);
    widest(model, &rest) <= CLOSED_AT_REST
}

/// A shape near `q0` with closed loops. Rejects a shape from which loops cannot be closed.
pub(super) fn closed(model: &mut dyn Static, q0: &[f64]) -> Result<Vec<f64>, InvalidInput> {
    let mut q = q0.to_vec();
    if model.facts().constraints() == 0 {
        return Ok(q);
    }
    closing::close(model, &mut q);
    match model.open_loop(&q) {
        None => Ok(q),
        Some(invalid_shape) => {
            let found = format_args!(
                "a start that {} and could not be closed",
                invalid_shape.with_loops(&model.facts().loops)
            );
            let expected =
                "a start closer to a closed shape; if there is none, loops that do not contradict each other";
            Err(InvalidInput::new("q0", found, expected))
        }
    }
}

/// Reports a failure if a loop is open. Judges stability by motions that keep the loops closed: motions
/// against almost rigid springs are so fast that rounding decides whether they grow. Unknown multipliers are computed without
/// accelerations.
pub(super) fn judged(
    model: &mut dyn Static,
    found: Equilibrium,
    multipliers: Option<&[f64]>,
    options: &Options,
) -> Equilibrium {
    if !found.status.is_success() || model.facts().constraints() == 0 {
        return found;
    }
    let status = match model.open_loop(&found.q) {
        Some(invalid_shape) => Status::Invalid(invalid_shape),
        None if search::is_open(model, &found.q) || search::multipliers_are_rounding(model, &found.q) => {
            Status::Stalled
        }
        None => found.status,
    };
    let reached = found.path.load_factor.last().copied().unwrap_or(found.load_factor);
    if !status.is_success() {
        let message = outcome::message(model, status, reached, options.stability, None, &found.path);
        return Equilibrium { status, message, ..found };
    }
    let motions = match multipliers {
        Some(multipliers) => {
            let mut sizes = vec![0.0; found.q.len()];
            model.sizes(&found.q, &mut sizes);
            small_motions(model, &found.q, &sizes, 1.0, multipliers)
        }
        None => modes::motions(model, &found.q).ok().map(|(motions, _)| motions),
    };
    let lowest = motions.as_ref().and_then(lowest).unwrap_or(f64::NAN);
    let verdict = motions.filter(|_| options.stability).and_then(|motions| stability::verdict(&motions));
    let message = outcome::message(model, status, reached, options.stability, verdict, &found.path);
    Equilibrium { status, message, verdict, lowest, ..found }
}

/// The smallest eigenvalue of a stiffness in normalised coordinates, of motions that keep the loops closed: one where nothing can
/// move.
pub(super) fn lowest(motions: &SmallMotions) -> Option<f64> {
    let values = symmetric_eigenvalues(&symmetric_part(&motions.stiffness))?;
    Some(values.first().map_or(1.0, |value| value.min(1.0)))
}

fn widest(model: &mut dyn Static, q: &[f64]) -> f64 {
    let mut gaps = vec![0.0; model.facts().constraints()];
    model.gaps(q, &mut gaps);
    let gaps = gaps.into_iter().zip(&model.facts().gap_sizes).map(|(gap, size)| gap / size);
    gaps.fold(0.0, |widest, gap| if gap.abs() <= widest { widest } else { gap.abs() })
}

/// Implements [`super::continuation`]. `counters` is what its start has cost.
pub(super) fn continuation(
    model: &mut dyn Static,
    options: &ContinuationOptions,
    counters: Counters,
    monitor: Monitor<'_>,
) -> Result<Result<Continuation, Unfinished<Continuation>>, InvalidInput> {
    let rest = vec![0.0; model.facts().n];
    model.release_open(options.q0.as_deref().unwrap_or(&rest), None);
    let q0 = match &options.q0 {
        None if widest(model, &rest) <= CLOSED_AT_REST => None,
        None => Some(closed(model, &rest)?),
        Some(q0) => Some(closed(model, q0)?),
    };
    let mut with_springs = AsSprings::new(model, q0.as_deref().unwrap_or(&rest));
    Ok(super::follow(&mut with_springs, &ContinuationOptions { q0, ..options.clone() }, counters, monitor))
}
