//! Forces and moments on a rod as robots hold them, with indices of links. [`described`] is what users describe.
//!
//! ```
//! use lissom::load::{Extent, Frame, Load};
//!
//! let thrust = Load { frame: Frame::Body, force: [-0.05, 0.0, 0.0].into(), ..Load::at_tip() };
//! let current = Load { extent: Extent::Along([0.1, 0.4]), force: [0.0, 0.1, 0.0].into(), ..Load::at_tip() };
//! assert!(thrust.validate(0.4).is_ok() && current.validate(0.4).is_ok());
//! ```

pub mod described;

use crate::description::{Described, Item as _};
use crate::error::{Checker, InvalidInput};
use crate::signal::{Cell, Signal};

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

    /// Whether force or moment depends on time explicitly.
    pub(crate) fn varies_in_time(&self) -> bool {
        self.force.varies_in_time() || self.moment.varies_in_time()
    }

    /// The next time at which a step of fixed size must end, so that it loses nothing of the load.
    pub(crate) fn corner(&self, cell: Cell) -> Option<f64> {
        self.force.corner(cell).into_iter().chain(self.moment.corner(cell)).reduce(f64::min)
    }

    /// Whether force or moment may jump at some time for steps of the size `dt`.
    pub(crate) fn has_edges(&self, dt: f64) -> bool {
        self.force.has_edges(dt) || self.moment.has_edges(dt)
    }

    /// The time at which one of them jumps for steps of the size `dt`, if that is `t`, but for rounding.
    pub(crate) fn edge_near(&self, t: f64, dt: f64) -> Option<f64> {
        self.force.edge_near(t, dt).or_else(|| self.moment.edge_near(t, dt))
    }

    /// Latest end of a step from `t` that cannot miss a feature of the load ([`Signal::horizon`]).
    pub fn horizon(&self, t: f64) -> f64 {
        self.force.horizon(t).min(self.moment.horizon(t))
    }

    /// Shortest period in seconds; infinite for a load that does not oscillate.
    pub fn period(&self) -> f64 {
        self.force.period().min(self.moment.period())
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

/// Whether `x` is an arc length of a rod of this length, which is a sum over segments: ten of 0.15 m are 1.4999999999999998 m
/// long, and yet 1.5 m is their tip. A model puts what is beyond it by rounding at the tip.
pub(crate) fn is_on_rod(x: f64, length: f64) -> bool {
    /// Rounding of a sum of n lengths is below `n eps` times the sum (Higham 2002, section 4.2): this suffices for thousands.
    const ROUNDING: f64 = 1e-12;
    x >= 0.0 && x <= length * (1.0 + ROUNDING)
}

/// Reports an arc length beyond the end of a rod; one that is none at all is reported with its part.
pub(crate) fn check_end(check: &mut Checker, x: f64, place: &str, length: f64) {
    if x.is_finite() && x >= 0.0 {
        check_place(check, x, place, length);
    }
}

/// `x` must be an arc length of a rod of this length, or any arc length if the length is infinite. Reports
/// nothing if the length itself is invalid.
pub(crate) fn check_place(check: &mut Checker, x: f64, place: &str, length: f64) -> bool {
    let is_inside = x.is_finite() && is_on_rod(x, length);
    if length == f64::INFINITY {
        return check.require(is_inside, place, x, "an arc length >= 0 (metres)");
    }
    let expected = format!("an arc length in [0, {length}] (metres)");
    check.require(is_inside || length.is_nan() || length <= 0.0, place, x, &expected)
}
