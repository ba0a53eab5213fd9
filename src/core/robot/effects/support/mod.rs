//! Elastic supports of a rod as robots hold them, with indices of links. [`described`] is what users describe.
//!
//! ```
//! use lissom::support::Support;
//!
//! let prop = Support { at: Some(0.5), stiffness: [0.0, 0.0, 1e3], ..Support::at_tip() };
//! assert!(prop.validate(1.0).is_ok());
//! ```

pub(crate) mod compile;
pub mod described;
pub(crate) mod force;
pub(crate) mod plan;

use crate::description::rod::arc_length::check_end;
use crate::description::schema::Item as _;
use crate::error::{Checker, InvalidInput};

/// Springs and dampers between a section of the rod and a pose fixed in the world, the *anchor*.
///
/// Let the section have its centre at r and the axes `e_i`, and the anchor its origin at p and the axes
/// `a_i`. With stiffnesses `k_i` along and rotational stiffnesses `kappa_i` about the axes of the anchor, the
/// potential is
///
/// ```text
/// 1/2 sum_i k_i (a_i . (r - p))^2 + sum_i c_i (1 - a_i . e_i),   c_1 = (kappa_2 + kappa_3 - kappa_1) / 2 and so on
/// ```
///
/// (the modified trace function of Koditschek 1989). For small rotations by the rotation vector theta the
/// second sum is `1/2 sum_i kappa_i theta_i^2`; a rotation by any angle about axis i alone meets the moment
/// `kappa_i sin angle`. The potential is smooth for all rotations, and its only minimum is at `e_i = a_i` if
/// all `kappa_i > 0`. If one `kappa_i` is zero and the other two are equal, the potential does not depend on
/// rotations of the section about its own axis i.
#[derive(Clone, Debug, PartialEq)]
pub struct Support {
    /// Index of the link in the robot; 0 for a rod.
    pub link: usize,
    /// Arc length from the base to the supported section, in metres; `None` is the tip.
    pub at: Option<f64>,
    /// Stiffness along the axes of the anchor, in N/m.
    pub stiffness: [f64; 3],
    /// Rotational stiffness about the axes of the anchor, in N m/rad.
    pub rotational_stiffness: [f64; 3],
    /// Viscous damping along the axes of the anchor, in N s/m.
    pub damping: [f64; 3],
    /// Viscous damping of rotation about the axes of the anchor, in N m s/rad.
    pub rotational_damping: [f64; 3],
    /// Position of the anchor in the world, in metres; `None` is the position of the section at zero
    /// coordinates with the base at its initial pose.
    pub position: Option<[f64; 3]>,
    /// Orientation of the anchor: quaternion (w, x, y, z) that rotates its axes into those of the world,
    /// normalised on use; `None` is the orientation of that section.
    pub orientation: Option<[f64; 4]>,
}

impl Support {
    /// A support without springs at the tip: a start for `..` syntax.
    pub fn at_tip() -> Self {
        Self {
            link: 0,
            at: None,
            stiffness: [0.0; 3],
            rotational_stiffness: [0.0; 3],
            damping: [0.0; 3],
            rotational_damping: [0.0; 3],
            position: None,
            orientation: None,
        }
    }

    /// Reports every problem of this support on a rod of this length (infinite if not known yet).
    pub fn validate(&self, length: f64) -> Result<(), InvalidInput> {
        let mut check = Checker::new();
        check.all(self.described(None).validate());
        if let Some(x) = self.at {
            check_end(&mut check, x, "at", length);
        }
        check.finish()
    }
}
