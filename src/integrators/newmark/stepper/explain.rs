//! Descriptions of statuses of an integration, with advice.

use super::{Lengths, StepperOf};
use crate::error::Time;
use crate::integrators::newmark::numbers::Numbers;
use crate::integrators::second_order::{Failure, Status};

/// Below this relative tolerance rounding alone can keep Newton's method from converging: accelerations are differences of much
/// larger forces, which cost some digits of sixteen.
const TIGHT_RTOL: f64 = 1e-10;

impl<V: Numbers> StepperOf<V> {
    /// What the step that could not be solved contained, and a remedy.
    fn unsolved(&self) -> (&'static str, &'static str) {
        if !self.scheme.has_inertia() {
            return (
                ", nor in parts of it, with and without inertia",
                "Take a smaller `dt`. If that ends at the same place, look at the last state, and follow it by another method.",
            );
        }
        if self.unilateral.has_touched {
            return (
                ", in which surfaces touch",
                "Take a `dt` that is shorter than the impact; adaptive steps and `method=\"radau\"` find the step size \
                 themselves.",
            );
        }
        if self.is_one_sided && self.lengths != Lengths::Smooth {
            return (
                ", over which lengths of tendons that do not stretch jump",
                "Take a smaller `dt`, change the tendon's `length` more slowly, or give it a `stiffness`.",
            );
        }
        if self.a.len() > self.q.len() {
            return (
                ", with closed loops or tendons that do not stretch",
                "Take a smaller `dt`. If that ends at the same place, the mechanism cannot go on there: look at the last state, \
                 whose loops may lock or conflict with each other.",
            );
        }
        if self.rtol.iter().any(|&rtol| rtol < TIGHT_RTOL) {
            return ("", "Loosen `rtol`, which rounding may not let it reach, or reduce `dt`.");
        }
        ("", "Reduce `dt` or use adaptive steps.")
    }

    /// Describes a status of this integration, with advice unless it is a success.
    pub(super) fn explain(&self, status: Status) -> String {
        // A run that is shorter than a step is a step.
        let h = self.options.dt.min(self.t_end - self.t);
        let [t, t_end, h] = [self.t, self.t_end, h].map(Time);
        let limit = self.scheme.stability_limit();
        match status {
            Status::Finished => "The end of the interval was reached.".to_owned(),
            Status::NoInitialAcceleration(Failure::SingularJacobian) => format!(
                "The accelerations at t = {t} could not be found: the mass matrix (the derivative of the residual with \
                 respect to them) is singular at the start. Change the initial state, give every coordinate a mass, or \
                 give the accelerations (`a0` of `newmark`)."
            ),
            Status::NoInitialAcceleration(Failure::NonFinite) => format!(
                "The accelerations at t = {t} could not be found: the residual or its derivative is NaN or infinite at \
                 the initial state. Check the equations of motion there."
            ),
            Status::NoInitialAcceleration(Failure::NotConverged | Failure::PassedThrough) => format!(
                "The accelerations at t = {t} could not be found: Newton's method did not converge from zero. Check the \
                 Jacobian, loosen `atol` or `rtol`, or give the accelerations (`a0` of `newmark`)."
            ),
            Status::StepFailed(Failure::NotConverged) => {
                let (doing, cure) = self.unsolved();
                format!(
                    "Newton's method did not converge in the step from t = {t} (step size {h}){doing}; the result ends there. {cure}"
                )
            }
            Status::StepFailed(Failure::SingularJacobian) if !self.scheme.has_inertia() => format!(
                "The stiffness in the step from t = {t} (step size {h}) is singular; the result ends there. Without inertia something \
                 must hold every part: a joint with `stiffness`, `damping` or `friction`, a support, or what it lies on. A method \
                 with inertia follows what moves freely."
            ),
            Status::StepFailed(Failure::SingularJacobian) => format!(
                "The Jacobian of the step from t = {t} (step size {h}) is singular; the result ends there. Change `dt` or \
                 use adaptive steps; if that does not help the equations of motion do not determine the accelerations."
            ),
            Status::StepFailed(Failure::NonFinite) if limit.is_finite() => format!(
                "The residual became NaN or infinite in the step from t = {t} (step size {h}); the result ends there. {}",
                self.explain(Status::Unstable)
            ),
            Status::Unstable => format!(
                "This scheme is stable only for step sizes below {limit:.4} / (largest natural frequency in rad/s): reduce `dt` \
                 or use average acceleration."
            ),
            Status::StepFailed(Failure::NonFinite) => format!(
                "The residual or its Jacobian became NaN or infinite in the step from t = {t} (step size {h}); the result \
                 ends there. Reduce `dt` or use adaptive steps, and check the equations of motion near the last state."
            ),
            Status::StepFailed(Failure::PassedThrough) => format!(
                "Surfaces pass through each other, or come so deep that they push each other out by another side, in the step from \
                 t = {t} (step size {h}), in parts of it as well; the result ends there. Give the contact more `stiffness`, or \
                 reduce `dt`."
            ),
            Status::StepTooSmall => format!(
                "The step size fell below its limit at t = {t} after {} rejected and {} unsolved steps: loosen `rtol` and \
                 `atol`, reduce `min_step`, or check the equations of motion there for a singularity.",
                self.counters.rejected, self.counters.unsolved
            ),
            Status::TooManySteps => format!(
                "The limit of {} steps was reached at t = {t}, before the end of the interval, {t_end}: increase \
                 `max_steps`, or take larger steps.",
                self.options.max_steps
            ),
            Status::Interrupted => format!("The integration was stopped at t = {t}, as asked for."),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrators::newmark::Options;

    /// Advice about a step that could not be solved depends on its contents.
    #[test]
    fn advice_is_for_what_the_step_did() {
        let options = Options::new(0.1);
        let start: [&[f64]; 2] = [&[0.0], &[0.0]];
        let tolerances: (&[f64], Option<&[f64]>) = (&[1e-6], None);
        let mut stepper = StepperOf::<Vec<f64>>::new((0.0, 1.0), start, &options, tolerances);
        let explained =
            |stepper: &StepperOf<Vec<f64>>| stepper.explain(Status::StepFailed(Failure::NotConverged));
        let plain = explained(&stepper);
        assert!(plain.ends_with("the result ends there. Reduce `dt` or use adaptive steps."), "{plain}");
        assert!(["contact", "tendon", "loop"].iter().all(|other| !plain.contains(other)), "{plain}");
        stepper.rtol[0] = 1e-14;
        assert!(explained(&stepper).contains("Loosen `rtol`"));
        stepper.a.push(0.0);
        assert!(explained(&stepper).contains("with closed loops or tendons that do not stretch"));
        (stepper.is_one_sided, stepper.lengths) = (true, Lengths::Jump);
        assert!(explained(&stepper).contains(
            "lengths of tendons that do not stretch jump; the result ends there. Take a smaller `dt`, change"
        ));
        stepper.unilateral.has_touched = true;
        assert!(
            explained(&stepper)
                .contains("in which surfaces touch; the result ends there. Take a `dt` that is shorter")
        );
    }
}
