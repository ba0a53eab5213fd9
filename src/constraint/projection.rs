//! Projection of states onto constraints.

use super::saddle::MassSaddle;
use crate::linalg::Matrix;
use crate::model::{Model, SingularMass};

/// Gaps below this are rounding: metres, or differences of cosines.
const CLOSED: f64 = 1e-13;

/// Steps of the projection, which is Gauss and Newton's method: it converges quadratically from nearby.
const MAX_STEPS: usize = 100;

/// Gaps above this are no rounding; where a start has been left with one, so many shapes beside it are tried, whose coordinates
/// differ by this part of their typical sizes.
const STUCK: f64 = 1e-9;
const NUDGES: usize = 3;
const NUDGE: f64 = 0.01;

/// No step moves a coordinate by more than this, in units of its typical size.
const LONGEST: f64 = 0.3;

/// Constraints that are nearer to each other than this angle (radians) are at a singular position: accelerations there grow
/// with the inverse square of it, and so do their errors.
const SMALLEST_MARGIN: f64 = 1e-4;

/// Where no step is small enough, constraints are why that are nearer to each other than this angle, or of which one moves so
/// little beside the others: accelerations are at least ten thousand times those elsewhere.
const NEARLY_SINGULAR: f64 = 1e-2;
const NEARLY_IN_LINE: f64 = 1e-4;

/// What of a shape counts when it is moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Metric {
    /// Kinetic energy: of small corrections.
    Mass,
    /// Elastic energy, and where there is none the mass, moved within a second.
    Elastic,
}

impl Metric {
    fn of<M: Model + ?Sized>(self, model: &mut M, q: &[f64]) -> Matrix {
        let n = q.len();
        let mut mass = Matrix::zeros(n, n);
        model.mass_matrix(q, &mut mass);
        if self == Self::Mass {
            return mass;
        }
        let mut stiffness = Matrix::zeros(n, n);
        model.elastic_tangent(q, &mut stiffness);
        let sum = 0.5 * (&stiffness + stiffness.transpose()) + &mass;
        if sum.clone().cholesky().is_some() { sum } else { mass }
    }
}

fn largest(gaps: &[f64]) -> f64 {
    gaps.iter().fold(0.0, |largest: f64, gap| if gap.abs() <= largest { largest } else { gap.abs() })
}

/// Moves a shape until constraints hold, by as little as can be in a metric. Returns the largest gap that is left: not
/// small where they conflict or cannot be closed from there. Allocates.
///
/// At a singular shape, such as that of straight arms or of ends that coincide, no motion closes a gap to first order: shapes
/// beside a start there are tried, too.
pub(crate) fn close<M: Model + ?Sized>(
    model: &mut M,
    q: &mut [f64],
    metric: Metric,
) -> Result<f64, SingularMass> {
    let mut best = approach(model, q, metric)?;
    let mut sizes = vec![0.0; q.len()];
    model.typical_coordinates(&mut sizes);
    for attempt in 0..NUDGES {
        // Not finite gaps end here, too.
        if metric == Metric::Mass || !(best > STUCK && best.is_finite()) {
            break;
        }
        let mut other: Vec<f64> = q
            .iter()
            .zip(&sizes)
            .enumerate()
            .map(|(k, (q, size))| q + NUDGE * size * (1.7 * (k + 1) as f64 + attempt as f64).cos())
            .collect();
        let gap = approach(model, &mut other, metric)?;
        if gap <= STUCK {
            best = gap;
            q.copy_from_slice(&other);
        }
    }
    Ok(best)
}

/// Gauss and Newton's method from one shape, to the best one on its way.
fn approach<M: Model + ?Sized>(model: &mut M, q: &mut [f64], metric: Metric) -> Result<f64, SingularMass> {
    let mut sizes = vec![0.0; q.len()];
    model.typical_coordinates(&mut sizes);
    let mut gaps = vec![0.0; model.constraints()];
    model.gaps(q, &mut gaps);
    let mut gap = largest(&gaps);
    let mut best = (gap, q.to_vec());
    for _ in 0..MAX_STEPS {
        if !(gap > CLOSED && gap.is_finite()) {
            break;
        }
        let of_shape = metric.of(model, q);
        let (step, _) = MassSaddle::with(model, q, &of_shape)?.closing(&gaps);
        let longest = step.iter().zip(&sizes).map(|(x, size)| (x / size).abs()).fold(0.0, f64::max);
        let part = if longest > LONGEST { LONGEST / longest } else { 1.0 };
        q.iter_mut().zip(&step).for_each(|(q, step)| *q -= part * step);
        model.gaps(q, &mut gaps);
        let next = largest(&gaps);
        // Near rounding it no longer falls.
        let has_ended = part == 1.0 && next > 0.5 * gap && gap < STUCK;
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

/// How velocities were fitted to constraints.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fit {
    /// Twice the kinetic energy of the change, and its largest entry in typical sizes of the coordinates a second.
    pub(crate) change: f64,
    pub(crate) largest: f64,
    /// How many constraints are independent, and how nearly one of them is not: the sine of the smallest angle between one and
    /// the others, about.
    pub(crate) rank: usize,
    pub(crate) margin: f64,
    /// How little the constraint moves that moves least, beside the one that moves most.
    pub(crate) least_motion: f64,
}

impl Fit {
    /// Whether constraints are at a singular position.
    pub(crate) fn is_singular(&self) -> bool {
        self.margin <= SMALLEST_MARGIN
    }

    /// Whether constraints are so near to a singular position that no step from there may be small enough.
    pub(crate) fn is_nearly_singular(&self) -> bool {
        self.margin < NEARLY_SINGULAR || self.least_motion < NEARLY_IN_LINE
    }
}

/// Changes velocities by the smallest kinetic energy that makes them fit the constraints: as an impulse of what holds these
/// would. Allocates.
pub(crate) fn fit_velocities<M: Model + ?Sized>(
    model: &mut M,
    q: &[f64],
    v: &mut [f64],
) -> Result<Fit, SingularMass> {
    let mut rates = vec![0.0; model.constraints()];
    model.gap_rates(q, v, &mut rates);
    let saddle = MassSaddle::new(model, q)?;
    let (step, multipliers) = saddle.closing(&rates);
    v.iter_mut().zip(&step).for_each(|(v, step)| *v -= step);
    // M x = -G^T lambda, and G x are the rates.
    let change = rates.iter().zip(&multipliers).map(|(rate, multiplier)| -rate * multiplier).sum();
    let mut sizes = vec![0.0; v.len()];
    model.typical_coordinates(&mut sizes);
    let largest = step.iter().zip(&sizes).map(|(step, size)| (step / size).abs()).fold(0.0, f64::max);
    Ok(Fit {
        change,
        largest,
        rank: saddle.rank(),
        margin: saddle.margin(),
        least_motion: saddle.least_motion(),
    })
}
