//! One-sided forces of a model: contacts, joint stops and tendons that can become slack.

use super::{Dynamics, GainCheck, Impact, InvalidShape, Radius, Separation};
use crate::numerics::linalg::Matrix;

/// Surfaces and stops count as only just touching up to this part of the lengths of which their gap is a difference: ten times the
/// tolerance of equilibria, well above rounding.
pub(crate) const REACHED: f64 = 1e-9;

/// A one-sided force at the limit of acting, with a gap of zero: rounding would decide whether it acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reached {
    /// The stop of a coordinate, not acting.
    Stop(usize),
    /// A pair of surfaces without a contact force.
    Surfaces(usize),
    /// An elastic tendon, by its row of the [`LengthTendons`](super::springs::LengthTendons), that is slack.
    Slack(usize),
    /// An elastic tendon, by the same row, that also resists shortening because others are then stretched.
    Taut(usize),
}

/// What a contact is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactText {
    /// Its name in messages and results.
    Name,
    /// Advice in sentences, or nothing, on a shape that is refused because its surfaces overlap deeply.
    AdviceOnDeepOverlap,
}

/// Softened contacts.
#[derive(Clone, Copy, Debug)]
pub struct Softened<'a> {
    /// For every pair of surfaces, an estimate of the force on it, newtons. Empty: the stiffness of each pair is a fraction of its own.
    pub forces: &'a [f64],
    /// The fraction of these forces that presses surfaces into each other by their soft depth, or of the stiffnesses.
    pub fraction: f64,
    /// Enlargement of obstacles, over the largest one. Obstacles that would press a body from opposite sides in `start` are not enlarged.
    pub enlargement: f64,
    /// The shape in which the first search begins.
    pub start: &'a [f64],
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
    /// The one with the larger share.
    pub fn deeper(known: Option<Self>, found: Option<Self>) -> Option<Self> {
        match (known, found) {
            (Some(known), Some(found)) if found.share <= known.share => Some(known),
            (known, found) => found.or(known),
        }
    }
}

/// How an iteration sees friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FrictionTreatment {
    /// As it acts, with exact tangents.
    Exact,
    /// Linearised as an unknown of its own: at the start of an iteration, or after a step that took this fraction of the last increment.
    Followed(f64),
    /// Along rods with the normal forces of the state evaluated last, so that it has a potential of the velocities.
    Held,
}

/// Contacts and stops of a model, as statics uses them.
pub trait InContact: Dynamics {
    /// The stops and pairs of surfaces that only just touch in a shape. Allocates.
    fn reached(&mut self, q: &[f64]) -> Vec<Reached>;

    /// Fixes whether these act, in all shapes; with an empty list, every force follows its gap again.
    fn decide(&mut self, reached: &[Reached]);

    /// Disables contact forces, or enables them again.
    fn leave_contact(&mut self, is_left: bool);

    /// Softens contacts: limits the stiffness of every pair of [`Self::shifts_of_contact`], and enlarges obstacles of thin rods. `None` undoes
    /// that. Returns whether any became softer.
    fn soften_contact(&mut self, soft: Option<Softened<'_>>) -> bool;

    /// The overlaps with the largest share in a shape: of all surfaces, over the thickness of the thinner one and the growth of softened
    /// obstacles; and of those with two sides, which excludes half-spaces, over the largest valid overlap ([`Self::deep_penetration`]) and that growth.
    fn deepest_overlaps(&mut self, q: &[f64]) -> [Option<Overlap>; 2];

    /// The overlap in a shape with the largest share.
    fn deepest_overlap(&mut self, q: &[f64]) -> Option<Overlap>;

    /// A text about a contact. Allocates.
    fn text_of_contact(&self, contact: usize, text: ContactText) -> String;

    /// Advice in sentences, or nothing: what to change if contacts are too soft, from the deepest overlap so far; and, after a failed
    /// run or search with these last shapes, the contact that overlaps most and the stop and tendon with the largest force in the last
    /// shape, or that are reached in the next one. Allocates.
    fn advice_at_end(&mut self, failed: &[&[f64]], deepest: Option<Overlap>) -> String;

    /// One row for every pair of surfaces that may touch: how far either of them moves at most for a unit step of each coordinate.
    /// Allocates.
    fn shifts_of_contact(&mut self, q: &[f64]) -> Matrix;

    /// Magnitudes of the generalised forces of contacts and actuators in a shape at rest, in newtons or newton metres, to which the
    /// rounding of forces and stiffness is relative: with the motions of both surfaces, of their places of contact and of both ends of
    /// tendons added up, not subtracted.
    fn work_of_interactions(&mut self, q: &[f64], work: &mut [f64]);

    /// A contact whose surfaces overlap by more than a radius, if any.
    fn deep_penetration(&mut self, q: &[f64]) -> Option<InvalidShape>;

    /// Stores the positions of surfaces in a shape, from which [`Self::have_tunnelled`] continues.
    fn store_surfaces(&mut self, q: &[f64]);

    /// Whether surfaces pass through each other, or overlap by more than half of the given radius, on the
    /// straight path from the stored shape to `q`. Stores `q` afterwards.
    fn have_tunnelled(&mut self, q: &[f64], radius: Radius) -> bool;

    /// Whether surfaces touch in the state evaluated last.
    fn is_touched(&self) -> bool;
}

/// Contacts and stops of a model, as integrators use them.
pub trait InImpact: InContact {
    /// By how much each [stop](super::Facts::has_stops) is deformed in a shape, negative where it does not act, in radians or parts of the
    /// model's length.
    fn beyond_stops(&mut self, q: &[f64], beyond: &mut Vec<f64>);

    /// Selects how an iteration sees friction from here on.
    fn treat_friction(&mut self, treatment: FrictionTreatment);

    /// Whether an impact in a step of size `h`, in seconds, from the coordinates and velocities `before` to the given motion is too hard
    /// for the step.
    fn has_unresolved_impact(&mut self, before: [&[f64]; 2], motion: [&[f64]; 3], h: f64) -> bool;

    /// How touching surfaces separate again whose impacts take less than ten steps of size `h`, in seconds. `v_before` are the
    /// velocities at the time `since` earlier. Allocates if surfaces approach each other.
    fn separation(&mut self, v_before: &[f64], motion: [&[f64]; 3], since: f64, h: f64) -> Separation;

    /// Whether surfaces have touched in any state evaluated since the last call.
    fn take_touched(&mut self) -> bool;

    /// Whether surfaces in the state evaluated last are so close that they may touch in the next one.
    fn may_touch(&self) -> bool;

    /// Whether the energy rose over such a step by more than the error of a step that resolves its impacts.
    fn gains_energy(&mut self, before: [&[f64]; 2], motion: [&[f64]; 3], h: f64, check: GainCheck) -> bool;

    /// Marks the coordinates that contact forces push in a state, and leaves the marks of others.
    fn mark_pushed(&mut self, state: [&[f64]; 2], marks: &mut [bool]);

    /// The hardest impact in such a step, and the energy that it took from the motion.
    fn impact(&mut self, before: [&[f64]; 2], motion: [&[f64]; 3], h: f64) -> Option<Impact>;
}
