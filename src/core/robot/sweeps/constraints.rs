//! Gaps of closed loops and inextensible tendons, and their multipliers.

use super::Sweeps;
use crate::model::Constraint;
use crate::numerics::lie::Vector;
use crate::numerics::linalg::Matrix;
use crate::robot::algebra::tie::Row;
use crate::robot::kernel::{lines, loops, time};
use crate::robot::turning::Turning;

/// The gap that is widest for its size.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WidestGap {
    pub(crate) constraint: Constraint,
    pub(crate) gap: f64,
    /// Typical size, in the same unit.
    pub(crate) size: f64,
    /// Whether it is a length.
    pub(crate) is_length: bool,
}

impl<G: Turning> Sweeps<G> {
    /// Sets the multipliers of constraints.
    pub(crate) fn set_multipliers(&mut self, multipliers: &[f64]) {
        if self.work.effects.loops.multipliers != multipliers {
            self.work.effects.loops.multipliers.copy_from_slice(multipliers);
            self.work.motion_is_known = false;
        }
    }

    /// Updates everything on which constraints depend in a shape: poses, and lengths of inextensible tendons.
    fn update_constraints(&mut self, q: &[f64]) {
        self.update_kinematics(q);
        // Lengths are evaluated with the motion, at any velocity.
        if !self.plan.effects.loops.lengths.is_empty() && !self.work.motion_is_known {
            self.with_zeros(|sweeps, zeros| sweeps.update_motion([q, zeros, zeros]));
        }
    }

    /// Gaps g(q) of closed loops and inextensible tendons.
    pub(crate) fn gaps(&mut self, q: &[f64], gaps: &mut [f64]) {
        self.update_constraints(q);
        loops::values(&self.plan, &self.work, q, gaps);
    }

    /// Changes the sign of gaps of angles in ties whose ends are turned away from each other, in the shape evaluated last. Returns
    /// the largest [`loops::turned_away`].
    pub(crate) fn away_from_half_turns(&self, gaps: &mut [f64]) -> f64 {
        let mut most = 0.0_f64;
        for tie in &self.plan.effects.loops.ties {
            if let Some(by) = loops::turned_away(&self.plan, &self.work, tie) {
                most = most.max(by);
                let of_tie = gaps[tie.first..].iter_mut().zip(&tie.rows);
                of_tie.filter(|(_, row)| matches!(row, Row::Angle { .. })).for_each(|(gap, _)| *gap = -*gap);
            }
        }
        most
    }

    /// The constraint with the largest gap relative to these sizes, this gap, and its size.
    pub(crate) fn widest_gap(&mut self, q: &[f64], sizes: &[f64]) -> Option<WidestGap> {
        if self.plan.effects.loops.constraints.is_empty() {
            return None;
        }
        self.update_constraints(q);
        let mut gaps = std::mem::take(&mut self.work.effects.loops.gaps);
        loops::values(&self.plan, &self.work, q, &mut gaps);
        let mut widest: Option<WidestGap> = None;
        for (row, (gap, &size)) in gaps.iter().zip(sizes).enumerate() {
            let gap = gap.abs();
            if gap.is_nan() || widest.is_none_or(|widest| gap * widest.size > widest.gap * size) {
                let constraint = self.plan.effects.loops.constraints[row];
                widest = Some(WidestGap {
                    constraint,
                    gap,
                    size,
                    is_length: self.plan.effects.loops.is_length(row),
                });
            }
        }
        self.work.effects.loops.gaps = gaps;
        let Self { plan, work, .. } = self;
        let turned = plan.effects.loops.ties.iter().find_map(|tie| {
            let by = loops::turned_away(plan, work, tie)?;
            let constraint = plan.effects.loops.constraints[tie.first];
            Some(WidestGap { constraint, gap: by, size: 1.0, is_length: false })
        });
        turned.or(widest)
    }

    /// Excess of the lengths of all inextensible tendons over the commanded lengths, and its rates.
    pub(crate) fn excesses(&mut self, q: &[f64], qd: &[f64]) -> Vec<[f64; 2]> {
        self.update_velocities(q, qd);
        time::find_command_rates(&self.plan, &mut self.work);
        let state = &self.work.effects.actuation;
        let excess =
            |&i: &usize| [state.lengths[i] - state.commands[i], state.rates[i] - state.command_rates[i][0]];
        self.plan.effects.loops.lengths.iter().map(excess).collect()
    }

    /// Which inextensible tendons are slack.
    pub(crate) fn slack(&self) -> &[bool] {
        &self.work.effects.loops.slack
    }

    /// Sets which inextensible tendons are slack.
    pub(crate) fn set_slack(&mut self, slack: &[bool]) {
        self.work.effects.loops.slack.copy_from_slice(slack);
    }

    /// Moment, about the second end of a tie, and force of the first end on the second one for these
    /// multipliers, in world axes.
    pub(crate) fn tie_wrench(&mut self, q: &[f64], tie: usize, multipliers: &[f64]) -> [Vector<f64>; 2] {
        self.update_kinematics(q);
        let [moment, force] = loops::wrench(&self.plan, &self.work, tie, multipliers);
        let base = &self.work.surroundings.base.rotation;
        [base.apply(-moment), base.apply(-force)]
    }

    /// `dg/dt`.
    pub(crate) fn gap_rates(&mut self, q: &[f64], qd: &[f64], rates: &mut [f64]) {
        self.update_velocities(q, qd);
        time::find_command_rates(&self.plan, &mut self.work);
        loops::rates(&self.plan, &self.work, rates);
    }

    /// `d2g/dt2`.
    pub(crate) fn gap_accelerations(&mut self, state: [&[f64]; 3], accelerations: &mut [f64]) {
        self.update_motion(state);
        let Self { plan, work, tangent, .. } = self;
        time::find_command_rates(plan, work);
        if !plan.effects.loops.lengths.is_empty() {
            lines::find(plan, work, &mut tangent.effects.actuation);
        }
        loops::accelerations(plan, work, &mut tangent.effects.actuation, accelerations);
    }

    /// `dg/dq`, rows x n.
    pub(crate) fn gap_jacobian(&mut self, q: &[f64], jacobian: &mut Matrix) {
        self.update_constraints(q);
        let Self { plan, work, tangent, .. } = self;
        loops::find(plan, work, &mut tangent.effects.loops);
        if !plan.effects.loops.lengths.is_empty() {
            lines::find(plan, work, &mut tangent.effects.actuation);
        }
        loops::jacobian(plan, work, &tangent.effects.loops, &mut tangent.effects.actuation, jacobian);
    }
}
