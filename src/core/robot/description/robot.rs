//! A robot as plain data: a tree of links, with loads, actuators, loops and contacts.

use std::collections::HashSet;

use super::carriers::{Carrier, Carriers};
use super::driven::Driven;
use super::link::Link;
use super::mimic::check_mimics;
use super::signals::PlacedSignal;
use crate::description::body::Body;
use crate::description::joint::Joint;
use crate::description::rod::arc_length::check_end;
use crate::description::rod::{Allowable, Section, Segment};
use crate::description::schema::Item as _;
use crate::description::signal::Signal;
use crate::description::world::{BaseMotion, STANDARD_GRAVITY};
use crate::error::{Checker, InvalidInput, Number};
use crate::robot::effects::actuator::{Actuator, Along, Drive};
use crate::robot::effects::contact::{Contact, Surface};
use crate::robot::effects::fluid::Fluid;
use crate::robot::effects::load::{Extent, Load};
use crate::robot::effects::loops::{Loop, Tie};
use crate::robot::effects::magnet::{self, Magnet};
use crate::robot::effects::support::Support;

/// Maximum number of entries of a robot's integration matrices, summed squares of the numbers of nodes: 1 GiB
/// in two matrices.
const MAX_INTEGRATION: f64 = (1u64 << 26) as f64;

/// Maximum number of generalised coordinates of a robot: its dense Jacobian then takes 288 MiB. A pile of 400 rods has 5200.
pub const MAX_COORDINATES: usize = 6144;

/// A robot: a tree of links, and everything that acts on them.
///
/// Coordinates are ordered by link; within a link first those of the joint, then the modes of the rod,
/// segment by segment.
#[derive(Clone, Debug, PartialEq)]
pub struct Robot {
    /// Links, with parents before their children.
    pub links: Vec<Link>,
    /// Motion of everything fixed to the world, about the frame of the first link's joint; `None` if it is at
    /// rest.
    pub base_motion: Option<BaseMotion>,
    /// Gravity in the world, in m/s^2.
    pub gravity: [f64; 3],
    /// Loads on the links.
    pub loads: Vec<Load>,
    /// Rigid bodies on the links, in addition to the links' own bodies.
    pub bodies: Vec<Body>,
    /// Springs and dampers between links and the world.
    pub supports: Vec<Support>,
    /// The fluid around the rods.
    pub fluid: Option<Fluid>,
    /// The actuators.
    pub actuators: Vec<Actuator>,
    /// Joints that close loops of links.
    pub loops: Vec<Loop>,
    /// Pairs of surfaces that can touch.
    pub contacts: Vec<Contact>,
    /// Magnets on the links.
    pub magnets: Vec<Magnet>,
    /// Uniform magnetic field in the world, in tesla.
    pub field: Signal<3>,
}

impl Robot {
    /// These links under standard gravity along -z.
    pub fn new(links: Vec<Link>) -> Self {
        Self {
            links,
            base_motion: None,
            gravity: STANDARD_GRAVITY,
            loads: Vec::new(),
            bodies: Vec::new(),
            supports: Vec::new(),
            fluid: None,
            actuators: Vec::new(),
            loops: Vec::new(),
            contacts: Vec::new(),
            magnets: Vec::new(),
            field: Signal::default(),
        }
    }

    /// Number of generalised coordinates.
    pub fn coordinates(&self) -> usize {
        self.links.iter().map(Link::coordinates).sum()
    }

    /// Names of all coordinates: the link's name, a dot, and the name within the link.
    pub fn coordinate_names(&self) -> Vec<String> {
        let of_link = |link: &Link| {
            let name = link.name.clone();
            link.coordinate_names().into_iter().map(move |of_link| format!("{name}.{of_link}"))
        };
        self.links.iter().flat_map(of_link).collect()
    }

    /// Indices of a link's coordinates.
    pub fn coordinates_of(&self, link: usize) -> std::ops::Range<usize> {
        let first = self.links[..link].iter().map(Link::coordinates).sum();
        first..first + self.links[link].coordinates()
    }

    /// Index of the first coordinate of every link.
    pub(crate) fn first_coordinates(&self) -> Vec<usize> {
        let mut next = 0;
        let first = |link: &Link| {
            let first = next;
            next += link.coordinates();
            first
        };
        self.links.iter().map(first).collect()
    }

    /// Numbers of coordinates of consecutive groups of links that move independently ([`parts`](crate::model::Facts::parts)).
    pub(crate) fn parts(&self) -> Vec<usize> {
        let mut roots: Vec<Option<usize>> = Vec::with_capacity(self.links.len());
        let mut sizes = Vec::new();
        let mut last_root = None;
        for (i, link) in self.links.iter().enumerate() {
            let size = link.coordinates();
            let carrier = link.parent.and_then(|parent| roots[parent]);
            let root = carrier.or((size > 0).then_some(i));
            roots.push(root);
            match sizes.last_mut() {
                _ if size == 0 => continue,
                Some(last) if root == last_root => *last += size,
                _ => sizes.push(size),
            }
            last_root = root;
        }
        sizes
    }

    /// The first coordinates of the rotation vectors of joints.
    pub fn rotation_vectors(&self) -> Vec<usize> {
        let of_link = |(link, first): (&Link, usize)| match link.joint {
            _ if link.driven.is_some() => None,
            Joint::Spherical => Some(first),
            Joint::Free => Some(first + 3),
            _ => None,
        };
        self.links.iter().zip(self.first_coordinates()).filter_map(of_link).collect()
    }

    /// Whether everything that rods carry is located at their tips, and distributed effects are uniform along
    /// them. The length of a segment then affects only its own rod.
    pub(crate) fn has_all_at_tips(&self) -> bool {
        let acts_alike = |actuator: &Actuator| {
            let is_alike = match actuator {
                Actuator::Motor(_) | Actuator::Chamber(_) => true,
                Actuator::Tendon(tendon) => {
                    matches!(tendon.drive, Drive::Tension(_)) && tendon.friction == 0.0
                }
                Actuator::ActiveStrain(_) => false,
            };
            let is_whole = |along: &&Along| {
                along.along == [0.0, self.links[along.link].length()]
                    && along.offset.iter().all(|offset| offset.constant().is_some())
            };
            is_alike && actuator.vias().is_empty() && actuator.along().iter().all(is_whole)
        };
        self.links.iter().all(|link| link.at.is_none())
            && self.bodies.iter().all(|body| body.at.is_none())
            && self.loads.iter().all(|load| load.extent == Extent::Tip)
            && self.supports.is_empty()
            && self.loops.is_empty()
            && !self.has_magnets()
            && self.actuators.iter().all(acts_alike)
    }

    /// Whether the inertia of sections affects only the forces along their rods.
    pub(crate) fn has_separate_sections(&self) -> bool {
        let Self { base_motion, fluid, contacts, .. } = self;
        base_motion.is_none() && fluid.is_none() && contacts.is_empty() && !self.has_magnets()
    }

    /// Whether a segment has an allowable bend radius, strain or stress.
    pub fn has_limits(&self) -> bool {
        self.segments().any(|segment| segment.allowable != Allowable::default())
    }

    /// Whether anything is magnetised.
    pub(crate) fn has_magnets(&self) -> bool {
        !self.magnets.is_empty() || self.segments().any(magnet::is_magnetised)
    }

    /// All segments, link by link.
    pub fn segments(&self) -> impl Iterator<Item = &Segment> {
        self.links.iter().flat_map(|link| &link.rod)
    }

    /// All segments, mutable.
    pub fn segments_mut(&mut self) -> impl Iterator<Item = &mut Segment> {
        self.links.iter_mut().flat_map(|link| &mut link.rod)
    }

    /// Indices of the segments whose modes are open, counted link by link.
    pub fn open_segments(&self) -> Vec<usize> {
        let segments = self.segments().enumerate();
        segments.filter(|(_, segment)| segment.modes_are_open).map(|(i, _)| i).collect()
    }

    /// A segment, counted link by link, in words for messages.
    pub fn name_of_segment(&self, segment: usize) -> String {
        let mut before = 0;
        for link in &self.links {
            if segment < before + link.rod.len() {
                let own = segment - before;
                return match self.links.len() {
                    1 => format!("segments[{own}]"),
                    _ => format!("segments[{own}] of link {:?}", link.name),
                };
            }
            before += link.rod.len();
        }
        String::new()
    }

    /// Index of the first coordinate of a segment, counted link by link.
    pub fn first_coordinate(&self, segment: usize) -> usize {
        let (mut first, mut before) = (0, 0);
        for link in &self.links {
            first += link.joint_coordinates().len();
            let own = &link.rod[..link.rod.len().min(segment - before)];
            first += own.iter().map(Segment::coordinates).sum::<usize>();
            before += own.len();
            if before == segment && own.len() < link.rod.len() {
                break;
            }
        }
        first
    }

    /// Whether the robot is a single rod that is welded to the world.
    pub fn is_rod(&self) -> bool {
        let [link] = &self.links[..] else { return false };
        link.joint == Joint::Weld && link.body.is_none() && !link.rod.is_empty()
    }

    /// Loads that are not zero.
    pub(crate) fn acting_loads(&self) -> impl Iterator<Item = &Load> {
        self.loads.iter().filter(|load| !load.force.is_zero() || !load.moment.is_zero())
    }

    /// All bodies that are not zero: the links' own bodies, then the others.
    pub(crate) fn all_bodies(&self) -> impl Iterator<Item = Body> {
        let of_link = |(i, link): (usize, &Link)| link.body.clone().map(|body| Body { link: i, ..body });
        let is_body = |body: &Body| body.mass != 0.0 || body.inertia != [[0.0; 3]; 3] || body.hull.is_some();
        self.links.iter().enumerate().filter_map(of_link).chain(self.bodies.iter().cloned()).filter(is_body)
    }

    /// The same links with supports only, for their response to deformation.
    pub(crate) fn unloaded(&self) -> Self {
        let links = self.links.iter().map(|link| Link { body: None, ..link.clone() }).collect();
        Self { gravity: [0.0; 3], supports: self.supports.clone(), ..Self::new(links) }
    }

    /// Number of constraints: those of closed loops, and one per inextensible tendon.
    pub fn constraints(&self) -> usize {
        let of_loops = self.loops.iter().map(|closed| closed.tie.rows()).sum::<usize>();
        of_loops + self.inextensible_tendons().count()
    }

    /// Inextensible tendons.
    pub fn inextensible_tendons(&self) -> impl Iterator<Item = &Actuator> {
        self.actuators.iter().filter(|actuator| actuator.is_inextensible())
    }

    /// All prescribed forces and commands, in the order of the inputs: loads, the magnetic field, actuators.
    pub fn signals_with_places(&self) -> impl Iterator<Item = PlacedSignal<'_>> {
        let of_loads = self.loads.iter().enumerate().flat_map(|(i, load)| {
            load.named_signals().map(|(key, signal)| PlacedSignal::vector(Some(("loads", i)), key, signal))
        });
        let of_robot = [PlacedSignal::vector(None, "field", &self.field)];
        let of_actuators = self.actuators.iter().enumerate().flat_map(|(i, actuator)| {
            actuator.named_signals().map(move |(key, signal)| PlacedSignal::command(i, key, signal, actuator))
        });
        of_loads.chain(of_robot).chain(of_actuators)
    }

    /// Reports every problem of this robot, including links and everything that acts on them.
    pub fn validate(&self) -> Result<(), InvalidInput> {
        let mut check = Checker::new();
        check.require(!self.links.is_empty(), "links", "none", "at least one link");
        let mut names = HashSet::with_capacity(self.links.len());
        for (i, link) in self.links.iter().enumerate() {
            let place = format!("links[{i}]");
            check.nested(&place, link.validate());
            check_name(&mut check, &mut names, &link.name, &place, "link");
            self.check_place_in_tree(&mut check, i, &place);
        }
        check_mimics(&mut check, &self.links);
        if check.is_ok() {
            self.check_size(&mut check);
            self.check_masses(&mut check);
        }
        check_surroundings(&mut check, self.base_motion.as_ref(), self.gravity);
        self.check_on_links(&mut check, |check, place, link, has_place, validate| {
            self.check_on_link(check, place, link, has_place, validate);
        });
        self.field.check(&mut check, "field");
        let carriers = Carriers::of(&self.links, self.base_motion.is_some());
        self.check_actuators(&mut check, &carriers);
        self.check_loops(&mut check, &carriers);
        self.check_contacts(&mut check, &carriers);
        if let Some(fluid) = &self.fluid {
            check.nested("fluid", fluid.validate());
            let is_given = |segment: &Segment| matches!(segment.section, Section::Given(_));
            let given = self.links.iter().find(|link| link.rod.iter().any(is_given));
            check.require(
                given.is_none(),
                "fluid",
                format_args!(
                    "a fluid around link \"{}\", which has a given section",
                    given.map_or("", |link| &link.name)
                ),
                "sections with an outline that a fluid can flow around",
            );
        }
        check.finish()
    }

    /// Reports problems of a link's parent.
    fn check_place_in_tree(&self, check: &mut Checker, i: usize, place: &str) {
        let link = &self.links[i];
        let Some(parent) = link.parent else {
            let expected = "none: `at` is an arc length of the parent's rod, and this link has no parent";
            check.require(link.at.is_none(), &format!("{place}.at"), link.at.unwrap_or(0.0), expected);
            return;
        };
        if !check.require(
            parent < i,
            &format!("{place}.parent"),
            format_args!("link {parent}"),
            &format!("a link that stands before this one, which is {i}"),
        ) {
            return;
        }
        let (Some(at), parent) = (link.at, &self.links[parent]) else { return };
        let place = format!("{place}.at");
        if parent.rod.is_empty() {
            let found = format_args!("{at} on \"{}\", which has no rod", parent.name);
            check.require(false, &place, found, "none: the link is attached to the parent's body");
        } else {
            crate::description::rod::arc_length::check_place(check, at, &place, parent.length());
        }
    }

    /// Calls a check for every part on a link: its place in the description, its link, whether it has a place along the link, and the
    /// validation for the length of the rod.
    pub(super) fn check_on_links(
        &self,
        check: &mut Checker,
        on_link: impl Fn(&mut Checker, &str, usize, bool, Validate<'_>),
    ) {
        for (i, load) in self.loads.iter().enumerate() {
            let has_place = load.extent != Extent::Tip;
            on_link(check, &format!("loads[{i}]"), load.link, has_place, &|x| load.validate(x));
        }
        for (i, body) in self.bodies.iter().enumerate() {
            on_link(check, &format!("bodies[{i}]"), body.link, body.at.is_some(), &|x| body.validate(x));
        }
        for (i, support) in self.supports.iter().enumerate() {
            let place = format!("supports[{i}]");
            on_link(check, &place, support.link, support.at.is_some(), &|x| support.validate(x));
        }
        for (i, magnet) in self.magnets.iter().enumerate() {
            on_link(check, &format!("magnets[{i}]"), magnet.link, magnet.at.is_some(), &|x| {
                magnet.validate(x)
            });
        }
    }

    /// Reports problems of an object on a link, including its place.
    fn check_on_link(
        &self,
        check: &mut Checker,
        place: &str,
        link: usize,
        has_place: bool,
        validate: Validate<'_>,
    ) {
        let Some(link) = self.links.get(link) else {
            let expected = format!("a link, 0 to {}", self.links.len().saturating_sub(1));
            check.require(false, &format!("{place}.link"), link, &expected);
            return;
        };
        if has_place && link.rod.is_empty() {
            let found = format_args!("a place on \"{}\", which has no rod", link.name);
            check.require(false, &format!("{place}.at"), found, "none: it is at the base of the link");
            return;
        }
        check.nested(place, validate(link.length()));
    }

    /// Reports problems of closed loops.
    fn check_loops(&self, check: &mut Checker, carriers: &Carriers<'_>) {
        let mut names = HashSet::with_capacity(self.loops.len());
        for (i, (closed, described)) in self.loops.iter().zip(self.described_loops()).enumerate() {
            let place = format!("loops[{i}]");
            check_name(check, &mut names, &closed.name, &place, "loop");
            check.nested(&place, described.validate());
            if let Tie::Joint { joint: joint @ (Joint::Free | Joint::Screw { .. }), .. } = &closed.tie {
                let expected =
                    "a joint that forbids a motion, but no screw, whose turns two frames do not determine";
                check.require(
                    false,
                    &format!("{place}.kind"),
                    format_args!("a {} joint", joint.name()),
                    expected,
                );
            }
            if let Tie::Coordinates { coordinates, .. } = closed.tie {
                let count = self.coordinates();
                for (key, k) in ["a", "b"].into_iter().zip(coordinates) {
                    let expected = format!("a coordinate, 0 to {}", count.saturating_sub(1));
                    check.require(k < count, &format!("{place}.{key}"), k, &expected);
                }
            }
            let Some([a, b]) = closed.tie.ends() else { continue };
            for (key, end) in [("a", a), ("b", b)] {
                let Some(link) = end.link else { continue };
                match (self.links.get(link).map(Link::length), end.at) {
                    (None, _) => {
                        check.require(false, &format!("{place}.{key}.link"), link, "a link of the robot");
                    }
                    (Some(length), Some(x)) if length > 0.0 => {
                        check_end(check, x, &format!("{place}.{key}.at"), length);
                    }
                    (Some(_), Some(x)) => {
                        let expected = "none: the link has no rod";
                        check.require(false, &format!("{place}.{key}.at"), Number(x), expected);
                    }
                    (Some(_), None) => {}
                }
            }
            // The validation of the loop itself reports these.
            if a.link == b.link && (a.at == b.at || a.link.is_none()) {
                continue;
            }
            let [first, second] = [a, b].map(|end| match end.link {
                None => Some(Carrier::World),
                Some(link) => carriers.at(link, end.at),
            });
            check.require(
                first.is_none() || first != second,
                &format!("{place}.b"),
                self.names_of_welded("ends on", [a.link, b.link]),
                "a place that can move against the first one",
            );
        }
    }

    /// Reports problems of contacts.
    pub(super) fn check_contacts(&self, check: &mut Checker, carriers: &Carriers<'_>) {
        let length = |link: usize| self.links.get(link).map(Link::length);
        let mut names = HashSet::with_capacity(self.contacts.len());
        for (i, contact) in self.contacts.iter().enumerate() {
            let place = format!("contacts[{i}]");
            check_name(check, &mut names, &contact.name, &place, "contact");
            check.nested(&place, contact.validate(&length));
            // A deformable link moves relative to everything.
            let [a, b] = contact.surfaces.each_ref().map(|surface| match surface {
                Surface::Rod { .. } => None,
                Surface::Obstacle(_) => Some(Carrier::World),
                Surface::Ball { link, at, .. } | Surface::Solid { link, at, .. } => carriers.at(*link, *at),
            });
            let links = contact.surfaces.each_ref().map(Surface::link);
            let is_self = links[0] == links[1];
            check.require(
                is_self || a.is_none() || a != b,
                &format!("{place}.b"),
                self.names_of_welded("surfaces of", links),
                "surfaces that can move against each other",
            );
        }
    }

    fn names_of_welded(&self, what: &str, links: [Option<usize>; 2]) -> String {
        let [a, b] = links.map(|link| self.name_of(link));
        format!("{what} {a} and {b}, which are welded together")
    }

    /// Name of a link in quotes, or the world.
    pub(super) fn name_of(&self, link: Option<usize>) -> String {
        let Some(link) = link else { return "the world".to_owned() };
        self.links.get(link).map_or(String::new(), |link| format!("\"{}\"", link.name))
    }

    fn check_size(&self, check: &mut Checker) {
        // Coordinates of driven joints are computed too.
        let driven = self.links.iter().filter(|link| link.driven.is_some());
        let n = self.coordinates() + driven.map(|link| link.joint.coordinates().len()).sum::<usize>();
        check.require(
            n <= MAX_COORDINATES,
            "links",
            format_args!("{n} coordinates in all"),
            &format!("at most {MAX_COORDINATES} coordinates in all links together"),
        );
        check_integration(check, "links", self.segments());
    }

    /// Reports joints that move no mass. The mass behind a mimicking joint counts for the mimicked one too.
    fn check_masses(&self, check: &mut Checker) {
        let mut has_mass: Vec<bool> = self.links.iter().map(|link| !link.rod.is_empty()).collect();
        for body in self.all_bodies().filter(|body| body.mass != 0.0) {
            if let Some(has_mass) = has_mass.get_mut(body.link) {
                *has_mass = true;
            }
        }
        for (i, link) in self.links.iter().enumerate().rev() {
            if let (Some(parent), true) = (link.parent, has_mass[i]) {
                has_mass[parent] = true;
            }
        }
        // A mimicked link also moves the masses of the links that mimic it.
        for driven in self.driven() {
            if let Driven::Mimic { link, .. } = driven
                && let Some(has_mass) = has_mass.get_mut(*link)
            {
                *has_mass = true;
            }
        }
        for (i, link) in self.links.iter().enumerate() {
            let has_armature = link.joint.forces().is_some_and(|forces| forces.armature > 0.0);
            if let (false, false, Some(coordinate)) =
                (has_mass[i], has_armature, link.joint_coordinates().first())
            {
                check.require(
                    false,
                    &format!("links[{i}].joint"),
                    format_args!("a joint of \"{}\" with no mass behind it", link.name),
                    &format!("a rod or a body on this link or on one behind it, that `{coordinate}` moves"),
                );
            }
        }
    }
}

/// Every problem of a part on a rod of a length.
type Validate<'a> = &'a dyn Fn(f64) -> Result<(), InvalidInput>;

/// Reports a name that another part of the same kind has.
pub(super) fn check_name<'a>(
    check: &mut Checker,
    known: &mut HashSet<&'a str>,
    name: &'a str,
    place: &str,
    kind: &str,
) {
    let is_new = known.insert(name);
    let found = format_args!("\"{name}\", the name of another {kind}");
    check.require(is_new, &format!("{place}.name"), found, "a different name");
}

/// Reports integration matrices that are too large.
pub(super) fn check_integration<'a>(
    check: &mut Checker,
    place: &str,
    segments: impl Iterator<Item = &'a Segment>,
) {
    let numbers: f64 = segments.map(Segment::integration).sum();
    check.require(
        numbers <= MAX_INTEGRATION,
        place,
        format_args!("{:.1} GB of integration matrices", numbers * 16e-9),
        "fewer quadrature nodes: their square in each segment counts",
    );
}

/// Reports problems of the base motion and of gravity.
pub(super) fn check_surroundings(check: &mut Checker, motion: Option<&BaseMotion>, gravity: [f64; 3]) {
    if let Some(motion) = motion {
        check.nested("base_motion", motion.validate());
    }
    check.finite(&gravity, "gravity");
}
