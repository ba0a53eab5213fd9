//! Forces and moments on a rod, in plain data.
//!
//! ```
//! use lissom::load::{Extent, Frame, Load};
//!
//! let thrust = Load { frame: Frame::Body, force: [-0.05, 0.0, 0.0].into(), ..Load::at_tip() };
//! let current = Load { extent: Extent::Along([0.1, 0.4]), force: [0.0, 0.1, 0.0].into(), ..Load::at_tip() };
//! assert!(thrust.validate(0.4).is_ok() && current.validate(0.4).is_ok());
//! ```

use crate::error::{Checker, InvalidInput};
use crate::signal::Signal;

/// Where along the unstretched rod a load acts, by arc length from the base in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Extent {
    /// At the end of the rod.
    Tip,
    /// At one place.
    At(f64),
    /// Spread evenly from one place to another.
    Along([f64; 2]),
}

/// The axes in which a load keeps its direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Frame {
    /// Those of the world: a dead load.
    World,
    /// Those of the section that it acts on: a follower load.
    Body,
}

/// A force and a moment, at a place or spread along a part of the rod.
#[derive(Clone, Debug, PartialEq)]
pub struct Load {
    /// The link that it is on, by its place among those of a robot; 0 on a rod.
    pub link: usize,
    /// Where it acts.
    pub extent: Extent,
    /// What it keeps its direction in.
    pub frame: Frame,
    /// Force in newtons; per metre of the unstretched rod where it is spread.
    pub force: Signal<3>,
    /// Moment in newton metres, or in newtons where it is spread.
    pub moment: Signal<3>,
}

impl Load {
    /// No load yet at the tip, in world axes: a start for `..` syntax.
    pub fn at_tip() -> Self {
        Self {
            link: 0,
            extent: Extent::Tip,
            frame: Frame::World,
            force: Signal::default(),
            moment: Signal::default(),
        }
    }

    /// Whether its force or its moment depends on time by itself.
    pub(crate) fn varies_in_time(&self) -> bool {
        self.force.varies_in_time() || self.moment.varies_in_time()
    }

    /// How far a step from `t` may go that cannot pass over a part of it unseen ([`Signal::horizon`]).
    pub fn horizon(&self, t: f64) -> f64 {
        self.force.horizon(t).min(self.moment.horizon(t))
    }

    /// Its shortest period in seconds; infinite where nothing oscillates.
    pub fn period(&self) -> f64 {
        self.force.period().min(self.moment.period())
    }

    /// Everything that is wrong with this load on a rod of this length (infinite where it is not known yet).
    pub fn validate(&self, length: f64) -> Result<(), InvalidInput> {
        let mut check = Checker::new();
        match self.extent {
            Extent::Tip => {}
            Extent::At(x) => _ = check_place(&mut check, x, "at", length),
            Extent::Along([from, to]) => {
                let from_is_fine = check_place(&mut check, from, "along[0]", length);
                let to_is_fine = check_place(&mut check, to, "along[1]", length);
                if from_is_fine && to_is_fine {
                    let expected = format!("an arc length > along[0] = {from} (metres)");
                    check.require(from < to, "along[1]", to, &expected);
                }
            }
        }
        self.force.check(&mut check, "force");
        self.moment.check(&mut check, "moment");
        check.finish()
    }
}

/// `x` must be an arc length of a rod of this length, any where the length is infinite; says nothing where the length
/// itself makes no sense.
pub(crate) fn check_place(check: &mut Checker, x: f64, place: &str, length: f64) -> bool {
    let is_inside = x.is_finite() && x >= 0.0 && x <= length;
    if length == f64::INFINITY {
        return check.require(is_inside, place, x, "an arc length >= 0 (metres)");
    }
    let expected = format!("an arc length in [0, {length}] (metres)");
    check.require(is_inside || length.is_nan() || length <= 0.0, place, x, &expected)
}
