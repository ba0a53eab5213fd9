//! Contacts as robots hold them: surfaces of links by their indices, obstacles, and the forces between them.
//! [`described`] is what users describe, and checks all that needs no robot.
//!
//! ```
//! use lissom::contact::{Contact, HalfSpace, Surface};
//!
//! let floor = Surface::Obstacle(HalfSpace { point: [0.0; 3], normal: [0.0, 0.0, 1.0] }.into());
//! let contact = Contact { friction: [0.4; 3], ..Contact::between("floor", [Surface::Rod { link: 0 }, floor]) };
//! assert!(contact.validate(&|_| Some(1.0)).is_ok());
//! ```

pub(crate) mod advice;
mod bore;
mod bounds;
pub(crate) mod broad_phase;
pub(crate) mod clearance;
pub(crate) mod compile;
pub(crate) mod curve;
pub mod described;
pub(crate) mod detection;
pub(crate) mod explain;
pub(crate) mod follow;
pub(crate) mod force;
mod friction;
pub(crate) mod intervals;
mod narrow_phase;
pub mod obstacles;
mod patch;
pub(crate) mod plan;
pub(crate) mod products;
pub(crate) mod query;
pub(crate) mod shapes;
mod sliding;
pub(crate) mod state;
pub(crate) mod tunnelling;

use self::obstacles::Shape;
use crate::description::rod::arc_length::check_place;
use crate::description::schema::{Item as _, LinkName};
use crate::error::{Checker, InvalidInput, Number};
use crate::robot::effects::actuator::AlongRodTable;

pub use self::friction::Coefficients;
pub use self::obstacles::{
    Capsule, ConvexMesh, Cuboid, DistanceGrid, HalfSpace, HeightField, Mesh, Obstacle, Sphere, Tube,
    centre_line,
};

/// One of the two surfaces of a contact.
#[derive(Clone, Debug, PartialEq)]
pub enum Surface {
    /// Surface of a link's rod. Sections are ellipses with the half extents of the section; against another
    /// rod they are circles with the larger half extent.
    Rod {
        /// Index of the link in the robot.
        link: usize,
    },
    /// A ball fixed to a link.
    Ball {
        /// Index of the link in the robot.
        link: usize,
        /// Arc length from the base of the link's rod, in metres; `None` is the tip, or the base of a rigid
        /// link.
        at: Option<f64>,
        /// Centre of the ball relative to the section or body, in its axes, metres.
        position: [f64; 3],
        /// Metres.
        radius: f64,
    },
    /// A shape fixed to a link.
    Solid {
        /// Index of the link in the robot.
        link: usize,
        /// Arc length from the base of the link's rod, in metres; `None` is the tip, or the base of a rigid link.
        at: Option<f64>,
        /// The shape, in the axes of that section or body.
        shape: Obstacle,
    },
    /// A shape fixed in the world.
    Obstacle(Obstacle),
}

impl Surface {
    /// Index of the link that carries the surface; `None` for an obstacle.
    pub fn link(&self) -> Option<usize> {
        match self {
            Self::Rod { link } | Self::Ball { link, .. } | Self::Solid { link, .. } => Some(*link),
            Self::Obstacle(_) => None,
        }
    }

    /// The shape; `None` for rods and balls.
    pub(crate) fn obstacle(&self) -> Option<&Obstacle> {
        match self {
            Self::Rod { .. } | Self::Ball { .. } => None,
            Self::Solid { shape, .. } | Self::Obstacle(shape) => Some(shape),
        }
    }

    /// The shape as contacts use it; `None` for rods and balls.
    pub(crate) fn shape(&self) -> Option<&dyn Shape> {
        self.obstacle().map(Obstacle::shape)
    }

    /// Whether the link has the place of the surface.
    fn check(&self, check: &mut Checker, place: &str, length: &dyn Fn(usize) -> Option<f64>) {
        let Some(link) = self.link() else { return };
        let Some(length) = length(link) else {
            check.require(false, &format!("{place}.link"), link, "a link of the robot");
            return;
        };
        if let Self::Ball { at: Some(x), .. } | Self::Solid { at: Some(x), .. } = self {
            let place_at = format!("{place}.at");
            if length > 0.0 {
                check_place(check, *x, &place_at, length);
            } else {
                check.require(false, &place_at, Number(*x), "none: the link has no rod");
            }
        }
        let expected = "a link with a rod, or a Ball on it (or another shape)";
        let has_rod = length > 0.0 || !matches!(self, Self::Rod { .. });
        check.require(has_rod, place, "a link without a rod", expected);
    }
}

/// A stiffness of a contact that users set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stiffness {
    /// A number, in N/m^2 along rods, in N/m for balls and for each corner and edge of bodies.
    Given(f64),
    /// From the material of the rods.
    Material,
}

/// A pair of surfaces with a contact force where they overlap.
///
/// Along a rod the normal force per metre is `f = k d max(0, 1 + c d')` at the overlap d; a ball has one such
/// force at its point of contact (Hunt and Crossley 1975). Boxes, meshes and capsules have one such force at
/// each corner or end in contact with a half-space; between two of these bodies the closest points of edges
/// carry forces too. Friction is `-mu f v / sqrt(|v|^2 + v_s^2)` with the sliding velocity v.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    /// Its name in messages and results.
    pub name: String,
    /// The surfaces; the first one is not an obstacle.
    pub surfaces: [Surface; 2],
    /// k; `None` takes the stiffness of the rod's material, but no more than the loads of the robot need.
    pub stiffness: Option<Stiffness>,
    /// c, in s/m.
    pub dissipation: f64,
    /// mu of the first surface for sliding forward along its rod, backward, and sideways; balls use one value
    /// for all three.
    pub friction: [f64; 3],
    /// mu along the rod of the first surface, over its whole length and for all directions, in place of `friction`.
    pub friction_along: Option<AlongRodTable>,
    /// Coefficient of static friction, at least that of sliding, which must then be isotropic; `None` is that of sliding.
    pub static_friction: Option<f64>,
    /// v_st, in m/s: friction falls from the static to the sliding value over about this velocity.
    pub stribeck_velocity: f64,
    /// v_s, in m/s. Sticking surfaces creep at less than this velocity.
    pub slip_velocity: f64,
    /// r, in metres: friction resists spin with a moment of up to the sideways coefficient times the normal
    /// force times r.
    pub patch_radius: f64,
}

impl Contact {
    /// Default dissipation in s/m: an impact at 0.1 m/s loses about 7 percent of its speed, as rubber does.
    pub const DISSIPATION: f64 = 1.0;
    /// Default slip velocity in m/s, far below the velocities of robots.
    pub const SLIP_VELOCITY: f64 = 1e-4;
    /// Default Stribeck velocity in m/s: the upper end of the range for metals and polymers, 1 mm/s to 0.1 m/s (Armstrong-Hélouvry,
    /// Dupont and Canudas de Wit 1994, section 2.2), which steps of fixed size resolve best.
    pub const STRIBECK_VELOCITY: f64 = 0.1;

    /// Whether one of its surfaces is that of a rod.
    pub fn has_rod(&self) -> bool {
        self.surfaces.iter().any(|surface| matches!(surface, Surface::Rod { .. }))
    }

    /// A contact with the default stiffness and without friction.
    pub fn between(name: &str, surfaces: [Surface; 2]) -> Self {
        Self {
            name: name.to_owned(),
            surfaces,
            stiffness: None,
            dissipation: Self::DISSIPATION,
            friction: [0.0; 3],
            friction_along: None,
            static_friction: None,
            stribeck_velocity: Self::STRIBECK_VELOCITY,
            slip_velocity: Self::SLIP_VELOCITY,
            patch_radius: 0.0,
        }
    }

    /// Whether forces are distributed along a rod.
    pub fn is_spread(&self) -> bool {
        self.surfaces.iter().any(|surface| matches!(surface, Surface::Rod { .. }))
    }

    /// Reports every problem of the contact on a robot whose links have these lengths (zero for rigid links,
    /// `None` for indices without a link).
    pub fn validate(&self, length: &dyn Fn(usize) -> Option<f64>) -> Result<(), InvalidInput> {
        let mut check = Checker::new();
        check.require(!self.name.is_empty(), "name", "''", "a name");
        for (surface, place) in self.surfaces.iter().zip(["a", "b"]) {
            surface.check(&mut check, place, length);
        }
        self.check_friction(&mut check, length);
        // Only whether links are equal matters here, not their names.
        let described = self.described(&|link| LinkName(link.to_string()));
        check.all(described.validate());
        check.finish()
    }
}
