//! What touches, in plain data: surfaces of links and obstacles, and how they press on each other.
//!
//! ```
//! use lissom::contact::{Contact, Obstacle, Surface};
//!
//! let floor = Surface::Obstacle(Obstacle::HalfSpace { point: [0.0; 3], normal: [0.0, 0.0, 1.0] });
//! let contact = Contact { friction: [0.4; 3], ..Contact::between("floor", [Surface::Rod { link: 0 }, floor]) };
//! assert!(contact.validate(&|_| Some(1.0)).is_ok());
//! ```

use crate::error::{Checker, InvalidInput, Number};
use crate::lie::QUATERNION_TOLERANCE;
use crate::load::check_place;

/// What is fixed in the world and can be touched.
#[derive(Clone, Debug, PartialEq)]
pub enum Obstacle {
    /// All that lies behind a plane.
    HalfSpace {
        /// A point of the plane, metres.
        point: [f64; 3],
        /// Away from what it fills; normalised on use.
        normal: [f64; 3],
    },
    /// A ball.
    Sphere {
        /// Metres.
        centre: [f64; 3],
        /// Metres.
        radius: f64,
    },
    /// All that is not further from a straight line between two points than a radius.
    Capsule {
        /// Where the line begins and ends, metres.
        ends: [[f64; 3]; 2],
        /// Metres.
        radius: f64,
    },
    /// A box with sharp edges.
    Cuboid {
        /// Metres.
        centre: [f64; 3],
        /// Half the lengths along its axes, metres.
        half_extents: [f64; 3],
        /// Of its axes: unit quaternion (w, x, y, z).
        orientation: [f64; 4],
    },
}

impl Obstacle {
    /// Everything that is wrong with it.
    pub fn validate(&self) -> Result<(), InvalidInput> {
        let mut check = Checker::new();
        match self {
            Self::HalfSpace { point, normal } => {
                check.finite(point, "point");
                if check.finite(normal, "normal") {
                    let is_direction = normal.iter().any(|&x| x != 0.0);
                    check.require(
                        is_direction,
                        "normal",
                        "(0, 0, 0)",
                        "a direction: away from what is filled",
                    );
                }
            }
            Self::Sphere { centre, radius } => {
                check.finite(centre, "centre");
                check.positive(*radius, "radius", "metres");
            }
            Self::Capsule { ends: [start, end], radius } => {
                check.finite(start, "start");
                check.finite(end, "end");
                check.require(start != end, "end", "the start", "another point; a ball is a Sphere");
                check.positive(*radius, "radius", "metres");
            }
            Self::Cuboid { centre, half_extents, orientation } => {
                check.finite(centre, "centre");
                for (i, &half) in half_extents.iter().enumerate() {
                    check.positive(half, &format!("half_extents[{i}]"), "metres");
                }
                if check.finite(orientation, "orientation") {
                    let norm = orientation.iter().map(|x| x * x).sum::<f64>().sqrt();
                    check.require(
                        (norm - 1.0).abs() <= QUATERNION_TOLERANCE,
                        "orientation",
                        format_args!("a quaternion of norm {norm}"),
                        "a quaternion (w, x, y, z) of norm 1",
                    );
                }
            }
        }
        check.finish()
    }
}

/// One of two that touch.
#[derive(Clone, Debug, PartialEq)]
pub enum Surface {
    /// That of a link's rod, round with the larger of the section's half extents.
    Rod {
        /// The link, by its place among those of the robot.
        link: usize,
    },
    /// A ball that is fixed to a link.
    Ball {
        /// The link, by its place among those of the robot.
        link: usize,
        /// Arc length from the base of the link's rod, in metres; `None` is the tip, or the base of a rigid link.
        at: Option<f64>,
        /// Its centre beside the section or body, in the axes there, metres.
        position: [f64; 3],
        /// Metres.
        radius: f64,
    },
    /// What is fixed in the world.
    Obstacle(Obstacle),
}

impl Surface {
    /// The link that it is on.
    pub fn link(&self) -> Option<usize> {
        match self {
            Self::Rod { link } | Self::Ball { link, .. } => Some(*link),
            Self::Obstacle(_) => None,
        }
    }

    fn check(&self, check: &mut Checker, place: &str, length: &dyn Fn(usize) -> Option<f64>) {
        if let Self::Obstacle(obstacle) = self {
            check.nested(place, obstacle.validate());
            return;
        }
        let Some(length) = self.link().and_then(length) else {
            check.require(false, &format!("{place}.link"), self.link().unwrap_or(0), "a link of the robot");
            return;
        };
        match self {
            Self::Ball { at, position, radius, .. } => {
                let place_at = format!("{place}.at");
                match at {
                    Some(x) if length > 0.0 => {
                        check_place(check, *x, &place_at, length);
                    }
                    Some(x) => {
                        check.require(false, &place_at, Number(*x), "none: the link has no rod");
                    }
                    None => {}
                }
                check.finite(position, &format!("{place}.position"));
                check.positive(*radius, &format!("{place}.radius"), "metres");
            }
            _ => {
                let expected = "a link with a rod, or a Ball on it";
                check.require(length > 0.0, place, "a link without a rod", expected);
            }
        }
    }
}

/// A pair of surfaces that can touch: they press on each other where they overlap.
///
/// Along a rod they press with `f = k d max(0, 1 + c d')` a metre, where they overlap by d; two balls, or a ball and an
/// obstacle, with as much at their point (Hunt and Crossley 1975). Friction is `-mu f v / sqrt(|v|^2 + v_s^2)` with the
/// velocity v at which they slide.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    /// Its name in messages and results.
    pub name: String,
    /// The first one is not an obstacle.
    pub surfaces: [Surface; 2],
    /// k, in N/m^2 along rods and N/m of balls; of rods that of their material where it is `None`.
    pub stiffness: Option<f64>,
    /// c, in s/m.
    pub dissipation: f64,
    /// mu of the first surface as it slides forward along its rod, backward, and sideways; of a ball all are the same.
    pub friction: [f64; 3],
    /// v_s, in m/s: what sticks creeps by less than that.
    pub slip_velocity: f64,
}

impl Contact {
    /// Loses about as much in an impact of 0.1 m/s as rubber does: 7 percent of its speed.
    pub const DISSIPATION: f64 = 1.0;
    /// Far below what a robot moves at.
    pub const SLIP_VELOCITY: f64 = 1e-4;

    /// Of material stiffness, without friction.
    pub fn between(name: &str, surfaces: [Surface; 2]) -> Self {
        Self {
            name: name.to_owned(),
            surfaces,
            stiffness: None,
            dissipation: Self::DISSIPATION,
            friction: [0.0; 3],
            slip_velocity: Self::SLIP_VELOCITY,
        }
    }

    /// Whether forces are spread along a rod.
    pub fn is_spread(&self) -> bool {
        self.surfaces.iter().any(|surface| matches!(surface, Surface::Rod { .. }))
    }

    /// Everything that is wrong with it on a robot whose links have these lengths (zero of rigid ones, `None` where there is
    /// no such link).
    pub fn validate(&self, length: &dyn Fn(usize) -> Option<f64>) -> Result<(), InvalidInput> {
        let mut check = Checker::new();
        check.require(!self.name.is_empty(), "name", "''", "a name");
        for (surface, place) in self.surfaces.iter().zip(["a", "b"]) {
            surface.check(&mut check, place, length);
        }
        let [a, b] = &self.surfaces;
        check.require(
            !matches!(a, Surface::Obstacle(_)),
            "a",
            "an obstacle",
            "what moves: the name of a link with a rod, or a Ball; obstacles come second",
        );
        let is_one = a.link().is_some() && a.link() == b.link();
        let is_self = matches!(self.surfaces, [Surface::Rod { .. }, Surface::Rod { .. }]);
        check.require(
            !is_one || is_self,
            "b",
            "another surface of the same link",
            "a surface of another link, or of a rod with itself",
        );
        let unit = if self.is_spread() { "N/m^2" } else { "N/m" };
        match self.stiffness {
            Some(stiffness) => {
                check.positive(stiffness, "stiffness", unit);
            }
            None => {
                check.require(
                    self.is_spread(),
                    "stiffness",
                    "None",
                    "N/m, > 0: a rigid ball has no material",
                );
            }
        }
        check.non_negative(self.dissipation, "dissipation", "s/m");
        let [forward, backward, sideways] = self.friction;
        for (mu, place) in [(forward, "forward"), (backward, "backward"), (sideways, "sideways")] {
            check.non_negative(mu, &format!("friction.{place}"), "1");
        }
        let is_even = forward == backward && forward == sideways;
        check.require(
            is_even || matches!(a, Surface::Rod { .. }),
            "friction",
            "three coefficients",
            "one number: a ball slides alike in all directions",
        );
        check.positive(self.slip_velocity, "slip_velocity", "m/s");
        check.finish()
    }
}
