//! Explanations of magnets.

use super::is_magnetised;
use crate::robot::description::Robot;
use crate::robot::explain::text::{Explained, counted};

/// Explains what is computed for magnets and magnetised segments of a robot, if there are any.
pub(crate) fn explain(robot: &Robot) -> Vec<Explained> {
    let segments = robot.segments().filter(|segment| is_magnetised(segment)).count();
    let mut explained = Vec::new();
    if robot.magnets.is_empty() && segments == 0 {
        return explained;
    }
    let parts = [(robot.magnets.len(), "magnet"), (segments, "magnetised segment")];
    let named =
        parts.into_iter().filter(|(number, _)| *number > 0).map(|(number, name)| counted(number, name));
    let what = named.collect::<Vec<_>>().join(" and ");
    let has_field = !robot.field.is_zero();
    let why = match robot.field.constant() {
        _ if !has_field => "none".to_owned(),
        Some(_) => format!("turns {what}; has a potential"),
        None => format!("turns {what}; supplies energy as it varies"),
    };
    explained.push((has_field, "uniform magnetic field".into(), why));
    let others = robot.magnets.iter().any(|magnet| {
        let is_other = |link: usize| link != magnet.link;
        let has_magnetised =
            |(i, link): (usize, &crate::robot::Link)| is_other(i) && link.rod.iter().any(is_magnetised);
        robot.links.iter().enumerate().any(has_magnetised)
    });
    let feel = robot.magnets.len() > 1 || others;
    let why = if feel { "of dipoles, pair by pair" } else { "nothing else is magnetised" };
    explained.push((feel, "forces between magnets".into(), why.into()));
    explained
}
