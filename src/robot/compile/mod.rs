//! A rod in plain data made into a plan.

mod anchor;
mod immersion;
mod load;
mod piece;
mod points;

use crate::lie::Instructions;
use crate::load::Frame;
use crate::robot::description::Rod;
use crate::robot::effect::all as effects;
use crate::robot::plan::Plan;
use crate::robot::plan::load::LoadPlan;
use crate::robot::plan::tree::Joined;
use crate::robot::plan::world::World;
use crate::robot::turning::Turning;

/// Compiles a valid rod for a frame that it does not leave.
pub(crate) fn plan<G: Turning>(rod: &Rod, frame: G::Frame) -> Plan<G> {
    let mut pieces = Vec::with_capacity(rod.segments.len());
    let (mut first, mut first_pack) = (0, 0);
    for piece in rod.segments.iter().flat_map(crate::rod::piece::of) {
        let plan = piece::plan(piece, frame, Joined::in_chain(pieces.len()), first, first_pack);
        first += plan.n;
        first_pack += plan.packs;
        pieces.push(plan);
    }
    let world = World::new(rod);
    let is_moving = world.motion.is_some();
    let loads: Vec<LoadPlan<G>> =
        rod.all_loads().map(|load| load::plan(load, frame, &world.base.rotation, is_moving)).collect();
    load::compile(&mut pieces, &loads);
    let (points, supported) = points::compile(frame, &mut pieces, &loads, rod.all_bodies(), &rod.supports);
    let mut plan = Plan {
        n: first,
        stations: pieces.len() + 1,
        has_branches: false,
        instructions: Instructions::of_machine(),
        packs: first_pack,
        frame,
        points,
        anchors: Vec::new(),
        immersion: None,
        has_responses: false,
        has_dead_loads: loads.iter().any(|load| load.frame == Frame::World),
        varies_in_time: is_moving || loads.iter().any(|load| load.signals.is_some()),
        pieces,
        loads,
        world,
    };
    if !rod.supports.is_empty() {
        plan.anchors = anchor::compile(&plan, &rod.supports, &supported);
    }
    if let Some(fluid) = &rod.fluid {
        immersion::compile(&mut plan, rod, fluid);
    }
    plan.find_families();
    plan.has_responses = effects::responds(&plan);
    plan
}
