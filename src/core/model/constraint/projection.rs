//! Projection of states onto constraints.

use super::saddle::{MassSaddle, accelerations_by};
use crate::model::{SingularMass, Static};

/// Gaps below this part of the lengths of the joined parts are rounding.
const ROUNDING_GAP: f64 = 1e-13;

/// Below this, the projection ends once gaps stop falling.
const NEARLY_CLOSED_GAP: f64 = 1e-9;

/// Steps of the projection, which is Gauss and Newton's method: it converges quadratically from nearby.
const MAX_STEPS: usize = 100;

/// No step moves a coordinate by more than this, in units of its typical size.
const LONGEST_STEP: f64 = 0.3;

/// Constraints whose rows enclose less than this angle (radians) are at a singular position: accelerations grow with its inverse
/// square, and so do their errors.
const SMALLEST_MARGIN: f64 = 1e-4;

/// If no step is small enough, constraints are named as the reason if their rows enclose less than this angle, or one moves less
/// than another by this factor: accelerations are then at least ten thousand times those elsewhere.
const NEARLY_SINGULAR: f64 = 1e-2;
const NEARLY_IN_LINE: f64 = 1e-4;

fn largest(gaps: &[f64], sizes: &[f64]) -> f64 {
    let beside = gaps.iter().zip(sizes).map(|(gap, size)| (gap / size).abs());
    beside.fold(0.0, |largest, gap| if gap <= largest { largest } else { gap })
}

/// Projects a shape that nearly satisfies its constraints onto them, in the metric of the mass matrix. Returns the largest
/// remaining gap, in [`gap_sizes`](crate::model::Facts::gap_sizes). Allocates.
pub fn close<M: Static + ?Sized>(model: &mut M, q: &mut [f64]) -> Result<f64, SingularMass> {
    let m = model.facts().constraints();
    let (sizes, gap_sizes) = (model.facts().typical_coordinates.clone(), model.facts().gap_sizes.clone());
    let mut gaps = vec![0.0; m];
    model.gaps(q, &mut gaps);
    let mut gap = largest(&gaps, &gap_sizes);
    let mut best = (gap, q.to_vec());
    for _ in 0..MAX_STEPS {
        if !(gap > ROUNDING_GAP && gap.is_finite()) {
            break;
        }
        let (step, _) = MassSaddle::new(model, q)?.closing(&gaps);
        let longest = step.iter().zip(&sizes).map(|(x, size)| (x / size).abs()).fold(0.0, f64::max);
        let part = if longest > LONGEST_STEP { LONGEST_STEP / longest } else { 1.0 };
        q.iter_mut().zip(&step).for_each(|(q, step)| *q -= part * step);
        model.gaps(q, &mut gaps);
        let next = largest(&gaps, &gap_sizes);
        // Near rounding the gap no longer falls.
        let has_ended = part == 1.0 && next > 0.5 * gap && gap < NEARLY_CLOSED_GAP;
        gap = next;
        if gap < best.0 {
            best = (gap, q.to_vec());
        }
        if has_ended {
            break;
        }
    }
    q.copy_from_slice(&best.1);
    Ok(best.0)
}

/// Result of the projection of velocities onto constraints.
#[derive(Clone, Copy, Debug)]
pub struct Fit {
    /// Twice the kinetic energy of the change.
    pub change: f64,
    /// Its largest entry, in typical sizes of the coordinates per second.
    pub largest: f64,
    /// Number of independent constraints, and roughly the sine of the smallest angle between one of them and the span of the
    /// others.
    pub rank: usize,
    pub(crate) margin: f64,
    /// Length of the shortest row of the constraint Jacobian over that of the longest, in the metric of the mass.
    pub(crate) least_motion: f64,
}

impl Fit {
    /// Whether constraints are at a singular position.
    pub fn is_singular(&self) -> bool {
        self.margin <= SMALLEST_MARGIN
    }

    /// Whether constraints are so close to a singular position that no step from there may be small enough.
    pub fn is_nearly_singular(&self) -> bool {
        self.margin < NEARLY_SINGULAR || self.least_motion < NEARLY_IN_LINE
    }
}

/// Projects velocities onto the constraints in the metric of the mass matrix, as impulses of the constraints would. Allocates.
pub fn fit_velocities<M: Static + ?Sized>(
    model: &mut M,
    q: &[f64],
    v: &mut [f64],
) -> Result<Fit, SingularMass> {
    Ok(fit_by(&MassSaddle::new(model, q)?, model, q, v))
}

/// The same; also writes the accelerations of that state, followed by the multipliers, to `unknowns`. Allocates.
pub fn fit_motion<M: Static + ?Sized>(
    model: &mut M,
    q: &[f64],
    v: &mut [f64],
    unknowns: &mut [f64],
) -> Result<Fit, SingularMass> {
    let mut saddle = MassSaddle::new(model, q)?;
    let fit = fit_by(&saddle, model, q, v);
    let (a, multipliers) = unknowns.split_at_mut(q.len());
    accelerations_by(&mut saddle, model, [q, v], a, multipliers);
    Ok(fit)
}

fn fit_by<M: Static + ?Sized>(saddle: &MassSaddle, model: &mut M, q: &[f64], v: &mut [f64]) -> Fit {
    let mut rates = vec![0.0; model.facts().constraints()];
    model.gap_rates(q, v, &mut rates);
    let (step, multipliers) = saddle.closing(&rates);
    v.iter_mut().zip(&step).for_each(|(v, step)| *v -= step);
    // M x = -G^T lambda, and G x are the rates.
    let change = rates.iter().zip(&multipliers).map(|(rate, multiplier)| -rate * multiplier).sum();
    let sizes = &model.facts().typical_coordinates;
    let largest = step.iter().zip(sizes).map(|(step, size)| (step / size).abs()).fold(0.0, f64::max);
    Fit { change, largest, rank: saddle.rank(), margin: saddle.margin(), least_motion: saddle.least_motion() }
}
