//! Strains that a finite number of modes leaves out of a shape at rest, and their effects.
//!
//! Two laws give the internal wrench of a section ([`super::section`]): the balance of everything beyond it, F, and the material
//! with the strains of the modes, `-H (xi - xi_0)`. With infinitely many modes they agree, together with the forces f of embedded
//! tendons and chambers, at every place. With a finite number the strains that have modes lack
//! `-H^-1 (F + f + H (xi - xi_0))`, if all forces stay as they are: the residual of the strong form of the equilibrium.

use crate::description::rod::{STRAINS, SectionProperties};
use crate::model::{MissingStrain, RigidStretch};
use crate::numerics::lie::{Cross, LANES, Lanes, Twist, VectorSpace, weighted_sum};
use crate::numerics::linalg::small_cholesky;
use crate::robot::description::Robot;
use crate::robot::effects::actuator::along_strains;
use crate::robot::effects::actuator::plan::RoutingComponent;
use crate::robot::plan::Plan;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::state::Workspace;
use crate::robot::turning::Turning;

use super::adjoint::carried;
use super::validity;

/// Stretch, by its index in [`STRAIN_NAMES`](crate::description::rod::STRAIN_NAMES).
const STRETCH: usize = 3;

/// Stiffness per length of the strains.
type Stiffness = [[f64; STRAINS]; STRAINS];

/// Values of the strains at a node.
type Strains = [f64; STRAINS];

/// Whether a piece is a part of a rod that can deform.
fn deforms<G: Turning>(piece: &PiecePlan<G>) -> bool {
    piece.packs > 0 && !piece.is_joint && !piece.components.is_empty()
}

/// The nodes of a piece among those of all pieces, as they are in packs.
fn nodes_of<G: Turning>(piece: &PiecePlan<G>) -> std::ops::Range<usize> {
    let first = LANES * piece.first_pack;
    first..first + piece.gauss.nodes.len()
}

/// Stiffness at the nodes of a piece.
fn stiffness_at_nodes<G: Turning>(piece: &PiecePlan<G>) -> impl Fn(usize) -> Stiffness + '_ {
    let part = piece.part();
    let constant = part.has_constant_section().then(|| part.section(0.5).stiffness);
    move |i| constant.unwrap_or_else(|| part.section(piece.gauss.nodes[i]).stiffness)
}

/// Strains of fields in the geometry of a plan, at all nodes; zero where nothing deforms.
fn in_order<G: Turning>(plan: &Plan<G>, fields: &[Twist<G, G::Pack>]) -> Vec<Strains> {
    let mut strains = vec![[0.0; STRAINS]; LANES * plan.packs];
    for piece in plan.pieces.iter().filter(|piece| deforms(piece)) {
        let components = along_strains::components(piece);
        for (i, node) in nodes_of(piece).enumerate() {
            let mut field = fields[piece.first_pack + i / LANES];
            for (component, RoutingComponent { strain, .. }) in piece.components.iter().zip(&components) {
                strains[node][*strain] = field.component_mut(component.index).lane(i % LANES);
            }
        }
    }
    strains
}

/// `sum_k phi_k q_k` of every strain at all nodes.
pub(crate) fn of_modes<G: Turning>(plan: &Plan<G>, q: &[f64]) -> Vec<Strains> {
    let mut fields = vec![Twist::zero(); plan.packs];
    for piece in plan.pieces.iter().filter(|piece| deforms(piece)) {
        piece.fields(q, &mut fields[piece.node_packs()]);
    }
    in_order(plan, &fields)
}

/// Missing strains at all nodes, and the axial strain that stretch without modes leaves out, with the generalised forces at rest up to
/// date: the forces along the rod at its nodes are those of the last projection. A fraction of the loads acts.
pub(crate) fn of_balance<G: Turning>(
    plan: &Plan<G>,
    work: &Workspace<G>,
    robot: &Robot,
    (q, load_factor): (&[f64], f64),
) -> (Vec<Strains>, RigidStretch) {
    let strains = of_modes(plan, q);
    let mut fields = wrenches_as_fields(plan, work);
    let balance = in_order(plan, &fields);
    let mut acting = vec![[0.0; STRAINS]; strains.len()];
    along_strains::add(plan, work, robot, &strains, &mut acting);
    let rigid_stretch = rigid_stretch(plan, &mut fields, &acting);
    let rigid_stretch = RigidStretch {
        strain: load_factor * rigid_stretch.strain,
        force: load_factor * rigid_stretch.force,
        ..rigid_stretch
    };
    let mut missing = vec![[0.0; STRAINS]; strains.len()];
    for piece in plan.pieces.iter().filter(|piece| deforms(piece)) {
        let present: Vec<usize> = along_strains::components(piece).iter().map(|own| own.strain).collect();
        let stiffness = stiffness_at_nodes(piece);
        let mut factors = vec![0.0; present.len() * present.len()];
        let mut force = vec![0.0; present.len()];
        for (i, node) in nodes_of(piece).enumerate() {
            let stiffness = stiffness(i);
            for (a, &row) in present.iter().enumerate() {
                let of_material: f64 = present.iter().map(|&k| stiffness[row][k] * strains[node][k]).sum();
                force[a] = -(load_factor * (balance[node][row] + acting[node][row]) + of_material);
                for (b, &column) in present.iter().enumerate() {
                    factors[b * present.len() + a] = stiffness[row][column];
                }
            }
            if small_cholesky::factorise(&mut factors, present.len()).is_ok() {
                small_cholesky::solve(&factors, &mut force);
                present.iter().zip(&force).for_each(|(&strain, &x)| missing[node][strain] = x);
            }
        }
    }
    (missing, rigid_stretch)
}

/// The segment whose length the axial forces in it would change most, of those whose stretch has no modes: by the wrenches of the balance and
/// the forces of actuators at the nodes.
fn rigid_stretch<G: Turning>(
    plan: &Plan<G>,
    balance: &mut [Twist<G, G::Pack>],
    acting: &[Strains],
) -> RigidStretch {
    let index = G::strain_index(plan.frame, STRETCH);
    let mut found = RigidStretch::default();
    let is_rigid = |piece: &PiecePlan<G>| deforms(piece) && piece.part().modes[STRETCH] == 0;
    // A segment may consist of several pieces, of constant strain.
    let mut whole = (None, RigidStretch::default(), 0.0);
    for (s, piece) in plan.pieces.iter().enumerate().filter(|(_, piece)| is_rigid(piece)) {
        let segment = segment_of(plan, s);
        if whole.0 != Some(segment) {
            whole = (Some(segment), RigidStretch { segment, ..RigidStretch::default() }, 0.0);
        }
        let (_, own, length) = &mut whole;
        let stiffness = stiffness_at_nodes(piece);
        let mut elongation = own.strain * *length;
        for (i, node) in nodes_of(piece).enumerate() {
            let weight = piece.weights[i / LANES].lane(i % LANES);
            let field = balance[piece.first_pack + i / LANES].component_mut(index).lane(i % LANES);
            let (force, stiffness) = (-(field + acting[node][STRETCH]), stiffness(i)[STRETCH][STRETCH]);
            *length += weight;
            // Sections may be given with a stiffness of zero where there are no modes.
            if stiffness > 0.0 {
                elongation += weight * force / stiffness;
            }
            if force.abs() > own.force.abs() {
                (own.force, own.stiffness) = (force, stiffness);
            }
        }
        own.strain = elongation / *length;
        if own.strain.abs() > found.strain.abs() {
            found = *own;
        }
    }
    found
}

/// The internal wrench at the nodes in section axes, as components of a twist.
fn wrenches_as_fields<G: Turning>(plan: &Plan<G>, work: &Workspace<G>) -> Vec<Twist<G, G::Pack>> {
    let as_field = |wrench: &crate::numerics::lie::Wrench<G, G::Pack>| {
        let (mut wrench, mut field) = (*wrench, Twist::zero());
        for k in 0..G::COMPONENTS {
            *field.component_mut(k) = *wrench.component_mut(k);
        }
        field
    };
    work.body[..plan.packs].iter().map(as_field).collect()
}

/// [`MissingStrain::rigid_shear`] of a segment, counted through all rods, by the theory of Timoshenko (1921): F L / (k G A) over
/// F L^3 / (3 E I), the larger one of both planes.
pub(crate) fn rigid_shear(robot: &Robot, segment: usize) -> f64 {
    /// Bending strains and the shear strains along which they deflect, by their indices in [`STRAIN_NAMES`](crate::description::rod::STRAIN_NAMES).
    const PLANES: [(usize, usize); 2] = [(1, 5), (2, 4)];
    let rods = robot.links.iter().flat_map(|link| link.rod.iter().map(|segment| (segment, &link.rod)));
    let Some((segment, rod)) = rods.clone().nth(segment) else { return 0.0 };
    let length: f64 = rod.iter().map(|segment| segment.length).sum();
    let stiffness = SectionProperties::at(segment, 0.5).stiffness;
    let is_rigid = |&(bend, shear): &(usize, usize)| segment.modes[bend] > 0 && segment.modes[shear] == 0;
    let ratio = |(bend, shear): (usize, usize)| stiffness[bend][bend] / stiffness[shear][shear];
    3.0 / length.powi(2) * PLANES.into_iter().filter(is_rigid).map(ratio).fold(0.0, f64::max)
}

/// Effects of strains at all nodes, to first order, with the kinematics up to date and fixed joints.
pub(crate) fn effect<G: Turning>(plan: &Plan<G>, work: &Workspace<G>, strains: &[Strains]) -> MissingStrain {
    let mut motion = Motion::new(plan);
    let mut effect = MissingStrain::default();
    for (s, piece) in plan.pieces.iter().enumerate() {
        motion.pass(plan, work, strains, s);
        if deforms(piece) {
            let stiffness = stiffness_at_nodes(piece);
            for (i, node) in nodes_of(piece).enumerate() {
                let [curvature, moment] = sizes(&strains[node], &stiffness(i));
                effect.curvature = effect.curvature.max(curvature);
                effect.moment = effect.moment.max(moment);
            }
        }
    }
    effect.displacement = motion.farthest.0;
    if let Some(s) = motion.cause(plan) {
        effect.segment = segment_of(plan, s);
        effect.strain = largest_strain(&plan.pieces[s], strains);
    }
    effect
}

/// Largest rotation of a rod between neighbouring nodes.
pub(crate) fn largest_turn<G: Turning>(plan: &Plan<G>, q: &[f64]) -> f64 {
    let rods = plan.pieces.iter().filter(|piece| piece.packs > 0 && !piece.is_joint);
    rods.map(|piece| validity::largest_turn(piece, q)).fold(0.0, f64::max)
}

/// Curvature, and moment of the material, of these strains.
fn sizes(strains: &Strains, stiffness: &Stiffness) -> [f64; 2] {
    let size = |values: [f64; 3]| values.iter().map(|x| x * x).sum::<f64>().sqrt();
    let moment = |row: usize| (0..STRAINS).map(|k| stiffness[row][k] * strains[k]).sum::<f64>();
    [size([strains[0], strains[1], strains[2]]), size([moment(0), moment(1), moment(2)])]
}

/// The strain of a piece that stores most energy.
fn largest_strain<G: Turning>(piece: &PiecePlan<G>, strains: &[Strains]) -> usize {
    let stiffness = stiffness_at_nodes(piece);
    let mut energy = [0.0; STRAINS];
    for (i, node) in nodes_of(piece).enumerate() {
        let (stiffness, weight) = (stiffness(i), piece.gauss.weights[i]);
        for (k, energy) in energy.iter_mut().enumerate() {
            *energy += weight * stiffness[k][k] * strains[node][k].powi(2);
        }
    }
    (1..STRAINS).fold(0, |largest, k| if energy[k] > energy[largest] { k } else { largest })
}

/// Index of the segment of a piece, counted through all rods.
fn segment_of<G: Turning>(plan: &Plan<G>, piece: usize) -> usize {
    let rods = plan.links.iter().flat_map(|link| link.rod.clone());
    let up_to = rods.take_while(|&other| other <= piece);
    up_to.filter(|&other| plan.pieces[other].part().begins_segment()).count().saturating_sub(1)
}

/// The motion of a robot by strains, to first order, from the base to the tips.
struct Motion<G: Turning> {
    stations: Vec<Twist<G, f64>>,
    /// The piece at which a station is, and the motion by the strains of every piece.
    piece_at: Vec<Option<usize>>,
    by_piece: Vec<Twist<G, f64>>,
    /// The largest displacement, its place and its piece.
    farthest: (f64, G::Vector<f64>, usize),
}

impl<G: Turning> Motion<G> {
    fn new(plan: &Plan<G>) -> Self {
        Self {
            stations: vec![Twist::zero(); plan.stations],
            piece_at: vec![None; plan.stations],
            by_piece: vec![Twist::zero(); plan.pieces.len()],
            farthest: (0.0, VectorSpace::zero(), 0),
        }
    }

    /// Adds a piece whose carrier is known.
    fn pass(&mut self, plan: &Plan<G>, work: &Workspace<G>, strains: &[Strains], s: usize) {
        let piece = &plan.pieces[s];
        let (end, start) = (piece.joined.end, self.stations[piece.joined.carrier()]);
        self.piece_at[end] = Some(s);
        let mut rates = vec![Twist::zero(); piece.packs];
        if deforms(piece) {
            self.find_rates(piece, work, strains, &mut rates);
            let mut change = Twist::zero();
            rates.iter().zip(&piece.weights).for_each(|(&rate, &weight)| change += rate * weight);
            self.by_piece[s] = change.sum();
            for (pack, row) in piece.rows(&piece.from_base).enumerate() {
                let moved = weighted_sum(start.splat(), row, &rates, Twist::add_lane);
                let position = &work.position[piece.first_pack + pack];
                for lane in 0..LANES.min(piece.gauss.nodes.len() - LANES * pack) {
                    let position = G::map_vector(position, |x: &G::Pack| x.lane(lane));
                    self.record_displacement(moved.map(|x: &G::Pack| x.lane(lane)), position, s);
                }
            }
        }
        self.stations[end] = start + self.by_piece[s];
        self.record_displacement(self.stations[end], work.stations[end].position, s);
        for point in piece.points.inside.clone().map(|p| &plan.points[p]) {
            if let Some(station) = point.carries {
                self.stations[station] = start + point.reach().integral(&rates);
                self.piece_at[station] = Some(s);
            }
        }
    }

    /// Twists per length of the strains at the nodes of a piece.
    fn find_rates(
        &self,
        piece: &PiecePlan<G>,
        work: &Workspace<G>,
        strains: &[Strains],
        rates: &mut [Twist<G, G::Pack>],
    ) {
        let components = along_strains::components(piece);
        for (i, node) in nodes_of(piece).enumerate() {
            for (component, own) in piece.components.iter().zip(&components) {
                let entry = rates[i / LANES].component_mut(component.index);
                entry.set_lane(i % LANES, strains[node][own.strain]);
            }
        }
        for (pack, rate) in rates.iter_mut().enumerate() {
            let at = piece.first_pack + pack;
            *rate = carried(&work.rotation[at], work.position[at], *rate, piece.is_extensible);
        }
    }

    fn record_displacement(&mut self, moved: Twist<G, f64>, position: G::Vector<f64>, s: usize) {
        let distance = displacement(moved, position);
        if distance > self.farthest.0 {
            self.farthest = (distance, position, s);
        }
    }

    /// The piece whose strains contribute most to the largest displacement.
    fn cause(&self, plan: &Plan<G>) -> Option<usize> {
        let (farthest, position, mut s) = self.farthest;
        if farthest == 0.0 {
            return None;
        }
        let mut cause = (0.0, None);
        loop {
            let by_this = displacement(self.by_piece[s], position);
            if by_this > cause.0 {
                cause = (by_this, Some(s));
            }
            match self.piece_at[plan.pieces[s].joined.carrier()] {
                Some(before) if before != s => s = before,
                _ => return cause.1,
            }
        }
    }
}

/// Displacement of a point by a twist.
fn displacement<G: Turning>(moved: Twist<G, f64>, position: G::Vector<f64>) -> f64 {
    let by = moved.linear - position.cross(moved.angular);
    by.dot(by).sqrt()
}
