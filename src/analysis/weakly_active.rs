//! Weakly active constraints: stops, contacts and tendons with a gap of zero and no force. They do not resist motions to one side, so
//! that the stiffness must not contain them, although rounding of their gaps may activate them.

use crate::analysis::at_rest::{AtRest, LARGEST_RESIDUAL};
use crate::analysis::spring_forces::SpringForces;
use crate::analysis::ties::Ties;
use crate::model::constraint::saddle;
use crate::model::{Reached, Static};
#[cfg(feature = "python")]
use crate::numerics::linalg::Matrix;

/// A force is needed for equilibrium if the residual without it is larger by this factor. Out of equilibrium, rounding of stiff forces
/// changes the residual by less.
const RESIDUAL_OF_NEEDED_FORCE: f64 = 1.1;

/// Residual forces in a shape, with bounds of rounding.
struct Balance {
    residual: Vec<f64>,
    rounding: Vec<f64>,
    work: Vec<f64>,
}

impl Balance {
    /// `None` if the mass is singular or a number is not finite.
    fn of(
        model: &mut dyn Static,
        q: &[f64],
        sizes: &[f64],
        load_factor: f64,
        multipliers: &[f64],
    ) -> Option<Self> {
        let ties = Ties::new(model, q, sizes, load_factor);
        let springs = SpringForces::new(model, q, sizes, load_factor, multipliers, &ties)?;
        let mut at_rest =
            AtRest { model, q, sizes, load_factor, multipliers, ties: &ties, tie_forces: &springs.forces };
        let [residual, work] = at_rest.forces();
        let work = at_rest.most_work(&work);
        Some(Self { residual, rounding: springs.rounding(), work })
    }

    /// Whether the residual is within tolerance and rounding, or no larger than in another state.
    fn is_no_worse_than(&self, other: &Self) -> bool {
        (0..self.residual.len()).all(|k| {
            let tolerance = LARGEST_RESIDUAL * self.work[k].max(other.work[k]) + self.rounding[k];
            self.residual[k].abs() <= tolerance + RESIDUAL_OF_NEEDED_FORCE * other.residual[k].abs()
        })
    }
}

/// Disables the stops and contacts at their limits that are not needed for equilibrium, and returns these with the multipliers of the
/// constraints without them. The caller must undo this by [`decide`](crate::model::InContact::decide) with an empty list.
pub(crate) fn decide(
    model: &mut dyn Static,
    q: &[f64],
    sizes: &[f64],
    load_factor: f64,
    multipliers: &[f64],
) -> (Vec<Reached>, Vec<f64>) {
    let reached = model.reached(q);
    if reached.is_empty() {
        return (reached, multipliers.to_vec());
    }
    let balance = |model: &mut dyn Static, reached: &[Reached]| {
        model.decide(reached);
        let multipliers = active_multipliers(model, q, multipliers)?;
        Some((Balance::of(model, q, sizes, load_factor, &multipliers)?, multipliers))
    };
    let Some((whole, _)) = balance(model, &[]) else { return (Vec::new(), multipliers.to_vec()) };
    let without = |model: &mut dyn Static, reached: &[Reached]| {
        balance(model, reached)
            .filter(|(left, _)| left.is_no_worse_than(&whole))
            .map(|(_, multipliers)| multipliers)
    };
    if let Some(multipliers) = without(model, &reached) {
        return (reached, multipliers);
    }
    let (mut idle, mut multipliers) = (Vec::new(), multipliers.to_vec());
    for each in reached {
        idle.push(each);
        match without(model, &idle) {
            Some(by) => multipliers = by,
            None => _ = idle.pop(),
        }
    }
    model.decide(&idle);
    (idle, multipliers)
}

/// Stiffness, damping and mass of a model about rest at `q`, at the time set last, without weakly active forces and without
/// constraints. Allocates.
#[cfg(feature = "python")]
pub(crate) fn tangents(model: &mut dyn Static, q: &[f64]) -> [Matrix; 3] {
    let (n, m) = (q.len(), model.facts().constraints());
    let [mut sizes, rest] = [vec![0.0; n], vec![0.0; n]];
    model.sizes(q, &mut sizes);
    let multipliers = active_multipliers(model, q, &vec![0.0; m]).unwrap_or_else(|| vec![0.0; m]);
    let (mut reached, multipliers) = decide(model, q, &sizes, 1.0, &multipliers);
    if let Some((_, ties)) = SpringForces::with_ties(model, q, &sizes, 1.0, &multipliers) {
        reached.extend(ties.reached());
    }
    model.decide(&reached);
    let tangents = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|weights| {
        let mut tangent = Matrix::zeros(n, n);
        model.weighted_tangent(q, &rest, &rest, weights, &mut tangent);
        tangent
    });
    model.decide(&[]);
    tangents
}

/// Multipliers of the active constraints.
fn active_multipliers(model: &mut dyn Static, q: &[f64], multipliers: &[f64]) -> Option<Vec<f64>> {
    let mut active = multipliers.to_vec();
    if !active.is_empty() {
        let rest = vec![0.0; q.len()];
        saddle::multipliers(model, [q, &rest, &rest], &mut active).ok()?;
        model.set_multipliers(&vec![0.0; active.len()]);
    }
    Some(active)
}
