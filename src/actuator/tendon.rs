//! Tendons: cables that pull and cannot push.

use super::path::Part;
use crate::error::{Checker, Number};
use crate::signal::Signal;

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

/// Reports a signal with a known value below zero. Inputs count with their default value.
fn check_never_below_zero(check: &mut Checker, signal: &Signal<1>, name: &str, expected: &str) {
    if let Some((lowest, place)) = signal.known_lowest(0)
        && lowest < 0.0
        && lowest.is_finite()
    {
        check.require(false, &format!("{name}{place}"), Number(lowest), expected);
    }
}

impl Tendon {
    /// Whether the tendon is inextensible.
    pub fn is_inextensible(&self) -> bool {
        matches!(self.drive, Drive::Length { stiffness: None, .. })
    }

    pub(super) fn check(&self, check: &mut Checker) {
        for (i, part) in self.path.iter().enumerate() {
            check.nested(&format!("path[{i}]"), part.validate());
        }
        let has_length = self.path.len() > 1 || self.path.iter().any(|part| part.along().is_some());
        let found = if self.path.is_empty() { "no parts" } else { "one point" };
        check.require(has_length, "path", found, "a part along a rod, or two points");
        match &self.drive {
            Drive::Tension(tension) => {
                tension.check(check, "tension");
                let expected = "a tension >= 0 (newtons): a tendon pulls, and a chamber pushes";
                check_never_below_zero(check, tension, "tension", expected);
            }
            Drive::Length { length, stiffness, damping } => {
                length.check(check, "length");
                check_never_below_zero(check, length, "length", "a free length >= 0 (metres)");
                check.non_negative(*damping, "damping", "newton seconds a metre");
                if let Some(stiffness) = stiffness {
                    check.positive(*stiffness, "stiffness", "newtons a metre");
                } else {
                    let expected = "none: a tendon without `stiffness` does not stretch";
                    check.require(*damping == 0.0, "damping", Number(*damping), expected);
                    let expected = "none, or a `stiffness`: friction along a tendon that does not stretch is not supported";
                    check.require(self.friction == 0.0, "friction", Number(self.friction), expected);
                }
            }
        }
        check.non_negative(self.friction, "friction", "a coefficient of friction");
        check.positive(self.friction_velocity, "friction_velocity", "metres a second");
        if let Some(sliding) = &self.sliding {
            sliding.check(check, "sliding");
            let constant = sliding.constant().map_or(0.0, |[sliding]| sliding);
            let expected = "a direction in [-1, 1]: 1 while it is pulled, -1 while it is let out";
            check.require(constant.abs() <= 1.0 || constant.is_nan(), "sliding", constant, expected);
        }
    }
}
