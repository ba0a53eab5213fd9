//! Steps that are tried, judged, and then made or made shorter: once for all methods.
//!
//! Steppers know smooth equations of motion with constraints. They try a step, accept what they have tried, and try again without what
//! they remember, or a shorter step. What acts one way only (surfaces, stops, tendons) is looked at here, at the end of the step
//! that is tried. The first [`Diagnosis`] in this order decides:
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
//! Fixed steps without inertia have a ladder of their own: to the equilibrium that is near; in parts; and where there is none with inertia, in
//! parts, by the backward Euler method. Of these only whether their ends are invalid or surfaces have crossed is asked.
//!
//! Fixed steps ask the last of those without memory, and whether an impact is resolved of those with memory. Of adaptive steps of the
//! Newmark family only what they have missed is asked: their error estimate sees the rest.

mod adaptive;
mod diagnosis;
mod fixed;
mod impacts;

pub(crate) use adaptive::{Adaptive, MOST_UNSOUND, Sizes, Tried, adaptive_step};
pub(crate) use diagnosis::{Diagnosis, Ends, Kind, Unilateral, matters};
pub(crate) use fixed::{Fixed, Memory, fixed_step};
pub(crate) use impacts::Remedy;

use crate::error::Interrupted;
use crate::integrators::second_order::System;

/// A stepper of smooth equations of motion with constraints.
pub(crate) trait Stepper {
    /// The step that was tried last, and what is known of what acts one way only.
    fn tried(&mut self) -> (Ends<'_>, &mut Unilateral);

    /// Makes the step that was tried last.
    fn accept<S: System + ?Sized>(&mut self, system: &mut S) -> Result<(), Interrupted>;
}
