//! Whether an equilibrium is stable: from its tangent stiffness, and where forces depend on velocities from the whole linearised
//! motion.

use super::equations::Equations;
use crate::linalg::{Complex, Matrix, eigenvalues, symmetric_eigen, symmetric_eigenvalues};
use crate::modes;

/// A tangent is symmetric, so that its loads have a potential, when no entry differs from its mirror image by more than this
/// part of the stiffnesses it couples. Above what the quadrature of strongly bent rods leaves, below what any follower load
/// that matters does.
const SYMMETRIC: f64 = 1e-6;

/// Eigenvalues relative to the elastic stiffness that are rounding: some units for each coordinate.
const ROUNDING: f64 = 100.0 * f64::EPSILON;

/// An eigenvalue of the motion whose imaginary part is larger than this part of its size belongs to flutter; below, it may
/// be what rounding makes of two equal real ones.
const FLUTTER: f64 = 1e-5;

/// What small disturbances of an equilibrium do: without damping, unless a fluid or a moving base make forces depend on velocities.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stability {
    /// They stay small.
    Stable,
    /// In some direction there is no restoring force, to rounding: a critical point, or freedom to turn.
    Neutral,
    /// They grow away from the equilibrium.
    Divergence,
    /// They grow as oscillations, which follower loads, currents and turning bases can do.
    Flutter,
}

impl Stability {
    /// As one word in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stable => "stable",
            Self::Neutral => "neutral",
            Self::Divergence => "divergence",
            Self::Flutter => "flutter",
        }
    }
}

/// A stability, and what it is that of.
#[derive(Clone, Copy, Debug)]
pub(super) struct Judgement {
    pub(super) stability: Stability,
    /// Whether forces that depend on velocities have been counted; where stiffness alone decides they need not be.
    pub(super) counts_velocities: bool,
}

/// What changes its sign at a critical point.
#[derive(Clone, Copy, Debug)]
pub(super) enum Test {
    /// An eigenvalue of the symmetric tangent, by its place in order.
    Eigenvalue(usize),
    /// The determinant of a tangent that is not symmetric: its sign, with the size of the smallest eigenvalue.
    Determinant,
}

/// The tangent stiffness relative to the elastic one: `D^-1/2 K D^-1/2` with the diagonal D of the elastic stiffness. All its
/// eigenvalues are one without load; where one is zero there is a critical point.
#[derive(Clone, Debug)]
pub(super) struct Stiffness {
    relative: Matrix,
    /// `D^-1/2`, scaled.
    scale: Vec<f64>,
    pub(super) is_symmetric: bool,
    /// Its eigenvalues, smallest first, if it is symmetric: what changes sign at critical points.
    eigenvalues: Vec<f64>,
    /// Smallest eigenvalue of the symmetric part; NaN when the tangent is not finite.
    pub(super) lowest: f64,
}

impl Stiffness {
    pub(super) fn new(equations: &Equations<'_>, tangent: &Matrix) -> Self {
        let n = equations.n();
        let scale: Vec<f64> = equations
            .reference_stiffness(tangent)
            .into_iter()
            .map(|stiffness| 1.0 / stiffness.sqrt())
            .collect();
        let relative = Matrix::from_fn(n, n, |i, j| scale[i] * tangent[(i, j)] * scale[j]);
        let asymmetry = |i: usize, j: usize| (relative[(i, j)] - relative[(j, i)]).abs();
        let is_symmetric = (0..n).all(|j| (0..j).all(|i| asymmetry(i, j) <= SYMMETRIC));
        let symmetric = symmetric_eigenvalues(&symmetric_part(&relative));
        let lowest = symmetric.as_ref().map_or(f64::NAN, |values| values.first().copied().unwrap_or(1.0));
        let eigenvalues = symmetric.filter(|_| is_symmetric).unwrap_or_default();
        Self { relative, scale, is_symmetric, eigenvalues, lowest }
    }

    /// What changes sign at the critical points between this tangent and another one.
    pub(super) fn tests_until(&self, other: &Self) -> Vec<Test> {
        if self.is_symmetric && other.is_symmetric {
            let negative = |stiffness: &Self| stiffness.eigenvalues.iter().filter(|x| **x < 0.0).count();
            let (before, after) = (negative(self), negative(other));
            return (before.min(after)..before.max(after)).map(Test::Eigenvalue).collect();
        }
        let changes = (self.value(Test::Determinant) < 0.0) != (other.value(Test::Determinant) < 0.0);
        if changes { vec![Test::Determinant] } else { Vec::new() }
    }

    /// The smallest absolute eigenvalue.
    pub(super) fn smallest(&self) -> f64 {
        if self.is_symmetric {
            self.eigenvalues.iter().fold(f64::INFINITY, |smallest, x| smallest.min(x.abs()))
        } else {
            self.value(Test::Determinant).abs()
        }
    }

    /// The value of a test; NaN where it does not apply.
    pub(super) fn value(&self, test: Test) -> f64 {
        match test {
            Test::Eigenvalue(i) => self.eigenvalues.get(i).copied().unwrap_or(f64::NAN),
            Test::Determinant => signed_smallest(&self.relative),
        }
    }

    /// The scaled directions of the m smallest stiffnesses, each of norm one; and whether a load along `load` (scaled) pushes
    /// in one of them, as it does at limit points and does not at bifurcations.
    pub(super) fn softest(&self, m: usize, load: &[f64]) -> Option<(Vec<Vec<f64>>, bool)> {
        /// A load that is orthogonal to a direction to this accuracy does not push in it.
        const ORTHOGONAL: f64 = 1e-5;
        let n = load.len();
        let (_, right) = symmetric_eigen(&(self.relative.transpose() * &self.relative))?;
        let (_, left) = symmetric_eigen(&(&self.relative * self.relative.transpose()))?;
        let load: Vec<f64> = load.iter().zip(&self.scale).map(|(load, scale)| load * scale).collect();
        let size = load.iter().map(|x| x * x).sum::<f64>().sqrt();
        let is_pushed = (0..m).any(|k| {
            let along: f64 = (0..n).map(|i| left[(i, k)] * load[i]).sum();
            along.abs() > ORTHOGONAL * size
        });
        let directions = (0..m).map(|k| {
            let mut direction: Vec<f64> = (0..n).map(|i| self.scale[i] * right[(i, k)]).collect();
            let norm = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
            // The sign of an eigenvector is arbitrary; ours makes the largest entry positive.
            let largest = direction.iter().fold(0.0_f64, |m, x| if x.abs() > m.abs() { *x } else { m });
            direction.iter_mut().for_each(|x| *x /= norm.copysign(largest));
            direction
        });
        Some((directions.collect(), is_pushed))
    }

    /// What small disturbances do. Asks mass and damping only where stiffness alone does not decide; `None` when the mass matrix is
    /// singular or the tangent not finite.
    pub(super) fn stability(
        &self,
        equations: &mut Equations<'_>,
        q: &[f64],
        tangent: &Matrix,
    ) -> Option<Judgement> {
        let rounding = ROUNDING * q.len() as f64;
        let of_stiffness = |stability| Some(Judgement { stability, counts_velocities: false });
        if self.is_symmetric {
            match self.lowest {
                lowest if lowest.is_nan() => return None,
                lowest if lowest.abs() <= rounding => return of_stiffness(Stability::Neutral),
                // Neither damping nor gyroscopic forces can change that (Thomson and Tait 1879; Chetaev 1961).
                lowest if lowest > 0.0 => return of_stiffness(Stability::Stable),
                _ if !equations.has_velocity_forces() => return of_stiffness(Stability::Divergence),
                _ => {}
            }
        }
        if equations.has_velocity_forces() {
            return self.stability_in_motion(equations, q, tangent, rounding);
        }
        let motion = equations
            .mass(q)
            .cholesky()
            .map(|factors| factors.solve(tangent))
            .and_then(|a| eigenvalues(&a))?;
        // M qdd + K q = 0 has solutions exp(i omega t) with omega^2 an eigenvalue of M^-1 K.
        let is_flutter = motion.iter().any(|value| is_complex(*value));
        let is_divergence = motion.iter().any(|value| value.re < 0.0);
        of_stiffness(if self.value(Test::Determinant).abs() <= rounding {
            Stability::Neutral
        } else if is_divergence && !is_flutter {
            Stability::Divergence
        } else if is_flutter {
            Stability::Flutter
        } else {
            Stability::Stable
        })
    }

    /// That of `M qdd + D qd + K q = 0`.
    fn stability_in_motion(
        &self,
        equations: &mut Equations<'_>,
        q: &[f64],
        tangent: &Matrix,
        rounding: f64,
    ) -> Option<Judgement> {
        let motions = equations.small_motions(q, tangent);
        // Without gyroscopic forces damping does not help against a negative stiffness.
        if self.is_symmetric && modes::is_symmetric(&motions.damping) {
            return Some(Judgement { stability: Stability::Divergence, counts_velocities: false });
        }
        let found = motions.modes().ok()?;
        let stability = if self.smallest() <= rounding {
            Stability::Neutral
        } else if found.growing().any(is_complex) {
            Stability::Flutter
        } else if found.growing().next().is_some() {
            Stability::Divergence
        } else {
            Stability::Stable
        };
        Some(Judgement { stability, counts_velocities: true })
    }
}

fn is_complex(value: Complex) -> bool {
    value.im.abs() > FLUTTER * value.norm()
}

fn symmetric_part(a: &Matrix) -> Matrix {
    Matrix::from_fn(a.nrows(), a.ncols(), |i, j| 0.5 * (a[(i, j)] + a[(j, i)]))
}

/// The smallest absolute eigenvalue with the sign of the determinant: that of the number of negative real ones.
fn signed_smallest(a: &Matrix) -> f64 {
    let Some(values) = eigenvalues(a) else { return f64::NAN };
    let smallest = values.iter().map(|value| value.norm()).fold(f64::INFINITY, f64::min);
    let negative = values.iter().filter(|value| value.im == 0.0 && value.re < 0.0).count();
    if negative % 2 == 0 { smallest } else { -smallest }
}
