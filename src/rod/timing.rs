//! What depends on the time by itself, taken at a time: the loads that vary.

use super::plan::{self, Plan};
use super::turning::Turning;
use super::workspace::Workspace;
use crate::error::Interrupted;

/// The loads at the time `t`. Where a function of time fails, no time is set.
pub(super) fn set<G: Turning>(plan: &Plan<G>, work: &mut Workspace<G>, t: f64) -> Result<(), Interrupted> {
    work.time = f64::NAN;
    work.motion_is_known = false;
    for (load, acting) in plan.loads.iter().zip(&mut work.acting) {
        if let Some([force, moment]) = &load.signals {
            let now = [force.at(t)?, moment.at(t)?];
            *acting = plan::wrench(now, load.frame, plan.frame, &plan.base_rotation);
        }
    }
    work.time = t;
    Ok(())
}
