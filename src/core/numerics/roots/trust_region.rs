//! Double dogleg step in a trust region (Powell 1970; Dennis and Mei 1979), with MINPACK's rules for the
//! radius.

use crate::numerics::linalg::{Matrix, norm};

/// Initial radius as a multiple of the scaled start, or of the scales if the start is smaller (MINPACK's
/// `factor`).
const FIRST_RADIUS: f64 = 100.0;

/// Below this ratio the radius shrinks (`hybrj`).
const POOR_RATIO: f64 = 0.1;

/// From this ratio on, or after two steps that were not poor, the radius may grow (`hybrj`).
const GOOD_RATIO: f64 = 0.5;

/// If the ratio is this close to one, the radius follows from the step (`hybrj`).
const EXCELLENT: f64 = 0.1;

/// Factor of the radius after a poor step (`hybrj`).
const SHRINK: f64 = 0.5;

/// Largest radius relative to a good step (`hybrj`).
const GROW: f64 = 2.0;

/// The second leg of the double dogleg ends at least at this fraction of the Newton step; the fraction
/// increases with the quality of the steepest descent (Dennis and Schnabel 1983, section 6.4.2).
const NEWTON_BIAS: f64 = 0.2;

/// The region `||dx / x_scale||_2 <= radius` and working memory.
#[derive(Clone, Debug)]
pub(super) struct TrustRegion {
    pub(super) radius: f64,
    successes: usize,
    pub(super) newton: Vec<f64>,
    pub(super) gradient: Vec<f64>,
    leg: Vec<f64>,
    pub(super) image: Vec<f64>,
}

impl TrustRegion {
    pub(super) fn new(unknowns: usize, equations: usize) -> Self {
        Self {
            radius: f64::NAN,
            successes: 0,
            newton: vec![0.0; unknowns],
            gradient: vec![0.0; unknowns],
            leg: vec![0.0; unknowns],
            image: vec![0.0; equations],
        }
    }

    /// Resets the region for a new search; `size` is the scaled norm of the start.
    pub(super) fn reset(&mut self, size: f64) {
        self.radius = FIRST_RADIUS * size.max(1.0);
        self.successes = 0;
    }

    /// `step <-` dogleg path within the region: along the steepest descent to the minimum of the linear
    /// model, then to a point on the Newton step, then to the end of the Newton step. False without a descent
    /// direction.
    pub(super) fn dogleg(
        &mut self,
        jacobian: &Matrix,
        residual_norm: f64,
        x_scale: &[f64],
        f_scale: &[f64],
        step: &mut [f64],
    ) -> bool {
        let inner = |a: &[f64], b: &[f64]| -> f64 {
            (0..x_scale.len()).map(|j| (a[j] / x_scale[j]) * (b[j] / x_scale[j])).sum()
        };
        let newton_length = inner(&self.newton, &self.newton).sqrt();
        if newton_length <= self.radius {
            step.copy_from_slice(&self.newton);
            return true;
        }
        // Unit vector of steepest descent, slope of |R| along it, and norm of its image.
        for j in 0..step.len() {
            step[j] = -self.gradient[j] * x_scale[j] * x_scale[j];
        }
        let slope = inner(step, step).sqrt();
        for v in step.iter_mut() {
            *v /= slope;
        }
        for (i, image) in self.image.iter_mut().enumerate() {
            let row = jacobian.row(i);
            *image = step.iter().enumerate().map(|(j, dx)| row[j] * dx).sum::<f64>() / f_scale[i];
        }
        let stretch = norm(&self.image);
        if !(slope > 0.0 && stretch > 0.0) {
            return false;
        }
        let cauchy_length = (slope / stretch) * (residual_norm / stretch);
        // Decrease at the minimum along the steepest descent, relative to the decrease of the Newton step, in
        // the linear model.
        let newton_gain: f64 = -(0..step.len()).map(|j| self.gradient[j] * self.newton[j]).sum::<f64>();
        let progress = cauchy_length * slope / newton_gain;
        let knee = NEWTON_BIAS + (1.0 - NEWTON_BIAS) * progress.min(1.0);
        if knee * newton_length <= self.radius {
            for j in 0..step.len() {
                step[j] = self.newton[j] * (self.radius / newton_length);
            }
        } else if cauchy_length >= self.radius {
            for v in step.iter_mut() {
                *v *= self.radius;
            }
        } else {
            // |c + t (knee s - c)| = radius: the root in (0, 1), in a form without cancellation.
            for j in 0..step.len() {
                step[j] *= cauchy_length;
                self.leg[j] = knee * self.newton[j] - step[j];
            }
            let (square, along) = (inner(&self.leg, &self.leg), inner(&self.leg, step));
            let gap = (self.radius - cauchy_length) * (self.radius + cauchy_length);
            let t = gap / (along + (along * along + square * gap).sqrt());
            for j in 0..step.len() {
                step[j] += t * self.leg[j];
            }
        }
        true
    }

    /// Adapts the radius after a step of this length: `ratio` is the actual over the predicted reduction of
    /// `|R|^2`.
    pub(super) fn adapt(&mut self, ratio: f64, length: f64) {
        if ratio < POOR_RATIO {
            self.successes = 0;
            self.radius *= SHRINK;
        } else {
            self.successes += 1;
            if ratio >= GOOD_RATIO || self.successes > 1 {
                self.radius = self.radius.max(GROW * length);
            }
            if (ratio - 1.0).abs() <= EXCELLENT {
                self.radius = GROW * length;
            }
        }
    }
}
