//! Newton's method: iteration, stopping rules and memory.

use super::cycle::Cycle;
use super::difference::Differences;
use super::multiplicity::Multiplicity;
use super::options::{Method, Options, Reuse};
use super::outcome::{Outcome, Status};
use super::step::NewtonStep;
use super::trust_region::TrustRegion;
use super::{Derivative, NonlinearSystem};
use crate::error::{Checker, Interrupted, InvalidInput, Unfinished};
use crate::numerics::linalg::{Matrix, norm, norm_inf};
use crate::numerics::memory;

/// The step rule may stop only after a step that reduced the residual at least to this fraction. Near a
/// simple root a Newton step does far better; near a pole of order p it gives `(1 + 1/p)^-p`, between 1/2 and
/// 1/e. If rounding ends the search, the same reduction is required of the whole search.
pub(super) const CONFIRMED_REDUCTION: f64 = 0.25;

/// A search that breaks down at this multiple of the start's size has diverged: the distance at which Dennis
/// and Schnabel (1983, section A7) and KINSOL stop a single step.
pub(super) const FAR_AWAY: f64 = 1000.0;

/// Steps of at least this fraction of the maximum length count as steps of maximum length (Dennis and
/// Schnabel 1983, A6.3.1).
const NEARLY_LONGEST: f64 = 0.99;

/// Full Newton steps that contract by less than this do not converge: towards a root of multiplicity m they contract by 1 - 1/m, in
/// `exp(-x)` not at all, and in `1/x^p` they grow by 1 + 1/p.
const UNCONTRACTED: f64 = 0.99;

/// An iterate of a search.
#[derive(Clone, Debug, PartialEq)]
pub struct Iterate {
    /// Unknowns, shape (n,).
    pub x: Vec<f64>,
    /// `||R / f_scale||_2` at x.
    pub residual_norm: f64,
    /// `||dx / x_scale||_2` of the step to x; NaN at the start.
    pub step_norm: f64,
    /// Length of this step relative to the full Newton step; NaN at the start.
    pub step_length: f64,
    /// Residual norm over the previous one; NaN at the start.
    pub rate: f64,
}

/// Availability and origin of a factorised Jacobian.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum JacobianState {
    /// None, or one that must be replaced.
    None,
    /// Evaluated at the current iterate.
    Fresh,
    /// Evaluated at an earlier iterate, or in an earlier solve.
    Kept,
}

/// Progress of a search.
#[derive(Clone, Copy, Debug)]
pub(super) struct Progress {
    /// Scaled residual norm and largest scaled unknown at the start.
    pub(super) start_norm: f64,
    pub(super) start_size: f64,
    /// Scaled residual norm at x.
    pub(super) residual_norm: f64,
    /// Properties of the last step: its scaled norm, its length relative to the Newton step, the ratio of the
    /// residual norms, and whether it changed x.
    pub(super) step_norm: f64,
    pub(super) length: f64,
    pub(super) rate: f64,
    /// The scaled norm of the last step over that of the one before.
    pub(super) contraction: f64,
    pub(super) moved: bool,
    /// Number of consecutive last steps with the maximum length.
    pub(super) longest_steps: usize,
}

impl Progress {
    /// Before the first evaluation.
    fn none() -> Self {
        Self {
            start_norm: f64::NAN,
            start_size: f64::NAN,
            residual_norm: f64::NAN,
            step_norm: f64::NAN,
            length: f64::NAN,
            rate: f64::NAN,
            contraction: f64::NAN,
            moved: false,
            longest_steps: 0,
        }
    }
}

#[derive(Clone, Copy, Debug, Default)]
struct Counters {
    iterations: usize,
    residuals: usize,
    difference_residuals: usize,
    jacobians: usize,
    factorisations: usize,
}

/// Result of a search for a step.
#[derive(Clone, Copy, Debug)]
pub(super) enum Trial {
    /// The trial iterate is accepted; `norm` is its scaled residual norm, `length` is relative to the Newton
    /// step.
    Taken { norm: f64, length: f64 },
    /// There is no step.
    Refused(Status),
}

/// Newton's method with its memory, for repeated use at a fixed size. A solve allocates only for a Jacobian
/// that is singular or not square (singular value decomposition), and for the history.
///
/// The iteration is `x <- x - J^-1 R`. If J is singular to rounding or not square, the pseudo-inverse gives
/// the minimum-norm step in the scaled variables. Convergence tests use `||R / f_scale||_2` and the scaled
/// step; [`Status`] lists all other reasons to stop.
#[derive(Clone, Debug)]
pub struct Newton {
    pub(super) x_scale: Vec<f64>,
    pub(super) f_scale: Vec<f64>,
    pub(super) residual: Vec<f64>,
    pub(super) step: Vec<f64>,
    pub(super) jacobian: Matrix,
    pub(super) linear: NewtonStep,
    pub(super) region: TrustRegion,
    pub(super) longest_step: f64,
    trial_x: Vec<f64>,
    trial_residual: Vec<f64>,
    best_x: Vec<f64>,
    best_residual: Vec<f64>,
    best_norm: f64,
    scaled: Vec<f64>,
    age: JacobianState,
    differences: Differences,
    multiplicity: Multiplicity,
    cycle: Cycle,
    counters: Counters,
    history: Vec<Iterate>,
}

impl Newton {
    /// Rejects problems whose matrices do not fit in memory, for which [`Self::new`] would end the process.
    pub fn check_memory(unknowns: usize, equations: usize) -> Result<(), InvalidInput> {
        /// The Jacobian, its equilibrated form and the factors of the latter.
        const MATRICES: usize = 3;
        let numbers = MATRICES.saturating_mul(unknowns).saturating_mul(equations);
        let found = format_args!("{unknowns} values for {equations} equations");
        memory::check(numbers, "x0", found, "this method needs dense matrices; solve for fewer unknowns")
    }

    /// Memory for `equations` equations in `unknowns` unknowns, with all scales equal to one.
    pub fn new(unknowns: usize, equations: usize) -> Self {
        Self {
            x_scale: vec![1.0; unknowns],
            f_scale: vec![1.0; equations],
            residual: vec![0.0; equations],
            step: vec![0.0; unknowns],
            jacobian: Matrix::zeros(equations, unknowns),
            linear: NewtonStep::new(unknowns, equations),
            region: TrustRegion::new(unknowns, equations),
            longest_step: f64::INFINITY,
            trial_x: vec![0.0; unknowns],
            trial_residual: vec![0.0; equations],
            best_x: vec![0.0; unknowns],
            best_residual: vec![0.0; equations],
            best_norm: f64::INFINITY,
            scaled: vec![0.0; unknowns.max(equations)],
            age: JacobianState::None,
            differences: Differences::new(unknowns, equations),
            multiplicity: Multiplicity::new(unknowns),
            cycle: Cycle::new(unknowns),
            counters: Counters::default(),
            history: Vec::new(),
        }
    }

    /// Sets the typical size of each unknown (for difference increments and the step norm) and of each
    /// equation (for the residual norm). All must be finite and positive.
    pub fn with_scales(mut self, x_scale: &[f64], f_scale: &[f64]) -> Result<Self, InvalidInput> {
        let mut checker = Checker::new();
        checker.length(x_scale, self.x_scale.len(), "x_scale");
        checker.length(f_scale, self.f_scale.len(), "f_scale");
        for (scale, name, unit) in [(x_scale, "x_scale", "units of x"), (f_scale, "f_scale", "units of R")] {
            for (i, &value) in scale.iter().enumerate() {
                checker.positive(value, &format!("{name}[{i}]"), unit);
            }
        }
        checker.finish()?;
        self.x_scale.copy_from_slice(x_scale);
        self.f_scale.copy_from_slice(f_scale);
        Ok(self)
    }

    /// Searches from `x`, which becomes the root. On failure `x` is the stationary point, if the search found
    /// one, otherwise the iterate with the smallest residual; so it is after an interruption.
    ///
    /// # Panics
    /// If the sizes of the system or of x do not match this memory.
    pub fn solve(
        &mut self,
        system: &mut dyn NonlinearSystem,
        x: &mut [f64],
        options: &Options,
    ) -> Result<Outcome, Unfinished<Outcome>> {
        assert_eq!(
            (system.unknowns(), system.equations(), x.len()),
            (self.x_scale.len(), self.f_scale.len(), self.x_scale.len()),
            "unknowns, equations and length of x"
        );
        let mut progress = Progress::none();
        let searched = self.search(system, x, options, &mut progress);
        let status = match searched {
            Ok(ended) => self.or_diverged(ended, x, &progress),
            Err(Interrupted) => Status::Interrupted,
        };
        if status == Status::Interrupted && progress.residual_norm.is_nan() {
            // The residual is that of an earlier search.
            self.residual.fill(f64::NAN);
        }
        if !status.is_success() && status != Status::StationaryPoint && self.best_norm.is_finite() {
            x.copy_from_slice(&self.best_x);
            self.residual.copy_from_slice(&self.best_residual);
            progress.residual_norm = self.best_norm;
        }
        let outcome = Outcome {
            status,
            iterations: self.counters.iterations,
            residual_evaluations: self.counters.residuals,
            difference_evaluations: self.counters.difference_residuals,
            jacobian_evaluations: self.counters.jacobians,
            factorisations: self.counters.factorisations,
            residual_norm: progress.residual_norm,
            step_norm: progress.step_norm,
            runs_off: status == Status::ConvergedResidual
                && progress.rate > CONFIRMED_REDUCTION
                && progress.length >= 1.0
                && progress.contraction > UNCONTRACTED,
            cycle: self.cycle.period(),
            multiplicity: self.multiplicity.settled(progress.length > 1.0).filter(|_| status.is_success()),
        };
        if status == Status::Interrupted { Err(Unfinished::new(outcome)) } else { Ok(outcome) }
    }

    fn search(
        &mut self,
        system: &mut dyn NonlinearSystem,
        x: &mut [f64],
        options: &Options,
        progress: &mut Progress,
    ) -> Result<Status, Interrupted> {
        *progress = self.start(system, x, options)?;
        self.iterate(system, x, options, progress)
    }

    /// R at the x returned by the last solve, shape (m,).
    pub fn residual(&self) -> &[f64] {
        &self.residual
    }

    /// Jacobian evaluated last, shape (m, n); not necessarily at the returned x.
    pub fn jacobian(&self) -> &Matrix {
        &self.jacobian
    }

    /// Iterates of the last solve including its start, if [`Options::history`] is set.
    pub fn history(&self) -> &[Iterate] {
        &self.history
    }

    /// Makes the next solve with [`Reuse::AcrossSolves`] start with a fresh Jacobian, after the system has
    /// changed more than from one time step to the next.
    pub fn forget_jacobian(&mut self) {
        self.age = JacobianState::None;
    }

    /// Clears the last search, except a reusable Jacobian, and evaluates R at x.
    fn start(
        &mut self,
        system: &mut dyn NonlinearSystem,
        x: &[f64],
        options: &Options,
    ) -> Result<Progress, Interrupted> {
        let x_norm = scaled_norm(x, &self.x_scale, &mut self.scaled);
        self.counters = Counters { residuals: 1, ..Counters::default() };
        self.history.clear();
        self.multiplicity.reset();
        self.cycle.reset(x);
        self.region.reset(x_norm);
        self.best_norm = f64::INFINITY;
        let keep = options.reuse == Reuse::AcrossSolves && self.linear.is_regular();
        self.age =
            if keep && self.age != JacobianState::None { JacobianState::Kept } else { JacobianState::None };
        self.longest_step = options.longest_step.unwrap_or(match options.method {
            Method::LineSearch => FAR_AWAY * x_norm.max(1.0),
            Method::Newton | Method::TrustRegion => f64::INFINITY,
        });
        system.residual(x, &mut self.residual)?;
        let residual_norm = scaled_norm(&self.residual, &self.f_scale, &mut self.scaled);
        let progress = Progress {
            start_norm: residual_norm,
            start_size: self.size(x),
            residual_norm,
            ..Progress::none()
        };
        self.record(x, &progress, options);
        Ok(progress)
    }

    fn iterate(
        &mut self,
        system: &mut dyn NonlinearSystem,
        x: &mut [f64],
        options: &Options,
        progress: &mut Progress,
    ) -> Result<Status, Interrupted> {
        if !progress.residual_norm.is_finite() {
            return Ok(Status::NonFiniteResidual);
        }
        if progress.residual_norm <= options.residual_tolerance {
            return Ok(Status::AlreadyRoot);
        }
        self.record_best(x, progress.residual_norm);
        while self.counters.iterations < options.max_iter {
            if self.age == JacobianState::None
                && let Some(failure) = self.renew_jacobian(system, x, progress.residual_norm, options)?
            {
                return Ok(failure);
            }
            let trial = self.find_step(system, x, progress.residual_norm, options)?;
            let (norm, length) = match trial {
                Trial::Taken { norm, length } => (norm, length),
                Trial::Refused(_) if self.age == JacobianState::Kept => {
                    self.age = JacobianState::None; // the kept Jacobian is to blame
                    continue;
                }
                Trial::Refused(refusal) => return Ok(self.reason(refusal, x, progress)),
            };
            self.take_step(x, norm, length, progress);
            self.record(x, progress, options);
            if let Some(status) = self.verdict(x, progress, options) {
                return Ok(status);
            }
            let keep = options.reuse != Reuse::Never && progress.rate <= options.chord_rate;
            self.age =
                if keep && self.linear.is_regular() { JacobianState::Kept } else { JacobianState::None };
        }
        Ok(Status::IterationLimit)
    }

    /// Computes the next iterate with the factorised Jacobian.
    fn find_step(
        &mut self,
        system: &mut dyn NonlinearSystem,
        x: &[f64],
        residual_norm: f64,
        options: &Options,
    ) -> Result<Trial, Interrupted> {
        if !self.solve_linear() {
            return Ok(Trial::Refused(Status::SingularJacobian));
        }
        if self.age == JacobianState::Kept {
            self.multiplicity.reset();
            let trial = self.full_step(system, x)?;
            let reduced = matches!(trial, Trial::Taken { norm, .. } if norm < residual_norm);
            return Ok(if reduced { trial } else { Trial::Refused(Status::Stalled) });
        }
        if self.is_stationary(residual_norm) {
            return Ok(Trial::Refused(Status::StationaryPoint));
        }
        self.multiplicity.observe(&self.step, &self.x_scale);
        if options.accelerate
            && let Some(length) = self.multiplicity.overrelaxation()
        {
            let norm = self.try_step(system, x, length)?;
            if norm <= CONFIRMED_REDUCTION * residual_norm {
                return Ok(Trial::Taken { norm, length });
            }
            self.solve_linear(); // the Newton step, as it was
        }
        match options.method {
            Method::Newton => self.full_step(system, x),
            Method::LineSearch => self.search_line(system, x, residual_norm),
            Method::TrustRegion => self.search_region(system, x, residual_norm),
        }
    }

    /// Newton step, limited to the maximum length.
    fn full_step(&mut self, system: &mut dyn NonlinearSystem, x: &[f64]) -> Result<Trial, Interrupted> {
        let length = (self.longest_step / self.scaled_step_norm()).min(1.0);
        let norm = self.try_step(system, x, length)?;
        Ok(if norm.is_nan() {
            Trial::Refused(Status::NonFiniteResidual)
        } else {
            Trial::Taken { norm, length }
        })
    }

    /// Makes the trial iterate the current one.
    fn take_step(&mut self, x: &mut [f64], norm: f64, length: f64, progress: &mut Progress) {
        progress.moved = self.trial_x != x;
        x.copy_from_slice(&self.trial_x);
        std::mem::swap(&mut self.residual, &mut self.trial_residual);
        progress.rate = norm / progress.residual_norm;
        progress.residual_norm = norm;
        progress.length = length;
        let before = std::mem::replace(&mut progress.step_norm, self.scaled_step_norm());
        progress.contraction = progress.step_norm / before;
        let longest = progress.step_norm >= NEARLY_LONGEST * self.longest_step;
        progress.longest_steps = if longest { progress.longest_steps + 1 } else { 0 };
        self.multiplicity.took(&self.step);
        self.counters.iterations += 1;
        self.cycle.observe(x, &self.x_scale, progress.step_norm);
        if norm < self.best_norm {
            self.record_best(x, norm);
        }
    }

    /// `step <- -J^-1 R`; false if there is no finite step.
    fn solve_linear(&mut self) -> bool {
        self.linear.solve(&self.jacobian, &self.residual, &self.x_scale, &self.f_scale, &mut self.step)
    }

    /// Multiplies the step by `length`, evaluates R at its end and returns its scaled norm, NaN if it is not
    /// finite.
    pub(super) fn try_step(
        &mut self,
        system: &mut dyn NonlinearSystem,
        x: &[f64],
        length: f64,
    ) -> Result<f64, Interrupted> {
        for j in 0..x.len() {
            self.step[j] *= length;
            self.trial_x[j] = x[j] + self.step[j];
        }
        self.counters.residuals += 1;
        system.residual(&self.trial_x, &mut self.trial_residual)?;
        Ok(scaled_norm(&self.trial_residual, &self.f_scale, &mut self.scaled))
    }

    /// Evaluates and factorises the Jacobian at x; `Some` is a status that ends the search.
    fn renew_jacobian(
        &mut self,
        system: &mut dyn NonlinearSystem,
        x: &[f64],
        residual_norm: f64,
        options: &Options,
    ) -> Result<Option<Status>, Interrupted> {
        self.evaluate_jacobian(system, x, options.derivative)?;
        let mut derivative = options.derivative;
        // If the gradient could be an error of forward differences, recompute with central differences.
        if derivative == Derivative::Forward && self.gradient_is_noise(x, residual_norm, derivative) {
            derivative = Derivative::Central;
            self.evaluate_jacobian(system, x, derivative)?;
        }
        if !self.jacobian.iter().all(|v| v.is_finite()) {
            return Ok(Some(Status::NonFiniteJacobian));
        }
        if self.gradient_is_noise(x, residual_norm, derivative) {
            return Ok(Some(Status::StationaryPoint));
        }
        self.linear.factorise(&self.jacobian);
        self.counters.factorisations += 1;
        self.age = JacobianState::Fresh;
        Ok(None)
    }

    fn evaluate_jacobian(
        &mut self,
        system: &mut dyn NonlinearSystem,
        x: &[f64],
        derivative: Derivative,
    ) -> Result<(), Interrupted> {
        let evaluations = match derivative {
            Derivative::Analytic => {
                system.jacobian(x, &mut self.jacobian)?;
                0
            }
            Derivative::Forward => {
                self.differences.forward(system, x, &self.residual, &self.x_scale, &mut self.jacobian)?;
                x.len()
            }
            Derivative::Central => {
                self.differences.central(system, x, &self.x_scale, &mut self.jacobian)?;
                2 * x.len()
            }
        };
        self.counters.jacobians += 1;
        self.counters.residuals += evaluations;
        self.counters.difference_residuals += evaluations;
        Ok(())
    }

    /// Entry j of the gradient `J^T R / |R|` of `|R|`, R scaled.
    pub(super) fn gradient(&self, j: usize, residual_norm: f64) -> f64 {
        let column = self.jacobian.column(j);
        (0..self.residual.len())
            .map(|i| column[i] / self.f_scale[i] * (self.residual[i] / self.f_scale[i] / residual_norm))
            .sum()
    }

    /// Fraction of |R| that the step removes in the linear model: `|J dx| / |R|`.
    pub(super) fn predicted_reduction(&mut self, residual_norm: f64) -> f64 {
        for i in 0..self.residual.len() {
            let row = self.jacobian.row(i);
            self.trial_residual[i] = self.step.iter().enumerate().map(|(j, dx)| row[j] * dx).sum();
        }
        scaled_norm(&self.trial_residual, &self.f_scale, &mut self.scaled) / residual_norm
    }

    /// Number of steps so far.
    pub(super) fn iterations(&self) -> usize {
        self.counters.iterations
    }

    /// `||dx / x_scale||_2`.
    pub(super) fn scaled_step_norm(&mut self) -> f64 {
        scaled_norm(&self.step, &self.x_scale, &mut self.scaled)
    }

    /// Largest scaled entry of a point or a step.
    pub(super) fn size(&self, x: &[f64]) -> f64 {
        x.iter().zip(&self.x_scale).fold(0.0, |m: f64, (x, scale)| m.max((x / scale).abs()))
    }

    fn record_best(&mut self, x: &[f64], residual_norm: f64) {
        self.best_norm = residual_norm;
        self.best_x.copy_from_slice(x);
        self.best_residual.copy_from_slice(&self.residual);
    }

    fn record(&mut self, x: &[f64], progress: &Progress, options: &Options) {
        if options.history {
            self.history.push(Iterate {
                x: x.to_vec(),
                residual_norm: progress.residual_norm,
                step_norm: progress.step_norm,
                step_length: progress.length,
                rate: progress.rate,
            });
        }
    }
}

/// `||v / scale||_2`; NaN or infinite if v is.
fn scaled_norm(v: &[f64], scale: &[f64], memory: &mut [f64]) -> f64 {
    let memory = &mut memory[..v.len()];
    for (i, scaled) in memory.iter_mut().enumerate() {
        *scaled = v[i] / scale[i];
    }
    if norm_inf(memory).is_finite() { norm(memory) } else { f64::NAN }
}
