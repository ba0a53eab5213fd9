//! One-sided constraints, `g <= 0` with non-negative multipliers: inextensible tendons. The active set is
//! found iteratively: a constraint that would have to push is released, a violated one is activated.

use super::projection::{self, Metric};
use super::saddle;
use crate::model::{Model, SingularMass, Switch};

/// Switches that are tried for every constraint until it is clear which of them hold.
const SWITCHES: usize = 4;

/// How many switches are tried.
pub(crate) fn most_switches(constraints: usize) -> usize {
    SWITCHES * (constraints + 1)
}

/// Moves a shape until constraints hold ([`projection::close`]), without those that are open there and stay so. Returns the
/// largest gap that is left. Allocates.
pub(crate) fn close<M: Model + ?Sized>(
    model: &mut M,
    q: &mut [f64],
    metric: Metric,
) -> Result<f64, SingularMass> {
    model.release_open(q, None);
    let mut left = projection::close(model, q, metric)?;
    let mut none = vec![0.0; model.constraints()];
    for _ in 0..most_switches(none.len()) {
        if !model.is_one_sided() || model.switch(q, &mut none) == Switch::Nothing {
            break;
        }
        left = projection::close(model, q, metric)?;
    }
    Ok(left)
}

/// Accelerations and multipliers ([`saddle::accelerations`]) of those that hold in a state. Allocates.
pub(crate) fn accelerations<M: Model + ?Sized>(
    model: &mut M,
    q: &[f64],
    v: &[f64],
    a: &mut [f64],
    multipliers: &mut [f64],
) -> Result<(), SingularMass> {
    model.release_open(q, Some(v));
    until_settled(model, q, multipliers, |model, multipliers| {
        saddle::accelerations(model, q, v, a, multipliers)
    })
}

/// What holds the constraints in a motion ([`saddle::multipliers`]). Allocates.
pub(crate) fn multipliers<M: Model + ?Sized>(
    model: &mut M,
    state: [&[f64]; 3],
    multipliers: &mut [f64],
) -> Result<(), SingularMass> {
    let [q, ..] = state;
    model.release_open(q, None);
    until_settled(model, q, multipliers, |model, multipliers| saddle::multipliers(model, state, multipliers))
}

/// Finds multipliers until it is clear which constraints hold in a shape.
fn until_settled<M: Model + ?Sized>(
    model: &mut M,
    q: &[f64],
    multipliers: &mut [f64],
    mut find: impl FnMut(&mut M, &mut [f64]) -> Result<(), SingularMass>,
) -> Result<(), SingularMass> {
    find(model, multipliers)?;
    for _ in 0..most_switches(multipliers.len()) {
        if !model.is_one_sided() || model.switch(q, multipliers) == Switch::Nothing {
            break;
        }
        find(model, multipliers)?;
    }
    Ok(())
}
