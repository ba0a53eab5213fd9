//! What touches, in plain data: surfaces of links and obstacles, and how they press on each other.
//!
//! ```
//! use lissom::contact::{Contact, Obstacle, Surface};
//!
//! let floor = Surface::Obstacle(Obstacle::HalfSpace { point: [0.0; 3], normal: [0.0, 0.0, 1.0] });
//! let contact = Contact { friction: [0.4; 3], ..Contact::between("floor", [Surface::Rod { link: 0 }, floor]) };
//! assert!(contact.validate(&|_| Some(1.0)).is_ok());
//! ```

mod mesh;

use crate::error::{Checker, InvalidInput, Number};
use crate::lie::QUATERNION_TOLERANCE;
use crate::load::check_place;

/// A shape that can be touched, fixed in the world or to a link: in the axes of what it is fixed to.
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
    /// All that lies below a smooth surface through heights above a rectangle: the natural cubic spline in both directions,
    /// which continues straight beyond the rectangle.
    HeightField {
        /// Along its z axis, metres; those along its y axis follow each other.
        heights: Vec<f64>,
        /// How many there are along its x axis, and along its y axis.
        shape: [usize; 2],
        /// Between neighbours along its x axis and its y axis, metres.
        spacing: [f64; 2],
        /// Where the first height stands, metres.
        corner: [f64; 3],
        /// Of its axes: unit quaternion (w, x, y, z).
        orientation: [f64; 4],
    },
    /// All that is within a radius of a convex body with flat faces.
    ConvexMesh {
        /// Its corners, metres.
        points: Vec<[f64; 3]>,
        /// Triangles, by their corners in any order; all of them enclose the body.
        faces: Vec<[usize; 3]>,
        /// Of its rounded edges, metres; zero is a sharp one.
        radius: f64,
    },
}

impl Obstacle {
    /// Whether two shapes of which neither is a rod or a ball on a link can touch: through the centre of a sphere, or the corners
    /// and edges of a body.
    fn touches(&self, other: &Self) -> bool {
        let is_ball = |shape: &Self| matches!(shape, Self::Sphere { .. });
        [self, other].into_iter().any(|shape| is_ball(shape) || shape.has_corners())
    }

    /// Whether it is a body with corners: the ends of a capsule are such.
    pub(crate) fn has_corners(&self) -> bool {
        matches!(self, Self::Capsule { .. } | Self::Cuboid { .. } | Self::ConvexMesh { .. })
    }

    /// What it is called in messages.
    pub(crate) fn name(&self) -> &'static str {
        match self {
            Self::HalfSpace { .. } => "a half-space",
            Self::Sphere { .. } => "a sphere",
            Self::Capsule { .. } => "a capsule",
            Self::Cuboid { .. } => "a box",
            Self::HeightField { .. } => "a height field",
            Self::ConvexMesh { .. } => "a convex mesh",
        }
    }

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
                check_orientation(&mut check, orientation);
            }
            Self::HeightField { heights, shape, spacing, corner, orientation } => {
                let [rows, columns] = *shape;
                let is_grid = rows.min(columns) >= 2 && rows.checked_mul(columns) == Some(heights.len());
                check.require(
                    is_grid && heights.len() <= MOST_HEIGHTS,
                    "heights",
                    format_args!("{} numbers in {rows} rows of {columns}", heights.len()),
                    &format!("two or more along each axis, and at most {MOST_HEIGHTS} in all"),
                );
                check.finite(heights, "heights");
                for (i, &space) in spacing.iter().enumerate() {
                    check.positive(space, &format!("spacing[{i}]"), "metres");
                }
                check.finite(corner, "corner");
                check_orientation(&mut check, orientation);
            }
            Self::ConvexMesh { points, faces, radius } => {
                check.non_negative(*radius, "radius", "metres");
                mesh::check(&mut check, points, faces);
            }
        }
        check.finish()
    }
}

/// More heights are no model of what robots touch, but a mistake.
const MOST_HEIGHTS: usize = 250_000;

fn check_orientation(check: &mut Checker, orientation: &[f64; 4]) {
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

/// One of two that touch.
#[derive(Clone, Debug, PartialEq)]
pub enum Surface {
    /// That of a link's rod: sections are ellipses with their half extents; against rods they are round, with the larger one.
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
    /// A shape that is fixed to a link.
    Solid {
        /// The link, by its place among those of the robot.
        link: usize,
        /// Arc length from the base of the link's rod, in metres; `None` is the tip, or the base of a rigid link.
        at: Option<f64>,
        /// The shape, in the axes of the section or body there.
        shape: Obstacle,
    },
    /// What is fixed in the world.
    Obstacle(Obstacle),
}

impl Surface {
    /// The link that it is on.
    pub fn link(&self) -> Option<usize> {
        match self {
            Self::Rod { link } | Self::Ball { link, .. } | Self::Solid { link, .. } => Some(*link),
            Self::Obstacle(_) => None,
        }
    }

    /// The shape of what is neither a rod nor a ball.
    pub(crate) fn shape(&self) -> Option<&Obstacle> {
        match self {
            Self::Rod { .. } | Self::Ball { .. } => None,
            Self::Solid { shape, .. } | Self::Obstacle(shape) => Some(shape),
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
        if let Self::Ball { at: Some(x), .. } | Self::Solid { at: Some(x), .. } = self {
            let place_at = format!("{place}.at");
            if length > 0.0 {
                check_place(check, *x, &place_at, length);
            } else {
                check.require(false, &place_at, Number(*x), "none: the link has no rod");
            }
        }
        match self {
            Self::Solid { shape, .. } => {
                check.nested(place, shape.validate());
            }
            Self::Ball { position, radius, .. } => {
                check.finite(position, &format!("{place}.position"));
                check.positive(*radius, &format!("{place}.radius"), "metres");
            }
            _ => {
                let expected = "a link with a rod, or a Ball on it (or another shape)";
                check.require(length > 0.0, place, "a link without a rod", expected);
            }
        }
    }
}

/// A pair of surfaces that can touch: they press on each other where they overlap.
///
/// Along a rod they press with `f = k d max(0, 1 + c d')` a metre, where they overlap by d; a ball with as much at its point
/// (Hunt and Crossley 1975). Boxes, meshes and capsules press on half-spaces so with each
/// of their corners or ends, and on each other with these and the nearest places of their edges. Friction is `-mu f v / sqrt(|v|^2 + v_s^2)` with the
/// velocity v at which they slide.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    /// Its name in messages and results.
    pub name: String,
    /// The first one is not an obstacle.
    pub surfaces: [Surface; 2],
    /// k, in N/m^2 along rods, in N/m of balls and of each corner and edge of bodies; of rods that of their material
    /// where it is `None`.
    pub stiffness: Option<f64>,
    /// c, in s/m.
    pub dissipation: f64,
    /// mu of the first surface as it slides forward along its rod, backward, and sideways; of a ball all are the same.
    pub friction: [f64; 3],
    /// v_s, in m/s: what sticks creeps by less than that.
    pub slip_velocity: f64,
    /// r, in metres: friction resists spinning by up to the coefficient sideways, times the normal force, times r.
    pub patch_radius: f64,
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
            patch_radius: 0.0,
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
            "what moves: the name of a link with a rod, a Ball, or a shape on a link; obstacles come second",
        );
        if let (Some(shape), Some(other)) = (a.shape(), b.shape()) {
            check.require(
                shape.touches(other),
                "b",
                format_args!("{} for {}", other.name(), shape.name()),
                "a body: half-spaces and height fields touch rods, balls, spheres, capsules, boxes and meshes",
            );
        }
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
                    "N/m, > 0: what is rigid has no material",
                );
            }
        }
        check.non_negative(self.dissipation, "dissipation", "s/m");
        let [forward, backward, sideways] = self.friction;
        // NaN is even, too.
        let is_even = [backward, sideways].iter().all(|mu| mu.to_bits() == forward.to_bits());
        if is_even {
            check.non_negative(forward, "friction", "1");
        } else {
            for (mu, place) in [(forward, "forward"), (backward, "backward"), (sideways, "sideways")] {
                check.non_negative(mu, &format!("friction.{place}"), "1");
            }
        }
        check.require(
            is_even || matches!(a, Surface::Rod { .. }),
            "friction",
            "three coefficients",
            "one number: what is no rod slides alike in all directions",
        );
        check.positive(self.slip_velocity, "slip_velocity", "m/s");
        check.non_negative(self.patch_radius, "patch_radius", "metres");
        check.finish()
    }
}
