//! Diagnosis of attempted steps: contacts, stops and impacts that the solver of a step does not see.

use super::impacts::{FollowedImpact, Impacts, Remedy, ResolvedLoss, StoppedImpact, StoppedImpacts};
use crate::error::{Interrupted, Number, Time};
use crate::integrators::Reason;
use crate::integrators::second_order::set_motion;
use crate::model::{
    CollidingParts, EnergySnapshot, Facts, ForwardScratch, GainCheck, Impact, InvalidShape, Model, Radius,
    Separation, have_missed, have_tunnelled, may_miss,
};
use crate::numerics::hermite;
use crate::numerics::tape::Tape;

/// Number of steps without memory after a step in which a slack tendon became taut, unless velocities were projected: the first
/// removes the velocity along the tendon, and its acceleration is that of this jump.
const STEPS_AFTER_STOP: usize = 2;

/// A step excites unresolved vibrations if the kinetic energy of `h` times its change of the accelerations exceeds this part of the
/// largest kinetic energy.
const EXCITED_ENERGY: f64 = 1e-3;

/// In addition, the energy must have changed by more than this part of the kinetic energy.
const CHANGED_ENERGY: f64 = 2e-3;

/// Impacts matter if surfaces separate for more than this number of steps afterwards. Impacts without rebound then lose at most a height of
/// `2 g dt^2`, four times the loss of a step without memory.
const STEPS_OF_FLIGHT: f64 = 4.0;

/// Whether impacts with this separation of surfaces matter. The criterion involves the colliding parts only, so it is the same in all frames.
pub(crate) fn matters(separation: &Separation) -> bool {
    separation.flight > STEPS_OF_FLIGHT
}

/// After a step without memory that only its parts could make, the whole step is tried again at every so many.
const WHOLE_AGAIN: usize = 4;

/// The first of these problems that an attempted step has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Diagnosis {
    /// Contact or a stop acts within the step but not at its ends: bodies thrown against a ceiling (`test_contact_passing`), joints
    /// that swing beyond a stop and back (`test_stops`).
    Missed,
    /// The step is too long for an impact, sometimes visible only as a gain of energy
    /// (`test_what_meets_within_a_step_does_not_rebound`, `test_stiff_boxes_do_not_gain_energy`).
    Unresolved,
    /// The end is invalid: surfaces penetrate each other deeply (`test_contact_hard`), or a rotation is too large for one step
    /// (`test_what_spins_freely_is_followed`).
    Invalid,
    /// Surfaces have passed through each other, or would have without the contact forces at the end of the step: balls and thin
    /// obstacles (`test_contact_passing`).
    Crossed,
    /// The step about doubles the energy: bodies leave each other through another side than they entered
    /// (`test_stiff_boxes_do_not_gain_energy`).
    Explodes,
    Valid,
}

impl Diagnosis {
    /// Why a step with this problem is attempted again.
    pub(crate) fn reason(self) -> Option<Reason> {
        Some(match self {
            Self::Missed => Reason::Missed,
            Self::Unresolved => Reason::Impact,
            Self::Invalid => Reason::InvalidEnd,
            Self::Crossed => Reason::PassedThrough,
            Self::Explodes => Reason::EnergyGain,
            Self::Valid => return None,
        })
    }
}

/// The kind of an attempted step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Of adaptive size. If the motion within the step is curved, its middle is examined too. The end is checked only while steps may
    /// be shortened because of it (`is_judged`).
    Adaptive { bends: bool, is_judged: bool },
    /// Of fixed size, by the scheme of the method.
    WithMemory,
    /// Without inertia, to an equilibrium.
    WithoutInertia,
    /// The same, along a way on which nothing has passed through a surface.
    Downhill,
    /// By the backward Euler method, in which colliding bodies do not rebound.
    WithoutMemory,
    /// By the backward Euler method, after shorter steps have failed too.
    Last,
}

/// Both ends of an attempted step: times, displacements, velocities, and accelerations followed by multipliers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ends<'a> {
    pub(crate) t: [f64; 2],
    /// The size of the step: their difference, but for rounding.
    pub(crate) h: f64,
    pub(crate) q: [&'a [f64]; 2],
    pub(crate) v: [&'a [f64]; 2],
    pub(crate) a: [&'a [f64]; 2],
}

impl<'a> Ends<'a> {
    /// Displacements and velocities at the start.
    pub(super) fn before(&self) -> [&'a [f64]; 2] {
        [self.q[0], self.v[0]]
    }

    /// The motion at the end, without multipliers.
    pub(super) fn after(&self) -> [&'a [f64]; 3] {
        [self.q[1], self.v[1], &self.a[1][..self.q[1].len()]]
    }

    /// The straight path from the start to the displacements `q` at the end.
    fn way<'b>(&self, q: &'b [f64]) -> impl Iterator<Item = (f64, &'b [f64])>
    where
        'a: 'b,
    {
        [(self.t[0], self.q[0]), (self.t[1], q)].into_iter()
    }
}

/// State of one-sided forces that persists from step to step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Unilateral {
    /// Number of remaining steps without memory after an unresolved impact.
    pub(super) steps_without_memory: usize,
    /// Number of the last steps without memory that were made in parts, one after the other.
    pub(super) parts: usize,
    /// Whether surfaces touch, now and in the step that is tried.
    pub(super) touches: bool,
    pub(super) will_touch: bool,
    /// Whether they touched in any iterate of that step.
    pub(crate) has_touched: bool,
    pub(super) impacts: Impacts,
    /// Whether impacts are followed in parts of a step of fixed size rather than stopped, if contacts would give back much energy; the one
    /// that is followed, or that has not ended with the last step.
    follows: bool,
    pub(super) followed: Option<FollowedImpact>,
    /// Whether steps of fixed size are repeated if impacts matter; then also the size of the last step, and how the surfaces that collide in
    /// it would separate.
    resolves: bool,
    size: f64,
    separation: Separation,
    /// Whether the last step was repeated by a method that resolves its impacts, and whether the step after it excites unresolved
    /// vibrations.
    pub(super) resumes: bool,
    is_excited: bool,
    /// The impacts before the last step of fixed size.
    impacts_before: Impacts,
    stopped: StoppedImpacts,
    /// Steps without inertia in which the shape has snapped to another one, and the end of the first of them.
    snaps: usize,
    first_snap: f64,
    /// The end of the first of the last steps without inertia that end in unstable equilibria.
    unstable_from: Option<f64>,
    colliding_parts: CollidingParts,
    /// Energies at the current state, if surfaces touch and the last step resolved their forces.
    pub(super) snapshot: Option<EnergySnapshot>,
    /// Displacements at a time within the step, and memory of [`have_missed`].
    place: Vec<f64>,
    memory: Vec<f64>,
}

impl Unilateral {
    /// The first problem of a step. Whether surfaces touch is taken from the last evaluation of the model, by the step itself.
    pub(crate) fn diagnose<M: Model + ?Sized>(
        &mut self,
        model: &mut M,
        ends: &Ends<'_>,
        kind: Kind,
    ) -> Result<Diagnosis, Interrupted> {
        let (has_contact, t, q) = (model.facts().has_contact, ends.t[1], ends.q[1]);
        if let Kind::Adaptive { bends, .. } = kind
            && may_miss(model)
            && self.has_missed(model, ends, bends)?
        {
            return Ok(Diagnosis::Missed);
        }
        let is_unresolved = match kind {
            Kind::Adaptive { is_judged: false, .. } => false,
            Kind::Adaptive { .. } => {
                model.set_time(t)?;
                has_contact && model.gains_energy(ends.before(), ends.after(), ends.h, GainCheck::Kinetic)
            }
            Kind::WithMemory => self.is_unresolved(model, ends)?,
            Kind::WithoutInertia | Kind::Downhill | Kind::WithoutMemory | Kind::Last => false,
        };
        if is_unresolved {
            return Ok(Diagnosis::Unresolved);
        }
        if let Kind::Adaptive { is_judged, .. } = kind {
            let is_invalid =
                is_judged && matches!(model.invalid_shape(q), Some(InvalidShape::Unresolved { .. }));
            return Ok(if is_invalid { Diagnosis::Invalid } else { Diagnosis::Valid });
        }
        model.set_time(t)?;
        if model.invalid_shape(q).is_some() || model.deep_penetration(q).is_some() {
            return Ok(Diagnosis::Invalid);
        }
        if has_contact
            && kind != Kind::Downhill
            && (have_tunnelled(model, ends.way(q), Radius::Smaller)?
                || matches!(kind, Kind::WithMemory | Kind::WithoutMemory)
                    && model.is_touched()
                    && self.would_have_tunnelled(model, ends)?)
        {
            return Ok(Diagnosis::Crossed);
        }
        let explodes = match kind {
            Kind::WithoutMemory => self.gains_energy(model, ends, GainCheck::Mechanical)?,
            Kind::Last => self.gains_energy(model, ends, GainCheck::Explosion)?,
            Kind::Adaptive { .. } | Kind::WithMemory | Kind::WithoutInertia | Kind::Downhill => false,
        };
        Ok(if explodes { Diagnosis::Explodes } else { Diagnosis::Valid })
    }

    fn has_missed<M: Model + ?Sized>(
        &mut self,
        model: &mut M,
        ends: &Ends<'_>,
        bends: bool,
    ) -> Result<bool, Interrupted> {
        let [start, end] = [0, 1].map(|i| (ends.t[i], ends.q[i]));
        if !bends {
            return have_missed(model, &[start, end], ends.v, &mut self.memory);
        }
        hermite::middle(ends.h, ends.q, ends.v, &mut self.place);
        let middle = (0.5 * (ends.t[0] + ends.t[1]), &self.place[..]);
        have_missed(model, &[start, middle, end], ends.v, &mut self.memory)
    }

    /// Whether surfaces that touch at the end would have passed through each other without contact forces, which may have pushed
    /// them aside.
    fn would_have_tunnelled<M: Model + ?Sized>(
        &mut self,
        model: &mut M,
        ends: &Ends<'_>,
    ) -> Result<bool, Interrupted> {
        let ([q, v], h) = (ends.before(), ends.t[1] - ends.t[0]);
        self.place.clear();
        self.place.extend(q.iter().zip(v).map(|(q, v)| q + h * v));
        have_tunnelled(model, ends.way(&self.place), Radius::Larger)
    }

    /// Whether the step is too long for an impact in it.
    pub(super) fn is_unresolved<M: Model + ?Sized>(
        &mut self,
        model: &mut M,
        ends: &Ends<'_>,
    ) -> Result<bool, Interrupted> {
        if !model.facts().has_contact {
            return Ok(false);
        }
        let a = set_motion(model, ends.t[1], ends.q[1], ends.a[1])?;
        let has_unresolved_impact =
            model.has_unresolved_impact(ends.before(), [ends.q[1], ends.v[1], a], ends.h);
        self.will_touch = model.is_touched();
        Ok(has_unresolved_impact || self.gains_energy(model, ends, GainCheck::Kinetic)?)
    }

    /// Whether surfaces that touch at one of its ends, or did on the way to the solution of its equations, make the step gain energy:
    /// bodies that have come too deep push each other out by another side than they entered, and Newton's method may leave a
    /// surface for a solution far away from it.
    fn gains_energy<M: Model + ?Sized>(
        &self,
        model: &mut M,
        ends: &Ends<'_>,
        check: GainCheck,
    ) -> Result<bool, Interrupted> {
        if !model.facts().has_contact || !(self.touches || self.has_touched || model.is_touched()) {
            return Ok(false);
        }
        model.set_time(ends.t[1])?;
        Ok(model.gains_energy(ends.before(), ends.after(), ends.h, check))
    }

    /// Whether a step after resolved impacts excites vibrations that it does not resolve: the change of its accelerations would change
    /// velocities considerably, and its energy changes without dissipation or supply. Such a step is repeated, too.
    pub(super) fn excites<M: Model + ?Sized>(
        &mut self,
        model: &mut M,
        ends: &Ends<'_>,
    ) -> Result<bool, Interrupted> {
        let (h, [before, after]) = (ends.h, ends.a);
        model.set_time(ends.t[1])?;
        self.place.clear();
        self.place.extend(ends.q[1].iter().zip(before.iter().zip(after)).map(|(_, (a0, a1))| h * (a1 - a0)));
        let [of_change, kinetic] = [&self.place[..], ends.v[1]].map(|v| model.energy(ends.q[1], v).kinetic);
        if of_change <= EXCITED_ENERGY * kinetic.max(self.impacts.largest_kinetic()) {
            return Ok(false);
        }
        let Facts { is_driven, is_carried, varies_in_time, .. } = *model.facts();
        self.is_excited = is_carried || varies_in_time || {
            let mut change = 0.0;
            for (end, sign) in [(0, -1.0), (1, 1.0)] {
                let [q, v, a] = [ends.q[end], ends.v[end], &ends.a[end][..ends.q[end].len()]];
                let supplied = if is_driven { model.supplied_power(q, v, a) } else { 0.0 };
                change +=
                    sign * model.energy(q, v).total() + 0.5 * h * (model.dissipated_power(q, v) - supplied);
            }
            change.abs() > CHANGED_ENERGY * kinetic
        };
        Ok(self.is_excited)
    }

    /// Whether the last step of fixed size followed resolved impacts and excited unresolved vibrations.
    pub(crate) fn is_excited(&self) -> bool {
        self.is_excited
    }

    /// Records the energy lost in an accepted step at one of whose ends surfaces touch.
    pub(super) fn follow_impact<M: Model + ?Sized>(
        &mut self,
        model: &mut M,
        ends: &Ends<'_>,
    ) -> Result<(), Interrupted> {
        if !self.touches && !self.will_touch {
            return Ok(());
        }
        let motions = [0, 1].map(|i| [ends.q[i], ends.v[i], ends.a[i]]);
        let before = match self.snapshot.take() {
            Some(snapshot) => Some(snapshot),
            None => snapshot(model, ends.t[0], motions[0])?,
        };
        let after = snapshot(model, ends.t[1], motions[1])?;
        if let (Some(before), Some(after)) = (&before, &after) {
            let states = motions.map(|[q, v, _]| [q, v]);
            self.colliding_parts.find(model, states);
            let kinetic = [(states[0], before), (states[1], after)]
                .map(|(state, snapshot)| self.colliding_parts.kinetic(model, state, snapshot.kinetic));
            let gain = self.colliding_parts.gain(model, states[0], states[1], after.total - before.total);
            let lost = 0.5 * ends.h * (before.supplied + after.supplied) - gain;
            self.impacts.follow(lost, kinetic[0].max(kinetic[1]), after.elastic);
        }
        self.snapshot = after.filter(|_| self.will_touch);
        Ok(())
    }

    /// A slack tendon becomes taut in the next step, which, like those after it, is made without memory.
    pub(crate) fn stop(&mut self) {
        self.steps_without_memory = STEPS_AFTER_STOP + 1;
    }

    /// Velocities were projected onto the taut tendons: at most one step without memory remains, and only with contact.
    pub(crate) fn resume_after_stop(&mut self, has_contact: bool) {
        self.steps_without_memory = self.steps_without_memory.min(usize::from(has_contact));
    }

    /// Whether surfaces touch at the end of the last step.
    pub(crate) fn touches(&self) -> bool {
        self.touches
    }

    /// Forgets the energies after a jump of forces or velocities.
    pub(crate) fn forget(&mut self) {
        self.snapshot = None;
    }

    /// Sets whether steps of fixed size are repeated if impacts matter, and whether they follow impacts in parts.
    pub(crate) fn set_treatment(&mut self, [resolves, follows]: [bool; 2]) {
        (self.resolves, self.follows) = (resolves, follows);
    }

    /// The impact that a step of size `h` to `t` has stopped, if it is to be followed in parts of the step instead.
    pub(super) fn to_follow(&self, impact: &Impact, t: f64, h: f64) -> Option<FollowedImpact> {
        if self.follows { self.impacts.followed(impact, t, h) } else { None }
    }

    /// The impact that was followed up to time `t` and has not ended.
    pub(super) fn unfinished(&self, t: f64) -> Option<FollowedImpact> {
        self.followed.filter(|followed| self.touches && followed.lasts(t))
    }

    /// Whether surfaces touch, at the start of a step or at the end of an attempted one, whose size does not resolve the followed impact.
    pub(super) fn is_too_long(&self, touches: bool, h: f64) -> bool {
        touches && self.followed.is_some_and(|followed| !followed.is_resolved_by(h))
    }

    /// The motion starts in this shape, in which surfaces may overlap.
    pub(crate) fn start<M: Model + ?Sized>(
        &mut self,
        model: &mut M,
        t: f64,
        q: &[f64],
    ) -> Result<(), Interrupted> {
        model.set_time(t)?;
        self.touches = model.deepest_overlap(q).is_some();
        Ok(())
    }

    /// Whether a whole step without memory is tried before its parts.
    pub(super) fn tries_whole(&self) -> bool {
        self.parts.is_multiple_of(WHOLE_AGAIN)
    }

    /// A step of fixed size begins.
    pub(super) fn begin_step(&mut self, h: f64) {
        self.impacts_before = self.impacts;
        self.stopped.begin_step();
        (self.size, self.separation, self.is_excited) = (h, Separation::default(), false);
    }

    /// Records how surfaces would separate that collide during a step or a part of one, or that touch at its start only.
    pub(super) fn follow_separation<M: Model + ?Sized>(
        &mut self,
        model: &mut M,
        ends: &Ends<'_>,
    ) -> Result<(), Interrupted> {
        if !self.resolves {
            return Ok(());
        }
        let separation = if self.will_touch || self.touches {
            let (end, since) = if self.will_touch { (1, ends.h) } else { (0, 0.0) };
            let a = set_motion(model, ends.t[end], ends.q[end], ends.a[end])?;
            model.separation(ends.v[0], [ends.q[end], ends.v[end], a], since, self.size)
        } else if self.has_touched {
            self.separation_without_contact(model, ends)?
        } else {
            return Ok(());
        };
        self.separation = self.separation.and(separation);
        Ok(())
    }

    /// How surfaces would separate that collide during a step and are apart at its end, from their overlap without contact forces. Allocates.
    fn separation_without_contact<M: Model + ?Sized>(
        &mut self,
        model: &mut M,
        ends: &Ends<'_>,
    ) -> Result<Separation, Interrupted> {
        let [q, v] = ends.before();
        self.place.clear();
        self.place.extend(q.iter().zip(v).map(|(q, v)| q + ends.h * v));
        model.set_time(ends.t[1])?;
        let (mut a, mut scratch) = (vec![0.0; q.len()], ForwardScratch::of(model));
        if model.deepest_overlap(&self.place).is_none()
            || model.forward_dynamics(&self.place, v, &mut a, &mut scratch).is_err()
        {
            return Ok(Separation::default());
        }
        Ok(model.separation(v, [&self.place, v, &a], ends.h, self.size))
    }

    /// How surfaces that have collided in the last step of fixed size would separate.
    pub(crate) fn separation(&self) -> Separation {
        self.separation
    }

    /// Whether the energy of impacts without rebound in the last step counts as lost: not if impacts are resolved and these do not matter.
    pub(super) fn counts(&self) -> bool {
        !self.resolves || matters(&self.separation)
    }

    /// The last step was repeated with resolved impacts and has lost nothing. Accelerations of unresolved vibrations would add energy in
    /// the next step, which is therefore made without memory if it is [excited](Self::is_excited).
    pub(crate) fn resolve(&mut self, touches: bool) {
        self.impacts = self.impacts.without_losses_since(&self.impacts_before);
        self.stopped.undo_step();
        (self.steps_without_memory, self.resumes, self.touches) = (1, true, touches);
        self.forget();
    }

    /// Records an impact of rods that a step has stopped. Allocates if the step before has not.
    pub(super) fn record_stopped(&mut self, impact: &Impact, ends: &Ends<'_>) {
        self.impacts.compare_rods(impact);
        self.stopped.add(impact, (ends.t, self.size), ends.before());
    }

    /// The worst impact of rods that steps have stopped, if all that such impacts have lost would matter.
    pub(crate) fn stopped_impact(&self) -> Option<&StoppedImpact> {
        self.stopped.worst().filter(|stopped| self.impacts.may_doubt_rods(stopped))
    }

    /// Why the motion in steps of this size may be wrong, by what a motion loses that resolves [that impact](Self::stopped_impact).
    pub(crate) fn doubt_of_rods(&self, dt: f64, remedy: Remedy, resolved: ResolvedLoss) -> Option<String> {
        self.impacts.doubt_of_rods(dt, remedy, self.stopped_impact()?, resolved)
    }

    /// Records whether the step without inertia to this time ends in a stable equilibrium.
    pub(crate) fn record_stability(&mut self, t: f64, is_stable: bool) {
        if is_stable {
            self.unstable_from = None;
        } else {
            self.unstable_from.get_or_insert(t);
        }
    }

    /// Records that the shape has snapped to another one in the step to this time.
    pub(crate) fn record_snap(&mut self, t: f64) {
        if self.snaps == 0 {
            self.first_snap = t;
        }
        self.snaps += 1;
    }

    /// Why the motion in steps of this size may be wrong although all steps were made.
    pub(crate) fn doubt(&self, dt: f64, remedy: Remedy) -> Option<String> {
        if self.snaps > 0 {
            let (steps, first) = (self.snaps, Number(self.first_snap));
            let steps = if steps == 1 { "one step".to_owned() } else { format!("{steps} steps") };
            return Some(format!(
                "In {steps}, first in the one to t = {first}, no equilibrium is near: a contact begins to slip, the shape snaps through to another \
                 one, or a part is not supported. Such steps lose the energy of this motion. If it matters for the result, use a method with inertia."
            ));
        }
        if let Some(t) = self.unstable_from {
            return Some(format!(
                "From t = {} on the shape is an unstable equilibrium, which steps without inertia do not leave: take shorter steps up to this time, \
                 so that they follow the stable branch, perturb the shape slightly, or use a method with inertia.",
                Time(t)
            ));
        }
        self.impacts.doubt(dt, remedy)
    }

    /// Serialises additional data of steps without inertia.
    pub(crate) fn serialise_snaps(&mut self, tape: &mut Tape<'_>) {
        tape.count(&mut self.snaps);
        tape.number(&mut self.first_snap);
        tape.optional(&mut self.unstable_from, 0.0, Tape::number);
    }

    /// Serialises all data that persist from step to step.
    pub(crate) fn serialise(&mut self, tape: &mut Tape<'_>) {
        tape.below(STEPS_AFTER_STOP + 1, &mut self.steps_without_memory);
        tape.count(&mut self.parts);
        tape.flag(&mut self.touches);
        // In one number: simulations saved by earlier versions know whether motions resume alone.
        let mut state = usize::from(self.resumes) + 2 * usize::from(self.followed.is_some());
        tape.below(4, &mut state);
        self.resumes = state % 2 == 1;
        if tape.reads() {
            self.followed = (state >= 2).then(FollowedImpact::default);
        }
        if let Some(followed) = &mut self.followed {
            followed.serialise(tape);
        }
        self.impacts.serialise(tape);
    }
}

/// Whether a change of the energy shows what steps lose: not with dissipation, which is inaccurate within impacts, and not if the base or
/// loads vary in time, whose power is known at single times only.
pub(super) fn knows_losses(facts: &Facts) -> bool {
    !(facts.is_carried || facts.varies_in_time || facts.is_damped)
}

/// Energies and supplied power of a state; `None` if they do not show [what steps lose](knows_losses).
fn snapshot<M: Model + ?Sized>(
    model: &mut M,
    t: f64,
    [q, v, a]: [&[f64]; 3],
) -> Result<Option<EnergySnapshot>, Interrupted> {
    if !knows_losses(model.facts()) {
        return Ok(None);
    }
    let is_driven = model.facts().is_driven;
    model.set_time(t)?;
    let energy = model.energy(q, v);
    let supplied = if is_driven { model.supplied_power(q, v, &a[..q.len()]) } else { 0.0 };
    Ok(Some(EnergySnapshot {
        total: energy.total(),
        kinetic: energy.kinetic,
        elastic: energy.elastic,
        supplied,
    }))
}
