//! Natural vibrations about an equilibrium: frequencies, damping and shapes of `M x'' + D x' + K x = 0`.
//!
//! ```
//! use lissom::modes::modes;
//! use lissom::robot::{Rod, RobotModel};
//! use lissom::rod::Segment;
//!
//! let segment = Segment { modes: [0, 3, 0, 0, 0, 0], ..Segment::straight(1.0, 1e-3, 210e9, 80e9, 7800.0) };
//! let weightless = Rod { gravity: [0.0; 3], ..Rod::new(vec![segment]) };
//! let found = modes(&mut RobotModel::of_rod(&weightless)?, &[0.0; 3]).expect("a straight rod vibrates");
//! assert!((found.frequency[0] / std::f64::consts::TAU - 1.452).abs() < 1e-3); // hertz
//! # Ok::<(), lissom::error::InvalidInput>(())
//! ```

use crate::analysis::small_motions::{Modal, SMALLEST_GROWTH_RATE, SmallMotions, small_motions};
use crate::analysis::stability::{Stability, verdict};
use crate::model::Static;
use crate::model::constraint::one_sided;
use crate::numerics::linalg::{Complex, Matrix};

/// Damping counts as uncoupled if its coupling of the undamped modes changes eigenvalues by less than this
/// relative amount. The change is quadratic in the coupling.
const LARGEST_COUPLING: f64 = 1e-9;

/// Vibrations of a model, slowest first.
#[derive(Clone, Debug, PartialEq)]
pub struct Modes {
    /// Natural frequencies in rad/s, shape (m,): of the undamped motion if damping does not couple its modes,
    /// otherwise `|s|` of the eigenvalue s. Zero for undamped motions that diverge and for rigid-body motions
    /// without restoring force.
    pub frequency: Vec<f64>,
    /// Damping ratios, shape (m,): negative if the motion grows, above one if it is overdamped.
    pub damping: Vec<f64>,
    /// Eigenvalues s of the motions exp(s t), shape (m,): of conjugate pairs the one with positive imaginary
    /// part, of two real eigenvalues of an uncoupled motion the larger one.
    pub eigenvalues: Vec<Complex>,
    /// Shapes as columns, n x m. If damping does not couple them, they are real and mass-normalised (`phi^T M
    /// phi = 1`), and m is n minus the number of independent constraints. Otherwise they are normalised with
    /// their conjugates (`phi^H M phi = 1`), and m is between n and 2 n.
    pub shapes: Vec<Complex>,
    /// Whether shapes are real: without damping, or if damping does not couple the undamped modes.
    pub is_classical: bool,
    /// `|s R|` in joules, as in statics: zero at an equilibrium.
    pub residual_norm: f64,
    /// Stability of the equilibrium, as in statics; `None` if unknown.
    pub stability: Option<Stability>,
}

/// Why there are no modes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoModes {
    /// The mass matrix is not positive definite.
    SingularMass,
    /// Masses, stiffnesses or damping are not finite.
    NonFinite,
}

impl std::fmt::Display for NoModes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::SingularMass => "the mass matrix is not positive definite",
            Self::NonFinite => "masses, stiffnesses or damping are not finite",
        })
    }
}

impl std::error::Error for NoModes {}

/// Computes the vibrations of `model` about rest at `q`, at the time set last. With closed loops, only
/// motions that keep the loops closed: one for each coordinate, minus independent constraints. Cost: about 10
/// n^3 flops, or about 200 n^3 if damping couples the modes or loads have no potential.
pub fn modes(model: &mut dyn Static, q: &[f64]) -> Result<Modes, NoModes> {
    let (motions, residual_norm) = motions(model, q)?;
    let stability = verdict(&motions).map(|verdict| verdict.stability);
    Ok(Modes { residual_norm, stability, ..motions.modes()? })
}

/// Small motions about rest that keep the loops closed, and `|s R|` in joules. Allocates.
pub(crate) fn motions(model: &mut dyn Static, q: &[f64]) -> Result<(SmallMotions, f64), NoModes> {
    let rest = vec![0.0; model.facts().n];
    let [mut sizes, mut residual] = [rest.clone(), rest.clone()];
    model.sizes(q, &mut sizes);
    let mut multipliers = vec![0.0; model.facts().constraints()];
    if !multipliers.is_empty() {
        one_sided::multipliers(model, [q, &rest, &rest], &mut multipliers)
            .map_err(|_| NoModes::SingularMass)?;
    }
    model.set_multipliers(&multipliers);
    model.inverse_dynamics(q, &rest, &rest, &mut residual);
    model.set_multipliers(&vec![0.0; multipliers.len()]);
    let residual_norm = residual.iter().zip(&sizes).map(|(r, s)| (r * s) * (r * s)).sum::<f64>().sqrt();
    let motions = small_motions(model, q, &sizes, 1.0, &multipliers);
    Ok((motions.ok_or(NoModes::NonFinite)?, residual_norm))
}

impl SmallMotions {
    /// Computes modes without residual norm.
    pub(crate) fn modes(&self) -> Result<Modes, NoModes> {
        if !self.is_finite() {
            return Err(NoModes::NonFinite);
        }
        let modal = self.modal().ok_or(NoModes::SingularMass)?;
        let is_symmetric = self.has_potential() && self.is_damping_symmetric();
        let modes = if is_symmetric && modal.is_uncoupled() {
            self.classical(&modal)
        } else {
            self.coupled(&modal).ok_or(NoModes::NonFinite)?
        };
        // Products of finite numbers may overflow.
        let numbers = modes.frequency.iter().chain(&modes.damping).copied();
        let complex = modes.eigenvalues.iter().chain(&modes.shapes).flat_map(|number| [number.re, number.im]);
        if numbers.chain(complex).all(f64::is_finite) { Ok(modes) } else { Err(NoModes::NonFinite) }
    }

    /// Undamped modes, and the effect of damping on each.
    fn classical(&self, modal: &Modal) -> Modes {
        let Modal { squared_frequencies, shapes, damping, .. } = modal;
        let mut modes = Modes::empty(true);
        for (i, &square) in squared_frequencies.iter().enumerate() {
            let half = 0.5 * damping[(i, i)];
            let discriminant = half * half - square;
            let eigenvalue = if discriminant < 0.0 {
                Complex::new(-half, (-discriminant).sqrt())
            } else if square > 0.0 {
                // The larger of two negative roots, without cancellation.
                Complex::from(-square / (half + discriminant.sqrt()))
            } else {
                Complex::from(-half + discriminant.sqrt())
            };
            let frequency = square.max(0.0).sqrt();
            modes.frequency.push(frequency);
            modes.damping.push(match square {
                _ if frequency > 0.0 => half / frequency,
                square if square < 0.0 => -1.0,
                _ => 0.0,
            });
            modes.eigenvalues.push(eigenvalue);
            let shape = &self.basis * shapes.column(i);
            // The sign of an eigenvector is arbitrary: make the largest entry positive.
            let largest = shape.iter().fold(0.0_f64, |m, x| if x.abs() > m.abs() { *x } else { m });
            let sign = 1f64.copysign(largest);
            let scaled = shape.iter().zip(&self.sizes).map(|(x, size)| Complex::from(sign * size * x));
            modes.shapes.extend(scaled);
        }
        modes
    }

    /// Modes with whatever couples them.
    fn coupled(&self, modal: &Modal) -> Option<Modes> {
        let times = |a: &Matrix, x: &[Complex]| -> Vec<Complex> {
            (0..a.nrows()).map(|i| (0..a.ncols()).map(|j| x[j] * a[(i, j)]).sum()).collect()
        };
        let mut pairs: Vec<(Complex, Vec<Complex>)> =
            modal.motions()?.into_iter().map(|motion| (motion.rate, motion.shape)).collect();
        // Keep one of each conjugate pair. A mode that diverges without oscillation comes first.
        pairs.retain(|(value, _)| value.im >= 0.0);
        let frequency = |value: &Complex| if value.im == 0.0 && value.re > 0.0 { 0.0 } else { value.norm() };
        pairs.sort_by(|(a, _), (b, _)| frequency(a).total_cmp(&frequency(b)).then(b.re.total_cmp(&a.re)));
        let mut modes = Modes::empty(false);
        for (value, vector) in pairs {
            // Undamped shapes are mass-normalised, so the mass is the norm. The largest entry shall be real and positive.
            let size = vector.iter().map(Complex::norm_sqr).sum::<f64>().sqrt();
            let shape = times(&self.basis, &times(&modal.shapes, &vector));
            let largest =
                shape.iter().fold(Complex::from(0.0), |m, x| if x.norm() > m.norm() { *x } else { m });
            let phase = largest / largest.norm() * size;
            modes.frequency.push(frequency(&value));
            modes.damping.push(if value.norm() > 0.0 { -value.re / value.norm() } else { 0.0 });
            modes.eigenvalues.push(value);
            modes.shapes.extend(shape.iter().zip(&self.sizes).map(|(x, size)| x * *size / phase));
        }
        Some(modes)
    }
}

impl Modal {
    fn is_uncoupled(&self) -> bool {
        let Self { squared_frequencies, damping, .. } = self;
        (0..self.n()).all(|j| {
            (0..j).all(|i| {
                let gap = (squared_frequencies[i] - squared_frequencies[j]).abs();
                damping[(i, j)].powi(2) <= LARGEST_COUPLING * gap
            })
        })
    }
}

impl Modes {
    /// Eigenvalues of growing motions.
    pub fn growing(&self) -> impl Iterator<Item = Complex> {
        self.eigenvalues.iter().copied().filter(|s| s.re > SMALLEST_GROWTH_RATE * s.norm())
    }

    fn empty(is_classical: bool) -> Self {
        Self {
            frequency: Vec::new(),
            damping: Vec::new(),
            eigenvalues: Vec::new(),
            shapes: Vec::new(),
            is_classical,
            residual_norm: 0.0,
            stability: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::pendulum::SpringPendulum;

    #[test]
    fn a_hanging_pendulum_swings_and_bounces() {
        let mut pendulum = SpringPendulum::default();
        let elongation = pendulum.mass() * pendulum.gravity() / pendulum.stiffness();
        let modes = modes(&mut pendulum, &[-std::f64::consts::FRAC_PI_2, elongation]).unwrap();
        let exact = [(9.81 / (1.0 + elongation)).sqrt(), 10f64.sqrt()];
        for (found, exact) in modes.frequency.iter().zip(exact) {
            assert!((found / exact - 1.0).abs() < 1e-14, "{found} is not {exact}");
        }
        assert!(modes.is_classical && modes.residual_norm < 1e-14);
    }

    /// Two masses between springs with one damper, compared with the characteristic polynomial.
    #[test]
    fn damping_that_couples_has_complex_shapes() {
        let motions = SmallMotions {
            mass: Matrix::from_diagonal(&vec![1.0, 2.0].into()),
            damping: Matrix::from_row_slice(2, 2, &[0.5, 0.0, 0.0, 0.0]),
            stiffness: Matrix::from_row_slice(2, 2, &[5.0, -2.0, -2.0, 3.0]),
            error: Matrix::from_element(2, 2, f64::EPSILON),
            change: Matrix::zeros(2, 2),
            basis: Matrix::identity(2, 2),
            sizes: vec![1.0, 1.0],
        };
        let modes = motions.modes().unwrap();
        assert!(!modes.is_classical && modes.frequency.len() == 2);
        for (k, s) in modes.eigenvalues.iter().enumerate() {
            let determinant = (s * s + s * 0.5 + 5.0) * (s * s * 2.0 + 3.0) - 4.0;
            assert!(determinant.norm() < 1e-12 && s.re < 0.0 && s.im > 0.0);
            let shape = &modes.shapes[2 * k..2 * k + 2];
            let first = (s * s + s * 0.5 + 5.0) * shape[0] - shape[1] * 2.0;
            assert!(first.norm() < 1e-12);
            assert!((shape[0].norm_sqr() + 2.0 * shape[1].norm_sqr() - 1.0).abs() < 1e-12);
        }
    }
}
