//! Sections as users describe them.

use super::shape::Shape;
use crate::description::rod::profile::{Profile, Size};
use crate::description::schema::{Described, Reader};
use crate::error::Checker;

/// A plane figure with these sizes.
macro_rules! figure {
    ($(#[$meta:meta])* $Figure:ident, $tag:literal: $($(#[$size_meta:meta])* $size:ident),+) => {
        #[derive(Clone, Debug, PartialEq, Described)]
        #[part(base = "Section", nested, tag = $tag, tag_key = "shape", family = "a section", brief,
               complete = $Figure::complete, check = $Figure::fits)]
        $(#[$meta])*
        pub struct $Figure {
            $($(#[$size_meta])* pub $size: Size,)+
            /// Length of the segment. Required with callables.
            #[part(unit = "metres", positive, by_place)]
            pub length: Option<f64>,
        }

        impl $Figure {
            fn complete(&mut self) {
                self.length = needed(self.length, &self.section());
            }

            fn fits(&self, reader: &mut Reader) {
                check_along(&self.section(), self.length, reader);
            }

            fn section(&self) -> super::Section {
                super::Section::Shape(Shape::$Figure { $($size: self.$size.0.clone()),+ })
            }
        }
    };
}

figure! {
    /// A full circle.
    Circle, "circle":
    /// Radius.
    #[part(unit = "metres", positive)]
    radius
}

figure! {
    /// A tube with a circular section.
    HollowCircle, "hollow_circle":
    /// Outer radius.
    #[part(unit = "metres", positive)]
    outer,
    /// Inner radius.
    #[part(unit = "metres", non_negative)]
    inner
}

figure! {
    /// A rectangle.
    Rectangle, "rectangle":
    /// Side along body y.
    #[part(unit = "metres", positive)]
    width,
    /// Side along body z.
    #[part(unit = "metres", positive)]
    height
}

figure! {
    /// An ellipse.
    Ellipse, "ellipse":
    /// Semi-axis along body y.
    #[part(unit = "metres", positive)]
    semi_axis_y,
    /// Semi-axis along body z.
    #[part(unit = "metres", positive)]
    semi_axis_z
}

/// Given stiffness and inertia, for example of composites or of sections computed elsewhere.
///
/// The segment then takes neither moduli nor density. Each parameter may also be a function of the arc length X from the
/// segment's base: a table (stations, values), or in Python a callable (which requires `length`) or a `Profile`, with values
/// of these shapes.
#[derive(Clone, Debug, PartialEq, Described)]
#[part(base = "Section", nested, tag = "given", tag_key = "shape", family = "a section", brief, positional = 4,
       complete = Given::complete, check = Given::fits)]
pub struct Given {
    /// Stiffness per length in the order torsion, bend_y, bend_z, stretch, shear_y, shear_z: a symmetric matrix, or its
    /// diagonal. N m^2 between angular strains, N between linear ones, N m between one and another. It must be positive
    /// definite on the strains that have modes; entries of others do not matter.
    pub stiffness: Profile<36>,
    /// Mass per length.
    #[part(unit = "kg/m", positive)]
    pub mass: Profile<1>,
    /// Inertia tensor per length about the centre of mass, in the section's axes, or its diagonal.
    #[part(unit = "kg m", default = Profile::from([0.0; 9]))]
    pub inertia: Profile<9>,
    /// Centre of mass along body y and z, relative to the rod's axis.
    #[part(unit = "metres", default = Profile::from([0.0; 2]))]
    pub centre: Profile<2>,
    /// Length of the segment. Required with callables.
    #[part(unit = "metres", positive, by_place)]
    pub length: Option<f64>,
}

impl Given {
    fn complete(&mut self) {
        self.length = needed(self.length, &self.section());
    }

    fn fits(&self, reader: &mut Reader) {
        check_along(&self.section(), self.length, reader);
    }

    fn section(&self) -> super::Section {
        let Self { stiffness, mass, inertia, centre, .. } = self.clone();
        super::Section::Given(Box::new(super::GivenSection { stiffness, mass, inertia, centre }))
    }
}

fn is_length(length: f64) -> bool {
    length.is_finite() && length > 0.0
}

/// The length, if parameters are functions along it; an invalid length is kept to be reported.
fn needed(length: Option<f64>, section: &super::Section) -> Option<f64> {
    length.filter(|length| !is_length(*length) || section.varies())
}

/// Reports every problem along a segment of this length, or of that of the section's first table.
fn check_along(section: &super::Section, length: Option<f64>, reader: &mut Reader) {
    let of_table = || section.functions().iter().find_map(|stations| stations.last().copied());
    let length = length.or_else(of_table).unwrap_or(1.0);
    // An invalid length is reported by itself.
    if is_length(length) {
        let mut check = Checker::new();
        check.all(section.validate(length));
        reader.nested(check);
    }
}

/// Cross-section of a segment.
#[derive(Clone, Debug, PartialEq, Described)]
pub enum Section {
    /// A circle.
    Circle(Circle),
    /// A circle with a hole.
    HollowCircle(HollowCircle),
    /// A rectangle.
    Rectangle(Rectangle),
    /// An ellipse.
    Ellipse(Ellipse),
    /// Given stiffness and inertia.
    Given(Box<Given>),
}

impl Section {
    /// The section of a segment.
    pub fn resolved(&self) -> super::Section {
        match self {
            Self::Circle(circle) => circle.section(),
            Self::HollowCircle(tube) => tube.section(),
            Self::Rectangle(rectangle) => rectangle.section(),
            Self::Ellipse(ellipse) => ellipse.section(),
            Self::Given(given) => given.section(),
        }
    }

    /// Length of the segment over which its parameters are functions.
    pub fn length(&self) -> Option<f64> {
        match self {
            Self::Circle(Circle { length, .. })
            | Self::HollowCircle(HollowCircle { length, .. })
            | Self::Rectangle(Rectangle { length, .. })
            | Self::Ellipse(Ellipse { length, .. }) => *length,
            Self::Given(given) => given.length,
        }
    }
}

impl super::Section {
    /// The description of the section of a segment of this length.
    pub fn described(&self, length: f64) -> Section {
        let length = self.varies().then_some(length);
        let size = |size: &Profile<1>| Size(size.clone());
        match self {
            Self::Shape(Shape::Circle { radius }) => Circle { radius: size(radius), length }.into(),
            Self::Shape(Shape::HollowCircle { outer, inner }) => {
                HollowCircle { outer: size(outer), inner: size(inner), length }.into()
            }
            Self::Shape(Shape::Rectangle { width, height }) => {
                Rectangle { width: size(width), height: size(height), length }.into()
            }
            Self::Shape(Shape::Ellipse { semi_axis_y, semi_axis_z }) => {
                Ellipse { semi_axis_y: size(semi_axis_y), semi_axis_z: size(semi_axis_z), length }.into()
            }
            Self::Given(given) => {
                let super::GivenSection { stiffness, mass, inertia, centre } = (**given).clone();
                Box::new(Given { stiffness, mass, inertia, centre, length }).into()
            }
        }
    }
}
