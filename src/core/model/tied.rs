//! Constraints of a model, such as closed loops.

use super::{Dynamics, InvalidShape};
use crate::numerics::linalg::Matrix;

/// Change of the set of active constraints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Switch {
    /// No change: all multipliers and gaps have admissible signs.
    Nothing,
    /// One constraint was released.
    Released,
    /// Some constraints became active.
    Activated,
}

/// Constraints on the coordinates of a model: m equations `g(q, t) = 0` with multipliers in `tau + G^T lambda
/// = 0`, where `G = dg/dq`.
pub trait Tied: Dynamics {
    /// Adds the constraint forces `G^T lambda` to inverse dynamics and their tangents. Zero initially.
    fn set_multipliers(&mut self, multipliers: &[f64]);

    /// Changes the sign of the gaps evaluated last for directions that should coincide but are more than a right angle apart: such
    /// gaps fall towards half a turn as well, where nothing is closed. Returns by how much the lowest cosine of such an angle is
    /// below 1; zero if there is none.
    fn away_from_half_turns(&mut self, gaps: &mut [f64]) -> f64;

    /// How far loops are open, g(q): metres, or differences of cosines, or of a coordinate.
    fn gaps(&mut self, q: &[f64], gaps: &mut [f64]);

    /// `dg/dt`.
    fn gap_rates(&mut self, q: &[f64], qd: &[f64], rates: &mut [f64]);

    /// `d2g/dt2`.
    fn gap_accelerations(&mut self, q: &[f64], qd: &[f64], qdd: &[f64], accelerations: &mut [f64]);

    /// G, m x n.
    fn gap_jacobian(&mut self, q: &[f64], jacobian: &mut Matrix);

    /// The constraint with the largest gap in a shape, if the gap exceeds the error of a method that enforces
    /// constraints.
    fn open_loop(&mut self, q: &[f64]) -> Option<InvalidShape>;
}

/// One-sided constraints, the last ones of a model ([`is_one_sided`](super::Facts::is_one_sided)): inextensible tendons.
pub trait OneSided: Dynamics {
    /// Which constraints are active.
    fn active(&self) -> Vec<bool>;

    /// Makes exactly the constraints with non-zero multipliers active.
    fn release(&mut self, multipliers: &[f64]);

    /// Makes exactly the constraints active that are not open in a shape and do not open with these
    /// velocities.
    fn release_open(&mut self, q: &[f64], qd: Option<&[f64]>);

    /// Activates the constraints violated in a shape. If there are none, releases the one with the most
    /// negative multiplier, and sets this multiplier to zero.
    fn switch(&mut self, q: &[f64], multipliers: &mut [f64]) -> Switch;

    /// Fixes the active set, so that [`Self::release_open`] and [`Self::switch`] change nothing, or ends that. For methods that locate
    /// changes of the active set themselves.
    fn keep_active_set(&mut self, is_kept: bool);

    /// Violation of every one-sided constraint, active or not, and its rate, in units of [`gap_sizes`](super::Facts::gap_sizes); at
    /// corners in time, the rate after the corner. Their rows are the last ones. Allocates.
    fn passed(&mut self, q: &[f64], qd: &[f64]) -> Vec<[f64; 2]>;
}
