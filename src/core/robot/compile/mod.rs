//! Compiles the description of a robot to a plan.

mod joint;
pub(crate) mod links;
mod piece;
pub(crate) mod points;

use self::links::Tree;
use crate::robot::description::{Inputs, Robot};
use crate::robot::effects::actuator::plan::ActuatorPlan;
use crate::robot::effects::load::Frame;
use crate::robot::effects::load::plan::LoadPlan;
use crate::robot::effects::parts::Plans;
use crate::robot::effects::{self, actuator, load};
use crate::robot::plan::Plan;
use crate::robot::plan::world::World;
use crate::robot::turning::Turning;

/// Compiles a valid robot for a frame that it does not leave.
pub(crate) fn plan<G: Turning>(robot: &Robot, frame: G::Frame) -> Plan<G> {
    plan_of(robot, frame, Tree::of(robot, frame, true))
}

/// The same with one piece per link, so that the wrench transmitted to each link is known.
pub(crate) fn plan_of_every_link<G: Turning>(robot: &Robot, frame: G::Frame) -> Plan<G> {
    plan_of(robot, frame, Tree::of(robot, frame, false))
}

fn plan_of<G: Turning>(robot: &Robot, frame: G::Frame, mut tree: Tree<G>) -> Plan<G> {
    let world = World::new(robot);
    let is_moving = world.motion.is_some();
    let inputs = Inputs::of(robot);
    let loads: Vec<LoadPlan<G>> = robot
        .acting_loads()
        .map(|load| load::compile::plan(load.clone(), frame, &world.base.rotation, is_moving, &inputs))
        .collect();
    load::compile::compile(&mut tree, &loads);
    let straight = actuator::compile::straight(robot, &tree);
    let pulled = straight.iter().flat_map(|line| &line.ends).map(|end| end.place().cloned()).collect();
    let places = effects::places(robot, &tree, pulled);
    let points = points::compile(frame, &mut tree, &loads, places, robot);
    let stations = tree.stations();
    let Tree { pieces, links, n, packs, hinges, .. } = tree;
    let actuation = actuator::compile::compile(robot, &pieces, &links, &inputs, straight);
    let mut plan = Plan {
        n,
        stations,
        packs,
        hinges,
        points,
        has_dead_loads: loads.iter().any(|load| load.frame == Frame::World) || !actuation.lines.is_empty(),
        varies_in_time: is_moving
            || loads.iter().any(|load| load.varies_in_time)
            || actuation.actuators.iter().any(ActuatorPlan::varies_in_time),
        pieces,
        links,
        ..Plan::empty(frame, world, inputs, Plans { loads, actuation, ..Plans::default() })
    };
    plan.find_families();
    actuator::compile::attach(&mut plan);
    effects::compile(&mut plan, robot);
    plan
}
