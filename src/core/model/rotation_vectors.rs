//! Rotation vectors among the coordinates, kept no longer than pi to avoid their singularity.

use std::f64::consts::{PI, TAU};

/// Replaces every rotation vector longer than pi by the equivalent shorter one, `phi' = (1 - 2 pi k / |phi|)
/// phi` with k turns, and its velocities and accelerations by the derivatives of that expression. Returns
/// whether any vector changed.
///
/// `first` are the indices of the rotation vectors' first components. All `accelerations`, including those of
/// an integrator, are transformed. Rotation vectors are singular at 2 pi: a step that starts within pi stays
/// clear of that.
#[inline]
pub fn wrap(first: &[usize], q: &mut [f64], v: &mut [f64], accelerations: &mut [&mut [f64]]) -> bool {
    !first.is_empty() && wrap_some(first, q, v, accelerations)
}

fn wrap_some(first: &[usize], q: &mut [f64], v: &mut [f64], accelerations: &mut [&mut [f64]]) -> bool {
    let mut has_wrapped = false;
    for &first in first {
        let vector = |values: &[f64]| -> [f64; 3] { std::array::from_fn(|i| values[first + i]) };
        let (phi, rate) = (vector(q), vector(v));
        let length = dot(phi, phi).sqrt();
        if length.is_nan() || length <= PI {
            continue;
        }
        has_wrapped = true;
        // phi' = g phi with g = 1 - 2 pi k / |phi|, and its derivatives.
        let turns = TAU * (length / TAU).round();
        let g = 1.0 - turns / length;
        let length_rate = dot(phi, rate) / length;
        let g_rate = turns * length_rate / (length * length);
        for acceleration in accelerations.iter_mut() {
            let second = vector(acceleration);
            let length_second = (dot(rate, rate) + dot(phi, second) - length_rate * length_rate) / length;
            let g_second =
                turns * (length_second - 2.0 * length_rate * length_rate / length) / (length * length);
            for i in 0..3 {
                acceleration[first + i] = g * second[i] + 2.0 * g_rate * rate[i] + g_second * phi[i];
            }
        }
        for i in 0..3 {
            v[first + i] = g * rate[i] + g_rate * phi[i];
            q[first + i] = g * phi[i];
        }
    }
    has_wrapped
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::lie::{Quaternion, Vector};

    /// The vector after a time of motion with constant second derivative.
    fn moved([phi, rate, second]: [[f64; 3]; 3], t: f64) -> [f64; 3] {
        std::array::from_fn(|i| phi[i] + t * (rate[i] + 0.5 * t * second[i]))
    }

    #[test]
    fn the_other_vector_is_the_same_motion() {
        let motion = [[2.0, -2.5, 1.0], [0.3, 0.2, -1.0], [1.0, -2.0, 0.5]];
        let mut q = [[9.0].as_slice(), &motion[0]].concat();
        let mut v = [[9.0].as_slice(), &motion[1]].concat();
        let mut a = [[9.0].as_slice(), &motion[2]].concat();
        assert!(wrap(&[1], &mut q, &mut v, &mut [&mut a]));
        assert_eq!([q[0], v[0], a[0]], [9.0; 3]);
        assert!(!wrap(&[1], &mut q, &mut v, &mut [&mut a]), "it is within pi");
        let other = [&q, &v, &a].map(|values| std::array::from_fn(|i| values[1 + i]));
        // The quaternions differ by their sign, and by third order in time.
        for t in [0.0, 1e-3, -1e-3] {
            let [one, two] = [motion, other].map(|motion| Quaternion::exp(Vector::from(moved(motion, t))));
            let difference = one.v + two.v;
            assert!(
                difference.dot(difference).sqrt() < 1e-15 + 10.0 * t.abs().powi(3),
                "at {t}: {difference:?}"
            );
        }
    }
}
