//! Bases of the strain, as functions of the fraction x in [0, 1] of a segment's length.

use crate::description::schema::{Data as _, Described, Kind};

/// Functions in which the strains of a segment are expanded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Described)]
pub enum Basis {
    /// Shifted Legendre polynomials `P_k(2 x - 1)`: orthogonal, so that the stiffness of a constant section is diagonal.
    #[default]
    Legendre,
    /// Shifted Chebyshev polynomials `T_k(2 x - 1)`: bounded by one.
    Chebyshev,
    /// Powers `x^k`: the coordinates are coefficients of a polynomial. Ill-conditioned beyond a few modes.
    Monomial,
    /// Indicator functions of pieces of equal length (piecewise constant strain: Renda, Boyer, Dias and
    /// Seneviratne 2018). Coordinates are ordered piece by piece.
    PiecewiseConstant,
    /// Piecewise cubics with continuous slope, given by values and slopes at equally spaced knots.
    /// Coordinates alternate between the strain at a knot and its derivative there times the distance of the
    /// knots. Two modes are one knot at the base: a linear function.
    Hermite,
}

impl Basis {
    /// All bases, the default one first.
    pub const ALL: [Self; 5] =
        [Self::Legendre, Self::Chebyshev, Self::Monomial, Self::PiecewiseConstant, Self::Hermite];

    /// Name in files and in Python.
    pub fn name(self) -> &'static str {
        let Kind::Word(_, names) = Self::KIND else { unreachable!("an enum without fields") };
        names[self as usize]
    }

    /// Whether different functions are orthogonal.
    pub fn is_orthogonal(self) -> bool {
        matches!(self, Self::Legendre | Self::PiecewiseConstant)
    }

    /// Whether additional modes leave the first ones unchanged.
    pub fn is_nested(self) -> bool {
        matches!(self, Self::Legendre | Self::Chebyshev | Self::Monomial)
    }

    /// Number of pieces for this number of modes; each piece is computed as a segment of its own.
    pub(crate) fn pieces(self, modes: usize) -> usize {
        if self == Self::PiecewiseConstant { modes.max(1) } else { 1 }
    }

    /// Points inside (0, 1) where derivatives jump; quadrature rules end there.
    pub(crate) fn breaks(self, modes: usize) -> Vec<f64> {
        match self {
            Self::Hermite => {
                let intervals = hermite_intervals(modes);
                (1..intervals).map(|i| i as f64 / intervals as f64).collect()
            }
            _ => Vec::new(),
        }
    }

    /// Polynomial degree of this number of functions, between breaks; zero without functions.
    pub(crate) fn degree(self, modes: usize) -> usize {
        match self {
            Self::Legendre | Self::Chebyshev | Self::Monomial => modes.saturating_sub(1),
            Self::PiecewiseConstant => 0,
            Self::Hermite => modes.saturating_sub(1).min(3),
        }
    }

    /// Writes the functions at `x`. For piecewise constant strains `x` lies inside the piece.
    pub fn values(self, x: f64, values: &mut [f64]) {
        match self {
            Self::Legendre => legendre(x, values),
            Self::Chebyshev => chebyshev(x, values),
            Self::Monomial => powers(x, 1.0, values),
            Self::PiecewiseConstant => values.fill(1.0),
            Self::Hermite => hermite(x, values),
        }
    }

    /// Writes the integrals of the functions from 0 to `x`.
    pub fn integrals(self, x: f64, values: &mut [f64]) {
        match self {
            Self::Legendre => legendre_integrals(x, values),
            Self::Chebyshev => chebyshev_integrals(x, values),
            Self::Monomial => {
                powers(x, x, values);
                values.iter_mut().enumerate().for_each(|(k, value)| *value /= (k + 1) as f64);
            }
            Self::PiecewiseConstant => values.fill(x),
            Self::Hermite => hermite_integrals(x, values),
        }
    }
}

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
fn legendre_integrals(x: f64, values: &mut [f64]) {
    let mut polynomials = vec![0.0; values.len() + 1];
    legendre(x, &mut polynomials);
    for (k, value) in values.iter_mut().enumerate() {
        *value = match k {
            0 => x,
            _ => (polynomials[k + 1] - polynomials[k - 1]) / (2.0 * (2.0 * k as f64 + 1.0)),
        };
    }
}

/// `T_k(2 x - 1)` by the recursion `T_{k+1} = 2 t T_k - T_{k-1}`.
fn chebyshev(x: f64, values: &mut [f64]) {
    let t = 2.0 * x - 1.0;
    let (mut before, mut here) = (t, 1.0);
    for value in values {
        *value = here;
        (before, here) = (here, 2.0 * t * here - before);
    }
}

/// `int T_k = (T_{k+1} / (k + 1) - T_{k-1} / (k - 1)) / 4` with respect to x from k = 2 on, up to a constant.
fn chebyshev_integrals(x: f64, values: &mut [f64]) {
    let mut polynomials = vec![0.0; values.len() + 1];
    chebyshev(x, &mut polynomials);
    for (k, value) in values.iter_mut().enumerate() {
        *value = match k {
            0 => x,
            1 => x * x - x,
            _ => {
                // T_j(-1) = (-1)^j, and k + 1 and k - 1 are both even or both odd.
                let at_base = if k % 2 == 0 { -1.0 } else { 1.0 };
                let [up, down] = [k + 1, k - 1].map(|j| (polynomials[j] - at_base) / j as f64);
                (up - down) / 4.0
            }
        };
    }
}

/// Writes `first` and then multiplies by `x` from value to value.
fn powers(x: f64, first: f64, values: &mut [f64]) {
    let mut power = first;
    for value in values {
        *value = power;
        power *= x;
    }
}

/// Number of intervals between the knots for this number of modes; zero with a single knot.
fn hermite_intervals(modes: usize) -> usize {
    (modes / 2).saturating_sub(1)
}

/// Index of the interval that contains a point, and the point's fraction within this interval.
fn hermite_place(x: f64, intervals: usize) -> (usize, f64) {
    let scaled = x * intervals as f64;
    let i = (scaled.max(0.0) as usize).min(intervals - 1);
    (i, scaled - i as f64)
}

fn hermite(x: f64, values: &mut [f64]) {
    let intervals = hermite_intervals(values.len());
    if intervals == 0 {
        return powers(x, 1.0, values);
    }
    let (i, t) = hermite_place(x, intervals);
    let s = 1.0 - t;
    values.fill(0.0);
    values[2 * i..][..4].copy_from_slice(&[
        s * s * (1.0 + 2.0 * t),
        s * s * t,
        t * t * (1.0 + 2.0 * s),
        -t * t * s,
    ]);
}

fn hermite_integrals(x: f64, values: &mut [f64]) {
    /// Integrals over a whole interval.
    const WHOLE: [f64; 4] = [1.0 / 2.0, 1.0 / 12.0, 1.0 / 2.0, -1.0 / 12.0];
    let intervals = hermite_intervals(values.len());
    if intervals == 0 {
        powers(x, x, values);
        values.iter_mut().enumerate().for_each(|(k, value)| *value /= (k + 1) as f64);
        return;
    }
    let (i, t) = hermite_place(x, intervals);
    let part = [
        t - t * t * t * (1.0 - 0.5 * t),
        t * t * (0.5 - t * (2.0 / 3.0 - 0.25 * t)),
        t * t * t * (1.0 - 0.5 * t),
        t * t * t * (0.25 * t - 1.0 / 3.0),
    ];
    values.fill(0.0);
    let width = 1.0 / intervals as f64;
    for (interval, integrals) in (0..i).map(|interval| (interval, WHOLE)).chain([(i, part)]) {
        for (value, integral) in values[2 * interval..][..4].iter_mut().zip(integrals) {
            *value += width * integral;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::quadrature::Gauss;
    use super::*;

    #[test]
    fn integrals_are_those_of_the_values() {
        let gauss = Gauss::new(40);
        for basis in Basis::ALL {
            for modes in [2, 4, 6, 10] {
                for x in [0.0, 0.2, 0.5, 0.77, 1.0] {
                    let mut found = vec![0.0; modes];
                    basis.integrals(x, &mut found);
                    // Interval by interval.
                    let mut wanted = vec![0.0; modes];
                    let mut values = vec![0.0; modes];
                    let mut from = 0.0;
                    for to in basis.breaks(modes).into_iter().chain([1.0]).map(|to: f64| to.min(x)) {
                        for (node, weight) in gauss.nodes.iter().zip(&gauss.weights) {
                            basis.values(from + node * (to - from), &mut values);
                            wanted.iter_mut().zip(&values).for_each(|(w, v)| *w += (to - from) * weight * v);
                        }
                        from = to;
                    }
                    for (found, wanted) in found.iter().zip(&wanted) {
                        assert!((found - wanted).abs() < 1e-14, "{basis:?}, {modes} modes up to {x}");
                    }
                }
            }
        }
    }

    #[test]
    fn names_are_those_of_files() {
        let names = ["legendre", "chebyshev", "monomial", "piecewise_constant", "hermite"];
        assert_eq!(Basis::ALL.map(Basis::name), names);
    }

    #[test]
    fn hermite_coordinates_are_values_and_slopes_at_the_knots() {
        let (modes, width) = (8, 1.0 / 3.0);
        let mut values = [0.0; 8];
        for knot in 0..4 {
            let x = f64::from(knot) * width;
            Basis::Hermite.values(x, &mut values);
            let expected: Vec<f64> = (0..modes).map(|k| if k == 2 * knot { 1.0 } else { 0.0 }).collect();
            assert!(values.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-14), "{values:?}");
            for step in [1e-6, -1e-6] {
                let mut beside = [0.0; 8];
                if (0.0..=1.0).contains(&(x + step)) {
                    Basis::Hermite.values(x + step, &mut beside);
                    let slope =
                        (beside[2 * knot as usize + 1] - values[2 * knot as usize + 1]) / step * width;
                    assert!((slope - 1.0).abs() < 1e-4, "slope {slope} at knot {knot}");
                }
            }
        }
    }

    #[test]
    fn known_chebyshev_polynomials() {
        for x in [0.0, 0.2, 0.5, 1.0] {
            let t: f64 = 2.0 * x - 1.0;
            let mut values = [0.0; 4];
            Basis::Chebyshev.values(x, &mut values);
            let wanted = [1.0, t, 2.0 * t * t - 1.0, 4.0 * t.powi(3) - 3.0 * t];
            assert!(values.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-15), "{values:?} at {x}");
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
