//! Stored data of many runs.

use super::spread::Spread;
use crate::simulation::simulate::{Simulation, Slack, Statistics, Status};

/// Data stored of the runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keep {
    /// The states at all times.
    States,
    /// The last state.
    Final,
    /// The last state, the minimum and maximum of the coordinates, and mean and variance of the places over
    /// all rows.
    Summary,
}

/// Dimensions of an ensemble.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Number of rows.
    pub count: usize,
    /// Number of times of the states.
    pub times: usize,
    /// Number of coordinates.
    pub n: usize,
    /// Number of recorded places.
    pub places: usize,
}

/// Number of entries of a homogeneous matrix.
pub const POSE: usize = 16;

/// Indices of the position in a row-major homogeneous matrix.
pub(super) const POSITION: [usize; 3] = [3, 7, 11];

/// Maximum number of groups with separate means: enough for the threads of a large machine, with negligible
/// memory.
const GROUPS: usize = 256;

impl Size {
    /// Number of times at which a row stores its states.
    pub(super) fn kept_times(&self, keep: Keep) -> usize {
        if keep == Keep::States { self.times } else { 1 }
    }

    /// Number of values stored per row.
    pub(super) fn of_row(&self, keep: Keep) -> usize {
        let extremes = if keep == Keep::Summary { 2 * self.n } else { 0 };
        let of_time = POSE.saturating_mul(self.places).saturating_add(2 * self.n);
        self.kept_times(keep).saturating_mul(of_time).saturating_add(extremes)
    }

    /// Maximum number of values of an ensemble with this number of threads: stored data plus runs in
    /// progress.
    pub fn numbers(&self, keep: Keep, inputs: usize, workers: usize) -> usize {
        /// Additional values: times, coordinates, velocities, accelerations and energy flow.
        const OTHER_VALUES: usize = 3;
        let of_run = self.times.saturating_mul(3 * self.n + inputs + OTHER_VALUES);
        let means = if keep == Keep::Summary { self.rows_of_groups().1 } else { 0 };
        let means = means.saturating_mul(2 * self.width_of_means());
        let rows = self.count.saturating_mul(self.of_row(keep));
        rows.saturating_add(means).saturating_add(of_run.saturating_mul(workers.min(self.count)))
    }

    pub(super) fn width_of_means(&self) -> usize {
        self.times.saturating_mul(3 * self.places)
    }

    /// Rows per group and number of groups for means.
    pub(super) fn rows_of_groups(&self) -> (usize, usize) {
        let rows = self.count.div_ceil(GROUPS).max(1);
        (rows, self.count.div_ceil(rows))
    }
}

/// Run of a row.
#[derive(Clone, Debug)]
pub struct Run {
    /// Result of the run.
    pub simulation: Simulation,
    /// Slack tendons during the run.
    pub slack: Vec<Slack>,
    /// Row-major homogeneous matrices of the places, at all times or at the last ones.
    pub poses: Vec<f64>,
}

/// Outcome of a run.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Status.
    pub status: Status,
    /// Status in words.
    pub message: String,
    /// Reason to doubt the motion, if any.
    pub doubt: Option<String>,
    /// Slack tendons during the run.
    pub slack: Vec<Slack>,
    /// Counts of steps, iterations and evaluations.
    pub statistics: Statistics,
    /// Last time that was reached; NaN if none was.
    pub reached: f64,
}

/// Stored results of many runs. Missing values are NaN.
#[derive(Clone, Debug)]
pub struct Ensemble {
    /// Dimensions.
    pub size: Size,
    /// Coordinates, row by row: all times in sequence, or the last time.
    pub q: Vec<f64>,
    /// Velocities, in the same layout.
    pub v: Vec<f64>,
    /// Homogeneous matrices of the places, in the same layout.
    pub poses: Vec<f64>,
    /// Minimum and maximum of each coordinate over the times of each row, if requested.
    pub extremes: Option<[Vec<f64>; 2]>,
    /// Positions of the places at all times over the successful rows, if statistics are requested.
    pub spread: Option<Spread>,
    /// Outcomes of the runs; `None` for runs that were not started.
    pub outcomes: Vec<Option<Outcome>>,
    /// Wall-clock time of all runs, in seconds.
    pub wall_time: f64,
}
