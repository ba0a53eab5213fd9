//! Explicit embedded Runge-Kutta pairs as data.

use super::dense::Form;
use super::dormand_prince_5::DORMAND_PRINCE_5;
use super::dormand_prince_8::DORMAND_PRINCE_8;
use super::options::Method;

/// The nonzero entries of a row of a tableau: (stage, coefficient).
pub(super) type Row = &'static [(usize, f64)];

/// An explicit Runge-Kutta method with embedded error estimates and a continuous extension, in the notation of
/// Hairer, Norsett and Wanner (1993), section II.4. Stage 0 is `f(t, y)`; the stage after the last row of `a` is
/// `f(t + h, y_new)`, which the next step uses again.
#[derive(Debug)]
pub(super) struct Pair {
    /// `c[i]`: stage i is evaluated at `t + c[i] h`.
    pub(super) c: &'static [f64],
    /// Rows of the matrix A, the one of stage 0 (empty) included.
    pub(super) a: &'static [Row],
    /// Weights of the solution.
    pub(super) b: Row,
    /// Error estimates.
    pub(super) error: ErrorEstimate,
    /// The local error estimate is `O(h^(error_order + 1))`.
    pub(super) error_order: f64,
    /// Continuous extension.
    pub(super) extension: Extension,
    /// `|h lambda|` beyond this means that stability, not accuracy, limits the step (Hairer and Wanner 1996,
    /// section IV.2, and the codes DOPRI5 and DOP853).
    pub(super) stability_limit: f64,
}

/// The tableau of an explicit method, in the notation of Hairer, Norsett and Wanner (1993), section II.1.
#[derive(Clone, Debug, PartialEq)]
pub struct Tableau {
    /// Coefficients of the stages, s rows of s.
    pub a: Vec<Vec<f64>>,
    /// Weights of the stages, s.
    pub b: Vec<f64>,
    /// Times of the stages, s.
    pub c: Vec<f64>,
}

/// The pair of an explicit method; `None` for an implicit one.
pub(super) fn pair(method: Method) -> Option<&'static Pair> {
    match method {
        Method::Rk45 => Some(&DORMAND_PRINCE_5),
        Method::Dop853 => Some(&DORMAND_PRINCE_8),
        Method::Radau => None,
    }
}

/// Largest stable `|h lambda|` of an explicit method, roughly; `None` for an implicit one.
pub(crate) fn stability_limit(method: Method) -> Option<f64> {
    pair(method).map(|pair| pair.stability_limit)
}

/// The tableau of an explicit method; `None` for an implicit one.
pub fn tableau(method: Method) -> Option<Tableau> {
    let pair = pair(method)?;
    let dense = |row: Row| {
        let mut values = vec![0.0; pair.stages()];
        row.iter().for_each(|&(stage, weight)| values[stage] = weight);
        values
    };
    Some(Tableau { a: pair.a.iter().map(|row| dense(row)).collect(), b: dense(pair.b), c: pair.c.to_vec() })
}

/// Weights of the error estimate, over the stages with `f(t + h, y_new)` included.
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

/// The polynomial through a step.
#[derive(Debug)]
pub(super) enum Extension {
    /// `y(t + x h) = y + h sum_j x^(j+1) sum_i p[j][i] k_i`.
    Monomial(&'static [Row]),
    /// The extension of DOP853: extra stages, then coefficients of a nested form whose first three follow from the
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
    /// Number of stages that a step evaluates, `f(t + h, y_new)` not counted.
    pub(super) fn stages(&self) -> usize {
        self.a.len()
    }

    /// Number of stages to keep: those of the step, the first of the next, and those of the extension.
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

    /// The form of the polynomial.
    pub(super) fn form(&self) -> Form {
        match self {
            Self::Monomial(rows) => Form::Monomial { degree: rows.len() },
            Self::Nested { d, .. } => Form::Nested { terms: 3 + d.len() },
        }
    }
}

/// How many components are combined at a time, so that the compiler keeps their sums in vector registers.
const LANES: usize = 4;

/// `out[i] <- finish(i, sum_j weight_j stages[j][i])` with `n = out.len()` components a stage.
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
