//! Robots and rods as users describe them: trees of links with parts that name their links.

use super::named::{LinkNames, Named};
use super::names::number_default_names;
use super::{Link as ResolvedLink, Robot as Resolved, Rod as ResolvedRod};
use crate::description::body::described::Body;
use crate::description::rod::described::Segment;
use crate::description::schema::{Described, LinkName, Reader};
use crate::description::signal::Signal;
use crate::description::world::STANDARD_GRAVITY;
use crate::description::world::described::BaseMotion;
use crate::robot::effects::actuator::described::Actuator;
use crate::robot::effects::contact::described::Contact;
use crate::robot::effects::fluid::Fluid;
use crate::robot::effects::load::described::Load;
use crate::robot::effects::loops::described::Loop;
use crate::robot::effects::magnet::described::Magnet;
use crate::robot::effects::support::described::Support;

pub use super::link::described::{Link, LinkRod};

/// A robot: a tree of links, each of which is a joint followed by a rod or a rigid body, with loads, actuators, loops and
/// contacts.
///
/// Coordinates are ordered by link, in the order of `links`. Within a link, those of the joint come first, then the strain
/// modes of the rod: by segment, then by strain (torsion, bend_y, bend_z, stretch, shear_y, shear_z), then by mode.
/// Velocities are the time derivatives of the coordinates, also for rotation vectors. A `Rod` is a robot with one link,
/// welded to the world.
#[derive(Clone, Debug, PartialEq, Described)]
#[part(called = "a robot", example = include_str!("robot_example.txt"))]
pub struct Robot {
    /// Links, parents before their children, at least one.
    pub links: Vec<Link>,
    /// Acceleration of gravity in world axes.
    #[part(unit = "metres per second squared", default = STANDARD_GRAVITY)]
    pub gravity: [f64; 3],
    /// Forces and moments. Each names its link.
    #[part(default)]
    pub loads: Vec<Load>,
    /// Additional rigid bodies on links; each one names its link.
    #[part(default)]
    pub bodies: Vec<Body>,
    /// Springs and dampers to the world; each one names its link.
    #[part(default)]
    pub supports: Vec<Support>,
    /// The fluid around rods and bodies; none by default.
    pub fluid: Option<Fluid>,
    /// Motion of everything that is fixed to the world, about the frame of the first link's joint. By default it is at rest.
    pub base_motion: Option<BaseMotion>,
    /// The actuators of the robot.
    #[part(default)]
    pub actuators: Vec<Actuator>,
    /// Joints that close loops of links.
    #[part(default)]
    pub loops: Vec<Loop>,
    /// Pairs of surfaces that can touch.
    #[part(default)]
    pub contacts: Vec<Contact>,
    /// Magnetic dipoles on links; each one names its link. They act on each other, and on magnetised segments of other links.
    #[part(default)]
    pub magnets: Vec<Magnet>,
    /// Uniform magnetic field in world axes, at magnets and magnetised segments. Takes the forms of a `Load`'s `force`.
    #[part(unit = "tesla", default)]
    pub field: Signal<3>,
}

/// A Cosserat rod that is clamped at its base: a sequence of segments with loads and rigid bodies.
///
/// The coordinates are the amplitudes of the strain modes, ordered by segment, then by strain (torsion, bend_y, bend_z,
/// stretch, shear_y, shear_z), then by mode (the degree of a Legendre polynomial). With piecewise constant strain, each
/// piece counts as a segment of its own in this order.
#[derive(Clone, Debug, PartialEq, Described)]
#[part(called = "a rod", positional = 7)]
pub struct Rod {
    /// Segments from base to tip, at least one.
    pub segments: Vec<Segment>,
    /// Position of the base.
    #[part(unit = "metres", default)]
    pub base_position: [f64; 3],
    /// Orientation of the base: unit quaternion (w, x, y, z) that maps body axes to world axes. The rod starts along the body
    /// x axis.
    #[part(default = [1.0, 0.0, 0.0, 0.0])]
    pub base_orientation: [f64; 4],
    /// Acceleration of gravity in world axes.
    #[part(unit = "metres per second squared", default = STANDARD_GRAVITY)]
    pub gravity: [f64; 3],
    /// Dead force at the tip in world axes.
    #[part(unit = "newtons", default)]
    pub tip_force: [f64; 3],
    /// Dead moment at the tip in world axes. A dead moment has no potential, so `energy` does not include it.
    #[part(unit = "newton metres", default)]
    pub tip_moment: [f64; 3],
    /// Point mass at the tip.
    #[part(unit = "kilograms", non_negative, default = 0.0)]
    pub tip_mass: f64,
    /// Additional forces and moments, anywhere on the rod.
    #[part(default)]
    pub loads: Vec<Load>,
    /// Additional rigid bodies, anywhere on the rod.
    #[part(default)]
    pub bodies: Vec<Body>,
    /// Motion of the base relative to its position and orientation. By default the base is fixed.
    pub base_motion: Option<BaseMotion>,
    /// Springs and dampers to the world, anywhere on the rod.
    #[part(default)]
    pub supports: Vec<Support>,
    /// Fluid around the rod. By default there is none.
    pub fluid: Option<Fluid>,
    /// The actuators of the rod.
    #[part(default)]
    pub actuators: Vec<Actuator>,
    /// Contacts of the rod, which they name as the link "rod".
    #[part(default)]
    pub contacts: Vec<Contact>,
    /// Magnetic dipoles on the rod. They act on each other.
    #[part(default)]
    pub magnets: Vec<Magnet>,
    /// Uniform magnetic field in world axes, at magnets and magnetised segments. Takes the forms of a `Load`'s `force`.
    #[part(unit = "tesla", default)]
    pub field: Signal<3>,
}

/// For each list of a robot, the places of its items in the described list. Items that refer to unknown names are left out of the
/// robot.
#[derive(Debug, Default)]
pub struct Places(Vec<(&'static str, Vec<usize>)>);

impl Places {
    /// The place in the description of a place in the robot.
    pub fn described(&self, place: &str) -> Option<String> {
        let (list, rest) = place.split_once('[')?;
        let (i, rest) = rest.split_once(']')?;
        let (_, places) = self.0.iter().find(|(name, _)| *name == list)?;
        Some(format!("{list}[{}]{rest}", places.get(i.parse::<usize>().ok()?)?))
    }

    /// Resolves the items of a list, and records their places.
    fn each<T, R>(
        &mut self,
        list: &'static str,
        items: &[T],
        reader: &mut Reader,
        mut resolve: impl FnMut(&T, &mut Reader) -> Option<R>,
    ) -> Vec<R> {
        let (mut found, mut places) = (Vec::with_capacity(items.len()), Vec::with_capacity(items.len()));
        for (i, item) in items.iter().enumerate() {
            if let Some(made) =
                reader.at_key(list, |reader| reader.at_item(i, |reader| resolve(item, reader)))
            {
                found.push(made);
                places.push(i);
            }
        }
        self.0.push((list, places));
        found
    }

    /// As [`Self::each`]; equal default names are numbered.
    fn each_named<T, R>(
        &mut self,
        list: &'static str,
        items: &[T],
        reader: &mut Reader,
        resolve: impl FnMut(&T, &mut Reader) -> Option<R>,
        has_default_name: impl Fn(&T) -> bool,
        name: impl Fn(&mut R) -> &mut String,
    ) -> Vec<R> {
        let mut found = self.each(list, items, reader, resolve);
        let (_, places) = self.0.last().expect("those of this list");
        number_default_names(
            found.iter_mut().map(name).zip(places.iter().map(|i| has_default_name(&items[*i]))),
        );
        found
    }
}

impl Robot {
    /// A robot of these links with the parts that name links or coordinates, as far as what they name is known. Reports what
    /// is not.
    fn added_to(
        &self,
        robot: Resolved,
        is_rod: bool,
        are_incomplete: bool,
        reader: &mut Reader,
    ) -> (Resolved, Places) {
        let mut places = Places::default();
        let named = Named::of(&robot, is_rod, are_incomplete);
        let on = |link: &Option<LinkName>, reader: &mut Reader| match (is_rod, link) {
            (true, Some(LinkName(link))) => {
                let expected = "none: a rod is one link, a Robot has several";
                reader.require(false, "link", format_args!("'{link}'"), expected);
                None
            }
            (true, None) => Some(0),
            (false, link) => named.only_link("link", link.as_ref(), reader),
        };
        let loads =
            places.each("loads", &self.loads, reader, |it, reader| Some(it.resolved(on(&it.link, reader)?)));
        let bodies = places
            .each("bodies", &self.bodies, reader, |it, reader| Some(it.resolved(on(&it.link, reader)?)));
        let supports = places
            .each("supports", &self.supports, reader, |it, reader| Some(it.resolved(on(&it.link, reader)?)));
        let magnets = places
            .each("magnets", &self.magnets, reader, |it, reader| Some(it.resolved(on(&it.link, reader)?)));
        let actuators = places.each_named(
            "actuators",
            &self.actuators,
            reader,
            |it, reader| named.actuator(it, reader),
            Actuator::has_default_name,
            |actuator| actuator.name_mut(),
        );
        let loops = places.each_named(
            "loops",
            &self.loops,
            reader,
            |it, reader| named.closed(it, reader),
            Loop::has_default_name,
            |closed| &mut closed.name,
        );
        let contacts = places.each_named(
            "contacts",
            &self.contacts,
            reader,
            |it, reader| it.resolved(|key, name| named.link(key, name, reader)),
            Contact::has_default_name,
            |contact| &mut contact.name,
        );
        (Resolved { loads, bodies, supports, magnets, actuators, loops, contacts, ..robot }, places)
    }

    /// The robot, as far as what its parts name is known; reports what is not. If there are further links, `are_incomplete`,
    /// unknown names may be theirs.
    pub fn resolved(&self, are_incomplete: bool, reader: &mut Reader) -> (Resolved, Places) {
        let names = LinkNames::new(self.links.iter().map(|link| link.name.as_str()), are_incomplete);
        let link = |(i, link): (usize, &Link)| {
            reader.at_key("links", |reader| reader.at_item(i, |reader| names.resolved(i, link, reader)))
        };
        let links: Vec<ResolvedLink> = self.links.iter().enumerate().map(link).collect();
        let robot = Resolved {
            gravity: self.gravity,
            fluid: self.fluid.clone(),
            base_motion: self.base_motion.as_ref().map(BaseMotion::resolved),
            field: self.field.clone(),
            ..Resolved::new(links)
        };
        self.added_to(robot, false, are_incomplete, reader)
    }
}

impl Rod {
    /// The rod, as far as what its parts name is known; reports what is not.
    pub fn resolved(&self, reader: &mut Reader) -> (ResolvedRod, Places) {
        let rod = ResolvedRod {
            base_position: self.base_position,
            base_orientation: self.base_orientation,
            base_motion: self.base_motion.as_ref().map(BaseMotion::resolved),
            gravity: self.gravity,
            tip_force: self.tip_force,
            tip_moment: self.tip_moment,
            tip_mass: self.tip_mass,
            fluid: self.fluid.clone(),
            field: self.field.clone(),
            ..ResolvedRod::new(self.segments.iter().map(Segment::resolved).collect())
        };
        if self.has_no_parts() {
            return (rod, Places::default());
        }
        let (robot, places) = self.on_robot().added_to(Resolved::from(&rod), true, false, reader);
        let Resolved { loads, bodies, supports, magnets, actuators, contacts, .. } = robot;
        (ResolvedRod { loads, bodies, supports, magnets, actuators, contacts, ..rod }, places)
    }

    /// Whether nothing refers to the rod by a name.
    fn has_no_parts(&self) -> bool {
        let Self { loads, bodies, supports, actuators, contacts, magnets, .. } = self;
        loads.is_empty()
            && bodies.is_empty()
            && supports.is_empty()
            && actuators.is_empty()
            && contacts.is_empty()
            && magnets.is_empty()
    }

    /// The parts of the rod as those of a robot, without the link.
    fn on_robot(&self) -> Robot {
        Robot {
            links: Vec::new(),
            gravity: self.gravity,
            loads: self.loads.clone(),
            bodies: self.bodies.clone(),
            supports: self.supports.clone(),
            fluid: self.fluid.clone(),
            base_motion: self.base_motion.clone(),
            actuators: self.actuators.clone(),
            loops: Vec::new(),
            contacts: self.contacts.clone(),
            magnets: self.magnets.clone(),
            field: self.field.clone(),
        }
    }
}

impl Resolved {
    /// The description of this robot.
    pub fn described(&self) -> Robot {
        // The only link of a robot need not be named.
        let name = |link: usize| (self.links.len() > 1).then(|| LinkName(self.links[link].name.clone()));
        Robot {
            links: self.links.iter().map(|link| self.described_link(link)).collect(),
            gravity: self.gravity,
            loads: self.loads.iter().map(|load| load.described(name(load.link))).collect(),
            bodies: self.bodies.iter().map(|body| body.described(name(body.link))).collect(),
            supports: self.supports.iter().map(|support| support.described(name(support.link))).collect(),
            fluid: self.fluid.clone(),
            base_motion: self.base_motion.as_ref().map(|motion| motion.described()),
            actuators: self.actuators.iter().map(|actuator| self.described_actuator(actuator)).collect(),
            loops: self.described_loops().collect(),
            contacts: self.contacts.iter().map(|contact| self.described_contact(contact)).collect(),
            magnets: self.magnets.iter().map(|magnet| magnet.described(name(magnet.link))).collect(),
            field: self.field.clone(),
        }
    }
}

impl ResolvedRod {
    /// The description of this rod.
    pub fn described(&self) -> Rod {
        let described = Resolved::from(self).described();
        let Robot { mut loads, mut bodies, supports, fluid, base_motion, .. } = described;
        let Robot { actuators, contacts, magnets, field, .. } = described;
        // Those at the tip have arguments of their own.
        loads.truncate(self.loads.len());
        bodies.truncate(self.bodies.len());
        Rod {
            segments: self.segments.iter().map(crate::description::rod::Segment::described).collect(),
            base_position: self.base_position,
            base_orientation: self.base_orientation,
            gravity: self.gravity,
            tip_force: self.tip_force,
            tip_moment: self.tip_moment,
            tip_mass: self.tip_mass,
            loads,
            bodies,
            base_motion,
            supports,
            fluid,
            actuators,
            contacts,
            magnets,
            field,
        }
    }
}
