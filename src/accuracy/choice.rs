//! Explicit or implicit: by what the largest rate of the model allows and what the accuracy needs.

use std::f64::consts::TAU;

use super::following::Following;
use super::integrator::{DOP853, Integrator, RADAU};
use crate::spectrum::Spectrum;

/// Which method, and why.
#[derive(Clone, Debug)]
pub(super) struct Choice {
    pub(super) integrator: &'static Integrator,
    /// The highest frequency that is to be resolved, in rad/s; infinite where that is not known.
    pub(super) resolved: f64,
    /// What relates errors of velocities to those of coordinates, in rad/s: between the lowest frequency and the one
    /// that is to be resolved.
    pub(super) frequency: f64,
    /// One sentence.
    pub(super) reason: String,
}

impl Choice {
    /// Without a spectrum.
    pub(super) fn implicit() -> Self {
        let reason = "Method: radau.".to_owned();
        Self { integrator: &RADAU, resolved: f64::INFINITY, frequency: 1.0, reason }
    }

    /// Compares the costs of a second of motion. Closed loops are left to Radau: it holds them as equations of its steps, while
    /// explicit methods project after each of them.
    pub(super) fn new(spectrum: &Spectrum, following: &Following, tolerance: f64, has_loops: bool) -> Self {
        let slowest = spectrum.modes.iter().map(|mode| mode.frequency).filter(|&w| w > 0.0);
        let slowest = slowest.fold(f64::INFINITY, f64::min);
        if has_loops {
            let reason = "Method: radau, because it holds constraints as equations of its steps.";
            let moves = slowest.is_finite();
            let resolved = if moves { following.highest(tolerance).max(slowest) } else { f64::INFINITY };
            let frequency = if moves { (slowest * resolved).sqrt() } else { 1.0 };
            return Self { integrator: &RADAU, resolved, frequency, reason: reason.to_owned() };
        }
        if !slowest.is_finite() {
            let reason = "Method: dop853, because nothing in the model is stiff.".to_owned();
            return Self { integrator: &DOP853, resolved: f64::INFINITY, frequency: 1.0, reason };
        }
        let resolved = following.highest(tolerance).max(slowest);
        let step = |integrator: &Integrator| {
            let of_accuracy = integrator.step * integrator.shorter(tolerance) / resolved;
            of_accuracy.min(following.longest_step(integrator, tolerance))
        };
        let stable = DOP853.stability / spectrum.rate();
        let (explicit, implicit) = (step(&DOP853).min(stable), step(&RADAU));
        let (highest, wanted) = (spectrum.rate() / TAU, resolved / TAU);
        let frequency = (slowest * resolved).sqrt();
        if DOP853.cost / explicit <= RADAU.cost / implicit {
            let reason = format!(
                "Method: dop853, because its largest rate, {highest:.3} Hz, allows explicit steps of {stable:.1e} s, and the \
                 accuracy takes steps of {explicit:.1e} s anyway, for vibrations of up to {wanted:.3} Hz."
            );
            return Self { integrator: &DOP853, resolved, frequency, reason };
        }
        let reason = format!(
            "Method: radau, because its largest rate, {highest:.3} Hz, limits explicit steps to {stable:.1e} s, while the \
             accuracy takes implicit ones of {implicit:.1e} s, for vibrations of up to {wanted:.3} Hz."
        );
        Self { integrator: &RADAU, resolved, frequency, reason }
    }
}
