//! Options and their validation.

use crate::error::InvalidInput;
use crate::integrators::ode;
use crate::integrators::ode::{Tolerance, Tolerances};
use crate::integrators::second_order::check_start;

/// Options of an integration.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Relative tolerance, one for all numbers, or one for each of the n displacements followed by the n
    /// velocities. The root mean square over all 2n numbers y of the local error relative to
    /// `atol + rtol |y|` is kept below one. Default: 1e-6; values below 100 rounding units are raised to
    /// that.
    pub rtol: Tolerance,
    /// Absolute tolerance, in the same form. Default: 1e-9.
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
}

impl From<ode::Options> for Options {
    /// The same tolerances and bounds of steps.
    fn from(options: ode::Options) -> Self {
        let ode::Options { rtol, atol, first_step, max_step, min_step, max_steps, .. } = options;
        Self { rtol, atol, first_step, max_step, min_step, max_steps }
    }
}

impl Default for Options {
    fn default() -> Self {
        Self {
            rtol: 1e-6.into(),
            atol: 1e-9.into(),
            first_step: None,
            max_step: f64::INFINITY,
            min_step: 0.0,
            max_steps: usize::MAX,
        }
    }
}

impl Options {
    /// Checks the options for a problem; returns the tolerances of the 2n numbers.
    pub(super) fn check(
        &self,
        n: usize,
        t_span: (f64, f64),
        q0: &[f64],
        v0: &[f64],
    ) -> Result<Tolerances, InvalidInput> {
        let (t0, t_end) = t_span;
        let any_step = if t_end > t0 { t_end - t0 } else { 1.0 };
        check_start(n, t_span, q0, v0, any_step)?;
        let options = ode::Options {
            method: ode::Method::Radau,
            rtol: self.rtol.clone(),
            atol: self.atol.clone(),
            first_step: self.first_step,
            max_step: self.max_step,
            min_step: self.min_step,
            max_steps: self.max_steps,
            ..ode::Options::default()
        };
        options.check(2 * n, t_span, &[q0, v0].concat())
    }
}
