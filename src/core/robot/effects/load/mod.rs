//! Forces and moments on a rod as robots hold them, with indices of links. [`described`] is what users describe.
//!
//! ```
//! use lissom::load::{Extent, Frame, Load};
//!
//! let thrust = Load { frame: Frame::Body, force: [-0.05, 0.0, 0.0].into(), ..Load::at_tip() };
//! let current = Load { extent: Extent::Along([0.1, 0.4]), force: [0.0, 0.1, 0.0].into(), ..Load::at_tip() };
//! assert!(thrust.validate(0.4).is_ok() && current.validate(0.4).is_ok());
//! ```

pub(crate) mod compile;
pub mod described;
pub(crate) mod force;
pub(crate) mod plan;

use crate::description::rod::arc_length::check_end;
use crate::description::schema::{Described, Item as _};
use crate::description::signal::Signal;
use crate::error::{Checker, InvalidInput};

/// Where a load acts along the unstretched rod, by arc length from the base in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Extent {
    /// At the end of the rod.
    Tip,
    /// At a point.
    At(f64),
    /// Distributed uniformly between two arc lengths.
    Along([f64; 2]),
}

/// The axes in which a load keeps its direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Described)]
pub enum Frame {
    /// The axes of the world: a dead load.
    World,
    /// The axes of the section at which the load acts: a follower load.
    Body,
}

/// A force and a moment, at a point or distributed along a part of the rod.
#[derive(Clone, Debug, PartialEq)]
pub struct Load {
    /// Index of the link in the robot; 0 for a rod.
    pub link: usize,
    /// Where the load acts.
    pub extent: Extent,
    /// The axes of force and moment.
    pub frame: Frame,
    /// Force in newtons; newtons per metre of the unstretched rod if distributed.
    pub force: Signal<3>,
    /// Moment in newton metres, or in newtons if distributed.
    pub moment: Signal<3>,
}

impl Load {
    /// Zero load at the tip, in world axes: a start for `..` syntax.
    pub fn at_tip() -> Self {
        Self {
            link: 0,
            extent: Extent::Tip,
            frame: Frame::World,
            force: Signal::default(),
            moment: Signal::default(),
        }
    }

    /// Force and moment with their names.
    pub(crate) fn named_signals(&self) -> [(&'static str, &Signal<3>); 2] {
        [("force", &self.force), ("moment", &self.moment)]
    }

    /// Whether force or moment depends on time explicitly.
    pub(crate) fn varies_in_time(&self) -> bool {
        self.force.varies_in_time() || self.moment.varies_in_time()
    }

    /// Reports every problem of this load on a rod of this length (infinite if not known yet).
    pub fn validate(&self, length: f64) -> Result<(), InvalidInput> {
        let mut check = Checker::new();
        check.all(self.described(None).validate());
        match self.extent {
            Extent::Tip => {}
            Extent::At(x) => check_end(&mut check, x, "at", length),
            Extent::Along([from, to]) => {
                check_end(&mut check, from, "along[0]", length);
                check_end(&mut check, to, "along[1]", length);
            }
        }
        check.finish()
    }
}
