//! Bodies as users describe them: on links with these names, where scenes do not say it by their place.

use super::{Hull, check_inertia};
use crate::description::schema::{Described, LinkName, Reader};
use crate::error::Checker;

/// A rigid body fixed to a section of a rod.
#[derive(Clone, Debug, PartialEq, Described)]
#[part(brief, check = Body::fits, example = include_str!("example.txt"))]
pub struct Body {
    /// Mass.
    #[part(unit = "kilograms", non_negative)]
    pub mass: f64,
    /// Arc length of the unstretched rod at which the body is fixed; by default the tip.
    #[part(arc_length)]
    pub at: Option<f64>,
    /// Centre of mass relative to the section's centre, in the section's axes.
    #[part(unit = "metres", default)]
    pub centre: [f64; 3],
    /// Inertia tensor about the centre of mass in the section's axes, or its three principal moments where these are the principal axes; by
    /// default zero, a point.
    #[part(unit = "kg m^2", default)]
    pub inertia: [[f64; 3]; 3],
    /// Link of a `Robot` to which the body is fixed, unless the body belongs to a `Link` itself.
    #[part(by_place)]
    pub link: Option<LinkName>,
    /// Displaced volume, for buoyancy and added mass in the fluid of the rod or robot. By default zero: the fluid exerts neither.
    #[part(unit = "m^3", non_negative, default = Hull::none().volume)]
    pub volume: f64,
    /// Centre of the volume, where the fluid acts, in the axes of `centre`; by default `centre`.
    #[part(unit = "metres")]
    pub centre_of_volume: Option<[f64; 3]>,
    /// Added mass over the displaced mass, the same in all directions; by default that of a sphere in an inviscid fluid.
    #[part(non_negative, default = Hull::none().added_mass_coefficient)]
    pub added_mass_coefficient: f64,
    /// Reference area A of the quadratic drag ``density / 2 * drag_coefficient * A * |v| * v``.
    #[part(unit = "m^2", non_negative, default = Hull::none().drag_area)]
    pub drag_area: f64,
    /// Coefficient of the quadratic drag.
    #[part(non_negative, default = Hull::none().drag_coefficient)]
    pub drag_coefficient: f64,
    /// Drag over velocity; ``6 * pi * viscosity * radius`` for a small sphere (Stokes 1851).
    #[part(unit = "N s/m", non_negative, default = Hull::none().viscous_drag)]
    pub viscous_drag: f64,
}

impl Body {
    fn fits(&self, reader: &mut Reader) {
        // Numbers that are not finite are reported by themselves.
        if self.inertia.as_flattened().iter().all(|entry| entry.is_finite()) {
            let mut check = Checker::new();
            check_inertia(&mut check, &self.inertia);
            reader.nested(check);
        }
        let has_inertia = self.inertia != [[0.0; 3]; 3];
        let expected = "a number > 0 (kilograms): what has inertia has mass; that of a rotor is an armature";
        reader.require(self.mass != 0.0 || !has_inertia, "mass", "0 with an inertia", expected);
    }

    /// The body of a robot on a link with this index.
    pub fn resolved(&self, link: usize) -> super::Body {
        let hull = Hull {
            volume: self.volume,
            centre: self.centre_of_volume,
            added_mass_coefficient: self.added_mass_coefficient,
            drag_area: self.drag_area,
            drag_coefficient: self.drag_coefficient,
            viscous_drag: self.viscous_drag,
        };
        let Self { at, mass, centre, inertia, .. } = *self;
        super::Body { link, at, mass, centre, inertia, hull: hull.unless_none() }
    }
}

impl super::Body {
    /// The description of this body.
    pub fn described(&self, link: Option<LinkName>) -> Body {
        let hull = self.hull.unwrap_or_else(Hull::none);
        Body {
            mass: self.mass,
            at: self.at,
            centre: self.centre,
            inertia: self.inertia,
            link,
            volume: hull.volume,
            centre_of_volume: hull.centre,
            added_mass_coefficient: hull.added_mass_coefficient,
            drag_area: hull.drag_area,
            drag_coefficient: hull.drag_coefficient,
            viscous_drag: hull.viscous_drag,
        }
    }
}
