//! Motions that grow without bound, told from steps that fail for other reasons.

use super::solution::Solution;
use super::status::{Failure, Status};
use crate::error::Time;

/// Growth of a velocity and of its acceleration during the second half of a motion, beyond which it runs away. A body that falls from rest
/// doubles its velocity, an impact changes accelerations alone; where time ends at a singularity both grow like its inverse distance, or faster.
const FASTER: f64 = 10.0;
const STRONGER: f64 = 100.0;

/// With fewer states nothing is said.
const FEWEST: usize = 10;

/// What happened, if the motion failed where it runs away.
pub(crate) fn sentence(solution: &Solution) -> Option<String> {
    let has_failed = matches!(
        solution.status,
        Status::StepFailed(Failure::NotConverged | Failure::NonFinite) | Status::StepTooSmall
    );
    let Solution { t, v, a, n, .. } = solution;
    let (&first, &last) = (t.first()?, t.last()?);
    if !has_failed || t.len() < FEWEST {
        return None;
    }
    let half = t.partition_point(|t| t - first <= 0.5 * (last - first));
    let growth = |values: &[f64], i: usize| {
        let early = values[..half * n].iter().skip(i).step_by(*n).fold(0.0, |most: f64, x| most.max(x.abs()));
        values[values.len() - n + i].abs() / early
    };
    (0..*n).find_map(|i| {
        let [faster, stronger] = [growth(v, i), growth(a, i)];
        // What did not move at all before may have been set in motion later.
        let runs_away = faster.is_finite() && faster > FASTER && stronger.is_finite() && stronger > STRONGER;
        runs_away.then(|| {
            format!(
                "The motion grows without bound: from t = {} to {} the velocity of coordinate {i} grows by a factor of {faster:.1e}, its \
                 acceleration by {stronger:.1e}. If the equations have no solution beyond, no step finds one: check the signs of forces, or \
                 end before.",
                Time(t[half - 1]),
                Time(last)
            )
        })
    })
}
