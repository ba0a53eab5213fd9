//! Attempted steps, their diagnosis, and what is done about it, for all methods.
//!
//! Steppers solve smooth equations of motion with constraints. They attempt a step, and accept it or repeat it without memory of
//! earlier steps or with a smaller size. One-sided forces (contact, stops, tendons) are examined here, at the end of the attempted step.
//! The first [`Diagnosis`] in this order decides:
//!
//! | diagnosis | fixed steps | adaptive steps |
//! |---|---|---|
//! | equations not solved, or not within the error | without memory, then halves; of mechanisms without surfaces and tendons halves | shorter |
//! | [missed](Diagnosis::Missed) something | – | shorter |
//! | [unresolved](Diagnosis::Unresolved) impact | without memory, and the next | shorter, where it gains energy |
//! | [invalid](Diagnosis::Invalid) end | without memory, then halves | shorter |
//! | [crossed](Diagnosis::Crossed) surfaces | without memory, then halves | – |
//! | [explodes](Diagnosis::Explodes) | halves | – |
//! | sound | made | made |
//!
//! Fixed steps without inertia have a sequence of their own: to the nearby equilibrium; to the one downhill; in parts; and, if there
//! is none, in parts with inertia by the backward Euler method. They are only examined for invalid ends and crossed surfaces.
//!
//! Of fixed steps, only those without memory are examined for explosions, and only those with memory for unresolved impacts. Adaptive
//! steps of the Newmark family are only examined for missed contacts: their error estimate detects the rest.

mod adaptive;
mod diagnosis;
mod fixed;
mod impacts;

pub(crate) use adaptive::{Adaptive, MAX_INVALID_ATTEMPTS, Sizes, Tried, adaptive_step};
pub(crate) use diagnosis::{Diagnosis, Ends, Kind, Unilateral, matters};
pub(crate) use fixed::{Fixed, Memory, fixed_step};
pub(crate) use impacts::{Remedy, ResolvedLoss, StoppedImpact};

use crate::error::Interrupted;
use crate::integrators::Retries;
use crate::integrators::second_order::SecondOrderSystem;

/// A stepper of smooth equations of motion with constraints.
pub(crate) trait Stepper {
    /// The last attempted step, and the state of the one-sided forces.
    fn tried(&mut self) -> (Ends<'_>, &mut Unilateral);

    /// The attempts of the current step.
    fn retries(&mut self) -> &mut Retries;

    /// Accepts the last attempted step.
    fn accept<S: SecondOrderSystem + ?Sized>(&mut self, system: &mut S) -> Result<(), Interrupted>;
}
