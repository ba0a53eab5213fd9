//! Compiles loads to parts of a plan.

use crate::numerics::lie::{Rotation, VectorSpace, Wrench};
use crate::robot::compile::links::Tree;
use crate::robot::description::Inputs;
use crate::robot::effects::load::plan as load;
use crate::robot::effects::load::plan::{LoadPlan, Spread};
use crate::robot::effects::load::{Extent, Frame};
use crate::robot::plan::command::Command;
use crate::robot::plan::packed;
use crate::robot::turning::Turning;

pub(crate) fn plan<G: Turning>(
    load: crate::robot::effects::load::Load,
    frame: G::Frame,
    base_rotation: &Rotation<f64>,
    base_moves: bool,
    inputs: &Inputs,
) -> LoadPlan<G> {
    let constant = [&load.force, &load.moment].map(|signal| signal.constant().unwrap_or_default());
    let wrench: Wrench<G, f64> = load::wrench(constant, load.frame, frame, base_rotation);
    let varies_in_time = load.varies_in_time() || (base_moves && load.frame == Frame::World);
    let has_input = load.force.input().is_some() || load.moment.input().is_some();
    LoadPlan {
        link: load.link,
        extent: load.extent,
        frame: load.frame,
        has_potential: load.frame == Frame::World && load.force.constant().is_some(),
        has_moment: load.moment.constant().is_none() || wrench.moment.dot(wrench.moment) > 0.0,
        signals: (varies_in_time || has_input)
            .then(|| [&load.force, &load.moment].map(|signal| Command::new(signal, inputs))),
        varies_in_time,
        wrench,
    }
}

/// Assigns distributed loads to the pieces.
pub(crate) fn compile<G: Turning>(tree: &mut Tree<G>, loads: &[LoadPlan<G>]) {
    for (l, link) in tree.links.iter().enumerate() {
        let mut start = 0.0;
        for piece in &mut tree.pieces[link.rod.clone()] {
            let end = start + piece.length;
            let mut integral = None;
            for (load, LoadPlan { extent, .. }) in loads.iter().enumerate().filter(|(_, load)| load.link == l)
            {
                let &Extent::Along([from, to]) = extent else { continue };
                if to <= start || from >= end {
                    continue;
                }
                let gauss = &piece.gauss;
                let integral = integral.get_or_insert_with(|| gauss.integral());
                let part = [from, to].map(|x| ((x - start) / piece.length).clamp(0.0, 1.0));
                let [from, to] = part.map(|x| integral.weights_up_to(x));
                let density = packed(from.len(), |i| (to[i] - from[i]) / gauss.weights[i]);
                let part = (part != [0.0, 1.0]).then_some(part);
                piece.spread.push(Spread { load, density, part });
            }
            start = end;
        }
    }
}
