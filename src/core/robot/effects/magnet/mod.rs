//! Magnets on links as robots hold them, with indices of links. [`described`] is what users describe. Segments have a
//! magnetisation; the uniform field of the robot and the fields of its magnets act on both.
//!
//! ```
//! use lissom::magnet::Magnet;
//!
//! let magnet = Magnet { moment: [0.1, 0.0, 0.0], ..Magnet::at_tip() };
//! assert!(magnet.validate(0.4).is_ok());
//! ```

pub(crate) mod compile;
pub mod described;
pub(crate) mod explain;
pub(crate) mod force;
pub(crate) mod law;
pub(crate) mod plan;

use crate::description::rod::Segment;
use crate::description::rod::arc_length::check_end;
use crate::description::schema::Item as _;
use crate::error::{Checker, InvalidInput};

/// A magnetic dipole that is fixed to a link.
#[derive(Clone, Debug, PartialEq)]
pub struct Magnet {
    /// Index of the link in the robot.
    pub link: usize,
    /// Arc length of its section, in metres; `None` is the tip, or the base of a link without a rod.
    pub at: Option<f64>,
    /// Magnetic moment in the axes there, in A m^2.
    pub moment: [f64; 3],
    /// Position in the axes there, in metres.
    pub position: [f64; 3],
}

impl Magnet {
    /// A magnet without a moment at the tip: a start for `..` syntax.
    pub fn at_tip() -> Self {
        Self { link: 0, at: None, moment: [0.0; 3], position: [0.0; 3] }
    }

    /// Reports every problem of this magnet on a rod of this length (infinite if not known yet).
    pub fn validate(&self, length: f64) -> Result<(), InvalidInput> {
        let mut check = Checker::new();
        check.all(self.described(None).validate());
        if let Some(x) = self.at {
            check_end(&mut check, x, "at", length);
        }
        check.finish()
    }
}

/// Whether a segment is magnetised anywhere.
pub(crate) fn is_magnetised(segment: &Segment) -> bool {
    segment.magnetisation.constant() != Some([0.0; 3])
}
