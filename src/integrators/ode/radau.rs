//! The Radau IIA method of order 5 for systems of first order (Hairer and Wanner 1996, "Solving Ordinary Differential
//! Equations II", section IV.8, and their code RADAU5).
//!
//! The stages `z_i = y(t + c_i h) - y` solve `z = h (A x I) F(z)`. The inverse of A has one real eigenvalue
//! and one conjugate pair. With the transformation `z = (T x I) w`, each iteration of the simplified Newton
//! method solves one real and one complex system of n equations: `(mu / h - J) dw = ...`.

use super::dense::{Form, StepPolynomial};
use super::differences::{DifferencedJacobian, Place, Sparsity};
use super::norm::{all_finite, scaled_norm};
use super::radau_iia::{
    self, C, DIVERGENCE_FACTOR, E, MU_COMPLEX, MU_REAL, SMALLEST_FACTOR, SQRT_6, STAGES, StepError, T,
    T_INVERSE, is_same_size, next_size, norm_of_stages, step_factor, transform,
};
use super::state::{Advance, State};
use super::status::Status;
use super::{FirstOrderSystem, JacobianKind};
use crate::error::{Interrupted, InvalidInput};
use crate::integrators::Reason;
use crate::integrators::chord::{Converged, Iteration, Verdict};
use crate::numerics::linalg::{ComplexLu, Lu, Matrix, Singular};
use crate::numerics::memory;

/// Collocation polynomial: row j maps the stages to the coefficient of `x^(j+1)`.
const POLYNOMIAL: [[f64; STAGES]; STAGES] = [
    [13.0 / 3.0 + 7.0 * SQRT_6 / 3.0, 13.0 / 3.0 - 7.0 * SQRT_6 / 3.0, 1.0 / 3.0],
    [-23.0 / 3.0 - 22.0 * SQRT_6 / 3.0, -23.0 / 3.0 + 22.0 * SQRT_6 / 3.0, -8.0 / 3.0],
    [10.0 / 3.0 + 5.0 * SQRT_6, 10.0 / 3.0 - 5.0 * SQRT_6, 10.0 / 3.0],
];

/// Radau IIA with its working memory.
#[derive(Clone, Debug)]
pub(super) struct Radau {
    newton_tolerance: f64,
    differences: DifferencedJacobian,
    jacobian: Matrix,
    jacobian_is_current: bool,
    jacobian_is_finite: bool,
    // The next step must start with a new Jacobian.
    jacobian_is_wanted: bool,
    shifted: Matrix,
    real: Lu,
    complex: ComplexLu,
    // Step size of the current factorisations.
    factorised_for: Option<f64>,
    // Three vectors each, stored consecutively.
    z: Vec<f64>,
    w: Vec<f64>,
    dw: Vec<f64>,
    f: Vec<f64>,
    argument: Vec<f64>,
    error: Vec<f64>,
    scale: Vec<f64>,
    // Data of the last accepted step.
    accepted_error: Vec<f64>,
    polynomial: Vec<f64>,
    last: Option<LastStep>,
}

/// Last step: data for its polynomial and for the choice of the next step size.
#[derive(Clone, Copy, Debug)]
struct LastStep {
    t_old: f64,
    t: f64,
    sized: StepError,
}

impl Radau {
    pub(super) const FORM: Form = Form::Monomial { degree: STAGES };
    pub(super) const ERROR_ORDER: f64 = radau_iia::ERROR_ORDER;

    /// Memory for `n` equations; fails if there is not enough.
    pub(super) fn new(n: usize, rtol: &[f64], sparsity: Option<Sparsity>) -> Result<Self, InvalidInput> {
        check_memory(n, sparsity.as_ref().map_or(n, Sparsity::groups))?;
        Ok(Self {
            newton_tolerance: Iteration::tolerance(rtol.iter().copied().fold(1.0, f64::min)),
            differences: DifferencedJacobian::new(n, sparsity),
            jacobian: Matrix::zeros(n, n),
            jacobian_is_current: false,
            jacobian_is_finite: true,
            jacobian_is_wanted: false,
            shifted: Matrix::zeros(n, n),
            real: Lu::new(n),
            complex: ComplexLu::new(n),
            factorised_for: None,
            z: vec![0.0; STAGES * n],
            w: vec![0.0; STAGES * n],
            dw: vec![0.0; STAGES * n],
            f: vec![0.0; STAGES * n],
            argument: vec![0.0; n],
            error: vec![0.0; n],
            accepted_error: vec![0.0; n],
            scale: vec![0.0; n],
            polynomial: vec![0.0; (STAGES + 1) * n],
            last: None,
        })
    }

    /// Collocation polynomial of the last accepted step.
    pub(super) fn polynomial(&self) -> &[f64] {
        &self.polynomial
    }

    /// Error estimate of the last accepted step.
    pub(super) fn error_estimate(&self) -> &[f64] {
        &self.accepted_error
    }

    /// Evaluates the first Jacobian.
    pub(super) fn start<S: FirstOrderSystem + ?Sized>(
        &mut self,
        state: &mut State,
        system: &mut S,
    ) -> Result<(), Interrupted> {
        match system.jacobian_kind() {
            JacobianKind::Constant => {
                system.jacobian(state.t, &state.y, &mut self.jacobian)?;
                self.jacobian_is_current = true;
                self.jacobian_is_finite = all_finite(self.jacobian.as_slice());
                Ok(())
            }
            JacobianKind::Supplied | JacobianKind::Differenced => self.evaluate_jacobian(state, system),
        }
    }

    /// Restarts from a state in new coordinates.
    pub(super) fn restart<S: FirstOrderSystem + ?Sized>(
        &mut self,
        state: &mut State,
        system: &mut S,
    ) -> Result<(), Interrupted> {
        self.last = None;
        self.evaluate_jacobian(state, system)
    }

    /// Updates the Jacobian at the current state, unless it is constant.
    fn evaluate_jacobian<S: FirstOrderSystem + ?Sized>(
        &mut self,
        state: &mut State,
        system: &mut S,
    ) -> Result<(), Interrupted> {
        match system.jacobian_kind() {
            JacobianKind::Constant => return Ok(()),
            JacobianKind::Supplied => system.jacobian(state.t, &state.y, &mut self.jacobian)?,
            JacobianKind::Differenced => {
                let place = Place {
                    t: state.t,
                    y: &state.y,
                    f: &state.f,
                    threshold: &state.tolerances.atol,
                    h_abs: state.h_abs,
                };
                state.counters.nfev_jacobian +=
                    self.differences.evaluate(system, &place, &mut self.jacobian)?;
            }
        }
        state.counters.njev += 1;
        self.jacobian_is_current = true;
        self.jacobian_is_finite = all_finite(self.jacobian.as_slice());
        self.jacobian_is_wanted = false;
        self.factorised_for = None;
        Ok(())
    }

    /// Makes one accepted step, not longer than `state` proposes.
    pub(super) fn advance<S: FirstOrderSystem + ?Sized>(
        &mut self,
        state: &mut State,
        system: &mut S,
    ) -> Result<Advance, Interrupted> {
        let smallest = state.smallest_step();
        let (mut h_abs, last) = if state.h_abs > state.max_step {
            (state.max_step, None)
        } else if state.h_abs >= smallest {
            (state.h_abs, self.last)
        } else {
            (smallest, None)
        };
        if self.jacobian_is_wanted {
            self.evaluate_jacobian(state, system)?;
        }
        let mut was_rejected = false;
        let mut finite = true;
        loop {
            if h_abs < smallest {
                return Ok(Advance::Failed(if finite { Status::StepTooSmall } else { Status::NonFinite }));
            }
            let (t_new, h) = state.step_to(h_abs);
            h_abs = h.abs();
            state.retries.attempt();
            let Some(newton) = self.solve_stages(state, system, t_new, h)? else {
                if !self.jacobian_is_finite {
                    return Ok(Advance::Failed(Status::NonFiniteJacobian));
                }
                state.counters.rejected += 1;
                finite = all_finite(&self.f);
                state.retries.fail(if finite { Reason::NotConverged } else { Reason::NonFinite });
                h_abs *= DIVERGENCE_FACTOR;
                continue;
            };
            finite = true;
            self.evaluate_error(state, system, h, was_rejected)?;
            let error = scaled_norm(&self.error, &self.scale);
            let sized = StepError { h_abs, error };
            let factor = step_factor(sized, last.map(|last| last.sized), newton.iterations);
            if error <= 1.0 {
                state.counters.nfev += 1;
                system.rhs(t_new, &state.y_new, &mut self.argument)?;
                finite = all_finite(&state.y_new) && all_finite(&self.argument);
                if finite {
                    let constant_jacobian = system.jacobian_kind() == JacobianKind::Constant;
                    self.accept(state, t_new, &newton, (sized, factor), constant_jacobian);
                    return Ok(Advance::Accepted);
                }
            }
            state.counters.rejected += 1;
            state.retries.fail(if finite { Reason::Error } else { Reason::NonFinite });
            was_rejected = true;
            h_abs *= if finite { factor.max(SMALLEST_FACTOR) } else { DIVERGENCE_FACTOR };
        }
    }

    /// Solves for the stages of a step, with a new Jacobian if the old one does not converge; `None` if the
    /// Newton iteration fails.
    fn solve_stages<S: FirstOrderSystem + ?Sized>(
        &mut self,
        state: &mut State,
        system: &mut S,
        t_new: f64,
        h: f64,
    ) -> Result<Option<Converged>, Interrupted> {
        loop {
            if !self.jacobian_is_finite {
                return Ok(None);
            }
            if self.factorise(state, h).is_ok() {
                let converged = self.iterate(state, system, t_new, h)?;
                if converged.is_some() || self.jacobian_is_current {
                    return Ok(converged);
                }
            } else if self.jacobian_is_current {
                return Ok(None);
            }
            self.evaluate_jacobian(state, system)?;
        }
    }

    /// Factorises `mu / h - J` for the real and the complex eigenvalue, unless the factorisations are
    /// current.
    fn factorise(&mut self, state: &mut State, h: f64) -> Result<(), Singular> {
        if self.factorised_for.is_some_and(|size| is_same_size(h, size)) {
            return Ok(());
        }
        self.factorised_for = None;
        state.counters.nlu += 2;
        for (entry, jacobian) in self.shifted.iter_mut().zip(self.jacobian.iter()) {
            *entry = -jacobian;
        }
        for i in 0..state.y.len() {
            self.shifted[(i, i)] += MU_REAL / h;
        }
        self.real.factorise(&self.shifted)?;
        self.complex.factorise((MU_COMPLEX.0 / h, MU_COMPLEX.1 / h), &self.jacobian)?;
        self.factorised_for = Some(h);
        Ok(())
    }

    /// Simplified Newton iteration; on success `z` and `state.y_new` are those of the step.
    fn iterate<S: FirstOrderSystem + ?Sized>(
        &mut self,
        state: &mut State,
        system: &mut S,
        t_new: f64,
        h: f64,
    ) -> Result<Option<Converged>, Interrupted> {
        let n = state.y.len();
        self.predict_stages(state, h);
        transform(&T_INVERSE, &self.z, &mut self.w);
        for i in 0..n {
            self.scale[i] = state.tolerances.atol[i] + state.y[i].abs() * state.tolerances.rtol[i];
        }
        let mut iteration = Iteration::new(self.newton_tolerance);
        loop {
            for (stage, c) in C.into_iter().enumerate() {
                let z = &self.z[stage * n..][..n];
                for ((argument, y), z) in self.argument.iter_mut().zip(&state.y).zip(z) {
                    *argument = y + z;
                }
                // Rounding must not carry the last stage beyond the end of the interval.
                let t = if stage + 1 == STAGES { t_new } else { state.t + c * h };
                state.counters.nfev += 1;
                system.rhs(t, &self.argument, &mut self.f[stage * n..][..n])?;
            }
            if !all_finite(&self.f) {
                return Ok(None);
            }
            self.newton_update(h);
            let verdict = iteration.judge(norm_of_stages(&self.dw, &self.scale));
            if matches!(verdict, Verdict::Diverges) {
                return Ok(None);
            }
            for (w, dw) in self.w.iter_mut().zip(&self.dw) {
                *w += dw;
            }
            transform(&T, &self.w, &mut self.z);
            if let Verdict::Converged(converged) = verdict {
                for ((y_new, y), z) in state.y_new.iter_mut().zip(&state.y).zip(&self.z[2 * n..]) {
                    *y_new = y + z;
                }
                return Ok(Some(converged));
            }
        }
    }

    /// Initial guess of the stages: extrapolation of the last step's polynomial.
    fn predict_stages(&mut self, state: &State, h: f64) {
        let n = state.y.len();
        let Some(last) = self.last else {
            self.z.fill(0.0);
            return;
        };
        let polynomial =
            StepPolynomial { form: Self::FORM, coefficients: &self.polynomial, t_old: last.t_old, t: last.t };
        for (c, z) in C.into_iter().zip(self.z.chunks_exact_mut(n)) {
            polynomial.evaluate(state.t + c * h, z);
            for (z, y) in z.iter_mut().zip(&state.y) {
                *z -= y;
            }
        }
    }

    /// Computes the correction `dw` of `w` from the right-hand sides at the stages.
    fn newton_update(&mut self, h: f64) {
        let n = self.argument.len();
        transform(&T_INVERSE, &self.f, &mut self.dw);
        let (real, pair) = self.dw.split_at_mut(n);
        let (first, second) = pair.split_at_mut(n);
        let (re, im) = (MU_COMPLEX.0 / h, MU_COMPLEX.1 / h);
        for i in 0..n {
            let (w0, w1, w2) = (self.w[i], self.w[n + i], self.w[2 * n + i]);
            real[i] -= MU_REAL / h * w0;
            first[i] -= re * w1 - im * w2;
            second[i] -= re * w2 + im * w1;
        }
        self.real.solve(real);
        self.complex.solve(first, second);
    }

    /// Error estimate of the step, and its scale (ibid., eq. IV.8.19 and IV.8.20).
    fn evaluate_error<S: FirstOrderSystem + ?Sized>(
        &mut self,
        state: &mut State,
        system: &mut S,
        h: f64,
        was_rejected: bool,
    ) -> Result<(), Interrupted> {
        let n = state.y.len();
        for i in 0..n {
            let size = state.y[i].abs().max(state.y_new[i].abs());
            self.scale[i] = state.tolerances.atol[i] + size * state.tolerances.rtol[i];
        }
        // `w` is no longer needed: reuse its memory for the part of the estimate that stays.
        let from_stages = &mut self.w[..n];
        for (i, value) in from_stages.iter_mut().enumerate() {
            *value = (0..STAGES).map(|stage| E[stage] * self.z[stage * n + i]).sum::<f64>() / h;
        }
        for i in 0..n {
            self.error[i] = state.f[i] + self.w[i];
        }
        self.real.solve(&mut self.error);
        if was_rejected && scaled_norm(&self.error, &self.scale) > 1.0 {
            // For very stiff problems the first estimate is far too large.
            for i in 0..n {
                self.argument[i] = state.y[i] + self.error[i];
            }
            state.counters.nfev += 1;
            system.rhs(state.t, &self.argument, &mut self.error)?;
            for i in 0..n {
                self.error[i] += self.w[i];
            }
            self.real.solve(&mut self.error);
        }
        Ok(())
    }

    /// Accepts the step, whose right-hand side at the end is in `argument`, and prepares the next one.
    fn accept(
        &mut self,
        state: &mut State,
        t_new: f64,
        newton: &Converged,
        (sized, factor): (StepError, f64),
        constant_jacobian: bool,
    ) {
        let n = state.y.len();
        state.accept(t_new, &self.argument);
        self.polynomial[..n].copy_from_slice(&state.y_old);
        for (row, coefficients) in POLYNOMIAL.iter().zip(self.polynomial[n..].chunks_exact_mut(n)) {
            for (i, value) in coefficients.iter_mut().enumerate() {
                *value = (0..STAGES).map(|stage| row[stage] * self.z[stage * n + i]).sum();
            }
        }
        std::mem::swap(&mut self.error, &mut self.accepted_error);
        self.last = Some(LastStep { t_old: state.t_old, t: state.t, sized });
        self.jacobian_is_current = constant_jacobian;
        self.jacobian_is_wanted = newton.wants_jacobian() && !constant_jacobian;
        state.h_abs = next_size(sized.h_abs, factor, self.jacobian_is_wanted);
    }
}

/// Rejects systems whose matrices do not fit in memory.
fn check_memory(n: usize, groups: usize) -> Result<(), InvalidInput> {
    /// The Jacobian, the real matrix and its factors, and the complex factors, which count as two.
    const SQUARE_MATRICES: usize = 5;
    /// Arguments and values of a Jacobian by differences, one column per group.
    const COLUMNS_OF_A_GROUP: usize = 2;
    let columns = SQUARE_MATRICES.saturating_mul(n).saturating_add(COLUMNS_OF_A_GROUP.saturating_mul(groups));
    let instead = "an explicit method needs no matrices";
    memory::check(columns.saturating_mul(n), "y0", format_args!("{n} values"), instead)
}
