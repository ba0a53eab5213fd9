//! Jacobians by finite differences.

use super::{Derivative, NonlinearSystem};
use crate::error::{Interrupted, InvalidInput};
use crate::numerics::linalg::Matrix;
use crate::numerics::memory;

/// Forward increment relative to `max(|x|, x_scale)`: the square root of the rounding unit, which balances
/// the truncation error (of order h) and the rounding error (of order eps/h) (Dennis and Schnabel 1983,
/// section 5.4; KINSOL's choice).
pub const FORWARD_INCREMENT: f64 = 1.490_116_119_384_765_6e-8; // 2^-26 = sqrt(f64::EPSILON)

/// Central increment relative to `max(|x|, x_scale)`: the cube root of the rounding unit, which balances the
/// truncation error (of order h^2) and the rounding error (of order eps/h) (Dennis and Schnabel 1983, section
/// 5.6).
pub const CENTRAL_INCREMENT: f64 = 6.055_454_452_393_343e-6; // f64::EPSILON.cbrt()

/// Finite-difference Jacobians, with memory for repeated use at a fixed size.
#[derive(Clone, Debug)]
pub struct Differences {
    x: Vec<f64>,
    plus: Vec<f64>,
    minus: Vec<f64>,
}

impl Differences {
    /// Rejects Jacobians that do not fit in memory together with a copy of the caller.
    pub fn check_memory(unknowns: usize, equations: usize) -> Result<(), InvalidInput> {
        const MATRICES: usize = 2;
        let numbers = MATRICES.saturating_mul(unknowns).saturating_mul(equations);
        let found = format_args!("{unknowns} values for {equations} equations");
        memory::check(numbers, "x", found, "differentiate with respect to fewer variables at a time")
    }

    /// Memory for `equations` functions of `unknowns` variables.
    pub fn new(unknowns: usize, equations: usize) -> Self {
        Self { x: vec![0.0; unknowns], plus: vec![0.0; equations], minus: vec![0.0; equations] }
    }

    /// `jacobian <- dR/dx` (m x n) at `x` by forward differences from `residual = R(x)`. Each variable moves
    /// away from zero by [`FORWARD_INCREMENT`]` max(|x_j|, x_scale_j)`, rounded such that `x_j + h_j` is a
    /// double. Cost: n evaluations.
    pub fn forward(
        &mut self,
        system: &mut dyn NonlinearSystem,
        x: &[f64],
        residual: &[f64],
        x_scale: &[f64],
        jacobian: &mut Matrix,
    ) -> Result<(), Interrupted> {
        self.x.copy_from_slice(x);
        for j in 0..x.len() {
            self.x[j] = x[j] + increment(x[j], x_scale[j], FORWARD_INCREMENT);
            let h = self.x[j] - x[j];
            system.residual(&self.x, &mut self.plus)?;
            for i in 0..residual.len() {
                jacobian[(i, j)] = (self.plus[i] - residual[i]) / h;
            }
            self.x[j] = x[j];
        }
        Ok(())
    }

    /// `jacobian <- dR/dx` (m x n) at `x` by central differences. Each variable moves to both sides by
    /// [`CENTRAL_INCREMENT`]` max(|x_j|, x_scale_j)`; the difference is divided by the exact distance of both
    /// doubles. Cost: 2n evaluations.
    pub fn central(
        &mut self,
        system: &mut dyn NonlinearSystem,
        x: &[f64],
        x_scale: &[f64],
        jacobian: &mut Matrix,
    ) -> Result<(), Interrupted> {
        self.x.copy_from_slice(x);
        for j in 0..x.len() {
            let h = increment(x[j], x_scale[j], CENTRAL_INCREMENT);
            let (right, left) = (x[j] + h, x[j] - h);
            self.x[j] = right;
            system.residual(&self.x, &mut self.plus)?;
            self.x[j] = left;
            system.residual(&self.x, &mut self.minus)?;
            for i in 0..self.plus.len() {
                jacobian[(i, j)] = (self.plus[i] - self.minus[i]) / (right - left);
            }
            self.x[j] = x[j];
        }
        Ok(())
    }
}

/// Increment of a variable away from zero, so that functions defined on a half line are evaluated in their
/// domain.
fn increment(x: f64, scale: f64, relative: f64) -> f64 {
    (relative * x.abs().max(scale)).copysign(x)
}

/// Rounding error of the difference quotients of column `j`, per unit of |R|.
pub(super) fn rounding_error(x: f64, scale: f64, derivative: Derivative) -> f64 {
    match derivative {
        Derivative::Analytic => 0.0,
        Derivative::Forward => 2.0 * f64::EPSILON / increment(x, scale, FORWARD_INCREMENT).abs(),
        Derivative::Central => f64::EPSILON / increment(x, scale, CENTRAL_INCREMENT).abs(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Exponentials;
    impl NonlinearSystem for Exponentials {
        fn unknowns(&self) -> usize {
            2
        }
        fn equations(&self) -> usize {
            3
        }
        fn residual(&mut self, x: &[f64], r: &mut [f64]) -> Result<(), Interrupted> {
            r[0] = x[0].exp();
            r[1] = x[0] * x[1];
            r[2] = x[1].sin();
            Ok(())
        }
        fn jacobian(&mut self, x: &[f64], j: &mut Matrix) -> Result<(), Interrupted> {
            *j = Matrix::from_row_slice(3, 2, &[x[0].exp(), 0.0, x[1], x[0], 0.0, x[1].cos()]);
            Ok(())
        }
    }

    #[test]
    fn the_constants_are_what_they_say() {
        assert_eq!(FORWARD_INCREMENT, f64::EPSILON.sqrt());
        assert!((CENTRAL_INCREMENT / f64::EPSILON.cbrt() - 1.0).abs() < 4.0 * f64::EPSILON);
    }

    #[test]
    fn both_schemes_have_their_accuracy() {
        let x = [0.7, -1.3];
        let mut exact = Matrix::zeros(3, 2);
        Exponentials.jacobian(&x, &mut exact).unwrap();
        let mut residual = [0.0; 3];
        Exponentials.residual(&x, &mut residual).unwrap();
        let mut differences = Differences::new(2, 3);
        let mut found = Matrix::zeros(3, 2);
        differences.forward(&mut Exponentials, &x, &residual, &[1.0; 2], &mut found).unwrap();
        assert!((&found - &exact).amax() < 5e-8, "{found}");
        differences.central(&mut Exponentials, &x, &[1.0; 2], &mut found).unwrap();
        assert!((&found - &exact).amax() < 2e-10, "{found}");
    }

    #[test]
    fn increments_point_away_from_zero_and_scale() {
        assert_eq!(increment(0.0, 1.0, 1e-3), 1e-3);
        assert_eq!(increment(-2.0, 1.0, 1e-3), -2e-3);
        assert_eq!(increment(1e-9, 1e-6, 1e-3), 1e-9);
    }
}
