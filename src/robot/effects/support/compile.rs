//! Compiles supports to anchors of a plan.

use crate::numerics::lie::{Quaternion, Rotation, Vector};
use crate::robot::effects::support::Support;
use crate::robot::effects::support::plan::{AlongAxes, Anchor};
use crate::robot::kernel::kinematics;
use crate::robot::plan::Plan;
use crate::robot::state::Workspace;
use crate::robot::turning::Turning;

/// Compiles the supports of a rod, in the frame of the base at rest. `at` contains the index of the plan's
/// point for each support.
pub(crate) fn compile<G: Turning>(plan: &Plan<G>, supports: &[Support], at: &[usize]) -> Vec<Anchor> {
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
    supports.iter().zip(at).map(compiled).collect()
}
