//! End times of steps with fixed size.

use crate::description::signal::{Cell, rounding_of_times};
use crate::numerics::tape::Tape;

/// Steps are counted so that a remainder of less than this fraction of a step is rounding, not another step.
pub(crate) const ROUNDING_OF_STEPS: f64 = 1e-9;

/// Number of steps of size `dt` that an interval takes, the last one perhaps shorter; saturates.
pub(crate) fn number_of_steps(length: f64, dt: f64) -> usize {
    (length / dt * (1.0 - ROUNDING_OF_STEPS)).ceil() as usize
}

/// Steps of one size `h` from an origin: the k-th ends at `origin + k h`, so that no rounding adds up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Grid {
    origin: f64,
    h: f64,
    /// Number of steps made from the origin.
    done: usize,
}

impl Grid {
    pub(crate) fn new(origin: f64, h: f64) -> Self {
        Self { origin, h, done: 0 }
    }

    /// The time after this many more steps.
    pub(crate) fn after(&self, steps: usize) -> f64 {
        self.origin + self.done.saturating_add(steps) as f64 * self.h
    }

    /// Counts a step.
    pub(crate) fn count(&mut self) {
        self.done += 1;
    }

    /// The same after the step that ends at `t`, up to the rounding of a corner there; `None` if no step does.
    pub(crate) fn at(self, t: f64) -> Option<Self> {
        let grid = Self { done: ((t - self.origin) / self.h).round() as usize, ..self };
        ((grid.after(0) - t).abs() <= rounding_of_times(self.h, t)).then_some(grid)
    }

    /// Prepares equal steps of at most `dt` from `t` to `t_end`; returns the total number of steps at the end. The grid continues if the
    /// interval is a multiple of `dt`.
    pub(crate) fn begin_interval(&mut self, t: f64, t_end: f64, dt: f64) -> usize {
        let way = t_end - t;
        let steps = number_of_steps(way, dt).max(1);
        let is_whole = is_whole(way, steps, dt);
        if !is_whole || self.h != dt {
            *self = Self::new(t, if is_whole { dt } else { way / steps as f64 });
        }
        self.done.saturating_add(steps)
    }

    /// End and size of the next step, of which the one with the number `last` ends at `t_end`.
    pub(crate) fn step(&self, last: usize, t_end: f64) -> (f64, f64) {
        if self.done + 1 < last {
            return (self.after(1), self.h);
        }
        let rest = t_end - self.after(0);
        // A step that is whole up to rounding keeps its size, and with it the Jacobian.
        let is_whole = (rest - self.h).abs() <= ROUNDING_OF_STEPS * (t_end - self.origin).max(self.h);
        (t_end, if is_whole { self.h } else { rest })
    }

    /// End and size of the next step from `t`, which ends at a corner if there is one in between, and whether that is the end of a step
    /// of the grid. A corner that equals such an end up to rounding replaces it; the size is that of the grid.
    pub(crate) fn step_to_corner(
        &self,
        last: usize,
        (t, t_end): (f64, f64),
        corner: impl FnOnce(Cell) -> Option<f64>,
    ) -> (f64, f64, bool) {
        let (end, h) = self.step(last, t_end);
        let cell = Cell { start: self.after(0), t, end };
        match corner(cell) {
            Some(corner) if !cell.ends_at(corner) => (corner, corner - t, false),
            found => {
                let end = found.filter(|_| end < t_end).unwrap_or(end);
                (end, if t > cell.start { end - t } else { h }, true)
            }
        }
    }

    pub(crate) fn serialise(&mut self, tape: &mut Tape<'_>) {
        tape.number(&mut self.origin);
        tape.number(&mut self.h);
        tape.count(&mut self.done);
    }
}

/// Whether this number of steps covers an interval, up to rounding.
pub(crate) fn is_whole(interval: f64, steps: usize, dt: f64) -> bool {
    (interval - steps as f64 * dt).abs() <= ROUNDING_OF_STEPS * interval
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_counted_without_their_rounding() {
        assert_eq!(number_of_steps(1.1, 0.1), 11);
        assert_eq!(number_of_steps(1.100001, 0.1), 12);
        assert_eq!(number_of_steps(1e300, 1e-300), usize::MAX);
        assert_eq!(number_of_steps(0.0, 0.1), 0);
    }

    #[test]
    fn a_time_is_on_the_grid_or_not() {
        let grid = Grid::new(0.3, 0.1);
        for steps in [0, 1, 7, 12_345_678] {
            let t = 0.3 + f64::from(steps) * 0.1;
            assert_eq!(grid.at(t).unwrap().after(1), 0.3 + f64::from(steps + 1) * 0.1);
            assert_eq!(grid.at(t + 0.01), None);
        }
        assert_eq!(grid.at(0.2), None);
    }

    #[test]
    fn whole_steps_go_on_and_others_begin_anew() {
        let mut grid = Grid::new(0.3, 0.1);
        let mut t = 0.3;
        let mut go = |grid: &mut Grid, t_end: f64| {
            let last = grid.begin_interval(t, t_end, 0.1);
            let mut steps = Vec::new();
            while t < t_end {
                let (end, h) = grid.step(last, t_end);
                grid.count();
                steps.push((end, h));
                t = end;
            }
            steps
        };
        let whole = 0.3 + 3.0 * 0.1;
        assert_eq!(go(&mut grid, whole), [(0.3 + 0.1, 0.1), (0.3 + 2.0 * 0.1, 0.1), (whole, 0.1)]);
        let h = 0.25 / 3.0;
        let [parts, end] = [go(&mut grid, whole + 0.25), go(&mut grid, whole + 0.25 + 0.1)];
        assert_eq!(parts.len(), 3);
        assert!(parts.iter().all(|step| (step.1 - h).abs() < 1e-15), "{parts:?}");
        assert_eq!(end, [(whole + 0.25 + 0.1, 0.1)]);
    }
}
