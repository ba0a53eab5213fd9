//! Tendons: cables that pull and cannot push.

use super::path::Part;
use crate::description::signal::Signal;

/// A cable along a path through a robot, with optional friction in embedded parts.
#[derive(Clone, Debug, PartialEq)]
pub struct Tendon {
    /// The name.
    pub name: String,
    /// Path, from the actuated end to the fixed end.
    pub path: Vec<Part>,
    /// Command of the tendon.
    pub drive: Drive,
    /// Coefficient of friction mu along embedded parts (capstan equation).
    pub friction: f64,
    /// Rate of the tendon's length, in m/s, below which friction is smoothed.
    pub friction_velocity: f64,
    /// Direction of sliding in [-1, 1] where the rate of length is zero, as in statics; 1 as if the tendon is
    /// pulled.
    pub sliding: Option<Signal<1>>,
}

/// Command of a tendon.
#[derive(Clone, Debug, PartialEq)]
pub enum Drive {
    /// Tension in newtons; positive values pull.
    Tension(Signal<1>),
    /// Rest length l_0 in metres: `T = max(0, k (l - l_0) + c l')`; for an inextensible tendon the constraint
    /// `l <= l_0` and its multiplier as tension.
    Length {
        /// l_0.
        length: Signal<1>,
        /// k in N/m; `None` for an inextensible tendon.
        stiffness: Option<f64>,
        /// c in N s/m.
        damping: f64,
    },
}

impl Drive {
    /// The command and its name.
    pub(super) fn command(&self) -> (&'static str, &Signal<1>) {
        match self {
            Self::Tension(tension) => ("tension", tension),
            Self::Length { length, .. } => ("length", length),
        }
    }
}

impl Tendon {
    /// Whether the tendon is inextensible.
    pub fn is_inextensible(&self) -> bool {
        matches!(self.drive, Drive::Length { stiffness: None, .. })
    }
}
