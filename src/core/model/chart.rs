//! Steps in the coordinates of a shape with rotation vectors as rotations of the body, for searches among shapes.
//!
//! A step d is added to a coordinate; for a rotation vector v it is a turn about the axes of the body, `R <- R
//! exp(d)` with `R = exp(v)`. To first order `dv = U(v) d` with `U = 1 + [v] / 2 + (1 / t^2 - (1 + cos t) / (2 t sin t))
//! [v]^2` and t = |v| (Simo and Vu-Quoc 1986; Absil, Mahony and Sepulchre 2008 on retractions). With U in the columns of
//! rotation vectors and ones elsewhere, forces `r` along the coordinates are `U' r` along the steps: true moments, which
//! vanish only where the body is in equilibrium, while r also vanishes at 2 pi. Rows of Jacobians are `G U`, and the
//! second derivative of a potential with the gradient r and the tangent K is `U' K U + d(U' r)/dv U`, of which
//! the symmetric part counts because turns do not commute. U is singular at t = 2 pi only, which folded vectors are far from.
//!
//! `first` are the indices of the rotation vectors' first components among the coordinates.

use std::f64::consts::PI;

use nalgebra::Matrix3;

use super::rotation_vectors;
use crate::numerics::lie::{
    Quaternion, Vector, moment_of_rotation_vector, moment_of_rotation_vector_slopes, rotation_vector_rate,
};
use crate::numerics::linalg::Matrix;

/// Replaces rotation vectors by the equivalent ones no longer than pi.
pub fn fold(first: &[usize], q: &mut [f64]) {
    // Few models have rotation vectors; only theirs need rates.
    if !first.is_empty() {
        let mut rest = vec![0.0; q.len()];
        rotation_vectors::wrap(first, q, &mut rest, &mut []);
    }
}

/// Replaces folded rotation vectors by the equivalent ones nearest to those of another shape, which may be longer than pi: a small
/// turn that passes pi changes folded ones by 2 pi.
pub fn unfold(first: &[usize], beside: &[f64], q: &mut [f64]) {
    for &k in first {
        let (folded, there) = (vector(q, k), vector(beside, k));
        let angle = folded.dot(folded).sqrt();
        if angle > 0.0 {
            let other = folded * (1.0 - 2.0 * PI / angle);
            let apart = |v: Vector<f64>| (v - there).dot(v - there);
            if apart(other) < apart(folded) {
                q[k..k + 3].copy_from_slice(&other.to_array());
            }
        }
    }
}

/// Moves a shape by a step; its rotation vectors are folded then.
pub fn retract(first: &[usize], q: &mut [f64], step: &[f64]) {
    let turned: Vec<_> = first
        .iter()
        .map(|&k| Quaternion::exp(vector(q, k)).times(Quaternion::exp(vector(step, k))).log())
        .collect();
    q.iter_mut().zip(step).for_each(|(q, step)| *q += step);
    for (&k, turned) in first.iter().zip(turned) {
        q[k..k + 3].copy_from_slice(&turned.to_array());
    }
}

/// The step that leads from one shape to another one ([`retract`]), with the shortest turns.
pub fn step_between(first: &[usize], from: &[f64], to: &[f64]) -> Vec<f64> {
    let mut step: Vec<f64> = from.iter().zip(to).map(|(from, to)| to - from).collect();
    for &k in first {
        let back = Quaternion::exp(-vector(from, k));
        step[k..k + 3].copy_from_slice(&back.times(Quaternion::exp(vector(to, k))).log().to_array());
    }
    step
}

/// `U(v)`, row by row: the rate of a rotation vector for unit turns about the axes of the body.
pub fn rate_matrix(v: [f64; 3]) -> [[f64; 3]; 3] {
    let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
        .map(|axis| rotation_vector_rate(v.into(), axis.into()).to_array());
    std::array::from_fn(|i| std::array::from_fn(|k| columns[k][i]))
}

/// `U' r` in place: forces along steps from those along coordinates.
pub fn forces(first: &[usize], q: &[f64], forces: &mut [f64]) {
    for &k in first {
        let moment = moment_of_rotation_vector(vector(q, k), vector(forces, k));
        forces[k..k + 3].copy_from_slice(&moment.to_array());
    }
}

/// `G U` in place: derivatives with respect to steps from those with respect to coordinates, row by row.
pub fn rows(first: &[usize], q: &[f64], rows: &mut Matrix) {
    for &k in first {
        let v = vector(q, k);
        for i in 0..rows.nrows() {
            let row = Vector::from(std::array::from_fn(|j| rows[(i, k + j)]));
            for (j, entry) in moment_of_rotation_vector(v, row).to_array().into_iter().enumerate() {
                rows[(i, k + j)] = entry;
            }
        }
    }
}

/// `U' K U + d(U' r)/dv U` in place: the second derivative of a potential with respect to steps, from its tangent K and
/// gradient r with respect to coordinates. Only its symmetric part is that of the potential: turns do not commute.
pub fn hessian(first: &[usize], q: &[f64], gradient: &[f64], tangent: &mut Matrix) {
    let n = q.len();
    // Rows of K U, then of U' (K U) by its transpose: blocks of three columns each.
    rows(first, q, tangent);
    for &k in first {
        let v = vector(q, k);
        for j in 0..n {
            let column = Vector::from(std::array::from_fn(|i| tangent[(k + i, j)]));
            for (i, entry) in moment_of_rotation_vector(v, column).to_array().into_iter().enumerate() {
                tangent[(k + i, j)] = entry;
            }
        }
        let slopes = moment_of_rotation_vector_slopes(v, vector(gradient, k)).map(Vector::to_array);
        let rate = rate_matrix(v.to_array());
        for i in 0..3 {
            for j in 0..3 {
                tangent[(k + i, k + j)] += (0..3).map(|m| slopes[m][i] * rate[m][j]).sum::<f64>();
            }
        }
    }
}

/// Correction of a tangent `dr/dv` of forces r along the coordinates of a rotation vector to `U'^-1 d(U' r)/dv`, with which Newton's
/// method solves for the moments `U' r`. Zero where r vanishes. Elsewhere r times the curvature of the coordinates can far exceed
/// the derivative of the moment about an axis of small inertia. Zero also where U is singular.
pub fn correction_for_moments(v: [f64; 3], forces: [f64; 3]) -> [[f64; 3]; 3] {
    let transposed = Matrix3::from(rate_matrix(v));
    let slopes = moment_of_rotation_vector_slopes(v.into(), forces.into()).map(Vector::to_array);
    let correction = transposed.lu().solve(&Matrix3::from(slopes)).unwrap_or_default();
    std::array::from_fn(|i| std::array::from_fn(|j| correction[(i, j)]))
}

fn vector(values: &[f64], first: usize) -> Vector<f64> {
    Vector::from(std::array::from_fn(|i| values[first + i]))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FIRST: [usize; 1] = [1];

    /// A potential of a shift and a rotation: of forces on four corners of a body and of a spring, with no formula of rotation
    /// vectors but the rotation itself.
    fn potential(q: &[f64]) -> f64 {
        let rotation = Quaternion::exp(vector(q, 1)).rotation();
        let corners = [[1.0, 0.2, -0.3], [-0.4, 0.9, 0.1], [0.3, -0.2, 1.2]].map(Vector::from);
        let pulls = [[0.3, -1.0, 0.4], [1.1, 0.2, -0.7], [-0.5, 0.6, 0.9]].map(Vector::from);
        let of_corners: f64 =
            corners.iter().zip(pulls).map(|(&corner, pull)| rotation.apply(corner).dot(pull)).sum();
        (1.0 + 0.3 * q[0]) * of_corners + q[0] * q[0]
    }

    #[test]
    fn corrected_tangents_are_those_of_moments() {
        let forces = |v: [f64; 3]| [v[1] * v[2] - 0.3, v[0].sin() + v[2], 2.0 * v[0] * v[1] - v[2] * v[2]];
        let h = 1e-5;
        for v in [[0.0; 3], [1e-3, 0.0, -2e-3], [0.4, -0.9, 0.2], [1.9, 1.7, -1.6], [0.0, -0.2, 6.0]] {
            let ends = |k: usize| {
                [h, -h].map(|by| {
                    let mut moved = v;
                    moved[k] += by;
                    moved
                })
            };
            let correction = correction_for_moments(v, forces(v));
            let rates = rate_matrix(v);
            for k in 0..3 {
                let moments = ends(k).map(|moved| {
                    let mut moments = forces(moved);
                    super::forces(&[0], &moved, &mut moments);
                    moments
                });
                let [plus, minus] = ends(k).map(forces);
                let tangent: [f64; 3] =
                    std::array::from_fn(|i| (plus[i] - minus[i]) / (2.0 * h) + correction[i][k]);
                for i in 0..3 {
                    let found: f64 = (0..3).map(|m| rates[m][i] * tangent[m]).sum();
                    let expected = (moments[0][i] - moments[1][i]) / (2.0 * h);
                    assert!(
                        (found - expected).abs() < 1e-7 * (1.0 + expected.abs()),
                        "{v:?}: {found} {expected}"
                    );
                }
            }
        }
        assert_eq!(correction_for_moments([2.0 * PI, 0.0, 0.0], [0.0; 3]), [[0.0; 3]; 3]);
    }

    /// Gradient and tangent in the coordinates, by differences.
    fn derivatives(q: &[f64]) -> (Vec<f64>, Matrix) {
        let h = 1e-4;
        let at = |moves: &[(usize, f64)]| {
            let mut moved = q.to_vec();
            moves.iter().for_each(|&(k, by)| moved[k] += by);
            potential(&moved)
        };
        let gradient = (0..4).map(|k| (at(&[(k, h)]) - at(&[(k, -h)])) / (2.0 * h)).collect();
        let second = |j: usize, k: usize| {
            let of = |a: f64, b: f64| a * b * at(&[(j, a * h), (k, b * h)]);
            (of(1.0, 1.0) + of(1.0, -1.0) + of(-1.0, 1.0) + of(-1.0, -1.0)) / (4.0 * h * h)
        };
        (gradient, Matrix::from_fn(4, 4, second))
    }

    #[test]
    fn forces_and_second_derivatives_are_those_along_steps() {
        for v in [[0.0; 3], [0.4, -0.2, 0.3], [1.5, -2.0, 1.2], [0.0, 0.0, 3.1]] {
            let q = [0.6, v[0], v[1], v[2]];
            let (gradient, mut tangent) = derivatives(&q);
            let mut moments = gradient.clone();
            forces(&FIRST, &q, &mut moments);
            hessian(&FIRST, &q, &gradient, &mut tangent);
            let h = 1e-3;
            let along = |step: [f64; 4]| {
                let mut moved = q;
                retract(&FIRST, &mut moved, &step);
                potential(&moved)
            };
            for direction in
                [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.3, 0.5, -0.8, 0.1], [-0.2, 0.4, 0.6, 0.7]]
            {
                let [up, here, down] = [h, 0.0, -h].map(|by| along(direction.map(|d| by * d)));
                let slope: f64 = direction.iter().zip(&moments).map(|(d, moment)| d * moment).sum();
                assert!(((up - down) / (2.0 * h) - slope).abs() < 1e-5, "{v:?}, {direction:?}");
                let direction = Matrix::from_column_slice(4, 1, &direction);
                let bend = (direction.transpose() * &tangent * &direction)[(0, 0)];
                assert!(((up - 2.0 * here + down) / (h * h) - bend).abs() < 1e-5, "{v:?}, {direction:?}");
            }
        }
    }

    #[test]
    fn a_moment_does_not_vanish_where_the_force_along_the_vector_does() {
        // After a whole turn only the force along the vector is left of the moment about another axis.
        let near = [0.0, 0.0, 0.0, 2.0 * PI - 1e-9];
        let mut folded = near;
        fold(&FIRST, &mut folded);
        assert!(vector(&folded, 1).dot(vector(&folded, 1)).sqrt() < 2e-9);
        let (gradient, _) = derivatives(&folded);
        let mut moments = gradient;
        forces(&FIRST, &folded, &mut moments);
        assert!(moments[1].abs() > 0.1 && moments[2].abs() > 0.1, "{moments:?}");
    }

    #[test]
    fn unfolded_vectors_are_as_far_apart_as_their_rotations() {
        let from = [0.0, PI - 0.1, 0.0, 0.0];
        for by in [0.05, 0.3, -0.4] {
            let mut q = from;
            retract(&FIRST, &mut q, &[0.0, by, 0.0, 0.0]);
            unfold(&FIRST, &from, &mut q);
            assert!((q[1] - from[1] - by).abs() < 1e-13, "{by}: {q:?}");
        }
        let mut none = [0.0; 4];
        unfold(&FIRST, &from, &mut none);
        assert_eq!(none, [0.0; 4]);
    }

    #[test]
    fn steps_lead_from_one_shape_to_another_by_the_shorter_way() {
        let (from, to) = ([0.1, 2.0, -1.5, 1.0], [0.7, -2.2, 1.4, -1.1]);
        let step = step_between(&FIRST, &from, &to);
        assert!(vector(&step, 1).dot(vector(&step, 1)).sqrt() <= PI);
        let mut reached = from;
        retract(&FIRST, &mut reached, &step);
        let [reached, wanted] = [&reached, &to].map(|q| Quaternion::exp(vector(q, 1)).rotation());
        for axis in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Vector::from) {
            let apart = reached.apply(axis) - wanted.apply(axis);
            assert!(apart.dot(apart).sqrt() < 1e-14);
        }
        assert!((from[0] + step[0] - to[0]).abs() < 1e-15);
        // A turn of zero is no turn, whatever the vector.
        let mut same = [0.0, 5.0, 0.0, 0.0];
        retract(&FIRST, &mut same, &[0.0; 4]);
        assert!((same[1] - (5.0 - 2.0 * PI)).abs() < 1e-15);
    }
}
