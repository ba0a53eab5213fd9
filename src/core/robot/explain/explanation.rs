//! Explanation of a compiled robot: what is computed, what is skipped, and why.

use std::cmp::Reverse;
use std::fmt::{self, Write as _};

use super::cost::{Multiplications, OfActuator, Share};
use super::text::{counted, grouped, listed, percent, significant};
use crate::description::body::Body;
use crate::description::rod::{
    Basis, GivenSection, Parts, Profile, STRAIGHT, STRAIN_NAMES, Section, Segment, Shape, piece, stiffness,
};
use crate::model::Facts;
use crate::robot::choice::{
    COORDINATES_OF_A_CHAIN, COORDINATES_OF_A_ROBOT, Kernel, SEGMENTS_OF_A_CHAIN, Solve,
};
use crate::robot::description::{Driven, Link, Robot};
use crate::robot::effects;
use crate::robot::effects::actuator::Actuator;
use crate::robot::effects::actuator::explain as actuators;
use crate::robot::effects::load::{Extent, Frame, Load};
use crate::robot::effects::loops::Loop;

/// Maximum number of links and actuators listed with their costs, the most expensive ones.
const LISTED_SHARES: usize = 10;

/// An explanation of what is computed for a robot and what is skipped, with reasons.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Explanation {
    /// One line about the whole robot.
    pub summary: String,
    /// What is computed: subjects and remarks.
    pub computed: Vec<(String, String)>,
    /// What is skipped because the robot does not have it: subjects and remarks.
    pub skipped: Vec<(String, String)>,
    /// Costs of evaluations: subjects and remarks.
    pub cost: Vec<(String, String)>,
    /// Costs of links without actuators: subjects and remarks; if there are many, the most expensive ones.
    /// Empty for a single link.
    pub links: Vec<(String, String)>,
    /// Costs of actuators: subjects and remarks.
    pub actuators: Vec<(String, String)>,
    /// Costs of loops: subjects and remarks.
    pub loops: Vec<(String, String)>,
}

impl Explanation {
    /// Explains a valid robot with these facts that is computed by `kernel` and solved by `solve`, with these numbers of nodes
    /// per segment, its cost, and the shares of links, actuators and loops.
    #[allow(clippy::too_many_arguments, reason = "all that is known of it")]
    pub(crate) fn new(
        robot: &Robot,
        facts: &Facts,
        kernel: Kernel,
        solve: Solve,
        nodes: &[usize],
        cost: &Multiplications,
        of_links: &[Share],
        of_actuators: &[OfActuator],
        of_loops: &[Share],
    ) -> Self {
        let what = match robot.is_rod() {
            true => format!("Rod of {}", counted(robot.segments().count(), "segment")),
            false => format!("Robot of {}", counted(robot.links.len(), "link")),
        };
        let summary = format!(
            "{what} with {}, {} kernel",
            counted(robot.coordinates(), "coordinate"),
            match kernel {
                Kernel::Planar => "planar",
                Kernel::Spatial => "spatial",
            }
        );
        let mut explanation = Self {
            summary,
            computed: Vec::new(),
            skipped: Vec::new(),
            cost: costs(cost),
            links: costs_of_links(robot, of_links, cost),
            actuators: costs_of_actuators(robot, of_actuators, cost),
            loops: costs_of_loops(robot, of_loops, cost),
        };
        let length = significant(facts.length);
        explanation.add(
            true,
            "length",
            format!("{length} m, to which accuracies on request and warnings are relative"),
        );
        explanation.kernel(robot, kernel);
        let mut nodes = nodes.iter();
        for link in &robot.links {
            let name = if robot.is_rod() { String::new() } else { format!("{}, ", link.name) };
            if !robot.is_rod() {
                explanation.joint(&name, link);
            }
            for (s, (segment, &nodes)) in link.rod.iter().zip(nodes.by_ref()).enumerate() {
                explanation.segment(&format!("{name}segment {}", s + 1), segment, nodes);
            }
        }
        explanation.loads(robot);
        explanation.fluid(robot);
        let of_effects = actuators::explain(robot, of_actuators).into_iter().chain(effects::explain(robot));
        for (is_computed, what, why) in of_effects {
            explanation.add(is_computed, what, why);
        }
        explanation.solve(solve, robot, of_actuators);
        explanation.steps(facts);
        explanation
    }

    pub(crate) fn add(&mut self, is_computed: bool, what: impl Into<String>, why: impl Into<String>) {
        let list = if is_computed { &mut self.computed } else { &mut self.skipped };
        list.push((what.into(), why.into()));
    }

    /// Explains the joint of a link, and the forces on it.
    fn joint(&mut self, name: &str, link: &Link) {
        let coordinates = link.joint.coordinates();
        let what = if link.rod.is_empty() { "a rigid link" } else { "a rod" };
        let why = match coordinates.len() {
            0 => format!("{what}: no coordinates"),
            _ => format!("{what} with {}", coordinates.join(", ")),
        };
        let why = match &link.driven {
            None => why,
            Some(Driven::Mimic { .. }) => {
                format!("{what} that follows another joint: no coordinates")
            }
            Some(_) => format!("{what} with prescribed motion: no coordinates"),
        };
        self.add(!coordinates.is_empty(), format!("{name}{} joint", link.joint.name()), why);
        let Some(forces) = link.joint.forces() else { return };
        let parts = [
            ("spring", forces.stiffness > 0.0),
            ("viscous damping", forces.damping > 0.0),
            ("dry friction", forces.friction > 0.0),
            ("stops", forces.limits.is_some()),
            ("armature", forces.armature > 0.0),
        ];
        let (present, absent): (Vec<_>, Vec<_>) = parts.into_iter().partition(|(_, is_there)| *is_there);
        for (is_there, parts) in [(true, present), (false, absent)] {
            let parts: Vec<&str> = parts.into_iter().map(|(part, _)| part).collect();
            if !parts.is_empty() {
                self.add(is_there, format!("{name}forces on the joint"), parts.join(", "));
            }
        }
    }

    fn kernel(&mut self, robot: &Robot, kernel: Kernel) {
        match kernel {
            Kernel::Planar => {
                self.add(true, "motion in a plane", "one angular and two linear components");
                self.add(
                    false,
                    "motion in space",
                    match robot.is_rod() {
                        true => "modes and reference strains stay in one plane of the base",
                        false => "links, joints and modes stay in one plane of the first joint",
                    },
                );
            }
            Kernel::Spatial => {
                let at_rest = Robot { base_motion: None, ..robot.clone() };
                let why = match Kernel::plane(&at_rest) {
                    Some(_) => "the motion of the base may leave the plane of the rod",
                    None if robot.is_rod() => "modes or reference strains leave every plane of the base",
                    None => "places, joints or modes of links leave every plane of the first joint",
                };
                self.add(true, "motion in space", why);
            }
        }
    }

    fn segment(&mut self, name: &str, segment: &Segment, nodes: usize) {
        let what = |part: &str| format!("{name}, {part}");
        let (present, absent): (Vec<usize>, Vec<usize>) =
            (0..STRAIN_NAMES.len()).partition(|&strain| segment.modes[strain] > 0);
        let named = |strains: &[usize], name: &dyn Fn(usize) -> String| {
            strains.iter().map(|&strain| name(strain)).collect::<Vec<_>>().join(", ")
        };
        let with_modes = |strain| format!("{} {}", STRAIN_NAMES[strain], segment.modes[strain]);
        let mut strains = named(&present, &with_modes);
        if strains.is_empty() {
            strains.push_str("none: the segment is rigid");
        }
        self.add(true, what("modes"), strains);
        if !absent.is_empty() {
            let names = named(&absent, &|strain| STRAIN_NAMES[strain].to_owned());
            self.add(false, what("strains"), format!("{names}: no modes, fixed at their reference values"));
        }
        let is_extensible = segment.modes[3..].iter().any(|&modes| modes > 0);
        let is_straight =
            |strain: usize| segment.reference_strain.is_entry_constant(strain) == Some(STRAIGHT[strain]);
        if !is_extensible && (3..STRAIGHT.len()).all(is_straight) {
            self.add(false, what("stretch and shear"), "the tangent of the rod is its body axis");
        }
        self.section(&what("section"), &what("coupling of strains"), segment);
        self.basis(&what, segment);
        let is_tapered = !segment.section.is_constant();
        let mut needs = vec!["its modes"];
        if is_tapered {
            needs.push("its taper");
        }
        if segment.reference_strain.degree() > 0 {
            needs.push("its reference strain");
        }
        let reason = match segment.nodes {
            Some(_) => "as given".to_owned(),
            None => format!("for {}", needs.join(" and ")),
        };
        self.add(true, what("quadrature"), format!("{nodes} nodes: {reason}, a multiple of 4"));
        if !segment.basis.is_orthogonal() {
            let condition = stiffness::condition_of_stiffness(segment);
            self.add(
                true,
                what("coupling of modes by stiffness"),
                format!("the basis is not orthogonal: condition number {condition:.0e}"),
            );
        } else if !is_tapered {
            self.add(
                false,
                what("coupling of modes by stiffness"),
                "constant section: the basis is orthogonal",
            );
        }
        if segment.retardation_time > 0.0 {
            let time = segment.retardation_time;
            self.add(true, what("damping"), format!("stiffness times the retardation time, {time} s"));
        } else {
            self.add(false, what("damping"), "the retardation time is zero");
        }
    }

    /// Explains deviations from the default: bases other than Legendre's, and varying reference strains.
    fn basis(&mut self, what: &dyn Fn(&str) -> String, segment: &Segment) {
        let modes = segment.modes.into_iter().max().unwrap_or(0);
        let basis = match segment.basis {
            Basis::Legendre => None,
            Basis::Chebyshev => Some("Chebyshev polynomials".to_owned()),
            Basis::Monomial => Some("powers of X / L".to_owned()),
            Basis::PiecewiseConstant => Some(format!(
                "constant strain on {}, each computed as a separate segment",
                counted(piece::number(segment), "piece")
            )),
            Basis::Hermite => Some(format!("Hermite's cubics between {}", counted(modes / 2, "knot"))),
        };
        if let Some(basis) = basis {
            self.add(true, what("basis"), basis);
        }
        if let Some(varies) = varies(&segment.reference_strain) {
            self.add(true, what("reference strain"), format!("{varies} in X: at no cost once compiled"));
        }
    }

    /// Constant or linearly tapered circles need no remark, because everything else is compared with them.
    fn section(&mut self, what: &str, coupling: &str, segment: &Segment) {
        let profiles: Vec<Option<String>> = match &segment.section {
            Section::Shape(shape) => {
                shape.sizes().into_iter().map(|(name, size)| named(name, size)).collect()
            }
            Section::Given(given) => {
                let GivenSection { stiffness, mass, inertia, centre } = &**given;
                vec![
                    named("stiffness", stiffness),
                    named("mass", mass),
                    named("inertia", inertia),
                    named("centre", centre),
                ]
            }
        };
        let profiles: Vec<String> = profiles.into_iter().flatten().collect();
        let along = match profiles.is_empty() {
            true => String::new(),
            false => format!("; in X {}", profiles.join(", ")),
        };
        match &segment.section {
            Section::Shape(Shape::Circle { .. }) if along.is_empty() => {}
            Section::Shape(shape @ (Shape::Circle { .. } | Shape::HollowCircle { .. })) => {
                self.add(true, what, format!("{}: at the cost of a circle{along}", shape.name()));
            }
            Section::Shape(shape) => {
                let why = "at the cost of a circle in a plane; in space its inertia turns with it";
                self.add(true, what, format!("{}: {why}{along}", shape.name()));
            }
            Section::Given(given) => {
                self.add(true, what, format!("given stiffness and inertia{along}"));
                let pairs: Vec<String> = given
                    .coupled(&segment.modes)
                    .map(|[i, j]| format!("{} with {}", STRAIN_NAMES[i], STRAIN_NAMES[j]))
                    .collect();
                let is_coupled = !pairs.is_empty();
                let none = "the stiffness between the strains that have modes is zero";
                self.add(is_coupled, coupling, if is_coupled { pairs.join(", ") } else { none.to_owned() });
            }
        }
    }

    fn loads(&mut self, robot: &Robot) {
        let is_zero = |v: [f64; 3]| v.iter().all(|&x| x == 0.0);
        if is_zero(robot.gravity) {
            self.add(false, "gravity", "zero");
        } else {
            self.add(true, "gravity", "at no cost: an acceleration of the base");
        }
        self.loads_of(
            robot,
            "dead loads",
            Frame::World,
            "they keep their direction, which the tangent includes",
        );
        self.loads_of(
            robot,
            "follower loads",
            Frame::Body,
            "they turn with the rod, at no cost in the tangent",
        );
        let loads = robot.acting_loads().filter(|load| load.varies_in_time()).count();
        let driven = robot.links.iter().filter_map(|link| link.driven.as_ref());
        let joints = driven.filter(|driven| driven.varies_in_time()).count();
        let is_told = |actuator: &&Actuator| actuator.signals().any(|signal| signal.varies_in_time());
        let actuators = robot.actuators.iter().filter(is_told).count();
        let varying: Vec<String> = [(loads, "load"), (joints, "joint"), (actuators, "actuator")]
            .into_iter()
            .filter(|(number, _)| *number > 0)
            .map(|(number, what)| counted(number, what))
            .collect();
        if varying.is_empty() {
            self.add(false, "functions of time", "none: no load, joint or actuator varies by itself");
        } else {
            let what = varying.join(", ");
            self.add(true, "functions of time", format!("{what}: evaluated once for each time"));
        }
        match &robot.base_motion {
            Some(_) if robot.supports.is_empty() && robot.fluid.is_none() => {
                let what = "velocity and acceleration of its first section, at no cost";
                self.add(true, "motion of the base", what);
            }
            Some(_) => {
                let what = "velocity and acceleration of its first section; supports and fluid evaluated once for each time";
                self.add(true, "motion of the base", what);
            }
            None => self.add(false, "motion of the base", "none: it is fixed"),
        }
        let bodies: Vec<Body> = robot.all_bodies().collect();
        let is_point = |body: &&Body| body.centre == [0.0; 3] && body.inertia == [[0.0; 3]; 3];
        let points = bodies.iter().filter(is_point).count();
        let kinds = kinds([(points, "point"), (bodies.len() - points, "rigid")]);
        let has_bodies = !bodies.is_empty();
        self.add(
            has_bodies,
            if robot.is_rod() { "bodies on the rod" } else { "rigid bodies" },
            if has_bodies { &kinds } else { "none" },
        );
        match robot.supports.len() {
            0 => self.add(false, "supports", "none"),
            number => {
                let supports = counted(number, "place");
                self.add(
                    true,
                    "supports",
                    format!("springs at {supports}: part of elasticity, not of the loads"),
                );
            }
        }
    }

    fn fluid(&mut self, robot: &Robot) {
        let Some(fluid) = &robot.fluid else {
            self.add(false, "fluid", "none");
            return;
        };
        let has_viscous = fluid.viscous_drag != [0.0; 2];
        let has_quadratic = fluid.density > 0.0 && fluid.drag_coefficients != [0.0; 2];
        let drag = match (has_viscous, has_quadratic) {
            (true, true) => "viscous and quadratic",
            (true, false) => "viscous",
            (false, true) => "quadratic",
            (false, false) => "its coefficients are zero",
        };
        self.add(fluid.has_drag(), "drag of the fluid", drag);
        let (mass, none) = ("across the axis of each section", "its coefficient or the density is zero");
        let has_mass = fluid.has_added_mass();
        self.add(has_mass, "added mass of the fluid", if has_mass { mass } else { none });
        let has_buoyancy = fluid.has_buoyancy(robot.gravity);
        let why = if has_buoyancy { "a dead load along the rod" } else { "switched off, or without gravity" };
        self.add(has_buoyancy, "buoyancy", why);
        let bodies = robot.all_bodies().filter(|body| body.hull.is_some()).count();
        if bodies > 0 {
            self.add(true, "fluid around bodies", format!("buoyancy, added mass and drag of {bodies}"));
        }
        let is_moving = fluid.velocity != [0.0; 3];
        self.add(is_moving, "current", if is_moving { "uniform and steady" } else { "the fluid is at rest" });
    }

    fn loads_of(&mut self, robot: &Robot, what: &str, frame: Frame, remark: &str) {
        let loads: Vec<&Load> = robot.acting_loads().filter(|load| load.frame == frame).collect();
        let spread = loads.iter().filter(|load| matches!(load.extent, Extent::Along(_))).count();
        let kinds = kinds([(loads.len() - spread, "concentrated"), (spread, "spread")]);
        if kinds.is_empty() {
            self.add(false, what, "none");
        } else {
            self.add(true, what, format!("{kinds}: {remark}"));
        }
    }

    /// Explains which loop makes fixed steps.
    fn steps(&mut self, facts: &Facts) {
        let what = "fixed steps with arrays of known size";
        let most = Facts::MOST_PLAIN;
        let mut watched: Vec<String> = facts.watched().into_iter().map(str::to_owned).collect();
        if facts.n > most {
            watched.push(format!("more than {most} coordinates"));
        }
        if facts.has_plain_steps() {
            self.add(
                true,
                what,
                format!("up to {most} coordinates, and nothing to look after within a step"),
            );
        } else if !watched.is_empty() {
            self.add(false, what, listed(watched));
        }
    }

    fn solve(&mut self, solve: Solve, robot: &Robot, of_actuators: &[OfActuator]) {
        let coupling = robot.actuators.iter().zip(of_actuators).filter(|(_, of)| of.couples_pieces);
        let coupling: Vec<String> = coupling.map(|(actuator, _)| actuator.name().to_owned()).collect();
        let (parts, limit) = if robot.is_rod() {
            let limit = format!("{SEGMENTS_OF_A_CHAIN} segments and {COORDINATES_OF_A_CHAIN} coordinates");
            ("segments", limit)
        } else {
            ("links", format!("{COORDINATES_OF_A_ROBOT} coordinates"))
        };
        let sweeps = format!("linear systems by sweeps along the {parts}");
        match solve {
            Solve::Tree => {
                self.add(true, sweeps, format!("their cost is linear in the number of {parts}"));
                let why = format!("not formed: more expensive from {limit} on");
                self.add(false, format!("blocks between {parts}"), why);
            }
            Solve::Dense if robot.links.iter().any(|link| link.driven.is_some()) => {
                self.add(false, sweeps, "driven joints couple branches");
            }
            Solve::Dense if !robot.loops.is_empty() => {
                self.add(false, sweeps, "closed loops couple branches");
            }
            Solve::Dense if robot.constraints() > 0 => {
                self.add(false, sweeps, "inextensible tendons are constraints");
            }
            Solve::Dense if !robot.contacts.is_empty() => {
                self.add(false, sweeps, "contact couples the links that touch");
            }
            Solve::Dense if !coupling.is_empty() => {
                self.add(false, sweeps, format!("{} couples the links along its path", listed(coupling)));
            }
            Solve::Dense => self.add(false, sweeps, format!("cheaper from {limit} on")),
        }
    }
}

/// Costs by name.
fn costs(cost: &Multiplications) -> Vec<(String, String)> {
    let Multiplications { residual, tangent, mass_matrix, factorisation, solution } = *cost;
    [
        ("residual", residual),
        ("Jacobian", tangent),
        ("factorisation", factorisation),
        ("solution", solution),
        ("mass matrix", mass_matrix),
    ]
    .map(|(what, number)| (what.to_owned(), format!("{} multiplications", grouped(number))))
    .into()
}

/// Links by name (if there are several), each with its share of the products.
fn costs_of_links(robot: &Robot, of_links: &[Share], all: &Multiplications) -> Vec<(String, String)> {
    if of_links.len() < 2 {
        return Vec::new();
    }
    // Driven coordinates are computed, but are not coordinates of the robot.
    let own = |(link, share): (&Link, &Share)| {
        (link.name.clone(), Share { coordinates: link.coordinates(), ..*share })
    };
    shares(robot.links.iter().zip(of_links).map(own).collect(), "link", all)
}

/// Actuators by name, each with its share of the products.
fn costs_of_actuators(
    robot: &Robot,
    of_actuators: &[OfActuator],
    all: &Multiplications,
) -> Vec<(String, String)> {
    let own = |(actuator, of): (&Actuator, &OfActuator)| (actuator.name().to_owned(), of.share);
    shares(robot.actuators.iter().zip(of_actuators).map(own).collect(), "actuator", all)
}

/// Loops by name, each with its share of the products; solving with their constraints is part of the total.
fn costs_of_loops(robot: &Robot, of_loops: &[Share], all: &Multiplications) -> Vec<(String, String)> {
    let own = |(closed, share): (&Loop, &Share)| (closed.name.clone(), *share);
    shares(robot.loops.iter().zip(of_loops).map(own).collect(), "loop", all)
}

/// Shares in words; if there are many, the most expensive ones, and the sum of the others.
fn shares(mut lines: Vec<(String, Share)>, what: &str, all: &Multiplications) -> Vec<(String, String)> {
    if lines.len() > LISTED_SHARES {
        // A stable sort, so that equal shares keep their order.
        lines.sort_by_key(|(_, share)| Reverse(share.residual + share.tangent));
        let rest = lines.split_off(LISTED_SHARES);
        let sum = |of: fn(&Share) -> u64| rest.iter().map(|(_, share)| of(share)).sum();
        let together = Share {
            nodes: rest.iter().map(|(_, share)| share.nodes).sum(),
            coordinates: rest.iter().map(|(_, share)| share.coordinates).sum(),
            residual: sum(|share| share.residual),
            tangent: sum(|share| share.tangent),
        };
        lines.push((counted(rest.len(), &format!("other {what}")), together));
    }
    let line = |(name, share): (String, Share)| {
        let Share { nodes, coordinates, residual, tangent } = share;
        let [residual, tangent] = [percent(residual, all.residual), percent(tangent, all.tangent)];
        let nodes = if nodes == 0 { String::new() } else { format!(", {}", counted(nodes, "node")) };
        let size = format!("{}{nodes}", counted(coordinates, "coordinate"));
        (name, format!("{residual} of the residual, {tangent} of the Jacobian: {size}"))
    };
    lines.into_iter().map(line).collect()
}

/// Non-zero numbers of several kinds: `2 concentrated, 1 spread`.
fn kinds(kinds: [(usize, &str); 2]) -> String {
    let present = kinds.iter().filter(|(number, _)| *number > 0);
    present.map(|(number, kind)| format!("{number} {kind}")).collect::<Vec<_>>().join(", ")
}

impl fmt::Display for Explanation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.summary)?;
        let lists = [
            ("computed", &self.computed),
            ("skipped", &self.skipped),
            ("cost", &self.cost),
            ("cost of links", &self.links),
            ("cost of actuators", &self.actuators),
            ("cost of loops", &self.loops),
        ];
        let width = lists.iter().flat_map(|(_, list)| *list).map(|(what, _)| what.len()).max().unwrap_or(0);
        for (title, list) in lists.into_iter().filter(|(_, list)| !list.is_empty()) {
            write!(f, "\n  {title}")?;
            for (what, why) in list {
                write!(f, "\n    {what:<width$}  {why}")?;
            }
        }
        f.write_char('\n')
    }
}

/// Describes a profile that is neither constant nor linear.
fn varies<const N: usize>(profile: &Profile<N>) -> Option<String> {
    match profile.parts() {
        Parts::Constant(_) | Parts::Linear(_) => None,
        Parts::Table(stations, _) => Some(format!("a table of {} stations", stations.len())),
        Parts::Polynomial(coefficients) => Some(format!("a polynomial of degree {}", coefficients.len() - 1)),
    }
}

fn named<const N: usize>(name: &str, profile: &Profile<N>) -> Option<String> {
    varies(profile).map(|varies| format!("{name} {varies}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::joint::Joint;
    use crate::description::rod::diagonal;
    use crate::robot::RobotModel;
    use crate::robot::description::Rod;

    /// Why the subject is in a list.
    fn find(list: &[(String, String)], subject: &str) -> Option<String> {
        list.iter().find(|(what, _)| what == subject).map(|(_, why)| why.clone())
    }

    #[test]
    fn what_a_rod_lacks_is_skipped_and_what_it_has_is_computed() {
        let plain =
            Segment { modes: [0, 3, 0, 0, 0, 0], ..Segment::straight(1.0, 1e-3, 210e9, 80e9, 7800.0) };
        let rich = Segment {
            modes: [1; 6],
            section: Section::circle([2e-3, 1e-3]),
            retardation_time: 0.1,
            nodes: Some(9),
            ..plain.clone()
        };
        let has = |list: &[(String, String)], text: &str| list.iter().any(|(what, _)| what == text);
        let explain = |rod: &Rod| RobotModel::of_rod(rod).unwrap().explanation();

        let simple = explain(&Rod::new(vec![plain]));
        assert_eq!(simple.summary, "Rod of 1 segment with 3 coordinates, planar kernel");
        for skipped in [
            "motion in space",
            "segment 1, damping",
            "segment 1, strains",
            "dead loads",
            "follower loads",
            "bodies on the rod",
            "supports",
            "fluid",
        ] {
            assert!(has(&simple.skipped, skipped) && !has(&simple.computed, skipped), "{skipped}");
        }
        assert!(simple.to_string().contains("12 nodes: for its modes"));
        assert!(has(&simple.cost, "residual") && simple.to_string().contains("8 multiplications"));

        let loaded =
            Rod { tip_force: [1.0, 0.0, 0.0], tip_mass: 0.1, gravity: [0.0; 3], ..Rod::new(vec![rich]) };
        let full = explain(&loaded);
        for computed in ["motion in space", "segment 1, damping", "dead loads", "bodies on the rod"] {
            assert!(has(&full.computed, computed) && !has(&full.skipped, computed), "{computed}");
        }
        let skipped: Vec<&str> = full.skipped.iter().map(|(what, _)| what.as_str()).collect();
        let absent = [
            "gravity",
            "follower loads",
            "functions of time",
            "motion of the base",
            "supports",
            "fluid",
            "actuators",
            "contact",
            "linear systems by sweeps along the segments",
            "fixed steps with arrays of known size",
        ];
        assert_eq!(skipped, absent);
        assert!(full.to_string().contains("12 nodes: as given"));
    }

    #[test]
    fn the_basis_and_its_conditioning_are_explained() {
        let said = |basis, modes| {
            let modes = [0, modes, 0, 0, 0, 0];
            let segment = Segment { modes, basis, ..Segment::straight(1.0, 1e-3, 210e9, 80e9, 7800.0) };
            RobotModel::of_rod(&Rod::new(vec![segment])).unwrap().explanation().to_string()
        };
        assert!(!said(Basis::Legendre, 4).contains("segment 1, basis"));
        assert!(said(Basis::Chebyshev, 4).contains("Chebyshev polynomials"));
        // Hilbert's matrix of four rows (Todd 1954: 1.6e4).
        assert!(said(Basis::Monomial, 4).contains("powers of X / L"));
        assert!(said(Basis::Monomial, 4).contains("not orthogonal: condition number 2e4"));
        assert!(said(Basis::Hermite, 6).contains("Hermite's cubics between 3 knots"));
        let pieces = said(Basis::PiecewiseConstant, 3);
        assert!(pieces.contains("constant strain on 3 pieces, each computed as a separate segment"));
        assert!(pieces.contains("36 nodes: for its modes") && pieces.contains("the basis is orthogonal"));
    }

    #[test]
    fn sections_that_are_no_circles_are_named() {
        let given = |stiffness: [[f64; 6]; 6]| GivenSection {
            stiffness: stiffness.into(),
            mass: 1.0.into(),
            inertia: [0.0; 9].into(),
            centre: [0.0; 2].into(),
        };
        let explain = |segment: Segment| {
            let segment = Segment { modes: [1, 1, 0, 0, 0, 0], ..segment };
            RobotModel::of_rod(&Rod::new(vec![segment])).unwrap().explanation()
        };
        let coupling = "segment 1, coupling of strains";
        assert!(find(&explain(Segment::given(1.0, given(diagonal([1.0; 6])))).skipped, coupling).is_some());
        let mut stiffness = diagonal([1.0; 6]);
        for (i, j) in [(0, 1), (0, 5)] {
            (stiffness[i][j], stiffness[j][i]) = (0.1, 0.1);
        }
        let coupled = explain(Segment::given(1.0, given(stiffness)));
        assert_eq!(find(&coupled.computed, coupling).as_deref(), Some("torsion with bend_y"));
        let rectangle = Section::Shape(Shape::Rectangle { width: 0.1.into(), height: 0.2.into() });
        let named = explain(Segment { section: rectangle, ..Segment::straight(1.0, 0.1, 1e6, 4e5, 1e3) });
        assert!(find(&named.computed, "segment 1, section").unwrap().starts_with("rectangle"));
        let radius = Profile::table(&[0.0, 0.5, 1.0], &[[0.1], [0.2], [0.1]]).unwrap();
        let bulb = Section::Shape(Shape::Circle { radius });
        let varies = explain(Segment { section: bulb, ..Segment::straight(1.0, 0.1, 1e6, 4e5, 1e3) });
        let why = "circle: at the cost of a circle; in X radius a table of 3 stations";
        assert_eq!(find(&varies.computed, "segment 1, section").as_deref(), Some(why));
    }

    #[test]
    fn what_keeps_fixed_steps_from_the_short_loop_is_said() {
        let explain = |modes: [usize; 6], joint: Joint| {
            let rod = Rod::new(vec![Segment { modes, ..Segment::straight(1.0, 1e-3, 210e9, 80e9, 7800.0) }]);
            let robot = Robot::from(&rod);
            let root = Link { joint, ..robot.links[0].clone() };
            RobotModel::new(&Robot { links: vec![root], ..robot }).unwrap().explanation()
        };
        let what = "fixed steps with arrays of known size";
        let bend = |modes| [0, modes, 0, 0, 0, 0];
        assert!(find(&explain(bend(4), Joint::Weld).computed, what).is_some());
        let many = find(&explain(bend(5), Joint::Weld).skipped, what);
        assert_eq!(many.as_deref(), Some("more than 4 coordinates"));
        let free = find(&explain(bend(0), Joint::Free).skipped, what);
        assert_eq!(free.as_deref(), Some("rotation vectors and more than 4 coordinates"));
    }

    #[test]
    fn long_chains_are_solved_by_sweeps() {
        let segment =
            Segment { modes: [0, 2, 0, 0, 0, 0], ..Segment::straight(0.1, 1e-3, 210e9, 80e9, 7800.0) };
        let explain = |segments: usize, modes| {
            let segment = Segment { modes: [0, modes, 0, 0, 0, 0], ..segment.clone() };
            RobotModel::of_rod(&Rod::new(vec![segment; segments])).unwrap().explanation()
        };
        let sweeps = "linear systems by sweeps along the segments";
        for (segments, modes) in [(1, 40), (2, 20), (9, 2)] {
            let explanation = explain(segments, modes);
            assert!(explanation.skipped.iter().any(|(what, _)| what == sweeps), "{segments} {modes}");
            assert!(explanation.to_string().contains("cheaper from 3 segments and 20 coordinates on"));
        }
        for (segments, modes) in [(3, 7), (10, 2), (20, 1)] {
            let explanation = explain(segments, modes);
            assert!(explanation.computed.iter().any(|(what, _)| what == sweeps), "{segments} {modes}");
        }
    }

    #[test]
    fn the_dearest_of_many_links_come_first_and_the_rest_together() {
        let rods = |modes: &[usize]| {
            let segment = Segment::straight(0.1, 1e-3, 210e9, 80e9, 7800.0);
            let link = |(i, &modes): (usize, &usize)| Link {
                rod: vec![Segment { modes: [0, modes, 1, 0, 0, 0], ..segment.clone() }],
                ..Link::new(format!("arm{i}"))
            };
            let robot = Robot::new(modes.iter().enumerate().map(link).collect());
            RobotModel::new(&robot).unwrap().explanation()
        };
        assert!(rods(&[2]).links.is_empty() && !rods(&[2]).to_string().contains("cost of links"));
        let names =
            |links: &[(String, String)]| links.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
        let few = rods(&[2, 9, 2, 2]);
        assert_eq!(names(&few.links), ["arm0", "arm1", "arm2", "arm3"]);
        assert_eq!(few.links[2].1, few.links[3].1);
        assert!(few.links[1].1.ends_with("Jacobian: 10 coordinates, 20 nodes"), "{}", few.links[1].1);

        let many = rods(&[1, 2, 1, 2, 2, 2, 2, 9, 2, 2, 2, 2, 5]);
        let order = ["arm7", "arm12", "arm1", "arm3", "arm4", "arm5", "arm6", "arm8", "arm9", "arm10"];
        assert_eq!(names(&many.links[..10]), order);
        assert_eq!(names(&many.links[10..]), ["3 other links"]);
        let percents =
            many.links.iter().map(|(_, why)| why.split(" %").next().unwrap().trim().parse::<f64>());
        assert!((percents.map(Result::unwrap).sum::<f64>() - 100.0).abs() < 1.0);
        assert!(many.to_string().contains("\n  cost of links\n    arm7 "));
    }
}
