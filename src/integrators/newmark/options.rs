//! Options and their validation.

use super::Scheme;
use crate::description::schema::Described;
use crate::error::{Checker, InvalidInput, Number};
use crate::integrators::ode::Tolerance;
use crate::integrators::second_order::check_problem;
use crate::model::Facts;
use crate::numerics::roots::Derivative;

/// Initial guess of the accelerations of a step, before the first Newton iteration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Described)]
pub enum Predictor {
    /// Zero, the last accelerations, or an extrapolation of the last two: whichever would have been best for
    /// the last step.
    #[default]
    Best,
    /// Accelerations of the last step.
    Last,
    /// Zero, as in the lab.
    Zero,
}

/// Treatment of impacts that are shorter than steps of fixed size.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Described)]
pub enum Impacts {
    /// Resolved in robots of rigid parts. In those with rods followed in parts of the step, where these are few and contacts give back much
    /// energy, and stopped otherwise.
    #[default]
    Auto,
    /// Stopped: bodies that collide within a step do not rebound.
    Stopped,
    /// Resolved: simulations repeat the steps in which bodies rebound, by Radau's method.
    Resolved,
}

impl Impacts {
    /// Whether impacts of a model with these facts are resolved. Repeated steps do not support inextensible tendons.
    pub(crate) fn are_resolved(self, facts: &Facts) -> bool {
        let asks = match self {
            // Fixed steps do not resolve the waves that a rebound excites in rods, and would gain energy.
            Self::Auto => !facts.has_rods_in_contact && !facts.is_discretised,
            Self::Stopped => false,
            Self::Resolved => true,
        };
        asks && facts.has_contact && !facts.is_one_sided
    }

    /// Whether impacts of such a model are followed in parts of steps of fixed size.
    pub(crate) fn are_followed(self, facts: &Facts) -> bool {
        self == Self::Auto && !self.are_resolved(facts) && facts.has_contact && !facts.is_one_sided
    }
}

/// Step-size selection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepSize {
    /// Always `dt`; the last step is shorter if the interval is not a multiple of it.
    Fixed,
    /// By the error estimate of Zienkiewicz and Xie (1991), with initial step `dt`.
    Adaptive {
        /// Largest step size; may be infinite.
        max_step: f64,
        /// Smallest step size (ten spacings of floating-point numbers at t always count). The last step may be shorter.
        min_step: f64,
    },
}

impl StepSize {
    /// Adaptive steps within these bounds, by default any, or fixed ones, which take no bounds.
    ///
    /// # Errors
    /// Bounds of fixed steps.
    pub fn new(adaptive: bool, max_step: Option<f64>, min_step: f64) -> Result<Self, InvalidInput> {
        if adaptive {
            return Ok(Self::Adaptive { max_step: max_step.unwrap_or(f64::INFINITY), min_step });
        }
        let given =
            [("max_step", max_step), ("min_step", Some(min_step).filter(|&min_step| min_step != 0.0))];
        match given.into_iter().find_map(|(name, value)| Some((name, value?))) {
            None => Ok(Self::Fixed),
            Some((name, value)) => Err(InvalidInput::new(
                name,
                Number(value),
                "nothing: it is for adaptive steps (adaptive=True)",
            )),
        }
    }
}

/// Relative and absolute tolerance by default, the latter of local errors alone.
pub(crate) const RTOL: f64 = 1e-6;
pub(crate) const ATOL: f64 = 1e-9;

/// Without an `atol`, accelerations near zero are solved to this part of the sizes of coordinates over the square of the usual step, or of
/// a longer adaptive one, in any units: what is left moves coordinates by a few spacings of floating-point numbers. In steps of 10 ms of
/// a robot of one metre it is 6e-10. Runs of 25 models in steps of 0.1 to 10 ms take nearly the same iterations with 16 to 1024 spacings,
/// and up to six times as many with zero, where a coordinate is zero but for rounding.
pub(super) const UNRESOLVED_MOTION: f64 = 256.0 * f64::EPSILON;

/// Options of an integration.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Member of the Newmark family. Default: [`Scheme::AVERAGE_ACCELERATION`].
    pub scheme: Scheme,
    /// Step size, or initial step size.
    pub dt: f64,
    /// Step-size selection. Default: fixed.
    pub step_size: StepSize,
    /// Source of the Jacobian of a step. Default: [`Derivative::Analytic`].
    pub derivative: Derivative,
    /// Relative tolerance. Default: 1e-6. The Newton iteration of a step ends when the estimated remaining
    /// error of the accelerations, relative to `atol[i] + rtol[i] |a[i]|`, is below one in the root mean
    /// square over the coordinates. With adaptive steps the local errors of displacements and velocities,
    /// relative to `atol[i] + rtol[i] |q[i]|` and `atol[i] + rtol[i] |v[i]|`, are controlled in the same way.
    pub rtol: Tolerance,
    /// Absolute tolerance, in units of q, of q per time and of q per time squared. `None`, the default, is independent of units in fixed
    /// steps: accelerations near zero have errors that move coordinates by rounding alone, a few spacings of their
    /// [typical sizes](Facts::typical_coordinates) in a step; without inertia, coordinates have errors of 1e-9 of these sizes. Local
    /// errors of adaptive steps are then controlled with 1e-9.
    pub atol: Option<Tolerance>,
    /// Initial guess of the accelerations. Default: [`Predictor::Best`].
    pub predictor: Predictor,
    /// Whether a factorised Jacobian is kept from step to step while Newton's method converges with it.
    /// Default: true.
    pub reuse_jacobian: bool,
    /// Treatment of impacts in steps of fixed size. Default: [`Impacts::Auto`].
    pub impacts: Impacts,
    /// Accelerations at the start; `None` solves for them.
    pub initial_acceleration: Option<Vec<f64>>,
    /// Maximum number of accepted steps. Default: no limit.
    pub max_steps: usize,
}

/// Smallest relative tolerance: the Newton iteration cannot do better than a few rounding units.
const SMALLEST_RTOL: f64 = 10.0 * f64::EPSILON;

impl Options {
    /// Defaults for steps of size `dt`.
    pub fn new(dt: f64) -> Self {
        Self {
            scheme: Scheme::AVERAGE_ACCELERATION,
            dt,
            step_size: StepSize::Fixed,
            derivative: Derivative::Analytic,
            rtol: RTOL.into(),
            atol: None,
            predictor: Predictor::default(),
            reuse_jacobian: true,
            impacts: Impacts::default(),
            initial_acceleration: None,
            max_steps: usize::MAX,
        }
    }

    /// Checks the options together with the problem that they are for; returns rtol and a given atol of each coordinate.
    pub(super) fn check(
        &self,
        n: usize,
        (t0, t_end): (f64, f64),
        q0: &[f64],
        v0: &[f64],
    ) -> Result<(Vec<f64>, Option<Vec<f64>>), InvalidInput> {
        let mut checker = Checker::new();
        check_problem(n, (t0, t_end), q0, v0, self.dt, &mut checker);
        if let Some(a0) = &self.initial_acceleration {
            checker.length(a0, n, "a0");
            checker.finite(a0, "a0");
        }
        let mut rtol = self.rtol.expand(n, "rtol", &mut checker);
        let atol = self.atol.as_ref().map(|atol| atol.expand(n, "atol", &mut checker));
        rtol.iter_mut().for_each(|rtol| *rtol = rtol.max(SMALLEST_RTOL));
        if let StepSize::Adaptive { max_step, min_step } = self.step_size {
            checker.require(max_step > 0.0, "max_step", Number(max_step), "a number > 0");
            checker.non_negative(min_step, "min_step", "of the time");
            let ordered = min_step <= max_step || min_step.is_nan() || max_step.is_nan();
            let expected = format!("at most max_step = {}", Number(max_step));
            checker.require(ordered, "min_step", Number(min_step), &expected);
            self.scheme.check_error_estimate(&mut checker);
        }
        checker.finish()?;
        Ok((rtol, atol))
    }
}
