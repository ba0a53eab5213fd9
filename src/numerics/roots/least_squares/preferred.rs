//! Among all roots within bounds, the one that minimises a quadratic form.
//!
//! Solves `min |D (x - w)|^2 / 2` subject to `R(x) = 0` and bounds by the method of multipliers (Hestenes
//! 1969; Powell 1969): a sequence of least-squares problems for `r (R + y)` and `D (x - w)`, with updates `y
//! <- y + R` and with r increased until R vanishes.

use super::{Bounds, Counters, End, LeastSquares, Options, solve};
use crate::error::{Interrupted, Unfinished};
use crate::numerics::linalg::{Matrix, norm};
use crate::numerics::roots::System;

/// Initial weight r^2 of the equations, its growth after rounds that leave more than the fraction `SLOW` of
/// R, and its largest value, at which doubles still resolve the quadratic form (Nocedal and Wright 2006,
/// section 17.4).
const FIRST_WEIGHT: f64 = 1e2;
const GROWTH: f64 = 10.0;
const SLOW: f64 = 0.03;
const LARGEST_WEIGHT: f64 = 1e10;

/// Maximum number of rounds: at the boundary of the reachable set, multipliers do not exist and the iteration
/// never converges.
const MAX_ROUNDS: usize = 30;

/// Steps allowed per round as a multiple of those of a start: weak preferences have long flat valleys.
const STEPS: usize = 10;

/// The quadratic form `|D (x - w)|^2 / 2`.
#[derive(Clone, Debug)]
pub(crate) struct Form {
    /// D.
    pub(crate) root: Matrix,
    /// w.
    pub(crate) wanted: Vec<f64>,
}

impl Form {
    /// Moves from a root to the preferred one nearby; returns whether it converged. Otherwise x is unchanged.
    pub(crate) fn settle(
        &self,
        system: &mut dyn LeastSquares,
        x: &mut [f64],
        bounds: &Bounds,
        options: &Options,
        counters: &mut Counters,
    ) -> Result<bool, Interrupted> {
        let equations = system.equations();
        let mut here = x.to_vec();
        let mut augmented =
            Augmented { form: self, system, multipliers: vec![0.0; equations], weight: FIRST_WEIGHT.sqrt() };
        let mut residual = vec![0.0; equations];
        let mut before = f64::INFINITY;
        for _ in 0..MAX_ROUNDS {
            let search = Options {
                tolerance: 0.0,
                terms: options.terms * augmented.weight,
                max_iter: STEPS * options.max_iter,
                second_order: true,
            };
            let found = solve(&mut augmented, &mut here, bounds, &search).map_err(Unfinished::interrupted)?;
            *counters += found.counters;
            if !matches!(found.end, End::Minimum | End::Root) {
                break;
            }
            augmented.system.residual(&here, &mut residual)?;
            let left = norm(&residual);
            if left <= options.tolerance {
                x.copy_from_slice(&here);
                return Ok(true);
            }
            let growth = if left > SLOW * before { GROWTH.sqrt() } else { 1.0 };
            before = left;
            let weight = (augmented.weight * growth).min(LARGEST_WEIGHT.sqrt());
            let ratio = (augmented.weight / weight).powi(2);
            for (multiplier, residual) in augmented.multipliers.iter_mut().zip(&residual) {
                *multiplier = (*multiplier + residual) * ratio;
            }
            augmented.weight = weight;
        }
        Ok(false)
    }
}

/// `r (R + y)` and `D (x - w)`.
struct Augmented<'a> {
    form: &'a Form,
    system: &'a mut dyn LeastSquares,
    multipliers: Vec<f64>,
    weight: f64,
}

impl System for Augmented<'_> {
    fn unknowns(&self) -> usize {
        self.system.unknowns()
    }

    fn equations(&self) -> usize {
        self.multipliers.len() + self.system.unknowns()
    }

    fn residual(&mut self, x: &[f64], residual: &mut [f64]) -> Result<(), Interrupted> {
        let (of_system, of_form) = residual.split_at_mut(self.multipliers.len());
        self.system.residual(x, of_system)?;
        for (residual, multiplier) in of_system.iter_mut().zip(&self.multipliers) {
            *residual = self.weight * (*residual + multiplier);
        }
        of_form.fill(0.0);
        for (k, column) in self.form.root.column_iter().enumerate() {
            let difference = x[k] - self.form.wanted[k];
            of_form.iter_mut().zip(column.iter()).for_each(|(sum, entry)| *sum += entry * difference);
        }
        Ok(())
    }

    fn jacobian(&mut self, x: &[f64], jacobian: &mut Matrix) -> Result<(), Interrupted> {
        let (m, n) = (self.multipliers.len(), x.len());
        let mut of_system = Matrix::zeros(m, n);
        self.system.jacobian(x, &mut of_system)?;
        jacobian.rows_mut(0, m).copy_from(&(of_system * self.weight));
        jacobian.rows_mut(m, n).copy_from(&self.form.root);
        Ok(())
    }
}

impl LeastSquares for Augmented<'_> {}
