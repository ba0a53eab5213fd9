//! Explanations of contacts.

use crate::robot::description::Robot;
use crate::robot::effects::contact::compile::{of_material, stiffnesses};
use crate::robot::effects::contact::obstacles::Shape;
use crate::robot::effects::contact::{Contact, Stiffness, Surface};
use crate::robot::explain::text::{Explained, counted};

/// Explains what is computed for the contacts of a robot.
pub(crate) fn explain(robot: &Robot) -> Vec<Explained> {
    if robot.contacts.is_empty() {
        return vec![(false, "contact".to_owned(), "none".to_owned())];
    }
    let line = |(contact, stiffness): (&Contact, f64)| {
        (true, format!("contact {}", contact.name), pair(robot, contact, stiffness))
    };
    let mut lines: Vec<_> = robot.contacts.iter().zip(stiffnesses(robot)).map(line).collect();
    let pairs = counted(robot.contacts.len(), "pair");
    let why = format!("{pairs}, in every step; Newmark's method is generalised alpha with rho_inf = 0.8");
    lines.push((true, "contact".to_owned(), why));
    lines
}

/// Describes a pair of surfaces with its stiffness and friction.
fn pair(robot: &Robot, contact: &Contact, stiffness: f64) -> String {
    let [a, b] = &contact.surfaces;
    let between = match (a, b) {
        (Surface::Rod { link: a }, Surface::Rod { link: b }) if a == b => {
            format!("the rod of {} and itself", robot.links[*a].name)
        }
        _ => format!("{} and {}", surface(robot, a), surface(robot, b)),
    };
    let is_material = || stiffness >= of_material(contact, robot);
    let unit = match (contact.is_spread(), contact.stiffness) {
        (false, _) => "N/m",
        (true, Some(Stiffness::Given(_))) => "N/m^2",
        (true, None) if !is_material() => "N/m^2 for its loads",
        (true, _) => "N/m^2 of the material",
    };
    let friction = match contact.largest_friction() {
        [most, ..] if contact.friction_along.is_some() => format!("friction of up to {most} along the rod"),
        [0.0, 0.0, 0.0] => "no friction".to_owned(),
        [forward, backward, sideways] if forward == backward && forward == sideways => {
            format!("friction {forward}")
        }
        [forward, backward, sideways] => {
            format!("friction {forward} forward, {backward} backward, {sideways} sideways")
        }
    };
    let friction = match contact.static_friction {
        Some(at_rest) => format!("{friction}, {at_rest} at rest"),
        None => friction,
    };
    let spinning = match contact.patch_radius {
        0.0 => String::new(),
        radius => format!(", against spinning over a patch of {radius} m"),
    };
    format!("{between}: {stiffness:.3e} {unit}, {friction}{spinning}")
}

fn surface(robot: &Robot, surface: &Surface) -> String {
    match surface {
        Surface::Rod { link } => format!("the rod of {}", robot.links[*link].name),
        Surface::Ball { link, radius, .. } => format!("a ball of {radius} m on {}", robot.links[*link].name),
        Surface::Solid { link, shape, .. } => {
            format!("{} on {}", of_shape(shape.shape()), robot.links[*link].name)
        }
        Surface::Obstacle(shape) => of_shape(shape.shape()),
    }
}

fn of_shape(shape: &dyn Shape) -> String {
    match shape.rounding() {
        Some(rounding) => format!("{} (edges rounded by up to {rounding:.1e} m)", shape.label()),
        None => shape.label(),
    }
}

#[cfg(test)]
mod tests {
    use crate::description::rod::Segment;
    use crate::robot::description::{Link, Robot};
    use crate::robot::effects::contact::{Contact, HalfSpace, Surface};
    use crate::robot::model::RobotModel;

    #[test]
    fn contacts_are_explained_with_their_forces() {
        let segment = Segment { modes: [0, 2, 0, 0, 0, 0], ..Segment::straight(0.5, 0.01, 1e6, 4e5, 1000.0) };
        let rod = Link { rod: vec![segment], ..Link::new("rod") };
        let floor = Surface::Obstacle(HalfSpace { point: [0.0, 0.0, -1.0], normal: [0.0, 0.0, 1.0] }.into());
        let contact = Contact {
            friction: [0.5, 0.6, 0.7],
            ..Contact::between("floor", [Surface::Rod { link: 0 }, floor])
        };
        let robot = Robot { contacts: vec![contact], ..Robot::new(vec![rod]) };
        let explained = |robot: &Robot| RobotModel::new(robot).unwrap().full_explanation().to_string();
        let touching = explained(&robot);
        // pi/4 E / (1 - nu^2) with nu = 0.25
        for wanted in [
            "contact floor",
            "the rod of rod and a half space: 8.378e5 N/m^2 of the material, friction 0.5 forward",
        ] {
            assert!(touching.contains(wanted), "{wanted}: {touching}");
        }
        assert!(!explained(&Robot { contacts: Vec::new(), ..robot }).contains("half space"));
    }
}
