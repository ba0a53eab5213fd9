//! What tells a root from a place where a search merely stands still.

use super::difference::rounding_error;
use super::newton::{CONFIRMED_REDUCTION, FAR_AWAY, Newton, Progress};
use super::options::Options;
use super::{Derivative, Status};

/// A linear model that promises to reduce |R| by less than this fraction promises nothing: the square root of
/// the rounding unit, as in the relative gradient test of MINPACK's `lmder`.
const STATIONARY: f64 = 1.490_116_119_384_765_6e-8;

/// Where no step helps any more, a gradient that small, relative to R and to the column of the Jacobian or to
/// R over the unknown, means a stationary point: the cube root of the rounding unit (`gradtol` of Dennis and
/// Schnabel 1983, section 7.2).
const SMALL_GRADIENT: f64 = 6.055_454_452_393_343e-6;

/// R is taken to carry that many rounding units of error: two digits of cancellation in its evaluation.
pub(super) const EVALUATION_ERROR: f64 = 100.0;

/// Steps of that many rounding units of x are as small as rounding lets them be.
const ROUNDING_STEP: f64 = 4.0 * f64::EPSILON;

/// Beyond the square root of the largest double no two unknowns can be multiplied: an iterate that came there
/// ran away. Less will not do: on its way through a chain of squares Newton's method may pass 1e30 and come
/// back.
const RUNAWAY: f64 = 1.340_780_792_994_259_6e154;

/// That many steps of the greatest length one after the other, and the search gives up (KINSOL's
/// `KIN_MXNEWT_5X_EXCEEDED`).
const LONGEST_STEPS_IN_A_ROW: usize = 5;

impl Newton {
    /// Why to stop after a step, if there is a reason.
    pub(super) fn verdict(&self, x: &[f64], progress: &Progress, options: &Options) -> Option<Status> {
        if progress.residual_norm <= options.residual_tolerance {
            return Some(Status::ConvergedResidual);
        }
        if self.linear.is_regular() && progress.length >= 1.0 {
            let confirmed = progress.rate <= CONFIRMED_REDUCTION && self.step_is_small(x, options);
            let smallest = self.size(&self.step) <= ROUNDING_STEP * self.size(x);
            if confirmed || smallest && self.residual_is_rounding(x, progress) {
                return Some(Status::ConvergedStep);
            }
        }
        if !progress.moved {
            Some(Status::Stalled)
        } else if self.size(x) > RUNAWAY && progress.residual_norm >= progress.start_norm {
            Some(Status::Diverged)
        } else if progress.longest_steps >= LONGEST_STEPS_IN_A_ROW {
            Some(Status::LongestSteps)
        } else {
            None
        }
    }

    /// Why there is no step: at a root to rounding there need not be one, at a stationary point there cannot
    /// be.
    pub(super) fn reason(&self, refusal: Status, x: &[f64], progress: &Progress) -> Status {
        match refusal {
            Status::NonFiniteResidual | Status::SingularJacobian => refusal,
            _ if self.residual_is_rounding(x, progress) => Status::ConvergedStep,
            _ if self.gradient_is_small(x, progress.residual_norm) => Status::StationaryPoint,
            _ => refusal,
        }
    }

    /// A breakdown far away from the start, where the residual is no smaller, is the end of a divergence.
    pub(super) fn or_diverged(&self, breakdown: Status, x: &[f64], progress: &Progress) -> Status {
        let ran_away = self.size(x) > FAR_AWAY * progress.start_size.max(1.0)
            && progress.residual_norm >= progress.start_norm;
        match breakdown {
            Status::StationaryPoint
            | Status::SingularJacobian
            | Status::Stalled
            | Status::NonFiniteResidual
            | Status::NonFiniteJacobian
                if ran_away =>
            {
                Status::Diverged
            }
            _ => breakdown,
        }
    }

    /// True when the linear model sees no way to reduce |R|. Only a singular Jacobian, or one with more
    /// equations than unknowns, can be that blind.
    pub(super) fn is_stationary(&mut self, residual_norm: f64) -> bool {
        !self.linear.is_regular() && self.promised_reduction(residual_norm) <= STATIONARY
    }

    /// True when the gradient of `|R|` is zero as far as a Jacobian by differences can tell.
    pub(super) fn gradient_is_noise(&self, x: &[f64], residual_norm: f64, derivative: Derivative) -> bool {
        derivative != Derivative::Analytic
            && (0..x.len()).all(|j| {
                let noise = EVALUATION_ERROR * rounding_error(x[j], self.x_scale[j], derivative);
                self.gradient(j, residual_norm).abs() <= noise * residual_norm
            })
    }

    /// The step rule of the options, for the step that led to x.
    fn step_is_small(&self, x: &[f64], options: &Options) -> bool {
        let tolerance = options.step_tolerance;
        let sum: f64 = (0..x.len())
            .map(|j| (self.step[j] / (tolerance.absolute + tolerance.relative * x[j].abs())).powi(2))
            .sum();
        sum <= x.len() as f64 // false for 0/0: a step of zero against a tolerance of zero
    }

    /// True when the search got far, and every residual is as small as rounding x alone makes it:
    /// `|R_i| <= c eps sum_j |J_ij x_j|`.
    fn residual_is_rounding(&self, x: &[f64], progress: &Progress) -> bool {
        progress.residual_norm <= CONFIRMED_REDUCTION * progress.start_norm
            && (0..self.residual.len()).all(|i| {
                let row = self.jacobian.row(i);
                let size: f64 = x.iter().enumerate().map(|(j, x)| (row[j] * x).abs()).sum();
                self.residual[i].abs() <= EVALUATION_ERROR * f64::EPSILON * size
            })
    }

    /// True when R is almost orthogonal to every column of the Jacobian, or that column is almost zero for the
    /// size of its unknown.
    fn gradient_is_small(&self, x: &[f64], residual_norm: f64) -> bool {
        (0..x.len()).all(|j| {
            let column = self.jacobian.column(j);
            let size = column.iter().zip(&self.f_scale).map(|(v, f)| (v / f) * (v / f)).sum::<f64>().sqrt();
            let natural_size = residual_norm / x[j].abs().max(self.x_scale[j]);
            self.gradient(j, residual_norm).abs() <= SMALL_GRADIENT * size.max(natural_size)
        })
    }
}
