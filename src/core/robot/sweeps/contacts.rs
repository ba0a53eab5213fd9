//! Contact queries of the sweeps: surfaces that touch, have touched or may touch.

use std::sync::Arc;

use super::Sweeps;
use crate::model::{FrictionTreatment, Overlap, Radius, Reached, Separation, Softened};
use crate::robot::effects::actuator::force as actuation;
use crate::robot::effects::contact::query::ReportedTouch;
use crate::robot::effects::contact::state::ContactState;
use crate::robot::effects::contact::{detection, force as contact, query, tunnelling};
use crate::robot::effects::joint_forces;
use crate::robot::kernel::sizes::Motions;
use crate::robot::kernel::{elasticity, lines, sizes};
use crate::robot::turning::Turning;

impl<G: Turning> Sweeps<G> {
    /// Stops, and pairs of surfaces without deeper contact, that only just touch. `length` is that of the robot. Allocates.
    pub(crate) fn reached(&mut self, q: &[f64], length: f64) -> Vec<Reached> {
        self.with_zeros(|sweeps, zeros| sweeps.update_motion([q, zeros, zeros]));
        let Self { plan, work, .. } = self;
        let mut sizes = vec![0.0; plan.n];
        elasticity::typical_coordinates(plan, length, &mut sizes);
        let stops = joint_forces::reached_stops(plan, q, &sizes).map(Reached::Stop);
        stops.chain(query::reached(plan, work, length).into_iter().map(Reached::Surfaces)).collect()
    }

    /// Fixes whether these act; with an empty list, every force follows its gap again.
    pub(crate) fn decide(&mut self, reached: &[Reached]) {
        if let Some(undecided) = self.undecided.take() {
            self.plan = undecided;
        }
        self.forget_touches();
        if reached.is_empty() {
            return;
        }
        let mut plan = (*self.plan).clone();
        let length_tendons: Vec<usize> = self.length_tendons().map(|(i, _)| i).collect();
        for reached in reached {
            // The unloaded robot has neither contacts nor actuators.
            match *reached {
                Reached::Stop(k) => joint_forces::remove_stops(&mut plan, k),
                Reached::Surfaces(p) => {
                    let pair = plan.effects.contacts.pairs.get_mut(p);
                    pair.into_iter().for_each(|pair| pair.law.stiffness = 0.0);
                }
                Reached::Slack(row) | Reached::Taut(row) => {
                    let actuator = length_tendons.get(row).map(|&i| &mut plan.effects.actuation.actuators[i]);
                    actuator.into_iter().for_each(|actuator| {
                        actuator.law.decide(matches!(*reached, Reached::Taut(_)));
                    });
                }
            }
        }
        self.undecided = Some(std::mem::replace(&mut self.plan, Arc::new(plan)));
    }

    /// Disables contact forces, or enables them again.
    pub(crate) fn leave_contact(&mut self, is_left: bool) {
        self.work.effects.contact.is_left = is_left;
        self.work.motion_is_known = false;
    }

    /// Whether contact forces are disabled.
    pub(crate) fn has_left_contact(&self) -> bool {
        self.work.effects.contact.is_left
    }

    /// Marks contact points, whose laws or surfaces change, and the motion as unknown.
    fn forget_touches(&mut self) {
        self.work.motion_is_known = false;
        self.work.effects.contact.forget();
        self.work.effects.contact.clearance.forget();
    }

    /// Limits the stiffness of every pair, and enlarges obstacles of thin rods that became softer; `None` undoes that. Returns whether any
    /// became softer.
    pub(crate) fn soften_contact(&mut self, soft: Option<Softened<'_>>) -> bool {
        self.forget_touches();
        let ContactState { stiffest, grown, .. } = &mut self.work.effects.contact;
        let mut is_softer = false;
        for (p, pair) in self.plan.effects.contacts.pairs.iter().enumerate() {
            (stiffest[p], grown[p]) = (f64::INFINITY, 0.0);
            let Some(Softened { forces, fraction, enlargement, .. }) = soft else { continue };
            stiffest[p] = match forces.get(p) {
                Some(force) => pair.stiffness_for_soft_depth(fraction * force),
                None => fraction * pair.law.stiffness,
            };
            if stiffest[p] < pair.law.stiffness {
                is_softer = true;
                grown[p] = pair.growth * enlargement;
            }
        }
        if let Some(Softened { start, .. }) = soft.filter(|soft| is_softer && soft.enlargement > 0.0) {
            self.shrink_opposed(start);
        }
        is_softer
    }

    /// Takes back the enlargement of obstacles that would press from opposite sides on what the same coordinates move in this shape, also where
    /// one moves it towards the other by as much as it is enlarged: they would squeeze it out between them.
    fn shrink_opposed(&mut self, q: &[f64]) {
        self.work.effects.contact.grown.iter_mut().for_each(|grown| *grown *= 2.0);
        self.find_touches(q);
        let Self { plan, work, .. } = self;
        let pairs = &plan.effects.contacts.pairs;
        let are_coupled = |a: usize, b: usize| {
            let mut others = pairs[b].reaches.iter();
            others.any(|b| pairs[a].reaches.iter().any(|a| a.start < b.end && b.start < a.end))
        };
        let ContactState { touches, grown, .. } = &mut work.effects.contact;
        let mut is_opposed = vec![false; grown.len()];
        for (i, one) in touches.iter().enumerate() {
            for other in &touches[..i] {
                let are_opposed = one.contact_point.normal.dot(other.contact_point.normal) < 0.0;
                if one.pair != other.pair && are_opposed && are_coupled(one.pair, other.pair) {
                    (is_opposed[one.pair], is_opposed[other.pair]) = (true, true);
                }
            }
        }
        for (grown, is_opposed) in grown.iter_mut().zip(is_opposed) {
            *grown = if is_opposed { 0.0 } else { 0.5 * *grown };
        }
        self.forget_touches();
    }

    /// The overlaps with the largest share: of all surfaces, over the thickness of the thinner one and the growth of softened obstacles, and of
    /// those with two sides, over the largest valid overlap and that growth.
    pub(crate) fn deepest_overlaps(&mut self, q: &[f64]) -> [Option<Overlap>; 2] {
        self.find_touches(q);
        let Self { plan, work, .. } = self;
        let mut deepest = [None; 2];
        for touch in &work.effects.contact.touches {
            let pair = &plan.effects.contacts.pairs[touch.pair];
            let (depth, grown) = (touch.contact_point.overlap, work.effects.contact.grown[touch.pair]);
            let over = |thickness: f64| {
                Some(Overlap { contact: pair.contact, depth, share: depth / (thickness + grown) })
            };
            deepest[0] = Overlap::deeper(deepest[0], over(pair.thickness));
            if tunnelling::has_two_sides(plan, pair) {
                deepest[1] = Overlap::deeper(deepest[1], over(query::largest_valid_overlap(touch)));
            }
        }
        deepest
    }

    /// The overlap with the largest share. Does not change [`Self::take_touched`].
    pub(crate) fn deepest_overlap(&mut self, q: &[f64]) -> Option<Overlap> {
        let has_touched = self.work.effects.contact.has_touched;
        self.find_touches(q);
        self.work.effects.contact.has_touched = has_touched;
        let Self { plan, work, .. } = self;
        let overlaps = work.effects.contact.touches.iter().map(|touch| {
            let pair = &plan.effects.contacts.pairs[touch.pair];
            let depth = touch.contact_point.overlap;
            Overlap { contact: pair.contact, depth, share: depth / pair.thickness }
        });
        overlaps.fold(None, |deepest, overlap| Overlap::deeper(deepest, Some(overlap)))
    }

    /// Motions of the surfaces of every pair of contacts by the coordinates, and their number for each pair. Allocates.
    pub(crate) fn motions_of_contact(&mut self, q: &[f64]) -> (Motions, Vec<usize>) {
        self.with_zeros(|sweeps, zeros| sweeps.update_motion([q, zeros, zeros]));
        sizes::motions_of_contact(&self.plan, &self.work)
    }

    /// Magnitudes of the generalised forces of contacts and actuators. Allocates.
    pub(crate) fn work_of_interactions(&mut self, q: &[f64]) -> Vec<f64> {
        self.with_zeros(|sweeps, zeros| sweeps.update_motion([q, zeros, zeros]));
        let Self { plan, work, tangent, .. } = self;
        let mut most = sizes::work_of_contact(plan, work);
        lines::find(plan, work, &mut tangent.effects.actuation);
        for (i, actuator) in plan.effects.actuation.actuators.iter().enumerate() {
            let force = work.effects.actuation.forces[i].value.abs();
            for &k in &actuator.reaches {
                most[k] += force * actuation::reach(plan, work, &tangent.effects.actuation, i, k);
            }
        }
        most
    }

    /// Selects how an iteration sees friction. Returns whether its forces change.
    pub(crate) fn treat_friction(&mut self, treatment: FrictionTreatment) -> bool {
        let length = match treatment {
            FrictionTreatment::Followed(length) => Some(length),
            FrictionTreatment::Exact | FrictionTreatment::Held => None,
        };
        let followed = &mut self.tangent.effects.contact.followed;
        followed.is_new |= length.is_none();
        followed.length = length;
        let contact = &mut self.work.effects.contact;
        let holds = treatment == FrictionTreatment::Held;
        let changes = holds || contact.held.is_some();
        if changes {
            contact.hold_friction(holds);
            self.forget_touches();
        }
        changes
    }

    /// Whether nothing touches in the motion evaluated last.
    pub(crate) fn is_known_apart(&self) -> bool {
        self.work.motion_is_known && self.work.effects.contact.touches.is_empty()
    }

    /// Stores the approach velocities of surfaces that touch in a motion; false if none do.
    pub(crate) fn store_rates(&mut self, motion: [&[f64]; 3]) -> bool {
        self.update_motion(motion);
        query::store_rates(&mut self.work);
        !self.work.effects.contact.touches.is_empty()
    }

    /// Whether a step of size `h` that ends in a motion of the same shape is too long for the impacts in it.
    pub(crate) fn has_unresolved_impact(&mut self, motion: [&[f64]; 3], h: f64) -> bool {
        self.update_motion(motion);
        query::has_unresolved_impact(&self.plan, &self.work, h)
    }

    /// Whether surfaces that touch in a shape may separate again, by the velocities before and now.
    pub(crate) fn may_separate(&mut self, [q, v_before, v]: [&[f64]; 3], h: f64) -> bool {
        self.with_zeros(|sweeps, zeros| {
            [v_before, v].into_iter().any(|v| {
                sweeps.update_motion([q, v, zeros]);
                query::may_separate(&sweeps.work, h)
            })
        })
    }

    /// Stores the accelerations with which touching surfaces separate in a motion without contact forces.
    pub(crate) fn store_openings(&mut self, motion: [&[f64]; 3]) {
        self.update_motion(motion);
        query::store_openings(&self.plan, &mut self.work);
    }

    /// Pairs of surfaces whose impacts seem to take many steps of size `h` because others push them.
    pub(crate) fn between_others(&self, h: f64) -> Vec<usize> {
        query::between_others(&self.work, h)
    }

    /// Leaves forces to this pair of surfaces alone, or enables all again.
    pub(crate) fn enable_only(&mut self, pair: Option<usize>) {
        self.forget_touches();
        for (p, stiffest) in self.work.effects.contact.stiffest.iter_mut().enumerate() {
            *stiffest = if pair.is_none_or(|pair| pair == p) { f64::INFINITY } else { 0.0 };
        }
    }

    /// Stores how stiff the places are where this pair touches, or all do, in a motion with its forces, if stiffer than stored.
    pub(crate) fn store_stiffnesses(&mut self, motion: [&[f64]; 3], pair: Option<usize>) {
        self.update_motion(motion);
        query::store_stiffnesses(&self.plan, &mut self.work, pair);
    }

    /// How surfaces that touch in a motion of the same shape part again, in steps of size `h`.
    pub(crate) fn separation(
        &mut self,
        motion: [&[f64]; 3],
        since: f64,
        h: f64,
        by_weight: bool,
    ) -> Separation {
        self.update_motion(motion);
        query::separation(&self.plan, &self.work, since, h, by_weight)
    }

    /// The hardest impact in a step that ends in a motion of the same shape.
    pub(crate) fn fastest_impact(&mut self, motion: [&[f64]; 3]) -> Option<query::FastestImpact> {
        self.update_motion(motion);
        query::fastest_impact(&self.plan, &self.work)
    }

    /// Evaluates a state for queries about contact points in its shape.
    pub(crate) fn touch(&mut self, [q, qd]: [&[f64]; 2]) {
        if !self.work.motion_is_known || self.work.kinematics_of != q {
            self.update_velocities(q, qd);
        }
    }

    /// Whether surfaces touch in the state evaluated last.
    pub(crate) fn is_touched(&self) -> bool {
        !self.work.effects.contact.touches.is_empty()
    }

    /// Whether surfaces have touched in any state evaluated since the last call.
    pub(crate) fn take_touched(&mut self) -> bool {
        std::mem::take(&mut self.work.effects.contact.has_touched)
    }

    /// Whether surfaces in the state evaluated last are so close that they may touch in the next one.
    pub(crate) fn may_touch(&self) -> bool {
        contact::may_touch(&self.work.effects.contact)
    }

    /// Stores the positions of surfaces in a shape, from which [`Self::have_tunnelled`] continues.
    pub(crate) fn store_surfaces(&mut self, q: &[f64]) {
        // With a moving base the world moves even if the shape does not.
        let is_stored = self.plan.world.motion.is_none() && self.work.effects.contact.cached.of == q;
        if !tunnelling::is_possible(&self.plan) || is_stored || self.store_clear_surfaces(q) {
            return;
        }
        self.update_surfaces(q);
        tunnelling::store_surfaces(&mut self.work);
    }

    /// Stores a shape in which nothing is near, with its positions pending.
    fn store_clear_surfaces(&mut self, q: &[f64]) -> bool {
        let Self { plan, work, .. } = self;
        let is_clear = detection::is_clear(plan, &work.effects.contact, q);
        if is_clear {
            work.effects.contact.cached.store_pending(q);
        }
        is_clear
    }

    /// Computes positions of the stored shape that are pending.
    fn update_pending_surfaces(&mut self) {
        if self.work.effects.contact.cached.is_pending {
            let q = std::mem::take(&mut self.work.effects.contact.cached.of);
            self.update_surfaces(&q);
            tunnelling::store_surfaces(&mut self.work);
        }
    }

    /// Whether surfaces have passed through each other on the straight path to a shape, which is then stored.
    pub(crate) fn have_tunnelled(&mut self, q: &[f64], radius: Radius) -> bool {
        if self.work.effects.contact.is_left || !tunnelling::is_possible(&self.plan) {
            return false;
        }
        // Places that are far before and after are far on the straight paths between.
        let is_clear = |of: &[f64]| detection::is_clear(&self.plan, &self.work.effects.contact, of);
        if is_clear(q) && is_clear(&self.work.effects.contact.cached.of) {
            self.work.effects.contact.cached.store_pending(q);
            return false;
        }
        self.update_pending_surfaces();
        self.update_surfaces(q);
        let have_tunnelled = tunnelling::has_tunnelled(&self.plan, &mut self.work, radius);
        tunnelling::store_surfaces(&mut self.work);
        have_tunnelled
    }

    fn update_surfaces(&mut self, q: &[f64]) {
        self.update_kinematics(q);
        detection::update_positions(&self.plan, &mut self.work);
    }

    /// A contact whose surfaces overlap by more than a radius, and its overlap.
    pub(crate) fn deep_penetration(&mut self, q: &[f64]) -> Option<(usize, f64)> {
        let Self { plan, work, .. } = self;
        let contact = &mut work.effects.contact;
        // Contact points in memory belong to another shape.
        if contact.touches.is_empty() && !contact.is_left && detection::is_clear(plan, contact, q) {
            contact.mark_apart();
            return None;
        }
        self.find_touches(q);
        query::deep_penetration(&self.plan, &self.work)
    }

    /// Energy of the overlaps in the shape evaluated last.
    pub(crate) fn overlap_energy(&self) -> f64 {
        query::overlap_energy(&self.work)
    }

    /// The coordinates that move either side of contact points with a force, in the motion evaluated last.
    pub(crate) fn pushed(&self) -> impl Iterator<Item = usize> {
        let touches = self.work.effects.contact.touches.iter();
        let pressed = touches.filter(|touch| touch.contact_force.normal_force != 0.0);
        pressed
            .flat_map(|touch| self.plan.effects.contacts.pairs[touch.pair].reaches.iter().cloned().flatten())
    }

    /// Finds what touches in exactly this shape, without its motion: curvatures of long rods, and of all rods in small units of length, are
    /// small numbers, so that no difference of coordinates is negligible. Rates and forces at contact points are those of no motion.
    fn find_touches(&mut self, q: &[f64]) {
        if self.work.motion_is_known && self.work.kinematics_of == q {
            return;
        }
        self.update_kinematics(q);
        contact::find(&self.plan, &mut self.work);
    }

    /// Contact points in a state.
    pub(crate) fn touches(&mut self, q: &[f64], qd: &[f64]) -> Vec<ReportedTouch> {
        self.update_velocities(q, qd);
        query::reported(&self.plan, &self.work).collect()
    }
}
