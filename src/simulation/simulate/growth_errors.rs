//! Errors of steps in motions that grow from the start of a run: from an unstable equilibrium, under follower loads, or from a spin about an
//! intermediate axis.
//!
//! A step of size h multiplies a motion `x exp(s t)` by `R(s h)`, with the stability function R of the method in place of the exponential.
//! The resulting error, up to the time at which the motion is no longer small, follows from the rates at the start; nothing is computed
//! without growth.

use std::cmp::Ordering;

use crate::analysis::growing::{FARTHEST, Growing, ROUNDING_OF_STATES};
use crate::integrators::newmark::Scheme;
use crate::integrators::ode::{Tableau, tableau};
use crate::model::Model;
use crate::numerics::linalg::Complex;
use crate::simulation::balance::State;
use crate::simulation::stepping::Method;

/// Errors of the tip, or of coordinates relative to their typical sizes, above this fraction cause a warning.
const WORTH_A_WARNING: f64 = 2e-2;

/// Models with more coordinates are not checked: their rates would cost more than a short run.
const MOST_COORDINATES: usize = 100;

/// The start is near an equilibrium or a steady spin if the displacement from it in the time of a growth by e is less than this, relative to
/// typical coordinates.
const NEAR_STEADY: f64 = 0.1;

/// The same for later states. It may be larger, since the size of the motion there includes the growth that this displacement excites.
const NEAR_LATER: f64 = 0.5;

/// Number of times at which later states are checked, after the growth from the start has become large.
const LATER_CHECKS: f64 = 16.0;

/// The stability function of a method.
enum Steps {
    Newmark(Scheme),
    Radau,
    Explicit(Tableau),
}

/// A growing motion.
struct GrowthError {
    /// Complex rate in 1/s.
    rate: Complex,
    /// Size at the start, relative to the length or to typical coordinates.
    begins: f64,
    /// Time at which it is no longer small, at the latest the end of the run.
    until: f64,
    /// Sum of the relative errors of all steps up to this time.
    error: f64,
}

/// A state near an unstable equilibrium, or an unstable spin, that the motion passes later.
struct Passed {
    t: f64,
    rate: f64,
    /// Error at the end of the run: earlier errors of steps that grow from there.
    lost: f64,
}

/// Errors of motions that grow from the start of a run.
pub(super) struct GrowthErrors {
    steps: Steps,
    t_span: (f64, f64),
    last: f64,
    longest: f64,
    /// Size of the last step, and the relative error of each growth in a step of this size.
    known: (f64, Vec<f64>),
    growths: Vec<GrowthError>,
    /// The state with the largest error so far, the time of the next check, and the time between checks.
    passed: Option<Passed>,
    next: f64,
    between: f64,
}

impl GrowthErrors {
    /// For a run from the state (q, v, a). `None` without visible growth, for large models and for constrained ones.
    pub(super) fn new<M: Model>(
        model: &mut M,
        t_span: (f64, f64),
        [q, v, a]: [&[f64]; 3],
        method: &Method,
    ) -> Option<Self> {
        let (n, duration) = (model.facts().n, t_span.1 - t_span.0);
        let is_free = model.facts().constraints() == 0 && method.has_inertia();
        // A moving rod is not in a steady state.
        let is_steady = !model.facts().is_discretised || v.iter().all(|v| *v == 0.0);
        if !is_free || !is_steady || n > MOST_COORDINATES || duration.is_nan() || duration <= 0.0 {
            return None;
        }
        let steps = match method {
            Method::Newmark(options) => Steps::Newmark(options.scheme),
            Method::Radau { .. } => Steps::Radau,
            Method::FirstOrder { options, .. } => {
                tableau(options.method).map_or(Steps::Radau, Steps::Explicit)
            }
        };
        model.set_time(t_span.0).ok()?;
        let growing = Growing::about(model, [q, v, a], duration).into_iter();
        let growths = growing.filter(|growing| growing.departure < NEAR_STEADY).map(|growing| {
            let begins = growing.size * growing.reach(model, q);
            let lasts = (FARTHEST / begins.max(ROUNDING_OF_STATES)).ln() / growing.rate;
            let until = t_span.0 + lasts.clamp(0.0, duration);
            GrowthError { rate: growing.value, begins, until, error: 0.0 }
        });
        let is_visible = |growth: &GrowthError| growth.ends(t_span.0) > WORTH_A_WARNING;
        let growths: Vec<GrowthError> = growths.filter(is_visible).collect();
        let known = (0.0, vec![0.0; growths.len()]);
        let fastest = growths.iter().max_by(|a, b| a.rate.re.total_cmp(&b.rate.re))?;
        let next = fastest.until;
        let between = ((t_span.1 - next) / LATER_CHECKS).max(1.0 / fastest.rate.re);
        let (last, longest, passed) = (t_span.0, 0.0, None);
        Some(Self { steps, t_span, last, longest, known, growths, passed, next, between })
    }

    /// Records a step to this state.
    pub(super) fn step<M: Model>(&mut self, model: &mut M, state: State<'_>) {
        let t = state.t;
        let step = t - self.last;
        let (steps, last) = (&self.steps, self.last);
        self.last = t;
        self.longest = self.longest.max(step);
        // Sizes of fixed steps differ by the rounding of times.
        if (step - self.known.0).abs() > 1e-6 * step {
            self.known.0 = step;
            let rates = self.growths.iter().map(|growth| growth.rate * step);
            self.known.1.clear();
            self.known.1.extend(rates.map(|rate| steps.error(rate)));
        }
        for (growth, error) in self.growths.iter_mut().zip(&self.known.1) {
            growth.error += error * ((growth.until - last) / step).clamp(0.0, 1.0);
        }
        if t >= self.next && t < self.t_span.1 && !model.facts().is_discretised {
            self.next = t + self.between;
            self.check_state(model, state);
        }
    }

    /// Checks whether the motion of rigid bodies is near a state from which earlier errors of steps grow.
    fn check_state<M: Model>(&mut self, model: &mut M, State { t, q, v, a }: State<'_>) {
        let before =
            self.growths.iter().map(|growth| growth.error_of_steps(self.t_span.0)).fold(0.0, f64::max);
        let left = self.t_span.1 - t;
        if before == 0.0 || model.set_time(t).is_err() {
            return;
        }
        for growing in
            Growing::about(model, [q, v, a], left).into_iter().filter(|one| one.departure < NEAR_LATER)
        {
            let begins = (growing.size * growing.reach(model, q)).max(before);
            let lost = before * (growing.rate * left).exp().min(FARTHEST / begins);
            if self.passed.as_ref().is_none_or(|passed| lost > passed.lost) {
                self.passed = Some(Passed { t, rate: growing.rate, lost });
            }
        }
    }

    /// Reason why a completed run may be wrong.
    pub(super) fn doubt(&self) -> Option<String> {
        let t0 = self.t_span.0;
        let worst =
            self.growths.iter().max_by(|a, b| a.error_of_steps(t0).total_cmp(&b.error_of_steps(t0)))?;
        let (lost, rate) = (worst.error_of_steps(t0), worst.rate.re);
        if lost > WORTH_A_WARNING {
            return Some(format!(
                "About its start the motion grows by a factor of e in {:.1e} s ({rate:.3} per second), and steps of up to {:.1e} s follow that with an \
                 error of about {:.1} % of the length, or of typical coordinates, once it is large. Take shorter steps, a smaller tolerance, \
                 or method \"auto\".",
                1.0 / rate,
                self.longest,
                100.0 * lost.min(1.0),
            ));
        }
        if let Some(Passed { t, rate, lost }) = &self.passed
            && *lost > WORTH_A_WARNING
        {
            return Some(format!(
                "At t = {t:.3} s the motion passes near an unstable equilibrium or an unstable spin, where errors grow by a factor of e in {:.1e} s \
                 ({rate:.3} per second): those of steps of up to {:.1e} s become about {:.0} % of the length, or of typical coordinates. \
                 Take shorter steps, a smaller tolerance, or method \"auto\".",
                1.0 / rate,
                self.longest,
                100.0 * lost.min(1.0),
            ));
        }
        let rounded = |growth: &&GrowthError| growth.begins <= ROUNDING_OF_STATES;
        let by_rate = |a: &&GrowthError, b: &&GrowthError| -> Ordering { a.rate.re.total_cmp(&b.rate.re) };
        let fastest = self.growths.iter().filter(rounded).max_by(by_rate)?;
        let exponent = fastest.rate.re * (self.t_span.1 - t0);
        Some(unstable_equilibrium(fastest.rate.re, exponent))
    }
}

/// A warning about a motion that starts within rounding of a diverging one. Deviations grow by `exp(exponent)`.
pub(crate) fn unstable_equilibrium(rate: f64, exponent: f64) -> String {
    format!(
        "The motion is near an unstable equilibrium or an unstable spin, where deviations grow by a factor of e in {:.1e} s ({rate:.3} per second), by 1e{:.0} within \
         the run as long as they are small: rounding decides how it ends. Give the start a deviation that is far larger than rounding, or \
         shorten the time.",
        1.0 / rate,
        exponent / std::f64::consts::LN_10
    )
}

impl GrowthError {
    /// Its size at the time `until`.
    fn ends(&self, t0: f64) -> f64 {
        self.begins.max(ROUNDING_OF_STATES) * (self.rate.re * (self.until - t0)).exp()
    }

    /// Error due to steps at that time.
    fn error_of_steps(&self, t0: f64) -> f64 {
        if self.begins <= ROUNDING_OF_STATES {
            0.0
        } else {
            self.ends(t0).min(FARTHEST) * self.error.exp_m1().min(1.0)
        }
    }
}

impl Steps {
    /// Relative error of a step, by the product of the rate and the step.
    fn error(&self, z: Complex) -> f64 {
        let grown = match self {
            Self::Newmark(scheme) => scheme.growth(z),
            Self::Radau => radau(z),
            Self::Explicit(tableau) => explicit(tableau, z),
        };
        let error = (grown.ln() - z).norm();
        // A factor of zero loses everything.
        if error.is_finite() { error } else { f64::MAX.ln() }
    }
}

/// `(1 + 2 z/5 + z^2/20) / (1 - 3 z/5 + 3 z^2/20 - z^3/60)`, the stability function of Radau IIA (Hairer and Wanner 1996, section IV.3).
fn radau(z: Complex) -> Complex {
    let one = Complex::from(1.0);
    (one + z * 0.4 + z * z * 0.05) / (one - z * 0.6 + z * z * 0.15 - z * z * z / 60.0)
}

/// The stability function of an explicit method.
fn explicit(Tableau { a, b, .. }: &Tableau, z: Complex) -> Complex {
    let mut stages: Vec<Complex> = Vec::with_capacity(b.len());
    let sum = |weights: &[f64], stages: &[Complex]| -> Complex {
        weights.iter().zip(stages).map(|(weight, stage)| stage * *weight).sum()
    };
    for row in a {
        let stage = z * (Complex::from(1.0) + sum(row, &stages));
        stages.push(stage);
    }
    Complex::from(1.0) + sum(b, &stages)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrators::ode::Method as Pair;

    fn error(steps: &Steps, z: f64) -> f64 {
        steps.error(Complex::from(z))
    }

    #[test]
    fn errors_of_a_growth_have_the_order_of_the_method() {
        let average = Steps::Newmark(Scheme::AVERAGE_ACCELERATION);
        for (steps, order) in [
            (average, 2),
            (Steps::Newmark(Scheme::generalised_alpha(0.8).unwrap()), 2),
            (Steps::Radau, 5),
            (Steps::Explicit(tableau(Pair::Rk45).unwrap()), 5),
            (Steps::Explicit(tableau(Pair::Dop853).unwrap()), 8),
        ] {
            let ratio = error(&steps, 0.4) / error(&steps, 0.2);
            let expected = f64::from(2_i32.pow(order + 1));
            assert!((0.6..1.7).contains(&(ratio / expected)), "{order}: {ratio}");
            // Also where it turns.
            assert!(steps.error(Complex::new(0.1, 0.1)) < 2.0 * error(&steps, 0.2));
        }
        let average = Steps::Newmark(Scheme::AVERAGE_ACCELERATION);
        let exact = (1.25_f64 / 0.75).ln() - 0.5;
        assert!((error(&average, 0.5) / exact - 1.0).abs() < 1e-9);
    }

    #[test]
    fn what_long_steps_damp_is_lost() {
        assert!(error(&Steps::Radau, 30.0) > 25.0);
        assert!(error(&Steps::Newmark(Scheme::AVERAGE_ACCELERATION), 30.0) > 25.0);
        assert!(error(&Steps::Radau, 1.0) < 1e-3);
    }
}
