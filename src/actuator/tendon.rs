//! Tendons: cables that pull and cannot push.

use super::path::Part;
use crate::error::{Checker, Number};
use crate::signal::Signal;

/// A cable through a robot, frictionless or with friction where it is embedded.
#[derive(Clone, Debug, PartialEq)]
pub struct Tendon {
    /// The name.
    pub name: String,
    /// Its way, from the end where it is pulled to the one where it is fixed.
    pub path: Vec<Part>,
    /// What it is told.
    pub drive: Drive,
    /// Coefficient of friction mu along the parts that are embedded (capstan).
    pub friction: f64,
    /// Rate of its length, in m/s, below which friction is smoothed.
    pub friction_velocity: f64,
    /// The direction of sliding in [-1, 1], 1 as while it is pulled, where the rate of its length does not tell.
    pub sliding: Option<Signal<1>>,
}

/// How a tendon is driven.
#[derive(Clone, Debug, PartialEq)]
pub enum Drive {
    /// By its tension in newtons, which pulls where it is positive.
    Tension(Signal<1>),
    /// By the length l_0 at which it is free of force, in metres: `T = max(0, k (l - l_0) + c l')`, or, where it does not
    /// stretch, `l <= l_0` with the tension that this takes.
    Length {
        /// l_0.
        length: Signal<1>,
        /// k in N/m; `None` where it does not stretch.
        stiffness: Option<f64>,
        /// c in N s/m.
        damping: f64,
    },
}

impl Drive {
    /// The command and what it is called.
    pub(super) fn command(&self) -> (&'static str, &Signal<1>) {
        match self {
            Self::Tension(tension) => ("tension", tension),
            Self::Length { length, .. } => ("length", length),
        }
    }
}

/// Notes where a signal is known to fall below zero as long as nobody sets it.
fn check_never_below_zero(check: &mut Checker, signal: &Signal<1>, name: &str, expected: &str) {
    if let Some((lowest, place)) = signal.known_lowest(0)
        && lowest < 0.0
        && lowest.is_finite()
    {
        check.require(false, &format!("{name}{place}"), Number(lowest), expected);
    }
}

impl Tendon {
    /// Where all of its path is, in words, if that is one body or section, which cannot change its length. On a robot alone: by
    /// itself a tendon does not know links.
    pub(crate) fn only_body(&self) -> Option<&'static str> {
        let vias = self.path.iter().map(Part::via).collect::<Option<Vec<_>>>()?;
        let first = vias.first()?;
        let is_one = vias.iter().all(|via| via.link == first.link && via.at == first.at);
        is_one.then_some(if first.link.is_some() { "on one body or section" } else { "in the world" })
    }

    /// Whether it holds its length whatever that takes.
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
