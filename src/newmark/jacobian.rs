//! The Jacobian of a step: the derivative of its residual with respect to the accelerations.

use super::trial::Trial;
use super::{Counters, System};
use crate::error::Interrupted;
use crate::linalg::{Matrix, norm_inf};
use crate::roots::{self, CENTRAL_INCREMENT, Derivative, Differences, FORWARD_INCREMENT};

/// Jacobians of one kind, with memory for repeated use at one size.
#[derive(Clone, Debug)]
pub(super) struct Jacobian {
    derivative: Derivative,
    differences: Differences,
    shifted: Trial,
    zeros: Vec<f64>,
    scale: Vec<f64>,
    /// Smallest sizes that count: where the absolute tolerance takes over from the relative one.
    smallest: Vec<f64>,
}

/// Differences change accelerations by at most this fraction of the largest one: equations that are not linear in them
/// have a derivative there, too.
const LARGEST_CHANGE: f64 = 0.1;

impl Jacobian {
    pub(super) fn new(derivative: Derivative, rtol: &[f64], atol: &[f64]) -> Self {
        let n = rtol.len();
        let memory = if derivative == Derivative::Analytic { 0 } else { n };
        Self {
            derivative,
            differences: Differences::new(memory, memory),
            shifted: Trial::new(memory),
            zeros: vec![0.0; memory],
            scale: vec![0.0; memory],
            smallest: rtol.iter().zip(atol).map(|(r, a)| (a / r).max(f64::MIN_POSITIVE / r)).collect(),
        }
    }

    /// The cost of an evaluation, in residual evaluations.
    pub(super) fn cost<S: System + ?Sized>(&self, system: &S) -> f64 {
        match self.derivative {
            Derivative::Analytic => system.tangent_cost(),
            Derivative::Forward => system.n() as f64,
            Derivative::Central => 2.0 * system.n() as f64,
        }
    }

    /// `jacobian <- dr/da` at `trial`, where the residual is `residual`.
    ///
    /// Differences move the accelerations so that the displacements move by the usual fraction of their size (of
    /// velocities or accelerations, where the scheme leaves displacements alone), but not by more than [`LARGEST_CHANGE`].
    /// The size of a displacement is at least what it moves within `h`; no size is below `atol / rtol`.
    pub(super) fn evaluate<S: System + ?Sized>(
        &mut self,
        system: &mut S,
        trial: &Trial,
        residual: &[f64],
        h: f64,
        jacobian: &mut Matrix,
        counters: &mut Counters,
    ) -> Result<(), Interrupted> {
        counters.njev += 1;
        if self.derivative == Derivative::Analytic {
            return system.tangent(trial.t, &trial.q, &trial.v, &trial.a, trial.weights, jacobian);
        }
        let n = trial.a.len();
        let [wq, wv, _] = trial.weights;
        // What moves by the usual fraction, and by how much it moves with the accelerations.
        let (unit_of_time, lead) = if wq > 0.0 {
            (1.0, wq)
        } else if wv > 0.0 {
            (h, wv)
        } else {
            (h * h, 1.0)
        };
        let increment =
            if self.derivative == Derivative::Central { CENTRAL_INCREMENT } else { FORWARD_INCREMENT };
        let largest_acceleration = norm_inf(&trial.a);
        for i in 0..n {
            let size = trial.q[i].abs().max(h * trial.v[i].abs()).max(h * h * trial.a[i].abs());
            let largest = LARGEST_CHANGE * largest_acceleration.max(self.smallest[i]) * lead / increment;
            self.scale[i] = (size.max(self.smallest[i]) / unit_of_time).min(largest);
        }
        let mut moved = Moved { system, trial, lead, shifted: &mut self.shifted, evaluations: 0 };
        moved.shifted.t = trial.t;
        let result = match self.derivative {
            Derivative::Central => self.differences.central(&mut moved, &self.zeros, &self.scale, jacobian),
            _ => self.differences.forward(&mut moved, &self.zeros, residual, &self.scale, jacobian),
        };
        counters.nfev_jacobian += moved.evaluations;
        *jacobian *= lead;
        result
    }
}

/// The residual of a step as a function of how far its leading quantity has moved from a trial.
struct Moved<'a, S: ?Sized> {
    system: &'a mut S,
    trial: &'a Trial,
    lead: f64,
    shifted: &'a mut Trial,
    evaluations: usize,
}

impl<S: System + ?Sized> roots::System for Moved<'_, S> {
    fn unknowns(&self) -> usize {
        self.trial.a.len()
    }

    fn residual(&mut self, x: &[f64], residual: &mut [f64]) -> Result<(), Interrupted> {
        let [wq, wv, wa] = self.trial.weights.map(|weight| weight / self.lead);
        for (i, x) in x.iter().enumerate() {
            self.shifted.q[i] = self.trial.q[i] + wq * x;
            self.shifted.v[i] = self.trial.v[i] + wv * x;
            self.shifted.a[i] = self.trial.a[i] + wa * x;
        }
        self.evaluations += 1;
        let Trial { t, q, v, a, .. } = &*self.shifted;
        self.system.residual(*t, q, v, a, residual)
    }

    fn jacobian(&mut self, _x: &[f64], _jacobian: &mut Matrix) -> Result<(), Interrupted> {
        unreachable!("differences evaluate residuals only")
    }
}
