//! Lengths and forces of actuators, and stops of joints.

use super::Sweeps;
use crate::model::springs::LengthTendons;
use crate::numerics::lie::Vector;
use crate::robot::effects::actuator::force as actuation;
use crate::robot::effects::actuator::plan::Law;
use crate::robot::effects::joint_forces;
use crate::robot::kernel::lines;
use crate::robot::turning::Turning;

impl<G: Turning> Sweeps<G> {
    /// Whether any joint has stops or any tendon a stiffness.
    pub(crate) fn has_stops(&self) -> bool {
        joint_forces::all(&self.plan).any(|(_, forces)| forces.limits.is_some()) || self.has_cables()
    }

    /// Whether any joint has dry friction.
    pub(crate) fn has_joint_friction(&self) -> bool {
        joint_forces::all(&self.plan).any(|(_, forces)| forces.friction > 0.0)
    }

    fn has_cables(&self) -> bool {
        self.plan.effects.actuation.actuators.iter().any(|actuator| actuator.law.is_cable())
    }

    /// By how much joints are beyond their nearest stops, and tendons with a stiffness longer than commanded; negative before
    /// that, in radians or in units of `length`, that of the robot.
    pub(crate) fn beyond_stops(&mut self, q: &[f64], length: f64, beyond: &mut Vec<f64>) {
        beyond.clear();
        beyond.extend(joint_forces::beyond_stops(&self.plan, q, length));
        if !self.has_cables() {
            return;
        }
        self.with_zeros(|sweeps, zeros| sweeps.update_motion([q, zeros, zeros]));
        let state = &self.work.effects.actuation;
        let cables = self.plan.effects.actuation.actuators.iter().enumerate();
        let cables = cables.filter(|(_, actuator)| actuator.law.is_cable());
        beyond.extend(cables.map(|(i, _)| (state.lengths[i] - state.commands[i]) / length));
    }

    /// Commands of actuators; NaN until a required time is set.
    pub(crate) fn commands(&self) -> &[f64] {
        &self.work.effects.actuation.commands
    }

    /// Length, rate and force of an actuator, and the gradient of its length.
    pub(crate) fn actuator(&mut self, q: &[f64], qd: &[f64], i: usize) -> ([f64; 3], &[f64]) {
        self.update_velocities(q, qd);
        let Self { plan, work, tangent, .. } = self;
        lines::find(plan, work, &mut tangent.effects.actuation);
        let state = &work.effects.actuation;
        let numbers = [state.lengths[i], state.rates[i], state.forces[i].value];
        (numbers, actuation::gradient(plan, work, &mut tangent.effects.actuation, i))
    }

    /// The tendons of a commanded length without friction, by their actuators.
    pub(crate) fn length_tendons(&self) -> impl Iterator<Item = (usize, f64)> {
        let plan = &self.plan;
        plan.effects.actuation.actuators.iter().enumerate().filter_map(|(i, actuator)| match actuator.law {
            Law::Cable { stiffness, .. } if actuator.friction.is_none() => Some((i, stiffness)),
            Law::Inextensible { .. } => Some((i, f64::INFINITY)),
            _ => None,
        })
    }

    /// These tendons in a shape.
    pub(crate) fn linearise_length_tendons(&mut self, q: &[f64], length_tendons: &mut LengthTendons) {
        self.with_zeros(|sweeps, zeros| sweeps.update_motion([q, zeros, zeros]));
        let Self { plan, work, tangent, .. } = self;
        lines::find(plan, work, &mut tangent.effects.actuation);
        for (row, (i, stiffness)) in self.length_tendons().collect::<Vec<_>>().into_iter().enumerate() {
            let Self { plan, work, tangent, .. } = &mut *self;
            let state = &work.effects.actuation;
            length_tendons.stiffness[row] = stiffness;
            length_tendons.excesses[row] = state.lengths[i] - state.commands[i];
            let ends =
                plan.effects.actuation.lines.iter().zip(&state.lines).filter(|(line, _)| line.actuator == i);
            let far = ends.flat_map(|(_, line)| line.ends).map(|end| end.dot(end).sqrt());
            length_tendons.spans[row] = state.lengths[i].abs() + state.commands[i].abs() + far.sum::<f64>();
            let gradient = actuation::gradient(plan, work, &mut tangent.effects.actuation, i);
            length_tendons.jacobian.row_mut(row).copy_from_slice(gradient);
            for k in 0..plan.n {
                length_tendons.reach[(row, k)] =
                    actuation::reach(plan, work, &tangent.effects.actuation, i, k);
            }
        }
    }

    /// Replaces tensions of these tendons; `None` undoes that.
    pub(crate) fn hold_length_tendons(&mut self, tensions: Option<&[f64]>) {
        self.work.motion_is_known = false;
        for (row, (i, _)) in self.length_tendons().collect::<Vec<_>>().into_iter().enumerate() {
            self.work.effects.actuation.fixed_tensions[i] = tensions.map(|tensions| tensions[row]);
        }
    }

    /// The actuator with a force in a straight part that has collapsed.
    pub(crate) fn collapsed(&mut self, q: &[f64]) -> Option<usize> {
        // Any velocities: lengths do not depend on them, but forces may.
        self.update_velocities(q, q);
        self.shortest_line()?;
        self.update_velocities(q, &vec![0.0; q.len()]);
        self.shortest_line().filter(|&actuator| self.work.effects.actuation.forces[actuator].value != 0.0)
    }

    /// The actuator with a straight part shorter than the limit.
    fn shortest_line(&self) -> Option<usize> {
        let actuation = &self.plan.effects.actuation;
        let is_short = |ends: &[Vector<f64>; 2], shortest: f64| {
            let way = ends[1] - ends[0];
            way.dot(way).sqrt() < shortest
        };
        let mut lines = actuation.lines.iter().zip(&self.work.effects.actuation.lines);
        lines
            .find(|(line, state)| line.can_shrink() && is_short(&state.ends, line.shortest))
            .map(|(line, _)| line.actuator)
    }
}
