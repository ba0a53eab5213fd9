//! Vibrations about a state: their frequencies, and the amplitudes with which the state excites them.

use crate::analysis::growing::Growing;
use crate::analysis::normalised::scaled;
use crate::analysis::small_motions::{Modal, SmallMotions, small_motions};
use crate::model::constraint::one_sided;
use crate::model::{ForwardScratch, Static};
use crate::numerics::linalg::{Matrix, dot};

/// Vibrations about the start, `M x'' + C x' + K x = 0`, ignoring coupling by damping. With closed loops,
/// only motions that keep them closed.
pub(crate) struct Spectrum {
    pub(crate) modes: Vec<Vibration>,
    modal: Modal,
    /// Mode shapes, and their products with the mass matrix, as columns.
    shapes: [Matrix; 2],
    /// Velocities and accelerations of the state.
    rates: [Vec<f64>; 2],
    /// Typical sizes of the coordinates.
    sizes: Vec<f64>,
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
    /// Mass times mode shape.
    pub(crate) momentum: Vec<f64>,
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
    pub(crate) fn reach<M: Static>(&self, model: &mut M, q: &[f64], size: f64) -> f64 {
        let moved: Vec<f64> = q.iter().zip(&self.shape).map(|(q, x)| q + x * size).collect();
        let by = model.moved(q, &moved);
        if by.is_nan() { f64::INFINITY } else { by }
    }

    /// Elastic stiffness against the vibration with a modal mass of one, in 1/s^2.
    pub(crate) fn elastic(&self, stiffness: &Matrix) -> f64 {
        let forces = stiffness.column_iter().map(|column| dot(column.as_slice(), &self.shape));
        forces.zip(&self.shape).map(|(force, x)| force * x).sum()
    }

    /// Returns to rest without oscillation.
    pub(crate) fn is_overdamped(&self) -> bool {
        0.5 * self.damping.abs() > self.frequency
    }
}

impl Spectrum {
    /// Largest rate, in 1/s, which limits explicit steps.
    pub(crate) fn rate(&self) -> f64 {
        self.modes.iter().map(Vibration::rate).fold(0.0, f64::max)
    }

    /// Highest frequency, in rad/s, among vibrations that oscillate and move the tip by more than `distance`
    /// metres; zero if there are none.
    pub(crate) fn highest_visible<M: Static>(&self, model: &mut M, q: &[f64], distance: f64) -> f64 {
        let visible = self
            .modes
            .iter()
            .filter(|mode| !mode.is_overdamped() && mode.reach(model, q, mode.size) > distance);
        visible.map(|mode| mode.frequency).fold(0.0, f64::max)
    }

    /// `None` if the mass matrix is not positive definite, a number is not finite, or a function of time
    /// fails. About 40 n^3 flops.
    pub(crate) fn new<M: Static>(model: &mut M, t: f64, q0: &[f64], v0: &[f64]) -> Option<Self> {
        let n = model.facts().n;
        model.set_time(t).ok()?;
        let mut a0 = vec![0.0; n];
        let mut multipliers = vec![0.0; model.facts().constraints()];
        if multipliers.is_empty() {
            model.forward_dynamics(q0, v0, &mut a0, &mut ForwardScratch::new(n)).ok()?;
        } else {
            one_sided::accelerations(model, q0, v0, &mut a0, &mut multipliers).ok()?;
        }
        let sizes = model.facts().typical_coordinates.clone();
        let motions = small_motions(model, q0, &sizes, 1.0, &multipliers)?;
        Self::of(model, motions, [q0, v0, &a0])
    }

    /// The same by [`Self::by_tangent`] where there are no constraints.
    pub(crate) fn fast<M: Static>(model: &mut M, t: f64, [q0, v0]: [&[f64]; 2]) -> Option<Self> {
        if model.facts().constraints() > 0 {
            return Self::new(model, t, q0, v0);
        }
        model.set_time(t).ok()?;
        let mut a0 = vec![0.0; q0.len()];
        model.forward_dynamics(q0, v0, &mut a0, &mut ForwardScratch::new(q0.len())).ok()?;
        Self::by_tangent(model, t, [q0, v0, &a0])
    }

    /// The same for a model without constraints with known accelerations `a0`, by its tangent alone: a third of the cost for
    /// few coordinates. Slow vibrations may be rounding.
    pub(crate) fn by_tangent<M: Static>(model: &mut M, t: f64, [q0, v0, a0]: [&[f64]; 3]) -> Option<Self> {
        let n = model.facts().n;
        model.set_time(t).ok()?;
        let (sizes, rest) = (model.facts().typical_coordinates.clone(), vec![0.0; n]);
        let [mut mass, mut damping, mut stiffness] = [(); 3].map(|()| Matrix::zeros(n, n));
        model.mass_matrix(q0, &mut mass);
        model.weighted_tangent(q0, &rest, &rest, [0.0, 1.0, 0.0], &mut damping);
        model.weighted_tangent(q0, &rest, &rest, [1.0, 0.0, 0.0], &mut stiffness);
        let [mass, damping, stiffness] = [mass, damping, stiffness].map(|a| scaled(a, &sizes));
        let (error, change, basis) = (Matrix::zeros(n, n), Matrix::zeros(n, n), Matrix::identity(n, n));
        let motions = SmallMotions { mass, damping, stiffness, error, change, basis, sizes };
        Self::of(model, motions, [q0, v0, a0])
    }

    fn of<M: Static>(model: &mut M, motions: SmallMotions, [q0, v0, a0]: [&[f64]; 3]) -> Option<Self> {
        let n = q0.len();
        let modal = motions.modal()?;
        let mut shapes = &motions.basis * &modal.shapes;
        for (mut row, size) in shapes.row_iter_mut().zip(&motions.sizes) {
            row *= *size;
        }
        let mut mass = Matrix::zeros(n, n);
        model.mass_matrix(q0, &mut mass);
        let with_mass = mass * &shapes;
        let modes = modal.squared_frequencies.iter().enumerate().map(|(k, &square)| {
            let frequency = square.max(0.0).sqrt();
            let [shape, momentum]: [Vec<f64>; 2] =
                [&shapes, &with_mass].map(|a| a.column(k).iter().copied().collect());
            let velocity = dot(&momentum, v0);
            let size = if frequency > 0.0 {
                dot(&momentum, a0).abs() / square + velocity.abs() / frequency
            } else {
                0.0
            };
            Vibration { frequency, damping: modal.damping[(k, k)], shape, momentum, velocity, size }
        });
        Some(Self {
            modes: modes.collect(),
            modal,
            shapes: [shapes, with_mass],
            rates: [v0, a0].map(<[f64]>::to_vec),
            sizes: motions.sizes,
        })
    }

    /// Motions that grow, with coupling by damping. About 300 n^3 flops if something may grow.
    pub(crate) fn growing(&self) -> Vec<Growing> {
        let Self { modal, shapes, rates, sizes, .. } = self;
        if !modal.may_grow() {
            return Vec::new();
        }
        Growing::of(modal, shapes.each_ref(), sizes, rates.each_ref().map(Vec::as_slice))
    }
}
