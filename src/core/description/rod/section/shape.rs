//! Plane figures and their properties: area, second moments, torsion constant, shear correction.

use std::f64::consts::PI;

use super::along::validate_along;
use super::torsion;
use crate::description::rod::profile::{Profile, Variation};
use crate::error::{Checker, InvalidInput};

/// A figure about its centre, with sizes in metres along body y and z. Sizes are numbers at one point of a
/// rod, or profiles along a rod.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs, reason = "the sizes of plane figures")]
pub enum Shape<Size> {
    Circle {
        radius: Size,
    },
    HollowCircle {
        outer: Size,
        inner: Size,
    },
    /// Width along y, height along z.
    Rectangle {
        width: Size,
        height: Size,
    },
    Ellipse {
        semi_axis_y: Size,
        semi_axis_z: Size,
    },
}

impl<Size> Shape<Size> {
    /// Name in scenes.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Circle { .. } => "circle",
            Self::HollowCircle { .. } => "hollow_circle",
            Self::Rectangle { .. } => "rectangle",
            Self::Ellipse { .. } => "ellipse",
        }
    }

    fn is_hollow(&self) -> bool {
        matches!(self, Self::HollowCircle { .. })
    }

    /// Sizes with their names.
    pub fn sizes(&self) -> Vec<(&'static str, &Size)> {
        match self {
            Self::Circle { radius } => vec![("radius", radius)],
            Self::HollowCircle { outer, inner } => vec![("outer", outer), ("inner", inner)],
            Self::Rectangle { width, height } => vec![("width", width), ("height", height)],
            Self::Ellipse { semi_axis_y, semi_axis_z } => {
                vec![("semi_axis_y", semi_axis_y), ("semi_axis_z", semi_axis_z)]
            }
        }
    }

    /// The same figure with other sizes.
    pub fn map<Other>(&self, f: impl Fn(&Size) -> Other) -> Shape<Other> {
        match self {
            Self::Circle { radius } => Shape::Circle { radius: f(radius) },
            Self::HollowCircle { outer, inner } => Shape::HollowCircle { outer: f(outer), inner: f(inner) },
            Self::Rectangle { width, height } => Shape::Rectangle { width: f(width), height: f(height) },
            Self::Ellipse { semi_axis_y, semi_axis_z } => {
                Shape::Ellipse { semi_axis_y: f(semi_axis_y), semi_axis_z: f(semi_axis_z) }
            }
        }
    }
}

impl Shape<Profile<1>> {
    /// The figure at the fraction `x` in [0, 1] of the length from base to tip.
    pub fn at(&self, x: f64) -> Shape<f64> {
        self.map(|size| size.at(x)[0])
    }

    /// Whether the figure is constant.
    pub fn is_constant(&self) -> bool {
        self.sizes().iter().all(|(_, size)| size.is_constant())
    }

    /// Variations of the non-constant sizes.
    pub(crate) fn variations(&self) -> Vec<Variation<'_>> {
        self.sizes().into_iter().filter_map(|(_, size)| size.variation()).collect()
    }

    /// Reports every problem of the figure along a segment of this length.
    pub(crate) fn validate(&self, length: f64) -> Result<(), InvalidInput> {
        let mut check = Checker::new();
        for (name, size) in self.sizes() {
            check.nested(name, size.validate(length));
        }
        if self.sizes().iter().all(|(_, size)| size.ends().is_some()) {
            self.check_ends(&mut check);
        } else {
            check.all(validate_along(&self.variations(), length, |x| self.at(x).validate()));
        }
        check.finish()
    }

    /// Linear sizes are valid if they are valid at both ends.
    fn check_ends(&self, check: &mut Checker) {
        let ends = self.map(|size| size.ends().unwrap_or_default().map(|[size]| size));
        let is_hollow = ends.is_hollow();
        for (name, [base, tip]) in ends.sizes() {
            if base.to_bits() == tip.to_bits() {
                check_size(check, is_hollow, name, *base, name);
            } else {
                check_size(check, is_hollow, name, *base, &format!("{name}[0]"));
                check_size(check, is_hollow, name, *tip, &format!("{name}[1]"));
            }
        }
        if let Shape::HollowCircle { outer, inner } = ends {
            let is_inside = (0..2).all(|end| inner[end].is_nan() || inner[end] < outer[end]);
            check.require(is_inside, "inner", format_args!("{inner:?}"), INSIDE);
        }
    }
}

const INSIDE: &str = "less than the outer radius";

/// Reports an invalid size. The inner radius of a hollow circle may be zero.
fn check_size(check: &mut Checker, is_hollow: bool, name: &str, size: f64, place: &str) {
    match is_hollow && name == "inner" {
        true => check.non_negative(size, place, "metres"),
        false => check.positive(size, place, "metres"),
    };
}

impl Shape<f64> {
    /// Reports every problem of the figure.
    fn validate(&self) -> Result<(), InvalidInput> {
        let mut check = Checker::new();
        for (name, size) in self.sizes() {
            check_size(&mut check, self.is_hollow(), name, *size, name);
        }
        if let Self::HollowCircle { outer, inner } = *self {
            check.require(inner.is_nan() || inner < outer, "inner", inner, INSIDE);
        }
        check.finish()
    }

    /// Area A in m^2.
    pub fn area(&self) -> f64 {
        match *self {
            Self::Circle { radius } => PI * radius.powi(2),
            Self::HollowCircle { outer, inner } => PI * (outer - inner) * (outer + inner),
            Self::Rectangle { width, height } => width * height,
            Self::Ellipse { semi_axis_y, semi_axis_z } => PI * semi_axis_y * semi_axis_z,
        }
    }

    /// Area within the outline in m^2, including a hole.
    pub fn outline_area(&self) -> f64 {
        match *self {
            Self::HollowCircle { outer, .. } => PI * outer.powi(2),
            _ => self.area(),
        }
    }

    /// Second moments of area `I_y = int z^2 dA` and `I_z = int y^2 dA` in m^4, for bending about y and about
    /// z.
    pub fn second_moments(&self) -> [f64; 2] {
        match *self {
            Self::Circle { radius } => [PI * radius.powi(4) / 4.0; 2],
            Self::HollowCircle { outer, inner } => [self.area() * (outer.powi(2) + inner.powi(2)) / 4.0; 2],
            Self::Rectangle { width, height } => {
                [width * height.powi(3) / 12.0, height * width.powi(3) / 12.0]
            }
            Self::Ellipse { semi_axis_y, semi_axis_z } => {
                [self.area() * semi_axis_z.powi(2) / 4.0, self.area() * semi_axis_y.powi(2) / 4.0]
            }
        }
    }

    /// Saint-Venant's torsion constant J_t in m^4: the torsional stiffness is G J_t. Equal to the polar
    /// moment I_y + I_z for circles, and smaller for all other figures, whose sections warp.
    pub fn torsion_constant(&self) -> f64 {
        match *self {
            Self::Circle { .. } | Self::HollowCircle { .. } => {
                let [second_moment, _] = self.second_moments();
                2.0 * second_moment
            }
            Self::Rectangle { width, height } => torsion::rectangle(width, height),
            // Saint-Venant (1855), exact.
            Self::Ellipse { semi_axis_y: a, semi_axis_z: b } => {
                PI * a.powi(3) * b.powi(3) / (a.powi(2) + b.powi(2))
            }
        }
    }

    /// Cowper's shear correction factors for shear along y and along z at Poisson's ratio `poisson` (Cowper 1966,
    /// "The shear coefficient in Timoshenko's beam theory", Journal of Applied Mechanics 33, table 1).
    pub fn cowper(&self, poisson: f64) -> [f64; 2] {
        match *self {
            Self::Circle { .. } => [6.0 * (1.0 + poisson) / (7.0 + 6.0 * poisson); 2],
            Self::HollowCircle { outer, inner } => {
                let square = (inner / outer).powi(2);
                let sum = (1.0 + square).powi(2);
                let below = (7.0 + 6.0 * poisson) * sum + (20.0 + 12.0 * poisson) * square;
                [6.0 * (1.0 + poisson) * sum / below; 2]
            }
            Self::Rectangle { .. } => [10.0 * (1.0 + poisson) / (12.0 + 11.0 * poisson); 2],
            Self::Ellipse { semi_axis_y, semi_axis_z } => {
                // Factor from the axes along the shear force and perpendicular to it.
                let factor = |along: f64, across: f64| {
                    let (a, b) = (along.powi(2), across.powi(2));
                    let below =
                        (40.0 + 37.0 * poisson) * a * a + (16.0 + 10.0 * poisson) * a * b + poisson * b * b;
                    12.0 * (1.0 + poisson) * a * (3.0 * a + b) / below
                };
                [factor(semi_axis_y, semi_axis_z), factor(semi_axis_z, semi_axis_y)]
            }
        }
    }

    /// Half extents along y and along z, in metres.
    pub fn half_extents(&self) -> [f64; 2] {
        match *self {
            Self::Circle { radius } => [radius; 2],
            Self::HollowCircle { outer, .. } => [outer; 2],
            Self::Rectangle { width, height } => [width / 2.0, height / 2.0],
            Self::Ellipse { semi_axis_y, semi_axis_z } => [semi_axis_y, semi_axis_z],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::quadrature::Gauss;
    use super::*;

    fn ellipse(a: f64, b: f64) -> Shape<f64> {
        Shape::Ellipse { semi_axis_y: a, semi_axis_z: b }
    }

    fn assert_near(value: f64, wanted: f64, tolerance: f64, what: &str) {
        assert!((value - wanted).abs() <= tolerance * wanted.abs(), "{what}: {value}, not {wanted}");
    }

    /// Outer minus inner width along y at the height z, and the largest height: from the outline of the
    /// figure only.
    fn chord(shape: Shape<f64>, z: f64) -> [f64; 2] {
        let ellipse = |a: f64, b: f64| 2.0 * a * (1.0 - (z / b).powi(2)).max(0.0).sqrt();
        match shape {
            Shape::Circle { radius } => [ellipse(radius, radius), 0.0],
            Shape::HollowCircle { outer, inner } => [ellipse(outer, outer), ellipse(inner, inner)],
            Shape::Rectangle { width, .. } => [width, 0.0],
            Shape::Ellipse { semi_axis_y, semi_axis_z } => [ellipse(semi_axis_y, semi_axis_z), 0.0],
        }
    }

    #[test]
    fn moments_are_the_integrals_over_the_figure() {
        let shapes = [
            Shape::Circle { radius: 0.3 },
            Shape::HollowCircle { outer: 0.5, inner: 0.2 },
            Shape::Rectangle { width: 0.4, height: 0.9 },
            ellipse(0.7, 0.2),
        ];
        let gauss = Gauss::new(60);
        for shape in shapes {
            let [_, top] = shape.half_extents();
            let mut kinks = vec![0.0, top];
            if let Shape::HollowCircle { inner, .. } = shape {
                kinks.insert(1, inner);
            }
            let [mut area, mut second_y, mut second_z] = [0.0; 3];
            for ends in kinks.windows(2) {
                for (&node, &weight) in gauss.nodes.iter().zip(&gauss.weights) {
                    // z = from + (to - from) sin: the outline has a vertical tangent at the top.
                    let (angle, length) = (node * PI / 2.0, ends[1] - ends[0]);
                    let z = ends[0] + length * angle.sin();
                    let weight = 2.0 * weight * length * angle.cos() * PI / 2.0;
                    let [outer, inner] = chord(shape, z);
                    area += weight * (outer - inner);
                    second_y += weight * (outer - inner) * z * z;
                    second_z += weight * (outer.powi(3) - inner.powi(3)) / 12.0;
                }
            }
            assert_near(shape.area(), area, 1e-7, "area");
            assert_near(shape.second_moments()[0], second_y, 1e-7, "about y");
            assert_near(shape.second_moments()[1], second_z, 1e-7, "about z");
        }
    }

    #[test]
    fn a_figure_that_looks_like_another_has_its_constants() {
        let circle = Shape::Circle { radius: 0.3 };
        for other in [ellipse(0.3, 0.3), Shape::HollowCircle { outer: 0.3, inner: 0.0 }] {
            assert_near(other.area(), circle.area(), 1e-15, "area");
            assert_near(other.second_moments()[1], circle.second_moments()[0], 1e-15, "second moment");
            assert_near(other.torsion_constant(), circle.torsion_constant(), 1e-15, "torsion");
            for (own, wanted) in other.cowper(0.3).into_iter().zip(circle.cowper(0.3)) {
                assert_near(own, wanted, 1e-15, "shear");
            }
        }
    }

    #[test]
    fn shear_corrections_have_their_published_values_and_limits() {
        // Cowper 1966, table 2, at Poisson's ratio 0.3; a thin tube has 2 (1 + nu) / (4 + 3 nu).
        let rectangle = Shape::Rectangle { width: 1.0, height: 3.0 };
        assert_near(rectangle.cowper(0.0)[0], 5.0 / 6.0, 1e-15, "rectangle");
        assert_near(rectangle.cowper(0.3)[1], 0.850, 1e-3, "rectangle");
        assert_near(Shape::Circle { radius: 2.0 }.cowper(0.3)[0], 0.886, 1e-3, "circle");
        let tube = Shape::HollowCircle { outer: 1.0, inner: 1.0 - 1e-9 };
        assert_near(tube.cowper(0.3)[0], 2.0 * 1.3 / 4.9, 1e-9, "tube");
        // A thin ellipse along the force: beam theory with a parabolic shear flow over the chord gives 9/10.
        assert_near(ellipse(1.0, 1e-6).cowper(0.0)[0], 0.9, 1e-9, "ellipse");
    }
}
