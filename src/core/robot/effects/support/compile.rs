//! Compiles supports to anchors of a plan.

use crate::numerics::lie::{Quaternion, Rotation, Vector};
use crate::robot::compile::links::Tree;
use crate::robot::description::Robot;
use crate::robot::effects::support::Support;
use crate::robot::effects::support::plan::{AlongAxes, Anchor};
use crate::robot::kernel::kinematics;
use crate::robot::plan::Plan;
use crate::robot::plan::point::Place;
use crate::robot::state::Workspace;
use crate::robot::turning::{Turning, place};

/// Places of all supports.
pub(crate) fn places<G: Turning>(robot: &Robot, tree: &Tree<G>) -> Vec<Option<Place>> {
    let place_of = |support: &Support| place::on_link(&tree.pieces, &tree.links[support.link], support.at);
    robot.supports.iter().map(place_of).map(Some).collect()
}

/// Compiles the supports of a plan whose points are known, in the frame of the base at rest: `anchors` of its points lists
/// those at each.
pub(crate) fn compile<G: Turning>(plan: &mut Plan<G>, robot: &Robot) {
    if robot.supports.is_empty() {
        return;
    }
    let mut at = vec![0; robot.supports.len()];
    for (p, point) in plan.points.iter().enumerate() {
        point.effects.anchors.iter().for_each(|&a| at[a] = p);
    }
    // Poses of the sections at zero coordinates.
    let mut work = Workspace::new(plan);
    kinematics::run(plan, &mut work, &vec![0.0; plan.n]);
    let base = &plan.world.base.rotation;
    let in_frame = |v: Vector<f64>| base.apply_transposed(v);
    let compiled = |(support, &p): (&Support, &usize)| {
        let state = &work.points[p];
        let position = match support.position {
            Some(position) => in_frame(Vector::from(position) - plan.world.base.position),
            None => G::in_space(plan.frame, state.position),
        };
        let axes = match support.orientation {
            Some(orientation) => {
                let Rotation { x, y, z } = Quaternion::from_array(orientation).rotation();
                Rotation { x: in_frame(x), y: in_frame(y), z: in_frame(z) }
            }
            None => G::rotation_in_space(plan.frame, &state.rotation),
        };
        let [x, y, z] = support.rotational_stiffness.map(|stiffness| 0.5 * stiffness);
        let turning = [y + z - x, z + x - y, x + y - z];
        let &Support { stiffness, damping, rotational_damping, .. } = support;
        Anchor::new(position, axes, turning, AlongAxes { stiffness, damping, rotational_damping })
    };
    plan.effects.anchors = robot.supports.iter().zip(&at).map(compiled).collect();
}
