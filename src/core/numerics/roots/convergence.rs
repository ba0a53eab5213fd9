//! Convergence tests that distinguish a root from a point where the search stalls.

use super::difference::rounding_error;
use super::newton::{CONFIRMED_REDUCTION, FAR_AWAY, Newton, Progress};
use super::options::Options;
use super::{Derivative, Status};

/// A linear model that predicts a relative reduction of |R| below this predicts none: the square root of the
/// rounding unit, as in the relative gradient test of MINPACK's `lmder`.
const STATIONARY: f64 = 1.490_116_119_384_765_6e-8;

/// If no step reduces |R| any more, a gradient this small, relative to R and to the column of the Jacobian or
/// to R over the unknown, indicates a stationary point: the cube root of the rounding unit (`gradtol` of
/// Dennis and Schnabel 1983, section 7.2).
const SMALL_GRADIENT: f64 = 6.055_454_452_393_343e-6;

/// Assumed error of R in rounding units: two digits of cancellation in its evaluation.
pub(super) const EVALUATION_ERROR: f64 = 100.0;

/// Steps of this relative size are at the level of rounding.
const ROUNDING_STEP: f64 = 4.0 * f64::EPSILON;

/// Square root of the largest double, beyond which products of two unknowns overflow: an iterate of this size
/// has diverged. A smaller limit would be wrong: for a chain of squares Newton's method may pass 1e30 and
/// return.
const DIVERGENCE_LIMIT: f64 = 1.340_780_792_994_259_6e154;

/// The search ends after this many consecutive steps of maximum length (KINSOL's `KIN_MXNEWT_5X_EXCEEDED`).
const LONGEST_STEPS_IN_A_ROW: usize = 5;

impl Newton {
    /// Reason to stop after a step, if any.
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
        } else if self.size(x) > DIVERGENCE_LIMIT && progress.residual_norm >= progress.start_norm {
            Some(Status::Diverged)
        } else if progress.longest_steps >= LONGEST_STEPS_IN_A_ROW {
            Some(Status::LongestSteps)
        } else {
            None
        }
    }

    /// Reason why there is no step: the iterate may be a root to rounding, or a stationary point.
    pub(super) fn reason(&self, refusal: Status, x: &[f64], progress: &Progress) -> Status {
        match refusal {
            Status::NonFiniteResidual | Status::SingularJacobian => refusal,
            _ if self.residual_is_rounding(x, progress) => Status::ConvergedStep,
            _ if self.gradient_is_small(x, progress.residual_norm) => Status::StationaryPoint,
            _ => refusal,
        }
    }

    /// Reports a breakdown far from the start, with a residual that is no smaller, as divergence.
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

    /// True if the linear model cannot reduce |R|. Requires a singular Jacobian, or more equations than
    /// unknowns.
    pub(super) fn is_stationary(&mut self, residual_norm: f64) -> bool {
        !self.linear.is_regular() && self.predicted_reduction(residual_norm) <= STATIONARY
    }

    /// True if the gradient of `|R|` is zero within the error of a Jacobian by differences.
    pub(super) fn gradient_is_noise(&self, x: &[f64], residual_norm: f64, derivative: Derivative) -> bool {
        derivative != Derivative::Analytic
            && (0..x.len()).all(|j| {
                let noise = EVALUATION_ERROR * rounding_error(x[j], self.x_scale[j], derivative);
                self.gradient(j, residual_norm).abs() <= noise * residual_norm
            })
    }

    /// Step rule of the options, for the step that led to x.
    fn step_is_small(&self, x: &[f64], options: &Options) -> bool {
        let tolerance = options.step_tolerance;
        let sum: f64 = (0..x.len())
            .map(|j| (self.step[j] / (tolerance.absolute + tolerance.relative * x[j].abs())).powi(2))
            .sum();
        sum <= x.len() as f64 // false for 0/0: a step of zero against a tolerance of zero
    }

    /// True if the search made progress and every residual is at the level of the rounding of x: `|R_i| <= c
    /// eps sum_j |J_ij x_j|`.
    fn residual_is_rounding(&self, x: &[f64], progress: &Progress) -> bool {
        progress.residual_norm <= CONFIRMED_REDUCTION * progress.start_norm
            && (0..self.residual.len()).all(|i| {
                let row = self.jacobian.row(i);
                let size: f64 = x.iter().enumerate().map(|(j, x)| (row[j] * x).abs()).sum();
                self.residual[i].abs() <= EVALUATION_ERROR * f64::EPSILON * size
            })
    }

    /// True if, for every column of the Jacobian, R is almost orthogonal to it, or the column is almost zero
    /// for the size of its unknown.
    fn gradient_is_small(&self, x: &[f64], residual_norm: f64) -> bool {
        (0..x.len()).all(|j| {
            let column = self.jacobian.column(j);
            let size = column.iter().zip(&self.f_scale).map(|(v, f)| (v / f) * (v / f)).sum::<f64>().sqrt();
            let natural_size = residual_norm / x[j].abs().max(self.x_scale[j]);
            self.gradient(j, residual_norm).abs() <= SMALL_GRADIENT * size.max(natural_size)
        })
    }
}
