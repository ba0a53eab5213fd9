//! Newton's method: the loop, its stopping rules and its memory.

use super::difference::{Differences, rounding_error};
use super::multiplicity::Multiplicity;
use super::options::{Method, Options, Reuse};
use super::outcome::{Outcome, Status};
use super::step::NewtonStep;
use super::trust_region::TrustRegion;
use super::{Derivative, System};
use crate::error::{Checker, Interrupted, InvalidInput};
use crate::linalg::{Matrix, norm, norm_inf};

/// A linear model that promises to reduce |R| by less than this fraction promises nothing: the square root of the
/// rounding unit (the relative gradient test of MINPACK's `lmder`, `gtol`).
const STATIONARY: f64 = 1.490_116_119_384_765_6e-8;

/// Where no step helps any more, a cosine that small between R and each column of the Jacobian means a stationary point:
/// the cube root of the rounding unit (`gradtol` of Dennis and Schnabel 1983, section 7.2).
const SMALL_GRADIENT: f64 = 6.055_454_452_393_343e-6;

/// R is taken to carry that many rounding units of error: two digits of cancellation in its evaluation.
pub(super) const EVALUATION_ERROR: f64 = 100.0;

/// A step by which the step rule may stop must have reduced the residual at least to this fraction: near a simple root
/// a Newton step does far better, near a pole of order p it gives `(1 + 1/p)^-p`, between 1/2 and 1/e. Where rounding ends
/// the search, it is the whole of it that must have done so.
const CONFIRMED_REDUCTION: f64 = 0.25;

/// Steps of that many rounding units of x are as small as rounding lets them be.
const ROUNDING_STEP: f64 = 4.0 * f64::EPSILON;

/// Where the iterates have lost every digit of the start (a factor of one over the rounding unit) they ran away.
const RUNAWAY: f64 = 1.0 / f64::EPSILON;

/// Default longest step of the line search, as a multiple of the scaled start, or of the scales where the start is smaller
/// (Dennis and Schnabel 1983, section A7; KINSOL's default).
const LONGEST_STEP: f64 = 1000.0;

/// That many steps of the greatest length one after the other, and the search gives up (KINSOL's `KIN_MXNEWT_5X_EXCEEDED`).
const LONGEST_STEPS_IN_A_ROW: usize = 5;

/// One iterate of a search.
#[derive(Clone, Debug, PartialEq)]
pub struct Iterate {
    /// Where, shape (n,).
    pub x: Vec<f64>,
    /// `||R / f_scale||_2` there.
    pub residual_norm: f64,
    /// `||dx / x_scale||_2` of the step that led there; NaN at the start.
    pub step_norm: f64,
    /// That step as a multiple of the full Newton step; NaN at the start.
    pub step_length: f64,
    /// Residual norm over the one before; NaN at the start.
    pub rate: f64,
}

/// Whether there is a factorised Jacobian, and from where.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Age {
    /// None, or one that has served its time.
    None,
    /// From the current iterate.
    Fresh,
    /// From an earlier iterate, or an earlier solve.
    Kept,
}

/// What a search remembers of its last step.
struct Search {
    step_norm: f64,
    accelerated: bool,
}

#[derive(Clone, Copy, Debug, Default)]
struct Counters {
    iterations: usize,
    residuals: usize,
    difference_residuals: usize,
    jacobians: usize,
    factorisations: usize,
}

/// What came of looking for a step.
#[derive(Clone, Copy, Debug)]
pub(super) enum Trial {
    /// The trial iterate is the next one; `norm` is its scaled residual norm, `length` is relative to the Newton step.
    Taken { norm: f64, length: f64 },
    /// There is none.
    Refused(Status),
}

/// Newton's method with its memory, for repeated use at one size. A solve allocates only where the Jacobian is singular or
/// not square (a singular value decomposition), and for the history.
///
/// The iteration is `x <- x - J^-1 R`, with the pseudo-inverse where J is singular to rounding or not square, as the
/// minimum-norm step in the scaled variables. Tests of convergence use `||R / f_scale||_2` and the scaled step; what
/// stops the search otherwise is listed in [`Status`].
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
    age: Age,
    differences: Differences,
    multiplicity: Multiplicity,
    counters: Counters,
    history: Vec<Iterate>,
}

impl Newton {
    /// Memory for `equations` equations in `unknowns` unknowns, all scales one.
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
            age: Age::None,
            differences: Differences::new(unknowns, equations),
            multiplicity: Multiplicity::new(unknowns),
            counters: Counters::default(),
            history: Vec::new(),
        }
    }

    /// The typical size of each unknown (it sets difference increments and the step norm) and of each equation (what
    /// counts as a small residual). All must be finite and positive.
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

    /// Searches from `x`, which becomes the root, or on failure the iterate with the smallest residual.
    ///
    /// # Panics
    /// When the system or x is not of the size of this memory.
    pub fn solve(
        &mut self,
        system: &mut dyn System,
        x: &mut [f64],
        options: &Options,
    ) -> Result<Outcome, Interrupted> {
        assert_eq!(
            (system.unknowns(), system.equations(), x.len()),
            (self.x_scale.len(), self.f_scale.len(), self.x_scale.len()),
            "unknowns, equations and length of x"
        );
        self.start(x, options);
        let mut search = Search { step_norm: f64::NAN, accelerated: false };
        let status = self.iterate(system, x, options, &mut search)?;
        if !status.is_success() && self.best_norm.is_finite() {
            x.copy_from_slice(&self.best_x);
            self.residual.copy_from_slice(&self.best_residual);
        }
        Ok(Outcome {
            status,
            iterations: self.counters.iterations,
            residual_evaluations: self.counters.residuals,
            difference_evaluations: self.counters.difference_residuals,
            jacobian_evaluations: self.counters.jacobians,
            factorisations: self.counters.factorisations,
            residual_norm: scaled_norm(&self.residual, &self.f_scale, &mut self.scaled),
            step_norm: search.step_norm,
            multiplicity: self.multiplicity.settled(search.accelerated).filter(|_| status.is_success()),
        })
    }

    /// R at the x that the last solve returned, shape (m,).
    pub fn residual(&self) -> &[f64] {
        &self.residual
    }

    /// The Jacobian that was evaluated last, shape (m, n); not necessarily at the x that was returned.
    pub fn jacobian(&self) -> &Matrix {
        &self.jacobian
    }

    /// The iterates of the last solve from its start on, if [`Options::history`] asked for them.
    pub fn history(&self) -> &[Iterate] {
        &self.history
    }

    /// Makes the next solve with [`Reuse::AcrossSolves`] begin with a fresh Jacobian: for when the system has changed more
    /// than from one time step to the next.
    pub fn forget_jacobian(&mut self) {
        self.age = Age::None;
    }

    fn start(&mut self, x: &[f64], options: &Options) {
        self.counters = Counters::default();
        self.history.clear();
        self.multiplicity.reset();
        self.region.reset();
        self.best_norm = f64::INFINITY;
        if options.reuse != Reuse::AcrossSolves {
            self.age = Age::None;
        } else if self.age == Age::Fresh {
            self.age = Age::Kept;
        }
        self.longest_step = match options.method {
            Method::LineSearch => LONGEST_STEP * scaled_norm(x, &self.x_scale, &mut self.scaled).max(1.0),
            Method::Newton | Method::TrustRegion => f64::INFINITY,
        };
        if let Some(longest) = options.longest_step {
            self.longest_step = longest;
        }
    }

    fn iterate(
        &mut self,
        system: &mut dyn System,
        x: &mut [f64],
        options: &Options,
        search: &mut Search,
    ) -> Result<Status, Interrupted> {
        self.counters.residuals += 1;
        system.residual(x, &mut self.residual)?;
        let mut residual_norm = scaled_norm(&self.residual, &self.f_scale, &mut self.scaled);
        let (start_norm, runaway) = (residual_norm, RUNAWAY * self.size(x).max(1.0));
        let mut longest_steps = 0;
        self.record(x, residual_norm, f64::NAN, f64::NAN, f64::NAN, options);
        if !residual_norm.is_finite() {
            return Ok(Status::NonFiniteResidual);
        }
        if residual_norm <= options.residual_tolerance {
            return Ok(Status::AlreadyRoot);
        }
        self.note_best(x, residual_norm);
        while self.counters.iterations < options.max_iterations {
            if self.age == Age::None
                && let Some(failure) = self.renew_jacobian(system, x, residual_norm, options)?
            {
                return Ok(failure);
            }
            if !self.solve_linear() {
                return Ok(Status::SingularJacobian);
            }
            if !self.linear.is_regular() && self.promised_reduction(residual_norm) <= STATIONARY {
                return Ok(Status::StationaryPoint);
            }
            let trial = if self.age == Age::Kept {
                let norm = self.try_step(system, x, 1.0)?;
                if norm >= residual_norm || norm.is_nan() {
                    self.age = Age::None; // the step is not taken: the kept Jacobian is to blame
                    continue;
                }
                self.multiplicity.reset();
                Trial::Taken { norm, length: 1.0 }
            } else {
                self.multiplicity.observe(&self.step, &self.x_scale);
                self.find_step(system, x, residual_norm, options)?
            };
            let (trial_norm, length) = match trial {
                Trial::Taken { norm, length } => (norm, length),
                Trial::Refused(status) => return Ok(self.reason(status, x, residual_norm, start_norm)),
            };

            let rate = trial_norm / residual_norm;
            let moved = self.trial_x != x;
            x.copy_from_slice(&self.trial_x);
            std::mem::swap(&mut self.residual, &mut self.trial_residual);
            residual_norm = trial_norm;
            search.step_norm = self.scaled_step_norm();
            search.accelerated = length > 1.0;
            self.multiplicity.took(&self.step);
            self.counters.iterations += 1;
            self.record(x, residual_norm, search.step_norm, length, rate, options);
            if residual_norm < self.best_norm {
                self.note_best(x, residual_norm);
            }

            if residual_norm <= options.residual_tolerance {
                return Ok(Status::ConvergedResidual);
            }
            if self.linear.is_regular() && length >= 1.0 {
                let confirmed = rate <= CONFIRMED_REDUCTION;
                let smallest = self.size(&self.step) <= ROUNDING_STEP * self.size(x);
                if confirmed && self.step_is_small(x, options)
                    || smallest && self.residual_is_rounding(x, residual_norm, start_norm)
                {
                    return Ok(Status::ConvergedStep);
                }
            }
            if !moved {
                return Ok(Status::Stalled);
            }
            if self.size(x) > runaway && residual_norm >= start_norm {
                return Ok(Status::Diverged);
            }
            longest_steps = if search.step_norm >= 0.99 * self.longest_step { longest_steps + 1 } else { 0 };
            if longest_steps == LONGEST_STEPS_IN_A_ROW {
                return Ok(Status::LongestSteps);
            }
            let keep =
                options.reuse != Reuse::Never && self.linear.is_regular() && rate <= options.chord_rate;
            self.age = if keep { Age::Kept } else { Age::None };
        }
        Ok(Status::IterationLimit)
    }

    /// From a fresh Newton step to the next iterate.
    fn find_step(
        &mut self,
        system: &mut dyn System,
        x: &[f64],
        residual_norm: f64,
        options: &Options,
    ) -> Result<Trial, Interrupted> {
        if options.accelerate
            && let Some(length) = self.multiplicity.overrelaxation()
        {
            let norm = self.try_step(system, x, length)?;
            if norm <= CONFIRMED_REDUCTION * residual_norm {
                return Ok(Trial::Taken { norm, length });
            }
            // The Newton step, as it was.
            self.solve_linear();
        }
        match options.method {
            Method::Newton => {
                let length = (self.longest_step / self.scaled_step_norm()).min(1.0);
                let norm = self.try_step(system, x, length)?;
                if norm.is_nan() {
                    return Ok(Trial::Refused(Status::NonFiniteResidual));
                }
                Ok(Trial::Taken { norm, length })
            }
            Method::LineSearch => self.search_line(system, x, residual_norm),
            Method::TrustRegion => self.search_region(system, x, residual_norm),
        }
    }

    /// Why there is no step: at a root to rounding there need not be one, at a stationary point there cannot be.
    fn reason(&self, status: Status, x: &[f64], residual_norm: f64, start_norm: f64) -> Status {
        if status == Status::NonFiniteResidual {
            status
        } else if self.residual_is_rounding(x, residual_norm, start_norm) {
            Status::ConvergedStep
        } else if self.gradient_is_small(residual_norm) {
            Status::StationaryPoint
        } else {
            status
        }
    }

    /// `step <- -J^-1 R`; false when there is no finite step.
    fn solve_linear(&mut self) -> bool {
        self.linear.solve(&self.jacobian, &self.residual, &self.x_scale, &self.f_scale, &mut self.step)
    }

    /// Multiplies the step by `length`, evaluates R at its end and returns its scaled norm, NaN when it is not finite.
    pub(super) fn try_step(
        &mut self,
        system: &mut dyn System,
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

    /// Evaluates and factorises the Jacobian at x; `Some` status when the search must end with it.
    fn renew_jacobian(
        &mut self,
        system: &mut dyn System,
        x: &[f64],
        residual_norm: f64,
        options: &Options,
    ) -> Result<Option<Status>, Interrupted> {
        self.evaluate_jacobian(system, x, options.derivative)?;
        let mut derivative = options.derivative;
        // A gradient that could be the error of forward differences is looked at again with central ones.
        if derivative == Derivative::Forward && self.gradient_is_noise(x, residual_norm, derivative) {
            derivative = Derivative::Central;
            self.evaluate_jacobian(system, x, derivative)?;
        }
        if !self.jacobian.iter().all(|v| v.is_finite()) {
            return Ok(Some(Status::NonFiniteJacobian));
        }
        if derivative == Derivative::Central && self.gradient_is_noise(x, residual_norm, derivative) {
            return Ok(Some(Status::StationaryPoint));
        }
        self.linear.factorise(&self.jacobian);
        self.counters.factorisations += 1;
        self.age = Age::Fresh;
        Ok(None)
    }

    fn evaluate_jacobian(
        &mut self,
        system: &mut dyn System,
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

    /// True when the gradient `J^T R` of `|R|^2 / 2` is zero as far as a Jacobian by differences can tell.
    fn gradient_is_noise(&self, x: &[f64], residual_norm: f64, derivative: Derivative) -> bool {
        (0..x.len()).all(|j| {
            let noise = EVALUATION_ERROR * rounding_error(x[j], self.x_scale[j], derivative);
            self.gradient(j).abs() <= noise * residual_norm * residual_norm
        })
    }

    /// Entry j of the gradient `J^T R` of `|R|^2 / 2`, R scaled.
    pub(super) fn gradient(&self, j: usize) -> f64 {
        let column = self.jacobian.column(j);
        (0..self.residual.len())
            .map(|i| column[i] / self.f_scale[i] * (self.residual[i] / self.f_scale[i]))
            .sum()
    }

    /// The fraction of |R| that the step removes in the linear model: `|J dx| / |R|`.
    pub(super) fn promised_reduction(&mut self, residual_norm: f64) -> f64 {
        for i in 0..self.residual.len() {
            let row = self.jacobian.row(i);
            self.trial_residual[i] = self.step.iter().enumerate().map(|(j, dx)| row[j] * dx).sum();
        }
        scaled_norm(&self.trial_residual, &self.f_scale, &mut self.scaled) / residual_norm
    }

    /// The step rule of the options, for the step that led to x.
    fn step_is_small(&self, x: &[f64], options: &Options) -> bool {
        let tolerance = options.step_tolerance;
        let sum: f64 = (0..x.len())
            .map(|j| {
                let bound = tolerance.absolute + tolerance.relative * x[j].abs();
                // 0/0 is a step of zero against a tolerance of zero: not a reason to stop.
                (self.step[j] / bound).powi(2)
            })
            .sum();
        sum <= x.len() as f64
    }

    /// True when the search got far, and every residual is as small as rounding x alone makes it:
    /// `|R_i| <= c eps sum_j |J_ij x_j|`.
    fn residual_is_rounding(&self, x: &[f64], residual_norm: f64, start_norm: f64) -> bool {
        let rounding = (0..self.residual.len()).all(|i| {
            let row = self.jacobian.row(i);
            let size: f64 = x.iter().enumerate().map(|(j, x)| (row[j] * x).abs()).sum();
            self.residual[i].abs() <= EVALUATION_ERROR * f64::EPSILON * size
        });
        rounding && residual_norm <= CONFIRMED_REDUCTION * start_norm
    }

    /// True when R is almost orthogonal to every column of the Jacobian.
    fn gradient_is_small(&self, residual_norm: f64) -> bool {
        (0..self.step.len()).all(|j| {
            let column = self.jacobian.column(j);
            let size = column.iter().zip(&self.f_scale).map(|(v, f)| (v / f) * (v / f)).sum::<f64>().sqrt();
            self.gradient(j).abs() <= SMALL_GRADIENT * size * residual_norm
        })
    }

    /// Steps taken so far.
    pub(super) fn iterations(&self) -> usize {
        self.counters.iterations
    }

    /// `||dx / x_scale||_2`.
    pub(super) fn scaled_step_norm(&mut self) -> f64 {
        scaled_norm(&self.step, &self.x_scale, &mut self.scaled)
    }

    /// Largest scaled entry of a point or a step.
    fn size(&self, x: &[f64]) -> f64 {
        x.iter().zip(&self.x_scale).fold(0.0, |m: f64, (x, scale)| m.max((x / scale).abs()))
    }

    fn note_best(&mut self, x: &[f64], residual_norm: f64) {
        self.best_norm = residual_norm;
        self.best_x.copy_from_slice(x);
        self.best_residual.copy_from_slice(&self.residual);
    }

    fn record(
        &mut self,
        x: &[f64],
        residual_norm: f64,
        step_norm: f64,
        step_length: f64,
        rate: f64,
        options: &Options,
    ) {
        if options.history {
            self.history.push(Iterate { x: x.to_vec(), residual_norm, step_norm, step_length, rate });
        }
    }
}

/// `||v / scale||_2`; NaN or infinite when v is.
fn scaled_norm(v: &[f64], scale: &[f64], memory: &mut [f64]) -> f64 {
    let memory = &mut memory[..v.len()];
    for (i, scaled) in memory.iter_mut().enumerate() {
        *scaled = v[i] / scale[i];
    }
    if norm_inf(memory).is_finite() { norm(memory) } else { f64::NAN }
}
