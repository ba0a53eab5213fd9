//! Motions that grow from a state, such as the fall of a pendulum from its upper position, and the steps that resolve them.
//!
//! Radau's method damps motions that grow by more than a factor of e^4 in a step. Error estimates do not show this as long as the motion is
//! small: errors that are small relative to the typical size of a coordinate are large relative to 1e-4 of it. Two runs that do not resolve a
//! growth agree with each other, but not with the exact motion. Therefore steps resolve motions that grow to a visible size, as they resolve
//! vibrations, until they have this size; from then on the difference of two runs shows the error. No steps resolve the growth of rounding.

use std::cmp::Ordering;

use super::integrator::Integrator;
use crate::analysis::growing::{FARTHEST, Growing, ROUNDING_OF_STATES};
use crate::model::Model;
use crate::simulation::simulate::unstable_equilibrium;

/// Motions that grow to at most this fraction of the requested accuracy need not be resolved.
const NEGLECTED_MOTION: f64 = 0.25;

/// Fraction of the requested accuracy that each growing motion may use in the first run.
const ERROR_SHARE: f64 = 0.75;

/// Longest step, relative to the time of a growth by e: for longer steps, the leading term does not describe the error.
const LONGEST_STEP: f64 = 1.0;

/// A motion that grows from a state.
#[derive(Clone, Copy, Debug)]
pub(super) struct GrowthResolution {
    /// Rate of growth, and absolute value of the complex rate, in 1/s.
    rate: f64,
    speed: f64,
    /// Natural logarithm of the factor by which rounding grows.
    exponent: f64,
    /// Final size of the motion, relative to the length or to typical coordinates; zero if the state excites only rounding.
    reach: f64,
    /// Absolute value of the complex rate times the duration of the growth.
    radians: f64,
    /// Elastic stiffness over the square of the speed times the mass.
    elastic_share: f64,
}

impl GrowthResolution {
    /// Growth from a state q for at most this time. `size` is the amplitude that the state or loads excite.
    pub(super) fn new<M: Model>(model: &mut M, q: &[f64], growing: &Growing, size: f64, time: f64) -> Self {
        let begins = size * growing.reach(model, q);
        let lasts = |begins: f64| ((FARTHEST / begins).ln() / growing.rate).clamp(0.0, time);
        let is_excited = begins > ROUNDING_OF_STATES;
        let reach = if is_excited { begins * (growing.rate * lasts(begins)).exp() } else { 0.0 };
        Self {
            rate: growing.rate,
            speed: growing.speed,
            exponent: growing.rate * lasts(begins.max(ROUNDING_OF_STATES)),
            reach: reach.min(FARTHEST),
            radians: growing.speed * lasts(begins.max(ROUNDING_OF_STATES)),
            elastic_share: growing.elastic(model, q) / growing.speed.powi(2),
        }
    }

    /// Also resolves this speed, at which the start excites the growth, if this part of the growth becomes visible.
    pub(super) fn follow_from(&mut self, part: f64, speed: f64, wanted: f64) {
        if part * self.reach > NEGLECTED_MOTION * wanted {
            self.speed = self.speed.max(speed);
        }
    }

    pub(super) fn by_exponent(a: &Self, b: &Self) -> Ordering {
        a.exponent.total_cmp(&b.exponent)
    }

    /// Whether steps must resolve it for this accuracy.
    fn is_visible(&self, wanted: f64) -> bool {
        self.reach > NEGLECTED_MOTION * wanted
    }

    /// The speed in 1/s that steps must resolve for this accuracy; zero if none.
    pub(super) fn visible_speed(&self, wanted: f64) -> f64 {
        if self.is_visible(wanted) { self.speed } else { 0.0 }
    }

    /// Error after steps of this size, relative to the length.
    pub(super) fn error_of_steps(&self, integrator: &Integrator, step: f64) -> f64 {
        self.reach * (self.radians * integrator.error_of_a_radian(self.speed, step)).min(1.0)
    }

    /// Error if the relative error of stiffnesses is such that frequencies have this relative error. It is at most what grows from the
    /// largest error `most` of deflections.
    pub(super) fn error_of_frequencies(&self, relative: f64, most: f64) -> f64 {
        (self.reach * (self.radians * self.elastic_share * relative).min(1.0)).min(most * self.exponent.exp())
    }

    /// Longest step for which the error stays within its share of `wanted`, times `tightening`. Runs with different tolerances must not
    /// have the same steps.
    pub(super) fn longest_step(&self, integrator: &Integrator, wanted: f64, tightening: f64) -> f64 {
        if !self.is_visible(wanted) {
            return f64::INFINITY;
        }
        let allowed = ERROR_SHARE * wanted * tightening / (self.reach * self.radians.max(1.0));
        integrator.step_of_error(allowed).min(LONGEST_STEP * integrator.shorter(tightening)) / self.speed
    }

    /// A warning about a motion that starts within rounding of a diverging one.
    pub(super) fn doubt(growths: &[Self], wanted: f64) -> Option<String> {
        let exponent: f64 = growths.iter().map(|growth| growth.exponent).sum();
        let grown = ROUNDING_OF_STATES * exponent.exp();
        let fastest = growths.iter().max_by(|a, b| a.rate.total_cmp(&b.rate))?;
        (grown >= wanted).then(|| unstable_equilibrium(fastest.rate, exponent))
    }
}

#[cfg(test)]
mod tests {
    use super::super::integrator::{DOP853, RADAU};
    use super::*;

    fn growth(reach: f64) -> GrowthResolution {
        GrowthResolution { rate: 4.0, speed: 5.0, exponent: 12.0, reach, radians: 15.0, elastic_share: 2.0 }
    }

    #[test]
    fn steps_of_a_growth_have_the_error_that_the_first_run_may_have() {
        let wanted = 1e-4;
        for integrator in [&RADAU, &DOP853] {
            let step = growth(1.0).longest_step(integrator, wanted, 1.0);
            assert!(step * 5.0 <= LONGEST_STEP);
            assert!(growth(1.0).error_of_steps(integrator, step) <= ERROR_SHARE * wanted * (1.0 + 1e-9));
            assert!(growth(1.0).longest_step(integrator, wanted, 0.2) < 0.9 * step);
        }
        assert_eq!(growth(0.2 * wanted).longest_step(&RADAU, wanted, 1.0), f64::INFINITY);
    }

    #[test]
    fn wrong_stiffnesses_change_a_growth_by_at_most_what_grows_from_deflections() {
        let most = 1e-9;
        assert_eq!(growth(1.0).error_of_frequencies(0.01, f64::INFINITY), 0.01 * 15.0 * 2.0);
        assert_eq!(growth(1.0).error_of_frequencies(0.01, most), most * 12.0_f64.exp());
    }

    #[test]
    fn only_what_rounding_grows_to_is_doubted() {
        let of =
            |exponent: f64| GrowthResolution::doubt(&[GrowthResolution { exponent, ..growth(0.0) }], 1e-3);
        assert!(of(20.0).is_none());
        assert!(of(30.0).unwrap().contains("(4.000 per second)"));
        assert!(GrowthResolution::doubt(&[], 1e-3).is_none());
    }
}
