//! Steps within a trust region.

use super::NonlinearSystem;
use super::newton::{Newton, Trial};
use super::outcome::Status;
use crate::error::Interrupted;
use crate::numerics::linalg::norm;

/// A step is accepted if it achieves this fraction of the decrease of `|R|^2` predicted by the linear model
/// (`hybrj`).
const ACCEPTED_RATIO: f64 = 1e-4;

/// The search ends when the radius relative to x falls below this value.
const SMALLEST: f64 = f64::EPSILON;

impl Newton {
    /// Tries dogleg steps in a shrinking region until one reduces `|R|^2` sufficiently compared with the
    /// linear model.
    pub(super) fn search_region(
        &mut self,
        system: &mut dyn NonlinearSystem,
        x: &[f64],
        residual_norm: f64,
    ) -> Result<Trial, Interrupted> {
        self.region.newton.copy_from_slice(&self.step);
        for j in 0..x.len() {
            self.region.gradient[j] = self.gradient(j, residual_norm);
        }
        let newton_norm = self.scaled_step_norm();
        loop {
            if !self.region.dogleg(
                &self.jacobian,
                residual_norm,
                &self.x_scale,
                &self.f_scale,
                &mut self.step,
            ) {
                return Ok(Trial::Refused(Status::StationaryPoint));
            }
            let length = self.scaled_step_norm();
            if self.iterations() == 0 {
                self.region.radius = self.region.radius.min(length);
            }
            let predicted = self.model_reduction(residual_norm);
            let norm = self.try_step(system, x, 1.0)?;
            let reduction = 1.0 - (norm / residual_norm).powi(2);
            let ratio = if predicted > 0.0 && reduction.is_finite() { reduction / predicted } else { 0.0 };
            self.region.adapt(ratio, length);
            if ratio >= ACCEPTED_RATIO {
                return Ok(Trial::Taken { norm, length: (length / newton_norm).min(1.0) });
            }
            if self.region.radius <= SMALLEST * self.size(x) {
                return Ok(Trial::Refused(Status::TrustRegionCollapsed));
            }
        }
    }

    /// Relative decrease of `|R|^2` that the linear model predicts for the step: `1 - |R + J dx|^2 / |R|^2`.
    fn model_reduction(&mut self, residual_norm: f64) -> f64 {
        let image = &mut self.region.image;
        for (i, image) in image.iter_mut().enumerate() {
            let row = self.jacobian.row(i);
            let change: f64 = self.step.iter().enumerate().map(|(j, dx)| row[j] * dx).sum();
            *image = (self.residual[i] + change) / self.f_scale[i];
        }
        1.0 - (norm(image) / residual_norm).powi(2)
    }
}
