//! The equations of the stages of a step, their solution and the estimate of the step's error.

use crate::error::Interrupted;
use crate::linalg::{ComplexLu, Lu, Matrix, Singular};
use crate::ode::norm::{all_finite, scaled_norm};
use crate::ode::radau_iia::{
    A, A_SQUARED, C, Converged, E_A, E_A_SQUARED, Iteration, MU_COMPLEX, MU_REAL, STAGES, T, T_INVERSE,
    Verdict, is_same_size, norm_of_stages, transform,
};
use crate::second_order::{Counters, Failure, System};
use crate::tape::Tape;

/// So many steps begin with the tangents of each stage after one that needed them.
const STEPS_BY_STAGE: u32 = 16;

/// The state from which a step starts.
#[derive(Clone, Copy, Debug)]
pub(super) struct Start<'a> {
    pub(super) t: f64,
    pub(super) q: &'a [f64],
    pub(super) v: &'a [f64],
    pub(super) a: &'a [f64],
}

/// The stages with their memory.
#[derive(Clone, Debug)]
pub(super) struct Stages {
    n: usize,
    newton_tolerance: f64,
    /// dr/dq, dr/dv and dr/da.
    tangents: [Matrix; 3],
    tangents_are_current: bool,
    /// The step size for which both systems are factorised.
    factorised_for: Option<f64>,
    real_matrix: Matrix,
    complex_matrix: [Matrix; 2],
    real: Lu,
    complex: ComplexLu,
    /// What the real matrix would be with the tangents of each stage, and how many steps are to begin with that.
    stage_matrix: Matrix,
    stage_systems: [Lu; STAGES],
    steps_by_stage: u32,
    /// One vector.
    scratch: Vec<f64>,
    /// Accelerations of the stages, three times n numbers, like `w`, the same in the basis of the eigenvectors.
    pub(super) a: Vec<f64>,
    w: Vec<f64>,
    residual: Vec<f64>,
    dw: Vec<f64>,
    da: Vec<f64>,
    /// Corrections of displacements and velocities of each stage, 2n numbers each.
    dy: Vec<f64>,
    /// Displacements and velocities of one stage; those at the end of the step when it is solved.
    pub(super) q: Vec<f64>,
    pub(super) v: Vec<f64>,
    /// Size of the last step, where it can be continued, and its stages.
    last_size: Option<f64>,
    last: Vec<f64>,
    /// Error of displacements and velocities.
    error: Vec<f64>,
    work: Vec<f64>,
}

impl Stages {
    /// Memory for `n` coordinates; `rtol` is the smallest relative tolerance.
    pub(super) fn new(n: usize, rtol: f64) -> Self {
        let square = || Matrix::zeros(n, n);
        let vectors = |count| vec![0.0; count * n];
        Self {
            n,
            newton_tolerance: Iteration::tolerance(rtol),
            tangents: [square(), square(), square()],
            tangents_are_current: false,
            factorised_for: None,
            real_matrix: square(),
            complex_matrix: [square(), square()],
            real: Lu::new(n),
            complex: ComplexLu::new(n),
            stage_matrix: square(),
            stage_systems: std::array::from_fn(|_| Lu::new(n)),
            steps_by_stage: 0,
            scratch: vectors(1),
            a: vectors(STAGES),
            w: vectors(STAGES),
            residual: vectors(STAGES),
            dw: vectors(STAGES),
            da: vectors(STAGES),
            dy: vectors(2 * STAGES),
            q: vectors(1),
            v: vectors(1),
            last_size: None,
            last: vectors(STAGES),
            error: vectors(2),
            work: vectors(2),
        }
    }

    /// Evaluates the tangents at the start of a step.
    pub(super) fn evaluate_tangents<S: System + ?Sized>(
        &mut self,
        system: &mut S,
        start: &Start<'_>,
        counters: &mut Counters,
    ) -> Result<(), Interrupted> {
        self.factorised_for = None;
        let unit = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for (tangent, weights) in self.tangents.iter_mut().zip(unit) {
            system.tangent(start.t, start.q, start.v, start.a, weights, tangent)?;
        }
        counters.njev += 1;
        self.tangents_are_current = true;
        Ok(())
    }

    /// The derivative of the residual with respect to the accelerations.
    pub(super) fn mass(&self) -> &Matrix {
        &self.tangents[2]
    }

    /// True while steps begin with the tangents of each stage, beside which those at the start may be old.
    pub(super) fn have_own_tangents(&self) -> bool {
        self.steps_by_stage > 0
    }

    /// Tangents belong to an earlier step from now on.
    pub(super) fn forget_start(&mut self) {
        self.tangents_are_current = false;
    }

    /// Solves for the stages of a step of size `h`. On success `a`, and `q`, `v` at the end of the step, are those of
    /// the step.
    ///
    /// Where the iteration does not converge, the masses have often changed within the step (those of torsion do by
    /// orders of magnitude as a rod bends). It is tried again with the tangents of each stage in place of those at
    /// one state, then with fresh ones there.
    pub(super) fn solve<S: System + ?Sized>(
        &mut self,
        system: &mut S,
        start: &Start<'_>,
        (h, t_new): (f64, f64),
        scale: &[f64],
        counters: &mut Counters,
    ) -> Result<Result<Converged, Failure>, Interrupted> {
        let mut by_stage = self.steps_by_stage > 0;
        loop {
            let found = match self.factorise(h, counters) {
                Ok(()) => self.iterate(system, start, (h, t_new), scale, by_stage, counters)?,
                Err(Singular) => Err(Failure::SingularJacobian),
            };
            match found {
                Ok(_) if by_stage => self.steps_by_stage = self.steps_by_stage.saturating_sub(1),
                Err(Failure::NotConverged) if !by_stage => {
                    by_stage = true;
                    self.steps_by_stage = STEPS_BY_STAGE;
                    counters.full_newton += 1;
                    continue;
                }
                Err(_) if !self.tangents_are_current => {
                    counters.reuse_failures += 1;
                    self.evaluate_tangents(system, start, counters)?;
                    continue;
                }
                _ => {}
            }
            return Ok(found);
        }
    }

    /// `W_i = M + (h / mu) C + (h / mu)^2 K` with the tangents of each stage as it is predicted. Multiplied by
    /// `W W_i^-1`, with the W at the start of the step, the equations of a stage get the tangents that the iteration
    /// assumes: for slow motions, which the masses govern, and for stiff ones.
    fn factorise_stages<S: System + ?Sized>(
        &mut self,
        system: &mut S,
        start: &Start<'_>,
        h: f64,
        counters: &mut Counters,
    ) -> Result<Result<(), Failure>, Interrupted> {
        let (n, x) = (self.n, h / MU_REAL);
        counters.njev += 1;
        counters.nlu += STAGES;
        for (stage, c) in C.into_iter().enumerate() {
            self.move_to_stage(start, h, stage);
            let a = &self.a[stage * n..][..n];
            let t = start.t + c * h;
            system.tangent(t, &self.q, &self.v, a, [x * x, x, 1.0], &mut self.stage_matrix)?;
            if self.stage_systems[stage].factorise(&self.stage_matrix).is_err() {
                let is_finite = all_finite(self.stage_matrix.as_slice());
                return Ok(Err(if is_finite { Failure::SingularJacobian } else { Failure::NonFinite }));
            }
        }
        Ok(Ok(()))
    }

    /// Factorises `M + (h / mu) C + (h / mu)^2 K` for the real and the complex eigenvalue, unless that has been done.
    fn factorise(&mut self, h: f64, counters: &mut Counters) -> Result<(), Singular> {
        if self.factorised_for.is_some_and(|size| is_same_size(h, size)) {
            return Ok(());
        }
        self.factorised_for = None;
        counters.nlu += 2;
        let [k, c, m] = &self.tangents;
        let sum = |out: &mut Matrix, weights: [f64; 3]| {
            for (((out, k), c), m) in out.iter_mut().zip(k.iter()).zip(c.iter()).zip(m.iter()) {
                *out = weights[0] * k + weights[1] * c + weights[2] * m;
            }
        };
        let x = h / MU_REAL;
        sum(&mut self.real_matrix, [x * x, x, 1.0]);
        self.real.factorise(&self.real_matrix)?;
        let (re, im) = MU_COMPLEX;
        let size = re * re + im * im;
        let (x, y) = (h * re / size, -h * im / size);
        let [real, imaginary] = &mut self.complex_matrix;
        sum(real, [x * x - y * y, x, 1.0]);
        sum(imaginary, [2.0 * x * y, y, 0.0]);
        self.complex.factorise_sum(real, imaginary)?;
        self.factorised_for = Some(h);
        Ok(())
    }

    /// The simplified Newton iteration.
    fn iterate<S: System + ?Sized>(
        &mut self,
        system: &mut S,
        start: &Start<'_>,
        (h, t_new): (f64, f64),
        scale: &[f64],
        by_stage: bool,
        counters: &mut Counters,
    ) -> Result<Result<Converged, Failure>, Interrupted> {
        let n = self.n;
        self.predict(start, h);
        if by_stage && let Err(failure) = self.factorise_stages(system, start, h, counters)? {
            return Ok(Err(failure));
        }
        transform(&T_INVERSE, &self.a, &mut self.w);
        let mut iteration = Iteration::new(self.newton_tolerance);
        loop {
            counters.newton_iterations += 1;
            for (stage, c) in C.into_iter().enumerate() {
                self.move_to_stage(start, h, stage);
                // Rounding must not carry the last stage beyond the end of the interval.
                let t = if stage + 1 == STAGES { t_new } else { start.t + c * h };
                let (a, residual) = (&self.a[stage * n..][..n], &mut self.residual[stage * n..][..n]);
                counters.nfev += 1;
                system.residual(t, &self.q, &self.v, a, residual)?;
            }
            if !all_finite(&self.residual) {
                return Ok(Err(Failure::NonFinite));
            }
            if by_stage {
                for (residual, stage) in self.residual.chunks_exact_mut(n).zip(&mut self.stage_systems) {
                    stage.solve(residual);
                    multiply(&self.real_matrix, residual, &mut self.scratch);
                    residual.copy_from_slice(&self.scratch);
                }
            }
            transform(&T_INVERSE, &self.residual, &mut self.dw);
            let (real, pair) = self.dw.split_at_mut(n);
            let (first, second) = pair.split_at_mut(n);
            self.real.solve(real);
            self.complex.solve(first, second);
            transform(&T, &self.dw, &mut self.da);
            let size = self.size_of_correction(h, scale);
            let verdict = iteration.judge(size);
            if matches!(verdict, Verdict::Diverges) {
                return Ok(Err(Failure::NotConverged));
            }
            for (a, da) in self.a.iter_mut().zip(&self.da) {
                *a -= da;
            }
            if let Verdict::Converged(converged) = verdict {
                self.move_to_stage(start, h, STAGES - 1);
                return Ok(Ok(converged));
            }
        }
    }

    /// First guess of the accelerations: the polynomial through those of the last step, continued.
    fn predict(&mut self, start: &Start<'_>, h: f64) {
        let n = self.n;
        let (Some(last_h), last) = (self.last_size, &self.last) else {
            for stage in self.a.chunks_exact_mut(n) {
                stage.copy_from_slice(start.a);
            }
            return;
        };
        for (c, stage) in C.into_iter().zip(self.a.chunks_exact_mut(n)) {
            let x = 1.0 + c * h / last_h;
            let weights: [f64; STAGES] = std::array::from_fn(|i| {
                (0..STAGES).filter(|&j| j != i).map(|j| (x - C[j]) / (C[i] - C[j])).product()
            });
            for (i, value) in stage.iter_mut().enumerate() {
                *value = (0..STAGES).map(|j| weights[j] * last[j * n + i]).sum();
            }
        }
    }

    /// Displacements and velocities of a stage from its accelerations.
    fn move_to_stage(&mut self, start: &Start<'_>, h: f64, stage: usize) {
        let (n, c) = (self.n, C[stage]);
        let (row, squared) = (&A[stage], &A_SQUARED[stage]);
        for i in 0..n {
            let a: [f64; STAGES] = std::array::from_fn(|j| self.a[j * n + i]);
            let sum = |row: &[f64; STAGES]| row[0] * a[0] + row[1] * a[1] + row[2] * a[2];
            self.q[i] = start.q[i] + h * (c * start.v[i] + h * sum(squared));
            self.v[i] = start.v[i] + h * sum(row);
        }
    }

    /// What the correction `da` does to displacements and velocities of the stages, relative to the tolerances.
    fn size_of_correction(&mut self, h: f64, scale: &[f64]) -> f64 {
        let n = self.n;
        for (stage, dy) in self.dy.chunks_exact_mut(2 * n).enumerate() {
            let (dq, dv) = dy.split_at_mut(n);
            for i in 0..n {
                let da: [f64; STAGES] = std::array::from_fn(|j| self.da[j * n + i]);
                let sum = |row: &[f64; STAGES]| row[0] * da[0] + row[1] * da[1] + row[2] * da[2];
                dq[i] = h * h * sum(&A_SQUARED[stage]);
                dv[i] = h * sum(&A[stage]);
            }
        }
        norm_of_stages(&self.dy, scale)
    }

    /// The estimated error of the step relative to `scale` (Hairer and Wanner 1996, eqs. IV.8.19 and IV.8.20).
    ///
    /// Of first order it reads `(mu / h - J) e = f(y0) + sum E_i z_i / h`. With e = (e_q, e_v), multiplied by the
    /// mass matrix and with e_v eliminated, it takes the real matrix of the step.
    pub(super) fn error<S: System + ?Sized>(
        &mut self,
        system: &mut S,
        start: &Start<'_>,
        h: f64,
        scale: &[f64],
        was_rejected: bool,
        counters: &mut Counters,
    ) -> Result<f64, Interrupted> {
        let n = self.n;
        let (g_q, g_v) = self.work.split_at_mut(n);
        for i in 0..n {
            let a: [f64; STAGES] = std::array::from_fn(|j| self.a[j * n + i]);
            let sum = |row: &[f64; STAGES]| row[0] * a[0] + row[1] * a[1] + row[2] * a[2];
            // The velocities at the start cancel.
            g_q[i] = h * sum(&E_A_SQUARED);
            g_v[i] = start.a[i] + sum(&E_A);
        }
        self.residual[..n].fill(0.0);
        self.filter(h);
        let mut size = scaled_norm(&self.error, scale);
        if was_rejected && size > 1.0 {
            // The first estimate is far too large where the problem is very stiff.
            for i in 0..n {
                self.q[i] = start.q[i] + self.error[i];
                self.v[i] = start.v[i] + self.error[n + i];
                self.work[i] += self.error[n + i];
            }
            counters.nfev += 1;
            system.residual(start.t, &self.q, &self.v, start.a, &mut self.residual[..n])?;
            self.filter(h);
            size = scaled_norm(&self.error, scale);
            self.move_to_stage(start, h, STAGES - 1);
        }
        Ok(size)
    }

    /// `error` from the g of displacements and velocities in `work`, where the accelerations at the start leave a
    /// residual.
    fn filter(&mut self, h: f64) {
        let n = self.n;
        let x = h / MU_REAL;
        let (g_q, g_v) = self.work.split_at(n);
        let (e_q, e_v) = self.error.split_at_mut(n);
        let [_, c, m] = &self.tangents;
        e_q.fill(0.0);
        for j in 0..n {
            let (of_mass, of_damping) = (x * x * g_v[j] + x * g_q[j], x * x * g_q[j]);
            for i in 0..n {
                e_q[i] += m[(i, j)] * of_mass + c[(i, j)] * of_damping;
            }
        }
        for (e_q, residual) in e_q.iter_mut().zip(&self.residual) {
            *e_q -= x * x * residual;
        }
        self.real.solve(e_q);
        for i in 0..n {
            e_v[i] = e_q[i] / x - g_q[i];
        }
    }

    /// Predicts nothing from the stages of the last step, which belong to other coordinates.
    pub(super) fn forget_last(&mut self) {
        self.last_size = None;
    }

    /// Keeps the stages of an accepted step, for the next prediction.
    pub(super) fn accept(&mut self, h: f64) {
        self.last_size = Some(h);
        self.last.copy_from_slice(&self.a);
    }

    /// What goes on from step to step: tangents, and the last stages.
    pub(super) fn carry(&mut self, tape: &mut Tape<'_>) {
        for tangent in &mut self.tangents {
            tape.numbers(tangent.as_mut_slice());
        }
        tape.flag(&mut self.tangents_are_current);
        tape.optional(&mut self.factorised_for, 0.0, Tape::number);
        tape.small_count(&mut self.steps_by_stage);
        tape.optional(&mut self.last_size, 0.0, Tape::number);
        tape.numbers(&mut self.last);
        if tape.reads()
            && let Some(h) = self.factorised_for.take()
        {
            // Where it fails, the next step meets that, too.
            let _ = self.factorise(h, &mut Counters::default());
        }
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
