//! The strain basis: shifted Legendre polynomials `P_k(2 X / L - 1)`.

/// Writes `P_0 .. P_{values.len()-1}` at `x` in [0, 1] (shifted), by Bonnet's recursion.
pub fn legendre(x: f64, values: &mut [f64]) {
    let t = 2.0 * x - 1.0;
    let (mut before, mut here) = (0.0, 1.0);
    for (k, value) in values.iter_mut().enumerate() {
        *value = here;
        let k = k as f64;
        (before, here) = (here, ((2.0 * k + 1.0) * t * here - k * before) / (k + 1.0));
    }
}

/// Writes the integrals of `P_0 .. P_{values.len()-1}` from 0 to `x` (shifted):
/// `int P_k = (P_{k+1} - P_{k-1}) / (2 (2k + 1))`, and `int P_0 = x`.
pub(super) fn integrals(x: f64, values: &mut [f64]) {
    let mut polynomials = vec![0.0; values.len() + 1];
    legendre(x, &mut polynomials);
    for (k, value) in values.iter_mut().enumerate() {
        *value = match k {
            0 => x,
            _ => (polynomials[k + 1] - polynomials[k - 1]) / (2.0 * (2.0 * k as f64 + 1.0)),
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integrals_of_known_polynomials() {
        for x in [0.0, 0.2, 0.5, 1.0] {
            let mut values = [0.0; 3];
            integrals(x, &mut values);
            let wanted = [x, x * x - x, 2.0 * x.powi(3) - 3.0 * x * x + x];
            for (value, wanted) in values.iter().zip(wanted) {
                assert!((value - wanted).abs() < 1e-15, "{value} is not {wanted} at {x}");
            }
        }
    }

    #[test]
    fn known_polynomials() {
        for x in [0.0, 0.2, 0.5, 1.0] {
            let t: f64 = 2.0 * x - 1.0;
            let mut values = [0.0; 5];
            legendre(x, &mut values);
            let wanted = [
                1.0,
                t,
                1.5 * t * t - 0.5,
                2.5 * t.powi(3) - 1.5 * t,
                (35.0 * t.powi(4) - 30.0 * t * t + 3.0) / 8.0,
            ];
            for (value, wanted) in values.iter().zip(wanted) {
                assert!((value - wanted).abs() < 1e-15, "{value} is not {wanted} at {x}");
            }
        }
    }
}
