//! One-sided constraints, `g <= 0` with non-negative multipliers: inextensible tendons. The active set is
//! found iteratively: a constraint that would have to push is released, a violated one is activated.

use super::projection;
use super::saddle::{self, MassSaddle};
use crate::model::{SingularMass, Static, Switch};

/// In a given state, an inextensible tendon counts as taut if it is shorter than commanded by less than this part of the length of
/// what it joins ([`gap_sizes`](crate::model::Facts::gap_sizes)): above the error of a method, too small to matter. For the rates of
/// lengths, the same per second.
pub const TAUT: f64 = 1e-7;

/// A slack tendon becomes taut once it is longer than commanded by this part: well above rounding.
pub const ACTIVATION_EXCESS: f64 = 1e-10;

/// At a change of the active set, a tendon that shortens by more than this part per second is slack. Rounding of velocities that
/// satisfy the constraints is smaller.
pub const SLACKENING_RATE: f64 = 1e-9;

/// At a change of the active set, a tendon that is shorter by less than this part may be taut, and one that would be taut again
/// before it becomes shorter than that stays taut. Well above [`ACTIVATION_EXCESS`].
const NEARLY_TAUT: f64 = 10.0 * ACTIVATION_EXCESS;

/// Switches of the active set that are tried per constraint.
const MAX_SWITCHES: usize = 4;

/// Number of switches of the active set that are tried.
pub fn most_switches(constraints: usize) -> usize {
    MAX_SWITCHES * (constraints + 1)
}

/// Accelerations, and multipliers of the active constraints, in a state ([`saddle::accelerations`]). Allocates.
pub fn accelerations<M: Static + ?Sized>(
    model: &mut M,
    q: &[f64],
    v: &[f64],
    a: &mut [f64],
    multipliers: &mut [f64],
) -> Result<(), SingularMass> {
    model.release_open(q, Some(v));
    until_consistent(model, q, multipliers, |model, multipliers| {
        saddle::accelerations(model, q, v, a, multipliers)
    })
}

/// Multipliers of the active constraints in a motion ([`saddle::multipliers`]). Allocates.
pub fn multipliers<M: Static + ?Sized>(
    model: &mut M,
    state: [&[f64]; 3],
    multipliers: &mut [f64],
) -> Result<(), SingularMass> {
    let [q, ..] = state;
    model.release_open(q, None);
    until_consistent(model, q, multipliers, |model, multipliers| {
        saddle::multipliers(model, state, multipliers)
    })
}

/// Computes multipliers and switches constraints until the active set of a shape is consistent.
fn until_consistent<M: Static + ?Sized>(
    model: &mut M,
    q: &[f64],
    multipliers: &mut [f64],
    mut find: impl FnMut(&mut M, &mut [f64]) -> Result<(), SingularMass>,
) -> Result<(), SingularMass> {
    find(model, multipliers)?;
    for _ in 0..most_switches(multipliers.len()) {
        if !model.facts().is_one_sided || model.switch(q, multipliers) == Switch::Nothing {
            break;
        }
        find(model, multipliers)?;
    }
    Ok(())
}

/// Why no consistent set of active constraints was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ActiveSetFailure {
    /// A constraint is violated by this much, in metres: more than the error of a method.
    Violated(f64),
    /// No accelerations follow from the forces.
    SingularMass,
    /// With every set tried, a constraint pushes or is violated.
    Undecided,
}

impl From<SingularMass> for ActiveSetFailure {
    fn from(_: SingularMass) -> Self {
        Self::SingularMass
    }
}

/// The state after a change of the active constraints.
#[derive(Clone, Debug)]
pub struct Changed {
    /// Coordinates.
    pub q: Vec<f64>,
    /// Velocities.
    pub v: Vec<f64>,
    /// Accelerations, and multipliers behind them.
    pub a: Vec<f64>,
    /// Energy lost, and work of the drives of the constraints, in joules.
    pub flow: [f64; 2],
}

/// Finds the constraints that are active from this state on, and keeps them
/// ([`keep_active_set`](crate::model::OneSided::keep_active_set)). Constraints that are reached at a speed stop the motion by
/// impulses without rebound. `released` is a constraint that is no longer active. Allocates.
pub fn change(
    model: &mut dyn Static,
    state: [&[f64]; 2],
    released: Option<usize>,
) -> Result<Changed, ActiveSetFailure> {
    model.keep_active_set(false);
    let changed = changed(model, state, released);
    model.keep_active_set(true);
    changed
}

fn changed(
    model: &mut dyn Static,
    [q, v]: [&[f64]; 2],
    released: Option<usize>,
) -> Result<Changed, ActiveSetFailure> {
    let (n, m) = (q.len(), model.facts().constraints());
    let (mut q, mut v, mut a) = (q.to_vec(), v.to_vec(), vec![0.0; n + m]);
    let passed = model.passed(&q, &v);
    let first = m - passed.len();
    let sizes = model.facts().gap_sizes[first..].to_vec();
    let farthest = passed.iter().zip(&sizes).max_by(|([a, _], _), ([b, _], _)| a.total_cmp(b));
    if let Some(([by, _], size)) = farthest.filter(|([by, _], _)| *by > TAUT) {
        return Err(ActiveSetFailure::Violated(by * size));
    }
    let is_near = |i: usize| passed[i][0] >= -NEARLY_TAUT && released != Some(i);
    let mut may_hold = vec![1.0; m];
    for (i, may_hold) in may_hold[first..].iter_mut().enumerate() {
        *may_hold = if is_near(i) { 1.0 } else { 0.0 };
    }
    let (mut lost, before) = (0.0, model.energy(&q, &v).kinetic);
    if (0..passed.len()).any(|i| is_near(i) && passed[i][1] > SLACKENING_RATE) {
        (v, lost) = impulses(model, [&q, &v], &may_hold, first)?;
    }
    let near = may_hold.clone();
    let rates: Vec<f64> = model.passed(&q, &v).into_iter().map(|[_, rate]| rate).collect();
    for (rate, may_hold) in rates.iter().zip(&mut may_hold[first..]) {
        *may_hold = if *rate < -SLACKENING_RATE { 0.0 } else { *may_hold };
    }
    let rises = accelerate(model, [&q, &v], [&may_hold, &near], first, &mut a)?;
    // A constraint that would open and close again within `NEARLY_TAUT` stays active; otherwise it would switch ever faster.
    let mut has_others = false;
    for ((i, &rate), size) in (first..m).zip(&rates).zip(sizes) {
        if near[i] == 1.0 && may_hold[i] == 0.0 && rate * rate < 2.0 * rises[i] / size * NEARLY_TAUT {
            (may_hold[i], has_others) = (1.0, true);
        }
    }
    if has_others {
        model.release(&may_hold);
        lost += 0.5 * projection::fit_velocities(model, &q, &mut v)?.change;
        accelerate(model, [&q, &v], [&may_hold, &near], first, &mut a)?;
    }
    projection::close(model, &mut q)?;
    lost += 0.5 * projection::fit_velocities(model, &q, &mut v)?.change;
    let work = model.energy(&q, &v).kinetic - before + lost;
    let (accelerations, multipliers) = a.split_at_mut(n);
    saddle::accelerations(model, &q, &v, accelerations, multipliers)?;
    Ok(Changed { q, v, a, flow: [lost, work] })
}

/// Activates the constraints among those that may hold ([`hold_some`]) and computes accelerations and multipliers. Returns the gap
/// accelerations of the constraints that are nearly closed.
fn accelerate(
    model: &mut dyn Static,
    [q, v]: [&[f64]; 2],
    [may_hold, near]: [&[f64]; 2],
    first: usize,
    a: &mut [f64],
) -> Result<Vec<f64>, ActiveSetFailure> {
    let mut found = vec![0.0; near.len()];
    hold_some(model, may_hold, first, &mut |model, multipliers, rises| {
        saddle::accelerations(model, q, v, &mut a[..q.len()], multipliers)?;
        model.release(near);
        model.gap_accelerations(q, v, &a[..q.len()], rises);
        found.copy_from_slice(rises);
        Ok(())
    })?;
    Ok(found)
}

/// Velocities after the impulses of constraints that are reached at a speed, and the lost energy.
fn impulses(
    model: &mut dyn Static,
    [q, v]: [&[f64]; 2],
    may_hold: &[f64],
    first: usize,
) -> Result<(Vec<f64>, f64), ActiveSetFailure> {
    let (mut fitted, mut lost) = (v.to_vec(), 0.0);
    hold_some(model, may_hold, first, &mut |model, multipliers, rises| {
        let mut rates = vec![0.0; may_hold.len()];
        model.gap_rates(q, v, &mut rates);
        let (step, opposite) = MassSaddle::new(model, q)?.closing(&rates);
        fitted.iter_mut().zip(v).zip(step).for_each(|((fitted, v), step)| *fitted = v - step);
        multipliers.iter_mut().zip(&opposite).for_each(|(multiplier, opposite)| *multiplier = -opposite);
        lost = 0.5 * rates.iter().zip(multipliers).map(|(rate, multiplier)| rate * *multiplier).sum::<f64>();
        model.release(may_hold);
        model.gap_rates(q, &fitted, rises);
        Ok(())
    })?;
    Ok((fitted, lost))
}

/// Computes the multipliers of the active constraints, and the rises of all that may be active.
type Find<'a> = dyn FnMut(&mut dyn Static, &mut [f64], &mut [f64]) -> Result<(), SingularMass> + 'a;

/// Activates a set of the constraints in `may_hold`, of which those from `first` on are one-sided, such that multipliers are
/// non-negative and no inactive constraint rises. Pivoting by the least index (Murty 1974, "Note on a Bard-type scheme for solving the
/// complementarity problem"); ends if the constraints are independent.
fn hold_some(
    model: &mut dyn Static,
    may_hold: &[f64],
    first: usize,
    find: &mut Find<'_>,
) -> Result<(), ActiveSetFailure> {
    /// Multipliers and rises that are smaller than the largest ones by that factor are rounding.
    const ROUNDING: f64 = 1e-12;
    let m = may_hold.len();
    let [mut active, mut multipliers, mut rises] = [may_hold.to_vec(), vec![0.0; m], vec![0.0; m]];
    let mut largest: f64 = 0.0;
    for _ in 0..most_switches(m) * m.max(1) {
        model.release(&active);
        find(model, &mut multipliers, &mut rises)?;
        let size = |values: &[f64]| values[first..].iter().fold(0.0, |size: f64, x| size.max(x.abs()));
        largest = largest.max(size(&rises));
        let [slightest_pull, slightest_rise] = [size(&multipliers), largest].map(|size| ROUNDING * size);
        let fits = |i: usize| match active[i] == 0.0 {
            true => may_hold[i] == 0.0 || rises[i] <= slightest_rise,
            false => multipliers[i] >= -slightest_pull,
        };
        let Some(other) = (first..m).find(|&i| !fits(i)) else {
            model.release(&active);
            return Ok(());
        };
        active[other] = 1.0 - active[other];
    }
    Err(ActiveSetFailure::Undecided)
}
