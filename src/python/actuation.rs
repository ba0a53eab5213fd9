//! Actuators by their names.

use crate::description::schema::or_meant;
use crate::error::InvalidInput;
use crate::robot::Robot;
use crate::robot::effects::actuator::Actuator;

/// Index of an actuator of a robot.
pub(super) fn actuator_index(robot: &Robot, name: &str) -> Result<usize, InvalidInput> {
    let names = || robot.actuators.iter().map(Actuator::name);
    names().position(|known| known == name).ok_or_else(|| {
        let all = names().map(|name| format!("'{name}'")).collect::<Vec<_>>().join(", ");
        let meant = or_meant(name, names());
        let expected = match all.is_empty() {
            true => "an actuator, but the robot has none".to_owned(),
            false => format!("one of the actuators: {all}{meant}"),
        };
        InvalidInput::new("name", format_args!("'{name}'"), expected)
    })
}
