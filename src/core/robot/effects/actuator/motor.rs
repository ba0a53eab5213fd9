//! Motors of joints.

use crate::description::signal::Signal;

/// A torque about the axis of a joint, or a force along it.
#[derive(Clone, Debug, PartialEq)]
pub struct Motor {
    /// The name.
    pub name: String,
    /// Index of the link whose joint the motor moves.
    pub link: usize,
    /// Index of the coordinate among those of the joint.
    pub coordinate: usize,
    /// Command of the motor.
    pub command: MotorCommand,
    /// Minimum and maximum torque in N m, or force in N.
    pub limits: Option<[f64; 2]>,
}

/// Command of a motor.
#[derive(Clone, Debug, PartialEq)]
pub enum MotorCommand {
    /// A torque in N m, or a force in N.
    Torque(Signal<1>),
    /// A desired coordinate q_0, in radians or metres: the motor's force is `k (q_0 - q) - c q'`.
    Position {
        /// q_0.
        position: Signal<1>,
        /// k in N m (per radian) or N/m.
        stiffness: f64,
        /// c in N m s or N s/m.
        damping: f64,
    },
}

impl MotorCommand {
    /// The command and its name.
    pub(super) fn signal(&self) -> (&'static str, &Signal<1>) {
        match self {
            Self::Torque(torque) => ("torque", torque),
            Self::Position { position, .. } => ("position", position),
        }
    }
}
