//! Cost of each actuator: its share of the products of a residual and of a tangent.
//!
//! As in [`super::cost`], formulas are evaluated with [`Counted`] numbers; a test counts the pack products of
//! [`crate::robot::effect::actuation`] and [`crate::robot::kernel::lines`]. Costs are those of actuators with
//! a force; with zero force some products are skipped.

use crate::lie::{Counted, Cross as _, LANES, Twist, Vector, VectorSpace, Wrench, products};
use crate::robot::algebra::inertia::Gyroscope;
use crate::robot::algebra::products::Products;
use crate::robot::plan::Plan;
use crate::robot::plan::actuation::{ActuatorPlan, End, Law, Part, Sleeve, pairs};
use crate::robot::plan::piece::PiecePlan;
use crate::robot::turning::Turning;

/// Size of the computation for an actuator, and its share of the products.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct OfActuator {
    /// Numbers of quadrature nodes of embedded parts, and of straight parts.
    pub(crate) nodes: usize,
    pub(crate) lines: usize,
    /// Number of coordinates on which its force acts.
    pub(crate) coordinates: usize,
    /// Whether its tangent has entries between different pieces.
    pub(crate) couples_pieces: bool,
    /// Share of [`super::cost::Multiplications::residual`].
    pub(crate) residual: u64,
    /// Share of [`super::cost::Multiplications::tangent`].
    pub(crate) tangent: u64,
}

/// Costs of the actuators of a plan.
pub(crate) fn of_actuators<G: Turning>(plan: &Plan<G>) -> Vec<OfActuator> {
    let (action, response) = (action(plan), response(plan));
    let of_actuator = |(i, actuator): (usize, &ActuatorPlan)| OfActuator {
        nodes: threads(plan, i).map(|sleeve| sleeve.packs * LANES).sum(),
        lines: actuator.path.iter().filter(|part| matches!(part, Part::Line(_))).count(),
        coordinates: actuator.reaches.len(),
        couples_pieces: plan.actuation.couples(i),
        residual: action[i].total(),
        tangent: response[i].total(),
    };
    plan.actuation.actuators.iter().enumerate().map(of_actuator).collect()
}

/// Sleeves that contain threads of an actuator, one for each thread.
fn threads<G: Turning>(plan: &Plan<G>, actuator: usize) -> impl Iterator<Item = &Sleeve<G::Pack>> {
    let sleeve_of = |part: &Part| match *part {
        Part::Thread { sleeve, .. } => Some(&plan.actuation.sleeves[sleeve]),
        Part::Line(_) => None,
    };
    plan.actuation.actuators[actuator].path.iter().filter_map(sleeve_of)
}

/// Sizes of a sleeve.
struct Sizes {
    packs: u64,
    nodes: u64,
    components: u64,
    /// Number of pairs of components c <= d.
    pairs: u64,
    coordinates: u64,
    /// Number of these for curvatures.
    angular: u64,
}

impl Sizes {
    fn of<P>(sleeve: &Sleeve<P>) -> Self {
        let components = sleeve.components.len();
        let angular = sleeve.components.iter().filter(|component| component.strain < ANGULAR).count();
        Self {
            packs: sleeve.packs as u64,
            nodes: (sleeve.packs * LANES) as u64,
            components: components as u64,
            pairs: pairs(components).count() as u64,
            coordinates: sleeve.components.iter().map(|component| component.modes as u64).sum(),
            angular: angular as u64,
        }
    }
}

/// Number of angular strains.
const ANGULAR: usize = 3;

/// Divides the shared cost of a sleeve's threads equally among their actuators, up to rounding.
fn share<P>(sleeve: &Sleeve<P>, shared: Products, to: &mut [Products]) {
    let number = sleeve.threads.len() as u64;
    let part = |count: u64, i: u64| count * (i + 1) / number - count * i / number;
    for (i, thread) in (0..).zip(&sleeve.threads) {
        to[thread.actuator] += Products { packs: part(shared.packs, i), singles: part(shared.singles, i) };
    }
}

/// `effect::actuation`, forces: lengths with their gradients and rates, and forces.
pub(super) fn action<G: Turning>(plan: &Plan<G>) -> Vec<Products> {
    let (vector, number) = (Vector::<Counted>::zero(), Counted);
    let dot = products(|| vector.dot(vector));
    let of_linear = |actuator: &ActuatorPlan| {
        let law = if actuator.law.has_stiffness() { 2 } else { 0 };
        // The gradient of the linear part, the rate, and the generalised forces.
        (actuator.gradient.len() + 2 * actuator.reaches.len() + law) as u64
    };
    let mut counts: Vec<Products> = plan
        .actuation
        .actuators
        .iter()
        .map(|actuator| Products { packs: 0, singles: of_linear(actuator) })
        .collect();
    for sleeve in &plan.actuation.sleeves {
        let Sizes { packs, components, coordinates, .. } = Sizes::of(sleeve);
        share(sleeve, Products { packs: packs * coordinates, singles: 0 }, &mut counts);
        let slope = products(|| vector.add_scaled(vector, number));
        let node = components * slope + dot + 1 + components * (dot + 1);
        for thread in &sleeve.threads {
            counts[thread.actuator].packs += packs * (node + coordinates);
        }
    }
    for (i, actuator) in plan.actuation.actuators.iter().enumerate().filter(|(_, a)| a.friction.is_some()) {
        for sleeve in threads(plan, i) {
            let size = Sizes::of(sleeve);
            counts[i].packs += 2 * size.packs * size.coordinates;
            counts[i].singles += size.nodes * (turning(&size) + dot + 2 + size.nodes + 1);
        }
        counts[i].singles += actuator.reaches.len() as u64;
    }
    for line in &plan.actuation.lines {
        let count = &mut counts[line.actuator].singles;
        // Length, direction and rate.
        *count += 2 * dot + products(|| vector * number);
        for _ in line.ends.iter().filter(|end| matches!(end, End::On { .. })) {
            let position = products(|| G::rotate::<Counted>(&G::unrotated(), VectorSpace::zero()));
            let velocity = products(|| vector.cross(vector));
            *count += position + velocity + pull::<G>();
        }
    }
    counts
}

/// `kernel::lines`, and responses of `effect::actuation`: the derivative of the forces.
pub(super) fn response<G: Turning>(plan: &Plan<G>) -> Vec<Products> {
    let vector = Vector::<Counted>::zero();
    let dot = products(|| vector.dot(vector));
    let mut counts = vec![Products::default(); plan.actuation.actuators.len()];
    for sleeve in &plan.actuation.sleeves {
        let Sizes { packs, pairs, coordinates, .. } = Sizes::of(sleeve);
        // Entries of the block; the lower triangle is a copy of the upper one.
        let entries = coordinates * (coordinates + 1) / 2;
        share(sleeve, Products { packs: packs * 2 * entries, singles: 0 }, &mut counts);
        for thread in &sleeve.threads {
            counts[thread.actuator].packs += packs * pairs * 4;
        }
    }
    for (i, actuator) in plan.actuation.actuators.iter().enumerate() {
        let reached = actuator.reaches.len() as u64;
        if has_rate(actuator) {
            for sleeve in threads(plan, i) {
                let Sizes { packs, components, pairs, coordinates, .. } = Sizes::of(sleeve);
                counts[i].packs += packs * (2 * coordinates + 3 * pairs + (pairs - components));
            }
        }
        if actuator.friction.is_some() {
            for sleeve in threads(plan, i) {
                let size = Sizes::of(sleeve);
                let Sizes { packs, nodes, components, coordinates, .. } = size;
                counts[i].packs += 3 * packs * coordinates;
                // Derivatives of the rotation, and their effect on all following nodes.
                let changes = turning(&size)
                    + 2 * dot
                    + components * (products(|| vector.cross(vector)) + 3 * dot + 4)
                    + 2 * coordinates;
                let behind = reached + nodes * nodes + coordinates * nodes;
                counts[i].singles += nodes * changes + coordinates * behind + coordinates * nodes;
            }
        }
        let law = actuator.law.has_stiffness();
        if law || has_rate(actuator) {
            counts[i].singles += reached * (3 + reached * if has_rate(actuator) { 2 } else { 1 });
        }
        if law || actuator.friction.is_some() {
            let lines = plan.actuation.lines.iter().filter(|line| line.actuator == i).count();
            counts[i].singles += lines as u64 * plan.n as u64 * dot;
        }
    }
    for line in &plan.actuation.lines {
        let reached = plan.actuation.actuators[line.actuator].reaches.len() as u64;
        let count = &mut counts[line.actuator];
        count.singles += reached * (2 * dot + reached * (dot + 1));
        for end in &line.ends {
            let End::On { moved_by, .. } = end else { continue };
            let dead =
                products(|| Gyroscope::<G, Counted>::of_dead_load(Wrench::zero(), VectorSpace::zero()));
            count.singles += pull::<G>() + dead;
            for (s, _) in moved_by {
                *count += column(&plan.pieces[*s]);
            }
        }
    }
    counts
}

/// Effect of a piece on an end of a straight part (`turning::columns`, `effect::actuation::line::changes`).
fn column<G: Turning>(piece: &PiecePlan<G>) -> Products {
    let (twist, vector) = (Twist::<G, Counted>::zero(), Vector::<Counted>::zero());
    let [bracket, dot] = [products(|| twist.bracket(twist)), products(|| vector.dot(vector))];
    let change = bracket + 3 * products(|| vector.cross(vector)) + 5 * dot;
    let mut count = Products { packs: 0, singles: piece.n as u64 * change };
    if piece.packs == 0 {
        count.singles += bracket;
        return count;
    }
    let at_node = 1 + bracket + 2 * products(|| twist.add_scaled(twist, Counted));
    for component in &piece.components {
        let (position, axis) = (<G::Vector<Counted>>::zero(), <G::Axial<Counted>>::zero());
        let shape = if component.index < G::ANGULAR { products(|| position.cross(axis)) } else { 0 };
        count.packs += (component.modes * piece.packs) as u64 * (shape + at_node);
    }
    count
}

/// Whether the tangent needs the rate of the length's gradient.
fn has_rate(actuator: &ActuatorPlan) -> bool {
    let is_damped = match actuator.law {
        Law::Cable { damping, .. } | Law::Servo { damping, .. } => damping != 0.0,
        Law::Tension | Law::Inextensible { .. } | Law::Pressure | Law::Torque { .. } | Law::Amount { .. } => {
            false
        }
    };
    is_damped || actuator.friction.as_ref().is_some_and(|friction| friction.sliding.is_none())
}

/// Rotation of a thread at a node (`friction::node_of`).
fn turning(size: &Sizes) -> u64 {
    let (vector, number) = (Vector::<Counted>::zero(), Counted);
    let [dot, cross, scaled] =
        [products(|| vector.dot(vector)), products(|| vector.cross(vector)), products(|| vector * number)];
    let strains = 2 * size.coordinates + (3 * size.components + size.angular) * scaled;
    strains + cross + 3 * dot + 3 * scaled + 1
}

/// Force of a straight part on one end.
fn pull<G: Turning>() -> u64 {
    let wrench = Wrench::<G, Counted>::zero();
    // The force, its direction, and its moment about the origin.
    products(|| (Counted * Counted, Vector::zero() * (Counted * Counted), wrench.at(VectorSpace::zero())))
}
