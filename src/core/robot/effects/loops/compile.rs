//! Compiles closed loops to constraints of a plan.

use crate::description::joint::{Joint, across, unit};
use crate::model::Constraint;
use crate::numerics::lie::{Quaternion, Rotation, Vector};
use crate::robot::algebra::tie::{Frame, Row};
use crate::robot::compile::links::Tree;
use crate::robot::description::Robot;
use crate::robot::effects::loops::plan::{Gear, Loops, On, TieEnd, TiePlan};
use crate::robot::effects::loops::{Loop, LoopEnd, Tie};
use crate::robot::kernel::kinematics;
use crate::robot::plan::Plan;
use crate::robot::plan::point::{Offset, Place, Point};
use crate::robot::turning::{Turning, place};

/// Places of the ends of all ties, two for each; `None` for ends in the world.
pub(crate) fn places<G: Turning>(robot: &Robot, tree: &Tree<G>) -> Vec<Option<Place>> {
    let place_of = |end: &LoopEnd| Some(place::on_link(&tree.pieces, &tree.links[end.link?], end.at));
    robot.loops.iter().filter_map(|tie| tie.tie.ends()).flatten().map(place_of).collect()
}

/// Constraints of a plan whose points are known: `tied` of its points lists the ends at each.
pub(crate) fn compile<G: Turning>(plan: &mut Plan<G>, robot: &Robot) {
    let mut loops = Loops::default();
    let mut ends = 0;
    for Loop { tie, .. } in &robot.loops {
        let rows = match tie {
            Tie::Joint { joint, .. } => rows_of(joint),
            Tie::Distance { length, .. } => vec![Row::Distance(*length)],
            Tie::Coordinates { .. } => continue,
        };
        let shared = match tie {
            Tie::Joint { joint, .. } => shared_by(joint),
            _ => Vec::new(),
        };
        let first = loops.rows;
        loops.rows += rows.len();
        let ends: [TieEnd<G::Pack>; 2] =
            tie.ends().expect("all but gears have ends").each_ref().map(|described| {
                ends += 1;
                end(plan, robot, described, ends - 1)
            });
        let moved_by = ends.iter().filter_map(|end| end.on.as_ref()).flat_map(|on| &on.moved_by);
        let mut reaches: Vec<usize> = moved_by.flat_map(|(s, _)| plan.pieces[*s].coordinates()).collect();
        reaches.sort_unstable();
        reaches.dedup();
        let number = loops.ties.len();
        loops.ties.push(TiePlan { number, ends, rows, shared, first, reaches });
    }
    let all = places_of_own(robot);
    for Loop { tie, .. } in &robot.loops {
        if let &Tie::Coordinates { coordinates, ratio, offset } = tie {
            loops.gears.push(Gear { coordinates: coordinates.map(|k| all[k]), ratio, offset });
            loops.rows += 1;
        }
    }
    let is_gear = |l: usize| matches!(robot.loops[l].tie, Tie::Coordinates { .. });
    let in_order =
        (0..robot.loops.len()).filter(|&l| !is_gear(l)).chain((0..robot.loops.len()).filter(|&l| is_gear(l)));
    let of_loops = in_order.flat_map(|l| std::iter::repeat_n(Constraint::Loop(l), robot.loops[l].tie.rows()));
    let is_inextensible = |&i: &usize| robot.actuators[i].is_inextensible();
    loops.lengths = (0..robot.actuators.len()).filter(is_inextensible).collect();
    loops.rows += loops.lengths.len();
    loops.constraints = of_loops.chain(loops.lengths.iter().map(|&i| Constraint::Tendon(i))).collect();
    plan.has_dead_loads |= !loops.ties.is_empty();
    plan.effects.loops = loops;
}

/// Indices of the robot's own coordinates among those of all joints and rods.
fn places_of_own(robot: &Robot) -> Vec<usize> {
    let (mut own, mut first) = (Vec::new(), 0);
    for link in &robot.links {
        let of_joint = link.joint.coordinates().len();
        let all = of_joint + link.coordinates() - link.joint_coordinates().len();
        let driven = if link.driven.is_some() { of_joint } else { 0 };
        own.extend(first + driven..first + all);
        first += all;
    }
    own
}

fn end<G: Turning>(plan: &Plan<G>, robot: &Robot, described: &LoopEnd, number: usize) -> TieEnd<G::Pack> {
    let (position, orientation) =
        (Vector::from(described.position), Quaternion::from_array(described.orientation));
    let Some(link) = described.link else {
        // The frame of the plan is that of the first link's joint.
        let root = &robot.links[0];
        let base = Quaternion::from_array(root.orientation).rotation();
        let Rotation { x, y, z } = orientation.rotation();
        let seen = |v: Vector<f64>| base.apply_transposed(v);
        let axes = Rotation { x: seen(x), y: seen(y), z: seen(z) };
        let frame = Frame { position: seen(position - Vector::from(root.position)), axes };
        return TieEnd { frame, on: None };
    };
    let has_it = |point: &Point<G>| point.effects.tied.contains(&number);
    let point = plan.points.iter().position(has_it).expect("every end is at a point");
    let at = &plan.points[point].place;
    let own = Offset { orientation, position };
    // Links that are welded together share a point, with different offsets.
    let of_link = place::on_link(&plan.pieces, &plan.links[link], described.at).beside;
    let beside = of_link.map_or(own, |place| place.times(own));
    let on = On { point, moved_by: kinematics::moved_by(plan, at) };
    let frame = Frame { position: beside.position, axes: beside.orientation.rotation() };
    TieEnd { frame, on: Some(on) }
}

/// Directions that are the same in both ends of a joint.
fn shared_by(joint: &Joint) -> Vec<Vector<f64>> {
    match joint {
        Joint::Weld | Joint::Prismatic { .. } => {
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Vector::from).to_vec()
        }
        Joint::Revolute { axis, .. } | Joint::Cylindrical { axis } | Joint::Planar { normal: axis } => {
            vec![unit(*axis).into()]
        }
        Joint::Universal { .. } | Joint::Screw { .. } | Joint::Spherical | Joint::Free => Vec::new(),
    }
}

/// Constraints of a joint on its second end, in the axes of the ends.
fn rows_of(joint: &Joint) -> Vec<Row> {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Vector::from);
    let along = |directions: &[Vector<f64>]| directions.iter().copied().map(Row::Across).collect::<Vec<_>>();
    let square = |first, second| Row::Angle { first, second, cosine: 0.0 };
    let [x, y, z] = axes;
    let no_turn = [square(x, y), square(y, z), square(z, x)];
    let about = |axis: [f64; 3]| {
        let axis = unit(axis);
        across(axis).map(Vector::from)
    };
    match joint {
        Joint::Weld => [along(&axes), no_turn.to_vec()].concat(),
        Joint::Revolute { axis, .. } => {
            let turns = about(*axis).map(|direction| square(direction, unit(*axis).into()));
            [along(&axes), turns.to_vec()].concat()
        }
        Joint::Prismatic { axis, .. } => [along(&about(*axis)), no_turn.to_vec()].concat(),
        Joint::Cylindrical { axis } => {
            let turns = about(*axis).map(|direction| square(direction, unit(*axis).into()));
            [along(&about(*axis)), turns.to_vec()].concat()
        }
        Joint::Universal { axes: cross } => {
            let [first, second] = cross.map(|axis| Vector::from(unit(axis)));
            let turn = Row::Angle { first, second, cosine: first.dot(second) };
            [along(&axes), vec![turn]].concat()
        }
        Joint::Planar { normal } => {
            let turns = about(*normal).map(|direction| square(direction, unit(*normal).into()));
            [along(&[unit(*normal).into()]), turns.to_vec()].concat()
        }
        Joint::Spherical => along(&axes),
        Joint::Screw { .. } | Joint::Free => unreachable!("such a joint closes no loop: `Robot::validate`"),
    }
}
