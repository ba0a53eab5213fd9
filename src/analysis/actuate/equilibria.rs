//! Equilibria and their sensitivity as a function of the inputs, by continuation from one input to the next.

use crate::analysis::statics::{
    Continuation, ContinuationOptions, CriticalKind, InputPath, Monitor, Status, continuation,
};
use crate::error::{Interrupted, Unfinished};
use crate::model::constraint::one_sided;
use crate::model::constraint::saddle::Saddle;
use crate::model::{Dynamics as _, InTime as _, Tied as _};
use crate::numerics::linalg::Matrix;
use crate::robot::RobotModel;

/// Bound of the last Newton step, in scaled coordinates: rounding, because derivatives are differences of
/// equilibria.
const TOLERANCE: f64 = 1e-12;

/// Effectively no limit: Newton's method determines the step length.
const MAX_STEP: f64 = 1e6;

/// More than any path between neighbouring inputs takes.
const MAX_STEPS: usize = 100;

/// Load factor at which a path that turned back is abandoned.
const ABANDONED_LOAD_FACTOR: f64 = -1.0;

/// Inputs and the equilibrium shape at these inputs.
#[derive(Clone, Debug)]
pub(super) struct State {
    pub(super) u: Vec<f64>,
    pub(super) q: Vec<f64>,
}

/// Reason why no equilibrium was found for some inputs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum NoEquilibrium {
    /// The path reached a limit point and turned back: the equilibrium snaps through.
    Limit,
    /// Continuation failed with this status.
    Continuation(Status),
}

/// Equilibria computed during a search.
pub(super) struct Equilibria<'a, 'b> {
    model: &'a mut RobotModel,
    monitor: Monitor<'b>,
    time: f64,
    sizes: Vec<f64>,
    /// Start of continuation paths: the equilibrium at the search's latest iterate.
    anchor: State,
    latest: State,
    /// Reason for the last failure since the anchor was set.
    pub(super) no_equilibrium: Option<NoEquilibrium>,
    /// Number of equilibria requested.
    pub(super) number: usize,
}

impl<'a, 'b> Equilibria<'a, 'b> {
    /// Starts at an equilibrium. `sizes` are those of the scaled coordinates.
    pub(super) fn new(
        model: &'a mut RobotModel,
        time: f64,
        u: Vec<f64>,
        q: Vec<f64>,
        sizes: Vec<f64>,
        monitor: Monitor<'b>,
    ) -> Self {
        let anchor = State { u, q };
        Self { model, monitor, time, sizes, latest: anchor.clone(), anchor, no_equilibrium: None, number: 0 }
    }

    /// Shape at these inputs, by continuation from the anchor; `None` if the path does not lead there.
    pub(super) fn at(&mut self, u: &[f64]) -> Result<Option<&[f64]>, Interrupted> {
        if self.latest.u != u {
            self.number += 1;
            if self.anchor.u == u {
                self.latest = self.anchor.clone();
            } else if let Some(q) = self.follow(u)? {
                self.latest = State { u: u.to_vec(), q };
            } else {
                return Ok(None);
            }
        }
        Ok(Some(&self.latest.q))
    }

    /// Moves the anchor to these inputs, if they were the last ones requested.
    pub(super) fn move_anchor(&mut self, u: &[f64]) {
        if self.latest.u == u && self.anchor.u != u {
            self.anchor = self.latest.clone();
            self.no_equilibrium = None;
        }
    }

    /// The known equilibrium at these inputs; if there is none, that of the search's latest iterate.
    pub(super) fn known(&self, u: &[f64]) -> State {
        if self.latest.u == u { self.latest.clone() } else { self.anchor.clone() }
    }

    /// The model and the monitor, with the shape `near` or the latest one.
    pub(super) fn parts(&mut self, near: Option<Vec<f64>>) -> (&mut RobotModel, Monitor<'_>, Vec<f64>) {
        (self.model, self.monitor, near.unwrap_or_else(|| self.latest.q.clone()))
    }

    fn follow(&mut self, u: &[f64]) -> Result<Option<Vec<f64>>, Interrupted> {
        let options = ContinuationOptions {
            inputs: Some(InputPath { from: self.anchor.u.clone(), to: u.to_vec(), time: self.time }),
            q0: Some(self.anchor.q.clone()),
            bounds: [ABANDONED_LOAD_FACTOR, 1.0],
            max_step: MAX_STEP,
            max_steps: MAX_STEPS,
            tol: TOLERANCE,
            // Where forces have no potential, a verdict costs more than an equilibrium.
            stability: false,
            ..ContinuationOptions::default()
        };
        let found = continuation(self.model, &options, self.monitor);
        let Continuation { path, status, .. } = match found {
            Ok(found) => found.map_err(Unfinished::interrupted)?,
            // Inputs or shape are not finite.
            Err(_) => {
                self.no_equilibrium = Some(NoEquilibrium::Continuation(Status::NonFinite));
                return Ok(None);
            }
        };
        let has_turned = path.critical.iter().any(|point| point.kind == CriticalKind::Limit);
        if has_turned || path.load_factor.last() != Some(&1.0) {
            self.no_equilibrium =
                Some(if has_turned { NoEquilibrium::Limit } else { NoEquilibrium::Continuation(status) });
            return Ok(None);
        }
        Ok(Some(path.q[path.q.len() - self.sizes.len()..].to_vec()))
    }

    /// Derivative of the latest shape with respect to the inputs, `[K, G^T; G, 0] [dq; dlambda] = -[dtau;
    /// dg]`, in scaled coordinates; n x m. K is the tangent stiffness, G the constraint Jacobian. `None` if
    /// the matrix is singular.
    pub(super) fn sensitivity(&mut self) -> Result<Option<Matrix>, Interrupted> {
        let State { u, q } = &self.latest;
        let (n, m) = (q.len(), u.len());
        self.model.set_inputs(u);
        self.model.set_time(self.time)?;
        let rest = vec![0.0; n];
        let constraints = self.model.facts().constraints();
        let mut multipliers = vec![0.0; constraints];
        if constraints > 0 && one_sided::multipliers(self.model, [q, &rest, &rest], &mut multipliers).is_err()
        {
            return Ok(None);
        }
        let mut saddle = Saddle::new(n, constraints);
        let mut pushed = Matrix::zeros(n, m);
        self.model.set_multipliers(&multipliers);
        self.model.weighted_tangent(q, &rest, &rest, [1.0, 0.0, 0.0], &mut saddle.tangent);
        self.model.input_tangent(q, &rest, &rest, &mut pushed);
        self.model.set_multipliers(&vec![0.0; constraints]);
        if constraints > 0 {
            self.model.gap_jacobian(q, &mut saddle.constraints);
        }
        for (i, size) in self.sizes.iter().enumerate() {
            saddle.tangent.row_mut(i).scale_mut(*size);
            saddle.tangent.column_mut(i).scale_mut(*size);
            saddle.constraints.column_mut(i).scale_mut(*size);
            pushed.row_mut(i).scale_mut(-size);
        }
        if saddle.factorise().is_err() {
            return Ok(None);
        }
        let of_gaps = self.gaps_of_inputs()?;
        for (k, mut column) in pushed.column_iter_mut().enumerate() {
            let mut right: Vec<f64> =
                column.iter().copied().chain(of_gaps.column(k).iter().map(|x| -x)).collect();
            saddle.solve(&mut right);
            column.copy_from_slice(&right[..n]);
        }
        Ok(Some(pushed))
    }

    /// Derivatives of the gaps with respect to the inputs, which are linear in commanded lengths. Shape
    /// (constraints, inputs).
    fn gaps_of_inputs(&mut self) -> Result<Matrix, Interrupted> {
        let State { u, q } = &self.latest;
        let constraints = self.model.facts().constraints();
        let mut change = Matrix::zeros(constraints, u.len());
        if constraints == 0 {
            return Ok(change);
        }
        let [mut before, mut after] = [vec![0.0; constraints], vec![0.0; constraints]];
        self.model.gaps(q, &mut before);
        for (k, mut column) in change.column_iter_mut().enumerate() {
            let mut other = u.clone();
            other[k] += 1.0;
            self.model.set_inputs(&other);
            self.model.set_time(self.time)?;
            self.model.gaps(q, &mut after);
            for (change, (after, before)) in column.iter_mut().zip(after.iter().zip(&before)) {
                *change = after - before;
            }
        }
        self.model.set_inputs(u);
        self.model.set_time(self.time)?;
        Ok(change)
    }
}
