//! Many runs in threads, and their stored results.
//!
//! A row is one run. The assignment of rows to threads is not deterministic, but the results are: each row
//! writes to its own part, and statistics over rows are accumulated in groups that depend only on the number
//! of rows, and merged in order.
//!
//! ```
//! use lissom::ensemble::{Keep, Refusal, Run, Runs, Size, simulate_many};
//! use lissom::newmark;
//! use lissom::robot::{Rod, RobotModel};
//! use lissom::rod::Segment;
//! use lissom::simulate::{Method, simulate};
//!
//! let segment = Segment { modes: [0, 3, 0, 0, 0, 0], ..Segment::straight(1.0, 1e-3, 210e9, 80e9, 7800.0) };
//! let wire = RobotModel::of_rod(&Rod::new(vec![segment]))?;
//! let method = Method::Newmark(newmark::Options::new(1e-2));
//! // Every row is released from another curvature.
//! let run: &Runs<'_> = &|row, monitor| {
//!     let q0 = [0.1 * row as f64, 0.0, 0.0];
//!     let simulation = simulate(wire.clone(), (0.0, 0.1), &q0, &[0.0; 3], &method, None, monitor)
//!         .map_err(Refusal::Input)?;
//!     Ok(Run { simulation, slack: Vec::new(), poses: Vec::new() })
//! };
//! let size = Size { count: 8, times: 11, n: 3, places: 0 };
//! let (ensemble, ended) = simulate_many(size, Keep::Final, 2, run, &mut |_| Ok(()));
//! assert!(ended.is_ok() && ensemble.q.len() == 8 * 3);
//! # Ok::<(), lissom::error::InvalidInput>(())
//! ```

mod kept;
mod spread;
mod stored;

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use crate::error::{Interrupted, InvalidInput};
use crate::model::{Dynamics, InTime as _, Model};
use crate::numerics::parallel;
use crate::robot::{Place, Pose, RobotModel};
use crate::simulation::simulate::Simulation;

use self::kept::{Group, groups};

pub use self::spread::Spread;
pub use self::stored::{Ensemble, Keep, Outcome, POSE, Run, Size};

/// Called with the time of a run after every step; may stop the run.
pub type Monitor<'a> = dyn FnMut(f64) -> Result<(), Interrupted> + 'a;

/// Computes the run of a row, in any thread.
pub type Runs<'a> = dyn Fn(usize, &mut Monitor<'_>) -> Result<Run, Refusal> + Sync + 'a;

/// Computes the runs of all rows in `workers` threads.
///
/// `run` computes one row and calls its monitor after every step. `watch` is called with the number of
/// finished runs about twenty times a second and may stop the ensemble: runs in progress then have the status
/// "interrupted", and rows that were not started have no outcome. A rejected or stopped run also stops the
/// ensemble; the refusal is returned with its row, beside the results so far.
pub fn simulate_many(
    size: Size,
    keep: Keep,
    workers: usize,
    run: &Runs<'_>,
    watch: &mut dyn FnMut(usize) -> Result<(), Interrupted>,
) -> (Ensemble, Result<(), (usize, InvalidInput)>) {
    let start = Instant::now();
    let Size { count, n, places, .. } = size;
    let times = size.kept_times(keep);
    let of = |width: usize| vec![0.0; count * width];
    let is_summary = keep == Keep::Summary;
    let mut ensemble = Ensemble {
        size,
        q: of(times * n),
        v: of(times * n),
        poses: of(times * places * POSE),
        extremes: is_summary.then(|| [of(n), of(n)]),
        spread: None,
        outcomes: vec![None; count],
        wall_time: 0.0,
    };
    let done = AtomicUsize::new(0);
    let refused = Mutex::new(None);
    let mut all = groups(&mut ensemble, keep);
    let work = |group: &mut Group<'_>, is_over: &AtomicBool| {
        let mut check_interrupt = |_| if is_over.load(Ordering::Relaxed) { Err(Interrupted) } else { Ok(()) };
        for i in 0..group.rows() {
            check_interrupt(0.0)?;
            match run(group.first + i, &mut check_interrupt) {
                Ok(run) => group.keep(i, run),
                Err(Refusal::Input(error)) => {
                    refused
                        .lock()
                        .unwrap_or_else(PoisonError::into_inner)
                        .get_or_insert((group.first + i, error));
                    return Err(Interrupted);
                }
                Err(Refusal::Ended(run)) => {
                    group.keep(i, *run);
                    return Err(Interrupted);
                }
            }
            done.fetch_add(1, Ordering::Relaxed);
        }
        Ok(())
    };
    // `watch` has the reason; outcomes show which rows are missing.
    let _ = parallel::for_each(&mut all, workers, work, &mut || watch(done.load(Ordering::Relaxed)));
    let spread = is_summary.then(|| {
        let mut spread = Spread::new(size.width_of_means());
        all.iter().for_each(|group| spread.merge(group.spread()));
        spread
    });
    all.iter_mut().for_each(Group::forget_what_was_not_begun);
    drop(all);
    ensemble.spread = spread;
    ensemble.wall_time = start.elapsed().as_secs_f64();
    let refused = refused.into_inner().unwrap_or_else(PoisonError::into_inner);
    (ensemble, refused.map_or(Ok(()), Err))
}

/// Reason to stop the ensemble after a run.
#[derive(Debug)]
pub enum Refusal {
    /// The input of the run is invalid.
    Input(InvalidInput),
    /// A callback stopped the run; contains the results so far.
    Ended(Box<Run>),
}

/// Poses of the places of a robot at the times of a motion, starting with time index `from`; the same number
/// of poses for each time. Only a function of time can fail.
pub fn poses(
    model: &mut RobotModel,
    simulation: &Simulation,
    places: &[Place],
    from: usize,
) -> Result<Vec<Pose>, Interrupted> {
    let n = simulation.n;
    let mut poses = Vec::with_capacity(places.len() * (simulation.t.len() - from));
    for (i, &t) in simulation.t.iter().enumerate().skip(from) {
        if model.facts().varies_in_time {
            model.set_time(t)?;
        }
        let q = &simulation.q[i * n..][..n];
        poses.extend(places.iter().map(|place| model.pose_at(q, place)));
    }
    Ok(poses)
}

/// Positions of the [tip](Dynamics::tip) of a model, in its frame, at the times of a motion, starting with time
/// index `from`.
pub fn tips<M: Model + ?Sized>(model: &mut M, simulation: &Simulation, from: usize) -> Vec<[f64; 3]> {
    let n = simulation.n;
    (from..simulation.t.len()).map(|i| model.tip(&simulation.q[i * n..][..n])).collect()
}

#[cfg(test)]
mod tests {
    use super::stored::POSITION;
    use super::*;
    use crate::integrators::newmark;
    use crate::model::pendulum::SpringPendulum;
    use crate::simulation::simulate::{Method, simulate};

    const TIMES: usize = 11;

    fn size(count: usize) -> Size {
        Size { count, times: TIMES, n: 2, places: 1 }
    }

    /// A pendulum whose amplitude increases with the row; its place is its tip.
    fn run_of(row: usize, monitor: &mut Monitor<'_>) -> Result<Run, Refusal> {
        let mut pendulum = SpringPendulum::new(1.0, 1.0, 50.0, 9.81).unwrap();
        let start = [0.01 * row as f64, 0.1];
        let method = Method::Newmark(newmark::Options::new(1e-2));
        let simulation = simulate(pendulum.clone(), (0.0, 0.1), &start, &[0.0; 2], &method, None, monitor)
            .map_err(Refusal::Input)?;
        let matrices = tips(&mut pendulum, &simulation, 0).into_iter().flat_map(|[x, y, z]| {
            let mut matrix = [0.0; POSE];
            POSITION.iter().zip([x, y, z]).for_each(|(&i, x)| matrix[i] = x);
            matrix
        });
        let poses = matrices.collect();
        Ok(Run { simulation, slack: Vec::new(), poses })
    }

    fn all(count: usize, keep: Keep, workers: usize) -> Ensemble {
        let (ensemble, refused) = simulate_many(size(count), keep, workers, &run_of, &mut |_| Ok(()));
        refused.unwrap();
        ensemble
    }

    #[test]
    fn a_summary_is_that_of_the_states_whatever_the_threads() {
        for count in [1, 5, 600] {
            let states = all(count, Keep::States, 2);
            let summary = all(count, Keep::Summary, 1);
            let [lowest, highest] = summary.extremes.clone().unwrap();
            for (row, q) in states.q.chunks_exact(2 * TIMES).enumerate() {
                assert_eq!(q[2 * (TIMES - 1)..], summary.q[2 * row..][..2]);
                for i in 0..2 {
                    let path = q.iter().skip(i).step_by(2).copied();
                    assert_eq!(path.clone().fold(f64::INFINITY, f64::min), lowest[2 * row + i]);
                    assert_eq!(path.fold(f64::NEG_INFINITY, f64::max), highest[2 * row + i]);
                }
            }
            let spread = summary.spread.as_ref().unwrap();
            assert_eq!((spread.samples(), spread.mean().len()), (count, 3 * TIMES));
            for workers in [2, 7] {
                let other = all(count, Keep::Summary, workers);
                assert_eq!((other.spread.as_ref(), other.q), (Some(spread), summary.q.clone()));
            }
        }
    }

    #[test]
    fn a_run_that_is_refused_ends_the_others_and_names_its_row() {
        let run = |row: usize, monitor: &mut Monitor<'_>| match row {
            3 => Err(Refusal::Input(InvalidInput::new("q0", "nothing", "something"))),
            _ => run_of(row, monitor),
        };
        let (ensemble, refused) = simulate_many(size(9), Keep::States, 1, &run, &mut |_| Ok(()));
        assert_eq!(refused.unwrap_err().0, 3);
        let begun: Vec<bool> = ensemble.outcomes.iter().map(Option::is_some).collect();
        assert_eq!(begun, [true, true, true, false, false, false, false, false, false]);
        let known: Vec<bool> = ensemble.q.chunks_exact(2 * TIMES).map(|q| q[0].is_finite()).collect();
        assert_eq!(known, begun);
    }

    #[test]
    fn the_numbers_of_an_ensemble_are_those_that_it_has() {
        for keep in [Keep::States, Keep::Final, Keep::Summary] {
            let Ensemble { q, v, poses, extremes, .. } = all(40, keep, 1);
            let kept =
                q.len() + v.len() + poses.len() + extremes.iter().flatten().map(Vec::len).sum::<usize>();
            assert_eq!(size(40).of_row(keep) * 40, kept);
            assert!(size(40).numbers(keep, 0, 2) >= kept);
        }
        assert_eq!(size(usize::MAX).numbers(Keep::States, 0, 1), usize::MAX);
    }
}
