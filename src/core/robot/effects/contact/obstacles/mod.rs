//! Shapes that rods, balls and bodies touch: one file each with its description, its checks, and its implementation of `Shape`.
//!
//! A new shape is a file here, its line in the list below, and its `Solid`, which has its distances.

mod capsule;
mod closed;
mod convex_mesh;
mod convexity;
mod corners;
mod cuboid;
mod distance_grid;
mod frame;
mod given_triangles;
mod half_space;
mod height_field;
mod mesh;
mod recent;
mod sphere;
mod tube;

pub(crate) use self::corners::{Core, Cornered};
pub(crate) use self::frame::Frame;
pub use self::tube::centre_line;
use crate::robot::effects::contact::shapes::obstacle::Solid;

/// A shape, as contacts use it.
pub(crate) trait Shape {
    /// Its name in explanations.
    fn label(&self) -> String;

    /// By how much its edges are rounded at most, metres, if that depends on how it is computed.
    fn rounding(&self) -> Option<f64> {
        None
    }

    /// Whether it is symmetric about the plane at this height across an axis, and exerts forces only within that plane.
    fn lies_across(&self, axis: usize, height: f64) -> bool;

    /// Distance from its middle to its surface, metres; infinite for unbounded solids.
    fn thickness(&self) -> f64;

    /// The shape in the axes in which it is computed.
    fn solid(&self, frame: &Frame) -> Solid;

    /// Its corners, if it touches other bodies with them; the ends of a capsule count as corners.
    fn corners(&self) -> Option<&dyn Cornered>;

    /// Its role in contacts with bodies.
    fn role(&self) -> Role;
}

/// Role of a shape in contacts with bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    /// Another body.
    Body,
    /// A plane, which a body touches first with its corners.
    Plane,
    /// Uneven ground or a wall, which places between corners may touch first.
    Ground,
}

/// Makes of a shape its data, and a description with a link to which it may be fixed.
macro_rules! shape {
    (
        $(#[doc = $text:literal])*
        #[part($($option:tt)*)]
        pub struct $Shape:ident {$(
            $(#[doc = $of_field:literal])*
            $(#[part($($limit:tt)*)])?
            pub $field:ident: $Type:ty,
        )*}
    ) => {
        $(#[doc = $text])*
        #[derive(Clone, Debug, PartialEq)]
        pub struct $Shape {
            $($(#[doc = $of_field])* pub $field: $Type,)*
        }

        impl $Shape {
            /// Its description, fixed to a link or to the world.
            pub(crate) fn described(
                self,
                link: Option<crate::description::schema::LinkName>,
                at: Option<f64>,
            ) -> described::$Shape {
                described::$Shape { $($field: self.$field,)* link, at }
            }
        }

        /// As users describe it.
        pub(crate) mod described {
            #[allow(unused_imports, reason = "types of fields are named where the shape is")]
            use super::*;
            use crate::description::schema::{Described, LinkName, Reader};

            $(#[doc = $text])*
            #[derive(Clone, Debug, PartialEq, Described)]
            #[part(family = "an obstacle", checked_later, check = $Shape::fits, $($option)*)]
            pub struct $Shape {
                $($(#[doc = $of_field])* $(#[part($($limit)*)])? pub $field: $Type,)*
                /// Link to which the shape is fixed; by default the world. On a link, positions and orientations are in the axes
                /// of the section or body.
                pub link: Option<LinkName>,
                /// Arc length of the link's unstretched rod; by default the tip, or the base of a rigid link.
                #[part(unit = "metres", needs = "link")]
                pub at: Option<f64>,
            }

            impl $Shape {
                /// The shape alone.
                pub(crate) fn shape(&self) -> super::$Shape {
                    super::$Shape { $($field: self.$field.clone(),)* }
                }

                fn fits(&self, reader: &mut Reader) {
                    self.shape().fits(reader);
                }
            }
        }
    };
}
use shape;

/// Calls a macro with all shapes and their files.
macro_rules! shapes {
    ($make:ident) => {
        $make! {
            HalfSpace in half_space,
            Sphere in sphere,
            Capsule in capsule,
            Cuboid in cuboid,
            HeightField in height_field,
            ConvexMesh in convex_mesh,
            Tube in tube,
            DistanceGrid in distance_grid,
            Mesh in mesh,
        }
    };
}
pub(super) use shapes;

macro_rules! obstacle {
    ($($Shape:ident in $file:ident,)*) => {
        $(pub use self::$file::$Shape;)*

        /// Shapes as users describe them, with links to which they may be fixed.
        pub(crate) mod described {
            $(pub use super::$file::described::$Shape;)*
        }

        /// A shape for contacts, fixed in the world or to a link, in the axes of the world or of the link.
        #[derive(Clone, Debug, PartialEq)]
        pub enum Obstacle {
            $(
                #[doc = concat!("See [`", stringify!($Shape), "`].")]
                $Shape($Shape),
            )*
        }

        $(impl From<$Shape> for Obstacle {
            fn from(shape: $Shape) -> Self {
                Self::$Shape(shape)
            }
        })*

        impl Obstacle {
            /// The shape as contacts use it.
            pub(crate) fn shape(&self) -> &dyn Shape {
                match self {
                    $(Self::$Shape(shape) => shape,)*
                }
            }
        }
    };
}
shapes!(obstacle);
