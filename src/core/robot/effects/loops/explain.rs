//! Explanations of closed loops.

use crate::robot::description::Robot;
use crate::robot::effects::actuator::Actuator;
use crate::robot::effects::loops::{Loop, Tie};
use crate::robot::explain::text::{Explained, counted, listed};

/// Explains what is computed for the loops of a robot.
pub(crate) fn explain(robot: &Robot) -> Vec<Explained> {
    let mut explained = Vec::new();
    if robot.is_rod() && robot.constraints() == 0 {
        return explained;
    }
    let mut add = |is_computed, what: String, why| explained.push((is_computed, what, why));
    if robot.loops.is_empty() {
        add(false, "closed loops".into(), "none".into());
    }
    if robot.constraints() == 0 {
        return explained;
    }
    let names = robot.coordinate_names();
    for closed in &robot.loops {
        let rows = counted(closed.tie.rows(), "constraint");
        add(true, format!("loop {}", closed.name), format!("{rows}: {}", kind(robot, closed, &names)));
    }
    let rows = robot.constraints();
    let n = robot.coordinates();
    let why = format!(
        "{} held by multipliers: {} of a step, exact at its end",
        counted(rows, "constraint"),
        counted(n + rows, "unknown"),
    );
    add(true, if robot.loops.is_empty() { "constraints" } else { "closed loops" }.into(), why);
    explained
}

/// Describes the constraint of a loop.
fn kind(robot: &Robot, closed: &Loop, names: &[String]) -> String {
    let ends = || {
        let ends = closed.tie.ends().into_iter().flatten();
        let name = |link: Option<usize>| link.map_or("the world", |link| robot.links[link].name.as_str());
        ends.map(|end| name(end.link)).collect::<Vec<_>>().join(" to ")
    };
    match &closed.tie {
        Tie::Joint { joint, .. } => format!("{} joint, {}", joint.name(), ends()),
        Tie::Distance { length, .. } => format!("a distance of {length} m, {}", ends()),
        Tie::Coordinates { coordinates: [first, second], ratio, offset } => {
            let offset = match *offset {
                0.0 => String::new(),
                offset if offset < 0.0 => format!(" - {}", -offset),
                offset => format!(" + {offset}"),
            };
            format!("gear, {} = {ratio} {}{offset}", names[*first], names[*second])
        }
    }
}

/// Which constraints are redundant at zero coordinates, loop by loop.
pub(crate) fn explain_redundant(robot: &Robot, redundant: &[usize]) -> Explained {
    let of_loops = robot.loops.iter().map(|closed| closed.name.as_str());
    let names = of_loops.chain(robot.inextensible_tendons().map(Actuator::name));
    let named = names.zip(redundant).filter(|(_, number)| **number > 0);
    let named: Vec<String> = named.map(|(name, number)| format!("{number} of {name}")).collect();
    let (is_there, why) = match named.is_empty() {
        true => (false, "none where all coordinates are zero".to_owned()),
        false => {
            let why = "where all coordinates are zero; implied by the others, without multipliers";
            (true, format!("{}, {why}", listed(named)))
        }
    };
    (is_there, "redundant constraints".into(), why)
}

#[cfg(test)]
mod tests {
    use crate::description::body::Body;
    use crate::description::joint::Joint;
    use crate::robot::description::{Link, Robot};
    use crate::robot::effects::loops::{Loop, LoopEnd, Tie};
    use crate::robot::model::RobotModel;

    fn hinge() -> Joint {
        Joint::Revolute { axis: [0.0, 1.0, 0.0], forces: Default::default() }
    }

    /// Two bars in a plane, with the end hinged to a point of the world at this distance.
    fn bars(reach: f64) -> Robot {
        let inertia = [[1e-5, 0.0, 0.0], [0.0, 4e-4, 0.0], [0.0, 0.0, 4e-4]];
        let body = Body { centre: [0.1, 0.0, 0.0], inertia, ..Body::point(0.1) };
        let bar = |name: &str| Link { joint: hinge(), body: Some(body.clone()), ..Link::new(name) };
        let links = vec![bar("a"), Link { parent: Some(0), position: [0.2, 0.0, 0.0], ..bar("b") }];
        let end = LoopEnd { position: [0.2, 0.0, 0.0], ..LoopEnd::on(1) };
        let tie = Tie::Joint { ends: [end, LoopEnd::in_world([reach, 0.0, 0.0])], joint: hinge() };
        let loops = vec![Loop { name: "pin".into(), tie }];
        Robot { loops, ..Robot::new(links) }
    }

    #[test]
    fn loops_are_explained_with_redundant_constraints() {
        let explained = |robot: &Robot| RobotModel::new(robot).unwrap().full_explanation().to_string();
        let closed = explained(&bars(0.4));
        for wanted in [
            "loop pin                                  5 constraints: revolute joint, b to the world",
            "5 constraints held by multipliers: 7 unknowns of a step",
            "4 of pin, where all coordinates are zero",
            "closed loops couple branches",
        ] {
            assert!(closed.contains(wanted), "{wanted}: {closed}");
        }
        assert!(!explained(&bars(0.3)).contains("redundant"));
        let open = explained(&Robot { loops: Vec::new(), ..bars(0.3) });
        assert!(!open.contains("loop pin") && open.contains("closed loops"));
    }

    #[test]
    fn constraints_are_part_of_linear_systems() {
        let costs = |robot: &Robot| RobotModel::new(robot).unwrap().multiplications();
        let (closed, open) = (costs(&bars(0.4)), costs(&Robot { loops: Vec::new(), ..bars(0.4) }));
        assert_eq!([open.solution, closed.solution], [4, 49]);
        assert!(closed.factorisation > open.factorisation && closed.tangent > open.tangent);
        assert_eq!(closed.mass_matrix, open.mass_matrix);
    }
}
