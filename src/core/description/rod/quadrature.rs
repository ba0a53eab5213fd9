//! Gauss-Legendre quadrature on [0, 1], and integrals up to its nodes.

use std::f64::consts::PI;
use std::sync::OnceLock;

use super::basis::legendre;

/// Nodes, weights and integration matrix of Gauss-Legendre quadrature on [0, 1].
#[derive(Clone, Debug)]
pub struct Gauss {
    /// Nodes x_i in ascending order.
    pub nodes: Vec<f64>,
    /// Weights w_i: `sum w_i f(x_i)` is exact for polynomials of degree 2m - 1.
    pub weights: Vec<f64>,
    /// Boundaries between the rules of a composite one, inside (0, 1).
    breaks: Vec<f64>,
}

/// Rules of fewer nodes are kept: more than segments need that are not bent many times over.
const KNOWN_RULES: usize = 65;

impl Gauss {
    /// A rule without nodes, for bodies without extent.
    pub(crate) fn none() -> Self {
        Self { nodes: Vec::new(), weights: Vec::new(), breaks: Vec::new() }
    }

    /// The rule with `m` nodes, m > 0. Small rules are computed once: every rod needs some.
    pub fn new(m: usize) -> Self {
        static KNOWN: [OnceLock<Gauss>; KNOWN_RULES] = [const { OnceLock::new() }; KNOWN_RULES];
        match KNOWN.get(m) {
            Some(known) => known.get_or_init(|| Self::computed(m)).clone(),
            None => Self::computed(m),
        }
    }

    /// Zeros of P_m by Newton's method from Tricomi's estimate (Hale and
    /// Townsend 2013, section 2), weights from the derivative at the zeros.
    fn computed(m: usize) -> Self {
        let mut nodes = vec![0.0; m];
        let mut weights = vec![0.0; m];
        let mut values = vec![0.0; m + 1];
        for i in 0..m {
            let angle = PI * (4 * (m - i) - 1) as f64 / (4 * m + 2) as f64;
            let mut t = angle.cos();
            let mut slope = 1.0;
            // Quadratic convergence from an error below 1e-2: five steps reach rounding, more have no effect.
            for _ in 0..6 {
                legendre((t + 1.0) / 2.0, &mut values);
                slope = m as f64 * (values[m - 1] - t * values[m]) / (1.0 - t * t);
                t -= values[m] / slope;
            }
            nodes[i] = (t + 1.0) / 2.0;
            weights[i] = 1.0 / ((1.0 - t * t) * slope * slope);
        }
        Self { nodes, weights, breaks: Vec::new() }
    }

    /// Composite rule with `m` nodes between any two of 0, the ascending `breaks` inside (0, 1), and 1: for
    /// functions whose derivatives jump at the breaks. Integrals up to a point are as accurate as those of a
    /// single rule.
    pub fn composite(m: usize, breaks: &[f64]) -> Self {
        let rule = Self::new(m);
        let mut composite = Self { nodes: Vec::new(), weights: Vec::new(), breaks: breaks.to_vec() };
        if breaks.is_empty() {
            return rule;
        }
        for [from, to] in intervals(breaks) {
            composite.nodes.extend(rule.nodes.iter().map(|x| from + (to - from) * x));
            composite.weights.extend(rule.weights.iter().map(|w| (to - from) * w));
        }
        composite
    }

    /// Largest distance between neighbouring nodes, or between an end and the adjacent node.
    pub(crate) fn largest_gap(&self) -> f64 {
        let before = std::iter::once(&0.0).chain(&self.nodes);
        let gaps = self.nodes.iter().chain([&1.0]).zip(before).map(|(node, before)| node - before);
        gaps.fold(0.0, f64::max)
    }

    /// Integral, from 0 to any point, of the polynomial through values at the nodes.
    pub fn integral(&self) -> Integral {
        let rule = match self.breaks.len() {
            0 => self.clone(),
            breaks => Self::new(self.nodes.len() / (breaks + 1)),
        };
        let m = rule.nodes.len();
        let mut at_nodes = vec![0.0; m * m];
        let mut at_node = vec![0.0; m];
        for (l, &node) in rule.nodes.iter().enumerate() {
            legendre(node, &mut at_node);
            for (k, &value) in at_node.iter().enumerate() {
                at_nodes[k * m + l] = value;
            }
        }
        Integral { breaks: self.breaks.clone(), rule, at_nodes }
    }

    /// Weights of the integrals from 0 to each node, one row after the other.
    pub(crate) fn weights_up_to_nodes(&self) -> Vec<f64> {
        static KNOWN: [OnceLock<Vec<f64>>; KNOWN_RULES] = [const { OnceLock::new() }; KNOWN_RULES];
        let computed = || {
            let integral = self.integral();
            self.nodes.iter().flat_map(|&x| integral.weights_up_to(x)).collect()
        };
        match KNOWN.get(self.nodes.len()) {
            Some(known) if self.breaks.is_empty() => known.get_or_init(computed).clone(),
            _ => computed(),
        }
    }

    /// Weights of the integral from 0 to `x`.
    pub fn weights_up_to(&self, x: f64) -> Vec<f64> {
        self.integral().weights_up_to(x)
    }
}

/// Integrals up to arbitrary points, with precomputed Legendre polynomials at the nodes.
#[derive(Clone, Debug)]
pub struct Integral {
    breaks: Vec<f64>,
    /// The rule between two breaks.
    rule: Gauss,
    /// Entry `[k * m + l]` is the polynomial of degree k at node l.
    at_nodes: Vec<f64>,
}

impl Integral {
    /// Weights `w_l(x) = int_0^x l_l` of the integral from 0 to `x` of the polynomial through the values at
    /// the nodes: exact for polynomials of degree m - 1. On [0, 1], `l_l(x) = w_l sum_k (2k+1) P_k(x_l)
    /// P_k(x)` and `int P_k = (P_{k+1} - P_{k-1}) / (2 (2k+1))`. With breaks, one polynomial between any two
    /// of them.
    pub fn weights_up_to(&self, x: f64) -> Vec<f64> {
        let m = self.rule.nodes.len();
        let mut weights = vec![0.0; m * (self.breaks.len() + 1)];
        self.write_weights_up_to(x, &mut weights, &mut vec![0.0; m + 1]);
        weights
    }

    /// Points inside (0, 1) between two polynomials.
    pub(crate) fn breaks(&self) -> &[f64] {
        &self.breaks
    }

    /// Chebyshev coefficients of the polynomials through the values at the nodes: for each polynomial and
    /// each degree the weights of all nodes. They are sums over the zeros of the next polynomial (Mason and
    /// Handscomb 2003, section 6.3).
    pub(crate) fn expansion(&self) -> Vec<Vec<f64>> {
        let m = self.rule.nodes.len();
        let mut rows = Vec::with_capacity(m * (self.breaks.len() + 1));
        let mut weights = vec![0.0; m * (self.breaks.len() + 1)];
        let mut polynomials = vec![0.0; m];
        for [from, to] in intervals(&self.breaks) {
            let first = rows.len();
            rows.resize(first + m, vec![0.0; weights.len()]);
            for j in 0..m {
                let angle = PI * (j as f64 + 0.5) / m as f64;
                let x = from + (to - from) * 0.5 * (1.0 + angle.cos());
                self.write_weights_at(x, &mut weights, &mut polynomials);
                for (k, row) in rows[first..].iter_mut().enumerate() {
                    let share = if k == 0 { 1.0 } else { 2.0 * (k as f64 * angle).cos() } / m as f64;
                    row.iter_mut().zip(&weights).for_each(|(sum, weight)| *sum += share * weight);
                }
            }
        }
        rows
    }

    /// Writes the weights `l_l(x)` of the interpolating polynomial at `x`, one per node, without allocation.
    /// `polynomials` is memory of one entry per node of the rule.
    pub(crate) fn write_weights_at(&self, x: f64, weights: &mut [f64], polynomials: &mut [f64]) {
        let m = self.rule.nodes.len();
        weights.fill(0.0);
        let here = self.breaks.partition_point(|&place| place <= x);
        let [from, to] = intervals(&self.breaks).nth(here).unwrap_or([0.0, 1.0]);
        let at_x = &mut polynomials[..m];
        legendre((x - from) / (to - from), at_x);
        for (l, weight) in weights[here * m..][..m].iter_mut().enumerate() {
            let sum: f64 = (0..m).map(|k| (2 * k + 1) as f64 * self.at_nodes[k * m + l] * at_x[k]).sum();
            *weight = self.rule.weights[l] * sum;
        }
    }

    /// Like [`Self::weights_up_to`], without allocation: one weight per node; `polynomials` has one entry
    /// more than the rule has nodes.
    pub(crate) fn write_weights_up_to(&self, x: f64, weights: &mut [f64], polynomials: &mut [f64]) {
        if self.breaks.is_empty() {
            return self.of_rule(x, weights, polynomials);
        }
        let parts = weights.chunks_exact_mut(self.rule.nodes.len());
        for ([from, to], part) in intervals(&self.breaks).zip(parts) {
            self.of_rule(((x - from) / (to - from)).clamp(0.0, 1.0), part, polynomials);
            part.iter_mut().for_each(|weight| *weight *= to - from);
        }
    }

    fn of_rule(&self, x: f64, sums: &mut [f64], polynomials: &mut [f64]) {
        let Gauss { nodes, weights, .. } = &self.rule;
        let m = nodes.len();
        let at_x = &mut polynomials[..m + 1];
        legendre(x, at_x);
        sums.fill(0.0);
        for k in 1..m {
            let integral = at_x[k + 1] - at_x[k - 1];
            for (sum, value) in sums.iter_mut().zip(&self.at_nodes[k * m..][..m]) {
                *sum += value * integral / 2.0;
            }
        }
        for (sum, weight) in sums.iter_mut().zip(weights) {
            *sum = weight * (x + *sum);
        }
    }
}

/// Intervals from 0 to the first break, between breaks, and from the last break to 1.
fn intervals(breaks: &[f64]) -> impl Iterator<Item = [f64; 2]> {
    let ends = breaks.iter().copied().chain([1.0]);
    [0.0].into_iter().chain(breaks.iter().copied()).zip(ends).map(|(from, to)| [from, to])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_that_are_kept_are_those_that_are_computed() {
        for m in [1, 12, KNOWN_RULES - 1, KNOWN_RULES, 1, 12] {
            let (kept, computed) = (Gauss::new(m), Gauss::computed(m));
            assert_eq!((&kept.nodes, &kept.weights), (&computed.nodes, &computed.weights));
            let up_to = kept.weights_up_to_nodes();
            for (row, &x) in up_to.chunks(m).zip(&computed.nodes) {
                assert_eq!(row, computed.weights_up_to(x));
            }
        }
        let composite = Gauss::composite(4, &[0.3]);
        let up_to = composite.weights_up_to_nodes();
        assert_eq!(up_to[..8], composite.weights_up_to(composite.nodes[0]));
    }

    #[test]
    fn composite_rules_see_kinks_and_sum_by_parts() {
        let gauss = Gauss::composite(4, &[0.3, 0.6]);
        let kinked = |x: f64| {
            if x < 0.3 {
                x
            } else if x < 0.6 {
                0.3 - 2.0 * (x - 0.3)
            } else {
                x * x
            }
        };
        let integral: f64 = gauss.nodes.iter().zip(&gauss.weights).map(|(&x, w)| w * kinked(x)).sum();
        assert!((integral - (0.045 + 0.0 + (1.0 - 0.216) / 3.0)).abs() < 1e-15);
        let up_to = gauss.weights_up_to(0.5);
        let integral: f64 = gauss.nodes.iter().zip(&up_to).map(|(&x, w)| w * kinked(x)).sum();
        assert!((integral - (0.045 + 0.06 - 0.04)).abs() < 1e-15, "{integral}");
        for i in 0..12 {
            let row = gauss.weights_up_to(gauss.nodes[i]);
            for l in 0..12 {
                let column = gauss.weights_up_to(gauss.nodes[l]);
                let sum = gauss.weights[i] * row[l] + gauss.weights[l] * column[i];
                assert!((sum - gauss.weights[i] * gauss.weights[l]).abs() < 1e-16);
            }
        }
    }

    #[test]
    fn integrates_polynomials_exactly_up_to_the_degrees_promised() {
        for m in 1..=40 {
            let gauss = Gauss::new(m);
            for degree in 0..2 * m {
                let integral: f64 =
                    gauss.nodes.iter().zip(&gauss.weights).map(|(x, w)| w * x.powi(degree as i32)).sum();
                assert!((integral - 1.0 / (degree + 1) as f64).abs() < 1e-14, "{m} nodes, degree {degree}");
            }
            for x in [0.0, 0.3, 0.99, 1.0] {
                let weights = gauss.weights_up_to(x);
                for degree in 0..m as i32 {
                    let integral: f64 =
                        gauss.nodes.iter().zip(&weights).map(|(x, w)| w * x.powi(degree)).sum();
                    let wanted = x.powi(degree + 1) / f64::from(degree + 1);
                    assert!((integral - wanted).abs() < 1e-14, "{m} nodes, degree {degree} up to {x}");
                }
            }
        }
    }

    #[test]
    fn summation_by_parts_is_exact() {
        // w_i W_il + w_l W_li = w_i w_l makes the discrete mass matrix symmetric.
        let gauss = Gauss::new(12);
        let matrix: Vec<Vec<f64>> = gauss.nodes.iter().map(|&x| gauss.weights_up_to(x)).collect();
        for i in 0..12 {
            for l in 0..12 {
                let sum = gauss.weights[i] * matrix[i][l] + gauss.weights[l] * matrix[l][i];
                assert!((sum - gauss.weights[i] * gauss.weights[l]).abs() < 1e-16);
            }
        }
    }
}
