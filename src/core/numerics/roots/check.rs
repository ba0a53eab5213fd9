//! Comparison of a Jacobian with finite differences of its system.

use super::convergence::EVALUATION_ERROR;
use super::difference::{Differences, rounding_error};
use super::{Derivative, NonlinearSystem};
use crate::error::Interrupted;
use crate::numerics::linalg::{Matrix, norm_inf};

/// The entry where a Jacobian differs most from central differences.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JacobianCheck {
    /// `|given - difference|`, minus the rounding error of R, relative to the larger of the two; infinite if
    /// one of them is not finite.
    pub relative_difference: f64,
    /// Row (equation) of the entry.
    pub row: usize,
    /// Column (unknown) of the entry.
    pub column: usize,
    /// The entry of the system's own Jacobian.
    pub given: f64,
    /// The entry by central differences.
    pub difference: f64,
}

/// Compares the system's Jacobian at `x` with central differences, entry by entry. A correct Jacobian of a
/// smooth system typically gives 1e-9 and rarely more than 1e-6; a wrong entry gives about one. `None`
/// without entries. Cost: 2n + 1 evaluations and one Jacobian.
pub fn check_jacobian(
    system: &mut dyn NonlinearSystem,
    x: &[f64],
    x_scale: &[f64],
) -> Result<Option<JacobianCheck>, Interrupted> {
    let (m, n) = (system.equations(), system.unknowns());
    let (mut given, mut difference) = (Matrix::zeros(m, n), Matrix::zeros(m, n));
    let mut residual = vec![0.0; m];
    system.residual(x, &mut residual)?;
    system.jacobian(x, &mut given)?;
    Differences::new(n, m).central(system, x, x_scale, &mut difference)?;
    let mut worst: Option<JacobianCheck> = None;
    for row in 0..m {
        for column in 0..n {
            let (a, b) = (given[(row, column)], difference[(row, column)]);
            let noise = EVALUATION_ERROR * rounding_error(x[column], x_scale[column], Derivative::Central);
            let excess = (a - b).abs() - noise * residual[row].abs();
            let relative_difference = if !norm_inf(&[a, b]).is_finite() {
                f64::INFINITY
            } else if excess > 0.0 {
                excess / a.abs().max(b.abs())
            } else {
                0.0
            };
            if worst.is_none_or(|worst| relative_difference > worst.relative_difference) {
                worst = Some(JacobianCheck { relative_difference, row, column, given: a, difference: b });
            }
        }
    }
    Ok(worst)
}
