//! Contacts of robots by their names.

use pyo3::prelude::*;

use super::loops::index_of_one;
use crate::robot::Robot;

/// Index of a contact of a robot.
pub(super) fn contact_index(robot: &Robot, name: Option<&str>) -> PyResult<usize> {
    index_of_one(name, robot.contacts.iter().map(|contact| contact.name.as_str()), "contact")
}
