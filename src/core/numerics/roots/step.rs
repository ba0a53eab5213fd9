//! Newton step `J dx = -R` by LU factorisation, or by the pseudo-inverse if there is no unique solution.

use crate::numerics::linalg::{Lu, Matrix, minimum_norm_solution};

/// If the ratio of the smallest to the largest pivot exceeds this, the matrix is far from singular; otherwise
/// its condition number is estimated.
const PIVOT_RATIO: f64 = 1e-8;

/// A factorised Jacobian.
#[derive(Clone, Debug)]
pub(super) struct NewtonStep {
    lu: Lu,
    equilibrated: Matrix,
    row_scale: Vec<f64>,
    column_scale: Vec<f64>,
    regular: bool,
}

impl NewtonStep {
    pub(super) fn new(unknowns: usize, equations: usize) -> Self {
        let size = if unknowns == equations { unknowns } else { 0 };
        Self {
            lu: Lu::new(size),
            equilibrated: Matrix::zeros(size, size),
            row_scale: vec![1.0; size],
            column_scale: vec![1.0; size],
            regular: false,
        }
    }

    /// True if the factorised Jacobian is square and not singular to rounding.
    pub(super) fn is_regular(&self) -> bool {
        self.regular
    }

    /// Factorises a finite Jacobian. Rows and columns are first scaled by powers of two, which is exact, so
    /// that the test for singularity does not depend on the units of equations and unknowns.
    pub(super) fn factorise(&mut self, jacobian: &Matrix) {
        self.regular = jacobian.is_square() && self.equilibrate(jacobian) && self.factorise_equilibrated();
    }

    /// False if a row or a column is zero.
    fn equilibrate(&mut self, jacobian: &Matrix) -> bool {
        self.row_scale.fill(0.0);
        for column in jacobian.column_iter() {
            for (scale, entry) in self.row_scale.iter_mut().zip(column.iter()) {
                *scale = scale.max(entry.abs());
            }
        }
        for scale in &mut self.row_scale {
            *scale = 1.0 / power_of_two_below(*scale);
        }
        for j in 0..jacobian.ncols() {
            let mut scaled = self.equilibrated.column_mut(j);
            let mut largest = 0.0_f64;
            for ((scaled, entry), scale) in
                scaled.iter_mut().zip(jacobian.column(j).iter()).zip(&self.row_scale)
            {
                *scaled = entry * scale;
                largest = largest.max(scaled.abs());
            }
            self.column_scale[j] = 1.0 / power_of_two_below(largest);
            scaled *= self.column_scale[j];
        }
        self.row_scale.iter().chain(&self.column_scale).all(|scale| scale.is_finite())
    }

    fn factorise_equilibrated(&mut self) -> bool {
        let n = self.equilibrated.nrows();
        self.lu.factorise(&self.equilibrated).is_ok()
            && (self.lu.pivot_ratio() > PIVOT_RATIO
                || self.lu.reciprocal_condition() > n as f64 * f64::EPSILON)
    }

    /// `step <- -J^-1 R`, or the minimum-norm least-squares step in the scaled variables (dx / x_scale, R /
    /// f_scale) if J is singular or not square. False if there is no finite step.
    pub(super) fn solve(
        &mut self,
        jacobian: &Matrix,
        residual: &[f64],
        x_scale: &[f64],
        f_scale: &[f64],
        step: &mut [f64],
    ) -> bool {
        if self.regular {
            for (i, step) in step.iter_mut().enumerate() {
                *step = -residual[i] * self.row_scale[i];
            }
            self.lu.solve(step);
            for (j, step) in step.iter_mut().enumerate() {
                *step *= self.column_scale[j];
            }
        } else {
            let (m, n) = jacobian.shape();
            let scaled = Matrix::from_fn(m, n, |i, j| jacobian[(i, j)] * x_scale[j] / f_scale[i]);
            let right: Vec<f64> = residual.iter().zip(f_scale).map(|(r, scale)| -r / scale).collect();
            let Some(solution) = minimum_norm_solution(&scaled, &right) else { return false };
            for j in 0..n {
                step[j] = solution.x[j] * x_scale[j];
            }
        }
        step.iter().all(|v| v.is_finite())
    }
}

/// Largest power of two not greater than `value`; zero for zero and subnormal numbers.
fn power_of_two_below(value: f64) -> f64 {
    const EXPONENT: u64 = 0x7ff0_0000_0000_0000; // IEEE 754 binary64
    f64::from_bits(value.to_bits() & EXPONENT)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn newton_step(jacobian: &Matrix, residual: &[f64]) -> (bool, Vec<f64>) {
        let (m, n) = jacobian.shape();
        let mut solver = NewtonStep::new(n, m);
        solver.factorise(jacobian);
        let mut step = vec![0.0; n];
        assert!(solver.solve(jacobian, residual, &vec![1.0; n], &vec![1.0; m], &mut step));
        (solver.is_regular(), step)
    }

    #[test]
    fn units_do_not_make_a_matrix_singular() {
        let jacobian = Matrix::from_row_slice(2, 2, &[1e-20, 2e-20, 1e15, -1e15]);
        let (regular, step) = newton_step(&jacobian, &[-3e-20, 0.0]);
        assert!(regular);
        assert!((step[0] - 1.0).abs() < 1e-15 && (step[1] - 1.0).abs() < 1e-15);
    }

    #[test]
    fn a_singular_matrix_gives_the_minimum_norm_step() {
        let (regular, step) = newton_step(&Matrix::from_element(2, 2, 1.0), &[-2.0, -2.0]);
        assert!(!regular);
        assert!((step[0] - 1.0).abs() < 1e-15 && (step[1] - 1.0).abs() < 1e-15);
        let third = 1.0 / 3.0;
        let nearly = Matrix::from_row_slice(2, 2, &[third, 0.1, 3.0 * third, 3.0 * 0.1]);
        assert!(!newton_step(&nearly, &[1.0, 1.0]).0);
    }

    #[test]
    fn powers_of_two() {
        assert_eq!(power_of_two_below(1.0), 1.0);
        assert_eq!(power_of_two_below(1023.9), 512.0);
        assert_eq!(power_of_two_below(0.3), 0.25);
        assert_eq!(power_of_two_below(0.0), 0.0);
    }
}
