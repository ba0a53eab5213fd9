//! Choice between the explicit and the implicit method, from the largest rate of the model and the required
//! accuracy.

use std::f64::consts::TAU;

use super::following::Following;
use super::integrator::{DOP853, Integrator, RADAU};
use crate::analysis::spectrum::Spectrum;
use crate::model::Facts;

/// The chosen method, and the reason.
#[derive(Clone, Debug)]
pub(super) struct Choice {
    pub(super) integrator: &'static Integrator,
    /// Highest frequency to be resolved, in rad/s; infinite if unknown.
    pub(super) resolved: f64,
    /// Scale between errors of velocities and of coordinates, in rad/s: between the lowest frequency and the
    /// highest one to be resolved.
    pub(super) frequency: f64,
    /// Steps of the explicit method beyond which the implicit one is expected to cost less.
    pub(super) worth: usize,
    /// Whether explicit steps became too short in a run.
    pub(super) has_switched: bool,
    /// Reason in one sentence.
    pub(super) reason: String,
}

/// The explicit method may cost this many times the expected cost of the implicit one; `FEW_STEPS` steps are allowed in any case.
const EXPLICIT_COST_FACTOR: f64 = 4.0;
const FEW_STEPS: f64 = 300.0;

impl Choice {
    /// The implicit method, for models without a spectrum.
    pub(super) fn implicit() -> Self {
        let reason = "Method: radau.".to_owned();
        Self {
            integrator: &RADAU,
            resolved: f64::INFINITY,
            frequency: 1.0,
            worth: usize::MAX,
            has_switched: false,
            reason,
        }
    }

    /// Compares the costs of one second of motion. Models with closed loops use Radau, which includes the
    /// constraints in the equations of its steps, whereas explicit methods project after each step.
    pub(super) fn new(
        spectrum: &Spectrum,
        following: &Following,
        tolerance: f64,
        facts: &Facts,
        duration: f64,
    ) -> Self {
        let has_loops = facts.constraints() > 0;
        let slowest = spectrum.modes.iter().map(|mode| mode.frequency).filter(|&w| w > 0.0);
        let slowest = slowest.fold(f64::INFINITY, f64::min);
        if has_loops {
            let reason = "Method: radau, because it holds constraints as equations of its steps.";
            let moves = slowest.is_finite();
            let resolved = if moves { following.highest().max(slowest) } else { f64::INFINITY };
            let frequency = if moves { (slowest * resolved).sqrt() } else { 1.0 };
            return Self {
                integrator: &RADAU,
                resolved,
                frequency,
                worth: usize::MAX,
                has_switched: false,
                reason: reason.to_owned(),
            };
        }
        if !slowest.is_finite() && facts.has_contact {
            // Explicit steps reject every other step at impacts, and become short where bodies rest on each other.
            let reason = "Method: radau, because contacts are stiff.".to_owned();
            return Self { reason, ..Self::implicit() };
        }
        if !slowest.is_finite() {
            let reason = "Method: dop853, because nothing in the model is stiff.".to_owned();
            let may_be_stiff = facts.has_one_sided_forces || facts.has_dry_friction;
            let worth = if may_be_stiff { FEW_STEPS as usize } else { usize::MAX };
            return Self { integrator: &DOP853, worth, reason, ..Self::implicit() };
        }
        let resolved = following.highest().max(slowest);
        let step = |integrator: &Integrator| {
            let of_accuracy = following.accurate_step(integrator, tolerance);
            let slow = integrator.step * integrator.shorter(tolerance) / slowest;
            of_accuracy.min(slow).min(following.longest_step(integrator, tolerance))
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
            let steps = EXPLICIT_COST_FACTOR * RADAU.cost / DOP853.cost * duration / implicit;
            let worth = steps.max(FEW_STEPS) as usize;
            return Self { integrator: &DOP853, resolved, frequency, worth, has_switched: false, reason };
        }
        let reason = format!(
            "Method: radau, because its largest rate, {highest:.3} Hz, limits explicit steps to {stable:.1e} s, while the \
             accuracy takes implicit ones of {implicit:.1e} s, for vibrations of up to {wanted:.3} Hz."
        );
        Self { resolved, frequency, reason, ..Self::implicit() }
    }

    /// Changes to the implicit method after the explicit one took too many steps.
    pub(super) fn switch(&mut self) {
        self.integrator = &RADAU;
        self.worth = usize::MAX;
        self.has_switched = true;
        self.reason =
            "Method: radau, because explicit steps became short where something stiff began to act."
                .to_owned();
    }
}
