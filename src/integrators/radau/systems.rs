//! Linear systems of the simplified Newton iteration: a real and a complex one for all coordinates and
//! multipliers.

use crate::integrators::newmark::LinearSystem;
use crate::integrators::ode::radau_iia::{MU_COMPLEX, MU_REAL, is_same_size};
use crate::integrators::second_order::{Counters, Failure};
use crate::numerics::linalg::{ComplexLu, Matrix};

/// `M + (h / mu) C + (h / mu)^2 K`, bordered by constraints where there are any, for the real and the complex eigenvalue.
#[derive(Clone, Debug)]
pub(super) struct Systems {
    n: usize,
    /// The step size for which both are factorised.
    factorised_for: Option<f64>,
    real: LinearSystem,
    /// Real and imaginary part, and the same with their borders.
    complex_matrix: [Matrix; 2],
    bordered: [Matrix; 2],
    complex: ComplexLu,
}

impl Systems {
    pub(super) fn new(n: usize, constraints: usize) -> Self {
        let bordered = if constraints > 0 { n + constraints } else { 0 };
        Self {
            n,
            factorised_for: None,
            real: LinearSystem::of_size(n, constraints),
            complex_matrix: [(); 2].map(|()| Matrix::zeros(n, n)),
            bordered: [(); 2].map(|()| Matrix::zeros(bordered, bordered)),
            complex: ComplexLu::new(n + constraints),
        }
    }

    /// The step size for which both are factorised.
    pub(super) fn factorised_for(&mut self) -> &mut Option<f64> {
        &mut self.factorised_for
    }

    /// Factorises both from the tangents, K, C and M, and the derivative of the constraints, unless that has been done.
    pub(super) fn factorise(
        &mut self,
        h: f64,
        tangents: &[Matrix; 3],
        constraints: &Matrix,
        counters: &mut Counters,
    ) -> Result<(), Failure> {
        if self.factorised_for.is_some_and(|size| is_same_size(h, size)) {
            return Ok(());
        }
        self.factorised_for = None;
        counters.nlu += 2;
        let x = h / MU_REAL;
        let matrix = match &mut self.real {
            LinearSystem::Dense { jacobian, .. } => jacobian,
            LinearSystem::Saddle(saddle) => {
                saddle.constraints.copy_from(constraints);
                &mut saddle.tangent
            }
            LinearSystem::Tree { .. } | LinearSystem::Blocks { .. } => {
                unreachable!("all entries are solved with")
            }
        };
        sum(tangents, [x * x, x, 1.0], matrix);
        self.real.factorise()?;
        let (re, im) = MU_COMPLEX;
        let size = re * re + im * im;
        let (x, y) = (h * re / size, -h * im / size);
        let [real, imaginary] = &mut self.complex_matrix;
        sum(tangents, [x * x - y * y, x, 1.0], real);
        sum(tangents, [2.0 * x * y, y, 0.0], imaginary);
        let factorised = match &self.real {
            LinearSystem::Saddle(saddle) => {
                let [with_border, without] = &mut self.bordered;
                saddle.border(real, with_border);
                without.view_mut((0, 0), (self.n, self.n)).copy_from(imaginary);
                self.complex.factorise_sum(with_border, without)
            }
            _ => self.complex.factorise_sum(real, imaginary),
        };
        factorised.map_err(|_| Failure::SingularJacobian)?;
        self.factorised_for = Some(h);
        Ok(())
    }

    /// Solves the real one, in place.
    pub(super) fn solve_real(&mut self, b: &mut [f64]) {
        self.real.solve(b);
    }

    /// Solves the complex one, in place.
    pub(super) fn solve_complex(&mut self, real: &mut [f64], imaginary: &mut [f64]) {
        self.drop_dependent(real);
        self.drop_dependent(imaginary);
        self.complex.solve(real, imaginary);
    }

    /// Sets multipliers of constraints that others determine to zero.
    pub(super) fn drop_dependent(&self, unknowns: &mut [f64]) {
        if let LinearSystem::Saddle(saddle) = &self.real {
            saddle.drop_dependent(&mut unknowns[self.n..]);
        }
    }

    /// `out <- W x` with the real one, where there are no constraints.
    pub(super) fn multiply_real(&self, x: &[f64], out: &mut [f64]) {
        match &self.real {
            LinearSystem::Dense { jacobian, .. } => multiply(jacobian, x, out),
            _ => unreachable!("there are constraints"),
        }
    }
}

/// `out <- weights[0] K + weights[1] C + weights[2] M`.
pub(super) fn sum([k, c, m]: &[Matrix; 3], weights: [f64; 3], out: &mut Matrix) {
    let parts = k.as_slice().iter().zip(c.as_slice()).zip(m.as_slice());
    for (out, ((k, c), m)) in out.as_mut_slice().iter_mut().zip(parts) {
        *out = weights[0] * k + weights[1] * c + weights[2] * m;
    }
}

/// `out <- matrix x`.
fn multiply(matrix: &Matrix, x: &[f64], out: &mut [f64]) {
    out.fill(0.0);
    for (column, x) in matrix.column_iter().zip(x) {
        for (out, entry) in out.iter_mut().zip(column.iter()) {
            *out += entry * x;
        }
    }
}
