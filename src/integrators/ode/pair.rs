//! Explicit embedded Runge-Kutta pairs as data.

use super::dense::Form;

/// Nonzero entries of a row of a tableau: (stage, coefficient).
pub(super) type Row = &'static [(usize, f64)];

/// An explicit Runge-Kutta method with embedded error estimates and a continuous extension, in the notation
/// of Hairer, Norsett and Wanner (1993), section II.4. Stage 0 is `f(t, y)`; the stage after the last row of
/// `a` is `f(t + h, y_new)`, which the next step reuses.
#[derive(Debug)]
pub(super) struct Pair {
    /// `c[i]`: stage i is evaluated at `t + c[i] h`.
    pub(super) c: &'static [f64],
    /// Rows of the matrix A, including the empty row of stage 0.
    pub(super) a: &'static [Row],
    /// Weights of the solution.
    pub(super) b: Row,
    /// Error estimates.
    pub(super) error: ErrorEstimate,
    /// The local error estimate is `O(h^(error_order + 1))`.
    pub(super) error_order: f64,
    /// Continuous extension.
    pub(super) extension: Extension,
    /// If `|h lambda|` exceeds this, stability rather than accuracy limits the step (Hairer and Wanner 1996,
    /// section IV.2, and the codes DOPRI5 and DOP853).
    pub(super) stability_limit: f64,
}

/// Weights of the error estimate over all stages, including `f(t + h, y_new)`.
#[derive(Debug)]
pub(super) enum ErrorEstimate {
    /// The embedded solution minus the solution.
    Difference(Row),
    /// Two differences, of orders 5 and 3, combined into `|e5|^2 / sqrt(|e5|^2 + 0.01 |e3|^2)` (Hairer, Norsett
    /// and Wanner 1993, eq. II.10.17).
    Combined {
        /// Fifth order.
        fifth: Row,
        /// Third order.
        third: Row,
    },
}

/// Continuous extension of a step.
#[derive(Debug)]
pub(super) enum Extension {
    /// `y(t + x h) = y + h sum_j x^(j+1) sum_i p[j][i] k_i`.
    Monomial(&'static [Row]),
    /// Extension of DOP853: extra stages, then coefficients of a nested form; the first three follow from the
    /// ends of the step.
    Nested {
        /// Times of the extra stages.
        c: &'static [f64],
        /// Rows of the extra stages.
        a: &'static [Row],
        /// Coefficients after the third.
        d: &'static [Row],
    },
}

impl Pair {
    /// Number of stages per step, without `f(t + h, y_new)`.
    pub(super) fn stages(&self) -> usize {
        self.a.len()
    }

    /// Number of stages to store: those of the step, the first of the next step, and those of the extension.
    pub(super) fn kept_stages(&self) -> usize {
        self.stages() + 1 + self.extension.extra_stages()
    }
}

impl Extension {
    fn extra_stages(&self) -> usize {
        match self {
            Self::Monomial(_) => 0,
            Self::Nested { a, .. } => a.len(),
        }
    }

    /// Form of the polynomial.
    pub(super) fn form(&self) -> Form {
        match self {
            Self::Monomial(rows) => Form::Monomial { degree: rows.len() },
            Self::Nested { d, .. } => Form::Nested { terms: 3 + d.len() },
        }
    }
}

/// Number of components combined at a time, so that the compiler keeps their sums in vector registers.
const LANES: usize = 4;

/// `out[i] <- finish(i, sum_j weight_j stages[j][i])` for stages of `n = out.len()` components.
#[inline(always)]
pub(super) fn combine(
    stages: &[f64],
    row: &[(usize, f64)],
    out: &mut [f64],
    finish: impl Fn(usize, f64) -> f64,
) {
    let n = out.len();
    let (blocks, rest) = out.as_chunks_mut::<LANES>();
    for (index, block) in blocks.iter_mut().enumerate() {
        let start = index * LANES;
        let mut sums = [0.0; LANES];
        for &(stage, weight) in row {
            let k = &stages[stage * n + start..][..LANES];
            for lane in 0..LANES {
                sums[lane] += weight * k[lane];
            }
        }
        for lane in 0..LANES {
            block[lane] = finish(start + lane, sums[lane]);
        }
    }
    let start = n - rest.len();
    for (lane, value) in rest.iter_mut().enumerate() {
        let i = start + lane;
        *value = finish(i, row.iter().map(|&(stage, weight)| weight * stages[stage * n + i]).sum());
    }
}
