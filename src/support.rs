//! Elastic supports of a rod, in plain data.
//!
//! ```
//! use lissom::support::Support;
//!
//! let prop = Support { at: Some(0.5), stiffness: [0.0, 0.0, 1e3], ..Support::at_tip() };
//! assert!(prop.validate(1.0).is_ok());
//! ```

use crate::error::{Checker, InvalidInput};
use crate::lie::QUATERNION_TOLERANCE;
use crate::load::check_place;

/// Springs and dampers between a section of the rod and a fixed pose in the world, the *anchor*.
///
/// With the section's centre at r and its axes `e_i`, the anchor at p with the axes `a_i`, stiffnesses `k_i` and
/// rotational stiffnesses `kappa_i`, both along and about the axes of the anchor, the potential is
///
/// ```text
/// 1/2 sum_i k_i (a_i . (r - p))^2 + sum_i c_i (1 - a_i . e_i),   c_1 = (kappa_2 + kappa_3 - kappa_1) / 2 and so on
/// ```
///
/// (the modified trace function of Koditschek 1989). For small turns by the rotation vector theta the second sum is
/// `1/2 sum_i kappa_i theta_i^2`; a turn by any angle about axis i alone meets the moment `kappa_i sin angle`. It is
/// smooth for all rotations, and has no minimum but that with `e_i = a_i` where all `kappa_i > 0`. With one `kappa_i`
/// zero and the other two equal, it does not depend at all on how far the section turns about that axis of its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Support {
    /// The link that it is on, by its place among those of a robot; 0 on a rod.
    pub link: usize,
    /// Arc length from the base of the section that it holds, in metres; `None` is the tip.
    pub at: Option<f64>,
    /// Stiffness along the axes of the anchor, in N/m.
    pub stiffness: [f64; 3],
    /// Rotational stiffness about the axes of the anchor, in N m/rad.
    pub rotational_stiffness: [f64; 3],
    /// Viscous damping along the axes of the anchor, in N s/m.
    pub damping: [f64; 3],
    /// Viscous damping of rotation about the axes of the anchor, in N m s/rad.
    pub rotational_damping: [f64; 3],
    /// Position of the anchor in the world, in metres; `None` is where the section is when all coordinates are zero and
    /// the base is at its place, without its motion.
    pub position: Option<[f64; 3]>,
    /// Orientation of the anchor: quaternion (w, x, y, z) that turns its axes into those of the world, normalised on
    /// use; `None` is that of the section then.
    pub orientation: Option<[f64; 4]>,
}

impl Support {
    /// No spring yet, at the tip: a start for `..` syntax.
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

    /// Everything that is wrong with this support of a rod of this length (infinite where it is not known yet).
    pub fn validate(&self, length: f64) -> Result<(), InvalidInput> {
        let mut check = Checker::new();
        if let Some(x) = self.at {
            check_place(&mut check, x, "at", length);
        }
        let coefficients = [
            (self.stiffness, "stiffness", "N/m"),
            (self.rotational_stiffness, "rotational_stiffness", "N m/rad"),
            (self.damping, "damping", "N s/m"),
            (self.rotational_damping, "rotational_damping", "N m s/rad"),
        ];
        for (values, name, unit) in coefficients {
            if values.iter().all(|value| value.to_bits() == values[0].to_bits()) {
                check.non_negative(values[0], name, unit);
                continue;
            }
            for (i, value) in values.into_iter().enumerate() {
                check.non_negative(value, &format!("{name}[{i}]"), unit);
            }
        }
        if let Some(position) = self.position {
            check.finite(&position, "position");
        }
        if let Some(orientation) = self.orientation
            && check.finite(&orientation, "orientation")
        {
            let norm = orientation.iter().map(|x| x * x).sum::<f64>().sqrt();
            check.require(
                (norm - 1.0).abs() <= QUATERNION_TOLERANCE,
                "orientation",
                format_args!("a quaternion of norm {norm}"),
                "a quaternion (w, x, y, z) of norm 1",
            );
        }
        check.finish()
    }
}
