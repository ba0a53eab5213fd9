//! Paths of the tip, and distances between two motions.

use crate::error::Interrupted;
use crate::model::Model;
use crate::simulation::simulate::Simulation;

/// Minimum number of times at which runs are compared.
const MIN_COMPARED_TIMES: usize = 100;

/// If differences grow by this factor from the first half of the time to the second one, errors are
/// multiplied; otherwise they grow at most quadratically in time.
const GROWTH_OF_ERRORS: f64 = 100.0;

/// Number of evaluated tips between two calls of the monitor; a tip costs less than a step.
const TIPS_BETWEEN: usize = 16;

/// These times and, if they are few, additional ones: runs may agree by chance at one time, but not at all of
/// them. Invalid times are left for validation to reject.
pub(super) fn with_more_times(times: &[f64], (t0, t_end): (f64, f64)) -> Vec<f64> {
    let mut all = times.to_vec();
    let make_sense = times.iter().all(|t| (t0..=t_end).contains(t)) && times.is_sorted();
    if times.len() < MIN_COMPARED_TIMES && make_sense {
        all.extend(
            (0..=MIN_COMPARED_TIMES).map(|i| t0 + (t_end - t0) * (i as f64 / MIN_COMPARED_TIMES as f64)),
        );
        all.sort_by(f64::total_cmp);
        all.dedup();
    }
    all
}

/// Measured places at all times, one time after the other. `monitor` is called regularly with the end time
/// and may stop the evaluation.
pub(super) fn tips<M: Model>(
    model: &mut M,
    simulation: &Simulation,
    monitor: &mut dyn FnMut(f64) -> Result<(), Interrupted>,
) -> Result<Vec<[f64; 3]>, Interrupted> {
    let end = simulation.t.last().copied().unwrap_or(0.0);
    let mut tips = Vec::with_capacity(simulation.t.len());
    for (i, q) in simulation.q.chunks_exact(simulation.n.max(1)).enumerate() {
        if i.is_multiple_of(TIPS_BETWEEN) {
            monitor(end)?;
        }
        if model.facts().varies_in_time {
            model.set_time(simulation.t[i])?;
        }
        model.places(q, &mut tips);
    }
    Ok(tips)
}

/// Distances between two paths at each time.
pub(super) fn distances(a: &[[f64; 3]], b: &[[f64; 3]]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| size(&std::array::from_fn(|i| a[i] - b[i]))).collect()
}

/// Largest distance of paths over this number of times from their starts.
pub(super) fn range(tips: &[[f64; 3]], times: usize) -> f64 {
    let places = tips.len() / times.max(1);
    let starts = tips.iter().take(places).cycle().copied().take(tips.len());
    largest(&distances(tips, &starts.collect::<Vec<_>>()))
}

/// Radians by which joints turn altogether during a motion: all coordinates that turn but the increasing `others`.
pub(super) fn turned(motion: &Simulation, turns: &[bool], others: &[usize]) -> f64 {
    let joints: Vec<usize> =
        (0..motion.n).filter(|k| turns[*k] && others.binary_search(k).is_err()).collect();
    let rows: Vec<&[f64]> = motion.q.chunks_exact(motion.n.max(1)).collect();
    let of_pair = |pair: &[&[f64]]| joints.iter().map(|&k| (pair[1][k] - pair[0][k]).abs()).sum::<f64>();
    rows.windows(2).map(of_pair).sum()
}

pub(super) fn size(vector: &[f64; 3]) -> f64 {
    vector.iter().map(|x| x * x).sum::<f64>().sqrt()
}

pub(super) fn largest(distances: &[f64]) -> f64 {
    distances.iter().copied().fold(0.0, f64::max)
}

/// Whether the distances are far larger in the second half of the time than in the first one.
pub(super) fn grows(distances: &[f64]) -> bool {
    let (first, second) = distances.split_at(distances.len() / 2);
    largest(second) > GROWTH_OF_ERRORS * largest(first) && largest(first) > 0.0
}
