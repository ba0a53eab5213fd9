//! Stiffness of contacts: the given one, that of the material, or no more than the loads need.
//!
//! The material of steel wire is stiffer than any load on it asks for, by factors of thousands, and each such factor costs Newton
//! iterations. By default the surfaces are therefore as stiff as the material, but no stiffer than needed for small overlaps under
//! what the robot can press with: its weight, its loads, and the force that bends its rods. Where more presses, of which nothing is
//! known before a run, they are as stiff as the material.

use std::f64::consts::{FRAC_PI_4, SQRT_2};

use crate::description::joint::Joint;
use crate::description::rod::{SectionProperties, Segment};
use crate::description::signal::Signal;
use crate::error::{Checker, InvalidInput};
use crate::robot::description::{Driven, Link, Robot};
use crate::robot::effects::actuator::{Actuator, Drive, MotorCommand};
use crate::robot::effects::contact::obstacles::Shape;
use crate::robot::effects::contact::plan::{NODES, WEIGHTS};
use crate::robot::effects::contact::{Contact, Stiffness, Surface};
use crate::robot::effects::load::Extent;

/// Overlap at an edge over the radius, under the whole load: deeper ones change the force by the shape of the section.
pub(crate) const OVERLAP: f64 = 0.15;

/// The same over the length of the rod, so that its shape is right to a thousandth of its length.
const OF_LENGTH: f64 = 5e-4;

/// At the overlap d a straight rod of radius r overlaps a sharp edge across it along `2 sqrt(2 r d)`, and the force of the
/// parabola of overlaps is `4/3 sqrt(2) k d^(3/2) r^(1/2)`.
const OF_PARABOLA: f64 = 4.0 / 3.0 * SQRT_2;

/// `F L^2 / (E I)` of a force F that turns the tip of a clamped rod by about 75 degrees (Bisshopp and Drucker 1945, figure 2).
const BENDING: f64 = 7.0;

/// Weights count twice, because what is let go presses twice as much as at rest. What free joints let fall counts four times: from
/// twice the length of a slender rod it overlaps by a third of the radius, by `d = sqrt(2 F h / (k L))` of a fall by h.
const LET_GO: f64 = 2.0;
const FALLING: f64 = 4.0;

/// Sections are looked at in this many parts of a segment along which they vary.
pub(super) const PARTS: usize = 8;

/// The stiffness of every contact of a robot.
pub(crate) fn stiffnesses(robot: &Robot) -> Vec<f64> {
    let is_open = |contact: &Contact| contact.stiffness.is_none();
    let known = robot.contacts.iter().any(is_open).then(|| Known::new(robot));
    let stiffness = |contact: &Contact| match (contact.stiffness, &known) {
        (Some(Stiffness::Given(stiffness)), _) => stiffness,
        (None, Some(known)) if known.is_complete(contact) => {
            of_material(contact, robot).min(known.of_loads(contact))
        }
        _ => of_material(contact, robot),
    };
    robot.contacts.iter().map(stiffness).collect()
}

/// What would be the default of a contact if nothing else pressed than what is known.
pub(crate) fn needed_stiffness(robot: &Robot, contact: &Contact) -> f64 {
    of_material(contact, robot).min(Known::new(robot).of_loads(contact))
}

/// Rejects contacts of rods without a material, if nothing else tells how stiff they are.
pub(super) fn check_stiffness(robot: &Robot) -> Result<(), InvalidInput> {
    let mut check = Checker::new();
    for (i, (contact, stiffness)) in robot.contacts.iter().zip(stiffnesses(robot)).enumerate() {
        let found = if contact.stiffness.is_none() { "none" } else { "\"material\"" };
        let expected = "a number in N/m^2: sections of given stiffness have no material";
        check.require(stiffness.is_finite(), &format!("contacts[{i}].stiffness"), found, expected);
    }
    check.finish()
}

/// A cylinder pressed into a half-space has `pi / 4 E*` per metre and overlap, with `E* = E / (1 - nu^2)` (Popov 2010, eq. 5.33);
/// two cylinders act in series. Infinite if no rod has a material.
pub(crate) fn of_material(contact: &Contact, robot: &Robot) -> f64 {
    let of_segment = |segment: &Segment| {
        let nu = segment.poisson_ratio();
        (1.0 - nu * nu) / segment.young_modulus
    };
    let of_rod = |link: usize| {
        let compliances = robot.links[link].rod.iter().filter(|segment| segment.young_modulus > 0.0);
        compliances.map(of_segment).fold(0.0, f64::max)
    };
    FRAC_PI_4 / rods(contact).map(of_rod).sum::<f64>()
}

fn rods(contact: &Contact) -> impl Iterator<Item = usize> {
    let rod = |surface: &Surface| if let Surface::Rod { link } = surface { Some(*link) } else { None };
    contact.surfaces.iter().filter_map(rod)
}

/// What is known of a robot before it moves.
struct Known {
    rods: Vec<Rod>,
    /// The first link of all that hang together, through joints, loops, tendons and contacts.
    roots: Vec<usize>,
    /// Of each such link, what acts on all of them.
    pressing: Vec<Pressing>,
}

/// A rod with those to which it is welded, end to end.
#[derive(Clone, Copy, Debug, Default)]
struct Rod {
    length: f64,
    /// Integral of 1 / (E I) over that length, I about the axis about which it is stiffer.
    compliance: f64,
    /// Smallest half extent of the own sections.
    radius: f64,
}

/// Magnitudes that press, added up.
#[derive(Clone, Copy, Debug, Default)]
struct Pressing {
    /// Newtons.
    weight: f64,
    /// Whether a free joint lets all of it fall.
    falls: bool,
    /// Newtons, besides the weight.
    force: f64,
    /// Newton metres.
    moment: f64,
    /// Whether something presses with a force of which nothing is known before a run.
    is_unknown: bool,
}

impl Pressing {
    fn add(&mut self, force: Option<f64>, moment: Option<f64>) {
        self.is_unknown |= force.is_none() || moment.is_none();
        self.force += force.unwrap_or(0.0);
        self.moment += moment.unwrap_or(0.0);
    }

    fn force(&self) -> f64 {
        self.weight * if self.falls { FALLING } else { LET_GO } + self.force
    }
}

impl Known {
    fn new(robot: &Robot) -> Self {
        let (sections, masses): (Vec<_>, Vec<_>) = robot.links.iter().map(rod).unzip();
        let roots = roots(robot);
        let mut pressing = vec![Pressing::default(); robot.links.len()];
        let gravity = norm(robot.gravity);
        for (i, (link, mass)) in robot.links.iter().zip(masses).enumerate() {
            let pressing = &mut pressing[roots[i]];
            pressing.weight += mass * gravity;
            pressing.falls |= link.joint == Joint::Free && link.driven.is_none();
            // Without gravity, only whoever sets things in motion knows how fast they meet.
            let is_thrown = gravity == 0.0 && !link.joint_coordinates().is_empty();
            let is_moved = match &link.driven {
                Some(Driven::Coordinate(motion)) => motion.constant().is_none(),
                Some(Driven::Base(_)) => true,
                Some(Driven::Mimic { .. }) | None => false,
            };
            // Springs that are stretched far, magnets and currents press as hard as the shape makes them.
            let is_sprung = link.joint.forces().is_some_and(|forces| forces.stiffness > 0.0);
            let is_drawn = robot.has_magnets()
                || robot.fluid.as_ref().is_some_and(|fluid| fluid.velocity.iter().any(|v| *v != 0.0));
            pressing.is_unknown |=
                is_thrown || is_moved || is_sprung || is_drawn || robot.base_motion.is_some();
        }
        for support in &robot.supports {
            pressing[roots[support.link]].is_unknown = true;
        }
        for body in robot.all_bodies() {
            pressing[roots[body.link]].weight += body.mass * gravity;
        }
        for load in robot.acting_loads() {
            let along = if let Extent::Along([from, to]) = load.extent { to - from } else { 1.0 };
            let [force, moment] = [&load.force, &load.moment].map(|signal| Some(along * largest(signal)?));
            pressing[roots[load.link]].add(force, moment);
        }
        for actuator in &robot.actuators {
            if let (Some(link), [force, moment]) = of_actuator(actuator, robot) {
                pressing[roots[link]].add(force, moment);
            }
        }
        Self { rods: in_rows(robot, sections), roots, pressing }
    }

    /// Whether all is known that presses on the surfaces of a contact.
    fn is_complete(&self, contact: &Contact) -> bool {
        contact
            .surfaces
            .iter()
            .filter_map(Surface::link)
            .all(|link| !self.pressing[self.roots[link]].is_unknown)
    }

    /// The stiffness at which the overlap is small although all that presses does so at one edge; infinite if nothing does.
    fn of_loads(&self, contact: &Contact) -> f64 {
        let rods = || rods(contact).map(|link| self.rods[link]);
        let shapes = contact.surfaces.iter().map(|surface| match surface {
            Surface::Ball { radius, .. } => *radius,
            surface => surface.shape().map_or(f64::INFINITY, Shape::thickness),
        });
        let radius = rods().map(|rod| rod.radius).fold(f64::INFINITY, f64::min);
        let thickness = shapes.fold(radius, f64::min);
        let length = rods().map(|rod| rod.length).fold(f64::INFINITY, f64::min);
        let overlap = (OVERLAP * thickness).min(OF_LENGTH * length);
        let links = contact.surfaces.iter().filter_map(Surface::link);
        let largest = |pressed: fn(&Pressing) -> f64| {
            links.clone().map(|link| pressed(&self.pressing[self.roots[link]])).fold(0.0, f64::max)
        };
        let bending = rods().map(|rod| BENDING / (rod.length * rod.compliance)).fold(0.0, f64::max);
        let force = largest(Pressing::force) + largest(|all| all.moment) / length + bending;
        let stiffness = force / (OF_PARABOLA * overlap.powf(1.5) * radius.sqrt());
        if stiffness > 0.0 { stiffness } else { f64::INFINITY }
    }
}

/// The rod of a link by itself, and its mass.
fn rod(link: &Link) -> (Rod, f64) {
    let mut rod = Rod { radius: f64::INFINITY, ..Rod::default() };
    let mut mass = 0.0;
    for segment in &link.rod {
        let parts = if segment.section.is_constant() { 1 } else { PARTS };
        for part in 0..parts {
            for (node, weight) in NODES.into_iter().zip(WEIGHTS) {
                let x = (part as f64 + node) / parts as f64;
                let length = weight * segment.length / parts as f64;
                let SectionProperties { stiffness, mass: per_length, .. } = SectionProperties::at(segment, x);
                mass += per_length * length;
                rod.compliance += length / stiffness[1][1].max(stiffness[2][2]);
                rod.radius = thin(segment, x).min(rod.radius);
            }
        }
        rod.radius = thin(segment, 0.0).min(thin(segment, 1.0)).min(rod.radius);
        rod.length += segment.length;
    }
    (rod, mass)
}

fn thin(segment: &Segment, x: f64) -> f64 {
    let [y, z] = segment.section.half_extents(x);
    y.min(z)
}

/// Rods as long as with those before and behind them to which they are welded: where a rod is cut does not matter.
fn in_rows(robot: &Robot, own: Vec<Rod>) -> Vec<Rod> {
    let is_rod = |link: usize| !robot.links[link].rod.is_empty();
    let before = |link: usize| {
        let Link { parent, joint, driven, at, .. } = &robot.links[link];
        let length =
            |parent: usize| robot.links[parent].rod.iter().map(|segment| segment.length).sum::<f64>();
        let is_at_tip = at.is_none_or(|at| parent.is_some_and(|parent| at == length(parent)));
        let is_next = joint.coordinates().is_empty() && driven.is_none() && is_at_tip;
        parent.filter(|&parent| is_next && is_rod(link) && is_rod(parent))
    };
    let longer = |a: Rod, b: Rod| if b.length > a.length { b } else { a };
    let mut behind = vec![Rod::default(); own.len()];
    for link in (0..own.len()).rev() {
        if let Some(parent) = before(link) {
            behind[parent] = longer(behind[parent], joined(own[link], behind[link]));
        }
    }
    let mut up_to: Vec<Rod> = Vec::with_capacity(own.len());
    for (link, &rod) in own.iter().enumerate() {
        up_to.push(before(link).map_or(rod, |parent| joined(rod, up_to[parent])));
    }
    up_to.into_iter().zip(behind).map(|(rod, behind)| joined(rod, behind)).collect()
}

fn joined(rod: Rod, other: Rod) -> Rod {
    let Rod { length, compliance, radius } = rod;
    Rod { length: length + other.length, compliance: compliance + other.compliance, radius }
}

/// The first link of all that hang together, of each link.
fn roots(robot: &Robot) -> Vec<usize> {
    let mut roots: Vec<usize> = (0..robot.links.len()).collect();
    let mut join = |links: &mut dyn Iterator<Item = usize>| {
        let Some(mut first) = links.next() else { return };
        for mut other in links {
            while roots[first] != first {
                first = roots[first];
            }
            while roots[other] != other {
                other = roots[other];
            }
            let [low, high] = [first.min(other), first.max(other)];
            roots[high] = low;
        }
    };
    for (i, link) in robot.links.iter().enumerate() {
        join(&mut [Some(i), link.parent].into_iter().flatten());
    }
    for ends in robot.loops.iter().filter_map(|closed| closed.tie.ends()) {
        join(&mut ends.iter().filter_map(|end| end.link));
    }
    for actuator in &robot.actuators {
        let along = actuator.along().into_iter().map(|along| along.link);
        join(&mut along.chain(actuator.vias().into_iter().filter_map(|via| via.link)));
    }
    for contact in &robot.contacts {
        join(&mut contact.surfaces.iter().filter_map(Surface::link));
    }
    // Parents are followed from the lowest on, whose own are final.
    for link in 0..roots.len() {
        roots[link] = roots[roots[link]];
    }
    roots
}

/// A link on which an actuator acts, and the force and the moment with which it presses at most; `None` for those that depend on
/// the motion.
fn of_actuator(actuator: &Actuator, robot: &Robot) -> (Option<usize>, [Option<f64>; 2]) {
    let nothing = Some(0.0);
    match actuator {
        Actuator::Tendon(tendon) => {
            let along = actuator.along().first().map(|along| along.link);
            let link = along.or_else(|| actuator.vias().into_iter().find_map(|via| via.link));
            match &tendon.drive {
                Drive::Tension(tension) => (link, [largest(tension), nothing]),
                Drive::Length { .. } => (link, [None, nothing]),
            }
        }
        Actuator::Chamber(chamber) => {
            let force = largest(&chamber.pressure).map(|pressure| chamber.area * pressure);
            (chamber.path.first().map(|along| along.link), [force, nothing])
        }
        Actuator::Motor(motor) => {
            let limit = motor.limits.map(|[lower, upper]| lower.abs().max(upper.abs()));
            let most = match (limit.filter(|limit| limit.is_finite()), &motor.command) {
                (Some(limit), _) => Some(limit),
                (None, MotorCommand::Torque(torque)) => largest(torque),
                (None, MotorCommand::Position { .. }) => None,
            };
            let motions = robot.links[motor.link].joint.motions();
            let is_turned = motions.get(motor.coordinate).is_some_and(|motion| motion.is_turn());
            (Some(motor.link), if is_turned { [nothing, most] } else { [most, nothing] })
        }
        Actuator::ActiveStrain(active) => (Some(active.link), [None, nothing]),
    }
}

/// Largest magnitude of a signal, of an input that of its default; `None` of what grows, and of functions, which are not called
/// before a run.
fn largest<const N: usize>(signal: &Signal<N>) -> Option<f64> {
    match signal {
        Signal::Constant(value) => Some(norm(*value)),
        Signal::Input(input) => Some(norm(input.value)),
        Signal::Table(table) => Some(table.values().iter().map(|value| norm(*value)).fold(0.0, f64::max)),
        Signal::Harmonic(harmonic) if harmonic.rate == [0.0; N] => {
            let reach = |i: usize| harmonic.mean[i].abs() + harmonic.amplitude[i].abs();
            Some(norm(std::array::from_fn::<f64, N, _>(reach)))
        }
        Signal::Harmonic(_) | Signal::Function(_) => None,
    }
}

fn norm<const N: usize>(vector: [f64; N]) -> f64 {
    vector.into_iter().map(|x| x * x).sum::<f64>().sqrt()
}
