//! Invalid shapes.

/// A radius of two surfaces in contact. Surfaces that are not round have none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Radius {
    /// The smaller radius. A larger overlap is a deep penetration.
    Smaller,
    /// The larger radius. Beyond an overlap of this size on a straight path, surfaces may be pushed out on
    /// either side.
    Larger,
    /// A small part of the smaller radius: whether surfaces touch along the path.
    Touching,
}

/// Reason why a shape is invalid or cannot be followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum InvalidShape {
    /// The rod rotates by more than half a turn between neighbouring quadrature nodes.
    Unresolved {
        /// Required number of nodes over the present one.
        shortage: f64,
    },
    /// The rod is turned inside out.
    Inverted {
        /// Arc length of the unstretched rod at the worst section, in metres.
        at: f64,
        /// Stretch of that section: length over rest length, not positive.
        stretch: f64,
    },
    /// A tendon has pulled two points of its path together, and its force has no direction.
    Collapsed {
        /// Index of the actuator.
        actuator: usize,
    },
    /// A closed loop is open, or an inextensible tendon is longer than commanded.
    Open {
        /// The violated constraint.
        constraint: Constraint,
        /// Size of the gap.
        gap: f64,
        /// Whether it is in metres; otherwise it is a difference of cosines, or of coordinates.
        is_length: bool,
    },
    /// Surfaces overlap by more than a radius, or have passed through each other.
    DeepPenetration {
        /// Index of the contact in the model.
        contact: usize,
        /// Overlap in metres.
        overlap: f64,
    },
}

/// A constraint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Constraint {
    /// A loop, by its index in the model.
    Loop(usize),
    /// An inextensible tendon, by its index among the actuators.
    Tendon(usize),
}

impl InvalidShape {
    /// In words, with what an open loop joins: `loops` has that of each loop ([`Facts::loops`](crate::model::Facts::loops)).
    pub fn with_loops(&self, loops: &[String]) -> String {
        match *self {
            Self::Open { constraint: Constraint::Loop(closed), .. } if closed < loops.len() => {
                format!("{self} between {}", loops[closed])
            }
            _ => self.to_string(),
        }
    }
}

impl std::fmt::Display for InvalidShape {
    /// Describes the problem of the rod.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match *self {
            Self::Unresolved { .. } => {
                write!(f, "turns by more than half a turn between neighbouring quadrature nodes")
            }
            Self::Inverted { at, stretch } => {
                write!(f, "is turned inside out (stretch {} at X = {})", Rounded(stretch), Rounded(at))
            }
            Self::Collapsed { actuator } => {
                write!(f, "has two points that its tendon number {} has pulled together", actuator + 1)
            }
            Self::Open { constraint: Constraint::Loop(closed), gap, is_length } => {
                let unit = if is_length { " m" } else { "" };
                write!(f, "has an open loop: loops[{closed}] misses by {}{unit}", Rounded(gap))
            }
            Self::Open { constraint: Constraint::Tendon(actuator), gap, .. } => {
                write!(f, "has a tendon that is too long: actuators[{actuator}] by {} m", Rounded(gap))
            }
            Self::DeepPenetration { contact, overlap } => {
                write!(
                    f,
                    "is sunk into what it touches: contacts[{contact}] overlaps by {} m",
                    Rounded(overlap)
                )
            }
        }
    }
}

/// A number with four digits.
struct Rounded(f64);

impl std::fmt::Display for Rounded {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self(value) = *self;
        let is_handy = value == 0.0 || (1e-3..1e4).contains(&value.abs());
        if is_handy { write!(f, "{}", (value * 1e4).round() / 1e4) } else { write!(f, "{value:.3e}") }
    }
}

/// ", at least 3 times as many": the number of nodes that would resolve a shape, if it is a reasonable
/// number.
pub fn at_least(shortage: f64) -> String {
    /// Beyond this factor the state has diverged, and more nodes would not help.
    const LARGEST_SHORTAGE: f64 = 1000.0;
    if shortage < LARGEST_SHORTAGE {
        format!(", at least {:.0} times as many", shortage.ceil())
    } else {
        String::new()
    }
}
