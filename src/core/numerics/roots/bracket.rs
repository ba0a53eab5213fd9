//! Zero of a function of one variable between two points with different signs.

use crate::error::Interrupted;

/// Tolerance of the zero in rounding units, relative to the zero.
const TOLERANCE_IN_ROUNDING_UNITS: f64 = 4.0;
/// Tolerance relative to the distance of the two points, for a zero at or near 0: the square of the rounding unit.
/// A larger one would make zeros much closer to 0 than the points inaccurate.
const TOLERANCE_OF_DISTANCE: f64 = f64::EPSILON * f64::EPSILON;
/// A safeguard only: bisection alone needs about 1100 steps from the largest to the smallest double.
const MAX_ITERATIONS: usize = 2200;

/// An argument and the value of a function.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// The argument.
    pub t: f64,
    /// The value there.
    pub value: f64,
}

/// Brent's method (Brent 1973, "Algorithms for Minimization without Derivatives", chapter 4): inverse
/// quadratic interpolation or the secant method, safeguarded by bisection. The values at `a` and `b` must
/// have different signs, or one of them must be zero. The unit of `t` does not matter: with `t` scaled by a power of
/// two, the result is scaled by the same.
pub fn find_zero(
    mut a: Point,
    mut b: Point,
    mut function: impl FnMut(f64) -> Result<f64, Interrupted>,
) -> Result<f64, Interrupted> {
    // b is the best point, a the previous one, c the one on the other side of the zero.
    let mut c = a;
    let mut step = b.t - a.t;
    let mut previous_step = step;
    let floor = TOLERANCE_OF_DISTANCE * step.abs();
    for _ in 0..MAX_ITERATIONS {
        if (b.value > 0.0) == (c.value > 0.0) {
            c = a;
            step = b.t - a.t;
            previous_step = step;
        }
        if c.value.abs() < b.value.abs() {
            (a, b, c) = (b, c, b);
        }
        let tolerance = 0.5 * TOLERANCE_IN_ROUNDING_UNITS * f64::EPSILON * b.t.abs() + floor;
        let to_middle = 0.5 * (c.t - b.t);
        if to_middle.abs() <= tolerance || b.value == 0.0 || b.value.is_nan() {
            break;
        }
        if previous_step.abs() >= tolerance && a.value.abs() > b.value.abs() {
            let s = b.value / a.value;
            let (mut p, mut q) = if a.t == c.t {
                (2.0 * to_middle * s, 1.0 - s)
            } else {
                let (q, r) = (a.value / c.value, b.value / c.value);
                (
                    s * (2.0 * to_middle * q * (q - r) - (b.t - a.t) * (r - 1.0)),
                    (q - 1.0) * (r - 1.0) * (s - 1.0),
                )
            };
            if p > 0.0 {
                q = -q;
            } else {
                p = -p;
            }
            if 2.0 * p < (3.0 * to_middle * q - (tolerance * q).abs()).min((previous_step * q).abs()) {
                previous_step = step;
                step = p / q;
            } else {
                step = to_middle;
                previous_step = step;
            }
        } else {
            step = to_middle;
            previous_step = step;
        }
        a = b;
        b.t += if step.abs() > tolerance { step } else { tolerance.copysign(to_middle) };
        b.value = function(b.t)?;
    }
    Ok(b.t)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn zero(f: impl Fn(f64) -> f64, a: f64, b: f64) -> f64 {
        let point = |t| Point { t, value: f(t) };
        find_zero(point(a), point(b), |t| Ok(f(t))).unwrap()
    }

    #[test]
    fn zeros_of_easy_and_hard_functions() {
        assert_eq!(zero(|t| t - 7.0, 6.0, 9.0), 7.0);
        assert!((zero(f64::cos, 1.0, 2.0) - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
        assert!((zero(f64::cos, 2.0, 1.0) - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
        // A triple zero and a jump, which need bisection.
        assert!(zero(|t| (t - 0.3).powi(3), 0.0, 1.0) - 0.3 < 1e-5);
        assert!((zero(|t| if t < 0.7 { -1.0 } else { 1.0 }, 0.0, 1.0) - 0.7).abs() < 1e-15);
        assert_eq!(zero(|t| t, 0.0, 1.0), 0.0);
        // Zeros much closer to 0 than the points.
        assert!((zero(|t| (1e18 * t).tanh() - 0.5, 0.0, 1.0) / (0.5f64.atanh() * 1e-18) - 1.0).abs() < 1e-14);
        assert!(zero(|t| if t < 0.0 { -1.0 } else { 1.0 }, -0.7, 1.0).abs() < 1e-30);
    }

    proptest::proptest! {
        #[test]
        fn the_zero_of_a_cubic(root in -1.0f64..1.0, slope in 1e-6f64..1e6, curvature in 0.0f64..1e6, power in -100i32..100) {
            let f = |t: f64| (t - root) * (slope + curvature * (t - root) * (t - root));
            let found = zero(f, -2.0, 1.5);
            proptest::prop_assert!((found - root).abs() <= 4.0 * f64::EPSILON * (1.0 + root.abs()));
            let unit = 2f64.powi(power);
            let scaled = zero(|t| f(t / unit), -2.0 * unit, 1.5 * unit);
            proptest::prop_assert_eq!(scaled, unit * found);
        }
    }
}
