//! Integration methods and their options.

use crate::description::signal::covers;
use crate::error::{Checker, InvalidInput, Number};
use crate::integrators::newmark;
use crate::integrators::ode;
use crate::integrators::radau;
use crate::model::Facts;

/// Integration method of a motion, with its options.
#[derive(Clone, Debug, PartialEq)]
pub enum Method {
    /// A member of the Newmark family, with inverse dynamics and their tangent.
    Newmark(newmark::Options),
    /// Radau IIA of order 5, with inverse dynamics and their tangent.
    Radau {
        /// Options; the tolerances are those of displacements and velocities.
        options: radau::Options,
        /// Interval of the output times if none are given.
        dt: f64,
        /// Whether results contain all accepted steps instead.
        returns_steps: bool,
    },
    /// A first-order method, with forward dynamics.
    FirstOrder {
        /// Options; the tolerances are those of displacements and velocities.
        options: ode::Options,
        /// Interval of the output times if none are given.
        dt: f64,
        /// Whether results contain all accepted steps instead.
        returns_steps: bool,
    },
}

impl Method {
    /// Size of fixed steps, or interval of output times.
    pub(crate) fn dt(&self) -> f64 {
        match self {
            Self::Newmark(options) => options.dt,
            Self::Radau { dt, .. } | Self::FirstOrder { dt, .. } => *dt,
        }
    }

    /// Whether results contain all steps if no times are given.
    pub(crate) fn returns_steps(&self) -> bool {
        match self {
            Self::Newmark(_) => true,
            Self::Radau { returns_steps, .. } | Self::FirstOrder { returns_steps, .. } => *returns_steps,
        }
    }

    /// Size of fixed steps; `None` for adaptive methods.
    pub(crate) fn fixed_step(&self) -> Option<f64> {
        match self {
            Self::Newmark(options) if options.step_size == newmark::StepSize::Fixed => Some(options.dt),
            _ => None,
        }
    }

    /// Whether accelerations act.
    pub(crate) fn has_inertia(&self) -> bool {
        !matches!(self, Self::Newmark(options) if !options.scheme.has_inertia())
    }

    /// Whether steps of fixed size are repeated if an impact of a model with these facts is not resolved.
    pub(crate) fn resolves_impacts(&self, facts: &Facts) -> bool {
        self.fixed_step().is_some()
            && matches!(self, Self::Newmark(options) if options.impacts.are_resolved(facts))
    }
}

/// Fixed steps must resolve oscillations: steps longer than half a period alias them to lower frequencies
/// (Nyquist).
pub(crate) fn check_step(dt: f64, shortest_period: f64) -> Result<(), InvalidInput> {
    let mut check = Checker::new();
    check.require(
        dt < 0.5 * shortest_period,
        "dt",
        format_args!(
            "{} s for a load or a base motion with a period of {} s",
            Number(dt),
            Number(shortest_period)
        ),
        "less than half a period (a twentieth follows it)",
    );
    check.finish()
}

/// A motion must end within the interval on which the model is defined.
pub(crate) fn check_span(known: [f64; 2], (t0, t_end): (f64, f64)) -> Result<(), InvalidInput> {
    let starts = covers(known, t0);
    if !starts || !covers(known, t_end) {
        let [from, to] = known;
        let expected = format!("a run within [{from}, {to}] (seconds), where all prescribed motion is known");
        let place = if starts { "t_span[1]" } else { "t_span[0]" };
        return Err(InvalidInput::new(place, format_args!("a run from {t0} to {t_end}"), expected));
    }
    Ok(())
}
