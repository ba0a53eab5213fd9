//! Vibrations about a state: their frequencies, and the amplitudes with which the state excites them.

use crate::constraint::{MassSaddle, one_sided};
use crate::linalg::{Matrix, symmetric_eigen};
use crate::model::{ForwardScratch, Model};

/// Vibrations about the start, `M x'' + C x' + K x = 0`, ignoring coupling by damping. With closed loops,
/// only motions that keep them closed.
#[derive(Clone, Debug)]
pub(crate) struct Spectrum {
    pub(crate) modes: Vec<Vibration>,
}

/// A vibration mode.
#[derive(Clone, Debug)]
pub(crate) struct Vibration {
    /// Natural frequency in rad/s; zero if the motion diverges.
    pub(crate) frequency: f64,
    /// Modal damping over modal mass, in 1/s.
    pub(crate) damping: f64,
    /// Mode shape, mass-normalised.
    pub(crate) shape: Vec<f64>,
    /// Modal velocity of the state.
    pub(crate) velocity: f64,
    /// Modal amplitude that the state excites under constant loads.
    pub(crate) size: f64,
}

impl Vibration {
    /// Magnitude of the faster of both eigenvalues, in 1/s, which limits explicit steps.
    pub(crate) fn rate(&self) -> f64 {
        let half = 0.5 * self.damping.abs();
        if self.is_overdamped() {
            half + (half * half - self.frequency.powi(2)).sqrt()
        } else {
            self.frequency
        }
    }

    /// Displacement of the tip of `model` from `q` for this modal amplitude, in metres; may be infinite.
    pub(crate) fn reach<M: Model>(&self, model: &mut M, q: &[f64], size: f64) -> f64 {
        let moved: Vec<f64> = q.iter().zip(&self.shape).map(|(q, x)| q + x * size).collect();
        let by = model.moved(q, &moved);
        if by.is_nan() { f64::INFINITY } else { by }
    }

    /// Returns to rest without oscillation.
    pub(crate) fn is_overdamped(&self) -> bool {
        0.5 * self.damping.abs() > self.frequency
    }
}

/// Accuracy of eigenvalues: this factor times the precision of the largest one times their number.
const ROUNDING: f64 = 16.0;

impl Spectrum {
    /// Largest rate, in 1/s, which limits explicit steps.
    pub(crate) fn rate(&self) -> f64 {
        self.modes.iter().map(Vibration::rate).fold(0.0, f64::max)
    }

    /// Highest frequency, in rad/s, among vibrations that oscillate and move the tip by more than `distance`
    /// metres; zero if there are none.
    pub(crate) fn highest_visible<M: Model>(&self, model: &mut M, q: &[f64], distance: f64) -> f64 {
        let visible = self
            .modes
            .iter()
            .filter(|mode| !mode.is_overdamped() && mode.reach(model, q, mode.size) > distance);
        visible.map(|mode| mode.frequency).fold(0.0, f64::max)
    }

    /// `None` if the mass matrix is not positive definite, a number is not finite, or a function of time
    /// fails. About 20 n^3 flops.
    pub(crate) fn new<M: Model>(model: &mut M, t: f64, q0: &[f64], v0: &[f64]) -> Option<Self> {
        let n = model.n();
        model.set_time(t).ok()?;
        let mut a0 = vec![0.0; n];
        let mut multipliers = vec![0.0; model.constraints()];
        if multipliers.is_empty() {
            model.forward_dynamics(q0, v0, &mut a0, &mut ForwardScratch::new(n)).ok()?;
        } else {
            one_sided::accelerations(model, q0, v0, &mut a0, &mut multipliers).ok()?;
            model.set_multipliers(&multipliers);
        }
        let mut mass = Matrix::zeros(n, n);
        model.mass_matrix(q0, &mut mass);
        let [stiffness, damping] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(|weights| {
            let mut tangent = Matrix::zeros(n, n);
            let rest = vec![0.0; n];
            model.weighted_tangent(q0, &rest, &rest, weights, &mut tangent);
            (&tangent + tangent.transpose()) * 0.5
        });
        let held = if multipliers.is_empty() {
            Matrix::zeros(n, 0)
        } else {
            multipliers.fill(0.0);
            model.set_multipliers(&multipliers);
            MassSaddle::with(model, q0, &mass).ok()?.held()
        };
        // M = L L^T, L^-1 K L^-T y = omega^2 y, shape = L^-T y.
        let lower = mass.clone().cholesky()?.l();
        let mut half = stiffness;
        lower.solve_lower_triangular_mut(&mut half).then_some(())?;
        let mut whole = half.transpose();
        lower.solve_lower_triangular_mut(&mut whole).then_some(())?;
        // Projection leaves rounding of the whole matrix.
        let size = whole.norm();
        let (squares, mut shapes) = free_eigen(whole, &held)?;
        lower.tr_solve_lower_triangular_mut(&mut shapes).then_some(())?;
        // Free motions have frequency zero up to the rounding of the others.
        let largest = squares.iter().fold(size, |largest: f64, square| largest.max(square.abs()));
        let rounding = ROUNDING * n as f64 * f64::EPSILON * largest;
        let modes = squares.iter().enumerate().map(|(k, &square)| {
            let square = if square.abs() <= rounding { 0.0 } else { square };
            let shape = shapes.column(k);
            let frequency = square.max(0.0).sqrt();
            let with_mass = |x: &[f64]| {
                (0..n).map(|i| shape[i] * (0..n).map(|j| mass[(i, j)] * x[j]).sum::<f64>()).sum::<f64>()
            };
            let velocity = with_mass(v0);
            let size = if frequency > 0.0 {
                with_mass(&a0).abs() / square + velocity.abs() / frequency
            } else {
                0.0
            };
            let damping = (0..n)
                .map(|i| shape[i] * (0..n).map(|j| damping[(i, j)] * shape[j]).sum::<f64>())
                .sum::<f64>();
            Vibration { frequency, damping, shape: shape.iter().copied().collect(), velocity, size }
        });
        Some(Self { modes: modes.collect() })
    }
}

/// Eigenvalues and eigenvectors of a symmetric matrix on the orthogonal complement of the held directions.
fn free_eigen(matrix: Matrix, held: &Matrix) -> Option<(Vec<f64>, Matrix)> {
    /// Held directions are shifted beyond all other eigenvalues by this factor.
    const BEYOND: f64 = 2.0;
    if held.ncols() == 0 {
        return symmetric_eigen(&matrix);
    }
    let free = |matrix: Matrix| &matrix - held * held.tr_mul(&matrix);
    let between = free(free(matrix).transpose());
    let beyond = BEYOND * between.norm().max(f64::MIN_POSITIVE);
    let (mut values, vectors) = symmetric_eigen(&(between + held * held.transpose() * beyond))?;
    values.truncate(values.len() - held.ncols());
    let vectors = vectors.columns(0, values.len()).into_owned();
    Some((values, vectors))
}
