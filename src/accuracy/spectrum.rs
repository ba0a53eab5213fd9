//! What can vibrate, how fast, and how far the start sets it off.

use crate::linalg::{Matrix, symmetric_eigen};
use crate::model::{ForwardScratch, Model};

/// Vibrations about the start, `M x'' + C x' + K x = 0`, without the coupling by damping.
#[derive(Clone, Debug)]
pub(super) struct Spectrum {
    pub(super) modes: Vec<Vibration>,
}

/// One vibration.
#[derive(Clone, Debug)]
pub(super) struct Vibration {
    /// Natural frequency in rad/s; zero where the motion diverges.
    pub(super) frequency: f64,
    /// Modal damping over modal mass, in 1/s.
    pub(super) damping: f64,
    /// How far the coordinates go from the start: amplitude times shape.
    pub(super) amplitude: Vec<f64>,
}

impl Vibration {
    /// Magnitude of the fastest of its two eigenvalues, in 1/s: what limits an explicit step.
    pub(super) fn rate(&self) -> f64 {
        let half = 0.5 * self.damping.abs();
        if self.is_overdamped() {
            half + (half * half - self.frequency.powi(2)).sqrt()
        } else {
            self.frequency
        }
    }

    /// Creeps back instead of oscillating.
    pub(super) fn is_overdamped(&self) -> bool {
        0.5 * self.damping.abs() > self.frequency
    }
}

impl Spectrum {
    /// `None` where the mass matrix is not positive definite, something is not finite, or a function of time fails. About 20 n^3 flops.
    pub(super) fn new<M: Model>(model: &mut M, q0: &[f64], v0: &[f64]) -> Option<Self> {
        let n = model.n();
        model.set_time(0.0).ok()?;
        let mut a0 = vec![0.0; n];
        model.forward_dynamics(q0, v0, &mut a0, &mut ForwardScratch::new(n)).ok()?;
        let mut mass = Matrix::zeros(n, n);
        model.mass_matrix(q0, &mut mass);
        let [stiffness, damping] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(|weights| {
            let mut tangent = Matrix::zeros(n, n);
            let rest = vec![0.0; n];
            model.weighted_tangent(q0, &rest, &rest, weights, &mut tangent);
            (&tangent + tangent.transpose()) * 0.5
        });
        // M = L L^T, L^-1 K L^-T y = omega^2 y, shape = L^-T y.
        let lower = mass.clone().cholesky()?.l();
        let mut half = stiffness;
        lower.solve_lower_triangular_mut(&mut half).then_some(())?;
        let mut whole = half.transpose();
        lower.solve_lower_triangular_mut(&mut whole).then_some(())?;
        let (squares, mut shapes) = symmetric_eigen(&whole)?;
        lower.tr_solve_lower_triangular_mut(&mut shapes).then_some(())?;
        let modes = squares.iter().enumerate().map(|(k, &square)| {
            let shape = shapes.column(k);
            let frequency = square.max(0.0).sqrt();
            let with_mass = |x: &[f64]| {
                (0..n).map(|i| shape[i] * (0..n).map(|j| mass[(i, j)] * x[j]).sum::<f64>()).sum::<f64>().abs()
            };
            let size =
                if frequency > 0.0 { with_mass(&a0) / square + with_mass(v0) / frequency } else { 0.0 };
            let amplitude = shape.iter().map(|x| x * size).collect();
            let damping = (0..n)
                .map(|i| shape[i] * (0..n).map(|j| damping[(i, j)] * shape[j]).sum::<f64>())
                .sum::<f64>();
            Vibration { frequency, damping, amplitude }
        });
        Some(Self { modes: modes.collect() })
    }
}
