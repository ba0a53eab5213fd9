//! Gaps of constraints in Newton's method: those that are rounding, and those of rows that depend on others.

use super::super::linear_system::LinearSystem;
use super::super::numbers::Numbers;
use super::super::trial::Trial;
use super::Corrector;

/// Gaps below this part of their sizes are rounding, which adds up along the chain of sections that they join: a rod of ten segments has
/// eight spacings.
const ROUNDING_OF_GAPS: f64 = 64.0 * f64::EPSILON;

/// Constraint rows that were dependent where the Jacobian was evaluated may be independent at the trial: clamps at both ends of a
/// straight rod resist twist as soon as it bends. Their gaps are then larger than [`ROUNDING_OF_GAPS`], and
/// than the gaps that an increment leaves in dependent rows: its size times the distance from the Jacobian's state, times second
/// derivatives of gaps in units of sizes, of order one, summed over coordinates. Rods between clamps under an impact have the same
/// motion with 0.1 to 64; with 1000, opening gaps are missed.
const CURVATURE: f64 = 16.0;

/// Gaps of rows that remain dependent at the trial cannot be closed; they are ignored unless they grow by this factor. Rounding changes
/// them by less; with 1 to 100 the same rods take the same iterations.
const WIDER: f64 = 2.0;

/// After so many increments gaps that may be rounding are left. The first closes all of them, so that they do not add up: where each may
/// grow to its bound first, forces of loops jump by that over the square of the step.
const CLOSING_INCREMENTS: usize = 1;

impl<V: Numbers> Corrector<V> {
    /// Scales constraints on displacements to constraints on accelerations, so that the size of the equations does not depend on the step
    /// size (Bottasso, Dopico and Trainelli 2008). What may be rounding of a gap is left in the end: an increment that closes one spacing
    /// opens another on the other side, over and over.
    pub(super) fn scale_gaps(&mut self, trial: &Trial<V>) {
        let [of_displacement, ..] = trial.weights;
        let are_closed = self.increments >= CLOSING_INCREMENTS;
        for (gap, rounding) in self.residual[trial.q.len()..].iter_mut().zip(&self.gap_roundings) {
            *gap = if are_closed && gap.abs() <= *rounding { 0.0 } else { *gap / of_displacement };
        }
    }

    /// Whether constraints are open at `trial`, where the residual has been evaluated, whose rows the Jacobian leaves out as dependent, so
    /// that the increment does not close them.
    pub(super) fn misses_open_constraints(&self, trial: &Trial<V>) -> bool {
        if V::IS_PLAIN || self.gap_sizes.is_empty() {
            return false;
        }
        let left = self.left_open(trial);
        left > ROUNDING_OF_GAPS.max(WIDER * self.left_open) && left > self.left_by_dependent_rows(trial)
    }

    /// Finds what may be rounding of gaps: of an independent row no more than what coordinates close by spacings of their own. Clamps of a
    /// straight rod hardly turn its end where it hardly bends, and closing a spacing bends it visibly.
    pub(super) fn find_gap_roundings(&mut self) {
        let Self { linear: LinearSystem::Saddle(saddle), gap_roundings, gap_sizes, sizes, .. } = self else {
            return;
        };
        for (row, (rounding, size)) in gap_roundings.iter_mut().zip(gap_sizes.iter()).enumerate() {
            *rounding = ROUNDING_OF_GAPS * saddle.reach(row, sizes).min(*size);
        }
    }

    /// The largest remaining gap after the increment at `trial`, in rows that the Jacobian leaves out.
    pub(super) fn left_open(&self, trial: &Trial<V>) -> f64 {
        let LinearSystem::Saddle(saddle) = &self.linear else { return 0.0 };
        let [of_displacement, ..] = trial.weights;
        let gaps = &self.residual[trial.q.len()..];
        of_displacement * saddle.left_open(gaps, &self.increment, &self.gap_sizes)
    }

    /// Bound of the gaps that the increment leaves in dependent rows, because their dependence was slightly different where the Jacobian
    /// was evaluated.
    fn left_by_dependent_rows(&self, trial: &Trial<V>) -> f64 {
        let [reach, ..] = trial.weights;
        let (mut moved, mut distance) = (0.0, 0.0);
        for (i, size) in self.sizes.iter().enumerate() {
            moved += (reach * self.increment[i] / size).powi(2);
            distance += ((trial.q[i] - self.q_jacobian[i]) / size).powi(2);
        }
        CURVATURE * (moved * distance).sqrt()
    }
}
