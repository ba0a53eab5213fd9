//! Saint-Venant torsion of a rectangle.

use std::f64::consts::PI;

/// `sum 1/n^5` over odd n, which is 31/32 zeta(5) (OEIS A013663).
const ODD_FIFTH_POWERS: f64 = 31.0 / 32.0 * 1.036_927_755_143_37;

/// Number of terms of the series below; the first omitted term is exp(-11 pi) / 11^5, 1e-20.
const TERMS: u32 = 5;

/// Torsion constant of a rectangle (Timoshenko and Goodier, Theory of Elasticity, section 109). With sides a >= b,
///
/// `J_t = a b^3 / 3 (1 - 192/pi^5 b/a sum_odd tanh(n pi a / (2 b)) / n^5)`.
///
/// With tanh x = 1 - 2 / (exp(2 x) + 1) the sum is a constant minus a series that converges like exp(-n pi
/// a/b): accurate to rounding with a few terms.
pub(crate) fn rectangle(width: f64, height: f64) -> f64 {
    let (a, b) = (width.max(height), width.min(height));
    let mut sum = ODD_FIFTH_POWERS;
    for term in 0..TERMS {
        let n = f64::from(2 * term + 1);
        sum -= 2.0 / (n.powi(5) * ((n * PI * a / b).exp() + 1.0));
    }
    a * b.powi(3) / 3.0 * (1.0 - 192.0 / PI.powi(5) * b / a * sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `J_t = 2 int phi` with Prandtl's stress function, Laplace phi = -2 and zero at the boundary: the
    /// double sine series of a rectangle, summed to nine digits with the tail of n^-6.
    fn by_double_series(a: f64, b: f64) -> f64 {
        const TERMS: u32 = 400;
        let mut sum = 0.0;
        for m in (1..TERMS).step_by(2).map(f64::from) {
            for n in (1..TERMS).step_by(2).map(f64::from) {
                sum += 1.0 / ((m * n).powi(2) * ((m / a).powi(2) + (n / b).powi(2)));
            }
        }
        256.0 * a * b / PI.powi(6) * sum
    }

    #[test]
    fn torsion_constants_are_those_of_prandtls_stress_function() {
        for (a, b) in [(1.0, 1.0), (0.02, 0.03), (5.0, 1.0)] {
            let wanted = by_double_series(a, b);
            for value in [rectangle(a, b), rectangle(b, a)] {
                assert!((value - wanted).abs() < 1e-6 * wanted, "{a} x {b}: {value}, not {wanted}");
            }
        }
    }

    #[test]
    fn published_torsion_constants() {
        // Timoshenko and Goodier, table 4: k_1 of J_t = k_1 (2a)^3 (2b); the square to more digits.
        let published = [(1.0, 0.140_577), (1.5, 0.196), (2.0, 0.229), (5.0, 0.291), (10.0, 0.312)];
        for (ratio, wanted) in published {
            assert!((rectangle(ratio, 1.0) / ratio - wanted).abs() < 6e-4, "{ratio}");
        }
        assert!((rectangle(1.0, 1.0) - 0.140_577_014_955).abs() < 1e-12);
        // A thin strip of width b: b^3/3 a (1 - 0.630249 b/a).
        let strip = 1e3 / 3.0 * (1.0 - 0.630_249_245 / 1e3);
        assert!((rectangle(1e3, 1.0) - strip).abs() < 1e-9 * strip);
    }
}
