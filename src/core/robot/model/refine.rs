//! Parameters and numbers of modes of a robot.

use super::{AnySweeps, RobotModel};
use crate::description::rod::{MAX_NODES, STRAINS, piece};
use crate::model::{Differentiable, InertiaMatrix, MissingStrain, Refinable};
use crate::robot::description::Robot;
use crate::robot::effects::fluid::Fluid;

impl Differentiable for RobotModel {
    fn add_power_by_inertia(
        &mut self,
        q: &[f64],
        qd: &[f64],
        qdd: &[f64],
        rates: &[f64],
        by_inertia: &mut [InertiaMatrix],
    ) {
        let sweeps = &mut self.sweeps;
        on_sweeps!(sweeps, sweeps => sweeps.add_power_by_inertia([q, qd, qdd], rates, by_inertia));
    }

    fn add_power_by_length(
        &mut self,
        q: &[f64],
        qd: &[f64],
        qdd: &[f64],
        rates: &[f64],
        by_length: &mut [f64],
    ) {
        let state = [q, qd, qdd];
        match &mut self.sweeps {
            AnySweeps::Planar(sweeps) => sweeps.add_power_by_length(state, rates, by_length),
            AnySweeps::Spatial(sweeps) => sweeps.add_power_by_length(state, rates, by_length),
            #[cfg(portable)]
            AnySweeps::PortablePlanar(_) | AnySweeps::PortableSpatial(_) => {
                unreachable!("no length is free")
            }
        }
    }
}

impl Refinable for RobotModel {
    /// Numbers of modes of the six strains of every segment, if its basis is hierarchical.
    fn modes(&self) -> Option<Vec<usize>> {
        let is_nested = self.robot.segments().all(|segment| segment.basis.is_nested());
        (is_nested && self.facts.is_discretised)
            .then(|| self.robot.segments().flat_map(|segment| segment.modes).collect())
    }

    fn coordinates_between(&self) -> Vec<usize> {
        let mut between = vec![0];
        for link in &self.robot.links {
            let last = between.len() - 1;
            between[last] += link.joint_coordinates().len();
            between.extend(std::iter::repeat_n(0, STRAINS * link.rod.len()));
        }
        between
    }

    fn with_modes(&self, modes: &[usize]) -> Option<Self> {
        const MORE_NODES: usize = 8;
        let mut other = Robot::clone(&self.robot);
        for ((segment, modes), nodes) in
            other.segments_mut().zip(modes.as_chunks::<STRAINS>().0).zip(self.nodes())
        {
            let more = modes
                .iter()
                .max()
                .copied()
                .unwrap_or(0)
                .saturating_sub(segment.modes.into_iter().max().unwrap_or(0));
            segment.modes = *modes;
            segment.nodes = Some((nodes / piece::number(segment) + MORE_NODES.max(more)).min(MAX_NODES));
        }
        Self::new(&other).ok()
    }

    fn with_nodes_times(&self, factor: usize) -> Option<Self> {
        let mut finer = Robot::clone(&self.robot);
        for (segment, nodes) in finer.segments_mut().zip(self.nodes()) {
            let of_piece = nodes / piece::number(segment);
            segment.nodes.get_or_insert(factor * of_piece);
        }
        (finer != *self.robot).then(|| Self::new(&finer).ok()).flatten()
    }

    fn with_inertia_times(&self, factor: f64) -> Option<Self> {
        // In a flow, the forces of added mass depend on the velocity.
        let is_pushed = |fluid: &Fluid| fluid.velocity != [0.0; 3] && fluid.has_added_mass();
        if self.robot.fluid.as_ref().is_some_and(is_pushed) {
            return None;
        }
        Self::new(&self.robot.with_inertia_times(factor)).ok()
    }

    fn missing_strain(&mut self, q: &[f64], load_factor: f64) -> Option<MissingStrain> {
        if !self.facts.is_discretised {
            return None;
        }
        let rest = vec![0.0; q.len()];
        Some(self.with_loops_held([q, &rest, &rest], |model| {
            let Self { sweeps, coordinates, robot, .. } = model;
            coordinates
                .all([q], |[q]| on_sweeps!(sweeps, sweeps => sweeps.missing_strain(robot, q, load_factor)))
        }))
    }

    fn effect_of_strains(&mut self, q: &[f64], change: &[f64]) -> Option<MissingStrain> {
        let Self { sweeps, coordinates, facts, .. } = self;
        facts.is_discretised.then(|| {
            coordinates.all(
                [q, change],
                |[q, change]| on_sweeps!(sweeps, sweeps => sweeps.effect_of_strains(q, change)),
            )
        })
    }

    fn outline(&mut self, q: &[f64], positions: &mut Vec<[f64; 3]>) {
        let Self { sweeps, coordinates, .. } = self;
        coordinates.all([q], |[q]| on_sweeps!(sweeps, sweeps => sweeps.outline(q, positions)));
    }

    fn name_of_segment(&self, segment: usize) -> String {
        self.robot.name_of_segment(segment)
    }
}
