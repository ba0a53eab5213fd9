//! Compiles the fluid to parts of a plan.

use crate::description::body;
use crate::numerics::lie::Vector;
use crate::robot::description::Robot;
use crate::robot::effects::fluid::Fluid;
use crate::robot::effects::fluid::plan::{Drag, Hull, Immersed, Immersion};
use crate::robot::effects::load::Extent;
use crate::robot::effects::load::compile as load;
use crate::robot::effects::load::plan::Spread;
use crate::robot::plan::world::World;
use crate::robot::plan::{Plan, packed};
use crate::robot::turning::Turning;

/// Effects of a fluid on a body with this hull, whose centre is at `centre` in section axes.
pub(crate) fn hull<G: Turning>(fluid: &Fluid, hull: &body::Hull, centre: G::Vector<f64>) -> Hull<G> {
    let displaced = fluid.density * hull.volume;
    Hull {
        centre,
        displaced: if fluid.is_buoyant { displaced } else { 0.0 },
        added_mass: hull.added_mass_coefficient * displaced,
        viscous: hull.viscous_drag,
        quadratic: 0.5 * fluid.density * hull.drag_coefficient * hull.drag_area,
    }
}

/// Adds the fluid of a robot, with buoyancy, to the pieces of rods. Bodies are points; joints are not affected.
pub(crate) fn compile<G: Turning>(plan: &mut Plan<G>, robot: &Robot) {
    let Some(fluid) = &robot.fluid else { return };
    let Fluid { density, added_mass_coefficient, .. } = *fluid;
    let immersion = Immersion { has_drag: fluid.has_drag(), has_added_mass: fluid.has_added_mass() };
    let is_felt = immersion.has_drag || immersion.has_added_mass;
    let has_buoyancy = fluid.has_buoyancy(robot.gravity);
    let buoyancy = plan.effects.loads.len();
    let mut volume = 0.0;
    for piece in plan.pieces.iter_mut().filter(|piece| !piece.is_joint) {
        let nodes = &piece.gauss.nodes;
        let areas: Vec<f64> = nodes.iter().map(|&x| piece.part().section(x).outline_area).collect();
        let diameter = |i: usize| (4.0 * areas[i] / std::f64::consts::PI).sqrt();
        if is_felt {
            let constant = |value: f64| move |_: usize| value;
            let [across, along] = fluid.viscous_drag.map(|c| packed::<G::Pack>(nodes.len(), constant(c)));
            let [normal, tangential] = fluid.drag_coefficients;
            let quadratic = |c: f64| packed::<G::Pack>(nodes.len(), |i| 0.5 * density * diameter(i) * c);
            let (normal, tangential) = (quadratic(normal), quadratic(std::f64::consts::PI * tangential));
            let drag = |pack: usize| Drag {
                viscous: [across[pack], along[pack]],
                quadratic: [normal[pack], tangential[pack]],
            };
            piece.immersed = Some(Immersed {
                added_mass: packed(nodes.len(), |i| added_mass_coefficient * density * areas[i]),
                drag: (0..piece.packs).map(drag).collect(),
            });
        }
        if has_buoyancy {
            let weights = piece.gauss.weights.iter().zip(&areas);
            volume += piece.length * weights.map(|(weight, area)| weight * area).sum::<f64>();
            let density = packed(nodes.len(), |i| areas[i]);
            piece.spread.push(Spread { load: buoyancy, density, part: None });
        }
    }
    if has_buoyancy {
        let weight = robot.gravity.map(|g| -density * g);
        let extent = Extent::Along([0.0, robot.length()]);
        let load = crate::robot::effects::load::Load {
            force: weight.into(),
            extent,
            ..crate::robot::effects::load::Load::at_tip()
        };
        let World { base, motion, .. } = &plan.world;
        plan.effects.loads.push(load::plan(load, plan.frame, &base.rotation, motion.is_some(), &plan.inputs));
        plan.has_dead_loads = true;
        plan.world.dead_force += Vector::from(weight) * volume;
    }
    if is_felt {
        plan.effects.immersion = Some(immersion);
    }
}
