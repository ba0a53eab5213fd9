//! Derivative of the virtual power of inertial forces with respect to the inertia of sections.

use crate::model::{InertiaMatrix, SectionPlace};
use crate::numerics::lie::{Cross as _, LANES, Lanes, Twist, Vector};
use crate::robot::plan::Plan;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::state::Workspace;
use crate::robot::turning::Turning;

/// Pieces of rods in the order of their segments.
fn pieces<G: Turning>(plan: &Plan<G>) -> impl Iterator<Item = &PiecePlan<G>> {
    plan.links.iter().flat_map(|link| &plan.pieces[link.rod.clone()])
}

/// Places of the nodes of rods.
pub(crate) fn places<G: Turning>(plan: &Plan<G>) -> Vec<SectionPlace> {
    let mut segments = 0;
    let mut places = Vec::new();
    for piece in pieces(plan) {
        segments += usize::from(piece.part().begins_segment());
        let place = |&x: &f64| SectionPlace { segment: segments - 1, x: piece.part().place(x) };
        places.extend(piece.gauss.nodes.iter().map(place));
    }
    places
}

/// Velocities and accelerations at all nodes of rods.
pub(crate) struct Motion<G: Turning> {
    velocity: Vec<Twist<G, G::Pack>>,
    acceleration: Vec<Twist<G, G::Pack>>,
}

impl<G: Turning> Motion<G> {
    /// Copies the motion of a workspace. Allocates.
    pub(crate) fn of(work: &Workspace<G>) -> Self {
        Self { velocity: work.velocity.clone(), acceleration: work.acceleration.clone() }
    }

    /// Adds the derivatives of the power of these forces in the virtual motion of `work`, with respect to the
    /// inertia per length at each of the [`places`].
    ///
    /// With the virtual motion W the power is `W . (N A - ad_V^T N V) = W . N A - (ad_V W) . N V`, which is
    /// linear in N. The twists are converted to section axes, in which N is the inertia matrix M of the
    /// section.
    pub(crate) fn add(&self, plan: &Plan<G>, work: &Workspace<G>, by_inertia: &mut [InertiaMatrix]) {
        let components: Vec<usize> =
            (0..G::COMPONENTS).map(|c| component_in_space::<G>(plan.frame, c)).collect();
        let mut by_inertia = by_inertia.chunks_exact_mut(LANES);
        for piece in pieces(plan) {
            for (node, &weight) in piece.node_packs().zip(&piece.weights) {
                let (velocity, rates) = (self.velocity[node], work.velocity[node]);
                let twists = [rates, self.acceleration[node], velocity.bracket(rates), velocity];
                let (rotation, position) = (&work.rotation[node], work.position[node]);
                let [mut w, mut a, mut u, mut v] =
                    twists.map(|twist| carried_back(rotation, position, twist));
                let matrices = by_inertia.next().expect("a matrix for every place");
                for (i, &row) in components.iter().enumerate() {
                    let (w, u) = (*w.component_mut(i) * weight, *u.component_mut(i) * weight);
                    for (j, &column) in components.iter().enumerate() {
                        let product = w * *a.component_mut(j) - u * *v.component_mut(j);
                        for (lane, matrix) in matrices.iter_mut().enumerate() {
                            matrix[row][column] += product.lane(lane);
                        }
                    }
                }
            }
        }
    }
}

/// Converts a twist to the axes of a section at this place, `Ad_g^-1 V`.
fn carried_back<G: Turning>(
    rotation: &G::Rotation<G::Pack>,
    position: G::Vector<G::Pack>,
    Twist { angular, linear }: Twist<G, G::Pack>,
) -> Twist<G, G::Pack> {
    Twist {
        angular: G::rotate_axial_back(rotation, angular),
        linear: G::rotate_back(rotation, angular.cross_add(position, linear)),
    }
}

/// Index of this component among the components (angular; linear) of a twist in three dimensions.
fn component_in_space<G: Turning>(frame: G::Frame, component: usize) -> usize {
    let mut unit = Twist::<G, f64>::zero();
    *unit.component_mut(component) = 1.0;
    let axes =
        [G::axial_in_space(frame, unit.angular), G::in_space(frame, unit.linear)].map(Vector::to_array);
    axes.iter().flatten().position(|&x| x != 0.0).expect("a component of space")
}
