//! What depends on the time by itself, taken at a time: the base, the world seen from it, and the loads that vary.

use crate::error::Interrupted;
use crate::robot::plan::{Plan, load};
use crate::robot::state::surroundings::Surroundings;
use crate::robot::state::{Workspace, surroundings};
use crate::robot::turning::Turning;
use crate::world::base_motion::Base;

/// Moves a rod without base motion, without velocity, to where the base of another one is.
pub(crate) fn place<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>, base: &Base) {
    work.motion_is_known = false;
    see(plan, work, base.at_rest());
}

fn see<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>, base: Base) {
    work.surroundings = Surroundings::new(&plan.world, plan.frame, base);
    for (anchor, seen) in work.anchors.iter_mut().zip(surroundings::seen_anchors(plan, &base)) {
        *anchor = seen;
    }
}

/// Takes base and loads at the time `t`. Where a function of time fails, no time is set.
pub(crate) fn set<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>, t: f64) -> Result<(), Interrupted> {
    work.time = f64::NAN;
    work.motion_is_known = false;
    if let Some(motion) = &plan.world.motion {
        see(plan, work, motion.at(t)?);
        let base = &mut work.stations[0];
        (base.velocity, base.acceleration) = work.surroundings.motion(&plan.world, plan.frame);
    }
    for (load, acting) in plan.loads.iter().zip(&mut work.acting) {
        if let Some([force, moment]) = &load.signals {
            let now = [force.at(t)?, moment.at(t)?];
            *acting = load::wrench(now, load.frame, plan.frame, &work.surroundings.base.rotation);
        }
    }
    work.time = t;
    Ok(())
}
