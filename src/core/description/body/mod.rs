//! Rigid bodies attached to a rod as robots hold them, with indices of links. [`described`] is what users describe.
//!
//! ```
//! use lissom::body::Body;
//!
//! let camera = Body { at: Some(0.2), ..Body::point(0.01) };
//! assert!(camera.validate(0.3).is_ok());
//! assert!(camera.validate(0.1).is_err());
//! ```

pub mod described;

use nalgebra::Matrix3;

use crate::description::rod::arc_length::check_end;
use crate::description::schema::Item as _;
use crate::error::{Checker, InvalidInput, Number};

/// Tolerated violation of symmetry and of the inequalities of principal moments, relative to the largest
/// entry of an inertia tensor: rounding errors of the input.
const INERTIA_TOLERANCE: f64 = 1e-9;

/// A rigid body fixed to a section of the rod.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Index of the link in the robot; 0 for a rod.
    pub link: usize,
    /// Arc length from the base to the section that carries the body, in metres; `None` is the tip.
    pub at: Option<f64>,
    /// Mass in kilograms.
    pub mass: f64,
    /// Centre of mass relative to the section's centre, in the section's axes, in metres.
    pub centre: [f64; 3],
    /// Inertia tensor about the centre of mass, in the section's axes, in kg m^2: rows of a symmetric matrix.
    pub inertia: [[f64; 3]; 3],
    /// The outside on which the fluid around the robot acts; `None` if it does not act on the body.
    pub hull: Option<Hull>,
}

/// The outside of a body in a fluid of density rho, the same in all directions. With the velocity v of the centre of
/// the volume V relative to the fluid, and the gravity g, the fluid exerts at that centre
///
/// ```text
/// - rho V g                       buoyancy (Archimedes), unless the fluid has none
/// - d/dt (C_a rho V v)            added mass (Lamb 1932, section 92)
/// - 1/2 rho C_d A |v| v - c v     quadratic and viscous drag
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hull {
    /// Displaced volume V in m^3.
    pub volume: f64,
    /// Centre of the volume relative to the section's centre, in the section's axes, in metres; `None` is the centre
    /// of mass.
    pub centre: Option<[f64; 3]>,
    /// Coefficient C_a of the added mass.
    pub added_mass_coefficient: f64,
    /// Reference area A of the quadratic drag in m^2.
    pub drag_area: f64,
    /// Coefficient C_d of the quadratic drag.
    pub drag_coefficient: f64,
    /// Viscous drag c in N s/m.
    pub viscous_drag: f64,
}

impl Hull {
    /// A start for `..` syntax: no volume and no drag. The added mass is that of a sphere in an inviscid fluid, half
    /// the displaced mass; the drag area is one of coefficient one.
    pub fn none() -> Self {
        Self {
            volume: 0.0,
            centre: None,
            added_mass_coefficient: 0.5,
            drag_area: 0.0,
            drag_coefficient: 1.0,
            viscous_drag: 0.0,
        }
    }

    /// The hull, unless the fluid does not act on it.
    pub fn unless_none(self) -> Option<Self> {
        (self.volume != 0.0 || self.drag_area != 0.0 || self.viscous_drag != 0.0).then_some(self)
    }
}

impl Body {
    /// Point mass at the tip.
    pub fn point(mass: f64) -> Self {
        Self { link: 0, at: None, mass, centre: [0.0; 3], inertia: [[0.0; 3]; 3], hull: None }
    }

    /// Reports every problem of this body on a rod of this length (infinite if not known yet).
    pub fn validate(&self, length: f64) -> Result<(), InvalidInput> {
        let mut check = Checker::new();
        check.all(self.described(None).validate());
        if let Some(x) = self.at {
            check_end(&mut check, x, "at", length);
        }
        check.finish()
    }

    /// Root mean square distance of the mass from its centre, in metres; zero without a mass.
    pub(crate) fn radius_of_gyration(&self) -> f64 {
        let trace: f64 = (0..3).map(|i| self.inertia[i][i]).sum();
        if self.mass > 0.0 { (0.5 * trace / self.mass).sqrt() } else { 0.0 }
    }

    /// Distance of its mass from the section's centre, about, in metres.
    pub(crate) fn extent(&self) -> f64 {
        self.centre.iter().map(|x| x * x).sum::<f64>().sqrt() + self.radius_of_gyration()
    }

    /// Inertia tensor about the section's centre, in the section's axes.
    pub(crate) fn inertia_about_section(&self) -> [[f64; 3]; 3] {
        carried_inertia(self.mass, self.centre, &self.inertia)
    }
}

/// Reports a tensor that cannot be the inertia tensor of a body about its centre of mass.
pub(crate) fn check_inertia(check: &mut Checker, inertia: &[[f64; 3]; 3]) {
    let is_finite = [0, 1, 2].map(|i| check.finite(&inertia[i], &format!("inertia[{i}]")));
    if is_finite != [true; 3] {
        return;
    }
    let inertia = Matrix3::from_fn(|i, j| inertia[i][j]);
    let rounding = INERTIA_TOLERANCE * inertia.amax();
    let is_symmetric = (inertia - inertia.transpose()).amax() <= rounding;
    if check.require(is_symmetric, "inertia", "a matrix that is not symmetric", "a symmetric matrix") {
        let mut moments = inertia.symmetric_eigenvalues();
        moments.as_mut_slice().sort_by(f64::total_cmp);
        let [a, b, c] = moments.into();
        check.require(
            a >= -rounding && a + b >= c - rounding,
            "inertia",
            format_args!("the principal moments {}, {}, {}", Number(a), Number(b), Number(c)),
            "moments >= 0, none larger than the other two together, as every body has",
        );
    }
}

/// Inertia tensor about a point from which the centre of mass is at `c`, given the tensor about the centre of
/// mass (parallel-axis theorem).
pub(crate) fn carried_inertia(mass: f64, c: [f64; 3], inertia: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let square: f64 = c.iter().map(|x| x * x).sum();
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let identity = if i == j { square } else { 0.0 };
            inertia[i][j] + mass * (identity - c[i] * c[j])
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inertia_tensors_that_no_body_has_are_refused() {
        let with = |inertia| Body { inertia, ..Body::point(1.0) }.validate(1.0).is_ok();
        assert!(with([[2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]));
        assert!(!with([[2.1, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), "larger than the others");
        assert!(!with([[1.0, 0.1, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), "not symmetric");
        assert!(!with([[1.0, 2.0, 0.0], [2.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), "negative");
        assert!(!with([[f64::NAN, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), "not finite");
    }

    #[test]
    fn the_parallel_axis_theorem() {
        let body = Body { mass: 2.0, centre: [1.0, 0.0, 3.0], ..Body::point(2.0) };
        assert_eq!(body.inertia_about_section(), [[18.0, 0.0, -6.0], [0.0, 20.0, 0.0], [-6.0, 0.0, 2.0]]);
    }
}
