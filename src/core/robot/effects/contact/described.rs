//! Contacts as users describe them: surfaces are on links with these names.

pub use super::obstacles::described::{
    Capsule, ConvexMesh, Cuboid, DistanceGrid, HalfSpace, HeightField, Mesh, Sphere, Tube,
};
use super::obstacles::{Role, shapes};
use super::{Coefficients, Obstacle, Stiffness, Surface as Resolved};
use crate::description::schema::{
    Data, Described, Fault, Friction, Kind, Limits, LinkName, Part as _, PerAxis, Reader, Schema, Value,
};
use crate::error::Number;

/// Friction falls over at least that many slip velocities: below, the largest friction lies where it has begun to fall.
const LEAST_STRIBECK: f64 = 3.0;

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

macro_rules! surface {
    ($($Shape:ident in $file:ident,)*) => {
        /// One of the two surfaces of a contact.
        #[derive(Clone, Debug, PartialEq, Described)]
        pub enum Surface {
            /// The surface of a link's rod.
            Rod(LinkName),
            /// A ball on a link.
            Ball(Ball),
            $(
                #[doc = concat!("See [`", stringify!($Shape), "`].")]
                $Shape($Shape),
            )*
        }

        impl Surface {
            /// The link that carries it; `None` in the world.
            pub fn link(&self) -> Option<&LinkName> {
                match self {
                    Self::Rod(link) | Self::Ball(Ball { link, .. }) => Some(link),
                    $(Self::$Shape(shape) => shape.link.as_ref(),)*
                }
            }

            /// Its shape, the table of that, and the place along the link; `None` for rods and balls.
            fn shape(&self) -> Option<(Obstacle, &'static Schema, Option<f64>)> {
                match self {
                    Self::Rod(_) | Self::Ball(_) => None,
                    $(Self::$Shape(shape) => Some((shape.shape().into(), $Shape::SCHEMA, shape.at)),)*
                }
            }
        }

        impl Obstacle {
            /// The description of the shape, fixed to a link or to the world.
            fn described(self, link: Option<LinkName>, at: Option<f64>) -> Surface {
                match self {
                    $(Self::$Shape(shape) => shape.described(link, at).into(),)*
                }
            }
        }
    };
}
shapes!(surface);

impl Surface {
    /// Name within the default name of a contact: the link, or the class of the shape.
    fn word(&self) -> String {
        let class = || self.shape().map_or_else(String::new, |(_, schema, _)| schema.name.to_lowercase());
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
    /// sphere, capsule, box or convex mesh: these touch each other, half-spaces, height fields, tubes, distance grids and meshes, with their
    /// corners, edges or ends.
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
    /// Coefficient of friction mu. Three numbers are for a rod that slides forward along its axis, backward, and sideways. Two numbers
    /// are `static_friction` and mu: ``(0.6, 0.4)``. A table of stations and values is mu along the rod of `a`: stations are arc lengths
    /// from its start to its end, in metres, such as ``([0, 0.4, 0.5], [0.3, 0.3, 0.05])`` for a tip that is slippery.
    #[part(non_negative, default = Coefficients::NONE)]
    pub friction: Coefficients,
    /// Coefficient of friction at rest, mu_s, at least `friction`, which must be one number above zero then. Friction falls with the speed of sliding from
    /// mu_s to mu: ``mu + (mu_s - mu) exp(-(|v| / v_st)^2)`` (Bo and Pavelescu 1982). By default it is `friction`.
    #[part(positive)]
    pub static_friction: Option<f64>,
    /// Stribeck velocity v_st, over which friction falls from `static_friction`; at least 3 times `slip_velocity`. Steps that are to
    /// follow stick and slip must be short against the time in which this velocity is reached.
    #[part(unit = "m/s", positive, default = super::Contact::STRIBECK_VELOCITY)]
    pub stribeck_velocity: f64,
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
        if let (None, Coefficients::Even(friction)) = (self.static_friction, &mut self.friction) {
            self.static_friction = friction.at_rest.take();
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
        if let (Some((first, shape, _)), Some((second, other, _))) = (a.shape(), b.shape()) {
            reader.require(
                [first, second].iter().any(|shape| shape.shape().role() == Role::Body),
                "b",
                format_args!("{} for {}", other.called, shape.called),
                "a body: half-spaces, height fields, tubes, grids and meshes that are not convex touch rods, balls, spheres, capsules, boxes and \
                 convex meshes",
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
        match &self.friction {
            Coefficients::Even(friction) => self.friction_fits(friction, reader),
            Coefficients::Along(_) => {
                reader.require(
                    is_rod(a),
                    "friction",
                    "a table",
                    "a number: only the rod of a first surface, `a`, has places along it",
                );
                reader.require(
                    self.static_friction.is_none(),
                    "static_friction",
                    "a value beside a table of `friction`",
                    "none: `friction` is one number then",
                );
            }
        }
    }

    fn friction_fits(&self, friction: &Friction<3>, reader: &mut Reader) {
        let Friction { sliding: PerAxis([forward, backward, sideways]), at_rest: with_friction } = *friction;
        reader.require(
            with_friction.is_none(),
            "static_friction",
            "a value beside two of friction",
            "one of both: the first of two values of `friction` is that at rest",
        );
        // NaN is even, too.
        let is_even = [backward, sideways].iter().all(|mu| mu.to_bits() == forward.to_bits());
        reader.require(
            is_even || matches!(self.a, Surface::Rod(_)),
            "friction",
            "three coefficients",
            "one number: what is no rod slides alike in all directions",
        );
        if let Some(at_rest) = self.static_friction {
            reader.require(
                is_even && forward > 0.0 && at_rest >= forward,
                "static_friction",
                Number(at_rest),
                &format!("at least `friction`, one number above zero ({forward} forward, {backward} backward, {sideways} sideways)"),
            );
            reader.require(
                self.stribeck_velocity >= LEAST_STRIBECK * self.slip_velocity,
                "stribeck_velocity",
                Number(self.stribeck_velocity),
                &format!("{LEAST_STRIBECK} times `slip_velocity` or more: what creeps at {} m/s has not begun to slide", self.slip_velocity),
            );
        }
    }

    /// The contact of a robot; `link` gives the index of each link, by the place of its name in this description.
    /// `None` as soon as a link has no index.
    pub fn resolved(&self, mut link: impl FnMut(&str, &LinkName) -> Option<usize>) -> Option<super::Contact> {
        let a = self.a.resolved("a", &mut link);
        let b = self.b.resolved("b", &mut link);
        let (friction, friction_along) = match &self.friction {
            Coefficients::Even(friction) => (friction.sliding.0, None),
            Coefficients::Along(table) => ([0.0; 3], Some(table.clone())),
        };
        Some(super::Contact {
            name: self.name.clone(),
            surfaces: [a?, b?],
            stiffness: self.stiffness,
            dissipation: self.dissipation,
            friction,
            friction_along,
            static_friction: self.static_friction,
            stribeck_velocity: self.stribeck_velocity,
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
        let place_of_link = || format!("{place}.link");
        match self {
            Self::Rod(link) => return Some(Resolved::Rod { link: link_of(place, link)? }),
            Self::Ball(Ball { link, radius, at, position }) => {
                let link = link_of(&place_of_link(), link)?;
                return Some(Resolved::Ball { link, at: *at, position: *position, radius: *radius });
            }
            _ => {}
        }
        let (shape, _, at) = self.shape()?;
        Some(match self.link() {
            None => Resolved::Obstacle(shape),
            Some(link) => Resolved::Solid { link: link_of(&place_of_link(), link)?, at, shape },
        })
    }
}

impl super::Contact {
    /// The description of this contact, of a robot whose links have these names.
    pub fn described(&self, name: &dyn Fn(usize) -> LinkName) -> Contact {
        let [a, b] = self.surfaces.each_ref().map(|surface| surface.described(name));
        let friction = match &self.friction_along {
            Some(table) => Coefficients::Along(table.clone()),
            None => Coefficients::Even(Friction { sliding: PerAxis(self.friction), at_rest: None }),
        };
        Contact {
            a,
            b,
            stiffness: self.stiffness,
            dissipation: self.dissipation,
            friction,
            static_friction: self.static_friction,
            stribeck_velocity: self.stribeck_velocity,
            slip_velocity: self.slip_velocity,
            patch_radius: self.patch_radius,
            name: self.name.clone(),
        }
    }
}

impl Resolved {
    fn described(&self, name: &dyn Fn(usize) -> LinkName) -> Surface {
        match self {
            Self::Rod { link } => Surface::Rod(name(*link)),
            &Self::Ball { link, at, position, radius } => {
                Surface::Ball(Ball { link: name(link), radius, at, position })
            }
            Self::Solid { link, at, shape } => shape.clone().described(Some(name(*link)), *at),
            Self::Obstacle(shape) => shape.clone().described(None, None),
        }
    }
}
