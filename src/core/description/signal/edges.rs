//! Edges of tables that are narrower than the resolution of steps: values jump there.

use super::table::Table;
use super::times::rounding_of_times;

/// How a model that moves in steps evaluates functions of time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StepContext {
    /// Size of the steps in seconds if it is fixed, otherwise zero; NaN without steps, for exact tables.
    pub(crate) dt: f64,
    /// Time of the last jump that was passed; NaN before the first one.
    pub(crate) passed: f64,
    /// Seconds before a time over which rates of prescribed motions are averaged, without accelerations; zero for the rates at the time.
    pub(crate) mean_over: f64,
}

impl StepContext {
    /// Exact tables, without steps.
    pub(crate) const EXACT: Self = Self { dt: f64::NAN, passed: f64::NAN, mean_over: 0.0 };
}

impl<const N: usize> Table<N> {
    /// Value at `t`. At a jump the value before it, unless that jump was passed.
    pub(super) fn value_in_step(&self, t: f64, step_context: StepContext) -> [f64; N] {
        let Some([before, after]) = self.edge(t, step_context.dt) else { return self.at(t) };
        let (margin, passed) = (margin(t, step_context.dt), step_context.passed);
        let has_passed = passed >= self.times[before] - margin && passed <= self.times[after] + margin;
        self.values[if has_passed { after } else { before }]
    }

    /// Whether values may jump at some time for steps of the size `dt`, as in [`StepContext`].
    pub(super) fn has_edges(&self, dt: f64) -> bool {
        let largest = self.times[0].abs().max(self.times[self.times.len() - 1].abs());
        !dt.is_nan() && self.narrowest <= 2.0 * margin(largest, dt)
    }

    /// Start of the edge that is at `t` up to rounding.
    pub(super) fn edge_near(&self, t: f64, dt: f64) -> Option<f64> {
        self.edge(t, dt).map(|[before, _]| self.times[before])
    }

    /// Indices of the first and the last of several times that equal `t` up to the rounding of the times of steps.
    fn edge(&self, t: f64, dt: f64) -> Option<[usize; 2]> {
        if dt.is_nan() {
            return None;
        }
        let margin = margin(t, dt);
        if self.narrowest > 2.0 * margin {
            return None;
        }
        let first = self.times.partition_point(|&time| time < t - margin);
        let end = self.times.partition_point(|&time| time <= t + margin);
        (first + 1 < end).then(|| [first, end - 1])
    }
}

/// The rounding of the times of a step of the size `dt` from or to `t`: [`super::Cell`] has no corners within it.
fn margin(t: f64, dt: f64) -> f64 {
    rounding_of_times(dt, t.abs() + dt)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_jump_at_edges_that_steps_cannot_tell_apart() {
        let pulse = [0.0, 0.3, 0.3 + 1e-12, 0.4, 0.4 + 1e-6].to_vec();
        let table = Table::new(pulse, [0.0, 0.0, 5.0, 5.0, 0.0].map(|x| [x]).to_vec()).unwrap();
        let value_in_step = |t: f64, dt: f64, passed: f64| {
            table.value_in_step(t, StepContext { dt, passed, ..StepContext::EXACT })[0]
        };
        const NEVER: f64 = f64::NAN;
        assert!(table.has_edges(0.01) && ![1e-5, 0.0, NEVER].map(|dt| table.has_edges(dt)).contains(&true));
        // Both ends of the edge are the same time.
        for t in [0.3, 0.3 + 1e-12] {
            assert_eq!(table.edge_near(t, 0.01), Some(0.3));
            assert_eq!([value_in_step(t, 0.01, NEVER), value_in_step(t, 0.01, 0.3)], [0.0, 5.0]);
            assert_eq!([1e-5, 0.0, NEVER].map(|dt| table.edge_near(t, dt)), [None; 3]);
        }
        assert_eq!([value_in_step(0.3, 1e-5, NEVER), value_in_step(0.3 + 1e-12, 1e-5, NEVER)], [0.0, 5.0]);
        // The passed jump is another one; no jump at all.
        assert_eq!(value_in_step(0.3, 0.01, 0.2), 0.0);
        assert_eq!(value_in_step(0.35, 0.01, NEVER), 5.0);
        assert!((value_in_step(0.4 + 5e-7, 0.01, NEVER) - 2.5).abs() < 1e-8);
    }
}
