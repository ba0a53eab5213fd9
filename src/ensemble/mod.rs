//! Many runs in threads, and the data kept of them.
//!
//! A row is one run. Which thread makes it is left to chance, but nothing that is kept depends on that: rows write to places
//! of their own, and what is taken over all rows is taken in groups that only their number decides, merged in their order.
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

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use crate::error::{Interrupted, InvalidInput};
use crate::model::{InTime as _, Model};
use crate::parallel;
use crate::robot::{Place, Pose, RobotModel};
use crate::simulate::{Simulation, Slack, Statistics, Status};

use self::kept::{Group, groups};

pub use self::spread::Spread;

/// The data kept of the runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keep {
    /// The states at all times.
    States,
    /// The last state.
    Final,
    /// The last state, the lowest and highest coordinates, and mean and variance of the places over all rows.
    Summary,
}

/// How many numbers an ensemble has of what.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Rows.
    pub count: usize,
    /// Times at which the states are known.
    pub times: usize,
    /// Coordinates.
    pub n: usize,
    /// Places that are followed.
    pub places: usize,
}

/// Entries of a homogeneous matrix.
pub const POSE: usize = 16;

/// Where the position stands in a homogeneous matrix that is written row by row.
const POSITION: [usize; 3] = [3, 7, 11];

/// Most groups of rows whose means are taken by themselves: enough for the threads of a large machine, few enough that
/// their memory does not matter.
const GROUPS: usize = 256;

impl Size {
    /// Times at which a row keeps its states.
    fn kept_times(&self, keep: Keep) -> usize {
        if keep == Keep::States { self.times } else { 1 }
    }

    /// Numbers that are kept of every row.
    fn of_row(&self, keep: Keep) -> usize {
        let extremes = if keep == Keep::Summary { 2 * self.n } else { 0 };
        let of_time = POSE.saturating_mul(self.places).saturating_add(2 * self.n);
        self.kept_times(keep).saturating_mul(of_time).saturating_add(extremes)
    }

    /// Numbers that an ensemble takes at most, in so many threads: what it keeps, and the runs that are under way.
    pub fn numbers(&self, keep: Keep, inputs: usize, workers: usize) -> usize {
        /// Of times, coordinates, velocities, accelerations and the flow of energy.
        const BESIDE: usize = 3;
        let of_run = self.times.saturating_mul(3 * self.n + inputs + BESIDE);
        let means = if keep == Keep::Summary { self.rows_of_groups().1 } else { 0 };
        let means = means.saturating_mul(2 * self.width_of_means());
        let rows = self.count.saturating_mul(self.of_row(keep));
        rows.saturating_add(means).saturating_add(of_run.saturating_mul(workers.min(self.count)))
    }

    fn width_of_means(&self) -> usize {
        self.times.saturating_mul(3 * self.places)
    }

    /// Rows of a group, and number of groups, where means are taken.
    fn rows_of_groups(&self) -> (usize, usize) {
        let rows = self.count.div_ceil(GROUPS).max(1);
        (rows, self.count.div_ceil(rows))
    }
}

/// A run of a row.
#[derive(Clone, Debug)]
pub struct Run {
    /// The outcome.
    pub simulation: Simulation,
    /// Its slack tendons.
    pub slack: Vec<Slack>,
    /// Homogeneous matrices, row by row, of the places at the last of its times: at all of them, or at less.
    pub poses: Vec<f64>,
}

/// How a run ended.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Its status.
    pub status: Status,
    /// The status in words.
    pub message: String,
    /// Why the motion may be far from the right one.
    pub doubt: Option<String>,
    /// Its slack tendons.
    pub slack: Vec<Slack>,
    /// Counts of steps, iterations and evaluations.
    pub statistics: Statistics,
    /// The last of its times; NaN where it has none.
    pub reached: f64,
}

/// The data kept of many runs. Missing values are NaN.
#[derive(Clone, Debug)]
pub struct Ensemble {
    /// How many numbers there are of what.
    pub size: Size,
    /// Coordinates, row by row: at all times one after the other, or at the last one.
    pub q: Vec<f64>,
    /// Velocities, likewise.
    pub v: Vec<f64>,
    /// Homogeneous matrices of the places, likewise.
    pub poses: Vec<f64>,
    /// The lowest and the highest coordinates of every row over its times, where they are wanted.
    pub extremes: Option<[Vec<f64>; 2]>,
    /// The positions of the places at all times, of the rows that succeeded, where their means are wanted.
    pub spread: Option<Spread>,
    /// How the runs ended; `None` of those that were not begun.
    pub outcomes: Vec<Option<Outcome>>,
    /// Seconds from the start to the end of all runs.
    pub wall_time: f64,
}

/// Sees the time of a run after every step, and may end it.
pub type Monitor<'a> = dyn FnMut(f64) -> Result<(), Interrupted> + 'a;

/// Makes the run of a row, in whatever thread.
pub type Runs<'a> = dyn Fn(usize, &mut Monitor<'_>) -> Result<Run, Refusal> + Sync + 'a;

/// Makes the runs of all rows, as many threads as `workers` says at once.
///
/// `run` makes that of a row and is asked by its monitor whether to go on. `watch` is told how many are done about twenty
/// times a second and may end the rest: runs under way then have the status "interrupted", others none. Where a run is
/// refused, or asks for an end, there is an end, too, and the refusal is returned beside what was done, with its row.
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
        let mut go_on = |_| if is_over.load(Ordering::Relaxed) { Err(Interrupted) } else { Ok(()) };
        for i in 0..group.rows() {
            go_on(0.0)?;
            match run(group.first + i, &mut go_on) {
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
    // Who ended it knows that; the rows say which were not made.
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

/// Why there are no more runs after one.
#[derive(Debug)]
pub enum Refusal {
    /// It makes no sense.
    Input(InvalidInput),
    /// What it calls asked for an end; what it has done so far.
    Ended(Box<Run>),
}

/// Where the places of a robot are at the times of a motion from the one of this number on: as many poses for each time.
/// Only a function of time can fail.
pub fn poses(
    model: &mut RobotModel,
    simulation: &Simulation,
    places: &[Place],
    from: usize,
) -> Result<Vec<Pose>, Interrupted> {
    let n = simulation.n;
    let mut poses = Vec::with_capacity(places.len() * (simulation.t.len() - from));
    for (i, &t) in simulation.t.iter().enumerate().skip(from) {
        if model.varies_in_time() {
            model.set_time(t)?;
        }
        let q = &simulation.q[i * n..][..n];
        poses.extend(places.iter().map(|place| model.pose_at(q, place)));
    }
    Ok(poses)
}

/// Where the [tip](Model::tip) of a model is at the times of a motion from the one of this number on, in its frame.
pub fn tips<M: Model + ?Sized>(model: &mut M, simulation: &Simulation, from: usize) -> Vec<[f64; 3]> {
    let n = simulation.n;
    (from..simulation.t.len()).map(|i| model.tip(&simulation.q[i * n..][..n])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::newmark;
    use crate::pendulum::SpringPendulum;
    use crate::simulate::{Method, simulate};

    const TIMES: usize = 11;

    fn size(count: usize) -> Size {
        Size { count, times: TIMES, n: 2, places: 1 }
    }

    /// A pendulum that swings out the farther the higher its row; its tip is its place.
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
    fn a_run_that_is_refused_ends_the_others_and_tells_its_row() {
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
