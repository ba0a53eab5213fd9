//! Rotation vectors and their rates.

use super::{Quaternion, Vector};

/// Up to this squared angle `c` is evaluated by its series; beyond, the closed form loses few digits.
const SERIES_LIMIT: f64 = 0.5;

/// Coefficients of `c(x) = (1 - (angle / 2) cot(angle / 2)) / angle^2` in the squared angle x: `|B_2k| / (2k)!` with
/// Bernoulli's numbers. With x up to [`SERIES_LIMIT`] the remainder is below 1e-16 of the whole.
const SERIES: [f64; 8] = [
    1.0 / 12.0,
    1.0 / 720.0,
    1.0 / 30_240.0,
    1.0 / 1_209_600.0,
    1.0 / 47_900_160.0,
    691.0 / 1_307_674_368_000.0,
    1.0 / 74_724_249_600.0,
    3617.0 / 10_670_622_842_880_000.0,
];

impl Quaternion<f64> {
    /// The rotation vector of a unit quaternion, no longer than pi.
    pub fn log(self) -> Vector<f64> {
        let sine = self.v.dot(self.v).sqrt();
        // If the sine is at the level of rounding, the quotient is one to rounding.
        let angle_over_sine = if sine < f64::MIN_POSITIVE { 1.0 } else { sine.atan2(self.w.abs()) / sine };
        self.v * (2.0 * angle_over_sine * 1.0_f64.copysign(self.w))
    }
}

/// Rate of a rotation vector shorter than 2 pi for an angular velocity in body axes: `phi' = (1 + phi^ / 2 +
/// c phi^ phi^) w` (Bullo and Murray 1995).
pub fn rotation_vector_rate(phi: Vector<f64>, angular_velocity: Vector<f64>) -> Vector<f64> {
    let [c, _] = factor(phi.dot(phi));
    let across = phi.cross(angular_velocity);
    angular_velocity + across * 0.5 + phi.cross(across) * c
}

/// The moment in body axes of forces along a rotation vector shorter than 2 pi: by virtual work the transpose of
/// [`rotation_vector_rate`], `m = (1 - phi^ / 2 + c phi^ phi^) f`.
pub fn moment_of_rotation_vector(phi: Vector<f64>, forces: Vector<f64>) -> Vector<f64> {
    let [c, _] = factor(phi.dot(phi));
    let across = phi.cross(forces);
    forces - across * 0.5 + phi.cross(across) * c
}

/// The derivatives of [`moment_of_rotation_vector`] with respect to the components of phi, at constant forces.
pub fn moment_of_rotation_vector_slopes(phi: Vector<f64>, forces: Vector<f64>) -> [Vector<f64>; 3] {
    let [c, slope] = factor(phi.dot(phi));
    let across = phi.cross(forces);
    let twice_across = phi.cross(across);
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|axis| {
        let axis = Vector::from(axis);
        let changed = axis.cross(forces);
        twice_across * (2.0 * slope * phi.dot(axis)) - changed * 0.5
            + (axis.cross(across) + phi.cross(changed)) * c
    })
}

/// The rotation vector phi of a rotation and its first two derivatives, from angular velocity and angular
/// acceleration in world axes: `phi' = T^-1(phi) w` with `T^-1 = 1 - phi^ / 2 + c phi^ phi^` (Bullo and
/// Murray 1995, eq. 2.4), and its time derivative.
pub fn rotation_vector_motion(
    rotation: Quaternion<f64>,
    angular_velocity: Vector<f64>,
    angular_acceleration: Vector<f64>,
) -> [Vector<f64>; 3] {
    let phi = rotation.log();
    let [c, slope] = factor(phi.dot(phi));
    let across = phi.cross(angular_velocity);
    let twice_across = phi.cross(across);
    let rate = angular_velocity - across * 0.5 + twice_across * c;
    let of_acceleration = {
        let across = phi.cross(angular_acceleration);
        angular_acceleration - across * 0.5 + phi.cross(across) * c
    };
    let turned = rate.cross(angular_velocity);
    let of_change = twice_across * (2.0 * slope * phi.dot(rate)) - turned * 0.5
        + (rate.cross(across) + phi.cross(turned)) * c;
    [phi, rate, of_acceleration + of_change]
}

/// `c` and its derivative with respect to the squared angle.
fn factor(x: f64) -> [f64; 2] {
    if x < SERIES_LIMIT {
        let value = SERIES.iter().rev().fold(0.0, |sum, c| sum * x + c);
        let slope = (1..SERIES.len()).rev().fold(0.0, |sum, k| sum * x + k as f64 * SERIES[k]);
        return [value, slope];
    }
    let half = 0.5 * x.sqrt();
    let (sine, cosine) = half.sin_cos();
    let value = (1.0 - half * cosine / sine) / x;
    // d(h cot h)/dx with x = 4 h^2.
    let slope_of_product = (cosine / sine - half / (sine * sine)) / (8.0 * half);
    [value, -(slope_of_product + value) / x]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn size(v: Vector<f64>) -> f64 {
        v.dot(v).sqrt()
    }

    #[test]
    fn the_logarithm_undoes_the_exponential_up_to_half_a_turn() {
        for angle in [0.0, 1e-300, 1e-12, 0.3, 1.0, 2.0, 3.0, 3.1] {
            let phi = Vector::from([0.6, -0.48, 0.64]) * angle;
            let q = Quaternion::exp(phi);
            assert!(size(q.log() - phi) <= 4e-16 * (1.0 + angle), "{angle}");
            let other = Quaternion { w: -q.w, v: -q.v };
            assert!(size(other.log() - phi) <= 4e-16 * (1.0 + angle), "{angle}, the other sign");
        }
        let beyond = Quaternion::exp(Vector::from([0.0, 0.0, 4.0])).log();
        assert!((beyond.z - (4.0 - std::f64::consts::TAU)).abs() < 1e-15, "the short way round");
    }

    #[test]
    fn its_rate_in_the_axes_of_the_body() {
        let angular = Vector { x: 0.4, y: -0.9, z: 0.2 };
        for omega in [[0.0; 3], [1e-9, 0.0, 2e-9], [0.1, -0.1, 0.1], [0.5, -0.4, 0.33], [1.0, 2.0, -1.5]] {
            let phi = Vector::from(omega);
            let turned = |t: f64| Quaternion::exp(phi).times(Quaternion::exp(angular * t)).log();
            let h = 1e-5;
            let difference = (turned(h) - turned(-h)) * (0.5 / h) - rotation_vector_rate(phi, angular);
            assert!(size(difference) < 1e-9, "{omega:?}: {difference:?}");
        }
    }

    /// The work of the moment is that of the forces, and its slopes are differences.
    #[test]
    fn moments_do_the_work_of_forces_along_it() {
        let (forces, turn) = (Vector::from([0.7, -1.1, 0.4]), Vector::from([0.2, 0.5, -0.8]));
        for phi in [[0.0; 3], [1e-9, 0.0, 2e-9], [0.5, -0.4, 0.33], [1.0, 2.0, -1.5], [0.0, 3.1, 0.3]] {
            let phi = Vector::from(phi);
            let work = forces.dot(rotation_vector_rate(phi, turn));
            assert!((moment_of_rotation_vector(phi, forces).dot(turn) - work).abs() < 1e-14, "{phi:?}");
            let h = 1e-5;
            for (k, slope) in moment_of_rotation_vector_slopes(phi, forces).into_iter().enumerate() {
                let step = Vector::from(std::array::from_fn(|i| if i == k { h } else { 0.0 }));
                let [up, down] = [phi + step, phi - step].map(|phi| moment_of_rotation_vector(phi, forces));
                assert!(size((up - down) * (0.5 / h) - slope) < 1e-9, "{phi:?}, {k}");
            }
        }
    }

    /// Angular velocity and acceleration by differences of the quaternions of a motion that is quadratic in time.
    #[test]
    fn its_derivatives_are_those_of_the_motion() {
        for phi in [[0.0, 0.0, 0.0], [0.1, -0.2, 0.3], [0.4, 0.4, 0.42], [0.5, 0.4, 0.42], [1.5, -2.0, 1.2]] {
            let [phi, rate, second] = [phi, [0.5, 0.8, -0.3], [-0.7, 0.2, 0.9]].map(Vector::from);
            let at = |t: f64| Quaternion::exp(phi + rate * t + second * (0.5 * t * t));
            // w = 2 q' q*, and its derivative, by central differences of fourth order.
            let h = 1e-3;
            let derivative = |f: &dyn Fn(f64) -> Quaternion<f64>| {
                let part = |weight: f64, q: Quaternion<f64>| (weight * q.w, q.v * weight);
                let parts =
                    [part(8.0, f(h)), part(-8.0, f(-h)), part(-1.0, f(2.0 * h)), part(1.0, f(-2.0 * h))];
                let sum = parts.into_iter().reduce(|a, b| (a.0 + b.0, a.1 + b.1)).unwrap();
                Quaternion { w: sum.0 / (12.0 * h), v: sum.1 * (1.0 / (12.0 * h)) }
            };
            let velocity = |t: f64| {
                let conjugate = Quaternion { w: at(t).w, v: -at(t).v };
                derivative(&|s| at(t + s)).times(conjugate).v * 2.0
            };
            let acceleration = derivative(&|s| Quaternion { w: 0.0, v: velocity(s) }).v;
            let found = rotation_vector_motion(at(0.0), velocity(0.0), acceleration);
            for (order, (found, wanted)) in found.into_iter().zip([phi, rate, second]).enumerate() {
                assert!(size(found - wanted) < 2e-8, "derivative {order} at {phi:?}: {found:?}");
            }
        }
    }
}
