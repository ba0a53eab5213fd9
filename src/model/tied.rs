//! Closed loops of a model.

use super::Flaw;
use crate::error::InvalidInput;
use crate::linalg::Matrix;

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
        let expected = format!("a robot without closed loops: {what} does not hold them yet");
        Err(InvalidInput::new("model", "one with closed loops", expected))
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
