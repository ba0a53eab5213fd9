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

use crate::linalg::{Complex, Matrix, eigenvalues, symmetric_eigenvalues, symmetric_part};
use crate::small_motions::{self, GROWING, SmallMotions};

/// A stiffness counts as symmetric, so that its loads have a potential, if no entry differs from its
/// transpose by more than this fraction of the elastic stiffnesses it couples. This is above the quadrature
/// error of strongly bent rods and below the effect of any relevant follower load.
const SYMMETRIC: f64 = 1e-6;

/// Rounding of a stiffness per coordinate, relative to the elastic stiffness, or to a larger one such as a
/// contact stiffness.
const ROUNDING: f64 = 100.0 * f64::EPSILON;

/// An eigenvalue whose imaginary part exceeds this fraction of its magnitude is flutter. A smaller imaginary
/// part may be the rounding error of two equal real eigenvalues.
const FLUTTER: f64 = 1e-5;

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

/// Stability of motions in natural coordinates, in which the elastic stiffness is one; `None` if a number is
/// not finite or the mass matrix is not positive definite.
///
/// Damping matters. It cannot destabilise a symmetric positive stiffness (Thomson and Tait 1879; Chetaev
/// 1961), but under follower loads it destabilises some motions (Ziegler 1952) and stabilises others, such as
/// those with the equal frequencies of round rods.
pub(crate) fn verdict(motions: &SmallMotions) -> Option<Verdict> {
    let SmallMotions { stiffness, damping, .. } = motions;
    let (n, size) = (stiffness.nrows(), largest(stiffness));
    let rounding = rounding(n, size);
    let lowest =
        |a: &Matrix| Some(symmetric_eigenvalues(&symmetric_part(a))?.first().copied().unwrap_or(1.0));
    let same = |stability| Some(Verdict { stability, undamped: stability });
    let is_damped = damping.iter().any(|x| *x != 0.0);
    if is_symmetric(stiffness) {
        let undamped = of_stiffness(lowest(stiffness)?, n, size)?.undamped;
        let size = largest(damping);
        let dissipates = lowest(damping)? >= -rounding * size;
        let is_gyroscopic = !small_motions::is_symmetric(damping);
        // Only gyroscopic forces can stabilise a motion that is unstable without damping.
        if !is_damped || dissipates && (undamped == Stability::Stable || !is_gyroscopic) {
            return same(undamped);
        }
        return Some(Verdict { stability: in_motion(motions, rounding)?, undamped });
    }
    let undamped = without_damping(motions, rounding)?;
    let stability = if is_damped { in_motion(motions, rounding)? } else { undamped };
    Some(Verdict { stability, undamped })
}

/// Largest absolute entry.
pub(crate) fn largest(a: &Matrix) -> f64 {
    a.iter().fold(0.0, |size: f64, x| size.max(x.abs()))
}

/// Rounding of a stiffness of this size in n natural coordinates.
fn rounding(n: usize, size: f64) -> f64 {
    ROUNDING * n as f64 * size.max(1.0)
}

/// Verdict from the smallest eigenvalue and the size of a symmetric stiffness in n natural coordinates, if
/// friction is the only force that depends on velocities. `None` for NaN.
pub(crate) fn of_stiffness(lowest: f64, n: usize, size: f64) -> Option<Verdict> {
    let stability = match lowest {
        lowest if lowest.is_nan() => return None,
        lowest if lowest.abs() <= rounding(n, size) => Stability::Neutral,
        lowest if lowest > 0.0 => Stability::Stable,
        _ => Stability::Divergence,
    };
    Some(Verdict { stability, undamped: stability })
}

/// Stability of `M x'' + K x = 0`: its solutions are `exp(i omega t)` with `omega^2` an eigenvalue of `M^-1 K`.
/// Those of slow motions are accurate as inverses of the eigenvalues of `K^-1 M`.
fn without_damping(motions: &SmallMotions, rounding: f64) -> Option<Stability> {
    let SmallMotions { mass, stiffness, .. } = motions;
    let is_neutral = smallest(stiffness)? <= rounding;
    let factor = mass.clone().cholesky();
    let own = factor
        .and_then(|factor| small_motions::reduced(stiffness, &factor.l()))
        .and_then(|reduced| eigenvalues(&reduced));
    let inverse = match stiffness.clone().lu().solve(mass) {
        Some(compliance) if !is_neutral => Some(eigenvalues(&compliance)?),
        _ => None,
    };
    let values = match (inverse, own) {
        (inverse, Some(own)) => small_motions::merged_values(inverse, own),
        // Motions without mass are infinitely fast.
        (Some(inverse), None) => inverse,
        (None, None) => return None,
    };
    let largest = values.iter().map(|value| value.norm()).fold(0.0, f64::max);
    let grows = |value: &Complex| {
        if is_neutral && value.norm() <= FLUTTER * FLUTTER * largest {
            false
        } else {
            is_complex(*value) || value.re < 0.0
        }
    };
    Some(if values.iter().any(|value| grows(value) && is_complex(*value)) {
        Stability::Flutter
    } else if values.iter().any(grows) {
        Stability::Divergence
    } else if is_neutral {
        Stability::Neutral
    } else {
        Stability::Stable
    })
}

/// Stability of `M x'' + D x' + K x = 0`.
fn in_motion(motions: &SmallMotions, rounding: f64) -> Option<Stability> {
    let is_neutral = smallest(&motions.stiffness)? <= rounding;
    let values = motions.eigenvalues()?;
    let slowest = values.iter().map(|value| value.norm()).fold(f64::INFINITY, f64::min);
    let mut growing = values.iter().copied().filter(|s| {
        // Motions without stiffness have rates of the size of rounding.
        s.re > GROWING * s.norm() && !(is_neutral && s.norm() <= 10.0 * slowest)
    });
    Some(match growing.clone().any(is_complex) {
        true => Stability::Flutter,
        false if growing.next().is_some() => Stability::Divergence,
        false if is_neutral => Stability::Neutral,
        false => Stability::Stable,
    })
}

fn is_complex(value: Complex) -> bool {
    value.im.abs() > FLUTTER * value.norm()
}

/// Whether a stiffness in natural coordinates has a potential.
pub(crate) fn is_symmetric(a: &Matrix) -> bool {
    (0..a.nrows()).all(|j| (0..j).all(|i| (a[(i, j)] - a[(j, i)]).abs() <= SYMMETRIC))
}

/// Smallest absolute eigenvalue.
fn smallest(a: &Matrix) -> Option<f64> {
    Some(eigenvalues(a)?.iter().map(|value| value.norm()).fold(f64::INFINITY, f64::min))
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
            stiffness,
            basis: Matrix::identity(4, 4),
            sizes: vec![1.0; 4],
        };
        let judged = |stiffness: &Matrix| verdict(&motions(stiffness.clone())).map(|found| found.stability);
        assert_eq!(judged(&stiffness), Some(Stability::Stable));
        stiffness[(2, 2)] = -0.3;
        assert_eq!(judged(&stiffness), Some(Stability::Divergence));
    }
}
