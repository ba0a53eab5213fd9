//! Storage for the results of rows.

use super::spread::Spread;
use super::stored::{Ensemble, Keep, Outcome, POSE, POSITION, Run};

/// Consecutive rows with their part of the kept data.
pub(super) struct Group<'a> {
    pub(super) first: usize,
    keep: Keep,
    places: usize,
    outcomes: &'a mut [Option<Outcome>],
    q: &'a mut [f64],
    v: &'a mut [f64],
    poses: &'a mut [f64],
    extremes: [&'a mut [f64]; 2],
    spread: Spread,
}

/// Splits an ensemble into single rows, or into the groups over which means are accumulated.
pub(super) fn groups(ensemble: &mut Ensemble, keep: Keep) -> Vec<Group<'_>> {
    let size = ensemble.size;
    let (rows, width) = match keep {
        Keep::Summary => (size.rows_of_groups().0, size.width_of_means()),
        Keep::States | Keep::Final => (1, 0),
    };
    let count = size.count;
    let mut q = Parts::new(&mut ensemble.q, rows, count);
    let mut v = Parts::new(&mut ensemble.v, rows, count);
    let mut poses = Parts::new(&mut ensemble.poses, rows, count);
    let [lowest, highest]: [&mut [f64]; 2] = match &mut ensemble.extremes {
        Some([lowest, highest]) => [lowest.as_mut_slice(), highest.as_mut_slice()],
        None => [&mut [], &mut []],
    };
    let [mut lowest, mut highest] = [lowest, highest].map(|values| Parts::new(values, rows, count));
    let groups = ensemble.outcomes.chunks_mut(rows).enumerate().map(|(i, outcomes)| Group {
        first: i * rows,
        keep,
        places: size.places,
        outcomes,
        q: q.next_part(),
        v: v.next_part(),
        poses: poses.next_part(),
        extremes: [lowest.next_part(), highest.next_part()],
        spread: Spread::new(width),
    });
    groups.collect()
}

/// Remaining values, of which every row has the same number.
struct Parts<'a> {
    rest: &'a mut [f64],
    width: usize,
}

impl<'a> Parts<'a> {
    /// Splits `values` with `count` numbers per row into parts of `rows` rows; the last part may be smaller.
    fn new(values: &'a mut [f64], rows: usize, count: usize) -> Self {
        let width = values.len() / count.max(1) * rows;
        Self { rest: values, width }
    }

    fn next_part(&mut self) -> &'a mut [f64] {
        let rest = std::mem::take(&mut self.rest);
        let (part, rest) = rest.split_at_mut(self.width.min(rest.len()));
        self.rest = rest;
        part
    }
}

/// Values of a row within its group.
fn of_row(values: &mut [f64], row: usize, rows: usize) -> &mut [f64] {
    let width = values.len() / rows;
    &mut values[row * width..(row + 1) * width]
}

/// Writes values, followed by NaN.
fn write(kept: &mut [f64], values: &[f64]) {
    let (known, unknown) = kept.split_at_mut(values.len());
    known.copy_from_slice(values);
    unknown.fill(f64::NAN);
}

/// The last `width` values, or none.
fn last(values: &[f64], width: usize) -> &[f64] {
    &values[values.len() - width.min(values.len())..]
}

impl Group<'_> {
    pub(super) fn rows(&self) -> usize {
        self.outcomes.len()
    }

    pub(super) fn spread(&self) -> &Spread {
        &self.spread
    }

    /// Stores the data to be kept of a row's run.
    pub(super) fn keep(&mut self, row: usize, run: Run) {
        let Run { simulation, slack, poses } = run;
        let (rows, n) = (self.rows(), simulation.n);
        let all = self.keep == Keep::States;
        let kept = |values: &mut [f64], found: &[f64], width| {
            write(of_row(values, row, rows), if all { found } else { last(found, width) });
        };
        kept(self.q, &simulation.q, n);
        kept(self.v, &simulation.v, n);
        kept(self.poses, &poses, self.places * POSE);
        if self.keep == Keep::Summary {
            let better: [fn(f64, f64) -> f64; 2] = [f64::min, f64::max];
            for (extremes, better) in self.extremes.iter_mut().zip(better) {
                let extremes = of_row(extremes, row, rows);
                extremes.fill(f64::NAN);
                if n > 0 {
                    for q in simulation.q.chunks_exact(n) {
                        extremes.iter_mut().zip(q).for_each(|(extreme, &q)| *extreme = better(*extreme, q));
                    }
                }
            }
            if simulation.status.is_success() {
                self.spread.add(poses.chunks_exact(POSE).flat_map(|pose| POSITION.map(|i| pose[i])));
            }
        }
        let reached = simulation.t.last().copied().unwrap_or(f64::NAN);
        let message =
            slack.iter().fold(simulation.message, |message, slack| format!("{message} {}", slack.sentence()));
        self.outcomes[row] = Some(Outcome {
            status: simulation.status,
            message,
            doubt: simulation.doubt,
            slack,
            statistics: simulation.statistics,
            reached,
        });
    }

    /// Sets the data of rows that were not started to NaN.
    pub(super) fn forget_what_was_not_begun(&mut self) {
        let rows = self.rows();
        for row in (0..rows).filter(|&row| self.outcomes[row].is_none()) {
            let [lowest, highest] = &mut self.extremes;
            for values in [&mut *self.q, &mut *self.v, &mut *self.poses, lowest, highest] {
                of_row(values, row, rows).fill(f64::NAN);
            }
        }
    }
}
