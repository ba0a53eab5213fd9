//! Forces of actuators on the strains at places of a rod: the densities of their generalised forces.

use super::Actuator;
use super::compile::{self, Embedded};
use super::plan::{Part, RoutingComponent};
use crate::description::rod::STRAINS;
use crate::numerics::lie::{LANES, Lanes, Vector};
use crate::robot::description::Robot;
use crate::robot::plan::Plan;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::state::Workspace;
use crate::robot::turning::Turning;

/// Strain components of a piece that have modes, in the order of its coordinates.
pub(crate) fn components<G: Turning>(piece: &PiecePlan<G>) -> Vec<RoutingComponent> {
    compile::components(piece)
}

/// Adds the forces of all actuators per length, dual to the strains, at the nodes of all rods; the state and the strains of
/// the modes at the nodes are up to date.
pub(crate) fn add<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    robot: &Robot,
    strains: &[[f64; STRAINS]],
    to: &mut [[f64; STRAINS]],
) {
    let state = &work.effects.actuation;
    for (i, actuator) in robot.actuators.iter().enumerate() {
        let force = state.forces[i].value;
        let mut guides = plan.effects.actuation.actuators[i].path.iter().filter_map(|part| match *part {
            Part::Guide { routing_segment, guide } => Some([routing_segment, guide]),
            Part::Line(_) => None,
        });
        for along in actuator.along() {
            for part in compile::parts(along, robot, &plan.pieces, &plan.links[along.link].rod) {
                let piece = &plan.pieces[part.piece];
                let guide = guides.next();
                let shares = part.shares(piece);
                for (i, &x) in piece.gauss.nodes.iter().enumerate() {
                    let node = LANES * piece.first_pack + i;
                    let density = match (actuator, guide) {
                        (Actuator::Chamber(chamber), _) => {
                            part.volume_rates(x).map(|slope| chamber.area * slope)
                        }
                        (_, Some(guide)) => {
                            let ratio = ratio_at(plan, work, guide, &part, x);
                            part.lengthens(x, &strains[node]).map(|slope| ratio * slope)
                        }
                        _ => [0.0; STRAINS],
                    };
                    let force = force * shares[i];
                    to[node].iter_mut().zip(density).for_each(|(to, density)| *to += force * density);
                }
            }
        }
    }
    for active in &plan.effects.actuation.active_strains {
        let force = state.forces[active.actuator].value;
        let piece = &plan.pieces[active.piece];
        for (i, &x) in piece.gauss.nodes.iter().enumerate() {
            let stiffness = piece.part().section(x).stiffness;
            let amount = force * active.of_unit(x);
            for (to, row) in to[LANES * piece.first_pack + i].iter_mut().zip(stiffness) {
                *to += amount * row[active.strain];
            }
        }
    }
}

/// Tension at a place of a guide relative to that at the start of the tendon: that of the nearest node.
fn ratio_at<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    [routing_segment, guide]: [usize; 2],
    part: &Embedded<'_>,
    x: f64,
) -> f64 {
    let actuation = &plan.effects.actuation;
    let [first, _] = actuation.offsets(routing_segment, guide);
    let routing_segment = &actuation.routing_segments[routing_segment];
    let nodes = LANES * routing_segment.packs;
    let lane = |packs: &[G::Pack], i: usize| packs[i / LANES].lane(i % LANES);
    let [from, to] = part.ends;
    let passed =
        (x - from) / (to - from) * (0..nodes).map(|i| lane(&routing_segment.weights, i)).sum::<f64>();
    let mut up_to = 0.0;
    let nearest = (0..nodes).find(|&i| {
        up_to += lane(&routing_segment.weights, i);
        up_to >= passed
    });
    lane(&work.effects.actuation.ratios[first..], nearest.unwrap_or(nodes - 1))
}

impl Embedded<'_> {
    /// The share of each node of the piece in the path, such that integrals are exact for a path that ends between nodes (as for
    /// wrenches at points, `plan::point`).
    fn shares<G: Turning>(&self, piece: &PiecePlan<G>) -> Vec<f64> {
        let [from, to] = self.ends;
        if from <= 0.0 && to >= 1.0 {
            return vec![1.0; piece.gauss.nodes.len()];
        }
        let [before, up_to] = [from, to].map(|x| piece.gauss.weights_up_to(x));
        let parts = up_to.iter().zip(before).zip(&piece.gauss.weights);
        parts.map(|((up_to, before), weight)| (up_to - before) / weight).collect()
    }

    /// Change of a tendon's length per length of the rod, by each strain: `b_c . t` (`force::routing_segment`).
    fn lengthens(&self, x: f64, strains: &[f64; STRAINS]) -> [f64; STRAINS] {
        let [offset, _] = compile::offset(self, x);
        let along = |strain: usize| compile::direction(strain, offset);
        let u: Vector<f64> = (0..STRAINS)
            .fold(compile::slope_at_zero(self, x), |u, strain| u + along(strain) * strains[strain]);
        let size = u.dot(u).sqrt();
        std::array::from_fn(|strain| along(strain).dot(u) / size)
    }

    /// Change of a chamber's volume per length of the rod and area, by each strain.
    fn volume_rates(&self, x: f64) -> [f64; STRAINS] {
        let [offset, _] = compile::offset(self, x);
        std::array::from_fn(|strain| compile::direction(strain, offset).x)
    }
}
