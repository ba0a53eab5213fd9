//! Checks of a run beyond those of its method.

use crate::analysis::spectrum::Spectrum;
use crate::analysis::unresolved_vibrations::UnresolvedVibrations;
use crate::integrators::ode;
use crate::model::Model;
use crate::simulation::balance::State;
use crate::simulation::stepping::{Method, Status, Stop};

/// Number of steps that a stability limit may require of an explicit method, unless the caller sets a limit:
/// some seconds of work.
const STIFF_STEPS: usize = 100_000;

/// Accepted steps before the first check.
const FIRST_SAMPLE: usize = 256;

/// Steps longer than this fraction of the stability limit are limited by the largest rate, either for
/// stability or because they resolve that rate.
const STEP_NEAR_LIMIT: f64 = 0.1;

/// Resolving the largest rate is not intended if it exceeds the highest frequency that is visible at the tip
/// by `MANY_TIMES`. A vibration is visible if it moves the tip by `VISIBLE_MOTION` times the length.
const MANY_TIMES: f64 = 10.0;
const VISIBLE_MOTION: f64 = 1e-5;

/// Check made during a run.
pub(super) enum Watch {
    Nothing,
    /// For fixed steps: unresolved vibrations.
    Resolution(UnresolvedVibrations),
    /// For explicit methods: steps limited by stability.
    Stiffness(StiffnessWatch),
}

impl Watch {
    pub(super) fn new<M: Model>(
        model: &mut M,
        t_span: (f64, f64),
        start: [&[f64]; 3],
        method: &Method,
    ) -> Self {
        if let Method::FirstOrder { options, .. } = method {
            return StiffnessWatch::new(options, t_span).map_or(Self::Nothing, Self::Stiffness);
        }
        let Some(dt) = method.fixed_step() else { return Self::Nothing };
        UnresolvedVibrations::new(model, t_span, start, dt).map_or(Self::Nothing, Self::Resolution)
    }

    /// Checks the step that led to this state, the `accepted`-th one.
    pub(super) fn check<M: Model>(
        &mut self,
        model: &mut M,
        state: State<'_>,
        accepted: usize,
    ) -> Option<Stop> {
        match self {
            Self::Nothing => None,
            Self::Resolution(vibrations) => {
                vibrations.step(state.t, state.a);
                None
            }
            Self::Stiffness(watch) => watch.check(model, state, accepted),
        }
    }

    /// Reason why a completed run from `q0` may be inaccurate.
    pub(super) fn doubt<M: Model>(self, model: &mut M, q0: &[f64]) -> Option<String> {
        if let Self::Resolution(vibrations) = self { vibrations.verdict(model, q0) } else { None }
    }
}

/// Checks from time to time whether stability limits the steps of an explicit run, and how many steps remain.
pub(super) struct StiffnessWatch {
    limit: f64,
    t_end: f64,
    allowed: usize,
    /// Accepted steps and time at the last check, and accepted steps at the next one.
    last: (usize, f64),
    next: usize,
}

impl StiffnessWatch {
    fn new(options: &ode::Options, (t0, t_end): (f64, f64)) -> Option<Self> {
        let limit = ode::stability_limit(options.method)?;
        let allowed = if options.max_steps == usize::MAX { STIFF_STEPS } else { options.max_steps };
        Some(Self { limit, t_end, allowed, last: (0, t0), next: FIRST_SAMPLE })
    }

    fn check<M: Model>(&mut self, model: &mut M, state: State<'_>, accepted: usize) -> Option<Stop> {
        let State { t, q, v, .. } = state;
        if accepted < self.next {
            return None;
        }
        let step = (t - self.last.1) / (accepted - self.last.0) as f64;
        self.last = (accepted, t);
        self.next = 2 * accepted;
        let left = ((self.t_end - t) / step).ceil();
        if accepted as f64 + left <= self.allowed as f64 {
            return None;
        }
        let spectrum = Spectrum::new(model, t, q, v)?;
        let rate = spectrum.rate();
        let visible = spectrum.highest_visible(model, q, VISIBLE_MOTION * model.facts().length);
        if step * rate < STEP_NEAR_LIMIT * self.limit || rate < MANY_TIMES * visible {
            return None;
        }
        let message = format!(
            "The model is stiff: its largest rate at t = {t:.1e} s, {rate:.1e} per second, limits explicit steps to {:.1e} s for stability, \
             and the remaining time would take about {left:.0} of them. Use method \"radau\", which no rate limits, or \"auto\", or allow \
             that many `max_steps`.",
            self.limit / rate
        );
        Some(Stop { status: Status::Stiff, message })
    }
}
