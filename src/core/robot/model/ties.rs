//! Constraints of a robot.

use super::{AnySweeps, LARGEST_GAP, RobotModel};
use crate::model::constraint::forget_unmoved;
use crate::model::constraint::one_sided::{ACTIVATION_EXCESS, TAUT};
use crate::model::{Constraint, InvalidShape, OneSided, Switch, Tied};
use crate::numerics::linalg::{Matrix, symmetric_eigen};
use crate::robot::sweeps::WidestGap;

/// Loops whose constraints leave a combination of their rows shorter than this, of rows of length one, are near a singular position.
const NEARLY_DEPENDENT: f64 = 3e-2;

impl RobotModel {
    /// Names the closed loop that is nearest to a singular position in this shape, or, if nothing else is known to hold there, the one whose
    /// rows depend most on others.
    pub(super) fn advice_on_loops(&mut self, q: &[f64], is_held: bool) -> String {
        let Some((closed, margin)) = self.most_dependent_loop(q) else { return String::new() };
        let joined = &self.facts.loops[closed];
        if margin < NEARLY_DEPENDENT {
            return format!(
                " The loop between {joined} (loops[{closed}]) is near a singular position there, in which it locks or can go on in several \
                 ways: begin beside it, or take `method=\"generalised_alpha\"`, whose steps pass it."
            );
        }
        if is_held {
            return String::new();
        }
        format!(
            " The loop between {joined} (loops[{closed}]) holds there: where its force (`loop_forces`) grows without bound, the mechanism is at \
             the end of its travel, or loops contradict each other."
        )
    }

    /// The loop whose constraints depend most on each other and on those of others, and how far they are from that; `None` without loops.
    fn most_dependent_loop(&mut self, q: &[f64]) -> Option<(usize, f64)> {
        let (n, rows) = (self.facts.n, self.facts.constraints());
        if rows == 0 || !q.iter().all(|q| q.is_finite()) {
            return None;
        }
        let mut jacobian = Matrix::zeros(rows, n);
        self.gap_jacobian(q, &mut jacobian);
        forget_unmoved(&mut jacobian, &self.facts.typical_coordinates, &self.facts.gap_sizes);
        for (mut column, size) in jacobian.column_iter_mut().zip(&self.facts.typical_coordinates) {
            column *= *size;
        }
        let constraints = on_sweeps!(&self.sweeps, sweeps => sweeps.plan().effects.loops.constraints.clone());
        let kept: Vec<usize> = (0..rows).filter(|&row| jacobian.row(row).norm() > 0.0).collect();
        let units: Vec<_> = kept.iter().map(|&row| jacobian.row(row).normalize()).collect();
        let gram = Matrix::from_fn(kept.len(), kept.len(), |i, j| units[i].dot(&units[j]));
        let (values, vectors) = symmetric_eigen(&gram)?;
        let (least, value) = values.iter().enumerate().min_by(|(_, a), (_, b)| a.total_cmp(b))?;
        let mut shares = vec![0.0; self.facts.loops.len()];
        for (&row, share) in kept.iter().zip(vectors.column(least).iter()) {
            if let Constraint::Loop(closed) = constraints[row] {
                shares[closed] += share * share;
            }
        }
        let (closed, share) = shares.iter().enumerate().max_by(|(_, a), (_, b)| a.total_cmp(b))?;
        (*share > 0.0).then(|| (closed, value.max(0.0).sqrt()))
    }
}

impl Tied for RobotModel {
    fn set_multipliers(&mut self, multipliers: &[f64]) {
        on_sweeps!(&mut self.sweeps, sweeps => sweeps.set_multipliers(multipliers));
    }

    fn away_from_half_turns(&mut self, gaps: &mut [f64]) -> f64 {
        on_sweeps!(&self.sweeps, sweeps => sweeps.away_from_half_turns(gaps))
    }

    fn gaps(&mut self, q: &[f64], gaps: &mut [f64]) {
        let Self { sweeps, coordinates, .. } = self;
        coordinates.all([q], |[q]| on_sweeps!(sweeps, sweeps => sweeps.gaps(q, gaps)));
    }

    fn gap_rates(&mut self, q: &[f64], qd: &[f64], rates: &mut [f64]) {
        let Self { sweeps, coordinates, .. } = self;
        coordinates.all([q, qd], |[q, qd]| on_sweeps!(sweeps, sweeps => sweeps.gap_rates(q, qd, rates)));
    }

    fn gap_accelerations(&mut self, q: &[f64], qd: &[f64], qdd: &[f64], accelerations: &mut [f64]) {
        let Self { sweeps, coordinates, .. } = self;
        coordinates.all([q, qd, qdd], |state| {
            on_sweeps!(sweeps, sweeps => sweeps.gap_accelerations(state, accelerations));
        });
    }

    fn gap_jacobian(&mut self, q: &[f64], jacobian: &mut Matrix) {
        let Self { sweeps, coordinates, .. } = self;
        coordinates.columns(q, jacobian, |q, jacobian| {
            on_sweeps!(sweeps, sweeps => sweeps.gap_jacobian(q, jacobian));
        });
    }

    fn open_loop(&mut self, q: &[f64]) -> Option<InvalidShape> {
        let Self { sweeps, coordinates, facts, .. } = self;
        if facts.constraints() == 0 {
            return None;
        }
        let WidestGap { constraint, gap, size, is_length } = coordinates
            .all([q], |[q]| on_sweeps!(sweeps, sweeps => sweeps.widest_gap(q, &facts.gap_sizes)))?;
        // NaN counts as open.
        let is_open = gap.is_nan() || gap > LARGEST_GAP * size;
        is_open.then_some(InvalidShape::Open { constraint, gap, is_length })
    }
}

impl OneSided for RobotModel {
    fn active(&self) -> Vec<bool> {
        let slack = self.slack();
        let loops = self.facts.constraints() - slack.len();
        std::iter::repeat_n(true, loops).chain(slack.into_iter().map(|is_slack| !is_slack)).collect()
    }

    fn release(&mut self, multipliers: &[f64]) {
        let mut slack = self.slack();
        let own = &multipliers[multipliers.len() - slack.len()..];
        slack.iter_mut().zip(own).for_each(|(is_slack, multiplier)| *is_slack = *multiplier == 0.0);
        self.set_slack(&slack);
    }

    fn release_open(&mut self, q: &[f64], qd: Option<&[f64]>) {
        if self.slack_is_kept || !self.facts.is_one_sided {
            return;
        }
        let opens = |[by, rate]: [f64; 2]| by < -TAUT || (qd.is_some() && by < TAUT && rate < -TAUT);
        let rest = vec![0.0; q.len()];
        let slack: Vec<bool> = self.passed(q, qd.unwrap_or(&rest)).into_iter().map(opens).collect();
        self.set_slack(&slack);
    }

    fn switch(&mut self, q: &[f64], multipliers: &mut [f64]) -> Switch {
        if self.slack_is_kept {
            return Switch::Nothing;
        }
        let mut slack = self.slack();
        let mut has_activated = false;
        let rest = vec![0.0; q.len()];
        for (is_slack, [by, _]) in slack.iter_mut().zip(self.passed(q, &rest)) {
            if *is_slack && by > ACTIVATION_EXCESS {
                (*is_slack, has_activated) = (false, true);
            }
        }
        let first = multipliers.len() - slack.len();
        let lowest =
            (0..slack.len()).min_by(|&i, &j| multipliers[first + i].total_cmp(&multipliers[first + j]));
        let switch = match lowest.filter(|&i| multipliers[first + i] < 0.0) {
            _ if has_activated => Switch::Activated,
            None => return Switch::Nothing,
            Some(lowest) => {
                slack[lowest] = true;
                multipliers[first + lowest] = 0.0;
                Switch::Released
            }
        };
        self.set_slack(&slack);
        switch
    }

    fn keep_active_set(&mut self, is_kept: bool) {
        self.slack_is_kept = is_kept;
    }

    fn passed(&mut self, q: &[f64], qd: &[f64]) -> Vec<[f64; 2]> {
        let excesses = self.excesses(q, qd);
        let sizes = &self.facts.gap_sizes[self.facts.constraints() - excesses.len()..];
        excesses.into_iter().zip(sizes).map(|(excess, size)| excess.map(|x| x / size)).collect()
    }
}
