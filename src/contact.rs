//! Contacts as plain data: surfaces of links and obstacles, and the forces between them.
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

/// A shape for contacts, fixed in the world or to a link, in the axes of the world or of the link.
#[derive(Clone, Debug, PartialEq)]
pub enum Obstacle {
    /// The half-space behind a plane.
    HalfSpace {
        /// A point of the plane, metres.
        point: [f64; 3],
        /// Outward normal; normalised on use.
        normal: [f64; 3],
    },
    /// A ball.
    Sphere {
        /// Metres.
        centre: [f64; 3],
        /// Metres.
        radius: f64,
    },
    /// All points within `radius` of a straight segment.
    Capsule {
        /// Ends of the segment, metres.
        ends: [[f64; 3]; 2],
        /// Metres.
        radius: f64,
    },
    /// A box with sharp edges.
    Cuboid {
        /// Centre, metres.
        centre: [f64; 3],
        /// Half the edge lengths along the axes of the box, metres.
        half_extents: [f64; 3],
        /// Orientation of these axes: unit quaternion (w, x, y, z).
        orientation: [f64; 4],
    },
    /// The region below a smooth surface over a rectangle: a natural cubic spline through heights in both
    /// directions, extended linearly beyond the rectangle.
    HeightField {
        /// Heights along the field's z axis, metres, in row-major order: neighbours along y are adjacent.
        heights: Vec<f64>,
        /// Number of heights along the x axis and along the y axis.
        shape: [usize; 2],
        /// Distance between neighbours along the x axis and along the y axis, metres.
        spacing: [f64; 2],
        /// Position of the first height's base point, metres.
        corner: [f64; 3],
        /// Orientation of the field's axes: unit quaternion (w, x, y, z).
        orientation: [f64; 4],
    },
    /// All points within `radius` of a convex polyhedron.
    ConvexMesh {
        /// Corners of the polyhedron, metres.
        points: Vec<[f64; 3]>,
        /// Triangles as indices of corners, in any order; together they enclose the polyhedron.
        faces: Vec<[usize; 3]>,
        /// Radius of the rounded edges, metres; zero means sharp edges.
        radius: f64,
    },
}

impl Obstacle {
    /// Whether contact is supported between two shapes, neither of which is a rod or a ball of a link: one
    /// must be a sphere or have corners.
    fn touches(&self, other: &Self) -> bool {
        let is_ball = |shape: &Self| matches!(shape, Self::Sphere { .. });
        [self, other].into_iter().any(|shape| is_ball(shape) || shape.has_corners())
    }

    /// Whether the shape has corners; the ends of a capsule count as corners.
    pub(crate) fn has_corners(&self) -> bool {
        matches!(self, Self::Capsule { .. } | Self::Cuboid { .. } | Self::ConvexMesh { .. })
    }

    /// Name in messages.
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

    /// Reports every problem of the shape.
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

/// Largest number of heights: more would be a mistake in the input rather than a model of terrain.
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

    /// Shape of the surface; `None` for rods and balls.
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
    /// k, in N/m^2 along rods, in N/m for balls and for each corner and edge of bodies; `None` takes the
    /// stiffness of the rod's material.
    pub stiffness: Option<f64>,
    /// c, in s/m.
    pub dissipation: f64,
    /// mu of the first surface for sliding forward along its rod, backward, and sideways; balls use one value
    /// for all three.
    pub friction: [f64; 3],
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

    /// A contact with the stiffness of the material and without friction.
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
