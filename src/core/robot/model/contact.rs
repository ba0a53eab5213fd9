//! Contacts and stops of a robot.

use super::{AT_REST, AnySweeps, EXPLOSION, LARGEST_GAIN, RobotModel, SMALL_GAIN};
use crate::model::springs::LengthTendons;
use crate::model::{
    ContactText, Dynamics as _, ForwardScratch, FrictionTreatment, GainCheck, Impact, InContact, InImpact,
    InvalidShape, Overlap, Radius, Reached, Separation, Softened, Sprung as _, chart,
};
use crate::numerics::linalg::Matrix;
use crate::robot::effects::contact::query::FastestImpact;
use crate::robot::effects::{actuator, contact, joint_forces};

impl RobotModel {
    /// Names the stop with the largest force in the first of these shapes, or that is passed in a later one.
    fn advice_on_stops(&mut self, failed: &[&[f64]]) -> String {
        let Self { sweeps, coordinates, robot, .. } = self;
        let found = failed.iter().enumerate().find_map(|(number, q)| {
            let stop = coordinates.all(
                [*q],
                |[q]| on_sweeps!(sweeps, sweeps => joint_forces::most_loaded_stop(sweeps.plan(), q)),
            );
            Some((number, stop?))
        });
        found.map_or_else(String::new, |(number, stop)| joint_forces::advice(robot, stop, number > 0))
    }

    /// Names the tendon of commanded length that pulls most in the first of these shapes, or becomes taut in a later one.
    fn advice_on_tendons(&mut self, failed: &[&[f64]]) -> String {
        let length_tendons: Vec<usize> =
            on_sweeps!(&self.sweeps, sweeps => sweeps.length_tendons().map(|(i, _)| i).collect());
        if length_tendons.is_empty() {
            return String::new();
        }
        let mut found = LengthTendons::new(length_tendons.len(), self.facts.n);
        for (number, q) in failed.iter().enumerate() {
            self.linearise_length_tendons(q, &mut found);
            if let Some(row) = actuator::advice::most_loaded(&found, self.facts.length) {
                return actuator::advice::advice(&self.robot, length_tendons[row], &found, row, number > 0);
            }
        }
        String::new()
    }
}

impl InContact for RobotModel {
    fn reached(&mut self, q: &[f64]) -> Vec<Reached> {
        if !self.facts.has_contact && !self.facts.has_stops {
            return Vec::new();
        }
        let Self { sweeps, coordinates, facts, .. } = self;
        coordinates.all([q], |[q]| on_sweeps!(sweeps, sweeps => sweeps.reached(q, facts.length)))
    }

    fn decide(&mut self, reached: &[Reached]) {
        self.cached.forget();
        on_sweeps!(&mut self.sweeps, sweeps => sweeps.decide(reached));
        if let Some(unloaded) = &mut self.unloaded {
            on_sweeps!(&mut **unloaded, sweeps => sweeps.decide(reached));
        }
    }

    fn leave_contact(&mut self, is_left: bool) {
        on_sweeps!(&mut self.sweeps, sweeps => sweeps.leave_contact(is_left));
    }

    fn soften_contact(&mut self, soft: Option<Softened<'_>>) -> bool {
        self.cached.forget();
        let Self { sweeps, coordinates, .. } = self;
        let Some(soft) = soft else {
            return on_sweeps!(sweeps, sweeps => sweeps.soften_contact(None));
        };
        coordinates.all(
            [soft.start],
            |[start]| on_sweeps!(sweeps, sweeps => sweeps.soften_contact(Some(Softened { start, ..soft }))),
        )
    }

    fn deepest_overlaps(&mut self, q: &[f64]) -> [Option<Overlap>; 2] {
        let Self { sweeps, coordinates, .. } = self;
        coordinates.all([q], |[q]| on_sweeps!(sweeps, sweeps => sweeps.deepest_overlaps(q)))
    }

    fn deepest_overlap(&mut self, q: &[f64]) -> Option<Overlap> {
        if !self.facts.has_contact {
            return None;
        }
        let Self { sweeps, coordinates, .. } = self;
        coordinates.all([q], |[q]| on_sweeps!(sweeps, sweeps => sweeps.deepest_overlap(q)))
    }

    fn text_of_contact(&self, contact: usize, text: ContactText) -> String {
        let Some(contact) = self.robot.contacts.get(contact) else { return String::new() };
        match text {
            ContactText::Name => contact.name.clone(),
            ContactText::AdviceOnDeepOverlap => contact::advice::on_deep_overlap(contact),
        }
    }

    fn advice_at_end(&mut self, failed: &[&[f64]], deepest: Option<Overlap>) -> String {
        let mut said = String::new();
        if self.facts.has_contact {
            let mut touches = failed.iter().map(|q| self.touches(q, &vec![0.0; q.len()])).enumerate();
            let (number, touches) = touches.find(|(_, touches)| !touches.is_empty()).unwrap_or_default();
            said += &contact::advice::advice(&self.robot, &touches, number > 0, deepest, !failed.is_empty());
        }
        said = said + &self.advice_on_stops(failed) + &self.advice_on_tendons(failed);
        match failed.first() {
            Some(q) => self.advice_on_loops(q, !said.is_empty()) + &said,
            None => said,
        }
    }

    fn shifts_of_contact(&mut self, q: &[f64]) -> Matrix {
        if q.is_empty() || !self.facts.has_contact {
            return Matrix::zeros(0, q.len());
        }
        let Self { sweeps, coordinates, facts, .. } = self;
        on_sweeps!(sweeps, sweeps => {
            let (motions, numbers) = coordinates.all([q], |[q]| sweeps.motions_of_contact(q));
            let mut rows = coordinates.own_columns(motions.rows(sweeps.plan().n));
            chart::rows(&facts.rotation_vectors, q, &mut rows);
            let mut shifts = Matrix::zeros(numbers.len(), q.len());
            let mut first = 0;
            for (p, number) in numbers.into_iter().enumerate() {
                for k in 0..q.len() {
                    let rate = |i: usize| rows.fixed_view::<3, 1>(3 * i, k).norm();
                    shifts[(p, k)] = (first..first + number).map(rate).fold(0.0, f64::max);
                }
                first += number;
            }
            shifts
        })
    }

    fn work_of_interactions(&mut self, q: &[f64], work: &mut [f64]) {
        let Self { sweeps, coordinates, .. } = self;
        let of_all = coordinates.all([q], |[q]| on_sweeps!(sweeps, sweeps => sweeps.work_of_interactions(q)));
        // A row for each coordinate: dependent coordinates add to it, with either sign.
        let own = coordinates.own_columns(Matrix::from_diagonal(&of_all.into()));
        work.iter_mut().zip(own.column_iter()).for_each(|(work, column)| *work = column.abs().sum());
    }

    fn deep_penetration(&mut self, q: &[f64]) -> Option<InvalidShape> {
        if self.robot.contacts.is_empty() {
            return None;
        }
        let Self { sweeps, coordinates, .. } = self;
        let (contact, overlap) =
            coordinates.all([q, q], |[q, _]| on_sweeps!(sweeps, sweeps => sweeps.deep_penetration(q)))?;
        Some(InvalidShape::DeepPenetration { contact, overlap })
    }

    fn store_surfaces(&mut self, q: &[f64]) {
        let Self { sweeps, coordinates, .. } = self;
        coordinates.all([q, q], |[q, _]| on_sweeps!(sweeps, sweeps => sweeps.store_surfaces(q)));
    }

    fn have_tunnelled(&mut self, q: &[f64], radius: Radius) -> bool {
        let Self { sweeps, coordinates, .. } = self;
        coordinates.all([q, q], |[q, _]| on_sweeps!(sweeps, sweeps => sweeps.have_tunnelled(q, radius)))
    }

    fn is_touched(&self) -> bool {
        on_sweeps!(&self.sweeps, sweeps => sweeps.is_touched())
    }
}

impl InImpact for RobotModel {
    fn beyond_stops(&mut self, q: &[f64], beyond: &mut Vec<f64>) {
        let Self { sweeps, coordinates, facts, .. } = self;
        coordinates
            .all([q], |[q]| on_sweeps!(sweeps, sweeps => sweeps.beyond_stops(q, facts.length, beyond)));
    }

    fn treat_friction(&mut self, treatment: FrictionTreatment) {
        if on_sweeps!(&mut self.sweeps, sweeps => sweeps.treat_friction(treatment)) {
            self.cached.forget();
        }
    }

    fn has_unresolved_impact(&mut self, [_, qd_before]: [&[f64]; 2], motion: [&[f64]; 3], h: f64) -> bool {
        // Forces have just been computed in a shape close by.
        let is_apart = on_sweeps!(&self.sweeps, sweeps => sweeps.is_known_apart());
        if is_apart || !self.store_rates(qd_before, motion) {
            return false;
        }
        let Self { sweeps, coordinates, .. } = self;
        coordinates
            .all(motion, |motion| on_sweeps!(sweeps, sweeps => sweeps.has_unresolved_impact(motion, h)))
    }

    fn separation(&mut self, qd_before: &[f64], motion: [&[f64]; 3], since: f64, h: f64) -> Separation {
        let Self { sweeps, coordinates, .. } = self;
        let [q, qd, _] = motion;
        let may_separate = coordinates.all(
            [q, qd_before, qd],
            |[q, qd_before, qd]| on_sweeps!(sweeps, sweeps => sweeps.may_separate([q, qd_before, qd], h)),
        );
        if !may_separate || !self.store_stiffnesses(motion, h) {
            return Separation::default();
        }
        self.store_rates(qd_before, motion);
        let Self { sweeps, coordinates, facts, .. } = self;
        let by_weight = facts.is_discretised;
        coordinates.all(
            motion,
            |motion| on_sweeps!(sweeps, sweeps => sweeps.separation(motion, since, h, by_weight)),
        )
    }

    fn take_touched(&mut self) -> bool {
        on_sweeps!(&mut self.sweeps, sweeps => sweeps.take_touched())
    }

    fn may_touch(&self) -> bool {
        self.facts.has_contact && on_sweeps!(&self.sweeps, sweeps => sweeps.may_touch())
    }

    /// Gains are compared with `LARGEST_GAIN`, `AT_REST` and `EXPLOSION`.
    fn gains_energy(&mut self, [q, qd]: [&[f64]; 2], motion: [&[f64]; 3], h: f64, check: GainCheck) -> bool {
        // The work of prescribed motions over the step is unknown.
        if self.facts.is_carried {
            return false;
        }
        let [q_after, qd_after, qdd] = motion;
        // A step begins where the last one ended.
        let (before, of_overlaps) = self.cached_energy([q, qd]);
        let (after, of_more) = self.cached_energy([q_after, qd_after]);
        let of_overlaps = of_overlaps.max(of_more);
        // The end of the step is evaluated last, for later queries about contact points there.
        self.touch([q_after, qd_after]);
        let supplied =
            if self.facts.is_driven { h * self.supplied_power(q_after, qd_after, qdd) } else { 0.0 };
        let gain = after.total() - before.total() - supplied.max(0.0);
        let whole = after.kinetic + after.elastic;
        match check {
            GainCheck::Kinetic => {
                let at_rest = AT_REST * of_overlaps;
                let exceeds = |gain: f64, kinetic: f64| gain > (LARGEST_GAIN * kinetic).max(at_rest);
                if exceeds(gain, after.kinetic.max(before.kinetic)) {
                    return true;
                }
                if gain <= at_rest || self.facts.parts.len() < 2 || self.facts.is_driven {
                    return false;
                }
                let mut colliding_parts = std::mem::take(&mut self.colliding_parts);
                colliding_parts.find(self, [[q, qd], [q_after, qd_after]]);
                let gain = colliding_parts.gain(self, [q, qd], [q_after, qd_after], gain);
                let kinetic = [(q, qd, before), (q_after, qd_after, after)]
                    .map(|(q, qd, energy)| colliding_parts.kinetic(self, [q, qd], energy.kinetic));
                self.colliding_parts = colliding_parts;
                // Later queries refer to the end.
                self.touch([q_after, qd_after]);
                exceeds(gain, kinetic[0].max(kinetic[1]))
            }
            GainCheck::Mechanical => gain > SMALL_GAIN * whole,
            GainCheck::Explosion => gain > EXPLOSION * whole,
        }
    }

    fn mark_pushed(&mut self, state: [&[f64]; 2], marks: &mut [bool]) {
        self.cached_energy(state);
        let is_pushed = self.cached.of(state).map_or(&[][..], |known| &known.is_pushed);
        marks.iter_mut().zip(is_pushed).for_each(|(mark, is_pushed)| *mark |= is_pushed);
    }

    fn impact(&mut self, before: [&[f64]; 2], motion: [&[f64]; 3], h: f64) -> Option<Impact> {
        let [q, qd, qdd] = motion;
        let (at_start, _) = self.cached_energy(before);
        let (at_end, _) = self.cached_energy([q, qd]);
        let supplied = if self.facts.is_driven { self.supplied_power(q, qd, qdd).abs() } else { 0.0 };
        let mut colliding_parts = std::mem::take(&mut self.colliding_parts);
        colliding_parts.find(self, [before, [q, qd]]);
        let gain = colliding_parts.gain(self, before, [q, qd], at_end.total() - at_start.total());
        let kinetic = colliding_parts.kinetic(self, before, at_start.kinetic);
        self.colliding_parts = colliding_parts;
        // Over a step of the backward Euler method, forces act as at its end.
        let whole = -gain - h * supplied;
        let lost = whole - h * self.dissipated_power(q, qd);
        self.store_rates(before[1], motion);
        let Self { sweeps, coordinates, .. } = self;
        let FastestImpact { contact, rebound, longest } =
            coordinates.all(motion, |motion| on_sweeps!(sweeps, sweeps => sweeps.fastest_impact(motion)))?;
        Some(Impact {
            contact,
            lost: lost.max(0.0) * rebound * rebound,
            whole: whole.max(0.0),
            kinetic,
            elastic: at_end.elastic,
            longest,
        })
    }
}

impl RobotModel {
    /// Evaluates a state for queries about contact points in its shape.
    fn touch(&mut self, state: [&[f64]; 2]) {
        let Self { sweeps, coordinates, .. } = self;
        coordinates.all(state, |state| on_sweeps!(sweeps, sweeps => sweeps.touch(state)));
    }

    /// Stores the approach velocities at the start of a step of surfaces that touch at its end; false if none touch.
    fn store_rates(&mut self, qd_before: &[f64], [q, _, qdd]: [&[f64]; 3]) -> bool {
        let Self { sweeps, coordinates, .. } = self;
        coordinates
            .all([q, qd_before, qdd], |motion| on_sweeps!(sweeps, sweeps => sweeps.store_rates(motion)))
    }

    /// Stores with which accelerations surfaces that touch in a motion open without contact forces, and how stiff they are over the mass that
    /// takes part: with the forces of all, and where others hide that, as their impacts seem to take many steps of size `h`, with those of
    /// each pair alone. False where there are no accelerations.
    fn store_stiffnesses(&mut self, motion: [&[f64]; 3], h: f64) -> bool {
        let [q, qd, _] = motion;
        let mut a = vec![0.0; q.len()];
        let mut scratch = ForwardScratch::of(self);
        self.leave_contact(true);
        let unpushed = self.forward_dynamics(q, qd, &mut a, &mut scratch);
        self.leave_contact(false);
        if unpushed.is_err() {
            return false;
        }
        let Self { sweeps, coordinates, .. } = self;
        coordinates.all([q, qd, &a], |motion| on_sweeps!(sweeps, sweeps => sweeps.store_openings(motion)));
        coordinates
            .all(motion, |motion| on_sweeps!(sweeps, sweeps => sweeps.store_stiffnesses(motion, None)));
        for pair in on_sweeps!(&self.sweeps, sweeps => sweeps.between_others(h)) {
            on_sweeps!(&mut self.sweeps, sweeps => sweeps.enable_only(Some(pair)));
            let alone = self.forward_dynamics(q, qd, &mut a, &mut scratch);
            let Self { sweeps, coordinates, .. } = self;
            if alone.is_ok() {
                let motion = [q, qd, &a];
                coordinates.all(
                    motion,
                    |motion| on_sweeps!(sweeps, sweeps => sweeps.store_stiffnesses(motion, Some(pair))),
                );
            }
            on_sweeps!(sweeps, sweeps => sweeps.enable_only(None));
        }
        true
    }
}
