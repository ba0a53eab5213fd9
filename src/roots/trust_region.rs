//! Powell's dogleg in a trust region (Powell 1970), with the rules of MINPACK's `hybrj` for its size.

use super::newton::{Newton, Trial};
use super::{Status, System};
use crate::error::Interrupted;
use crate::linalg::{Matrix, norm};

/// The first radius is that multiple of the scaled start (MINPACK's `factor`).
const FIRST_RADIUS: f64 = 100.0;

/// A step is taken when it gives that fraction of the decrease of `|R|^2` that the linear model promises (`hybrj`).
const TAKEN: f64 = 1e-4;

/// Below this fraction the radius shrinks (`hybrj`).
const POOR: f64 = 0.1;

/// From this fraction on, or after two steps that were not poor, the radius may grow (`hybrj`).
const GOOD: f64 = 0.5;

/// That close to one, the radius is set from the step (`hybrj`).
const EXCELLENT: f64 = 0.1;

/// How much a poor step shrinks the radius (`hybrj`).
const SHRINK: f64 = 0.5;

/// How far the radius grows beyond a good step (`hybrj`).
const GROW: f64 = 2.0;

/// A region smaller than that, relative to x, holds no other point worth trying.
const SMALLEST: f64 = f64::EPSILON;

/// The region `||D dx||_2 <= radius` and the memory of the dogleg.
#[derive(Clone, Debug)]
pub(super) struct TrustRegion {
    radius: f64,
    /// The scaling D, shape (n,): the largest norm so far of each column of the Jacobian (MINPACK's `diag`).
    scaling: Vec<f64>,
    successes: usize,
    newton: Vec<f64>,
    gradient: Vec<f64>,
    cauchy: Vec<f64>,
    image: Vec<f64>,
}

impl TrustRegion {
    pub(super) fn new(unknowns: usize, equations: usize) -> Self {
        Self {
            radius: f64::NAN,
            scaling: vec![0.0; unknowns],
            successes: 0,
            newton: vec![0.0; unknowns],
            gradient: vec![0.0; unknowns],
            cauchy: vec![0.0; unknowns],
            image: vec![0.0; equations],
        }
    }

    /// Forgets an earlier search.
    pub(super) fn reset(&mut self) {
        self.radius = f64::NAN;
        self.scaling.fill(0.0);
        self.successes = 0;
    }

    /// Takes in the columns of a new Jacobian. D never shrinks, so that the region cannot follow a column into zero.
    fn rescale(&mut self, jacobian: &Matrix, f_scale: &[f64], x: &[f64]) {
        for (j, scaling) in self.scaling.iter_mut().enumerate() {
            let column = jacobian.column(j);
            let size = column.iter().zip(f_scale).map(|(v, f)| (v / f) * (v / f)).sum::<f64>().sqrt();
            *scaling = scaling.max(size);
        }
        if self.radius.is_nan() {
            let start = self.norm(x);
            self.radius = if start > 0.0 { FIRST_RADIUS * start } else { FIRST_RADIUS };
        }
    }

    /// `||D v||_2`.
    fn norm(&self, v: &[f64]) -> f64 {
        v.iter().zip(&self.scaling).map(|(v, scale)| (v * scale) * (v * scale)).sum::<f64>().sqrt()
    }

    /// `step <-` along the steepest descent to the minimum of the linear model, from there towards the Newton step, up to
    /// the edge of the region. False without a descent.
    fn dogleg(&mut self, jacobian: &Matrix, f_scale: &[f64], step: &mut [f64]) -> bool {
        step.copy_from_slice(&self.newton);
        if self.norm(&self.newton) <= self.radius {
            return true;
        }
        for j in 0..step.len() {
            let weight = self.scaling[j] * self.scaling[j];
            self.cauchy[j] = if weight > 0.0 { -self.gradient[j] / weight } else { 0.0 };
        }
        let slope = self.norm(&self.cauchy);
        for (i, image) in self.image.iter_mut().enumerate() {
            let row = jacobian.row(i);
            *image = self.cauchy.iter().enumerate().map(|(j, dx)| row[j] * dx).sum::<f64>() / f_scale[i];
        }
        let curvature = norm(&self.image);
        if !(slope > 0.0 && curvature > 0.0) {
            return false;
        }
        let cauchy_length = (slope / curvature) * (slope / curvature) * slope;
        let to_edge = cauchy_length.min(self.radius) / slope;
        for v in &mut self.cauchy {
            *v *= to_edge;
        }
        step.copy_from_slice(&self.cauchy);
        if cauchy_length < self.radius {
            // |D (c + t (s - c))| = radius; the root in (0, 1), written without cancellation.
            let (mut square, mut along) = (0.0, 0.0);
            for j in 0..step.len() {
                let weight = self.scaling[j] * self.scaling[j];
                let leg = self.newton[j] - self.cauchy[j];
                square += weight * leg * leg;
                along += weight * leg * self.cauchy[j];
            }
            let gap = (self.radius - cauchy_length) * (self.radius + cauchy_length);
            let t = gap / (along + (along * along + square * gap).sqrt());
            for j in 0..step.len() {
                step[j] += t * (self.newton[j] - self.cauchy[j]);
            }
        }
        true
    }

    /// Adapts the radius to how the step of that length did: `ratio` is actual over promised reduction of `|R|^2`.
    fn adapt(&mut self, ratio: f64, length: f64) {
        if ratio < POOR {
            self.successes = 0;
            self.radius *= SHRINK;
        } else {
            self.successes += 1;
            if ratio >= GOOD || self.successes > 1 {
                self.radius = self.radius.max(GROW * length);
            }
            if (ratio - 1.0).abs() <= EXCELLENT {
                self.radius = GROW * length;
            }
        }
    }
}

impl Newton {
    /// Tries dogleg steps, shrinking the region, until one reduces `|R|^2` as far as the linear model can be believed.
    pub(super) fn search_region(
        &mut self,
        system: &mut dyn System,
        x: &[f64],
        residual_norm: f64,
    ) -> Result<Trial, Interrupted> {
        self.region.rescale(&self.jacobian, &self.f_scale, x);
        self.region.newton.copy_from_slice(&self.step);
        for j in 0..x.len() {
            self.region.gradient[j] = self.gradient(j);
        }
        let newton_norm = self.scaled_step_norm();
        loop {
            if !self.region.dogleg(&self.jacobian, &self.f_scale, &mut self.step) {
                return Ok(Trial::Refused(Status::StationaryPoint));
            }
            let length = self.region.norm(&self.step);
            if self.iterations() == 0 {
                self.region.radius = self.region.radius.min(length);
            }
            let promised = self.model_reduction(residual_norm);
            let norm = self.try_step(system, x, 1.0)?;
            let reduction = 1.0 - (norm / residual_norm).powi(2);
            let ratio = if promised > 0.0 && reduction.is_finite() { reduction / promised } else { 0.0 };
            self.region.adapt(ratio, length);
            if ratio >= TAKEN {
                return Ok(Trial::Taken { norm, length: self.scaled_step_norm() / newton_norm });
            }
            if self.region.radius <= SMALLEST * self.region.norm(x) {
                return Ok(Trial::Refused(Status::TrustRegionCollapsed));
            }
        }
    }

    /// The fraction of `|R|^2` that the linear model promises for the step: `1 - |R + J dx|^2 / |R|^2`.
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
