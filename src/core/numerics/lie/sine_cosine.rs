//! Branch-free sine and cosine, for all lanes at once.

use super::Scalar;

/// Beyond this angle the reduction to [-pi/4, pi/4] loses digits: products of the parts of [`HALF_PI`] and
/// the number of quarter turns are exact below 2^20 quarter turns.
const LARGEST_ANGLE: f64 = 1e6;

/// pi/2 in two parts of 33 bits and a remainder (fdlibm 5.3, e_rem_pio2.c: pio2_1, pio2_2, pio2_2t).
const HALF_PI: [f64; 3] = [1.570_796_326_734_125_6, 6.077_100_506_303_966e-11, 2.022_266_248_795_950_6e-21];

/// Minimax coefficients of sin x / x in x^2, with an error below 2^-58 on [-pi/4, pi/4] (fdlibm 5.3, k_sin.c:
/// S1 to S6).
const SINE: [f64; 6] = [
    -1.666_666_666_666_663_2e-1,
    8.333_333_333_322_49e-3,
    -1.984_126_982_985_795e-4,
    2.755_731_370_707_006_8e-6,
    -2.505_076_025_340_686_3e-8,
    1.589_690_995_211_55e-10,
];

/// Coefficients of cos x beyond 1 - x^2/2 (fdlibm 5.3, k_cos.c: C1 to C6).
const COSINE: [f64; 6] = [
    4.166_666_666_666_66e-2,
    -1.388_888_888_887_411e-3,
    2.480_158_728_947_673e-5,
    -2.755_731_435_139_066_3e-7,
    2.087_572_321_298_175e-9,
    -1.135_964_755_778_819_5e-11,
];

/// Adding and subtracting this rounds numbers below 2^51 to integers.
const ROUNDING: f64 = 6_755_399_441_055_744.0;

#[inline(always)]
fn round<T: Scalar>(x: T) -> T {
    (x + T::splat(ROUNDING)) - T::splat(ROUNDING)
}

#[inline(always)]
fn polynomial<T: Scalar>(coefficients: &[f64; 6], x: T) -> T {
    coefficients.iter().rev().fold(T::splat(0.0), |sum, &c| sum.mul_add(x, T::splat(c)))
}

/// `(sin x, cos x)`, with an absolute error of about one unit in the last place of 1.
#[inline(always)]
pub fn sine_cosine<T: Scalar>(x: T) -> (T, T) {
    let largest = (x * x).largest();
    if largest > LARGEST_ANGLE * LARGEST_ANGLE || largest.is_nan() {
        return x.slow_sine_cosine();
    }
    let one = T::splat(1.0);
    let twice = |a: T| a + a;
    let quarters = round(x * std::f64::consts::FRAC_2_PI);
    let angle = ((x - quarters * HALF_PI[0]) - quarters * HALF_PI[1]) - quarters * HALF_PI[2];
    let square = angle * angle;
    let sine = angle + angle * square * polynomial(&SINE, square);
    let half_square = square * 0.5;
    let near_one = one - half_square;
    let rest = (one - near_one) - half_square;
    let cosine = near_one + (rest + square * square * polynomial(&COSINE, square));

    // The number of quarter turns modulo four, as two bits.
    let turns = round(quarters * 0.25 - T::splat(0.375));
    let quarter = quarters - turns * 4.0;
    let half = round(quarter * 0.5 - T::splat(0.25));
    let odd = quarter - twice(half);
    let even = one - odd;
    let sine_sign = one - twice(half);
    let cosine_sign = one - twice(half + odd - twice(half * odd));
    (sine_sign * (sine * even + cosine * odd), cosine_sign * (cosine * even + sine * odd))
}

#[cfg(test)]
mod tests {
    use super::super::{Lanes, Pack};
    use super::*;

    #[test]
    fn agrees_with_the_standard_library() {
        let mut angles = vec![0.0, -0.0, 1e-300, 1e-9, f64::MAX, -1e7];
        angles.extend((-4000..4000).map(|i| 0.01 * f64::from(i)));
        angles.extend((-40..40).map(|i| std::f64::consts::FRAC_PI_4 * f64::from(i)));
        angles.extend((0..200).map(|i| 1.1f64.powi(i) * 1e-3));
        for angle in angles {
            let (sine, cosine) = sine_cosine(angle);
            assert!((sine - angle.sin()).abs() <= f64::EPSILON, "sin {angle} is not {sine}");
            assert!((cosine - angle.cos()).abs() <= f64::EPSILON, "cos {angle} is not {cosine}");
            let lanes = [angle, 0.3, angle, -2.0];
            let packed = sine_cosine(Pack::<false>::from_lanes(lanes));
            let fused = sine_cosine(Pack::<true>::from_lanes(lanes));
            if angle.abs() <= LARGEST_ANGLE {
                assert_eq!(
                    (packed.0.lane(2).to_bits(), packed.1.lane(2).to_bits()),
                    (sine.to_bits(), cosine.to_bits())
                );
            }
            assert!((fused.0.lane(2) - angle.sin()).abs() <= f64::EPSILON);
            assert!((fused.1.lane(2) - angle.cos()).abs() <= f64::EPSILON);
        }
        assert!(sine_cosine(f64::NAN).0.is_nan() && sine_cosine(f64::INFINITY).1.is_nan());
        let (sine, _) = sine_cosine(Pack::<false>::from_lanes([0.5, f64::NAN, 0.5, 0.5]));
        assert!(sine.lane(1).is_nan() && sine.lane(0) == 0.5f64.sin());
    }
}
