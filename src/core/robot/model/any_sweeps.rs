//! The sweeps of a robot for any kernel and instruction set.

use crate::numerics::lie::{Planar, Plane, Spatial};
use crate::robot::choice::Kernel;
use crate::robot::compile;
use crate::robot::description::Robot;
use crate::robot::plan::Plan;
use crate::robot::sweeps::Sweeps;
use crate::robot::turning::Turning;

/// Boxed, because runs within runs move models on the stack (`test_endless_nesting_is_a_recursion_error`).
#[derive(Clone, Debug)]
pub(super) enum AnySweeps {
    Planar(Box<Sweeps<Planar<true>>>),
    Spatial(Box<Sweeps<Spatial<true>>>),
    #[cfg(portable)]
    PortablePlanar(Box<Sweeps<Planar<false>>>),
    #[cfg(portable)]
    PortableSpatial(Box<Sweeps<Spatial<false>>>),
}

fn boxed<G: Turning>(plan: Plan<G>) -> Box<Sweeps<G>> {
    Box::new(Sweeps::new(plan))
}

impl AnySweeps {
    /// Sweeps for a valid robot, in the given plane if any, with fused or, if they are compiled, with
    /// portable packs.
    pub(super) fn new(robot: &Robot, plane: Option<Plane>, is_fused: bool) -> Self {
        #[cfg(portable)]
        if !is_fused {
            return match plane {
                Some(plane) => Self::PortablePlanar(boxed(compile::plan(robot, plane))),
                None => Self::PortableSpatial(boxed(compile::plan(robot, ()))),
            };
        }
        let _ = is_fused;
        match plane {
            Some(plane) => Self::Planar(boxed(compile::plan(robot, plane))),
            None => Self::Spatial(boxed(compile::plan(robot, ()))),
        }
    }

    /// Sweeps of the same kind for another robot.
    pub(super) fn with_robot(&self, robot: &Robot) -> Self {
        match self {
            Self::Planar(sweeps) => Self::Planar(Box::new(sweeps.with_robot(robot))),
            Self::Spatial(sweeps) => Self::Spatial(Box::new(sweeps.with_robot(robot))),
            #[cfg(portable)]
            Self::PortablePlanar(sweeps) => Self::PortablePlanar(Box::new(sweeps.with_robot(robot))),
            #[cfg(portable)]
            Self::PortableSpatial(sweeps) => Self::PortableSpatial(Box::new(sweeps.with_robot(robot))),
        }
    }

    /// Sweeps of the same robot with one piece per link.
    pub(super) fn taken_apart(&self, robot: &Robot) -> Self {
        match self {
            Self::Planar(sweeps) => Self::Planar(Box::new(sweeps.taken_apart(robot))),
            Self::Spatial(sweeps) => Self::Spatial(Box::new(sweeps.taken_apart(robot))),
            #[cfg(portable)]
            Self::PortablePlanar(sweeps) => Self::PortablePlanar(Box::new(sweeps.taken_apart(robot))),
            #[cfg(portable)]
            Self::PortableSpatial(sweeps) => Self::PortableSpatial(Box::new(sweeps.taken_apart(robot))),
        }
    }

    /// Copies the time of other sweeps of the same kind.
    pub(super) fn take_time(&mut self, other: &Self) {
        match (self, other) {
            (Self::Planar(sweeps), Self::Planar(other)) => sweeps.take_time(other),
            (Self::Spatial(sweeps), Self::Spatial(other)) => sweeps.take_time(other),
            #[cfg(portable)]
            (Self::PortablePlanar(sweeps), Self::PortablePlanar(other)) => sweeps.take_time(other),
            #[cfg(portable)]
            (Self::PortableSpatial(sweeps), Self::PortableSpatial(other)) => sweeps.take_time(other),
            _ => unreachable!("sweeps of one robot are of one kind"),
        }
    }

    /// The same sweeps without skipping anything.
    pub(super) fn with_nothing_skipped(&self) -> Self {
        match self {
            Self::Spatial(sweeps) => Self::Spatial(boxed(sweeps.plan().clone().with_nothing_skipped())),
            #[cfg(portable)]
            Self::PortableSpatial(sweeps) => {
                Self::PortableSpatial(boxed(sweeps.plan().clone().with_nothing_skipped()))
            }
            _ => unreachable!("in a plane, something is skipped"),
        }
    }

    /// Whether derivatives with respect to lengths are compiled. Portable packs, for old machines, use differences of models instead,
    /// to keep wheels small.
    pub(super) fn follow_lengths(&self) -> bool {
        matches!(self, Self::Planar(_) | Self::Spatial(_))
    }

    pub(super) fn kernel(&self) -> Kernel {
        match self {
            Self::Planar(_) => Kernel::Planar,
            Self::Spatial(_) => Kernel::Spatial,
            #[cfg(portable)]
            Self::PortablePlanar(_) => Kernel::Planar,
            #[cfg(portable)]
            Self::PortableSpatial(_) => Kernel::Spatial,
        }
    }
}
