//! Dense output: the solution between steps, as one polynomial per step.

use crate::error::{Checker, InvalidInput};

/// Form of a method's polynomials. The polynomial of a step is stored as `y_old` followed by coefficient
/// vectors of n numbers each; x runs from 0 to 1 over the step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    /// `y_old + x (c1 + x (c2 + ...))`.
    Monomial {
        /// Number of coefficient vectors.
        degree: usize,
    },
    /// `y_old + x (F0 + (1 - x) (F1 + x (F2 + (1 - x) (...))))` (Hairer, Norsett and Wanner 1993, section II.6).
    Nested {
        /// Number of coefficient vectors.
        terms: usize,
    },
}

impl Form {
    /// Coefficient vectors of a step, `y_old` included.
    pub(super) fn vectors(self) -> usize {
        1 + match self {
            Self::Monomial { degree } => degree,
            Self::Nested { terms } => terms,
        }
    }

    /// The polynomial at each of these x, one after another: components from `first` on, as many as fit in `y`.
    fn evaluate(self, coefficients: &[f64], xs: &[f64], first: usize, y: &mut [f64]) {
        if y.is_empty() {
            return;
        }
        let nested = |k: usize, x: f64| if k.is_multiple_of(2) { 1.0 - x } else { x };
        match self {
            // The degrees of the explicit pairs, with unrolled sums.
            Self::Monomial { degree: 4 } => sums::<5>(|_, x| x, coefficients, xs, first, y),
            Self::Nested { terms: 7 } => sums::<8>(nested, coefficients, xs, first, y),
            Self::Monomial { degree } => sums_of(1 + degree, |_, x| x, coefficients, xs, first, y),
            Self::Nested { terms } => sums_of(1 + terms, nested, coefficients, xs, first, y),
        }
    }
}

/// Sums from the innermost of these vectors to the outermost, times a factor each.
fn sums_of(
    vectors: usize,
    factor: impl Fn(usize, f64) -> f64,
    coefficients: &[f64],
    xs: &[f64],
    first: usize,
    y: &mut [f64],
) {
    let (all, n) = (coefficients.len() / vectors, y.len() / xs.len());
    for (row, &x) in y.chunks_exact_mut(n).zip(xs) {
        for (i, y) in row.iter_mut().enumerate() {
            let inner = (1..vectors)
                .rev()
                .fold(0.0, |sum, k| (sum + coefficients[k * all + first + i]) * factor(k, x));
            *y = coefficients[first + i] + inner;
        }
    }
}

/// [`sums_of`] a number of vectors known at compile time.
fn sums<const VECTORS: usize>(
    factor: impl Fn(usize, f64) -> f64,
    coefficients: &[f64],
    xs: &[f64],
    first: usize,
    y: &mut [f64],
) {
    let (all, n) = (coefficients.len() / VECTORS, y.len() / xs.len());
    for i in 0..n {
        let of_component: [f64; VECTORS] = std::array::from_fn(|k| coefficients[k * all + first + i]);
        for (row, &x) in y.chunks_exact_mut(n).zip(xs) {
            let inner = (1..VECTORS).rev().fold(0.0, |sum, k| (sum + of_component[k]) * factor(k, x));
            row[i] = of_component[0] + inner;
        }
    }
}

/// The solution over one step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StepPolynomial<'a> {
    pub(super) form: Form,
    pub(super) coefficients: &'a [f64],
    pub(super) t_old: f64,
    pub(super) t: f64,
}

/// Number of times at which a polynomial is evaluated together, so that its coefficients are read once; their x fit on the stack.
const TIMES_AT_ONCE: usize = 64;

impl StepPolynomial<'_> {
    /// `y <- y(t)`.
    pub(super) fn evaluate(&self, t: f64, y: &mut [f64]) {
        self.form.evaluate(self.coefficients, &[self.x(t)], 0, y);
    }

    /// The solution at these times, one after another: the first half of the components and the second.
    pub(crate) fn evaluate_halves(&self, times: &[f64], [first, second]: [&mut [f64]; 2]) {
        let n = first.len() / times.len().max(1);
        let halves =
            first.chunks_mut((n * TIMES_AT_ONCE).max(1)).zip(second.chunks_mut((n * TIMES_AT_ONCE).max(1)));
        for (times, (first, second)) in times.chunks(TIMES_AT_ONCE).zip(halves) {
            let mut xs = [0.0; TIMES_AT_ONCE];
            for (x, &t) in xs.iter_mut().zip(times) {
                *x = self.x(t);
            }
            let xs = &xs[..times.len()];
            self.form.evaluate(self.coefficients, xs, 0, first);
            self.form.evaluate(self.coefficients, xs, n, second);
        }
    }

    /// Position of a time in the step, from 0 to 1.
    fn x(&self, t: f64) -> f64 {
        if self.t == self.t_old { 0.0 } else { (t - self.t_old) / (self.t - self.t_old) }
    }
}

/// The data of a [`DenseOutput`], for serialisation.
#[derive(Clone, Copy, Debug)]
pub struct DenseParts<'a> {
    /// Whether the polynomials are nested in x and 1 - x, or sums of powers of x.
    pub is_nested: bool,
    /// Number of coefficient vectors per polynomial.
    pub vectors: usize,
    /// Number of components.
    pub n: usize,
    /// Times at the ends of the polynomials.
    pub times: &'a [f64],
    /// End of the last polynomial's step.
    pub last_step_end: f64,
    /// Coefficients of all polynomials in order.
    pub coefficients: &'a [f64],
}

/// The solution as a function of time: a piecewise polynomial over the steps of an integration.
#[derive(Clone, Debug)]
pub struct DenseOutput {
    form: Form,
    n: usize,
    times: Vec<f64>,
    // Time at which x of the last polynomial is 1; later than the last time if an event ended the integration
    // within a step.
    last_step_end: f64,
    coefficients: Vec<f64>,
}

impl DenseOutput {
    pub(super) fn new(form: Form, n: usize, t0: f64) -> Self {
        Self { form, n, times: vec![t0], last_step_end: t0, coefficients: Vec::new() }
    }

    /// Adds the polynomial of a step that starts at the last time, valid up to `t`.
    pub(super) fn push(&mut self, t: f64, step: StepPolynomial<'_>) {
        debug_assert_eq!(step.t_old, self.times[self.times.len() - 1]);
        self.times.push(t);
        self.last_step_end = step.t;
        self.coefficients.extend_from_slice(step.coefficients);
    }

    /// Number of components.
    pub fn n(&self) -> usize {
        self.n
    }

    /// Times at the ends of the polynomials, in the order of the integration: one more than there are
    /// polynomials.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Data for serialisation.
    pub fn parts(&self) -> DenseParts<'_> {
        let Self { form, n, times, last_step_end, coefficients } = self;
        let is_nested = matches!(form, Form::Nested { .. });
        let vectors = form.vectors();
        DenseParts { is_nested, vectors, n: *n, times, last_step_end: *last_step_end, coefficients }
    }

    /// Restores a dense output from its data.
    pub fn from_parts(parts: DenseParts<'_>) -> Result<Self, InvalidInput> {
        let DenseParts { is_nested, vectors, n, times, last_step_end, coefficients } = parts;
        let mut check = Checker::new();
        check.require(vectors >= 1, "vectors", vectors, "at least one");
        check.require(times.len() >= 2, "times", format_args!("{} times", times.len()), "at least two");
        let numbers = times.len().saturating_sub(1).checked_mul(vectors).and_then(|rows| rows.checked_mul(n));
        check.require(
            numbers == Some(coefficients.len()),
            "coefficients",
            format_args!("{} numbers", coefficients.len()),
            "a polynomial for each step",
        );
        check.finish()?;
        let terms = vectors - 1;
        let form = if is_nested { Form::Nested { terms } } else { Form::Monomial { degree: terms } };
        Ok(Self { form, n, times: times.to_vec(), last_step_end, coefficients: coefficients.to_vec() })
    }

    /// `y <- y(t)`. At a time between two steps the earlier step is used. Before the first and after the last
    /// step their polynomials are extrapolated, without any guarantee of accuracy.
    ///
    /// # Panics
    /// If there is no step, or if `y` does not have `n` entries.
    pub fn evaluate(&self, t: f64, y: &mut [f64]) {
        let steps = self.times.len() - 1;
        let forward = self.times[steps] >= self.times[0];
        let before = |&end: &f64| if forward { end < t } else { end > t };
        let step = self.times[1..steps].partition_point(before);
        let t_old = self.times[step];
        let t_new = if step + 1 == steps { self.last_step_end } else { self.times[step + 1] };
        let size = self.form.vectors() * self.n;
        let coefficients = &self.coefficients[step * size..(step + 1) * size];
        StepPolynomial { form: self.form, coefficients, t_old, t: t_new }.evaluate(t, y);
    }
}
