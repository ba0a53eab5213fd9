//! Contacts as users describe them: surfaces are on links with these names.

use super::{Obstacle, Stiffness, Surface as Resolved, mesh, tube};
use crate::description::schema::{
    Data, Described, Fault, Kind, Limits, LinkName, Part as _, PerAxis, Reader, Rows, Schema, Value,
};
use crate::error::Checker;

/// Largest number of heights: more would be a mistake in the input rather than a model of terrain.
const MOST_HEIGHTS: usize = 250_000;

/// Orientation of axes that are not turned.
const UNTURNED: [f64; 4] = [1.0, 0.0, 0.0, 0.0];

/// A shape with a link to which it may be fixed.
macro_rules! shape {
    ($(#[$meta:meta])* pub struct $Shape:ident { $($(#[$of_field:meta])* pub $field:ident: $Type:ty,)* }) => {
        #[derive(Clone, Debug, PartialEq, Described)]
        $(#[$meta])*
        #[part(family = "an obstacle", checked_later)]
        pub struct $Shape {
            $($(#[$of_field])* pub $field: $Type,)*
            /// Link to which the shape is fixed; by default the world. On a link, positions and orientations are in the axes
            /// of the section or body.
            pub link: Option<LinkName>,
            /// Arc length of the link's unstretched rod; by default the tip, or the base of a rigid link.
            #[part(unit = "metres", needs = "link")]
            pub at: Option<f64>,
        }
    };
}

shape! {
    /// A floor or a wall: the region behind a plane.
    #[part(tag = "half_space", called = "a half-space", positional = 2, check = HalfSpace::fits)]
    pub struct HalfSpace {
        /// A point on the plane.
        #[part(unit = "metres", default)]
        pub point: [f64; 3],
        /// Outward normal, pointing away from the solid. Its length does not matter.
        #[part(default = [0.0, 0.0, 1.0])]
        pub normal: [f64; 3],
    }
}

impl HalfSpace {
    fn fits(&self, reader: &mut Reader) {
        let expected = "a direction: away from what is filled";
        reader.require(self.normal != [0.0; 3], "normal", "(0, 0, 0)", expected);
    }
}

shape! {
    /// A sphere fixed in the world or to a link.
    #[part(tag = "sphere", called = "a sphere")]
    pub struct Sphere {
        /// Centre.
        #[part(unit = "metres")]
        pub centre: [f64; 3],
        /// Radius.
        #[part(unit = "metres", positive)]
        pub radius: f64,
    }
}

shape! {
    /// A capsule fixed in the world, such as a peg, bar or pipe: the points within a radius of a line segment.
    #[part(tag = "capsule", called = "a capsule", check = Capsule::fits)]
    pub struct Capsule {
        /// Start of the line segment.
        #[part(unit = "metres")]
        pub start: [f64; 3],
        /// End of the line segment.
        #[part(unit = "metres")]
        pub end: [f64; 3],
        /// Radius.
        #[part(unit = "metres", positive)]
        pub radius: f64,
    }
}

impl Capsule {
    fn fits(&self, reader: &mut Reader) {
        reader.require(self.start != self.end, "end", "the start", "another point; a ball is a Sphere");
    }
}

shape! {
    /// A box with sharp edges, fixed in the world or to a link.
    ///
    /// Against boxes, meshes and capsules its edges are rounded by 0.04 of half the thickness of the thinner body.
    #[part(name = "Box", tag = "box", called = "a box", positional = 3, check = Cuboid::fits)]
    pub struct Cuboid {
        /// Centre.
        #[part(unit = "metres")]
        pub centre: [f64; 3],
        /// Half the edge lengths.
        #[part(unit = "metres", positive)]
        pub half_extents: [f64; 3],
        /// Orientation of its axes: unit quaternion (w, x, y, z).
        #[part(default = UNTURNED)]
        pub orientation: [f64; 4],
    }
}

impl Cuboid {
    fn fits(&self, reader: &mut Reader) {
        reader.check_orientation(&self.orientation);
    }
}

shape! {
    /// Uneven ground: the region below a smooth surface that interpolates heights on a rectangular grid.
    ///
    /// The surface is the natural cubic spline through the heights in both directions, so forces vary smoothly along it. It is
    /// extended linearly beyond the grid. Steps in the heights make the spline overshoot.
    #[part(tag = "height_field", called = "a height field", positional = 4, check = HeightField::fits)]
    pub struct HeightField {
        /// Heights along the z axis in rows: two rows or more along the x axis, each of two numbers or more along the y axis.
        #[part(unit = "metres")]
        pub heights: Rows,
        /// Distance between neighbouring heights; two numbers for different spacings along x and y.
        #[part(unit = "metres", positive)]
        pub spacing: PerAxis<2>,
        /// Position of the first grid point, from which its height is measured.
        #[part(unit = "metres", default)]
        pub corner: [f64; 3],
        /// Orientation of its axes: unit quaternion (w, x, y, z).
        #[part(default = UNTURNED)]
        pub orientation: [f64; 4],
    }
}

impl HeightField {
    fn fits(&self, reader: &mut Reader) {
        let Rows { numbers, shape: [rows, columns] } = &self.heights;
        let is_grid = *rows.min(columns) >= 2 && rows.checked_mul(*columns) == Some(numbers.len());
        reader.require(
            is_grid && numbers.len() <= MOST_HEIGHTS,
            "heights",
            format_args!("{} numbers in {rows} rows of {columns}", numbers.len()),
            &format!("two or more along each axis, and at most {MOST_HEIGHTS} in all"),
        );
        reader.check_orientation(&self.orientation);
    }
}

shape! {
    /// A convex body with flat faces, rounded by a radius.
    #[part(tag = "convex_mesh", called = "a convex mesh", positional = 3, check = ConvexMesh::fits)]
    pub struct ConvexMesh {
        /// Corners, 4 to 2000. Every corner belongs to a face.
        #[part(unit = "metres")]
        pub points: Vec<[f64; 3]>,
        /// Triangles, as indices into `points` (from 0) in any order. They must enclose the body.
        pub faces: Vec<[usize; 3]>,
        /// Rounding radius. The body grows by this radius on all sides.
        #[part(unit = "metres", non_negative, default = 0.0)]
        pub radius: f64,
    }
}

impl ConvexMesh {
    fn fits(&self, reader: &mut Reader) {
        let mut check = Checker::new();
        mesh::check(&mut check, &self.points, &self.faces);
        reader.nested(check);
    }
}

shape! {
    /// A tube with open ends: a vessel, a pipe, a guide or a ring, in which rods and balls are, or outside of it.
    ///
    /// The centre line is a smooth curve through the points, the cubic spline over the lengths of the chords between them; two
    /// points are a straight tube, and a short one is a ring, or the hole of a guide. Beyond its ends, whose planes are across the centre
    /// line, there is no wall; rods may leave through them, and touch their rims. A closed end is a `HalfSpace` across the tube, in a contact
    /// of its own. Rods and balls must be thinner than the bore, and round; what starts deep in the wall is refused, as with other shapes.
    #[part(tag = "tube", called = "a tube", check = Tube::fits)]
    pub struct Tube {
        /// Points of the centre line, 2 to 1000, from one end to the other.
        #[part(unit = "metres")]
        pub points: Vec<[f64; 3]>,
        /// Radius of the bore. It must be smaller than the radius at which the centre line bends, and than half of the way
        /// between places where the tube comes back to itself.
        #[part(unit = "metres", positive)]
        pub radius: f64,
        /// Thickness of the wall, by default the radius. What is pushed further than half of it leaves through the other side.
        #[part(unit = "metres", positive)]
        pub wall: Option<f64>,
    }
}

impl Tube {
    fn fits(&self, reader: &mut Reader) {
        let mut check = Checker::new();
        tube::check(&mut check, &self.points, self.radius);
        reader.nested(check);
    }
}

/// A ball fixed to a link, such as a finger tip, a sliding wheel or the outline of a body.
///
/// It has no mass; add a `Body` for that.
#[derive(Clone, Debug, PartialEq, Described)]
#[part(called = "a ball on a link", checked_later)]
pub struct Ball {
    /// Name of the link.
    pub link: LinkName,
    /// Radius.
    #[part(unit = "metres", positive)]
    pub radius: f64,
    /// Arc length of the link's unstretched rod; by default the tip, or the base of a rigid link.
    #[part(unit = "metres")]
    pub at: Option<f64>,
    /// Centre of the ball in the axes of the section or body.
    #[part(unit = "metres", default)]
    pub position: [f64; 3],
}

/// One of the two surfaces of a contact.
#[derive(Clone, Debug, PartialEq, Described)]
pub enum Surface {
    /// The surface of a link's rod.
    Rod(LinkName),
    /// A ball on a link.
    Ball(Ball),
    /// A plane.
    HalfSpace(HalfSpace),
    /// A sphere.
    Sphere(Sphere),
    /// A capsule.
    Capsule(Capsule),
    /// A box.
    Box(Cuboid),
    /// Uneven ground.
    HeightField(HeightField),
    /// A convex body.
    ConvexMesh(ConvexMesh),
    /// The wall of a tube.
    Tube(Tube),
}

impl Surface {
    /// The link that carries it; `None` in the world.
    pub fn link(&self) -> Option<&LinkName> {
        match self {
            Self::Rod(link) | Self::Ball(Ball { link, .. }) => Some(link),
            Self::HalfSpace(HalfSpace { link, .. })
            | Self::Sphere(Sphere { link, .. })
            | Self::Capsule(Capsule { link, .. })
            | Self::Box(Cuboid { link, .. })
            | Self::HeightField(HeightField { link, .. })
            | Self::ConvexMesh(ConvexMesh { link, .. })
            | Self::Tube(Tube { link, .. }) => link.as_ref(),
        }
    }

    /// The table of the shape; `None` for rods and balls.
    fn schema(&self) -> Option<&'static Schema> {
        match self {
            Self::Rod(_) | Self::Ball(_) => None,
            Self::HalfSpace(_) => Some(HalfSpace::SCHEMA),
            Self::Sphere(_) => Some(Sphere::SCHEMA),
            Self::Capsule(_) => Some(Capsule::SCHEMA),
            Self::Box(_) => Some(Cuboid::SCHEMA),
            Self::HeightField(_) => Some(HeightField::SCHEMA),
            Self::ConvexMesh(_) => Some(ConvexMesh::SCHEMA),
            Self::Tube(_) => Some(Tube::SCHEMA),
        }
    }

    /// Name within the default name of a contact: the link, or the class of the shape.
    fn word(&self) -> String {
        let class = || self.schema().map_or_else(String::new, |schema| schema.name.to_lowercase());
        self.link().map_or_else(class, |LinkName(link)| link.clone())
    }
}

/// A pair of surfaces that can touch.
///
/// Where the surfaces overlap by d, they press on each other with ``f = k d max(0, 1 + c d')`` (Hunt and Crossley 1975), in
/// newtons per metre along a rod, or in newtons if neither surface is a rod. Friction is ``-mu f v / sqrt(|v|^2 + v_s^2)``
/// with the sliding velocity v. The page "Contact" of the documentation explains how these constants affect step sizes and
/// accuracy.
#[derive(Clone, Debug, PartialEq, Described)]
#[part(complete = Contact::complete, check = Contact::fits, example = include_str!("example.txt"))]
pub struct Contact {
    /// The moving surface: a ball, a shape with a `link`, or the name of a link for the surface of its rod ("rod" for the
    /// only rod of a scene). The rod's sections are ellipses with its two half extents.
    pub a: Surface,
    /// The other surface, on another link or in the world. The name of the same link means self-contact of its rod; places
    /// closer than about three diameters along the rod are left out. If both surfaces are shapes, one of them must be a
    /// sphere, capsule, box or convex mesh: these touch each other, half-spaces, height fields and tubes, with their corners,
    /// edges or ends.
    pub b: Surface,
    /// Stiffness k. With a rod per metre of overlap and per metre of rod. "material" is that of the rods' material,
    /// ``pi/4 E / (1 - nu^2)`` (Popov 2010, eq. 5.33). The default is that, too, but no more than keeps the overlap at an edge
    /// to 15 % of the radius, and to 5e-4 of the rod's length, under all that the robot can press with: its weight, its loads,
    /// and what bends its rods (`Robot.explain` prints the number). Required without a rod; boxes, meshes and capsules have it
    /// at each corner, end and edge that touches.
    #[part(unit = "N/m^2 with a rod, otherwise N/m", positive)]
    pub stiffness: Option<Stiffness>,
    /// Dissipation c. The rebound speed after a slow impact at the speed v is ``v (1 - 2 c v / 3)``.
    #[part(unit = "s/m", non_negative, default = super::Contact::DISSIPATION)]
    pub dissipation: f64,
    /// Coefficient of friction mu. Three numbers are for a rod that slides forward along its axis, backward, and sideways.
    #[part(non_negative, default = PerAxis([0.0; 3]))]
    pub friction: PerAxis<3>,
    /// Velocity v_s. Sticking contacts creep at up to about this speed.
    #[part(unit = "m/s", positive, default = super::Contact::SLIP_VELOCITY)]
    pub slip_velocity: f64,
    /// Radius r of the contact patch. Friction then also resists spinning, with the torque
    /// ``-mu f r w / sqrt(w^2 + (v_s/r)^2)``, where w is the angular velocity about the normal and mu the sideways
    /// coefficient. Zero means no such resistance.
    #[part(unit = "metres", non_negative, default = 0.0)]
    pub patch_radius: f64,
    /// Name in messages and results. By default made of the surfaces, such as "rod on halfspace"; robots number equal
    /// default names: "rod on halfspace 2".
    #[part(default)]
    pub name: String,
}

impl Data for Stiffness {
    const KIND: Kind =
        Kind::OneOf("ContactStiffness", &[Kind::Number, Kind::Word("ContactRule", &["material"])]);

    fn read(value: &Value, reader: &mut Reader) -> Option<Self> {
        match value {
            Value::Number(_) | Value::Integer(_) => f64::read(value, reader).map(Self::Given),
            Value::Text(word) if word == "material" => Some(Self::Material),
            _ => reader.wrong_type(value, &Self::KIND),
        }
    }

    fn check(&self, limits: &Limits, reader: &mut Reader) {
        if let Self::Given(stiffness) = self {
            stiffness.check(limits, reader);
        }
    }

    fn write(&self) -> Value {
        match self {
            Self::Given(stiffness) => stiffness.write(),
            Self::Material => Value::Text("material".to_owned()),
        }
    }
}

impl Contact {
    /// The name that it has by default.
    pub fn default_name(&self) -> String {
        format!("{} on {}", self.a.word(), self.b.word())
    }

    /// Whether its name is the one that it has by default.
    pub fn has_default_name(&self) -> bool {
        self.name == self.default_name()
    }

    fn complete(&mut self) {
        if self.name.is_empty() {
            self.name = self.default_name();
        }
    }

    fn fits(&self, reader: &mut Reader) {
        let Self { a, b, .. } = self;
        reader.require(
            a.link().is_some(),
            "a",
            "an obstacle",
            "what moves: the name of a link with a rod, a Ball, or a shape on a link; obstacles come second",
        );
        if let (Some(shape), Some(other)) = (a.schema(), b.schema()) {
            let is_body = |surface: &Surface| {
                !matches!(surface, Surface::HalfSpace(_) | Surface::HeightField(_) | Surface::Tube(_))
            };
            reader.require(
                is_body(a) || is_body(b),
                "b",
                format_args!("{} for {}", other.called, shape.called),
                "a body: half-spaces, height fields and tubes touch rods, balls, spheres, capsules, boxes and meshes",
            );
        }
        let is_rod = |surface: &Surface| matches!(surface, Surface::Rod(_));
        reader.require(
            a.link().is_none() || a.link() != b.link() || (is_rod(a) && is_rod(b)),
            "b",
            "another surface of the same link",
            "a surface of another link, or of a rod with itself",
        );
        if !matches!(self.stiffness, Some(Stiffness::Given(_))) && !is_rod(a) && !is_rod(b) {
            let advice = " in N/m: only rods have one of their own, that of their material".to_owned();
            reader.refuse("", Fault::Missing { key: "stiffness", advice });
        }
        let PerAxis([forward, backward, sideways]) = self.friction;
        // NaN is even, too.
        let is_even = [backward, sideways].iter().all(|mu| mu.to_bits() == forward.to_bits());
        reader.require(
            is_even || is_rod(a),
            "friction",
            "three coefficients",
            "one number: what is no rod slides alike in all directions",
        );
    }

    /// The contact of a robot; `link` gives the index of each link, by the place of its name in this description.
    /// `None` as soon as a link has no index.
    pub fn resolved(&self, mut link: impl FnMut(&str, &LinkName) -> Option<usize>) -> Option<super::Contact> {
        let a = self.a.resolved("a", &mut link);
        let b = self.b.resolved("b", &mut link);
        Some(super::Contact {
            name: self.name.clone(),
            surfaces: [a?, b?],
            stiffness: self.stiffness,
            dissipation: self.dissipation,
            friction: self.friction.0,
            slip_velocity: self.slip_velocity,
            patch_radius: self.patch_radius,
        })
    }
}

impl Surface {
    fn resolved(
        &self,
        place: &str,
        link_of: &mut impl FnMut(&str, &LinkName) -> Option<usize>,
    ) -> Option<Resolved> {
        let (shape, at) = match self.clone() {
            Self::Rod(link) => return Some(Resolved::Rod { link: link_of(place, &link)? }),
            Self::Ball(Ball { link, radius, at, position }) => {
                let link = link_of(&format!("{place}.link"), &link)?;
                return Some(Resolved::Ball { link, at, position, radius });
            }
            Self::HalfSpace(HalfSpace { point, normal, at, .. }) => {
                (Obstacle::HalfSpace { point, normal }, at)
            }
            Self::Sphere(Sphere { centre, radius, at, .. }) => (Obstacle::Sphere { centre, radius }, at),
            Self::Capsule(Capsule { start, end, radius, at, .. }) => {
                (Obstacle::Capsule { ends: [start, end], radius }, at)
            }
            Self::Box(Cuboid { centre, half_extents, orientation, at, .. }) => {
                (Obstacle::Cuboid { centre, half_extents, orientation }, at)
            }
            Self::HeightField(HeightField { heights, spacing, corner, orientation, at, .. }) => {
                let Rows { numbers: heights, shape } = heights;
                (Obstacle::HeightField { heights, shape, spacing: spacing.0, corner, orientation }, at)
            }
            Self::ConvexMesh(ConvexMesh { points, faces, radius, at, .. }) => {
                (Obstacle::ConvexMesh { points, faces, radius }, at)
            }
            Self::Tube(Tube { points, radius, wall, at, .. }) => {
                (Obstacle::Tube { points, radius, wall }, at)
            }
        };
        Some(match self.link() {
            None => Resolved::Obstacle(shape),
            Some(link) => Resolved::Solid { link: link_of(&format!("{place}.link"), link)?, at, shape },
        })
    }
}

impl super::Contact {
    /// The description of this contact, of a robot whose links have these names.
    pub fn described(&self, name: &dyn Fn(usize) -> LinkName) -> Contact {
        let [a, b] = self.surfaces.each_ref().map(|surface| surface.described(name));
        Contact {
            a,
            b,
            stiffness: self.stiffness,
            dissipation: self.dissipation,
            friction: PerAxis(self.friction),
            slip_velocity: self.slip_velocity,
            patch_radius: self.patch_radius,
            name: self.name.clone(),
        }
    }
}

impl Resolved {
    fn described(&self, name: &dyn Fn(usize) -> LinkName) -> Surface {
        let (shape, link, at) = match self {
            Self::Rod { link } => return Surface::Rod(name(*link)),
            &Self::Ball { link, at, position, radius } => {
                return Surface::Ball(Ball { link: name(link), radius, at, position });
            }
            Self::Solid { link, at, shape } => (shape, Some(name(*link)), *at),
            Self::Obstacle(shape) => (shape, None, None),
        };
        match shape.clone() {
            Obstacle::HalfSpace { point, normal } => HalfSpace { point, normal, link, at }.into(),
            Obstacle::Sphere { centre, radius } => Sphere { centre, radius, link, at }.into(),
            Obstacle::Capsule { ends: [start, end], radius } => {
                Capsule { start, end, radius, link, at }.into()
            }
            Obstacle::Cuboid { centre, half_extents, orientation } => {
                Cuboid { centre, half_extents, orientation, link, at }.into()
            }
            Obstacle::HeightField { heights, shape, spacing, corner, orientation } => {
                let heights = Rows { numbers: heights, shape };
                HeightField { heights, spacing: PerAxis(spacing), corner, orientation, link, at }.into()
            }
            Obstacle::ConvexMesh { points, faces, radius } => {
                ConvexMesh { points, faces, radius, link, at }.into()
            }
            Obstacle::Tube { points, radius, wall } => Tube { points, radius, wall, link, at }.into(),
        }
    }
}
