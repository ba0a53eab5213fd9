//! Closed loops of a model.

use super::Flaw;
use crate::error::InvalidInput;
use crate::linalg::Matrix;

/// The change of the active constraints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Switch {
    /// Nothing: all multipliers and gaps are on their sides.
    Nothing,
    /// One holds no more.
    LetGo,
    /// Some hold that did not.
    TakenUp,
}

/// What ties the coordinates of a model beyond its equations of motion: m constraints `g(q, t) = 0`, held by multipliers,
/// `tau + G^T lambda = 0` with `G = dg/dq`. The defaults are those of a model without any.
pub trait Tied {
    /// Number of constraints m.
    fn constraints(&self) -> usize {
        0
    }

    /// From now on inverse dynamics and their tangents are those of `tau + G^T lambda`. Zero at first.
    fn set_multipliers(&mut self, _multipliers: &[f64]) {}

    /// Refuses closed loops, for what does not hold them.
    fn check_untied(&self, what: &str) -> Result<(), InvalidInput> {
        if self.constraints() == 0 {
            return Ok(());
        }
        let (found, expected) = match self.is_one_sided() {
            true => ("one with tendons that do not stretch", "tendons with a `stiffness`"),
            false => ("one with closed loops", "a robot without closed loops"),
        };
        Err(InvalidInput::new("model", found, format!("{expected}: {what} does not hold them yet")))
    }

    /// Whether constraints hold one way only: `g <= 0`, with multipliers that are not below zero. Those that do not hold at
    /// a time have gaps and rows of G that are zero, and no multiplier.
    fn is_one_sided(&self) -> bool {
        false
    }

    /// Which constraints hold.
    fn held(&self) -> Vec<bool> {
        vec![true; self.constraints()]
    }

    /// From now on those hold whose multipliers are not zero.
    fn release(&mut self, _multipliers: &[f64]) {}

    /// From now on those hold that are not open in a shape, and do not open with these velocities.
    fn release_open(&mut self, _q: &[f64], _qd: Option<&[f64]>) {}

    /// Takes up those that are passed in a shape; where there are none, lets go of the one whose multiplier is the lowest
    /// below zero, and sets that to zero.
    fn switch(&mut self, _q: &[f64], _multipliers: &mut [f64]) -> Switch {
        Switch::Nothing
    }

    /// From now on those hold that do, whatever a shape or multipliers say ([`Self::release_open`] and [`Self::switch`] change
    /// nothing), or no longer. A method that finds itself when they change keeps them within a step.
    fn keep_held(&mut self, _is_kept: bool) {}

    /// How far those are passed that hold one way only, and the rates of that: whether they hold or not, in units of the
    /// model's length, to the right of corners in time. Their rows are the last ones. Allocates.
    fn passed(&mut self, _q: &[f64], _qd: &[f64]) -> Vec<[f64; 2]> {
        Vec::new()
    }

    /// How far loops are open, g(q): metres, or differences of cosines, or of a coordinate.
    fn gaps(&mut self, _q: &[f64], _gaps: &mut [f64]) {}

    /// `dg/dt`.
    fn gap_rates(&mut self, _q: &[f64], _qd: &[f64], _rates: &mut [f64]) {}

    /// `d2g/dt2`.
    fn gap_accelerations(&mut self, _q: &[f64], _qd: &[f64], _qdd: &[f64], _accelerations: &mut [f64]) {}

    /// G, m x n.
    fn gap_jacobian(&mut self, _q: &[f64], _jacobian: &mut Matrix) {}

    /// The loop that is most open in a shape, where that is more than a method leaves that holds it.
    fn open_loop(&mut self, _q: &[f64]) -> Option<Flaw> {
        None
    }
}
