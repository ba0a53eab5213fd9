//! Explicit or implicit: by what the largest rate of the model allows and what the accuracy needs.

use std::f64::consts::TAU;

use super::following::{EXPLICIT_STABILITY, Following};
use crate::spectrum::Spectrum;

/// Steps that accuracy takes, times the largest frequency that is to be resolved: `EXPLICIT_STEP tolerance^(1/8)`, `IMPLICIT_STEP
/// tolerance^(1/5)`. Measured on the lab's rod.
const EXPLICIT_STEP: f64 = 6.0;
const IMPLICIT_STEP: f64 = 4.0;

/// What a step costs, in inverse dynamics: twelve forward dynamics; some three iterations of three residuals, and the tangents.
const EXPLICIT_COST: f64 = 30.0;
const IMPLICIT_COST: f64 = 20.0;

/// Which method, and why.
#[derive(Clone, Debug)]
pub(super) struct Choice {
    /// DOP853, or else Radau.
    pub(super) is_explicit: bool,
    /// What relates errors of velocities to those of coordinates, in rad/s: between the lowest frequency and the largest one that is
    /// to be resolved.
    pub(super) frequency: f64,
    /// One sentence.
    pub(super) reason: String,
}

impl Choice {
    /// Without a spectrum.
    pub(super) fn implicit() -> Self {
        Self { is_explicit: false, frequency: 1.0, reason: "Method: radau.".to_owned() }
    }

    /// Compares the costs of a second of motion.
    pub(super) fn new(spectrum: &Spectrum, following: &Following, tolerance: f64) -> Self {
        let rate = spectrum.rate();
        let slowest = spectrum.modes.iter().map(|mode| mode.frequency).filter(|&w| w > 0.0);
        let slowest = slowest.fold(f64::INFINITY, f64::min);
        let resolved = following.highest(tolerance);
        if !slowest.is_finite() {
            return Self {
                is_explicit: true,
                frequency: 1.0,
                reason: "Method: dop853, because nothing in the model is stiff.".to_owned(),
            };
        }
        let resolved = resolved.max(slowest);
        let stable = EXPLICIT_STABILITY / rate;
        let explicit = stable
            .min(EXPLICIT_STEP * tolerance.powf(1.0 / 8.0) / resolved)
            .min(following.longest_step(true, tolerance));
        let implicit = (IMPLICIT_STEP * tolerance.powf(1.0 / 5.0) / resolved)
            .min(following.longest_step(false, tolerance));
        let is_explicit = EXPLICIT_COST / explicit <= IMPLICIT_COST / implicit;
        let (highest, wanted) = (rate / TAU, resolved / TAU);
        let reason = if is_explicit {
            format!(
                "Method: dop853, because its largest rate, {highest:.3} Hz, allows explicit steps of {stable:.1e} s, and the \
                 accuracy takes steps of {explicit:.1e} s anyway, for vibrations of up to {wanted:.3} Hz."
            )
        } else {
            format!(
                "Method: radau, because its largest rate, {highest:.3} Hz, limits explicit steps to {stable:.1e} s, while the \
                 accuracy takes implicit ones of {implicit:.1e} s, for vibrations of up to {wanted:.3} Hz."
            )
        };
        Self { is_explicit, frequency: (slowest * resolved).sqrt(), reason }
    }
}
