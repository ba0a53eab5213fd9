//! A rod as plain data: a sequence of segments, a base, loads and bodies.

use super::carriers::Carriers;
use super::link::{Link, check_orientation};
use super::robot::{MAX_COORDINATES, Robot, check_integration, check_surroundings};
use crate::description::body::Body;
use crate::description::rod::{Section, Segment};
use crate::description::signal::Signal;
use crate::description::world::{BaseMotion, STANDARD_GRAVITY};
use crate::error::{Checker, InvalidInput};
use crate::robot::effects::actuator::Actuator;
use crate::robot::effects::contact::Contact;
use crate::robot::effects::fluid::Fluid;
use crate::robot::effects::load::Load;
use crate::robot::effects::magnet::Magnet;
use crate::robot::effects::support::Support;

/// A rod: a sequence of segments, clamped at its base, with loads and rigid bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct Rod {
    /// Segments from base to tip; each one continues at the end of the previous one.
    pub segments: Vec<Segment>,
    /// Position of the base in the world, in metres.
    pub base_position: [f64; 3],
    /// Orientation of the base: quaternion (w, x, y, z) that rotates body axes into world axes; normalised on
    /// use.
    pub base_orientation: [f64; 4],
    /// Motion of the base relative to this pose; `None` if it is at rest.
    pub base_motion: Option<BaseMotion>,
    /// Gravity in the world, in m/s^2.
    pub gravity: [f64; 3],
    /// Dead force at the tip in world axes, in newtons.
    pub tip_force: [f64; 3],
    /// Dead moment at the tip in world axes, in newton metres. A constant spatial moment has no potential.
    pub tip_moment: [f64; 3],
    /// Point mass at the tip, in kilograms.
    pub tip_mass: f64,
    /// Further loads.
    pub loads: Vec<Load>,
    /// Further rigid bodies.
    pub bodies: Vec<Body>,
    /// Springs and dampers to the world.
    pub supports: Vec<Support>,
    /// The fluid around the rod.
    pub fluid: Option<Fluid>,
    /// The actuators.
    pub actuators: Vec<Actuator>,
    /// The contacts.
    pub contacts: Vec<Contact>,
    /// Magnets on the rod.
    pub magnets: Vec<Magnet>,
    /// Uniform magnetic field in the world, in tesla.
    pub field: Signal<3>,
}

impl Rod {
    /// A rod at the origin along world x, under standard gravity along -z, without tip loads.
    pub fn new(segments: Vec<Segment>) -> Self {
        Self {
            segments,
            base_position: [0.0; 3],
            base_orientation: [1.0, 0.0, 0.0, 0.0],
            base_motion: None,
            gravity: STANDARD_GRAVITY,
            tip_force: [0.0; 3],
            tip_moment: [0.0; 3],
            tip_mass: 0.0,
            loads: Vec::new(),
            bodies: Vec::new(),
            supports: Vec::new(),
            fluid: None,
            actuators: Vec::new(),
            contacts: Vec::new(),
            magnets: Vec::new(),
            field: Signal::default(),
        }
    }

    /// The same rod with the segments of a robot that was made from it.
    pub fn with_segments_of(&self, robot: &Robot) -> Self {
        Self { segments: robot.segments().cloned().collect(), ..self.clone() }
    }

    /// Number of generalised coordinates.
    pub fn coordinates(&self) -> usize {
        self.segments.iter().map(Segment::coordinates).sum()
    }

    /// Length of the unstretched rod in metres.
    pub fn length(&self) -> f64 {
        self.segments.iter().map(|segment| segment.length).sum()
    }

    /// Reports every problem of this rod and its segments.
    pub fn validate(&self) -> Result<(), InvalidInput> {
        self.valid_robot().map(drop)
    }

    /// This rod as a robot, if it is valid.
    pub fn valid_robot(&self) -> Result<Robot, InvalidInput> {
        let mut check = Checker::new();
        check.require(!self.segments.is_empty(), "segments", "none", "at least one segment");
        for (i, segment) in self.segments.iter().enumerate() {
            if let Err(problems) = segment.validate() {
                check.nested::<()>(&format!("segments[{i}]"), Err(problems));
            }
        }
        if check.is_ok() {
            let n = self.coordinates();
            if n > MAX_COORDINATES {
                let expected = format!("at most {MAX_COORDINATES} modes in all segments together");
                check.refuse("segments", format_args!("{n} modes in all"), expected);
            }
            check_integration(&mut check, "segments", self.segments.iter());
        }
        check.finite(&self.base_position, "base_position");
        check_orientation(&mut check, &self.base_orientation, "base_orientation");
        check_surroundings(&mut check, self.base_motion.as_ref(), self.gravity);
        check.finite(&self.tip_force, "tip_force");
        check.finite(&self.tip_moment, "tip_moment");
        check.non_negative(self.tip_mass, "tip_mass", "kilograms");
        // Loads share inputs with actuators, and have the same indices in the robot. Those at the tip are known.
        let mut robot = Robot::from(self);
        let tip_loads = robot.loads.split_off(self.loads.len());
        let tip_bodies = robot.bodies.split_off(self.bodies.len());
        let length = self.length();
        robot.check_on_links(&mut check, |check, place, _, _, validate| {
            check.nested(place, validate(length));
        });
        self.field.check(&mut check, "field");
        if let Some(fluid) = &self.fluid {
            check.nested("fluid", fluid.validate());
            let given = self.segments.iter().position(|segment| matches!(segment.section, Section::Given(_)));
            check.require(
                given.is_none(),
                "fluid",
                format_args!("a fluid around segments[{}], whose section is given", given.unwrap_or(0)),
                "sections with an outline that a fluid can flow around",
            );
        }
        let carriers = Carriers::of(&robot.links, robot.base_motion.is_some());
        robot.check_actuators(&mut check, &carriers);
        robot.check_contacts(&mut check, &carriers);
        check.finish()?;
        robot.loads.extend(tip_loads);
        robot.bodies.extend(tip_bodies);
        Ok(robot)
    }
}

impl From<&Rod> for Robot {
    /// Converts a rod to a robot's link; tip force, tip moment and tip mass follow the other loads and
    /// bodies.
    fn from(rod: &Rod) -> Self {
        let link = Link {
            position: rod.base_position,
            orientation: rod.base_orientation,
            rod: rod.segments.clone(),
            ..Link::new("rod")
        };
        let tip = Load { force: rod.tip_force.into(), moment: rod.tip_moment.into(), ..Load::at_tip() };
        Self {
            links: vec![link],
            base_motion: rod.base_motion.clone(),
            gravity: rod.gravity,
            loads: rod.loads.iter().cloned().chain([tip]).collect(),
            bodies: rod.bodies.iter().cloned().chain([Body::point(rod.tip_mass)]).collect(),
            supports: rod.supports.clone(),
            fluid: rod.fluid.clone(),
            actuators: rod.actuators.clone(),
            loops: Vec::new(),
            contacts: rod.contacts.clone(),
            magnets: rod.magnets.clone(),
            field: rod.field.clone(),
        }
    }
}
