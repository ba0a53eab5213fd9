//! Equations of the stages of a step, their solution, and the error estimate of the step.

use super::systems::{Systems, sum};
use crate::error::Interrupted;
use crate::integrators::chord::{Converged, Iteration, Verdict};
use crate::integrators::newmark::LinearSystem;
use crate::integrators::ode::norm::{all_finite, scaled_norm};
use crate::integrators::ode::radau_iia::{
    A, A_SQUARED, A_SQUARED_INVERSE, C, E_A, E_A_SQUARED, LARGEST_FACTOR, MU_REAL, SAME_SIZE, STAGES, T,
    T_INVERSE, norm_of_stages, transform,
};
use crate::integrators::second_order::{Counters, Failure, SecondOrderSystem, model_at};
use crate::model::constraint::Saddle;
use crate::model::{Facts, Tied};
use crate::numerics::linalg::{Lu, Matrix, norm_inf};
use crate::numerics::tape::Tape;

/// Largest ratio of a step to the last one, through whose accelerations a polynomial is extrapolated: that by which steps grow, but for
/// rounding. A longer step follows one that ended early, such as one over a jump of a load, which tells nothing about it.
const FARTHEST_EXTRAPOLATION: f64 = LARGEST_FACTOR * (1.0 + SAME_SIZE);

/// Allowed error of the iteration, relative to the tolerances, with dry friction. Errors of velocities larger than the smoothing
/// velocity of friction cause wrong accelerations; extrapolated to the next step, they prevent convergence.
const WITH_FRICTION: f64 = 1e-5;

/// Number of steps that begin with the tangents of each stage after a step that needed them.
const STEPS_BY_STAGE: u32 = 16;

/// Gaps below this are rounding: metres, or differences of cosines.
const ROUNDING_GAP: f64 = 1e-15;

/// A step that leaves a larger gap has failed to close its loops.
const LARGEST_CLOSED_GAP: f64 = 1e-9;

/// Corrections smaller than this many times the effect of rounding errors of the gaps are rounding. The effect is computed for
/// [`PATTERNS`] patterns of signs, because it may cancel in one.
const ROUNDING_NOISE: f64 = 32.0;
const PATTERNS: usize = 2;

/// A correction below this part of the tolerance ends the iteration without a convergence rate: near rounding there is none.
const NEGLIGIBLE: f64 = 0.03;

/// Maximum number of corrections of displacements; they end when one leaves more than `LEAST_PROGRESS` of the gaps.
const MOST_CORRECTIONS: usize = 10;
const LEAST_PROGRESS: f64 = 0.5;

/// Larger corrections of velocities, in typical sizes of the coordinates per second, are no errors of a step: the commanded length of a
/// tendon jumps, which the rate of the function does not show.
const JUMP_CORRECTION: f64 = 10.0;

/// The state from which a step starts.
#[derive(Clone, Copy, Debug)]
pub(super) struct Start<'a> {
    pub(super) t: f64,
    pub(super) q: &'a [f64],
    pub(super) v: &'a [f64],
    /// Accelerations, and multipliers behind them.
    pub(super) a: &'a [f64],
}

/// The stages of a step, with all memory of their solution.
#[derive(Clone, Debug)]
pub(super) struct Stages {
    n: usize,
    /// Number of unknowns of a stage: accelerations, and multipliers of constraints.
    unknowns: usize,
    newton_tolerance: f64,
    /// Whether errors that may be rounding of gaps count as errors of a step.
    rounding_counts: bool,
    /// dr/dq, dr/dv and dr/da.
    tangents: [Matrix; 3],
    /// The Jacobian of the constraints.
    constraints: Matrix,
    tangents_are_current: bool,
    systems: Systems,
    /// The real matrix with the tangents of each stage, and the number of steps that are still to begin with these. Not used with
    /// constraints: near singular positions the tangents of single stages are not representative.
    stage_matrix: Matrix,
    stage_systems: [Lu; STAGES],
    steps_by_stage: u32,
    /// Work memory: one vector of unknowns.
    scratch: Vec<f64>,
    /// Unknowns of the stages one after the other, like `w`, the same in the basis of the eigenvectors.
    pub(super) a: Vec<f64>,
    w: Vec<f64>,
    residual: Vec<f64>,
    dw: Vec<f64>,
    da: Vec<f64>,
    /// Corrections of displacements and velocities of each stage, 2n numbers each.
    dy: Vec<f64>,
    /// System of the projection onto the constraints at the end of a step, if there are any.
    fitting: Option<Box<Saddle>>,
    /// Whether this system belongs to the start of the step, with the mass matrix there.
    fitting_is_of_start: bool,
    /// Typical sizes of displacements, and their errors due to rounding of gaps.
    sizes: Vec<f64>,
    noise: Vec<f64>,
    /// Displacements and velocities of one stage; those at the end of the step when it is solved.
    pub(super) q: Vec<f64>,
    pub(super) v: Vec<f64>,
    /// Accelerations and multipliers at the end of the step when it is solved.
    pub(super) end: Vec<f64>,
    /// Size of the last step, where it can be continued, and its stages.
    last_size: Option<f64>,
    last: Vec<f64>,
    /// Whether the last step was taken back, so that the next one begins where it did.
    last_is_taken_back: bool,
    /// Error of displacements and velocities.
    error: Vec<f64>,
    work: Vec<f64>,
}

impl Stages {
    /// Memory for a system with constraints; `rtol` is the smallest relative tolerance.
    pub(super) fn of_system<S: SecondOrderSystem + ?Sized>(system: &S, rtol: f64) -> Self {
        let mut stages = Self::new(system.facts().n, system.facts().constraints(), rtol);
        stages.sizes.copy_from_slice(&system.facts().typical_coordinates);
        stages
    }

    /// Memory for `n` coordinates and this number of constraints; `rtol` is the smallest relative tolerance.
    pub(super) fn new(n: usize, constraints: usize, rtol: f64) -> Self {
        let square = || Matrix::zeros(n, n);
        let unknowns = n + constraints;
        let of_stages = if constraints > 0 { 0 } else { n };
        let (vectors, of_unknowns) = (|count| vec![0.0; count * n], |count| vec![0.0; count * unknowns]);
        Self {
            n,
            unknowns,
            newton_tolerance: Iteration::tolerance(rtol),
            rounding_counts: true,
            tangents: [square(), square(), square()],
            constraints: Matrix::zeros(constraints, n),
            tangents_are_current: false,
            systems: Systems::new(n, constraints),
            stage_matrix: Matrix::zeros(of_stages, of_stages),
            stage_systems: std::array::from_fn(|_| Lu::new(of_stages)),
            steps_by_stage: 0,
            scratch: of_unknowns(1),
            a: of_unknowns(STAGES),
            w: of_unknowns(STAGES),
            residual: of_unknowns(STAGES),
            dw: of_unknowns(STAGES),
            da: of_unknowns(STAGES),
            dy: vectors(2 * STAGES),
            fitting: (constraints > 0).then(|| Box::new(Saddle::new(n, constraints))),
            fitting_is_of_start: false,
            sizes: vectors(1),
            noise: vec![0.0; if constraints > 0 { n } else { 0 }],
            q: vectors(1),
            v: vectors(1),
            end: of_unknowns(1),
            last_size: None,
            last: of_unknowns(STAGES),
            last_is_taken_back: false,
            error: vectors(2),
            work: vectors(2),
        }
    }

    /// Sets the accuracy of the iteration, which dry friction increases, and whether rounding of gaps counts as an error. With tendons
    /// that can become taut it does: it detects lengths that jump in short steps.
    pub(super) fn follow(&mut self, facts: &Facts) {
        if facts.has_dry_friction {
            self.newton_tolerance = self.newton_tolerance.min(WITH_FRICTION);
        }
        self.rounding_counts = facts.is_one_sided;
    }

    /// Number of unknowns of a stage.
    pub(super) fn unknowns(&self) -> usize {
        self.unknowns
    }

    /// Evaluates the tangents at the start of a step.
    pub(super) fn evaluate_tangents<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        start: &Start<'_>,
        counters: &mut Counters,
    ) -> Result<(), Interrupted> {
        *self.systems.factorised_for() = None;
        let unit = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for (tangent, weights) in self.tangents.iter_mut().zip(unit) {
            system.tangent(start.t, start.q, start.v, start.a, weights, tangent)?;
        }
        if self.unknowns > self.n {
            model_at(system, start.t)?.gap_jacobian(start.q, &mut self.constraints);
        }
        counters.njev += 1;
        self.tangents_are_current = true;
        Ok(())
    }

    /// The derivative of the residual with respect to the accelerations, bordered by the constraints, with its factors.
    /// Allocates.
    pub(super) fn mass(&self) -> Result<LinearSystem, Failure> {
        let mut system = LinearSystem::of_size(self.n, self.unknowns - self.n);
        match &mut system {
            LinearSystem::Dense { jacobian, .. } => jacobian.copy_from(&self.tangents[2]),
            LinearSystem::Saddle(saddle) => {
                saddle.tangent.copy_from(&self.tangents[2]);
                saddle.constraints.copy_from(&self.constraints);
            }
            LinearSystem::Tree { .. } | LinearSystem::Blocks { .. } => {
                unreachable!("all entries are solved with")
            }
        }
        system.factorise().map(|()| system)
    }

    /// True while steps begin with the tangents of each stage; those at the start may then be old.
    pub(super) fn have_own_tangents(&self) -> bool {
        self.steps_by_stage > 0
    }

    /// Marks the tangents as those of an earlier step.
    pub(super) fn forget_start(&mut self) {
        self.tangents_are_current = false;
    }

    /// Solves for the stages of a step of size `h`. On success `a` contains the accelerations of the stages, and `q`, `v` the state at
    /// the end of the step.
    ///
    /// If the iteration does not converge, the mass matrix has often changed within the step (the inertia of torsion changes by
    /// orders of magnitude as a rod bends). It is then repeated with the tangents of each stage instead of those at
    /// one state, and finally with new ones at this state.
    pub(super) fn solve<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        start: &Start<'_>,
        (h, t_new): (f64, f64),
        scale: &[f64],
        counters: &mut Counters,
    ) -> Result<Result<Converged, Failure>, Interrupted> {
        let mut by_stage = self.steps_by_stage > 0;
        loop {
            let found = match self.factorise(h, start.q, counters) {
                Ok(()) => self.iterate(system, start, (h, t_new), scale, by_stage, counters)?,
                Err(failure) => Err(failure),
            };
            match found {
                Ok(_) if by_stage => self.steps_by_stage = self.steps_by_stage.saturating_sub(1),
                Err(Failure::NotConverged) if !by_stage && self.unknowns == self.n => {
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

    /// Factorises `W_i = M + (h / mu) C + (h / mu)^2 K` with the tangents of each stage as predicted. Multiplied by
    /// `W W_i^-1`, with the W at the start of the step, the equations of a stage get the tangents that the iteration
    /// assumes, both for slow motions, which the mass dominates, and for stiff ones.
    fn factorise_stages<S: SecondOrderSystem + ?Sized>(
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

    /// Factorises the real and the complex system of a step of size `h`, unless that has been done.
    fn factorise(&mut self, h: f64, q: &[f64], counters: &mut Counters) -> Result<(), Failure> {
        let before = counters.nlu;
        self.systems.factorise(h, &self.tangents, &self.constraints, counters)?;
        if self.unknowns > self.n && counters.nlu > before {
            self.find_noise(h, q);
        }
        Ok(())
    }

    /// Errors of displacements due to rounding of the gaps: small, except near singular positions. Velocities have these
    /// errors divided by the step size, and no iteration can be more accurate.
    fn find_noise(&mut self, h: f64, q: &[f64]) {
        let (n, x) = (self.n, h / MU_REAL);
        let Self { noise, sizes, constraints, systems, scratch, .. } = self;
        noise.iter_mut().zip(&*sizes).for_each(|(noise, size)| *noise = f64::EPSILON * size);
        for pattern in 0..PATTERNS {
            scratch[..n].fill(0.0);
            for (i, (row, gap)) in constraints.row_iter().zip(&mut scratch[n..]).enumerate() {
                let moved =
                    row.iter().zip(q).zip(&*sizes).map(|((g, q), size)| (g * size.max(q.abs())).abs());
                let sign = if pattern * i % 2 == 0 { 1.0 } else { -1.0 };
                *gap = sign * f64::EPSILON * moved.sum::<f64>() / (x * x);
            }
            systems.solve_real(scratch);
            noise.iter_mut().zip(&*scratch).for_each(|(noise, a)| *noise = noise.max((x * x * a).abs()));
        }
    }

    /// The simplified Newton iteration.
    fn iterate<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        start: &Start<'_>,
        (h, t_new): (f64, f64),
        scale: &[f64],
        by_stage: bool,
        counters: &mut Counters,
    ) -> Result<Result<Converged, Failure>, Interrupted> {
        let unknowns = self.unknowns;
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
                // Rounding must not move the last stage beyond the end of the interval.
                let t = if stage + 1 == STAGES { t_new } else { start.t + c * h };
                let here = stage * unknowns..(stage + 1) * unknowns;
                let (a, residual) = (&self.a[here.clone()], &mut self.residual[here]);
                counters.nfev += 1;
                system.residual(t, &self.q, &self.v, a, residual)?;
            }
            if !all_finite(&self.residual) {
                return Ok(Err(Failure::NonFinite));
            }
            self.scale_gaps(h);
            if by_stage {
                for (residual, stage) in self.residual.chunks_exact_mut(unknowns).zip(&mut self.stage_systems)
                {
                    stage.solve(residual);
                    self.systems.multiply_real(residual, &mut self.scratch);
                    residual.copy_from_slice(&self.scratch);
                }
            }
            transform(&T_INVERSE, &self.residual, &mut self.dw);
            let (real, pair) = self.dw.split_at_mut(unknowns);
            let (first, second) = pair.split_at_mut(unknowns);
            self.systems.solve_real(real);
            self.systems.solve_complex(first, second);
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
                self.end.copy_from_slice(&self.a[(STAGES - 1) * unknowns..]);
                return Ok(Ok(converged));
            }
        }
    }

    /// Scales the gaps of the stages to the accelerations that would close them. The constraints then have the Jacobian G
    /// for any step size (Bottasso, Dopico and Trainelli 2008).
    fn scale_gaps(&mut self, h: f64) {
        let (n, unknowns) = (self.n, self.unknowns);
        for i in n..unknowns {
            let gaps: [f64; STAGES] = std::array::from_fn(|j| self.residual[j * unknowns + i]);
            for (j, row) in A_SQUARED_INVERSE.iter().enumerate() {
                let sum = row[0] * gaps[0] + row[1] * gaps[1] + row[2] * gaps[2];
                self.residual[j * unknowns + i] = sum / (h * h);
            }
        }
    }

    /// First guess of the unknowns: extrapolation of the polynomial through those of the last step, or those at the start after none
    /// or a far shorter one. Multipliers of dependent constraints are zero.
    fn predict(&mut self, start: &Start<'_>, h: f64) {
        let (unknowns, last) = (self.unknowns, &self.last);
        let last_h = self.last_size.filter(|last_h| h <= FARTHEST_EXTRAPOLATION * last_h);
        let behind = if self.last_is_taken_back { 0.0 } else { 1.0 };
        for (c, stage) in C.into_iter().zip(self.a.chunks_exact_mut(unknowns)) {
            if let Some(last_h) = last_h {
                let x = behind + c * h / last_h;
                let weights: [f64; STAGES] = std::array::from_fn(|i| {
                    (0..STAGES).filter(|&j| j != i).map(|j| (x - C[j]) / (C[i] - C[j])).product()
                });
                for (i, value) in stage.iter_mut().enumerate() {
                    *value = (0..STAGES).map(|j| weights[j] * last[j * unknowns + i]).sum();
                }
            } else {
                stage.copy_from_slice(start.a);
            }
            self.systems.drop_dependent(stage);
        }
    }

    /// Displacements and velocities of a stage from its accelerations.
    fn move_to_stage(&mut self, start: &Start<'_>, h: f64, stage: usize) {
        let (n, unknowns, c) = (self.n, self.unknowns, C[stage]);
        let (row, squared) = (&A[stage], &A_SQUARED[stage]);
        for i in 0..n {
            let a: [f64; STAGES] = std::array::from_fn(|j| self.a[j * unknowns + i]);
            let sum = |row: &[f64; STAGES]| row[0] * a[0] + row[1] * a[1] + row[2] * a[2];
            self.q[i] = start.q[i] + h * (c * start.v[i] + h * sum(squared));
            self.v[i] = start.v[i] + h * sum(row);
        }
    }

    /// Norm of the change of displacements and velocities of the stages by the correction `da`, relative to the tolerances.
    fn size_of_correction(&mut self, h: f64, scale: &[f64]) -> f64 {
        let (n, unknowns) = (self.n, self.unknowns);
        for (stage, dy) in self.dy.chunks_exact_mut(2 * n).enumerate() {
            let (dq, dv) = dy.split_at_mut(n);
            for i in 0..n {
                let da: [f64; STAGES] = std::array::from_fn(|j| self.da[j * unknowns + i]);
                let sum = |row: &[f64; STAGES]| row[0] * da[0] + row[1] * da[1] + row[2] * da[2];
                dq[i] = h * h * sum(&A_SQUARED[stage]);
                dv[i] = h * sum(&A[stage]);
            }
        }
        if unknowns > n {
            return self.without_rounding(h, scale);
        }
        norm_of_stages(&self.dy, scale)
    }

    /// The same without changes that may be rounding of the gaps.
    fn without_rounding(&mut self, h: f64, scale: &[f64]) -> f64 {
        let x = h / MU_REAL;
        for dy in self.dy.chunks_exact_mut(2 * self.n) {
            let (dq, dv) = dy.split_at_mut(self.n);
            drop_rounding([dq, dv], &self.noise, x);
        }
        let size = norm_of_stages(&self.dy, scale);
        if size <= NEGLIGIBLE * self.newton_tolerance { 0.0 } else { size }
    }

    /// The estimated error of the step relative to `scale` (Hairer and Wanner 1996, eqs. IV.8.19 and IV.8.20).
    ///
    /// For systems of first order it is `(mu / h - J) e = f(y0) + sum E_i z_i / h`. With e = (e_q, e_v), multiplied by the
    /// mass matrix and with e_v eliminated, this becomes a system with the real matrix of the step.
    pub(super) fn error<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        start: &Start<'_>,
        h: f64,
        scale: &[f64],
        was_rejected: bool,
        counters: &mut Counters,
    ) -> Result<f64, Interrupted> {
        let (n, unknowns) = (self.n, self.unknowns);
        let (g_q, g_v) = self.work.split_at_mut(n);
        for i in 0..n {
            let a: [f64; STAGES] = std::array::from_fn(|j| self.a[j * unknowns + i]);
            let sum = |row: &[f64; STAGES]| row[0] * a[0] + row[1] * a[1] + row[2] * a[2];
            // The velocities at the start cancel.
            g_q[i] = h * sum(&E_A_SQUARED);
            g_v[i] = start.a[i] + sum(&E_A);
        }
        self.residual[..n].fill(0.0);
        if unknowns > n {
            self.find_fitting(system, start)?;
        }
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
            let (residual, other) = self.residual.split_at_mut(unknowns);
            system.residual(start.t, &self.q, &self.v, start.a, residual)?;
            if unknowns > n {
                // Projected accelerations leave a residual at the start.
                counters.nfev += 1;
                system.residual(start.t, start.q, start.v, start.a, &mut other[..unknowns])?;
                residual.iter_mut().zip(other).for_each(|(residual, at_start)| *residual -= *at_start);
            }
            self.filter(h);
            size = scaled_norm(&self.error, scale);
            self.move_to_stage(start, h, STAGES - 1);
        }
        Ok(size)
    }

    /// Computes `error` from g of displacements and velocities in `work`, and the residual of the accelerations at the start.
    fn filter(&mut self, h: f64) {
        if self.unknowns > self.n {
            return self.filter_with_constraints(h);
        }
        let n = self.n;
        let x = h / MU_REAL;
        let (g_q, g_v) = self.work.split_at(n);
        let (e_q, e_v) = self.error.split_at_mut(n);
        let [_, c, m] = &self.tangents;
        e_q.fill(0.0);
        let [of_m, of_c] = [m, c].map(|matrix| matrix.as_slice().chunks_exact(n.max(1)));
        for (((m, c), g_v), g_q) in of_m.zip(of_c).zip(g_v).zip(g_q) {
            let (of_mass, of_damping) = (x * x * g_v + x * g_q, x * x * g_q);
            for ((e_q, m), c) in e_q.iter_mut().zip(m).zip(c) {
                *e_q += m * of_mass + c * of_damping;
            }
        }
        for (e_q, residual) in e_q.iter_mut().zip(&self.residual) {
            *e_q -= x * x * residual;
        }
        self.systems.solve_real(e_q);
        for i in 0..n {
            e_v[i] = e_q[i] / x - g_q[i];
        }
    }

    /// The same for errors that satisfy the constraints, `G e_q = 0` and `G e_v = 0`. Components that violate them are corrected at the
    /// end of the step; those of velocities are of lower order, and contain rounding of the gaps over the square of h. They are
    /// removed first, by a projection. `e_v` follows from the same equations with e_q eliminated.
    fn filter_with_constraints(&mut self, h: f64) {
        let n = self.n;
        let x = h / MU_REAL;
        let [k, c, m] = &self.tangents;
        let (g_q, g_v) = self.work.split_at_mut(n);
        let residual = &mut self.residual[..n];
        if let Some(fitting) = &mut self.fitting
            && self.fitting_is_of_start
        {
            project(fitting, g_q, &mut self.scratch, None);
            project(fitting, g_v, &mut self.scratch, Some(&*residual));
            residual.fill(0.0);
        }
        let (e_q, e_v) = self.error.split_at_mut(n);
        // Weights of M g_v and the residual, and of K, C and M times g_q.
        for (error, of_v, of_q) in [(e_q, x * x, [0.0, x * x, x]), (e_v, x, [-x * x, 0.0, 0.0])] {
            self.scratch.fill(0.0);
            for j in 0..n {
                let (of_mass, [stiff, damped]) =
                    (of_v * g_v[j] + of_q[2] * g_q[j], [of_q[0] * g_q[j], of_q[1] * g_q[j]]);
                for i in 0..n {
                    self.scratch[i] += m[(i, j)] * of_mass + c[(i, j)] * damped + k[(i, j)] * stiff;
                }
            }
            for (sum, residual) in self.scratch[..n].iter_mut().zip(&*residual) {
                *sum -= of_v * residual;
            }
            self.systems.solve_real(&mut self.scratch);
            error.copy_from_slice(&self.scratch[..n]);
        }
        if !self.rounding_counts {
            let (e_q, e_v) = self.error.split_at_mut(n);
            drop_rounding([e_q, e_v], &self.noise, x);
        }
    }

    /// Evaluates and factorises the system of mass matrix and constraints at the start of a step, unless the last step has left it. If
    /// this fails, errors are not projected.
    fn find_fitting<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        start: &Start<'_>,
    ) -> Result<(), Interrupted> {
        if let Some(fitting) = &mut self.fitting
            && !self.fitting_is_of_start
        {
            let weights = [0.0, 0.0, 1.0];
            system.tangent(start.t, start.q, start.v, start.a, weights, &mut fitting.tangent)?;
            model_at(system, start.t)?.gap_jacobian(start.q, &mut fitting.constraints);
            self.fitting_is_of_start = fitting.factorise().is_ok();
        }
        Ok(())
    }

    /// Projects the end of a step of size `h` onto the constraints: displacements to rounding, and velocities and accelerations, which
    /// satisfy them only to lower order at the stages. False if loops stay open.
    ///
    /// Displacements are projected with the matrix of the step, by less than its tolerance, so that stiff springs stay relaxed.
    /// Velocities are projected in the metric of the mass matrix at the end: only then are their free components of full order
    /// (Hairer, Lubich and Roche 1989, theorem 6.4).
    pub(super) fn fit<S: SecondOrderSystem + ?Sized>(
        &mut self,
        system: &mut S,
        (h, t): (f64, f64),
        counters: &mut Counters,
    ) -> Result<bool, Interrupted> {
        let n = self.n;
        self.fitting_is_of_start = false;
        let Self { fitting: Some(fitting), tangents, q, v, end, scratch, sizes, .. } = self else {
            return Ok(true);
        };
        let x = h / MU_REAL;
        sum(tangents, [x * x, x, 1.0], &mut fitting.tangent);
        model_at(system, t)?.gap_jacobian(q, &mut fitting.constraints);
        counters.nlu += 2;
        if fitting.factorise().is_err() {
            return Ok(false);
        }
        let mut last = f64::INFINITY;
        for _ in 0..MOST_CORRECTIONS {
            scratch[..n].fill(0.0);
            model_at(system, t)?.gaps(q, &mut scratch[n..]);
            let gap = norm_inf(&scratch[n..]);
            let has_ended = gap.is_nan() || gap <= ROUNDING_GAP || gap > LEAST_PROGRESS * last;
            last = gap;
            if has_ended {
                break;
            }
            fitting.solve(scratch);
            q.iter_mut().zip(&*scratch).for_each(|(q, change)| *q -= change);
        }
        if last.is_nan() || last > LARGEST_CLOSED_GAP {
            return Ok(false);
        }
        system.tangent(t, q, v, end, [0.0, 0.0, 1.0], &mut fitting.tangent)?;
        model_at(system, t)?.gap_jacobian(q, &mut fitting.constraints);
        if fitting.factorise().is_err() {
            return Ok(false);
        }
        // If a commanded length has a corner at the end of the step, its rate before the corner counts.
        let before = if system.facts().is_one_sided { t.next_down() } else { t };
        scratch[..n].fill(0.0);
        model_at(system, before)?.gap_rates(q, v, &mut scratch[n..]);
        fitting.solve(scratch);
        let is_swift = |(change, size): (&f64, &f64)| change.abs() > JUMP_CORRECTION * size;
        if system.facts().is_one_sided && scratch[..n].iter().zip(&*sizes).any(is_swift) {
            return Ok(false);
        }
        v.iter_mut().zip(&*scratch).for_each(|(v, change)| *v -= change);
        scratch[..n].fill(0.0);
        model_at(system, before)?.gap_accelerations(q, v, &end[..n], &mut scratch[n..]);
        fitting.solve(scratch);
        end.iter_mut().zip(&*scratch).for_each(|(a, change)| *a -= change);
        Ok(true)
    }

    /// Discards the stages of the last step, which belong to other coordinates.
    pub(super) fn forget_last(&mut self) {
        self.last_size = None;
        self.last_is_taken_back = false;
        self.fitting_is_of_start = false;
    }

    /// The next step begins where the last one did, so that its stages are interpolated.
    pub(super) fn undo_step(&mut self) {
        self.last_is_taken_back = true;
        self.fitting_is_of_start = false;
    }

    /// Keeps the stages of an accepted step, for the next prediction.
    pub(super) fn accept(&mut self, h: f64) {
        self.fitting_is_of_start = true;
        self.last_is_taken_back = false;
        self.last_size = Some(h);
        self.last.copy_from_slice(&self.a);
    }

    /// Serialises tangents and the stages of the last step.
    pub(super) fn serialise(&mut self, tape: &mut Tape<'_>) {
        for tangent in &mut self.tangents {
            tape.numbers(tangent.as_mut_slice());
        }
        tape.numbers(self.constraints.as_mut_slice());
        tape.numbers(&mut self.noise);
        tape.flag(&mut self.tangents_are_current);
        tape.optional(self.systems.factorised_for(), 0.0, Tape::number);
        tape.small_count(&mut self.steps_by_stage);
        tape.optional(&mut self.last_size, 0.0, Tape::number);
        tape.numbers(&mut self.last);
        tape.flag(&mut self.last_is_taken_back);
        if tape.reads()
            && let Some(h) = self.systems.factorised_for().take()
        {
            // If it fails, the next step reports the same failure.
            let _ = self.systems.factorise(h, &self.tangents, &self.constraints, &mut Counters::default());
        }
    }
}

/// Sets changes of displacements and velocities to zero where they may be rounding of the gaps.
fn drop_rounding([dq, dv]: [&mut [f64]; 2], noise: &[f64], x: f64) {
    for ((dq, dv), noise) in dq.iter_mut().zip(dv).zip(noise) {
        let noise = ROUNDING_NOISE * noise;
        // NaN stays.
        if dq.abs() <= noise && dv.abs() <= noise / x {
            (*dq, *dv) = (0.0, 0.0);
        }
    }
}

/// Projects a vector onto the constraints in the metric of the mass matrix, and subtracts the accelerations due to a residual.
fn project(fitting: &mut Saddle, g: &mut [f64], scratch: &mut [f64], residual: Option<&[f64]>) {
    scratch.fill(0.0);
    for (column, g) in fitting.tangent.column_iter().zip(&*g) {
        scratch.iter_mut().zip(column.iter()).for_each(|(sum, entry)| *sum += entry * g);
    }
    for (sum, residual) in scratch.iter_mut().zip(residual.into_iter().flatten()) {
        *sum -= residual;
    }
    fitting.solve(scratch);
    g.copy_from_slice(&scratch[..g.len()]);
}
