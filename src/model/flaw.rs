//! Invalid shapes.

/// One of the radii of two surfaces. What is not round has none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Radius {
    /// Overlap beyond which surfaces count as sunk.
    Smaller,
    /// Where the straight way leads so deep that surfaces may be pushed to either side.
    Larger,
}

/// Why a shape is none that the model can have, or none that it can follow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Flaw {
    /// It turns by more than half a turn between neighbouring quadrature nodes.
    Unresolved {
        /// How many times as many nodes it takes.
        shortage: f64,
    },
    /// It is turned inside out.
    Inverted {
        /// Arc length of the unstretched rod where it is worst, in metres.
        at: f64,
        /// The stretch there: length over length at rest, not positive.
        stretch: f64,
    },
    /// A tendon has pulled two points together: its force has no direction.
    Collapsed {
        /// Its place among the actuators.
        actuator: usize,
    },
    /// A loop that should be closed is open, or a tendon that does not stretch is longer than it is told.
    Open {
        /// Which one.
        held: Holder,
        /// By how much: metres, or a difference of cosines.
        gap: f64,
    },
    /// Surfaces have gone into each other by more than a radius, or through.
    Sunk {
        /// The contact's place among those of the model.
        contact: usize,
        /// By how much they overlap, in metres.
        overlap: f64,
    },
}

/// The constraint that is violated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holder {
    /// A loop, by its place among those of the model.
    Loop(usize),
    /// A tendon that does not stretch, by its place among the actuators.
    Tendon(usize),
}

impl std::fmt::Display for Flaw {
    /// What the rod does.
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
            Self::Open { held: Holder::Loop(closed), gap } => {
                write!(f, "has an open loop: loops[{closed}] misses by {}", Rounded(gap))
            }
            Self::Open { held: Holder::Tendon(actuator), gap } => {
                write!(f, "has a tendon that is too long: actuators[{actuator}] by {} m", Rounded(gap))
            }
            Self::Sunk { contact, overlap } => {
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

/// ", at least 3 times as many": how many nodes a shape takes that they do not resolve, where that is a number anyone
/// would ask for.
pub(crate) fn at_least(shortage: f64) -> String {
    /// More is no shape to be resolved but a state that has left all bounds.
    const MOST: f64 = 1000.0;
    if shortage < MOST { format!(", at least {:.0} times as many", shortage.ceil()) } else { String::new() }
}
