//! Surfaces and springs of a model that act one way only.

use super::{Beside, Dynamics, Flaw, Impact, Parting, Radius};
use crate::numerics::linalg::Matrix;

/// Surfaces and stops count as exactly reached up to this part of the lengths of which their gap is a difference: ten times the
/// tolerance of equilibria, well above rounding.
pub(crate) const REACHED: f64 = 1e-9;

/// What acts one way only and is exactly reached: rounding would decide whether it acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reached {
    /// The stop of a coordinate that does not act.
    Stop(usize),
    /// A pair of surfaces that do not press on each other.
    Surfaces(usize),
    /// An elastic tendon, by its row of the [cords](super::springs::Cords), that is slack.
    Slack(usize),
    /// One that resists being shortened as well, because others then stretch.
    Taut(usize),
}

/// The deepest of the surfaces that overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overlap {
    /// Index of the contact in the model.
    pub contact: usize,
    /// Metres.
    pub depth: f64,
    /// Depth over the thickness of the thinner surface: of a rod or ball its radius.
    pub share: f64,
}

impl Overlap {
    /// The one that is deeper for its surfaces.
    pub fn deeper(known: Option<Self>, found: Option<Self>) -> Option<Self> {
        match (known, found) {
            (Some(known), Some(found)) if found.share <= known.share => Some(known),
            (known, found) => found.or(known),
        }
    }
}

/// Contacts and stops of a model, as statics asks for them.
pub trait InContact: Dynamics {
    /// The stops and the surfaces that act in a shape and are exactly reached there. Allocates.
    fn reached(&mut self, q: &[f64]) -> Vec<Reached>;

    /// From now on these act in all shapes as they say; of none, rounding decides again.
    fn decide(&mut self, reached: &[Reached]);

    /// Disables contact forces, or enables them again.
    fn leave_contact(&mut self, is_left: bool);

    /// Softens contacts: surfaces are no stiffer than those that such a force, in newtons for every pair of [`Self::shifts_of_contact`],
    /// presses into each other by their thickness. `None` undoes that. Returns whether any are softer than they are.
    fn soften_contact(&mut self, forces: Option<&[f64]>) -> bool;

    /// The largest overlap in a shape over the thickness of the thinner surface, of all and of those that have two sides, unlike a
    /// half-space; zero if nothing touches.
    fn deepest_overlaps(&mut self, q: &[f64]) -> [f64; 2];

    /// The overlap in a shape that is deepest for its surfaces.
    fn deepest_overlap(&mut self, q: &[f64]) -> Option<Overlap>;

    /// Name of a contact.
    fn name_of_contact(&self, contact: usize) -> String;

    /// What to change where contacts are too soft for what presses, by the deepest overlap so far, and, where a run or search has
    /// failed, what holds it: the contact that overlaps most, and the stop and tendon that press or pull most in its last shape, or meet in the next one, by
    /// these shapes in turn; sentences, or nothing. Allocates.
    fn advice_at_end(&mut self, failed: &[&[f64]], deepest: Option<Overlap>) -> String;

    /// For every pair of surfaces that may touch, a row: how far either of them moves at most for a unit of each coordinate, along
    /// steps from the shape. Allocates.
    fn shifts_of_contact(&mut self, q: &[f64]) -> Matrix;

    /// What contacts and actuators could do for a unit of each coordinate, in a shape at rest, in newtons or newton metres, if the
    /// motions of both surfaces and of the places at which they touch added up, and those of both ends of tendons: magnitudes to which
    /// the rounding of their forces and of their stiffness is relative.
    fn work_of_interactions(&mut self, q: &[f64], work: &mut [f64]);

    /// A contact whose surfaces overlap by more than a radius, if any.
    fn deep_penetration(&mut self, q: &[f64]) -> Option<Flaw>;

    /// Takes down where surfaces are in a shape: [`Self::have_tunnelled`] goes on from there.
    fn note_surfaces(&mut self, q: &[f64]);

    /// Whether surfaces pass through each other, or overlap by more than half of the given radius, on the
    /// straight path from the stored shape to `q`. Stores `q` afterwards.
    fn have_tunnelled(&mut self, q: &[f64], radius: Radius) -> bool;

    /// Whether surfaces touch in the state evaluated last.
    fn is_touched(&self) -> bool;
}

/// Contacts and stops of a model, as steps ask for them.
pub trait InImpact: InContact {
    /// By how much each [stop](super::Facts::has_stops) is deformed in a shape, negative where it does not act.
    fn beyond_stops(&mut self, q: &[f64], beyond: &mut Vec<f64>);

    /// Selects the linearisation of friction for an iteration: at its start, or after a step that took this
    /// fraction of the last increment. `None` selects exact tangents.
    fn follow_friction(&mut self, length: Option<f64>);

    /// Whether any surfaces overlap in a shape.
    fn overlaps(&mut self, q: &[f64]) -> bool;

    /// Whether an impact in a step of size `h`, in seconds, from the coordinates and velocities `before` to the given motion is too hard
    /// for the step.
    fn is_jolted(&mut self, before: [&[f64]; 2], motion: [&[f64]; 3], h: f64) -> bool;

    /// How surfaces that touch in a motion part again, of those whose impacts take less than ten steps of size `h`, in seconds: by the
    /// velocities `v_before` that the time `since` ago had. Allocates where surfaces approach each other.
    fn parting(&mut self, v_before: &[f64], motion: [&[f64]; 3], since: f64, h: f64) -> Parting;

    /// Whether surfaces have touched in any state evaluated since the last call.
    fn take_touched(&mut self) -> bool;

    /// Whether surfaces in the state evaluated last are so close that they may touch in the next one.
    fn may_touch(&self) -> bool;

    /// Whether such a step ends with more energy than it began with, by more than errors of steps that see their impacts.
    fn gains_energy(&mut self, before: [&[f64]; 2], motion: [&[f64]; 3], h: f64, beside: Beside) -> bool;

    /// What an impact in such a step, which stops what meets, has taken out of the motion.
    fn impact(&mut self, before: [&[f64]; 2], motion: [&[f64]; 3], h: f64) -> Option<Impact>;
}
