//! Forces at the end of a failed run that are absurd for the stiffness of their rods.

use super::Simulation;
use crate::error::Interrupted;
use crate::robot::RobotModel;

/// Adds sentences about absurd forces to the message of a failed run, at its last time and with its last inputs. Only a function of time
/// can fail.
pub fn add_overloads(model: &RobotModel, simulation: &mut Simulation) -> Result<(), Interrupted> {
    let Simulation { t, u, status, .. } = simulation;
    let Some(&end) = t.last().filter(|_| !status.is_success() && !status.is_interrupted()) else {
        return Ok(());
    };
    let last = &u[u.len() - u.len() / t.len()..];
    for sentence in model.overloads(end, (!last.is_empty()).then_some(last))? {
        simulation.message = format!("{} {sentence}", simulation.message);
    }
    Ok(())
}
