//! Compiles magnets, and the field as a load without a place.

use super::law::Dipole;
use super::plan::{ActiveDipole, DipolePlace, Fixed, Magnets};
use super::{Magnet, is_magnetised};
use crate::numerics::lie::{LANES, Lanes, Rotation, Vector, VectorSpace};
use crate::robot::compile::links::Tree;
use crate::robot::description::Robot;
use crate::robot::effects::load::compile as load;
use crate::robot::effects::load::{Extent, Load};
use crate::robot::kernel::kinematics;
use crate::robot::plan::link::LinkPlan;
use crate::robot::plan::piece::PiecePlan;
use crate::robot::plan::point::Place;
use crate::robot::plan::{Plan, packed};
use crate::robot::turning::{Turning, place};

/// Places of all magnets.
pub(crate) fn places<G: Turning>(robot: &Robot, tree: &Tree<G>) -> Vec<Option<Place>> {
    let place_of = |magnet: &Magnet| place::on_link(&tree.pieces, &tree.links[magnet.link], magnet.at);
    robot.magnets.iter().map(place_of).map(Some).collect()
}

/// Adds magnets to a plan whose points are known; points list their magnets.
pub(crate) fn compile<G: Turning>(plan: &mut Plan<G>, robot: &Robot) {
    if robot.magnets.is_empty() && !robot.segments().any(is_magnetised) {
        return;
    }
    let mut magnets = Magnets::default();
    let owners: Vec<usize> = robot.magnets.iter().map(|magnet| magnet.link).collect();
    for (i, magnet) in robot.magnets.iter().enumerate() {
        let point = plan.points.iter().position(|point| point.effects.magnets.contains(&i));
        let point = point.expect("every magnet is at a point");
        let own = in_axes_of_point(plan, magnet);
        let moved_by = kinematics::moved_by(plan, &plan.points[point].place);
        magnets.fixed.push(Fixed { moment: G::vector_of(plan.frame, own.moment), point });
        magnets.active_dipoles.push(ActiveDipole { place: DipolePlace::Point(point), own, moved_by });
    }
    for a in 0..owners.len() {
        for b in a + 1..owners.len() {
            if !move_alike(&magnets.active_dipoles[a].moved_by, &magnets.active_dipoles[b].moved_by) {
                magnets.pairs.push([a, b]);
            }
        }
    }
    add_segments(plan, robot, &mut magnets);
    magnets.pairs.sort_unstable();
    add_field(plan, robot, &mut magnets);
    plan.effects.magnets = magnets;
}

/// Whether two places keep their distance, because the same pieces move them.
fn move_alike<P: Lanes>(a: &[(usize, Vec<P>)], b: &[(usize, Vec<P>)]) -> bool {
    let lanes = |weights: &[P]| -> Vec<[f64; LANES]> {
        weights.iter().map(|pack| std::array::from_fn(|lane| pack.lane(lane))).collect()
    };
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.0 == b.0 && lanes(&a.1) == lanes(&b.1))
}

/// A magnet in the axes of its point: links that are welded together share one.
fn in_axes_of_point<G: Turning>(plan: &Plan<G>, magnet: &Magnet) -> Dipole {
    let [moment, position] = [magnet.moment, magnet.position].map(Vector::from);
    let beside = place::on_link(&plan.pieces, &plan.links[magnet.link], magnet.at).beside;
    match beside {
        None => Dipole { moment, position },
        Some(beside) => {
            let Rotation { x, y, z } = beside.orientation.rotation();
            let turned = |v: Vector<f64>| x * v.x + y * v.y + z * v.z;
            Dipole { moment: turned(moment), position: beside.position + turned(position) }
        }
    }
}

/// Moment per length at the node i of a piece.
fn density<G: Turning>(piece: &PiecePlan<G>, i: usize) -> Vector<f64> {
    let (part, x) = (piece.part(), piece.gauss.nodes[i]);
    let area = part.section(x).mass / part.segment.density;
    Vector::from(part.segment.magnetisation.at(part.place(x))) * area
}

/// Adds the densities of magnetised segments and, if there are magnets, their nodes.
fn add_segments<G: Turning>(plan: &Plan<G>, robot: &Robot, magnets: &mut Magnets<G>) {
    if !robot.segments().any(is_magnetised) {
        return;
    }
    magnets.along = vec![VectorSpace::zero(); plan.packs];
    magnets.begins = vec![false; plan.packs];
    for (s, piece) in plan.pieces.iter().enumerate() {
        if piece.is_joint || !piece.source.as_ref().is_some_and(|part| is_magnetised(&part.segment)) {
            continue;
        }
        magnets.begins[piece.first_pack] = true;
        let nodes = piece.gauss.nodes.len();
        for index in 0..G::COMPONENTS - G::ANGULAR {
            let of_node =
                |i: usize| *G::vector_component(&mut G::vector_of(plan.frame, density(piece, i)), index);
            for (pack, values) in packed::<G::Pack>(nodes, of_node).into_iter().enumerate() {
                *G::vector_component(&mut magnets.along[piece.first_pack + pack], index) = values;
            }
        }
        let has_it = |link: &LinkPlan| link.rod.contains(&s);
        let owner = plan.links.iter().position(has_it);
        for i in 0..nodes {
            add_node(plan, robot, magnets, (s, i), owner);
        }
    }
}

/// Adds a node of a magnetised piece, if magnets of other links than its owner move against it.
fn add_node<G: Turning>(
    plan: &Plan<G>,
    robot: &Robot,
    magnets: &mut Magnets<G>,
    (s, i): (usize, usize),
    owner: Option<usize>,
) {
    if robot.magnets.iter().all(|magnet| Some(magnet.link) == owner) {
        return;
    }
    let piece = &plan.pieces[s];
    let (pack, lane) = (piece.first_pack + i / LANES, i % LANES);
    let weight = piece.weights[i / LANES].lane(lane);
    let moved_by = kinematics::moved_by(plan, &place::at_fraction(&plan.pieces, s, piece.gauss.nodes[i]));
    let before = magnets.pairs.len();
    let number = magnets.active_dipoles.len();
    for (a, magnet) in robot.magnets.iter().enumerate() {
        if Some(magnet.link) != owner && !move_alike(&magnets.active_dipoles[a].moved_by, &moved_by) {
            magnets.pairs.push([a, number]);
        }
    }
    if magnets.pairs.len() > before {
        let own = Dipole { moment: density(piece, i) * weight, position: Vector::zero() };
        magnets.active_dipoles.push(ActiveDipole {
            place: DipolePlace::Node { pack, lane, weight },
            own,
            moved_by,
        });
    }
}

/// Adds the field as a load without a place of action, so that it follows time, inputs and the base like other loads.
fn add_field<G: Turning>(plan: &mut Plan<G>, robot: &Robot, magnets: &mut Magnets<G>) {
    if robot.field.is_zero() {
        return;
    }
    let (base, is_moving) = (plan.world.base.rotation, plan.world.motion.is_some());
    let load = Load { force: robot.field.clone(), extent: Extent::Along([0.0; 2]), ..Load::at_tip() };
    let load = load::plan(load, plan.frame, &base, is_moving, &plan.inputs);
    if let Some(field) = robot.field.constant() {
        // Out of the plane of motion, at zero coordinates.
        let field = base.apply_transposed(Vector::from(field));
        let aside = |v: Vector<f64>| v - G::in_space(plan.frame, G::vector_of(plan.frame, v));
        let of_magnets = robot
            .magnets
            .iter()
            .zip(&magnets.active_dipoles)
            .map(|(_, active_dipole)| active_dipole.own.moment);
        let pieces = plan.pieces.iter().filter(|piece| magnets.begins.get(piece.first_pack) == Some(&true));
        let pieces = pieces.filter(|piece| piece.packs > 0);
        let of_segments = pieces.flat_map(|piece| {
            let nodes = 0..piece.gauss.nodes.len();
            nodes.map(move |i| density(piece, i) * (piece.gauss.weights[i] * piece.length))
        });
        magnets.aside = -of_magnets.chain(of_segments).map(|moment| aside(moment).dot(field)).sum::<f64>();
    }
    plan.varies_in_time |= load.varies_in_time;
    plan.has_dead_loads = true;
    magnets.field = Some(plan.effects.loads.len());
    plan.effects.loads.push(load);
}
