//! Stiffness of contacts: the given one, that of the material, or less if the loads need no more.
//!
//! Steel wire is thousands of times stiffer than its loads require, and such stiffness costs Newton iterations. By default surfaces are
//! therefore as stiff as the material, but no stiffer than needed for small overlaps under the forces that are known before a run:
//! weight, loads, and the force that bends the rods. If other forces may act, they are as stiff as the material.

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

/// Overlap at an edge over the radius under the whole load, for which the stiffness is chosen: in deeper ones the shape of the section
/// would matter.
pub(crate) const OVERLAP: f64 = 0.15;

/// The same over the length of the rod, so that the error of its shape is below a thousandth of its length.
const OF_LENGTH: f64 = 5e-4;

/// At the overlap d a straight rod of radius r overlaps a sharp edge across it along `2 sqrt(2 r d)`, and the force of the
/// parabola of overlaps is `4/3 sqrt(2) k d^(3/2) r^(1/2)`.
const OF_PARABOLA: f64 = 4.0 / 3.0 * SQRT_2;

/// `F L^2 / (E I)` of a force F that turns the tip of a clamped rod by about 75 degrees (Bisshopp and Drucker 1945, figure 2).
const BENDING: f64 = 7.0;

/// Weights count twice, because a weight that is released on a spring presses twice as much as at rest. Weights on free joints count
/// four times ([`FALLING`]): after a fall by h the overlap is `d = sqrt(2 F h / (k L))`, a third of the radius for twice the length
/// of a slender rod.
const RELEASED: f64 = 2.0;
const FALLING: f64 = 4.0;

/// Number of parts of a segment with varying sections at which these are evaluated.
pub(super) const PARTS: usize = 8;

/// The stiffness of every contact of a robot.
pub(crate) fn stiffnesses(robot: &Robot) -> Vec<f64> {
    let is_open = |contact: &Contact| contact.stiffness.is_none();
    let known = robot.contacts.iter().any(is_open).then(|| Known::new(robot));
    let stiffness = |contact: &Contact| match (contact.stiffness, &known) {
        (Some(Stiffness::Given(stiffness)), _) => stiffness,
        (None, Some(known)) => known.default(contact, robot),
        _ => of_material(contact, robot),
    };
    robot.contacts.iter().map(stiffness).collect()
}

/// The stiffness of a contact for which none is given; infinite if nothing is known that limits it.
pub(crate) fn default_stiffness(robot: &Robot, contact: &Contact) -> f64 {
    Known::new(robot).default(contact, robot)
}

/// The default stiffness of a contact if only the known forces acted.
pub(crate) fn needed_stiffness(robot: &Robot, contact: &Contact) -> f64 {
    of_material(contact, robot).min(Known::new(robot).of_loads(contact))
}

/// Rejects contacts of rods without a material whose stiffness does not follow from the loads either.
pub(super) fn check_stiffness(robot: &Robot) -> Result<(), InvalidInput> {
    let mut check = Checker::new();
    let known = Known::new(robot);
    for (i, (contact, stiffness)) in robot.contacts.iter().zip(stiffnesses(robot)).enumerate() {
        // Rods without extent are refused by themselves; with one, the loads say the stiffness.
        let is_thin = rods(contact).any(|link| known.rods[link].radius <= 0.0);
        if is_thin && contact.stiffness.is_none() && known.is_complete(contact) {
            continue;
        }
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
    // The sum of no numbers is minus zero.
    FRAC_PI_4 / rods(contact).map(of_rod).fold(0.0, |sum, compliance| sum + compliance)
}

fn rods(contact: &Contact) -> impl Iterator<Item = usize> {
    let rod = |surface: &Surface| if let Surface::Rod { link } = surface { Some(*link) } else { None };
    contact.surfaces.iter().filter_map(rod)
}

/// Forces and rods of a robot that are known before a run.
struct Known {
    rods: Vec<Rod>,
    /// For each link, the first link of its group, which joints, loops, tendons and contacts connect.
    roots: Vec<usize>,
    /// For each such first link, the forces on its group.
    loads: Vec<KnownLoads>,
}

/// A rod together with the rods that are welded to its ends.
#[derive(Clone, Copy, Debug, Default)]
struct Rod {
    length: f64,
    /// Integral of 1 / (E I) over that length, with the larger I.
    compliance: f64,
    /// Smallest half extent of the sections of this rod alone.
    radius: f64,
}

/// Summed magnitudes of forces and moments on a group of links.
#[derive(Clone, Copy, Debug, Default)]
struct KnownLoads {
    /// Newtons.
    weight: f64,
    /// Whether the group has a free joint and can fall.
    falls: bool,
    /// Newtons, without the weight.
    force: f64,
    /// Newton metres.
    moment: f64,
    /// Whether forces act that are unknown before a run.
    is_unknown: bool,
}

impl KnownLoads {
    fn add(&mut self, force: Option<f64>, moment: Option<f64>) {
        self.is_unknown |= force.is_none() || moment.is_none();
        self.force += force.unwrap_or(0.0);
        self.moment += moment.unwrap_or(0.0);
    }

    fn force(&self) -> f64 {
        self.weight * if self.falls { FALLING } else { RELEASED } + self.force
    }
}

impl Known {
    fn new(robot: &Robot) -> Self {
        let (sections, masses): (Vec<_>, Vec<_>) = robot.links.iter().map(rod).unzip();
        let roots = roots(robot);
        let mut loads = vec![KnownLoads::default(); robot.links.len()];
        let gravity = norm(robot.gravity);
        for (i, (link, mass)) in robot.links.iter().zip(masses).enumerate() {
            let loads = &mut loads[roots[i]];
            loads.weight += mass * gravity;
            loads.falls |= link.joint == Joint::Free && link.driven.is_none();
            // Without gravity, the speed of impacts depends on the initial velocities.
            let is_thrown = gravity == 0.0 && !link.joint_coordinates().is_empty();
            let is_moved = match &link.driven {
                Some(Driven::Coordinate(motion)) => motion.constant().is_none(),
                Some(Driven::Base(_)) => true,
                Some(Driven::Mimic { .. }) | None => false,
            };
            // The forces of springs, magnets and currents depend on the shape.
            let is_sprung = link.joint.forces().is_some_and(|forces| forces.stiffness > 0.0);
            let is_drawn = robot.has_magnets()
                || robot.fluid.as_ref().is_some_and(|fluid| fluid.velocity.iter().any(|v| *v != 0.0));
            loads.is_unknown |= is_thrown || is_moved || is_sprung || is_drawn || robot.base_motion.is_some();
        }
        for support in &robot.supports {
            loads[roots[support.link]].is_unknown = true;
        }
        for body in robot.all_bodies() {
            loads[roots[body.link]].weight += body.mass * gravity;
        }
        for load in robot.acting_loads() {
            let along = if let Extent::Along([from, to]) = load.extent { to - from } else { 1.0 };
            let [force, moment] = [&load.force, &load.moment].map(|signal| Some(along * largest(signal)?));
            loads[roots[load.link]].add(force, moment);
        }
        for actuator in &robot.actuators {
            if let (Some(link), [force, moment]) = of_actuator(actuator, robot) {
                loads[roots[link]].add(force, moment);
            }
        }
        Self { rods: in_rows(robot, sections), roots, loads }
    }

    /// Whether all forces on the links of a contact are known.
    fn is_complete(&self, contact: &Contact) -> bool {
        contact.surfaces.iter().filter_map(Surface::link).all(|link| !self.loads[self.roots[link]].is_unknown)
    }

    fn default(&self, contact: &Contact, robot: &Robot) -> f64 {
        let of_material = of_material(contact, robot);
        if self.is_complete(contact) { of_material.min(self.of_loads(contact)) } else { of_material }
    }

    /// The stiffness at which the overlap is small even if all forces act at one edge, or at one place where no rod touches; infinite without
    /// forces.
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
        let largest = |pressed: fn(&KnownLoads) -> f64| {
            links.clone().map(|link| pressed(&self.loads[self.roots[link]])).fold(0.0, f64::max)
        };
        let bending = rods().map(|rod| BENDING / (rod.length * rod.compliance)).fold(0.0, f64::max);
        let force = largest(KnownLoads::force) + largest(|all| all.moment) / length + bending;
        let stiffness = if contact.is_spread() {
            force / (OF_PARABOLA * overlap.powf(1.5) * radius.sqrt())
        } else {
            force / overlap
        };
        if stiffness > 0.0 { stiffness } else { f64::INFINITY }
    }
}

/// The rod of a link without welded neighbours, and its mass.
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

/// Joins rods that are welded end to end, so that the division of a rod into links does not matter.
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

/// For each link, the first link of its connected group.
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
    // In ascending order, so that the root of a lower link is final.
    for link in 0..roots.len() {
        roots[link] = roots[roots[link]];
    }
    roots
}

/// A link on which an actuator acts, and its largest force and moment; `None` for those that depend on the motion.
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

/// Largest magnitude of a signal; for an input that of its default; `None` for unbounded signals, and for functions, which are not
/// called before a run.
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
