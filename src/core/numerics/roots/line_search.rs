//! Backtracking along the Newton step (Dennis and Schnabel 1983, algorithm A6.3.1).

use super::newton::{Newton, Trial};
use super::{NonlinearSystem, Status};
use crate::error::Interrupted;

/// Armijo's condition requires this fraction of the decrease of `|R|^2 / 2` that the slope predicts (Dennis
/// and Schnabel 1983, section 6.3.2; KINSOL's alpha).
const ARMIJO: f64 = 1e-4;

/// One backtrack shortens the step at least to this fraction (Dennis and Schnabel 1983, section 6.3.2).
const SHORTEN_AT_LEAST: f64 = 0.5;

/// One backtrack shortens the step at most to this fraction (ibid.).
const SHORTEN_AT_MOST: f64 = 0.1;

/// A step that moves no unknown by more than this relative amount is negligible.
const SHORTEST_STEP: f64 = f64::EPSILON;

impl Newton {
    /// Shortens the Newton step until `|R|^2` falls by Armijo's condition and R is finite.
    pub(super) fn search_line(
        &mut self,
        system: &mut dyn NonlinearSystem,
        x: &[f64],
        residual_norm: f64,
    ) -> Result<Trial, Interrupted> {
        // The Newton step solves the least-squares problem, hence g . dx = -|J dx|^2, which is -|R|^2 for
        // regular J.
        let predicted =
            if self.linear.is_regular() { 1.0 } else { self.predicted_reduction(residual_norm).powi(2) };
        let relative =
            (0..x.len()).fold(0.0, |m: f64, j| m.max(self.step[j].abs() / x[j].abs().max(self.x_scale[j])));
        let shortest = SHORTEST_STEP / relative;
        let longest = self.longest_step / self.scaled_step_norm();
        let (mut tried, mut length) = (1.0, longest.min(1.0));
        let mut previous: Option<(f64, f64)> = None;
        while length >= shortest {
            let norm = self.try_step(system, x, length / tried)?;
            tried = length;
            // phi(length) - phi(0) with phi = |R|^2 / 2, in units of |R|^2.
            let change = 0.5 * ((norm / residual_norm).powi(2) - 1.0);
            // The first condition is sharper when the predicted decrease is below rounding.
            if norm < residual_norm && change <= -ARMIJO * length * predicted {
                return Ok(Trial::Taken { norm, length });
            }
            let next = if change.is_finite() {
                let next = minimum(length, change, previous, -predicted);
                previous = Some((length, change));
                next.clamp(SHORTEN_AT_MOST * length, SHORTEN_AT_LEAST * length)
            } else {
                SHORTEN_AT_LEAST * length
            };
            length = if next.is_finite() { next } else { SHORTEN_AT_LEAST * length };
        }
        Ok(Trial::Refused(Status::LineSearchFailed))
    }
}

/// Minimum of the parabola through `(0, 0)` with `slope` and `(length, change)`, or of the cubic that also
/// passes through the previous point.
fn minimum(length: f64, change: f64, previous: Option<(f64, f64)>, slope: f64) -> f64 {
    let Some((other_length, other_change)) = previous else {
        return -slope * length * length / (2.0 * (change - slope * length));
    };
    let u = (change - slope * length) / (length * length);
    let v = (other_change - slope * other_length) / (other_length * other_length);
    let a = (u - v) / (length - other_length);
    let b = (length * v - other_length * u) / (length - other_length);
    if a == 0.0 {
        -slope / (2.0 * b)
    } else {
        let discriminant = b * b - 3.0 * a * slope;
        if discriminant < 0.0 { SHORTEN_AT_LEAST * length } else { (discriminant.sqrt() - b) / (3.0 * a) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_models_have_the_right_minimum() {
        // 3 t^2 - 2 t, and t^3 + t^2 - 2 t with its minimum at (sqrt(7) - 1) / 3.
        assert!((minimum(2.0, 8.0, None, -2.0) - 1.0 / 3.0).abs() < 1e-15);
        let cubic = |t: f64| t * t * t + t * t - 2.0 * t;
        let found = minimum(1.0, cubic(1.0), Some((2.0, cubic(2.0))), -2.0);
        assert!((found - (7f64.sqrt() - 1.0) / 3.0).abs() < 1e-15);
    }
}
