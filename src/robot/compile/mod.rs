//! Compiles the description of a robot to a plan.

mod actuation;
mod anchor;
pub(crate) mod contact;
mod immersion;
mod joint;
mod links;
mod load;
mod loops;
mod piece;
mod points;

use self::links::Tree;
use crate::lie::Instructions;
use crate::load::Frame;
use crate::robot::description::{Inputs, Robot};
use crate::robot::effect::all as effects;
use crate::robot::plan::Plan;
use crate::robot::plan::actuation::ActuatorPlan;
use crate::robot::plan::contact::Contacts;
use crate::robot::plan::load::LoadPlan;
use crate::robot::plan::loops::Loops;
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
        .map(|load| load::plan(load.clone(), frame, &world.base.rotation, is_moving, &inputs))
        .collect();
    load::compile(&mut tree, &loads);
    let straight = actuation::straight(robot, &tree);
    let pulled: Vec<_> =
        straight.iter().flat_map(|line| &line.ends).map(|end| end.place().cloned()).collect();
    let tied = loops::places(robot, &tree);
    let surfaces = contact::places(robot, &tree);
    let (points, supported) = points::compile(frame, &mut tree, &loads, [&pulled, &tied, &surfaces], robot);
    let stations = tree.stations();
    let Tree { pieces, links, n, packs, hinges, .. } = tree;
    let actuation = actuation::compile(robot, &pieces, &links, &inputs, straight);
    let mut plan = Plan {
        n,
        stations,
        has_branches: false,
        carrying: Vec::new(),
        instructions: Instructions::of_machine(),
        packs,
        hinges,
        frame,
        points,
        anchors: Vec::new(),
        loops: Loops::none(),
        contacts: Contacts::none(),
        immersion: None,
        has_responses: false,
        has_dead_loads: loads.iter().any(|load| load.frame == Frame::World)
            || !actuation.lines.is_empty()
            || !tied.is_empty(),
        varies_in_time: is_moving
            || loads.iter().any(|load| load.varies_in_time)
            || actuation.actuators.iter().any(ActuatorPlan::varies_in_time),
        inputs,
        actuation,
        pieces,
        links,
        loads,
        world,
    };
    plan.find_families();
    actuation::attach(&mut plan);
    plan.loops = loops::compile(&plan, robot);
    plan.contacts = contact::compile(&plan, robot);
    if !robot.supports.is_empty() {
        plan.anchors = anchor::compile(&plan, &robot.supports, &supported);
    }
    if let Some(fluid) = &robot.fluid {
        immersion::compile(&mut plan, robot, fluid);
    }
    plan.has_responses = effects::responds(&plan);
    plan
}
