//! Stability of a state at rest, shared by statics and modes.
//!
//! ```
//! use lissom::robot::{Rod, RobotModel};
//! use lissom::rod::Segment;
//! use lissom::stability::Stability;
//! use lissom::statics::{Options, equilibrium};
//!
//! let segment = Segment { modes: [0, 3, 0, 0, 0, 0], ..Segment::straight(1.0, 1e-3, 210e9, 80e9, 7800.0) };
//! let mut wire = RobotModel::of_rod(&Rod::new(vec![segment]))?;
//! let shape = equilibrium(&mut wire, &Options::default(), &mut || Ok(()))?.expect("nothing interrupts it");
//! assert_eq!(shape.verdict.map(|verdict| verdict.stability), Some(Stability::Stable));
//! # Ok::<(), lissom::error::InvalidInput>(())
//! ```

use crate::analysis::small_motions::{Modal, SmallMotions};
use crate::numerics::linalg::{Complex, Matrix, symmetric_eigenvalues, symmetric_part};
use crate::numerics::pencil;

/// An eigenvalue whose imaginary part exceeds this fraction of its magnitude is flutter. A smaller imaginary
/// part may be the rounding error of two equal real eigenvalues.
const SMALLEST_FLUTTER: f64 = 1e-5;

/// Rounding of damping per coordinate, relative to its largest entry.
const ROUNDING: f64 = 100.0 * f64::EPSILON;

/// Stability of a state at rest against small disturbances.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stability {
    /// Disturbances stay small.
    Stable,
    /// In some direction there is no restoring force, to rounding: a critical point, or a freedom to turn.
    Neutral,
    /// Disturbances grow without oscillation.
    Divergence,
    /// Disturbances grow as oscillations, as follower loads, currents and rotating bases can cause.
    Flutter,
}

impl Stability {
    /// The name as one word in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stable => "stable",
            Self::Neutral => "neutral",
            Self::Divergence => "divergence",
            Self::Flutter => "flutter",
        }
    }
}

/// Stability of small motions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Verdict {
    /// Stability of the actual motion, with all damping, drag and gyroscopic forces.
    pub stability: Stability,
    /// Stability without forces that depend on velocities.
    pub undamped: Stability,
}

/// Stability of small motions; `None` if a number is not finite, or if the mass matrix is not positive definite and matters.
///
/// Damping matters. It cannot destabilise a symmetric positive stiffness (Thomson and Tait 1879; Chetaev
/// 1961), but under follower loads it destabilises some motions (Ziegler 1952) and stabilises others, such as
/// those with the equal frequencies of round rods.
pub(crate) fn verdict(motions: &SmallMotions) -> Option<Verdict> {
    if !motions.is_finite() {
        return None;
    }
    let damping = &motions.damping;
    let same = |stability| Some(Verdict { stability, undamped: stability });
    let is_damped = damping.iter().any(|x| *x != 0.0);
    if motions.has_potential() {
        let undamped = of_stiffness(motions)?;
        // Only gyroscopic forces can stabilise a motion that is unstable without damping.
        let is_friction = || undamped == Stability::Stable || motions.is_damping_symmetric();
        if !is_damped || dissipates(damping)? && is_friction() {
            return same(undamped);
        }
        return Some(Verdict { stability: in_motion(&motions.modal()?)?, undamped });
    }
    let modal = motions.modal()?;
    let undamped = without_damping(&modal)?;
    let stability = if is_damped { in_motion(&modal)? } else { undamped };
    Some(Verdict { stability, undamped })
}

/// Stability of `M x'' + K x = 0` with a symmetric stiffness. The number of negative eigenvalues of `K x = l M x` depends on K alone
/// (Sylvester 1852); the mass only determines the accuracy in each direction. Where mass is missing, the magnitudes of the stiffness
/// replace it.
fn of_stiffness(motions: &SmallMotions) -> Option<Stability> {
    let SmallMotions { stiffness, mass, error, change, .. } = motions;
    let uncertain = error + change.abs() * 2.0;
    if pencil::is_positive(stiffness, &uncertain) {
        return Some(Stability::Stable);
    }
    if pencil::is_negative(stiffness, &uncertain) {
        return Some(Stability::Divergence);
    }
    let magnitudes = || {
        let size = |i: usize| if error[(i, i)] > 0.0 { error[(i, i)] } else { 1.0 };
        Matrix::from_diagonal(&(0..motions.n()).map(size).collect::<Vec<f64>>().into())
    };
    let pairs = motions.pairs(mass).or_else(|| motions.pairs(&magnitudes()))?;
    let n = motions.n();
    Some(if (0..n).any(|k| pairs.values[k] < -pairs.bounds[k]) {
        Stability::Divergence
    } else if (0..n).any(|k| pairs.is_neutral(k)) {
        Stability::Neutral
    } else {
        Stability::Stable
    })
}

/// Whether damping forces never add energy.
fn dissipates(damping: &Matrix) -> Option<bool> {
    let size = damping.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
    let lowest = symmetric_eigenvalues(&symmetric_part(damping))?.first().copied().unwrap_or(0.0);
    Some(lowest >= -ROUNDING * damping.nrows() as f64 * size)
}

/// Stability of `M x'' + K x = 0` under loads without a potential: its solutions are `exp(i omega t)` with
/// `omega^2` an eigenvalue of `M^-1 K`.
fn without_damping(modal: &Modal) -> Option<Stability> {
    let values = modal.undamped()?;
    let grows = |value: &Complex| is_complex(*value) || value.re < 0.0;
    Some(if values.iter().copied().any(is_complex) {
        Stability::Flutter
    } else if values.iter().any(grows) {
        Stability::Divergence
    } else if values.iter().any(|value| *value == Complex::from(0.0)) {
        Stability::Neutral
    } else {
        Stability::Stable
    })
}

/// Stability of `M x'' + D x' + K x = 0`.
fn in_motion(modal: &Modal) -> Option<Stability> {
    let motions = modal.motions()?;
    let growing = || motions.iter().filter(|motion| motion.is_growing());
    Some(if growing().any(|motion| is_complex(motion.rate)) {
        Stability::Flutter
    } else if growing().next().is_some() {
        Stability::Divergence
    } else if motions.iter().any(|motion| motion.rate == Complex::from(0.0)) {
        Stability::Neutral
    } else {
        Stability::Stable
    })
}

fn is_complex(value: Complex) -> bool {
    value.im.abs() > SMALLEST_FLUTTER * value.norm()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three motions beside a stiff one, whose mass is at the rounding of the others, under loads without a
    /// potential.
    #[test]
    fn rounding_of_fast_motions_is_no_instability() {
        let size = 1e-13;
        let mass = Matrix::from_fn(4, 4, |i, j| {
            let part = |k: usize| if k == 3 { size } else { 1.0 };
            let coupling = if i == j { 2.0 } else { 0.7 - 0.1 * (i + j) as f64 };
            part(i) * part(j) * coupling
        });
        let mut stiffness = Matrix::from_diagonal(&vec![1.0, 0.6, 0.3, 1.0].into());
        (stiffness[(0, 1)], stiffness[(1, 0)]) = (0.3, 0.2);
        (stiffness[(1, 3)], stiffness[(3, 1)]) = (0.31, 0.3);
        let motions = |stiffness: Matrix| SmallMotions {
            mass: mass.clone(),
            damping: Matrix::zeros(4, 4),
            error: stiffness.abs() * (16.0 * f64::EPSILON),
            stiffness,
            change: Matrix::zeros(4, 4),
            basis: Matrix::identity(4, 4),
            sizes: vec![1.0; 4],
        };
        let judged = |stiffness: &Matrix| verdict(&motions(stiffness.clone())).map(|found| found.stability);
        assert_eq!(judged(&stiffness), Some(Stability::Stable));
        stiffness[(2, 2)] = -0.3;
        assert_eq!(judged(&stiffness), Some(Stability::Divergence));
    }
}
