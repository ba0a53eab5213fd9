//! Jacobian of a step: the derivative of its residual with respect to the accelerations.

use super::linear_system::LinearSystem;
use super::numbers::Numbers;
use super::options::{Options, RTOL, UNRESOLVED_MOTION};
use super::trial::Trial;
use crate::error::Interrupted;
use crate::integrators::second_order::{Counters, SecondOrderSystem, model_at};
use crate::model::chart::correction_for_moments;
use crate::model::{Dynamics, Tied};
use crate::numerics::linalg::{Matrix, norm_inf};
use crate::numerics::roots;
use crate::numerics::roots::{CENTRAL_INCREMENT, Derivative, Differences, FORWARD_INCREMENT};

/// Jacobians of one kind, with memory for repeated use at one size.
#[derive(Clone, Debug)]
pub(super) struct Jacobian {
    derivative: Derivative,
    /// Relative increment of the differences.
    increment: f64,
    differences: Differences,
    shifted: Trial<Vec<f64>>,
    zeros: Vec<f64>,
    scale: Vec<f64>,
    /// Smallest sizes, at which the absolute tolerance exceeds the relative one, if there is an absolute one. Increments of these sizes
    /// are within the absolute tolerance.
    smallest: Option<Vec<f64>>,
    /// Without absolute tolerances, accelerations that are solved to nothing but rounding, of coordinates whose size is one.
    smallest_acceleration: f64,
}

/// Approximate cost of the tangent of equations of motion given by functions, in residual evaluations.
const COST_OF_TANGENT: f64 = 3.0;

/// Differences change accelerations by at most this fraction of the largest one, for equations that are not linear in them.
const LARGEST_CHANGE: f64 = 0.1;

/// The size of coordinates that are zero and have no absolute tolerance (MINPACK's choice in `fdjac1`).
const SIZE_OF_ZERO: f64 = 1.0;

/// Without an absolute tolerance, displacements count as at least this part of the size of their coordinate: the ratio of the default
/// tolerances, [`ATOL`](super::ATOL) to [`RTOL`](super::RTOL), of coordinates whose size is one.
const SMALLEST_MOTION: f64 = 1e-3;

/// Smallest size over the relative increment: smaller ones would make increments that underflow.
const SMALLEST_SIZE: f64 = 1e-290;

/// Differences are repeated with larger increments while the residual changes by less than this fraction of its size, slightly above its
/// rounding: the 3/4th power of the rounding unit (Salane 1986).
const VISIBLE_CHANGE: f64 = 1.8e-12;

/// Maximum number of repetitions; each divides increments by the usual relative one.
const ENLARGEMENTS: usize = 2;

impl Jacobian {
    pub(super) fn new(options: &Options, rtol: &[f64], atol: Option<&[f64]>) -> Self {
        let (n, derivative) = (rtol.len(), options.derivative);
        let memory = if derivative == Derivative::Analytic { 0 } else { n };
        let increment = if derivative == Derivative::Central { CENTRAL_INCREMENT } else { FORWARD_INCREMENT };
        Self {
            derivative,
            increment,
            differences: Differences::new(memory, memory),
            shifted: Trial::new(memory),
            zeros: vec![0.0; memory],
            scale: vec![0.0; memory],
            smallest_acceleration: UNRESOLVED_MOTION / (RTOL * options.dt * options.dt),
            smallest: atol
                .map(|atol| rtol.iter().zip(atol).map(|(rtol, atol)| atol / rtol.max(increment)).collect()),
        }
    }

    /// Memory for the Jacobians of `system`.
    pub(super) fn linear_system<S: SecondOrderSystem + ?Sized>(&self, system: &mut S) -> LinearSystem {
        LinearSystem::new(system, self.derivative)
    }

    /// The cost of an evaluation, in residual evaluations.
    pub(super) fn cost<S: SecondOrderSystem + ?Sized>(&self, system: &mut S) -> f64 {
        match self.derivative {
            Derivative::Analytic => system.model().map_or(COST_OF_TANGENT, |model| model.tangent_cost()),
            Derivative::Forward => system.facts().n as f64,
            Derivative::Central => 2.0 * system.facts().n as f64,
        }
    }

    /// `dr/da` at `trial`, where the residual is `residual`; for rotation vectors that of moments ([`correction_for_moments`]).
    ///
    /// Differences change the accelerations such that displacements, or velocities times `h`, change by the usual fraction
    /// of a displacement's size, but by no more than [`LARGEST_CHANGE`]. The size of a displacement is at least its motion
    /// within `h`, and at least [`Self::smallest`]. If large forces hide the change of the residual, the change is enlarged.
    pub(super) fn evaluate<S: SecondOrderSystem + ?Sized, V: Numbers>(
        &mut self,
        system: &mut S,
        trial: &Trial<V>,
        residual: &[f64],
        h: f64,
        linear: &mut LinearSystem,
        counters: &mut Counters,
    ) -> Result<(), Interrupted> {
        counters.njev += 1;
        self.of_forces(system, trial, residual, h, linear, counters)?;
        // The derivative of moments about the axes of bodies instead of forces along rotation vectors.
        let [of_displacement, ..] = trial.weights;
        for &first in &system.facts().rotation_vectors {
            let [v, forces] = [&trial.q[..], residual].map(|x| std::array::from_fn(|i| x[first + i]));
            let correction = correction_for_moments(v, forces);
            for (i, row) in correction.iter().enumerate() {
                for (j, entry) in row.iter().enumerate() {
                    *linear.entry(first + i, first + j) += of_displacement * entry;
                }
            }
        }
        Ok(())
    }

    /// The derivative of the residual itself.
    #[inline(always)]
    fn of_forces<S: SecondOrderSystem + ?Sized, V: Numbers>(
        &mut self,
        system: &mut S,
        trial: &Trial<V>,
        residual: &[f64],
        h: f64,
        linear: &mut LinearSystem,
        counters: &mut Counters,
    ) -> Result<(), Interrupted> {
        let (Trial { t, q, v, weights, .. }, a) = (trial, trial.accelerations());
        let jacobian = match linear {
            LinearSystem::Tree { jacobian, .. } => {
                model_at(system, *t)?.tree_tangent(q, v, a, *weights, jacobian);
                return Ok(());
            }
            LinearSystem::Saddle(saddle) => {
                system.tangent(*t, q, v, a, *weights, &mut saddle.tangent)?;
                model_at(system, *t)?.gap_jacobian(q, &mut saddle.constraints);
                return Ok(());
            }
            LinearSystem::Dense { jacobian, .. } | LinearSystem::Blocks { jacobian, .. }
                if self.derivative == Derivative::Analytic =>
            {
                return system.tangent(*t, q, v, a, *weights, jacobian);
            }
            LinearSystem::Dense { jacobian, .. } | LinearSystem::Blocks { jacobian, .. } => jacobian,
        };
        let [wq, wv, _] = trial.weights;
        // Displacement, or velocity times h, per unit acceleration.
        let reach = wq.max(h * wv);
        let reach = if reach > 0.0 { reach } else { h * h };
        let increment = self.increment;
        let largest_acceleration = norm_inf(&trial.a);
        for i in 0..trial.a.len() {
            let moved = trial.q[i].abs().max(h * trial.v[i].abs()).max(h * h * trial.a[i].abs());
            let [smallest, smallest_acceleration] = self.smallest(i, system.facts().typical_coordinates[i]);
            let size = moved.max(smallest);
            let size = if size < SMALLEST_SIZE { SIZE_OF_ZERO } else { size };
            // Accelerations of zero are a guess and do not determine a size.
            let largest = if largest_acceleration > 0.0 {
                LARGEST_CHANGE * largest_acceleration.max(smallest_acceleration) / increment
            } else {
                f64::INFINITY
            };
            self.scale[i] = (size / reach).min(largest);
        }
        let visible = VISIBLE_CHANGE * norm_inf(residual);
        let mut moved = StepResidual { system, trial, shifted: &mut self.shifted, evaluations: 0 };
        moved.shifted.t = trial.t;
        let mut result = Ok(());
        for _ in 0..=ENLARGEMENTS {
            result = match self.derivative {
                Derivative::Central => {
                    self.differences.central(&mut moved, &self.zeros, &self.scale, jacobian)
                }
                _ => self.differences.forward(&mut moved, &self.zeros, residual, &self.scale, jacobian),
            };
            let is_lost = increment * largest_change(jacobian, &self.scale) < visible;
            if result.is_err() || !is_lost {
                break;
            }
            self.scale.iter_mut().for_each(|scale| *scale /= increment);
        }
        counters.nfev_jacobian += moved.evaluations;
        result
    }
}

impl Jacobian {
    /// The smallest displacement and acceleration that count as sizes, of a coordinate of this size.
    fn smallest(&self, i: usize, size: f64) -> [f64; 2] {
        if let Some(smallest) = &self.smallest {
            return [smallest[i]; 2];
        }
        let size = if size > 0.0 { size } else { SIZE_OF_ZERO };
        [SMALLEST_MOTION * size, self.smallest_acceleration * size]
    }
}

/// The largest change of a residual whose unknowns move by `scale`, one at a time; infinite where it is not finite.
fn largest_change(jacobian: &Matrix, scale: &[f64]) -> f64 {
    let mut largest = 0.0_f64;
    for (column, scale) in jacobian.column_iter().zip(scale) {
        for entry in column.iter() {
            let change = (entry * scale).abs();
            largest = if change.is_finite() { largest.max(change) } else { f64::INFINITY };
        }
    }
    largest
}

/// The residual of a step as a function of the change of accelerations from a trial.
struct StepResidual<'a, S: ?Sized, V> {
    system: &'a mut S,
    trial: &'a Trial<V>,
    shifted: &'a mut Trial<Vec<f64>>,
    evaluations: usize,
}

impl<S: SecondOrderSystem + ?Sized, V: Numbers> roots::NonlinearSystem for StepResidual<'_, S, V> {
    fn unknowns(&self) -> usize {
        self.trial.a.len()
    }

    fn residual(&mut self, x: &[f64], residual: &mut [f64]) -> Result<(), Interrupted> {
        let [wq, wv, wa] = self.trial.weights;
        for (i, x) in x.iter().enumerate() {
            self.shifted.q[i] = self.trial.q[i] + wq * x;
            self.shifted.v[i] = self.trial.v[i] + wv * x;
            self.shifted.a[i] = self.trial.accelerations()[i] + wa * x;
        }
        self.evaluations += 1;
        let Trial { t, q, v, a, .. } = &*self.shifted;
        self.system.residual(*t, q, v, a, residual)
    }

    fn jacobian(&mut self, _x: &[f64], _jacobian: &mut Matrix) -> Result<(), Interrupted> {
        unreachable!("differences evaluate residuals only")
    }
}
