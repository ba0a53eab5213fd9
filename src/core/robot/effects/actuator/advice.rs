//! Advice on tendons of commanded length after a failed run or search.

use crate::model::constraint::one_sided::TAUT;
use crate::model::springs::LengthTendons;
use crate::robot::description::Robot;

/// The row of the tendon with the largest tension in a shape; of inextensible ones, if any is taut, the one that exceeds its length
/// most. `length` is that of the robot.
pub(crate) fn most_loaded(length_tendons: &LengthTendons, length: f64) -> Option<usize> {
    let rows = 0..length_tendons.excesses.len();
    let is_rigid = |row: &usize| length_tendons.stiffness[*row].is_infinite();
    let taut = rows.clone().filter(is_rigid).filter(|&row| length_tendons.excesses[row] > -TAUT * length);
    let longest = taut.max_by(|&a, &b| length_tendons.excesses[a].total_cmp(&length_tendons.excesses[b]));
    let tension = |row: usize| length_tendons.stiffness[row] * length_tendons.excesses[row];
    let pulling = rows.filter(|row| !is_rigid(row) && length_tendons.excesses[*row] > 0.0);
    longest.or_else(|| pulling.max_by(|&a, &b| tension(a).total_cmp(&tension(b))))
}

/// A sentence about that tendon, in a shape that has been reached or lies ahead.
pub(crate) fn advice(
    robot: &Robot,
    actuator: usize,
    length_tendons: &LengthTendons,
    row: usize,
    is_ahead: bool,
) -> String {
    let name = robot.actuators[actuator].name();
    let (stiffness, excess) = (length_tendons.stiffness[row], length_tendons.excesses[row]);
    let when = if is_ahead { "becomes taut in the next step" } else { "is taut" };
    if stiffness.is_infinite() {
        return format!(
            " The tendon \"{name}\" {when} and does not stretch: if that holds the run, change its `length` more slowly, or give it a \
             `stiffness`."
        );
    }
    let pull = if is_ahead { String::new() } else { format!(" and pulls with {:.1e} N", stiffness * excess) };
    format!(
        " The tendon \"{name}\" {when}{pull}: if that holds the run, give it less `stiffness` than {stiffness:.1e} N/m, some damping, or \
         change its `length` more slowly."
    )
}
