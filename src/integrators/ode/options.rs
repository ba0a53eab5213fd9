//! Options and their validation.

use super::differences::Sparsity;
use crate::error::{Checker, InvalidInput, Number};

/// Integration method.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// Explicit pair 5(4) of Dormand and Prince (1980); dense output of order 4 (Shampine 1986).
    #[default]
    Rk45,
    /// Explicit method of order 8 with error estimates of orders 5 and 3 (Dormand and Prince; Hairer, Norsett and
    /// Wanner 1993); dense output of order 7. For tight tolerances.
    Dop853,
    /// Implicit Radau IIA method of order 5 (Hairer and Wanner 1996, section IV.8), L-stable; dense output of order 3.
    /// For stiff problems. Solves dense linear systems of n real and n complex equations.
    Radau,
}

/// Step-size control: how the next step size follows from error estimates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Controller {
    /// From the last error alone (the elementary controller, Hairer, Norsett and Wanner 1993, eq. II.4.13).
    #[default]
    Integral,
    /// From the last two errors (Gustafsson 1991): smoother step sizes, fewer rejections where stability limits
    /// the step.
    ProportionalIntegral,
}

/// A tolerance for all components, or one for each.
#[derive(Clone, Debug, PartialEq)]
pub enum Tolerance {
    /// The same for all components.
    Same(f64),
    /// One for each component.
    Each(Vec<f64>),
}

impl From<f64> for Tolerance {
    fn from(value: f64) -> Self {
        Self::Same(value)
    }
}

impl From<Vec<f64>> for Tolerance {
    fn from(values: Vec<f64>) -> Self {
        Self::Each(values)
    }
}

impl Tolerance {
    /// One value for each of `n` components.
    pub(crate) fn expand(&self, n: usize, place: &str, checker: &mut Checker) -> Vec<f64> {
        let values = match self {
            Self::Same(value) => vec![*value; n],
            Self::Each(values) => values.clone(),
        };
        checker.length(&values, n, place);
        // A bad common value gives one message, not n.
        let distinct = if matches!(self, Self::Same(_)) { n.min(1) } else { values.len() };
        for (i, &value) in values[..distinct].iter().enumerate() {
            let place =
                if matches!(self, Self::Same(_)) { place.to_owned() } else { format!("{place}[{i}]") };
            checker.non_negative(value, &place, "of the components of y");
        }
        values
    }
}

/// Options of an integration. The defaults are those of SciPy's `solve_ivp`.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Integration method. Default: [`Method::Rk45`].
    pub method: Method,
    /// Relative tolerance (default 1e-3): the root mean square over the components of the local error
    /// relative to `atol[i] + rtol[i] |y[i]|` is kept below one. Values below 100 rounding units are raised
    /// to that.
    pub rtol: Tolerance,
    /// Absolute tolerance (default 1e-6), in the units of y.
    pub atol: Tolerance,
    /// Size of the first step; `None` chooses it automatically.
    pub first_step: Option<f64>,
    /// Largest step size. Default: infinite.
    pub max_step: f64,
    /// Smallest step size. Default: 0; ten spacings of floating-point numbers at t always apply. The last
    /// step may be shorter.
    pub min_step: f64,
    /// Maximum number of accepted steps. Default: no limit.
    pub max_steps: usize,
    /// Step-size control of the explicit methods. Default: [`Controller::Integral`]. Radau always uses the
    /// predictive controller of Gustafsson (1994).
    pub controller: Controller,
    /// Sparsity pattern of the Jacobian, which reduces the evaluations of a Jacobian by differences. Default:
    /// dense.
    pub sparsity: Option<Sparsity>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            method: Method::default(),
            rtol: 1e-3.into(),
            atol: 1e-6.into(),
            first_step: None,
            max_step: f64::INFINITY,
            min_step: 0.0,
            max_steps: usize::MAX,
            controller: Controller::default(),
            sparsity: None,
        }
    }
}

/// Output that [`super::solve`] collects.
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// Output times, in the order of the integration; `None`: every accepted step.
    pub t_eval: Option<Vec<f64>>,
    /// Whether to keep the interpolants of all steps.
    pub dense: bool,
    /// Number of parts into which a step is divided to search for events; 1 checks its ends only.
    pub event_samples: usize,
}

/// Ten parts per step, as in DifferentialEquations.jl.
const EVENT_SAMPLES: usize = 10;

impl Default for Output {
    fn default() -> Self {
        Self { t_eval: None, dense: false, event_samples: EVENT_SAMPLES }
    }
}

impl Output {
    /// The solution at given times.
    pub fn at(times: impl Into<Vec<f64>>) -> Self {
        Self { t_eval: Some(times.into()), ..Self::default() }
    }

    pub(super) fn check(&self, (t0, t_end): (f64, f64)) -> Result<(), InvalidInput> {
        let mut checker = Checker::new();
        checker.require(self.event_samples > 0, "event_samples", self.event_samples, "a whole number > 0");
        let times = self.t_eval.as_deref().unwrap_or_default();
        let (low, high) = (t0.min(t_end), t0.max(t_end));
        let is_inside = |t: &f64| (low..=high).contains(t);
        if let Some(i) = times.iter().position(|t| !is_inside(t)) {
            let inside = format!("a time within t_span, between {} and {}", Number(low), Number(high));
            checker.require(false, &format!("t_eval[{i}]"), Number(times[i]), &inside);
        }
        let direction = if t_end < t0 { -1.0 } else { 1.0 };
        if let Some(i) = times.windows(2).position(|pair| direction * (pair[1] - pair[0]) <= 0.0) {
            let order = if direction > 0.0 { "larger" } else { "smaller" };
            let expected = format!("a time {order} than t_eval[{i}] = {}", Number(times[i]));
            checker.require(false, &format!("t_eval[{}]", i + 1), Number(times[i + 1]), &expected);
        }
        checker.finish()
    }
}

/// Tolerances below this number of rounding units exceed the accuracy of the arithmetic (SciPy's limit).
const SMALLEST_RTOL_IN_ROUNDING_UNITS: f64 = 100.0;

/// Validated tolerances for each component.
#[derive(Clone, Debug)]
pub(crate) struct Tolerances {
    pub(crate) rtol: Vec<f64>,
    pub(crate) atol: Vec<f64>,
    /// Whether an rtol below the accuracy of the arithmetic was raised.
    pub(super) rtol_raised: bool,
}

impl Options {
    /// Checks the options together with the problem.
    pub(crate) fn check(
        &self,
        n: usize,
        (t0, t_end): (f64, f64),
        y0: &[f64],
    ) -> Result<Tolerances, InvalidInput> {
        let mut checker = Checker::new();
        checker.require(t0.is_finite(), "t_span[0]", t0, "a finite number");
        checker.require(!t_end.is_nan(), "t_span[1]", t_end, "a number");
        checker.length(y0, n, "y0");
        if let Some(i) = y0.iter().position(|y| !y.is_finite()) {
            let expected = "a finite number: All components of the initial state `y0` must be finite.";
            checker.require(false, &format!("y0[{i}]"), y0[i], expected);
        }
        let mut rtol = self.rtol.expand(n, "rtol", &mut checker);
        let atol = self.atol.expand(n, "atol", &mut checker);
        if let Some(first_step) = self.first_step
            && checker.positive(first_step, "first_step", "in units of time")
        {
            let length = (t_end - t0).abs();
            let expected = format!("at most the length of t_span, {}", Number(length));
            checker.require(
                first_step <= length || length.is_nan(),
                "first_step",
                Number(first_step),
                &expected,
            );
        }
        checker.require(self.max_step > 0.0, "max_step", Number(self.max_step), "a number > 0");
        checker.non_negative(self.min_step, "min_step", "in units of time");
        if self.max_step > 0.0 && self.min_step > self.max_step {
            let expected = format!("at most max_step, {}", Number(self.max_step));
            checker.require(false, "min_step", Number(self.min_step), &expected);
        }
        if let Some(sparsity) = &self.sparsity {
            let expected = format!("one of {n} equations");
            let found = format!("one of {} equations", sparsity.n());
            checker.require(sparsity.n() == n, "jac_sparsity", found, &expected);
        }
        checker.finish()?;
        let smallest = SMALLEST_RTOL_IN_ROUNDING_UNITS * f64::EPSILON;
        let rtol_raised = rtol.iter().any(|&value| value < smallest);
        rtol.iter_mut().for_each(|value| *value = value.max(smallest));
        Ok(Tolerances { rtol, atol, rtol_raised })
    }
}
